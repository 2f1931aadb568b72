#include "scene/place.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include <libnova/julian_day.h>
#include <libnova/precession.h>
#include <libnova/solar.h>
#include <libnova/transform.h>

#include "optics/moon.h"
#include "scene/ephemeris.h"
#include "scene/geodesy.h"
#include "scene/scene_testkit.h"
#include "scene/snapshot.h"
#include "scene/waypoints.h"

static void near(double got, double want, double tolerance)
{
    if (!(fabs(got - want) <= tolerance)) {
        fail_msg("%.12g is not %.12g ± %g", got, want, tolerance);
    }
}

static double apart_deg(struct pel_vec3 a, struct pel_vec3 b)
{
    struct pel_vec3 c = pel_vec3_cross(a, b);
    return atan2(sqrt(pel_vec3_dot(c, c)), pel_vec3_dot(a, b)) / PEL_DEG;
}

static struct pel_vec3 towards(double azimuth_rad, double elevation_rad)
{
    return (struct pel_vec3){ sin(azimuth_rad) * cos(elevation_rad),
                              cos(azimuth_rad) * cos(elevation_rad),
                              sin(elevation_rad) };
}

static const struct pel_snapshot *snapshot_of(const char *json)
{
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 60 });
    must(scene, json);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    pel_scene_destroy(scene);
    return s;
}

static const struct {
    double lat, lon;
} origins[] = { { 52.6, 5.2 }, { 0, 180 }, { 85, -70 },
                { 89.9, 30 },  { 90, 0 },  { -90, 12 } },
  places[] = { { 52.61, 5.21 }, { 20.5, -157 }, { 70.5, 18 },  { 89, 0 },
               { 90, 45 },      { 0, 179.99 },  { 0, -179.9 }, { -77, 166 },
               { 84.9, -69 },   { -89.95, 80 } };
#define ORIGINS (sizeof origins / sizeof *origins)
#define PLACES (sizeof places / sizeof *places)

/* Closed forms, and there and back. */
static void the_earth_is_the_ellipsoid(void **state)
{
    (void)state;
    struct pel_vec3 p = pel_geo_earth(0, 90, 100);
    near(p.y, 6378237, 1e-8);
    p = pel_geo_earth(90, 0, 0);
    near(p.z, 6356752.314245, 1e-6);
    for (size_t i = 0; i < PLACES; i++) {
        for (double h = -100; h <= 1e7; h = h < 0 ? 0 : h * 10 + 1) {
            double lat, lon, height;
            p = pel_geo_earth(places[i].lat, places[i].lon, h);
            pel_geo_of_earth(p, &lat, &lon, &height);
            struct pel_vec3 back = pel_geo_earth(lat, lon, height);
            near(hypot(hypot(back.x - p.x, back.y - p.y), back.z - p.z), 0,
                 1e-8);
            near(height, h, 1e-8);
        }
    }
}

/* Axes are carried along the geodesic: along its own direction the local frame
 * and the true one differ by the turn. */
static void the_frame_turns_rigidly(void **state)
{
    (void)state;
    for (size_t i = 0; i < ORIGINS; i++) {
        for (size_t k = 0; k < PLACES; k++) {
            double lat0 = origins[i].lat, lon0 = origins[i].lon;
            double lat = places[k].lat, lon = places[k].lon;
            struct pel_mat3 m = pel_geo_local_axes(lat0, lon0, lat, lon);
            near(pel_vec3_dot(m.x, m.x), 1, 1e-12);
            near(pel_vec3_dot(m.x, m.y), 0, 1e-12);
            near(apart_deg(pel_vec3_cross(m.x, m.y), m.z), 0, 1e-6);
            /* What goes on straight from the origin does so in the map too. */
            double east, north, e2, n2;
            pel_geo_to_local(lat0, lon0, lat, lon, &east, &north);
            double r = hypot(east, north), s = (r - 10) / r;
            if (r < 100 || r > 1.9e7) {
                continue;
            }
            double la, lo, turn = pel_geo_turn(lat0, lon0, lat, lon);
            pel_geo_from_local(lat0, lon0, east * s, north * s, &la, &lo);
            pel_geo_to_local(lat, lon, la, lo, &e2, &n2);
            double true_rad = atan2(-e2, -n2), local_rad = atan2(east, north);
            /* Places are good to 1e-7 m of the 10. */
            near(remainder(local_rad - true_rad - turn, 2 * PEL_PI), 0, 1e-6);
        }
    }
    /* Within 100 km the map keeps lengths to 4e-5, angles to half of that. */
    near(pel_geo_turn(60, 5, 60.5, 6.5), pel_geo_convergence(60, 5, 60.5, 6.5),
         2.1e-5);
    near(pel_geo_turn(60, 5, 60, 5), 0, 1e-9);
}

