#include "ocean/shorebands.h"

#include <math.h>

#include "ocean/cascade.h"

#define TURNS 12 /* of the search for bands */
/* So much of its logarithm counts as a right angle of direction. */
#define LIKE_LENGTH 1.5

/* A sum of waves. */
struct sum {
    double x, y, k, energy;
};

static void add(struct sum *to, double kx, double ky, double energy)
{
    double k = hypot(kx, ky);
    to->x += energy * kx / k;
    to->y += energy * ky / k;
    to->k += energy * log(k);
    to->energy += energy;
}

static struct pel_shore_band mean_of(const struct sum *s)
{
    double along = hypot(s->x, s->y);
    return (struct pel_shore_band){ .x = along > 0 ? s->x / along : 1,
                                    .y = along > 0 ? s->y / along : 0,
                                    .k = exp(s->k / s->energy),
                                    .energy = s->energy };
}

/* --- cascades ---------------------------------------------------------------
 */

static struct sum of_cascade(const struct pel_cascade *c)
{
    struct sum sum = { 0 };
    for (int at = 0; at < PEL_CASCADE_MODES; at++) {
        int i = at % PEL_CASCADE_N, j = at / PEL_CASCADE_N;
        int m = i < PEL_CASCADE_N / 2 ? i : i - PEL_CASCADE_N;
        int n = j < PEL_CASCADE_N / 2 ? j : j - PEL_CASCADE_N;
        double re = (double)c->h0[at][0], im = (double)c->h0[at][1];
        double energy = re * re + im * im;
        if (energy > 0 && (m || n)) {
            double step = 2 * PEL_PI / c->length_m;
            add(&sum, step * (m * c->turn_cos - n * c->turn_sin),
                step * (m * c->turn_sin + n * c->turn_cos), energy);
        }
    }
    return sum;
}

/* --- trochoids --------------------------------------------------------------
 */

static double unlike(const struct pel_shore_band *b, const struct pel_wave *w)
{
    double k = hypot(w->kx, w->ky);
    double longer = log(k / b->k) / LIKE_LENGTH;
    return longer * longer + 1 - (b->x * w->kx + b->y * w->ky) / k;
}

static bool is_long(const struct pel_wave *w)
{
    return hypot(w->kx, w->ky) * PEL_AREA_SHORTER_M < 2 * PEL_PI;
}

static int nearest(const struct pel_shore *shore, const struct pel_wave *w)
{
    int best = 0;
    for (int b = 1; b < shore->bands; b++) {
        best = unlike(&shore->band[b], w) < unlike(&shore->band[best], w)
                   ? b
                   : best;
    }
    return best;
}

/* The wave that the bands so far fit least, by its energy; −1: they fit all. */
static int worst(const struct pel_sea *sea, const struct pel_shore *shore)
{
    int found = -1;
    double most = 0;
    for (int i = 0; i < sea->count; i++) {
        const struct pel_wave *w = &sea->waves[i];
        if (is_long(w)) {
            double energy = w->amplitude * w->amplitude;
            double off = shore->bands == 0
                             ? 1
                             : unlike(&shore->band[nearest(shore, w)], w);
            if (off > 1e-12 && off * energy > most) {
                most = off * energy;
                found = i;
            }
        }
    }
    return found;
}

static void settle(const struct pel_sea *sea, struct pel_shore *shore)
{
    for (int turn = 0; turn < TURNS; turn++) {
        struct sum sums[PEL_SHORE_BANDS] = { { 0 } };
        for (int i = 0; i < sea->count; i++) {
            const struct pel_wave *w = &sea->waves[i];
            shore->of_wave[i] = PEL_SHORE_BANDS;
            if (is_long(w)) {
                int b = nearest(shore, w);
                shore->of_wave[i] = (uint8_t)b;
                add(&sums[b], w->kx, w->ky, 0.5 * w->amplitude * w->amplitude);
            }
        }
        for (int b = 0; b < shore->bands; b++) {
            if (sums[b].energy > 0) {
                shore->band[b] = mean_of(&sums[b]);
            }
        }
    }
}

void pel_shore_bands_of(const struct pel_sea *sea, struct pel_shore *shore)
{
    shore->bands = 0;
    if (sea->cascades) {
        for (int c = 0; c < PEL_CASCADES / 2; c++) {
            struct sum sum = of_cascade(&sea->cascades->cascade[c]);
            if (sum.energy > 0) {
                shore->band[c] = mean_of(&sum);
                shore->bands = c + 1;
            } else {
                shore->band[c] = (struct pel_shore_band){ 1, 0, 1, 0 };
            }
        }
        return;
    }
    for (int at;
         shore->bands < PEL_SHORE_BANDS && (at = worst(sea, shore)) >= 0;) {
        const struct pel_wave *w = &sea->waves[at];
        double k = hypot(w->kx, w->ky);
        shore->band[shore->bands++] =
            (struct pel_shore_band){ w->kx / k, w->ky / k, k, 0 };
        settle(sea, shore);
    }
}
