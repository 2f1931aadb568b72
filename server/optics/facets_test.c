#include "optics/facets.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

#include <cmocka.h>

#include "base/near.h"
#include "optics/brdf.h"

/* As the nodes are placed. */
static double fall(double mu)
{
    return 1.2 / (1.0 + mu * mu / 36.0);
}

/* The facets that are seen at mu, by brute force: their moment, times
 * exp(-fall z), of those whose reflection escapes or does not. */
static double moment(double mu, int power, bool escapes)
{
    enum { STEPS = 200000 };
    double sum = 0.0, mass = 0.0, steeper = pel_seen_steeper(mu);
    double from = fmax(steeper - mu, -10.0), step = (10.0 - from) / STEPS;
    for (int i = 0; i < STEPS; i++) {
        double z = from + (i + 0.5) * step, y = z - steeper;
        double w = (mu + y) * exp(-0.5 * y * y * (1.0 + pel_seen_narrower(mu)));
        double escape = pel_facets_escape(mu, z);
        mass += w;
        sum += w * (escapes ? escape : 1.0 - escape) * pow(z, power) *
               exp(-fall(mu) * z);
    }
    return sum / mass;
}

static void moments_are_exact(void **state)
{
    (void)state;
    static const double mus[] = { 0.0, 0.1, 0.5, 1.0, 3.0, 20.0 };
    for (int m = 0; m < 6; m++) {
        double z[PEL_FACET_NODES], w[PEL_FACET_NODES], all = 0.0;
        pel_facets_seen(mus[m], z, w);
        assert_true(z[0] < z[1] && z[1] < z[2]);
        for (int power = 0; power <= 5; power++) {
            double sum = 0.0, want = moment(mus[m], power, true);
            for (int k = 0; k < 3; k++) {
                sum += w[k] * exp(-fall(mus[m]) * z[k]) * pow(z[k], power);
            }
            assert_near(sum, want, 1e-3 * fmax(fabs(want), 1.0));
        }
        for (int power = 0; power <= 1; power++) {
            double sum = w[3] * exp(-fall(mus[m]) * z[3]) * pow(z[3], power);
            assert_near(sum, moment(mus[m], power, false), 1e-3);
        }
        for (int k = 0; k < PEL_FACET_NODES; k++) {
            all += w[k];
        }
        assert_near(all, 1.0, 6e-3); /* it is no moment of theirs */
    }
}

/* By the mirror itself: a facet of slope z s towards the eye and s across it.
 */
static void tilted_facets_mirror_lower(void **state)
{
    (void)state;
    const double s = 0.1;
    for (double mu = 0.2; mu < 6.0; mu += 0.4) {
        for (double z = fmax(-0.45 * mu, -1.5); z < 2.0; z += 0.25) {
            double high = atan(mu * s);
            struct pel_vec3 v = { cos(high), 0.0, sin(high) };
            struct pel_vec3 n =
                pel_vec3_normalize((struct pel_vec3){ z * s, s, 1.0 });
            double up = 2.0 * pel_vec3_dot(v, n) * n.z - v.z;
            double tangent = up / sqrt(1.0 - up * up);
            assert_near(pel_facets_escape(mu, z), pel_escape(tangent / s, mu),
                        0.012);
        }
    }
}

/* From straight above every slope is seen as often as there is of it. */
static void from_above_all_is_seen(void **state)
{
    (void)state;
    double z[PEL_FACET_NODES], w[PEL_FACET_NODES], sum[3] = { 0 };
    pel_facets_seen(INFINITY, z, w);
    for (int k = 0; k < PEL_FACET_NODES; k++) {
        for (int power = 0; power < 3; power++) {
            sum[power] += w[k] * pow(z[k], power);
        }
    }
    assert_near(w[3], 0.0, 1e-9);
    assert_near(sum[0], 1.0, 1e-3);
    assert_near(sum[1], 0.0, 5e-3);
    assert_near(sum[2], 1.0, 2e-2);
}

/* Facets that face the light, each in proportion to the light that it meets;
 * what one sends to another is lost, which is why the grazing ones are left to
 * `make validate`. */
static double entering(double zenith, double azimuth, double var_x,
                       double var_y)
{
    enum { STEPS = 400 };
    const struct pel_vec3 to = { sin(zenith) * cos(azimuth),
                                 sin(zenith) * sin(azimuth), cos(zenith) };
    double sum = 0.0, all = 0.0;
    for (int k = 0; k < STEPS * STEPS; k++) {
        double x = 5.0 * (2.0 * (k % STEPS + 0.5) / STEPS - 1.0);
        double y = 5.0 * (2.0 * (k / STEPS + 0.5) / STEPS - 1.0);
        double zx = x * sqrt(var_x), zy = y * sqrt(var_y);
        double shown = to.z + to.x * zx + to.y * zy;
        if (shown > 0.0) {
            double w = exp(-0.5 * (x * x + y * y)) * shown;
            double cosine = shown / sqrt(1.0 + zx * zx + zy * zy);
            sum += w * (1.0 - pel_fresnel_exact(cosine, PEL_WATER_INDEX));
            all += w;
        }
    }
    return sum / all;
}

static void low_light_enters_through_waves(void **state)
{
    (void)state;
    static const double slopes[][2] = { { 0.005, 0.004 }, { 0.02, 0.015 } };
    for (int k = 0; k < 2; k++) {
        double x = slopes[k][0], y = slopes[k][1];
        for (int deg = 0; deg <= 80; deg += 10) {
            for (double azimuth = 0.0; azimuth < 2.0; azimuth += 0.7) {
                double zenith = deg * PEL_DEG;
                const struct pel_vec3 to = { sin(zenith) * cos(azimuth),
                                             sin(zenith) * sin(azimuth),
                                             cos(zenith) };
                double want = entering(zenith, azimuth, x, y);
                /* Facets seen are a fit: 2 %. */
                assert_near(pel_facets_entering(to, x, y), want, 0.02 * want);
            }
        }
    }
    const struct pel_vec3 low = { 0.9962, 0.0, 0.0872 };
    double level = pel_facets_entering(low, 0.0, 0.0);
    assert_near(level, 1.0 - pel_fresnel_exact(low.z, PEL_WATER_INDEX), 1e-12);
    assert_true(pel_facets_entering(low, 0.02, 0.02) > 1.4 * level);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moments_are_exact),
        cmocka_unit_test(tilted_facets_mirror_lower),
        cmocka_unit_test(from_above_all_is_seen),
        cmocka_unit_test(low_light_enters_through_waves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
