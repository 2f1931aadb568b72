#include "scene/scene.h"

#include <float.h>
#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/clock.h"
#include "bounds.h"
#include "path.h"
#include "scene/scene_testkit.h"
#include "scene/store.h"

static struct pel_scene *make(const char *path)
{
    return make_scene(
        (struct pel_scene_options){ .state_path = path, .wave_count = 60 });
}

static double number(struct pel_scene *scene, const char *path)
{
    char text[64];
    if (pel_path_get(pel_scene_state(scene), path, text, sizeof text, NULL)) {
        fail_msg("%s", path);
    }
    assert_true(text[0]);
    return strtod(text, NULL);
}

/* What a clock that is reset leaves undefined is not used for the poses. */
static void a_clock_is_reset_with_a_ship_under_way(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL);
    struct pel_fault fault;
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State part = PELAGOS__STATE__INIT;
    Pelagos__Entity ship = PELAGOS__ENTITY__INIT, *ships = &ship;
    char *paths[] = { "clock", "entities.1.heading" };
    ship.has_id = ship.has_speed = true;
    ship.id = 1;
    ship.speed = 4;
    part.n_entities = 1;
    part.entities = &ships;
    patch.state = &part;
    patch.n_remove = 2;
    patch.remove = paths;
    assert_int_equal(pel_scene_patch(scene, &patch, &fault), PEL_OK);
    assert_true(pel_scene_state(scene)->clock->reckoning == 60);
    pel_scene_destroy(scene);
}

static void defaults_are_all_there(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL);
    const Pelagos__State *now = pel_scene_state(scene);
    assert_true(now->sea->has_wind_speed && now->sea->wind_speed == 8);
    assert_true(now->clock->has_rate && now->water->has_chlorophyll);
    assert_string_equal(now->clock->utc, "2026-06-21T12:00:00Z");
    assert_int_equal(now->n_entities, 1);
    assert_string_equal(now->entities[0]->name, "ownship");
    assert_int_equal(now->n_views, 1);
    assert_true(now->views[0]->has_width && now->views[0]->width == 1280);
    assert_false(now->sky->has_sun_elevation);
    assert_null(now->views[0]->frustum);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    assert_int_equal(pel_snapshot_find_view(s, "bridge"), 0);
    assert_int_equal(pel_snapshot_find_view(s, "stern"), -1);
    assert_int_equal(s->views[0].entity, 0);
    pel_snapshot_unref(s);
    pel_scene_destroy(scene);
}

