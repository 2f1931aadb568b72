/* Ship waves as the scene has them. */
#include "scene/wakes.h"

#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/vec.h"
#include "scene/scene_testkit.h"
#include "scene/wakepasts.h"
#include "scene/washes.h"

/* A ship of 100 m that goes north at 12 knots from 1200 m south of the origin,
 * over a calm sea. */
static const char ship[] =
    "{\"clock\":{\"mode\":\"STEPPED\",\"time\":0,\"reckoning\":3600},"
    "\"sea\":{\"windSpeed\":0,\"whitecaps\":0,\"synthesiser\":\"TROCHOIDS\"},"
    "\"entities\":{"
    "\"5\":{\"latitude\":-0.0108,\"longitude\":0,\"speed\":6.17,\"wake\":true,"
    "\"model\":{\"name\":\"tanker\",\"length\":100}}}}";

static struct pel_scene *begin(void)
{
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 40 });
    must(scene, "{\"origin\":{\"latitude\":0,\"longitude\":0}}");
    must(scene, ship);
    return scene;
}

/* What takes milliseconds is left to threads, as with an FFT sea. */
static void control_leaves_it_to_others(void **state)
{
    (void)state;
    struct pel_scene *scene = begin();
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    assert_non_null(s->wakes);
    assert_true(pel_snapshot_transforms(s));
    pel_snapshot_unref(s);
    must(scene, "{\"entities\":{\"5\":{\"wake\":false}}}");
    s = pel_scene_snapshot(scene);
    assert_null(s->wakes);
    assert_false(pel_snapshot_transforms(s));
    pel_snapshot_unref(s);
    pel_scene_destroy(scene);
}

static void step(struct pel_scene *scene, double seconds)
{
    for (; seconds > 0; seconds -= 10) {
        assert_int_equal(pel_scene_step(scene, fmin(seconds, 10), NULL),
                         PEL_OK);
    }
}

enum { LINE = 160 };

/* Heights along a line that goes south from a place. */
static void line(struct pel_scene *scene, double time_s, double east_m,
                 double north_m, double heights[LINE])
{
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    struct pel_vec2 points[LINE];
    struct pel_surface_sample samples[LINE];
    for (int i = 0; i < LINE; i++) {
        points[i] = (struct pel_vec2){ east_m, north_m - i };
    }
    pel_snapshot_surface(s, points, LINE, time_s, false, samples);
    for (int i = 0; i < LINE; i++) {
        heights[i] = samples[i].height_m;
    }
    pel_snapshot_unref(s);
}

static double highest(const double heights[LINE])
{
    double most = 0;
    for (int i = 0; i < LINE; i++) {
        most = fmax(most, fabs(heights[i]));
    }
    return most;
}

/* Five ships of 100 m at 12 knots that turn, over a calm sea. */
static struct pel_scene *five(void)
{
    struct pel_scene *scene = begin();
    for (int i = 0; i < 5; i++) {
        char text[300];
        snprintf(text, sizeof text,
                 "{\"entities\":{\"%d\":{\"latitude\":%g,\"longitude\":0,"
                 "\"speed\":6.17,\"turnRate\":0.5,\"wake\":true,"
                 "\"model\":{\"name\":\"tanker\",\"length\":100}}}}",
                 5 + i, 0.004 * i);
        must(scene, text);
    }
    return scene;
}

