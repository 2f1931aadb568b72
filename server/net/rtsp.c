#include "net/rtsp.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <gio/gio.h>
#include <gst/rtsp-server/rtsp-server.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"
#include "bounds.h"
#include "encode/gst.h"
#include "net/listener.h"
#include "net/rtspauth.h"
#include "net/rtspgate.h"
#include "net/rtspguard.h"
#include "net/rtspstream.h"

#define MAX_CLIENTS PEL_BOUND_RTSP_CLIENTS
#define MAX_STRANGERS PEL_BOUND_RTSP_STRANGERS
#define MOST_CLIENTS (MAX_CLIENTS + MAX_STRANGERS)
#define MAX_SESSIONS MOST_CLIENTS
#define THREADS (-1) /* one a client: each waits for its own media only */
#define MAX_SHAKING PEL_BOUND_RTSP_HANDSHAKES
#define MAX_WAITING 32 /* clients, while GStreamer starts */
#define CLEAN_S 2
#define LEAVE_MS 2000 /* for the threads of clients when the server ends */
/* A client without a session, silent or in the middle of a request or of its
 * TLS handshake, has so long, and less where its place is wanted. */
#define LOITER_NS (PEL_BOUND_RTSP_IDLE_S * INT64_C(1000000000))
#define WANTED_NS (1 * INT64_C(1000000000))
/* A stranger has so long even where others wait: one that gives its token at
 * once is not crowded out by those who only connect. */
#define NEW_NS (100 * INT64_C(1000000))
/* Beyond that while we are at what it asked for: a first picture may take a
 * busy machine some seconds. */
#define BUSY_NS (22 * INT64_C(1000000000))
/* Of TLS, before gst-rtsp-server sees anything. GIO's would give each handshake
 * a thread of a pool that grows one by one, so that idle ones hold up the rest.
 * A player that is paused by not reading is left alone as long as RTSP's own
 * sessions are. */
#define HANDSHAKE_S 8.0
#define STALL_S 60.0
/* Frames that come without a time get that of their coming; the queue of a
 * client is bounded where it is filled (rtspstream.c). */
#define LAUNCH                                                                 \
    "( appsrc name=source is-live=true format=time do-timestamp=true "         \
    "block=false max-bytes=0 max-buffers=0 max-time=0 "                        \
    "caps=video/x-h264,stream-format=byte-stream,alignment=au ! "              \
    "rtph264pay name=pay0 pt=96 config-interval=-1 )"
#define STREAM_KEY "pelagos-stream"
#define VIEW_KEY "pelagos-view"
#define VISIT_KEY "pelagos-visit"

/* What is known of a client; it lives as long. */
struct visit {
    _Atomic int64_t since_ns; /* it does nothing; INT64_MAX: it was sent away */
    atomic_bool known;        /* it has a place: who it is is known */
    atomic_bool played;       /* once at least */
    bool at_work;             /* it has passed the gate; its thread's */
    GPtrArray *sessions;      /* its thread's */
    /* The lock of the places protects these: */
    struct pel_who who;
    int64_t placed_ns;
    GSocket *socket; /* a reference; NULL: it is closed */
};

enum state {
    STATE_ASLEEP, /* nobody has come yet */
    STATE_STARTING,
    STATE_RUNS,
    STATE_BROKEN, /* GStreamer does not start or lacks a part */
};

struct waiting {
    int fd;
    char host[64];
    int port;
};

struct pel_rtsp {
    struct pel_scene *scene;
    struct pel_rtsp_hub *hub;
    struct pel_listener *listener;
    uint16_t port;
    struct pel_token *token; /* NULL: none is asked for */
    struct pel_tls *tls;     /* NULL: plain */
    enum state state;
    pthread_t starter;
    enum pel_err start_err;
    struct pel_fault start_fault;
    struct waiting waiting[MAX_WAITING];
    unsigned waiting_count;
    GstRTSPServer *server;
    GHashTable *mounted; /* names of views */
    guint cleaner;
    pthread_mutex_t lock;
    GPtrArray *places; /* of struct visit: those that are known */
    struct pel_rtsp_gate gate;
    atomic_uint clients;
    atomic_uint crowded; /* refused: their share is taken */
    uint64_t accepted, refused, timeouts;
};

