/* A random walk through the life of protobuf sessions (docs/machines.md), by
 * the code that runs, over real sockets: clients that connect, log in, ask,
 * send rubbish or a byte at a time, stop reading, leave; the test plays the
 * renderer, and moves the clock. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>

#include <cmocka.h>

#include "base/log.h"
#include "base/walk_testkit.h"
#include "message.h"
#include "net/session_parts.h"
#include "net/walkframes_testkit.h"
#include "scene/scene_testkit.h"
#include "wire.h"

#define PEERS 10
#define TOKEN "0123456789abcdef-walk"
#define BUFFER (1 << 19)

/* A request that has no answer yet. */
struct owed {
    uint64_t id;
    unsigned result; /* of enum case; 0: that or an error */
    unsigned code;   /* of an error */
    bool picture, watch, login;
};

struct peer {
    int fd;                  /* -1: nobody */
    struct session *session; /* NULL: gone */
    enum pel_transport transport;
    bool known, doomed, shut, ended;
    int64_t since_ns, doomed_ns;
    uint8_t *out, *in;
    size_t out_size, in_size;
    struct owed owed[256];
    size_t owed_count;
    uint64_t watch_id; /* 0: none */
};

static struct pel_scene *scene;
static struct pel_frames *frames;
static struct pel_sessions *all;
static struct pel_net_limits limits;
static struct peer peers[PEERS];
static uint64_t next_id = 1, base_revision, patches_sent, patches_answered;
static unsigned long counts[PEL_SESSION_COMMANDS], answers, ends, errors,
    refusals;
static bool stopped;

static bool is_open(const struct session *s)
{
    return s && g_ptr_array_find(all->list, (gpointer)s, NULL);
}

/* Until nothing is left to do at this moment. */
static void come_to_rest(void)
{
    int turns = 0;
    while (g_main_context_iteration(NULL, FALSE)) {
        assert_true(++turns < 100000);
    }
    for (int i = 0; i < PEERS; i++) {
        if (peers[i].session && !is_open(peers[i].session)) {
            peers[i].session = NULL;
            ends++;
        }
    }
}

/* --- what a client reads -------------------------------------------------- */

struct reply {
    bool has_id;
    uint64_t id;
    unsigned result, code;
};

static uint64_t varint(const uint8_t **at, const uint8_t *end)
{
    uint64_t value = 0;
    for (int shift = 0; *at < end && shift < 64; shift += 7) {
        uint8_t byte = *(*at)++;
        value |= (uint64_t)(byte & 127) << shift;
        if (byte < 128) {
            break;
        }
    }
    return value;
}

/* The number, the kind of result, and an error's code: what is needed here,
 * at a tenth of the time that all of it takes. */
static struct reply read_reply(const uint8_t *at, size_t size)
{
    struct reply reply = { 0 };
    const uint8_t *end = at + size;
    while (at < end) {
        uint64_t tag = varint(&at, end);
        if (tag == 8) {
            reply.has_id = true;
            reply.id = varint(&at, end);
            continue;
        }
        assert_int_equal(tag & 7, 2);
        uint64_t length = varint(&at, end);
        assert_true(length <= (uint64_t)(end - at));
        reply.result = (unsigned)(tag >> 3);
        if (reply.result == 2) {
            assert_int_equal(*at, 8); /* code comes first */
            reply.code = at[1];
        }
        at += length;
    }
    return reply;
}

static void doom(struct peer *peer)
{
    if (!peer->doomed) {
        peer->doomed = true;
        peer->doomed_ns = walk.now_ns;
    }
}

