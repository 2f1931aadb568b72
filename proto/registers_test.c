/* The table is consistent, and numbers pass through registers unharmed. */
#include "registers.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "path.h"

/* cmocka's assert_float_equal compares in single precision. */
#define assert_near(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))

static void floats_go_out_in_each_order(void **state)
{
    (void)state;
    /* 123456.789f is 0x47f12065; libmodbus 3.1.6 gets this wrong. */
    static const uint16_t wanted[4][2] = {
        [PEL_MODBUS_ABCD] = { 0x47f1, 0x2065 },
        [PEL_MODBUS_CDAB] = { 0x2065, 0x47f1 },
        [PEL_MODBUS_BADC] = { 0xf147, 0x6520 },
        [PEL_MODBUS_DCBA] = { 0x6520, 0xf147 },
    };
    for (int order = 0; order < 4; order++) {
        uint16_t words[2];
        pel_register_encode(PEL_TYPE_F32, (enum pel_modbus_order)order,
                            123456.789, words);
        assert_memory_equal(words, wanted[order], sizeof words);
        /* Single precision: 24 bits. */
        assert_near(pel_register_decode(PEL_TYPE_F32,
                                        (enum pel_modbus_order)order, words),
                    123456.789, 123456.789 * 0x1p-24);
    }
    uint16_t half[2];
    pel_register_encode(PEL_TYPE_F32, PEL_MODBUS_ABCD, 3.5, half);
    assert_int_equal(half[0], 0x4060);
    assert_int_equal(half[1], 0);
}

static void doubles_and_integers_go_out_in_each_order(void **state)
{
    (void)state;
    static const uint16_t pi[4] = { 0x4009, 0x21fb, 0x5444, 0x2d18 };
    uint16_t words[4];
    pel_register_encode(PEL_TYPE_F64, PEL_MODBUS_ABCD, 0x1.921fb54442d18p+1,
                        words);
    assert_memory_equal(words, pi, sizeof pi);
    pel_register_encode(PEL_TYPE_F64, PEL_MODBUS_CDAB, 0x1.921fb54442d18p+1,
                        words);
    assert_int_equal(words[0], 0x2d18);
    assert_int_equal(words[3], 0x4009);
    pel_register_encode(PEL_TYPE_U32, PEL_MODBUS_ABCD, PEL_PROBE_U32, words);
    assert_int_equal(words[0], 0x0102);
    assert_int_equal(words[1], 0x0304);
    pel_register_encode(PEL_TYPE_U16, PEL_MODBUS_DCBA, 0x0102, words);
    assert_int_equal(words[0], 0x0102); /* one register has one order */
}

static void numbers_come_back(void **state)
{
    (void)state;
    static const struct {
        enum pel_register_type type;
        double value, back;
    } cases[] = {
        { PEL_TYPE_U16, 65535, 65535 },
        { PEL_TYPE_U16, 65536, 65535 },
        { PEL_TYPE_U16, -1, 0 },
        { PEL_TYPE_I16, -32768, -32768 },
        { PEL_TYPE_I16, 40000, 32767 },
        { PEL_TYPE_U32, 4294967295.0, 4294967295.0 },
        { PEL_TYPE_U32, -5, 0 },
        { PEL_TYPE_I32, -1799999999, -1799999999 },
        { PEL_TYPE_I32, 3e9, 2147483647 },
        { PEL_TYPE_F32, -0.5, -0.5 },
        { PEL_TYPE_F64, 1e9 + 1.0 / 3, 1e9 + 1.0 / 3 },
        { PEL_TYPE_I32, NAN, INT32_MIN },
        { PEL_TYPE_U32, NAN, UINT32_MAX },
        { PEL_TYPE_BIT, 1, 1 },
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (int order = 0; order < 4; order++) {
            uint16_t words[4];
            enum pel_modbus_order o = (enum pel_modbus_order)order;
            pel_register_encode(cases[i].type, o, cases[i].value, words);
            assert_true(pel_register_decode(cases[i].type, o, words) ==
                        cases[i].back);
        }
    }
    uint16_t words[4];
    pel_register_encode(PEL_TYPE_F32, PEL_MODBUS_CDAB, NAN, words);
    assert_true(
        isnan(pel_register_decode(PEL_TYPE_F32, PEL_MODBUS_CDAB, words)));
}

static void the_table_fits_its_spaces_and_the_schema(void **state)
{
    (void)state;
    static const unsigned sizes[] = { PEL_HOLDING_COUNT, PEL_INPUT_COUNT,
                                      PEL_DISCRETE_COUNT, PEL_COIL_COUNT };
    for (size_t i = 0; i < pel_register_count; i++) {
        const struct pel_register *reg = &pel_registers[i];
        unsigned end = reg->address + (unsigned)pel_register_words(reg->type);
        assert_true(end <= sizes[reg->space]);
        if (i + 1 < pel_register_count && reg[1].space == reg->space) {
            assert_true(reg[1].address >= end);
        }
        assert_ptr_equal(pel_register_at(reg->space, reg->address), reg);
        struct pel_path_info info;
        char path[96];
        int view;
        if (reg->path) {
            assert_int_equal(
                pel_register_path(reg, "x", path, sizeof path, &view), PEL_OK);
            assert_int_equal(pel_path_find(path, &info, NULL), PEL_OK);
            assert_true(info.field->type == PROTOBUF_C_TYPE_ENUM ||
                        info.field->type == PROTOBUF_C_TYPE_BOOL ||
                        info.info->ranged);
        }
    }
    assert_null(pel_register_at(PEL_SPACE_HOLDING, 6));
    assert_false(pel_register_writable(pel_register_at(PEL_SPACE_HOLDING, 0)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(floats_go_out_in_each_order),
        cmocka_unit_test(doubles_and_integers_go_out_in_each_order),
        cmocka_unit_test(numbers_come_back),
        cmocka_unit_test(the_table_fits_its_spaces_and_the_schema),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
