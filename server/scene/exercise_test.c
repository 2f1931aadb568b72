#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <glib.h>
#include <glib/gstdio.h>

#include "base/clock.h"
#include "scene/exercise.h"
#include "scene/exercisewhen.h"
#include "scene/scene_testkit.h"

/* Own ship under its helm, a target that crosses, one that stands. */
#define STATE                                                                  \
    "\"state\":{\"origin\":{\"latitude\":52.6,\"longitude\":5.2},"             \
    "\"sea\":{\"windSpeed\":6,\"synthesiser\":\"TROCHOIDS\"},"                 \
    "\"water\":{\"depth\":9},"                                                 \
    "\"ownShip\":{\"on\":true,\"throttle\":0.8},"                              \
    "\"entities\":[{\"id\":1,\"name\":\"own\",\"latitude\":52.6,"              \
    "\"longitude\":5.2,\"speed\":6,\"heading\":0,\"course\":0},"               \
    "{\"id\":2,\"latitude\":52.61,\"longitude\":5.21,\"speed\":5,"             \
    "\"heading\":270,\"course\":270},"                                         \
    "{\"id\":3,\"latitude\":52.602,\"longitude\":5.2003},"                     \
    "{\"id\":4,\"latitude\":52.604,\"longitude\":5.2006,\"heading\":190,"      \
    "\"course\":190,\"helm\":{\"on\":true,\"throttle\":0.6}}]}"
/* The ship that comes from the north has a bridge of her own. */
#define SHIPS "\"ships\":[{\"id\":4,\"draught\":8.5}]"
#define EVENTS                                                                 \
    "\"events\":["                                                             \
    "{\"name\":\"fog\",\"when\":[{\"at\":2.5}],"                               \
    "\"patch\":{\"state\":{\"sky\":{\"visibility\":700}}}},"                   \
    "{\"name\":\"gale\",\"when\":[{\"after\":\"fog\",\"delay\":1}],"           \
    "\"patch\":{\"state\":{\"sea\":{\"windSpeed\":12}}}},"                     \
    "{\"name\":\"turn\",\"when\":[{\"other\":2,\"rangeBelow\":1250}],"         \
    "\"patch\":{\"state\":{\"entities\":[{\"id\":2,\"course\":200,"            \
    "\"heading\":200}]}}},"                                                    \
    "{\"name\":\"failure\",\"when\":[{\"northOf\":52.6005}],"                  \
    "\"patch\":{\"state\":{\"ownShip\":{\"throttle\":0.1}}}},"                 \
    "{\"name\":\"again\",\"each\":true,\"when\":[{\"inside\":"                 \
    "{\"latitude\":52.6009,\"longitude\":5.2,\"radius\":30}}],"                \
    "\"patch\":{\"state\":{\"sky\":{\"rain\":3}}}}]"
#define EXERCISE "{\"title\":\"t\"," STATE "," SHIPS "," EVENTS "}"

static char *folder;

static int make_folder(void **state)
{
    (void)state;
    folder = g_dir_make_tmp("pelagos-exercise-XXXXXX", NULL);
    return folder ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    GDir *dir = g_dir_open(folder, 0, NULL);
    const char *name;
    while ((name = g_dir_read_name(dir))) {
        g_autofree char *path = g_build_filename(folder, name, NULL);
        g_remove(path);
    }
    g_dir_close(dir);
    g_rmdir(folder);
    g_free(folder);
    return 0;
}

static void write_exercise(const char *name, const char *text)
{
    g_autofree char *path = g_strdup_printf("%s/%s.json", folder, name);
    assert_true(g_file_set_contents(path, text, -1, NULL));
}

static struct pel_exercises *make_exercises(struct pel_scene *scene,
                                            const char *state_path)
{
    const struct pel_exercises_options options = { folder, state_path };
    struct pel_exercises *all;
    struct pel_fault fault;
    if (pel_exercises_create(&options, scene, &all, &fault)) {
        fail_msg("%s", fault.message);
    }
    return all;
}

static enum pel_err command(struct pel_exercises *all,
                            Pelagos__ExerciseAction action, const char *name,
                            double time_s, Pelagos__ExerciseStatus **out,
                            struct pel_fault *fault)
{
    Pelagos__ExerciseCommand c = PELAGOS__EXERCISE_COMMAND__INIT;
    Pelagos__ExerciseStatus *status;
    c.has_action = true;
    c.action = action;
    c.name = (char *)name;
    c.has_time = time_s >= 0;
    c.time = time_s;
    enum pel_err err = pel_exercises_command(all, &c, &status, fault);
    if (!err && !out) {
        pelagos__exercise_status__free_unpacked(status, NULL);
    } else if (!err) {
        *out = status;
    }
    return err;
}