static void take_reply(struct peer *peer, struct reply r)
{
    answers++;
    errors += r.result == 2;
    if (!peer->known) { /* nothing else for a stranger */
        assert_int_equal(r.result, 2);
        assert_int_equal(r.code, PELAGOS__ERROR_CODE__UNAUTHORIZED);
        assert_true(peer->doomed);
    }
    if (!r.has_id) {
        assert_true(peer->doomed && r.result == 2);
        assert_true(r.code == PELAGOS__ERROR_CODE__MALFORMED ||
                    r.code == PELAGOS__ERROR_CODE__BUSY);
        peer->ended = true;
        return;
    }
    assert_false(peer->ended); /* nothing comes after that */
    bool ordered = true;
    for (size_t i = 0; i < peer->owed_count; i++) {
        struct owed o = peer->owed[i];
        if (o.id == r.id && o.login && r.result == 2 &&
            r.code == PELAGOS__ERROR_CODE__BUSY) { /* no place was left */
            doom(peer);
            peer->ended = true;
            peer->owed_count = 0;
            refusals++;
            return;
        }
        if (o.id == r.id) {
            assert_true(ordered || o.picture);
            assert_true(r.result == o.result || o.result == 0 || stopped);
            if (r.result == 2 && o.code && !stopped) {
                assert_int_equal(r.code, o.code);
            }
            patches_answered += o.result == 3 && o.code == 99;
            memmove(peer->owed + i, peer->owed + i + 1,
                    (--peer->owed_count - i) * sizeof o);
            peer->watch_id = o.watch ? r.id : peer->watch_id;
            return;
        }
        ordered = ordered && o.picture;
    }
    /* Not asked for, or answered before: news for who watches. */
    assert_true(peer->watch_id && r.id <= peer->watch_id && r.result == 3);
}

/* What has come, up to `most` bytes of it. */
static void read_some_of(struct peer *peer, size_t most)
{
    most = MIN(most, BUFFER - peer->in_size);
    ssize_t n = recv(peer->fd, peer->in + peer->in_size, most, MSG_DONTWAIT);
    peer->in_size += n > 0 ? (size_t)n : 0;
    size_t used = 0, offset = 0, length = 0;
    while (pel_wire_next(peer->in + used, peer->in_size - used, BUFFER, &offset,
                         &length) == PEL_WIRE_MESSAGE) {
        take_reply(peer, read_reply(peer->in + used + offset, length));
        used += offset + length;
    }
    memmove(peer->in, peer->in + used, peer->in_size - used);
    peer->in_size -= used;
}

/* --- what a client does --------------------------------------------------- */

static void connect_peer(struct peer *peer)
{
    int pair[2], small = 4096;
    unsigned open = 0;
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, pair),
                     0);
    setsockopt(pair[1], SOL_SOCKET, SO_SNDBUF, &small, sizeof small);
    peer->transport = below(2) ? PEL_TRANSPORT_TCP : PEL_TRANSPORT_UNIX;
    for (guint i = 0; i < all->list->len; i++) {
        const struct session *s = g_ptr_array_index(all->list, i);
        open += s->transport == peer->transport && !s->stranger && !s->ended;
    }
    bool at_once = peer->transport == PEL_TRANSPORT_UNIX; /* it has a place */
    uint64_t evicted = all->evicted;
    peer->fd = pair[0];
    peer->known = peer->transport == PEL_TRANSPORT_UNIX;
    peer->doomed = peer->shut = peer->ended = false;
    peer->since_ns = walk.now_ns;
    peer->out_size = peer->in_size = peer->owed_count = 0;
    peer->watch_id = 0;
    if (pel_sessions_accept(all, pair[1], peer->transport)) {
        peer->session = g_ptr_array_index(all->list, all->list->len - 1);
        assert_true(!at_once || open < limits.sessions ||
                    all->evicted == evicted + 1);
        for (int i = 0; i < PEERS; i++) { /* at an old one's address */
            if (&peers[i] != peer && peers[i].session == peer->session) {
                peers[i].session = NULL;
            }
        }
    } else {
        assert_true((at_once && open == limits.sessions) || stopped);
        close(pair[1]);
        peer->session = NULL;
        peer->doomed = peer->known = true;
        peer->doomed_ns = walk.now_ns;
        refusals++;
    }
}

