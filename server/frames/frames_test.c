/* Pictures that are asked for one by one, and the surface. */
#include "encode/encode.h"
#include "frames/core.h"
#include "frames/frames_testkit.h"
#include "proto/formats.h"

/* --- one picture
 * --------------------------------------------------------------- */

static void every_format_is_answered(void **state)
{
    (void)state;
    static const char *const magic[PEL_FORMATS] = {
        [PEL_FORMAT_AT_JPEG] = "\xff\xd8\xff",
        [PEL_FORMAT_AT_PNG] = "\x89PNG",
        [PEL_FORMAT_AT_EXR] = "\x76\x2f\x31\x01",
        [PEL_FORMAT_AT_JSON] = "{\"view\":",
    };
    for (int i = 0; i < PEL_FORMATS; i++) {
        struct answer answer = { 0 };
        Pelagos__FrameRequest request = small(pel_format_table[i].format);
        ask(&request, &answer);
        assert_int_equal(answer.calls, 0);
        run_until(&answer.calls, 1);
        assert_int_equal(answer.err, PEL_OK);
        assert_int_equal(answer.frame->width, 64);
        assert_int_equal(answer.frame->height, 48);
        assert_int_equal(answer.frame->format, pel_format_table[i].format);
        assert_string_equal(answer.frame->view, "test");
        assert_true(answer.frame->time_s == 10);
        assert_true(answer.frame->size >
                    (magic[i] && *magic[i] == '{' ? 50 : 100));
        if (magic[i]) {
            assert_memory_equal(answer.frame->data, magic[i], strlen(magic[i]));
        }
        drop(&answer);
    }
}

static void the_same_request_gives_the_same_bytes(void **state)
{
    (void)state;
    for (int i = 0; i < PEL_FORMATS; i++) {
        struct answer first = { 0 }, second = { 0 };
        Pelagos__FrameRequest request = small(pel_format_table[i].format);
        char *layers[] = { (char *)"radiance", (char *)"depth",
                           (char *)"normal" };
        if (pel_format_table[i].uses & PEL_FORMAT_LAYERS) {
            request.n_layers = 3;
            request.layers = layers;
        }
        ask(&request, &first);
        run_until(&first.calls, 1);
        ask(&request, &second);
        run_until(&second.calls, 1);
        /* Of one moment, so of one frame. */
        assert_int_equal(first.frame->number, second.frame->number);
        assert_int_equal(first.frame->size, second.frame->size);
        assert_memory_equal(first.frame->data, second.frame->data,
                            first.frame->size);
        drop(&first);
        drop(&second);
    }
}

static void own_size_and_time_are_drawn(void **state)
{
    (void)state;
    struct answer answer = { 0 }, plain = { 0 };
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__PNG);
    ask(&request, &plain);
    request.has_width = request.has_time = true;
    request.width = 33;
    request.time = 1234.5;
    ask(&request, &answer);
    run_until(&answer.calls, 1);
    run_until(&plain.calls, 1);
    assert_int_equal(answer.frame->width, 33);
    assert_int_equal(answer.frame->height, 48);
    assert_true(answer.frame->time_s == 1234.5);
    assert_true(plain.frame->time_s == 10);
    assert_int_not_equal(answer.frame->number, plain.frame->number);
    drop(&answer);
    drop(&plain);
}

static void requests_of_one_turn_share_a_frame(void **state)
{
    (void)state;
    struct answer a = { 0 }, b = { 0 }, c = { 0 }, d = { 0 }, e = { 0 };
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__JPEG);
    struct pel_frames_stats before, after;
    run_until_still(); /* the test before this one */
    pel_frames_get_stats(frames, &before);
    ask(&request, &a);
    ask(&request, &b);
    request.has_quality = true, request.quality = 20;
    ask(&request, &e);
    request.format = PELAGOS__FRAME_FORMAT__PNG;
    ask(&request, &c);
    request.quality = 90;
    ask(&request, &d);
    run_until(&a.calls, 1);
    run_until(&b.calls, 1);
    run_until(&c.calls, 1);
    run_until(&d.calls, 1);
    run_until(&e.calls, 1);
    run_until_still();
    pel_frames_get_stats(frames, &after);
    assert_int_equal(a.frame->number, b.frame->number);
    assert_int_equal(a.frame->number, c.frame->number);
    assert_ptr_equal(a.frame, b.frame); /* encoded once */
    assert_ptr_equal(c.frame, d.frame); /* PNG has no quality */
    assert_true(e.frame->size < a.frame->size);
    assert_int_equal(after.views_drawn - before.views_drawn, 1);
    assert_int_equal(after.pictures_encoded - before.pictures_encoded, 3);
    drop(&d);
    drop(&e);
    drop(&a);
    drop(&b);
    drop(&c);
}

