#include "scene/ship.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "scene/scene_testkit.h"

static struct pel_ship_orders usual(void)
{
    return (struct pel_ship_orders){
        .length_m = 40,
        .beam_m = 9,
        .max_speed_mps = 8,
        .surge_time_s = 20,
        .turn_gain = 1.5,
        .turn_time = 1.5,
        .heave_period_s = pel_ship_heave_period(9),
        .pitch_period_s = pel_ship_heave_period(9),
        .roll_period_s = pel_ship_roll_period(9),
        .roll_damping = 0.1,
    };
}

static void make_sea(double wind_mps, double swell_m, double period_s,
                     double direction_rad, struct pel_sea *sea)
{
    struct pel_sea_desc desc = {
        .wind_mps = wind_mps,
        .fetch_m = 2e5,
        .gamma = 3.3,
        .seed = 1,
        .wave_count = 60,
        .swell_count = swell_m > 0,
        .swell[0] = { .height_m = swell_m,
                      .period_s = period_s,
                      .direction_rad = direction_rad,
                      .spread_rad = 0.02 },
    };
    assert_int_equal(pel_sea_build(&desc, sea), PEL_OK);
}

/* r(t) = K δ (1 − e^{−t/T}), ψ = K δ (t − T (1 − e^{−t/T})) at constant speed:
 * throttle and speed agree, so that u does not change. */
static void nomoto_step_response(void **state)
{
    (void)state;
    struct pel_sea calm;
    struct pel_ship ship;
    struct pel_ship_motion m = { .speed_mps = 4 }, at;
    struct pel_ship_orders o = usual();
    make_sea(0, 0, 0, 0, &calm);
    o.throttle = 0.5;
    o.rudder_rad = 10 * PEL_DEG;
    double T = 1.5 * 40 / 4, K = 1.5 * 4 / 40.0, step = K * o.rudder_rad;
    pel_ship_start(&ship, &o, &m, 100, 1);
    for (double t = 0.37; t < 60; t += 3.1) {
        pel_ship_advance(&ship, 100 + t, &calm);
        pel_ship_at(&ship, 100 + t, &calm, &at);
        double gone = 1 - exp(-t / T);
        /* closed form in 300 steps: rounding only */
        assert_near(at.turn_rate_rps, step * gone, 1e-13);
        assert_near(at.heading_rad, step * (t - T * gone), 1e-11);
        assert_near(at.speed_mps, 4, 1e-12);
    }
    pel_sea_finish(&calm);
}

/* u = u∞ (1 − e^{−t/Tu}), straight north; the track by Simpson's rule in steps
 * of 0.2 s: error below h⁵ u''''/2880 a step, 1e-11 m. */
static void surge_step_response(void **state)
{
    (void)state;
    struct pel_sea calm;
    struct pel_ship ship;
    struct pel_ship_motion m = { 0 }, at;
    struct pel_ship_orders o = usual();
    make_sea(0, 0, 0, 0, &calm);
    o.throttle = 1;
    pel_ship_start(&ship, &o, &m, 0, 1);
    pel_ship_advance(&ship, 50.1, &calm);
    pel_ship_at(&ship, 50.1, &calm, &at);
    double gone = 1 - exp(-50.1 / 20);
    assert_near(at.speed_mps, 8 * gone, 1e-12);
    assert_near(at.north_m, 8 * (50.1 - 20 * gone), 1e-8);
    assert_near(at.east_m, 0, 0);
    pel_sea_finish(&calm);
}

/* A steady turn is a circle of radius U / (K δ). */
static void turning_circle(void **state)
{
    (void)state;
    struct pel_sea calm;
    struct pel_ship ship;
    struct pel_ship_orders o = usual();
    make_sea(0, 0, 0, 0, &calm);
    o.throttle = 1;
    o.rudder_rad = 20 * PEL_DEG;
    double rate = 1.5 * 8 / 40 * o.rudder_rad, radius = 8 / rate;
    struct pel_ship_motion m = { .speed_mps = 8, .turn_rate_rps = rate }, at;
    pel_ship_start(&ship, &o, &m, 0, 1);
    double half_s = PEL_PI / rate;
    pel_ship_advance(&ship, half_s, &calm);
    pel_ship_at(&ship, half_s, &calm, &at);
    assert_near(at.east_m, 2 * radius, 1e-4); /* to starboard */
    assert_near(at.north_m, 0, 1e-4);
    assert_near(at.heading_rad, PEL_PI, 1e-9);
    pel_sea_finish(&calm);
}

