/* Pictures for whoever subscribed to them. */
#include "frames/core.h"
#include "frames/frames_testkit.h"

static void live_frames_come_in_order(void **state)
{
    (void)state;
    struct answer a = { 0 }, b = { 0 };
    struct pel_subscription *first, *second;
    add_view("other", 48, 32);
    assert_int_equal(
        pel_frames_subscribe(frames, "test", 80, take, &a, &first, NULL),
        PEL_OK);
    assert_int_equal(
        pel_frames_subscribe(frames, "other", 80, take, &b, &second, NULL),
        PEL_OK);
    run_until(&a.frame_count, 10);
    run_until(&b.frame_count, 10);
    int count = a.frame_count < 64 ? a.frame_count : 64;
    for (int i = 1; i < count; i++) {
        assert_true(a.numbers[i] > a.numbers[i - 1]);
    }
    /* The views of one frame share its number: b has no number of its own. */
    int shared = 0;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < 64 && k < b.frame_count; k++) {
            shared += a.numbers[i] == b.numbers[k];
        }
    }
    assert_true(shared >= 9);
    /* Asked for meanwhile, a picture comes with the live ones. */
    struct answer one = { 0 }, timed = { 0 };
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__PNG);
    ask(&request, &one);
    request.has_time = true;
    request.time = 77;
    ask(&request, &timed);
    run_until(&one.calls, 1);
    run_until(&timed.calls, 1);
    assert_true(timed.frame->time_s == 77);
    drop(&one);
    drop(&timed);
    pel_frames_unsubscribe(first);
    pel_frames_unsubscribe(second);
    run_until_still();
    int calls = a.calls;
    struct pel_frames_stats before, after;
    pel_frames_get_stats(frames, &before);
    run_for(200);
    pel_frames_get_stats(frames, &after);
    assert_int_equal(a.calls, calls);
    assert_int_equal(after.frames_drawn, before.frames_drawn);
    assert_int_equal(after.subscriptions, 0);
    drop(&a);
    drop(&b);
}

static void paced_time_advances_by_the_frame(void **state)
{
    (void)state;
    struct answer answer = { 0 };
    struct pel_subscription *subscription;
    set_clock(PELAGOS__CLOCK_MODE__PACED, 100);
    pel_frames_set_max_fps(frames, 50);
    run_for(100);
    assert_true(pel_scene_time(scene) == 100); /* nobody watches */
    assert_int_equal(pel_frames_subscribe(frames, "test", 80, take, &answer,
                                          &subscription, NULL),
                     PEL_OK);
    run_until(&answer.frame_count, 10);
    pel_frames_unsubscribe(subscription);
    for (int i = 1; i < 10; i++) {
        /* 1/50 s to the rounding of sums near 100. */
        assert_true(fabs(answer.times[i] - answer.times[i - 1] - 0.02) < 1e-9);
        assert_int_equal(answer.numbers[i] - answer.numbers[i - 1], 1);
    }
    pel_frames_set_max_fps(frames, 60);
    run_for(100);
    drop(&answer);
    set_clock(PELAGOS__CLOCK_MODE__STEPPED, 10);
}

static void a_deleted_view_ends_its_subscription(void **state)
{
    (void)state;
    struct answer answer = { 0 };
    struct pel_subscription *subscription;
    add_view("short", 32, 32);
    assert_int_equal(pel_frames_subscribe(frames, "short", 80, take, &answer,
                                          &subscription, NULL),
                     PEL_OK);
    run_until(&answer.frame_count, 2);
    remove_path("views.short");
    assert_int_equal(answer.err, PEL_ERR_NOT_FOUND);
    int calls = answer.calls;
    run_for(100);
    assert_int_equal(answer.calls, calls);
    pel_frames_unsubscribe(subscription);
    drop(&answer);
}

static void size_changes_while_watched(void **state)
{
    (void)state;
    struct answer answer = { 0 };
    struct pel_subscription *subscription;
    assert_int_equal(pel_frames_subscribe(frames, "test", 80, take, &answer,
                                          &subscription, NULL),
                     PEL_OK);
    run_until(&answer.frame_count, 2);
    add_view("test", 80, 40);
    for (int i = 0; i < 3000 && answer.frame->width != 80; i++) {
        run_for(20);
    }
    assert_int_equal(answer.frame->width, 80);
    assert_int_equal(answer.frame->height, 40);
    pel_frames_unsubscribe(subscription);
    add_view("test", 64, 48);
    drop(&answer);
}