/* In any order, by any way: the same bits; and what is kept is bounded. */
static void moments_in_any_order(void **state)
{
    (void)state;
    enum { MOMENTS = 12 };
    static double up[MOMENTS][LINE], down[MOMENTS][LINE];
    struct pel_scene *scene = five();
    double spent = 0, first = 0;
    for (int i = 0; i < MOMENTS; i++) {
        clock_t begun = clock();
        line(scene, 600 + 0.1 * i, 420, -560, up[i]);
        double ms = 1e3 * (double)(clock() - begun) / CLOCKS_PER_SEC;
        first = i ? first : ms;
        spent += i ? ms : 0;
        assert_true(pel_wakes_bytes() <= PEL_WAKES_MOST_BYTES);
    }
    print_message("five ships: first moment %.1f ms, others %.1f ms each, "
                  "%.1f MiB kept\n",
                  first, spent / (MOMENTS - 1),
                  (double)pel_wakes_bytes() / (1 << 20));
    assert_true(pel_wakes_bytes() > 0);
    line(scene, 600, 420, -560, down[0]);
    clock_t begun = clock();
    for (int i = 0; i < 20; i++) {
        line(scene, 600, 420, -560, down[0]);
    }
    print_message("a point of a moment at hand: %.2f us\n",
                  1e6 * (double)(clock() - begun) / CLOCKS_PER_SEC /
                      (20 * LINE));
    pel_scene_destroy(scene);
    scene = five();
    step(scene, 30);
    for (int i = MOMENTS - 1; i >= 0; i--) {
        line(scene, 600 + 0.1 * i, 420, -560, down[i]);
    }
    assert_true(highest(up[0]) > 0.05);
    assert_memory_equal(up, down, sizeof up);
    pel_scene_destroy(scene);
}

/* Of a few places only some tiles are made: they get the same bits as of whole
 * moments, and far from all ships none is made. */
static void moments_in_part(void **state)
{
    (void)state;
    struct pel_scene *scene = five();
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    int moved = 0;
    for (int k = 0; k < 40; k++) {
        double time_s = 300 + 0.1 * k;
        struct pel_vec2 place = { 40.0 * k, 150.0 * (k % 11) };
        struct pel_box of = { place, place };
        struct pel_wake_shift part, whole;
        const struct pel_wake_moment *m =
            pel_wakes_within(s->wakes, time_s, &of);
        (void)pel_wakes_before(m, PEL_WAKES_ALL, place, &part);
        pel_wake_moment_unref(m);
        m = pel_wakes_at(s->wakes, time_s);
        (void)pel_wakes_before(m, PEL_WAKES_ALL, place, &whole);
        pel_wake_moment_unref(m);
        assert_memory_equal(&part, &whole, sizeof part);
        moved += part.d.z != 0;
    }
    assert_true(moved > 10 && moved < 40);
    size_t before = pel_wakes_bytes();
    struct pel_box far = { { 1e5, 1e5 }, { 1.1e5, 1.1e5 } };
    pel_wake_moment_unref(pel_wakes_within(s->wakes, 304.5, &far));
    assert_true(pel_wakes_bytes() <= before);
    pel_snapshot_unref(s);
    pel_scene_destroy(scene);
}

/* Nobody who asks for one moment after the other waits for a past but the
 * first; also where the pose is edited between. */
static void pasts_are_made_ahead(void **state)
{
    (void)state;
    unsigned long awaited[3], ahead[3];
    struct pel_scene *scene = five();
    double heights[LINE];
    step(scene, 100);
    line(scene, 100, 0, -400, heights);
    pel_wake_kept_settle();
    pel_wake_kept_counts(&awaited[0], &ahead[0]);
    for (int i = 1; i <= 150; i++) {
        line(scene, 100 + 0.2 * i, 0, -400, heights);
        pel_wake_kept_settle();
    }
    pel_wake_kept_counts(&awaited[1], &ahead[1]);
    assert_int_equal(awaited[1], awaited[0]);
    /* every few seconds one of each of five */
    assert_true(ahead[1] - ahead[0] >= 5 * 5);
    assert_true(ahead[1] - ahead[0] <= 5 * 15);
    step(scene, 30);
    for (int i = 1; i <= 50; i++) {
        step(scene, 0.2);
        must(scene, "{\"entities\":{\"9\":{\"speed\":6.1}}}");
        line(scene, 130 + 0.2 * i, 0, -400, heights);
        pel_wake_kept_settle();
    }
    pel_wake_kept_counts(&awaited[2], &ahead[2]);
    /* the first edits lay the arc that it was reckoned along anew */
    assert_true(awaited[2] - awaited[1] <= 3);
    pel_scene_destroy(scene);
}

