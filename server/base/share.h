/* How the places of one kind are shared out by who asks for them, so that
 * clients who may do less leave places to those who may do more, and one token
 * leaves places to another. Plain functions; any thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

/* Highest first, so that { 0 } is the daemon itself, or a client where no token
 * is asked for. */
enum pel_rank {
    PEL_RANK_INSTRUCT,
    PEL_RANK_STEER,
    PEL_RANK_WATCH,
    PEL_RANK_NOBODY, /* gave no token yet */
    PEL_RANKS,
};

struct pel_who {
    enum pel_rank rank;
    uint32_t token; /* a number of its own; 0: none */
};

/* Places of a kind that are taken: by ranks, and by the asker's token. */
struct pel_taken {
    uint64_t of_rank[PEL_RANKS];
    uint64_t of_token;
};

/* `holder` has `amount`; `asker` wants to know. */
void pel_taken_add(struct pel_taken *taken, const struct pel_who *asker,
                   const struct pel_who *holder, uint64_t amount);

/* The most of `places` that clients of this rank and lower may take together:
 * all, seven eighths (STEER), three quarters (WATCH), three eighths (NOBODY);
 * and one token: three quarters of that, and all of them an instructor's. 1
 * where there are any. */
uint64_t pel_share_of_rank(uint64_t places, enum pel_rank rank);
uint64_t pel_share_of_token(uint64_t places, enum pel_rank rank);

enum pel_share_answer {
    PEL_SHARE_FREE,
    PEL_SHARE_TOKEN_FULL,
    PEL_SHARE_RANK_FULL, /* for INSTRUCT: all are taken */
};

/* Whether `asker` may take `amount` more of `places`. */
enum pel_share_answer pel_share_ask(uint64_t places,
                                    const struct pel_taken *taken,
                                    const struct pel_who *asker,
                                    uint64_t amount);

/* For people: "of this token", "of the role watch", … */
const char *pel_share_words(enum pel_share_answer share, enum pel_rank rank);