#define DO(all, action, name, time_s)                                          \
    do {                                                                       \
        struct pel_fault fault_;                                               \
        if (command(all, PELAGOS__EXERCISE_ACTION__##action, name, time_s,     \
                    NULL, &fault_)) {                                          \
            fail_msg(#action ": %s", fault_.message);                          \
        }                                                                      \
    } while (0)

/* ship: -1: as who knows of one. */
static char *facts_of_ship(struct pel_exercises *all, int64_t ship)
{
    Pelagos__ExerciseCommand c = PELAGOS__EXERCISE_COMMAND__INIT;
    Pelagos__ExerciseStatus *status;
    struct pel_fault fault;
    c.has_action = true;
    c.action = PELAGOS__EXERCISE_ACTION__FACTS;
    c.has_ship = ship >= 0;
    c.ship = (uint32_t)ship;
    if (pel_exercises_command(all, &c, &status, &fault)) {
        fail_msg("%s", fault.message);
        return NULL;
    }
    char *text = g_strdup(status->facts);
    pelagos__exercise_status__free_unpacked(status, NULL);
    return text;
}

/* Of both own ships. */
static char *facts_of(struct pel_exercises *all)
{
    g_autofree char *own = facts_of_ship(all, -1);
    g_autofree char *other = facts_of_ship(all, 4);
    assert_string_not_equal(own, other);
    return g_strconcat(own, other, NULL);
}

/* --- a run ---------------------------------------------------------------- */

/* Every edit with its time, as a log of commands has them. */
static void hear(void *user, double time_s, const Pelagos__Patch *patch)
{
    GString *log = user;
    if (patch) {
        char *text = pel_json_from_message(&patch->base, false);
        g_string_append_printf(log, "%a %s\n", time_s, text);
        free(text);
    }
}

struct outcome {
    char *facts, *state;
    GString *log;
};

static void finish(struct outcome *o)
{
    g_free(o->facts);
    free(o->state);
    g_string_free(o->log, TRUE);
}

static char *state_text(struct pel_scene *scene)
{
    Pelagos__State state = *pel_scene_state(scene);
    Pelagos__ExerciseRun run = *state.exercise;
    state.has_revision = false;
    run.has_time = run.has_since = false; /* when it was started last */
    state.exercise = &run;
    return pel_json_from_message(&state.base, false);
}

static void step_to(struct pel_scene *scene, double from_s, double to_s,
                    double step_s)
{
    struct pel_fault fault;
    for (int64_t i = 1; from_s + (double)i * step_s < to_s - 1e-9; i++) {
        assert_int_equal(
            pel_scene_step_to(scene, from_s + (double)i * step_s, &fault),
            PEL_OK);
        pel_scene_settle(scene);
    }
    if (pel_scene_step_to(scene, to_s, &fault)) {
        fail_msg("%s", fault.message);
    }
    pel_scene_settle(scene);
}

static struct outcome run_by(double step_s, double seconds)
{
    struct outcome o = { .log = g_string_new(NULL) };
    struct pel_scene *scene = make_scene((struct pel_scene_options){ 0 });
    struct pel_exercises *all = make_exercises(scene, NULL);
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\"}}");
    DO(all, LOAD, "one", -1);
    DO(all, START, NULL, -1);
    (void)pel_scene_listen(scene, hear, o.log);
    step_to(scene, 0, seconds, step_s);
    o.facts = facts_of(all);
    o.state = state_text(scene);
    pel_exercises_destroy(all);
    pel_scene_destroy(scene);
    return o;
}

static void runs_are_the_same_whatever_the_steps(void **state)
{
    (void)state;
    write_exercise("one", EXERCISE);
    struct outcome a = run_by(10, 40), b = run_by(1.0 / 24, 40),
                   c = run_by(0.73, 40);
    assert_string_equal(a.log->str, b.log->str);
    assert_string_equal(a.log->str, c.log->str);
    assert_string_equal(a.facts, b.facts);
    assert_string_equal(a.facts, c.facts);
    assert_string_equal(a.state, b.state);
    assert_string_equal(a.state, c.state);
    static const char *const names[] = { "fog", "gale", "turn", "failure",
                                         "again" };
    for (size_t i = 0; i < G_N_ELEMENTS(names); i++) {
        g_autofree char *said = g_strdup_printf("\"event\":\"%s\"", names[i]);
        if (!strstr(a.log->str, said)) {
            fail_msg("%s never happened:\n%s\n%s", names[i], a.log->str,
                     a.facts);
        }
    }
    /* Exactly at their moments. */
    assert_non_null(strstr(a.log->str, "0x1.4p+1 {\"state\":{\"sky\":"
                                       "{\"visibility\":700}"));
    finish(&a);
    finish(&b);
    finish(&c);
}

