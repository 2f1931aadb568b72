/* Lightning against what is published of flashes: how often, how many strokes,
 * how far apart; that a stream's frames have each stroke's light once; that it
 * is a function of the moment. */
#include "optics/lightning.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { MANY = 40000 };
static const struct pel_lightning storm = { .per_minute = 6,
                                            .east_m = 3000,
                                            .north_m = -2000,
                                            .radius_m = 5000,
                                            .base_m = 1200,
                                            .seed = 7 };
static struct pel_lightning_flash flashes[MANY];

/* Rakov and Uman 2003: 3 to 5 strokes a flash, a fifth single, intervals of 60
 * ms in the geometric mean; Poisson's counts are as uneven as they are many. */
static void flashes_are_like_flashes(void **state)
{
    (void)state;
    const double hours = 40;
    size_t n = pel_lightning_flashes(&storm, 0, hours * 3600, flashes, MANY);
    double expected = hours * 360, strokes = 0, single = 0, log_gap = 0,
           gaps = 0, odd = 0, middle = 0;
    for (size_t i = 0; i < n; i++) {
        const struct pel_lightning_flash *f = &flashes[i];
        strokes += f->strokes;
        single += f->strokes == 1;
        for (int k = 1; k < f->strokes; k++, gaps++) {
            log_gap += log(f->begin_s[k] - f->begin_s[k - 1]);
        }
        double away = hypot(f->east_m - 3000, f->north_m + 2000);
        assert_true(away <= 5000);
        middle += away < 5000 * sqrt(0.5);
    }
    for (int m = 0; m < (int)(hours * 60); m++) {
        size_t here = pel_lightning_flashes(&storm, 60.0 * m, 60.0 * (m + 1),
                                            flashes, MANY);
        odd += pow((double)here - 6, 2) / (hours * 60);
    }
    double dn = (double)n;
    print_message("%zu flashes of %.0f, %.2f strokes, %.3f single, intervals "
                  "%.1f ms, variance of a minute's %.2f\n",
                  n, expected, strokes / dn, single / dn,
                  1e3 * exp(log_gap / gaps), odd);
    assert_true(fabs(dn - expected) < 3.5 * sqrt(expected));
    assert_true(strokes / dn > 3 && strokes / dn < 5);
    assert_true(fabs(single / dn - 0.2) < 0.02);
    assert_true(fabs(exp(log_gap / gaps) / 0.06 - 1) < 0.05);
    assert_true(fabs(odd / 6 - 1) < 0.12); /* 3.5 sigma of 2400 minutes */
    assert_true(fabs(middle / dn - 0.5) < 0.02);
}

/* Frames that follow each other without a gap have all of its light. */
static void frames_share_the_light(void **state)
{
    (void)state;
    size_t n = pel_lightning_flashes(&storm, 0, 600, flashes, MANY);
    static const double rates[] = { 24, 30, 60 };
    for (size_t r = 0; r < 3; r++) {
        double worst = 0;
        for (size_t i = 0; i < n; i++) {
            const struct pel_lightning_flash *f = &flashes[i];
            double all = f->continuing_lms, seen = 0, dt = 1 / rates[r];
            for (int k = 0; k < f->strokes; k++) {
                all += f->energy_lms[k];
            }
            for (int k = 0; k < (int)(3 * rates[r]); k++) {
                double at_s = floor(f->time_s / dt) * dt + k * dt;
                seen += 4 * M_PI * dt * pel_lightning_intensity(f, at_s, dt);
            }
            worst = fmax(worst, fabs(seen / all - 1));
        }
        print_message("%.0f Hz: %.1e of a flash's light off\n", rates[r],
                      worst);
        assert_true(worst < 1e-6);
    }
}

/* At 10 km a first stroke of 3.7e7 lm s gives 0.029 lx s: E = Q / 4 pi r^2. */
static void as_bright_as_measured(void **state)
{
    (void)state;
    size_t n = pel_lightning_flashes(&storm, 0, 36000, flashes, MANY);
    double first = 0, later = 0, laters = 0;
    for (size_t i = 0; i < n; i++) {
        first += flashes[i].energy_lms[0] / (double)n;
        for (int k = 1; k < flashes[i].strokes; k++, laters++) {
            later += flashes[i].energy_lms[k];
        }
    }
    double lx_s = first / (4 * M_PI * 1e8);
    print_message("first strokes %.2e lm s, %.4f lx s at 10 km; later ones "
                  "%.2f of it\n",
                  first, lx_s, later / laters / first);
    assert_true(fabs(lx_s / 0.0294 - 1) < 0.05);
    assert_true(fabs(later / laters / first - 0.25) < 0.02);
}

static void lamps_are_the_moment_alone(void **state)
{
    (void)state;
    static struct pel_lamp a[512], b[512];
    size_t n = pel_lightning_flashes(&storm, 0, 600, flashes, MANY), burn = 0;
    assert_true(n > 30);
    for (size_t i = 20; i-- > 0;) { /* backwards: no history */
        double time_s = flashes[i].time_s + 0.003;
        size_t count = pel_lightning_lamps(&storm, time_s, 1.0 / 60, a, 512);
        assert_true(count >= PEL_LIGHTNING_LAMPS);
        assert_int_equal(count,
                         pel_lightning_lamps(&storm, time_s, 1.0 / 60, b, 512));
        assert_memory_equal(a, b, count * sizeof *a);
        double sum = 0, mirrored = 0;
        for (int k = 0; k < PEL_LIGHTNING_LAMPS; k++) {
            sum += a[k].intensity_cd[1];
            mirrored +=
                a[k].mirrors > 0 ? a[k].mirrors * a[k].intensity_cd[1] : 0;
            assert_true(a[k].altitude_m > 0 && a[k].altitude_m < 1200);
        }
        assert_true(fabs(mirrored / sum - 1) < 1e-9);
        burn++;
    }
    assert_int_equal(burn, 20);
    /* Between flashes one lamp without light; no storm, none. */
    double dark = 0;
    for (size_t i = 0; i + 1 < n && dark == 0; i++) {
        dark = flashes[i + 1].time_s - flashes[i].time_s > 5
                   ? flashes[i].time_s + 4
                   : 0;
    }
    assert_true(dark > 0);
    assert_int_equal(pel_lightning_lamps(&storm, dark, 1.0 / 60, a, 512), 1);
    assert_true(a[0].intensity_cd[1] == 0);
    const struct pel_lightning none = { 0 };
    assert_int_equal(pel_lightning_lamps(&none, dark, 1.0 / 60, a, 512), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flashes_are_like_flashes),
        cmocka_unit_test(frames_share_the_light),
        cmocka_unit_test(as_bright_as_measured),
        cmocka_unit_test(lamps_are_the_moment_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