/* libnova: VSOP87 with aberration, from J2000's equinox to that of date. */
static struct pel_vec3 novas_sun(double unix_s, double lat, double lon)
{
    struct ln_lnlat_posn at = { lon, lat };
    struct ln_equ_posn of_2000, sun;
    struct ln_hrz_posn seen;
    double jd = unix_s / 86400 + 2440587.5;
    ln_get_solar_equ_coords(jd + pel_ephemeris_delta_t(unix_s) / 86400,
                            &of_2000);
    ln_get_equ_prec(&of_2000, jd, &sun);
    ln_get_hrz_from_equ(&sun, &at, jd, &seen); /* from the south */
    return towards((seen.az + 180) * PEL_DEG, seen.alt * PEL_DEG);
}

/* In the local frame's axes at the place, from true ones. */
static struct pel_vec3 in_local(struct pel_vec3 v, double turned)
{
    double s = sin(turned), c = cos(turned);
    return (struct pel_vec3){ v.x * c + v.y * s, v.y * c - v.x * s, v.z };
}

static void the_sky_is_that_of_the_place(void **state)
{
    (void)state;
    static const char *const moments[] = { "2026-06-21T20:00:00Z",
                                           "2026-12-03T03:10:00Z",
                                           "2041-03-20T11:00:00Z" };
    double worst_sun = 0, worst_moon = 0, worst_star = 0;
    for (size_t t = 0; t < 3; t++) {
        for (size_t i = 0; i < ORIGINS; i++) {
            char json[160];
            snprintf(json, sizeof json,
                     "{\"clock\":{\"utc\":\"%s\"},\"origin\":{\"latitude\":%g,"
                     "\"longitude\":%g}}",
                     moments[t], origins[i].lat, origins[i].lon);
            const struct pel_snapshot *s = snapshot_of(json);
            for (size_t k = 0; k < PLACES; k++) {
                double east, north;
                struct pel_place p;
                pel_geo_to_local(origins[i].lat, origins[i].lon, places[k].lat,
                                 places[k].lon, &east, &north);
                pel_place_of(s, east, north, &p);
                if (p.origin) {
                    continue;
                }
                struct pel_light lights[PEL_LIGHTS];
                struct pel_moon_place moon;
                pel_place_lights(s, 0, &p, lights);
                struct pel_vec3 sun = in_local(
                    novas_sun(s->epoch_unix_s, p.latitude, p.longitude),
                    p.turned_rad);
                worst_sun = fmax(
                    worst_sun, apart_deg(lights[PEL_LIGHT_SUN].direction, sun));
                pel_ephemeris_moon(s->epoch_unix_s, p.latitude * PEL_DEG,
                                   p.longitude * PEL_DEG, &moon);
                const struct pel_light *seen = &lights[PEL_LIGHT_MOON];
                worst_moon =
                    fmax(worst_moon,
                         apart_deg(seen->direction,
                                   in_local(moon.direction, p.turned_rad)));
                near(PEL_MOON_RADIUS / sin(seen->radius_rad), moon.distance_m,
                     1);
                struct pel_mat3 sky =
                    pel_ephemeris_sky(s->epoch_unix_s, p.latitude * PEL_DEG,
                                      p.longitude * PEL_DEG);
                struct pel_mat3 here =
                    pel_ephemeris_sky(s->epoch_unix_s, s->origin_latitude_rad,
                                      s->origin_longitude_rad);
                worst_star = fmax(worst_star,
                                  apart_deg(pel_mat3_apply(&p.turned, here.x),
                                            in_local(sky.x, p.turned_rad)));
            }
            pel_snapshot_unref(s);
        }
    }
    printf("# Sun off libnova's by %.4f deg, Moon %.1e, stars %.1e off what is "
           "computed there\n",
           worst_sun, worst_moon, worst_star);
    assert_true(worst_sun < 0.01);
    assert_true(worst_moon < 1e-6);
    assert_true(worst_star < 1e-6);
}

