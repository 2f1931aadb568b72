#include "sealight.h"

#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846
/* The Sun's radius seen from the Earth, mean. */
#define SUN_RADIUS_RAD 4.652e-3

void sea_sky_look(const struct sea_sky *sky, const double *direction,
                  double *radiance)
{
    double elevation = asin(fmin(fmax(direction[2], 0), 1));
    double along = sky->sun[0], aside = sky->sun[1];
    double flat = hypot(along, aside);
    double azimuth =
        flat > 0 ? atan2(fabs(along * direction[1] - aside * direction[0]),
                         along * direction[0] + aside * direction[1])
                 : 0;
    double a = sqrt(elevation / (PI / 2)) * (SEA_SKY_ELEVATIONS - 1);
    double b = azimuth / PI * (SEA_SKY_AZIMUTHS - 1);
    int i = (int)fmin(a, SEA_SKY_ELEVATIONS - 2);
    int j = (int)fmin(b, SEA_SKY_AZIMUTHS - 2);
    a -= i;
    b -= j;
    for (int c = 0; c < SEA_CHANNELS; c++) {
        radiance[c] = (1 - a) * ((1 - b) * sky->radiance[i][j][c] +
                                 b * sky->radiance[i][j + 1][c]) +
                      a * ((1 - b) * sky->radiance[i + 1][j][c] +
                           b * sky->radiance[i + 1][j + 1][c]);
    }
}

/* Direction from the sea to the eye, spread over the row's fields. */
static void to_eye(const struct sea_row *row, struct sea_random *random,
                   double *v)
{
    double h = (sea_random_unit(random) - 0.5) * row->wide_rad;
    double u = (sea_random_unit(random) - 0.5) * row->high_rad;
    /* The eye's own axes: right, up, forward; small fields. */
    double z = row->zenith_rad, a = row->azimuth_rad;
    double forward[3] = { sin(z) * cos(a), sin(z) * sin(a), -cos(z) };
    double right[3] = { sin(a), -cos(a), 0 };
    double up[3] = { cos(z) * cos(a), cos(z) * sin(a), sin(z) };
    double length = 0;
    for (int i = 0; i < 3; i++) {
        v[i] = -(forward[i] + tan(h) * right[i] + tan(u) * up[i]);
        length += v[i] * v[i];
    }
    for (int i = 0; i < 3; i++) {
        v[i] /= sqrt(length);
    }
}

/* A point of the Sun's disc. */
static void to_sun(const struct sea_sky *sky, struct sea_random *random,
                   double *s)
{
    double r = SUN_RADIUS_RAD * sqrt(sea_random_unit(random));
    double angle = 2 * PI * sea_random_unit(random);
    const double *c = sky->sun;
    double flat = hypot(c[0], c[1]);
    double right[3] = { c[1] / flat, -c[0] / flat, 0 };
    double up[3] = { -c[2] * c[0] / flat, -c[2] * c[1] / flat, flat };
    double length = 0;
    for (int i = 0; i < 3; i++) {
        s[i] = c[i] + r * (cos(angle) * right[i] + sin(angle) * up[i]);
        length += s[i] * s[i];
    }
    for (int i = 0; i < 3; i++) {
        s[i] /= sqrt(length);
    }
}

/* The normal that mirrors s to v, and its slopes; 0 where it looks down. */
static int mirror_normal(const double *v, const double *s, double *n,
                         double *slope)
{
    double length = 0;
    for (int i = 0; i < 3; i++) {
        n[i] = v[i] + s[i];
        length += n[i] * n[i];
    }
    length = sqrt(length);
    if (length < 1e-9 || n[2] <= 1e-6 * length) {
        return 0;
    }
    for (int i = 0; i < 3; i++) {
        n[i] /= length;
    }
    slope[0] = -n[0] / n[2];
    slope[1] = -n[1] / n[2];
    return 1;
}

/* Density of slopes at `wanted` from samples near it: a disc of radius 0.15
 * (far: 0.3) of the root mean square slope of an axis, each sample weighted by
 * how much likelier `wanted` is to a Gaussian of the sea's slopes, which takes
 * away the error of first and second order that a disc's mean would have. */