/* --- threads of gst-rtsp-server ------------------------------------------ */

static void on_unprepared(GstRTSPMedia *media, gpointer user)
{
    (void)user;
    struct pel_rtsp_stream *stream =
        g_object_steal_data(G_OBJECT(media), STREAM_KEY);
    if (stream) {
        pel_rtsp_stream_close(stream);
    }
}

static struct visit *visit_of(GstRTSPClient *client)
{
    return g_object_get_data(G_OBJECT(client), VISIT_KEY);
}

/* Role and token of this thread's client, which has been admitted. */
static struct pel_who who_asks(void)
{
    const GstRTSPContext *at = gst_rtsp_context_get_current();
    const struct visit *visit = at && at->client ? visit_of(at->client) : NULL;
    return visit ? visit->who : (struct pel_who){ PEL_RANK_NOBODY, 0 };
}

static void on_configure(GstRTSPMediaFactory *factory, GstRTSPMedia *media,
                         gpointer user)
{
    struct pel_rtsp_hub *hub = user;
    GstElement *bin = gst_rtsp_media_get_element(media);
    GstElement *source = gst_bin_get_by_name_recurse_up(GST_BIN(bin), "source");
    const char *view = g_object_get_data(G_OBJECT(factory), VIEW_KEY);
    const struct pel_who who = who_asks();
    struct pel_rtsp_stream *stream =
        pel_rtsp_stream_create(hub, view, &who, GST_APP_SRC(source));
    g_object_set_data_full(G_OBJECT(media), STREAM_KEY, stream,
                           (GDestroyNotify)pel_rtsp_stream_close);
    g_signal_connect(media, "unprepared", G_CALLBACK(on_unprepared), NULL);
    gst_object_unref(source);
    gst_object_unref(bin);
}

static void on_play(GstRTSPClient *client, GstRTSPContext *context,
                    gpointer user)
{
    (void)user;
    atomic_store(&visit_of(client)->played, true);
    GstRTSPMedia *media =
        context->sessmedia
            ? gst_rtsp_session_media_get_media(context->sessmedia)
            : NULL;
    struct pel_rtsp_stream *stream =
        media ? g_object_get_data(G_OBJECT(media), STREAM_KEY) : NULL;
    if (stream) {
        pel_rtsp_stream_play(stream);
    }
}

static void free_visit(gpointer pointer)
{
    struct visit *visit = pointer;
    g_ptr_array_unref(visit->sessions);
    g_clear_object(&visit->socket);
    g_free(visit);
}

/* An answer goes out, whatever it is. */
static void on_answered(GstRTSPClient *client, GstRTSPContext *context,
                        gpointer message, gpointer user)
{
    (void)context;
    (void)message;
    struct pel_rtsp *rtsp = user;
    pel_rtsp_gate_leave(&rtsp->gate, &visit_of(client)->at_work);
}

/* Before a description is made, a stream is set up or torn down, of one who may
 * ask. */
static GstRTSPStatusCode on_asked(GstRTSPClient *client,
                                  GstRTSPContext *context, gpointer user)
{
    (void)context;
    struct pel_rtsp *rtsp = user;
    struct visit *visit = visit_of(client);
    if (atomic_load(&visit->since_ns) != INT64_MAX) {
        atomic_store(&visit->since_ns, pel_now_ns() + BUSY_NS);
    }
    if (visit->who.rank >= PEL_RANK_WATCH) {
        pel_rtsp_gate_pass(&rtsp->gate, &visit->since_ns, &visit->at_work);
    }
    return GST_RTSP_STS_OK;
}

/* One session a connection: they are as many as connections then. */
static GstRTSPStatusCode on_setup(GstRTSPClient *client,
                                  GstRTSPContext *context, gpointer user)
{
    if (!context->session) {
        GList *sessions = gst_rtsp_client_session_filter(client, NULL, NULL);
        bool has_one = sessions != NULL;
        g_list_free_full(sessions, g_object_unref);
        if (has_one) {
            return GST_RTSP_STS_SERVICE_UNAVAILABLE;
        }
    }
    return on_asked(client, context, user);
}

