/* A climb from 1 m to 8 km: nothing pops. What is drawn from two heights that
 * differ by a ten-thousandth must hardly differ, above all where tables change:
 * the sky's are made for heights in fractions of an octave
 * (pel_sky_quantize_height), and the mesh's rings and columns come in whole
 * numbers. */
#include "render/render_testkit.h"

#define WIDTH 128
#define HEIGHT 96

static struct pel_sea sea;

/* Mean green radiance of each row. */
static void rows_from(double height_m, double pitch, double out[HEIGHT])
{
    struct pel_environment env = test_environment(&sea, 20.0);
    env.lights[PEL_LIGHT_SUN].direction =
        test_sun(30.0, 220.0); /* behind: a glint may come and go */
    struct pel_camera c = test_camera(
        (struct test_look){ height_m, 40.0, pitch, 0.0, 50.0, WIDTH, HEIGHT });
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
    for (int y = 0; y < HEIGHT; y++) {
        out[y] = 0;
        for (int x = 0; x < WIDTH; x++) {
            out[y] += p->radiance[4 * (y * WIDTH + x) + 1] / WIDTH;
        }
    }
    pel_picture_release(p);
}

struct jump {
    double whole, row, whole_at_m, row_at_m;
};

static void compare(double height_m, double pitch, struct jump *worst)
{
    double below[HEIGHT], above[HEIGHT], sum[2] = { 0 }, row = 0;
    rows_from(height_m * (1 - 5e-5), pitch, below);
    rows_from(height_m * (1 + 5e-5), pitch, above);
    for (int y = 0; y < HEIGHT; y++) {
        sum[0] += below[y];
        sum[1] += above[y];
    }
    for (int y = 0; y < HEIGHT; y++) {
        row = fmax(row, fabs(above[y] - below[y]) * HEIGHT / sum[0]);
    }
    double whole = fabs(sum[1] / sum[0] - 1);
    if (whole > worst->whole) {
        worst->whole = whole;
        worst->whole_at_m = height_m;
    }
    if (row > worst->row) {
        worst->row = row;
        worst->row_at_m = height_m;
    }
}

/* Of the mean radiance, where the eye sees half a per cent: the picture a fifth
 * of that, a row of 128 pixels all. */
#define WHOLE 1e-3
#define ROW 5e-3

static void climb(bool fft, double pitch)
{
    struct jump edges = { 0 }, between = { 0 };
    if (fft) {
        test_fft_sea(8.0, 3, &sea);
    } else {
        test_sea(8.0, 0.0, 3, &sea);
    }
    for (int i = 0; i < 208; i += 8) { /* 1 m to 8 km, every half octave */
        double octave = i / 16.0;
        double steps = octave < 6.0 ? 16.0 : octave < 8.0 ? 64.0 : 256.0;
        compare(exp2(octave + 0.5 / steps), pitch, &edges);
        compare(exp2(octave + 5.3 / 16.0), pitch, &between);
    }
    print_message("%s, pitch %g: the picture jumps by %.4f %% at %.1f m "
                  "(elsewhere %.4f %%), a row by %.3f %% at %.1f m (%.3f %%)\n",
                  fft ? "FFT" : "trochoids", pitch, 100 * edges.whole,
                  edges.whole_at_m, 100 * between.whole, 100 * edges.row,
                  edges.row_at_m, 100 * between.row);
    assert_true(edges.whole < WHOLE && between.whole < WHOLE);
    assert_true(edges.row < ROW && between.row < ROW);
    pel_sea_finish(&sea);
}

static void nothing_pops(void **state)
{
    (void)state;
    climb(false, -12.0);
    climb(true, -12.0);
    climb(true, -60.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_pops),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
