/* Whitecaps as they are drawn: the same coverage at every distance and size of
 * pixels, by fragments and in one dispatch, in parts and in any order, and
 * nothing without them. */
#include "ocean/foam.h"
#include "render/render_testkit.h"

static void foamy(double wind, bool fft, double whitecaps, struct pel_sea *out)
{
    struct pel_sea_desc desc = test_wind(wind, 3);
    desc.synthesiser = fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS;
    desc.whitecaps = whitecaps;
    assert_int_equal(pel_sea_build(&desc, out), PEL_OK);
}

/* Mean of the layer over a square of the sea, straight down, and of its square.
 */
static double means_of_foam(const struct pel_environment *env, double height_m,
                            double side_m, uint32_t pixels, double *squared)
{
    double fov = 2 * atan(0.5 * side_m / height_m) / PEL_DEG;
    struct pel_camera c = test_camera(
        (struct test_look){ height_m, 0, -90, 0, fov, pixels, pixels });
    struct pel_picture *p = test_draw(renderer, env, &c, PEL_LAYER_FOAM);
    double sum = 0;
    *squared = 0;
    for (uint32_t i = 0; i < pixels * pixels; i++) {
        double foam = (double)p->layer[PEL_AT_FOAM][i];
        sum += foam / (pixels * pixels);
        *squared += foam * foam / (pixels * pixels);
    }
    pel_picture_release(p);
    return sum;
}

static double mean_foam(const struct pel_environment *env, double height_m,
                        double side_m, uint32_t pixels)
{
    double squared;
    return means_of_foam(env, height_m, side_m, pixels, &squared);
}

static void coverage_is_the_same_everywhere(void **state)
{
    (void)state;
    renderer = test_renderer(NULL);
    for (int fft = 0; fft < 2; fft++) {
        struct pel_sea sea;
        foamy(16, fft, 1, &sea);
        struct pel_environment env = test_environment(&sea, 30);
        double goal = PEL_FOAM_DENSE * sea.foam->coverage;
        /* The same square kilometre by pixels of 2, 4 and 10 m, from 8 km. */
        double fine = mean_foam(&env, 2000, 1000, 500);
        double half = mean_foam(&env, 2000, 1000, 250);
        double coarse = mean_foam(&env, 2000, 1000, 100);
        double far = mean_foam(&env, 8000, 8000, 100);
        print_message("%s: %.4f; of it 2 m %.3f, 4 m %.3f, 10 m %.3f, 80 m %.3f"
                      "\n",
                      fft ? "cascades" : "trochoids", goal, fine / goal,
                      half / goal, coarse / goal, far / goal);
        /* Sixty waves: of those that large pixels resolve so few are left that
         * their sum is not normal. */
        assert_float_equal(far / goal, 1, fft ? 0.04 : 0.1);
        /* A square kilometre holds some hundred groups of waves, each with foam
         * or without. */
        assert_float_equal(fine / goal, 1, 0.15);
        assert_float_equal(half / fine, 1, 0.05);
        assert_float_equal(coarse / fine, 1, 0.1);
        pel_sea_finish(&sea);
    }
    pel_renderer_destroy(renderer);
}

/* Where wind tears foam about, it is as much from near, where that is seen, as
 * from where it is not; and seen so, pixels have more of it or less. */
static void torn_is_as_much(void **state)
{
    (void)state;
    struct pel_sea sea;
    double near = 0, far = 0, near_squared = 0, far_squared = 0;
    renderer = test_renderer(NULL);
    foamy(20, true, 1, &sea);
    for (int k = 0; k < 4; k++) {
        const struct pel_environment env = test_environment(&sea, 30 + 40 * k);
        double squared;
        near += means_of_foam(&env, 1000, 250, 1250, &squared);
        near_squared += squared;
        far += means_of_foam(&env, 1000, 250, 200, &squared);
        far_squared += squared;
    }
    print_message("pixels of 0.2 m: %.4f of the water, %.3f of that in full; "
                  "of 1.25 m: %.4f, %.3f\n",
                  near / 4, near_squared / near, far / 4, far_squared / far);
    /* Of four squares of 250 m, with a tile of 5 m. */
    assert_float_equal(near / far, 1, 0.02);
    /* Without it by 0.08. */
    assert_true(near_squared / near > far_squared / far + 0.1);
    pel_sea_finish(&sea);
    pel_renderer_destroy(renderer);
}