static void on_session(GstRTSPClient *client, GstRTSPSession *session,
                       gpointer user)
{
    (void)user;
    const struct visit *visit = visit_of(client);
    g_ptr_array_add(visit->sessions, g_object_ref(session));
    pel_rtsp_guard_own(gst_rtsp_connection_get_read_socket(
                           gst_rtsp_client_get_connection(client)),
                       gst_rtsp_session_get_sessionid(session));
}

/* Without TEARDOWN sessions would stay for a minute, and 64 who came and went
 * would keep everybody out. */
static void on_closed(GstRTSPClient *client, gpointer user)
{
    struct pel_rtsp *rtsp = user;
    struct visit *visit = visit_of(client);
    GPtrArray *sessions = visit->sessions;
    pel_rtsp_gate_leave(&rtsp->gate, &visit->at_work);
    pthread_mutex_lock(&rtsp->lock);
    g_ptr_array_remove_fast(rtsp->places, visit);
    g_clear_object(&visit->socket);
    pthread_mutex_unlock(&rtsp->lock);
    GstRTSPSessionPool *pool = gst_rtsp_client_get_session_pool(client);
    for (guint i = 0; pool && i < sessions->len; i++) {
        pel_rtsp_guard_disown(
            gst_rtsp_session_get_sessionid(g_ptr_array_index(sessions, i)));
        gst_rtsp_session_pool_remove(pool, g_ptr_array_index(sessions, i));
    }
    g_ptr_array_set_size(sessions, 0);
    g_clear_object(&pool);
    atomic_fetch_sub(&rtsp->clients, 1);
}

/* --- places by who they are of -------------------------------------------- */

/* With the lock. Its own thread sees the end, as if the client had left, and
 * tidies up; closed from here the socket would stay, and the thread read from
 * what is gone. */
static void end_visit(struct pel_rtsp *rtsp, struct visit *visit)
{
    g_ptr_array_remove_fast(rtsp->places, visit);
    atomic_store(&visit->since_ns, INT64_MAX);
    if (visit->socket) {
        pel_rtsp_guard_end(visit->socket);
    }
}

/* With the lock: of the lowest rank below, the oldest. False: there is none. */
static bool make_room(struct pel_rtsp *rtsp, const struct pel_who *who)
{
    struct visit *found = NULL;
    for (guint i = 0; who->rank < PEL_RANK_WATCH && i < rtsp->places->len;
         i++) {
        struct visit *each = g_ptr_array_index(rtsp->places, i);
        bool better = !found || each->who.rank > found->who.rank ||
                      (each->who.rank == found->who.rank &&
                       each->placed_ns < found->placed_ns);
        found = each->who.rank > who->rank && better ? each : found;
    }
    if (found) {
        end_visit(rtsp, found);
    }
    return found != NULL;
}

/* Any thread: whether a client of this token may have a place. */
static bool admit(void *user, GstRTSPClient *client, const struct pel_who *who)
{
    struct pel_rtsp *rtsp = user;
    struct visit *visit = visit_of(client);
    bool same = atomic_load(&visit->known) && visit->who.token == who->token &&
                visit->who.rank == who->rank;
    if (same) {
        return true;
    }
    pthread_mutex_lock(&rtsp->lock);
    g_ptr_array_remove_fast(rtsp->places, visit);
    enum pel_share_answer share;
    do {
        struct pel_taken taken = { { 0 }, 0 };
        for (guint i = 0; i < rtsp->places->len; i++) {
            const struct visit *each = g_ptr_array_index(rtsp->places, i);
            pel_taken_add(&taken, who, &each->who, 1);
        }
        share = pel_share_ask(MAX_CLIENTS, &taken, who, 1);
    } while (share && make_room(rtsp, who));
    if (!share) {
        visit->who = *who;
        visit->placed_ns = pel_now_ns();
        g_ptr_array_add(rtsp->places, visit);
    }
    atomic_store(&visit->known, !share);
    pthread_mutex_unlock(&rtsp->lock);
    if (share) {
        atomic_fetch_add(&rtsp->crowded, 1);
    }
    return !share;
}

void pel_rtsp_revoke(struct pel_rtsp *rtsp)
{
    pthread_mutex_lock(&rtsp->lock);
    for (guint i = rtsp->places->len; i-- > 0;) {
        struct visit *each = g_ptr_array_index(rtsp->places, i);
        if (!pel_token_holds(rtsp->token, &each->who)) {
            end_visit(rtsp, each);
        }
    }
    pthread_mutex_unlock(&rtsp->lock);
}

