#include "waterrays.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846
#define INDEX 1.34 /* of the surface */
#define CELLS 8192 /* over sin of half the angle */
#define CAP (PI / 180.0)
#define ABOUT 0.35 /* share of directions drawn about a Sun */

struct vector {
    double x, y, z;
};

struct scene {
    double extinction, scattering; /* 1/m, without the narrow peak */
    double value[CELLS + 1];       /* 1/sr */
    double below[CELLS + 1];
    struct vector sun[RAY_SUNS]; /* towards it, in the water */
    double lit[RAY_SUNS];        /* irradiance normal to it, in the water */
    int suns;
    uint64_t random;
    struct scene *excited_by; /* where the path may go on; NULL: nowhere */
    double excitation;        /* 1/m */
};

/* PCG (O'Neill 2014), 0..1. */
static double draw(struct scene *s)
{
    uint64_t old = s->random;
    s->random = old * 6364136223846793005u + 1442695040888963407u;
    uint32_t x = (uint32_t)(((old >> 18) ^ old) >> 27);
    unsigned turn = (unsigned)(old >> 59);
    x = (x >> turn) | (x << ((32 - turn) & 31));
    return ((double)x + 0.5) / 4294967296.0;
}

static double particles(double n, double mu, double angle)
{
    double v = 0.5 * (3.0 - mu), half = sin(0.5 * angle), s2 = half * half;
    double to_delta = 4.0 / (3.0 * (n - 1.0) * (n - 1.0));
    double d = to_delta * s2, d180 = to_delta;
    if (fabs(d - 1.0) < 1e-4) {
        d = 1.0 + 1e-4;
    }
    double dv = pow(d, v), one = 1.0 - d;
    double first = (v * one - (1.0 - dv) + (d * (1.0 - dv) - v * one) / s2) /
                   (4.0 * PI * one * one * dv);
    double d180v = pow(d180, v), c = cos(angle);
    return first + (1.0 - d180v) / (16.0 * PI * (d180 - 1.0) * d180v) *
                       (3.0 * c * c - 1.0);
}

/* Share turned by more than `from`: Simpson's rule in ln θ. */
static double beyond(double n, double mu, double from)
{
    enum { STEPS = 4000 };
    double low = log(from), step = (log(PI) - low) / STEPS, sum = 0.0;
    for (int i = 0; i <= STEPS; i++) {
        double angle = fmin(exp(low + i * step), PI);
        double weight = i == 0 || i == STEPS ? 1.0 : i % 2 ? 4.0 : 2.0;
        sum += weight * 2.0 * PI * sin(angle) * angle * particles(n, mu, angle);
    }
    return sum * step / 3.0;
}

double water_ray_back(double index, double size_slope)
{
    return beyond(index, size_slope, 0.5 * PI);
}

static void tabulate(const struct ray_water *w, struct scene *s)
{
    double q = w->molecular_anisotropy;
    double cap = particles(w->index, w->size_slope, CAP);
    s->scattering = w->molecular + w->particles;
    s->extinction = w->absorption + s->scattering;
    /* Within the degree, what is left after the peak: as at its edge; the
     * share beyond is then a little less, and all is divided by the sum. */
    double sum = 0.0;
    for (int i = 0; i <= CELLS; i++) {
        double half = (double)i / CELLS, angle = 2.0 * asin(half);
        double c = cos(angle);
        double p =
            angle < CAP ? cap : particles(w->index, w->size_slope, angle);
        s->value[i] =
            (w->molecular * (1.0 + q * c * c) / (4.0 * PI * (1.0 + q / 3.0)) +
             w->particles * p) /
            s->scattering;
        if (i > 0) {
            /* dΩ = 4π d(half²) */
            double before = (double)(i - 1) / CELLS;
            sum += 0.5 * (s->value[i] + s->value[i - 1]) * 4.0 * PI *
                   (half * half - before * before);
        }
        s->below[i] = sum;
    }
    s->scattering *= sum;
    s->extinction = w->absorption + s->scattering;
    for (int i = 0; i <= CELLS; i++) {
        s->value[i] /= sum;
        s->below[i] /= sum;
    }
}