static void calm_water_keeps_it_level(void **state)
{
    (void)state;
    struct pel_sea calm;
    struct pel_ship ship;
    struct pel_ship_orders o = usual();
    struct pel_ship_motion m = { .east_m = 3, .north_m = -7 }, at;
    make_sea(0, 0, 0, 0, &calm);
    pel_ship_start(&ship, &o, &m, 5, 1);
    pel_ship_advance(&ship, 605, &calm);
    pel_ship_at(&ship, 605, &calm, &at);
    assert_memory_equal(&at, &m, sizeof m); /* to the bit */
    pel_sea_finish(&calm);
}

/* Heeled and let go in calm water it rolls with its damped period
 * T / √(1 − ζ²), and each swing is e^{−2πζ/√(1−ζ²)} of the one before. */
static void rolls_with_its_period(void **state)
{
    (void)state;
    struct pel_sea calm;
    struct pel_ship ship;
    struct pel_ship_orders o = usual();
    struct pel_ship_motion m = { .roll = { 0.2, 0 } }, at;
    make_sea(0, 0, 0, 0, &calm);
    double root = sqrt(1 - 0.1 * 0.1), period = o.roll_period_s / root;
    pel_ship_start(&ship, &o, &m, 0, 1);
    for (int n = 1; n <= 5; n++) {
        pel_ship_advance(&ship, n * period, &calm);
        pel_ship_at(&ship, n * period, &calm, &at);
        double left = exp(-2 * PEL_PI * 0.1 / root * n);
        assert_near(at.roll.x, 0.2 * left, 1e-12);
        assert_near(at.roll.rate, 0, 1e-12); /* a crest of the swing */
    }
    assert_near(at.pitch.x, 0, 0);
    pel_sea_finish(&calm);
}

/* The closed form against small Runge-Kutta steps. */
static void response_solves_the_equation(void **state)
{
    (void)state;
    const double T = 5, z = 0.3, from = 0.4, to = -0.7, span = 0.2;
    const double w = 2 * PEL_PI / T;
    double x = 0.1, v = -0.3, h = 1e-4;
    struct pel_ship_mode start = { x, v };
    for (int i = 0; i < 1500; i++) { /* mid-point rule: error 1e-9 */
        double f0 = from + (to - from) * (i + 0.5) * h / span;
        double a =
            w * w * (from + (to - from) * i * h / span - x) - 2 * z * w * v;
        double xm = x + 0.5 * h * v, vm = v + 0.5 * h * a;
        x += h * vm;
        v += h * (w * w * (f0 - xm) - 2 * z * w * vm);
    }
    struct pel_ship_mode end =
        pel_ship_respond(start, T, z, from, to, span, 0.15);
    assert_near(end.x, x, 1e-8);
    assert_near(end.rate, v, 1e-8);
    end = pel_ship_respond(start, T, z, 0.5, 0.5, span, 200);
    assert_near(end.x, 0.5, 1e-12); /* it comes to rest there */
}

/* In swell much longer than the ship and slower than its periods it follows
 * the surface: heave with its height, pitch with its slope. */
