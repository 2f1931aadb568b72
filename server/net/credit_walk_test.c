/* A random walk through the credit of live viewers (docs/machines.md), by the
 * code that runs, over real sockets: viewers that read and acknowledge at
 * once, late, never, what was not sent; that ask for other profiles, and
 * leave. The test plays renderer and encoder, and moves the clock. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>

#include <cmocka.h>

#include "base/log.h"
#include "base/walk_testkit.h"
#include "net/liveviewer.h"
#include "net/walkframes_testkit.h"
#include "net/websocket.h"
#include "scene/scene_testkit.h"

#define VIEWERS 8 /* the first of them keeps up, whatever the others do */
#define BUFFER (1 << 18)
#define STREAMS (1 << 20) /* that there ever were: what each encoded last */

struct viewer {
    struct pel_live_viewer *live; /* NULL: nobody */
    int fd, far;                  /* the server's end, ours */
    unsigned credit;
    bool video, closed, ended;
    uint64_t shown, acked; /* numbers of pictures */
    uint64_t failed;       /* before the last one */
    unsigned unacked;
    uint32_t serial, missed;
    unsigned long pictures;
    uint8_t *in;
    size_t in_size;
};

/* What a picture carries: whether it can be shown after the one before. */
struct mark {
    uint32_t serial;
    bool key;
    uint64_t number, previous; /* of the same stream */
    uint64_t failed;           /* before this one */
};

/* A picture that is drawn, and not yet delivered. */
struct due {
    uint32_t serial;
    uint64_t number;
    bool key;
    struct pel_job *job;
};

static struct pel_scene *scene;
static struct pel_frames *frames;
static struct pel_live_stats stats;
static struct viewer viewers[VIEWERS];
static struct due due[PEL_JOBS_FIRST];
static size_t due_count;
static uint64_t number, encoded[STREAMS];
static uint64_t failed; /* pictures that could not be drawn */
static unsigned long taken, keys, gaps, ends, refused;

static void on_closed(void *user)
{
    struct viewer *v = user;
    pel_live_viewer_destroy(v->live);
    v->live = NULL;
    close(v->fd);
    ends++;
}

static void come_to_rest(void)
{
    int turns = 0;
    while (g_main_context_iteration(NULL, FALSE)) {
        assert_true(++turns < 10000);
    }
}

/* --- renderer and encoder ------------------------------------------------- */

/* One frame: a picture of each stream that is due one. */
static void draw(void)
{
    struct pel_job *job = NULL;
    number++;
    for (int i = 0; i < PEL_MAX_STREAMS && due_count < PEL_JOBS_FIRST; i++) {
        struct pel_stream *stream = &frames->streams[i];
        struct pel_output want;
        if (!stream->serial || !pel_live_output(frames, stream, &want)) {
            continue;
        }
        for (int k = 0; k < PEL_JOBS_FIRST; k++) {
            job = frames->jobs[k].used ? job : &frames->jobs[k];
        }
        assert_non_null(job);
        job->used = true;
        job->output_count = 1;
        job->outputs[0].stream = stream->serial;
        job->outputs[0].delivered = false;
        assert_true(stream->serial < STREAMS);
        bool key = !want.track || want.want_key || !encoded[stream->serial];
        pel_live_began(stream, key && want.track);
        due[due_count++] = (struct due){ stream->serial, number, key, job };
    }
}

/* The oldest one, encoded or not. */
static void deliver(void)
{
    if (due_count == 0) {
        return;
    }
    struct due d = due[0];
    memmove(due, due + 1, --due_count * sizeof d);
    d.job->used = false;
    bool fails = below(60) == 0;
    struct mark mark = { d.serial, d.key, d.number, encoded[d.serial], failed };
    struct pel_frame *frame =
        walk_picture(sizeof mark + (below(20) ? below(400) : below(40000)), 7);
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        const struct pel_stream *s = &frames->streams[i];
        frame->codec = s->serial == d.serial ? s->profile.codec : frame->codec;
    }
    memcpy((uint8_t *)frame->data, &mark, sizeof mark);
    frame->number = d.number;
    frame->key = d.key;
    frame->width = frame->drawn_width = 640;
    frame->height = frame->drawn_height = 480;
    frame->requested_ns = walk.now_ns - 1000000;
    if (!fails) {
        encoded[d.serial] = d.number;
    }
    failed += fails;
    pel_live_deliver(frames, d.serial, fails ? PEL_ERR_IO : PEL_OK, "",
                     fails ? NULL : frame);
    pel_frame_unref(frame);
}

