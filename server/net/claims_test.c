#include "net/claims.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "bounds.h"

#define MIB ((uint64_t)1 << 20)

static const struct pel_who one = { PEL_RANK_WATCH, 1 },
                            other = { PEL_RANK_WATCH, 2 },
                            instructor = { PEL_RANK_INSTRUCT, 3 };

static void what_is_under_way_is_shared_out(void **state)
{
    (void)state;
    struct pel_claims *all = pel_claims_create();
    struct pel_claim claims[PEL_BOUND_SURFACE_QUERIES + 1] = { { 0 } };
    struct pel_fault fault;
    unsigned count = 0, first;
    while (!pel_claim_take(all, PEL_CLAIM_SURFACES, &one, 1, &claims[count],
                           &fault)) {
        count++;
    }
    first = count;
    assert_int_equal(
        count, pel_share_of_token(PEL_BOUND_SURFACE_QUERIES, PEL_RANK_WATCH));
    assert_int_equal(fault.code, PEL_ERR_BUSY);
    while (!pel_claim_take(all, PEL_CLAIM_SURFACES, &other, 1, &claims[count],
                           &fault)) {
        count++;
    }
    assert_true(count > first && count < PEL_BOUND_SURFACE_QUERIES);
    while (!pel_claim_take(all, PEL_CLAIM_SURFACES, &instructor, 1,
                           &claims[count], &fault)) {
        count++;
    }
    assert_int_equal(count, PEL_BOUND_SURFACE_QUERIES);
    for (unsigned i = 0; i < count; i++) {
        pel_claim_give(&claims[i]);
        pel_claim_give(&claims[i]); /* once */
    }
    assert_int_equal(
        pel_claim_take(all, PEL_CLAIM_SURFACES, &one, 1, &claims[0], &fault),
        PEL_OK);
    pel_claims_destroy(all);
    pel_claim_give(&claims[0]); /* it outlives them */
}

static void end(void *user)
{
    ++*(int *)user;
}

/* Each has 64 MiB; the bound is 384. */
static void who_has_most_unread_for_longest_ends(void **state)
{
    (void)state;
    struct pel_claims *all = pel_claims_create();
    struct pel_claim claims[12] = { { 0 } };
    int ended[12] = { 0 };
    for (int i = 0; i < 12; i++) {
        claims[i].end = end;
        claims[i].user = &ended[i];
    }
    for (int i = 0; i < 3; i++) { /* of 216 that one token may have */
        pel_claim_unread(all, &one, 64 * MIB, &claims[i]);
    }
    claims[1].since_ns -= 5000000000;
    pel_claim_unread(all, &one, 64 * MIB, &claims[3]);
    assert_true(ended[1] == 1 && !ended[0] && !ended[2] && !ended[3]);
    /* An instructor's answers end those of lower roles first. */
    for (int i = 4; i < 10; i++) {
        pel_claim_unread(all, &instructor, 64 * MIB, &claims[i]);
        assert_int_equal(ended[i], 0);
    }
    assert_int_equal(ended[0] + ended[2] + ended[3], 3);
    /* One that is larger than all may have is let be, alone. */
    pel_claim_unread(all, &instructor, PEL_BOUND_UNREAD_BYTES + 1, &claims[10]);
    for (int i = 4; i < 10; i++) {
        assert_int_equal(ended[i], 1);
    }
    assert_int_equal(ended[10], 0);
    pel_claim_unread(all, &instructor, 0, &claims[10]); /* it is read */
    assert_null(claims[10].all);
    pel_claims_destroy(all);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_under_way_is_shared_out),
        cmocka_unit_test(who_has_most_unread_for_longest_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