static void each_gets_its_own_time_and_quality(void **state)
{
    (void)state;
    struct answer answers[4] = { 0 };
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__JPEG);
    request.has_time = request.has_quality = true;
    for (int i = 0; i < 4; i++) {
        request.time = i < 2 ? 50 : 51 + i;
        request.quality = i == 1 ? 20 : 95;
        ask(&request, &answers[i]);
    }
    for (int i = 0; i < 4; i++) {
        run_until(&answers[i].calls, 1);
        assert_true(answers[i].frame->time_s == (i < 2 ? 50 : 51 + i));
    }
    assert_int_equal(answers[0].frame->number, answers[1].frame->number);
    assert_int_not_equal(answers[0].frame->number, answers[2].frame->number);
    assert_true(answers[1].frame->size < answers[0].frame->size);
    for (int i = 0; i < 4; i++) {
        drop(&answers[i]);
    }
}

static void the_next_frame_shows_a_patch(void **state)
{
    (void)state;
    struct answer before = { 0 }, after = { 0 };
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__JPEG);
    ask(&request, &before);
    run_until(&before.calls, 1);
    Pelagos__State change = PELAGOS__STATE__INIT;
    Pelagos__Sky sky = PELAGOS__SKY__INIT;
    sky.has_visibility = true;
    sky.visibility = 500;
    change.sky = &sky;
    patch_state(&change);
    ask(&request, &after);
    run_until(&after.calls, 1);
    assert_int_equal(after.frame->revision, before.frame->revision + 1);
    drop(&before);
    drop(&after);
}

static void an_exr_says_how_it_came_about(void **state)
{
    (void)state;
    struct answer answer = { 0 };
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__EXR);
    ask(&request, &answer);
    run_until(&answer.calls, 1);
    GBytes *bytes = g_bytes_new_static(answer.frame->data, answer.frame->size);
    static const char *const names[] = {
        "pelagos.view",      "pelagos.time",     "pelagos.seed",
        "pelagos.exposure",  "pelagos.revision", "pelagos.sunAzimuth",
        "pelagos.windSpeed", "software",         "pelagos.device",
        "worldToCamera",     "worldToNDC",       "capDate"
    };
    for (size_t i = 0; i < G_N_ELEMENTS(names); i++) {
        /* With its final zero: a whole name of the header. */
        assert_non_null(memmem(answer.frame->data, answer.frame->size, names[i],
                               strlen(names[i]) + 1));
    }
    g_bytes_unref(bytes);
    drop(&answer);
}

static void what_cannot_be_is_refused_at_once(void **state)
{
    (void)state;
    struct pel_fault fault;
    struct answer answer = { 0 };
    struct pel_frames_stats before, after;
    char *layers[] = { (char *)"colour" };
    Pelagos__FrameRequest bad[8];
    static const struct {
        enum pel_err err;
        const char *path;
    } want[8] = {
        { PEL_ERR_NOT_FOUND, "view" },     { PEL_ERR_NOT_FOUND, "view" },
        { PEL_ERR_OUT_OF_RANGE, "width" }, { PEL_ERR_OUT_OF_RANGE, "height" },
        { PEL_ERR_OUT_OF_RANGE, "time" },  { PEL_ERR_OUT_OF_RANGE, "quality" },
        { PEL_ERR_INVALID, "layers" },     { PEL_ERR_INVALID, "layers" },
    };
    for (int i = 0; i < 8; i++) {
        bad[i] = small(PELAGOS__FRAME_FORMAT__EXR);
    }
    bad[0].view = (char *)"nowhere";
    bad[1].view = NULL;
    bad[2].has_width = true, bad[2].width = 15;
    bad[3].has_height = true, bad[3].height = 4097;
    bad[4].has_time = true, bad[4].time = NAN;
    bad[5].has_quality = true, bad[5].quality = 0;
    bad[6].n_layers = 1, bad[6].layers = layers;
    bad[7].n_layers = 1, bad[7].layers = (char *[]){ (char *)"depth" };
    bad[7].format = PELAGOS__FRAME_FORMAT__JPEG;
    pel_frames_get_stats(frames, &before);
    for (int i = 0; i < 8; i++) {
        assert_int_equal(
            pel_frames_request(frames, &bad[i], take, &answer, NULL, &fault),
            want[i].err);
        assert_string_equal(fault.path, want[i].path);
    }
    assert_string_equal(
        fault.message,
        "JPEG has no layers: set format to EXR or leave them out");
    pel_frames_get_stats(frames, &after);
    assert_int_equal(after.requests_refused - before.requests_refused, 8);
    run_for(50);
    assert_int_equal(answer.calls, 0);
}

