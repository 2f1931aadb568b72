/* The wash of ships as it is drawn: the queried surface, the slopes that a
 * pixel leaves to shading, foam; both wrappers, parts and order, nothing where
 * there is none. */
#include "ocean/areas.h"
#include "ocean/foam.h"
#include "ocean/restquery.h"
#include "ocean/wash.h"
#include "render/render_testkit.h"

#define NOW 600.0

static struct pel_wash_ship sailing(void)
{
    struct pel_wash_ship s = { 100, 15, 5, .count = 3 };
    pel_wash_waterline(&s);
    /* Along the north, then to the east; now 100 m east of the origin. */
    s.point[0] = (struct pel_wash_point){ 0, -500, -3000, 0, NAN };
    s.point[1] = (struct pel_wash_point){ NOW - 100, -500, 0, 0.8, NAN };
    s.point[2] = (struct pel_wash_point){ NOW, 100, 0, PEL_PI / 2, NAN };
    return s;
}

static struct pel_wash *wash_at(double east_m, double north_m)
{
    struct pel_wash *w;
    struct pel_wash_ship s = sailing();
    for (int i = 0; i < s.count; i++) {
        s.point[i].x_m += east_m;
        s.point[i].y_m += north_m;
    }
    assert_int_equal(pel_wash_create(&w), PEL_OK);
    assert_int_equal(pel_wash_add(w, &s, NOW), PEL_OK);
    assert_int_equal(pel_wash_index(w), PEL_OK);
    return w;
}

static struct pel_wash *a_wash(void)
{
    return wash_at(0, 0);
}

static void a_sea(double wind, bool fft, double whitecaps, struct pel_sea *out)
{
    struct pel_sea_desc desc = test_wind(wind, 3);
    desc.kind = PEL_SPECTRUM_ELFOUHAILY;
    desc.synthesiser = fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS;
    desc.whitecaps = whitecaps;
    assert_int_equal(pel_sea_build(&desc, out), PEL_OK);
}

static void expect_one_surface(const struct pel_sea *sea,
                               const struct pel_wash *w, double east_m,
                               double north_m, const char *what)
{
    struct pel_environment env = test_environment(sea, NOW);
    struct pel_camera c =
        test_camera((struct test_look){ 8, 0, -90, 0, 40, 64, 64 });
    env.wash = w;
    c.east_m = east_m;
    c.north_m = north_m;
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_DEPTH);
    double square = 0, worst = 0, beside = 0;
    for (uint32_t i = 0; i < c.width * c.height; i++) {
        struct pel_vec3 dir =
            test_ray(&c, i % c.width + 0.5, (double)(i / c.width) + 0.5);
        struct pel_vec3 at =
            pel_vec3_scale(dir, (double)p->layer[PEL_AT_DEPTH][i]);
        const struct pel_vec2 place = { east_m + at.x, north_m + at.y };
        struct pel_surface_sample s, plain;
        pel_rest_query(sea, &place, 1, NOW, false, w, &s);
        pel_sea_query(sea, &place, 1, NOW, &plain);
        double error = c.altitude_m + at.z - s.height_m;
        double other = plain.height_m - s.height_m;
        square += error * error / (c.width * c.height);
        beside += other * other / (c.width * c.height);
        worst = fmax(worst, fabs(error));
    }
    printf("%s: %.2f mm rms, worst %.2f; without wash %.2f mm off\n", what,
           1e3 * sqrt(square), 1e3 * worst, 1e3 * sqrt(beside));
    /* As areas': pixels of 9 cm leave out the ripples. */
    assert_true(sqrt(square) < 0.002 && worst < 0.012);
    assert_true(beside > 4 * square);
    pel_picture_release(p);
}

static void drawn_is_queried(void **state)
{
    (void)state;
    renderer = test_renderer(NULL);
    struct pel_wash *w = a_wash();
    for (int fft = 0; fft < 2; fft++) {
        struct pel_sea sea;
        a_sea(6, fft, 0, &sea);
        expect_one_surface(&sea, w, -300, 0, "wake");
        expect_one_surface(&sea, w, -300, 7, "its edge");
        expect_one_surface(&sea, w, -500, -1500, "older");
        pel_sea_finish(&sea);
    }
    pel_wash_destroy(w);
    pel_renderer_destroy(renderer);
}

/* Means of a layer and of the reference over one window. */
static void mean_of(const struct pel_sea *sea, const struct pel_wash *w,
                    double east_m, double north_m, int layer, unsigned bit,
                    double *out)
{
    struct pel_environment env = test_environment(sea, NOW);
    struct pel_camera c =
        test_camera((struct test_look){ 200, 0, -90, 0, 6, 64, 64 });
    env.wash = w;
    c.east_m = east_m;
    c.north_m = north_m;
    struct pel_picture *p = test_draw(renderer, &env, &c, bit);
    *out = 0;
    for (uint32_t i = 0; i < 64 * 64; i++) {
        int parts = layer == PEL_AT_SLOPE_VARIANCE ? 2 : 1;
        *out += (double)p->layer[layer][i * (uint32_t)parts] / (64 * 64);
    }
    pel_picture_release(p);
}