struct quitter {
    struct answer answer;
    struct pel_subscription *mine, *other;
};

static void quit_both(void *user, enum pel_err err,
                      const struct pel_fault *fault, struct pel_frame *frame)
{
    struct quitter *quitter = user;
    take(&quitter->answer, err, fault, frame);
    pel_frames_unsubscribe(quitter->mine);
    pel_frames_unsubscribe(quitter->other);
    quitter->mine = quitter->other = NULL;
}

static void subscribers_may_leave_in_their_callback(void **state)
{
    (void)state;
    struct quitter quitter = { 0 };
    struct answer other = { 0 };
    assert_int_equal(pel_frames_subscribe(frames, "test", 80, take, &other,
                                          &quitter.other, NULL),
                     PEL_OK);
    assert_int_equal(pel_frames_subscribe(frames, "test", 80, quit_both,
                                          &quitter, &quitter.mine, NULL),
                     PEL_OK);
    run_until(&quitter.answer.calls, 1);
    run_for(100);
    assert_int_equal(quitter.answer.calls, 1);
    assert_true(other.calls <= 1);
    drop(&other);
    drop(&quitter.answer);
}

/* Streams of a rank until no more are given, each of its own quality. */
static int open_all(struct pel_who who, int first, struct answer *answer,
                    struct pel_subscription *all[PEL_MAX_STREAMS])
{
    int count = 0;
    for (int q = 0; q < PEL_MAX_STREAMS; q++) {
        const struct pel_profile profile = { .quality = first + q, .who = who };
        count += pel_frames_open(frames, "test", &profile, take, answer,
                                 &all[count], NULL) == PEL_OK;
    }
    return count;
}

static void streams_are_shared_out(void **state)
{
    (void)state;
    struct pel_subscription *a[PEL_MAX_STREAMS], *b[PEL_MAX_STREAMS],
        *c[PEL_MAX_STREAMS];
    struct answer one = { 0 }, other = { 0 }, above = { 0 };
    int first = open_all((struct pel_who){ PEL_RANK_WATCH, 1 }, 1, &one, a);
    assert_int_equal(first,
                     pel_share_of_token(PEL_MAX_STREAMS, PEL_RANK_WATCH));
    int second = open_all((struct pel_who){ PEL_RANK_WATCH, 2 }, 37, &other, b);
    assert_int_equal(first + second,
                     pel_share_of_rank(PEL_MAX_STREAMS, PEL_RANK_WATCH));
    /* An instructor takes the rest, and then theirs, the newest first. */
    int third = open_all((struct pel_who){ 0 }, 37, &above, c);
    assert_int_equal(third, PEL_MAX_STREAMS);
    assert_int_equal(one.err, PEL_ERR_NOT_FOUND);
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        pel_frames_unsubscribe(i < first ? a[i] : NULL);
        pel_frames_unsubscribe(i < second ? b[i] : NULL);
        pel_frames_unsubscribe(i < third ? c[i] : NULL);
    }
    run_for(100);
    drop(&one);
    drop(&other);
    drop(&above);
}

/* Sixteen kinds of live views of who may watch, each as large as what is drawn
 * at once: while each has its first picture, an instructor has many. With one
 * job for all he had as many as they. */
