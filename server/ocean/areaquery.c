#include <math.h>
#include <stdlib.h>

#include "ocean/areas.h"
#include "ocean/atrest.h"
#include "ocean/newton.h"
#include "ocean/wander.h"
#include "ocean/wash.h"

#define MET_M 1e-6
#define MOST_STEPS 40
#define MOST_HALVINGS 10

/* What trochoids do to the water that rests at (x, y). */
static void trochoids_at_rest(const struct pel_sea *sea, double x, double y,
                              double time_s, struct pel_at_rest out[2])
{
    for (int i = 0; i < sea->count; i++) {
        const struct pel_wave *w = &sea->waves[i];
        struct pel_wave_phase p = pel_wave_at(w, x, y, time_s);
        double k = hypot(w->kx, w->ky);
        struct pel_at_rest *to =
            &out[k * PEL_AREA_SHORTER_M > 2.0 * PEL_PI ? 1 : 0];
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
            to->a[n] -=
                rate.faster * turned[n] + rate.omega * rate.omega * d[n];
        }
    }
}

struct asked {
    const struct pel_sea *sea;
    struct pel_moment *moment; /* of cascades */
    double time_s;
    const struct pel_wash *wash; /* NULL: none */
};

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

/* All waves together, the short ones by their factor. */
static void at_rest(const struct asked *q, double x, double y,
                    struct pel_at_rest *out)
{
    struct pel_at_rest two[2] = { 0 };
    struct pel_vec2 slope;
    if (q->moment) {
        pel_moment_at_rest(q->sea->cascades, q->moment, x, y, two);
    } else {
        trochoids_at_rest(q->sea, x, y, q->time_s, two);
    }
    double up = factor_at(q, x, y, &slope);
    *out = two[0];
    for (int n = 0; n < 3; n++) {
        bool level = n < 2 && up > 1.0;
        double by = level ? 1.0 : up;
        double gx = level ? 0.0 : slope.x, gy = level ? 0.0 : slope.y;
        out->d[n] += by * two[1].d[n];
        out->dx[n] += by * two[1].dx[n] + gx * two[1].d[n];
        out->dy[n] += by * two[1].dy[n] + gy * two[1].d[n];
        out->v[n] += by * two[1].v[n];
        out->a[n] += by * two[1].a[n];
    }
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
    out->depth_m = NAN;
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

void pel_areas_query(const struct pel_sea *sea, const struct pel_vec2 *points,
                     size_t n, double time_s, bool moving,
                     const struct pel_wash *wash,
                     struct pel_surface_sample *out)
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
    }
    if (sea->cascades) {
        pel_moment_give(sea->cascades, q.moment);
    }
}

struct pel_vec3 pel_areas_displace(const struct pel_sea *sea, double x_m,
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
