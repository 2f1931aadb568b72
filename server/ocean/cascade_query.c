#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "base/simd.h"
#include "ocean/atrest.h"
#include "ocean/fields.h"
#include "ocean/newton.h"

#define N PEL_CASCADE_N
/* So near the last step needs no new sums. */
#define NEAR_M 1e-4
#define MOST_STEPS 40
#define MOST_HALVINGS 10
#define TOGETHER 8 /* points whose searches take turns */

/* Two numbers a cascade: along a row of its grid, and along a column. */
#define ALONG (2 * PEL_CASCADES)
typedef double places __attribute__((vector_size(8 * ALONG)));
typedef float fractions __attribute__((vector_size(4 * ALONG)));
typedef int32_t texels __attribute__((vector_size(4 * ALONG)));

/* A place's x and y times these, summed, are tiles of the grids. */
struct grids {
    places by_x, by_y;
};

static struct grids grids_of(const struct pel_cascades *c)
{
    struct grids g;
    for (int i = 0; i < PEL_CASCADES; i++) {
        const struct pel_cascade *of = &c->cascade[i];
        double cosine = of->turn_cos / of->length_m;
        double sine = of->turn_sin / of->length_m;
        g.by_x[2 * i] = g.by_y[2 * i + 1] = cosine;
        g.by_y[2 * i] = sine;
        g.by_x[2 * i + 1] = -sine;
    }
    return g;
}

/* Where the cascades are read for a place. */
struct reading {
    texels below;     /* a place of 1 on texel 0's far side is texel 1's 0 */
    fractions beyond; /* 0 .. 1 */
    struct pel_sheared sheared;
};

PEL_INLINE void read_at(const struct pel_cascades *c, const struct grids *g,
                        struct pel_vec2 at, struct reading *r)
{
    const double magic = 6755399441055744.0; /* 1.5 · 2⁵²: rounds */
    pel_shear(&c->shears, at.x, at.y, &r->sheared);
    places x, y;
    for (int i = 0; i < PEL_CASCADES; i++) {
        x[2 * i] = x[2 * i + 1] = r->sheared.place[i][0];
        y[2 * i] = y[2 * i + 1] = r->sheared.place[i][1];
    }
    places tiles = x * g->by_x + y * g->by_y;
    places at_texel = (tiles - ((tiles + magic) - magic)) * N - 0.5;
    places below = ((at_texel - 0.5) + magic) - magic;
    r->below = __builtin_convertvector(below, texels);
    r->beyond = __builtin_convertvector(at_texel - below, fractions);
}

/* East, north, up and nothing of two texels: what is summed over texels is
 * single, as they are themselves; a place is double. */
typedef float texel __attribute__((vector_size(16)));
typedef float pair __attribute__((vector_size(32)));
typedef double lanes4 __attribute__((vector_size(32)));

PEL_INLINE pair pair_at(float (*field)[4], int row, const int column[2])
{
    texel a, b;
    memcpy(&a, field[row + column[0]], sizeof a);
    memcpy(&b, field[row + column[1]], sizeof b);
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
}

PEL_INLINE pair both(float a, float b)
{
    return (pair){ a, a, a, a, b, b, b, b };
}

PEL_INLINE lanes4 fold(pair p)
{
    texel low = __builtin_shufflevector(p, p, 0, 1, 2, 3);
    texel high = __builtin_shufflevector(p, p, 4, 5, 6, 7);
    return __builtin_convertvector(low + high, lanes4);
}

/* pel_cubic_spline of all: weights of texels −1, 0, 1, 2 and derivatives. */
struct spline {
    float w[4][ALONG], d[4][ALONG];
};

PEL_INLINE void splines_of(const struct reading *r, struct spline *s)
{
    const float sixth = 1.0f / 6.0f;
    fractions f = r->beyond, g = 1.0f - f;
    const fractions w[4] = {
        g * g * g * sixth,
        (4.0f - 6.0f * f * f + 3.0f * f * f * f) * sixth,
        (4.0f - 6.0f * g * g + 3.0f * g * g * g) * sixth,
        f * f * f * sixth,
    };
    const fractions d[4] = {
        -0.5f * g * g,
        f * (1.5f * f - 2.0f),
        g * (2.0f - 1.5f * g),
        0.5f * f * f,
    };
    memcpy(s->w, w, sizeof w);
    memcpy(s->d, d, sizeof d);
}

PEL_INLINE void columns_of(const struct reading *r, int cascade, int column[4])
{
#pragma GCC unroll 4
    for (int a = 0; a < 4; a++) {
        column[a] = (r->below[2 * cascade] + a - 1) & (N - 1);
    }
}

PEL_INLINE int row_of(const struct reading *r, int cascade, int b)
{
    return ((r->below[2 * cascade + 1] + b - 1) & (N - 1)) * N;
}

