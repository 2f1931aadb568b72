#include "optics/lightning.h"

#include <math.h>

#include "base/hash.h"

#define SLOT_S 0.1 /* few enough flashes in each to count by one number */
#define SLOT_MOST 8
#define FIRST_LMS 3.7e7 /* 3.7e5 J at 100 lm/W */
#define LATER 0.25
#define SPREAD 0.6 /* of energies, of their logarithms */
#define INTERVAL_S 0.06
#define INTERVAL_SPREAD 0.7
#define LEAST_INTERVAL_S 0.005
#define SINGLE 0.2
#define ANOTHER 0.68 /* after the second: a mean of 3.5 strokes */
#define CONTINUES (1.0 / 3)
#define CONTINUING_S 0.1
#define LEAN 0.25       /* of a channel from the upright, of its height */
#define CROOKED 0.22    /* of a half's length, at each halving */
#define LEVELS 7        /* halvings of a channel: 128 pieces */
#define WHITE_BLUE 1.15 /* some 7,500 K */

/* Streams of random numbers, a flash's own. */
enum { ENERGY = 1, GAP, CONTINUES_AT, PLACE, WAY };

static double at(uint32_t stream, uint32_t what, uint32_t i)
{
    return pel_hash01(stream, what, i);
}

static double normal(uint32_t stream, uint32_t what, uint32_t i)
{
    double u = fmax(at(stream, what, 2 * i), 1e-12);
    return sqrt(-2 * log(u)) * cos(2 * PEL_PI * at(stream, what, 2 * i + 1));
}

static struct pel_lightning_flash flash_of(const struct pel_lightning *l,
                                           double time_s, uint32_t stream)
{
    struct pel_lightning_flash f = { .time_s = time_s, .stream = stream };
    double away = l->radius_m * sqrt(at(stream, PLACE, 0)),
           turn = 2 * PEL_PI * at(stream, PLACE, 1), after = 0;
    f.east_m = l->east_m + away * cos(turn);
    f.north_m = l->north_m + away * sin(turn);
    bool more = true;
    for (uint32_t i = 0; i < PEL_LIGHTNING_STROKES && more; i++) {
        double gap = INTERVAL_S * exp(INTERVAL_SPREAD * normal(stream, GAP, i));
        after += i ? fmax(gap, LEAST_INTERVAL_S) : 0;
        if (after > PEL_LIGHTNING_LASTS_S - CONTINUING_S) {
            break;
        }
        f.begin_s[i] = after;
        /* The factor's mean is 1. */
        f.energy_lms[i] =
            FIRST_LMS * (i ? LATER : 1) *
            exp(SPREAD * normal(stream, ENERGY, i) - 0.5 * SPREAD * SPREAD);
        f.strokes++;
        more = at(stream, GAP, 1000 + i) < (i ? ANOTHER : 1 - SINGLE);
    }
    if (at(stream, CONTINUES_AT, 0) < CONTINUES) {
        f.continuing_lms = f.energy_lms[f.strokes - 1];
    }
    return f;
}

size_t pel_lightning_flashes(const struct pel_lightning *l, double from_s,
                             double to_s, struct pel_lightning_flash *out,
                             size_t most)
{
    size_t count = 0;
    double mean = l->per_minute / 60 * SLOT_S;
    if (!(mean > 0)) {
        return 0;
    }
    for (double slot = floor(from_s / SLOT_S); slot * SLOT_S < to_s; slot++) {
        uint64_t key =
            pel_hash_mix(pel_hash_mix(l->seed) ^ (uint64_t)(int64_t)slot);
        uint32_t stream = (uint32_t)(key >> 32);
        /* Poisson's distribution, from below. */
        double u = at(stream, 0, 0), part = exp(-mean), sum = part;
        for (uint32_t i = 0; i < SLOT_MOST && u >= sum && count < most; i++) {
            part *= mean / (i + 1);
            sum += part;
            double time_s = (slot + at(stream, 0, 1 + i)) * SLOT_S;
            if (time_s >= from_s && time_s < to_s) {
                out[count++] =
                    flash_of(l, time_s, (uint32_t)pel_hash_mix(key + 1 + i));
            }
        }
    }
    return count;
}

