#include "undersurface.h"

#include <stdio.h>
#include <stdlib.h>

#define PI UNDER_PI

/* Facets that a ray meets at most. */
enum { FACETS = 1000 };

double under_fresnel(double cosine, double index)
{
    double inside2 = 1 - (1 - cosine * cosine) / (index * index);
    if (inside2 <= 0) {
        return 1;
    }
    double inside = sqrt(inside2);
    double s = (cosine - index * inside) / (cosine + index * inside);
    double p = (index * cosine - inside) / (index * cosine + inside);
    return (s * s + p * p) / 2;
}

/* Refracted at a facet whose normal m is on the side that d comes from. */
static struct under_vec bend(struct under_vec d, struct under_vec m,
                             double index)
{
    double c = -under_dot(d, m);
    double inside = sqrt(fmax(0, 1 - (1 - c * c) / (index * index)));
    double by = c / index - inside;
    return (struct under_vec){ d.x / index + by * m.x, d.y / index + by * m.y,
                               d.z / index + by * m.z };
}

struct under_vec under_refracted(const struct under_surface *surface,
                                 enum under_side from, struct under_vec d,
                                 double *reflectance)
{
    double index = from == UNDER_AIR ? surface->index : 1 / surface->index;
    *reflectance = under_fresnel(fabs(d.z), index);
    if (*reflectance >= 1) {
        return (struct under_vec){ 0 };
    }
    return bend(d, (struct under_vec){ 0, 0, from == UNDER_AIR ? 1 : -1 },
                index);
}

/* --- facets --------------------------------------------------------------- */

/* Covariance of slopes along the azimuth of a direction and across it. */
struct spread {
    double ex, ey; /* that azimuth */
    double along, both, across;
};

static struct spread spread_at(const struct under_surface *s,
                               struct under_vec d)
{
    double level = hypot(d.x, d.y);
    struct spread w = { .ex = 1 };
    if (level > 0) {
        w.ex = d.x / level;
        w.ey = d.y / level;
    }
    double ax = cos(s->toward), ay = sin(s->toward);
    double c = w.ex * ax + w.ey * ay, n = w.ex * ay - w.ey * ax;
    w.along = s->along * c * c + s->across * n * n;
    w.across = s->along * n * n + s->across * c * c;
    w.both = (s->across - s->along) * -n * c;
    return w;
}

static double normal(double x)
{
    return exp(-x * x / 2) / sqrt(2 * PI);
}

static double normal_below(double x)
{
    return erfc(-x / sqrt(2)) / 2;
}

/* Smith's Lambda of a direction that rises from the surface by the cotangent of
 * its zenith angle over the slopes' deviation; below the horizon -1 - Lambda of
 * the opposite. */
static double lambda(double x)
{
    return normal(x) / x - normal_below(-x);
}

static double lambda_of(const struct under_surface *s, struct under_vec d)
{
    double level = hypot(d.x, d.y);
    if (level < 1e-9) {
        return d.z > 0 ? 0 : -1;
    }
    return lambda(d.z / level / sqrt(spread_at(s, d).along));
}

/* The slope x along a view, in deviations, of facets seen from the cotangent v
 * (in deviations): density (v - x) normal(x) for x < v. */
static double seen_slope(double v, double number)
{
    double low = -9, high = fmin(v, 9);
    if (high <= low) {
        return high;
    }
    double all = v * normal_below(high) + normal(high), x = fmin(high, 0);
    double wanted = number * all;
    for (int i = 0; i < 60 && high - low > 1e-12; i++) {
        double off = v * normal_below(x) + normal(x) - wanted;
        if (fabs(off) < 1e-13 * all) {
            break;
        }
        if (off > 0) {
            high = x;
        } else {
            low = x;
        }
        double rate = (v - x) * normal(x);
        double next = x - off / rate;
        x = next > low && next < high ? next : (low + high) / 2;
    }
    return x;
}

