#include "base/share.h"

#define TOKEN_NUMERATOR 3 /* of 4, what one token may have of its role's */

void pel_taken_add(struct pel_taken *taken, const struct pel_who *asker,
                   const struct pel_who *holder, uint64_t amount)
{
    taken->of_rank[holder->rank] += amount;
    if (holder->token != 0 && holder->token == asker->token) {
        taken->of_token += amount;
    }
}

static uint64_t part(uint64_t places, uint64_t numerator, uint64_t denominator)
{
    uint64_t some = places / denominator * numerator +
                    places % denominator * numerator / denominator;
    return some == 0 && places > 0 ? 1 : some;
}

uint64_t pel_share_of_rank(uint64_t places, enum pel_rank rank)
{
    static const uint64_t eighths[PEL_RANKS] = { 8, 7, 6, 3 };
    return part(places, eighths[rank], 8);
}

uint64_t pel_share_of_token(uint64_t places, enum pel_rank rank)
{
    uint64_t all = pel_share_of_rank(places, rank);
    return rank == PEL_RANK_INSTRUCT ? all : part(all, TOKEN_NUMERATOR, 4);
}

enum pel_share_answer pel_share_ask(uint64_t places,
                                    const struct pel_taken *taken,
                                    const struct pel_who *asker,
                                    uint64_t amount)
{
    uint64_t lower = 0, of_rank = amount;
    for (int rank = PEL_RANK_NOBODY; rank >= PEL_RANK_INSTRUCT; rank--) {
        lower += taken->of_rank[rank];
        /* Higher ranks may have taken what was left to all. */
        if (rank >= (int)asker->rank) {
            of_rank = lower + amount;
        }
    }
    if (asker->token != 0 &&
        taken->of_token + amount > pel_share_of_token(places, asker->rank)) {
        return PEL_SHARE_TOKEN_FULL;
    }
    return of_rank > pel_share_of_rank(places, asker->rank) ||
                   lower + amount > places
               ? PEL_SHARE_RANK_FULL
               : PEL_SHARE_FREE;
}

const char *pel_share_words(enum pel_share_answer share, enum pel_rank rank)
{
    static const char *const of_rank[PEL_RANKS] = {
        "of all clients", "of the roles steer and watch", "of the role watch",
        "of clients without a token"
    };
    return share == PEL_SHARE_TOKEN_FULL ? "of this token" : of_rank[rank];
}
