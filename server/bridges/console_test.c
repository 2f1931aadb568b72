#include "bridges/console_table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/near.h"

static struct pel_console_table table;

static enum pel_err read_text(const char *text, struct pel_fault *fault)
{
    return pel_console_table_read(text, strlen(text), PEL_MODBUS_ABCD, &table,
                                  fault);
}

static void reads_a_table(void **state)
{
    (void)state;
    struct pel_fault fault;
    assert_int_equal(
        read_text("# a console\r\n"
                  "\n"
                  "holding 12 f32 sea.windSpeed order=cdab # the fan\n"
                  "holding 10 i16 entities.1.heading scale=0.1 offset=-5 "
                  "min=0 max=360 deadband=0.2\n"
                  "coil 3 bit views.bridge.width scale=100 offset=200 "
                  "stale=300\n"
                  "input 11 u16 views.bridge.height\n"
                  "holding 11 i16 entities.1.roll",
                  &fault),
        PEL_OK);
    assert_int_equal(table.row_count, 5);
    /* three neighbours, an input, a coil */
    assert_int_equal(table.group_count, 3);
    assert_int_equal(table.groups[0].space, PEL_SPACE_HOLDING);
    assert_int_equal(table.groups[0].address, 10);
    assert_int_equal(table.groups[0].words, 4);
    assert_int_equal(table.groups[0].count, 3);
    assert_string_equal(table.rows[0].path, "entities.1.heading");
    const uint16_t turned[] = { (uint16_t)-20 }, far[] = { 9999 };
    assert_near(pel_console_value(&table.rows[0], turned), 0, 0); /* held */
    assert_near(pel_console_value(&table.rows[0], far), 360, 0);
    const uint16_t fan[] = { 0x0000, 0x4060 }; /* 3.5, low word first */
    assert_near(pel_console_value(&table.rows[2], fan), 3.5, 0);
    const uint16_t nan[] = { 0x0000, 0x7fc0 };
    assert_true(isnan(pel_console_value(&table.rows[2], nan)));
    assert_true(table.rows[4].has_stale);
    assert_near(table.rows[4].stale, 300, 0);
}

static void refuses_what_is_no_table(void **state)
{
    (void)state;
    static const struct {
        const char *text, *says;
    } bad[] = {
        { "", "no row" },
        { "# nothing\n", "no row" },
        { "holding 1 i16", "line 1" },
        { "\nregister 1 i16 sea.windSpeed", "line 2: the first word" },
        { "holding -1 i16 sea.windSpeed", "0 .. 65535" },
        { "holding 65536 i16 sea.windSpeed", "0 .. 65535" },
        { "holding 65535 f32 sea.windSpeed", "65535" },
        { "holding 1 float sea.windSpeed", "the type" },
        { "holding 1 bit sea.windSpeed", "bit" },
        { "coil 1 i16 sea.windSpeed", "bit" },
        { "holding 1 i16 sea.wind", "no field" },
        { "holding 1 i16 clock.utc", "no field" },
        { "holding 1 i16 sea", "no field" },
        { "holding 1 i16 sea.windSpeed scale", "NAME=VALUE" },
        { "holding 1 i16 sea.windSpeed scale=", "finite" },
        { "holding 1 i16 sea.windSpeed scale=nan", "finite" },
        { "holding 1 i16 sea.windSpeed size=1", "known are" },
        { "holding 1 i16 sea.windSpeed order=dabc", "order" },
        { "holding 1 i16 sea.windSpeed min=2 max=1", "min" },
        { "holding 1 i16 sea.windSpeed deadband=-1", "deadband" },
        { "holding 1 i16 sea.fetch\nholding 2 i16 sea.fetch", "earlier" },
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct pel_fault fault;
        assert_int_equal(read_text(bad[i].text, &fault), PEL_ERR_INVALID);
        if (!strstr(fault.message, bad[i].says)) {
            fail_msg("%s: %s", bad[i].text, fault.message);
        }
    }
    struct pel_fault fault;
    assert_int_equal(
        pel_console_table_read("coil\0", 5, PEL_MODBUS_ABCD, &table, &fault),
        PEL_ERR_INVALID);
    char *many = malloc(300 * 64);
    size_t used = 0;
    for (int i = 0; i < 257; i++) {
        used += (size_t)sprintf(many + used,
                                "holding %d i16 entities.%d.heading\n", i, i);
    }
    assert_int_equal(read_text(many, &fault), PEL_ERR_INVALID);
    assert_non_null(strstr(fault.message, "line 257"));
    free(many);
}