static void say(struct viewer *v, uint8_t opcode, const uint8_t *data,
                size_t size)
{
    uint8_t frame[6 + 64] = { 0x80 | opcode, (uint8_t)(0x80 | size) };
    memcpy(frame + 6, data, size);
    ssize_t sent = send(v->far, frame, 6 + size, MSG_DONTWAIT | MSG_NOSIGNAL);
    (void)sent; /* whole, or the peer is gone */
}

/* --- what a viewer gets --------------------------------------------------- */

static uint64_t number_at(const uint8_t *at, size_t bytes)
{
    uint64_t value = 0;
    for (size_t i = 0; i < bytes; i++) {
        value |= (uint64_t)at[i] << (8 * i);
    }
    return value;
}

static void take_picture(struct viewer *v, const uint8_t *head, size_t size)
{
    struct mark mark;
    assert_true(size >= PEL_LIVE_HEADER + sizeof mark);
    memcpy(&mark, head + PEL_LIVE_HEADER, sizeof mark);
    uint64_t at = number_at(head + 8, 8), missed = number_at(head + 52, 4);
    bool key = head[2] & 1, gap = head[2] & 2;
    assert_int_equal(at, mark.number);
    assert_true(at > v->shown); /* in order, none twice */
    assert_true(missed >= v->missed);
    assert_int_equal(key, mark.key);
    bool next = mark.serial == v->serial && mark.previous == v->shown;
    assert_true(!v->video || key || next); /* it can be decoded */
    assert_true(gap || next || mark.serial != v->serial);
    if (missed > v->missed) {
        assert_true(gap);
        assert_true(v != &viewers[0] || mark.failed > v->failed);
    }
    v->failed = mark.failed;
    taken++;
    keys += key;
    gaps += gap;
    v->missed = (uint32_t)missed;
    v->shown = at;
    v->serial = mark.serial;
    v->pictures++;
    v->unacked++;
    assert_true(v->unacked <= v->credit); /* never more under way */
}

static void take_text(struct viewer *v, const char *text, size_t size)
{
    assert_true(size > 9 && memcmp(text, "{\"type\":\"", 9) == 0);
    v->ended = v->ended || memcmp(text + 9, "end", 3) == 0;
}

/* False: nothing had come. */
static bool read_some_of(struct viewer *v, size_t most)
{
    most = MIN(most, BUFFER - v->in_size);
    ssize_t n = recv(v->far, v->in + v->in_size, most, MSG_DONTWAIT);
    v->in_size += n > 0 ? (size_t)n : 0;
    size_t used = 0;
    while (v->in_size - used >= 2) {
        const uint8_t *at = v->in + used;
        size_t extra = at[1] < 126 ? 0 : at[1] == 126 ? 2 : 8, size = at[1];
        if (v->in_size - used < 2 + extra) {
            break;
        }
        size = extra ? 0 : size;
        for (size_t i = 0; i < extra; i++) {
            size = size << 8 | at[2 + i];
        }
        if (v->in_size - used < 2 + extra + size) {
            break;
        }
        assert_false(v->closed); /* nothing follows a goodbye */
        at += 2 + extra;
        switch (v->in[used] & 15) {
        case 1:
            take_text(v, (const char *)at, size);
            break;
        case 2:
            assert_false(v->ended);
            take_picture(v, at, size);
            break;
        case 8:
            v->closed = true;
            break;
        case 9:
            say(v, 10, at, size);
            break;
        default:
            break;
        }
        used += 2 + extra + size;
    }
    memmove(v->in, v->in + used, v->in_size - used);
    v->in_size -= used;
    return n > 0;
}

/* --- what a viewer says --------------------------------------------------- */

static void acknowledge(struct viewer *v, uint64_t upto)
{
    uint8_t data[PEL_LIVE_MESSAGE] = { PEL_LIVE_ACK };
    for (int i = 0; i < 8; i++) {
        data[8 + i] = (uint8_t)(upto >> (8 * i));
    }
    say(v, 2, data, sizeof data);
    if (upto >= v->shown) {
        v->unacked = 0;
    }
    v->acked = upto > v->acked ? upto : v->acked;
}