/* The log's patches alone lead to the same state: nothing else was done. */
static void a_log_replays_without_an_exercise(void **state)
{
    (void)state;
    write_exercise("one", EXERCISE);
    struct pel_scene *live = make_scene((struct pel_scene_options){ 0 });
    struct pel_scene *played = make_scene((struct pel_scene_options){ 0 });
    struct pel_exercises *all = make_exercises(live, NULL);
    GString *log = g_string_new(NULL);
    must(live, "{\"clock\":{\"mode\":\"STEPPED\"}}");
    must(played, "{\"clock\":{\"mode\":\"STEPPED\"}}");
    (void)pel_scene_listen(live, hear, log);
    DO(all, LOAD, "one", -1);
    DO(all, START, NULL, -1);
    step_to(live, 0, 25, 0.5);
    char **lines = g_strsplit(log->str, "\n", 0);
    for (char **line = lines; *line && **line; line++) {
        char *text;
        double time_s = strtod(*line, &text);
        ProtobufCMessage *patch;
        struct pel_fault fault;
        assert_int_equal(pel_json_to_message(text, strlen(text),
                                             &pelagos__patch__descriptor,
                                             &patch, &fault),
                         PEL_OK);
        if (time_s > pel_scene_time(played)) {
            step_to(played, pel_scene_time(played), time_s, 10);
        }
        if (pel_scene_patch(played, (Pelagos__Patch *)patch, &fault)) {
            fail_msg("%s: %s", text, fault.message);
        }
        protobuf_c_message_free_unpacked(patch, NULL);
    }
    step_to(played, pel_scene_time(played), 25, 10);
    g_strfreev(lines);
    char *a = state_text(live), *b = state_text(played);
    assert_string_equal(a, b);
    free(a);
    free(b);
    g_string_free(log, TRUE);
    pel_exercises_destroy(all);
    pel_scene_destroy(live);
    pel_scene_destroy(played);
}

static void rewound_it_goes_the_same_way(void **state)
{
    static const double back_s[] = { 27.3, 20, 12.34, 3.5, 2.5, 0.05, 0 };
    (void)state;
    write_exercise("one", EXERCISE);
    struct outcome straight = run_by(0.5, 32);
    struct pel_scene *scene = make_scene((struct pel_scene_options){ 0 });
    struct pel_exercises *all = make_exercises(scene, NULL);
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\"}}");
    DO(all, LOAD, "one", -1);
    DO(all, START, NULL, -1);
    step_to(scene, 0, 32, 0.5);
    for (size_t i = 0; i < G_N_ELEMENTS(back_s); i++) {
        DO(all, REWIND, NULL, back_s[i]);
        assert_true(pel_scene_time(scene) == back_s[i]);
        assert_int_equal(pel_scene_state(scene)->exercise->phase,
                         PELAGOS__EXERCISE_PHASE__PAUSED);
        DO(all, START, NULL, -1);
        step_to(scene, back_s[i], 32, 0.5);
        g_autofree char *facts = facts_of(all);
        char *after = state_text(scene);
        assert_string_equal(facts, straight.facts);
        assert_string_equal(after, straight.state);
        free(after);
    }
    struct pel_fault fault;
    assert_int_equal(
        command(all, PELAGOS__EXERCISE_ACTION__REWIND, NULL, 33, NULL, &fault),
        PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "time");
    finish(&straight);
    pel_exercises_destroy(all);
    pel_scene_destroy(scene);
}

