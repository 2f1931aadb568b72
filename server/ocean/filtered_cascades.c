#include "ocean/filtered_cascades.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ocean/fields.h"

#define N PEL_CASCADE_N
#define LEVELS PEL_CASCADE_LEVELS
#define PYRAMID ((4 * N * N - 1) / 3) /* texels of all levels */

/* The levels of detail of one cascade, the largest first. */
struct pyramid {
    float displacement[PYRAMID][4];
    float slopes[PYRAMID][4];
    float fold[PYRAMID];
};

static int level_start(int level)
{
    int at = 0;
    for (int l = 0; l < level; l++) {
        at += (N >> l) * (N >> l);
    }
    return at;
}

static float mean4(const float *from, int n, int stride)
{
    return 0.25f * (from[0] + from[stride] + from[2 * n * stride] +
                    from[(2 * n + 1) * stride]);
}

static void fill(const struct pel_cascade_fields *f, int index,
                 struct pyramid *p)
{
    memcpy(p->displacement, f->displacement[index],
           N * N * sizeof *p->displacement);
    memcpy(p->slopes, f->slopes[index], N * N * sizeof *p->slopes);
    memcpy(p->fold, f->fold[index], N * N * sizeof *p->fold);
    for (int l = 1; l < LEVELS; l++) {
        int n = N >> l, to = level_start(l), from = level_start(l - 1);
        for (int i = 0; i < n * n; i++) {
            int at = from + (i / n) * 4 * n + (i % n) * 2;
            for (int k = 0; k < 4; k++) {
                p->displacement[to + i][k] =
                    mean4(p->displacement[at] + k, n, 4);
                p->slopes[to + i][k] = mean4(p->slopes[at] + k, n, 4);
            }
            p->fold[to + i] = mean4(p->fold + at, n, 1);
        }
    }
}

/* Texel below a place in tiles, and the fraction, at n texels a tile. */
static int texel_below(double tiles, int n, double *fraction)
{
    double at = (tiles - floor(tiles)) * n - 0.5, below = floor(at);
    *fraction = at - below;
    return (int)below + n;
}

/* Adds what bilinear interpolation at a level gives of the five. */
static void add_slopes(const struct pyramid *p, int level, double weight,
                       double u, double v, double sum[5])
{
    int n = N >> level, start = level_start(level);
    double f[2];
    int i = texel_below(u, n, &f[0]), j = texel_below(v, n, &f[1]);
    for (int corner = 0; corner < 4; corner++) {
        int a = corner % 2, b = corner / 2;
        int at = start + (j + b) % n * n + (i + a) % n;
        double w = weight * (a ? f[0] : 1 - f[0]) * (b ? f[1] : 1 - f[1]);
        for (int k = 0; k < 4; k++) {
            sum[k] += w * p->slopes[at][k];
        }
        sum[4] += w * p->fold[at];
    }
}

static void add_shift(const struct pyramid *p, int level, double weight,
                      double u, double v, double sum[3])
{
    int n = N >> level, start = level_start(level);
    double f[2], w[2][4];
    int i = texel_below(u, n, &f[0]), j = texel_below(v, n, &f[1]);
    for (int k = 0; k < 2; k++) {
        double g = 1 - f[k], h = f[k];
        w[k][0] = g * g * g / 6;
        w[k][1] = (4 - 6 * h * h + 3 * h * h * h) / 6;
        w[k][2] = (4 - 6 * g * g + 3 * g * g * g) / 6;
        w[k][3] = h * h * h / 6;
    }
    for (int b = 0; b < 4; b++) {
        for (int a = 0; a < 4; a++) {
            /* + n: of the smallest levels the spline goes around twice */
            int at = start + (j + b - 1 + n) % n * n + (i + a - 1 + n) % n;
            for (int k = 0; k < 3; k++) {
                sum[k] += weight * w[0][a] * w[1][b] * p->displacement[at][k];
            }
        }
    }
}