static void waiting_requests_are_bounded(void **state)
{
    (void)state;
    struct answer answers[129] = { 0 };
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__JPEG);
    request.has_width = true;
    for (int i = 0; i < 128; i++) {
        request.width = 16 + (uint32_t)i % 32;
        ask(&request, &answers[i]);
    }
    struct pel_fault fault;
    assert_int_equal(
        pel_frames_request(frames, &request, take, &answers[128], NULL, &fault),
        PEL_ERR_BUSY);
    for (int i = 0; i < 128; i++) {
        run_until(&answers[i].calls, 1);
        assert_int_equal(answers[i].err, PEL_OK);
        drop(&answers[i]);
    }
    assert_int_equal(answers[128].calls, 0);
}

static void a_cancelled_request_is_silent(void **state)
{
    (void)state;
    struct answer gone = { 0 }, late = { 0 }, kept = { 0 };
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__JPEG);
    uint64_t id;
    assert_int_equal(
        pel_frames_request(frames, &request, take, &gone, &id, NULL), PEL_OK);
    pel_frames_cancel(frames, id);
    pel_frames_cancel(frames, id);
    assert_int_equal(
        pel_frames_request(frames, &request, take, &late, &id, NULL), PEL_OK);
    g_main_context_iteration(NULL, FALSE); /* it is being drawn now */
    pel_frames_cancel(frames, id);
    ask(&request, &kept);
    run_until(&kept.calls, 1);
    run_for(50);
    assert_int_equal(gone.calls, 0);
    assert_int_equal(late.calls, 0);
    drop(&kept);
    struct pel_frames_stats stats;
    pel_frames_get_stats(frames, &stats);
    assert_int_equal(stats.requests_waiting, 0);
}

/* Whoever asks for little after somebody who asks for much has it before him,
 * and live views go on. The bands are smaller then, and the bytes the same. */
static void a_large_picture_waits_for_others(void **state)
{
    (void)state;
    struct answer alone = { 0 }, among = { 0 }, little = { 0 }, live = { 0 };
    Pelagos__FrameRequest much = small(PELAGOS__FRAME_FORMAT__PNG);
    Pelagos__FrameRequest one = small(PELAGOS__FRAME_FORMAT__JPEG);
    struct pel_frames_stats before, after;
    struct pel_subscription *subscription;
    much.has_width = much.has_height = true;
    much.width = 1408;
    much.height = 1200;
    much.has_time = one.has_time = true;
    much.time = one.time = 7;
    ask(&much, &alone);
    run_until(&alone.calls, 1);
    pel_frames_get_stats(frames, &before);
    assert_int_equal(pel_frames_subscribe(frames, "test", 50, take, &live,
                                          &subscription, NULL),
                     PEL_OK);
    run_until(&live.calls, 3);
    ask(&much, &among);
    run_for(1);
    for (int i = 0; i < 5; i++) {
        ask(&one, &little);
    }
    int seen = live.calls;
    run_until(&little.calls, 5);
    assert_int_equal(among.calls, 0);
    run_until(&among.calls, 1);
    assert_true(live.calls > seen + 5);
    pel_frames_get_stats(frames, &after);
    assert_int_equal(after.large_drawn, before.large_drawn + 1);
    assert_non_null(alone.frame);
    assert_non_null(among.frame);
    assert_int_equal(alone.frame->size, among.frame->size);
    assert_memory_equal(alone.frame->data, among.frame->data,
                        alone.frame->size);
    pel_frames_unsubscribe(subscription);
    drop(&alone);
    drop(&among);
    drop(&little);
    drop(&live);
}