double pel_lightning_intensity(const struct pel_lightning_flash *f,
                               double time_s, double exposure_s)
{
    double end = time_s - f->time_s, begin = end - exposure_s, sum = 0;
    for (int i = 0; i < f->strokes; i++) {
        sum += f->begin_s[i] > begin && f->begin_s[i] <= end ? f->energy_lms[i]
                                                             : 0;
    }
    double last = f->begin_s[f->strokes - 1];
    double shared = fmin(end, last + CONTINUING_S) - fmax(begin, last);
    sum += f->continuing_lms * fmax(shared, 0) / CONTINUING_S;
    return sum / (4 * PEL_PI * exposure_s);
}

/* Share of the way up, and offsets to both sides as shares of the height:
 * halves are bent at random, again and again. */
static void channel(uint32_t stream, double share, double out[2])
{
    for (int k = 0; k < 2; k++) {
        double low = 0, high = LEAN * normal(stream, WAY, (uint32_t)k);
        double begin = 0, end = 1;
        uint32_t node = 1;
        for (int level = 0; level < LEVELS; level++) {
            double middle = 0.5 * (begin + end);
            double bent = 0.5 * (low + high) +
                          CROOKED * 0.5 * (end - begin) *
                              normal(stream, WAY, 2 * node + (uint32_t)k + 8);
            bool above = share >= middle;
            *(above ? &begin : &end) = middle;
            *(above ? &low : &high) = bent;
            node = 2 * node + (above ? 1 : 0);
        }
        out[k] = low + (high - low) * (share - begin) / (end - begin);
    }
}

static void put_channel(const struct pel_lightning *l,
                        const struct pel_lightning_flash *f, double candela,
                        struct pel_lamp *out)
{
    const int step = PEL_LIGHTNING_LAMPS / PEL_LIGHTNING_MIRRORED;
    double each = candela / PEL_LIGHTNING_LAMPS;
    for (int i = 0; i < PEL_LIGHTNING_LAMPS; i++) {
        double share = (i + 0.5) / PEL_LIGHTNING_LAMPS, off[2];
        channel(f->stream, share, off);
        out[i] = (struct pel_lamp){
            .entity = PEL_NO_ENTITY,
            .east_m = f->east_m + l->base_m * off[0],
            .north_m = f->north_m + l->base_m * off[1],
            .altitude_m = l->base_m * share,
            .intensity_cd = { each, each, WHITE_BLUE * each },
            .ahead = { 0, 1, 0 },
            .up = { 0, 0, 1 },
            .arc_rad = 2 * PEL_PI,
            .spread_rad = 0.5 * PEL_PI,
            .size_m = 2 * l->base_m / PEL_LIGHTNING_LAMPS,
            .mirrors = i % step == step / 2 ? step : -1,
        };
    }
}

size_t pel_lightning_lamps(const struct pel_lightning *l, double time_s,
                           double exposure_s, struct pel_lamp *out, size_t most)
{
    enum { KNOWN = 16 };
    struct pel_lightning_flash flashes[KNOWN];
    if (!(l->per_minute > 0) || most == 0) {
        return 0;
    }
    size_t count = 0, known = pel_lightning_flashes(
                          l, time_s - exposure_s - PEL_LIGHTNING_LASTS_S,
                          nextafter(time_s, INFINITY), flashes, KNOWN);
    for (size_t i = 0; i < known; i++) {
        double candela =
            pel_lightning_intensity(&flashes[i], time_s, exposure_s);
        if (candela > 0 && count + PEL_LIGHTNING_LAMPS <= most) {
            put_channel(l, &flashes[i], candela, out + count);
            count += PEL_LIGHTNING_LAMPS;
        }
    }
    if (count == 0) {
        out[count++] = (struct pel_lamp){ .entity = PEL_NO_ENTITY,
                                          .east_m = l->east_m,
                                          .north_m = l->north_m,
                                          .altitude_m = l->base_m,
                                          .ahead = { 0, 1, 0 },
                                          .up = { 0, 0, 1 } };
    }
    return count;
}
