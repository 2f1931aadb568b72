#include "cluster/etcd.h"

#include <curl/curl.h>
#include <errno.h>
#include <glib-unix.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"
#include "cluster/etcdtext.h"
#include "scene/worker.h"

#define ANSWER_MS 400L  /* a leader that dies leaves requests hanging */
#define CONNECT_MS 300L /* also of the watch */
#define AGAIN_MS 80     /* another attempt beside those under way */
#define MOST_ATTEMPTS 3 /* of a request at once */
#define REST_MS 20      /* after a failure */
#define HOPELESS_MS 500
/* Limits of an answer, and of a line of the watch: etcd takes 1.5 MiB in a
 * request, and a watch that was cut off brings a thousand changes in a line. */
#define MOST_ANSWER (4u << 20)
#define MOST_LINE (16u << 20)
#define FEW_KEYS 64
#define MOST_KEYS 1024 /* of an answer: 64 nodes, and what an exercise has */
/* So that nobody else waits for a millisecond: what is taken from connections
 * in one turn of the loop, what is read on this thread instead of another, how
 * long changes are told of. */
#define TURN_BYTES (32u << 10)
#define SHORT_BYTES (8u << 10)
#define TELL_NS 300000

/* One exchange over HTTP: of a request, or the watch's. */
struct attempt {
    struct pel_etcd *etcd;
    struct pel_etcd_request *request; /* NULL: the watch */
    size_t endpoint;
    CURL *easy;
    GString *in;
    size_t taken;    /* bytes of it: lines of the watch */
    size_t searched; /* bytes of it that end no further line */
    bool paused;     /* until the next turn */
    bool full;       /* more came than may */
};

/* A text that a thread reads. */
struct reading {
    struct pel_task task;
    struct pel_etcd *etcd;
    uint64_t request;    /* its serial; 0: a line of the watch */
    unsigned generation; /* of that */
    size_t endpoint;
    long status;
    char *data;
    size_t size;
    struct pel_etcd_text text;
    enum pel_err err;
};

struct pel_etcd_request {
    struct pel_etcd *etcd;
    uint64_t serial;
    char *body;
    GPtrArray *attempts; /* under way */
    size_t begun;
    unsigned cut; /* attempts that the other side ended, or that do not trust
                   * it */
    guint timer;
    pel_etcd_done done;
    void *user;
};

struct pel_etcd {
    CURLM *multi;
    struct curl_slist *headers;
    char **endpoints;
    char *cert, *key, *ca;
    size_t endpoint_count, best, watched; /* of requests; of the watch */
    guint timer, resume;
    GPtrArray *requests;
    struct pel_worker *reader;
    size_t turn_bytes; /* taken in this turn */
    uint64_t serial, attempts, failures;
    struct {
        char *prefix; /* NULL: none */
        uint64_t next;
        struct attempt *attempt;
        guint timer;
        pel_etcd_event event;
        void (*lost)(void *user);
        void *user;
        unsigned generation; /* of the calls of pel_etcd_watch */
        unsigned session;    /* of its connections */
        bool reading;        /* a thread has its line */
        bool telling;        /* `text` is told of from `at` on */
        struct pel_etcd_text text;
        guint at;
    } watch;
};

/* --- libcurl on GLib's loop ----------------------------------------------- */

static void settle(struct pel_etcd *etcd);

static gboolean on_socket_ready(gint fd, GIOCondition condition, gpointer user)
{
    PEL_WATCH("etcd");
    struct pel_etcd *etcd = user;
    etcd->turn_bytes = 0;
    int running;
    int what = (condition & G_IO_IN ? CURL_CSELECT_IN : 0) |
               (condition & G_IO_OUT ? CURL_CSELECT_OUT : 0) |
               (condition & (G_IO_ERR | G_IO_HUP) ? CURL_CSELECT_ERR : 0);
    curl_multi_socket_action(etcd->multi, fd, what, &running);
    settle(etcd);
    return G_SOURCE_CONTINUE;
}

