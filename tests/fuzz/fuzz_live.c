/* Live viewers over real WebSockets: three of them, whose bytes come as they
 * are or as whole messages, with the handshake or after it, who read or do not,
 * and leave; pictures; time. */
#include <string.h>
#include <sys/socket.h>

#include "fuzz_steps.h"
#include "net/liveviewer.h"
#include "net/walkframes_testkit.h"
#include "net/websocket.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { OPEN, RAW, MESSAGE, READ, CLOSE, PICTURE, WAIT, STEPS };
#define VIEWERS 3

struct viewer {
    struct pel_live_viewer *live; /* NULL: gone */
    int fd, far;
};

static struct pel_frames *frames;
static struct pel_live_stats stats;
static struct viewer viewers[VIEWERS];

static void on_closed(void *user)
{
    struct viewer *v = user;
    pel_live_viewer_destroy(v->live);
    v->live = NULL;
    close(v->fd);
}

static void connect_viewer(struct viewer *v, const struct fuzz_step *s)
{
    int pair[2], small = 4096;
    struct pel_live_wish wish = { .view = "bridge" };
    if (v->live ||
        socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, pair) < 0) {
        return;
    }
    if (v->far >= 0) {
        close(v->far);
    }
    v->fd = pair[0];
    v->far = pair[1];
    setsockopt(v->fd, SOL_SOCKET, SO_SNDBUF, &small, sizeof small);
    wish.credit = 1 + fuzz_byte(s, 0) % PEL_WEBSOCKET_MAX_PICTURES;
    wish.profile.codec =
        fuzz_byte(s, 0) & 64 ? PEL_CODEC_H264 : PEL_CODEC_PICTURE;
    wish.profile.quality = wish.profile.codec == PEL_CODEC_PICTURE ? 80 : 0;
    size_t early = s->size > 1 ? s->size - 1 : 0;
    v->live = pel_live_viewer_create(frames, &wish, v->fd,
                                     (const char *)s->data + (early > 0), early,
                                     &stats, on_closed, v, NULL);
    fuzz_demand(v->live != NULL);
}

/* Of every stream that wants one. */
static void give_pictures(const struct fuzz_step *s)
{
    static uint64_t number;
    number++;
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        struct pel_stream *stream = &frames->streams[i];
        struct pel_output want;
        if (!stream->serial || !pel_live_output(frames, stream, &want)) {
            continue;
        }
        uint32_t serial = stream->serial;
        struct pel_frame *frame = walk_picture(30 * (size_t)fuzz_byte(s, 1), 7);
        bool fails = fuzz_byte(s, 0) % 8 == 7;
        frame->number = number;
        frame->codec = stream->profile.codec;
        frame->key = !want.track || want.want_key;
        frame->width = frame->drawn_width = 64;
        frame->height = frame->drawn_height = 16u + fuzz_byte(s, 2);
        pel_live_began(stream, want.want_key);
        pel_live_deliver(frames, serial, fails ? PEL_ERR_IO : PEL_OK, "",
                         fails ? NULL : frame);
        pel_frame_unref(frame);
    }
}

static void say(int far, const void *data, size_t size)
{
    ssize_t sent = send(far, data, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    (void)sent; /* or the viewer is gone */
}

static void take(const struct fuzz_step *s)
{
    static uint8_t waste[1 << 16];
    struct viewer *v = &viewers[s->what / STEPS % VIEWERS];
    uint8_t head[6] = { 0x82, (uint8_t)(0x80 | (s->size % 126)) };
    switch (s->what % STEPS) {
    case OPEN:
        connect_viewer(v, s);
        break;
    case RAW:
        say(v->far, s->data, s->size);
        break;
    case MESSAGE:
        say(v->far, head, sizeof head);
        say(v->far, s->data, s->size % 126);
        break;
    case READ: {
        ssize_t n = recv(v->far, waste, sizeof waste, MSG_DONTWAIT);
        (void)n;
        break;
    }
    case CLOSE:
        if (v->far >= 0) {
            close(v->far);
            v->far = -1;
        }
        break;
    case PICTURE:
        give_pictures(s);
        break;
    default:
        fuzz_wait(s);
        break;
    }
}

static void look(void)
{
    unsigned open = 0, running = 0, viewing = 0;
    for (const struct pel_subscription *s = frames->subscriptions; s;
         s = s->next) {
        open += s->stream != NULL;
        running += s->stream && s->flow != PEL_FLOW_PAUSED;
    }
    for (int i = 0; i < VIEWERS; i++) {
        viewing += viewers[i].live != NULL;
    }
    fuzz_demand(open == frames->subscription_count &&
                running == frames->running_count && viewing == stats.viewers);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct pel_scene *scene; /* nothing here edits it */
    struct fuzz_steps steps = { data, data + size };
    struct fuzz_step step;
    if (!scene) {
        scene = fuzz_world();
    }
    walk.stands = true;
    walk.now_ns = 1000000000000;
    frames = walk_frames(scene);
    stats = (struct pel_live_stats){ 0 };
    for (int i = 0; i < VIEWERS; i++) {
        viewers[i] = (struct viewer){ .fd = -1, .far = -1 };
    }
    for (int i = 0; i < 64 && fuzz_next(&steps, &step); i++) {
        take(&step);
        fuzz_rest();
        look();
    }
    for (int i = 0; i < VIEWERS; i++) {
        if (viewers[i].live) {
            on_closed(&viewers[i]);
        }
        if (viewers[i].far >= 0) {
            close(viewers[i].far);
        }
    }
    fuzz_demand(frames->subscription_count == 0);
    walk_start_clock();
    walk_frames_end(frames);
    return 0;
}