/* --- the server ---------------------------------------------------------- */

static void on_connected(GstRTSPServer *server, GstRTSPClient *client,
                         gpointer user)
{
    (void)server;
    struct pel_rtsp *rtsp = user;
    struct visit *visit = g_new0(struct visit, 1);
    atomic_init(&visit->since_ns, pel_now_ns());
    visit->socket = g_object_ref(gst_rtsp_connection_get_read_socket(
        gst_rtsp_client_get_connection(client)));
    visit->sessions = g_ptr_array_new_with_free_func(g_object_unref);
    g_object_set_data_full(G_OBJECT(client), VISIT_KEY, visit, free_visit);
    g_signal_connect(client, "pre-describe-request", G_CALLBACK(on_asked),
                     user);
    g_signal_connect(client, "pre-setup-request", G_CALLBACK(on_setup), user);
    g_signal_connect(client, "pre-teardown-request", G_CALLBACK(on_asked),
                     user);
    g_signal_connect(client, "send-message", G_CALLBACK(on_answered), user);
    g_signal_connect(client, "new-session", G_CALLBACK(on_session), NULL);
    g_signal_connect(client, "play-request", G_CALLBACK(on_play), NULL);
    g_signal_connect(client, "closed", G_CALLBACK(on_closed), user);
    if (!rtsp->token) {
        const struct pel_who all = { PEL_RANK_INSTRUCT, 0 };
        (void)admit(rtsp, client, &all); /* pel_rtsp_accept counted them */
    }
}

static void mount(struct pel_rtsp *rtsp, GstRTSPMountPoints *points,
                  const char *view)
{
    char path[PEL_NAME_SIZE + 1];
    GstRTSPMediaFactory *factory = gst_rtsp_media_factory_new();
    snprintf(path, sizeof path, "/%s", view);
    gst_rtsp_media_factory_set_launch(factory, LAUNCH);
    gst_rtsp_media_factory_set_shared(factory, FALSE);
    gst_rtsp_media_factory_set_latency(factory, 0);
    if (rtsp->tls) {
        gst_rtsp_media_factory_set_protocols(factory, GST_RTSP_LOWER_TRANS_TCP);
    }
    g_object_set_data_full(G_OBJECT(factory), VIEW_KEY, g_strdup(view), g_free);
    g_signal_connect_data(factory, "media-configure", G_CALLBACK(on_configure),
                          pel_rtsp_hub_ref(rtsp->hub),
                          (GClosureNotify)(void (*)(void))pel_rtsp_hub_unref,
                          0);
    gst_rtsp_mount_points_add_factory(points, path, factory);
    g_hash_table_add(rtsp->mounted, g_strdup(view));
}

void pel_rtsp_changed(struct pel_rtsp *rtsp)
{
    if (rtsp->state != STATE_RUNS) {
        return;
    }
    GstRTSPMountPoints *points = gst_rtsp_server_get_mount_points(rtsp->server);
    const struct pel_snapshot *s = pel_scene_snapshot(rtsp->scene);
    GHashTableIter at;
    gpointer name;
    g_hash_table_iter_init(&at, rtsp->mounted);
    while (g_hash_table_iter_next(&at, &name, NULL)) {
        if (pel_snapshot_find_view(s, name) < 0) {
            char path[PEL_NAME_SIZE + 1];
            snprintf(path, sizeof path, "/%s", (const char *)name);
            gst_rtsp_mount_points_remove_factory(points, path);
            g_hash_table_iter_remove(&at);
        }
    }
    for (size_t i = 0; i < s->view_count; i++) {
        if (!g_hash_table_contains(rtsp->mounted, s->views[i].name)) {
            mount(rtsp, points, s->views[i].name);
        }
    }
    pel_snapshot_unref(s);
    g_object_unref(points);
}

/* --- clients that do nothing ---------------------------------------------- */

struct loiterers {
    struct pel_rtsp *rtsp;
    int64_t now_ns, patience_ns;
    bool stranger;         /* only those that are not known */
    GstRTSPClient *oldest; /* of those beyond patience; a reference */
    int64_t oldest_ns;
    bool spoke; /* it has: what it said was not read yet */
};

