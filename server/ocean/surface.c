#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "base/simd.h"
#include "ocean/fields.h"
#include "ocean/newton.h"
#include "ocean/restquery.h"
#include "ocean/shore.h"
#include "ocean/wander.h"

#define MET_M 1e-6
#define MOST_STEPS 40
#define MOST_HALVINGS 10
/* From so near the last step needs no new sines (see finish). */
#define NEAR_M 1e-4

/* Waves at a time: one register of AVX2, two of any other 64-bit machine,
 * with the same bits, since nothing is contracted. */
#define WIDTH 4
typedef double lanes4 __attribute__((vector_size(8 * WIDTH)));
typedef uint64_t bits4 __attribute__((vector_size(8 * WIDTH)));
#define LANES (PEL_SEA_MAX_WAVES / WIDTH)

PEL_INLINE lanes4 all(double v)
{
    return (lanes4){ v, v, v, v };
}

PEL_INLINE double total(lanes4 v)
{
    return (v[0] + v[1]) + (v[2] + v[3]);
}

/* sin and cos of |x| < 8e8, absolute error below 1e-13 plus the rounding of x:
 * reduction by π/2 in three parts (24, 24 and 53 bits, products exact), then
 * Taylor's series on [−π/4, π/4]. */
PEL_INLINE void sincos4(lanes4 x, lanes4 *sn, lanes4 *cs)
{
    const lanes4 shift = all(0x1.8p52);
    lanes4 turned = x * all(0.63661977236758134308) + shift;
    bits4 quadrant = (bits4)turned; /* the low bits hold the integer */
    lanes4 n = turned - shift;
    lanes4 r = ((x - n * all(0x1.921fb4p+0)) - n * all(0x1.4442dp-24)) -
               n * all(0x1.8469898cc5170p-48);
    lanes4 z = r * r;
    lanes4 s = all(1.0 / 6227020800.0);
    s = s * z - all(1.0 / 39916800.0);
    s = s * z + all(1.0 / 362880.0);
    s = s * z - all(1.0 / 5040.0);
    s = s * z + all(1.0 / 120.0);
    s = s * z - all(1.0 / 6.0);
    s = s * z * r + r;
    lanes4 c = all(-1.0 / 87178291200.0);
    c = c * z + all(1.0 / 479001600.0);
    c = c * z - all(1.0 / 3628800.0);
    c = c * z + all(1.0 / 40320.0);
    c = c * z - all(1.0 / 720.0);
    c = c * z + all(1.0 / 24.0);
    c = c * z - all(0.5);
    c = c * z + all(1.0);
    bits4 one = { 1, 1, 1, 1 }, two = { 2, 2, 2, 2 };
    bits4 odd = -(quadrant & one);
    bits4 s_bits = ((bits4)s & ~odd) | ((bits4)c & odd);
    bits4 c_bits = ((bits4)c & ~odd) | ((bits4)s & odd);
    *sn = (lanes4)(s_bits ^ ((quadrant & two) << 62));
    *cs = (lanes4)(c_bits ^ (((quadrant + one) & two) << 62));
}

/* The waves of one moment, turned on their side. */
struct lanes {
    int count;
    lanes4 kx[LANES], ky[LANES], phase[LANES]; /* phase − ω t */
    lanes4 ax[LANES], ay[LANES];               /* k̂ c h */
    lanes4 h[LANES], omega[LANES];
    /* wander.h: wander, its s at the origin now, and swing times wander */
    lanes4 mx[LANES], my[LANES], start[LANES], swing[LANES];
    lanes4 wx[LANES], wy[LANES];
    lanes4 rate[LANES], surge[LANES]; /* swing · rate, 4 swing · rate² */
};

