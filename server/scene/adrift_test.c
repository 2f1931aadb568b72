#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "scene/reckon.h"
#include "scene/scene_testkit.h"

/* Wind 10 m/s from the west, a boat that drifts and one of each that is moored;
 * the clock stands at 50 s. */
static const char things[] =
    "{\"clock\":{\"mode\":\"STEPPED\",\"time\":50},"
    "\"sea\":{\"windSpeed\":10,\"windDirection\":270},\"entities\":{"
    "\"5\":{\"name\":\"boat\",\"model\":{\"name\":\"rib\"},\"afloat\":true,"
    "\"leeway\":0.03},"
    "\"6\":{\"name\":\"yacht\",\"model\":{\"name\":\"sailing-yacht\"},"
    "\"afloat\":true,\"mooring\":40},"
    "\"7\":{\"name\":\"buoy\",\"heading\":123,\"afloat\":true,"
    "\"model\":{\"name\":\"safe-water\"},\"mooring\":15}}}";

static struct pel_scene *begin(void)
{
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 40 });
    assert_int_equal(patch(scene, things, NULL), PEL_OK);
    return scene;
}

static void go(struct pel_scene *scene, double time_s)
{
    assert_int_equal(pel_scene_step_to(scene, time_s, NULL), PEL_OK);
}

/* 1: the boat, 2: the yacht, 3: the buoy. */
static struct pel_entity_state at(struct pel_scene *scene, size_t index,
                                  double time_s)
{
    struct pel_entity_state e;
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    pel_snapshot_entity_at(s, index, time_s, &e);
    pel_snapshot_unref(s);
    return e;
}

static void assert_place(struct pel_scene *scene, double time_s, double east_m,
                         double north_m)
{
    struct pel_entity_state e = at(scene, 1, time_s);
    /* degrees of the state are exact to a nanometre's thousandth part */
    assert_near(e.east_m, east_m, 1e-6);
    assert_near(e.north_m, north_m, 1e-6);
}

static void drifts_with_the_wind(void **state)
{
    (void)state;
    struct pel_scene *scene = begin();
    assert_place(scene, 50, 0, 0);
    assert_place(scene, 60, 3, 0);
    go(scene, 2050); /* past clock.reckoning: nothing is stale of it */
    assert_place(scene, 2050, 600, 0);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    assert_int_equal(pel_snapshot_stale(s, 2050), 0);
    pel_snapshot_unref(s);
    /* Another wind: from where it is, by any way of saying so. */
    assert_int_equal(patch(scene,
                           "{\"sea\":{\"windDirection\":180,\"windSpeed\":20}}",
                           NULL),
                     PEL_OK);
    assert_place(scene, 2050, 600, 0);
    go(scene, 2100);
    assert_place(scene, 2100, 600, 30);
    assert_int_equal(patch(scene, "{\"sea\":{\"windSpeed\":null}}", NULL),
                     PEL_OK); /* 8 m/s */
    assert_place(scene, 2200, 600, 54);
    /* The clock is set, the origin moves: the boat does not. */
    assert_int_equal(patch(scene, "{\"clock\":{\"time\":5}}", NULL), PEL_OK);
    assert_place(scene, 5, 600, 30);
    /* Another leeway counts from now on. */
    go(scene, 105);
    assert_int_equal(
        patch(scene, "{\"entities\":{\"5\":{\"leeway\":0.01}}}", NULL), PEL_OK);
    assert_place(scene, 105, 600, 54);
    assert_place(scene, 205, 600, 62);
    go(scene, 205);
    assert_int_equal(
        patch(scene, "{\"entities\":{\"5\":{\"afloat\":false}}}", NULL),
        PEL_OK);
    go(scene, 305);
    assert_place(scene, 305, 600, 62);
    pel_scene_destroy(scene);
}

/* A patch may take the wind or the plane away and touch a pose: what was before
 * it has moved the boat. */
static void what_moved_it_goes(void **state)
{
    (void)state;
    static const char *const patches[] = {
        "{\"sea\":null,\"entities\":{\"5\":{\"heading\":5}}}",
        "{\"origin\":null,\"entities\":{\"5\":{\"heading\":5}}}",
        "{\"sea\":null,\"entities\":{\"5\":{\"heading\":null}}}",
        "{\"clock\":null,\"sea\":null,\"entities\":{\"5\":{\"speed\":0}}}",
        "{\"sea\":null,\"entities\":{\"5\":{\"poseTime\":150}}}",
    };
    for (size_t i = 0; i < sizeof patches / sizeof patches[0]; i++) {
        struct pel_scene *scene = begin();
        go(scene, 150);
        must(scene, patches[i]);
        double now_s = pel_scene_state(scene)->clock->time;
        struct pel_entity_state e = at(scene, 1, now_s);
        assert_near(e.east_m, 30, 0.01); /* where the clock runs again */
        assert_near(e.north_m, 0, 0.01);
        pel_scene_destroy(scene);
    }
}

static void swings_in_its_circle(void **state)
{
    (void)state;
    struct pel_scene *scene = begin();
    double least = 1e9, most = 0, widest = 0;
    for (int i = 0; i < 2000; i++) {
        double t = 50 + 3.7 * i;
        struct pel_entity_state yacht = at(scene, 2, t), buoy = at(scene, 3, t);
        double r = hypot(yacht.east_m, yacht.north_m);
        least = fmin(least, r);
        most = fmax(most, r);
        widest = fmax(widest, fabs(atan2(yacht.north_m, yacht.east_m)));
        /* her bow points to the anchor */
        assert_near(yacht.east_m + r * sin(yacht.heading_rad), 0, 1e-9);
        assert_near(yacht.north_m + r * cos(yacht.heading_rad), 0, 1e-9);
        assert_true(hypot(buoy.east_m, buoy.north_m) <= 15);
        assert_near(buoy.heading_rad, 123 * PEL_DEG, 1e-12);
        assert_true(buoy.east_m > 0); /* downwind */
    }
    /* 40 m of 100 / 125, a tenth in and out of it */
    assert_near(most, 32, 0.1);
    assert_near(least, 32 * 0.9 / 1.1, 0.1);
    assert_true(widest > 24 * PEL_DEG && widest <= 29 * PEL_DEG);
    /* Without wind it lies over its anchor. */
    assert_int_equal(patch(scene, "{\"sea\":{\"windSpeed\":0}}", NULL), PEL_OK);
    assert_near(at(scene, 2, 77).east_m, 0, 0);
    pel_scene_destroy(scene);
}

/* Forwards, backwards, in a second scene whose clock went there another way. */
static void any_order_is_the_same(void **state)
{
    (void)state;
    struct pel_scene *a = begin(), *b = begin();
    for (int i = 0; i < 60; i++) {
        go(a, 51 + i);
    }
    go(b, 110);
    for (size_t k = 1; k <= 3; k++) {
        for (int i = 0; i < 100; i++) {
            struct pel_entity_state x = at(a, k, 50 + 7 * i);
            struct pel_entity_state y = at(b, k, 50 + 7 * i);
            assert_memory_equal(&x.east_m, &y.east_m, 6 * sizeof x.east_m);
        }
        struct pel_entity_state x = at(a, k, 99), y = at(a, k, 99);
        assert_memory_equal(&x.east_m, &y.east_m, 6 * sizeof x.east_m);
    }
    pel_scene_destroy(a);
    pel_scene_destroy(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(drifts_with_the_wind),
        cmocka_unit_test(what_moved_it_goes),
        cmocka_unit_test(swings_in_its_circle),
        cmocka_unit_test(any_order_is_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