/* In the zenith of the origin, it stands lower elsewhere by the angle between
 * the two verticals. */
static void a_fixed_sun_is_fixed_at_the_origin(void **state)
{
    (void)state;
    const struct pel_snapshot *s =
        snapshot_of("{\"origin\":{\"latitude\":0,\"longitude\":170},"
                    "\"sky\":{\"sunElevation\":90,\"sunAzimuth\":0}}");
    struct pel_place p;
    double east, north;
    pel_geo_to_local(0, 170, 0, -170, &east, &north);
    pel_place_of(s, east, north, &p);
    struct pel_vec3 sun = pel_place_sun(s, 0, &p);
    /* Parallax: 0.0008 deg. */
    near(asin(sun.z) / PEL_DEG, 70, 0.001);
    near(atan2(sun.x, sun.y) / PEL_DEG, -90, 1e-6);
    struct pel_light lights[PEL_LIGHTS];
    pel_place_lights(s, 0, &p, lights);
    near(lights[PEL_LIGHT_MOON].direction.z, -1, 0); /* there is none */
    /* Near the origin nothing is turned, to the bit. */
    pel_place_of(s, 499, -499, &p);
    assert_true(p.origin);
    sun = pel_place_sun(s, 0, &p);
    near(sun.z, pel_snapshot_sun(s, 0).z, 0);
    pel_snapshot_unref(s);
}

/* --- cameras ----------------------------------------------------------------
 */

static const struct pel_snapshot *view_of(const char *origin, const char *view)
{
    char json[1024];
    snprintf(json, sizeof json,
             "{\"origin\":{%s},\"entities\":{\"1\":{%s}},"
             "\"views\":{\"bridge\":{\"entity\":null,%s}}}",
             origin, origin, view);
    return snapshot_of(json);
}

static struct pel_camera camera_at(const struct pel_snapshot *s, double time_s)
{
    struct pel_camera c;
    pel_snapshot_camera(s, 0, time_s, 0, 0, &c);
    return c;
}

static struct pel_vec3 ahead_of(const struct pel_camera *c)
{
    return pel_vec3_scale(c->world_from_camera.z, -1);
}

/* On Earth, and the axes there. */
static struct pel_vec3 on_earth(const struct pel_snapshot *s,
                                const struct pel_camera *c,
                                struct pel_mat3 *axes)
{
    double lat0 = s->origin_latitude_rad / PEL_DEG, lat;
    double lon0 = s->origin_longitude_rad / PEL_DEG, lon;
    pel_geo_from_local(lat0, lon0, c->east_m, c->north_m, &lat, &lon);
    *axes = pel_geo_local_axes(lat0, lon0, lat, lon);
    return pel_geo_earth(lat, lon, c->altitude_m);
}

#define HOLLAND "\"latitude\":52.6,\"longitude\":5.2"
#define POLE "\"latitude\":90,\"longitude\":0"

