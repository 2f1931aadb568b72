#include "scene/geodesy.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/vec.h"
#include "scene/ephemeris.h"
#include "scene/reckon.h"
#include "scene/sun.h"

static void near(double got, double want, double tolerance)
{
    if (!(fabs(got - want) <= tolerance)) {
        fail_msg("%.12g is not %.12g ± %g", got, want, tolerance);
    }
}

static double dms(double d, double m, double s)
{
    return d + m / 60 + s / 3600;
}

/* The test line of Vincenty's formulae that Geoscience Australia publishes
 * (Flinders Peak to Buninyong, 54,972.271 m, 306°52′05.37″), on GRS 80, which
 * is WGS 84 to 0.1 mm; its figures have 1 mm and 0.01″. */
static void a_published_geodesic(void **state)
{
    (void)state;
    double east, north;
    pel_geo_to_local(-dms(37, 57, 3.7203), dms(144, 25, 29.5244),
                     -dms(37, 39, 10.1561), dms(143, 55, 35.3839), &east,
                     &north);
    near(hypot(east, north), 54972.271, 1e-3);
    near(atan2(east, north) / PEL_DEG + 360, dms(306, 52, 5.37), 0.01 / 3600);
    /* One degree of the equator is a·π/180, of the first meridian arc
     * 110,574.389 m (any table of WGS 84). */
    pel_geo_to_local(0, 0, 0, 1, &east, &north);
    near(east, 6378137 * PEL_DEG, 1e-6);
    near(north, 0, 1e-6);
    pel_geo_to_local(0, 179.5, 1, 179.5, &east, &north);
    near(north, 110574.389, 1e-3);
    /* Across the date line. */
    pel_geo_to_local(0, 179.5, 0, -179.5, &east, &north);
    near(east, 6378137 * PEL_DEG, 1e-6);
}

static void places_come_back(void **state)
{
    (void)state;
    const double origins[][2] = {
        { 52.6, 5.2 },
        { -37.9, 179.99 },
        { 84.9, -120 },
        { 0, 0 },
    };
    for (size_t i = 0; i < 4; i++) {
        for (int r = 0; r <= 100000; r += 12500) {
            for (int a = 0; a < 360; a += 15) {
                double e = r * sin(a * PEL_DEG), n = r * cos(a * PEL_DEG);
                double lat, lon, e2, n2;
                pel_geo_from_local(origins[i][0], origins[i][1], e, n, &lat,
                                   &lon);
                assert_true(fabs(lat) <= 90 && fabs(lon) <= 180);
                pel_geo_to_local(origins[i][0], origins[i][1], lat, lon, &e2,
                                 &n2);
                near(e2, e, 1e-3); /* what is promised */
                near(n2, n, 1e-3);
            }
        }
    }
}

static void everywhere_is_finite(void **state)
{
    (void)state;
    for (int lat = -90; lat <= 90; lat += 6) {
        for (int lon = -180; lon <= 180; lon += 6) {
            double e, n;
            pel_geo_to_local(30, 0, lat, lon, &e, &n);
            assert_true(isfinite(e) && isfinite(n));
            /* Half the Earth's girth, plus 1 % for the sphere. */
            assert_true(hypot(e, n) < 20.21e6);
            assert_true(isfinite(pel_geo_convergence(30, 0, lat, lon)));
        }
    }
    double e, n;
    pel_geo_to_local(0, 0, 0.1, 179.9, &e, &n); /* Vincenty's blind spot */
    assert_true(isfinite(e) && isfinite(n));
}

static void north_turns_with_longitude(void **state)
{
    (void)state;
    near(pel_geo_convergence(60, 5, 60, 5), 0, 1e-9);
    /* Δλ sin φ to first order; the next is Δλ² here, 0.01°. */
    near(pel_geo_convergence(60, 5, 60, 6) / PEL_DEG, -sin(60 * PEL_DEG), 0.01);
    near(pel_geo_convergence(-60, 5, -60, 6) / PEL_DEG, sin(60 * PEL_DEG),
         0.01);
}

