/* The field's cover, and the light of a slab against photons that are followed
 * through it. */
#include "optics/clouds.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#define SIDE PEL_CLOUD_SIDE

static float texels[SIDE * SIDE][4];

/* Of all places exactly `cover` have clouds, by any genus and seed; the tile
 * closes at its edges. */
static void covers_what_is_asked(void **state)
{
    (void)state;
    for (int genus = 0; genus < PEL_CLOUD_GENERA; genus++) {
        pel_cloud_field((enum pel_cloud_genus)genus, 7 + (uint32_t)genus,
                        texels);
        for (int okta = 1; okta <= 8; okta++) {
            const struct pel_clouds c = { .cover = okta / 8.0,
                                          .genus =
                                              (enum pel_cloud_genus)genus };
            int count = 0;
            for (int i = 0; i < SIDE * SIDE; i++) {
                count += pel_cloud_thick(&c, (double)texels[i][0]) > 0;
            }
            assert_float_equal((double)count / (SIDE * SIDE), c.cover, 1e-5);
        }
        double step = 0, edge = 0, fine = 0;
        for (int i = 0; i < SIDE; i++) {
            const float *row = texels[i * SIDE], *end = row + 4 * (SIDE - 1);
            step += fabs((double)(row[0] - row[4])) / SIDE;
            edge += fabs((double)(row[0] - end[0])) / SIDE;
        }
        for (int i = 0; i < SIDE * SIDE; i++) {
            fine += (double)texels[i][2] / (SIDE * SIDE);
        }
        printf("genus %d: neighbours differ by %.4f, across the edge %.4f\n",
               genus, step, edge);
        assert_true(edge < 2 * step);
        assert_float_equal(fine, 0.5, 1e-4);
    }
}

/* --- photons ---------------------------------------------------------------
 */