struct kernel {
    double xx, xy, yy; /* inverse of the covariance */
    double radius2, height;
};

static struct kernel make_kernel(const struct sea_surface *surface,
                                 double share)
{
    double a = surface->along, c = surface->cross;
    double wx = surface->wind_x, wy = surface->wind_y;
    struct kernel k = { .xx = wx * wx / a + wy * wy / c,
                        .xy = wx * wy / a - wx * wy / c,
                        .yy = wy * wy / a + wx * wx / c };
    k.radius2 = share * share * 0.5 * (a + c);
    k.height = 1 / (PI * k.radius2);
    return k;
}

static inline double kernel_at(const struct kernel *k, double x, double y,
                               const double *wanted)
{
    double dx = x - wanted[0], dy = y - wanted[1];
    if (dx * dx + dy * dy >= k->radius2) {
        return 0;
    }
    double here = k->xx * x * x + 2 * k->xy * x * y + k->yy * y * y;
    double there = k->xx * wanted[0] * wanted[0] +
                   2 * k->xy * wanted[0] * wanted[1] +
                   k->yy * wanted[1] * wanted[1];
    return k->height * exp(0.5 * (here - there));
}

/* --- rays of the eye ------------------------------------------------------ */

/* The Sun mirrored at a hit towards where the ray came from. */
static double sun_at(const struct sea_surface *surface, double index,
                     const struct kernel *kernel, const struct sea_sky *sky,
                     const struct sea_hit *hit, const double *direction,
                     struct sea_random *random)
{
    double v[3] = { -direction[0], -direction[1], -direction[2] };
    double s[3], n[3], wanted[2];
    to_sun(sky, random, s);
    if (!mirror_normal(v, s, n, wanted)) {
        return 0;
    }
    double density = kernel_at(kernel, -hit->normal[0] / hit->normal[2],
                               -hit->normal[1] / hit->normal[2], wanted);
    if (density == 0) {
        return 0;
    }
    struct sea_hit other;
    if (sea_dot(s, hit->normal) <= 0 ||
        sea_trace(surface, hit->point, s, &other) != SEA_ESCAPED) {
        return 0;
    }
    double cosine = sea_dot(v, n);
    return sky->irradiance * sea_fresnel(cosine, index) * density /
           (4 * cosine * n[2] * n[2] * n[2]);
}

static void follow(const struct sea_surface *surface, double index,
                   const struct kernel *kernel, const struct sea_row *row,
                   const struct sea_sky *skies, int suns,
                   struct sea_random *random, struct sea_row_light *sum)
{
    double v[3], direction[3];
    to_eye(row, random, v);
    /* Over a square of 20 km, from above all crests. */
    double from[3] = { 2e4 * sea_random_unit(random),
                       2e4 * sea_random_unit(random), surface->finer[0] + 1 };
    for (int i = 0; i < 3; i++) {
        direction[i] = -v[i];
    }
    double weight = 1;
    struct sea_hit hit;
    for (int order = 0;; order++) {
        enum sea_end end = sea_trace(surface, from, direction, &hit);
        if (end == SEA_LOST) {
            sum->lost += 1;
            return;
        }
        if (end == SEA_ESCAPED) {
            sum->white += weight;
            sum->closed += weight;
            sum->once += order == 1 ? weight : 0;
            for (int i = 0; i < suns; i++) {
                double radiance[SEA_CHANNELS];
                sea_sky_look(&skies[i], direction, radiance);
                sum->sky_once[i] += order == 1 ? weight * radiance[1] : 0;
                for (int c = 0; c < SEA_CHANNELS; c++) {
                    sum->sky[i][c] += weight * radiance[c];
                }
            }
            return;
        }
        if (order == SEA_ORDERS) {
            return;
        }
        double cosine = fmax(-sea_dot(direction, hit.normal), 0);
        for (int i = 0; i < suns; i++) {
            double *to = order == 0 ? sum->sun_rays : sum->sun_more;
            to[i] += weight * sun_at(surface, index, kernel, &skies[i], &hit,
                                     direction, random);
        }
        double reflected = sea_fresnel(cosine, index);
        if (order == 0) {
            sum->fresnel += reflected;
            sum->area += v[2] * hit.normal[2] / fmax(cosine, 1e-6);
        } else if (order == 1) {
            sum->blocked += 1;
        }
        sum->closed += weight * (1 - reflected);
        weight *= reflected;
        double next[3];
        sea_reflect(direction, hit.normal, next);
        memcpy(direction, next, sizeof(direction));
        memcpy(from, hit.point, sizeof(from));
    }
}

