/* The sea from high up under winds that differ by place: each place as the sea
 * of its wind is everywhere, times between those of the field, poles. */
#include "render/render_testkit.h"

#include "weather/weather.h"

#define WIDTH 96
#define HEIGHT 72
#define PIXELS (WIDTH * HEIGHT)
#define COLUMNS 36
#define ROWS 181
#define TIMES 2
#define BLOWS_TO 0.4 /* of test_wind */

/* Winds of the southern and the northern half, at both times. */
static const struct pel_weather *field_of(const double mps[TIMES][2])
{
    static const double unix_s[TIMES] = { 1.7e9, 1.7e9 + 3600 };
    static int16_t values[2][TIMES][ROWS][COLUMNS];
    for (int t = 0; t < TIMES; t++) {
        for (int y = 0; y < ROWS; y++) {
            double v = y < ROWS / 2   ? mps[t][0]
                       : y > ROWS / 2 ? mps[t][1]
                                      : 0.5 * (mps[t][0] + mps[t][1]);
            for (int x = 0; x < COLUMNS; x++) {
                values[0][t][y][x] = pel_weather_quantise(PEL_WEATHER_WIND_EAST,
                                                          v * cos(BLOWS_TO));
                values[1][t][y][x] = pel_weather_quantise(
                    PEL_WEATHER_WIND_NORTH, v * sin(BLOWS_TO));
            }
        }
    }
    const struct pel_weather_grid grid = {
        .columns = COLUMNS,
        .rows = ROWS,
        .times = TIMES,
        .west_deg = -180,
        .south_deg = -90,
        .east_step = 10,
        .north_step = 1,
        .unix_s = unix_s,
        .values = { [PEL_WEATHER_WIND_EAST] = &values[0][0][0][0],
                    [PEL_WEATHER_WIND_NORTH] = &values[1][0][0][0] },
    };
    const struct pel_weather *field;
    struct pel_fault fault;
    if (pel_weather_create(&grid, &field, &fault) != PEL_OK) {
        fail_msg("%s", fault.message);
    }
    return field;
}

static struct pel_sea sea;

