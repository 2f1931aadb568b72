#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "base/simd.h"
#include "ocean/atrest.h"
#include "ocean/fields.h"
#include "ocean/newton.h"
#include "ocean/spline.h"

#define N PEL_CASCADE_N
/* So near the last step needs no new sums. */
#define NEAR_M 1e-4
#define MOST_STEPS 40
#define MOST_HALVINGS 10
#define TOGETHER 8 /* points whose searches take turns */

/* Where a place lies in a cascade's grid: texel below and fraction. */
struct place {
    int i, j;
    double fi, fj;
};

PEL_INLINE struct place place_of(const struct pel_cascade *c, double x,
                                 double y)
{
    double u = (x * c->turn_cos + y * c->turn_sin) / c->length_m;
    double v = (y * c->turn_cos - x * c->turn_sin) / c->length_m;
    u = (u - floor(u)) * N - 0.5;
    v = (v - floor(v)) * N - 0.5;
    double i = floor(u), j = floor(v);
    return (struct place){ (int)i + N, (int)j + N, u - i, v - j };
}

/* Where the cascades are read for a place. */
struct reading {
    struct place place[PEL_CASCADES];
    struct pel_sheared sheared;
};

PEL_INLINE void read_at(const struct pel_cascades *c, struct pel_vec2 at,
                        struct reading *r)
{
    pel_shear(&c->shears, at.x, at.y, &r->sheared);
    for (int i = 0; i < PEL_CASCADES; i++) {
        const double *place = r->sheared.place[i];
        r->place[i] = place_of(&c->cascade[i], place[0], place[1]);
    }
}

/* East, north, up and nothing, at once. */
typedef double lanes4 __attribute__((vector_size(32)));
typedef float texel4 __attribute__((vector_size(16)));

PEL_INLINE lanes4 texel_at(float (*texels)[4], int i, int j)
{
    texel4 t;
    memcpy(&t, texels[j % N * N + i % N], sizeof t);
    return __builtin_convertvector(t, lanes4);
}

/* What the cascades do to one rest position. */
struct shift {
    lanes4 d;      /* displacement */
    lanes4 dx, dy; /* its derivatives as interpolated */
};

PEL_INLINE lanes4 sample_spline(float (*texels)[4], struct place p)
{
    double wi[4], wj[4], unused[4];
    pel_cubic_spline(p.fi, wi, unused);
    pel_cubic_spline(p.fj, wj, unused);
    lanes4 sum = { 0, 0, 0, 0 };
    for (int b = 0; b < 4; b++) {
        for (int a = 0; a < 4; a++) {
            sum += wi[a] * wj[b] * texel_at(texels, p.i + a - 1, p.j + b - 1);
        }
    }
    return sum;
}

PEL_INLINE void add_shift(const struct pel_cascade *c, float (*texels)[4],
                          struct place p, const double by[4], struct shift *s)
{
    double wi[4], wj[4], di[4], dj[4];
    pel_cubic_spline(p.fi, wi, di);
    pel_cubic_spline(p.fj, wj, dj);
    lanes4 du = { 0, 0, 0, 0 }, dv = { 0, 0, 0, 0 };
    for (int b = 0; b < 4; b++) {
        lanes4 row = { 0, 0, 0, 0 }, along = { 0, 0, 0, 0 };
        for (int a = 0; a < 4; a++) {
            lanes4 t = texel_at(texels, p.i + a - 1, p.j + b - 1);
            row += wi[a] * t;
            along += di[a] * t;
        }
        s->d += wj[b] * row;
        du += wj[b] * along;
        dv += dj[b] * row;
    }
    double cosine = c->turn_cos / c->texel_m, sine = c->turn_sin / c->texel_m;
    lanes4 by_x = du * cosine - dv * sine, by_y = du * sine + dv * cosine;
    s->dx += by_x * by[0] + by_y * by[2];
    s->dy += by_x * by[1] + by_y * by[3];
}

PEL_INLINE void shift_at(const struct pel_cascades *c,
                         const struct pel_cascade_fields *f,
                         const struct reading *r, struct shift *s)
{
    *s = (struct shift){ 0 };
    for (int i = 0; i < PEL_CASCADES; i++) {
        add_shift(&c->cascade[i], f->displacement[i], r->place[i],
                  r->sheared.by[i], s);
    }
}

/* Asks for the texels of a spline there, which another place's sums hide. */
PEL_INLINE void fetch_spline(float (*texels)[4], struct place p)
{
    for (int b = -1; b <= 2; b++) {
        int row = (p.j + b) % N * N;
        __builtin_prefetch(texels[row + (p.i - 1) % N]);
        __builtin_prefetch(texels[row + (p.i + 2) % N]);
    }
}

PEL_INLINE void fetch_shift(const struct pel_cascade_fields *f,
                            const struct reading *r)
{
    for (int i = 0; i < PEL_CASCADES; i++) {
        fetch_spline(f->displacement[i], r->place[i]);
    }
}