static void low_ranks_are_behind(void **state)
{
    (void)state;
    enum { KINDS = 16 };
    struct pel_subscription *front, *low[KINDS];
    struct answer above = { 0 }, below[KINDS] = { { 0 } };
    const struct pel_profile high = { .quality = 80 };
    pel_frames_set_quality(frames, 1);
    assert_int_equal(
        pel_frames_open(frames, "test", &high, take, &above, &front, NULL),
        PEL_OK);
    run_until(&above.frame_count, 3);
    int before = above.frame_count;
    for (int i = 0; i < KINDS; i++) {
        const struct pel_profile profile = {
            .quality = 80,
            .width = 256,
            .height = 256 + 2 * (unsigned)i,
            .who = { PEL_RANK_WATCH, 1 },
        };
        assert_int_equal(pel_frames_open(frames, "test", &profile, take,
                                         &below[i], &low[i], NULL),
                         PEL_OK);
    }
    for (int i = 0; i < KINDS; i++) {
        run_until(&below[i].frame_count, 1);
    }
    assert_true(above.frame_count - before >= 6);
    for (int i = 0; i < KINDS; i++) { /* and all go on */
        run_until(&below[i].frame_count, 3);
        assert_int_equal(below[i].frame->height, 256 + 2 * i);
        assert_true(below[i].numbers[0] < below[i].numbers[1]);
        assert_true(below[i].numbers[1] < below[i].numbers[2]);
    }
    /* Alone they are as any other. */
    pel_frames_unsubscribe(front);
    int most = below[0].frame_count;
    run_until(&below[0].frame_count, most + 2);
    for (int i = 0; i < KINDS; i++) {
        pel_frames_unsubscribe(low[i]);
        drop(&below[i]);
    }
    pel_frames_set_quality(frames, 0);
    run_for(100);
    drop(&above);
}

/* One says the size that the view has, the other none: one picture, and each
 * gets it, while time goes on. */
static void the_same_picture_goes_to_both(void **state)
{
    (void)state;
    struct pel_subscription *plain, *sized;
    struct answer one = { 0 }, other = { 0 };
    const struct pel_profile its = { .quality = 80 };
    const struct pel_profile said = { .quality = 80,
                                      .width = 64,
                                      .height = 48 };
    set_clock(PELAGOS__CLOCK_MODE__FREE, 10);
    assert_int_equal(
        pel_frames_open(frames, "test", &its, take, &one, &plain, NULL),
        PEL_OK);
    assert_int_equal(
        pel_frames_open(frames, "test", &said, take, &other, &sized, NULL),
        PEL_OK);
    run_until(&one.frame_count, 5);
    run_until(&other.frame_count, 5);
    pel_frames_unsubscribe(plain);
    pel_frames_unsubscribe(sized);
    run_for(100);
    set_clock(PELAGOS__CLOCK_MODE__STEPPED, 10);
    drop(&one);
    drop(&other);
}

/* Who opens a live view and leaves at once has cost no picture. */
static void who_leaves_has_cost_nothing(void **state)
{
    (void)state;
    struct pel_subscription *front, *low;
    struct answer above = { 0 }, below = { 0 };
    const struct pel_profile high = { .quality = 80 };
    struct pel_frames_stats first, last;
    assert_int_equal(
        pel_frames_open(frames, "test", &high, take, &above, &front, NULL),
        PEL_OK);
    run_until(&above.frame_count, 3);
    pel_frames_get_stats(frames, &first);
    int64_t begun_ns = pel_now_ns();
    unsigned opened = 0;
    while (pel_now_ns() - begun_ns < 1000000000LL) {
        const struct pel_profile profile = {
            .codec = PEL_CODEC_H264,
            .width = 64 + 16 * (opened++ % 64),
            .height = 64,
            .who = { PEL_RANK_WATCH, 1 },
        };
        int64_t opened_ns = pel_now_ns();
        assert_int_equal(
            pel_frames_open(frames, "test", &profile, take, &below, &low, NULL),
            PEL_OK);
        while (pel_now_ns() - opened_ns < 40000000) {
            g_main_context_iteration(NULL, FALSE);
        }
        pel_frames_unsubscribe(low);
        pel_frames_get_stats(frames, &last);
        if (pel_now_ns() - opened_ns < 90000000) { /* else it has stayed */
            assert_int_equal(last.behind_drawn, first.behind_drawn);
        }
        first = last;
    }
    pel_frames_unsubscribe(front);
    run_for(100);
    drop(&above);
    drop(&below);
}