#define SIDE 512  /* pixels of 0.25 m */
#define SQUARES 8 /* a side, of 16 m */
#define OF (SIDE / SQUARES)

/* Drawn and queried foam of a nadir picture, means over squares. */
static void squares_of(const struct pel_environment *env,
                       double drawn[SQUARES * SQUARES],
                       double asked[SQUARES * SQUARES])
{
    static struct pel_vec2 at[SIDE];
    static struct pel_surface_sample samples[SIDE];
    const double height_m = 2000, pixel_m = 0.25;
    struct pel_camera c = test_camera((struct test_look){
        height_m, 0, -90, 0,
        2 * atan(0.5 * SIDE * pixel_m / height_m) / PEL_DEG, SIDE, SIDE });
    struct pel_picture *p = test_draw(renderer, env, &c, PEL_LAYER_FOAM);
    for (int row = 0; row < SIDE; row++) {
        for (int i = 0; i < SIDE; i++) {
            at[i] = (struct pel_vec2){ (i + 0.5 - SIDE / 2) * pixel_m,
                                       (SIDE / 2 - row - 0.5) * pixel_m };
        }
        pel_sea_query(env->sea, at, SIDE, env->time_s, samples);
        pel_foam_query(env->sea, NULL, SIDE, env->time_s, samples);
        for (int i = 0; i < SIDE; i++) {
            int square = row / OF * SQUARES + i / OF;
            drawn[square] +=
                (double)p->layer[PEL_AT_FOAM][row * SIDE + i] / (OF * OF);
            asked[square] += samples[i].foam / (OF * OF);
        }
    }
    pel_picture_release(p);
}

/* No streaks, whose tile is longer than the picture; more foam than that wind
 * has, so that most squares have some. What differs is the structure, which a
 * square of its tile's width does not average out: a tenth of the mean of all,
 * and a third of the deviation from square to square. With the sign of Y
 * turned round they have 0.66 in common. */
static void queried_is_drawn(void **state)
{
    (void)state;
    enum { COUNT = SQUARES * SQUARES };
    renderer = test_renderer(NULL);
    for (int fft = 0; fft < 2; fft++) {
        struct pel_sea sea;
        foamy(12, fft, 4, &sea);
        struct pel_environment env = test_environment(&sea, 30);
        double drawn[COUNT] = { 0 }, asked[COUNT] = { 0 };
        squares_of(&env, drawn, asked);
        double d = 0, a = 0, dd = 0, da = 0, aa = 0, off = 0;
        for (int i = 0; i < COUNT; i++) {
            d += drawn[i] / COUNT;
            a += asked[i] / COUNT;
        }
        for (int i = 0; i < COUNT; i++) {
            dd += (drawn[i] - d) * (drawn[i] - d) / COUNT;
            da += (drawn[i] - d) * (asked[i] - a) / COUNT;
            aa += (asked[i] - a) * (asked[i] - a) / COUNT;
            off += (drawn[i] - asked[i]) * (drawn[i] - asked[i]) / COUNT;
        }
        double together = da / sqrt(dd * aa);
        print_message("%s: drawn %.4f +- %.4f, asked %.4f +- %.4f, apart "
                      "%.4f, together %.3f\n",
                      fft ? "cascades" : "trochoids", d, sqrt(dd), a, sqrt(aa),
                      sqrt(off), together);
        assert_float_equal(d / a, 1, 0.15);
        assert_true(off < 0.15 * dd);
        assert_true(together > 0.95);
        pel_sea_finish(&sea);
    }
    pel_renderer_destroy(renderer);
}

#define PIXELS (192 * 128)