static void lanes_fill(const struct pel_sea *sea, double t, struct lanes *l)
{
    l->count = (sea->count + WIDTH - 1) / WIDTH;
    for (int i = 0; i < WIDTH * l->count; i++) {
        struct pel_wave w = { 0 };
        if (i < sea->count) {
            w = sea->waves[i];
        }
        double k = sqrt(w.kx * w.kx + w.ky * w.ky);
        double a = k > 0 ? w.chop * w.amplitude / k : 0;
        int v = i / WIDTH, j = i % WIDTH;
        l->kx[v][j] = w.kx;
        l->ky[v][j] = w.ky;
        l->phase[v][j] = remainder(w.phase - w.omega * t, 2.0 * PEL_PI);
        l->ax[v][j] = w.kx * a;
        l->ay[v][j] = w.ky * a;
        l->h[v][j] = w.amplitude;
        l->omega[v][j] = w.omega;
        l->mx[v][j] = w.wander_x;
        l->my[v][j] = w.wander_y;
        l->start[v][j] =
            remainder(w.wander_start - w.wander_rate * t, 1.0) - 0.5;
        l->swing[v][j] = w.swing;
        l->wx[v][j] = w.swing * w.wander_x;
        l->wy[v][j] = w.swing * w.wander_y;
        l->rate[v][j] = w.swing * w.wander_rate;
        l->surge[v][j] = 4.0 * l->rate[v][j] * w.wander_rate;
    }
}

/* What the sum does to one rest position, D = (−k̂ c h sin p, h cos p). */
struct shift {
    double dx, dy;
    double xx, xy, yx, yy; /* ∂dx/∂x, ∂dx/∂y, ∂dy/∂x, ∂dy/∂y */
    lanes4 sn[LANES], cs[LANES];
    lanes4 r[LANES]; /* of wander.h */
};

/* x less the nearest whole number: within ±½, and −½ as well as ½. */
PEL_INLINE lanes4 fold1(lanes4 x)
{
    const lanes4 shift = all(0x1.8p52);
    return x - ((x + shift) - shift);
}

PEL_INLINE lanes4 abs4(lanes4 x)
{
    return (lanes4)((bits4)x & ~((bits4){ 0 } + (UINT64_C(1) << 63)));
}

struct gradient {
    lanes4 xx, xy, yx, yy;
};

/* Of wave i where its wander's G' is u. */
PEL_INLINE void add_gradient(const struct lanes *l, int i, lanes4 u, lanes4 cs,
                             struct gradient *to)
{
    lanes4 kx = (l->kx[i] + u * l->wx[i]) * cs;
    lanes4 ky = (l->ky[i] + u * l->wy[i]) * cs;
    to->xx -= l->ax[i] * kx;
    to->xy -= l->ax[i] * ky;
    to->yx -= l->ay[i] * kx;
    to->yy -= l->ay[i] * ky;
}

PEL_INLINE void take_gradient(const struct gradient *from, struct shift *to)
{
    to->xx = total(from->xx);
    to->xy = total(from->xy);
    to->yx = total(from->yx);
    to->yy = total(from->yy);
}

PEL_INLINE void shift_at(const struct lanes *l, double x, double y,
                         struct shift *out)
{
    lanes4 dx = all(0), dy = all(0);
    struct gradient d = { 0 };
    lanes4 px = all(x), py = all(y);
    for (int i = 0; i < l->count; i++) {
        lanes4 sn, cs;
        lanes4 r = fold1(l->mx[i] * px + l->my[i] * py + l->start[i]);
        lanes4 q = abs4(r);
        sincos4(l->kx[i] * px + l->ky[i] * py + l->phase[i] +
                    l->swing[i] * (r - (r + r) * q),
                &sn, &cs);
        dx -= l->ax[i] * sn;
        dy -= l->ay[i] * sn;
        add_gradient(l, i, all(1.0) - all(4.0) * q, cs, &d);
        out->sn[i] = sn;
        out->cs[i] = cs;
        out->r[i] = r;
    }
    out->dx = total(dx);
    out->dy = total(dy);
    take_gradient(&d, out);
}

/* Height, exact normal and particle velocity where `s` was taken. */
PEL_INLINE void surface_of(const struct lanes *l, const struct shift *s,
                           struct pel_surface_sample *out)
{
    lanes4 dz = all(0), zx = all(0), zy = all(0);
    lanes4 vx = all(0), vy = all(0), vz = all(0);
    for (int i = 0; i < l->count; i++) {
        lanes4 u = all(1.0) - all(4.0) * abs4(s->r[i]);
        lanes4 omega = l->omega[i] + u * l->rate[i];
        dz += l->h[i] * s->cs[i];
        zx -= l->h[i] * (l->kx[i] + u * l->wx[i]) * s->sn[i];
        zy -= l->h[i] * (l->ky[i] + u * l->wy[i]) * s->sn[i];
        vx += l->ax[i] * omega * s->cs[i];
        vy += l->ay[i] * omega * s->cs[i];
        vz += l->h[i] * omega * s->sn[i];
    }
    struct pel_vec3 along_x = { 1.0 + s->xx, s->yx, total(zx) };
    struct pel_vec3 along_y = { s->xy, 1.0 + s->yy, total(zy) };
    out->height_m = total(dz);
    out->normal = pel_vec3_normalize(pel_vec3_cross(along_x, along_y));
    out->velocity_mps = (struct pel_vec3){ total(vx), total(vy), total(vz) };
    out->acceleration_mps2 = (struct pel_vec3){ NAN, NAN, NAN };
    out->depth_m = out->foam = NAN;
}

