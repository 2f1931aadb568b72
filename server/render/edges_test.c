/* Outlines against the mean of pictures without antialiasing whose pixels are
 * shifted by parts of a pixel: the same surface, 64 samples a pixel. */
#include "render/edges.h"
#include "render/render_testkit.h"

#define WIDTH 192
#define HEIGHT 96
#define PIXELS (WIDTH * HEIGHT)
#define SIDE 8 /* samples along a side of a pixel */

/* What is drawn, and what pixels that outlines cut are allowed to be off. */
struct scene {
    const char *name;
    double wind_mps, height_m, pitch, roll, fov, sun, sun_azimuth;
    bool fft;
    double share; /* of the error without, root mean square */
};

struct mean {
    double light[PIXELS][3];
    float least[PIXELS], most[PIXELS]; /* depth */
};

static struct pel_camera camera_of(const struct scene *s, bool antialiasing)
{
    struct pel_camera c = test_camera((struct test_look){
        s->height_m, 0.0, s->pitch, s->roll, s->fov, WIDTH, HEIGHT });
    c.antialiasing = antialiasing;
    return c;
}

static struct pel_camera shifted(struct pel_camera c, double x, double y)
{
    double px = (c.tan_right - c.tan_left) / c.width;
    double py = (c.tan_top - c.tan_bottom) / c.height;
    c.tan_left += x * px;
    c.tan_right += x * px;
    c.tan_top -= y * py;
    c.tan_bottom -= y * py;
    return c;
}

static void mean_of(const struct pel_environment *env, const struct scene *s,
                    struct mean *out)
{
    const struct pel_camera c = camera_of(s, false);
    memset(out->light, 0, sizeof out->light);
    for (int k = 0; k < SIDE * SIDE; k++) {
        const struct pel_camera at = shifted(c, (k % SIDE + 0.5) / SIDE - 0.5,
                                             (k / SIDE + 0.5) / SIDE - 0.5);
        struct pel_picture *p =
            test_draw(renderer, env, &at, PEL_LAYER_RADIANCE | PEL_LAYER_DEPTH);
        for (int i = 0; i < PIXELS; i++) {
            float depth = fminf(p->depth[i], 1e6F);
            for (int j = 0; j < 3; j++) {
                out->light[i][j] +=
                    (double)p->radiance[4 * i + j] / (SIDE * SIDE);
            }
            out->least[i] = k ? fminf(out->least[i], depth) : depth;
            out->most[i] = k ? fmaxf(out->most[i], depth) : depth;
        }
        pel_picture_release(p);
    }
}

/* Whether an outline cuts the pixel: what is seen in it lies far apart, more
 * than the surface's slant makes it. */
static bool is_cut(const struct mean *m, int i)
{
    return m->most[i] > 1.5F * m->least[i];
}

/* Root mean square of a colour of the cut pixels, as part of their mean. */
static double error_of(const struct pel_picture *p, const struct mean *m,
                       int *count)
{
    double off = 0, all = 0;
    *count = 0;
    for (int i = 0; i < PIXELS; i++) {
        for (int j = 0; j < 3 && is_cut(m, i); j++) {
            double d = (double)p->radiance[4 * i + j] - m->light[i][j];
            off += d * d;
            all += m->light[i][j];
            ++*count;
        }
    }
    return sqrt(off / *count) / (all / *count);
}

static void compare(const struct scene *s)
{
    static struct mean mean;
    struct pel_sea *sea = malloc(sizeof *sea);
    assert_non_null(sea);
    if (s->fft) {
        test_fft_sea(s->wind_mps, 7, sea);
    } else {
        test_sea(s->wind_mps, 0.0, 7, sea);
    }
    struct pel_environment env = test_environment(sea, 20.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(s->sun, s->sun_azimuth);
    mean_of(&env, s, &mean);
    double error[2];
    int count = 0;
    for (int on = 0; on < 2; on++) {
        const struct pel_camera c = camera_of(s, on);
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
        error[on] = error_of(p, &mean, &count);
        pel_picture_release(p);
    }
    printf("%s: %d pixels cut, error %.4f without, %.4f with\n", s->name,
           count / 3, error[0], error[1]);
    assert_true(count / 3 > WIDTH / 4);
    assert_true(error[1] < s->share * error[0]);
    pel_sea_finish(sea);
    free(sea);
}

static void outlines_are_the_mean_of_many_samples(void **state)
{
    (void)state;
    static const struct scene scenes[] = {
        { "horizon", 5, 6, 0, 0, 20, 30, 40, true, 0.5 },
        { "horizon rolled", 5, 6, 0, 30, 20, 30, 40, true, 0.5 },
        { "storm from 2 m", 20, 2, 0, 0, 60, 30, 140, true, 0.5 },
        { "storm from 4 m", 20, 4, 0, 0, 60, 30, 140, true, 0.5 },
        { "storm from 6 m", 20, 6, -3, 0, 60, 30, 140, true, 0.5 },
        { "storm rolled", 20, 4, 0, 40, 60, 30, 140, true, 0.5 },
        { "trochoids", 15, 3, 0, 0, 60, 30, 140, false, 0.5 },
        { "towards the Sun", 15, 3, 0, 0, 60, 15, 40, true, 0.5 },
    };
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        compare(&scenes[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(outlines_are_the_mean_of_many_samples),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