static void paused_nothing_happens(void **state)
{
    (void)state;
    write_exercise("one", EXERCISE);
    struct pel_scene *scene = make_scene((struct pel_scene_options){ 0 });
    struct pel_exercises *all = make_exercises(scene, NULL);
    struct pel_fault fault;
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\"}}");
    assert_int_equal(
        command(all, PELAGOS__EXERCISE_ACTION__START, NULL, -1, NULL, &fault),
        PEL_ERR_CONFLICT);
    DO(all, LOAD, "one", -1);
    step_to(scene, 0, 5, 5);
    DO(all, START, NULL, -1);
    step_to(scene, 5, 6, 1);
    DO(all, PAUSE, NULL, -1);
    step_to(scene, 6, 12, 1);
    assert_near(pel_exercises_time(all), 1, 1e-12);
    assert_true(pel_scene_state(scene)->sky->visibility != 700);
    DO(all, START, NULL, -1);
    step_to(scene, 12, 13.4, 0.7);
    assert_true(pel_scene_state(scene)->sky->visibility != 700);
    step_to(scene, 13.4, 13.6, 0.1);
    assert_true(pel_scene_state(scene)->sky->visibility == 700);
    DO(all, STOP, NULL, -1);
    assert_int_equal(
        command(all, PELAGOS__EXERCISE_ACTION__START, NULL, -1, NULL, &fault),
        PEL_ERR_CONFLICT);
    pel_exercises_destroy(all);
    pel_scene_destroy(scene);
}

static void a_clock_of_its_own_stands_while_it_is_paused(void **state)
{
    (void)state;
    write_exercise("one", EXERCISE);
    struct pel_scene *scene = make_scene((struct pel_scene_options){ 0 });
    struct pel_exercises *all = make_exercises(scene, NULL);
    must(scene, "{\"clock\":{\"mode\":\"FREE\",\"rate\":20}}");
    DO(all, LOAD, "one", -1);
    pel_scene_settle(scene);
    assert_true(pel_scene_time(scene) == 0);
    assert_true(pel_scene_state(scene)->clock->rate == 0);
    DO(all, START, NULL, -1);
    assert_true(pel_scene_state(scene)->clock->rate == 20);
    while (pel_scene_time(scene) < 6) {
        pel_scene_catch_up(scene);
        pel_scene_settle(scene);
        g_usleep(1000);
    }
    pel_scene_catch_up(scene);
    pel_scene_settle(scene);
    DO(all, PAUSE, NULL, -1);
    double time_s = pel_scene_time(scene);
    assert_true(time_s == pel_scene_time(scene));
    assert_true(pel_scene_state(scene)->sky->visibility == 700);
    assert_true(pel_scene_state(scene)->sea->wind_speed == 12);
    DO(all, STOP, NULL, -1);
    assert_true(pel_scene_state(scene)->clock->rate == 20);
    pel_exercises_destroy(all);
    pel_scene_destroy(scene);
}

/* As after a kill: nobody says goodbye to the journal. */
static void a_restart_goes_on(void **state)
{
    (void)state;
    write_exercise("one", EXERCISE);
    g_autofree char *path = g_build_filename(folder, "s.state", NULL);
    struct outcome straight = run_by(0.5, 32);
    const struct pel_scene_options options = { .state_path = path };
    struct pel_scene *scene = make_scene(options);
    struct pel_exercises *all = make_exercises(scene, path);
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\"}}");
    DO(all, LOAD, "one", -1);
    DO(all, START, NULL, -1);
    step_to(scene, 0, 20, 0.5);
    pel_exercises_destroy(all);
    assert_true(pel_scene_destroy(scene));
    scene = make_scene(options);
    all = make_exercises(scene, path);
    assert_near(pel_exercises_time(all), 20, 1e-12);
    step_to(scene, 20, 32, 0.5);
    g_autofree char *facts = facts_of(all);
    assert_string_equal(facts, straight.facts);
    finish(&straight);
    pel_exercises_destroy(all);
    assert_true(pel_scene_destroy(scene));
}

static void another_edit_takes_it_over(void **state)
{
    (void)state;
    write_exercise("one", EXERCISE);
    struct pel_scene *scene = make_scene((struct pel_scene_options){ 0 });
    struct pel_exercises *all = make_exercises(scene, NULL);
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\"}}");
    DO(all, LOAD, "one", -1);
    DO(all, START, NULL, -1);
    must(scene, "{\"exercise\":{\"mark\":7}}");
    step_to(scene, 0, 5, 1);
    assert_true(pel_scene_state(scene)->sky->visibility != 700);
    pel_exercises_destroy(all);
    pel_scene_destroy(scene);
}

/* --- bad ones ------------------------------------------------------------- */