static void a_view_stands_at_a_place(void **state)
{
    (void)state;
    const struct pel_snapshot *s =
        view_of(HOLLAND, "\"forward\":7,\"right\":9,\"yaw\":30,\"at\":{"
                         "\"latitude\":53.3,\"longitude\":6.2,\"height\":40}");
    struct pel_camera c = camera_at(s, 3);
    double east, north;
    pel_geo_to_local(52.6, 5.2, 53.3, 6.2, &east, &north);
    near(c.east_m, east, 1e-6);
    near(c.north_m, north, 1e-6);
    near(c.altitude_m, 40, 0);
    struct pel_vec3 ahead = ahead_of(&c);
    near(remainder(atan2(ahead.x, ahead.y) - pel_geo_turn(52.6, 5.2, 53.3, 6.2),
                   2 * PEL_PI) /
             PEL_DEG,
         30, 1e-9);
    pel_snapshot_unref(s);
    /* Without a height: up. The pole's north is by its longitude. */
    s = view_of(POLE, "\"up\":3,\"at\":{\"latitude\":90,\"longitude\":-90}");
    c = camera_at(s, 0);
    near(c.altitude_m, 3, 0);
    near(hypot(c.east_m, c.north_m), 0, 1e-6);
    ahead = ahead_of(&c); /* along 90 E, east of the frame of 0 E is ... */
    struct pel_mat3 axes = pel_geo_axes(90, 0);
    struct pel_vec3 on = pel_mat3_apply(&axes, ahead);
    near(on.x, 0, 1e-7);
    near(on.y, 1, 1e-7); /* beyond the pole, on 90 E */
    pel_snapshot_unref(s);
}

static void a_view_looks_at_things(void **state)
{
    (void)state;
    static const struct {
        const char *json;
        double lat, lon, height;
    } rows[] = {
        /* A tanker's mast 20 km away, a place below, one far beyond the
         * horizon from space, over the pole and the date line. */
        { "\"up\":20,\"lookAt\":{\"latitude\":52.7,\"longitude\":5.4,"
          "\"height\":30}",
          52.7, 5.4, 30 },
        { "\"up\":200,\"lookAt\":{\"latitude\":52.6001,\"longitude\":5.2001}",
          52.6001, 5.2001, 0 },
        { "\"at\":{\"latitude\":60,\"longitude\":-150,\"height\":4e5},"
          "\"lookAt\":{\"latitude\":60,\"longitude\":-140}",
          60, -140, 0 },
        { "\"at\":{\"latitude\":89.9,\"longitude\":0,\"height\":1e6},"
          "\"lookAt\":{\"latitude\":80,\"longitude\":180}",
          80, 180, 0 },
        { "\"at\":{\"latitude\":10,\"longitude\":179,\"height\":1e6},"
          "\"lookAt\":{\"latitude\":10,\"longitude\":-179}",
          10, -179, 0 },
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct pel_snapshot *s = view_of(HOLLAND, rows[i].json);
        struct pel_camera c = camera_at(s, 0);
        struct pel_mat3 axes;
        struct pel_vec3 eye = on_earth(s, &c, &axes);
        struct pel_vec3 to = pel_vec3_add(
            pel_geo_earth(rows[i].lat, rows[i].lon, rows[i].height),
            pel_vec3_scale(eye, -1));
        /* Near ones are aimed at where they are drawn, on a globe of 6360 km:
         * 20 km away 0.0002 deg lower than on the ellipsoid. */
        near(apart_deg(pel_mat3_apply(&axes, ahead_of(&c)), to), 0,
             i < 2 ? 5e-4 : 1e-9);
        near(c.world_from_camera.x.z, 0, 1e-12); /* level */
        pel_snapshot_unref(s);
    }
    /* yaw, pitch and roll come after it. */
    const struct pel_snapshot *s =
        view_of(HOLLAND, "\"up\":0,\"yaw\":10,\"lookAt\":{\"latitude\":52.6,"
                         "\"longitude\":5.3}");
    struct pel_camera c = camera_at(s, 0);
    struct pel_vec3 ahead = ahead_of(&c);
    near(atan2(ahead.x, ahead.y) / PEL_DEG, 100, 0.05);
    pel_snapshot_unref(s);
    /* An entity that it passes. */
    s = snapshot_of("{\"entities\":{\"1\":{\"speed\":10,\"course\":90},"
                    "\"2\":{\"latitude\":52.61,\"longitude\":5.2}},"
                    "\"views\":{\"bridge\":{\"up\":0,\"lookAt\":{"
                    "\"entity\":2}}}}");
    c = camera_at(s, 50);
    ahead = ahead_of(&c);
    near(atan2(ahead.x, ahead.y), atan2(-500, 1112.74), 1e-4);
    pel_snapshot_unref(s);
}

