#include "json.h"

#include <float.h>
#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static char *again(const ProtobufCMessageDescriptor *type, const char *json)
{
    ProtobufCMessage *message;
    struct pel_fault fault;
    if (pel_json_to_message(json, strlen(json), type, &message, &fault)) {
        fail_msg("%s: %s", json, fault.message);
    }
    char *out = pel_json_from_message(message, false);
    protobuf_c_message_free_unpacked(message, NULL);
    return out;
}

static void expect(const ProtobufCMessageDescriptor *type, const char *json,
                   const char *want)
{
    char *got = again(type, json);
    assert_string_equal(got, want);
    free(got);
}

static void values_round_trip(void **state)
{
    (void)state;
    expect(&pelagos__request__descriptor,
           " { \"id\" : 18446744073709551615 , \"step\":{\"seconds\":0.5}}\n",
           "{\"id\":\"18446744073709551615\",\"step\":{\"seconds\":0.5}}");
    expect(&pelagos__request__descriptor, "{\"id\":\"5\",\"get\":{}}",
           "{\"id\":\"5\",\"get\":{}}");
    expect(&pelagos__frame__descriptor,
           "{\"data\":\"AAEC_w\",\"format\":2,\"view\":\"\\u00e9\\n\\\"\"}",
           "{\"view\":\"\xc3\xa9\\u000a\\\"\",\"format\":\"EXR\","
           "\"data\":\"AAEC/w==\"}");
    expect(&pelagos__surface_query__descriptor,
           "{\"points\":[[0,5],[1.25,-4],{\"east\":2}],\"time\":\"3\"}",
           "{\"points\":[{\"east\":0,\"north\":5},{\"east\":1.25,"
           "\"north\":-4},{\"east\":2}],\"time\":3}");
    expect(&pelagos__frame_request__descriptor,
           "{\"layers\":[\"depth\",\"normal\"],\"floatSamples\":true,"
           "\"width\":64.0,\"height\":null}",
           "{\"width\":64,\"layers\":[\"depth\",\"normal\"],"
           "\"floatSamples\":true}");
    expect(&pelagos__sea__descriptor, "{\"wind_speed\":1e1}",
           "{\"windSpeed\":10}");
    expect(&pelagos__frame__descriptor, "{\"view\":\"\\ud83d\\ude00\"}",
           "{\"view\":\"\xf0\x9f\x98\x80\"}");
}

/* Elements by their keys mean the same in every message; what they remove is
 * the nearest patch's. */
static void keyed_objects(void **state)
{
    (void)state;
    expect(&pelagos__exercise__descriptor,
           "{\"state\":{\"entities\":{\"1\":{\"speed\":5},\"tug\":{}}},"
           "\"events\":[{\"name\":\"a\",\"patch\":{\"remove\":[\"sky\"],"
           "\"state\":{\"entities\":{\"3\":{\"speed\":2,\"light\":null},"
           "\"4\":null},\"views\":{\"bow\":{\"yaw\":5}}}}}]}",
           "{\"state\":{\"entities\":[{\"id\":1,\"speed\":5},"
           "{\"name\":\"tug\"}]},\"events\":[{\"name\":\"a\",\"patch\":{"
           "\"state\":{\"entities\":[{\"id\":3,\"speed\":2}],"
           "\"views\":[{\"name\":\"bow\",\"yaw\":5}]},"
           "\"remove\":[\"sky\",\"entities.3.light\",\"entities.4\"]}}]}");
    expect(&pelagos__spectrum_query__descriptor,
           "{\"patch\":{\"state\":{\"views\":{\"a\":null}}}}",
           "{\"patch\":{\"state\":{},\"remove\":[\"views.a\"]}}");
    /* null outside of them is absent, as it always was */
    expect(&pelagos__spectrum_query__descriptor,
           "{\"patch\":{\"state\":{\"sea\":{\"fetch\":null},\"entities\":["
           "{\"id\":3,\"light\":null}]}}}",
           "{\"patch\":{\"state\":{\"sea\":{},\"entities\":[{\"id\":3}]}}}");
}

