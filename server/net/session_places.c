/* Places of sessions, by role and token: base/share.h. */
#include <glib.h>

#include "base/clock.h"
#include "bounds.h"
#include "net/session_parts.h"

/* A full house lets the longest-idle session go after this. */
#define EVICT_IDLE_NS (60 * INT64_C(1000000000))

void pel_session_end_soon(void *user)
{
    struct session *self = user;
    self->ended = true;
    pel_fdsource_wake_at(self->source, 0);
}

static bool is_idle(const struct session *each)
{
    return each->jobs->len == 0 && each->out.bytes == 0 && !each->watching;
}

/* Ends the session that has been idle for longest among those that count
 * against this one, if for long enough; else the one of the lowest rank below
 * that has asked nothing for longest. False: there is none. */
static bool make_room(const struct session *self, enum pel_share_answer share)
{
    struct pel_sessions *all = self->all;
    struct session *idle = NULL, *lower = NULL;
    for (guint i = 0; i < all->list->len; i++) {
        struct session *each = g_ptr_array_index(all->list, i);
        if (each == self || each->transport != self->transport ||
            each->stranger || each->ended) {
            continue;
        }
        bool counts = share == PEL_SHARE_TOKEN_FULL
                          ? each->who.token == self->who.token
                          : each->who.rank >= self->who.rank;
        if (counts && is_idle(each) &&
            (!idle || each->active_ns < idle->active_ns)) {
            idle = each;
        }
        if (self->who.rank < PEL_RANK_WATCH &&
            each->who.rank > self->who.rank &&
            (!lower || each->who.rank > lower->who.rank ||
             (each->who.rank == lower->who.rank &&
              each->active_ns < lower->active_ns))) {
            lower = each;
        }
    }
    bool old = idle && pel_now_ns() - idle->active_ns >= EVICT_IDLE_NS;
    struct session *last = old ? idle : lower;
    if (last) {
        all->evicted++;
        pel_session_end_soon(last);
    }
    return last != NULL;
}

bool pel_session_find_place(struct session *self, struct pel_fault *fault)
{
    struct pel_sessions *all = self->all;
    for (;;) {
        struct pel_taken taken = { { 0 }, 0 };
        for (guint i = 0; i < all->list->len; i++) {
            const struct session *each = g_ptr_array_index(all->list, i);
            if (each != self && each->transport == self->transport &&
                !each->stranger && !each->ended) {
                pel_taken_add(&taken, &self->who, &each->who, 1);
            }
        }
        enum pel_share_answer share =
            pel_share_ask(all->limits.sessions, &taken, &self->who, 1);
        if (!share) {
            return true;
        }
        if (!make_room(self, share)) {
            all->refused[self->transport]++;
            pel_fault_set(
                fault, PEL_ERR_BUSY, "all %u sessions %s are taken",
                (unsigned)(share == PEL_SHARE_TOKEN_FULL
                               ? pel_share_of_token(all->limits.sessions,
                                                    self->who.rank)
                               : pel_share_of_rank(all->limits.sessions,
                                                   self->who.rank)),
                pel_share_words(share, self->who.rank));
            return false;
        }
    }
}

unsigned pel_sessions_count(const struct pel_sessions *all,
                            enum pel_transport transport, bool strangers)
{
    unsigned count = 0;
    for (guint i = 0; i < all->list->len; i++) {
        const struct session *each = g_ptr_array_index(all->list, i);
        count += each->transport == transport && !each->ended &&
                 each->stranger == strangers;
    }
    return count;
}

bool pel_sessions_find_stranger_place(struct pel_sessions *all)
{
    struct session *oldest = NULL;
    if (pel_sessions_count(all, PEL_TRANSPORT_TCP, true) <
        PEL_BOUND_SESSION_STRANGERS) {
        return true;
    }
    for (guint i = 0; i < all->list->len; i++) {
        struct session *each = g_ptr_array_index(all->list, i);
        bool stranger = each->stranger && !each->ended;
        if (stranger && (!oldest || each->active_ns < oldest->active_ns)) {
            oldest = each;
        }
    }
    if (oldest) {
        all->evicted++;
        pel_session_end_soon(oldest);
    }
    return oldest != NULL;
}

bool pel_sessions_starved(struct pel_sessions *all)
{
    struct session *found = NULL;
    for (guint i = 0; i < all->list->len; i++) {
        struct session *each = g_ptr_array_index(all->list, i);
        bool spare = each->transport == PEL_TRANSPORT_TCP && !each->ended &&
                     each->who.rank >= PEL_RANK_WATCH;
        bool better = !found || each->who.rank > found->who.rank ||
                      (each->who.rank == found->who.rank &&
                       each->active_ns < found->active_ns);
        found = spare && better ? each : found;
    }
    if (found) {
        all->evicted++;
        pel_session_end_soon(found);
    }
    return found != NULL;
}

void pel_sessions_revoke(struct pel_sessions *all)
{
    for (guint i = 0; i < all->list->len; i++) {
        struct session *each = g_ptr_array_index(all->list, i);
        if (!pel_token_holds(all->token, &each->who)) {
            pel_session_end_soon(each);
        }
    }
}
