#include "optics/clouds.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/reserve.h"

#define SIDE PEL_CLOUD_SIDE

const struct pel_cloud_kind *pel_cloud_kind(enum pel_cloud_genus genus)
{
    static const struct pel_cloud_kind kinds[] = {
#define PEL_CLOUD(ID, base, thickness, extinction, tile, along, rise, grain,   \
                  soft)                                                        \
    { base, thickness, extinction, tile, along, rise, grain, soft },
#include "optics/clouds.def"
    };
    return &kinds[genus];
}

/* --- noise ----------------------------------------------------------------
 */

static double at_node(uint32_t seed, int period, int i, int j)
{
    int x = ((i % period) + period) % period;
    int y = ((j % period) + period) % period;
    return pel_hash01(seed, (uint32_t)period, (uint32_t)(y * period + x));
}

static double smooth(double f)
{
    return f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
}

/* Values at the nodes of a grid of `period` cells a tile, 0..1. */
static double values(uint32_t seed, int period, double x, double y)
{
    double u = x * period, v = y * period;
    int i = (int)floor(u), j = (int)floor(v);
    double f = smooth(u - i), g = smooth(v - j);
    double low = at_node(seed, period, i, j) * (1 - f) +
                 at_node(seed, period, i + 1, j) * f;
    double high = at_node(seed, period, i, j + 1) * (1 - f) +
                  at_node(seed, period, i + 1, j + 1) * f;
    return low * (1 - g) + high * g;
}

/* Octaves of it, each half as high. */
static double rough(uint32_t seed, int period, int octaves, double x, double y)
{
    double sum = 0, weight = 0, w = 1;
    for (int k = 0; k < octaves; k++, period *= 2, w *= 0.5) {
        sum += w * values(seed + (uint32_t)k, period, x, y);
        weight += w;
    }
    return sum / weight;
}

/* 1 at scattered points, `period`² a tile, falling with the distance to the
 * nearest: heaps. */
static double heaps(uint32_t seed, int period, double x, double y)
{
    double u = x * period, v = y * period, nearest = 9;
    int i = (int)floor(u), j = (int)floor(v);
    for (int b = -1; b <= 1; b++) {
        for (int a = -1; a <= 1; a++) {
            double px = i + a + at_node(seed, period, i + a, j + b);
            double py = j + b + at_node(seed + 77u, period, i + a, j + b);
            double d2 = (u - px) * (u - px) + (v - py) * (v - py);
            nearest = fmin(nearest, d2);
        }
    }
    return 1.0 - fmin(sqrt(nearest), 1.2) / 1.2;
}

static double heaped(uint32_t seed, int period, int octaves, double x, double y)
{
    double sum = 0, weight = 0, w = 1;
    for (int k = 0; k < octaves; k++, period *= 2, w *= 0.5) {
        sum += w * heaps(seed + 13u * (uint32_t)k, period, x, y);
        weight += w;
    }
    return sum / weight;
}

/* By genus: where there is more of them, in no unit. */
static double shape(enum pel_cloud_genus genus, uint32_t seed, double x,
                    double y)
{
    double wide = rough(seed + 500u, 3, 3, x, y);
    double dx = 0.02 * (rough(seed + 600u, 8, 3, x, y) - 0.5);
    double dy = 0.02 * (rough(seed + 700u, 8, 3, x, y) - 0.5);
    switch (genus) {
    case PEL_CLOUD_CUMULUS:
        return heaped(seed, 11, 5, x + dx, y + dy) + 0.7 * wide;
    case PEL_CLOUD_CUMULONIMBUS:
        return heaped(seed, 4, 5, x + dx, y + dy) + 1.2 * wide;
    case PEL_CLOUD_STRATOCUMULUS:
        return heaped(seed, 18, 3, x + dx, y + dy) + 0.6 * wide;
    case PEL_CLOUD_ALTOCUMULUS:
        return 0.5 * heaped(seed, 44, 2, x + dx, y + dy) + wide;
    case PEL_CLOUD_CIRRUS:
        return rough(seed, 10, 6, x + 8 * dx, y + 5 * dy) + 0.6 * wide;
    case PEL_CLOUD_STRATUS:
    case PEL_CLOUD_NIMBOSTRATUS:
    case PEL_CLOUD_ALTOSTRATUS:
    case PEL_CLOUD_GENERA:
        break;
    }
    return rough(seed, 6, 6, x + dx, y + dy) + 0.5 * wide;
}

struct place {
    float value;
    int at;
};

static int by_value(const void *a, const void *b)
{
    const struct place *x = a, *y = b;
    return x->value != y->value ? (x->value > y->value) - (x->value < y->value)
                                : (x->at > y->at) - (x->at < y->at);
}

