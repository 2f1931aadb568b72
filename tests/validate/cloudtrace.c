/* A reference for clouds: photons through a level slab over the sea, counted
 * one by one. Shares nothing with the program.
 *
 * The slab scatters and does not absorb, by Henyey and Greenstein's phase
 * function (1941); space above it is black, the sea below reflects 6 % as
 * Lambert's surface does, and between cloud and sea nothing happens. Radiance
 * is that of a light whose beam brings irradiance 1 to a level plane, by local
 * estimates: from every scattering the part that leaves unscattered at each
 * zenith angle, at an azimuth drawn anew. Errors are those of BATCHES means.
 *
 *   cloudtrace                  the table, to standard output
 *   cloudtrace --photons 100000 of each row (20000)
 *   cloudtrace --check          against what is known in closed form
 *   cloudtrace --cases          lines "depth, degrees above" of standard input,
 *                               degrees 0: a sky of one radiance; a line each
 *                               of what comes through, direct and not, its
 *                               error, and the radiance below by zenith angle
 *
 * --check: energy; single scattering in a thin slab; light through a thick
 * slab of isotropic scattering, whose darkening is Chandrasekhar's H
 * (Radiative Transfer, 1950, table XI); its reflection by a black surface,
 * which Hopf's constant gives. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define BATCHES 10
#define ANGLES 9
/* Towards the light, across, away from it: 60 degrees of azimuth each. */
#define SECTORS 3

static const double zenith_deg[ANGLES] = { 0, 15, 30, 45, 60, 70, 80, 85, 88 };

struct slab {
    double depth; /* optical, vertical */
    double g;
    double light_mu; /* 0: a sky of one radiance */
    double albedo;   /* of the sea */
};

/* Per batch, of irradiance 1 on a level plane. */
struct tally {
    double above[ANGLES][SECTORS]; /* upwards, seen from above */
    double below[ANGLES][SECTORS]; /* downwards, seen from the sea */
    double direct;                 /* downwards at the sea, never scattered */
    double diffuse;                /* downwards at the sea, all other */
    double back;                   /* upwards into space */
};

struct photon {
    double x, y, z; /* direction; z up */
    double depth;   /* of the place, from the top */
    double weight;
    bool scattered;
};

static uint64_t state[2] = { 0x9E3779B97F4A7C15u, 0xD1B54A32D192ED03u };

/* xoroshiro128+ (Blackman and Vigna 2018); in [0, 1). */
static double uniform(void)
{
    uint64_t a = state[0], b = state[1], sum = a + b;
    b ^= a;
    state[0] = (a << 24 | a >> 40) ^ b ^ (b << 16);
    state[1] = b << 37 | b >> 27;
    return (double)(sum >> 11) * 0x1p-53;
}

static double phase(double g, double c)
{
    double d = 1 + g * g - 2 * g * c;
    return (1 - g * g) / (4 * PI * d * sqrt(d));
}

static double drawn_cosine(double g)
{
    double u = uniform();
    if (fabs(g) < 1e-6) {
        return 2 * u - 1;
    }
    double s = (1 - g * g) / (1 - g + 2 * g * u);
    double c = (1 + g * g - s * s) / (2 * g);
    return fmax(-1, fmin(1, c));
}

static void turn(struct photon *p, double c)
{
    double s = sqrt(fmax(0, 1 - c * c)), a = 2 * PI * uniform();
    double u = s * cos(a), v = s * sin(a);
    double x = p->x, y = p->y, z = p->z, r = sqrt(x * x + y * y);
    if (r < 1e-9) {
        p->x = u;
        p->y = v;
        p->z = z > 0 ? c : -c;
        return;
    }
    p->x = c * x + (u * x * z - v * y) / r;
    p->y = c * y + (u * y * z + v * x) / r;
    p->z = c * z - u * r;
    double n = 1 / sqrt(p->x * p->x + p->y * p->y + p->z * p->z);
    p->x *= n;
    p->y *= n;
    p->z *= n;
}

/* What one scattering gives to each angle. The eye looks against the light's
 * way: light that goes to azimuth a is seen at a + PI, and the light itself
 * stands there at azimuth 0. */
static void estimate(const struct slab *slab, const struct photon *p,
                     struct tally *t)
{
    double seen = 2 * PI * uniform();
    double folded = seen > PI ? 2 * PI - seen : seen;
    int sector = (int)fmin(SECTORS - 1, folded / (PI / SECTORS));
    double ca = -cos(seen), sa = -sin(seen);
    for (int i = 0; i < ANGLES; i++) {
        double mu = cos(zenith_deg[i] * PI / 180);
        double s = sqrt(1 - mu * mu);
        double level = s * (ca * p->x + sa * p->y);
        double up = p->weight * phase(slab->g, level + mu * p->z) *
                    exp(-p->depth / mu) / mu;
        double down = p->weight * phase(slab->g, level - mu * p->z) *
                      exp(-(slab->depth - p->depth) / mu) / mu;
        t->above[i][sector] += SECTORS * up;
        t->below[i][sector] += SECTORS * down;
    }
}

