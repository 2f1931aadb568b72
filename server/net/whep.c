#include "net/whep.h"

#include <stdatomic.h>
#include <string.h>
#include <sys/random.h>

#include <glib.h>

#include "base/clock.h"
#include "base/watch.h"

#define MAX_QUEUED 8 /* pictures that wait in a peer's appsrc */
#define SWEEP_MS 500
#define IDLE_NS (PEL_BOUND_WHEP_IDLE_S * INT64_C(1000000000))
/* One that is not connected makes room for another after so long. */
#define WANTED_NS (1 * INT64_C(1000000000))

struct session {
    atomic_int references; /* the list's, the worker's, those of calls */
    struct pel_whep *all;  /* a reference */
    char id[PEL_WHEP_ID];
    char view[PEL_NAME_SIZE];
    struct pel_profile profile;
    struct pel_whep_offer offer;
    /* The worker's until the answer is told, then the control thread's until
     * the end is asked for, then the worker's again. */
    struct pel_whep_peer *peer;
    enum pel_err err;
    struct pel_fault fault;
    char *answer;
    /* Control thread: */
    pel_whep_done done; /* NULL: told, or nobody waits */
    void *user;
    struct pel_subscription *subscription;
    int64_t since_ns;
    bool answered, connected;
    atomic_bool over; /* the worker looks whether it is worth to begin */
};

/* What the worker does, in order of asking. */
struct task {
    struct session *session; /* NULL: the thread ends */
    bool end;
};

struct pel_whep {
    atomic_int references;
    struct pel_frames *frames;
    struct pel_whep_places places;
    GPtrArray *sessions; /* control thread */
    GAsyncQueue *tasks;
    GThread *worker; /* NULL: nobody has asked yet */
    guint sweeper;
    uint64_t accepted, refused, malformed, timeouts, sent, bytes, dropped, keys;
};

/* --- references ----------------------------------------------------------- */

static void whep_unref(struct pel_whep *whep)
{
    if (atomic_fetch_sub(&whep->references, 1) == 1) {
        g_async_queue_unref(whep->tasks);
        g_ptr_array_unref(whep->sessions);
        g_free(whep);
    }
}

static struct session *session_ref(struct session *s)
{
    atomic_fetch_add(&s->references, 1);
    return s;
}

static void session_unref(gpointer pointer)
{
    struct session *s = pointer;
    if (atomic_fetch_sub(&s->references, 1) == 1) {
        g_free(s->answer);
        whep_unref(s->all);
        g_free(s);
    }
}

/* Any thread: has the control thread call it; in order of asking. */
static void on_control(struct session *s, GSourceFunc call)
{
    GSource *source = g_idle_source_new();
    g_source_set_priority(source, G_PRIORITY_DEFAULT);
    g_source_set_callback(source, call, session_ref(s), session_unref);
    g_source_attach(source, NULL);
    g_source_unref(source);
}

static void order(struct session *s, bool end)
{
    struct task *task = g_new0(struct task, 1);
    *task = (struct task){ session_ref(s), end };
    g_async_queue_push(s->all->tasks, task);
}

/* --- the end of a session --------------------------------------------------
 */

/* Its peer is closed by the worker; who still waits is told why. */
static void end_session(struct session *s, enum pel_err err, const char *why)
{
    struct pel_whep *whep = s->all;
    if (s->over) {
        return;
    }
    atomic_store(&s->over, true);
    if (s->subscription) {
        pel_frames_unsubscribe(s->subscription);
        s->subscription = NULL;
    }
    order(s, true);
    if (s->done) {
        struct pel_fault fault;
        pel_whep_done done = s->done;
        s->done = NULL;
        pel_fault_set(&fault, err, "%s", why);
        done(s->user, err, &fault, NULL, NULL);
    }
    g_ptr_array_remove(whep->sessions, s); /* gives the list's reference back */
}

/* --- pictures --------------------------------------------------------------
 */