static void doubles_are_shortest(void **state)
{
    (void)state;
    char text[32];
    pel_json_number(0.1, text);
    assert_string_equal(text, "0.1");
    pel_json_number(1e9, text);
    assert_string_equal(text, "1000000000");
    pel_json_number(-0.0, text);
    assert_string_equal(text, "-0");
    uint64_t bits = 0x9e3779b97f4a7c15u;
    for (int i = 0; i < 100000; i++) {
        double value;
        bits = bits * 6364136223846793005u + 1442695040888963407u;
        memcpy(&value, &bits, sizeof value);
        if (isfinite(value)) {
            pel_json_number(value, text);
            assert_true(strtod(text, NULL) == value);
        }
    }
}

static void locale_does_not_matter(void **state)
{
    (void)state;
    const char *locales[] = { "de_DE.UTF-8", "nl_NL.UTF-8", "fr_FR.UTF-8" };
    for (size_t i = 0; i < 3 && !setlocale(LC_ALL, locales[i]); i++) {
    }
    expect(&pelagos__sea__descriptor, "{\"windSpeed\":1.5}",
           "{\"windSpeed\":1.5}");
    setlocale(LC_ALL, "C");
}

static void bad_text_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *json;
        enum pel_err err;
        const char *path;
    } bad[] = {
        { "", PEL_ERR_MALFORMED, "" },
        { "{", PEL_ERR_MALFORMED, "" },
        { "{}x", PEL_ERR_MALFORMED, "" },
        { "{} {}", PEL_ERR_MALFORMED, "" },
        { "[]", PEL_ERR_INVALID, "" },
        { "null", PEL_ERR_INVALID, "" },
        { "{'sea':{}}", PEL_ERR_MALFORMED, "" },
        { "{sea:{}}", PEL_ERR_MALFORMED, "" },
        { "/* c */{}", PEL_ERR_MALFORMED, "" },
        { "var a = {}", PEL_ERR_MALFORMED, "" },
        { "{\"sea\":{},}", PEL_ERR_MALFORMED, "" },
        { "{\"sea\":{},\"sea\":{}}", PEL_ERR_MALFORMED, "sea" },
        { "{\"sea\":{\"windSpeed\":1,\"wind_speed\":2}}", PEL_ERR_MALFORMED,
          "sea.wind_speed" },
        { "{\"sea\":{\"windSpeed\":01}}", PEL_ERR_MALFORMED, "sea" },
        { "{\"sea\":{\"windSpeed\":.5}}", PEL_ERR_MALFORMED, "sea.windSpeed" },
        { "{\"sea\":{\"windSpeed\":5.}}", PEL_ERR_MALFORMED, "sea.windSpeed" },
        { "{\"sea\":{\"windSpeed\":+5}}", PEL_ERR_MALFORMED, "sea.windSpeed" },
        { "{\"sea\":{\"windSpeed\":NaN}}", PEL_ERR_MALFORMED, "sea.windSpeed" },
        { "{\"sea\":{\"windSpeed\":\"NaN\"}}", PEL_ERR_OUT_OF_RANGE,
          "sea.windSpeed" },
        { "{\"sea\":{\"windSpeed\":\"Infinity\"}}", PEL_ERR_OUT_OF_RANGE,
          "sea.windSpeed" },
        { "{\"sea\":{\"windSpeed\":1e400}}", PEL_ERR_OUT_OF_RANGE,
          "sea.windSpeed" },
        { "{\"sea\":{\"windSpeed\":\"x\"}}", PEL_ERR_INVALID, "sea.windSpeed" },
        { "{\"sea\":{\"windSpeed\":true}}", PEL_ERR_INVALID, "sea.windSpeed" },
        { "{\"sea\":{\"windSpeed\":[]}}", PEL_ERR_INVALID, "sea.windSpeed" },
        { "{\"sea\":{\"seed\":-1}}", PEL_ERR_OUT_OF_RANGE, "sea.seed" },
        { "{\"sea\":{\"seed\":4294967296}}", PEL_ERR_OUT_OF_RANGE, "sea.seed" },
        { "{\"sea\":{\"seed\":1.5}}", PEL_ERR_INVALID, "sea.seed" },
        { "{\"sea\":{\"spectrum\":\"PM\"}}", PEL_ERR_INVALID, "sea.spectrum" },
        { "{\"sea\":{\"spectrum\":9}}", PEL_ERR_INVALID, "sea.spectrum" },
        { "{\"sea\":{\"wind\":9}}", PEL_ERR_NOT_FOUND, "sea.wind" },
        { "{\"sea\":[]}", PEL_ERR_INVALID, "sea" },
        { "{\"sea\":{\"swell\":{}}}", PEL_ERR_INVALID, "sea.swell" },
        { "{\"sea\":{\"swell\":[[1,2,3,4,5]]}}", PEL_ERR_INVALID,
          "sea.swell.0" },
        { "{\"sea\":{\"swell\":[{},{\"period\":\"\"}]}}", PEL_ERR_INVALID,
          "sea.swell.1.period" },
        { "{\"views\":[{\"name\":\"a\\u0000b\"}]}", PEL_ERR_MALFORMED,
          "views.0.name" },
        { "{\"views\":[{\"name\":\"\\ud800\"}]}", PEL_ERR_MALFORMED,
          "views.0.name" },
        { "{\"views\":[{\"name\":\"\xc3(\"}]}", PEL_ERR_MALFORMED,
          "views.0.name" },
        { "{\"views\":[{\"name\":\"\t\"}]}", PEL_ERR_MALFORMED,
          "views.0.name" },
        { "{\"views\":[null]}", PEL_ERR_INVALID, "views.0" },
        { "{\"views\":{\"a\":null}}", PEL_ERR_INVALID, "views.a" },
        { "{\"views\":{\"a\":7}}", PEL_ERR_INVALID, "views.a" },
        { "{\"views\":{\"a\":{\"name\":\"b\"}}}", PEL_ERR_INVALID, "views.a" },
        { "{\"entities\":{\"1.speed\":{}}}", PEL_ERR_INVALID,
          "entities.1.speed" },
        { "{\"views\":[{\"name\":7}]}", PEL_ERR_INVALID, "views.0.name" },
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        ProtobufCMessage *message;
        struct pel_fault fault;
        enum pel_err err =
            pel_json_to_message(bad[i].json, strlen(bad[i].json),
                                &pelagos__state__descriptor, &message, &fault);
        if (err != bad[i].err || strcmp(fault.path, bad[i].path) != 0) {
            fail_msg("%s: %s at '%s': %s", bad[i].json, pel_err_name(err),
                     fault.path, fault.message);
        }
        assert_null(message);
    }
    const char nul[] = "{\"revision\":1\0}";
    ProtobufCMessage *message;
    assert_int_equal(pel_json_to_message(nul, sizeof nul - 1,
                                         &pelagos__state__descriptor, &message,
                                         NULL),
                     PEL_ERR_MALFORMED);
    const char *both = "{\"get\":{},\"watch\":{}}";
    assert_int_equal(pel_json_to_message(both, strlen(both),
                                         &pelagos__request__descriptor,
                                         &message, NULL),
                     PEL_ERR_INVALID);
}