static int on_socket(CURL *easy, curl_socket_t fd, int what, void *user,
                     void *kept)
{
    (void)easy;
    struct pel_etcd *etcd = user;
    guint source = GPOINTER_TO_UINT(kept);
    if (source) {
        g_source_remove(source);
        source = 0;
    }
    if (what != CURL_POLL_REMOVE) {
        GIOCondition condition = G_IO_ERR | G_IO_HUP;
        condition |= what & CURL_POLL_IN ? G_IO_IN : 0;
        condition |= what & CURL_POLL_OUT ? G_IO_OUT : 0;
        source = g_unix_fd_add_full(G_PRIORITY_HIGH, fd, condition,
                                    on_socket_ready, etcd, NULL);
    }
    curl_multi_assign(etcd->multi, fd, GUINT_TO_POINTER(source));
    return 0;
}

static gboolean on_timeout(gpointer user)
{
    PEL_WATCH("etcd");
    struct pel_etcd *etcd = user;
    int running;
    etcd->timer = 0;
    etcd->turn_bytes = 0;
    curl_multi_socket_action(etcd->multi, CURL_SOCKET_TIMEOUT, 0, &running);
    settle(etcd);
    return G_SOURCE_REMOVE;
}

static int on_timer(CURLM *multi, long ms, void *user)
{
    (void)multi;
    struct pel_etcd *etcd = user;
    if (etcd->timer) {
        g_source_remove(etcd->timer);
    }
    etcd->timer = ms < 0 ? 0
                         : g_timeout_add_full(G_PRIORITY_HIGH, (guint)ms,
                                              on_timeout, etcd, NULL);
    return 0;
}

/* --- attempts ------------------------------------------------------------- */

static gboolean on_resume(gpointer user);

/* After everybody else: whoever sends without end is not waited for. */
static void resume_soon(struct pel_etcd *etcd)
{
    if (!etcd->resume) {
        etcd->resume =
            g_idle_add_full(G_PRIORITY_DEFAULT, on_resume, etcd, NULL);
    }
}

static bool watch_is_busy(const struct pel_etcd *etcd)
{
    return etcd->watch.reading || etcd->watch.telling;
}

static size_t on_data(char *data, size_t one, size_t count, void *user)
{
    struct attempt *attempt = user;
    struct pel_etcd *etcd = attempt->etcd;
    size_t size = one * count;
    size_t most = attempt->request ? MOST_ANSWER : MOST_LINE;
    if (attempt->in->len - attempt->taken + size > most) {
        attempt->full = true;
        return 0;
    }
    bool waits = !attempt->request && watch_is_busy(etcd) &&
                 attempt->in->len - attempt->taken > TURN_BYTES;
    if (waits ||
        (etcd->turn_bytes > 0 && etcd->turn_bytes + size > TURN_BYTES)) {
        attempt->paused = true;
        if (!waits) {
            resume_soon(etcd);
        }
        return CURL_WRITEFUNC_PAUSE;
    }
    etcd->turn_bytes += size;
    g_string_append_len(attempt->in, data, (gssize)size);
    return size;
}

static struct attempt *attempt_begin(struct pel_etcd *etcd,
                                     struct pel_etcd_request *request,
                                     size_t endpoint, const char *path,
                                     const char *body)
{
    struct attempt *attempt = g_new0(struct attempt, 1);
    *attempt = (struct attempt){ .etcd = etcd,
                                 .request = request,
                                 .endpoint = endpoint,
                                 .easy = curl_easy_init(),
                                 .in = g_string_new(NULL) };
    g_autofree char *url = g_strconcat(etcd->endpoints[endpoint], path, NULL);
    CURL *easy = attempt->easy;
    curl_easy_setopt(easy, CURLOPT_URL, url);
    curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(easy, CURLOPT_NOPROXY, "*");
    curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(easy, CURLOPT_HTTPHEADER, etcd->headers);
    curl_easy_setopt(easy, CURLOPT_POSTFIELDSIZE, (long)strlen(body));
    curl_easy_setopt(easy, CURLOPT_COPYPOSTFIELDS, body);
    curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS, CONNECT_MS);
    curl_easy_setopt(easy, CURLOPT_TCP_KEEPALIVE, 1L);
    curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, on_data);
    curl_easy_setopt(easy, CURLOPT_WRITEDATA, attempt);
    curl_easy_setopt(easy, CURLOPT_PRIVATE, attempt);
    curl_easy_setopt(easy, CURLOPT_SSLCERT, etcd->cert);
    curl_easy_setopt(easy, CURLOPT_SSLKEY, etcd->key);
    if (etcd->ca) {
        curl_easy_setopt(easy, CURLOPT_CAINFO, etcd->ca);
    }
    if (request) {
        curl_easy_setopt(easy, CURLOPT_TIMEOUT_MS, ANSWER_MS);
    }
    curl_multi_add_handle(etcd->multi, easy);
    return attempt;
}

