/* Areas as they are drawn: the queried surface, the slopes that a pixel leaves
 * to shading, foam; both wrappers, parts and order. */
#include "ocean/areas.h"
#include "ocean/foam.h"
#include "render/render_testkit.h"

/* At time 0 a slick 300 m to the east, which comes by 5 m/s; a polygon of
 * gusts. */
static void with_areas(double wind, bool fft, struct pel_sea *out)
{
    struct pel_sea_desc desc = test_wind(wind, 3);
    desc.kind = PEL_SPECTRUM_ELFOUHAILY;
    desc.fetch_m = 200000;
    desc.synthesiser = fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS;
    desc.whitecaps = 1;
    desc.area_count = 2;
    desc.area[0] = (struct pel_area_desc){ .east_m = 300,
                                           .radius_m = 40,
                                           .velocity_east_mps = -5,
                                           .edge_m = 4,
                                           .factor = 0.25 };
    desc.area[1] = (struct pel_area_desc){
        .east_m = -100,
        .corner_count = 3,
        .corner = { { -80, -60 }, { 80, -60 }, { 0, 90 } },
        .edge_m = 10,
        .factor = 1.4
    };
    assert_int_equal(pel_sea_build(&desc, out), PEL_OK);
}

static void expect_one_surface(const struct pel_sea *sea, double east_m,
                               double north_m, const char *what)
{
    struct pel_environment env = test_environment(sea, 60);
    struct pel_camera c =
        test_camera((struct test_look){ 8, 0, -90, 0, 40, 64, 64 });
    c.east_m = east_m;
    c.north_m = north_m;
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_DEPTH);
    double square = 0, worst = 0;
    for (uint32_t i = 0; i < c.width * c.height; i++) {
        struct pel_vec3 dir =
            test_ray(&c, i % c.width + 0.5, (double)(i / c.width) + 0.5);
        struct pel_vec3 at =
            pel_vec3_scale(dir, (double)p->layer[PEL_AT_DEPTH][i]);
        struct pel_surface_sample s;
        pel_sea_sample(sea, east_m + at.x, north_m + at.y, env.time_s, &s);
        double error = c.altitude_m + at.z - s.height_m;
        square += error * error / (c.width * c.height);
        worst = fmax(worst, fabs(error));
    }
    printf("%s: %.2f mm rms, worst %.2f\n", what, 1e3 * sqrt(square),
           1e3 * worst);
    /* Pixels of 9 cm leave out the ripples, and more of them in a gust. */
    assert_true(sqrt(square) < 0.002 && worst < 0.012);
    pel_picture_release(p);
}

static void drawn_is_queried(void **state)
{
    (void)state;
    renderer = test_renderer(NULL);
    for (int fft = 0; fft < 2; fft++) {
        struct pel_sea sea;
        with_areas(6, fft, &sea);
        expect_one_surface(&sea, 0, 0, "slick");
        expect_one_surface(&sea, 40, 0, "its edge");
        expect_one_surface(&sea, -100, 0, "gust");
        expect_one_surface(&sea, -58, 0, "its edge");
        pel_sea_finish(&sea);
    }
    pel_renderer_destroy(renderer);
}

/* Means of a layer over 20 m by 20 m, from so high that a pixel is 60 m. */
static void mean_of(const struct pel_sea *sea, double east_m, int layer,
                    unsigned bit, int parts, double out[2])
{
    struct pel_environment env = test_environment(sea, 60);
    struct pel_camera c =
        test_camera((struct test_look){ 2000, 0, -90, 0, 0.6, 16, 16 });
    c.east_m = east_m;
    struct pel_picture *p = test_draw(renderer, &env, &c, bit);
    out[0] = out[1] = 0;
    for (uint32_t i = 0; i < 256; i++) {
        for (int k = 0; k < parts; k++) {
            out[k] +=
                (double)p->layer[layer][i * (uint32_t)parts + (uint32_t)k] /
                256;
        }
    }
    pel_picture_release(p);
}

/* Pixels of 1.3 m: what is left to shading inside over outside is between the
 * factor's square (short waves alone) and 1. */
