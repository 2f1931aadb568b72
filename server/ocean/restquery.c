#include <math.h>
#include <stdlib.h>

#include "ocean/areas.h"
#include "ocean/atrest.h"
#include "ocean/newton.h"
#include "ocean/restquery.h"
#include "ocean/shore.h"
#include "ocean/wander.h"
#include "ocean/wash.h"

#define MET_M 1e-6
#define MOST_STEPS 40
#define MOST_HALVINGS 10

struct asked {
    const struct pel_sea *sea;
    struct pel_moment *moment; /* of cascades */
    double time_s;
    const struct pel_wash *wash; /* NULL: none */
};

/* Sums of waves at rest: what no factor changes, what areas do, and each band
 * of the shore's. */
enum { PLAIN, SHORT, BANDED, SUMS = BANDED + PEL_SHORE_BANDS };

static void add_trochoid(const struct pel_wave *w, double x, double y,
                         double time_s, struct pel_at_rest *to)
{
    struct pel_wave_phase p = pel_wave_at(w, x, y, time_s);
    double k = hypot(w->kx, w->ky);
    double s = sin(p.phase), c = cos(p.phase), h = w->amplitude;
    double ax = w->chop * h * w->kx / k, ay = w->chop * h * w->ky / k;
    struct pel_wave_rate rate = pel_wave_rate_at(w, x, y, time_s);
    const double d[3] = { -ax * s, -ay * s, h * c };
    const double turned[3] = { -ax * c, -ay * c, -h * s };
    for (int n = 0; n < 3; n++) {
        to->d[n] += d[n];
        to->dx[n] += p.kx * turned[n];
        to->dy[n] += p.ky * turned[n];
        to->v[n] -= rate.omega * turned[n];
        to->a[n] -= rate.faster * turned[n] + rate.omega * rate.omega * d[n];
    }
}

static bool is_short(const struct pel_wave *w)
{
    return hypot(w->kx, w->ky) * PEL_AREA_SHORTER_M > 2.0 * PEL_PI;
}

static void trochoids_at_rest(const struct asked *q, double x, double y,
                              const struct pel_vec2 *read,
                              struct pel_at_rest out[SUMS])
{
    const struct pel_shore *shore = q->sea->shore;
    for (int i = 0; i < q->sea->count; i++) {
        const struct pel_wave *w = &q->sea->waves[i];
        int band = shore ? shore->of_wave[i] : PEL_SHORE_BANDS;
        if (band < PEL_SHORE_BANDS) {
            add_trochoid(w, read[band].x, read[band].y, q->time_s,
                         &out[BANDED + band]);
        } else {
            add_trochoid(w, x, y, q->time_s, &out[is_short(w) ? SHORT : PLAIN]);
        }
    }
}

static void cascades_at_rest(const struct asked *q, double x, double y,
                             const struct pel_vec2 *read,
                             struct pel_at_rest out[SUMS])
{
    const struct pel_cascades *c = q->sea->cascades;
    const int bands = q->sea->shore ? q->sea->shore->bands : 0;
    for (int b = 0; b < bands; b++) {
        pel_moment_at_rest(c, q->moment, read[b].x, read[b].y, b, b + 1,
                           &out[BANDED + b]);
    }
    const int half = PEL_CASCADES / 2;
    pel_moment_at_rest(c, q->moment, x, y, bands, half, &out[PLAIN]);
    pel_moment_at_rest(c, q->moment, x, y, half, PEL_CASCADES, &out[SHORT]);
}

/* Adds waves times f = (level, level, high), whose derivatives by the place of
 * rest are fx, fy. */
static void add_times(const struct pel_at_rest *r, const double f[3],
                      const double fx[3], const double fy[3],
                      struct pel_at_rest *to)
{
    for (int n = 0; n < 3; n++) {
        to->d[n] += f[n] * r->d[n];
        to->dx[n] += f[n] * r->dx[n] + fx[n] * r->d[n];
        to->dy[n] += f[n] * r->dy[n] + fy[n] * r->d[n];
        to->v[n] += f[n] * r->v[n];
        to->a[n] += f[n] * r->a[n];
    }
}

static double factor_at(const struct asked *q, double x, double y,
                        struct pel_vec2 *slope)
{
    double up = pel_areas_factor(&q->sea->desc, x, y, q->time_s, slope);
    if (q->wash) {
        struct pel_vec2 more;
        double by = pel_wash_factor(q->wash, x, y, &more);
        slope->x = slope->x * by + up * more.x;
        slope->y = slope->y * by + up * more.y;
        up *= by;
        if (up > PEL_AREA_MOST) {
            up = PEL_AREA_MOST;
            *slope = (struct pel_vec2){ 0, 0 };
        }
    }
    return up;
}

static void add_short(const struct asked *q, double x, double y,
                      const struct pel_at_rest *r, struct pel_at_rest *to)
{
    struct pel_vec2 slope = { 0, 0 };
    double up = factor_at(q, x, y, &slope);
    bool level = up > 1.0;
    const double f[3] = { level ? 1.0 : up, level ? 1.0 : up, up };
    const double fx[3] = { level ? 0.0 : slope.x, level ? 0.0 : slope.x,
                           slope.x };
    const double fy[3] = { level ? 0.0 : slope.y, level ? 0.0 : slope.y,
                           slope.y };
    add_times(r, f, fx, fy, to);
}

