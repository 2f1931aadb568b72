#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/build.h"
#include "scene/scene_testkit.h"
#include "scene/worker.h"

static struct pel_scene *scene;

/* How patches ended, in this order: their number, or minus their error. */
static int ends[512];
static int end_count, number;
static char last_path[96];

static void ended(void *user, enum pel_err err, const struct pel_fault *fault)
{
    assert_int_equal(err, fault->code);
    strcpy(last_path, fault->path);
    ends[end_count++] = err ? -(int)err : (int)(intptr_t)user;
}

static bool submit_as(const void *source, bool if_unchanged, const char *json)
{
    Pelagos__Patch *read = read_patch(json);
    const struct pel_scene_wish wish = {
        .patch = read,
        .source = source,
        .if_unchanged = if_unchanged,
    };
    bool waits =
        pel_scene_submit(scene, &wish, ended, (void *)(intptr_t)++number);
    pelagos__patch__free_unpacked(read, NULL);
    return waits;
}

static bool submit(const void *source, const char *json)
{
    return submit_as(source, false, json);
}

static double wind(void)
{
    return pel_scene_state(scene)->sea->wind_speed;
}

static bool sea_is_built(void)
{
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    bool built = pel_shared_sea_built(s->sea);
    pel_snapshot_unref(s);
    return built;
}

static int begin(void **state)
{
    (void)state;
    end_count = number = 0;
    scene = make_scene((struct pel_scene_options){ .wave_count = 20 });
    return 0;
}

static int end(void **state)
{
    (void)state;
    pel_scene_destroy(scene);
    return 0;
}

static void a_sea_is_built_before_its_commit(void **state)
{
    (void)state;
    uint64_t before = pel_scene_state(scene)->revision;
    assert_true(submit(NULL, "{\"sea\":{\"windSpeed\":11}}"));
    assert_int_equal(end_count, 0);
    assert_true(wind() != 11);
    assert_int_equal(pel_scene_state(scene)->revision, before);
    pel_scene_settle(scene);
    assert_int_equal(end_count, 1);
    assert_true(wind() == 11);
    assert_int_equal(pel_scene_state(scene)->revision, before + 1);
    assert_true(sea_is_built());
}

static void what_needs_none_is_committed_at_once(void **state)
{
    (void)state;
    assert_false(submit(NULL, "{\"sky\":{\"visibility\":9000}}"));
    assert_int_equal(ends[0], 1);
    /* past a sea that is under way; not past one of its own source */
    assert_true(submit(&scene, "{\"sea\":{\"windSpeed\":11}}"));
    assert_false(submit(NULL, "{\"sky\":{\"visibility\":8000}}"));
    assert_true(submit(&scene, "{\"sky\":{\"visibility\":7000}}"));
    assert_true(pel_scene_state(scene)->sky->visibility == 8000);
    pel_scene_settle(scene);
    assert_true(pel_scene_state(scene)->sky->visibility == 7000);
    const int order[] = { 1, 3, 2, 4 };
    assert_int_equal(end_count, 4);
    assert_memory_equal(ends, order, sizeof order);
}

/* A precondition is looked at before what else is wrong, and says so. */
static void another_edit_comes_before(void **state)
{
    (void)state;
    const char *unknown = "{\"sea\":{\"spectrum\":\"MEASURED\"}}";
    assert_true(submit_as(NULL, true, unknown)); /* 1: there is no --spectra */
    pel_scene_settle(scene);
    assert_int_equal(ends[0], -PEL_ERR_CONFLICT);
    assert_string_not_equal(last_path, PEL_SCENE_REVISION);
    assert_true(submit_as(NULL, true, unknown)); /* 2 */
    assert_false(submit(NULL, "{\"sky\":{\"visibility\":9000}}"));
    pel_scene_settle(scene);
    assert_int_equal(ends[2], -PEL_ERR_CONFLICT);
    assert_string_equal(last_path, PEL_SCENE_REVISION);
}