static void long_runs_are_cut(void **state)
{
    (void)state;
    struct pel_fault fault;
    char *text = malloc(200 * 64);
    size_t used = 0;
    for (int i = 0; i < 100; i++) {
        used += (size_t)sprintf(
            text + used, "holding %d f32 entities.%d.heading\n", 2 * i, i);
    }
    assert_int_equal(read_text(text, &fault), PEL_OK);
    free(text);
    /* 62 floats are 124 of at most 125 registers */
    assert_int_equal(table.group_count, 2);
    assert_int_equal(table.groups[0].words, 124);
    assert_int_equal(table.groups[1].address, 124);
    assert_int_equal(table.groups[1].words, 76);
}

static void answers(void **state)
{
    (void)state;
    struct pel_fault fault;
    uint16_t words[PEL_CONSOLE_MAX_BITS];
    unsigned code = 0;
    uint8_t adu[12];
    assert_int_equal(read_text("holding 5 i16 sea.windSpeed\n"
                               "holding 6 i16 sea.fetch\n",
                               &fault),
                     PEL_OK);
    const struct pel_console_group *g = &table.groups[0];
    static const uint8_t request[] = {
        0x12, 0x34, 0, 0, 0, 6, 9, 3, 0, 5, 0, 2
    };
    assert_int_equal(pel_console_request(g, 0x1234, 9, adu), 12);
    assert_memory_equal(adu, request, 12);
    const uint8_t good[] = {
        0x12, 0x34, 0, 0, 0, 7, 9, 3, 4, 1, 2, 0xff, 0xfe
    };
    for (size_t n = 0; n < sizeof good; n++) {
        assert_int_equal(
            pel_console_answer(g, 0x1234, 9, good, n, words, &code),
            PEL_CONSOLE_MORE);
    }
    assert_int_equal(
        pel_console_answer(g, 0x1234, 9, good, sizeof good, words, &code),
        PEL_CONSOLE_VALUES);
    assert_int_equal(words[0], 0x102);
    assert_int_equal(words[1], 0xfffe);
    for (size_t i = 0; i < 9; i++) { /* any byte of the head that differs */
        uint8_t wrong[sizeof good];
        memcpy(wrong, good, sizeof good);
        wrong[i] ^= 0x40;
        assert_int_equal(
            pel_console_answer(g, 0x1234, 9, wrong, sizeof good, words, &code),
            PEL_CONSOLE_WRONG);
    }
    const uint8_t refused[] = { 0x12, 0x34, 0, 0, 0, 3, 9, 0x83, 2 };
    assert_int_equal(
        pel_console_answer(g, 0x1234, 9, refused, sizeof refused, words, &code),
        PEL_CONSOLE_EXCEPTION);
    assert_int_equal(code, 2);
}

static void bits(void **state)
{
    (void)state;
    struct pel_fault fault;
    uint16_t words[PEL_CONSOLE_MAX_BITS];
    unsigned code;
    assert_int_equal(read_text("coil 0 bit sea.windSpeed\n"
                               "coil 8 bit sea.fetch\n"
                               "coil 9 bit sea.gamma\n",
                               &fault),
                     PEL_OK);
    assert_int_equal(table.group_count, 2);
    const uint8_t two[] = { 0, 1, 0, 0, 0, 4, 1, 1, 1, 2 };
    assert_int_equal(pel_console_answer(&table.groups[1], 1, 1, two, sizeof two,
                                        words, &code),
                     PEL_CONSOLE_VALUES);
    assert_int_equal(words[0], 0);
    assert_int_equal(words[1], 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_a_table),
        cmocka_unit_test(refuses_what_is_no_table),
        cmocka_unit_test(long_runs_are_cut),
        cmocka_unit_test(answers),
        cmocka_unit_test(bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
