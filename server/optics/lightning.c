#include "optics/lightning.h"

#include <math.h>

#include "base/hash.h"
#include "optics/clouds.h"

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
#define LEAN 0.25    /* of a channel from the upright, of its height */
#define CROOKED 0.22 /* of a half's length, at each halving */
#define LEVELS 7     /* halvings of a channel: 128 pieces */
#define WITHIN 3.0   /* flashes within clouds, of those to the sea */
#define HIGHEST 0.5  /* of light within clouds, of their thickness */
#define PIECES 4     /* places that a flash's light within clouds has */
#define LENGTH 0.5   /* of a flash within clouds, of their thickness */
#define APART 0.8    /* size of the lamps that a lit base is, of it, too */

/* Lamps of the channel itself, and of its branches. */
enum {
    BRANCHES = 2,
    BRANCH = 12,
    MAIN = PEL_LIGHTNING_LAMPS - BRANCHES * BRANCH,
    RINGS = 3, /* of lamps that stand for a lit base of clouds */
    RING = 4,  /* in each */
    STANDS_FOR = (MAIN + BRANCHES * BRANCH / 2) / PEL_LIGHTNING_MIRRORED
};

/* Some 12,000 K, linear Rec. 709: between the 25,000 K of a channel's plasma
 * (Orville 1968) and the red of its hydrogen. */
static const double colour[3] = { 0.8, 1.0, 1.5 };
#define COLOURED(CD)                                                           \
    {                                                                          \
        (CD) * colour[0], (CD)*colour[1], (CD)*colour[2]                       \
    }

/* Streams of random numbers, a flash's own. */
enum { ENERGY = 1, GAP, CONTINUES_AT, PLACE, WAY, PIECE };

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

static struct pel_lamp piece_of(const struct pel_lightning *l, double east_m,
                                double north_m, double up, double candela,
                                double size_m, int mirrors)
{
    return (struct pel_lamp){
        .entity = PEL_NO_ENTITY,
        .east_m = east_m,
        .north_m = north_m,
        .altitude_m = l->base_m * up,
        .intensity_cd = COLOURED(candela),
        .ahead = { 0, 1, 0 },
        .up = { 0, 0, 1 },
        .arc_rad = 2 * PEL_PI,
        .spread_rad = 0.5 * PEL_PI,
        .size_m = size_m,
        .mirrors = mirrors,
    };
}

/* From a place of the channel aside and down, and ends in the air. */
static void put_branch(const struct pel_lightning *l,
                       const struct pel_lightning_flash *f, uint32_t branch,
                       double candela, struct pel_lamp *out)
{
    uint32_t own = (uint32_t)pel_hash_mix(f->stream + 1 + branch);
    double from = 0.45 + 0.5 * at(own, PIECE, 0), off[2], bent[2];
    double falls = from * (0.35 + 0.4 * at(own, PIECE, 1)),
           turn = 2 * PEL_PI * at(own, PIECE, 2),
           far = falls * (0.5 + 0.6 * at(own, PIECE, 3));
    channel(f->stream, from, off);
    for (int i = 0; i < BRANCH; i++) {
        double share = (i + 0.5) / BRANCH;
        channel(own, share, bent);
        double east = off[0] + share * far * cos(turn) + falls * bent[0],
               north = off[1] + share * far * sin(turn) + falls * bent[1];
        out[i] = piece_of(l, f->east_m + l->base_m * east,
                          f->north_m + l->base_m * north, from - share * falls,
                          candela, l->base_m * falls / BRANCH, -1);
    }
}

static void put_channel(const struct pel_lightning *l,
                        const struct pel_lightning_flash *f, double candela,
                        struct pel_lamp *out)
{
    /* Branches are half as bright, and are in what those that the sea mirrors
     * stand for. */
    const int step = MAIN / PEL_LIGHTNING_MIRRORED;
    double each = candela / (MAIN + 0.5 * BRANCHES * BRANCH);
    for (int i = 0; i < MAIN; i++) {
        double share = (i + 0.5) / MAIN, off[2];
        channel(f->stream, share, off);
        out[i] = piece_of(l, f->east_m + l->base_m * off[0],
                          f->north_m + l->base_m * off[1], share, each,
                          2 * l->base_m / MAIN,
                          i % step == step / 2 ? STANDS_FOR : -1);
    }
    for (uint32_t i = 0; i < BRANCHES; i++) {
        put_branch(l, f, i, 0.5 * each, out + MAIN + i * BRANCH);
    }
}

/* Its light within clouds, in PIECES; `channel_up`: the channel goes on upwards
 * from its place, else along the cloud. */