/* One of the requests there are; `patch` and the like outlive the call. */
static struct owed fill(Pelagos__Request *request)
{
    static Pelagos__Get get = PELAGOS__GET__INIT;
    static Pelagos__Watch watch = PELAGOS__WATCH__INIT;
    static Pelagos__ClockStep step = PELAGOS__CLOCK_STEP__INIT;
    static Pelagos__Login login = PELAGOS__LOGIN__INIT;
    static Pelagos__FrameRequest frame = PELAGOS__FRAME_REQUEST__INIT;
    static Pelagos__Patch patched = PELAGOS__PATCH__INIT;
    static Pelagos__State state = PELAGOS__STATE__INIT;
    static Pelagos__Sky sky = PELAGOS__SKY__INIT;
    struct owed owed = { .result = 3 };
    switch (below(12)) {
    case 0:
    case 1:
        request->command_case = PELAGOS__REQUEST__COMMAND_GET;
        request->get = &get;
        break;
    case 2:
    case 3:
        state.sky = &sky;
        patched.state = &state;
        sky.has_visibility = true;
        sky.visibility = below(4) ? 1000.0 + below(5000) : -1;
        request->command_case = PELAGOS__REQUEST__COMMAND_PATCH;
        request->patch = &patched;
        owed.result = sky.visibility < 0 ? 2 : 3;
        owed.code = sky.visibility < 0 ? PELAGOS__ERROR_CODE__OUT_OF_RANGE : 99;
        break;
    case 4: /* the clock runs: it cannot be stepped */
        step.has_seconds = true;
        step.seconds = 1;
        request->command_case = PELAGOS__REQUEST__COMMAND_STEP;
        request->step = &step;
        owed.result = 2;
        owed.code = PELAGOS__ERROR_CODE__CONFLICT;
        break;
    case 5:
        request->command_case = PELAGOS__REQUEST__COMMAND_WATCH;
        request->watch = &watch;
        break;
    case 6:
        owed.result = 2;
        owed.code = PELAGOS__ERROR_CODE__INVALID;
        break;
    case 7:
        login.token = below(4) ? (char *)TOKEN : (char *)"wrong";
        request->command_case = PELAGOS__REQUEST__COMMAND_LOGIN;
        request->login = &login;
        break;
    default:
        frame.view = below(5) ? (char *)"bow" : (char *)"none";
        request->command_case = PELAGOS__REQUEST__COMMAND_FRAME;
        request->frame = &frame;
        owed.result = strcmp(frame.view, "bow") == 0 ? 0 : 2;
        owed.picture = owed.result == 0;
        break;
    }
    return owed;
}

/* Whether the request ends the session, and what it makes of the client. */
static void foresee(struct peer *peer, const Pelagos__Request *request)
{
    bool login = request->command_case == PELAGOS__REQUEST__COMMAND_LOGIN;
    if (peer->transport == PEL_TRANSPORT_UNIX) {
        return;
    }
    if (login) {
        peer->known = strcmp(request->login->token, TOKEN) == 0;
    }
    if (!peer->known) {
        doom(peer);
    }
}

static void write_request(struct peer *peer)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    if (peer->owed_count == 256 || peer->doomed || peer->shut) {
        return;
    }
    /* Answers of a moment ago must be told from those of what it is now. */
    bool was_known = peer->known;
    struct owed owed = fill(&request);
    if (was_known && request.command_case == PELAGOS__REQUEST__COMMAND_LOGIN &&
        peer->transport == PEL_TRANSPORT_TCP) {
        request.login->token = (char *)TOKEN;
    }
    request.has_id = true;
    request.id = owed.id = next_id++;
    foresee(peer, &request);
    if (!peer->known) {
        owed.result = 2;
        owed.code = PELAGOS__ERROR_CODE__UNAUTHORIZED;
        owed.picture = false;
    } else {
        owed.watch = request.command_case == PELAGOS__REQUEST__COMMAND_WATCH;
        owed.login = request.command_case == PELAGOS__REQUEST__COMMAND_LOGIN &&
                     peer->transport == PEL_TRANSPORT_TCP;
    }
    patches_sent += owed.result == 3 && owed.code == 99;
    counts[request.command_case]++;
    size_t size = 0;
    uint8_t *bytes = pel_wire_pack(&request.base, &size);
    assert_true(peer->out_size + size <= BUFFER);
    memcpy(peer->out + peer->out_size, bytes, size);
    peer->out_size += size;
    peer->owed[peer->owed_count++] = owed;
    free(bytes);
}

/* No message, one that is too long, no length at all. */
static void write_rubbish(struct peer *peer)
{
    static const uint8_t rubbish[][6] = {
        { 2, 0xff, 0xff },
        { 0xff, 0xff, 0xff, 0x7f },
        { 0xff, 0xff, 0xff, 0xff, 0xff, 0xff },
    };
    static const size_t sizes[] = { 3, 4, 6 };
    unsigned which = below(3);
    if (!peer->doomed && !peer->shut) {
        memcpy(peer->out + peer->out_size, rubbish[which], sizes[which]);
        peer->out_size += sizes[which];
        peer->known = true; /* MALFORMED is what a stranger gets as well */
        doom(peer);
    }
}