/* What the cascades do to one rest position. */
struct shift {
    lanes4 d;      /* displacement */
    lanes4 dx, dy; /* its derivatives as interpolated */
};
struct sums {
    pair d, dx, dy;
};

PEL_INLINE void add_spline(float (*field)[4], const struct reading *r,
                           const struct spline *s, int i, pair *sum)
{
    int column[4];
    columns_of(r, i, column);
    pair near = both(s->w[0][2 * i], s->w[1][2 * i]);
    pair far = both(s->w[2][2 * i], s->w[3][2 * i]);
#pragma GCC unroll 4
    for (int b = 0; b < 4; b++) {
        int row = row_of(r, i, b);
        pair along = near * pair_at(field, row, column) +
                     far * pair_at(field, row, column + 2);
        *sum += s->w[b][2 * i + 1] * along;
    }
}

PEL_INLINE void add_shift(const struct pel_cascade *c, float (*field)[4],
                          const struct reading *r, const struct spline *s,
                          int i, struct sums *sum)
{
    int column[4];
    columns_of(r, i, column);
    pair near = both(s->w[0][2 * i], s->w[1][2 * i]);
    pair far = both(s->w[2][2 * i], s->w[3][2 * i]);
    pair near_d = both(s->d[0][2 * i], s->d[1][2 * i]);
    pair far_d = both(s->d[2][2 * i], s->d[3][2 * i]);
    pair du = { 0 }, dv = { 0 };
#pragma GCC unroll 4
    for (int b = 0; b < 4; b++) {
        int row = row_of(r, i, b);
        pair first = pair_at(field, row, column);
        pair second = pair_at(field, row, column + 2);
        pair along = near * first + far * second;
        sum->d += s->w[b][2 * i + 1] * along;
        du += s->w[b][2 * i + 1] * (near_d * first + far_d * second);
        dv += s->d[b][2 * i + 1] * along;
    }
    const double *by = r->sheared.by[i];
    double cosine = c->turn_cos / c->texel_m, sine = c->turn_sin / c->texel_m;
    /* ∂/∂x and ∂/∂y of the place at rest, by the grid's u and v */
    sum->dx += (float)(cosine * by[0] + sine * by[2]) * du +
               (float)(cosine * by[2] - sine * by[0]) * dv;
    sum->dy += (float)(cosine * by[1] + sine * by[3]) * du +
               (float)(cosine * by[3] - sine * by[1]) * dv;
}

PEL_INLINE void shift_at(const struct pel_cascades *c,
                         const struct pel_cascade_fields *f,
                         const struct reading *r, int first, int end,
                         struct shift *out)
{
    struct spline s;
    struct sums sum = { 0 };
    splines_of(r, &s);
    for (int i = first; i < end; i++) {
        add_shift(&c->cascade[i], f->displacement[i], r, &s, i, &sum);
    }
    *out = (struct shift){ fold(sum.d), fold(sum.dx), fold(sum.dy) };
}

PEL_INLINE lanes4 velocity_at(const struct pel_cascade_fields *f,
                              const struct reading *r, int first, int end)
{
    struct spline s;
    pair sum = { 0 };
    splines_of(r, &s);
    for (int i = first; i < end; i++) {
        add_spline(f->velocity[i], r, &s, i, &sum);
    }
    return fold(sum);
}

/* Asks for the texels of a spline there, which another place's sums hide. */
PEL_INLINE void fetch_spline(float (*field)[4], const struct reading *r, int i)
{
    int column[4];
    columns_of(r, i, column);
#pragma GCC unroll 4
    for (int b = 0; b < 4; b++) {
        int row = row_of(r, i, b);
        __builtin_prefetch(field[row + column[0]]);
        __builtin_prefetch(field[row + column[3]]);
    }
}

PEL_INLINE void fetch_shift(const struct pel_cascade_fields *f,
                            const struct reading *r)
{
    for (int i = 0; i < PEL_CASCADES; i++) {
        fetch_spline(f->displacement[i], r, i);
    }
}

PEL_INLINE void fetch_surface(const struct pel_cascade_fields *f,
                              const struct reading *r)
{
    for (int i = 0; i < PEL_CASCADES; i++) {
        fetch_spline(f->velocity[i], r, i);
    }
}

/* The search for the rest position that is carried to `to`. */
struct search {
    struct pel_vec2 to, rest, trial, step;
    struct shift at;        /* what the cascades do to `rest` */
    struct reading reading; /* of `trial`; of `rest` when done */
    double rx, ry;          /* from there to `to` */
    double error;           /* squared */
    int steps, halved;      /* so far; of this step */
    bool done;
};

/* Chooses Newton's step; of a last short one the sums follow by their
 * derivatives, and it leaves its square times the curvature, < 1e-7 m. */