/* Of thirty seas the first and, with all others, the last is built. */
static void of_many_seas_the_newest_is_built(void **state)
{
    (void)state;
    uint64_t before = pel_scene_state(scene)->revision;
    for (int i = 0; i < 30; i++) {
        char json[64];
        snprintf(json, sizeof json, "{\"sea\":{\"windSpeed\":%g}}",
                 5 + 0.1 * i);
        assert_true(submit(NULL, json));
    }
    assert_int_equal(pel_scene_prepared(scene), 1);
    pel_scene_settle(scene);
    assert_int_equal(pel_scene_prepared(scene), 2);
    assert_int_equal(end_count, 30);
    for (int i = 0; i < 30; i++) {
        assert_int_equal(ends[i], i + 1);
    }
    assert_true(wind() == 5 + 0.1 * 29);
    assert_int_equal(pel_scene_state(scene)->revision, before + 30);
    assert_true(sea_is_built());
}

/* Each of a turn's commits copies the state: of a large one they are few. */
static void large_states_are_committed_by_few(void **state)
{
    (void)state;
    for (int i = 0; i < 60; i++) {
        char json[64];
        snprintf(json, sizeof json, "{\"views\":{\"v%d\":{\"yaw\":1}}}", i);
        assert_false(submit(NULL, json));
    }
    end_count = 0;
    for (int i = 0; i < 101; i++) {
        assert_true(submit(NULL, i % 2 ? "{\"sea\":{\"windSpeed\":7}}"
                                       : "{\"sea\":{\"windSpeed\":6}}"));
    }
    pel_scene_settle(scene);
    assert_int_equal(end_count, 101);
    assert_in_range(pel_scene_prepared(scene), 1 + 100 / 6, 1 + 100 / 4);
}

/* One names a file that is not there: it alone is refused, whole. */
static void a_refusal_is_its_own(void **state)
{
    (void)state;
    submit(NULL, "{\"sea\":{\"windSpeed\":6}}");
    submit(NULL, "{\"sea\":{\"windSpeed\":7}}");
    submit(NULL,
           "{\"sea\":{\"fetch\":3e5},\"seabed\":{\"file\":\"none.tif\"}}");
    submit(NULL, "{\"sea\":{\"spectrum\":\"MEASURED\",\"measured\":\"n\"}}");
    submit(NULL, "{\"sea\":{\"gamma\":2}}");
    submit(NULL, "{\"sea\":{\"windSpeed\":31}}");
    double fetch = pel_scene_state(scene)->sea->fetch;
    pel_scene_settle(scene);
    assert_int_equal(end_count, 6);
    assert_int_equal(ends[0], 1);
    assert_int_equal(ends[1], 2);
    assert_true(ends[2] < 0);
    assert_true(ends[3] < 0);
    assert_int_equal(ends[4], 5);
    assert_int_equal(ends[5], -PEL_ERR_OUT_OF_RANGE);
    assert_true(pel_scene_state(scene)->sea->fetch == fetch);
    assert_true(pel_scene_state(scene)->sea->gamma == 2);
    assert_true(sea_is_built());
}

static void too_many_are_refused(void **state)
{
    (void)state;
    for (int i = 0; i < 256; i++) {
        assert_true(submit(NULL, i % 2 ? "{\"sea\":{\"windSpeed\":7}}"
                                       : "{\"sea\":{\"windSpeed\":6}}"));
    }
    assert_false(submit(NULL, "{\"sea\":{\"windSpeed\":5}}"));
    assert_int_equal(ends[0], -PEL_ERR_BUSY);
    pel_scene_settle(scene);
    assert_int_equal(end_count, 257);
    assert_true(wind() == 7);
    assert_false(submit(NULL, "{\"sea\":{\"windSpeed\":31}}"));
    assert_int_equal(ends[257], -PEL_ERR_OUT_OF_RANGE);
}

