/* Models of entities: a built-in one that was had lately is had again as it is,
 * and which are kept is bounded. */
#include "scene/fleet.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* The model of a scene with one life raft so long [m], which is then left. */
static const struct pel_model *raft(double length_m)
{
    static const struct pel_fleet none;
    char name[] = "life-raft";
    Pelagos__Model wish = PELAGOS__MODEL__INIT;
    Pelagos__Entity entity = PELAGOS__ENTITY__INIT, *entities[] = { &entity };
    Pelagos__State state = PELAGOS__STATE__INIT;
    struct pel_fleet fleet;
    size_t next = 0;
    wish.name = name;
    wish.has_length = true;
    wish.length = length_m;
    entity.id = 3;
    entity.model = &wish;
    state.entities = entities;
    state.n_entities = 1;
    assert_int_equal(pel_fleet_get(&state, NULL, false, &none, &fleet, NULL),
                     PEL_OK);
    const struct pel_model *model =
        pel_model_ref(pel_fleet_of(&fleet, &entity, &next));
    pel_fleet_finish(&fleet);
    assert_non_null(model);
    return model;
}

static void the_same_again(void **state)
{
    (void)state;
    const struct pel_model *first = raft(3.4), *other = raft(3.5),
                           *again = raft(3.4);
    assert_ptr_equal(first, again);
    assert_ptr_not_equal(first, other);
    assert_true(other->length_m > first->length_m);
    pel_model_unref(first);
    pel_model_unref(other);
    pel_model_unref(again);
}

/* After forty others it is made anew; one that is wanted in between stays. */
static void not_for_ever(void **state)
{
    (void)state;
    const struct pel_model *first = raft(3.4), *wanted = raft(3.3);
    for (int i = 0; i < 40; i++) {
        pel_model_unref(raft(3.6 + 0.02 * i));
        const struct pel_model *again = raft(3.3);
        assert_ptr_equal(again, wanted);
        pel_model_unref(again);
    }
    const struct pel_model *anew = raft(3.4);
    assert_ptr_not_equal(first, anew);
    pel_model_unref(first);
    pel_model_unref(wanted);
    pel_model_unref(anew);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_again),
        cmocka_unit_test(not_for_ever),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
