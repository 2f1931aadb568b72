/* The light inside the water: against single scattering of thin water in closed
 * form, the solver's own field by another way, the decay of the light with
 * depth, and what Beer's law leaves of the beam. */
#include "optics/underlight.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/clock.h"
#include "base/vec.h"
#include "optics/ordinates.h"

enum { VIEWS = 8, MODES = 24, LEVELS = 4 };

static struct pel_medium clear_water(double depth_m, double albedo)
{
    return (struct pel_medium){
        .absorption = 0.06,
        .scattering = 0.08,
        .molecular = 0.05,
        .back = 0.018,
        .depth_m = depth_m,
        .albedo = albedo,
    };
}

static double many[LEVELS * MODES * 2 * VIEWS],
    once[LEVELS * MODES * 2 * VIEWS], flux[LEVELS * 2];

static double at(const double *modes, int level, int side, int view,
                 double azimuth)
{
    double sum = 0;
    for (int m = 0; m < MODES; m++) {
        sum += modes[((level * MODES + m) * 2 + side) * VIEWS + view] *
               cos(m * azimuth);
    }
    return sum;
}

/* Irradiance of each level plane is the integral of what the water alone sends
 * and of what the surface and the bottom do: here of the whole field by another
 * way, and the radiance straight up. */
static void as_the_field(void **state)
{
    (void)state;
    const double zenith = 0.6, depths[LEVELS] = { 0.0, 1.0, 10.0, 39.0 };
    const struct pel_medium m = clear_water(40.0, 0.3);
    struct pel_ordinates *o = pel_ordinates_create(12, 0.0);
    assert_non_null(o);
    const struct pel_geometry g = { .sun_zenith_rad = zenith };
    const struct pel_interface face = pel_interface_at(&g);
    const double mu[1] = { face.sun_mu };
    double view[VIEWS];
    for (int i = 0; i < VIEWS; i++) {
        view[i] = (i + 1.0) / VIEWS;
    }
    struct pel_field field[LEVELS];
    pel_ordinates_field(o, &m, zenith, depths, LEVELS, field);
    assert_int_equal(pel_ordinates_inside(o, &m, mu, 1, depths, LEVELS, view,
                                          VIEWS, MODES, many, once, flux),
                     PEL_OK);
    double c = pel_ordinates_extinction(o, &m);
    for (int k = 0; k < LEVELS; k++) {
        double beam = face.beam * mu[0] * exp(-c * depths[k] / mu[0]);
        double down = face.beam * flux[2 * k] + beam;
        double up = face.beam * flux[2 * k + 1];
        /* Straight down onto a Lambertian bottom, whose light is
         * albedo / pi of what falls on it. */
        struct pel_field floor_;
        double deepest = m.depth_m;
        pel_ordinates_field(o, &m, zenith, &deepest, 1, &floor_);
        double bed =
            m.albedo * floor_.down / PEL_PI * exp(-c * (m.depth_m - depths[k]));
        const double e = exp(-c * depths[k] / mu[0]);
        struct pel_medium rest = m;
        rest.depth_m -= depths[k];
        double first =
            pel_ordinates_single(o, &rest, face.beam * e, mu[0], 1.0, -mu[0]);
        double nadir = face.beam * at(many, k, 1, VIEWS - 1, 0.0) + first + bed;
        print_message("depth %4.1f m: down %.5f (%.5f), up %.5f (%.5f), nadir "
                      "%.6f (%.6f)\n",
                      depths[k], down, field[k].down, up, field[k].up, nadir,
                      field[k].nadir);
        /* Both solve the same equations: rounding alone. */
        assert_true(fabs(down / field[k].down - 1) < 1e-6);
        assert_true(fabs(up / field[k].up - 1) < 1e-6);
        assert_true(fabs(nadir / field[k].nadir - 1) < 1e-4);
    }
    pel_ordinates_destroy(o);
}

/* Of water so thin that light is scattered once, the second order is of the
 * order of the optical depth. */