static void a_view_circles(void **state)
{
    (void)state;
    const struct pel_snapshot *s = view_of(
        POLE, "\"orbit\":{\"latitude\":89.999,\"longitude\":20,"
              "\"height\":5,\"radius\":800,\"elevation\":30,\"azimuth\":40,"
              "\"period\":60}");
    struct pel_vec3 middle = pel_geo_earth(89.999, 20, 5);
    struct pel_mat3 there = pel_geo_axes(89.999, 20), axes;
    for (double t = 0; t < 60; t += 7) {
        struct pel_camera c = camera_at(s, t);
        struct pel_vec3 eye = on_earth(s, &c, &axes);
        struct pel_vec3 arm = pel_vec3_add(eye, pel_vec3_scale(middle, -1));
        double e = pel_vec3_dot(arm, there.x), n = pel_vec3_dot(arm, there.y);
        near(sqrt(pel_vec3_dot(arm, arm)), 800, 1e-6);
        near(asin(pel_vec3_dot(arm, there.z) / 800) / PEL_DEG, 30, 1e-6);
        near(remainder(atan2(e, n) / PEL_DEG - 40 - 6 * t, 360), 0, 1e-6);
        near(apart_deg(pel_mat3_apply(&axes, ahead_of(&c)),
                       pel_vec3_scale(arm, -1)),
             0, 5e-4);
        /* 2 pi r cos 30 / T */
        struct pel_vec3 v = c.velocity_mps;
        near(sqrt(pel_vec3_dot(v, v)), 2 * PEL_PI * 692.8203 / 60, 0.01);
    }
    /* Again after a turn, however late; the other way round; none. */
    struct pel_camera a = camera_at(s, 13), b = camera_at(s, 13 + 6e8);
    near(a.east_m, b.east_m, 1e-4);
    pel_snapshot_unref(s);
    s = view_of(HOLLAND, "\"orbit\":{\"entity\":1,\"radius\":100,"
                         "\"elevation\":0,\"azimuth\":90,\"period\":-40}");
    a = camera_at(s, 10);
    near(a.north_m, 100, 0.01);
    pel_snapshot_unref(s);
    s = view_of(HOLLAND, "\"orbit\":{\"entity\":1,\"radius\":100,"
                         "\"elevation\":90}");
    a = camera_at(s, 10);
    near(a.altitude_m, 100, 0.01);
    near(ahead_of(&a).z, -1, 1e-9);
    near(a.world_from_camera.y.y, 1, 1e-4); /* north is up */
    pel_snapshot_unref(s);
}

