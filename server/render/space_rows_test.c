/* Rows of the sea from 2 m to 400 km, an octave of height at a time, without
 * the air before them. A row is seen at one angle where it lies, under one sky,
 * Sun and wind: what is left to change is the form of what is drawn. From low
 * down a picture shows few waves, so a row is the mean over places and moments,
 * as many as its noise asks for.
 *
 *     space_rows_test [--long]     every octave, four angles, less noise
 */
#include "render/render_testkit.h"

#include "optics/atmosphere.h"

#define WIDTH 128
#define HEIGHT 8
#define PIXELS (WIDTH * HEIGHT)

/* Moments that a row is the mean of, and places of each. */
enum { LEAST = 8, LEAST_LONG = 16, MOST = 2000, PLACES = 8 };

#define HEADING 40.0
#define SUN_ELEVATION                                                          \
    25.0 /* straight below next to no glint, which is few facets */
#define SUN_ASIDE 120.0

/* Largest change an octave, of luminance; what the mean has of noise is added
 * twice. */
#define BAR 0.01
#define HIGHEST 4e5

static bool is_long;

struct row {
    double value, noise; /* of itself */
    int places;
};

/* Heading and Sun are the same where the row lies, γ round the Earth. */
static void see(double height_m, double below, struct pel_camera *camera,
                struct pel_vec3 *sun)
{
    double zenith = (90 - below) * PEL_DEG;
    double nadir =
        asin(sin(zenith) * PEL_EARTH_RADIUS / (PEL_EARTH_RADIUS + height_m));
    double round = zenith - nadir;
    double e = SUN_ELEVATION * PEL_DEG, a = SUN_ASIDE * PEL_DEG;
    double ahead = cos(e) * cos(a), up = sin(e);
    double here = up * cos(round) - ahead * sin(round);
    double there = ahead * cos(round) + up * sin(round);
    *camera = test_camera((struct test_look){
        height_m, HEADING, nadir / PEL_DEG - 90, 0.0, 30.0, WIDTH, HEIGHT });
    *sun = test_sun(asin(here) / PEL_DEG,
                    HEADING + atan2(cos(e) * sin(a), there) / PEL_DEG);
}

/* Luminance, by weights of 680, 550 and 440 nm in daylight. */
static double luminance(const struct pel_picture *p)
{
    static const double weight[3] = { 0.285, 0.70, 0.015 };
    double sum = 0;
    for (int k = 0; k < HEIGHT * WIDTH; k++) {
        for (int c = 0; c < 3; c++) {
            sum += weight[c] * (double)p->radiance[4 * k + c] / PIXELS;
        }
    }
    return sum;
}

static double moment(const struct pel_environment *env,
                     const struct pel_camera *camera, uint64_t *random)
{
    double sum = 0;
    for (int i = 0; i < PLACES; i++) {
        struct pel_camera c = *camera;
        c.east_m = test_random(random, -50e3, 50e3);
        c.north_m = test_random(random, -50e3, 50e3);
        struct pel_picture *p =
            test_draw(renderer, env, &c, PEL_LAYER_RADIANCE);
        sum += luminance(p) / PLACES;
        pel_picture_release(p);
    }
    return sum;
}

static struct row row_from(const struct pel_sea *sea, double height_m,
                           double below, double wanted)
{
    struct pel_environment env = test_environment(sea, 20.0);
    struct pel_camera camera;
    uint64_t random = 11;
    double sum = 0, squares = 0;
    struct row row = { .noise = 1 };
    see(height_m, below, &camera, &env.lights[PEL_LIGHT_SUN].direction);
    env.sparkle = false;
    env.no_air = true;
    int least = is_long ? LEAST_LONG : LEAST;
    for (int n = 1; n <= least || (row.noise > wanted && n <= MOST); n++) {
        env.time_s = test_random(&random, 10, 4000);
        double now = moment(&env, &camera, &random);
        sum += now;
        squares += now * now;
        row.places = n * PLACES;
        row.value = sum / n;
        row.noise =
            n < 2
                ? 1
                : sqrt(fmax(squares / n - row.value * row.value, 0) / (n - 1)) /
                      row.value;
    }
    return row;
}

static void rise(const struct pel_sea *sea, double below, double wanted)
{
    struct row before = { 0 };
    double worst = 0, from = 0, to = 2, noisy = 0;
    for (;;) {
        struct row now = row_from(sea, to, below, wanted);
        double octaves = from > 0 ? log2(to / from) : 1;
        double change = from > 0 ? now.value / before.value - 1 : 0;
        double noise = hypot(now.noise, before.noise);
        print_message(
            "%9.0f m %4.0f° below: %+6.2f %%, noise %.2f %%, bar %.1f "
            "%%, %d places\n",
            to, below, 100 * change, 100 * noise, 100 * BAR * fmax(octaves, 1),
            now.places);
        assert_true(now.noise < 1.5 * wanted);
        assert_true(fabs(change) < BAR * fmax(octaves, 1) + 2 * noise);
        worst = fmax(worst, fabs(change) / fmax(octaves, 1));
        noisy = fmax(noisy, now.noise);
        if (to >= HIGHEST) {
            break;
        }
        before = now;
        from = to;
        to = fmin(to * (is_long ? 2 : 8), HIGHEST);
    }
    print_message("%4.0f° below: %.2f %% an octave at most, noise of a height "
                  "%.2f %%\n",
                  below, 100 * worst, 100 * noisy);
}

static void octaves(void **state)
{
    (void)state;
    const double below[] = { 90, 35, 60, 22 };
    struct pel_sea sea;
    test_fft_sea(7.0, 3, &sea);
    for (int i = 0; i < (is_long ? 4 : 2); i++) {
        rise(&sea, below[i], is_long ? 0.003 : 0.012);
    }
    pel_sea_finish(&sea);
}

int main(int argc, char **argv)
{
    is_long = argc > 1 && strcmp(argv[1], "--long") == 0;
    const struct CMUnitTest tests[] = { cmocka_unit_test(octaves) };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