PEL_INLINE struct pel_vec3 acceleration_of(const struct lanes *l,
                                           const struct shift *s)
{
    lanes4 x = all(0), y = all(0), z = all(0);
    for (int i = 0; i < l->count; i++) {
        lanes4 u = all(1.0) - all(4.0) * abs4(s->r[i]);
        lanes4 omega = l->omega[i] + u * l->rate[i];
        /* ∂Ω/∂t: u rises before the middle of a turn, as s falls. */
        bits4 sign = (bits4)s->r[i] & ((bits4){ 0 } + (UINT64_C(1) << 63));
        lanes4 faster = (lanes4)((bits4)l->surge[i] ^ sign);
        lanes4 across = omega * omega * s->sn[i] + faster * s->cs[i];
        x += l->ax[i] * across;
        y += l->ay[i] * across;
        z -= l->h[i] * (omega * omega * s->cs[i] - faster * s->sn[i]);
    }
    return (struct pel_vec3){ total(x), total(y), total(z) };
}

/* Newton's last step, shorter than NEAR_M: the phases turn by so little that
 * their sines follow by a short series, |error| < 1e-7 for waves of 2 cm, and
 * what the step itself leaves is its square times the curvature, < 1e-7 m. */
PEL_INLINE void finish(const struct lanes *l, struct pel_vec2 step,
                       struct shift *s)
{
    struct gradient g = { 0 };
    lanes4 px = all(step.x), py = all(step.y);
    for (int i = 0; i < l->count; i++) {
        lanes4 u = all(1.0) - all(4.0) * abs4(s->r[i]);
        lanes4 p =
            (l->kx[i] + u * l->wx[i]) * px + (l->ky[i] + u * l->wy[i]) * py;
        lanes4 c = all(1.0) - p * p * all(0.5);
        lanes4 d = p - p * p * p * all(1.0 / 6.0);
        lanes4 sn = s->sn[i] * c + s->cs[i] * d;
        lanes4 cs = s->cs[i] * c - s->sn[i] * d;
        add_gradient(l, i, u, cs, &g);
        s->sn[i] = sn;
        s->cs[i] = cs;
    }
    take_gradient(&g, s);
}

/* Finds the rest position that is carried to (x, y); returns where its sums
 * are, one of the two. */
PEL_INLINE struct shift *rest_under(const struct lanes *l, double x, double y,
                                    struct shift two[2])
{
    struct shift *at = &two[0], *next = &two[1];
    double x0 = x, y0 = y;
    shift_at(l, x0, y0, at);
    double rx = -at->dx, ry = -at->dy;
    double error = rx * rx + ry * ry;
    for (int step = 0; step < MOST_STEPS && error > MET_M * MET_M; step++) {
        struct pel_vec2 s =
            pel_newton_step(1.0 + at->xx, at->xy, at->yx, 1.0 + at->yy, rx, ry);
        if (s.x * s.x + s.y * s.y < NEAR_M * NEAR_M) {
            finish(l, s, at);
            break;
        }
        bool nearer = false;
        for (int i = 0; i < MOST_HALVINGS && !nearer; i++) {
            double nx = x0 + s.x, ny = y0 + s.y;
            shift_at(l, nx, ny, next);
            double ex = x - nx - next->dx, ey = y - ny - next->dy;
            double e = ex * ex + ey * ey;
            if (e < error) {
                nearer = true;
                x0 = nx;
                y0 = ny;
                rx = ex;
                ry = ey;
                error = e;
                struct shift *swap = at;
                at = next;
                next = swap;
            }
            s.x *= 0.5;
            s.y *= 0.5;
        }
        if (!nearer) {
            break; /* the rounding of far places: as near as doubles go */
        }
    }
    return at;
}