static void depth_is_bounded(void **state)
{
    (void)state;
    static char deep[200001];
    memset(deep, '[', 200000);
    ProtobufCMessage *message;
    assert_int_not_equal(pel_json_to_message(deep, 200000,
                                             &pelagos__state__descriptor,
                                             &message, NULL),
                         PEL_OK);
    assert_int_not_equal(pel_json_to_message(deep, PEL_JSON_MAX_BYTES + 1,
                                             &pelagos__state__descriptor,
                                             &message, NULL),
                         PEL_OK);
}

static void expect_patch(const char *json, const char *want)
{
    Pelagos__Patch *patch;
    struct pel_fault fault;
    if (pel_json_merge_patch(json, strlen(json), &patch, &fault)) {
        fail_msg("%s: %s", json, fault.message);
    }
    char *got = pel_json_from_message(&patch->base, false);
    assert_string_equal(got, want);
    free(got);
    pelagos__patch__free_unpacked(patch, NULL);
}

static void merge_patches(void **state)
{
    (void)state;
    expect_patch("{}", "{\"state\":{}}");
    expect_patch("{\"sea\":{\"windSpeed\":5,\"fetch\":null}}",
                 "{\"state\":{\"sea\":{\"windSpeed\":5}},"
                 "\"remove\":[\"sea.fetch\"]}");
    expect_patch("{\"sky\":null}", "{\"state\":{},\"remove\":[\"sky\"]}");
    expect_patch("{\"views\":{\"bridge\":{\"yaw\":5,\"frustum\":null},"
                 "\"stern\":null}}",
                 "{\"state\":{\"views\":[{\"name\":\"bridge\",\"yaw\":5}]},"
                 "\"remove\":[\"views.bridge.frustum\",\"views.stern\"]}");
    expect_patch("{\"entities\":{\"3\":{\"heading\":5},\"tug\":{\"roll\":1}}}",
                 "{\"state\":{\"entities\":[{\"id\":3,\"heading\":5},"
                 "{\"name\":\"tug\",\"roll\":1}]}}");
    expect_patch("{\"views\":[{\"name\":\"a\",\"exposure\":null}]}",
                 "{\"state\":{\"views\":[{\"name\":\"a\"}]},"
                 "\"remove\":[\"views\"]}");
    expect_patch("{\"sea\":{\"swell\":[]}}",
                 "{\"state\":{\"sea\":{}},\"remove\":[\"sea.swell\"]}");
}