/* The normal, upwards, of a facet that the ray d (from above) meets. */
static struct under_vec facet(const struct under_surface *s,
                              struct sea_random *random, struct under_vec d)
{
    struct under_vec back = { -d.x, -d.y, -d.z };
    struct spread w = spread_at(s, back);
    double level = hypot(d.x, d.y), deviation = sqrt(w.along), a, b;
    double v = level > 1e-9 ? back.z / level / deviation : 1e9;
    sea_random_normal(random, &a, &b);
    /* A slope that rises along the view's azimuth turns away from the eye. */
    double x = deviation * seen_slope(v, sea_random_unit(random));
    double y = w.both / w.along * x +
               b * sqrt(fmax(0, w.across - w.both * w.both / w.along));
    double sx = w.ex * x - w.ey * y, sy = w.ey * x + w.ex * y;
    double r = 1 / sqrt(1 + sx * sx + sy * sy);
    return (struct under_vec){ -sx * r, -sy * r, r };
}

enum under_side under_cross(const struct under_surface *surface,
                            struct sea_random *random, enum under_side from,
                            struct under_vec *d)
{
    /* Always as if from above: from below, all is turned over. `lower` is the
     * share of the surface that lies lower than the ray. */
    enum under_side side = from;
    struct under_vec r = *d;
    double lower = 1;
    if (side == UNDER_WATER) {
        r.z = -r.z;
    }
    for (int i = 0; i < FACETS; i++) {
        double up = lambda_of(surface, r);
        double number = 1 - sea_random_unit(random); /* above 0 */
        if (up > 0 && number <= pow(lower, up)) {
            break;
        }
        if (r.z > 0 && up <= 0) {
            break;
        }
        lower = fmin(lower * pow(number, -1 / up), 1);
        struct under_vec m = facet(surface, random, r);
        double c = -under_dot(r, m);
        if (c <= 0) {
            continue;
        }
        double index = side == UNDER_AIR ? surface->index : 1 / surface->index;
        if (sea_random_unit(random) < under_fresnel(c, index)) {
            r = (struct under_vec){ r.x + 2 * c * m.x, r.y + 2 * c * m.y,
                                    r.z + 2 * c * m.z };
        } else {
            r = bend(r, m, index);
            r.z = -r.z;
            lower = 1 - lower;
            side = side == UNDER_AIR ? UNDER_WATER : UNDER_AIR;
        }
    }
    if (side == UNDER_WATER) {
        r.z = -r.z;
    }
    *d = r;
    return side;
}

double under_glitter(const struct under_surface *surface, struct under_vec sun,
                     struct under_vec toward)
{
    double n = surface->index;
    /* Light runs along -toward; snell: n (-toward) - (-sun) is along -m. */
    struct under_vec h = { n * toward.x - sun.x, n * toward.y - sun.y,
                           n * toward.z - sun.z };
    double length = sqrt(under_dot(h, h));
    struct under_vec m = { h.x / length, h.y / length, h.z / length };
    double into = under_dot(m, sun), out = under_dot(m, toward);
    if (m.z <= 0 || into <= 0 || out <= 0) {
        return 0;
    }
    double ax = cos(surface->toward), ay = sin(surface->toward);
    double along = -(m.x * ax + m.y * ay) / m.z;
    double across = -(m.y * ax - m.x * ay) / m.z;
    double density = exp(-along * along / (2 * surface->along) -
                         across * across / (2 * surface->across)) /
                     (2 * PI * sqrt(surface->along * surface->across));
    /* One height is seen from both sides: Euler's integral of the first kind.
     */
    double a = 1 + lambda_of(surface, sun), b = 1 + lambda_of(surface, toward);
    double seen = exp(lgamma(a) + lgamma(b) - lgamma(a + b));
    /* n out - into is the length of h. */
    return (1 - under_fresnel(into, n)) * into * density * seen * n * n * out /
           (pow(m.z, 4) * toward.z * length * length);
}

/* --- the sky -------------------------------------------------------------- */

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts, and leaves each once. */
static int once(double *value, int count)
{
    int n = 0;
    qsort(value, (size_t)count, sizeof(*value), ascending);
    for (int i = 0; i < count; i++) {
        if (n == 0 || value[i] > value[n - 1] + 1e-9) {
            value[n++] = value[i];
        }
    }
    return n;
}