static void on_frame(void *user, enum pel_err err,
                     const struct pel_fault *fault, struct pel_frame *frame)
{
    struct session *s = user;
    struct pel_whep *whep = s->all;
    if (err == PEL_ERR_NOT_FOUND) {
        end_session(s, err, fault->message);
    } else if (err != PEL_OK) {
        return;
    } else if (pel_whep_peer_queued(s->peer) >= MAX_QUEUED) {
        whep->dropped++;
        pel_frames_resync(s->subscription, false);
    } else {
        whep->sent++;
        whep->bytes += frame->size;
        pel_whep_peer_push(s->peer, frame);
    }
}

static gboolean on_connected(gpointer user)
{
    PEL_WATCH("whep");
    struct session *s = user;
    struct pel_fault fault;
    if (s->over || !s->answered || s->connected) {
        return G_SOURCE_REMOVE;
    }
    s->connected = true;
    if (pel_frames_open(s->all->frames, s->view, &s->profile, on_frame, s,
                        &s->subscription, &fault) != PEL_OK) {
        s->all->refused++;
        end_session(s, fault.code, fault.message);
    }
    return G_SOURCE_REMOVE;
}

static gboolean on_lost(gpointer user)
{
    PEL_WATCH("whep");
    end_session(user, PEL_ERR_BUSY, "the peer is gone");
    return G_SOURCE_REMOVE;
}

static gboolean on_key(gpointer user)
{
    PEL_WATCH("whep");
    struct session *s = user;
    if (s->subscription) {
        s->all->keys++;
        pel_frames_want_key(s->subscription, false);
    }
    return G_SOURCE_REMOVE;
}

/* --- the worker ------------------------------------------------------------
 */

static void told(void *user, enum pel_whep_event event)
{
    static const GSourceFunc calls[] = {
        [PEL_WHEP_CONNECTED] = on_connected,
        [PEL_WHEP_LOST] = on_lost,
        [PEL_WHEP_KEY] = on_key,
    };
    on_control(user, calls[event]);
}

static gboolean on_answer(gpointer user)
{
    PEL_WATCH("whep");
    struct session *s = user;
    pel_whep_done done = s->done;
    if (s->over || !done) {
        return G_SOURCE_REMOVE;
    }
    s->answered = true;
    s->since_ns = pel_now_ns();
    s->done = NULL;
    if (s->err == PEL_OK) {
        s->all->accepted++;
        done(s->user, PEL_OK, NULL, s->answer, s->id);
    } else {
        done(s->user, s->err, &s->fault, NULL, NULL);
        end_session(s, s->err, "");
    }
    return G_SOURCE_REMOVE;
}

static gpointer work(gpointer user)
{
    struct pel_whep *whep = user;
    for (;;) {
        struct task *task = g_async_queue_pop(whep->tasks);
        struct session *s = task->session;
        bool end = task->end;
        g_free(task);
        if (!s) {
            return NULL;
        }
        if (end) {
            pel_whep_peer_close(s->peer);
            s->peer = NULL;
        } else if (!atomic_load(&s->over)) {
            s->err = pel_whep_peer_open(&whep->places, &s->offer, told, s,
                                        &s->peer, &s->answer, &s->fault);
            on_control(s, on_answer);
        }
        session_unref(s);
    }
}

/* --- sessions --------------------------------------------------------------
 */

static gboolean sweep(gpointer user)
{
    PEL_WATCH("whep");
    struct pel_whep *whep = user;
    int64_t now_ns = pel_now_ns();
    for (guint i = whep->sessions->len; i-- > 0;) {
        struct session *s = g_ptr_array_index(whep->sessions, i);
        int64_t heard_ns =
            s->connected ? pel_whep_peer_heard_ns(s->peer) : s->since_ns;
        if (s->answered && now_ns - heard_ns > IDLE_NS) {
            whep->timeouts++;
            end_session(s, PEL_ERR_BUSY, "the peer is silent");
        }
    }
    whep->sweeper = whep->sessions->len > 0 ? whep->sweeper : 0;
    return whep->sweeper != 0;
}

/* Ends the session that has waited for its connection for longest, among those
 * that count against `who`, or else the oldest of the lowest rank below; false:
 * there is none. */