static void put_glows(const struct pel_lightning *l,
                      const struct pel_lightning_flash *f, double candela,
                      bool channel_up, struct pel_lightning_glow *out)
{
    double high = HIGHEST * l->thickness_m, far = LENGTH * l->thickness_m;
    double turn = 2 * PEL_PI * at(f->stream, PIECE, 0);
    double each =
        candela * (channel_up ? high / l->base_m : 1) / (double)PIECES;
    for (uint32_t i = 0; i < PIECES; i++) {
        double share = (i + 0.5) / PIECES;
        double aside = channel_up ? 0.25 * share * far : (share - 0.5) * far;
        double up =
            channel_up ? share : 0.3 + 0.7 * at(f->stream, PIECE, 10 + i);
        double bent = turn + 0.5 * normal(f->stream, PIECE, 20 + i);
        out[i] = (struct pel_lightning_glow){
            f->east_m + aside * cos(bent),
            f->north_m + aside * sin(bent),
            l->base_m + up * high,
            COLOURED(each),
        };
    }
}

size_t pel_lightning_glows(const struct pel_lightning *l, double time_s,
                           double exposure_s, struct pel_lightning_glow *out,
                           size_t most)
{
    enum { KNOWN = 16 };
    size_t count = 0;
    for (int within = 0; within < 2 && l->thickness_m > 0; within++) {
        struct pel_lightning here = *l;
        if (within) {
            here.per_minute *= WITHIN;
            here.seed = (uint32_t)pel_hash_mix(l->seed + 1);
        }
        struct pel_lightning_flash flashes[KNOWN];
        size_t known = pel_lightning_flashes(
            &here, time_s - exposure_s - PEL_LIGHTNING_LASTS_S,
            nextafter(time_s, INFINITY), flashes, KNOWN);
        for (size_t i = 0; i < known && count + PIECES <= most; i++) {
            double candela =
                pel_lightning_intensity(&flashes[i], time_s, exposure_s);
            if (candela > 0) {
                put_glows(l, &flashes[i], candela, !within, out + count);
                count += PIECES;
            }
        }
    }
    return count;
}

/* What comes out of the clouds' base about a flash's PIECES: in sum, by
 * diffusion, the part that their places between both sides give, in rings by
 * the mean intensity there. */
static void put_base(const struct pel_lightning *l,
                     const struct pel_lightning_glow *pieces,
                     struct pel_lamp *out)
{
    static const double ring[RINGS] = { 0.1, 0.35, 0.75 },
                        area[RINGS] = { 0.04, 0.21, 0.75 };
    double sum = 0, whole = 0, share[RINGS * RING] = { 0 }, at_m[2] = { 0 };
    for (int p = 0; p < PIECES; p++) {
        at_m[0] += pieces[p].east_m / PIECES;
        at_m[1] += pieces[p].north_m / PIECES;
        double up = (pieces[p].altitude_m - l->base_m) / l->thickness_m;
        /* Into half of all directions. */
        whole += 2 * (1 - up) * pieces[p].intensity_cd[1];
    }
    for (int i = 0; i < RINGS * RING; i++) {
        double turn = 2 * PEL_PI * (i % RING + 0.5 * (i / RING)) / RING,
               away = ring[i / RING] * l->thickness_m;
        out[i] =
            piece_of(l, at_m[0] + away * cos(turn), at_m[1] + away * sin(turn),
                     1, 0, APART * l->thickness_m, 0);
        out[i].unseen = true;
        for (int p = 0; p < PIECES; p++) {
            share[i] +=
                pieces[p].intensity_cd[1] * area[i / RING] *
                pel_cloud_within(l->turned_m, l->thickness_m,
                                 hypot(out[i].east_m - pieces[p].east_m,
                                       out[i].north_m - pieces[p].north_m),
                                 0, pieces[p].altitude_m - l->base_m);
        }
        sum += share[i];
    }
    for (int i = 0; i < RINGS * RING; i++) {
        for (int k = 0; k < 3; k++) {
            out[i].intensity_cd[k] = colour[k] * whole * share[i] / sum;
        }
    }
}

static size_t put_bases(const struct pel_lightning *l, double time_s,
                        double exposure_s, struct pel_lamp *out, size_t count,
                        size_t most)
{
    struct pel_lightning_glow glows[PEL_LIGHTNING_GLOWS];
    size_t known =
        pel_lightning_glows(l, time_s, exposure_s, glows, PEL_LIGHTNING_GLOWS);
    for (size_t i = 0; i < known && count + RINGS * RING <= most; i += PIECES) {
        put_base(l, glows + i, out + count);
        count += RINGS * RING;
    }
    return count;
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
    count = put_bases(l, time_s, exposure_s, out, count, most);
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