static void once_in_thin_water(void **state)
{
    (void)state;
    struct pel_medium m = clear_water(1.0, 0.0);
    m.absorption = 0.002;
    m.scattering = 0.004;
    m.molecular = 1.0; /* which 24 terms hold wholly */
    m.back = 0.0;
    const double depths[LEVELS] = { 0.1, 0.4, 0.7, 1.0 }, mu[1] = { 0.8 };
    const double view[VIEWS] = { 0.05, 0.2, 0.4, 0.5, 0.6, 0.7, 0.9, 1.0 };
    struct pel_ordinates *o = pel_ordinates_create(12, 0.0);
    assert_non_null(o);
    assert_int_equal(pel_ordinates_inside(o, &m, mu, 1, depths, LEVELS, view,
                                          VIEWS, MODES, many, once, flux),
                     PEL_OK);
    const struct pel_phase phase = pel_medium_phase(&m);
    const double c = m.absorption + m.scattering;
    double worst = 0, most = 0;
    for (int i = 0; i < LEVELS * VIEWS * 2 * 5; i++) {
        int k = i % LEVELS, v = i / LEVELS % VIEWS, side = i / 32 % 2;
        double azimuth = i / 64 * 0.7;
        double w = view[v] * (side ? -1 : 1);
        /* Looking up it sees light that goes down. */
        double turn = w * mu[0] +
                      sqrt(1 - w * w) * sqrt(1 - mu[0] * mu[0]) * cos(azimuth);
        double sum = 0;
        const int steps = 2000;
        double length =
            side ? (1.0 - depths[k]) / view[v] : depths[k] / view[v];
        for (int j = 0; j < steps; j++) {
            double s = (j + 0.5) / steps * length;
            double z = depths[k] - s * w;
            sum += exp(-c * (s + z / mu[0])) * length / steps;
        }
        double want = m.scattering * pel_phase_at(&phase, turn) * sum;
        worst = fmax(worst, fabs(at(once, k, side, v, azimuth) / want - 1));
        most = fmax(most, at(many, k, side, v, azimuth) / want);
    }
    print_message("first order to %.1e of its integral; the others %.3f of it "
                  "at most\n",
                  worst, most);
    assert_true(worst < 1e-4); /* midpoints of 2000 steps */
    assert_true(most < 0.1);   /* mirrored by the surface, too */
    pel_ordinates_destroy(o);
}

/* Far down every direction falls off alike, as fast as the slowest mode:
 * Gershun's equation in the asymptotic regime has K between a and c. */
static void asymptotic(void **state)
{
    (void)state;
    const struct pel_medium m = clear_water(400.0, 0.0);
    const double depths[LEVELS] = { 240, 260, 280, 300 }, mu[1] = { 0.9 };
    const double view[VIEWS] = { 0.05, 0.2, 0.4, 0.5, 0.6, 0.7, 0.9, 1.0 };
    struct pel_ordinates *o = pel_ordinates_create(12, 0.0);
    assert_non_null(o);
    assert_int_equal(pel_ordinates_inside(o, &m, mu, 1, depths, LEVELS, view,
                                          VIEWS, MODES, many, once, flux),
                     PEL_OK);
    double k = log(flux[4] / flux[6]) / 20.0, worst = 0;
    for (int i = 0; i < 2 * VIEWS; i++) {
        double a = at(many, 2, i % 2, i / 2, 1.0);
        double b = at(many, 3, i % 2, i / 2, 1.0);
        worst = fmax(worst, fabs(log(a / b) / 20.0 / k - 1));
    }
    print_message("K %.5f 1/m (a %.3f, c %.3f), in any direction to %.4f\n", k,
                  m.absorption, m.absorption + m.scattering, worst);
    assert_true(k > m.absorption && k < m.absorption + m.scattering);
    assert_true(worst < 0.02); /* the beam's last rest */
    pel_ordinates_destroy(o);
}

/* The phase function and its peak: shares of the whole. */
static void peak(void **state)
{
    (void)state;
    const struct pel_water_body body = pel_water_deep(0.3);
    struct pel_under_medium u;
    assert_int_equal(pel_under_medium_make(&body, 100.0, &u), PEL_OK);
    for (int i = 0; i < 3; i++) {
        double rest = 0;
        const int steps = 20000;
        for (int k = 0; k < steps; k++) {
            double a = PEL_PI * (k + 0.5) / steps;
            double x = sqrt(a / PEL_PI) * PEL_UNDER_TURNS;
            int j = (int)x;
            double low = (double)(&u.turns[j].x)[i];
            double high = (double)(&u.turns[j + 1].x)[i];
            rest += 2 * PEL_PI * sin(a) * PEL_PI / steps *
                    exp2(low + (x - j) * (high - low));
        }
        print_message("peak %.3f within %.1f deg; the rest %.4f of 1; c %.4f, "
                      "scaled %.4f\n",
                      u.peak[i], u.peak_rad / PEL_DEG, rest, u.full[i],
                      u.scaled[i]);
        /* Tables of 64 steps. */
        assert_true(fabs(rest - (1 - u.peak[i])) < 0.01);
    }
}

static void takes(void **state)
{
    (void)state;
    const struct pel_water_body body = pel_water_deep(0.3);
    struct pel_under_medium u;
    struct pel_under_kernel *k = malloc(sizeof *k);
    assert_non_null(k);
    int64_t start = pel_now_ns();
    assert_int_equal(pel_under_medium_make(&body, 100.0, &u), PEL_OK);
    int64_t middle = pel_now_ns();
    assert_int_equal(pel_under_kernel_build(&body, &u, body.depth_m, k),
                     PEL_OK);
    print_message("medium %.1f ms, kernel %.1f ms\n",
                  (double)(middle - start) * 1e-6,
                  (double)(pel_now_ns() - middle) * 1e-6);
    for (size_t i = 0; i < sizeof *k / sizeof(float); i++) {
        assert_true(isfinite((&k->sun[0][0][0][0][0])[i]));
    }
    free(k);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_the_field), cmocka_unit_test(once_in_thin_water),
        cmocka_unit_test(asymptotic),   cmocka_unit_test(peak),
        cmocka_unit_test(takes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
