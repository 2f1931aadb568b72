#include <math.h>
#include <stdlib.h>

#include "ocean/foam.h"
#include "ocean/hash.h"

/* The structure of foam: rafts of bubbles that tear into a net with holes of
 * many sizes, in patches. */

#define SIDE PEL_FOAM_GRAIN
#define SEED 7u

/* A lattice of `cells` a side, repeated. */
static double lattice(uint32_t stream, int cells, int i, int j)
{
    i = (i % cells + cells) % cells;
    j = (j % cells + cells) % cells;
    return pel_hash01(SEED, stream, (uint32_t)(j * cells + i));
}

/* Distance to the nearest of one point a cell, in cells. */
static double to_nearest(uint32_t stream, int cells, double u, double v)
{
    double x = u * cells, y = v * cells, best = 9;
    int i0 = (int)floor(x), j0 = (int)floor(y);
    for (int j = j0 - 1; j <= j0 + 1; j++) {
        for (int i = i0 - 1; i <= i0 + 1; i++) {
            double dx = i + lattice(stream, cells, i, j) - x;
            double dy = j + lattice(stream + 1, cells, i, j) - y;
            best = fmin(best, dx * dx + dy * dy);
        }
    }
    return sqrt(best);
}

static double smooth(double f)
{
    return f * f * f * (10.0 + f * (6.0 * f - 15.0));
}

/* Smooth noise of `cells` a side, −1..1. */
static double noise(uint32_t stream, int cells, double u, double v)
{
    double x = u * cells, y = v * cells;
    int i = (int)floor(x), j = (int)floor(y);
    double f = smooth(x - i), g = smooth(y - j);
    double a = lattice(stream, cells, i, j);
    double b = lattice(stream, cells, i + 1, j);
    double c = lattice(stream, cells, i, j + 1);
    double d = lattice(stream, cells, i + 1, j + 1);
    double low = a + f * (b - a), high = c + f * (d - c);
    return 2.0 * (low + g * (high - low)) - 1.0;
}

static double raw(double u, double v)
{
    /* Bent, or the holes would look like a lattice's. */
    double bent_u =
        u + 0.01 * noise(20, 19, u, v) + 0.004 * noise(21, 47, u, v);
    double bent_v =
        v + 0.01 * noise(22, 19, u, v) + 0.004 * noise(23, 47, u, v);
    double holes = 1.0 * to_nearest(1, 17, bent_u, bent_v) +
                   1.0 * to_nearest(3, 43, bent_u, bent_v) +
                   0.7 * to_nearest(5, 113, bent_u, bent_v);
    double patches = 0.35 * noise(10, 3, u, v) + 0.35 * noise(11, 7, u, v) +
                     0.3 * noise(12, 17, u, v) + 0.25 * noise(13, 41, u, v) +
                     0.2 * noise(14, 97, u, v);
    return patches - holes;
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

void pel_foam_grain(float (*out)[2])
{
    struct ranked *order = malloc(sizeof *order * SIDE * SIDE);
    for (int i = 0; i < SIDE * SIDE; i++) {
        out[i][0] = 0;
        out[i][1] = 1;
        if (order) {
            double u = (i % SIDE + 0.5) / SIDE, v = (i / SIDE + 0.5) / SIDE;
            order[i] = (struct ranked){ raw(u, v), i };
        }
    }
    if (!order) {
        return; /* foam without structure */
    }
    qsort(order, SIDE * SIDE, sizeof *order, by_value);
    for (int i = 0; i < SIDE * SIDE; i++) {
        double n = quantile((i + 0.5) / (SIDE * SIDE));
        out[order[i].at][0] = (float)n;
        out[order[i].at][1] = (float)(n * n);
    }
    free(order);
}