PEL_INLINE void fetch_surface(const struct pel_cascade_fields *f,
                              const struct reading *r)
{
    for (int i = 0; i < PEL_CASCADES; i++) {
        fetch_spline(f->velocity[i], r->place[i]);
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
                           const struct pel_vec2 *points, int n,
                           struct search *searches)
{
    int left = n;
    for (int i = 0; i < n; i++) {
        searches[i] = (struct search){ .to = points[i],
                                       .trial = points[i],
                                       .error = INFINITY };
        read_at(c, points[i], &searches[i].reading);
        fetch_shift(f, &searches[i].reading);
    }
    while (left > 0) {
        left = 0;
        for (int i = 0; i < n; i++) {
            struct search *s = &searches[i];
            if (!s->done) {
                struct shift there;
                shift_at(c, f, &s->reading, &there);
                search_turn(s, &there);
                read_at(c, s->done ? s->rest : s->trial, &s->reading);
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
    lanes4 v = { 0, 0, 0, 0 };
    for (int i = 0; i < PEL_CASCADES; i++) {
        v += sample_spline(f->velocity[i], r->place[i]);
    }
    const lanes4 *dx = &there->dx, *dy = &there->dy;
    struct pel_vec3 along_x = { 1.0 + (*dx)[0], (*dx)[1], (*dx)[2] };
    struct pel_vec3 along_y = { (*dy)[0], 1.0 + (*dy)[1], (*dy)[2] };
    out->height_m = there->d[2];
    out->normal = pel_vec3_normalize(pel_vec3_cross(along_x, along_y));
    out->velocity_mps = (struct pel_vec3){ v[0], v[1], v[2] };
    out->acceleration_mps2 = (struct pel_vec3){ NAN, NAN, v[3] };
    out->depth_m = out->foam = NAN;
}

/* Of one cascade, added to the sum. */
PEL_INLINE void add_surge(const struct pel_cascade_fields *f, int i,
                          struct place p, struct pel_vec2 *sum)
{
    double wi[4], wj[4], unused[4];
    pel_cubic_spline(p.fi, wi, unused);
    pel_cubic_spline(p.fj, wj, unused);
    for (int b = 0; b < 4; b++) {
        for (int a = 0; a < 4; a++) {
            int at = (p.j + b - 1) % N * N + (p.i + a - 1) % N;
            sum->x += wi[a] * wj[b] * (double)f->surge[i][at][0];
            sum->y += wi[a] * wj[b] * (double)f->surge[i][at][1];
        }
    }
}

PEL_INLINE struct pel_vec2 surge_at(const struct pel_cascade_fields *f,
                                    const struct reading *r)
{
    struct pel_vec2 sum = { 0, 0 };
    for (int i = 0; i < PEL_CASCADES; i++) {
        add_surge(f, i, r->place[i], &sum);
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
    for (size_t from = 0; from < n; from += TOGETHER) {
        int count = (int)(n - from < TOGETHER ? n - from : TOGETHER);
        search_all(c, f, points + from, count, searches);
        for (int i = 0; i < count; i++) {
            struct pel_surface_sample *to = &out[from + (size_t)i];
            const struct reading *r = &searches[i].reading;
            surface_at(f, r, &searches[i].at, to);
            struct pel_vec3 *a = &to->acceleration_mps2;
            if (moving) {
                struct pel_vec2 surge = surge_at(f, r);
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
    struct reading r;
    struct shift s;
    read_at(c, (struct pel_vec2){ x_m, y_m }, &r);
    shift_at(c, pel_fields_of(kept), &r, &s);
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
    struct pel_sheared sheared;
    pel_shear(&c->shears, x, y, &sheared);
    const struct place p = place_of(&c->cascade[index], sheared.place[index][0],
                                    sheared.place[index][1]);
    struct pel_vec2 z = { 0, 0 };
    for (int n = 0; n < 4; n++) {
        int i = p.i + (n & 1), j = p.j + (n >> 1);
        const float *texel = f->breaking[index][j % N * N + i % N];
        double w = (n & 1 ? p.fi : 1 - p.fi) * (n & 2 ? p.fj : 1 - p.fj);
        z.x += w * (double)texel[0];
        z.y += w * (double)texel[1];
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
    struct reading r;
    read_at(c, (struct pel_vec2){ x, y }, &r);
    for (int i = first; i < end; i++) {
        struct shift s = { 0 };
        add_shift(&c->cascade[i], f->displacement[i], r.place[i],
                  r.sheared.by[i], &s);
        lanes4 v = sample_spline(f->velocity[i], r.place[i]);
        for (int n = 0; n < 3; n++) {
            out->d[n] += s.d[n];
            out->dx[n] += s.dx[n];
            out->dy[n] += s.dy[n];
            out->v[n] += v[n];
        }
        out->a[2] += v[3];
        if (f->surge[i]) {
            struct pel_vec2 surge = { 0, 0 };
            add_surge(f, i, r.place[i], &surge);
            out->a[0] += surge.x;
            out->a[1] += surge.y;
        }
    }
}