static struct pel_environment day(double sun_deg)
{
    struct pel_environment env = test_environment(&sea, 20.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(sun_deg, 140.0);
    env.sparkle = false;
    return env;
}

static struct pel_picture *draw(const struct pel_environment *env,
                                double height_m, double pitch)
{
    struct pel_camera c = test_camera(
        (struct test_look){ height_m, 0.0, pitch, 0.0, 50.0, WIDTH, HEIGHT });
    return test_draw(renderer, env, &c, PEL_LAYER_RADIANCE);
}

/* At most, of one of the wavelengths, in rows [from, to). */
static double off(const struct pel_picture *is, const struct pel_picture *to_be,
                  int from, int to)
{
    double worst = 0;
    for (int k = 4 * from * WIDTH; k < 4 * to * WIDTH; k++) {
        if (k % 4 < 3) {
            worst = fmax(
                worst,
                fabs((double)is->radiance[k] / (double)to_be->radiance[k] - 1));
        }
    }
    return worst;
}

/* With whitecaps, which from 12 m/s on are seen from afar. */
static void build(double mps, bool fft)
{
    struct pel_sea_desc desc = test_wind(mps, 3);
    desc.synthesiser = fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS;
    desc.whitecaps = 1;
    assert_int_equal(pel_sea_build(&desc, &sea), PEL_OK);
}

static struct pel_picture *uniform(double mps, bool fft, double sun,
                                   double height_m)
{
    pel_sea_finish(&sea);
    build(mps, fft);
    struct pel_environment env = day(sun);
    return draw(&env, height_m, -90);
}

/* Straight down on the equator: its southern and its northern half. */
static void halves(void **state)
{
    (void)state;
    const double mps[TIMES][2] = { { 4, 12 }, { 4, 12 } };
    const struct pel_weather *field = field_of(mps);
    for (int i = 0; i < 4; i++) {
        bool fft = i / 2;
        double sun = i % 2 ? 30 : 65; /* beside the glitter, and in it */
        build(8, fft);
        struct pel_picture *calm = uniform(4, fft, sun, 2e6),
                           *rough = uniform(12, fft, sun, 2e6);
        pel_picture_release(uniform(8, fft, sun, 2e6));
        struct pel_environment env = day(sun);
        env.weather = field;
        env.weather_unix_s = 1.7e9;
        struct pel_picture *p = draw(&env, 2e6, -90);
        /* About the equator they are mixed, a dozen rows. */
        double north = off(p, rough, 0, 28), south = off(p, calm, 44, 72);
        print_message("%s, Sun %g: 12 m/s off by %.2f %%, 4 m/s by %.2f %%; "
                      "the two differ by %.0f %%\n",
                      fft ? "FFT" : "trochoids", sun, 100 * north, 100 * south,
                      100 * off(rough, calm, 0, 72));
        /* Light between waves is by the scene's slopes, and a wave stands for
         * a band of the spectrum. */
        assert_true(north < 0.03 && south < 0.03);
        assert_true(off(rough, calm, 0, 72) > 0.2);
        pel_picture_release(calm);
        pel_picture_release(rough);
        pel_picture_release(p);
        pel_sea_finish(&sea);
    }
    pel_weather_unref(field);
}

/* A field of the scene's own wind changes nothing. */
static void own_wind(void **state)
{
    (void)state;
    const double mps[TIMES][2] = { { 8, 8 }, { 8, 8 } };
    const struct pel_weather *field = field_of(mps);
    for (int fft = 0; fft < 2; fft++) {
        build(8, fft);
        for (int high = 0; high < 2; high++) {
            struct pel_environment env = day(40);
            double height_m = high ? 4e5 : 12000;
            struct pel_picture *without = draw(&env, height_m, -50);
            env.weather = field;
            env.weather_unix_s = 1.7e9 + 5;
            struct pel_picture *with = draw(&env, height_m, -50);
            double by = off(with, without, 0, HEIGHT);
            print_message("%g km: own wind as a field: off by %.3f %%\n",
                          height_m / 1e3, 100 * by);
            assert_true(by < 0.01); /* winds in 1/256 m/s and 16 bits */
            pel_picture_release(with);
            pel_picture_release(without);
        }
        pel_sea_finish(&sea);
    }
    pel_weather_unref(field);
}

/* Between two times what lies between; the same whatever was drawn before;
 * beyond them, the first and the last. */
static void times(void **state)
{
    (void)state;
    const double mps[TIMES][2] = { { 6, 6 }, { 10, 10 } },
                 middle[TIMES][2] = { { 8, 8 }, { 8, 8 } };
    const struct pel_weather *field = field_of(mps),
                             *between = field_of(middle);
    static float first[4 * PIXELS];
    build(7, false);
    struct pel_environment env = day(60);
    const double at[] = { 1800, 0, -1e6, 3600, 1e6, 1800 };
    struct pel_picture *p[6];
    env.weather = field;
    for (int i = 0; i < 6; i++) {
        env.weather_unix_s = 1.7e9 + at[i];
        p[i] = draw(&env, 4e5, -60);
        if (i == 0) {
            memcpy(first, p[0]->radiance, sizeof first);
        }
    }
    assert_memory_equal(first, p[5]->radiance, sizeof first);
    assert_true(off(p[1], p[2], 0, HEIGHT) < 1e-6);
    assert_true(off(p[3], p[4], 0, HEIGHT) < 1e-6);
    double change = off(p[1], p[3], 0, HEIGHT);
    env.weather = between;
    struct pel_picture *is = draw(&env, 4e5, -60);
    double by = off(p[0], is, 0, HEIGHT);
    print_message("half an hour between 6 and 10 m/s, which differ by %.1f "
                  "%%: off by %.3f %%\n",
                  100 * change, 100 * by);
    /* Winds in 16 bits. */
    assert_true(by < 0.01 && change > 5 * by && change > 0.02);
    for (int i = 0; i < 6; i++) {
        pel_picture_release(p[i]);
    }
    pel_picture_release(is);
    pel_weather_unref(field);
    pel_weather_unref(between);
    pel_sea_finish(&sea);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(halves),
        cmocka_unit_test(own_wind),
        cmocka_unit_test(times),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