static void a_view_goes_with_a_satellite(void **state)
{
    (void)state;
    const struct pel_snapshot *s =
        view_of(HOLLAND, "\"satellite\":{\"inclination\":51.6,\"node\":30}");
    struct pel_camera c = camera_at(s, 0);
    struct pel_mat3 axes;
    struct pel_vec3 eye = on_earth(s, &c, &axes);
    near(atan2(eye.y, eye.x) / PEL_DEG, 30, 1e-7);
    near(eye.z, 0, 1e-3);
    near(c.altitude_m, 4e5, 0);
    /* Kepler: 92.4 min at 400 km, and the Earth turns 23.2 deg meanwhile. */
    double r = 6371008.8 + 4e5;
    double period = 2 * PEL_PI * sqrt(r * r * r / 3.986004418e14);
    near(period / 60, 92.4, 0.1);
    c = camera_at(s, period);
    eye = on_earth(s, &c, &axes);
    near(atan2(eye.y, eye.x) / PEL_DEG, 30 - 360 * period / 86164.0989, 1e-4);
    /* A quarter on it is as far north as it comes, and goes east. */
    c = camera_at(s, period / 4);
    on_earth(s, &c, &axes);
    near(pel_vec3_dot(pel_mat3_apply(&axes, ahead_of(&c)),
                      (struct pel_vec3){ 0, 0, 1 }),
         0, 1e-4);
    pel_snapshot_unref(s);
}

#define KEY(t, lat, lon, h, heading, pitch)                                    \
    "{\"time\":" #t ",\"latitude\":" #lat ",\"longitude\":" #lon               \
    ",\"height\":" #h ",\"heading\":" #heading ",\"pitch\":" #pitch "}"

static void a_view_goes_a_way(void **state)
{
    (void)state;
    const struct pel_snapshot *s = view_of(
        HOLLAND, "\"waypoints\":[" KEY(10, 52.6, 5.2, 2, 350, 0) "," KEY(
                     40, 52.6, 5.2, 400000, 10, -60) "]");
    /* Evenly in the logarithm: asinh, which is it to 6 % at 2 m. */
    for (double t = 0; t <= 50; t += 1) {
        double part = pel_clamp((t - 10) / 30, 0, 1);
        struct pel_camera c = camera_at(s, t);
        near(asinh(c.altitude_m), asinh(2) + part * (asinh(4e5) - asinh(2)),
             1e-9);
        near(hypot(c.east_m, c.north_m), 0, 1e-6);
        struct pel_vec3 ahead = ahead_of(&c);
        near(remainder(atan2(ahead.x, ahead.y) / PEL_DEG - (-10 + 20 * part),
                       360),
             0, 1e-5); /* over north, not the long way */
        near(asin(ahead.z) / PEL_DEG, -60 * part, 1e-9);
    }
    pel_snapshot_unref(s);
    /* Through each, over pole and date line, no height beyond its ends. */
    s = view_of(HOLLAND, "\"waypoints\":[" KEY(0, 80, 170, 100, 0, 0) "," KEY(
                             100, 89, 180, 100, 0,
                             0) "," KEY(200, 80, -5, 5000, 0,
                                        0) "," KEY(300, 70, -170, 5, 0, 0) "]");
    static const double lats[] = { 80, 89, 80, 70 };
    static const double lons[] = { 170, 180, -5, -170 };
    for (int i = 0; i < 4; i++) {
        struct pel_camera c = camera_at(s, 100 * i);
        struct pel_mat3 axes;
        struct pel_vec3 at = on_earth(s, &c, &axes);
        struct pel_vec3 want = pel_geo_earth(lats[i], lons[i], c.altitude_m);
        near(apart_deg(at, want), 0, 1e-9);
    }
    struct pel_vec3 before = { 0 };
    for (double t = 0; t <= 300; t += 0.25) {
        struct pel_camera c = camera_at(s, t);
        struct pel_mat3 axes;
        struct pel_vec3 at = on_earth(s, &c, &axes);
        assert_true(c.altitude_m > 5 - 1e-6 && c.altitude_m < 5000 + 1e-6);
        if (t > 0) { /* no leap: 4500 km in 100 s is 11 km in 0.25 s */
            assert_true(apart_deg(at, before) < 0.4);
        }
        before = at;
    }
    pel_snapshot_unref(s);
}