static void bad_ones_say_what_to_mend(void **state)
{
    (void)state;
#define ONE "{\"state\":{\"entities\":[{\"id\":1}]},"
#define EVENT(when, patch)                                                     \
    ONE "\"events\":[{\"name\":\"a\",\"when\":[" when "],\"patch\":" patch "}" \
        "]"                                                                    \
        "}"
#define RAIN "{\"state\":{\"sky\":{\"rain\":1}}}"
    static const struct {
        const char *text, *path, *message;
    } bad[] = {
        { "{", "", "" },
        { "{\"titel\":\"x\"}", "titel", "" },
        { "{\"draught\":99}", "draught", "it must be 0.1 to 50 m" },
        { "{\"title\":\"a\\u0001b\"}", "title", "control character" },
        { "{\"state\":{\"sea\":{\"windSpeed\":99}}}", "state.sea.windSpeed",
          "it must be 0 to 30 m/s" },
        { "{\"state\":{\"clock\":{\"mode\":\"FREE\"}}}", "state.clock.mode",
          "leave it out" },
        { "{\"state\":{\"exercise\":{}}}", "state.exercise", "leave it out" },
        { "{\"ownShip\":7}", "ownShip", "add it to state.entities" },
        { "{\"events\":[{\"when\":[{\"at\":1}],\"patch\":" RAIN "}]}",
          "events.0.name", "1 to 64 of" },
        { EVENT("", RAIN), "events.a.when", "1 to 8 conditions" },
        { EVENT("{}", RAIN), "events.a.when.0", "has no condition" },
        { EVENT("{\"at\":-1}", RAIN), "events.a.when.0.at",
          "it must be 0 to 1000000 s" },
        { EVENT("{\"after\":\"b\"}", RAIN), "events.a.when.0.after",
          "another event" },
        { EVENT("{\"after\":\"a\"}", RAIN), "events.a.when.0.after",
          "another event" },
        { EVENT("{\"at\":1,\"delay\":1}", RAIN), "events.a.when.0.delay",
          "needs `after`" },
        { EVENT("{\"rangeBelow\":1}", RAIN), "events.a.when.0.other",
          "is missing" },
        { EVENT("{\"at\":1,\"other\":1}", RAIN), "events.a.when.0.other",
          "needs rangeBelow" },
        { EVENT("{\"other\":9,\"rangeBelow\":1}", RAIN),
          "events.a.when.0.other", "names an entity" },
        { EVENT("{\"other\":1,\"rangeBelow\":1}", RAIN),
          "events.a.when.0.other", "another than the entity" },
        { EVENT("{\"entity\":9,\"northOf\":1}", RAIN), "events.a.when.0.entity",
          "names an entity" },
        { EVENT("{\"inside\":{\"radius\":9}}", RAIN), "events.a.when.0.inside",
          "latitude, longitude and radius" },
        { EVENT("{\"inside\":{\"corners\":\"1 2, 3 4\"}}", RAIN),
          "events.a.when.0.inside.corners", "3 to 16 pairs" },
        { EVENT("{\"at\":1}", "{}"), "events.a.patch", "what changes then" },
        { EVENT("{\"at\":1}", "{\"state\":{\"sky\":{\"rain\":-1}}}"),
          "events.a.patch.state.sky.rain", "it must be 0 to 150 mm/h" },
        { EVENT("{\"at\":1}", "{\"remove\":[\"sky.nothing\"]}"),
          "events.a.patch.sky.nothing", "" },
        { EVENT("{\"at\":1}", "{\"remove\":[\"clock\"]}"),
          "events.a.patch.remove", "neither clock nor exercise" },
        { EVENT("{\"at\":1}", "{\"state\":{\"clock\":{\"time\":1}}}"),
          "events.a.patch.state.clock.time", "leave it out" },
        { ONE "\"ships\":[{\"draught\":3}]}", "ships.0.id", "is missing" },
        { ONE "\"ships\":[{\"id\":1}]}", "ships.0.id", "another than ownShip" },
        { ONE "\"ships\":[{\"id\":2},{\"id\":2}]}", "ships.1.id",
          "another than ownShip" },
        { ONE "\"ships\":[{\"id\":9}]}", "ships.9.id", "names an entity" },
        { ONE "\"ships\":[{\"id\":2,\"draught\":99}]}", "ships.2.draught",
          "it must be 0.1 to 50 m" },
        { ONE "\"ships\":[{\"id\":2},{\"id\":3},{\"id\":4},{\"id\":5},"
              "{\"id\":6},{\"id\":7},{\"id\":8},{\"id\":9}]}",
          "ships", "at most 7 elements" },
        { ONE "\"limits\":[{\"name\":\"a\",\"speed\":1,\"ship\":9}]}",
          "limits.a.ship", "must be ownShip or one of ships" },
        { ONE "\"limits\":[{\"name\":\"a\"}]}", "limits.a.speed",
          "is missing" },
        { ONE "\"limits\":[{\"name\":\"a b\",\"speed\":1}]}", "limits.0.name",
          "1 to 64 of" },
        { ONE "\"limits\":[{\"name\":\"a\",\"speed\":1,\"area\":{}}]}",
          "limits.a.area", "latitude, longitude and radius" },
    };
    for (size_t i = 0; i < G_N_ELEMENTS(bad); i++) {
        Pelagos__Exercise *exercise;
        struct pel_fault fault = { 0 };
        if (!pel_exercise_read(bad[i].text, strlen(bad[i].text), &exercise,
                               &fault)) {
            fail_msg("accepted: %s", bad[i].text);
        }
        if (strcmp(fault.path, bad[i].path) != 0 ||
            !strstr(fault.message, bad[i].message)) {
            fail_msg("%s\n  is refused at %s: %s", bad[i].text, fault.path,
                     fault.message);
        }
    }
}

