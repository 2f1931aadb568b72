/* A scene, its frames and who asks for them, for the tests of this room, with
 * the real renderer on the software device. One user a program. */
#pragma once

#include <glib.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "frames/frames.h"
#include "scene/scene_testkit.h"

static struct pel_scene *scene;
static struct pel_frames *frames;

struct answer {
    int calls, frame_count;
    enum pel_err err;
    struct pel_fault fault;
    struct pel_frame *frame; /* the last one */
    uint64_t numbers[64];
    double times[64];
};

static inline void take(void *user, enum pel_err err,
                        const struct pel_fault *fault, struct pel_frame *frame)
{
    struct answer *answer = user;
    answer->err = err;
    answer->calls++;
    if (fault) {
        answer->fault = *fault;
    }
    if (frame) {
        pel_frame_unref(answer->frame);
        answer->frame = pel_frame_ref(frame);
        answer->numbers[answer->frame_count % 64] = frame->number;
        answer->times[answer->frame_count % 64] = frame->time_s;
        answer->frame_count++;
    }
}

static inline void drop(struct answer *answer)
{
    pel_frame_unref(answer->frame);
    *answer = (struct answer){ 0 };
}

static inline gboolean nudge(gpointer user)
{
    (void)user;
    return G_SOURCE_CONTINUE;
}

/* Runs the main loop until *count reaches `wanted`, at most 60 s: the software
 * device under a sanitizer and beside other programs is slow. */
static inline void run_until(const int *count, int wanted)
{
    int64_t end = pel_now_ns() + 60000000000LL;
    guint timer = g_timeout_add(50, nudge, NULL);
    while (*count < wanted && pel_now_ns() < end) {
        g_main_context_iteration(NULL, TRUE);
    }
    g_source_remove(timer);
    assert_true(*count >= wanted);
}

static inline void run_for(int ms)
{
    int64_t end = pel_now_ns() + ms * 1000000LL;
    guint timer = g_timeout_add(5, nudge, NULL);
    while (pel_now_ns() < end) {
        g_main_context_iteration(NULL, TRUE);
    }
    g_source_remove(timer);
}

/* Until nothing was drawn for a while: what is under way ends late on a busy
 * machine, and counts come with a mail of their own. */
static inline void run_until_still(void)
{
    struct pel_frames_stats before, after;
    int64_t end = pel_now_ns() + 60000000000LL;
    pel_frames_get_stats(frames, &after);
    do {
        before = after;
        run_for(200);
        pel_frames_get_stats(frames, &after);
    } while ((after.views_drawn != before.views_drawn ||
              after.frames_drawn != before.frames_drawn ||
              after.pictures_encoded != before.pictures_encoded) &&
             pel_now_ns() < end);
}

static inline void patch_state(Pelagos__State *state)
{
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    struct pel_fault fault;
    patch.state = state;
    if (pel_scene_patch(scene, &patch, &fault) != PEL_OK) {
        fail_msg("%s: %s", fault.path, fault.message);
    }
}

static inline void set_clock(Pelagos__ClockMode mode, double time_s)
{
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Clock clock = PELAGOS__CLOCK__INIT;
    clock.has_mode = clock.has_time = true;
    clock.mode = mode;
    clock.time = time_s;
    state.clock = &clock;
    patch_state(&state);
}

static inline void add_view(const char *name, uint32_t width, uint32_t height)
{
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__View view = PELAGOS__VIEW__INIT, *views[] = { &view };
    view.name = (char *)name;
    view.has_width = view.has_height = true;
    view.width = width;
    view.height = height;
    state.n_views = 1;
    state.views = views;
    patch_state(&state);
}

static inline void remove_path(const char *path)
{
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    char *paths[] = { (char *)path };
    patch.n_remove = 1;
    patch.remove = paths;
    assert_int_equal(pel_scene_patch(scene, &patch, NULL), PEL_OK);
}

static inline Pelagos__FrameRequest small(Pelagos__FrameFormat format)
{
    Pelagos__FrameRequest request = PELAGOS__FRAME_REQUEST__INIT;
    request.view = (char *)"test";
    request.has_format = true;
    request.format = format;
    return request;
}

static inline void ask(const Pelagos__FrameRequest *request,
                       struct answer *answer)
{
    struct pel_fault fault;
    if (pel_frames_request(frames, request, take, answer, NULL, &fault) !=
        PEL_OK) {
        fail_msg("%s", fault.message);
    }
}

static inline enum pel_err create_frames(const char *device)
{
    struct pel_frames_options options = { .device = device, .max_fps = 60 };
    struct pel_fault fault;
    return pel_frames_create(&options, scene, &frames, &fault);
}

static inline int set_up(void **state)
{
    (void)state;
    pel_log_set_level(PEL_LOG_WARNING);
    scene = make_scene((struct pel_scene_options){ .wave_count = 60 });
    assert_int_equal(create_frames("software"), PEL_OK);
    add_view("test", 64, 48);
    set_clock(PELAGOS__CLOCK_MODE__STEPPED, 10);
    return 0;
}

static inline int tear_down(void **state)
{
    (void)state;
    bool joined = pel_frames_destroy(frames);
    pel_scene_destroy(scene);
    return joined ? 0 : -1;
}
