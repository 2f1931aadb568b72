#include "panorama/panorama.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"

#define SUN_WIDTH (3.0 * PEL_DEG) /* about the brightest texel, aureole in */
#define RING_WIDTH (4.0 * PEL_DEG)
#define LARGEST_HALF 65504.0

struct owned {
    struct pel_panorama public;
    atomic_uint refs;
    uint16_t halves[];
};

uint16_t pel_half_of(float value)
{
    double x = (double)value;
    if (!(x > 0)) {
        return 0;
    }
    if (x >= LARGEST_HALF) {
        return 0x7BFF;
    }
    int exponent;
    frexp(x, &exponent); /* x = [0.5, 1) · 2^exponent */
    exponent = exponent < -13 ? -13 : exponent;
    /* Of the number's eleven bits; one too many carries over by itself. */
    unsigned bits = (unsigned)nearbyint(ldexp(x, 11 - exponent));
    return (uint16_t)(((unsigned)(exponent + 13) << 10) + bits);
}

static double luminance(const float *rgb)
{
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] +
           0.0722 * (double)rgb[2];
}

struct grid {
    int columns, rows;
    float *values;
};

static struct pel_vec3 towards(const struct grid *g, int column, int row)
{
    double azimuth = ((column + 0.5) / g->columns - 0.5) * 2 * PEL_PI;
    double elevation = (0.5 - (row + 0.5) / g->rows) * PEL_PI;
    return (struct pel_vec3){ sin(azimuth) * cos(elevation),
                              cos(azimuth) * cos(elevation), sin(elevation) };
}

static double solid_angle(const struct grid *g, int row)
{
    double top = cos(PEL_PI * row / g->rows);
    double bottom = cos(PEL_PI * (row + 1) / g->rows);
    return (top - bottom) * 2 * PEL_PI / g->columns;
}

static float *texel(const struct grid *g, int column, int row)
{
    return g->values + 3 * ((size_t)row * (size_t)g->columns + (size_t)column);
}

static struct pel_vec3 brightest(const struct grid *g)
{
    double most = -1;
    struct pel_vec3 to = { 0, 0, 1 };
    for (int row = 0; row < g->rows / 2; row++) {
        for (int column = 0; column < g->columns; column++) {
            double l = luminance(texel(g, column, row));
            if (l > most) {
                most = l;
                to = towards(g, column, row);
            }
        }
    }
    return to;
}

/* Mean of what surrounds a direction, above the horizon. */
static bool surroundings(const struct grid *g, struct pel_vec3 to,
                         double mean[3])
{
    double sum[3] = { 0 }, weight = 0;
    for (int row = 0; row < g->rows / 2; row++) {
        double omega = solid_angle(g, row);
        for (int column = 0; column < g->columns; column++) {
            double away = pel_vec3_dot(towards(g, column, row), to);
            if (away < cos(SUN_WIDTH) && away > cos(RING_WIDTH)) {
                const float *rgb = texel(g, column, row);
                for (int i = 0; i < 3; i++) {
                    sum[i] += omega * (double)rgb[i];
                }
                weight += omega;
            }
        }
    }
    for (int i = 0; i < 3; i++) {
        mean[i] = weight > 0 ? sum[i] / weight : 0;
    }
    return weight > 0;
}

/* Takes the Sun out; its place is where its light comes from on the mean. */
static void take_sun(const struct grid *g, struct pel_panorama *out)
{
    struct pel_vec3 to = brightest(g), sum = { 0 };
    double mean[3], most = 0;
    if (!surroundings(g, to, mean)) {
        return;
    }
    const float around[3] = { (float)mean[0], (float)mean[1], (float)mean[2] };
    double level = luminance(around);
    for (int pass = 0; pass < 2; pass++) {
        for (int row = 0; row < g->rows / 2; row++) {
            double omega = solid_angle(g, row);
            for (int column = 0; column < g->columns; column++) {
                struct pel_vec3 dir = towards(g, column, row);
                float *rgb = texel(g, column, row);
                double more = luminance(rgb) - level;
                if (pel_vec3_dot(dir, to) < cos(SUN_WIDTH) || more <= 0) {
                    continue;
                }
                if (pass == 0) {
                    most = fmax(most, more);
                    continue;
                }
                sum = pel_vec3_add(sum, pel_vec3_scale(dir, more * omega));
                for (int i = 0; i < 3; i++) {
                    out->sun[i] += omega * ((double)rgb[i] - mean[i]);
                    rgb[i] = around[i];
                }
            }
        }
        if (most <= PEL_PANORAMA_SUN * level) {
            return;
        }
    }
    sum = pel_vec3_normalize(sum);
    for (int i = 0; i < 3; i++) {
        out->sun[i] = fmax(out->sun[i], 0);
    }
    out->sun_azimuth_rad = atan2(sum.x, sum.y);
    out->sun_elevation_rad = asin(pel_clamp(sum.z, -1, 1));
    out->has_sun = true;
}

static enum pel_err check(const struct grid *g, float *most,
                          struct pel_fault *fault)
{
    *most = 0;
    if (g->columns < PEL_PANORAMA_LEAST_COLUMNS ||
        g->columns > PEL_PANORAMA_MOST_COLUMNS || g->columns != 2 * g->rows) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "%d × %d texels are no panorama", g->columns,
                             g->rows);
    }
    size_t count = 3 * (size_t)g->columns * (size_t)g->rows;
    for (size_t i = 0; i < count; i++) {
        if (!(g->values[i] >= 0) || !isfinite(g->values[i])) {
            return pel_fault_set(fault, PEL_ERR_MALFORMED,
                                 "a value is negative or not finite");
        }
        *most = fmaxf(*most, g->values[i]);
    }
    return PEL_OK;
}

enum pel_err pel_panorama_create(int columns, int rows, float *values,
                                 bool sun_is_taken,
                                 const struct pel_panorama **out,
                                 struct pel_fault *fault)
{
    static atomic_uint_fast64_t ids;
    const struct grid grid = { columns, rows, values };
    float most;
    enum pel_err err = check(&grid, &most, fault);
    if (err) {
        return err;
    }
    size_t count = 3 * (size_t)columns * (size_t)rows;
    struct owned *p = calloc(1, sizeof *p + count * sizeof *p->halves);
    if (!p) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    if (sun_is_taken) {
        take_sun(&grid, &p->public);
        err = check(&grid, &most, fault);
        if (err) {
            free(p);
            return err;
        }
    }
    atomic_init(&p->refs, 1);
    p->public.id = atomic_fetch_add(&ids, 1) + 1;
    p->public.columns = columns;
    p->public.rows = rows;
    /* The brightest as a half's 2^15; 29 powers of two below it are whole. */
    p->public.unit = most > 0 ? (double)most / 32768.0 : 1.0;
    for (size_t i = 0; i < count; i++) {
        p->halves[i] = pel_half_of((float)((double)values[i] / p->public.unit));
    }
    p->public.halves = p->halves;
    *out = &p->public;
    return PEL_OK;
}

const struct pel_panorama *pel_panorama_ref(const struct pel_panorama *p)
{
    if (p) {
        atomic_fetch_add(&((struct owned *)p)->refs, 1);
    }
    return p;
}

void pel_panorama_unref(const struct pel_panorama *p)
{
    struct owned *own = (struct owned *)p;
    if (own && atomic_fetch_sub(&own->refs, 1) == 1) {
        free(own);
    }
}