static void refusals_change_nothing(void **state)
{
    (void)state;
    static const struct {
        const char *json;
        enum pel_err err;
        const char *path;
    } bad[] = {
        { "{\"sea\":{\"windSpeed\":31}}", PEL_ERR_OUT_OF_RANGE,
          "sea.windSpeed" },
        { "{\"sea\":{\"windSpeed\":12,\"fetch\":1}}", PEL_ERR_OUT_OF_RANGE,
          "sea.fetch" },
        { "{\"sea\":{\"swell\":[{},{\"height\":16}]}}", PEL_ERR_OUT_OF_RANGE,
          "sea.swell.1.height" },
        { "{\"sea\":{\"swell\":[{},{},{},{},{},{},{},{},{}]}}",
          PEL_ERR_OUT_OF_RANGE, "sea.swell" },
        { "{\"views\":{\"bridge\":{\"width\":8}}}", PEL_ERR_OUT_OF_RANGE,
          "views.bridge.width" },
        { "{\"views\":{\"bridge\":{\"entity\":9}}}", PEL_ERR_CONFLICT,
          "views.bridge.entity" },
        { "{\"views\":{\"bridge\":{\"meter\":\"two words\"}}}", PEL_ERR_INVALID,
          "views.bridge.meter" },
        { "{\"views\":{\"bridge\":{\"glare\":0.6}}}", PEL_ERR_OUT_OF_RANGE,
          "views.bridge.glare" },
        { "{\"entities\":null}", PEL_ERR_CONFLICT, "views.bridge.entity" },
        { "{\"views\":{\"br idge\":{}}}", PEL_ERR_INVALID, "views" },
        { "{\"views\":{\"bridge\":{\"frustum\":{\"left\":-5}}}}",
          PEL_ERR_INVALID, "views.bridge.frustum" },
        { "{\"views\":{\"bridge\":{\"frustum\":{\"left\":5,\"right\":5,"
          "\"top\":1,\"bottom\":-1}}}}",
          PEL_ERR_INVALID, "views.bridge.frustum" },
        { "{\"entities\":{\"tug\":{\"heading\":5}}}", PEL_ERR_NOT_FOUND,
          "entities.tug" },
        { "{\"entities\":[{\"heading\":5}],\"views\":[]}", PEL_ERR_NOT_FOUND,
          "entities." },
        { "{\"views\":{\"stern\":null}}", PEL_ERR_NOT_FOUND, "views.stern" },
        { "{\"water\":{\"depth\":0}}", PEL_ERR_OUT_OF_RANGE, "water.depth" },
        { "{\"water\":{\"jerlov\":\"IV\"}}", PEL_ERR_INVALID, "water.jerlov" },
        { "{\"water\":{\"absorption680\":0.5,\"scattering680\":1}}",
          PEL_ERR_INVALID, "water" },
        { "{\"water\":{\"albedo550\":0.5}}", PEL_ERR_INVALID, "water" },
        { "{\"water\":{\"jerlov\":\"IA\",\"named\":\"BALTIC\"}}",
          PEL_ERR_CONFLICT, "water" },
        { "{\"clock\":{\"utc\":\"yesterday\"}}", PEL_ERR_INVALID, "clock.utc" },
        { "{\"clock\":{\"utc\":\"2026-06-21T12:00:00\"}}", PEL_ERR_INVALID,
          "clock.utc" },
        { "{\"clock\":{\"utc\":\"1812-06-21T12:00:00Z\"}}",
          PEL_ERR_OUT_OF_RANGE, "clock.utc" },
        { "{\"entities\":{\"1\":{\"name\":\"a\\nb\"}}}", PEL_ERR_INVALID,
          "entities.1.name" },
    };
    struct pel_scene *scene = make(NULL);
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\"}}");
    char *before = pel_json_from_message(&pel_scene_state(scene)->base, false);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        struct pel_fault fault;
        enum pel_err err = patch(scene, bad[i].json, &fault);
        if (err != bad[i].err || strcmp(fault.path, bad[i].path) != 0) {
            fail_msg("%s: %s at '%s': %s", bad[i].json, pel_err_name(err),
                     fault.path, fault.message);
        }
        char *after =
            pel_json_from_message(&pel_scene_state(scene)->base, false);
        assert_string_equal(after, before);
        free(after);
    }
    struct pel_fault fault;
    assert_int_equal(patch(scene, bad[0].json, &fault), PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.message, "sea.windSpeed is 31 m/s; it must be "
                                       "0 to 30 m/s");
    assert_string_equal(fault.value, "31");
    assert_string_equal(fault.unit, "m/s");
    assert_true(fault.minimum == 0 && fault.maximum == 30);
    free(before);
    pel_scene_destroy(scene);
}

/* What JSON cannot say but protobuf can. */
static void binary_values_are_tested_too(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL);
    struct pel_fault fault;
    Pelagos__Patch p = PELAGOS__PATCH__INIT;
    Pelagos__State s = PELAGOS__STATE__INIT;
    Pelagos__Sea sea = PELAGOS__SEA__INIT;
    p.state = &s;
    s.sea = &sea;
    sea.has_wind_speed = true;
    const double values[] = { NAN, INFINITY, -INFINITY, -DBL_MIN };
    for (size_t i = 0; i < 4; i++) {
        sea.wind_speed = values[i];
        assert_int_equal(pel_scene_patch(scene, &p, &fault),
                         PEL_ERR_OUT_OF_RANGE);
        assert_string_equal(fault.path, "sea.windSpeed");
    }
    sea.has_wind_speed = false;
    sea.has_spectrum = true;
    sea.spectrum = (Pelagos__SpectrumKind)77;
    assert_int_equal(pel_scene_patch(scene, &p, &fault), PEL_ERR_INVALID);
    s.sea = NULL;
    Pelagos__Entity entity = PELAGOS__ENTITY__INIT;
    Pelagos__Entity *entities[] = { &entity };
    s.n_entities = 1;
    s.entities = entities;
    entity.has_id = true;
    entity.id = 1;
    entity.name = (char *)"\xff";
    assert_int_equal(pel_scene_patch(scene, &p, &fault), PEL_ERR_INVALID);
    entity.name = NULL;
    entity.has_heading = entity.has_pose_time = true;
    entity.pose_time = NAN;
    assert_int_equal(pel_scene_patch(scene, &p, &fault), PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "entities.1.poseTime");
    Pelagos__Clock clock = PELAGOS__CLOCK__INIT;
    s.n_entities = 0;
    s.clock = &clock;
    clock.has_time = true;
    clock.time = NAN;
    assert_int_equal(pel_scene_patch(scene, &p, &fault), PEL_ERR_OUT_OF_RANGE);
    pel_scene_destroy(scene);
}