/* Whether a stranger has said something that nobody has read yet, a busy
 * machine perhaps: those who are silent go first, and those who gave the token
 * of one who may steer or instruct never. */
static bool has_spoken(struct pel_rtsp *rtsp, const struct visit *visit,
                       bool *spared)
{
    bool waits = false;
    pthread_mutex_lock(&rtsp->lock);
    char *value =
        visit->socket ? pel_rtsp_guard_peek(visit->socket, &waits) : NULL;
    pthread_mutex_unlock(&rtsp->lock);
    struct pel_who who = { PEL_RANK_NOBODY, 0 };
    if (value && rtsp->token) {
        who = pel_token_authorizes(rtsp->token, value);
    }
    g_free(value);
    *spared = who.rank < PEL_RANK_WATCH;
    return waits;
}

static GstRTSPFilterResult find_loiterer(GstRTSPServer *server,
                                         GstRTSPClient *client, gpointer user)
{
    (void)server;
    struct loiterers *found = user;
    int64_t since_ns = atomic_load(&visit_of(client)->since_ns);
    if (since_ns > found->now_ns - found->patience_ns) {
        return GST_RTSP_FILTER_KEEP;
    }
    bool spared = false;
    bool spoke = found->stranger && !atomic_load(&visit_of(client)->known) &&
                 has_spoken(found->rtsp, visit_of(client), &spared);
    if (spared || (found->oldest &&
                   (spoke > found->spoke ||
                    (spoke == found->spoke && since_ns >= found->oldest_ns)))) {
        return GST_RTSP_FILTER_KEEP;
    }
    GList *sessions = gst_rtsp_client_session_filter(client, NULL, NULL);
    bool wanted = found->stranger
                      ? !atomic_load(&visit_of(client)->known)
                      : !sessions || !atomic_load(&visit_of(client)->played);
    if (wanted) {
        g_clear_object(&found->oldest);
        found->oldest = g_object_ref(client);
        found->oldest_ns = since_ns;
        found->spoke = spoke;
    }
    g_list_free_full(sessions, g_object_unref);
    return GST_RTSP_FILTER_KEEP;
}

/* Its own thread sees the end, as if the client had left, and tidies up; closed
 * from here the socket would stay, and the thread read from what is gone. */
static void send_away(GstRTSPClient *client)
{
    GSocket *socket = gst_rtsp_connection_get_read_socket(
        gst_rtsp_client_get_connection(client));
    if (socket) {
        pel_rtsp_guard_end(socket);
    }
}

/* Closes the one that has been idle for longest, of all or of those who have
 * not said who they are; false: there is none. */
static bool close_loiterer(struct pel_rtsp *rtsp, int64_t patience_ns,
                           bool stranger)
{
    struct loiterers found = { .rtsp = rtsp,
                               .now_ns = pel_now_ns(),
                               .patience_ns = patience_ns,
                               .stranger = stranger };
    gst_rtsp_server_client_filter(rtsp->server, find_loiterer, &found);
    if (!found.oldest) {
        return false;
    }
    rtsp->timeouts++;
    atomic_store(&visit_of(found.oldest)->since_ns, INT64_MAX);
    send_away(found.oldest);
    g_object_unref(found.oldest);
    return true;
}

static gboolean clean(gpointer user)
{
    PEL_WATCH("rtsp");
    struct pel_rtsp *rtsp = user;
    for (int i = 0; i < MOST_CLIENTS && close_loiterer(rtsp, LOITER_NS, false);
         i++) {
    }
    GstRTSPSessionPool *pool = gst_rtsp_server_get_session_pool(rtsp->server);
    gst_rtsp_session_pool_cleanup(pool);
    g_object_unref(pool);
    return G_SOURCE_CONTINUE;
}