/* --- numbers -------------------------------------------------------------- */

static struct pel_exercise_body body(double east, double north, double course,
                                     double speed)
{
    return (struct pel_exercise_body){ .east_m = east,
                                       .north_m = north,
                                       .heading_rad = course * PEL_DEG,
                                       .course_rad = course * PEL_DEG,
                                       .speed_mps = speed,
                                       .length_m = 100,
                                       .beam_m = 20 };
}

static void cpa_and_hulls_are_those_of_geometry(void **state)
{
    (void)state;
    double cpa, tcpa;
    struct pel_exercise_body a = body(0, 0, 0, 5), b = body(500, 500, 270, 5);
    pel_exercise_cpa(&a, &b, &cpa, &tcpa);
    assert_near(cpa, 0, 1e-9);
    assert_near(tcpa, 100, 1e-9);
    b = body(300, 0, 0, 5);
    pel_exercise_cpa(&a, &b, &cpa, &tcpa);
    assert_near(cpa, 300, 1e-9);
    assert_near(tcpa, 0, 1e-9);
    b = body(0, 1000, 180, 5);
    b.east_m = 40;
    pel_exercise_cpa(&a, &b, &cpa, &tcpa);
    assert_near(cpa, 40, 1e-9);
    assert_near(tcpa, 100, 1e-9);
    /* Side by side, bow to bow, crossed, one in the other. */
    assert_near(pel_exercise_hulls(&a, &b), 900 - 0, 15);
    b = body(50, 0, 0, 0);
    assert_near(pel_exercise_hulls(&a, &b), 30, 1e-9);
    b = body(0, 130, 180, 0);
    assert_near(pel_exercise_hulls(&a, &b), 30, 1e-9);
    b = body(10, 10, 90, 0);
    assert_true(pel_exercise_hulls(&a, &b) == 0);
    b = body(0, 0, 0, 0);
    b.length_m = 10;
    b.beam_m = 2;
    assert_true(pel_exercise_hulls(&a, &b) == 0);
    b.length_m = 0;
    assert_true(isnan(pel_exercise_hulls(&a, &b)));
}

static void areas_hold_what_is_in_them(void **state)
{
    (void)state;
    Pelagos__ExerciseArea area = PELAGOS__EXERCISE_AREA__INIT;
    area.latitude = 52.6;
    area.longitude = 5.2;
    area.radius = 1000;
    /* A minute of latitude there is 1854.6 m, of longitude 1129.0 m. */
    assert_true(pel_exercise_in_area(&area, 52.6 + 999 / 1854.6 / 60, 5.2));
    assert_false(pel_exercise_in_area(&area, 52.6 + 1001 / 1854.6 / 60, 5.2));
    assert_true(pel_exercise_in_area(&area, 52.6, 5.2 - 999 / 1129.0 / 60));
    assert_false(pel_exercise_in_area(&area, 52.6, 5.2 - 1001 / 1129.0 / 60));
    area.corners = "10 179, 11 -179, 9 -179";
    assert_true(pel_exercise_in_area(&area, 10, 179.99));
    assert_true(pel_exercise_in_area(&area, 10, -179.5));
    assert_false(pel_exercise_in_area(&area, 10, 178.9));
    assert_false(pel_exercise_in_area(&area, 10, -178.9));
    assert_false(pel_exercise_in_area(&area, 10.9, 179.5));
}