static void edits_merge_and_reset(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL);
    double revision = number(scene, "revision");
    must(scene, "{\"sea\":{\"windSpeed\":15},\"sky\":{\"sunElevation\":10},"
                "\"entities\":{\"7\":{\"name\":\"tug\"}},"
                "\"views\":{\"tug\":{\"entity\":7,\"exposure\":null}}}");
    assert_true(number(scene, "revision") == revision + 1);
    assert_true(number(scene, "sea.windSpeed") == 15);
    assert_true(number(scene, "sea.fetch") == 200000);
    assert_true(number(scene, "views.tug.fieldOfView") == 60);
    must(scene, "{\"entities\":{\"tug\":{\"heading\":33}}}");
    assert_true(number(scene, "entities.7.heading") == 33);
    must(scene, "{\"sea\":{\"windSpeed\":null},\"sky\":{\"sunElevation\":null},"
                "\"views\":{\"tug\":null},\"entities\":{\"7\":null}}");
    assert_true(number(scene, "sea.windSpeed") == 8);
    assert_false(pel_scene_state(scene)->sky->has_sun_elevation);
    assert_int_equal(pel_scene_state(scene)->n_views, 1);
    assert_int_equal(pel_scene_state(scene)->n_entities, 1);
    must(scene, "{\"sea\":null,\"clock\":null}");
    /* What a client reads it may send back. */
    char *all = pel_json_from_message(&pel_scene_state(scene)->base, true);
    must(scene, all);
    free(all);
    /* A name that two share names neither. */
    must(scene, "{\"entities\":{\"8\":{\"name\":\"ownship\"}}}");
    struct pel_fault fault;
    assert_int_equal(
        patch(scene, "{\"entities\":{\"ownship\":{\"roll\":3}}}", &fault),
        PEL_ERR_CONFLICT);
    assert_int_equal(patch(scene, "{\"entities\":{\"ownship\":null}}", &fault),
                     PEL_ERR_CONFLICT);
    pel_scene_destroy(scene);
}

static void limits_hold(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL);
    char json[80];
    struct pel_fault fault;
    for (int i = 1; i < PEL_MAX_VIEWS; i++) {
        snprintf(json, sizeof json, "{\"views\":{\"v%d\":{}}}", i);
        must(scene, json);
    }
    assert_int_equal(patch(scene, "{\"views\":{\"more\":{}}}", &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "views");
    for (int i = 2; i <= PEL_MAX_ENTITIES; i++) {
        snprintf(json, sizeof json, "{\"entities\":{\"%d\":{}}}", i);
        must(scene, json);
    }
    assert_int_equal(patch(scene, "{\"entities\":{\"999\":{}}}", &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "entities");
    pel_scene_destroy(scene);
}

/* A preset is kept as it was given, tested as a patch would be, and bounded. */
static void presets_are_tested_and_bounded(void **state)
{
    (void)state;
    static const struct {
        const char *json;
        enum pel_err err;
        const char *path;
    } bad[] = {
        { "{\"presets\":{\"a b\":{\"patch\":\"{}\"}}}", PEL_ERR_INVALID,
          "presets" },
        { "{\"presets\":[{\"patch\":\"{}\"}]}", PEL_ERR_INVALID, "presets" },
        { "{\"presets\":{\"a\":{\"patch\":\"{\"}}}", PEL_ERR_MALFORMED,
          "presets.a.patch" },
        { "{\"presets\":{\"a\":{\"patch\":\"{\\\"sea\\\":{\\\"x\\\":1}}\"}}}",
          PEL_ERR_NOT_FOUND, "presets.a.patch" },
        { "{\"presets\":{\"a\":{\"patch\":"
          "\"{\\\"sea\\\":{\\\"windSpeed\\\":31}}\"}}}",
          PEL_ERR_OUT_OF_RANGE, "presets.a.patch" },
        { "{\"presets\":{\"a\":{\"patch\":\"{\\\"presets\\\":null}\"}}}",
          PEL_ERR_INVALID, "presets.a.patch" },
    };
    struct pel_scene *scene = make(NULL);
    struct pel_fault fault;
    char json[80];
    for (size_t i = 0; i < G_N_ELEMENTS(bad); i++) {
        assert_int_equal(patch(scene, bad[i].json, &fault), bad[i].err);
        assert_string_equal(fault.path, bad[i].path);
    }
    assert_int_equal(pel_scene_state(scene)->n_presets, 0);
    for (int i = 0; i < PEL_BOUND_PRESETS; i++) {
        snprintf(json, sizeof json,
                 "{\"presets\":{\"p%d\":{\"patch\":\"{}\"}}}", i);
        must(scene, json);
    }
    assert_int_equal(
        patch(scene, "{\"presets\":{\"more\":{\"patch\":\"{}\"}}}", &fault),
        PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "presets");
    must(scene, "{\"presets\":{\"p3\":null}}");
    must(scene, "{\"presets\":{\"p4\":{\"title\":\"four\"}}}");
    assert_int_equal(pel_scene_state(scene)->n_presets, PEL_BOUND_PRESETS - 1);
    assert_string_equal(pel_scene_state(scene)->presets[3]->title, "four");
    assert_string_equal(pel_scene_state(scene)->presets[3]->patch, "{}");
    pel_scene_destroy(scene);
}

/* Two states take turns: an edit allocates what it changes, not 256 entities
 * again. */
static void the_state_before_last_is_the_memory_of_the_next(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL);
    const Pelagos__State *seen[4];
    void *taken[4][64]; /* what is freed is given to these */
    struct pel_fault fault;
    for (int i = 0; i < 4; i++) {
        must(scene, i % 2 ? "{\"entities\":{\"1\":{\"speed\":3}}}"
                          : "{\"entities\":{\"1\":{\"speed\":4}}}");
        seen[i] = pel_scene_state(scene);
        for (int k = 0; k < 64; k++) {
            taken[i][k] = malloc(sizeof *seen[i]);
        }
        assert_int_equal(patch(scene, "{\"sea\":{\"windSpeed\":99}}", &fault),
                         PEL_ERR_OUT_OF_RANGE);
    }
    assert_ptr_equal(seen[0], seen[2]);
    assert_ptr_equal(seen[1], seen[3]);
    for (int i = 0; i < 4 * 64; i++) {
        free(taken[i / 64][i % 64]);
    }
    pel_scene_destroy(scene);
}

