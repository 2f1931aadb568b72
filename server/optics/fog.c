#include "optics/fog.h"

#include <math.h>
#include <stdbool.h>

#include "optics/atmosphere.h"
#include "optics/clouds.h"

#define G PEL_CLOUD_ASYMMETRY

double pel_fog_extinction(double visibility_m)
{
    return PEL_KOSCHMIEDER / visibility_m;
}

struct pel_shader_fog pel_fog_seen(const struct pel_fog *f, double time_s,
                                   double east_m, double north_m)
{
    struct pel_shader_fog s = { .place = { .x = 0 } };
    if (f->radius_m > 0) {
        double half = f->base_m > 0 ? 0.5 * (f->top_m - f->base_m) : f->top_m;
        s.shape =
            (struct pel_vec4){ (float)(f->top_m - half), (float)(1 / half),
                               (float)f->extinction, 0 };
        s.place = (struct pel_vec4){
            (float)(f->east_m + time_s * f->east_mps - east_m),
            (float)(f->north_m + time_s * f->north_mps - north_m),
            (float)(1 / (f->radius_m * f->radius_m)), 0
        };
        return s;
    }
    double soft = fmax(fmin(f->soft_m, f->top_m - fmax(f->base_m, 0)), 1);
    s.shape = (struct pel_vec4){ (float)(fmax(f->base_m, 0)), (float)f->top_m,
                                 (float)f->extinction, (float)soft };
    return s;
}

/* --- one layer ------------------------------------------------------------ */

static double ramp(double x)
{
    return pel_clamp(x, 0, 1);
}

/* Its integral. */
static double ramped(double x)
{
    return x < 1 ? 0.5 * ramp(x) * ramp(x) : x - 0.5;
}

/* One that does not stand on the sea has a lower edge. */
static double layer_density(const struct pel_shader_fog *f, double z)
{
    double soft = (double)f->shape.w, base = (double)f->shape.x;
    return ramp(((double)f->shape.y - z) / soft + 0.5) -
           (base > 0 ? ramp((base - z) / soft + 0.5) : 0);
}

/* What of it is above a height, over its extinction. */
static double layer_above(const struct pel_shader_fog *f, double z)
{
    double soft = (double)f->shape.w, base = (double)f->shape.x;
    return soft * (ramped(((double)f->shape.y - z) / soft + 0.5) -
                   (base > 0 ? ramped((base - z) / soft + 0.5) : 0));
}

static double height_at(double h, double mu, double t)
{
    double r = PEL_EARTH_RADIUS + h, rise = t * (t + 2 * r * mu);
    return h + rise / (sqrt(fmax(r * r + rise, 0)) + r);
}

/* Distances along a ray where it is z high; far away and behind: none. */
static void crossings(double h, double mu, double z, double out[2])
{
    double b = (PEL_EARTH_RADIUS + h) * mu;
    double c = (z - h) * (2 * PEL_EARTH_RADIUS + h + z);
    double root = b * b + c;
    out[0] = out[1] = -b;
    if (root > 0) {
        double q = b > 0 ? -b - sqrt(root) : -b + sqrt(root);
        double other = q != 0 ? -c / q : 0;
        out[0] = fmin(q, other);
        out[1] = fmax(q, other);
    }
}

static double layer_piece(const struct pel_shader_fog *f, double h, double mu,
                          double from, double to)
{
    double z0 = height_at(h, mu, from), z1 = height_at(h, mu, to);
    double dz = z1 - z0;
    double mean = fabs(dz) < 0.05
                      ? layer_density(f, 0.5 * (z0 + z1))
                      : (layer_above(f, z0) - layer_above(f, z1)) / dz;
    return (double)f->shape.z * (to - from) * mean;
}

/* Of light that is emitted evenly over an optical depth: its mean place. */
static double emitted_at(double tau)
{
    return tau < 0.02 ? 0.5 - tau / 12 : 1 / tau - 1 / expm1(fmin(tau, 80));
}

static double layer_way(const struct pel_shader_fog *f, double h, double mu,
                        double range, double *mean_m)
{
    double soft = 0.5 * (double)f->shape.w;
    double high[2], low[2];
    crossings(h, mu, (double)f->shape.y + soft, high);
    crossings(h, mu, (double)f->shape.x - soft, low);
    /* Down into it, and up out of it again. */
    double from = pel_clamp(high[0], 0, range);
    double to = pel_clamp(high[1], from, range);
    bool lifted = f->shape.x > 0;
    double lowest = pel_clamp(-(PEL_EARTH_RADIUS + h) * mu, from, to);
    double down = lifted ? pel_clamp(low[0], from, to) : lowest;
    double up = lifted ? pel_clamp(low[1], down, to) : lowest;
    double first = layer_piece(f, h, mu, from, down);
    double second = layer_piece(f, h, mu, up, to);
    if (mean_m) {
        double one = -expm1(-first), two = exp(-first) * -expm1(-second);
        double near = from + (down - from) * emitted_at(first);
        double far = up + (to - up) * emitted_at(second);
        *mean_m = (one * near + two * far) / fmax(one + two, 1e-30);
    }
    return first + second;
}

/* --- one bank --------------------------------------------------------------
 */