static struct pel_picture *storm(struct pel_renderer *r,
                                 const struct pel_environment *env,
                                 unsigned layers)
{
    struct pel_camera c =
        test_camera((struct test_look){ 9, 30, -8, 0, 60, 192, 128 });
    return test_draw(r, env, &c, layers);
}

static void both_ways_draw_the_same(void **state)
{
    (void)state;
    static float seen[2][2][PIXELS];
    static const char *const ways[2] = { "fragment", "compute" };
    for (int way = 0; way < 2; way++) {
        renderer = test_renderer(ways[way]);
        for (int fft = 0; fft < 2; fft++) {
            struct pel_sea sea;
            foamy(22, fft, 1, &sea);
            struct pel_environment env = test_environment(&sea, 12);
            struct pel_picture *p = storm(renderer, &env, PEL_LAYER_FOAM);
            memcpy(seen[way][fft], p->layer[PEL_AT_FOAM], sizeof seen[0][0]);
            pel_picture_release(p);
            pel_sea_finish(&sea);
        }
        pel_renderer_destroy(renderer);
    }
    for (int fft = 0; fft < 2; fft++) {
        int other = 0;
        double most = 0;
        for (int i = 0; i < PIXELS; i++) {
            double x = (double)seen[0][fft][i], y = (double)seen[1][fft][i];
            other += fabs(x - y) > 1e-3;
            most = fmax(most, x);
        }
        /* Beside a triangle's edge one may see the next. */
        print_message("%d pixels differ\n", other);
        assert_true(other <= 24);
        assert_true(most > 0.5);
    }
}

static void other_moments_leave_nothing(void **state)
{
    (void)state;
    renderer = test_renderer(NULL);
    for (int fft = 0; fft < 2; fft++) {
        struct pel_sea sea;
        foamy(22, fft, 1, &sea);
        struct pel_environment env = test_environment(&sea, 12);
        struct pel_picture *a = storm(renderer, &env, PEL_LAYER_COLOR);
        env.time_s = 50;
        struct pel_picture *b = storm(renderer, &env, PEL_LAYER_COLOR);
        env.time_s = 12;
        struct pel_picture *c = storm(renderer, &env, PEL_LAYER_COLOR);
        assert_memory_equal(a->rgba, c->rgba, 192 * 128 * 4);
        assert_true(memcmp(a->rgba, b->rgba, 192 * 128 * 4) != 0);
        pel_picture_release(a);
        pel_picture_release(b);
        pel_picture_release(c);
        pel_sea_finish(&sea);
    }
    pel_renderer_destroy(renderer);
}

/* A sea after one with foam is drawn as by a renderer that saw none. */
static void without_it_nothing_changes(void **state)
{
    (void)state;
    static uint8_t seen[2][2][4 * PIXELS];
    for (int after = 0; after < 2; after++) {
        renderer = test_renderer(NULL);
        for (int fft = 0; fft < 2; fft++) {
            struct pel_sea sea;
            if (after) {
                foamy(22, fft, 1, &sea);
                struct pel_environment env = test_environment(&sea, 12);
                pel_picture_release(storm(renderer, &env, PEL_LAYER_COLOR));
                pel_sea_finish(&sea);
            }
            foamy(22, fft, 0, &sea);
            struct pel_environment env = test_environment(&sea, 12);
            struct pel_picture *p = storm(renderer, &env, PEL_LAYER_COLOR);
            memcpy(seen[after][fft], p->rgba, sizeof seen[0][0]);
            pel_picture_release(p);
            pel_sea_finish(&sea);
        }
        pel_renderer_destroy(renderer);
    }
    assert_memory_equal(seen[0], seen[1], sizeof seen[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coverage_is_the_same_everywhere),
        cmocka_unit_test(torn_is_as_much),
        cmocka_unit_test(queried_is_drawn),
        cmocka_unit_test(both_ways_draw_the_same),
        cmocka_unit_test(other_moments_leave_nothing),
        cmocka_unit_test(without_it_nothing_changes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