/* In whatever order, and however often it says one. */
static void a_patch_brings_a_thousand_elements(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL);
    Pelagos__Patch whole = PELAGOS__PATCH__INIT;
    Pelagos__State part = PELAGOS__STATE__INIT;
    static Pelagos__Entity ship[1024];
    Pelagos__Entity *ships[1024];
    struct pel_fault fault;
    for (int i = 0; i < 1024; i++) {
        ship[i] = (Pelagos__Entity)PELAGOS__ENTITY__INIT;
        ship[i].has_id = ship[i].has_altitude = true;
        ship[i].id = (uint32_t)(256 - i % 256);
        ship[i].altitude = i;
        ships[i] = &ship[i];
    }
    part.entities = ships;
    part.n_entities = 1024;
    whole.state = &part;
    for (int i = 0; i < 2; i++) {
        assert_int_equal(pel_scene_patch(scene, &whole, &fault), PEL_OK);
        assert_int_equal(pel_scene_state(scene)->n_entities, 256);
        for (uint32_t id = 1; id <= 256; id++) {
            assert_true(entity_of(scene, id)->altitude == 1024 - id);
        }
    }
    pel_scene_destroy(scene);
}

static void the_clock_has_modes(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL);
    struct pel_fault fault;
    assert_int_equal(pel_scene_step(scene, 1, &fault), PEL_ERR_CONFLICT);
    must(scene, "{\"clock\":{\"rate\":100}}");
    int64_t start = pel_now_ns();
    double before = pel_scene_time(scene);
    g_usleep(20000); /* at least that */
    double passed = pel_scene_time(scene) - before;
    double outside_s = (double)(pel_now_ns() - start) * 1e-9;
    assert_true(passed >= 2.0 && passed <= 100 * outside_s + 1e-6);
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\",\"time\":50}}");
    g_usleep(2000);
    assert_true(pel_scene_time(scene) == 50);
    assert_int_equal(pel_scene_step(scene, 0.25, &fault), PEL_OK);
    assert_true(number(scene, "clock.time") == 50.25);
    const double bad[] = { -1, NAN, INFINITY, 3601 };
    for (size_t i = 0; i < 4; i++) {
        assert_int_equal(pel_scene_step(scene, bad[i], &fault),
                         PEL_ERR_OUT_OF_RANGE);
    }
    /* Another edit leaves the time alone. */
    must(scene, "{\"sea\":{\"windSpeed\":3}}");
    assert_true(pel_scene_time(scene) == 50.25);
    must(scene, "{\"clock\":{\"mode\":\"PACED\"}}");
    assert_int_equal(pel_scene_step(scene, 1, &fault), PEL_OK);
    assert_true(pel_scene_time(scene) == 51.25);
    pel_scene_destroy(scene);
}