/* From the sea, as Lambert's surface sends it; false: it ends there. */
static bool reflected(const struct slab *slab, struct photon *p,
                      struct tally *t)
{
    *(p->scattered ? &t->diffuse : &t->direct) += p->weight;
    p->weight *= slab->albedo;
    if (p->weight < 1e-9) {
        return false;
    }
    for (int i = 0; i < ANGLES; i++) {
        double mu = cos(zenith_deg[i] * PI / 180);
        double up = p->weight * exp(-slab->depth / mu) / PI;
        for (int k = 0; k < SECTORS; k++) {
            t->above[i][k] += up;
        }
    }
    double mu = sqrt(uniform()), a = 2 * PI * uniform();
    p->x = sqrt(1 - mu * mu) * cos(a);
    p->y = sqrt(1 - mu * mu) * sin(a);
    p->z = mu;
    p->depth = slab->depth;
    p->scattered = true;
    return true;
}

static void trace(const struct slab *slab, struct tally *t)
{
    double mu = slab->light_mu > 0 ? slab->light_mu : sqrt(1 - uniform());
    struct photon p = { .x = -sqrt(1 - mu * mu), .z = -mu, .weight = 1 };
    for (;;) {
        p.depth -= p.z * -log(1 - uniform());
        if (p.depth < 0) {
            t->back += p.weight;
            return;
        }
        if (p.depth > slab->depth) {
            if (!reflected(slab, &p, t)) {
                return;
            }
            continue;
        }
        estimate(slab, &p, t);
        p.scattered = true;
        turn(&p, drawn_cosine(slab->g));
    }
}

/* Batches of means; tallies are all doubles, one after another. */
#define NUMBERS (sizeof(struct tally) / sizeof(double))

static void run(const struct slab *slab, unsigned photons, struct tally *mean,
                struct tally *error)
{
    double sum[NUMBERS] = { 0 }, squares[NUMBERS] = { 0 };
    for (int b = 0; b < BATCHES; b++) {
        struct tally t = { 0 };
        for (unsigned i = 0; i < photons / BATCHES; i++) {
            trace(slab, &t);
        }
        double v[NUMBERS];
        memcpy(v, &t, sizeof v);
        for (size_t i = 0; i < NUMBERS; i++) {
            v[i] /= photons / BATCHES;
            sum[i] += v[i];
            squares[i] += v[i] * v[i];
        }
    }
    double m[NUMBERS], e[NUMBERS];
    for (size_t i = 0; i < NUMBERS; i++) {
        m[i] = sum[i] / BATCHES;
        double var = squares[i] / BATCHES - m[i] * m[i];
        e[i] = sqrt(fmax(0, var) / (BATCHES - 1));
    }
    memcpy(mean, m, sizeof m);
    memcpy(error, e, sizeof e);
}

static double over_azimuth(const double v[SECTORS])
{
    return (v[0] + v[1] + v[2]) / SECTORS;
}

static void print_side(const char *name, const double mean[ANGLES][SECTORS],
                       const double error[ANGLES][SECTORS])
{
    for (int i = 0; i < ANGLES; i++) {
        double m = over_azimuth(mean[i]);
        double e = sqrt(error[i][0] * error[i][0] + error[i][1] * error[i][1] +
                        error[i][2] * error[i][2]) /
                   SECTORS;
        printf("  %s %2.0f  %8.5f +- %4.1f %%  %8.5f %8.5f %8.5f\n", name,
               zenith_deg[i], m, 100 * e / m, mean[i][0], mean[i][1],
               mean[i][2]);
    }
}

static void table(unsigned photons)
{
    static const double depths[] = { 2, 5, 10, 20, 40 };
    static const double suns[] = { 10, 20, 30, 45, 60 };
    puts(
        "Radiance of a slab of cloud, g 0.85, over a sea of albedo 0.06, of a\n"
        "beam that brings irradiance 1 to a level plane. By zenith angle: "
        "mean\n"
        "over azimuth, its error, mean within 60 degrees of the light's\n"
        "azimuth, across, away from it.");
    for (size_t d = 0; d < sizeof depths / sizeof *depths; d++) {
        for (size_t s = 0; s < sizeof suns / sizeof *suns; s++) {
            struct slab slab = { depths[d], 0.85, sin(suns[s] * PI / 180),
                                 0.06 };
            struct tally m, e;
            run(&slab, photons, &m, &e);
            printf("\ndepth %g, light %g degrees above: to the sea direct "
                   "%.5f, diffuse %.5f +- %.5f; to space %.5f +- %.5f; "
                   "balance %.5f\n",
                   slab.depth, suns[s], m.direct, m.diffuse, e.diffuse, m.back,
                   e.back, m.back + (1 - slab.albedo) * (m.direct + m.diffuse));
            print_side("below", m.below, e.below);
            print_side("above", m.above, e.above);
            double horizon = over_azimuth(m.below[ANGLES - 2]);
            printf("  zenith over 5 degrees above the horizon: %.2f\n",
                   over_azimuth(m.below[0]) / horizon);
            fflush(stdout);
        }
    }
}