static void long_swell_carries_it(void **state)
{
    (void)state;
    struct pel_sea sea;
    struct pel_ship ship;
    struct pel_ship_orders o = usual();
    struct pel_ship_motion m = { 0 }, at;
    make_sea(0, 2, 25, PEL_PI / 2, &sea); /* towards north, from astern */
    pel_ship_start(&ship, &o, &m, 0, 1);
    double worst = 0, most = 0;
    for (double t = 60; t < 300; t += 1) {
        struct pel_surface_sample s;
        pel_ship_advance(&ship, t, &sea);
        pel_ship_at(&ship, t, &sea, &at);
        pel_sea_sample(&sea, 0, 0, t, &s);
        worst = fmax(worst, fabs(at.heave.x - s.height_m));
        most = fmax(most, fabs(s.height_m));
        /* stern up as the crest comes: slope along the bow */
        assert_near(at.pitch.x, -s.normal.y / s.normal.z, 0.01);
        assert_near(at.roll.x, 0, 0.01);
    }
    assert_true(most > 0.7);
    /* The response lags by 2 ζ T_heave / T = 0.7 * 4.8 / 25 rad: 0.14 */
    assert_true(worst < 0.25 * most);
    pel_sea_finish(&sea);
}

/* The plane of the hull's points is that of a surface which bends little over
 * the ship (wavelength 156 m, 40 by 9 m: cubic terms of a few per cent). */
static void hull_lies_on_the_surface(void **state)
{
    (void)state;
    struct pel_sea sea;
    const struct pel_ship ship = { .orders = usual() };
    make_sea(0, 1, 10, 0, &sea); /* swell towards east */
    for (double t = 0; t < 30; t += 1.7) {
        struct pel_surface_sample s;
        double north[3], east[3];
        struct pel_ship_motion m = { .east_m = 5, .north_m = -3 };
        pel_sea_sample(&sea, 5, -3, t, &s);
        double slope = -s.normal.x / s.normal.z; /* up towards the east */
        pel_ship_sea(&ship, &m, t, &sea, north);
        m.heading_rad = PEL_PI / 2;
        pel_ship_sea(&ship, &m, t, &sea, east);
        assert_near(north[2], -atan(slope), 0.004); /* port lifted: st. down */
        assert_near(east[1], atan(slope), 0.004);   /* bow lifted: bow up */
        assert_near(north[0], s.height_m, 0.03);
        assert_near(east[2], -north[1], 0.004);
    }
    pel_sea_finish(&sea);
}

/* The same motion, bit for bit, however often it is looked at. */
static void looked_at_at_15_and_60_hz(void **state)
{
    (void)state;
    struct pel_sea sea;
    struct pel_ship slow, fast, once;
    struct pel_ship_orders o = usual();
    struct pel_ship_motion m = { .speed_mps = 3 }, a, b;
    make_sea(12, 1, 9, 1, &sea);
    o.throttle = 0.8;
    o.rudder_rad = 0.1;
    pel_ship_start(&slow, &o, &m, 7.7, 1);
    fast = once = slow;
    for (int i = 1; i <= 15 * 30; i++) {
        double t = 7.7 + i / 15.0;
        for (int k = 3; k >= 0; k--) {
            pel_ship_advance(&fast, t - k / 60.0, &sea);
        }
        pel_ship_advance(&slow, t, &sea);
        pel_ship_at(&slow, t, &sea, &a);
        pel_ship_at(&fast, t, &sea, &b);
        assert_memory_equal(&a, &b, sizeof a);
        /* a second ago is answered exactly too */
        struct pel_ship_motion past;
        pel_ship_at(&fast, t, &sea, &a);
        pel_ship_advance(&fast, t, &sea);
        pel_ship_at(&fast, t - 0.9, &sea, &past);
        if (i % 45 == 0) {
            struct pel_ship again;
            pel_ship_start(&again, &o, &m, 7.7, 1);
            pel_ship_advance(&again, t - 0.9, &sea);
            pel_ship_at(&again, t - 0.9, &sea, &b);
            assert_memory_equal(&past, &b, sizeof past);
        }
    }
    pel_ship_advance(&once, 37.7, &sea);
    pel_ship_at(&once, 37.7, &sea, &a);
    pel_ship_at(&slow, 37.7, &sea, &b);
    assert_memory_equal(&a, &b, sizeof a);
    assert_true(fabs(a.roll.x) > 1e-3 && fabs(a.heave.x) > 1e-2);
    /* ahead of its steps: the same as when they are done */
    pel_ship_at(&once, 42, &sea, &a);
    pel_ship_advance(&once, 42, &sea);
    pel_ship_at(&once, 42, &sea, &b);
    assert_memory_equal(&a, &b, sizeof a);
    pel_sea_finish(&sea);
}