/* Order and restarts: the same bits. */
static void places_are_functions_of_time(void **state)
{
    (void)state;
    static const char *const views[] = {
        "\"orbit\":{\"entity\":1,\"period\":77}",
        "\"satellite\":{\"inclination\":98}",
        "\"waypoints\":[" KEY(0, 10, 179, 2, 0, 0) "," KEY(
            50, 12, -179, 90, 0, 0) "," KEY(99, 12, -175, 1e6, 0, 0) "]",
    };
    for (size_t i = 0; i < 3; i++) {
        const struct pel_snapshot *a = view_of(HOLLAND, views[i]);
        const struct pel_snapshot *b = view_of(HOLLAND, views[i]);
        static const double times[] = { 50, 3, 99, 0, 27.5, 50, 3 };
        struct pel_camera first[7];
        for (int k = 0; k < 7; k++) {
            first[k] = camera_at(a, times[k]);
        }
        for (int k = 6; k >= 0; k--) {
            struct pel_camera c = camera_at(b, times[k]);
            assert_memory_equal(&c.east_m, &first[k].east_m, 8);
            assert_memory_equal(&c.world_from_camera,
                                &first[k].world_from_camera,
                                sizeof c.world_from_camera);
        }
        pel_snapshot_unref(a);
        pel_snapshot_unref(b);
    }
}

static void what_is_not_whole_is_refused(void **state)
{
    (void)state;
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 60 });
#define AT "\"at\":{\"latitude\":1,\"longitude\":2}"
    static const struct {
        const char *view, *path;
        enum pel_err err;
    } rows[] = {
        { AT, "at", PEL_ERR_CONFLICT }, /* it is on entity 1 */
        { "\"entity\":null,\"at\":{\"latitude\":1}", "at", PEL_ERR_INVALID },
        { "\"entity\":null,\"at\":{\"latitude\":90.1,\"longitude\":0}",
          "at.latitude", PEL_ERR_OUT_OF_RANGE },
        { "\"entity\":null," AT ",\"satellite\":{}", "satellite",
          PEL_ERR_CONFLICT },
        { "\"orbit\":{\"entity\":1}", "orbit", PEL_ERR_CONFLICT },
        { "\"entity\":null,\"orbit\":{\"entity\":9}", "orbit.entity",
          PEL_ERR_CONFLICT },
        { "\"entity\":null,\"orbit\":{\"radius\":9}", "orbit",
          PEL_ERR_INVALID },
        { "\"entity\":null,\"orbit\":{\"entity\":1,\"period\":0}",
          "orbit.period", PEL_ERR_INVALID },
        { "\"lookAt\":{\"entity\":1,\"latitude\":3}", "lookAt",
          PEL_ERR_CONFLICT },
        { "\"lookAt\":{\"longitude\":3}", "lookAt", PEL_ERR_INVALID },
        { "\"lookAt\":{\"entity\":77}", "lookAt.entity", PEL_ERR_CONFLICT },
        { "\"entity\":null,\"waypoints\":[{\"latitude\":1}]", "waypoints.0",
          PEL_ERR_INVALID },
        { "\"entity\":null,\"waypoints\":[" KEY(5, 0, 0, 9, 0, 0) "," KEY(
              5, 0, 0, 9, 0, 0) "]",
          "waypoints.1.time", PEL_ERR_INVALID },
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char json[512], path[96];
        struct pel_fault fault;
        snprintf(json, sizeof json, "{\"views\":{\"bridge\":{%s}}}",
                 rows[i].view);
        snprintf(path, sizeof path, "views.bridge.%s", rows[i].path);
        enum pel_err err = patch(scene, json, &fault);
        if (err != rows[i].err || strcmp(fault.path, path) != 0) {
            fail_msg("%s: %s at %s: %s", rows[i].view, pel_err_name(err),
                     fault.path, fault.message);
        }
        assert_true(pel_scene_state(scene)->views[0]->has_entity); /* none */
    }
    must(scene, "{\"views\":{\"bridge\":{\"entity\":null," AT "}}}");
    must(scene, "{\"views\":{\"bridge\":{\"entity\":1,\"at\":null}}}");
    /* Entities that are looked at stay. */
    must(scene, "{\"entities\":{\"2\":{}},\"views\":{\"bridge\":{"
                "\"lookAt\":{\"entity\":2}}}}");
    assert_int_equal(patch(scene, "{\"entities\":{\"2\":null}}", NULL),
                     PEL_ERR_CONFLICT);
    pel_scene_destroy(scene);
}

