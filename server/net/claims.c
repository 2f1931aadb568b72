#include "net/claims.h"

#include <glib.h>

#include "base/clock.h"
#include "base/log.h"
#include "bounds.h"

struct pel_claims {
    GPtrArray *list[PEL_CLAIM_KINDS]; /* of struct pel_claim */
    uint64_t refused, ended;
};

static const struct {
    uint64_t most;
    const char *words;
} kinds[PEL_CLAIM_KINDS] = {
    [PEL_CLAIM_PICTURES] = { PEL_BOUND_PICTURES, "pictures asked for" },
    [PEL_CLAIM_SURFACES] = { PEL_BOUND_SURFACE_QUERIES, "surface queries" },
    [PEL_CLAIM_OPTICS] = { PEL_BOUND_OPTICS_QUERIES, "queries of optics" },
    [PEL_CLAIM_QUESTIONS] = { PEL_BOUND_QUESTIONS, "questions" },
    [PEL_CLAIM_UNREAD] = { PEL_BOUND_UNREAD_BYTES, "bytes of answers" },
};

struct pel_claims *pel_claims_create(void)
{
    struct pel_claims *all = g_new0(struct pel_claims, 1);
    for (int i = 0; i < PEL_CLAIM_KINDS; i++) {
        all->list[i] = g_ptr_array_new();
    }
    return all;
}

void pel_claims_destroy(struct pel_claims *all)
{
    for (int i = 0; all && i < PEL_CLAIM_KINDS; i++) {
        for (guint k = 0; k < all->list[i]->len; k++) {
            struct pel_claim *claim = g_ptr_array_index(all->list[i], k);
            claim->all = NULL; /* its holder outlives us */
        }
        g_ptr_array_free(all->list[i], TRUE);
    }
    g_free(all);
}

static struct pel_taken taken_of(const struct pel_claims *all,
                                 enum pel_claim_kind kind,
                                 const struct pel_who *who)
{
    struct pel_taken taken = { { 0 }, 0 };
    for (guint i = 0; i < all->list[kind]->len; i++) {
        const struct pel_claim *claim = g_ptr_array_index(all->list[kind], i);
        pel_taken_add(&taken, who, &claim->who, claim->amount);
    }
    return taken;
}

static void add(struct pel_claims *all, struct pel_claim *claim)
{
    claim->all = all;
    claim->since_ns = pel_now_ns();
    g_ptr_array_add(all->list[claim->kind], claim);
}

enum pel_err pel_claim_take(struct pel_claims *all, enum pel_claim_kind kind,
                            const struct pel_who *who, uint64_t amount,
                            struct pel_claim *claim, struct pel_fault *fault)
{
    if (!all) {
        return PEL_OK;
    }
    struct pel_taken taken = taken_of(all, kind, who);
    enum pel_share_answer share =
        pel_share_ask(kinds[kind].most, &taken, who, amount);
    if (share) {
        all->refused++;
        return pel_fault_set(
            fault, PEL_ERR_BUSY,
            "the %s %s that may be under way are taken, %u: try again later",
            kinds[kind].words, pel_share_words(share, who->rank),
            (unsigned)(share == PEL_SHARE_TOKEN_FULL
                           ? pel_share_of_token(kinds[kind].most, who->rank)
                           : pel_share_of_rank(kinds[kind].most, who->rank)));
    }
    claim->kind = kind;
    claim->who = *who;
    claim->amount = amount;
    add(all, claim);
    return PEL_OK;
}

void pel_claim_give(struct pel_claim *claim)
{
    if (claim->all) {
        g_ptr_array_remove_fast(claim->all->list[claim->kind], claim);
        claim->all = NULL;
    }
}

/* --- answers that are not read -------------------------------------------- */

static double weight(const struct pel_claim *claim, int64_t now_ns)
{
    return (double)claim->amount * (double)(now_ns - claim->since_ns + 1);
}

/* The worst claim that counts against `who`; NULL: there is none but `mine`. */
static struct pel_claim *find_worst(const struct pel_claims *all,
                                    enum pel_share_answer share,
                                    const struct pel_claim *mine)
{
    const GPtrArray *list = all->list[PEL_CLAIM_UNREAD];
    int64_t now_ns = pel_now_ns();
    struct pel_claim *worst = NULL;
    for (guint i = 0; i < list->len; i++) {
        struct pel_claim *each = g_ptr_array_index(list, i);
        bool counts = share == PEL_SHARE_TOKEN_FULL
                          ? each->who.token == mine->who.token
                          : each->who.rank >= mine->who.rank;
        bool worse = !worst || each->who.rank > worst->who.rank ||
                     (each->who.rank == worst->who.rank &&
                      weight(each, now_ns) > weight(worst, now_ns));
        if (each != mine && counts && worse) {
            worst = each;
        }
    }
    return worst;
}

void pel_claim_unread(struct pel_claims *all, const struct pel_who *who,
                      uint64_t bytes, struct pel_claim *claim)
{
    static struct pel_log_limit limit;
    int64_t since_ns = claim->since_ns;
    bool had = claim->all != NULL;
    pel_claim_give(claim);
    if (!all || bytes == 0) {
        return;
    }
    claim->kind = PEL_CLAIM_UNREAD;
    claim->who = *who;
    claim->amount = bytes;
    for (;;) {
        struct pel_taken taken = taken_of(all, PEL_CLAIM_UNREAD, who);
        enum pel_share_answer share =
            pel_share_ask(PEL_BOUND_UNREAD_BYTES, &taken, who, bytes);
        struct pel_claim *worst = share ? find_worst(all, share, claim) : NULL;
        if (!worst) {
            break;
        }
        all->ended++;
        pel_log_limited(&limit, PEL_LOG_WARNING, "NET-022",
                        "a client is closed with %llu bytes of answers "
                        "unread: others need the memory",
                        (unsigned long long)worst->amount);
        pel_claim_give(worst);
        worst->end(worst->user);
    }
    add(all, claim);
    claim->since_ns = had ? since_ns : claim->since_ns;
}

void pel_claims_collect(const struct pel_claims *all,
                        struct pel_metrics_page *page)
{
    uint64_t bytes = 0;
    for (guint i = 0; i < all->list[PEL_CLAIM_UNREAD]->len; i++) {
        const struct pel_claim *claim =
            g_ptr_array_index(all->list[PEL_CLAIM_UNREAD], i);
        bytes += claim->amount;
    }
    pel_metric(page, "pelagos_unread_bytes", PEL_METRIC_GAUGE,
               "Bytes of answers that clients have not read yet.", NULL,
               (double)bytes);
    pel_metric(page, "pelagos_unread_ended_total", PEL_METRIC_COUNTER,
               "Clients closed that had not read theirs, for others.", NULL,
               (double)all->ended);
    pel_metric(page, "pelagos_shares_refused_total", PEL_METRIC_COUNTER,
               "Requests refused since their token or role had its share.",
               NULL, (double)all->refused);
}
