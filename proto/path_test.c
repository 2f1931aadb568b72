#include "path.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "json.h"

static Pelagos__State *state_from(const char *json)
{
    ProtobufCMessage *message;
    struct pel_fault fault;
    enum pel_err err = pel_json_to_message(
        json, strlen(json), &pelagos__state__descriptor, &message, &fault);
    if (err) {
        fail_msg("%s", fault.message);
    }
    return (Pelagos__State *)message;
}

static void sets_become_a_patch(void **state)
{
    (void)state;
    static const char *const sets[][2] = {
        { "sea.windSpeed", "12.5" },
        { "sea.wind_direction", "90" },
        { "view.bridge.yaw", "-5" },
        { "views.bridge.fieldOfView", "40" },
        { "entities.1.heading", "7" },
        { "entity.tug.heading", "8" },
        { "clock.mode", "stepped" },
        { "sea.swell.0.height", "2" },
        { "sea.swell.1.height", "3" },
        { "sky.sunElevation", NULL },
        { "view.stern", "null" },
        { "views.bridge.frustum.left", "-3" },
        { "clock.utc", "2026-01-01T00:00:00Z" },
    };
    Pelagos__Patch *patch = pel_patch_new();
    for (size_t i = 0; i < sizeof sets / sizeof sets[0]; i++) {
        struct pel_fault fault;
        if (pel_path_set(patch, NULL, sets[i][0], sets[i][1], &fault)) {
            fail_msg("%s", fault.message);
        }
    }
    char *json = pel_json_from_message(&patch->base, false);
    assert_string_equal(
        json, "{\"state\":{\"clock\":{\"mode\":\"STEPPED\","
              "\"utc\":\"2026-01-01T00:00:00Z\"},"
              "\"sea\":{\"windSpeed\":12.5,\"windDirection\":90,"
              "\"swell\":[{\"height\":2},{\"height\":3}]},"
              "\"entities\":[{\"id\":1,\"heading\":7},"
              "{\"name\":\"tug\",\"heading\":8}],"
              "\"views\":[{\"name\":\"bridge\",\"yaw\":-5,\"fieldOfView\":40,"
              "\"frustum\":{\"left\":-3}}]},"
              "\"remove\":[\"sky.sunElevation\",\"views.stern\"]}");
    free(json);
    pelagos__patch__free_unpacked(patch, NULL);
}

static void bad_sets_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *path, *value;
        enum pel_err err;
    } bad[] = {
        { "sea.windSped", "1", PEL_ERR_NOT_FOUND },
        { "", "1", PEL_ERR_NOT_FOUND },
        { ".", "1", PEL_ERR_NOT_FOUND },
        { "sea.", "1", PEL_ERR_NOT_FOUND },
        { "sea.windSpeed.x", "1", PEL_ERR_NOT_FOUND },
        { "view..yaw", "1", PEL_ERR_NOT_FOUND },
        { "sea.swell.x.height", "1", PEL_ERR_NOT_FOUND },
        { "sea.swell.2.height", "1", PEL_ERR_NOT_FOUND },
        { "sea.windSpeed", "fast", PEL_ERR_INVALID },
        { "sea.windSpeed", "", PEL_ERR_INVALID },
        { "sea.windSpeed", " 1", PEL_ERR_INVALID },
        { "sea.windSpeed", "1,5", PEL_ERR_INVALID },
        { "sea.windSpeed", "0x10", PEL_ERR_INVALID },
        { "sea.windSpeed", "nan", PEL_ERR_OUT_OF_RANGE },
        { "sea.windSpeed", "-inf", PEL_ERR_OUT_OF_RANGE },
        { "sea.windSpeed", "1e999", PEL_ERR_OUT_OF_RANGE },
        { "sea.seed", "4294967296", PEL_ERR_OUT_OF_RANGE },
        { "sea.seed", "1.5", PEL_ERR_INVALID },
        { "clock.mode", "WILD", PEL_ERR_INVALID },
        { "clock.mode", "17", PEL_ERR_INVALID },
        { "sea", "1", PEL_ERR_INVALID },
        { "views.bridge", "1", PEL_ERR_INVALID },
        { "clock.utc", "\xff", PEL_ERR_INVALID },
    };
    Pelagos__Patch *patch = pel_patch_new();
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        struct pel_fault fault;
        enum pel_err err =
            pel_path_set(patch, NULL, bad[i].path, bad[i].value, &fault);
        if (err != bad[i].err) {
            fail_msg("%s=%s: %d", bad[i].path, bad[i].value, err);
        }
        assert_string_equal(fault.path, bad[i].path);
        assert_true(fault.message[0]);
        assert_null(patch->state);
        assert_int_equal(patch->n_remove, 0);
    }
    pelagos__patch__free_unpacked(patch, NULL);
}