static void a_heading_alone_does_not_throw_the_ship_back(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL);
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\",\"time\":0},"
                "\"origin\":{\"latitude\":0,\"longitude\":0},"
                "\"entities\":{\"1\":{\"latitude\":0,\"longitude\":0,"
                "\"speed\":10,\"course\":90,\"turnRate\":0}}}");
    assert_int_equal(pel_scene_step(scene, 30, NULL), PEL_OK);
    must(scene, "{\"entities\":{\"1\":{\"heading\":45}}}");
    /* 300 m east on the equator: 6378137 m a radian. */
    assert_true(fabs(number(scene, "entities.1.longitude") -
                     300 / (6378137 * PEL_DEG)) < 1e-9);
    assert_true(number(scene, "entities.1.poseTime") == 30);
    /* Setting the clock carries the ship along where it is. */
    assert_int_equal(pel_scene_step(scene, 5, NULL), PEL_OK);
    must(scene, "{\"clock\":{\"time\":5000}}");
    assert_true(fabs(number(scene, "entities.1.longitude") -
                     350 / (6378137 * PEL_DEG)) < 1e-9);
    assert_true(number(scene, "entities.1.poseTime") == 5000);
    /* Removing a field is an edit of the pose too. */
    assert_int_equal(pel_scene_step(scene, 10, NULL), PEL_OK);
    must(scene, "{\"entities\":{\"1\":{\"speed\":null}}}");
    assert_true(fabs(number(scene, "entities.1.longitude") -
                     450 / (6378137 * PEL_DEG)) < 1e-9);
    assert_true(number(scene, "entities.1.speed") == 0);
    /* Over the pole it goes on, southward. */
    must(scene, "{\"entities\":{\"1\":{\"latitude\":89.99,\"longitude\":10,"
                "\"speed\":100,\"course\":0,\"heading\":0}}}");
    assert_int_equal(pel_scene_step(scene, 60, NULL), PEL_OK);
    must(scene, "{\"entities\":{\"1\":{\"speed\":1}}}");
    /* Meridian of WGS 84 at the pole: a^2 / b. */
    double past = 6000 / (6399593.6258 * PEL_DEG) - 0.01;
    assert_true(fabs(90 - number(scene, "entities.1.latitude") - past) < 1e-9);
    assert_true(fabs(number(scene, "entities.1.longitude") + 170) < 1e-6);
    assert_true(fabs(number(scene, "entities.1.course") - 180) < 1e-6);
    assert_true(fabs(number(scene, "entities.1.heading") - 180) < 1e-6);
    /* An explicit time is taken. */
    must(scene, "{\"entities\":{\"1\":{\"heading\":1,\"poseTime\":5073}}}");
    assert_true(number(scene, "entities.1.poseTime") == 5073);
    pel_scene_destroy(scene);
}

static int commits;

static void count_commit(void *user)
{
    assert_ptr_equal(user, &commits);
    commits++;
}

static void snapshots_share_the_sea(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL);
    commits = 0;
    pel_scene_on_commit(scene, count_commit, &commits);
    const struct pel_snapshot *a = pel_scene_snapshot(scene);
    must(scene, "{\"entities\":{\"1\":{\"heading\":45}}}");
    const struct pel_snapshot *b = pel_scene_snapshot(scene);
    must(scene, "{\"sea\":{\"windDirection\":180,\"windSpeed\":12}}");
    const struct pel_snapshot *c = pel_scene_snapshot(scene);
    assert_ptr_equal(a->sea, b->sea);
    assert_ptr_not_equal(b->sea, c->sea);
    assert_int_equal(commits, 2);
    /* From the south: it blows north, π/2 from east. */
    assert_true(fabs(c->wind_to_rad - PEL_PI / 2) < 1e-12);
    assert_true(pel_snapshot_sea(c)->desc.wind_mps == 12);
    pel_scene_destroy(scene);
    assert_true(fabs(pel_snapshot_sea(a)->desc.wind_mps - 8) <
                1e-12); /* still there */
    pel_snapshot_unref(a);
    pel_snapshot_unref(b);
    pel_snapshot_unref(c);
}

static char *temporary(void)
{
    char *directory = g_dir_make_tmp("pelagos-XXXXXX", NULL);
    char *path = g_build_filename(directory, "state.json", NULL);
    g_free(directory);
    return path;
}

static void remove_state(const char *path)
{
    g_autofree char *before = g_strconcat(path, PEL_STATE_BEFORE, NULL);
    unlink(path);
    unlink(before);
}

static void clean(char *path)
{
    char *directory = g_path_get_dirname(path);
    char *bad = g_strconcat(path, ".bad", NULL);
    remove_state(path);
    unlink(bad);
    assert_int_equal(rmdir(directory), 0); /* and no *.new is left */
    g_free(bad);
    g_free(directory);
    g_free(path);
}