/* What nobody waits for is not drawn to its end: a picture, and a set. */
static void a_large_picture_is_dropped(void **state)
{
    (void)state;
    struct answer answer = { 0 };
    struct pel_frames_stats before, after;
    Pelagos__FrameRequest much = small(PELAGOS__FRAME_FORMAT__EXR);
    much.has_width = much.has_height = true;
    much.width = much.height = 3072;
    uint64_t id;
    run_until_still();
    pel_frames_get_stats(frames, &before);
    /* At once, then when it has been begun; on a busy machine that may not be
     * so yet, and then there is nothing to drop. */
    int64_t end = pel_now_ns() + 60000000000LL;
    after = before;
    for (int i = 0; after.pictures_dropped < before.pictures_dropped + 2 &&
                    pel_now_ns() < end;
         i++) {
        assert_int_equal(
            pel_frames_request(frames, &much, take, &answer, &id, NULL),
            PEL_OK);
        run_for(i > 0 ? 100 : 0);
        pel_frames_cancel(frames, id);
        run_until_still();
        pel_frames_get_stats(frames, &after);
    }
    assert_int_equal(after.views_drawn, before.views_drawn);
    assert_int_equal(after.pictures_encoded, before.pictures_encoded);
    assert_int_equal(after.pictures_dropped, before.pictures_dropped + 2);
    assert_int_equal(answer.calls, 0);
    /* And the next one is. */
    much.width = much.height = 1100;
    ask(&much, &answer);
    run_until(&answer.calls, 1);
    assert_int_equal(answer.err, PEL_OK);
    drop(&answer);
}

static void a_picture_has_a_set_s_memory(void **state)
{
    (void)state;
    struct answer answer = { 0 };
    struct pel_fault fault;
    Pelagos__FrameRequest all = small(PELAGOS__FRAME_FORMAT__EXR);
    char *layers[] = { "radiance", "sun", "sky", "water" };
    all.has_width = all.has_height = true;
    all.width = all.height = 4096;
    all.n_layers = 4;
    all.layers = layers;
    assert_int_equal(
        pel_frames_request(frames, &all, take, &answer, NULL, &fault),
        PEL_ERR_INVALID);
    assert_string_equal(fault.path, "layers");
    assert_non_null(strstr(fault.message, "MiB"));
}

static void a_view_deleted_before_its_frame(void **state)
{
    (void)state;
    struct answer answer = { 0 };
    add_view("soon_gone", 32, 32);
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__JPEG);
    request.view = (char *)"soon_gone";
    ask(&request, &answer);
    remove_path("views.soon_gone");
    run_until(&answer.calls, 1);
    assert_int_equal(answer.err, PEL_ERR_NOT_FOUND);
    assert_string_equal(answer.fault.path, "view");
}

/* --- the surface
 * ------------------------------------------------------------------- */

struct surface {
    int calls;
    enum pel_err err;
    double time_s;
    size_t count;
    struct pel_surface_sample samples[4];
};

static void take_surface(void *user, enum pel_err err,
                         const struct pel_fault *fault,
                         struct pel_surface_answer *answer)
{
    struct surface *surface = user;
    (void)fault;
    surface->calls++;
    surface->err = err;
    surface->time_s = answer ? answer->time_s : 0;
    surface->count = answer ? answer->count : 0;
    for (size_t i = 0; i < surface->count && i < 4; i++) {
        surface->samples[i] = answer->samples[i];
    }
}

static enum pel_err ask_surface(const struct pel_vec2 *points, size_t count,
                                bool has_time, double time_s,
                                struct surface *surface)
{
    const struct pel_surface_wish wish = { .points_m = points,
                                           .count = count,
                                           .has_time = has_time,
                                           .time_s = time_s };
    return pel_frames_surface(frames, &wish, take_surface, surface, NULL);
}