/* 256 entities, 8 own ships and 64 events, of which each asks for distances. */
static void a_moment_is_cheap(void **state)
{
    (void)state;
    GString *text = g_string_new("{\"state\":{\"entities\":[{\"id\":1}");
    for (int i = 2; i <= 256; i++) {
        g_string_append_printf(text,
                               ",{\"id\":%d,\"latitude\":%.5f,\"speed\":3}", i,
                               52.6 + i * 0.001);
    }
    g_string_append(text, "]},\"ships\":[{\"id\":250},{\"id\":251},"
                          "{\"id\":252},{\"id\":253},{\"id\":254},{\"id\":255},"
                          "{\"id\":256}],\"events\":[");
    for (int i = 0; i < 64; i++) {
        g_string_append_printf(
            text,
            "%s{\"name\":\"e%d\",\"when\":[{\"other\":%d,\"cpaBelow\":0},"
            "{\"entity\":%d,\"inside\":{\"corners\":\"1 1, 2 1, 2 2, 1 2\"}}],"
            "\"patch\":{\"state\":{\"sky\":{\"rain\":1}}}}",
            i ? "," : "", i, 255 - i, 100 + i);
    }
    g_string_append(text, "]}");
    write_exercise("many", text->str);
    struct pel_scene *scene = make_scene((struct pel_scene_options){ 0 });
    struct pel_exercises *all = make_exercises(scene, NULL);
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\"}}");
    DO(all, LOAD, "many", -1);
    DO(all, START, NULL, -1);
    int64_t start = pel_now_ns();
    step_to(scene, 0, 9.95, 9.95);
    print_message("%.0f us a moment\n",
                  (double)(pel_now_ns() - start) * 1e-3 / 100);
    /* Eight own ships share 128 targets, one another's among them. */
    g_autofree char *facts = facts_of_ship(all, 256);
    g_auto(GStrv) parts = g_strsplit(facts, ",range_", 0);
    assert_int_equal(g_strv_length(parts) - 1, 16);
    assert_true(g_str_has_prefix(parts[1], "1_m,"));
    assert_true(g_str_has_prefix(parts[16], "255_m,"));
    g_string_free(text, TRUE);
    pel_exercises_destroy(all);
    pel_scene_destroy(scene);
}

/* --- steps that wait for a sea -------------------------------------------- */

struct ending {
    int count;
    enum pel_err err;
};

static void on_end(void *user, enum pel_err err, const struct pel_fault *fault)
{
    struct ending *end = user;
    assert_true(err == PEL_OK || *fault->message);
    end->count++;
    end->err = err;
}

/* Held at an event that asks for another sea, at 4 s. */
static struct pel_scene *held(struct pel_exercises **all, struct ending *end)
{
    Pelagos__ClockStep step = PELAGOS__CLOCK_STEP__INIT;
    struct pel_scene *scene = make_scene((struct pel_scene_options){ 0 });
    write_exercise("seas",
                   "{\"state\":{\"entities\":[{\"id\":1}]},\"events\":["
                   "{\"name\":\"storm\",\"when\":[{\"at\":4}],\"patch\":"
                   "{\"state\":{\"sea\":{\"windSpeed\":20}}}},"
                   "{\"name\":\"swell\",\"when\":[{\"after\":\"storm\","
                   "\"delay\":2}],\"patch\":{\"state\":{\"sea\":{\"swell\":"
                   "[{\"height\":2}]}}}}]}");
    *all = make_exercises(scene, NULL);
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\"}}");
    DO(*all, LOAD, "seas", -1);
    DO(*all, START, NULL, -1);
    step.has_seconds = true;
    step.seconds = 9;
    *end = (struct ending){ 0 };
    assert_true(pel_scene_submit_step(scene, &step, on_end, end));
    assert_int_equal(end->count, 0);
    assert_true(pel_scene_holds(scene));
    assert_near(pel_scene_time(scene), 4, 1e-9);
    assert_near(pel_scene_state(scene)->sea->wind_speed, 8, 1e-9);
    return scene;
}