/* The integral of (c - q)⁺ between two places from where q is least: q = least
 * + a v². */
static double inside(double c, double least, double a, double from, double to)
{
    double w = sqrt(fmax(c - least, 0) / a);
    double v0 = fmax(from, -w), v1 = fmin(to, w);
    return v1 > v0
               ? (c - least) * (v1 - v0) - a / 3 * (v1 * v1 * v1 - v0 * v0 * v0)
               : 0;
}

static double bank_part(const struct pel_shader_fog *f, double least, double a,
                        double from, double to)
{
    const double rim = PEL_FOG_RIM;
    return (double)f->shape.z / rim *
           (inside(1, least, a, from, to) -
            inside(1 - rim, least, a, from, to));
}

static double bank_way(const struct pel_shader_fog *f, struct pel_vec3 at,
                       struct pel_vec3 dir, double range, double *mean_m)
{
    double x = at.x - (double)f->place.x, y = at.y - (double)f->place.y;
    double wide = (double)f->place.z, tall = (double)f->shape.y;
    tall *= tall;
    double level = dir.x * dir.x + dir.y * dir.y;
    /* The height about where the way comes nearest, the sea's curve and all. */
    double near = -(x * dir.x + y * dir.y) / fmax(level, 1e-12);
    near = pel_clamp(near, 0, range);
    double bend = 0.5 * level / PEL_EARTH_RADIUS;
    double z = height_at(at.z, dir.z, near) - (double)f->shape.x;
    double rise = dir.z + 2 * bend * near;
    x += near * dir.x;
    y += near * dir.y;
    double a = fmax(level * wide + (rise * rise + 2 * z * bend) * tall, 1e-12);
    double b = (x * dir.x + y * dir.y) * wide + rise * z * tall;
    double least = (x * x + y * y) * wide + z * z * tall - b * b / a;
    double from = b / a - near, to = from + range;
    double tau = bank_part(f, least, a, from, to);
    if (mean_m) {
        double w = sqrt(fmax(1 - least, 0) / a);
        double v0 = pel_clamp(-w, from, to), v1 = pel_clamp(w, from, to);
        *mean_m = v0 - from + (v1 - v0) * emitted_at(tau);
    }
    return tau;
}

/* --- either --------------------------------------------------------------- */

double pel_fog_way(const struct pel_shader_fog *f, struct pel_vec3 from,
                   struct pel_vec3 dir, double range_m, double *mean_m)
{
    return f->place.z > 0 ? bank_way(f, from, dir, range_m, mean_m)
                          : layer_way(f, from.z, dir.z, range_m, mean_m);
}

double pel_fog_slant(const struct pel_shader_fog *f, double mu)
{
    double way[2], top = (double)f->shape.y;
    crossings(0, fmax(mu, 0), top, way);
    return way[1] / top;
}

static double of_centre(const struct pel_shader_fog *f, struct pel_vec3 at)
{
    double x = at.x - (double)f->place.x, y = at.y - (double)f->place.y;
    return (x * x + y * y) * (double)f->place.z;
}

void pel_fog_column(const struct pel_shader_fog *f, struct pel_vec3 at,
                    double *above, double *below)
{
    if (f->place.z > 0) {
        double tall = (double)f->shape.y, z = at.z - (double)f->shape.x;
        double least = of_centre(f, at), far = 2 / tall;
        double ground = -(double)f->shape.x;
        *above = bank_part(f, least, tall * tall, z, fmax(far, z));
        *below = bank_part(f, least, tall * tall, fmax(ground, -far), z);
        return;
    }
    double here = layer_above(f, at.z);
    *above = (double)f->shape.z * here;
    *below = (double)f->shape.z * (layer_above(f, 0) - here);
}

double pel_fog_density(const struct pel_shader_fog *f, struct pel_vec3 at)
{
    if (f->place.z > 0) {
        double z = (at.z - (double)f->shape.x) * (double)f->shape.y;
        return ramp((1 - of_centre(f, at) - z * z) / PEL_FOG_RIM);
    }
    return layer_density(f, at.z);
}

static double phase(double g, double cosine)
{
    double x = 1 + g * g - 2 * g * cosine;
    return (1 - g * g) / (4 * PEL_PI * x * sqrt(x));
}

double pel_fog_source(const struct pel_fog_light *l, double *single)
{
    double all = (1 - G) * (l->above + l->below), t = (1 - G) * l->above;
    double inverse = 1 / (all + 4.0 / 3);
    double mu = fmax(l->mu, 0.02);
    double sea =
        0.06 * (l->sky + l->beam * fmax(l->mu, 0)) * (4.0 / 3) * inverse;
    double source =
        (l->sky * (all - t + 2.0 / 3) + sea * (t + 2.0 / 3)) * inverse / PEL_PI;
    double lit = fmin((1 - G) * l->way * mu, all);
    double turned = fmax(exp(-lit / mu) - exp(-l->way), 0);
    double wide = exp(-lit / mu) / (4 * PEL_PI); /* in the glow */
    source += l->beam * (pel_cloud_glow(lit, all, mu) - wide +
                         turned * phase(pow(G, 1 + l->way), l->cosine));
    *single = l->beam * phase(G, l->cosine) * exp(-l->way);
    return source + *single;
}