static void start_server(struct pel_rtsp *rtsp)
{
    rtsp->server = gst_rtsp_server_new();
    gst_rtsp_server_set_content_length_limit(rtsp->server, PEL_RTSP_BODY_BYTES);
    GstRTSPSessionPool *pool = gst_rtsp_server_get_session_pool(rtsp->server);
    gst_rtsp_session_pool_set_max_sessions(pool, MAX_SESSIONS);
    g_object_unref(pool);
    GstRTSPThreadPool *threads = gst_rtsp_server_get_thread_pool(rtsp->server);
    gst_rtsp_thread_pool_set_max_threads(threads, THREADS);
    g_object_unref(threads);
    if (rtsp->token) {
        GstRTSPAuth *auth = pel_rtsp_auth_new(rtsp->token, admit, rtsp);
        gst_rtsp_server_set_auth(rtsp->server, auth);
        g_object_unref(auth);
    }
    g_signal_connect(rtsp->server, "client-connected", G_CALLBACK(on_connected),
                     rtsp);
    rtsp->cleaner = g_timeout_add_seconds(CLEAN_S, clean, rtsp);
    rtsp->state = STATE_RUNS;
    pel_rtsp_changed(rtsp);
}

static void hand_over(struct pel_rtsp *rtsp, const struct waiting *client)
{
    GSocket *socket = pel_rtsp_guarded_socket(client->fd);
    if (!socket) {
        close(client->fd);
        return;
    }
    atomic_fetch_add(&rtsp->clients, 1);
    if (!gst_rtsp_server_transfer_connection(rtsp->server, socket, client->host,
                                             client->port, NULL)) {
        atomic_fetch_sub(&rtsp->clients, 1);
    }
}

/* --- coming to life ------------------------------------------------------ */

static gboolean on_started(gpointer user)
{
    PEL_WATCH("rtsp");
    struct pel_rtsp *rtsp = user;
    pthread_join(rtsp->starter, NULL);
    rtsp->state = STATE_BROKEN;
    if (rtsp->start_err == PEL_OK) {
        start_server(rtsp);
    } else {
        pel_error("NET-031", "RTSP cannot start: %s",
                  rtsp->start_fault.message);
    }
    for (unsigned i = 0; i < rtsp->waiting_count; i++) {
        if (rtsp->state == STATE_RUNS) {
            hand_over(rtsp, &rtsp->waiting[i]);
        } else {
            close(rtsp->waiting[i].fd);
        }
    }
    rtsp->waiting_count = 0;
    return G_SOURCE_REMOVE;
}

static void *start(void *user)
{
    struct pel_rtsp *rtsp = user;
    static const char *const needed[] = { "appsrc", "rtph264pay", "rtpbin",
                                          "udpsrc" };
    rtsp->start_err = pel_gst_start(&rtsp->start_fault);
    for (size_t i = 0; rtsp->start_err == PEL_OK && i < G_N_ELEMENTS(needed);
         i++) {
        GstElementFactory *factory = gst_element_factory_find(needed[i]);
        if (factory) {
            gst_object_unref(factory);
        } else {
            rtsp->start_err = pel_fault_set(
                &rtsp->start_fault, PEL_ERR_NOT_FOUND,
                "GStreamer has no %s: gstreamer1.0-plugins-base and -good "
                "have what is needed",
                needed[i]);
        }
    }
    g_idle_add_full(G_PRIORITY_DEFAULT, on_started, rtsp, NULL);
    return NULL;
}

/* The first makes room for the last. */
static void wait_for_start(struct pel_rtsp *rtsp, const struct waiting *client)
{
    if (rtsp->waiting_count == MAX_WAITING) {
        close(rtsp->waiting[0].fd);
        rtsp->refused++;
        rtsp->waiting_count--;
        memmove(rtsp->waiting, rtsp->waiting + 1,
                rtsp->waiting_count * sizeof *rtsp->waiting);
    }
    rtsp->waiting[rtsp->waiting_count++] = *client;
}

/* Where a token is asked for a newcomer has one of the strangers' places, which
 * whoever came first and has not given it yet leaves. */
static bool has_room(struct pel_rtsp *rtsp)
{
    unsigned clients = atomic_load(&rtsp->clients);
    if (!rtsp->token) {
        return clients < MAX_CLIENTS || close_loiterer(rtsp, WANTED_NS, false);
    }
    pthread_mutex_lock(&rtsp->lock);
    unsigned known = rtsp->places->len;
    pthread_mutex_unlock(&rtsp->lock);
    bool many = clients >= known + MAX_STRANGERS;
    bool made = many && close_loiterer(rtsp, NEW_NS, true);
    /* Those that are being closed are counted until their threads have. */
    return clients < MOST_CLIENTS + MAX_STRANGERS && (!many || made);
}