/* Whenever orders come, the sea is asked at multiples of the step: else each
 * order would wait for moments of its own. */
static void the_sea_is_asked_at_multiples(void **state)
{
    (void)state;
    struct pel_sea sea;
    struct pel_ship ship;
    struct pel_ship_orders o = usual();
    struct pel_ship_motion m = { .east_m = 4, .speed_mps = 3 }, at;
    double before[3], after[3], next[3];
    make_sea(12, 1, 9, 1, &sea);
    pel_ship_start(&ship, &o, &m, 7.65, 1);
    assert_near(pel_ship_time(&ship, 1), 7.8, 1e-12);
    assert_near(pel_ship_time(&ship, 3), 8.2, 1e-12);
    pel_ship_advance(&ship, 7.66, &sea);
    pel_ship_sea(&ship, &m, 38 * 0.2, &sea, before);
    pel_ship_sea(&ship, &m, 39 * 0.2, &sea, after);
    pel_ship_at(&ship, 39 * 0.2, &sea, &at);
    pel_ship_sea(&ship, &at, 39 * 0.2, &sea, next);
    for (int i = 0; i < 3; i++) {
        assert_near(ship.steps[0].sea[i],
                    before[i] + 0.25 * (after[i] - before[i]), 1e-12);
        assert_near(ship.steps[0].sea_after[i], next[i], 1e-9);
    }
    /* On a multiple but for rounding, on either side of it. */
    static const double starts_s[] = { 0.2 * 39, 0.6 + 7.2, 7.8 - 1e-15 };
    for (int k = 0; k < 3; k++) {
        pel_ship_start(&ship, &o, &m, starts_s[k], 1);
        pel_ship_advance(&ship, 7.9, &sea);
        assert_near(pel_ship_time(&ship, 1), 8, 1e-12);
        assert_near(ship.steps[0].sea[0], after[0], 1e-12);
    }
    /* Of a fast clock: longer steps. */
    pel_ship_start(&ship, &o, &m, 7.65, 8);
    assert_near(pel_ship_time(&ship, 1), 8, 1e-12);
    assert_near(pel_ship_time(&ship, 2), 8.4, 1e-12);
    pel_sea_finish(&sea);
}

static void no_sea_breaks_it(void **state)
{
    (void)state;
    struct pel_sea sea;
    struct pel_ship ship;
    struct pel_ship_orders o = usual();
    struct pel_ship_motion m = { .speed_mps = 8 }, at;
    make_sea(30, 15, 7, 0.4, &sea);
    o.roll_damping = 0.01;
    o.roll_period_s = 7; /* resonance */
    o.throttle = 1;
    o.rudder_rad = 45 * PEL_DEG;
    pel_ship_start(&ship, &o, &m, 0, 1);
    for (double t = 0; t < 120; t += 0.5) {
        pel_ship_advance(&ship, t, &sea);
        pel_ship_at(&ship, t, &sea, &at);
        assert_true(fabs(at.roll.x) <= 60 * PEL_DEG);
        assert_true(fabs(at.heave.x) <= 50);
        assert_true(isfinite(at.east_m) && isfinite(at.heading_rad));
    }
    pel_sea_finish(&sea);
}

/* --- in the scene --------------------------------------------------------- */

static void step(struct pel_scene *scene, double seconds)
{
    struct pel_fault fault;
    if (pel_scene_step(scene, seconds, &fault)) {
        fail_msg("%s", fault.message);
    }
}

static char *json(struct pel_scene *scene)
{
    return pel_json_from_message(&pel_scene_state(scene)->base, false);
}