static int place(const double *value, int count, double x)
{
    int low = 0, high = count - 1;
    while (low + 1 < high) {
        int middle = (low + high) / 2;
        if (value[middle] <= x) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

static int fill(struct under_sky *sky, const double (*row)[3], int rows)
{
    for (int i = 0; i < rows; i++) {
        sky->zenith[i] = row[i][0];
        sky->azimuth[i] = row[i][1];
    }
    sky->zeniths = once(sky->zenith, rows);
    sky->azimuths = once(sky->azimuth, rows);
    if (sky->zeniths < 2 || sky->zeniths * sky->azimuths != rows) {
        return -1;
    }
    for (int i = 0; i < rows; i++) {
        sky->radiance[i] = -1;
    }
    for (int i = 0; i < rows; i++) {
        int z = place(sky->zenith, sky->zeniths, row[i][0] + 1e-9);
        int a = place(sky->azimuth, sky->azimuths, row[i][1] + 1e-9);
        z += row[i][0] > sky->zenith[z] + 1e-9;
        a += row[i][1] > sky->azimuth[a] + 1e-9;
        double *r = &sky->radiance[z * sky->azimuths + a];
        if (*r >= 0 || !(row[i][2] >= 0)) {
            return -1;
        }
        *r = row[i][2];
    }
    return 0;
}

int under_sky_read(struct under_sky *sky, const char *path, const char **why)
{
    enum { MOST = 1 << 18 };
    static double row[MOST][3];
    char line[256];
    int rows = 0;
    FILE *f = fopen(path, "r");
    *sky = (struct under_sky){ 0 };
    if (!f) {
        *why = "cannot be opened";
        return -1;
    }
    while (rows < MOST && fgets(line, sizeof(line), f)) {
        if (sscanf(line, "%lf,%lf,%lf", &row[rows][0], &row[rows][1],
                   &row[rows][2]) == 3) {
            row[rows][0] *= PI / 180;
            row[rows][1] *= PI / 180;
            rows++;
        }
    }
    fclose(f);
    size_t size = (size_t)rows * sizeof(double);
    sky->zenith = malloc(size + 1);
    sky->azimuth = malloc(size + 1);
    sky->radiance = malloc(size + 1);
    if (!sky->zenith || !sky->azimuth || !sky->radiance) {
        *why = "takes too much memory";
    } else if (fill(sky, row, rows)) {
        *why = "is no grid of zenith,azimuth,radiance";
    } else {
        return 0;
    }
    under_sky_free(sky);
    return -1;
}

void under_sky_free(struct under_sky *sky)
{
    free(sky->zenith);
    free(sky->azimuth);
    free(sky->radiance);
    *sky = (struct under_sky){ 0 };
}

static double between(const double *value, int i, double x)
{
    double f = (x - value[i]) / (value[i + 1] - value[i]);
    return f < 0 ? 0 : f > 1 ? 1 : f;
}

double under_sky_at(const struct under_sky *sky, struct under_vec toward)
{
    if (!sky->zeniths) {
        return sky->uniform;
    }
    double zenith = acos(fmin(fmax(toward.z, -1), 1));
    double azimuth = atan2(toward.y, toward.x);
    if (sky->azimuth[sky->azimuths - 1] < PI + 1e-9) {
        azimuth = fabs(azimuth);
    } else if (azimuth < 0) {
        azimuth += 2 * PI;
    }
    int i = place(sky->zenith, sky->zeniths, zenith);
    const double *low = &sky->radiance[i * sky->azimuths];
    const double *high = low + sky->azimuths;
    double f = between(sky->zenith, i, zenith);
    if (sky->azimuths < 2) {
        return *low + f * (*high - *low);
    }
    int k = place(sky->azimuth, sky->azimuths, azimuth);
    double g = between(sky->azimuth, k, azimuth);
    double a = low[k] + g * (low[k + 1] - low[k]);
    double b = high[k] + g * (high[k + 1] - high[k]);
    return a + f * (b - a);
}