static void an_edit_between_is_seen(void **state)
{
    (void)state;
    Pelagos__Sea sea = PELAGOS__SEA__INIT;
    Pelagos__State to = PELAGOS__STATE__INIT;
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    sea.has_wind_speed = 1;
    sea.wind_speed = 12;
    to.sea = &sea;
    patch.state = &to;
    const struct pel_scene_wish wish = { .patch = &patch,
                                         .if_unchanged = true };
    assert_true(pel_scene_submit(scene, &wish, ended, (void *)1));
    assert_false(submit(NULL, "{\"sky\":{\"visibility\":8000}}"));
    pel_scene_settle(scene);
    assert_int_equal(ends[1], -PEL_ERR_CONFLICT);
    assert_true(wind() != 12);
}

static void who_waits_at_the_end_is_told(void **state)
{
    (void)state;
    submit(NULL, "{\"sea\":{\"windSpeed\":6}}");
    submit(NULL, "{\"sea\":{\"windSpeed\":7}}");
    submit(&scene, "{\"sea\":{\"windSpeed\":8}}");
    pel_scene_forget(scene, &scene);
    pel_scene_destroy(scene);
    assert_int_equal(end_count, 2);
    assert_int_equal(ends[0], -PEL_ERR_CONFLICT);
    assert_int_equal(ends[1], -PEL_ERR_CONFLICT);
    begin(NULL);
}

/* Own ship's motion after the seas of a batch is that of the same patches one
 * after the other at that moment: what a replay does. */
static void own_ship_goes_the_same_way_in_a_replay(void **state)
{
    (void)state;
    static const char *const winds[] = { "{\"sea\":{\"windSpeed\":6}}",
                                         "{\"sea\":{\"windSpeed\":14}}",
                                         "{\"sea\":{\"windSpeed\":9}}" };
    Pelagos__Entity kept[2];
    struct pel_fault fault;
    for (int k = 0; k < 2; k++) {
        submit(NULL, "{\"clock\":{\"mode\":\"STEPPED\",\"time\":100},"
                     "\"ownShip\":{\"on\":true,\"throttle\":0.6}}");
        assert_int_equal(pel_scene_step(scene, 3.7, &fault), PEL_OK);
        for (int i = 0; i < 3; i++) {
            submit(NULL, winds[i]);
            if (k > 0) {
                pel_scene_settle(scene);
            }
        }
        pel_scene_settle(scene);
        assert_int_equal(pel_scene_step(scene, 7.3, &fault), PEL_OK);
        kept[k] = *pel_scene_state(scene)->entities[0];
        pel_scene_destroy(scene);
        begin(NULL);
    }
    assert_true(kept[0].latitude == kept[1].latitude);
    assert_true(kept[0].longitude == kept[1].longitude);
    assert_true(kept[0].altitude == kept[1].altitude);
    assert_true(kept[0].pitch == kept[1].pitch);
    assert_true(kept[0].roll == kept[1].roll);
    assert_true(kept[0].altitude != 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_sea_is_built_before_its_commit, begin,
                                        end),
        cmocka_unit_test_setup_teardown(what_needs_none_is_committed_at_once,
                                        begin, end),
        cmocka_unit_test_setup_teardown(another_edit_comes_before, begin, end),
        cmocka_unit_test_setup_teardown(of_many_seas_the_newest_is_built, begin,
                                        end),
        cmocka_unit_test_setup_teardown(large_states_are_committed_by_few,
                                        begin, end),
        cmocka_unit_test_setup_teardown(a_refusal_is_its_own, begin, end),
        cmocka_unit_test_setup_teardown(too_many_are_refused, begin, end),
        cmocka_unit_test_setup_teardown(an_edit_between_is_seen, begin, end),
        cmocka_unit_test_setup_teardown(who_waits_at_the_end_is_told, begin,
                                        end),
        cmocka_unit_test_setup_teardown(own_ship_goes_the_same_way_in_a_replay,
                                        begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