static void surface_queries_are_answered(void **state)
{
    (void)state;
    struct surface surface = { 0 };
    struct pel_vec2 points[3] = { { 0, 0 }, { 100, -50 }, { 1e6, -1e6 } };
    assert_int_equal(ask_surface(points, 3, true, 20, &surface), PEL_OK);
    points[0].x = 1e9; /* it has its own copy */
    run_until(&surface.calls, 1);
    assert_int_equal(surface.err, PEL_OK);
    assert_int_equal(surface.count, 3);
    assert_true(surface.time_s == 20);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    struct pel_surface_sample want;
    pel_sea_sample(pel_snapshot_sea(s), 100, -50, 20, &want);
    want.depth_m = s->water.depth_m;
    pel_snapshot_unref(s);
    assert_memory_equal(&want, &surface.samples[1], sizeof want);
    assert_int_equal(ask_surface(points, 1, false, 0, &surface),
                     PEL_ERR_OUT_OF_RANGE);
    points[0].x = NAN;
    assert_int_equal(ask_surface(points, 1, false, 0, &surface),
                     PEL_ERR_OUT_OF_RANGE);
    assert_int_equal(ask_surface(points, 10001, false, 0, &surface),
                     PEL_ERR_OUT_OF_RANGE);
    assert_int_equal(ask_surface(points, 0, true, -1, &surface),
                     PEL_ERR_OUT_OF_RANGE);
    for (int i = 0; i < 16; i++) {
        assert_int_equal(ask_surface(points, 0, false, 0, &surface), PEL_OK);
    }
    assert_int_equal(ask_surface(points, 0, false, 0, &surface), PEL_ERR_BUSY);
    run_until(&surface.calls, 17);
}

static void note_order(void *user, enum pel_err err,
                       const struct pel_fault *fault,
                       struct pel_surface_answer *answer)
{
    static int done;
    int *place = user;
    (void)fault;
    (void)answer;
    assert_int_equal(err, PEL_OK);
    *place = ++done;
}

/* Queries take turns: of eleven that come at once the one of one point is not
 * the last because it came last. */
static void few_points_do_not_wait_for_many(void **state)
{
    enum { MANY = 10, POINTS = 10000 };
    static struct pel_vec2 points[POINTS];
    int place[MANY + 1] = { 0 };
    struct pel_surface_wish wish = { .points_m = points, .count = POINTS };
    (void)state;
    for (size_t i = 0; i < POINTS; i++) {
        points[i] = (struct pel_vec2){ (double)i, 0.5 * (double)i };
    }
    for (int i = 0; i <= MANY; i++) {
        wish.count = i < MANY ? POINTS : 1;
        assert_int_equal(
            pel_frames_surface(frames, &wish, note_order, &place[i], NULL),
            PEL_OK);
    }
    for (int i = 0; i <= MANY; i++) {
        run_until(&place[i], 1);
    }
    assert_true(place[MANY] <= MANY);
}

static int64_t urgent_ns(int64_t *behind_ns)
{
    struct pel_frames_stats stats;
    pel_frames_get_stats(frames, &stats);
    *behind_ns = stats.surfaces_behind_ns;
    return stats.surfaces_urgent_ns;
}

/* Processor time before and behind the threads that draw, of eight queries of
 * that rank. */
static int64_t ask_eight(enum pel_rank rank, int64_t *behind_ns)
{
    enum { QUERIES = 8, POINTS = 10000 };
    static struct pel_vec2 points[POINTS];
    struct surface answers[QUERIES] = { 0 };
    const struct pel_surface_wish wish = { .points_m = points,
                                           .count = POINTS,
                                           .has_time = true,
                                           .time_s = 20,
                                           .rank = rank };
    int64_t behind_before_ns, before_ns = urgent_ns(&behind_before_ns);
    for (int i = 0; i < QUERIES; i++) {
        assert_int_equal(
            pel_frames_surface(frames, &wish, take_surface, &answers[i], NULL),
            PEL_OK);
    }
    for (int i = 0; i < QUERIES; i++) {
        run_until(&answers[i].calls, 1);
        assert_int_equal(answers[i].err, PEL_OK);
    }
    int64_t after_ns = urgent_ns(behind_ns);
    *behind_ns -= behind_before_ns;
    return after_ns - before_ns;
}

/* Whose questions do not steer leaves the processors to pictures, but for a
 * burst and a fortieth of the time. */
static void watchers_are_answered_behind_pictures(void **state)
{
    (void)state;
    int64_t behind_ns;
    assert_int_equal(ask_eight(PEL_RANK_NOBODY, &behind_ns), 0);
    assert_true(behind_ns > 0);
    assert_true(ask_eight(PEL_RANK_WATCH, &behind_ns) > 0);
    assert_true(behind_ns > 0);
    assert_true(ask_eight(PEL_RANK_INSTRUCT, &behind_ns) > 0);
}