/* What one cascade is read with: shaders/lib/filtered.glsl. */
struct reading {
    bool shown; /* false: at the coarsest level nothing is left */
    double slope_level, shift_level;
};

static struct reading reading_of(const struct pel_cascade *c,
                                 const struct pel_filter *filter,
                                 double footprint_m)
{
    double level = log2(footprint_m / c->texel_m);
    double slope_level = level + pel_filter_slope_bias(filter);
    return (struct reading){
        .shown = slope_level < LEVELS - 1,
        .slope_level = fmax(slope_level, 0),
        .shift_level = fmax(level + pel_filter_shift_bias(filter), 0),
    };
}

static void add_cascade(const struct pel_cascades *all, int index,
                        const struct pyramid *p, const struct reading *r,
                        const struct pel_sheared *at, double tangents[2][3],
                        double shift[3])
{
    const struct pel_cascade *c = &all->cascade[index];
    double slopes[5] = { 0 };
    const double *by = at->by[index];
    if (!r->shown) {
        return;
    }
    double x = at->place[index][0], y = at->place[index][1];
    double u = (x * c->turn_cos + y * c->turn_sin) / c->length_m;
    double v = (y * c->turn_cos - x * c->turn_sin) / c->length_m;
    int low = (int)r->slope_level;
    double f = r->slope_level - low;
    add_slopes(p, low, 1 - f, u, v, slopes);
    if (f > 0) {
        add_slopes(p, low + 1, f, u, v, slopes);
    }
    if (r->shift_level < LEVELS - 1) {
        low = (int)r->shift_level;
        f = r->shift_level - low;
        add_shift(p, low, 1 - f, u, v, shift);
        add_shift(p, low + 1, f, u, v, shift);
    }
    tangents[0][0] += slopes[2];
    tangents[0][1] += slopes[4];
    tangents[0][2] += slopes[0] * by[0] + slopes[1] * by[2];
    tangents[1][0] += slopes[4];
    tangents[1][1] += slopes[3];
    tangents[1][2] += slopes[0] * by[1] + slopes[1] * by[3];
}

enum pel_err pel_cascades_filtered(const struct pel_cascades *c,
                                   const struct pel_filter *filter,
                                   double footprint_m,
                                   const struct pel_vec2 *points, size_t n,
                                   double time_s, struct pel_filtered *out)
{
    struct pel_kept_fields *kept;
    struct pyramid *pyramids = malloc(PEL_CASCADES * sizeof *pyramids);
    enum pel_err err = pyramids
                           ? pel_fields_take(c, time_s, PEL_FIELDS_REST, &kept)
                           : PEL_ERR_NO_MEMORY;
    if (err) {
        free(pyramids);
        return err;
    }
    struct reading readings[PEL_CASCADES];
    for (int i = 0; i < PEL_CASCADES; i++) {
        fill(pel_fields_of(kept), i, &pyramids[i]);
        readings[i] = reading_of(&c->cascade[i], filter, footprint_m);
    }
    pel_fields_give(c, kept);
    for (size_t p = 0; p < n; p++) {
        double t[2][3] = { { 1, 0, 0 }, { 0, 1, 0 } }, d[3] = { 0 };
        struct pel_sheared at;
        pel_shear(&c->shears, points[p].x, points[p].y, &at);
        for (int i = 0; i < PEL_CASCADES; i++) {
            add_cascade(c, i, &pyramids[i], &readings[i], &at, t, d);
        }
        struct pel_vec3 along_x = { t[0][0], t[0][1], t[0][2] };
        struct pel_vec3 along_y = { t[1][0], t[1][1], t[1][2] };
        out[p].shift = (struct pel_vec3){ d[0], d[1], d[2] };
        out[p].normal = pel_vec3_normalize(pel_vec3_cross(along_x, along_y));
    }
    free(pyramids);
    return PEL_OK;
}