static void attempt_end(struct attempt *attempt)
{
    curl_multi_remove_handle(attempt->etcd->multi, attempt->easy);
    curl_easy_cleanup(attempt->easy);
    g_string_free(attempt->in, TRUE);
    g_free(attempt);
}

static void attempt_free(gpointer data)
{
    attempt_end(data);
}

/* --- requests ------------------------------------------------------------- */

static void request_free(gpointer data)
{
    struct pel_etcd_request *request = data;
    if (request->timer) {
        g_source_remove(request->timer);
    }
    g_ptr_array_free(request->attempts, TRUE);
    g_free(request->body);
    g_free(request);
}

static void request_again(struct pel_etcd_request *request, guint ms);

/* A handshake takes its time on this thread: where certificates do not fit it
 * is not begun twelve times a second. */
static bool is_hopeless(const struct pel_etcd_request *request)
{
    return request->cut > MOST_ATTEMPTS &&
           g_str_has_prefix(request->etcd->endpoints[0], "https://");
}

static void request_try(struct pel_etcd_request *request)
{
    struct pel_etcd *etcd = request->etcd;
    if (request->attempts->len < (is_hopeless(request) ? 1 : MOST_ATTEMPTS)) {
        size_t endpoint = (etcd->best + request->begun) % etcd->endpoint_count;
        request->begun++;
        etcd->attempts++;
        g_ptr_array_add(request->attempts,
                        attempt_begin(etcd, request, endpoint, "/v3/kv/txn",
                                      request->body));
    }
    request_again(request, is_hopeless(request) ? HOPELESS_MS : AGAIN_MS);
}

static gboolean on_again(gpointer user)
{
    PEL_WATCH("etcd");
    struct pel_etcd_request *request = user;
    request->timer = 0;
    request_try(request);
    return G_SOURCE_REMOVE;
}

static void request_again(struct pel_etcd_request *request, guint ms)
{
    if (request->timer) {
        g_source_remove(request->timer);
    }
    request->timer =
        g_timeout_add_full(G_PRIORITY_HIGH, ms, on_again, request, NULL);
}

struct pel_etcd_request *pel_etcd_send(struct pel_etcd *etcd,
                                       struct pel_etcd_txn *txn,
                                       pel_etcd_done done, void *user)
{
    struct pel_etcd_request *request = g_new0(struct pel_etcd_request, 1);
    request->etcd = etcd;
    request->serial = ++etcd->serial;
    request->body = pel_etcd_text_txn(txn);
    request->attempts = g_ptr_array_new_with_free_func(attempt_free);
    request->done = done;
    request->user = user;
    g_string_free(txn->compare, TRUE);
    g_string_free(txn->success, TRUE);
    g_string_free(txn->failure, TRUE);
    g_ptr_array_add(etcd->requests, request);
    request_try(request);
    return request;
}

void pel_etcd_drop(struct pel_etcd_request *request)
{
    g_ptr_array_remove(request->etcd->requests, request);
}

static void request_failed(struct pel_etcd_request *request, size_t endpoint,
                           const char *why)
{
    static struct pel_log_limit limit;
    struct pel_etcd *etcd = request->etcd;
    etcd->failures++;
    pel_log_limited(&limit, PEL_LOG_WARNING, "CLU-001",
                    "%s does not answer: %s; the next one is asked",
                    etcd->endpoints[endpoint], why);
    if (request->attempts->len == 0) {
        request_again(request, is_hopeless(request) ? HOPELESS_MS : REST_MS);
    }
}

