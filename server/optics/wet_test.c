#include "optics/wet.h"

#include <stdio.h>

#include "base/near.h"
#include "base/vec.h"
#include "shaders/lib/blocks.h"

/* Fresnel's equations, without polarisation, into an index n. */
static double fresnel(double cosine, double n)
{
    double sine2 = (1 - cosine * cosine) / (n * n);
    if (sine2 >= 1) {
        return 1;
    }
    double inner = sqrt(1 - sine2);
    double s = (cosine - n * inner) / (cosine + n * inner);
    double p = (n * cosine - inner) / (n * cosine + inner);
    return 0.5 * (s * s + p * p);
}

static double diffuse(double n)
{
    double sum = 0;
    for (int i = 0; i < 20000; i++) {
        double cosine = (i + 0.5) / 20000;
        sum += 2 * cosine * fresnel(cosine, n) / 20000;
    }
    return sum;
}

/* The film's two reflectances by quadrature, and what comes of them by turns.
 */
static void films_darken(void **state)
{
    (void)state;
    double outside = diffuse(PEL_WATER_INDEX),
           inside = diffuse(1 / PEL_WATER_INDEX);
    printf("%.4f from outside, %.4f from inside\n", outside, inside);
    assert_near(PEL_WET_OUTSIDE, outside, 0.001);
    assert_near(PEL_WET_INSIDE, inside, 0.001);
    for (double dry = 0; dry <= 1; dry += 0.125) {
        double light = 1 - outside, out = 0;
        for (int i = 0; i < 200; i++) {
            light *= dry;
            out += light * (1 - inside);
            light *= inside;
        }
        assert_near(pel_wet_reflectance(dry), out, 0.002);
    }
}

/* Crests of a narrow sea by random phases and amplitudes. */
static void the_highest_crest_wets(void **state)
{
    (void)state;
    enum { TURNS = 20000 };
    uint64_t seed = 1;
    int above[4] = { 0 };
    for (int i = 0; i < TURNS; i++) {
        double highest = 0;
        for (int k = 0; k < PEL_WET_WAVES; k++) {
            double sum[2];
            for (int j = 0; j < 2; j++) { /* two nearly normal numbers */
                sum[j] = -24;
                for (int n = 0; n < 48; n++) {
                    seed = seed * 6364136223846793005U + 1442695040888963407U;
                    sum[j] += (double)(seed >> 11) * 0x1p-53;
                }
            }
            highest = fmax(highest, hypot(sum[0], sum[1]) / 2);
        }
        for (int k = 0; k < 4; k++) {
            above[k] += highest > 1.5 + 0.5 * k;
        }
    }
    for (int k = 0; k < 4; k++) {
        double h = 1.5 + 0.5 * k, share = (double)above[k] / TURNS;
        printf("%.1f: %.3f of %.3f\n", h, pel_wet_share(0.4 * h, 0.4), share);
        /* Three standard errors, and what the sums lack of a tail. */
        assert_near(pel_wet_share(0.4 * h, 0.4), share, 0.02);
    }
    assert_near(pel_wet_share(-0.1, 0.4), 1, 0);
    assert_near(pel_wet_share(0.1, 0), 0, 1e-12);
}

/* The spectrum of Pierson and Moskowitz above a wavenumber, by quadrature. */
static void short_hulls_go_along(void **state)
{
    (void)state;
    const double g = 9.81, peak = 0.8; /* rad/s */
    double m0 = 0.0081 * g * g / (5 * pow(peak, 4));
    for (double length = 2; length < 400; length *= 3) {
        double least = sqrt(g * PEL_PI / length), sum = 0;
        for (int i = 0; i < 200000; i++) {
            double w = least + (i + 0.5) * 1e-4 * (least < 1 ? 1 : least);
            sum += 0.0081 * g * g * pow(w, -5) * exp(-1.25 * pow(peak / w, 4)) *
                   1e-4 * (least < 1 ? 1 : least);
        }
        assert_near(pel_wet_deviation(m0, length), sqrt(sum), 0.01 * sqrt(sum));
    }
    assert_near(pel_wet_deviation(0, 10), 0, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(films_darken),
        cmocka_unit_test(the_highest_crest_wets),
        cmocka_unit_test(short_hulls_go_along),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
