#include "pelagosctl/ctl.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>
#include <glib.h>

/* The table of this test instead of the program's. */
const struct ctl_option ctl_global_options[] = {
    { 's', "server", "ADDRESS", "", NULL },
    { 'j', "json", NULL, "", NULL },
    { 'h', "help", NULL, "", NULL },
    { 0, "version", NULL, "", NULL },
    { 0 },
};
static const struct ctl_option draw_options[] = {
    { 0, "width", "PIXELS", "", NULL },
    { 0 },
};
const struct ctl_command ctl_commands[] = {
    { "draw", "A B", "", "", draw_options, NULL, NULL, 2, 2, NULL },
    { 0 },
};

static void test_nearest(void **state)
{
    (void)state;
    static const char *const words[] = { "sea.windSpeed", "sea.windDirection",
                                         "sky.visibility", "clock.rate" };
    assert_string_equal(ctl_nearest("sea.windspede", words, 4),
                        "sea.windSpeed");
    assert_string_equal(ctl_nearest("sae.windSpeed", words, 4),
                        "sea.windSpeed");
    assert_string_equal(ctl_nearest("windSpeed", words, 4), "sea.windSpeed");
    assert_string_equal(ctl_nearest("sky.visibilty", words, 4),
                        "sky.visibility");
    assert_string_equal(ctl_nearest("sky.vis", words, 4), "sky.visibility");
    assert_null(ctl_nearest("entirely.other", words, 4));
    assert_null(ctl_nearest("", words, 4));
    static const char *const view[] = { "views.bridge.entity" };
    assert_null(ctl_nearest("views.bridge.heading", view, 1));
    char endless[4096];
    memset(endless, 'x', sizeof endless - 1);
    endless[sizeof endless - 1] = '\0';
    assert_non_null(ctl_nearest(endless, words, 4));
}

static enum ctl_exit parse(struct ctl *ctl, const char *line)
{
    static GStrv words;
    g_strfreev(words);
    words = g_strsplit(line, " ", -1);
    enum ctl_exit status = ctl_parse(ctl, (int)g_strv_length(words), words);
    g_free(ctl->args);
    ctl->args = NULL;
    return status;
}

static void test_options(void **state)
{
    (void)state;
    struct ctl ctl;
    double width = 0;
    assert_int_equal(parse(&ctl, "ctl -j draw --width=640 a -s tcp:x:1 b"),
                     CTL_DONE);
    assert_true(ctl_flag(&ctl, "json"));
    assert_string_equal(ctl_value(&ctl, "server"), "tcp:x:1");
    assert_int_equal(ctl_number(&ctl, "width", 16, 4096, &width), CTL_DONE);
    assert_true(width == 640);
    assert_int_equal(ctl.arg_count, 2);
    assert_int_equal(parse(&ctl, "ctl draw -5 -.5"), CTL_DONE);
    assert_int_equal(ctl.arg_count, 2);
    assert_int_equal(parse(&ctl, "ctl draw -- --json x"), CTL_DONE);
    assert_int_equal(ctl.arg_count, 2);
    assert_false(ctl_flag(&ctl, "json"));
}

static void test_wrong_command_lines(void **state)
{
    (void)state;
    static const char *const lines[] = {
        "ctl",
        "ctl nothing",
        "ctl draw",
        "ctl draw a b c",
        "ctl draw a b --widht 3",
        "ctl draw a b --width",
        "ctl draw a b --json=1",
        "ctl draw a b -x",
    };
    for (size_t i = 0; i < G_N_ELEMENTS(lines); i++) {
        struct ctl ctl;
        assert_int_equal(parse(&ctl, lines[i]), CTL_USAGE);
    }
    static const char *const numbers[] = { "--width=5",   "--width=5000",
                                           "--width=nan", "--width=1e999",
                                           "--width=7x",  "--width=" };
    for (size_t i = 0; i < G_N_ELEMENTS(numbers); i++) {
        struct ctl ctl;
        double width = 0;
        g_autofree char *line = g_strdup_printf("ctl draw a b %s", numbers[i]);
        assert_int_equal(parse(&ctl, line), CTL_DONE);
        assert_int_equal(ctl_number(&ctl, "width", 16, 4096, &width),
                         CTL_USAGE);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nearest),
        cmocka_unit_test(test_options),
        cmocka_unit_test(test_wrong_command_lines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