PEL_CLONES
static void query(const struct lanes *l, const struct pel_vec2 *points,
                  size_t n, bool moving, struct pel_surface_sample *out)
{
    struct shift two[2];
    for (size_t i = 0; i < n; i++) {
        const struct shift *s = rest_under(l, points[i].x, points[i].y, two);
        surface_of(l, s, &out[i]);
        out[i].rest_m =
            (struct pel_vec2){ points[i].x - s->dx, points[i].y - s->dy };
        if (moving) {
            out[i].acceleration_mps2 = acceleration_of(l, s);
        }
    }
}

static void query_far(const struct pel_sea *sea, const struct pel_vec2 *points,
                      size_t n, double time_s, bool moving,
                      struct pel_surface_sample *out)
{
    if (sea->desc.area_count) {
        pel_rest_query(sea, points, n, time_s, moving, NULL, out);
        return;
    }
    if (sea->cascades) {
        pel_cascades_query(sea->cascades, points, n, time_s, moving, out);
        return;
    }
    struct lanes lanes;
    lanes_fill(sea, time_s, &lanes);
    query(&lanes, points, n, moving, out);
}

/* Places whose waves feel no bottom are answered as without one. */
static void query_sea(const struct pel_sea *sea, const struct pel_vec2 *points,
                      size_t n, double time_s, bool moving,
                      struct pel_surface_sample *out)
{
    for (size_t first = 0, end; first < n; first = end) {
        bool far = !sea->shore ||
                   pel_shore_far(sea->shore, points[first].x, points[first].y);
        for (end = first + 1; end < n; end++) {
            if (sea->shore && pel_shore_far(sea->shore, points[end].x,
                                            points[end].y) != far) {
                break;
            }
        }
        if (far) {
            query_far(sea, points + first, end - first, time_s, moving,
                      out + first);
        } else {
            pel_rest_query(sea, points + first, end - first, time_s, moving,
                           NULL, out + first);
        }
    }
}

void pel_sea_query(const struct pel_sea *sea, const struct pel_vec2 *points,
                   size_t n, double time_s, struct pel_surface_sample *out)
{
    query_sea(sea, points, n, time_s, false, out);
}

void pel_sea_query_moving(const struct pel_sea *sea,
                          const struct pel_vec2 *points, size_t n,
                          double time_s, struct pel_surface_sample *out)
{
    query_sea(sea, points, n, time_s, true, out);
}

bool pel_sea_prepare(const struct pel_sea *sea, double time_s, bool moving,
                     bool (*go_on)(void *user), void *user)
{
    return !sea->cascades ||
           pel_fields_prepare(sea->cascades, time_s,
                              moving ? PEL_FIELDS_SURGE : PEL_FIELDS_VELOCITY,
                              go_on, user);
}

void pel_sea_hold(const struct pel_sea *sea, const double times_s[PEL_SEA_HELD])
{
    if (sea->cascades) {
        pel_fields_hold(sea->cascades, times_s, PEL_SEA_HELD);
    }
}

void pel_sea_sample(const struct pel_sea *sea, double x_m, double y_m,
                    double time_s, struct pel_surface_sample *out)
{
    struct pel_vec2 p = { x_m, y_m };
    pel_sea_query(sea, &p, 1, time_s, out);
}

struct pel_vec3 pel_sea_displace(const struct pel_sea *sea, double x_m,
                                 double y_m, double time_s)
{
    struct pel_vec3 d = { 0, 0, 0 };
    if (sea->desc.area_count ||
        (sea->shore && !pel_shore_far(sea->shore, x_m, y_m))) {
        return pel_rest_displace(sea, x_m, y_m, time_s);
    }
    if (sea->cascades) {
        return pel_cascades_displace(sea->cascades, x_m, y_m, time_s);
    }
    for (int i = 0; i < sea->count; i++) {
        const struct pel_wave *w = &sea->waves[i];
        double p = pel_wave_at(w, x_m, y_m, time_s).phase;
        double k = sqrt(w->kx * w->kx + w->ky * w->ky);
        double across = w->chop * w->amplitude * sin(p) / k;
        d.x -= w->kx * across;
        d.y -= w->ky * across;
        d.z += w->amplitude * cos(p);
    }
    return d;
}