/* --- numbers
 * ------------------------------------------------------------------------ */

static void windows_know_their_ranks(void **state)
{
    (void)state;
    static struct pel_window window;
    assert_true(pel_window_rank(&window, 0.5) == 0);
    pel_window_add(&window, 7);
    assert_true(pel_window_rank(&window, 0.5) == 7);
    assert_true(pel_window_rank(&window, 0.95) == 7);
    for (int i = 0; i < 300; i++) {
        pel_window_add(&window, i); /* 44 .. 299 stay */
    }
    assert_true(pel_window_rank(&window, 0.5) == 44 + 127);
    assert_true(pel_window_rank(&window, 1) == 299);
    assert_true(pel_window_rank(&window, 0) == 44);
}

/* --- the end
 * -------------------------------------------------------------------------- */

static void destroying_answers_what_waits(void **state)
{
    (void)state;
    struct answer answers[20] = { 0 }, live = { 0 };
    struct surface surface = { 0 };
    struct pel_vec2 point = { 0, 0 };
    struct pel_subscription *subscription;
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__EXR);
    /* Small ones: what is being drawn is soon over on a busy machine too, and
     * of what waits but a few can have been begun. */
    request.has_time = true;
    assert_int_equal(pel_frames_subscribe(frames, "test", 80, take, &live,
                                          &subscription, NULL),
                     PEL_OK);
    for (int i = 0; i < 20; i++) {
        request.time = i;
        ask(&request, &answers[i]);
    }
    assert_int_equal(ask_surface(&point, 1, false, 0, &surface), PEL_OK);
    run_until(&answers[0].calls, 1);
    /* What is under way is a picture of 64 × 48 and an encoding of it, some
     * 10 ms; each kind of thread has a second or two to end. */
    assert_true(pel_frames_destroy(frames));
    int conflicts = 0;
    for (int i = 0; i < 20; i++) {
        assert_int_equal(answers[i].calls, 1);
        conflicts += answers[i].err == PEL_ERR_CONFLICT;
        drop(&answers[i]);
    }
    assert_true(conflicts > 0);
    assert_int_equal(surface.calls, 1);
    drop(&live);
    run_for(20); /* nothing is left that would call */
    frames = NULL;
    pel_scene_destroy(scene);
    struct pel_scene_options options = { .wave_count = 60 };
    assert_int_equal(pel_scene_create(&options, &scene, NULL), PEL_OK);
}

static void a_device_that_is_not_there_is_a_fault(void **state)
{
    (void)state;
    struct pel_frames *none = NULL;
    struct pel_frames_options options = { .device = "99", .max_fps = 30 };
    struct pel_fault fault = { 0 };
    assert_int_not_equal(pel_frames_create(&options, scene, &none, &fault),
                         PEL_OK);
    assert_null(none);
    assert_true(strlen(fault.message) > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_format_is_answered),
        cmocka_unit_test(the_same_request_gives_the_same_bytes),
        cmocka_unit_test(own_size_and_time_are_drawn),
        cmocka_unit_test(requests_of_one_turn_share_a_frame),
        cmocka_unit_test(each_gets_its_own_time_and_quality),
        cmocka_unit_test(the_next_frame_shows_a_patch),
        cmocka_unit_test(an_exr_says_how_it_came_about),
        cmocka_unit_test(what_cannot_be_is_refused_at_once),
        cmocka_unit_test(waiting_requests_are_bounded),
        cmocka_unit_test(a_cancelled_request_is_silent),
        cmocka_unit_test(a_large_picture_waits_for_others),
        cmocka_unit_test(a_large_picture_is_dropped),
        cmocka_unit_test(a_picture_has_a_set_s_memory),
        cmocka_unit_test(a_view_deleted_before_its_frame),
        cmocka_unit_test(surface_queries_are_answered),
        cmocka_unit_test(watchers_are_answered_behind_pictures),
        cmocka_unit_test(few_points_do_not_wait_for_many),
        cmocka_unit_test(windows_know_their_ranks),
        cmocka_unit_test(destroying_answers_what_waits),
        cmocka_unit_test(a_device_that_is_not_there_is_a_fault),
    };
    return cmocka_run_group_tests_name("frames", tests, set_up, tear_down);
}