static void the_state_outlives_the_daemon(void **state)
{
    (void)state;
    char *path = temporary();
    struct pel_scene *scene = make(path);
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\",\"time\":12.5},"
                "\"sea\":{\"windSpeed\":17.3,\"swell\":[[2,9]]},"
                "\"views\":{\"stern\":{\"yaw\":180}}}");
    char *before = pel_json_from_message(&pel_scene_state(scene)->base, true);
    /* A thread writes it, without a destroy. */
    char *copy = g_strconcat(path, ".copy", NULL), *text = NULL;
    gsize size;
    for (int i = 0; i < 6000 && !(text && strstr(text, "17.3")); i++) {
        g_free(text);
        g_usleep(10000);
        g_main_context_iteration(NULL, FALSE);
        assert_true(g_file_get_contents(path, &text, &size, NULL));
    }
    assert_non_null(strstr(text, "17.3"));
    /* Elsewhere: this daemon has it. */
    assert_true(g_file_set_contents(copy, text, (gssize)size, NULL));
    struct pel_scene *other = make(copy);
    char *after = pel_json_from_message(&pel_scene_state(other)->base, true);
    assert_string_equal(after, before);
    free(after);
    g_free(text);
    pel_scene_destroy(other);
    remove_state(copy);
    g_free(copy);
    must(scene, "{\"sea\":{\"windSpeed\":1}}");
    pel_scene_destroy(scene);
    scene = make(path);
    assert_true(number(scene, "sea.windSpeed") == 1);
    pel_scene_destroy(scene);
    free(before);
    clean(path);
}

/* What a process that is killed leaves: the files as they are now. */
static void leave(const char *path, const char *to)
{
    for (int i = 0; i < 2; i++) {
        g_autofree char *from = g_strconcat(path, i ? ".journal" : "", NULL);
        g_autofree char *copy = g_strconcat(to, i ? ".journal" : "", NULL);
        g_autofree char *bytes = NULL;
        gsize size;
        assert_true(g_file_get_contents(from, &bytes, &size, NULL));
        assert_true(g_file_set_contents(copy, bytes, (gssize)size, NULL));
    }
}

/* At every edit, among them ones that the journal begins anew in. */
static void the_journal_has_every_edit(void **state)
{
    (void)state;
    char *path = temporary(), *copy = g_strconcat(path, ".copy", NULL);
    struct pel_scene *scene = make(path);
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\",\"time\":5}}");
    struct pel_fault fault;
    char name[65];
    memset(name, 'n', sizeof name - 1);
    name[sizeof name - 1] = '\0';
    for (int i = 0; i < 9000; i++) {
        g_autofree char *edit = g_strdup_printf(
            "{\"entities\":{\"%d\":{\"name\":\"%s\",\"latitude\":%d.5,"
            "\"speed\":3},\"1\":{\"heading\":%d}}}",
            2 + i / 70 % 100, name, i % 60, i % 360);
        must(scene, edit);
        assert_int_equal(pel_scene_step(scene, 0.1, &fault), PEL_OK);
        g_main_context_iteration(NULL, FALSE);
        if (i % 1500 == 0 || i == 8999) {
            leave(path, copy);
            char *before =
                pel_json_from_message(&pel_scene_state(scene)->base, true);
            struct pel_scene *other = make(copy);
            char *after =
                pel_json_from_message(&pel_scene_state(other)->base, true);
            assert_string_equal(after, before);
            free(after);
            free(before);
            pel_scene_destroy(other);
        }
    }
    pel_scene_destroy(scene);
    remove_state(copy);
    g_free(copy);
    clean(path);
}

static enum pel_err refused(const char *path, const char *words)
{
    struct pel_scene_options options = { .state_path = path };
    struct pel_scene *scene = NULL;
    struct pel_fault fault;
    enum pel_err err = pel_scene_create(&options, &scene, &fault);
    assert_null(scene);
    if (!strstr(fault.message, words) || !strstr(fault.message, "--state")) {
        fail_msg("%s", fault.message);
    }
    return err;
}

static void a_state_is_one_daemons(void **state)
{
    (void)state;
    char *path = temporary();
    struct pel_scene *scene = make(path);
    assert_int_equal(refused(path, "another daemon"), PEL_ERR_CONFLICT);
    pel_scene_destroy(scene);
    scene = make(path);
    pel_scene_destroy(scene);
    clean(path);
}