/* A ship that a host places with each of its frames. */
static void led_by_a_host(void **state)
{
    (void)state;
    struct pel_scene *scene = begin();
    double heights[LINE], before[LINE], spent = 0;
    int count = 0;
    for (double t = 100; t < 180; t += 0.25) {
        char text[200];
        snprintf(text, sizeof text,
                 "{\"entities\":{\"5\":{\"latitude\":%.9f,"
                 "\"longitude\":0}}}",
                 (6.17 * t - 1200) / 110574.0);
        assert_int_equal(pel_scene_step_to(scene, t, NULL), PEL_OK);
        must(scene, text);
        memcpy(before, heights, sizeof before);
        if (t > 150) {
            clock_t begun = clock();
            line(scene, t, 0, -450 + 6.17 * (t - 150), heights);
            spent += (double)(clock() - begun) / CLOCKS_PER_SEC;
            count++;
            /* at a ship's place of its waves: they stand before it */
            for (int i = 0; i < LINE && t > 151; i++) {
                assert_near(heights[i], before[i], 0.15);
            }
        }
    }
    print_message("led by a host: %.1f ms a moment, %zu points\n",
                  1e3 * spent / count, entity_of(scene, 5)->n_track);
    assert_true(highest(heights) > 0.05);
    assert_true(entity_of(scene, 5)->n_track > 8);
    assert_true(entity_of(scene, 5)->n_track < 20);
    pel_scene_destroy(scene);
}

static const char helm[] =
    "{\"entities\":{\"5\":{\"helm\":{\"on\":true,\"throttle\":1,"
    "\"length\":100,\"beam\":16,\"maxSpeed\":6.17}}}}";
static const char rudder[] =
    "{\"entities\":{\"5\":{\"helm\":{\"rudder\":10}}}}";

/* The same waves of a ship under its helm as of one that is reckoned on. */
static void under_a_helm(void **state)
{
    (void)state;
    double led[LINE], reckoned[LINE], later[LINE], again[LINE];
    struct pel_scene *scene = begin(), *other = begin();
    must(scene, helm);
    line(scene, 155, 0, -420, later);
    step(scene, 155);
    line(scene, 155, 0, -420, led);
    line(other, 155, 0, -420, reckoned);
    assert_memory_equal(led, later, sizeof led);
    assert_true(highest(led) > 0.05);
    for (int i = 0; i < LINE; i++) {
        /* pieces end at other places */
        assert_near(led[i], reckoned[i], 0.02 * highest(reckoned));
    }
    /* It turns; the old waves stay where they are. */
    assert_int_equal(entity_of(scene, 5)->n_track, 3);
    must(scene, rudder);
    line(scene, 155, 0, -420, again);
    for (int i = 0; i < LINE; i++) {
        assert_near(again[i], led[i], 0.006 * highest(led));
    }
    step(scene, 45);
    assert_true(entity_of(scene, 5)->n_track > 6);
    line(scene, 200, 0, -300, led);
    pel_scene_destroy(other);
    /* Another way to the same state. */
    other = begin();
    must(other, helm);
    for (int i = 0; i < 155; i++) {
        step(other, 1);
        assert_non_null(entity_of(other, 5));
    }
    must(other, rudder);
    must(other, "{\"entities\":{\"9\":{\"latitude\":1}}}");
    step(other, 3);
    assert_non_null(entity_of(other, 5));
    step(other, 42);
    line(other, 200, 0, -300, again);
    assert_memory_equal(led, again, sizeof led);
    pel_scene_destroy(scene);
    pel_scene_destroy(other);
}

/* A buoy beside the ship's track lies on the water there, and the ship not on
 * its own waves. */
static void things_float_on_them(void **state)
{
    (void)state;
    struct pel_scene *scene = begin();
    must(scene, "{\"entities\":{\"5\":{\"afloat\":true},"
                "\"6\":{\"latitude\":-0.0036,\"longitude\":0.0006,"
                "\"afloat\":true,\"model\":{\"name\":\"safe-water\"}}}}");
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    double most = 0;
    for (double t = 140; t < 180; t += 1.3) {
        struct pel_entity_state buoy, calm, own;
        struct pel_surface_sample water;
        pel_snapshot_entity_in_wakes(s, 2, t, &buoy);
        pel_snapshot_entity_at(s, 2, t, &calm);
        pel_snapshot_entity_in_wakes(s, 1, t, &own);
        struct pel_vec2 place = { buoy.east_m, buoy.north_m };
        pel_snapshot_surface(s, &place, 1, t, false, &water);
        most = fmax(most, fabs(water.height_m));
        /* its hull of 3 m feels less of waves that are little longer */
        assert_near(buoy.altitude_m, water.height_m, 0.2);
        assert_near(calm.altitude_m, 0, 1e-9);
        assert_near(own.altitude_m, 0, 1e-9);
    }
    assert_true(most > 0.3);
    pel_snapshot_unref(s);
    pel_scene_destroy(scene);
}