/* False: there is no room, and the descriptor stays the caller's. */
static bool take_client(struct pel_rtsp *rtsp, const struct waiting *client)
{
    if (rtsp->state == STATE_ASLEEP) {
        rtsp->state = pthread_create(&rtsp->starter, NULL, start, rtsp) == 0
                          ? STATE_STARTING
                          : STATE_ASLEEP;
    }
    bool room = rtsp->state == STATE_STARTING ||
                (rtsp->state == STATE_RUNS && has_room(rtsp));
    if (!room) {
        rtsp->refused++;
        return false;
    }
    rtsp->accepted++;
    if (rtsp->state == STATE_STARTING) {
        wait_for_start(rtsp, client);
    } else {
        hand_over(rtsp, client);
    }
    return true;
}

struct shaking {
    struct pel_rtsp *rtsp;
    struct waiting client;
};

static void on_shaken(void *user, int plain)
{
    struct shaking *shaking = user;
    shaking->client.fd = plain;
    if (plain >= 0 && !take_client(shaking->rtsp, &shaking->client)) {
        close(plain);
    }
    g_free(shaking);
}

/* Who has not ended his handshake has none of the places of clients. */
static void shake(struct pel_rtsp *rtsp, const struct waiting *client)
{
    if (pel_tls_shaking(rtsp->tls, on_shaken) >= MAX_SHAKING &&
        pel_tls_make_room(rtsp->tls, on_shaken)) {
        rtsp->timeouts++;
    }
    struct shaking *shaking = g_new(struct shaking, 1);
    *shaking = (struct shaking){ rtsp, *client };
    if (!pel_tls_serve_later(rtsp->tls, client->fd, true, HANDSHAKE_S, STALL_S,
                             on_shaken, shaking)) {
        rtsp->refused++;
        g_free(shaking);
    }
}

static bool accept_client(void *user, int fd, const struct sockaddr *address,
                          socklen_t size)
{
    struct pel_rtsp *rtsp = user;
    struct waiting client = { .fd = fd };
    GSocketAddress *from =
        g_socket_address_new_from_native((gpointer)address, size);
    if (G_IS_INET_SOCKET_ADDRESS(from)) {
        GInetSocketAddress *inet = G_INET_SOCKET_ADDRESS(from);
        char *text =
            g_inet_address_to_string(g_inet_socket_address_get_address(inet));
        g_strlcpy(client.host, text, sizeof client.host);
        client.port = g_inet_socket_address_get_port(inet);
        g_free(text);
    }
    g_clear_object(&from);
    if (rtsp->tls) {
        shake(rtsp, &client);
        return true;
    }
    return take_client(rtsp, &client);
}

/* --- life ---------------------------------------------------------------- */

enum pel_err pel_rtsp_create(const struct pel_rtsp_options *options,
                             struct pel_scene *scene, struct pel_frames *frames,
                             struct pel_rtsp **out, struct pel_fault *fault)
{
    struct pel_rtsp *rtsp = g_new0(struct pel_rtsp, 1);
    enum pel_err err = pel_listener_tcp(
        "--rtsp", options->address, options->port, options->allow_remote,
        accept_client, rtsp, &rtsp->listener, fault);
    if (err != PEL_OK) {
        g_free(rtsp);
        return err;
    }
    pthread_mutex_init(&rtsp->lock, NULL);
    pel_rtsp_gate_begin(&rtsp->gate);
    rtsp->places = g_ptr_array_new();
    rtsp->token = options->token;
    rtsp->tls = options->tls;
    rtsp->scene = scene;
    rtsp->hub = pel_rtsp_hub_create(frames);
    rtsp->port = pel_listener_port(rtsp->listener);
    rtsp->mounted =
        g_hash_table_new_full(g_str_hash, g_str_equal, g_free, NULL);
    *out = rtsp;
    return PEL_OK;
}

void pel_rtsp_stop(struct pel_rtsp *rtsp)
{
    pel_listener_destroy(rtsp->listener);
    rtsp->listener = NULL;
}

static void send_all_away(struct pel_rtsp *rtsp)
{
    GList *all = gst_rtsp_server_client_filter(rtsp->server, NULL, NULL);
    for (GList *each = all; each; each = each->next) {
        send_away(each->data);
    }
    g_list_free_full(all, g_object_unref);
    for (int i = 0; i < LEAVE_MS && atomic_load(&rtsp->clients) > 0; i++) {
        g_usleep(1000);
    }
}

