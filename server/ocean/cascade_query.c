#include <stdlib.h>

#include "ocean/fields.h"
#include "ocean/rest.h"

#define N PEL_CASCADE_N
#define MET_M 1e-6
#define MOST_STEPS 40
#define MOST_HALVINGS 10

/* Where a place lies in a cascade's grid: texel below and fraction. */
struct place {
    int i, j;
    double fi, fj;
};

static struct place place_of(const struct pel_cascade *c, double x, double y)
{
    double u = (x * c->turn_cos + y * c->turn_sin) / c->length_m;
    double v = (y * c->turn_cos - x * c->turn_sin) / c->length_m;
    u = (u - floor(u)) * N - 0.5;
    v = (v - floor(v)) * N - 0.5;
    double i = floor(u), j = floor(v);
    return (struct place){ (int)i + N, (int)j + N, u - i, v - j };
}

/* Uniform cubic B-spline of the four texels around, and its derivative. */
static void spline(double f, double w[4], double d[4])
{
    double g = 1.0 - f;
    w[0] = g * g * g / 6.0;
    w[1] = (4.0 - 6.0 * f * f + 3.0 * f * f * f) / 6.0;
    w[2] = (4.0 - 6.0 * g * g + 3.0 * g * g * g) / 6.0;
    w[3] = f * f * f / 6.0;
    d[0] = -0.5 * g * g;
    d[1] = f * (1.5 * f - 2.0);
    d[2] = g * (2.0 - 1.5 * g);
    d[3] = 0.5 * f * f;
}

/* What the cascades do to one rest position. */
struct shift {
    double x, y, z;
    double xx, xy, yy; /* derivatives of (x, y) as interpolated */
};

static void sample_spline(float (*texels)[4], struct place p, double out[3])
{
    double wi[4], wj[4], unused[4];
    spline(p.fi, wi, unused);
    spline(p.fj, wj, unused);
    out[0] = out[1] = out[2] = 0;
    for (int b = 0; b < 4; b++) {
        for (int a = 0; a < 4; a++) {
            const float *t = texels[(p.j + b - 1) % N * N + (p.i + a - 1) % N];
            double w = wi[a] * wj[b];
            out[0] += w * t[0];
            out[1] += w * t[1];
            out[2] += w * t[2];
        }
    }
}

static void add_shift(const struct pel_cascade *c, float (*texels)[4], double x,
                      double y, struct shift *s)
{
    struct place p = place_of(c, x, y);
    double wi[4], wj[4], di[4], dj[4];
    spline(p.fi, wi, di);
    spline(p.fj, wj, dj);
    double xu = 0, xv = 0, yu = 0, yv = 0;
    for (int b = 0; b < 4; b++) {
        for (int a = 0; a < 4; a++) {
            const float *t = texels[(p.j + b - 1) % N * N + (p.i + a - 1) % N];
            double w = wi[a] * wj[b];
            s->x += w * t[0];
            s->y += w * t[1];
            s->z += w * t[2];
            xu += di[a] * wj[b] * t[0];
            xv += wi[a] * dj[b] * t[0];
            yu += di[a] * wj[b] * t[1];
            yv += wi[a] * dj[b] * t[1];
        }
    }
    double xy = xu * c->turn_sin + xv * c->turn_cos;
    double yx = yu * c->turn_cos - yv * c->turn_sin;
    s->xx += (xu * c->turn_cos - xv * c->turn_sin) / c->texel_m;
    s->yy += (yu * c->turn_sin + yv * c->turn_cos) / c->texel_m;
    s->xy += 0.5 * (xy + yx) / c->texel_m;
}

static void shift_at(const struct pel_cascades *c,
                     const struct pel_cascade_fields *f, double x, double y,
                     struct shift *s)
{
    *s = (struct shift){ 0 };
    for (int i = 0; i < PEL_CASCADES; i++) {
        add_shift(&c->cascade[i], f->displacement[i], x, y, s);
    }
}