static bool make_room(struct pel_whep *whep, const struct pel_who *who,
                      enum pel_share_answer share)
{
    struct session *oldest = NULL, *lower = NULL;
    int64_t latest_ns = pel_now_ns() - WANTED_NS;
    for (guint i = 0; i < whep->sessions->len; i++) {
        struct session *s = g_ptr_array_index(whep->sessions, i);
        const struct pel_who *its = &s->profile.who;
        bool counts = share == PEL_SHARE_TOKEN_FULL ? its->token == who->token
                                                    : its->rank >= who->rank;
        if (counts && s->answered && !s->connected && s->since_ns < latest_ns) {
            oldest = s;
            latest_ns = s->since_ns;
        }
        if (who->rank < PEL_RANK_WATCH && its->rank > who->rank &&
            (!lower || its->rank > lower->profile.who.rank)) {
            lower = s;
        }
    }
    oldest = oldest ? oldest : lower;
    if (oldest) {
        whep->timeouts++;
        end_session(oldest, PEL_ERR_BUSY, "others want its place");
    }
    return oldest != NULL;
}

static enum pel_err find_place(struct pel_whep *whep, const struct pel_who *who,
                               struct pel_fault *fault)
{
    for (;;) {
        struct pel_taken taken = { { 0 }, 0 };
        for (guint i = 0; i < whep->sessions->len; i++) {
            const struct session *s = g_ptr_array_index(whep->sessions, i);
            pel_taken_add(&taken, who, &s->profile.who, 1);
        }
        enum pel_share_answer share =
            pel_share_ask(PEL_BOUND_WHEP_SESSIONS, &taken, who, 1);
        if (!share) {
            return PEL_OK;
        }
        if (!make_room(whep, who, share)) {
            whep->refused++;
            return pel_fault_set(
                fault, PEL_ERR_BUSY,
                "%u WebRTC sessions are open, as many as there "
                "may be %s; end one, or ask again later",
                whep->sessions->len, pel_share_words(share, who->rank));
        }
    }
}

static bool name_session(struct session *s)
{
    unsigned char bits[(PEL_WHEP_ID - 1) / 2];
    if (getrandom(bits, sizeof bits, 0) != (ssize_t)sizeof bits) {
        return false;
    }
    for (size_t i = 0; i < sizeof bits; i++) {
        g_snprintf(s->id + 2 * i, 3, "%02x", bits[i]);
    }
    return true;
}

static void add_session(struct pel_whep *whep, struct session *s)
{
    atomic_init(&s->references, 1);
    atomic_fetch_add(&whep->references, 1);
    s->all = whep;
    s->since_ns = pel_now_ns();
    g_ptr_array_add(whep->sessions, s);
    if (!whep->worker) {
        whep->worker = g_thread_new("whep", work, whep);
    }
    if (!whep->sweeper) {
        whep->sweeper = g_timeout_add(SWEEP_MS, sweep, whep);
    }
    order(s, false);
}

enum pel_err pel_whep_ask(struct pel_whep *whep,
                          const struct pel_whep_wish *wish, pel_whep_done done,
                          void *user, struct pel_fault *fault)
{
    struct session *s = g_new0(struct session, 1);
    enum pel_err err =
        pel_whep_offer_read(wish->offer, wish->offer_size, &s->offer, fault);
    whep->malformed += err != PEL_OK;
    if (err == PEL_OK) {
        err = find_place(whep, &wish->profile.who, fault);
    }
    if (err == PEL_OK && !name_session(s)) {
        err = pel_fault_set(fault, PEL_ERR_INTERNAL, "no random numbers");
    }
    if (err != PEL_OK) {
        g_free(s);
        return err;
    }
    pel_whep_offer_keep(&s->offer, wish->from, &whep->places.peers);
    g_strlcpy(s->view, wish->view, sizeof s->view);
    s->profile = wish->profile;
    s->profile.codec = s->offer.vp8 ? PEL_CODEC_VP8 : PEL_CODEC_H264;
    s->done = done;
    s->user = user;
    add_session(whep, s);
    return PEL_OK;
}

bool pel_whep_forget(struct pel_whep *whep, const void *user)
{
    for (guint i = 0; i < whep->sessions->len; i++) {
        struct session *s = g_ptr_array_index(whep->sessions, i);
        if (s->done && s->user == user) {
            s->done = NULL;
            end_session(s, PEL_ERR_BUSY, "");
            return true;
        }
    }
    return false;
}

