/* Waves over a bottom as they are drawn: the queried surface, by both
 * synthesisers; far out what is drawn
 * without a bottom; foam where they
 * break. */
#include "ocean/foam.h"
#include "ocean/shore.h"
#include "render/render_testkit.h"

#define COLUMNS 301
#define ROWS 301
#define SPACING 10.0
#define DEEPEST 60.0

static float heights[COLUMNS * ROWS];

/* From 60 m at the west to 3 m above the level at the east: 3 km. */
static void lay(struct pel_sea *sea)
{
    for (int j = 0; j < ROWS; j++) {
        for (int i = 0; i < COLUMNS; i++) {
            heights[j * COLUMNS + i] =
                (float)(-DEEPEST + (DEEPEST + 3) * i / (COLUMNS - 1));
        }
    }
    const struct pel_shore_bottom bottom = { .columns = COLUMNS,
                                             .rows = ROWS,
                                             .west_m = 0,
                                             .south_m = -1500,
                                             .spacing_m = SPACING,
                                             .height_m = heights,
                                             .beyond_m = 1000 };
    assert_int_equal(pel_sea_lay(sea, &bottom), PEL_OK);
    assert_non_null(sea->shore);
}

static void build(bool fft, bool laid, struct pel_sea *out)
{
    struct pel_sea_desc desc = test_wind(9, 3);
    desc.synthesiser = fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS;
    desc.direction_rad = 0.4;
    desc.whitecaps = 1;
    assert_int_equal(pel_sea_build(&desc, out), PEL_OK);
    if (laid) {
        lay(out);
    }
}

static double place_of(double depth)
{
    return 3000 * (DEEPEST - depth) / (DEEPEST + 3);
}

static void expect_one_surface(const struct pel_sea *sea, double east_m,
                               const char *what)
{
    struct pel_environment env = test_environment(sea, 60);
    struct pel_camera c =
        test_camera((struct test_look){ 8, 0, -90, 0, 40, 64, 64 });
    c.east_m = east_m;
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_DEPTH);
    double square = 0, worst = 0, high = 0;
    for (uint32_t i = 0; i < c.width * c.height; i++) {
        struct pel_vec3 dir =
            test_ray(&c, i % c.width + 0.5, (double)(i / c.width) + 0.5);
        struct pel_vec3 at =
            pel_vec3_scale(dir, (double)p->layer[PEL_AT_DEPTH][i]);
        struct pel_surface_sample s;
        pel_sea_sample(sea, east_m + at.x, at.y, env.time_s, &s);
        double error = c.altitude_m + at.z - s.height_m;
        square += error * error / (c.width * c.height);
        worst = fmax(worst, fabs(error));
        high = fmax(high, fabs(s.height_m));
    }
    printf("%s: %.2f mm rms, worst %.2f, waves of %.2f m\n", what,
           1e3 * sqrt(square), 1e3 * worst, high);
    /* Pixels of 9 cm leave out the ripples. */
    assert_true(sqrt(square) < 0.002 && worst < 0.012);
    pel_picture_release(p);
}

static void drawn_is_queried(void **state)
{
    (void)state;
    static const double depths[] = { 20, 5, 2, 0.8 };
    renderer = test_renderer(NULL);
    for (int fft = 0; fft < 2; fft++) {
        struct pel_sea sea;
        build(fft, true, &sea);
        for (size_t i = 0; i < sizeof depths / sizeof *depths; i++) {
            char what[64];
            snprintf(what, sizeof what, "%s, %.1f m deep",
                     fft ? "cascades" : "trochoids", depths[i]);
            expect_one_surface(&sea, place_of(depths[i]), what);
        }
        pel_sea_finish(&sea);
    }
    pel_renderer_destroy(renderer);
}

static void the_same_far_out(void **state)
{
    (void)state;
    renderer = test_renderer(NULL);
    for (int fft = 0; fft < 2; fft++) {
        struct pel_picture *p[2];
        struct pel_sea sea[2];
        for (int laid = 0; laid < 2; laid++) {
            build(fft, laid, &sea[laid]);
            struct pel_environment env = test_environment(&sea[laid], 60);
            struct pel_camera c =
                test_camera((struct test_look){ 8, 270, -12, 0, 50, 96, 64 });
            c.east_m = -300;
            p[laid] = test_draw(renderer, &env, &c,
                                PEL_LAYER_RADIANCE | PEL_LAYER_DEPTH);
        }
        double off = 0;
        for (size_t i = 0; i < 96 * 64; i++) {
            for (size_t k = 0; k < 3; k++) {
                double was = (double)p[0]->radiance[4 * i + k];
                off = fmax(off,
                           fabs((double)p[1]->radiance[4 * i + k] / was - 1));
            }
            off = fmax(
                off, fabs((double)p[1]->depth[i] / (double)p[0]->depth[i] - 1));
        }
        printf("%s: light and depth within %.1e\n",
               fft ? "cascades" : "trochoids", off);
        /* A compiler may round the same text in two programs differently. */
        bool software = pel_renderer_is_software(renderer);
        assert_true(off <= (software ? fft ? 1e-5 : 0 : 2e-3));
        struct pel_surface_sample a, b;
        pel_sea_sample(&sea[0], -300, 40, 7, &a);
        pel_sea_sample(&sea[1], -300, 40, 7, &b);
        assert_memory_equal(&a.height_m, &b.height_m, sizeof a.height_m);
        for (int i = 0; i < 2; i++) {
            pel_picture_release(p[i]);
            pel_sea_finish(&sea[i]);
        }
    }
    pel_renderer_destroy(renderer);
}

/* Drawn in the mean over 69 m; *asked: queried. */
static double foam_at(const struct pel_sea *sea, double east_m, double *asked)
{
    struct pel_environment env = test_environment(sea, 60);
    struct pel_camera c =
        test_camera((struct test_look){ 60, 0, -90, 0, 60, 64, 64 });
    double sum = 0;
    c.east_m = east_m;
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_FOAM);
    for (uint32_t i = 0; i < c.width * c.height; i++) {
        sum += (double)p->layer[PEL_AT_FOAM][i] / (c.width * c.height);
    }
    *asked = 0;
    for (int i = 0; i < 69 * 69; i++) {
        const struct pel_vec2 at = { east_m + i % 69 - 34, i / 69 - 34 };
        struct pel_surface_sample s;
        pel_sea_query(sea, &at, 1, 60, &s);
        pel_foam_query(sea, NULL, 1, 60, &s);
        *asked += s.foam / (69 * 69);
    }
    pel_picture_release(p);
    return sum;
}

static void surf_is_white(void **state)
{
    (void)state;
    renderer = test_renderer(NULL);
    for (int fft = 0; fft < 2; fft++) {
        struct pel_sea sea;
        build(fft, true, &sea);
        double asked[2];
        double deep = foam_at(&sea, place_of(20), &asked[0]);
        double surf = foam_at(&sea, place_of(0.8), &asked[1]);
        printf("foam: %.4f at 20 m, %.4f at 0.8 m; queried %.4f, %.4f\n", deep,
               surf, asked[0], asked[1]);
        assert_true(deep < 0.03 && surf > 0.08);
        /* The picture is as wide as one tile of surf's structure. */
        assert_float_equal(asked[1] / surf, 1, 0.15);
        assert_true(asked[0] < 0.03);
        pel_sea_finish(&sea);
    }
    pel_renderer_destroy(renderer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(drawn_is_queried),
        cmocka_unit_test(the_same_far_out),
        cmocka_unit_test(surf_is_white),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