PEL_INLINE void search_step(struct search *s)
{
    struct shift *at = &s->at;
    s->step = pel_newton_step(1.0 + at->dx[0], at->dy[0], at->dx[1],
                              1.0 + at->dy[1], s->rx, s->ry);
    s->trial =
        (struct pel_vec2){ s->rest.x + s->step.x, s->rest.y + s->step.y };
    s->halved = 0;
    s->done = ++s->steps > MOST_STEPS;
    if (s->step.x * s->step.x + s->step.y * s->step.y < NEAR_M * NEAR_M) {
        s->rest = s->trial;
        at->d += s->step.x * at->dx + s->step.y * at->dy;
        s->done = true;
    }
}

/* Judges the place tried last and chooses the next. */
PEL_INLINE void search_turn(struct search *s, const struct shift *there)
{
    double rx = s->to.x - s->trial.x - there->d[0];
    double ry = s->to.y - s->trial.y - there->d[1];
    double error = rx * rx + ry * ry;
    if (error < s->error) {
        s->rest = s->trial;
        s->at = *there;
        s->rx = rx;
        s->ry = ry;
        s->error = error;
        search_step(s);
    } else if (++s->halved < MOST_HALVINGS) {
        s->step.x *= 0.5;
        s->step.y *= 0.5;
        s->trial =
            (struct pel_vec2){ s->rest.x + s->step.x, s->rest.y + s->step.y };
    } else {
        s->done = true; /* the rounding of far places: as near as doubles go */
    }
}

/* Searches for all, in turns: while one place computes, the texels of the
 * others arrive. */
PEL_INLINE void search_all(const struct pel_cascades *c,
                           const struct pel_cascade_fields *f,
                           const struct grids *g, const struct pel_vec2 *points,
                           int n, struct search *searches)
{
    int left = n;
    for (int i = 0; i < n; i++) {
        searches[i] = (struct search){ .to = points[i],
                                       .trial = points[i],
                                       .error = INFINITY };
        read_at(c, g, points[i], &searches[i].reading);
        fetch_shift(f, &searches[i].reading);
    }
    while (left > 0) {
        left = 0;
        for (int i = 0; i < n; i++) {
            struct search *s = &searches[i];
            if (!s->done) {
                struct shift there;
                shift_at(c, f, &s->reading, 0, PEL_CASCADES, &there);
                search_turn(s, &there);
                read_at(c, g, s->done ? s->rest : s->trial, &s->reading);
                if (s->done) {
                    fetch_surface(f, &s->reading);
                } else {
                    fetch_shift(f, &s->reading);
                    left++;
                }
            }
        }
    }
}

/* `there`: at the rest position of `r`, whose derivatives are the surface's own
 * tangents. */
PEL_INLINE void surface_at(const struct pel_cascade_fields *f,
                           const struct reading *r, const struct shift *there,
                           struct pel_surface_sample *out)
{
    lanes4 v = velocity_at(f, r, 0, PEL_CASCADES);
    const lanes4 *dx = &there->dx, *dy = &there->dy;
    struct pel_vec3 along_x = { 1.0 + (*dx)[0], (*dx)[1], (*dx)[2] };
    struct pel_vec3 along_y = { (*dy)[0], 1.0 + (*dy)[1], (*dy)[2] };
    out->height_m = there->d[2];
    out->normal = pel_vec3_normalize(pel_vec3_cross(along_x, along_y));
    out->velocity_mps = (struct pel_vec3){ v[0], v[1], v[2] };
    out->acceleration_mps2 = (struct pel_vec3){ NAN, NAN, v[3] };
    out->depth_m = out->foam = NAN;
}

PEL_INLINE struct pel_vec2 surge_at(const struct pel_cascade_fields *f,
                                    const struct reading *r, int first, int end)
{
    struct spline s;
    struct pel_vec2 sum = { 0, 0 };
    splines_of(r, &s);
    for (int i = first; i < end; i++) {
        int column[4];
        columns_of(r, i, column);
        for (int b = 0; b < 4; b++) {
            int row = row_of(r, i, b);
            for (int a = 0; a < 4; a++) {
                const float *surge = f->surge[i][row + column[a]];
                float w = s.w[a][2 * i] * s.w[b][2 * i + 1];
                sum.x += (double)(w * surge[0]);
                sum.y += (double)(w * surge[1]);
            }
        }
    }
    return sum;
}

static struct pel_kept_fields *take(const struct pel_cascades *c, double time_s,
                                    enum pel_fields_depth depth)
{
    struct pel_kept_fields *kept;
    if (pel_fields_take(c, time_s, depth, &kept) &&
        (!pel_reserve_spend() || pel_fields_take(c, time_s, depth, &kept))) {
        abort();
    }
    return kept;
}