static void subscriptions_are_bounded(void **state)
{
    (void)state;
    struct pel_subscription *all[PEL_MAX_SUBSCRIPTIONS], *more;
    struct answer answer = { 0 };
    int streams = 0;
    for (int q = 1; q <= 100; q++) {
        streams += pel_frames_subscribe(frames, "test", q, take, &answer,
                                        &all[streams], NULL) == PEL_OK;
    }
    assert_int_equal(streams, PEL_MAX_STREAMS);
    for (int i = streams; i < PEL_MAX_SUBSCRIPTIONS; i++) {
        assert_int_equal(pel_frames_subscribe(frames, "test", 1, take, &answer,
                                              &all[i], NULL),
                         PEL_OK);
    }
    assert_int_equal(
        pel_frames_subscribe(frames, "test", 1, take, &answer, &more, NULL),
        PEL_ERR_BUSY);
    assert_int_equal(
        pel_frames_subscribe(frames, "test", 0, take, &answer, &more, NULL),
        PEL_ERR_OUT_OF_RANGE);
    assert_int_equal(
        pel_frames_subscribe(frames, "none", 9, take, &answer, &more, NULL),
        PEL_ERR_NOT_FOUND);
    for (int i = 0; i < PEL_MAX_SUBSCRIPTIONS; i++) {
        pel_frames_unsubscribe(all[i]);
    }
    run_for(100);
    drop(&answer);
}

/* Forty of 4096 x 4096 took 6.4 GB. */
static void live_views_have_a_budget(void **state)
{
    (void)state;
    struct pel_subscription *opened[40] = { NULL };
    struct answer answer = { 0 };
    struct pel_fault fault;
    int open = 0;
    for (int i = 0; i < 40; i++) {
        const struct pel_profile profile = { .codec = PEL_CODEC_H264,
                                             .width = 4096,
                                             .height = 4096 - 2 * (unsigned)i };
        enum pel_err err = pel_frames_open(frames, "test", &profile, take,
                                           &answer, &opened[i], &fault);
        open += err == PEL_OK;
        if (err != PEL_OK) {
            assert_int_equal(err, PEL_ERR_BUSY);
            assert_non_null(strstr(fault.message, "67 million pixels"));
            opened[i] = NULL;
        }
    }
    assert_int_equal(open, 4);
    /* One that is open can be shared, and changed for a smaller one. */
    const struct pel_profile same = { .codec = PEL_CODEC_H264,
                                      .width = 4096,
                                      .height = 4096 };
    const struct pel_profile less = { .codec = PEL_CODEC_H264,
                                      .width = 640,
                                      .height = 480 };
    struct pel_subscription *other;
    assert_int_equal(
        pel_frames_open(frames, "test", &same, take, &answer, &other, NULL),
        PEL_OK);
    assert_int_equal(pel_frames_change(opened[1], &less, NULL), PEL_OK);
    pel_frames_unsubscribe(other);
    for (int i = 0; i < 40; i++) {
        if (opened[i]) {
            pel_frames_unsubscribe(opened[i]);
        }
    }
    /* And so many encoders, however small. */
    for (int i = 0; i < 40; i++) {
        const struct pel_profile small_one = { .codec = PEL_CODEC_H264,
                                               .width = 64,
                                               .height = 64 + 2 * (unsigned)i };
        opened[i] = NULL;
        if (pel_frames_open(frames, "test", &small_one, take, &answer,
                            &opened[i], &fault) != PEL_OK) {
            assert_int_equal(i, 32);
            assert_non_null(strstr(fault.message, "32 encoders"));
            break;
        }
    }
    for (int i = 0; i < 40 && opened[i]; i++) {
        pel_frames_unsubscribe(opened[i]);
    }
    run_for(50);
    drop(&answer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(live_frames_come_in_order),
        cmocka_unit_test(paced_time_advances_by_the_frame),
        cmocka_unit_test(a_deleted_view_ends_its_subscription),
        cmocka_unit_test(size_changes_while_watched),
        cmocka_unit_test(subscribers_may_leave_in_their_callback),
        cmocka_unit_test(streams_are_shared_out),
        cmocka_unit_test(low_ranks_are_behind),
        cmocka_unit_test(the_same_picture_goes_to_both),
        cmocka_unit_test(who_leaves_has_cost_nothing),
        cmocka_unit_test(subscriptions_are_bounded),
        cmocka_unit_test(live_views_have_a_budget),
    };
    return cmocka_run_group_tests_name("live frames", tests, set_up, tear_down);
}