static const char tug[] =
    "{\"entities\":{\"7\":{\"latitude\":-0.0036,\"longitude\":0.0003,"
    "\"model\":{\"name\":\"tug\"},\"helm\":{\"on\":true,"
    "\"length\":24,\"beam\":9}}}}";
static const char course[] = "{\"entities\":{\"5\":{\"course\":350}}}";

/* How the tug rolls for half a minute; the ship changes its course meanwhile.
 */
static double tug_rolls(double by, bool ahead, double rolls[60])
{
    struct pel_scene *scene = begin();
    double most = 0;
    must(scene, tug);
    step(scene, 130);
    for (int i = 0; i < 60; i++) {
        for (double done = 0; done < 0.5; done += by) {
            assert_int_equal(pel_scene_step(scene, by, NULL), PEL_OK);
            g_usleep(ahead ? 10000 : 0); /* a thread does the next ones */
            while (ahead && g_main_context_iteration(NULL, FALSE)) {
            }
        }
        if (i == 20) {
            must(scene, course);
        }
        const struct pel_snapshot *s = pel_scene_snapshot(scene);
        struct pel_entity_state e;
        pel_snapshot_entity_at(s, 2, pel_scene_time(scene), &e);
        rolls[i] = e.roll_rad;
        most = fmax(most, fabs(e.roll_rad));
        pel_snapshot_unref(s);
    }
    pel_scene_destroy(scene);
    return most;
}

static void another_ship_rolls_it(void **state)
{
    (void)state;
    double a[60], b[60];
    double most = tug_rolls(0.5, false, a);
    print_message("a tug beside a tanker's track rolls by %.2f deg\n",
                  most / PEL_DEG);
    assert_true(most > 1 * PEL_DEG);
    (void)tug_rolls(0.25, true, b);
    assert_memory_equal(a, b, sizeof a);
}

/* Slices of a query share the wash of their moment; others' are their own. */
static void washes_are_shared(void **state)
{
    (void)state;
    struct pel_scene *scene = begin();
    must(scene, "{\"entities\":{\"5\":{\"wash\":true}}}");
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    const struct pel_wash *a = pel_snapshot_wash(s, 20);
    const struct pel_wash *b = pel_snapshot_wash(s, 20);
    assert_non_null(a);
    assert_ptr_equal(a, b);
    for (int i = 0; i < 8; i++) { /* more than are kept */
        const struct pel_wash *c = pel_snapshot_wash(s, 30 + i);
        assert_ptr_not_equal(a, c);
        pel_wash_destroy(c);
    }
    const struct pel_wash *again = pel_snapshot_wash(s, 20);
    size_t count = pel_wash_words(a, 0, 0, NULL);
    assert_int_equal(pel_wash_words(again, 0, 0, NULL), count);
    uint32_t *words = calloc(2 * count, sizeof *words);
    assert_non_null(words);
    pel_wash_words(a, 0, 0, words);
    pel_wash_words(again, 0, 0, words + count);
    assert_memory_equal(words, words + count, count * sizeof *words);
    free(words);
    pel_wash_destroy(again);
    pel_wash_destroy(b);
    pel_snapshot_unref(s);
    pel_wash_destroy(a); /* it outlives what it was made of */
    pel_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moments_in_any_order),
        cmocka_unit_test(moments_in_part),
        cmocka_unit_test(pasts_are_made_ahead),
        cmocka_unit_test(led_by_a_host),
        cmocka_unit_test(under_a_helm),
        cmocka_unit_test(things_float_on_them),
        cmocka_unit_test(another_ship_rolls_it),
        cmocka_unit_test(washes_are_shared),
        cmocka_unit_test(control_leaves_it_to_others),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