static void shading_follows(void **state)
{
    (void)state;
    renderer = test_renderer(NULL);
    struct pel_wash *w = a_wash();
    for (int fft = 0; fft < 2; fft++) {
        struct pel_sea sea;
        double in, beside;
        a_sea(8, fft, 0, &sea);
        mean_of(&sea, w, -500, -1500, PEL_AT_SLOPE_VARIANCE,
                PEL_LAYER_SLOPE_VARIANCE, &in);
        mean_of(&sea, NULL, -500, -1500, PEL_AT_SLOPE_VARIANCE,
                PEL_LAYER_SLOPE_VARIANCE, &beside);
        double up = pel_wash_at(w, -500, -1500, 0).up;
        printf("variance %.3f of the sea's, factor² %.3f\n", in / beside,
               up * up);
        /* Pixels of 0.3 m; all that is left to them is short. The factor
         * changes by some hundredths in the window of 21 m. */
        assert_float_equal(in / beside, up * up, 0.03);
        pel_sea_finish(&sea);
    }
    pel_wash_destroy(w);
    pel_renderer_destroy(renderer);
}

/* Queried foam of the same window, every metre. */
static double mean_asked(const struct pel_sea *sea, const struct pel_wash *w,
                         double east_m, double north_m)
{
    struct pel_vec2 at[441];
    struct pel_surface_sample s[441];
    double sum = 0;
    for (int k = 0; k < 441; k++) {
        at[k] =
            (struct pel_vec2){ east_m + k % 21 - 10, north_m + k / 21 - 10 };
    }
    pel_rest_query(sea, at, 441, NOW, false, w, s);
    pel_foam_query(sea, w, 441, NOW, s);
    for (int k = 0; k < 441; k++) {
        sum += s[k].foam / 441;
    }
    return sum;
}

/* The mean of its lace is the share that the reference has. */
static void foam_has_its_share(void **state)
{
    (void)state;
    renderer = test_renderer(NULL);
    struct pel_sea sea;
    a_sea(3, true, 1, &sea); /* no whitecaps */
    enum { SHIPS = 24, PLACES = 4 };
    double drawn = 0, wanted = 0, asked = 0, plain;
    for (int i = 0; i < SHIPS * PLACES; i++) {
        double foam, east = 137.0 * (i / PLACES), north = 53.0 * (i / PLACES);
        double x = east + 30 - 35.0 * (i % PLACES);
        struct pel_wash *w = wash_at(east, north);
        mean_of(&sea, w, x, north, PEL_AT_FOAM, PEL_LAYER_FOAM, &foam);
        drawn += foam / (SHIPS * PLACES);
        for (int k = 0; k < 441; k++) {
            double dx = k % 21 - 10.0, dy = k / 21 - 10.0;
            wanted += pel_wash_at(w, x + dx, north + dy, 0).foam /
                      (SHIPS * PLACES * 441);
        }
        asked += mean_asked(&sea, w, x, north) / (SHIPS * PLACES);
        pel_wash_destroy(w);
    }
    mean_of(&sea, NULL, 30, 0, PEL_AT_FOAM, PEL_LAYER_FOAM, &plain);
    assert_true(plain == 0);
    printf("foam %.3f drawn, %.3f wanted, %.3f asked\n", drawn, wanted, asked);
    /* A structure whose patches are up to 20 m wide, of 24 ships. */
    assert_true(wanted > 0.1);
    assert_float_equal(drawn, wanted, 0.08 * wanted);
    /* The waves carry the water some centimetres. */
    assert_float_equal(asked, wanted, 0.01 * wanted);
    pel_sea_finish(&sea);
    pel_renderer_destroy(renderer);
}

#define WIDTH 160
#define HEIGHT 96
#define PIXELS (WIDTH * HEIGHT)

static struct pel_picture *look(const struct pel_environment *env, bool half)
{
    struct pel_camera c =
        test_camera((struct test_look){ 20, 300, -12, 0, 70, WIDTH, HEIGHT });
    c.east_m = 60;
    c.auto_exposure = false;
    c.exposure_ev = 14;
    if (half) {
        c.width /= 2;
        c.tan_right = 0;
    }
    return test_draw(renderer, env, &c, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
}

/* By fragments and in one dispatch; parts, and after other pictures, the same
 * bits; without wash those of a renderer that never had any. */
static void ways_parts_and_orders(void **state)
{
    (void)state;
    static uint8_t seen[2][2][4 * PIXELS];
    static const char *const ways[2] = { "fragment", "compute" };
    struct pel_wash *w = a_wash();
    for (int way = 0; way < 2; way++) {
        renderer = test_renderer(ways[way]);
        for (int fft = 0; fft < 2; fft++) {
            struct pel_sea sea;
            a_sea(9, fft, 1, &sea);
            struct pel_environment env = test_environment(&sea, NOW);
            struct pel_picture *never = look(&env, false);
            env.wash = w;
            struct pel_picture *a = look(&env, false);
            struct pel_picture *half = look(&env, true);
            env.wash = NULL;
            struct pel_picture *off = look(&env, false);
            env.wash = w;
            struct pel_picture *again = look(&env, false);
            memcpy(seen[way][fft], a->rgba, sizeof seen[0][0]);
            assert_memory_equal(never->radiance, off->radiance, 16 * PIXELS);
            assert_memory_equal(a->radiance, again->radiance, 16 * PIXELS);
            assert_true(memcmp(a->rgba, off->rgba, sizeof seen[0][0]));
            for (int y = 0; y < HEIGHT; y++) {
                assert_memory_equal(half->radiance + 4 * (y * WIDTH / 2),
                                    a->radiance + 4 * (y * WIDTH), 8 * WIDTH);
            }
            pel_picture_release(never);
            pel_picture_release(a);
            pel_picture_release(half);
            pel_picture_release(off);
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
    pel_wash_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(drawn_is_queried),
        cmocka_unit_test(shading_follows),
        cmocka_unit_test(foam_has_its_share),
        cmocka_unit_test(ways_parts_and_orders),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
