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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moments_are_exact),
        cmocka_unit_test(tilted_facets_mirror_lower),
        cmocka_unit_test(from_above_all_is_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