static void a_state_that_cannot_be_kept_is_no_start(void **state)
{
    (void)state;
    char *path = temporary();
    char *directory = g_path_get_dirname(path);
    char *beyond = g_build_filename(path, "state.json", NULL);
    assert_int_equal(refused(beyond, "cannot be written"), PEL_ERR_IO);
    assert_int_equal(refused(directory, "is a directory"), PEL_ERR_IO);
    char *lock = g_strconcat(directory, ".lock", NULL);
    assert_false(g_file_test(lock, G_FILE_TEST_EXISTS));
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(refused(path, "is a FIFO"), PEL_ERR_IO);
    unlink(path);
    char *new = g_strconcat(path, ".new", NULL);
    assert_int_equal(mkdir(new, 0700), 0);
    assert_int_equal(refused(path, "cannot be written"), PEL_ERR_IO);
    assert_int_equal(rmdir(new), 0);
    g_free(new);
    g_free(lock);
    g_free(beyond);
    g_free(directory);
    clean(path);
}

static char *bad_name(const char *path, int number)
{
    return number == 1 ? g_strconcat(path, ".bad", NULL)
                       : g_strdup_printf("%s.bad.%d", path, number);
}

static void bad_files_do_not_overwrite_each_other(void **state)
{
    (void)state;
    char *path = temporary();
    char *taken = bad_name(path, 2);
    assert_int_equal(mkdir(taken, 0700), 0); /* not ours: left alone */
    for (int i = 0; i < 14; i++) {
        char text[16];
        snprintf(text, sizeof text, "{%d", i);
        assert_true(g_file_set_contents(path, text, -1, NULL));
        pel_scene_destroy(make(path));
    }
    for (int i = 1; i <= 15; i++) {
        char *name = bad_name(path, i), *text = NULL;
        if (i != 2) {
            assert_true(g_file_get_contents(name, &text, NULL, NULL));
            assert_int_equal(atoi(text + 1), i == 1 ? 0 : i - 2);
        }
        g_free(text);
        unlink(name);
        g_free(name);
    }
    assert_int_equal(rmdir(taken), 0);
    g_free(taken);
    clean(path);
}

/* Whatever ended the daemon before, the generation before is loaded. */
static void a_damaged_file_has_the_one_before_it(void **state)
{
    (void)state;
    char *path = temporary();
    g_autofree char *before = g_strconcat(path, PEL_STATE_BEFORE, NULL);
    struct pel_scene *scene = make(path);
    must(scene, "{\"sea\":{\"windSpeed\":11}}");
    pel_scene_destroy(scene);
    for (int turn = 0; turn < 2; turn++) {
        char *text;
        gsize size;
        assert_true(g_file_get_contents(path, &text, &size, NULL));
        char *digit = strstr(text, "\"windSpeed\": 11");
        assert_non_null(digit);
        digit[14] ^= 1;
        assert_true(g_file_set_contents(path, text, (gssize)size, NULL));
        scene = make(path); /* the damaged one takes nobody's place */
        assert_true(number(scene, "sea.windSpeed") == 11);
        struct pel_troubles troubles;
        pel_scene_troubles(scene, &troubles);
        assert_int_equal(troubles.count, 1);
        assert_non_null(strstr(troubles.items[0].words, PEL_STATE_BEFORE));
        assert_non_null(strstr(troubles.items[0].words, "revision 1"));
        pel_scene_destroy(scene);
        g_free(text);
    }
    /* What was before a file that is gone is nobody's. */
    assert_int_equal(unlink(path), 0);
    scene = make(path);
    assert_true(number(scene, "sea.windSpeed") == 8);
    assert_int_equal(access(before, F_OK), -1);
    pel_scene_destroy(scene);
    g_autofree char *second = bad_name(path, 2);
    unlink(second);
    clean(path);
}

static void a_bad_file_is_set_aside(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "{",
        "{\"sea\":{\"windSpeed\":99}}",
        "{\"nothing\":1}",
        "{\"views\":[{\"name\":\"a\",\"entity\":3}]}",
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        char *path = temporary();
        g_file_set_contents(path, bad[i], -1, NULL);
        struct pel_scene *scene = make(path);
        assert_true(number(scene, "sea.windSpeed") == 8);
        char *name = g_strconcat(path, ".bad", NULL), *kept;
        assert_true(g_file_get_contents(name, &kept, NULL, NULL));
        assert_string_equal(kept, bad[i]);
        g_free(kept);
        g_free(name);
        pel_scene_destroy(scene);
        clean(path);
    }
}

