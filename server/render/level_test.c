/* Levels of detail of objects: what a picture changes when one takes another
 * level, beside what it changes when the object moves by a part of a pixel. */
#include "render/objectplan.h"

#include "models/builtin.h"
#include "render/render_testkit.h"

#define WIDTH 320
#define HEIGHT 120
#define FIELD 24.0 /* deg */
#define MOVED_PX 0.5

static struct pel_sea sea;

static struct pel_camera camera(void)
{
    struct pel_camera c = test_camera(
        (struct test_look){ 8.0, 0.0, 1.0, 0.0, FIELD, WIDTH, HEIGHT });
    c.auto_exposure = false;
    c.exposure_ev = 14.0;
    return c;
}

/* Heading 60 degrees, so far north; in the model's axes. */
static const double turned = 60 * PEL_DEG;

static double away_from(const struct pel_model *m, double north_m)
{
    const double eye[3] = { -north_m * cos(turned), -north_m * sin(turned),
                            8.0 };
    const double low[3] = { m->low.x, m->low.y, m->low.z };
    const double high[3] = { m->high.x, m->high.y, m->high.z };
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        double off = eye[i] - fmin(fmax(eye[i], low[i]), high[i]);
        sum += off * off;
    }
    return sqrt(sum);
}

static void draw(const struct pel_model *m, double north_m, double east_m,
                 float *out)
{
    struct pel_environment env = test_environment(&sea, 5.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(35.0, 120.0);
    const struct pel_object object = {
        .id = 1,
        .model = m,
        .north_m = north_m,
        .east_m = east_m,
        .world_from_model = { { sin(turned), cos(turned), 0 },
                              { -cos(turned), sin(turned), 0 },
                              { 0, 0, 1 } },
    };
    env.objects = &object;
    env.object_count = 1;
    struct pel_camera c = camera();
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        out[i] = p->radiance[4 * i + 1];
    }
    pel_picture_release(p);
}

static double step(const float *a, const float *b)
{
    double sum = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double d = (double)b[i] - (double)a[i];
        sum += d * d;
    }
    return sqrt(sum / (WIDTH * HEIGHT));
}

/* The step to level k, by that of a small move to the side, the mean of three
 * places; 0: it would be too close or too far. */
static double pop(const struct pel_model *m, int k)
{
    static float fine[WIDTH * HEIGHT], moved[WIDTH * HEIGHT],
        coarse[WIDTH * HEIGHT];
    double pitch = 2 * tan(0.5 * FIELD * PEL_DEG) / WIDTH;
    double away = (double)m->levels[k].error_m / (PEL_OBJECT_LEVEL_PX * pitch);
    double low = 0, high = 80000;
    for (int i = 0; i < 60; i++) {
        double middle = 0.5 * (low + high);
        *(away_from(m, middle) < away ? &low : &high) = middle;
    }
    if (high < 1.5 * m->radius_m + 15 || high > 20000) {
        return 0;
    }
    double by_move = 0, by_level = 0;
    for (int i = 0; i < 3; i++) {
        double px = pitch * high, east = 0.37 * i * px;
        draw(m, high * (1 - 1e-5), east, fine);
        draw(m, high * (1 - 1e-5), east + MOVED_PX * px, moved);
        draw(m, high * (1 + 1e-5), east, coarse);
        by_move += step(fine, moved);
        by_level += step(fine, coarse);
    }
    printf("%-16s to level %d at %6.0f m: %.4f, moved %.4f: %.2f\n", m->name, k,
           high, by_level, by_move, by_level / by_move);
    return by_level / by_move;
}

static void levels_do_not_pop(void **state)
{
    (void)state;
    static const char *const names[] = { "tanker", "ferry", "tug",
                                         "sailing-yacht", "lateral-port-a" };
    double worst = 0;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const struct pel_builtin what = { .name = names[i] };
        const struct pel_model *m = NULL;
        struct pel_fault fault;
        assert_int_equal(pel_builtin_make(&what, &m, &fault), PEL_OK);
        assert_int_equal(pel_model_shade(m, &fault), PEL_OK);
        for (int k = 1; k < m->level_count; k++) {
            worst = fmax(worst, pop(m, k));
        }
        pel_model_unref(m);
    }
    printf("worst %.2f\n", worst);
    assert_true(worst < 1.0);
}

static int begin(void **state)
{
    test_sea(1.5, 0.0, 1, &sea);
    return begin_renderer(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(levels_do_not_pop),
    };
    return cmocka_run_group_tests(tests, begin, end_renderer);
}