static void keep_up(struct viewer *v)
{
    while (read_some_of(v, BUFFER)) {
        come_to_rest();
    }
    if (v->unacked > 0) {
        acknowledge(v, v->shown);
    }
}

static void wish_for_profile(struct viewer *v)
{
    uint8_t data[PEL_LIVE_MESSAGE] = { PEL_LIVE_PROFILE };
    data[1] = (uint8_t)(below(3) * 40);
    unsigned kbps = below(3) * 1000, width = 16 * below(4);
    data[4] = (uint8_t)kbps;
    data[5] = (uint8_t)(kbps >> 8);
    data[8] = (uint8_t)width;
    data[10] = (uint8_t)width;
    say(v, 2, data, sizeof data);
}

static void say_something(struct viewer *v)
{
    uint8_t data[2 * PEL_LIVE_MESSAGE] = { 0 };
    switch (below(12)) {
    case 0:
        data[0] = PEL_LIVE_KEY;
        say(v, 2, data, PEL_LIVE_MESSAGE);
        break;
    case 1:
        data[0] = PEL_LIVE_TIME;
        say(v, 2, data, PEL_LIVE_MESSAGE);
        break;
    case 2:
        say(v, 9, data, below(20)); /* ping */
        break;
    case 3:
        wish_for_profile(v);
        break;
    case 4: /* what was not sent yet cannot be acknowledged in advance */
        acknowledge(v, v->shown);
        break;
    case 5: /* old news */
        data[0] = PEL_LIVE_ACK;
        say(v, 2, data, PEL_LIVE_MESSAGE);
        break;
    case 6:
        if (below(20) == 0) {
            data[0] = (uint8_t)below(256);
            say(v, 2, data, below(32));
        }
        break;
    default:
        break;
    }
}

static void come(struct viewer *v, bool good)
{
    int pair[2], small = 8192;
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, pair),
                     0);
    uint8_t *in = v->in;
    *v = (struct viewer){ .fd = pair[0], .far = pair[1], .in = in };
    struct pel_live_wish wish = { .view = "bow" };
    if (!good && below(12) == 0) {
        snprintf(wish.view, sizeof wish.view, "none");
    }
    v->video = good || below(2);
    v->credit = wish.credit = good ? 8 : 1 + below(5);
    wish.profile.codec = v->video ? PEL_CODEC_H264 : PEL_CODEC_PICTURE;
    wish.profile.kbps = v->video && !good ? below(2) * 2000 : 0;
    wish.profile.quality = v->video ? 0 : 80;
    struct pel_fault fault;
    /* What came with the handshake: a wish, perhaps a goodbye, and more. */
    static const char early[] = "\x82\x90\0\0\0\0\2\0\0\0\0\0\0\0\0\0\0\0"
                                "\0\0\0\0\x88\x80\0\0\0\0\x82\x90\0\0";
    size_t early_size = good || below(4) ? 0 : below(sizeof early);
    v->live = pel_live_viewer_create(frames, &wish, pair[0], early, early_size,
                                     &stats, on_closed, v, &fault);
    assert_non_null(v->live);
    setsockopt(pair[0], SOL_SOCKET, SO_SNDBUF, &small, sizeof small);
    refused += strcmp(wish.view, "none") == 0;
}

static void go(struct viewer *v)
{
    close(v->far);
    v->far = -1;
}

/* --- what always holds ---------------------------------------------------- */

static void look(void)
{
    unsigned running = 0, open = 0, viewing = 0;
    for (const struct pel_subscription *s = frames->subscriptions; s;
         s = s->next) {
        assert_false(s->dead);
        if (s->stream) {
            open++;
            running += s->flow != PEL_FLOW_PAUSED;
        }
    }
    assert_int_equal(open, frames->subscription_count);
    assert_int_equal(running, frames->running_count);
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        const struct pel_stream *stream = &frames->streams[i];
        unsigned subscribers = 0, paused = 0;
        for (const struct pel_subscription *s = frames->subscriptions;
             stream->serial && s; s = s->next) {
            subscribers += s->stream == stream;
            paused += s->stream == stream && s->flow == PEL_FLOW_PAUSED;
        }
        assert_int_equal(subscribers, stream->subscribers);
        assert_int_equal(paused, stream->paused);
        assert_true(!stream->serial || subscribers > 0);
    }
    for (int i = 0; i < VIEWERS; i++) {
        viewing += viewers[i].live != NULL;
    }
    assert_int_equal(viewing, stats.viewers);
}

