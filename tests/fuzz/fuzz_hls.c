/* HLS: playlists and files that are asked for, by names as the playlists have
 * them or as anybody may write them, pictures, time, views that go. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "fuzz_steps.h"
#include "net/hls.h"
#include "net/walkframes_testkit.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { LIST, FILE_OF, FILE_NAMED, PICTURE, WAIT, FORGET, GONE, STEPS };
#define ASKERS 8

static struct pel_frames *frames;
static struct pel_hls *hls;
static struct asker {
    bool waits, named;
} askers[ASKERS];
static char names[64][40]; /* of files that playlists had, the last ones */
static size_t name_count;

/* Every line and every URI="" that leads to a file. */
static void read_playlist(const char *text)
{
    static const char start[] = "../../hls/";
    for (const char *at = text; (at = strstr(at, start)); at++) {
        at += sizeof start - 1;
        snprintf(names[name_count++ % 64], sizeof *names, "%.*s",
                 (int)strcspn(at, "\"\n"), at);
    }
}

static void on_done(void *user, enum pel_err err, const struct pel_fault *fault,
                    const struct pel_hls_answer *answer)
{
    struct asker *a = user;
    fuzz_demand(a->waits); /* once */
    a->waits = false;
    fuzz_demand(err ? fault->message[0] && !answer
                    : answer->size > 0 && answer->type && answer->cache);
    if (!err && !a->named) {
        char *text = g_strndup(answer->data, answer->size);
        fuzz_demand(g_str_has_prefix(text, "#EXTM3U"));
        read_playlist(text);
        g_free(text);
    }
}

static struct asker *new_asker(bool named)
{
    for (int i = 0; i < ASKERS; i++) {
        if (!askers[i].waits) {
            askers[i] = (struct asker){ true, named };
            return &askers[i];
        }
    }
    return NULL;
}

static void ask_list(const struct fuzz_step *s)
{
    struct asker *a = new_asker(false);
    struct pel_hls_wish wish = { .msn = -1, .part = -1 };
    snprintf(wish.view, sizeof wish.view, "%s",
             fuzz_byte(s, 0) & 1 ? "none" : "bridge");
    wish.profile.width = fuzz_byte(s, 0) & 2 ? 64 : 0;
    wish.profile.height = fuzz_byte(s, 0) & 2 ? 48 : 0;
    if (s->size > 1) {
        wish.msn = fuzz_byte(s, 1);
        wish.part = s->size > 2 ? fuzz_byte(s, 2) : -1;
    }
    if (a) {
        pel_hls_playlist(hls, &wish, on_done, a);
    }
}

static void ask_file(const struct fuzz_step *s, bool known)
{
    struct asker *a = new_asker(true);
    if (a && known && name_count > 0) {
        size_t most = name_count < 64 ? name_count : 64;
        pel_hls_file(hls, names[fuzz_byte(s, 0) % most], on_done, a);
    } else if (a) {
        char *name = g_strndup((const char *)s->data, s->size);
        pel_hls_file(hls, name, on_done, a);
        g_free(name);
    }
}

/* Of every stream; how much later than the last. */
static void give_pictures(const struct fuzz_step *s)
{
    static uint64_t number;
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        struct pel_stream *stream = &frames->streams[i];
        struct pel_output want;
        if (!stream->serial || !pel_live_output(frames, stream, &want)) {
            continue;
        }
        uint32_t serial = stream->serial;
        struct pel_frame *frame =
            walk_picture(1 + 30 * (size_t)fuzz_byte(s, 1), 7);
        bool fails = fuzz_byte(s, 0) % 8 == 7;
        frame->number = ++number;
        frame->codec = stream->profile.codec;
        frame->key = want.want_key || fuzz_byte(s, 0) % 8 == 6;
        frame->width = frame->drawn_width = 64;
        frame->height = frame->drawn_height = 48;
        frame->requested_ns = walk.now_ns;
        pel_live_began(stream, want.want_key);
        pel_live_deliver(frames, serial, fails ? PEL_ERR_IO : PEL_OK, "",
                         fails ? NULL : frame);
        pel_frame_unref(frame);
    }
}

static void take(const struct fuzz_step *s)
{
    struct asker *a = &askers[fuzz_byte(s, 0) % ASKERS];
    switch (s->what % STEPS) {
    case LIST:
        ask_list(s);
        break;
    case FILE_OF:
    case FILE_NAMED:
        ask_file(s, s->what % STEPS == FILE_OF);
        break;
    case PICTURE:
        walk.now_ns += 20000000LL * (1 + fuzz_byte(s, 2));
        give_pictures(s);
        break;
    case WAIT:
        fuzz_wait(s);
        break;
    case FORGET:
        fuzz_demand(pel_hls_forget(hls, a) == a->waits);
        a->waits = false;
        break;
    default:
        for (int i = 0; i < PEL_MAX_STREAMS; i++) {
            if (frames->streams[i].serial && fuzz_byte(s, 0) % 2) {
                pel_live_deliver(frames, frames->streams[i].serial,
                                 PEL_ERR_NOT_FOUND, "the view is gone", NULL);
            }
        }
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct pel_scene *scene; /* nothing here edits it */
    struct fuzz_steps steps = { data, data + size };
    struct fuzz_step step;
    if (!scene) {
        scene = fuzz_world();
    }
    g_random_set_seed(7); /* streams have random numbers */
    walk.stands = true;
    walk.now_ns = 1000000000000;
    frames = walk_frames(scene);
    hls = pel_hls_create(frames);
    memset(askers, 0, sizeof askers);
    name_count = 0;
    for (int i = 0; i < 160 && fuzz_next(&steps, &step); i++) {
        take(&step);
        fuzz_rest();
    }
    pel_hls_destroy(hls);
    for (int i = 0; i < ASKERS; i++) {
        fuzz_demand(!askers[i].waits); /* everybody was told */
    }
    walk_start_clock();
    walk_frames_end(frames);
    return 0;
}