/* Each way of saying what the water is reaches the snapshot. */
static void water_is_described(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL);
    struct pel_water_desc desc = { .chlorophyll_mg_m3 = 0.2,
                                   .salinity_g_kg = PEL_SALINITY_USUAL,
                                   .temperature_c = PEL_TEMPERATURE_USUAL,
                                   .depth_m = 1000,
                                   .raman = true };
    struct pel_water_body wanted;
    assert_int_equal(pel_water_resolve(&desc, &wanted, NULL), PEL_OK);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    assert_memory_equal(&s->water, &wanted, sizeof wanted);
    pel_snapshot_unref(s);

    must(scene, "{\"water\":{\"jerlov\":\"C3\",\"depth\":7.9,"
                "\"bottom\":\"SAND\"}}");
    desc.kind = PEL_WATER_JERLOV;
    desc.jerlov = PEL_JERLOV_3C;
    desc.depth_m = 7.9;
    desc.bottom = PEL_BOTTOM_SAND;
    assert_int_equal(pel_water_resolve(&desc, &wanted, NULL), PEL_OK);
    s = pel_scene_snapshot(scene);
    assert_memory_equal(&s->water, &wanted, sizeof wanted);
    pel_snapshot_unref(s);

    must(scene, "{\"water\":{\"jerlov\":null,\"named\":\"HARBOUR\"}}");
    desc.kind = PEL_WATER_NAMED;
    desc.name = PEL_WATER_HARBOUR;
    assert_int_equal(pel_water_resolve(&desc, &wanted, NULL), PEL_OK);
    s = pel_scene_snapshot(scene);
    assert_memory_equal(&s->water, &wanted, sizeof wanted);
    pel_snapshot_unref(s);

    must(scene, "{\"water\":{\"named\":null,\"cdom\":0.3,"
                "\"cdomSlope\":0.018,\"minerals\":2,\"detritus\":0.1,"
                "\"detritusSlope\":0.012,\"backscatterRatio\":0.02,"
                "\"phase\":\"HENYEY_GREENSTEIN\"}}");
    s = pel_scene_snapshot(scene);
    assert_true(s->water_desc.has_dissolved && s->water_desc.has_detritus &&
                s->water_desc.has_back);
    assert_true(s->water_desc.dissolved_per_m == 0.3 &&
                s->water_desc.dissolved_slope == 0.018 &&
                s->water_desc.detritus_per_m == 0.1 &&
                s->water_desc.detritus_slope == 0.012 &&
                s->water_desc.minerals_g_m3 == 2 &&
                s->water_desc.back == 0.02 && s->water.back[0] == 0.0);
    pel_snapshot_unref(s);
    must(scene, "{\"water\":{\"backscatterRatio\":null}}");
    must(scene, "{\"water\":{\"absorption680\":0.5,"
                "\"absorption550\":0.06,\"absorption440\":0.02,"
                "\"scattering680\":1,\"scattering550\":2,\"scattering440\":3,"
                "\"asymmetry550\":0.75,\"albedo680\":0.1,\"albedo550\":0.2,"
                "\"albedo440\":0.3}}");
    s = pel_scene_snapshot(scene);
    assert_true(s->water.absorption[2] == 0.02);
    assert_true(s->water.scattering[0] == 1.0);
    assert_true(s->water.asymmetry[0] == 0.924);
    assert_true(s->water.asymmetry[1] == 0.75);
    assert_true(s->water.albedo[2] == 0.3 && s->water.depth_m == 7.9);
    pel_snapshot_unref(s);
    pel_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_all_there),
        cmocka_unit_test(a_clock_is_reset_with_a_ship_under_way),
        cmocka_unit_test(water_is_described),
        cmocka_unit_test(refusals_change_nothing),
        cmocka_unit_test(binary_values_are_tested_too),
        cmocka_unit_test(edits_merge_and_reset),
        cmocka_unit_test(limits_hold),
        cmocka_unit_test(presets_are_tested_and_bounded),
        cmocka_unit_test(the_state_before_last_is_the_memory_of_the_next),
        cmocka_unit_test(a_patch_brings_a_thousand_elements),
        cmocka_unit_test(the_clock_has_modes),
        cmocka_unit_test(a_heading_alone_does_not_throw_the_ship_back),
        cmocka_unit_test(snapshots_share_the_sea),
        cmocka_unit_test(the_state_outlives_the_daemon),
        cmocka_unit_test(the_journal_has_every_edit),
        cmocka_unit_test(a_state_is_one_daemons),
        cmocka_unit_test(a_state_that_cannot_be_kept_is_no_start),
        cmocka_unit_test(bad_files_do_not_overwrite_each_other),
        cmocka_unit_test(a_damaged_file_has_the_one_before_it),
        cmocka_unit_test(a_bad_file_is_set_aside),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