/* Takes the answer that an attempt brought, once it is read. */
static void request_take(struct pel_etcd_request *request, size_t endpoint,
                         long status, enum pel_err err,
                         const struct pel_etcd_text *text)
{
    struct pel_etcd *etcd = request->etcd;
    if (err || status != 200) {
        request_failed(request, endpoint,
                       text->failed ? text->why : "no answer of etcd");
    } else if (text->answer.kvs->len > MOST_KEYS) {
        request_failed(request, endpoint, "more keys than an exercise has");
    } else {
        pel_etcd_done done = request->done;
        void *user = request->user;
        etcd->best = endpoint;
        g_ptr_array_remove(etcd->requests, request);
        if (done) {
            done(user, &text->answer);
        }
    }
}

/* --- reading by a thread -------------------------------------------------- */

static void read_text(struct pel_task *task)
{
    struct reading *reading = (struct reading *)task;
    reading->err =
        pel_etcd_text_read(reading->data, reading->size, &reading->text);
    g_free(reading->data); /* megabytes take their time */
    reading->data = NULL;
}

static void finish(struct pel_task *task)
{
    struct reading *reading = (struct reading *)task;
    pel_etcd_text_finish(&reading->text);
    reading->text.answer.kvs = NULL;
}

static void on_finished(struct pel_task *task, bool dropped)
{
    struct reading *reading = (struct reading *)task;
    (void)dropped;
    if (reading->text.answer.kvs) {
        finish(task);
    }
    g_free(reading);
}

/* The thread frees a text of many keys: that takes time, too. */
static void finish_text(struct pel_etcd *etcd, struct pel_etcd_text *text)
{
    if (text->answer.kvs->len <= FEW_KEYS) {
        pel_etcd_text_finish(text);
        return;
    }
    struct reading *reading = g_new0(struct reading, 1);
    reading->task = (struct pel_task){ .work = finish, .done = on_finished };
    reading->text = *text;
    pel_worker_push(etcd->reader, &reading->task);
}

static void watch_read(struct reading *reading);

static void on_read(struct pel_task *task, bool dropped)
{
    PEL_WATCH("etcd");
    struct reading *reading = (struct reading *)task;
    struct pel_etcd *etcd = reading->etcd;
    for (guint i = 0; i < etcd->requests->len && !dropped && reading->request;
         i++) {
        struct pel_etcd_request *request = g_ptr_array_index(etcd->requests, i);
        if (request->serial == reading->request) {
            request_take(request, reading->endpoint, reading->status,
                         reading->err, &reading->text);
            break;
        }
    }
    if (!reading->request && !dropped) {
        watch_read(reading);
    }
    if (reading->text.answer.kvs && dropped) {
        pel_etcd_text_finish(&reading->text);
    } else if (reading->text.answer.kvs) {
        finish_text(etcd, &reading->text);
    }
    g_free(reading->data);
    g_free(reading);
}

/* data: g_free() by it. */
static struct reading *read_apart(struct pel_etcd *etcd, char *data,
                                  size_t size)
{
    struct reading *reading = g_new0(struct reading, 1);
    reading->task = (struct pel_task){ .work = read_text, .done = on_read };
    reading->etcd = etcd;
    reading->data = data;
    reading->size = size;
    return reading;
}

