#include "waterrays.h"

#include <math.h>
#include <stdlib.h>

#include "photons.h"

#define PI PHOTON_PI
#define INDEX PHOTON_INDEX
#define CAP (PI / 180.0)
#define ABOUT 0.35 /* share of directions drawn about a Sun */

struct scene {
    double extinction, scattering; /* 1/m, without the narrow peak */
    struct photon_phase phase;
    struct photon_vector sun[RAY_SUNS]; /* towards it, in the water */
    double lit[RAY_SUNS]; /* irradiance normal to it, in the water */
    int suns;
    uint64_t random;
    struct scene *excited_by; /* where the path may go on; NULL: nowhere */
    double excitation;        /* 1/m */
};

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

double water_ray_particles(double index, double size_slope, double angle)
{
    /* Within the degree, what is left after the peak: as at its edge; the
     * share beyond is then a little less, and all is divided by the sum. */
    return particles(index, size_slope, fmax(angle, CAP));
}

static double mixed(double angle, const void *of)
{
    const struct ray_water *w = of;
    double q = w->molecular_anisotropy, c = cos(angle);
    return (w->molecular * (1.0 + q * c * c) / (4.0 * PI * (1.0 + q / 3.0)) +
            w->particles *
                water_ray_particles(w->index, w->size_slope, angle)) /
           (w->molecular + w->particles);
}

static void tabulate(const struct ray_water *w, struct scene *s)
{
    s->scattering =
        (w->molecular + w->particles) * photon_tabulate(&s->phase, mixed, w);
    s->extinction = w->absorption + s->scattering;
}

static void follow(struct scene *s, double depth, struct photon_vector to,
                   double weight, double *found);

/* A Raman scattering at a depth: what each Sun gives there, and what comes by
 * a path in the other water, into any direction alike. */
static void excite(const struct scene *s, double depth, struct photon_vector to,
                   double weight, double *found)
{
    struct scene *other = s->excited_by;
    const double mean = 1.0 + 0.55 / 3.0;
    for (int i = 0; i < other->suns; i++) {
        double c = photon_dot(to, other->sun[i]);
        found[i] += weight * other->lit[i] * (1.0 + 0.55 * c * c) /
                    (4.0 * PI * mean) *
                    exp(-other->extinction * depth / other->sun[i].z);
    }
    double up = 2.0 * photon_draw(&other->random) - 1.0,
           around = 2.0 * PI * photon_draw(&other->random);
    double flat = sqrt(1.0 - up * up);
    struct photon_vector next = { flat * cos(around), flat * sin(around), up };
    double c = photon_dot(to, next);
    double more[RAY_SUNS] = { 0 };
    follow(other, depth, next, (1.0 + 0.55 * c * c) / mean, more);
    for (int i = 0; i < other->suns; i++) {
        found[i] += weight * more[i];
    }
}

/* One path: z is up, depth positive; adds what each Sun gives. */
static void follow(struct scene *s, double depth, struct photon_vector to,
                   double weight, double *found)
{
    for (;;) {
        depth += log(photon_draw(&s->random)) / s->extinction * to.z;
        if (depth < 0.0) { /* beyond the surface: mirrored */
            double sine = sqrt(fmax(1.0 - to.z * to.z, 0.0));
            weight *= photon_mirrored(sine, to.z);
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
            found[i] += weight * s->lit[i] *
                        photon_turn(&s->phase, photon_dot(to, s->sun[i])) *
                        exp(-s->extinction * depth / s->sun[i].z);
        }
        if (weight < 0.1) {
            if (photon_draw(&s->random) > 0.3) {
                return;
            }
            weight /= 0.3;
        }
        struct photon_vector about = to;
        if (photon_draw(&s->random) < ABOUT) {
            about = s->sun[(int)(photon_draw(&s->random) * s->suns) % s->suns];
        }
        struct photon_vector next = photon_turned(
            &s->random, about, photon_draw_cosine(&s->phase, &s->random));
        double by_suns = 0.0;
        for (int i = 0; i < s->suns; i++) {
            by_suns += photon_density(&s->phase, photon_dot(next, s->sun[i]));
        }
        double c = photon_dot(to, next);
        weight *= photon_turn(&s->phase, c) /
                  ((1.0 - ABOUT) * photon_density(&s->phase, c) +
                   ABOUT * by_suns / s->suns);
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
        s->sun[i] = (struct photon_vector){ sine * cos(suns[i].azimuth),
                                            sine * sin(suns[i].azimuth), up };
        s->lit[i] =
            (1.0 - photon_mirrored(sine, up)) * cos(suns[i].zenith) / up;
    }
    return s;
}

static void look(struct scene *s, double view, uint64_t paths, double *mean,
                 double *error)
{
    double sum[RAY_SUNS] = { 0 }, square[RAY_SUNS] = { 0 };
    int count = s->suns;
    double sine = sin(view) / INDEX, down = sqrt(1.0 - sine * sine);
    double out = (1.0 - photon_mirrored(sine, down)) / (INDEX * INDEX);
    for (uint64_t k = 0; k < paths; k++) {
        double found[RAY_SUNS] = { 0 };
        follow(s, 0.0, (struct photon_vector){ sine, 0.0, -down }, 1.0, found);
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
