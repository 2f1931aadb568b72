/* Counts the requests that clients have under way, and the answers that they
 * have not read, by role and token: base/share.h says how much of each kind a
 * role and a token may have. Control thread. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "base/metrics.h"
#include "base/share.h"

enum pel_claim_kind {
    PEL_CLAIM_PICTURES,  /* not drawn yet */
    PEL_CLAIM_SURFACES,  /* queries */
    PEL_CLAIM_OPTICS,    /* queries */
    PEL_CLAIM_QUESTIONS, /* of spectra, soundings, the almanac, models,
                            recordings */
    PEL_CLAIM_UNREAD,    /* bytes of answers */
    PEL_CLAIM_KINDS,
};

struct pel_claims;

/* Part of its holder; { 0 } at first, and given back before its end. */
struct pel_claim {
    struct pel_claims *all; /* NULL: nothing is taken */
    enum pel_claim_kind kind;
    struct pel_who who;
    uint64_t amount;
    int64_t since_ns;
    /* For UNREAD: ends the client, not before the loop's next turn. */
    void (*end)(void *user);
    void *user;
};

struct pel_claims *pel_claims_create(void);
void pel_claims_destroy(struct pel_claims *all); /* NULL allowed */

/* BUSY, saying whose share is taken; frames have limits of their own as well.
 * all NULL: nothing is counted. */
PEL_CHECK enum pel_err pel_claim_take(struct pel_claims *all,
                                      enum pel_claim_kind kind,
                                      const struct pel_who *who,
                                      uint64_t amount, struct pel_claim *claim,
                                      struct pel_fault *fault);

/* A client has so many bytes to read now; 0: none. Where that is more than all
 * may have, or its rank, or its token, the one of them ends that has had most
 * for longest (bytes times seconds), of the lowest rank first, but never this
 * one. `end` and `user` are those of *claim. */
void pel_claim_unread(struct pel_claims *all, const struct pel_who *who,
                      uint64_t bytes, struct pel_claim *claim);

void pel_claim_give(struct pel_claim *claim); /* also of { 0 } */

void pel_claims_collect(const struct pel_claims *all,
                        struct pel_metrics_page *page);