PEL_CLONES
static void query(const struct pel_cascades *c,
                  const struct pel_cascade_fields *f, bool moving,
                  const struct pel_vec2 *points, size_t n,
                  struct pel_surface_sample *out)
{
    struct search searches[TOGETHER];
    const struct grids g = grids_of(c);
    for (size_t from = 0; from < n; from += TOGETHER) {
        int count = (int)(n - from < TOGETHER ? n - from : TOGETHER);
        search_all(c, f, &g, points + from, count, searches);
        for (int i = 0; i < count; i++) {
            struct pel_surface_sample *to = &out[from + (size_t)i];
            const struct reading *r = &searches[i].reading;
            surface_at(f, r, &searches[i].at, to);
            struct pel_vec3 *a = &to->acceleration_mps2;
            if (moving) {
                struct pel_vec2 surge = surge_at(f, r, 0, PEL_CASCADES);
                *a = (struct pel_vec3){ surge.x, surge.y, a->z };
            } else {
                *a = (struct pel_vec3){ NAN, NAN, NAN };
            }
            to->rest_m = searches[i].rest;
        }
    }
}

void pel_cascades_query(const struct pel_cascades *c,
                        const struct pel_vec2 *points, size_t n, double time_s,
                        bool moving, struct pel_surface_sample *out)
{
    if (n == 0) {
        return;
    }
    struct pel_kept_fields *kept =
        take(c, time_s, moving ? PEL_FIELDS_SURGE : PEL_FIELDS_VELOCITY);
    query(c, pel_fields_of(kept), moving, points, n, out);
    pel_fields_give(c, kept);
}

struct pel_vec3 pel_cascades_displace(const struct pel_cascades *c, double x_m,
                                      double y_m, double time_s)
{
    struct pel_kept_fields *kept = take(c, time_s, PEL_FIELDS_REST);
    const struct grids g = grids_of(c);
    struct reading r;
    struct shift s;
    read_at(c, &g, (struct pel_vec2){ x_m, y_m }, &r);
    shift_at(c, pel_fields_of(kept), &r, 0, PEL_CASCADES, &s);
    pel_fields_give(c, kept);
    return (struct pel_vec3){ s.d[0], s.d[1], s.d[2] };
}

/* --- at rest ----------------------------------------------------------------
 */

struct pel_moment *pel_moment_take(const struct pel_cascades *c, double time_s,
                                   bool moving)
{
    return (struct pel_moment *)take(
        c, time_s, moving ? PEL_FIELDS_SURGE : PEL_FIELDS_VELOCITY);
}

struct pel_moment *pel_breaking_take(const struct pel_cascades *c,
                                     double time_s)
{
    return (struct pel_moment *)take(c, time_s, PEL_FIELDS_BREAKING);
}

struct pel_vec2 pel_breaking_at(const struct pel_cascades *c,
                                const struct pel_moment *moment, double x,
                                double y, int index)
{
    const struct pel_cascade_fields *f =
        pel_fields_of((const struct pel_kept_fields *)moment);
    const struct grids g = grids_of(c);
    struct reading r;
    read_at(c, &g, (struct pel_vec2){ x, y }, &r);
    double fi = (double)r.beyond[2 * index];
    double fj = (double)r.beyond[2 * index + 1];
    int column[4];
    columns_of(&r, index, column);
    struct pel_vec2 z = { 0, 0 };
    for (int n = 0; n < 4; n++) {
        int row = row_of(&r, index, 1 + (n >> 1));
        const float *breaking = f->breaking[index][row + column[1 + (n & 1)]];
        double w = (n & 1 ? fi : 1 - fi) * (n & 2 ? fj : 1 - fj);
        z.x += w * (double)breaking[0];
        z.y += w * (double)breaking[1];
    }
    return z;
}

void pel_moment_give(const struct pel_cascades *c, struct pel_moment *moment)
{
    pel_fields_give(c, (struct pel_kept_fields *)moment);
}

void pel_moment_at_rest(const struct pel_cascades *c,
                        const struct pel_moment *moment, double x, double y,
                        int first, int end, struct pel_at_rest *out)
{
    const struct pel_cascade_fields *f =
        pel_fields_of((struct pel_kept_fields *)moment);
    const struct grids g = grids_of(c);
    struct reading r;
    struct shift s;
    read_at(c, &g, (struct pel_vec2){ x, y }, &r);
    shift_at(c, f, &r, first, end, &s);
    lanes4 v = velocity_at(f, &r, first, end);
    for (int n = 0; n < 3; n++) {
        out->d[n] += s.d[n];
        out->dx[n] += s.dx[n];
        out->dy[n] += s.dy[n];
        out->v[n] += v[n];
    }
    out->a[2] += v[3];
    if (f->surge[0]) {
        struct pel_vec2 surge = surge_at(f, &r, first, end);
        out->a[0] += surge.x;
        out->a[1] += surge.y;
    }
}
