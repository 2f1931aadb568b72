/* Dip and distance of the horizon against the ellipsoid's own geometry: a line
 * from E along d touches xᵀAx = 1 where (dᵀAE)² = dᵀAd (EᵀAE − 1). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "render/spacegeometry.h"

#define DEGREE 0.017453292519943295

struct point {
    double x, y, z;
};

static double times(struct point a, struct point b) /* aᵀAb */
{
    const double a2 = 6378137.0 * 6378137.0, b2 = a2 * (1 - 0.00669437999014);
    return (a.x * b.x + a.y * b.y) / a2 + a.z * b.z / b2;
}

/* Depression [rad] and distance [m] of the horizon towards a true azimuth. */
static void horizon(double height, double latitude, double azimuth, double *dip,
                    double *distance)
{
    const double e2 = 0.00669437999014, s = sin(latitude), c = cos(latitude);
    double n = 6378137.0 / sqrt(1 - e2 * s * s);
    const struct point e = { (n + height) * c, 0, (n * (1 - e2) + height) * s },
                       up = { c, 0, s },
                       l = { -s * cos(azimuth), sin(azimuth),
                             c * cos(azimuth) };
    double q = times(e, e) - 1, pl = times(l, e), pu = times(up, e);
    /* (pl − t pu)² = q (ll − 2 t lu + t² uu), t the dip's tangent */
    double a = pu * pu - q * times(up, up), b = q * times(l, up) - pl * pu,
           k = pl * pl - q * times(l, l);
    double t = (-b + sqrt(b * b - a * k)) / a;
    *dip = atan(t);
    const struct point d = { cos(*dip) * l.x - sin(*dip) * up.x,
                             cos(*dip) * l.y - sin(*dip) * up.y,
                             cos(*dip) * l.z - sin(*dip) * up.z };
    *distance = -times(d, e) / times(d, d);
}

/* Found by what is met and what is not. */
static void seen_horizon(double height, double latitude, double convergence,
                         double azimuth, double *dip, double *distance)
{
    const struct pel_space_geometry g =
        pel_space_geometry_of(height, latitude, 0.3, convergence);
    /* In the frame's axes: clockwise of its y. */
    double from_y = azimuth + convergence, low = 0, high = 1.5;
    struct pel_vec3 normal;
    for (int i = 0; i < 60; i++) {
        double middle = 0.5 * (low + high);
        const struct pel_vec3 d = { cos(middle) * sin(from_y),
                                    cos(middle) * cos(from_y), -sin(middle) };
        *(pel_space_meets(&g, d, distance, &normal) ? &high : &low) = middle;
    }
    *dip = high;
}

#define WITHIN (0.01 * DEGREE)

static void horizon_is_the_ellipsoids(void **state)
{
    (void)state;
    double worst = 0, worst_far = 0;
    for (double h = 2; h < 1.1e7; h *= 1.5) {
        for (int latitude = -90; latitude <= 90; latitude += 15) {
            for (int azimuth = 0; azimuth < 360; azimuth += 30) {
                double dip, far, own, own_far;
                horizon(h, latitude * DEGREE, azimuth * DEGREE, &dip, &far);
                if (h < PEL_SPACE_LEAST_M) { /* the low form's sphere */
                    own = acos(6360e3 / (6360e3 + h));
                    own_far = sqrt(h * (2 * 6360e3 + h));
                } else {
                    seen_horizon(h, latitude * DEGREE, 0.7, azimuth * DEGREE,
                                 &own, &own_far);
                }
                /* Of the Earth's centre between nadir and horizon. */
                double off = fabs(far - own_far) * cos(dip) / 6378137.0;
                worst = fmax(worst, fabs(dip - own));
                worst_far = fmax(worst_far, off);
            }
        }
    }
    print_message("dip within %.5f deg, the horizon's place within %.5f\n",
                  worst / DEGREE, worst_far / DEGREE);
    assert_true(worst < WITHIN && worst_far < WITHIN);
}

/* The normal that is met at the nadir is the eye's own, height is height. */
static void nadir_is_below(void **state)
{
    (void)state;
    for (int latitude = -90; latitude <= 90; latitude += 10) {
        const struct pel_vec3 down = { 0, 0, -1 };
        struct pel_vec3 normal;
        double distance;
        const struct pel_space_geometry g =
            pel_space_geometry_of(4e5, latitude * DEGREE, -2.0, 1.0);
        assert_true(pel_space_meets(&g, down, &distance, &normal));
        assert_true(fabs(distance - 4e5) < 1e-3);
        assert_true(fabs(normal.z - 1) < 1e-12);
        assert_true(fabs(normal.x) < 1e-9 && fabs(normal.y) < 1e-9);
        /* The frame's axes lead to the pole. */
        double to_pole = 0.5 * PEL_PI - latitude * DEGREE;
        assert_true(fabs(g.earth.z.z - cos(to_pole)) < 1e-12);
        assert_true(fabs(g.earth.y.z - cos(1.0) * sin(to_pole)) < 1e-12);
        assert_true(fabs(g.earth.x.z - sin(1.0) * sin(to_pole)) < 1e-12);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(horizon_is_the_ellipsoids),
        cmocka_unit_test(nadir_is_below),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