void sea_row_rays(const struct sea_surface *surface, double index,
                  const struct sea_row *row, const struct sea_sky *skies,
                  int suns, int rays, struct sea_random *random,
                  struct sea_row_light *light)
{
    struct sea_row_light sum = { 0 };
    struct kernel kernel = make_kernel(surface, 0.3);
    for (int i = 0; i < rays; i++) {
        follow(surface, index, &kernel, row, skies, suns, random, &sum);
    }
    double *value = (double *)&sum;
    for (size_t i = 0; i < sizeof(sum) / sizeof(double); i++) {
        value[i] /= rays;
    }
    memcpy(sum.sun, light->sun, sizeof(sum.sun));
    *light = sum;
}

/* --- the Sun, from its own facets ------------------------------------------
 */

void sea_facets(const struct sea_surface *surface, struct sea_random *random,
                struct sea_facet *facets, int count)
{
    for (int i = 0; i < count; i++) {
        float x = (float)(2e3 * sea_random_unit(random));
        float y = (float)(2e3 * sea_random_unit(random));
        double slope[2];
        sea_surface_height(surface, x, y, slope);
        facets[i] =
            (struct sea_facet){ x, y, (float)slope[0], (float)slope[1] };
    }
}

/* Radiance is E F p / (4 cos(eye) n_z^4), p the density of the slopes of
 * places, per horizontal area, that both eye and Sun see: from
 * L = sum of p dslope (v.n / n_z) / v_z F L_sun and
 * dslope = domega / (4 (v.n) n_z^3). */
static double sun_of_row(const struct sea_surface *surface, double index,
                         const struct sea_row *row, const struct sea_sky *sky,
                         const struct sea_facet *facets, int count,
                         struct sea_random *random)
{
    enum { BATCH = 2048 };
    struct kernel kernel = make_kernel(surface, 0.15);
    double reach = sqrt(kernel.radius2), sum = 0;
    for (int start = 0; start < count; start += BATCH) {
        double v[3], s[3], n[3], wanted[2];
        to_eye(row, random, v);
        to_sun(sky, random, s);
        if (!mirror_normal(v, s, n, wanted)) {
            continue;
        }
        double cosine = sea_dot(v, n);
        double factor = sky->irradiance * sea_fresnel(cosine, index) /
                        (4 * v[2] * pow(n[2], 4));
        for (int i = start; i < start + BATCH && i < count; i++) {
            const struct sea_facet *f = &facets[i];
            if (fabs(f->slope_x - wanted[0]) > reach ||
                fabs(f->slope_y - wanted[1]) > reach) {
                continue;
            }
            double density = kernel_at(&kernel, f->slope_x, f->slope_y, wanted);
            double facet[3] = { -f->slope_x, -f->slope_y, 1 };
            if (density > 0 && sea_dot(facet, v) > 0 && sea_dot(facet, s) > 0 &&
                sea_sees(surface, f->x, f->y, v) &&
                sea_sees(surface, f->x, f->y, s)) {
                sum += factor * density;
            }
        }
    }
    return sum / count;
}

void sea_row_sun(const struct sea_surface *surface, double index,
                 const struct sea_row *row, const struct sea_sky *skies,
                 int suns, const struct sea_facet *facets, int count,
                 struct sea_random *random, struct sea_row_light *light)
{
    for (int i = 0; i < suns; i++) {
        light->sun[i] =
            sun_of_row(surface, index, row, &skies[i], facets, count, random);
    }
}
