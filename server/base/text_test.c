#include "base/text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <glib.h>

#include "base/err.h"

static void what_is_shown(void **state)
{
    (void)state;
    static const char *const cases[][3] = {
        /* as it came, on one line, with its lines */
        { "plain \xc3\xa4 \xe2\x82\xac \xf0\x9f\x8c\x8a",
          "plain \xc3\xa4 \xe2\x82\xac \xf0\x9f\x8c\x8a",
          "plain \xc3\xa4 \xe2\x82\xac \xf0\x9f\x8c\x8a" },
        { "\x1b[31mred\a\x7f", "?[31mred??", "?[31mred??" },
        { "two\n\tlines\r", "two  lines ", "two\n\tlines " },
        { "\xc2\x9b"
          "31m",
          "?31m", "?31m" }, /* CSI of C1 */
        { "\xff\xfe\x80", "???", "???" },
        { "cut \xe2\x82", "cut ??", "cut ??" },
        { "\xc0\xaf \xe0\x80\xaf", "?? ???", "?? ???" }, /* overlong */
        { "\xed\xa0\x80", "???", "???" },                /* a surrogate */
        { "\xf4\x90\x80\x80", "????", "????" },          /* beyond */
        { "", "", "" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[64];
        strcpy(text, cases[i][0]);
        pel_text_clean(text);
        assert_string_equal(text, cases[i][1]);
        strcpy(text, cases[i][0]);
        pel_text_clean_lines(text);
        assert_string_equal(text, cases[i][2]);
    }
}

/* Against GLib's own judgement. */
static void random_bytes(void **state)
{
    (void)state;
    srand(1);
    for (int i = 0; i < 200000; i++) {
        char text[24], was[24];
        size_t size = (size_t)rand() % sizeof text;
        for (size_t k = 0; k < size; k++) {
            text[k] = (char)(rand() % 3 ? 1 + rand() % 255 : 'a' + rand() % 26);
        }
        text[size < sizeof text ? size : sizeof text - 1] = '\0';
        memcpy(was, text, sizeof was);
        pel_text_clean(text);
        assert_true(g_utf8_validate(text, -1, NULL));
        assert_true(strlen(text) <= strlen(was));
        bool good = g_utf8_validate(was, -1, NULL);
        for (const char *p = was; good && *p; p = g_utf8_next_char(p)) {
            good = !g_unichar_iscntrl(g_utf8_get_char(p));
        }
        assert_int_equal(good, strcmp(text, was) == 0);
    }
}

static void faults(void **state)
{
    (void)state;
    struct pel_fault fault;
    char longest[400];
    memset(longest, 'a', sizeof longest);
    longest[sizeof longest - 1] = '\0';
    for (size_t at = 240; at < 256; at++) { /* where the buffer ends */
        memcpy(longest + at, "\xe2\x82\xac", 3);
    }
    pel_fault_set(&fault, PEL_ERR_INVALID, "%s", longest);
    assert_true(g_utf8_validate(fault.message, -1, NULL));
    strcpy(fault.path, "views.\xff.name");
    strcpy(fault.value, "\x1b]0;x\a");
    pel_fault_clean(&fault);
    assert_string_equal(fault.path, "views.?.name");
    assert_string_equal(fault.value, "?]0;x?");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_shown),
        cmocka_unit_test(random_bytes),
        cmocka_unit_test(faults),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