static GstRTSPFilterResult drop_client(GstRTSPServer *server,
                                       GstRTSPClient *client, gpointer user)
{
    (void)server;
    g_signal_handlers_disconnect_by_data(client, user);
    gst_rtsp_client_close(client);
    return GST_RTSP_FILTER_REMOVE;
}

static GstRTSPFilterResult drop_session(GstRTSPSessionPool *pool,
                                        GstRTSPSession *session, gpointer user)
{
    (void)pool;
    (void)session;
    (void)user;
    return GST_RTSP_FILTER_REMOVE;
}

static void stop_server(struct pel_rtsp *rtsp)
{
    g_source_remove(rtsp->cleaner);
    GstRTSPSessionPool *pool = gst_rtsp_server_get_session_pool(rtsp->server);
    send_all_away(rtsp);
    gst_rtsp_server_client_filter(rtsp->server, drop_client, rtsp);
    gst_rtsp_session_pool_filter(pool, drop_session, NULL);
    g_object_unref(pool);
    g_object_unref(rtsp->server);
}

void pel_rtsp_destroy(struct pel_rtsp *rtsp)
{
    if (!rtsp) {
        return;
    }
    pel_listener_destroy(rtsp->listener);
    while (rtsp->tls && pel_tls_make_room(rtsp->tls, on_shaken)) {
    }
    if (rtsp->state == STATE_STARTING) {
        pthread_join(rtsp->starter, NULL);
        g_idle_remove_by_data(rtsp);
        for (unsigned i = 0; i < rtsp->waiting_count; i++) {
            close(rtsp->waiting[i].fd);
        }
    }
    pel_rtsp_hub_close(rtsp->hub);
    if (rtsp->state == STATE_RUNS) {
        stop_server(rtsp);
    }
    pel_rtsp_hub_unref(rtsp->hub);
    g_hash_table_destroy(rtsp->mounted);
    g_ptr_array_free(rtsp->places, TRUE);
    pthread_mutex_destroy(&rtsp->lock);
    pel_rtsp_gate_end(&rtsp->gate);
    g_free(rtsp);
}

uint16_t pel_rtsp_port(const struct pel_rtsp *rtsp)
{
    return rtsp->port;
}

void pel_rtsp_collect(const struct pel_rtsp *rtsp,
                      struct pel_metrics_page *page)
{
    const struct pel_rtsp_hub *hub = rtsp->hub;
    const struct {
        const char *name, *help;
        uint64_t value;
    } counters[] = {
        { "pelagos_rtsp_accepted_total", "RTSP connections accepted.",
          rtsp->accepted },
        { "pelagos_rtsp_frames_sent_total", "Pictures given to RTSP clients.",
          hub->sent },
        { "pelagos_rtsp_sent_bytes_total", "Bytes of them.", hub->bytes },
        { "pelagos_rtsp_frames_dropped_total",
          "Times that an RTSP client's queue was full.", hub->dropped },
    };
    pel_metric(page, "pelagos_rtsp_clients", PEL_METRIC_GAUGE,
               "RTSP connections open.", NULL, atomic_load(&rtsp->clients));
    pel_metric(page, "pelagos_rtsp_streams", PEL_METRIC_GAUGE,
               "RTSP streams prepared or playing.", NULL, hub->streaming);
    for (size_t i = 0; i < G_N_ELEMENTS(counters); i++) {
        pel_metric(page, counters[i].name, PEL_METRIC_COUNTER, counters[i].help,
                   NULL, (double)counters[i].value);
    }
    pel_metric(page, "pelagos_refused_total", PEL_METRIC_COUNTER,
               "Clients turned away at a limit.", "input=\"rtsp\"",
               (double)(rtsp->refused + atomic_load(&rtsp->crowded)));
    pel_metric(page, "pelagos_malformed_total", PEL_METRIC_COUNTER,
               "Messages that could not be read.", "input=\"rtsp\"",
               (double)pel_rtsp_guard_broken());
    pel_metric(page, "pelagos_timeouts_total", PEL_METRIC_COUNTER,
               "Clients closed for being too slow.", "input=\"rtsp\"",
               (double)rtsp->timeouts);
}
