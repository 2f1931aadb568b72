#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <glib.h>

#include "net/roles.h"
#include "scene/scene_testkit.h"

static void what_each_may_patch(void **state)
{
    (void)state;
    static const struct {
        const char *patch, *path; /* NULL: who steers may */
    } cases[] = {
        { "{\"ownShip\":{\"rudder\":5,\"throttle\":0.5,\"on\":true}}", NULL },
        { "{\"entities\":{\"1\":{\"speed\":5,\"course\":20}}}", NULL },
        { "{\"entities\":{\"ownship\":{\"heading\":5}}}", NULL },
        { "{\"views\":{\"bridge\":{\"yaw\":5,\"fieldOfView\":40}}}", NULL },
        { "{}", NULL },
        { "{\"ownShip\":{\"maxSpeed\":50}}", "ownShip.maxSpeed" },
        { "{\"ownShip\":{\"entity\":2,\"rudder\":1}}", "ownShip.entity" },
        { "{\"ownShip\":null}", "ownShip" },
        { "{\"ownShip\":{\"rudder\":null}}", "ownShip.rudder" },
        { "{\"entities\":{\"1\":{\"latitude\":5}}}", "entities.1.latitude" },
        { "{\"entities\":{\"2\":{\"speed\":5}}}", "entities.2" },
        { "{\"entities\":{\"target\":{\"speed\":5}}}", "entities.target" },
        { "{\"entities\":{\"1\":{\"name\":\"x\"}}}", "entities.1.name" },
        { "{\"entities\":{\"1\":null}}", "entities.1" },
        { "{\"entities\":{\"9\":{}}}", "entities.9" },
        { "{\"entities\":[]}", "entities" },
        { "{\"views\":{\"bridge\":{\"width\":99}}}", "views.bridge.width" },
        { "{\"views\":{\"bridge\":{\"entity\":2}}}", "views.bridge.entity" },
        { "{\"views\":{\"more\":{\"yaw\":5}}}", "views.more" },
        { "{\"views\":{\"bridge\":null}}", "views.bridge" },
        { "{\"sea\":{\"windSpeed\":5}}", "sea.windSpeed" },
        { "{\"clock\":{\"rate\":5}}", "clock.rate" },
        { "{\"exercise\":{\"mark\":5}}", "exercise.mark" },
        { "{\"sea\":{\"swell\":[{\"height\":2}]}}", "sea.swell" },
    };
    struct pel_scene *scene = make_scene((struct pel_scene_options){ 0 });
    must(scene, "{\"entities\":{\"2\":{\"name\":\"target\"}}}");
    const Pelagos__State *now = pel_scene_state(scene);
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        Pelagos__Patch *patch = read_patch(cases[i].patch);
        struct pel_fault fault = { 0 };
        bool empty = strcmp(cases[i].patch, "{}") == 0;
        enum pel_err err = pel_role_patch(PEL_ROLE_STEER, patch, now, &fault);
        if (err != (cases[i].path ? PEL_ERR_FORBIDDEN : PEL_OK)) {
            fail_msg("%s: %s", cases[i].patch, fault.message);
        }
        if (cases[i].path &&
            (strcmp(fault.path, cases[i].path) != 0 ||
             !strstr(fault.message, "needs the role instruct"))) {
            fail_msg("%s: %s: %s", cases[i].patch, fault.path, fault.message);
        }
        assert_int_equal(pel_role_patch(PEL_ROLE_WATCH, patch, now, &fault),
                         empty ? PEL_OK : PEL_ERR_FORBIDDEN);
        assert_int_equal(pel_role_patch(PEL_ROLE_INSTRUCT, patch, now, &fault),
                         PEL_OK);
        pelagos__patch__free_unpacked(patch, NULL);
    }
    pel_scene_destroy(scene);
}

static void what_is_not_named_is_the_instructors(void **state)
{
    (void)state;
    assert_int_equal(pel_role_of_route("GET", "v1/new"), PEL_ROLE_WATCH);
    assert_int_equal(pel_role_of_route("POST", "v1/new"), PEL_ROLE_INSTRUCT);
    assert_int_equal(pel_role_of_route("POST", "v1/surface"), PEL_ROLE_WATCH);
    assert_int_equal(pel_role_of_route("PATCH", "v1/state"), PEL_ROLE_STEER);
    assert_int_equal(pel_role_of_command(PELAGOS__REQUEST__COMMAND_GET),
                     PEL_ROLE_WATCH);
    assert_int_equal(pel_role_of_command(PELAGOS__REQUEST__COMMAND_STEP),
                     PEL_ROLE_INSTRUCT);
    assert_int_equal(pel_role_of_command((Pelagos__Request__CommandCase)99),
                     PEL_ROLE_INSTRUCT);
    for (int i = PEL_ROLE_WATCH; i <= PEL_ROLE_INSTRUCT; i++) {
        assert_int_equal(pel_role_by_name(pel_role_name((enum pel_role)i)), i);
    }
    assert_int_equal(pel_role_by_name("none"), PEL_ROLE_NONE);
}

static void the_fields_of_a_role_are_those_of_the_table(void **state)
{
    (void)state;
    size_t steers = 0;
    const char *field;
    assert_null(pel_role_field(PEL_ROLE_WATCH, 0));
    while ((field = pel_role_field(PEL_ROLE_STEER, steers))) {
        assert_true(strncmp(field, "ownShip.", 8) == 0 ||
                    strncmp(field, "entities.own.", 13) == 0 ||
                    strncmp(field, "views.*.", 8) == 0);
        steers++;
    }
    assert_int_equal(steers, 11);
    assert_string_equal(pel_role_field(PEL_ROLE_INSTRUCT, 0), "*");
    assert_null(pel_role_field(PEL_ROLE_INSTRUCT, 1));
}

static void what_is_to_come_is_not_read(void **state)
{
    (void)state;
    Pelagos__State whole, seen;
    Pelagos__ExerciseRun run = PELAGOS__EXERCISE_RUN__INIT;
    Pelagos__Sea sea = PELAGOS__SEA__INIT;
    Pelagos__Preset *presets[1] = { NULL };
    pelagos__state__init(&whole);
    whole.presets = presets;
    whole.n_presets = 1;
    whole.exercise = &run;
    whole.sea = &sea;
    pel_role_seen(PEL_ROLE_INSTRUCT, &whole, &seen);
    assert_true(seen.n_presets == 1 && seen.exercise == &run);
    for (int role = PEL_ROLE_NONE; role < PEL_ROLE_INSTRUCT; role++) {
        struct pel_fault fault;
        pel_role_seen((enum pel_role)role, &whole, &seen);
        assert_true(seen.n_presets == 0 && !seen.exercise && seen.sea == &sea);
        assert_int_equal(
            pel_role_read((enum pel_role)role, "presets.x.title", &fault),
            PEL_ERR_FORBIDDEN);
        assert_int_equal(pel_role_read((enum pel_role)role, "sea", &fault),
                         PEL_OK);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_to_come_is_not_read),
        cmocka_unit_test(what_each_may_patch),
        cmocka_unit_test(what_is_not_named_is_the_instructors),
        cmocka_unit_test(the_fields_of_a_role_are_those_of_the_table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
