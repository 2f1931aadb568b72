#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fields.h"
#include "message.h"
#include "pelagos.pb-c.h"
#include "scene/lookup.h"

static const ProtobufCFieldDescriptor *entities(void)
{
    return pel_field_by_name(&pelagos__state__descriptor, "entities", 8);
}

static Pelagos__Entity *add(Pelagos__State *state, uint32_t id)
{
    Pelagos__Entity *e =
        (Pelagos__Entity *)pel_message_append(&state->base, entities());
    e->has_id = id > 0;
    e->id = id;
    return e;
}

/* More than it has places for, some without a key, in no order. */
static void all_are_found(void **unused)
{
    (void)unused;
    enum { MANY = PEL_LOOKUP_ROOM };
    static struct pel_lookup lookup;
    Pelagos__State *state =
        (Pelagos__State *)pel_message_new(&pelagos__state__descriptor);
    Pelagos__Entity like = PELAGOS__ENTITY__INIT;
    pel_lookup_begin(&lookup, &state->base, entities());
    like.has_id = true;
    for (uint32_t i = 1; i <= MANY; i++) {
        like.id = i * 2654435761U;
        assert_null(pel_lookup_find(&lookup, &like.base));
        add(state, i % 7 == 0 ? 0 : like.id);
    }
    assert_null(pel_lookup_twin(&lookup));
    for (uint32_t i = MANY; i >= 1; i--) {
        like.id = i * 2654435761U;
        const ProtobufCMessage *found = pel_lookup_find(&lookup, &like.base);
        assert_ptr_equal(found, i % 7 == 0 ? NULL : state->entities[i - 1]);
    }
    like.has_id = false;
    assert_null(pel_lookup_find(&lookup, &like.base));
    pelagos__state__free_unpacked(state, NULL);
}

static void the_first_of_two_is_found_and_the_second_told(void **unused)
{
    (void)unused;
    struct pel_lookup lookup;
    Pelagos__State *state =
        (Pelagos__State *)pel_message_new(&pelagos__state__descriptor);
    Pelagos__Entity *first = add(state, 5);
    add(state, 6);
    Pelagos__Entity *second = add(state, 5);
    pel_lookup_begin(&lookup, &state->base, entities());
    assert_ptr_equal(pel_lookup_find(&lookup, &second->base), first);
    pel_lookup_begin(&lookup, &state->base, entities());
    assert_ptr_equal(pel_lookup_twin(&lookup), second);
    pelagos__state__free_unpacked(state, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_are_found),
        cmocka_unit_test(the_first_of_two_is_found_and_the_second_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