static void send_some(struct peer *peer, size_t most)
{
    most = MIN(most, peer->out_size);
    ssize_t n = send(peer->fd, peer->out, most, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n > 0) {
        peer->out_size -= (size_t)n;
        memmove(peer->out, peer->out + n, peer->out_size);
    }
}

static void leave(struct peer *peer)
{
    close(peer->fd);
    peer->fd = -1;
}

/* --- the renderer --------------------------------------------------------- */

static void answer_one(void)
{
    unsigned first = below(PEL_MAX_REQUESTS);
    for (unsigned i = 0; i < PEL_MAX_REQUESTS; i++) {
        struct pel_frame_request *r =
            &frames->requests[(first + i) % PEL_MAX_REQUESTS];
        if (!r->used) {
            continue;
        }
        struct pel_fault fault;
        bool fails = below(10) == 0;
        pel_fault_set(&fault, PEL_ERR_IO, "no picture");
        struct pel_frame *picture =
            walk_picture(below(30) ? below(3000) : 100000, (int)i);
        pel_request_finish(frames, r, fails ? PEL_ERR_IO : PEL_OK,
                           fails ? &fault : NULL, picture);
        pel_frame_unref(picture);
        return;
    }
}

/* --- what always holds ---------------------------------------------------- */

static void look_at(const struct session *s)
{
    const int64_t slack = 5000000, now = walk.now_ns;
    const int64_t second = 1000000000;
    assert_true(s->jobs->len <= limits.session_requests);
    assert_true(s->in_size <=
                limits.session_message_bytes + PEL_WIRE_MAX_PREFIX);
    /* A reader that takes nothing holds up no more than this. */
    assert_true(s->out.bytes <= limits.session_output_bytes + 300000);
    if (s->out.bytes > 0) {
        assert_true(now - s->progress_ns <=
                    (int64_t)(limits.session_stall_s * 1e9) + slack);
    }
    if (s->stranger && !s->closing) {
        assert_true(s->jobs->len == 0 && !s->watching && !s->owes);
        assert_true(now - s->active_ns <=
                    (int64_t)(limits.session_login_s * 1e9) + slack);
    }
    if (s->message_since_ns && !s->closing && !s->owes &&
        s->out.bytes <= 65536) {
        assert_true(now - s->message_since_ns <=
                    (int64_t)(limits.session_message_s * 1e9) + slack);
    }
    if (s->closing) {
        assert_int_equal(s->jobs->len, 0);
        assert_true(!s->close_by_ns || now <= s->close_by_ns + slack);
        assert_true(!s->close_by_ns || s->close_by_ns <= now + 2 * second);
    }
}

static void look(void)
{
    unsigned open[PEL_TRANSPORT_COUNT] = { 0 }, pictures = 0, waiting = 0;
    for (guint i = 0; i < all->list->len; i++) {
        const struct session *s = g_ptr_array_index(all->list, i);
        look_at(s);
        open[s->transport] += !s->stranger && !s->ended;
        for (guint k = 0; k < s->jobs->len; k++) {
            const struct job *job = g_ptr_array_index(s->jobs, k);
            assert_true(job->session == s);
            pictures += job->is_picture;
        }
    }
    for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
        waiting += frames->requests[i].used;
    }
    /* Nobody's pictures are not drawn, and nobody is forgotten. */
    assert_int_equal(pictures, waiting);
    assert_int_equal(waiting, frames->stats.requests_waiting);
    for (int i = 0; i < PEL_TRANSPORT_COUNT; i++) {
        assert_true(open[i] <= limits.sessions);
    }
    uint64_t revision = pel_scene_state(scene)->revision;
    assert_true(revision - base_revision <= patches_sent);
    assert_true(revision - base_revision >= patches_answered);
    for (int i = 0; i < PEERS; i++) {
        const struct peer *peer = &peers[i];
        if (peer->fd >= 0 && peer->session && !peer->known) {
            assert_true(walk.now_ns - peer->since_ns <=
                        (int64_t)((limits.session_login_s +
                                   limits.session_stall_s + 3) *
                                  1e9));
        }
    }
}

/* --- the walk ------------------------------------------------------------- */