static void ships_turn_in_circles(void **state)
{
    (void)state;
    double e, n;
    /* 6°/s: a whole circle in 60 s, of radius v/ω. */
    double omega = 6 * PEL_DEG, radius = 10 / omega;
    pel_reckon_move(10, 0.3, omega, 60, &e, &n);
    near(hypot(e, n), 0, 1e-9);
    pel_reckon_move(10, 0, omega, 15, &e, &n);
    near(e, radius, 1e-9);
    near(n, radius, 1e-9);
    pel_reckon_move(10, PEL_PI / 2, 0, 7, &e, &n);
    near(e, 70, 1e-9);
    near(n, 0, 1e-9);
    pel_reckon_move(10, PEL_PI / 2, 1e-12, 7, &e, &n);
    near(e, 70, 1e-9);
    /* Against 1 mm steps of the same motion. */
    double se = 0, sn = 0;
    for (int i = 0; i < 100000; i++) {
        double c = 1 + 0.02 * (i + 0.5) * 1e-4;
        se += 10e-4 * sin(c);
        sn += 10e-4 * cos(c);
    }
    pel_reckon_move(10, 1, 0.02, 10, &e, &n);
    near(e, se, 1e-6);
    near(n, sn, 1e-6);
    near(pel_reckon_seconds(100, 130, 60), 30, 0);
    near(pel_reckon_seconds(100, 1e6, 60), 60, 0);
    near(pel_reckon_seconds(100, 0, 60), -60, 0);
    near(pel_reckon_seconds(100, 1e6, 0), 0, 0);
}

static double utc(const char *text)
{
    double unix_s;
    assert_int_equal(pel_utc_parse(text, &unix_s), PEL_OK);
    return unix_s;
}

static void the_sun_is_where_others_say(void **state)
{
    (void)state;
    double azimuth, elevation;
    const double tolerance = 0.01; /* degrees: the method's own accuracy */
    /* Reda and Andreas 2004 (SPA), table A5.1: zenith 50.11162° with
     * refraction of 0.01633° (820 mbar, 11 °C), azimuth 194.34024°. */
    pel_sun_position(utc("2003-10-17T19:30:30Z"), 39.742476 * PEL_DEG,
                     -105.1786 * PEL_DEG, &azimuth, &elevation);
    near(azimuth / PEL_DEG, 194.34024, tolerance);
    near(elevation / PEL_DEG, 90 - 50.11162 - 0.01633, tolerance);
    /* At the pole the elevation is the declination, less 0.0024° of parallax.
     * Meeus, example 25.a: 1992 October 13.0, -7.78507°. */
    pel_sun_position(utc("1992-10-13T00:00:00Z"), PEL_PI / 2, 0, &azimuth,
                     &elevation);
    near(elevation / PEL_DEG, -7.78507, tolerance);
    /* Equinox and solstice of the almanacs. */
    pel_sun_position(utc("2020-03-20T03:49:36Z"), PEL_PI / 2, 0, &azimuth,
                     &elevation);
    near(elevation / PEL_DEG, 0, tolerance);
    pel_sun_position(utc("2020-06-20T21:43:40Z"), PEL_PI / 2, 0, &azimuth,
                     &elevation);
    near(elevation / PEL_DEG, 23.4367, tolerance);
}

/* By XEphem's code (Debian's python3-ephem 4.1.4), from the surface, without
 * refraction: azimuth, elevation, kilometres, share lit. */