static void swell_starts_from_the_present(void **state)
{
    (void)state;
    Pelagos__State *now =
        state_from("{\"sea\":{\"swell\":[[1,8],[2,9,10,11]]}}");
    Pelagos__Patch *patch = pel_patch_new();
    assert_int_equal(pel_path_set(patch, now, "sea.swell.1.height", "5", NULL),
                     PEL_OK);
    assert_int_equal(patch->state->sea->n_swell, 2);
    assert_true(patch->state->sea->swell[0]->period == 8);
    assert_true(patch->state->sea->swell[1]->height == 5);
    assert_true(patch->state->sea->swell[1]->spread == 11);
    pelagos__patch__free_unpacked(patch, NULL);
    pelagos__state__free_unpacked(now, NULL);
}

static void gets_are_text(void **state)
{
    (void)state;
    Pelagos__State *now = state_from(
        "{\"sea\":{\"windSpeed\":0.1,\"spectrum\":\"JONSWAP\"},"
        "\"revision\":\"12\",\"views\":[{\"name\":\"bridge\",\"yaw\":3}],"
        "\"entities\":[{\"id\":4,\"name\":\"a\",\"heading\":1},"
        "{\"id\":5,\"name\":\"b\"},{\"id\":6,\"name\":\"b\"}]}");
    static const char *const gets[][2] = {
        { "sea.windSpeed", "0.1" },
        { "sea.spectrum", "JONSWAP" },
        { "view.bridge.yaw", "3" },
        { "revision", "12" },
        { "entities.4.heading", "1" },
        { "entities.a.heading", "1" },
        { "views.bridge.name", "bridge" },
        { "views.bridge.pitch", "" },
        { "views.bridge", "{\"name\":\"bridge\",\"yaw\":3}" },
        { "sea", "{\"windSpeed\":0.1,\"spectrum\":\"JONSWAP\"}" },
        { "sea.swell", "[]" },
        { "clock.rate", "" },
        { "views", "[{\"name\":\"bridge\",\"yaw\":3}]" },
    };
    char text[200];
    for (size_t i = 0; i < sizeof gets / sizeof gets[0]; i++) {
        assert_int_equal(pel_path_get(now, gets[i][0], text, sizeof text, NULL),
                         PEL_OK);
        assert_string_equal(text, gets[i][1]);
    }
    assert_int_equal(pel_path_get(now, "views.x.yaw", text, 200, NULL),
                     PEL_ERR_NOT_FOUND);
    assert_int_equal(pel_path_get(now, "entities.b.heading", text, 200, NULL),
                     PEL_ERR_CONFLICT);
    assert_int_equal(pel_path_get(now, "sea", text, 10, NULL),
                     PEL_ERR_OUT_OF_RANGE);
    pelagos__state__free_unpacked(now, NULL);
}

static void removes_reset(void **state)
{
    (void)state;
    Pelagos__State *now =
        state_from("{\"sea\":{\"windSpeed\":20,\"swell\":[[1],[2]]},"
                   "\"sky\":{\"sunElevation\":3},\"clock\":{\"utc\":\"x\"},"
                   "\"views\":[{\"name\":\"a\"},{\"name\":\"b\"}]}");
    static const char *const paths[] = { "sea.windSpeed", "sky.sunElevation",
                                         "views.a", "sea.swell.0",
                                         "clock.utc" };
    for (size_t i = 0; i < sizeof paths / sizeof paths[0]; i++) {
        assert_int_equal(pel_path_remove(now, paths[i], NULL), PEL_OK);
    }
    char *json = pel_json_from_message(&now->base, false);
    assert_string_equal(json,
                        "{\"clock\":{\"utc\":\"2026-06-21T12:00:00Z\"},"
                        "\"sea\":{\"windSpeed\":8,\"swell\":[{\"height\":2}]},"
                        "\"sky\":{},\"views\":[{\"name\":\"b\"}]}");
    free(json);
    assert_int_equal(pel_path_remove(now, "views.b.name", NULL),
                     PEL_ERR_INVALID);
    assert_int_equal(pel_path_remove(now, "views.a", NULL), PEL_ERR_NOT_FOUND);
    assert_int_equal(pel_path_remove(now, "views", NULL), PEL_OK);
    assert_int_equal(now->n_views, 0);
    pelagos__state__free_unpacked(now, NULL);
}

static void count_path(const char *path, const struct pel_path_info *info,
                       void *user)
{
    struct pel_path_info found;
    int *counts = user;
    counts[0]++;
    counts[1] += strcmp(path, "views.*.frustum.left") == 0;
    counts[2] += strcmp(path, "sea.windSpeed") == 0 && info->info->ranged &&
                 info->info->maximum == 30;
    if (!strchr(path, '*')) {
        assert_int_equal(pel_path_find(path, &found, NULL), PEL_OK);
        assert_ptr_equal(found.info, info->info);
    }
}

static void every_path_is_listed(void **state)
{
    (void)state;
    int counts[3] = { 0 };
    pel_path_each(count_path, counts);
    assert_true(counts[0] > 50);
    assert_int_equal(counts[1], 1);
    assert_int_equal(counts[2], 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sets_become_a_patch),
        cmocka_unit_test(bad_sets_are_refused),
        cmocka_unit_test(swell_starts_from_the_present),
        cmocka_unit_test(gets_are_text),
        cmocka_unit_test(removes_reset),
        cmocka_unit_test(every_path_is_listed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
