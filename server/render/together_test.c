/* Views that are drawn together: each has the bits that it has alone, and those
 * of the passes of single views. */
#define TEST_ANTIALIASING true
#include "render/render_testkit.h"

#define MOST 10

static struct pel_sea trochoids, cascades;

/* Sizes that share no side; some look at the sky alone. */
static const struct test_look looks[MOST] = {
    { 7, 20, -4, 0, 60, 96, 54 },    { 7, 80, -9, 11, 40, 70, 33 },
    { 7, 140, 2, -5, 90, 33, 70 },   { 7, 200, -30, 0, 60, 64, 64 },
    { 7, 260, 70, 0, 30, 40, 20 },   { 7, 320, -1, 0, 20, 129, 41 },
    { 7, 350, -80, 30, 70, 17, 18 }, { 7, 20, -4, 0, 60, 48, 27 },
    { 7, 33, -4, 90, 60, 50, 50 },   { 7, 55, -6, 0, 100, 80, 20 },
};

struct kept {
    uint8_t *rgba;
    double ev;
};

static struct kept keep(struct pel_picture *p)
{
    size_t size = (size_t)p->width * p->height * 4;
    struct kept k = { malloc(size), p->exposure_ev };
    assert_non_null(k.rgba);
    memcpy(k.rgba, p->rgba, size);
    pel_picture_release(p);
    return k;
}

static void assert_kept(const struct kept *k, struct pel_picture *p)
{
    assert_memory_equal(k->rgba, p->rgba, (size_t)p->width * p->height * 4);
    assert_true(k->ev == p->exposure_ev);
    pel_picture_release(p);
}

static void set_up_draws(struct pel_draw draws[MOST], bool smooth)
{
    for (int i = 0; i < MOST; i++) {
        draws[i] = (struct pel_draw){ .camera = test_camera(looks[i]),
                                      .layers = PEL_LAYER_COLOR,
                                      .user = &draws[i] };
        draws[i].camera.antialiasing = smooth;
    }
    /* One is metered by another's window, one not at all. */
    draws[1].camera.sights[0] = (struct pel_sight){
        .altitude_m = 7,
        .world_from_camera = draws[0].camera.world_from_camera,
        .tan_left = -0.5,
        .tan_right = 0.5,
        .tan_top = 0.1,
        .tan_bottom = -0.1,
    };
    draws[1].camera.sight_count = 1;
    draws[2].camera.auto_exposure = false;
    draws[2].camera.exposure_ev = 12;
}

static void draw_all(const struct pel_environment *env, struct pel_draw *draws,
                     size_t count, struct pel_picture *out[])
{
    assert_int_equal(pel_renderer_submit(renderer, env, draws, count), PEL_OK);
    for (size_t i = 0; i < count; i++) {
        out[i] = pel_renderer_collect(renderer, 60000000000);
        assert_non_null(out[i]);
        assert_ptr_equal(out[i]->user, draws[i].user);
    }
}

static void compare(const struct pel_sea *sea, bool smooth)
{
    struct pel_environment env = test_environment(sea, 3.7);
    struct pel_draw draws[MOST];
    struct pel_picture *pictures[MOST];
    struct kept alone[MOST];
    set_up_draws(draws, smooth);
    for (int i = 0; i < MOST; i++) {
        draw_all(&env, &draws[i], 1, pictures);
        alone[i] = keep(pictures[0]);
    }
    draw_all(&env, draws, MOST, pictures);
    for (int i = 0; i < MOST; i++) {
        assert_kept(&alone[i], pictures[i]);
    }
    /* Others beside them, another eye between them. */
    struct pel_draw some[4] = { draws[5], draws[2], draws[9], draws[0] };
    some[1].camera.altitude_m = 21;
    draw_all(&env, some, 4, pictures);
    pel_picture_release(pictures[1]);
    assert_kept(&alone[5], pictures[0]);
    assert_kept(&alone[9], pictures[2]);
    assert_kept(&alone[0], pictures[3]);
    /* Depth too: by the passes of single views. */
    for (int i = 0; i < MOST; i++) {
        draws[i].layers |= PEL_LAYER_DEPTH;
        draw_all(&env, &draws[i], 1, pictures);
        assert_non_null(pictures[0]->depth);
        assert_kept(&alone[i], pictures[0]);
        free(alone[i].rgba);
    }
}

static void trochoids_alone_and_together(void **state)
{
    (void)state;
    compare(&trochoids, true);
}

static void cascades_alone_and_together(void **state)
{
    (void)state;
    compare(&cascades, true);
}

static void without_outlines(void **state)
{
    (void)state;
    compare(&cascades, false);
}

/* More pixels than are drawn together: lists grow and are dropped. */
static void sizes_in_turn(void **state)
{
    (void)state;
    struct pel_environment env = test_environment(&trochoids, 1.0);
    struct pel_draw draws[MOST], large;
    struct pel_picture *pictures[MOST];
    set_up_draws(draws, true);
    large = draws[0];
    large.camera =
        test_camera((struct test_look){ 7, 20, -4, 0, 60, 640, 360 });
    draw_all(&env, draws, 1, pictures);
    const struct kept small = keep(pictures[0]);
    draw_all(&env, &large, 1, pictures);
    const struct kept whole = keep(pictures[0]);
    for (int i = 0; i < 260; i++) { /* SMALL_DRAWS of together.c, and some */
        draw_all(&env, draws, 1, pictures);
        pel_picture_release(pictures[0]);
    }
    draw_all(&env, draws, 1, pictures);
    assert_kept(&small, pictures[0]);
    draw_all(&env, &large, 1, pictures);
    assert_kept(&whole, pictures[0]);
    free(small.rgba);
    free(whole.rgba);
}

static int set_up(void **state)
{
    (void)state;
    renderer = test_renderer("compute");
    test_sea(8.0, 0.0, 3, &trochoids);
    test_fft_sea(9.0, 4, &cascades);
    return 0;
}

static int tear_down(void **state)
{
    pel_sea_finish(&trochoids);
    pel_sea_finish(&cascades);
    return end_renderer(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trochoids_alone_and_together),
        cmocka_unit_test(cascades_alone_and_together),
        cmocka_unit_test(without_outlines),
        cmocka_unit_test(sizes_in_turn),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