static void the_moon_is_where_others_say(void **state)
{
    (void)state;
    static const struct {
        const char *utc;
        double latitude, longitude, azimuth, elevation, km, lit;
    } rows[] = {
        { "2026-06-29T23:00:00Z", 50, 0, 165.7947, 10.5836, 404061.8, 0.9987 },
        { "2026-03-03T11:30:00Z", -33, 151, 50.8204, 34.9731, 378893.5, 1 },
        { "1987-04-12T00:00:00Z", 0, -40, 79.5068, 72.5646, 380903.4, 0.9490 },
        { "2045-09-09T03:00:00Z", 70, 20, 86.0575, 13.7864, 358086.1, 0.0533 },
        { "2000-01-21T04:40:00Z", 35, -75, 153.9679, 73.0244, 354656.7, 1 },
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct pel_moon_place m;
        pel_ephemeris_moon(utc(rows[i].utc), rows[i].latitude * PEL_DEG,
                           rows[i].longitude * PEL_DEG, &m);
        double a = rows[i].azimuth * PEL_DEG, e = rows[i].elevation * PEL_DEG;
        const struct pel_vec3 off = {
            m.direction.x - cos(e) * sin(a),
            m.direction.y - cos(e) * cos(a),
            m.direction.z - sin(e),
        };
        /* Seen 0.003. Without parallax it is up to a degree. */
        near(sqrt(pel_vec3_dot(off, off)) / PEL_DEG, 0, 0.01);
        near(1e-3 * m.distance_m, rows[i].km, 1.0);
        near(m.lit, rows[i].lit, 0.002);
    }
}

/* By the same program, 50° N 0° E. */
static void planets_are_where_others_say(void **state)
{
    (void)state;
    static const struct {
        double unix_s;
        double at[PEL_PLANETS][3]; /* azimuth, elevation, magnitude */
    } rows[] = {
        { 1767225600,
          { { 1.2488, -63.6188, -3.79 },
            { 353.3635, -63.6006, 1.26 },
            { 156.1695, 60.3114, -2.51 },
            { 277.9308, -11.2700, 1.16 } } },
        { 1900000000,
          { { 291.9194, -36.7950, -4.27 },
            { 256.9644, 17.1498, 1.29 },
            { 43.3543, -52.0973, -2.11 },
            { 229.8876, 46.9477, 0.26 } } },
        { 946728000,
          { { 219.2339, 12.7535, -3.94 },
            { 129.9560, 13.1245, 1.05 },
            { 74.2239, -1.8878, -2.39 },
            { 60.0576, -7.4792, 0.14 } } },
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct pel_night_sky sky;
        pel_ephemeris_night(rows[i].unix_s, 50 * PEL_DEG, 0, &sky);
        for (size_t k = 0; k < PEL_PLANETS; k++) {
            const double *want = rows[i].at[k];
            double a = want[0] * PEL_DEG, e = want[1] * PEL_DEG;
            struct pel_vec3 to = pel_mat3_apply(&sky.local, sky.planets[k].to);
            const struct pel_vec3 off = { to.x - cos(e) * sin(a),
                                          to.y - cos(e) * cos(a),
                                          to.z - sin(e) };
            /* Aberration: 0.006. */
            near(sqrt(pel_vec3_dot(off, off)) / PEL_DEG, 0, 0.012);
            /* Jupiter's magnitude 1.0 is -9.40 or, in older tables, -9.25. */
            near(sky.planets[k].magnitude, want[2], 0.2);
        }
    }
}

static void utc_texts(void **state)
{
    (void)state;
    double unix_s;
    near(utc("1970-01-01T00:00:00Z"), 0, 0);
    near(utc("2026-06-21T12:00:00.5Z"), 1782043200.5, 1e-6);
    near(utc("2026-06-21T14:00:00+02:00"), 1782043200, 0);
    const char *const bad[] = { "", "now", "2026-06-21", "2026-13-01T00:00:00Z",
                                "2026-06-21T12:00:00" };
    for (size_t i = 0; i < 5; i++) {
        assert_int_equal(pel_utc_parse(bad[i], &unix_s), PEL_ERR_INVALID);
    }
    assert_int_equal(pel_utc_parse("2250-01-01T00:00:00Z", &unix_s),
                     PEL_ERR_OUT_OF_RANGE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_published_geodesic),
        cmocka_unit_test(places_come_back),
        cmocka_unit_test(everywhere_is_finite),
        cmocka_unit_test(north_turns_with_longitude),
        cmocka_unit_test(ships_turn_in_circles),
        cmocka_unit_test(the_sun_is_where_others_say),
        cmocka_unit_test(the_moon_is_where_others_say),
        cmocka_unit_test(planets_are_where_others_say),
        cmocka_unit_test(utc_texts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