static const char sails[] =
    "{\"clock\":{\"mode\":\"STEPPED\",\"time\":50},\"ownShip\":{\"on\":true,"
    "\"throttle\":0.9,\"rudder\":5},\"sea\":{\"windSpeed\":11}}";

/* A calm sea, and then 3 m more of it: the ship floats on it. */
static void the_tide_carries_the_ship(void **state)
{
    (void)state;
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 60 });
    assert_int_equal(patch(scene, sails, NULL), PEL_OK);
    assert_int_equal(
        patch(scene, "{\"sea\":{\"windSpeed\":0,\"level\":3}}", NULL), PEL_OK);
    for (int i = 0; i < 20; i++) {
        step(scene, 3);
    }
    /* Its heave of before has died away: e^-40. */
    assert_near(pel_scene_state(scene)->entities[0]->altitude, 3, 1e-6);
    assert_int_equal(patch(scene, "{\"sea\":{\"level\":-1}}", NULL), PEL_OK);
    assert_near(pel_scene_state(scene)->entities[0]->altitude, -1, 1e-6);
    pel_scene_destroy(scene);
}

/* 15 Hz, 60 Hz and in one piece, with orders and other edits between. */
static void frame_rate_does_not_matter(void **state)
{
    (void)state;
    static const double rates[] = { 15, 60, 0.25 };
    char *first = NULL;
    for (int r = 0; r < 3; r++) {
        struct pel_scene *scene =
            make_scene((struct pel_scene_options){ .wave_count = 60 });
        double now = 50;
        assert_int_equal(patch(scene, sails, NULL), PEL_OK);
        for (int leg = 0; leg < 3; leg++) {
            double end = 58.5 + 8.5 * leg, pace = 1 / rates[r];
            for (; now + pace < end; now += pace) {
                assert_int_equal(pel_scene_step_to(scene, now + pace, NULL),
                                 PEL_OK);
                pel_snapshot_unref(pel_scene_snapshot(scene));
                (void)pel_scene_state(scene);
            }
            assert_int_equal(pel_scene_step_to(scene, end, NULL), PEL_OK);
            now = end;
            assert_int_equal(patch(scene,
                                   leg == 0   ? "{\"ownShip\":{\"rudder\":-12}}"
                                   : leg == 1 ? "{\"sky\":{\"visibility\":900}}"
                                              : "{\"sea\":{\"windSpeed\":14}}",
                                   NULL),
                             PEL_OK);
        }
        step(scene, 3.3);
        char *end = json(scene);
        if (first) {
            assert_string_equal(end, first);
            free(end);
        } else {
            first = end;
        }
        pel_scene_destroy(scene);
    }
    free(first);
}

static const Pelagos__Entity *own(struct pel_scene *scene)
{
    return pel_scene_state(scene)->entities[0];
}

static void others_take_the_lead(void **state)
{
    (void)state;
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 60 });
    assert_false(pel_scene_state(scene)->own_ship->on); /* off by default */
    assert_int_equal(patch(scene, sails, NULL), PEL_OK);
    step(scene, 10);
    assert_true(own(scene)->speed > 2 && own(scene)->latitude > 52.6);
    /* a step too long is refused, and so is nonsense */
    assert_int_equal(pel_scene_step(scene, 10.1, NULL), PEL_ERR_OUT_OF_RANGE);
    assert_int_equal(patch(scene, "{\"ownShip\":{\"rudder\":46}}", NULL),
                     PEL_ERR_OUT_OF_RANGE);
    /* the model goes on from a pose where it is told to */
    assert_int_equal(
        patch(scene,
              "{\"ownShip\":{\"on\":true,\"throttle\":0},\"entities\":"
              "{\"1\":{\"heading\":90,\"course\":90,\"speed\":0,"
              "\"turnRate\":0}}}",
              NULL),
        PEL_OK);
    assert_true(pel_scene_state(scene)->own_ship->on);
    step(scene, 5);
    assert_near(own(scene)->heading, 90, 1e-6);
    /* a host sends a pose: it leads */
    assert_int_equal(patch(scene,
                           "{\"entities\":{\"1\":{\"roll\":3,\"heading\":10}}}",
                           NULL),
                     PEL_OK);
    assert_false(pel_scene_state(scene)->own_ship->on);
    step(scene, 100);
    assert_near(own(scene)->roll, 3, 0);
    assert_near(own(scene)->heading, 10, 0);
    pel_scene_destroy(scene);
}