static void request_ended(struct attempt *attempt, CURLcode code)
{
    struct pel_etcd *etcd = attempt->etcd;
    struct pel_etcd_request *request = attempt->request;
    size_t endpoint = attempt->endpoint, size = attempt->in->len;
    bool full = attempt->full;
    long status = 0;
    curl_easy_getinfo(attempt->easy, CURLINFO_RESPONSE_CODE, &status);
    char *data = g_string_free(attempt->in, FALSE);
    attempt->in = g_string_new(NULL);
    g_ptr_array_remove(request->attempts, attempt);
    if (code != CURLE_OK) {
        request->cut +=
            code != CURLE_COULDNT_CONNECT && code != CURLE_OPERATION_TIMEDOUT;
        request_failed(request, endpoint,
                       full ? "its answer is longer than 4 MiB"
                            : curl_easy_strerror(code));
    } else if (size > SHORT_BYTES) {
        struct reading *reading = read_apart(etcd, data, size);
        reading->request = request->serial;
        reading->endpoint = endpoint;
        reading->status = status;
        pel_worker_push(etcd->reader, &reading->task);
        return;
    } else {
        struct pel_etcd_text text;
        enum pel_err err = pel_etcd_text_read(data, size, &text);
        request_take(request, endpoint, status, err, &text);
        pel_etcd_text_finish(&text);
    }
    g_free(data);
}

/* --- the watch ------------------------------------------------------------ */

static void watch_stop(struct pel_etcd *etcd)
{
    if (etcd->watch.attempt) {
        attempt_end(etcd->watch.attempt);
        etcd->watch.attempt = NULL;
    }
    if (etcd->watch.timer) {
        g_source_remove(etcd->watch.timer);
        etcd->watch.timer = 0;
    }
    if (etcd->watch.telling) {
        finish_text(etcd, &etcd->watch.text);
        etcd->watch.telling = false;
    }
    etcd->watch.reading = false; /* a thread's answer is of another session */
    etcd->watch.session++;
}

static void watch_begin(struct pel_etcd *etcd)
{
    g_autofree char *body =
        pel_etcd_text_watch(etcd->watch.prefix, etcd->watch.next);
    watch_stop(etcd);
    etcd->watch.attempt =
        attempt_begin(etcd, NULL, etcd->watched, "/v3/watch", body);
}

static gboolean on_watch_again(gpointer user)
{
    PEL_WATCH("etcd");
    struct pel_etcd *etcd = user;
    etcd->watch.timer = 0;
    watch_begin(etcd);
    return G_SOURCE_REMOVE;
}

void pel_etcd_watch_elsewhere(struct pel_etcd *etcd)
{
    if (etcd->watch.prefix) {
        watch_stop(etcd);
        etcd->watched = (etcd->watched + 1) % etcd->endpoint_count;
        etcd->watch.timer = g_timeout_add_full(G_PRIORITY_HIGH, REST_MS,
                                               on_watch_again, etcd, NULL);
    }
}

void pel_etcd_watch(struct pel_etcd *etcd, const char *prefix,
                    uint64_t from_revision, pel_etcd_event event,
                    void (*lost)(void *user), void *user)
{
    g_free(etcd->watch.prefix);
    etcd->watch.prefix = g_strdup(prefix);
    etcd->watch.next = from_revision;
    etcd->watch.event = event;
    etcd->watch.lost = lost;
    etcd->watch.user = user;
    etcd->watch.generation++;
    watch_begin(etcd);
}

/* Tells what the line at hand says, as far as there is time in this turn. Who
 * is told may begin another watch, or none. */
static void watch_tell(struct pel_etcd *etcd)
{
    unsigned session = etcd->watch.session;
    struct pel_etcd_text text = etcd->watch.text;
    guint at = etcd->watch.at;
    int64_t end_ns = pel_now_ns() + TELL_NS;
    bool lost = text.ended && text.compacted;
    bool failed = text.failed || (text.ended && !lost);
    etcd->watch.telling = false;
    for (; !failed && at < text.answer.kvs->len &&
           session == etcd->watch.session && pel_now_ns() < end_ns;
         at++) {
        const struct pel_etcd_kv *kv = g_ptr_array_index(text.answer.kvs, at);
        if (kv->mod_revision >= etcd->watch.next && kv->key) {
            etcd->watch.event(etcd->watch.user, kv);
        }
    }
    bool same = session == etcd->watch.session;
    if (same && !failed && at < text.answer.kvs->len) {
        etcd->watch.text = text;
        etcd->watch.at = at;
        etcd->watch.telling = true;
        resume_soon(etcd);
        return;
    }
    if (same && lost) {
        watch_stop(etcd);
        g_clear_pointer(&etcd->watch.prefix, g_free);
        etcd->watch.lost(etcd->watch.user);
    } else if (same && failed) {
        pel_etcd_watch_elsewhere(etcd);
    } else if (same && text.answer.kvs->len > 0 &&
               text.answer.revision >= etcd->watch.next) {
        etcd->watch.next = text.answer.revision + 1;
    }
    finish_text(etcd, &text);
}