/* The rest position that is carried to (x, y). */
static struct pel_vec2 rest_under(const struct pel_cascades *c,
                                  const struct pel_cascade_fields *f, double x,
                                  double y, struct shift *at)
{
    struct pel_vec2 rest = { x, y };
    shift_at(c, f, x, y, at);
    double rx = -at->x, ry = -at->y;
    double error = rx * rx + ry * ry;
    for (int step = 0; step < MOST_STEPS && error > MET_M * MET_M; step++) {
        struct pel_vec2 s =
            pel_rest_step(1.0 + at->xx, at->xy, 1.0 + at->yy, rx, ry);
        bool nearer = false;
        for (int i = 0; i < MOST_HALVINGS && !nearer; i++) {
            struct shift next;
            double nx = rest.x + s.x, ny = rest.y + s.y;
            shift_at(c, f, nx, ny, &next);
            double ex = x - nx - next.x, ey = y - ny - next.y;
            double e = ex * ex + ey * ey;
            if (e < error) {
                nearer = true;
                rest = (struct pel_vec2){ nx, ny };
                rx = ex;
                ry = ey;
                error = e;
                *at = next;
            }
            s.x *= 0.5;
            s.y *= 0.5;
        }
        if (!nearer) {
            break; /* the rounding of far places: as near as doubles go */
        }
    }
    return rest;
}

static double bilinear(const float *texels, int stride, struct place p)
{
    int i0 = p.i % N, i1 = (p.i + 1) % N, j0 = p.j % N, j1 = (p.j + 1) % N;
    double a = texels[(j0 * N + i0) * stride];
    double b = texels[(j0 * N + i1) * stride];
    double c = texels[(j1 * N + i0) * stride];
    double d = texels[(j1 * N + i1) * stride];
    return (1 - p.fj) * ((1 - p.fi) * a + p.fi * b) +
           p.fj * ((1 - p.fi) * c + p.fi * d);
}

static void surface_at(const struct pel_cascades *c,
                       const struct pel_cascade_fields *f, struct pel_vec2 rest,
                       double height, struct pel_surface_sample *out)
{
    double s[5] = { 0 }, v[3] = { 0 };
    for (int i = 0; i < PEL_CASCADES; i++) {
        struct place p = place_of(&c->cascade[i], rest.x, rest.y);
        for (int j = 0; j < 4; j++) {
            s[j] += bilinear(f->slopes[i][0] + j, 4, p);
        }
        s[4] += bilinear(f->fold[i], 1, p);
        double w[3];
        sample_spline(f->velocity[i], p, w);
        for (int j = 0; j < 3; j++) {
            v[j] += w[j];
        }
    }
    struct pel_vec3 along_x = { 1.0 + s[2], s[4], s[0] };
    struct pel_vec3 along_y = { s[4], 1.0 + s[3], s[1] };
    out->height_m = height;
    out->normal = pel_vec3_normalize(pel_vec3_cross(along_x, along_y));
    out->velocity_mps = (struct pel_vec3){ v[0], v[1], v[2] };
}

static struct pel_kept_fields *take(const struct pel_cascades *c, double time_s)
{
    struct pel_kept_fields *kept;
    if (pel_fields_take(c, time_s, &kept)) {
        abort();
    }
    return kept;
}

void pel_cascades_query(const struct pel_cascades *c,
                        const struct pel_vec2 *points, size_t n, double time_s,
                        struct pel_surface_sample *out)
{
    if (n == 0) {
        return;
    }
    struct pel_kept_fields *kept = take(c, time_s);
    for (size_t i = 0; i < n; i++) {
        struct shift at;
        struct pel_vec2 rest =
            rest_under(c, kept->fields, points[i].x, points[i].y, &at);
        surface_at(c, kept->fields, rest, at.z, &out[i]);
    }
    pel_fields_give(c, kept);
}

struct pel_vec3 pel_cascades_displace(const struct pel_cascades *c, double x_m,
                                      double y_m, double time_s)
{
    struct pel_kept_fields *kept = take(c, time_s);
    struct shift s;
    shift_at(c, kept->fields, x_m, y_m, &s);
    pel_fields_give(c, kept);
    return (struct pel_vec3){ s.x, s.y, s.z };
}