static void bad_merge_patches(void **state)
{
    (void)state;
    static const struct {
        const char *json;
        enum pel_err err;
        const char *path;
    } bad[] = {
        { "{\"views\":{\"bridge\":{\"yaw\":\"x\"}}}", PEL_ERR_INVALID,
          "views.bridge.yaw" },
        { "{\"views\":{\"bridge\":{\"name\":\"stern\"}}}", PEL_ERR_INVALID,
          "views.bridge" },
        { "{\"entities\":{\"1\":{\"id\":2}}}", PEL_ERR_INVALID, "entities.1" },
        { "{\"entities\":{\"1.heading\":null}}", PEL_ERR_INVALID,
          "entities.1.heading" },
        { "{\"views\":{\"\":{}}}", PEL_ERR_INVALID, "views." },
        { "{\"views\":7}", PEL_ERR_INVALID, "views" },
        { "{\"nothing\":null}", PEL_ERR_NOT_FOUND, "nothing" },
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        Pelagos__Patch *patch;
        struct pel_fault fault;
        enum pel_err err = pel_json_merge_patch(
            bad[i].json, strlen(bad[i].json), &patch, &fault);
        if (err != bad[i].err || strcmp(fault.path, bad[i].path) != 0) {
            fail_msg("%s: %s at '%s': %s", bad[i].json, pel_err_name(err),
                     fault.path, fault.message);
        }
        assert_null(patch);
    }
}

static void pretty_is_the_same(void **state)
{
    (void)state;
    const char *json = "{\"clock\":{\"rate\":2},\"views\":[{\"name\":\"a\"}]}";
    ProtobufCMessage *message;
    assert_int_equal(pel_json_to_message(json, strlen(json),
                                         &pelagos__state__descriptor, &message,
                                         NULL),
                     PEL_OK);
    char *pretty = pel_json_from_message(message, true);
    assert_string_equal(pretty, "{\n  \"clock\": {\n    \"rate\": 2\n  },\n"
                                "  \"views\": [\n    {\n"
                                "      \"name\": \"a\"\n    }\n  ]\n}");
    expect(&pelagos__state__descriptor, pretty, json);
    free(pretty);
    protobuf_c_message_free_unpacked(message, NULL);
}

static void strings_are_json(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        { "", "\"\"" },
        { "a \"b\" \\", "\"a \\\"b\\\" \\\\\"" },
        { "\x01\n\x1f", "\"\\u0001\\u000a\\u001f\"" },
        { "Llvmpipe \xc2\xa9", "\"Llvmpipe \xc2\xa9\"" },
        { "\xff", "\"\xef\xbf\xbd\"" }, /* U+FFFD */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *text = pel_json_string(cases[i][0]);
        assert_string_equal(text, cases[i][1]);
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(strings_are_json),
        cmocka_unit_test(values_round_trip),
        cmocka_unit_test(keyed_objects),
        cmocka_unit_test(doubles_are_shortest),
        cmocka_unit_test(locale_does_not_matter),
        cmocka_unit_test(bad_text_is_refused),
        cmocka_unit_test(depth_is_bounded),
        cmocka_unit_test(merge_patches),
        cmocka_unit_test(bad_merge_patches),
        cmocka_unit_test(pretty_is_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
