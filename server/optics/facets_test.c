#include "optics/facets.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "base/near.h"

/* Moment of the visible density by brute force. */
static double moment(double mu, int power)
{
    double sum = 0.0, mass = 0.0;
    for (int i = 0; i < 200000; i++) {
        double z =
            -fmin(mu, 10.0) + (i + 0.5) * (10.0 + fmin(mu, 10.0)) / 200000;
        double w = (mu + z) * exp(-0.5 * z * z);
        mass += w;
        sum += w * pow(z, power);
    }
    return sum / mass;
}

static void moments_are_exact(void **state)
{
    (void)state;
    static const double mus[] = { 0.0, 0.1, 0.5, 1.0, 3.0, 20.0 };
    for (int m = 0; m < 6; m++) {
        double z[3], w[3];
        pel_facet_quadrature(mus[m], z, w);
        assert_true(z[0] < z[1] && z[1] < z[2] && z[0] > -mus[m]);
        for (int power = 0; power <= 5; power++) {
            double sum = 0.0;
            for (int k = 0; k < 3; k++) {
                sum += w[k] * pow(z[k], power);
            }
            /* Both sides sample the density at finite steps. */
            assert_near(sum, moment(mus[m], power), 2e-5);
        }
    }
}

static void far_limit_is_gauss_hermite(void **state)
{
    (void)state;
    double z[3], w[3];
    pel_facet_quadrature(INFINITY, z, w);
    assert_near(z[0], -sqrt(3.0), 1e-6);
    assert_near(z[1], 0.0, 1e-6);
    assert_near(z[2], sqrt(3.0), 1e-6);
    assert_near(w[1], 2.0 / 3.0, 1e-6);
    assert_near(w[0], 1.0 / 6.0, 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moments_are_exact),
        cmocka_unit_test(far_limit_is_gauss_hermite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
