#include "base/share.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* Takes places until no more are given; how many. */
static uint64_t fill(struct pel_taken *taken, uint64_t places,
                     struct pel_who who)
{
    uint64_t got = 0;
    while (pel_share_ask(places, taken, &who, 1) == PEL_SHARE_FREE) {
        pel_taken_add(taken, &who, &who, 1);
        got++;
    }
    return got;
}

static void leaves_places_to_those_above(void **state)
{
    (void)state;
    struct pel_taken taken = { { 0 }, 0 };
    assert_int_equal(fill(&taken, 64, (struct pel_who){ PEL_RANK_NOBODY, 0 }),
                     24);
    assert_int_equal(fill(&taken, 64, (struct pel_who){ PEL_RANK_WATCH, 1 }),
                     24);
    taken.of_token = 0;
    assert_int_equal(fill(&taken, 64, (struct pel_who){ PEL_RANK_STEER, 2 }),
                     8);
    assert_int_equal(fill(&taken, 64, (struct pel_who){ PEL_RANK_INSTRUCT, 0 }),
                     8);
}

static void leaves_places_to_other_tokens(void **state)
{
    (void)state;
    struct pel_taken taken = { { 0 }, 0 };
    struct pel_who one = { PEL_RANK_WATCH, 1 }, other = { PEL_RANK_WATCH, 2 };
    assert_int_equal(fill(&taken, 64, one), 36);
    assert_int_equal(pel_share_ask(64, &taken, &one, 1), PEL_SHARE_TOKEN_FULL);
    taken.of_token = 0;
    assert_int_equal(fill(&taken, 64, other), 12);
    assert_int_equal(pel_share_ask(64, &taken, &other, 1), PEL_SHARE_RANK_FULL);
}

/* Places that those above have taken are not given twice. */
static void counts_all(void **state)
{
    (void)state;
    struct pel_taken taken = { { 64 }, 0 };
    struct pel_who watch = { PEL_RANK_WATCH, 1 }, instruct = { 0 };
    assert_int_equal(pel_share_ask(64, &taken, &watch, 1), PEL_SHARE_RANK_FULL);
    assert_int_equal(pel_share_ask(64, &taken, &instruct, 1),
                     PEL_SHARE_RANK_FULL);
    assert_int_equal(pel_share_of_rank(UINT64_MAX, PEL_RANK_INSTRUCT),
                     UINT64_MAX);
    assert_int_equal(pel_share_of_token(1, PEL_RANK_WATCH), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(leaves_places_to_those_above),
        cmocka_unit_test(leaves_places_to_other_tokens),
        cmocka_unit_test(counts_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
