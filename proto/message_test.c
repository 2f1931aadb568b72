#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "json.h"
#include "message.h"
#include "pelagos.pb-c.h"

static ProtobufCMessage *state_of(const char *json)
{
    Pelagos__Patch *patch;
    struct pel_fault fault;
    if (pel_json_merge_patch(json, strlen(json), &patch, &fault)) {
        fail_msg("%s: %s", json, fault.message);
    }
    ProtobufCMessage *state = pel_message_copy(&patch->state->base);
    pelagos__patch__free_unpacked(patch, NULL);
    return state;
}

static const char *const states[] = {
    "{}",
    "{\"entities\":{\"1\":{\"name\":\"a\",\"speed\":3}}}",
    "{\"entities\":{\"1\":{\"name\":\"a longer name\",\"model\":{\"name\":"
    "\"tug\"},\"helm\":{\"on\":true}},\"2\":{},\"3\":{\"light\":{\"character\":"
    "\"Q\",\"sectors\":[{}]}}}}",
    "{\"sea\":{\"swell\":[{\"height\":1},{\"height\":2}],\"seed\":7},"
    "\"views\":{\"bow\":{\"entity\":1,\"at\":{\"latitude\":1}}}}",
    "{\"sea\":{\"swell\":[{\"height\":3}]},\"clock\":{\"utc\":"
    "\"2026-06-21T12:00:00Z\"},\"views\":{\"bow\":{},\"mast\":{}}}",
};
#define STATES (sizeof states / sizeof *states)

/* From each to each, and back: what one has and the other lacks, lists that
 * grow and shrink. */
static void a_copy_onto_another_is_a_copy(void **unused)
{
    (void)unused;
    for (size_t i = 0; i < STATES * STATES; i++) {
        ProtobufCMessage *from = state_of(states[i % STATES]);
        ProtobufCMessage *old = state_of(states[i / STATES]);
        ProtobufCMessage *copy = pel_message_copy_onto(old, from);
        assert_ptr_equal(copy, old);
        assert_true(pel_message_same(copy, from));
        protobuf_c_message_free_unpacked(from, NULL);
        copy = pel_message_copy_onto(NULL, copy);
        assert_true(pel_message_same(copy, old));
        protobuf_c_message_free_unpacked(old, NULL);
        protobuf_c_message_free_unpacked(copy, NULL);
    }
}

static void pieces_are_used_again(void **unused)
{
    (void)unused;
    ProtobufCMessage *from = state_of(states[2]), *old = state_of(states[2]);
    const Pelagos__Entity *first = ((Pelagos__State *)old)->entities[0];
    const char *name = first->name;
    const void *model = first->model, *helm = first->helm;
    const Pelagos__State *copy =
        (Pelagos__State *)pel_message_copy_onto(old, from);
    assert_ptr_equal(copy->entities[0], first);
    assert_ptr_equal(first->name, name);
    assert_ptr_equal(first->model, model);
    assert_ptr_equal(first->helm, helm);
    protobuf_c_message_free_unpacked(from, NULL);
    protobuf_c_message_free_unpacked(old, NULL);
}

/* Of a oneof the other member. */
static void one_of_several(void **unused)
{
    (void)unused;
    Pelagos__Request ask = PELAGOS__REQUEST__INIT, watch = ask;
    Pelagos__Login login = PELAGOS__LOGIN__INIT;
    Pelagos__Watch all = PELAGOS__WATCH__INIT;
    char token[] = "a token";
    login.token = token;
    ask.command_case = PELAGOS__REQUEST__COMMAND_LOGIN;
    ask.login = &login;
    watch.command_case = PELAGOS__REQUEST__COMMAND_WATCH;
    watch.watch = &all;
    ProtobufCMessage *copy = pel_message_copy(&ask.base);
    copy = pel_message_copy_onto(copy, &watch.base);
    assert_true(pel_message_same(copy, &watch.base));
    copy = pel_message_copy_onto(copy, &ask.base);
    assert_true(pel_message_same(copy, &ask.base));
    protobuf_c_message_free_unpacked(copy, NULL);
}

/* What a newer version wrote is neither kept nor lost from the heap. */
static void unknown_fields_go(void **unused)
{
    (void)unused;
    const uint8_t bytes[] = { 0xfa, 0xff, 0x07, 3, 'a', 'b', 'c' };
    ProtobufCMessage *old = protobuf_c_message_unpack(
        &pelagos__state__descriptor, NULL, sizeof bytes, bytes);
    assert_non_null(old);
    assert_int_equal(old->n_unknown_fields, 1);
    ProtobufCMessage *from = state_of(states[1]);
    ProtobufCMessage *copy = pel_message_copy_onto(old, from);
    assert_int_equal(copy->n_unknown_fields, 0);
    assert_true(pel_message_same(copy, from));
    protobuf_c_message_free_unpacked(from, NULL);
    protobuf_c_message_free_unpacked(copy, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_copy_onto_another_is_a_copy),
        cmocka_unit_test(pieces_are_used_again),
        cmocka_unit_test(one_of_several),
        cmocka_unit_test(unknown_fields_go),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