static void shading_follows(void **state)
{
    (void)state;
    renderer = test_renderer(NULL);
    for (int fft = 0; fft < 2; fft++) {
        struct pel_sea sea;
        double in[2], beside[2], gust[2];
        with_areas(12, fft, &sea);
        mean_of(&sea, 0, PEL_AT_SLOPE_VARIANCE, PEL_LAYER_SLOPE_VARIANCE, 2,
                in);
        mean_of(&sea, 400, PEL_AT_SLOPE_VARIANCE, PEL_LAYER_SLOPE_VARIANCE, 2,
                beside);
        mean_of(&sea, -100, PEL_AT_SLOPE_VARIANCE, PEL_LAYER_SLOPE_VARIANCE, 2,
                gust);
        printf("slick %.3f %.3f, gust %.3f %.3f of the slopes beside\n",
               in[0] / beside[0], in[1] / beside[1], gust[0] / beside[0],
               gust[1] / beside[1]);
        for (int k = 0; k < 2; k++) {
            /* Half precision of the layer aside, all that is left is short. */
            assert_float_equal(in[k] / beside[k], 0.0625, 0.02);
            assert_float_equal(gust[k] / beside[k], 1.96, 0.06);
        }
        pel_sea_finish(&sea);
    }
    pel_renderer_destroy(renderer);
}

static void a_slick_has_less_foam(void **state)
{
    (void)state;
    renderer = test_renderer(NULL);
    struct pel_sea_desc desc = test_wind(14, 3);
    double mean[3];
    static const double factors[3] = { 0.7, 1, 1.2 };
    desc.whitecaps = 1;
    desc.area_count = 1;
    for (int i = 0; i < 3; i++) {
        struct pel_sea sea;
        desc.area[0] = (struct pel_area_desc){ .radius_m = 20000,
                                               .edge_m = 1,
                                               .factor = factors[i] };
        assert_int_equal(pel_sea_build(&desc, &sea), PEL_OK);
        struct pel_environment env = test_environment(&sea, 60);
        struct pel_camera c =
            test_camera((struct test_look){ 8000, 0, -90, 0, 50, 64, 64 });
        struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_FOAM);
        mean[i] = 0;
        for (int k = 0; k < 64 * 64; k++) {
            mean[i] += (double)p->layer[PEL_AT_FOAM][k] / (64 * 64);
        }
        pel_picture_release(p);
        pel_sea_finish(&sea);
    }
    printf("foam %.3f and %.2f times\n", mean[0] / mean[1], mean[2] / mean[1]);
    /* 0.7^6.8, 1.2^6.8, to first order. */
    assert_float_equal(mean[0] / mean[1], 0.088, 0.04);
    assert_float_equal(mean[2] / mean[1], 3.45, 0.7);
    pel_renderer_destroy(renderer);
}

#define PIXELS (160 * 96)

static struct pel_picture *across(const struct pel_environment *env)
{
    struct pel_camera c =
        test_camera((struct test_look){ 12, 90, -12, 0, 70, 160, 96 });
    c.east_m = -160;
    return test_draw(renderer, env, &c, PEL_LAYER_COLOR);
}

/* By fragments and in one dispatch; after another moment the same bits. */
static void ways_and_orders(void **state)
{
    (void)state;
    static uint8_t seen[2][2][4 * PIXELS];
    static const char *const ways[2] = { "fragment", "compute" };
    for (int way = 0; way < 2; way++) {
        renderer = test_renderer(ways[way]);
        for (int fft = 0; fft < 2; fft++) {
            struct pel_sea sea;
            with_areas(9, fft, &sea);
            struct pel_environment env = test_environment(&sea, 30);
            struct pel_picture *a = across(&env);
            memcpy(seen[way][fft], a->rgba, sizeof seen[0][0]);
            env.time_s = 50;
            struct pel_picture *b = across(&env);
            env.time_s = 30;
            struct pel_picture *again = across(&env);
            assert_memory_equal(seen[way][fft], again->rgba, sizeof seen[0][0]);
            assert_true(memcmp(seen[way][fft], b->rgba, sizeof seen[0][0]));
            pel_picture_release(a);
            pel_picture_release(b);
            pel_picture_release(again);
            pel_sea_finish(&sea);
        }
        pel_renderer_destroy(renderer);
    }
    for (int fft = 0; fft < 2; fft++) {
        int other = 0;
        for (int i = 0; i < 4 * PIXELS; i++) {
            other += abs(seen[0][fft][i] - seen[1][fft][i]) > 2;
        }
        /* Beside a triangle's edge one may see the next. */
        printf("%d bytes differ\n", other);
        assert_true(other <= 40);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(drawn_is_queried),
        cmocka_unit_test(shading_follows),
        cmocka_unit_test(a_slick_has_less_foam),
        cmocka_unit_test(ways_and_orders),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