void pel_whep_revoke(struct pel_whep *whep, struct pel_token *token)
{
    for (guint i = whep->sessions->len; i-- > 0;) {
        struct session *s = g_ptr_array_index(whep->sessions, i);
        if (!pel_token_holds(token, &s->profile.who)) {
            end_session(s, PEL_ERR_FORBIDDEN, "its token was taken back");
        }
    }
}

enum pel_err pel_whep_end(struct pel_whep *whep, const char *id,
                          const struct pel_who *who, struct pel_fault *fault)
{
    for (guint i = 0; i < whep->sessions->len; i++) {
        struct session *s = g_ptr_array_index(whep->sessions, i);
        const struct pel_who *its = &s->profile.who;
        if (!s->answered || strcmp(s->id, id) != 0) {
            continue;
        }
        if (its->token != who->token && its->rank <= who->rank) {
            return pel_fault_set(fault, PEL_ERR_FORBIDDEN,
                                 "this WebRTC session is another token's: its "
                                 "own, or one of a higher role, may end it");
        }
        end_session(s, PEL_ERR_BUSY, "");
        return PEL_OK;
    }
    return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                         "there is no such WebRTC session: it has ended, or "
                         "never was");
}

/* --- life ------------------------------------------------------------------
 */

struct pel_whep *pel_whep_create(struct pel_frames *frames,
                                 const struct pel_whep_places *places)
{
    struct pel_whep *whep = g_new0(struct pel_whep, 1);
    atomic_init(&whep->references, 1);
    whep->frames = frames;
    whep->places = *places;
    whep->sessions = g_ptr_array_new_with_free_func(session_unref);
    whep->tasks = g_async_queue_new();
    return whep;
}

void pel_whep_destroy(struct pel_whep *whep)
{
    if (!whep) {
        return;
    }
    while (whep->sessions->len > 0) {
        end_session(g_ptr_array_index(whep->sessions, 0), PEL_ERR_BUSY,
                    "the daemon is stopping");
    }
    if (whep->worker) {
        g_async_queue_push(whep->tasks, g_new0(struct task, 1));
        g_thread_join(whep->worker);
    }
    if (whep->sweeper) {
        g_source_remove(whep->sweeper);
    }
    whep_unref(whep);
}

void pel_whep_collect(const struct pel_whep *whep,
                      struct pel_metrics_page *page)
{
    const struct {
        const char *name, *help, *labels;
        uint64_t value;
    } counters[] = {
        { "pelagos_whep_accepted_total", "WebRTC sessions begun.", NULL,
          whep->accepted },
        { "pelagos_whep_frames_sent_total", "Pictures given to WebRTC peers.",
          NULL, whep->sent },
        { "pelagos_whep_sent_bytes_total", "Bytes of them.", NULL,
          whep->bytes },
        { "pelagos_whep_frames_dropped_total",
          "Times that a WebRTC peer's queue was full.", NULL, whep->dropped },
        { "pelagos_whep_key_wishes_total",
          "Times that a WebRTC peer asked for a key frame.", NULL, whep->keys },
        { "pelagos_refused_total", "Clients turned away at a limit.",
          "input=\"whep\"", whep->refused },
        { "pelagos_malformed_total", "Messages that could not be read.",
          "input=\"whep\"", whep->malformed },
        { "pelagos_timeouts_total", "Clients closed for being too slow.",
          "input=\"whep\"", whep->timeouts },
    };
    unsigned connected = 0;
    for (guint i = 0; i < whep->sessions->len; i++) {
        const struct session *s = g_ptr_array_index(whep->sessions, i);
        connected += s->connected;
    }
    pel_metric(page, "pelagos_whep_sessions", PEL_METRIC_GAUGE,
               "WebRTC sessions, connected or not yet.", NULL,
               whep->sessions->len);
    pel_metric(page, "pelagos_whep_connected", PEL_METRIC_GAUGE,
               "WebRTC sessions that are connected.", NULL, connected);
    for (size_t i = 0; i < G_N_ELEMENTS(counters); i++) {
        pel_metric(page, counters[i].name, PEL_METRIC_COUNTER, counters[i].help,
                   counters[i].labels, (double)counters[i].value);
    }
}
