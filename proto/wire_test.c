#include "wire.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fault.h"
#include "message.h"
#include "unpack.h"

static void frames_split_anywhere(void **state)
{
    (void)state;
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    Pelagos__SurfaceQuery query = PELAGOS__SURFACE_QUERY__INIT;
    Pelagos__Point points[40];
    Pelagos__Point *list[40];
    for (int i = 0; i < 40; i++) {
        pelagos__point__init(&points[i]);
        points[i].has_east = true;
        points[i].east = i;
        list[i] = &points[i];
    }
    query.n_points = 40;
    query.points = list;
    request.has_id = true;
    request.id = 7;
    request.command_case = PELAGOS__REQUEST__COMMAND_SURFACE;
    request.surface = &query;
    size_t size, offset, length;
    uint8_t *bytes = pel_wire_pack(&request.base, &size);
    assert_true(size > 300); /* so that the prefix has two bytes */
    for (size_t have = 0; have < size; have++) {
        assert_int_equal(
            pel_wire_next(bytes, have, PEL_WIRE_MAX_REQUEST, &offset, &length),
            PEL_WIRE_MORE);
    }
    assert_int_equal(
        pel_wire_next(bytes, size, PEL_WIRE_MAX_REQUEST, &offset, &length),
        PEL_WIRE_MESSAGE);
    assert_int_equal(offset, 2);
    assert_int_equal(offset + length, size);
    Pelagos__Request *back =
        pelagos__request__unpack(NULL, length, bytes + offset);
    assert_non_null(back);
    assert_int_equal(back->surface->n_points, 40);
    pelagos__request__free_unpacked(back, NULL);
    free(bytes);
}

static void prefixes_are_bounded(void **state)
{
    (void)state;
    size_t offset, length;
    const uint8_t endless[] = { 0xff, 0xff, 0xff, 0xff, 0xff, 0xff };
    assert_int_equal(pel_wire_next(endless, 4, 100, &offset, &length),
                     PEL_WIRE_MORE);
    assert_int_equal(pel_wire_next(endless, 6, 100, &offset, &length),
                     PEL_WIRE_MALFORMED);
    const uint8_t big[] = { 0xe5, 0x00 };
    assert_int_equal(pel_wire_next(big, 2, 100, &offset, &length),
                     PEL_WIRE_TOO_LONG);
    assert_int_equal(length, 101);
    const uint8_t empty[] = { 0 };
    assert_int_equal(pel_wire_next(empty, 1, 100, &offset, &length),
                     PEL_WIRE_MESSAGE);
    assert_int_equal(length, 0);
    for (size_t n = 0; n < 70000; n += 63) {
        uint8_t out[PEL_WIRE_MAX_PREFIX];
        size_t used = pel_wire_prefix(n, out);
        pel_wire_next(out, used, SIZE_MAX, &offset, &length);
        assert_int_equal(length, n);
    }
}

static void faults_travel(void **state)
{
    (void)state;
    struct pel_fault fault, back;
    pel_fault_set(&fault, PEL_ERR_OUT_OF_RANGE, "too much");
    pel_fault_at(&fault, "sea.windSpeed", "99");
    assert_string_equal(fault.unit, "m/s");
    assert_true(fault.minimum == 0 && fault.maximum == 30);
    Pelagos__Error error;
    pel_fault_to_error(&fault, &error);
    size_t size;
    uint8_t *bytes = pel_wire_pack(&error.base, &size);
    Pelagos__Error *sent = pelagos__error__unpack(NULL, size - 1, bytes + 1);
    assert_non_null(sent);
    pel_fault_from_error(sent, &back);
    assert_int_equal(back.code, PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(back.path, "sea.windSpeed");
    assert_string_equal(back.value, "99");
    assert_string_equal(back.unit, "m/s");
    assert_string_equal(back.message, "too much");
    assert_true(back.minimum == 0 && back.maximum == 30);
    pelagos__error__free_unpacked(sent, NULL);
    free(bytes);
}

/* What the schema does not know, by tags of all lengths: a copy is without it,
 * and what was forgotten can be packed and read again. */
static void fields_that_nobody_knows(void **state)
{
    (void)state;
    struct pel_unpack unpack;
    pel_unpack_init(&unpack);
    unsigned read = 0;
    srand(3);
    for (int i = 0; i < 300000; i++) {
        uint8_t bytes[64] = { 0x0a, 0, 0x1a, 0 };
        size_t inner = 1 + (size_t)rand() % 24;
        bytes[1] = (uint8_t)(inner + 2);
        bytes[3] = (uint8_t)inner;
        for (size_t k = 0; k < inner; k++) {
            int kind = rand() % 4;
            bytes[4 + k] = (uint8_t)(kind == 0   ? 0
                                     : kind == 1 ? 0x80 | (rand() & 0x7f)
                                                 : rand());
        }
        Pelagos__Patch *patch =
            pelagos__patch__unpack(&unpack.allocator, inner + 4, bytes);
        if (patch) {
            ProtobufCMessage *copy = pel_message_copy(&patch->base);
            pel_message_forget_unknown(&patch->base);
            size_t size = 0, copied = 0;
            uint8_t *one = pel_wire_pack(&patch->base, &size);
            uint8_t *two = pel_wire_pack(copy, &copied);
            assert_int_equal(size, copied);
            assert_memory_equal(one, two, size);
            size_t offset, length;
            assert_int_equal(pel_wire_next(one, size, 1000, &offset, &length),
                             PEL_WIRE_MESSAGE);
            Pelagos__Patch *again =
                pelagos__patch__unpack(&unpack.allocator, length, one + offset);
            assert_non_null(again);
            protobuf_c_message_free_unpacked(copy, NULL);
            free(one);
            free(two);
            read++;
        }
        pel_unpack_reset(&unpack);
    }
    pel_unpack_finish(&unpack);
    assert_true(read > 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_that_nobody_knows),
        cmocka_unit_test(frames_split_anywhere),
        cmocka_unit_test(prefixes_are_bounded),
        cmocka_unit_test(faults_travel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