static double number(uint64_t *s)
{
    *s += UINT64_C(0x9e3779b97f4a7c15);
    uint64_t z = *s;
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return ((double)((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
}

/* Cosine of the zenith angle after a scattering by Henyey and Greenstein. */
static double turned(double mu, double g, uint64_t *s)
{
    double q = (1 - g * g) / (1 - g + 2 * g * number(s));
    double c = (1 + g * g - q * q) / (2 * g);
    double azimuth = 2 * M_PI * number(s);
    double next =
        mu * c + sqrt(fmax(1 - mu * mu, 0) * fmax(1 - c * c, 0)) * cos(azimuth);
    return fmax(-1, fmin(1, next));
}

/* Share that comes through a slab that absorbs nothing, and in `bright` its
 * radiance at zenith over that at 75 deg. */
static double through(double depth, double mu, int photons, double *bright)
{
    uint64_t s = 11;
    double up = 0, low = 0;
    int out = 0;
    for (int i = 0; i < photons; i++) {
        double t = 0, d = mu;
        while (t >= 0 && t <= depth) {
            t += -log(number(&s)) * d;
            if (t >= 0 && t <= depth) {
                d = turned(d, 0.85, &s);
            }
        }
        if (t > depth) {
            out++;
            /* Radiance is flux over cosine and solid angle. */
            up += d > 0.9 ? 1 / (0.1 * 0.95) : 0;
            low += d > 0.2 && d < 0.32 ? 1 / (0.12 * 0.26) : 0;
        }
    }
    *bright = up / fmax(low, 1);
    return (double)out / photons;
}

static void lets_through_what_photons_do(void **state)
{
    (void)state;
    enum { PHOTONS = 20000 };
    static const double depths[] = { 5, 15, 40 },
                        cosines[] = { 0.3, 0.6, 0.95 };
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            double bright;
            double theirs = through(depths[i], cosines[k], PHOTONS, &bright);
            double ours = pel_cloud_through(0.15 * depths[i], cosines[k]);
            printf("optical depth %2.0f, Sun %2.0f deg: %.3f of %.3f (noise "
                   "%.3f), zenith %.1f times 75 deg\n",
                   depths[i], asin(cosines[k]) * 180 / M_PI, ours, theirs,
                   sqrt(theirs * (1 - theirs) / PHOTONS), bright);
            /* Eddington's two streams, worst where few scatterings meet a low
             * Sun. */
            assert_float_equal(ours, theirs, 0.035);
        }
    }
}

enum { RINGS = 5, RING_M = 600 };

/* Mean intensity in the lowest 200 m of a slab, in rings about a lamp within
 * that gives off 1 a steradian; photons in three dimensions. */
static void about_a_lamp(double extinction, double high, double from,
                         int photons, double out[RINGS])
{
    enum { LOW_M = 200 };
    uint64_t s = 23;
    for (int k = 0; k < RINGS; k++) {
        out[k] = 0;
    }
    for (int i = 0; i < photons; i++) {
        double x[3] = { 0, 0, from }, mu = 2 * number(&s) - 1,
               turn = 2 * M_PI * number(&s);
        while (x[2] >= 0 && x[2] <= high) {
            double far = -log(number(&s)) / extinction,
                   level = sqrt(fmax(1 - mu * mu, 0));
            const double way[3] = { level * cos(turn), level * sin(turn), mu };
            if (x[2] + far * mu > high + LOW_M || x[2] + far * mu < 0 ||
                x[2] < LOW_M || x[2] + far * mu < LOW_M) {
                /* In short steps where it counts. */
                for (double at = 2.5; at < far; at += 5) {
                    double z = x[2] + at * mu;
                    if (z < 0 || z > high) {
                        break;
                    }
                    int ring =
                        (int)(hypot(x[0] + at * way[0], x[1] + at * way[1]) /
                              RING_M);
                    if (z < LOW_M && ring < RINGS) {
                        out[ring] += 5;
                    }
                }
            }
            for (int a = 0; a < 3; a++) {
                x[a] += far * way[a];
            }
            /* Henyey and Greenstein, about the way that it had. */
            double q = (1 - 0.85 * 0.85) / (1 - 0.85 + 1.7 * number(&s)),
                   c = (1 + 0.85 * 0.85 - q * q) / 1.7,
                   side = sqrt(fmax(1 - c * c, 0)),
                   about = 2 * M_PI * number(&s);
            double next = mu * c + level * side * cos(about);
            next = fmax(-1, fmin(1, next));
            double out_level = sqrt(fmax(1 - next * next, 1e-12)),
                   bend = (c - mu * next) / fmax(level * out_level, 1e-9);
            turn += copysign(acos(fmax(-1, fmin(1, bend))), sin(about));
            mu = next;
        }
    }
    for (int k = 0; k < RINGS; k++) {
        double volume = M_PI * RING_M * RING_M * (2 * k + 1) * LOW_M;
        /* 4 pi of power; mean intensity is what passes over 4 pi. */
        out[k] /= volume * photons;
    }
}

/* A flash within clouds, seen at their base. */
static void shines_through_like_photons(void **state)
{
    (void)state;
    enum { PHOTONS = 12000 };
    const double extinction = 0.03, high = 2500;
    double l = 1 / (0.15 * extinction), theirs[RINGS], worst = 0;
    for (int n = 0; n < 2; n++) {
        double from = n ? 1000 : 400;
        about_a_lamp(extinction, high, from, PHOTONS, theirs);
        for (int k = 0; k < RINGS; k++) {
            double ours = 0;
            enum { PARTS = 40 };
            for (int i = 0; i < PARTS; i++) {
                double across = RING_M * (k + (i + 0.5) / PARTS);
                double share =
                    2 * (k + (i + 0.5) / PARTS) / ((2 * k + 1) * PARTS);
                ours += share * pel_cloud_within(l, high, across, 100, from);
            }
            print_message("lamp at %.0f m, ring %.1f km: %.2e of %.2e, "
                          "%+.0f %%\n",
                          from, (k + 0.5) * RING_M * 1e-3, ours, theirs[k],
                          100 * (ours / theirs[k] - 1));
            worst = fmax(worst, fabs(ours / theirs[k] - 1));
        }
    }
    /* Diffusion does not hold within l of a side. */
    assert_true(worst < 0.3);
}

/* The glow at the lower side is that of the flux that leaves there. */
static void glow_below_is_what_leaves(void **state)
{
    (void)state;
    for (double b = 0.1; b < 10; b *= 2) {
        double last = INFINITY;
        for (double t = 0.25 * b; t <= b; t += 0.25 * b) {
            double glow = pel_cloud_glow(t, b, 0.5);
            assert_true(glow >= 0 && isfinite(glow));
            last = glow;
        }
        /* Below, light goes down only: J = 2 H there, H = through / 4 pi less
         * what is left of the beam. */
        double beam = exp(-b / 0.5);
        double wanted =
            2 * 0.5 * (pel_cloud_through(b, 0.5) - beam) / (4 * M_PI) +
            beam / (4 * M_PI);
        assert_float_equal(last, wanted, 1e-9);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(covers_what_is_asked),
        cmocka_unit_test(lets_through_what_photons_do),
        cmocka_unit_test(shines_through_like_photons),
        cmocka_unit_test(glow_below_is_what_leaves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