/* Turned on late it begins there and then, not at the pose of long ago. */
static void begins_now(void **state)
{
    (void)state;
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 60 });
    assert_int_equal(patch(scene,
                           "{\"clock\":{\"mode\":\"STEPPED\",\"time\":0},"
                           "\"entities\":{\"1\":{\"heading\":20,\"roll\":0}}}",
                           NULL),
                     PEL_OK);
    for (int i = 0; i < 1000; i++) { /* 3.6e6 s: 18 million steps of a ship */
        step(scene, 3600);
    }
    assert_int_equal(patch(scene, "{\"ownShip\":{\"on\":true}}", NULL), PEL_OK);
    assert_near(own(scene)->pose_time, 3.6e6, 0);
    assert_near(own(scene)->latitude, 52.6, 1e-12);
    assert_near(own(scene)->roll, 0, 1e-12);
    step(scene, 1);
    assert_near(own(scene)->heading, 20, 1e-9);
    assert_int_equal(patch(scene,
                           "{\"ownShip\":{\"on\":true},\"entities\":{\"1\":"
                           "{\"poseTime\":0,\"heading\":30}}}",
                           NULL),
                     PEL_OK);
    assert_near(own(scene)->heading, 30, 1e-9);
    assert_near(own(scene)->pose_time, 3600001, 0);
    /* and the clock may be set far away */
    assert_int_equal(patch(scene, "{\"clock\":{\"time\":1e9}}", NULL), PEL_OK);
    assert_near(own(scene)->heading, 30, 1e-9);
    pel_scene_destroy(scene);
}

/* --- several -------------------------------------------------------------- */

static const char two[] =
    "{\"clock\":{\"mode\":\"STEPPED\",\"time\":50},\"ownShip\":{\"on\":true,"
    "\"throttle\":0.9,\"rudder\":5},\"sea\":{\"windSpeed\":11},"
    "\"entities\":{\"7\":{\"name\":\"tug\",\"heading\":90,\"course\":90,"
    "\"helm\":{\"on\":true,\"throttle\":1,\"length\":24}}}}";

static char *json_of(struct pel_scene *scene, size_t i)
{
    return pel_json_from_message(&pel_scene_state(scene)->entities[i]->base,
                                 false);
}

/* Each goes its own way, and what is done to one leaves the other's bits as
 * they would be without. */
static void two_ships_do_not_mind_each_other(void **state)
{
    (void)state;
    static const char *const others[] = {
        NULL,
        "{\"ownShip\":{\"rudder\":-20}}",
        "{\"entities\":{\"1\":{\"heading\":200}}}",
        "{\"entities\":{\"3\":{\"name\":\"first in the list\"}}}",
    };
    char *first = NULL, *own_first = NULL;
    for (size_t k = 0; k < sizeof others / sizeof *others; k++) {
        struct pel_scene *scene =
            make_scene((struct pel_scene_options){ .wave_count = 60 });
        assert_int_equal(patch(scene, two, NULL), PEL_OK);
        step(scene, 4.1);
        if (others[k]) {
            assert_int_equal(patch(scene, others[k], NULL), PEL_OK);
        }
        step(scene, 9);
        const Pelagos__State *now = pel_scene_state(scene);
        assert_int_equal(now->entities[1]->id, 7);
        assert_true(now->entities[1]->longitude > 5.2003);
        assert_near(now->entities[1]->latitude, 52.6, 1e-6);
        assert_true(k == 2 || now->entities[0]->latitude > 52.6001);
        char *tug = json_of(scene, 1), *own_now = json_of(scene, 0);
        if (first) {
            assert_string_equal(tug, first);
            assert_int_equal(strcmp(own_now, own_first) == 0, k == 3);
            free(tug);
            free(own_now);
        } else {
            first = tug;
            own_first = own_now;
        }
        pel_scene_destroy(scene);
    }
    free(first);
    free(own_first);
}

