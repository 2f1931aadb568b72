#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/log.h"

/* 2026-11-28T23:14:51.007Z */
#define WHEN 1795907691007000000LL

static void each_form(void **state)
{
    (void)state;
    static const struct {
        enum pel_log_format format;
        const char *text;
        unsigned held;
        const char *line;
    } cases[] = {
        { PEL_LOG_TEXT, "stopping", 0,
          "2026-11-28T23:14:51.007Z warning DMN-008 stopping\n" },
        { PEL_LOG_TEXT, "twice", 2,
          "2026-11-28T23:14:51.007Z warning DMN-008 twice (and 2 like it "
          "before)\n" },
        { PEL_LOG_JOURNAL, "stopping", 0, "<4>warning DMN-008 stopping\n" },
        { PEL_LOG_JSON, "say \"\\\"", 0,
          "{\"time\":\"2026-11-28T23:14:51.007Z\",\"level\":\"warning\","
          "\"id\":\"DMN-008\",\"text\":\"say \\\"\\\\\\\"\"}\n" },
        { PEL_LOG_JSON, "twice", 2,
          "{\"time\":\"2026-11-28T23:14:51.007Z\",\"level\":\"warning\","
          "\"id\":\"DMN-008\",\"text\":\"twice\",\"held\":2}\n" },
        { PEL_LOG_TEXT, "a\nb\x1b[31m\xff", 0,
          "2026-11-28T23:14:51.007Z warning DMN-008 a b?[31m?\n" },
        { PEL_LOG_JSON, "a\nb\x01\xff", 0,
          "{\"time\":\"2026-11-28T23:14:51.007Z\",\"level\":\"warning\","
          "\"id\":\"DMN-008\",\"text\":\"a b??\"}\n" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char line[PEL_LOG_LINE], text[1024];
        strcpy(text, cases[i].text);
        size_t length =
            pel_log_line(line, cases[i].format, WHEN, PEL_LOG_WARNING,
                         "DMN-008", text, cases[i].held);
        assert_string_equal(line, cases[i].line);
        assert_int_equal(length, strlen(cases[i].line));
    }
}

/* The longest text that a record has, all of it quoted. */
static void the_longest_is_whole(void **state)
{
    (void)state;
    char line[PEL_LOG_LINE], text[1024];
    memset(text, '"', sizeof text - 1);
    text[sizeof text - 1] = 0;
    size_t length = pel_log_line(line, PEL_LOG_JSON, WHEN, PEL_LOG_INFO,
                                 "DMN-008", text, 4000000000U);
    assert_true(length < PEL_LOG_LINE);
    assert_string_equal(line + length - 3 - strlen(",\"held\":4000000000"),
                        "\"\",\"held\":4000000000}\n" + 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_form),
        cmocka_unit_test(the_longest_is_whole),
    };
    return cmocka_run_group_tests_name("log", tests, NULL, NULL);
}