/* A band's waves, of which r has the derivatives by the place they are read at.
 */
static void add_band(const struct pel_shore_band *band,
                     const struct pel_shored *here, struct pel_at_rest *r,
                     struct pel_at_rest *to)
{
    for (int n = 0; n < 3; n++) {
        double along = band->x * r->dx[n] + band->y * r->dy[n];
        r->dx[n] += along * here->sx;
        r->dy[n] += along * here->sy;
    }
    const double f[3] = { here->b, here->b, here->a };
    const double fx[3] = { here->bx, here->bx, here->ax };
    const double fy[3] = { here->by, here->by, here->ay };
    add_times(r, f, fx, fy, to);
}

/* All waves together. */
static void at_rest(const struct asked *q, double x, double y,
                    struct pel_at_rest *out)
{
    const struct pel_shore *shore = q->sea->shore;
    const int bands = shore ? shore->bands : 0;
    struct pel_at_rest sums[SUMS] = { 0 };
    struct pel_shored here[PEL_SHORE_BANDS];
    struct pel_vec2 read[PEL_SHORE_BANDS] = { { 0 } };
    for (int b = 0; b < bands; b++) {
        pel_shore_at(shore, b, x, y, &here[b]);
        read[b] = (struct pel_vec2){ x + here[b].s * shore->band[b].x,
                                     y + here[b].s * shore->band[b].y };
    }
    (q->moment ? cascades_at_rest : trochoids_at_rest)(q, x, y, read, sums);
    *out = sums[PLAIN];
    for (int b = 0; b < bands; b++) {
        add_band(&shore->band[b], &here[b], &sums[BANDED + b], out);
    }
    add_short(q, x, y, &sums[SHORT], out);
}

static void answer(const struct pel_at_rest *r, bool moving,
                   struct pel_surface_sample *out)
{
    struct pel_vec3 along_x = { 1.0 + r->dx[0], r->dx[1], r->dx[2] };
    struct pel_vec3 along_y = { r->dy[0], 1.0 + r->dy[1], r->dy[2] };
    out->height_m = r->d[2];
    out->normal = pel_vec3_normalize(pel_vec3_cross(along_x, along_y));
    out->velocity_mps = (struct pel_vec3){ r->v[0], r->v[1], r->v[2] };
    out->acceleration_mps2 =
        moving ? (struct pel_vec3){ r->a[0], r->a[1], r->a[2] }
               : (struct pel_vec3){ NAN, NAN, NAN };
    out->depth_m = out->foam = NAN;
}

/* Newton's steps to the rest position that is carried to `to`, each halved
 * until it leads nearer. */
static void find(const struct asked *q, struct pel_vec2 to,
                 struct pel_at_rest *at)
{
    double x = to.x, y = to.y;
    at_rest(q, x, y, at);
    double rx = -at->d[0], ry = -at->d[1], error = rx * rx + ry * ry;
    bool nearer = true;
    for (int i = 0; i < MOST_STEPS && nearer && error > MET_M * MET_M; i++) {
        struct pel_vec2 s = pel_newton_step(1.0 + at->dx[0], at->dy[0],
                                            at->dx[1], 1.0 + at->dy[1], rx, ry);
        nearer = false;
        for (int k = 0; k < MOST_HALVINGS && !nearer; k++) {
            struct pel_at_rest there;
            at_rest(q, x + s.x, y + s.y, &there);
            double ex = to.x - x - s.x - there.d[0];
            double ey = to.y - y - s.y - there.d[1];
            if (ex * ex + ey * ey < error) {
                nearer = true;
                x += s.x;
                y += s.y;
                rx = ex;
                ry = ey;
                error = ex * ex + ey * ey;
                *at = there;
            }
            s.x *= 0.5;
            s.y *= 0.5;
        }
    }
}

void pel_rest_query(const struct pel_sea *sea, const struct pel_vec2 *points,
                    size_t n, double time_s, bool moving,
                    const struct pel_wash *wash, struct pel_surface_sample *out)
{
    struct asked q = { sea, NULL, time_s, wash };
    if (n == 0) {
        return;
    }
    if (sea->cascades) {
        q.moment = pel_moment_take(sea->cascades, time_s, moving);
    }
    for (size_t i = 0; i < n; i++) {
        struct pel_at_rest at;
        find(&q, points[i], &at);
        answer(&at, moving, &out[i]);
        out[i].rest_m =
            (struct pel_vec2){ points[i].x - at.d[0], points[i].y - at.d[1] };
    }
    if (sea->cascades) {
        pel_moment_give(sea->cascades, q.moment);
    }
}

struct pel_vec3 pel_rest_displace(const struct pel_sea *sea, double x_m,
                                  double y_m, double time_s)
{
    struct asked q = { sea, NULL, time_s, NULL };
    struct pel_at_rest at;
    if (sea->cascades) {
        q.moment = pel_moment_take(sea->cascades, time_s, false);
    }
    at_rest(&q, x_m, y_m, &at);
    if (sea->cascades) {
        pel_moment_give(sea->cascades, q.moment);
    }
    return (struct pel_vec3){ at.d[0], at.d[1], at.d[2] };
}