static double turn(const struct scene *s, double cosine)
{
    double at = sqrt(fmax(0.5 * (1.0 - cosine), 0.0)) * CELLS;
    int i = (int)fmin(at, CELLS - 1);
    return s->value[i] + (at - i) * (s->value[i + 1] - s->value[i]);
}

/* The density by which draw_cosine draws, flat in each cell. */
static double density(const struct scene *s, double cosine)
{
    int i = (int)fmin(sqrt(fmax(0.5 * (1.0 - cosine), 0.0)) * CELLS, CELLS - 1);
    double ring = 4.0 * PI * (2.0 * i + 1.0) / ((double)CELLS * CELLS);
    return (s->below[i + 1] - s->below[i]) / ring;
}

static double draw_cosine(struct scene *s)
{
    double u = draw(s);
    int low = 0, high = CELLS;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (s->below[middle] <= u) {
            low = middle;
        } else {
            high = middle;
        }
    }
    double part = (u - s->below[low]) / (s->below[low + 1] - s->below[low]);
    double square = (low * (double)low + part * (2.0 * low + 1.0)) /
                    ((double)CELLS * CELLS);
    return 1.0 - 2.0 * square;
}

static double dot(struct vector a, struct vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* A direction at this cosine from another. */
static struct vector turned(struct scene *s, struct vector from, double cosine)
{
    double sine = sqrt(fmax(1.0 - cosine * cosine, 0.0));
    double around = 2.0 * PI * draw(s), c = cos(around), t = sin(around);
    double flat = sqrt(from.x * from.x + from.y * from.y);
    if (flat < 1e-9) {
        return (struct vector){ sine * c, sine * t,
                                from.z > 0 ? cosine : -cosine };
    }
    return (struct vector){
        cosine * from.x + sine * (from.x * from.z * c - from.y * t) / flat,
        cosine * from.y + sine * (from.y * from.z * c + from.x * t) / flat,
        cosine * from.z - sine * flat * c,
    };
}

/* Unpolarised, by the angles on both sides. */
static double mirrored(double sine_water, double cos_water)
{
    double sine_air = INDEX * sine_water;
    if (sine_air >= 1.0) {
        return 1.0;
    }
    double cos_air = sqrt(1.0 - sine_air * sine_air);
    double s = (cos_air - INDEX * cos_water) / (cos_air + INDEX * cos_water);
    double p = (INDEX * cos_air - cos_water) / (INDEX * cos_air + cos_water);
    return 0.5 * (s * s + p * p);
}

static void follow(struct scene *s, double depth, struct vector to,
                   double weight, double *found);

/* A Raman scattering at a depth: what each Sun gives there, and what comes by
 * a path in the other water, into any direction alike. */
static void excite(const struct scene *s, double depth, struct vector to,
                   double weight, double *found)
{
    struct scene *other = s->excited_by;
    const double mean = 1.0 + 0.55 / 3.0;
    for (int i = 0; i < other->suns; i++) {
        double c = dot(to, other->sun[i]);
        found[i] += weight * other->lit[i] * (1.0 + 0.55 * c * c) /
                    (4.0 * PI * mean) *
                    exp(-other->extinction * depth / other->sun[i].z);
    }
    double up = 2.0 * draw(other) - 1.0, around = 2.0 * PI * draw(other);
    double flat = sqrt(1.0 - up * up);
    struct vector next = { flat * cos(around), flat * sin(around), up };
    double c = dot(to, next);
    double more[RAY_SUNS] = { 0 };
    follow(other, depth, next, (1.0 + 0.55 * c * c) / mean, more);
    for (int i = 0; i < other->suns; i++) {
        found[i] += weight * more[i];
    }
}

/* One path: z is up, depth positive; adds what each Sun gives. */
static void follow(struct scene *s, double depth, struct vector to,
                   double weight, double *found)
{
    for (;;) {
        depth += log(draw(s)) / s->extinction * to.z;
        if (depth < 0.0) { /* beyond the surface: mirrored */
            double sine = sqrt(fmax(1.0 - to.z * to.z, 0.0));
            weight *= mirrored(sine, to.z);
            /* Free flight has no memory: fly on from the surface. */
            depth = 0.0;
            to.z = -to.z;
            if (weight < 1e-9) {
                return;
            }
            continue;
        }
        if (s->excited_by) {
            excite(s, depth, to, weight * s->excitation / s->extinction, found);
        }
        weight *= s->scattering / s->extinction;
        for (int i = 0; i < s->suns && !s->excited_by; i++) {
            found[i] += weight * s->lit[i] * turn(s, dot(to, s->sun[i])) *
                        exp(-s->extinction * depth / s->sun[i].z);
        }
        if (weight < 0.1) {
            if (draw(s) > 0.3) {
                return;
            }
            weight /= 0.3;
        }
        struct vector about = to;
        if (draw(s) < ABOUT) {
            about = s->sun[(int)(draw(s) * s->suns) % s->suns];
        }
        struct vector next = turned(s, about, draw_cosine(s));
        double by_suns = 0.0;
        for (int i = 0; i < s->suns; i++) {
            by_suns += density(s, dot(next, s->sun[i]));
        }
        double c = dot(to, next);
        weight *= turn(s, c) /
                  ((1.0 - ABOUT) * density(s, c) + ABOUT * by_suns / s->suns);
        to = next;
    }
}

static struct scene *make(const struct ray_water *w, const struct ray_sun *suns,
                          int count, uint64_t seed)
{
    struct scene *s = calloc(1, sizeof *s);
    if (!s) {
        abort();
    }
    tabulate(w, s);
    s->suns = count;
    s->random = seed * 0x9e3779b97f4a7c15u + 1u;
    for (int i = 0; i < count; i++) {
        double sine = sin(suns[i].zenith) / INDEX, up = sqrt(1.0 - sine * sine);
        /* An azimuth of 0 looks towards the Sun: the eye's ray goes on to it.
         */
        s->sun[i] = (struct vector){ sine * cos(suns[i].azimuth),
                                     sine * sin(suns[i].azimuth), up };
        s->lit[i] = (1.0 - mirrored(sine, up)) * cos(suns[i].zenith) / up;
    }
    return s;
}

static void look(struct scene *s, double view, uint64_t paths, double *mean,
                 double *error)
{
    double sum[RAY_SUNS] = { 0 }, square[RAY_SUNS] = { 0 };
    int count = s->suns;
    double sine = sin(view) / INDEX, down = sqrt(1.0 - sine * sine);
    double out = (1.0 - mirrored(sine, down)) / (INDEX * INDEX);
    for (uint64_t k = 0; k < paths; k++) {
        double found[RAY_SUNS] = { 0 };
        follow(s, 0.0, (struct vector){ sine, 0.0, -down }, 1.0, found);
        for (int i = 0; i < count; i++) {
            sum[i] += found[i];
            square[i] += found[i] * found[i];
        }
    }
    for (int i = 0; i < count; i++) {
        double n = (double)paths, m = sum[i] / n;
        mean[i] = out * m;
        error[i] = out * sqrt(fmax(square[i] / n - m * m, 0.0) / n);
    }
}

void water_rays(const struct ray_water *w, double view,
                const struct ray_sun *suns, int count, uint64_t paths,
                uint64_t seed, double *mean, double *error)
{
    struct scene *s = make(w, suns, count, seed);
    look(s, view, paths, mean, error);
    free(s);
}

void water_rays_raman(const struct ray_water *to, const struct ray_water *from,
                      double strength, double view, const struct ray_sun *suns,
                      int count, uint64_t paths, uint64_t seed, double *mean,
                      double *error)
{
    struct scene *s = make(to, suns, count, seed);
    s->excited_by = make(from, suns, count, seed + 1);
    s->excitation = strength;
    look(s, view, paths, mean, error);
    free(s->excited_by);
    free(s);
}
