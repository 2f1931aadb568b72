#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "ocean/foam.h"
#include "ocean/hash.h"

/* The structure of foam: rafts of bubbles that tear into a net of walls around
 * holes of many sizes, in patches. */

#define SIDE PEL_FOAM_GRAIN
#define SEED 7u

/* Random numbers on lattices, repeated: what is read of each is within its tile
 * or BESIDE cells beside it. */
enum { BESIDE = 4, MOST_CELLS = 113 + 2 * BESIDE };

struct lattice {
    int cells;
    double at[MOST_CELLS][MOST_CELLS]; /* from −BESIDE on */
};

enum { BENDS, PATCHES = 4, HOLES = 9, LATTICES = 15 };
static const struct {
    uint32_t stream;
    int cells;
} kinds[LATTICES] = {
    { 20, 19 }, { 21, 47 }, { 22, 19 }, { 23, 47 },             /* bends */
    { 10, 3 },  { 11, 7 },  { 12, 17 }, { 13, 41 }, { 14, 97 }, /* patches */
    { 1, 17 },  { 2, 17 },  { 3, 43 },  { 4, 43 },              /* holes */
    { 5, 113 }, { 6, 113 },
};

static void fill_lattice(int kind, struct lattice *l)
{
    const int n = kinds[kind].cells;
    l->cells = n;
    for (int j = 0; j < n + 2 * BESIDE; j++) {
        for (int i = 0; i < n + 2 * BESIDE; i++) {
            int x = (i - BESIDE + 2 * n) % n, y = (j - BESIDE + 2 * n) % n;
            l->at[j][i] =
                pel_hash01(SEED, kinds[kind].stream, (uint32_t)(y * n + x));
        }
    }
}

/* By how much the second nearest of one point a cell is farther than the
 * nearest, in cells; of two lattices. 0 on the walls between their cells. */
static double to_wall(const struct lattice *l, double u, double v)
{
    double x = u * l->cells, y = v * l->cells, best = 9, second = 9;
    int i0 = (int)floor(x), j0 = (int)floor(y);
    for (int j = j0 - 1; j <= j0 + 1; j++) {
        for (int i = i0 - 1; i <= i0 + 1; i++) {
            double dx = i + l[0].at[j + BESIDE][i + BESIDE] - x;
            double dy = j + l[1].at[j + BESIDE][i + BESIDE] - y;
            double square = dx * dx + dy * dy;
            second = square < best ? best : square < second ? square : second;
            best = square < best ? square : best;
        }
    }
    return sqrt(second) - sqrt(best);
}

static double smooth(double f)
{
    return f * f * f * (10.0 + f * (6.0 * f - 15.0));
}

/* Smooth noise of a lattice, −1..1. */
static double noise(const struct lattice *l, double u, double v)
{
    double x = u * l->cells, y = v * l->cells;
    int i = (int)floor(x), j = (int)floor(y);
    double f = smooth(x - i), g = smooth(y - j);
    const double *down = &l->at[j + BESIDE][i + BESIDE],
                 *up = down + MOST_CELLS;
    double low = down[0] + f * (down[1] - down[0]);
    double high = up[0] + f * (up[1] - up[0]);
    return 2.0 * (low + g * (high - low)) - 1.0;
}

static double raw(const struct lattice *l, double u, double v)
{
    /* Bent, or the holes would look like a lattice's. */
    const struct lattice *bends = l + BENDS, *p = l + PATCHES, *h = l + HOLES;
    double bent_u =
        u + 0.01 * noise(&bends[0], u, v) + 0.004 * noise(&bends[1], u, v);
    double bent_v =
        v + 0.01 * noise(&bends[2], u, v) + 0.004 * noise(&bends[3], u, v);
    double walls = 0.9 * to_wall(&h[0], bent_u, bent_v) +
                   0.7 * to_wall(&h[2], bent_u, bent_v) +
                   0.45 * to_wall(&h[4], bent_u, bent_v);
    double patches = 0.35 * noise(&p[0], u, v) + 0.35 * noise(&p[1], u, v) +
                     0.3 * noise(&p[2], u, v) + 0.25 * noise(&p[3], u, v) +
                     0.2 * noise(&p[4], u, v);
    return patches + walls;
}

struct ranked {
    double value;
    int at;
};

static int by_value(const void *a, const void *b)
{
    const struct ranked *p = a, *q = b;
    return p->value < q->value   ? -1
           : p->value > q->value ? 1
                                 : (p->at > q->at) - (p->at < q->at);
}

/* Inverse of the normal distribution (Abramowitz and Stegun 26.2.23, 4.5e-4).
 */
static double quantile(double p)
{
    double q = p < 0.5 ? p : 1.0 - p, t = sqrt(-2.0 * log(q));
    double x = t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                       (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
    return p < 0.5 ? -x : x;
}

bool pel_foam_grain_make(float *out)
{
    struct ranked *order = malloc(sizeof *order * SIDE * SIDE);
    struct lattice *lattices = malloc(sizeof *lattices * LATTICES);
    bool whole = order && lattices;
    for (int i = 0; i < LATTICES && whole; i++) {
        fill_lattice(i, &lattices[i]);
    }
    for (int i = 0; i < SIDE * SIDE && whole; i++) {
        double u = (i % SIDE + 0.5) / SIDE, v = (i / SIDE + 0.5) / SIDE;
        order[i] = (struct ranked){ raw(lattices, u, v), i };
    }
    if (whole) {
        qsort(order, SIDE * SIDE, sizeof *order, by_value);
        for (int i = 0; i < SIDE * SIDE; i++) {
            out[order[i].at] = (float)quantile((i + 0.5) / (SIDE * SIDE));
        }
    }
    free(lattices);
    free(order);
    return whole;
}