static void step(void)
{
    static const double waits[] = { 0.001, 0.001, 0.02, 0.02, 0.3, 2, 11, 70 };
    static unsigned long count;
    struct peer *peer = &peers[below(PEERS)];
    unsigned what = below(100);
    bool slow = ++count % 2000 < 1000; /* to draw */
    if (what < 8) {
        walk_wait(waits[below(below(20) ? 5 : 8)]);
    } else if (what < 28) {
        if (!slow || below(8) == 0) {
            answer_one();
        }
    } else if (peer->fd < 0) {
        connect_peer(peer);
    } else if (what < 50) {
        write_request(peer);
        send_some(peer, below(4) ? BUFFER : 1 + below(20));
    } else if (what < 60) {
        send_some(peer, below(2) ? BUFFER : 1 + below(9));
    } else if (what < 96) {
        read_some_of(peer, below(3) ? BUFFER : 1 + below(2000));
    } else if (what == 96) {
        if (below(6) == 0) {
            write_rubbish(peer);
        }
        send_some(peer, BUFFER);
    } else if (what == 97 && below(3) == 0) {
        shutdown(peer->fd, SHUT_WR);
        peer->shut = true;
        peer->out_size = 0;
        doom(peer);
    } else if (what >= 98 &&
               (!peer->session || (peer->doomed && below(2)) || !below(20))) {
        leave(peer);
    }
}

/* The scene has told net.c, and that all who watch. */
static void on_commit(void *user)
{
    (void)user;
    pel_sessions_changed(all);
}

static struct pel_token *make_token(void)
{
    char path[] = "/tmp/pelagos-walk-XXXXXX";
    int fd = mkstemp(path);
    struct pel_token *token;
    assert_true(fd >= 0);
    assert_int_equal(write(fd, TOKEN "\n", strlen(TOKEN) + 1),
                     strlen(TOKEN) + 1);
    close(fd);
    assert_int_equal(pel_token_create(path, &token, NULL), PEL_OK);
    unlink(path);
    return token;
}

/* Who reads on gets all that was owed, and who came late is told why. */
static void drain(void)
{
    stopped = true;
    pel_sessions_stop(all);
    for (int turn = 0; turn < 3000; turn++) {
        for (int i = 0; i < PEERS; i++) {
            if (peers[i].fd >= 0) {
                send_some(&peers[i], BUFFER);
                read_some_of(&peers[i], BUFFER);
            }
        }
        answer_one();
        come_to_rest();
        look();
    }
    for (int i = 0; i < PEERS; i++) {
        if (peers[i].session && !peers[i].doomed) {
            assert_int_equal(peers[i].owed_count, 0);
        }
    }
}

static void a_session_s_life(void **state)
{
    (void)state;
    walk_seed();
    walk_stop_clock();
    pel_log_set_level(PEL_LOG_ERROR);
    scene = make_scene((struct pel_scene_options){ .wave_count = 20 });
    must(scene, "{\"views\":{\"bow\":{\"width\":64,\"height\":48}}}");
    base_revision = pel_scene_state(scene)->revision;
    frames = walk_frames(scene);
    pel_net_limits_default(&limits);
    limits.sessions = 3;
    limits.session_requests = 2;
    limits.session_output_bytes = 200000;
    struct pel_token *token = make_token();
    all = pel_sessions_create(&limits, scene, frames, NULL, token);
    pel_scene_on_commit(scene, on_commit, NULL);
    for (int i = 0; i < PEERS; i++) {
        peers[i] = (struct peer){ .fd = -1,
                                  .out = malloc(2 * BUFFER),
                                  .in = malloc(BUFFER) };
    }
    unsigned long steps = walk_steps(20000);
    for (unsigned long i = 0; i < steps; i++) {
        step();
        come_to_rest();
        look();
    }
    print_message("%lu sessions over, %lu turned away, %lu answers, of them "
                  "%lu errors; %llu evicted, %llu + %llu timed out\n",
                  ends, refusals, answers, errors,
                  (unsigned long long)all->evicted,
                  (unsigned long long)all->timeouts[0],
                  (unsigned long long)all->timeouts[1]);
    assert_true(ends > steps / 500 && answers > steps / 20);
    drain();
    pel_sessions_destroy(all);
    for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
        assert_false(frames->requests[i].used);
    }
    for (int i = 0; i < PEERS; i++) {
        if (peers[i].fd >= 0) {
            leave(&peers[i]);
        }
        free(peers[i].out);
        free(peers[i].in);
    }
    walk_start_clock();
    pel_token_destroy(token);
    assert_true(walk_frames_end(frames));
    pel_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(a_session_s_life) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