static void watch_take(struct pel_etcd *etcd, enum pel_err err,
                       struct pel_etcd_text *text)
{
    if (err) {
        finish_text(etcd, text);
        pel_etcd_watch_elsewhere(etcd);
        return;
    }
    etcd->watch.text = *text;
    etcd->watch.at = 0;
    watch_tell(etcd);
}

static void watch_read(struct reading *reading)
{
    struct pel_etcd *etcd = reading->etcd;
    if (reading->generation != etcd->watch.session) {
        return;
    }
    struct pel_etcd_text text = reading->text;
    reading->text.answer.kvs = NULL;
    etcd->watch.reading = false;
    watch_take(etcd, reading->err, &text);
    resume_soon(etcd);
}

/* The end of the first line not taken; NULL: more is to come. A line that
 * comes in many pieces is searched once. */
static const char *line_end(struct attempt *attempt)
{
    const GString *in = attempt->in;
    size_t from = MAX(attempt->taken, attempt->searched);
    const char *end = memchr(in->str + from, '\n', in->len - from);
    attempt->searched = end ? (size_t)(end - in->str) : in->len;
    return end;
}

/* The lines that have come whole, as many as there is time for. */
static void watch_lines(struct pel_etcd *etcd)
{
    size_t turn = 0;
    while (!watch_is_busy(etcd)) {
        struct attempt *attempt = etcd->watch.attempt;
        const char *end = attempt ? line_end(attempt) : NULL;
        if (!end) {
            break;
        }
        const char *from = attempt->in->str + attempt->taken;
        size_t size = (size_t)(end - from);
        if (turn > 0 && turn + size > TURN_BYTES) {
            resume_soon(etcd);
            break;
        }
        turn += size + 1;
        char *line = g_strndup(from, size);
        attempt->taken += size + 1;
        if (size > SHORT_BYTES) {
            struct reading *reading = read_apart(etcd, line, size);
            reading->generation = etcd->watch.session;
            etcd->watch.reading = true;
            pel_worker_push(etcd->reader, &reading->task);
            break;
        }
        struct pel_etcd_text text;
        if (size > 0) {
            enum pel_err err = pel_etcd_text_read(line, size, &text);
            watch_take(etcd, err, &text);
        }
        g_free(line);
    }
    struct attempt *attempt = etcd->watch.attempt;
    if (attempt && attempt->taken > attempt->in->len / 2) {
        g_string_erase(attempt->in, 0, (gssize)attempt->taken);
        attempt->searched -= MIN(attempt->searched, attempt->taken);
        attempt->taken = 0;
    }
}

/* --- after libcurl has done something ------------------------------------- */

/* What its callbacks brought is looked at here: they must not call it. */
static void settle(struct pel_etcd *etcd)
{
    CURLMsg *message;
    int left;
    watch_lines(etcd);
    while ((message = curl_multi_info_read(etcd->multi, &left))) {
        struct attempt *attempt = NULL;
        if (message->msg != CURLMSG_DONE) {
            continue;
        }
        CURLcode code = message->data.result;
        curl_easy_getinfo(message->easy_handle, CURLINFO_PRIVATE,
                          (char **)&attempt);
        if (attempt->request) {
            request_ended(attempt, code);
        } else {
            pel_etcd_watch_elsewhere(etcd);
        }
    }
}

static void go_on(struct attempt *attempt)
{
    if (attempt && attempt->paused) {
        attempt->paused = false;
        curl_easy_pause(attempt->easy, CURLPAUSE_CONT);
    }
}