static void each_helm_is_led_by_itself(void **state)
{
    (void)state;
    struct pel_fault fault;
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 60 });
    assert_int_equal(patch(scene, two, NULL), PEL_OK);
    /* by name; a pose turns that helm off, and no other */
    assert_int_equal(patch(scene,
                           "{\"entities\":{\"tug\":{\"helm\":{\"rudder\":9}}}}",
                           NULL),
                     PEL_OK);
    assert_true(pel_scene_state(scene)->entities[1]->helm->on);
    assert_int_equal(
        patch(scene, "{\"entities\":{\"tug\":{\"heading\":9}}}", NULL), PEL_OK);
    assert_false(pel_scene_state(scene)->entities[1]->helm->on);
    assert_true(pel_scene_state(scene)->own_ship->on);
    assert_near(pel_scene_state(scene)->entities[1]->helm->rudder, 9, 0);
    /* a ship has one helm, of its own */
    assert_int_equal(
        patch(scene, "{\"entities\":{\"1\":{\"helm\":{\"on\":true}}}}", &fault),
        PEL_ERR_CONFLICT);
    assert_string_equal(fault.path, "entities.1.helm.on");
    assert_int_equal(patch(scene,
                           "{\"entities\":{\"7\":{\"helm\":{\"entity\":1}}}}",
                           &fault),
                     PEL_ERR_INVALID);
    /* eight of them */
    for (int id = 10; id < 18; id++) {
        char text[80];
        snprintf(text, sizeof text,
                 "{\"entities\":{\"%d\":{\"helm\":{\"on\":true}}}}", id);
        assert_int_equal(patch(scene, text, &fault),
                         id < 17 ? PEL_OK : PEL_ERR_OUT_OF_RANGE);
    }
    step(scene, 10);
    assert_int_equal(
        patch(scene, "{\"entities\":{\"10\":null,\"7\":null}}", &fault),
        PEL_OK);
    step(scene, 10);
    pel_scene_destroy(scene);
}

static void what_is_drawn_moves(void **state)
{
    (void)state;
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 60 });
    struct pel_camera a, b;
    assert_int_equal(patch(scene, sails, NULL), PEL_OK);
    step(scene, 10);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    pel_snapshot_camera(s, 0, 60, 0, 0, &a);
    pel_snapshot_camera(s, 0, 60.1, 0, 0, &b);
    assert_true(hypot(b.east_m - a.east_m, b.north_m - a.north_m) > 0.1);
    assert_true(a.altitude_m != b.altitude_m);
    struct pel_entity_state e;
    pel_snapshot_entity_at(s, 0, 60, &e);
    assert_near(e.roll_rad / PEL_DEG, own(scene)->roll, 1e-12);
    pel_snapshot_unref(s);
    pel_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nomoto_step_response),
        cmocka_unit_test(surge_step_response),
        cmocka_unit_test(turning_circle),
        cmocka_unit_test(calm_water_keeps_it_level),
        cmocka_unit_test(rolls_with_its_period),
        cmocka_unit_test(response_solves_the_equation),
        cmocka_unit_test(long_swell_carries_it),
        cmocka_unit_test(hull_lies_on_the_surface),
        cmocka_unit_test(looked_at_at_15_and_60_hz),
        cmocka_unit_test(the_sea_is_asked_at_multiples),
        cmocka_unit_test(no_sea_breaks_it),
        cmocka_unit_test(frame_rate_does_not_matter),
        cmocka_unit_test(the_tide_carries_the_ship),
        cmocka_unit_test(others_take_the_lead),
        cmocka_unit_test(begins_now),
        cmocka_unit_test(what_is_drawn_moves),
        cmocka_unit_test(two_ships_do_not_mind_each_other),
        cmocka_unit_test(each_helm_is_led_by_itself),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