/* The first viewer asks for nothing and keeps up: it misses nothing. */
static void look_at_the_good_one(void)
{
    const struct viewer *v = &viewers[0];
    assert_non_null(v->live);
    if (v->pictures > 0) {
        assert_int_equal(v->shown, encoded[v->serial]);
    }
}

/* --- the walk ------------------------------------------------------------- */

static void change_view(void)
{
    struct pel_fault fault;
    (void)patch(scene, "{\"views\":{\"bow\":{\"width\":64}}}", &fault);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    pel_live_check(frames, s);
    pel_snapshot_unref(s);
}

static void step(void)
{
    struct viewer *v = &viewers[1 + below(VIEWERS - 1)];
    unsigned what = below(100);
    if (what < 8) {
        walk_wait(below(20) ? 0.02 : below(10) ? 0.6 : 3);
    } else if (what < 30) {
        draw();
    } else if (what < 52) {
        deliver();
    } else if (!v->live) {
        if (v->far >= 0) {
            go(v);
        }
        come(v, false);
    } else if (v->far >= 0) {
        if (what < 70) {
            (void)read_some_of(v, below(3) ? BUFFER : 1 + below(500));
        } else if (what < 84) {
            if (v->shown) { /* all of it, or older ones only */
                acknowledge(v, v->shown);
            }
        } else if (what < 98) {
            say_something(v);
        } else if (what == 98) {
            if (below(8) == 0) {
                go(v);
            }
        } else if (below(20) == 0) {
            change_view();
        }
    }
}

static void step_and_look(void)
{
    step();
    come_to_rest();
    keep_up(&viewers[0]);
    come_to_rest();
    look();
    look_at_the_good_one();
}

/* Everybody reads and acknowledges: everybody has pictures again. */
static void all_recover(void)
{
    unsigned long before[VIEWERS];
    for (int i = 0; i < VIEWERS; i++) {
        before[i] = viewers[i].pictures;
    }
    for (int turn = 0; turn < 400; turn++) {
        walk_wait(0.05);
        draw();
        while (due_count > 0) {
            deliver();
        }
        for (int i = 0; i < VIEWERS; i++) {
            if (viewers[i].live && viewers[i].far >= 0) {
                come_to_rest();
                keep_up(&viewers[i]);
            }
        }
        come_to_rest();
        look();
    }
    for (int i = 0; i < VIEWERS; i++) {
        if (viewers[i].live && viewers[i].far >= 0) {
            assert_true(viewers[i].pictures > before[i] + 10);
        }
    }
}

static void credit_of_viewers(void **state)
{
    (void)state;
    walk_seed();
    walk_stop_clock();
    pel_log_set_level(PEL_LOG_ERROR);
    scene = make_scene((struct pel_scene_options){ .wave_count = 20 });
    must(scene, "{\"views\":{\"bow\":{\"width\":64,\"height\":48}}}");
    frames = walk_frames(scene);
    for (int i = 0; i < VIEWERS; i++) {
        viewers[i] = (struct viewer){ .far = -1, .in = malloc(BUFFER) };
    }
    come(&viewers[0], true);
    unsigned long steps = walk_steps(20000);
    for (unsigned long i = 0; i < steps; i++) {
        step_and_look();
        if (i % 50000 == 9999) {
            all_recover();
        }
    }
    print_message("%lu pictures taken, %lu of them keys, %lu after a gap; %llu "
                  "times starved; %lu viewers gone, %lu refused\n",
                  taken, keys, gaps, (unsigned long long)stats.starved, ends,
                  refused);
    assert_true(taken > steps / 10 && stats.starved > steps / 200);
    for (int i = 0; i < VIEWERS; i++) {
        if (viewers[i].live) {
            pel_live_viewer_destroy(viewers[i].live);
            close(viewers[i].fd);
        }
        if (viewers[i].far >= 0) {
            close(viewers[i].far);
        }
        free(viewers[i].in);
    }
    assert_int_equal(frames->subscription_count, 0);
    walk_start_clock();
    assert_true(walk_frames_end(frames));
    pel_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(credit_of_viewers) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
