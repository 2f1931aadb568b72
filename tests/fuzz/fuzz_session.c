/* Protobuf sessions over real sockets, with a scene of their own: four clients
 * that connect, send bytes as they are or requests behind a right length, read
 * or do not, stop sending, leave; pictures that come or fail; time. */
#include <sys/socket.h>

#include "fuzz_steps.h"
#include "net/session_parts.h"
#include "net/walkframes_testkit.h"
#include "wire.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { OPEN, RAW, REQUEST, READ, SHUT, CLOSE, ANSWER, WAIT, CHANGED, STEPS };
#define CLIENTS 4

static struct pel_frames *frames;
static struct pel_sessions *all;
static struct pel_net_limits limits;
static int clients[CLIENTS];

static void connect_client(int *client, bool tcp)
{
    int pair[2], small = 4096;
    if (*client >= 0 ||
        socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, pair) < 0) {
        return;
    }
    setsockopt(pair[1], SOL_SOCKET, SO_SNDBUF, &small, sizeof small);
    *client = pair[0];
    if (!pel_sessions_accept(all, pair[1],
                             tcp ? PEL_TRANSPORT_TCP : PEL_TRANSPORT_UNIX)) {
        close(pair[1]);
    }
}

static void send_bytes(int client, const uint8_t *bytes, size_t size)
{
    ssize_t sent = send(client, bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    (void)sent; /* or the session has ended */
}

static void answer_one(bool fails, size_t size)
{
    for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
        struct pel_frame_request *r = &frames->requests[i];
        struct pel_fault fault;
        if (r->used && !r->set) {
            struct pel_frame *picture = walk_picture(size, 7);
            pel_fault_set(&fault, PEL_ERR_IO, "no picture");
            pel_request_finish(frames, r, fails ? PEL_ERR_IO : PEL_OK,
                               fails ? &fault : NULL, picture);
            pel_frame_unref(picture);
            return;
        }
    }
}

static void take(const struct fuzz_step *s)
{
    static uint8_t waste[1 << 16];
    int *client = &clients[s->what / STEPS % CLIENTS];
    uint8_t prefix[PEL_WIRE_MAX_PREFIX];
    unsigned what = s->what % STEPS;
    if (what == OPEN) {
        connect_client(client, s->size % 2);
    } else if (what == ANSWER) {
        answer_one(fuzz_byte(s, 0) % 4 == 0, 100 * (size_t)fuzz_byte(s, 1));
    } else if (what == WAIT) {
        fuzz_wait(s);
    } else if (what == CHANGED) {
        pel_sessions_changed(all);
    } else if (*client < 0) {
        return;
    } else if (what == RAW) {
        send_bytes(*client, s->data, s->size);
    } else if (what == REQUEST) {
        send_bytes(*client, prefix, pel_wire_prefix(s->size, prefix));
        send_bytes(*client, s->data, s->size);
    } else if (what == READ) {
        ssize_t n = recv(*client, waste, sizeof waste, MSG_DONTWAIT);
        (void)n;
    } else if (what == SHUT) {
        shutdown(*client, SHUT_WR);
    } else {
        close(*client);
        *client = -1;
    }
}

static void look(void)
{
    unsigned pictures = 0, waiting = 0;
    for (guint i = 0; i < all->list->len; i++) {
        const struct session *s = g_ptr_array_index(all->list, i);
        /* A patch, or the like, is one more: nothing is taken meanwhile. */
        fuzz_demand(s->jobs->len <= limits.session_requests + 1);
        fuzz_demand(s->in_size <=
                    limits.session_message_bytes + PEL_WIRE_MAX_PREFIX);
        fuzz_demand(!s->closing || s->jobs->len == 0);
        fuzz_demand(s->out.bytes == 0 ||
                    (double)(walk.now_ns - s->progress_ns) <=
                        limits.session_stall_s * 1e9 + 5e6);
        for (guint k = 0; k < s->jobs->len; k++) {
            const struct job *job = g_ptr_array_index(s->jobs, k);
            pictures += job->is_picture;
        }
    }
    for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
        waiting += frames->requests[i].used && !frames->requests[i].set;
    }
    fuzz_demand(all->list->len <= CLIENTS + 2u && waiting <= pictures);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_steps steps = { data, data + size };
    struct fuzz_step step;
    struct pel_scene *scene = fuzz_world();
    frames = walk_frames(scene);
    /* Nobody computes here: these are refused, as by a busy daemon. */
    frames->surface_count = PEL_MAX_SURFACE_QUERIES;
    frames->optics_count = PEL_MAX_OPTICS_QUERIES;
    pel_net_limits_default(&limits);
    limits.sessions = 3;
    limits.session_requests = 2;
    all = pel_sessions_create(&limits, scene, frames, NULL, NULL);
    for (int i = 0; i < CLIENTS; i++) {
        clients[i] = -1;
    }
    for (int i = 0; i < 64 && fuzz_next(&steps, &step); i++) {
        take(&step);
        fuzz_rest();
        pel_scene_settle(scene);
        fuzz_rest();
        look();
    }
    pel_sessions_destroy(all);
    for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
        fuzz_demand(!frames->requests[i].used);
    }
    for (int i = 0; i < CLIENTS; i++) {
        if (clients[i] >= 0) {
            close(clients[i]);
        }
    }
    walk_start_clock();
    walk_frames_end(frames);
    pel_scene_destroy(scene);
    return 0;
}