/* What lies beside an eye far from the origin is seen where it is; the map has
 * it elsewhere by a tenth. */
static void far_places_see_things_where_they_are(void **state)
{
    (void)state;
    const struct pel_snapshot *s = snapshot_of(
        "{\"entities\":{\"1\":{\"latitude\":10,\"longitude\":-40,"
        "\"heading\":30},\"2\":{\"latitude\":10.01,\"longitude\":-40.01,"
        "\"heading\":60}}}");
    struct pel_entity_state own, other;
    struct pel_place p;
    pel_snapshot_entity_level(s, 0, 0, &own);
    pel_place_of(s, own.east_m, own.north_m, &p);
    assert_true(p.far);
    pel_snapshot_entity_seen(s, 1, 0, false, &p, &other);
    double east, north;
    pel_geo_to_local(10, -40, 10.01, -40.01, &east, &north);
    struct pel_vec3 want =
        in_local((struct pel_vec3){ east, north, 0 }, p.turned_rad);
    near(other.east_m - p.east_m, want.x, 1e-3);
    near(other.north_m - p.north_m, want.y, 1e-3);
    near(remainder(other.heading_rad - p.turned_rad - 60 * PEL_DEG, 2 * PEL_PI),
         0, 1e-4);
    /* The camera on own ship looks along its true heading. */
    struct pel_camera c = camera_at(s, 0);
    struct pel_vec3 ahead = ahead_of(&c);
    near(remainder(atan2(ahead.x, ahead.y) - p.turned_rad - 30 * PEL_DEG,
                   2 * PEL_PI),
         0, 1e-6);
    pel_snapshot_entity_level(s, 1, 0, &other);
    assert_true(hypot(other.east_m - p.east_m - want.x,
                      other.north_m - p.north_m - want.y) > 30);
    pel_snapshot_unref(s);
}

static void meters_have_one_light(void **state)
{
    (void)state;
    const struct pel_snapshot *s = snapshot_of(
        "{\"views\":{\"bridge\":{\"meter\":\"m\"},\"b\":{\"entity\":1,"
        "\"meter\":\"m\"},\"c\":{\"meter\":\"m\",\"at\":{\"latitude\":0,"
        "\"longitude\":0}}}}");
    struct pel_camera c;
    pel_snapshot_camera(s, 0, 0, 0, 0, &c);
    assert_int_equal(c.sight_count, 2);
    pel_snapshot_camera(s, 2, 0, 0, 0, &c);
    assert_int_equal(c.sight_count, 1);
    pel_snapshot_unref(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_earth_is_the_ellipsoid),
        cmocka_unit_test(the_frame_turns_rigidly),
        cmocka_unit_test(the_sky_is_that_of_the_place),
        cmocka_unit_test(a_fixed_sun_is_fixed_at_the_origin),
        cmocka_unit_test(a_view_stands_at_a_place),
        cmocka_unit_test(a_view_looks_at_things),
        cmocka_unit_test(a_view_circles),
        cmocka_unit_test(a_view_goes_with_a_satellite),
        cmocka_unit_test(a_view_goes_a_way),
        cmocka_unit_test(places_are_functions_of_time),
        cmocka_unit_test(what_is_not_whole_is_refused),
        cmocka_unit_test(far_places_see_things_where_they_are),
        cmocka_unit_test(meters_have_one_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