static void a_step_waits_for_the_seas_of_its_events(void **state)
{
    (void)state;
    struct pel_exercises *all;
    struct ending end;
    struct pel_fault fault;
    struct pel_scene *scene = held(&all, &end);
    /* Others go on meanwhile, but for steps and a rewind. */
    assert_int_equal(pel_scene_step(scene, 1, &fault), PEL_ERR_BUSY);
    assert_int_equal(
        command(all, PELAGOS__EXERCISE_ACTION__REWIND, NULL, 1, NULL, &fault),
        PEL_ERR_BUSY);
    must(scene, "{\"sky\":{\"rain\":3}}");
    pel_scene_settle(scene); /* the first, and the second, at which it is held
                                again */
    assert_int_equal(end.count, 1);
    assert_int_equal(end.err, PEL_OK);
    assert_false(pel_scene_holds(scene));
    assert_near(pel_scene_time(scene), 9, 0);
    const Pelagos__State *now = pel_scene_state(scene);
    assert_near(now->sea->wind_speed, 20, 0);
    assert_int_equal(now->sea->n_swell, 1);
    assert_int_equal(now->exercise->n_events, 2);
    assert_near(now->exercise->events[0]->time, 4, 1e-9);
    assert_near(now->exercise->events[1]->time, 6, 1e-9);
    assert_int_equal(pel_scene_step(scene, 1, &fault), PEL_OK);
    pel_exercises_destroy(all);
    pel_scene_destroy(scene);
}

static void a_paced_clock_stands_meanwhile(void **state)
{
    (void)state;
    struct pel_exercises *all;
    struct ending end;
    struct pel_fault fault;
    struct pel_scene *scene = held(&all, &end);
    pel_scene_settle(scene);
    must(scene, "{\"clock\":{\"mode\":\"PACED\"}}");
    DO(all, LOAD, "seas", -1);
    DO(all, START, NULL, -1);
    assert_int_equal(pel_scene_step(scene, 3.5, &fault), PEL_OK);
    assert_false(pel_scene_holds(scene));
    assert_int_equal(pel_scene_step(scene, 1, &fault), PEL_OK);
    assert_true(pel_scene_holds(scene));
    assert_near(pel_scene_time(scene), 4, 1e-9);
    pel_scene_settle(scene);
    assert_false(pel_scene_holds(scene));
    assert_near(pel_scene_time(scene), 4.5, 1e-9);
    pel_exercises_destroy(all);
    pel_scene_destroy(scene);
}

static void a_step_that_waits_ends_in_any_case(void **state)
{
    (void)state;
    struct pel_exercises *all;
    struct ending end;
    /* Somebody sets the clock. */
    struct pel_scene *scene = held(&all, &end);
    must(scene, "{\"clock\":{\"time\":100}}");
    pel_scene_settle(scene);
    assert_int_equal(end.count, 1);
    assert_int_equal(end.err, PEL_ERR_CONFLICT);
    assert_near(pel_scene_time(scene), 100, 0);
    pel_exercises_destroy(all);
    pel_scene_destroy(scene);
    /* Another exercise is loaded. */
    scene = held(&all, &end);
    DO(all, LOAD, "one", -1);
    pel_scene_settle(scene);
    assert_int_equal(end.count, 1);
    assert_int_equal(end.err, PEL_ERR_CONFLICT);
    assert_near(pel_scene_state(scene)->sea->wind_speed, 6, 1e-9);
    DO(all, START, NULL, -1); /* what the other asked for does not take it */
    pel_exercises_destroy(all);
    pel_scene_destroy(scene);
    /* There are no exercises any more. */
    scene = held(&all, &end);
    pel_exercises_destroy(all);
    pel_scene_settle(scene);
    assert_int_equal(end.count, 1);
    assert_near(pel_scene_time(scene), 9, 0);
    pel_scene_destroy(scene);
    /* The daemon stops. */
    scene = held(&all, &end);
    pel_exercises_destroy(all);
    pel_scene_destroy(scene);
    assert_int_equal(end.count, 1);
    assert_int_equal(end.err, PEL_ERR_CONFLICT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_ones_say_what_to_mend),
        cmocka_unit_test(cpa_and_hulls_are_those_of_geometry),
        cmocka_unit_test(areas_hold_what_is_in_them),
        cmocka_unit_test(runs_are_the_same_whatever_the_steps),
        cmocka_unit_test(a_log_replays_without_an_exercise),
        cmocka_unit_test(rewound_it_goes_the_same_way),
        cmocka_unit_test(paused_nothing_happens),
        cmocka_unit_test(a_clock_of_its_own_stands_while_it_is_paused),
        cmocka_unit_test(a_restart_goes_on),
        cmocka_unit_test(another_edit_takes_it_over),
        cmocka_unit_test(a_step_waits_for_the_seas_of_its_events),
        cmocka_unit_test(a_paced_clock_stands_meanwhile),
        cmocka_unit_test(a_step_that_waits_ends_in_any_case),
        cmocka_unit_test(a_moment_is_cheap),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