static gboolean on_resume(gpointer user)
{
    PEL_WATCH("etcd");
    struct pel_etcd *etcd = user;
    int running;
    etcd->resume = 0;
    etcd->turn_bytes = 0;
    if (etcd->watch.telling) {
        watch_tell(etcd);
    }
    if (!watch_is_busy(etcd)) {
        go_on(etcd->watch.attempt);
    }
    for (guint i = 0; i < etcd->requests->len; i++) {
        struct pel_etcd_request *request = g_ptr_array_index(etcd->requests, i);
        for (guint k = 0; k < request->attempts->len; k++) {
            go_on(g_ptr_array_index(request->attempts, k));
        }
    }
    curl_multi_socket_action(etcd->multi, CURL_SOCKET_TIMEOUT, 0, &running);
    settle(etcd);
    return G_SOURCE_REMOVE;
}

/* --- life ----------------------------------------------------------------- */

enum pel_err pel_etcd_create(const struct pel_etcd_options *options,
                             struct pel_etcd **out, struct pel_fault *fault)
{
    struct pel_etcd *etcd = g_new0(struct pel_etcd, 1);
    *out = NULL;
    curl_global_init(CURL_GLOBAL_DEFAULT);
    etcd->reader = pel_worker_create("etcd");
    etcd->endpoints = g_strsplit(options->endpoints, ",", 16);
    etcd->endpoint_count = g_strv_length(etcd->endpoints);
    etcd->requests = g_ptr_array_new_with_free_func(request_free);
    for (size_t i = 0; i < etcd->endpoint_count; i++) {
        const char *at = etcd->endpoints[i];
        if (!g_str_has_prefix(at, "http://") &&
            !g_str_has_prefix(at, "https://")) {
            enum pel_err err =
                pel_fault_set(fault, PEL_ERR_INVALID,
                              "%.100s is no http:// or https:// URL", at);
            pel_etcd_destroy(etcd);
            return err;
        }
    }
    const char *const files[] = { options->cert, options->key, options->ca };
    for (size_t i = 0; i < G_N_ELEMENTS(files); i++) {
        if (files[i] && access(files[i], R_OK) != 0) {
            enum pel_err err =
                pel_fault_set(fault, PEL_ERR_IO, "%.160s cannot be read: %s",
                              files[i], g_strerror(errno));
            pel_etcd_destroy(etcd);
            return err;
        }
    }
    etcd->cert = g_strdup(options->cert);
    etcd->key = g_strdup(options->key);
    etcd->ca = g_strdup(options->ca);
    etcd->headers = curl_slist_append(NULL, "Content-Type: application/json");
    etcd->headers = curl_slist_append(etcd->headers, "Expect:");
    etcd->multi = curl_multi_init();
    curl_multi_setopt(etcd->multi, CURLMOPT_SOCKETFUNCTION, on_socket);
    curl_multi_setopt(etcd->multi, CURLMOPT_SOCKETDATA, etcd);
    curl_multi_setopt(etcd->multi, CURLMOPT_TIMERFUNCTION, on_timer);
    curl_multi_setopt(etcd->multi, CURLMOPT_TIMERDATA, etcd);
    *out = etcd;
    return PEL_OK;
}

void pel_etcd_destroy(struct pel_etcd *etcd)
{
    if (!etcd) {
        return;
    }
    watch_stop(etcd);
    pel_worker_destroy(etcd->reader);
    g_ptr_array_free(etcd->requests, TRUE);
    if (etcd->resume) {
        g_source_remove(etcd->resume);
    }
    if (etcd->multi) {
        curl_multi_cleanup(etcd->multi);
    }
    if (etcd->timer) {
        g_source_remove(etcd->timer);
    }
    curl_slist_free_all(etcd->headers);
    g_strfreev(etcd->endpoints);
    g_free(etcd->watch.prefix);
    g_free(etcd->cert);
    g_free(etcd->key);
    g_free(etcd->ca);
    g_free(etcd);
}

void pel_etcd_count(const struct pel_etcd *etcd, uint64_t *attempts,
                    uint64_t *failures)
{
    *attempts = etcd->attempts;
    *failures = etcd->failures;
}