static void cases(unsigned photons)
{
    double depth, degrees;
    while (scanf("%lf %lf", &depth, &degrees) == 2) {
        struct slab slab = { depth, 0.85, sin(degrees * PI / 180), 0.06 };
        struct tally m, e;
        run(&slab, photons, &m, &e);
        printf("%.6f %.6f %.6f", m.direct, m.diffuse, e.diffuse);
        for (int i = 0; i < ANGLES; i++) {
            printf(" %.6f", over_azimuth(m.below[i]));
        }
        putchar('\n');
    }
}

static int failed;

static void expect(const char *what, double seen, double known, double within)
{
    bool good = fabs(seen - known) <= within;
    printf("%-52s %9.5f, known %9.5f +- %.5f%s\n", what, seen, known, within,
           good ? "" : "  FAIL");
    failed += !good;
}

/* Three standard errors, and what rounding leaves. */
static double margin(double error)
{
    return 3 * error + 1e-6;
}

static void check(unsigned photons)
{
    struct tally m, e;
    struct slab grey = { 10, 0.85, 0.5, 0.06 };
    run(&grey, photons, &m, &e);
    expect("energy: to space and into the sea",
           m.back + 0.94 * (m.direct + m.diffuse), 1,
           1e-6 /* weights end at 1e-9 */);

    struct slab thin = { 0.002, 0.85, 0.5, 0 };
    run(&thin, photons * 300, &m, &e);
    for (int i = 2; i < 5; i++) { /* 30 to 60 degrees: mean over azimuth */
        double mu = cos(zenith_deg[i] * PI / 180), known = 0;
        for (int a = 0; a < 3600; a++) {
            double s = sqrt(1 - mu * mu) * sqrt(0.75);
            double c = s * cos(a * 2 * PI / 3600) + mu * 0.5;
            known += phase(0.85, c) / 3600;
        }
        known *= thin.depth / (mu * thin.light_mu);
        double err =
            sqrt(e.below[i][0] * e.below[i][0] + e.below[i][1] * e.below[i][1] +
                 e.below[i][2] * e.below[i][2]) /
            SECTORS;
        /* Extinction on the way, of 0.4 %, is not in the closed form. */
        expect("single scattering, over its closed form",
               over_azimuth(m.below[i]) / known, 1,
               margin(err / known) + 0.005);
    }

    /* Conservative and isotropic, optical depth b: light through it is
     * (Hopf) mu0 H(mu0) sqrt(3) / 4 * (4 / 3) / (b + 2 * 0.710446), that
     * leaves as H(mu) does. */
    struct slab milk = { 20, 0, 0.5, 0 };
    run(&milk, photons * 30, &m, &e);
    double through = 1.7320508 * 2.012778 / 3 / (milk.depth + 1.420892);
    expect("thick, isotropic: share that comes through", m.direct + m.diffuse,
           through, margin(e.diffuse));
    /* Table XI: H(1) = 2.9078, H(0.5) = 2.0128. */
    double top = over_azimuth(m.below[0]), low = over_azimuth(m.below[4]);
    expect("thick, isotropic: 0 over 60 degrees of zenith", top / low,
           2.9078 / 2.0128,
           3 * 1.45 * (e.below[0][0] + e.below[4][0]) / top + 0.002);
}

int main(int argc, char **argv)
{
    unsigned photons = 20000;
    bool checks = false, by_line = false;
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--check")) {
            checks = true;
        } else if (!strcmp(argv[i], "--cases")) {
            by_line = true;
        } else if (!strcmp(argv[i], "--photons") && i + 1 < argc) {
            photons = (unsigned)strtoul(argv[++i], NULL, 10);
        } else {
            fprintf(stderr,
                    "usage: cloudtrace [--check | --cases] [--photons N]\n");
            return 2;
        }
    }
    if (photons < 10 * BATCHES) {
        photons = 10 * BATCHES;
    }
    if (checks) {
        check(photons);
        return failed != 0;
    }
    if (by_line) {
        cases(photons);
    } else {
        table(photons);
    }
    return 0;
}