void pel_cloud_field(enum pel_cloud_genus genus, uint32_t seed,
                     float (*texels)[4])
{
    struct place *places = pel_sure_malloc(sizeof *places * SIDE * SIDE);
    for (int at = 0; at < SIDE * SIDE; at++) {
        double x = (at % SIDE + 0.5) / SIDE, y = (double)(at / SIDE) / SIDE;
        y += 0.5 / SIDE;
        places[at] = (struct place){ (float)shape(genus, seed, x, y), at };
        texels[at][2] = (float)(0.55 * heaped(seed + 900u, 24, 3, x, y) +
                                0.45 * rough(seed + 950u, 32, 4, x, y));
        texels[at][3] = 0;
    }
    qsort(places, (size_t)SIDE * SIDE, sizeof *places, by_value);
    double mean = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        float u = ((float)i + 0.5f) / (SIDE * SIDE);
        texels[places[i].at][0] = u;
        texels[places[i].at][1] = u * u;
        mean += (double)texels[i][2] / (SIDE * SIDE);
    }
    for (int i = 0; i < SIDE * SIDE; i++) {
        texels[i][2] += (float)(0.5 - mean);
    }
    free(places);
}

double pel_cloud_bound(const struct pel_clouds *clouds)
{
    double rise = pel_cloud_kind(clouds->genus)->rise;
    return clouds->cover < 1 ? 1.0 - clouds->cover : -0.15 * rise;
}

double pel_cloud_thick(const struct pel_clouds *clouds, double u)
{
    double rise = pel_cloud_kind(clouds->genus)->rise * clouds->cover;
    double x = (u - pel_cloud_bound(clouds)) / fmax(rise, 1e-6);
    x = pel_clamp(x, 0, 1);
    return x * (2.0 - x);
}

/* --- light ---------------------------------------------------------------- */

/* J = c + d t - 3 f mu² e^(-t/mu): J'' = -3 f e^(-t/mu), no diffuse light comes
 * from outside (J = 2 H above, -2 H below; H = J'/3). */
static void solve(double b, double mu, double *c, double *d)
{
    const double f = 1.0 / (4.0 * PEL_PI);
    double left = exp(-b / mu);
    *d = -f * (3 * mu * mu * (1 - left) + 2 * mu * (1 + left)) / (b + 4.0 / 3);
    *c = f * (3 * mu * mu + 2 * mu) + 2.0 / 3 * *d;
}

double pel_cloud_escape(double mu)
{
    return (12 + 24 * mu) / (14 + 21 * mu);
}

double pel_cloud_glow(double t, double b, double mu)
{
    const double f = 1 / (4.0 * PEL_PI);
    double c, d;
    mu = fmax(mu, 0.02);
    solve(b, mu, &c, &d);
    double left = exp(-b / mu), k = pel_cloud_escape(mu);
    /* Below as it escapes; above what that leaves. */
    double below = 2 * PEL_PI * fmax(c + d * b - 3 * f * mu * mu * left, 0),
           above = mu * (1 - left) - below;
    double top = above > 0 ? (above + (1 - k) * below) / above : 1;
    return fmax(c + d * t - 3 * f * mu * mu * exp(-t / mu), 0) *
               (top + (k - top) * t / b) +
           f * exp(-t / mu);
}

double pel_cloud_through(double b, double mu)
{
    double c, d;
    mu = fmax(mu, 0.02);
    solve(b, mu, &c, &d);
    /* The net flux is the same at every depth: -4 pi H. */
    double all = (-4.0 * PEL_PI / 3) * d / mu, left = exp(-b / mu);
    return pel_cloud_escape(mu) * (all - left) + left;
}

/* Images: near enough to it that four of them on either side do. */
static double near_glow(double aside, double same, double other, double period)
{
    double sum = 0;
    for (int k = -2; k <= 2; k++) {
        /* The last are as far as what would follow them. */
        sum += (abs(k) < 2 ? 1 : 0.5) / hypot(aside, same + k * period) -
               (k < 2 ? 1 / hypot(aside, other + k * period) : 0);
    }
    return fmax(sum, 0);
}

/* Modes between the two sides, sin sin K0, by K0's series for far away. */
static double far_glow(double aside, double same, double other, double period)
{
    double sum = 0;
    for (int n = 1; n <= 3; n++) {
        double k = 2 * PEL_PI * n / period, x = k * aside;
        double k0 = sqrt(PEL_PI / (2 * x)) * exp(-x) *
                    (1 - 0.125 / x + 0.0703125 / (x * x));
        /* 2 sin a sin b = cos(a - b) - cos(a + b) */
        sum += (cos(k * same) - cos(k * other)) * k0;
    }
    return fmax(sum, 0) * 4 / period;
}

double pel_cloud_within(double l, double high, double across, double z,
                        double from)
{
    double beyond = l * 2 / 3, period = 2 * (high + 2 * beyond);
    double aside = hypot(across, l), same = from - z,
           other = from + z + 2 * beyond;
    return (aside < 0.25 * period ? near_glow(aside, same, other, period)
                                  : far_glow(aside, same, other, period)) *
           3 / (4 * PEL_PI * l);
}
