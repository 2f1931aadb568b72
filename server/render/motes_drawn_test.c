/* Particles in the water as drawn: as many as the law of their sizes says, as
 * bright as the light around them makes them, nearer than what lies behind, the
 * same in both wrappers, and nothing of them where there are none. */
#include "render/render_testkit.h"

#include "render/motemap.h"

static struct pel_sea calm;
enum { SIDE = 320 };
#define EXTINCTION 0.08
static const struct pel_mote_water law = { 6000, 4, 8e-3 };

static struct pel_camera towards(double depth_m, double zenith, double fov)
{
    struct pel_camera c = test_camera((struct test_look){
        -depth_m, 40.0, 90.0 - zenith, 0.0, fov, SIDE, SIDE });
    c.auto_exposure = false;
    c.exposure_ev = 13.0;
    return c;
}

/* That absorbs alone, at dusk: all light is the sky's, and nothing is behind
 * the particles. */
static struct pel_environment black_water(void)
{
    struct pel_environment env = test_environment(&calm, 5.0);
    env.lights[0].direction = test_sun(-3.0, 40.0);
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        env.water.absorption[i] = EXTINCTION;
        env.water.scattering[i] = 0.0;
        env.water.molecular[i] = 0.0;
        env.water.albedo[i] = 0.0;
    }
    env.water.depth_m = 1000.0;
    return env;
}

static float *green(const struct pel_environment *env,
                    const struct pel_camera *c)
{
    struct pel_picture *p = test_draw(renderer, env, c, PEL_LAYER_RADIANCE);
    float *out = malloc(sizeof *out * SIDE * SIDE);
    assert_non_null(out);
    for (int i = 0; i < SIDE * SIDE; i++) {
        out[i] = p->radiance[4 * i + 1];
    }
    pel_picture_release(p);
    return out;
}

static double solid_angle(const struct pel_camera *c, int i)
{
    double x = c->tan_left +
               (c->tan_right - c->tan_left) * (i % SIDE + 0.5) / SIDE,
           y = c->tan_top -
               (c->tan_top - c->tan_bottom) * (i / SIDE + 0.5) / SIDE;
    double side = (c->tan_right - c->tan_left) / SIDE;
    return side * side * pow(1 + x * x + y * y, -1.5);
}

/* Of all directions at a depth, from a picture of the window. */
static double scalar_irradiance(const struct pel_environment *env,
                                double depth_m)
{
    struct pel_camera c = towards(depth_m, 0.0, 110.0);
    float *light = green(env, &c);
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        sum += (double)light[i] * solid_angle(&c, i);
    }
    free(light);
    return sum;
}

/* What a pixel's worth of the whole picture's particles sends, by the list:
 * each is a disc in a light that falls with its depth. */
static double sent(const struct pel_environment *env,
                   const struct pel_camera *c, double around)
{
    static struct pel_mote list[PEL_MOTE_MOST];
    struct pel_mote_view v = pel_mote_map_view(env, c, EXTINCTION);
    size_t n = pel_motes_seen(&env->motes, &v, list, PEL_MOTE_MOST);
    double reach = pel_mote_reach(&env->motes, &v), sum = 0;
    const struct pel_mat3 *m = &c->world_from_camera;
    for (size_t i = 0; i < n; i++) {
        struct pel_vec3 p = { (double)list[i].from[0], (double)list[i].from[1],
                              (double)list[i].from[2] };
        double ahead = -pel_vec3_dot(p, m->z), d = (double)list[i].diameter_m;
        double away = sqrt(pel_vec3_dot(p, p)), far = reach * d;
        double x = pel_vec3_dot(p, m->x) / ahead,
               y = pel_vec3_dot(p, m->y) / ahead;
        double near_ = pel_clamp(away / PEL_MOTE_NEAREST_M * 2 - 2, 0, 1),
               end = pel_clamp((away / far - 0.7) / 0.3, 0, 1);
        if (ahead <= 0 || x < c->tan_left || x > c->tan_right ||
            y < c->tan_bottom || y > c->tan_top) {
            continue;
        }
        sum += near_ * near_ * (3 - 2 * near_) *
               (1 - end * end * (3 - 2 * end)) * around *
               exp(EXTINCTION * p.z - EXTINCTION * away) * PEL_MOTE_WHITE /
               (4 * PEL_PI) * PEL_PI / 4 * d * d * away /
               (ahead * ahead * ahead);
    }
    return sum;
}

static void as_bright_as_the_light_around(void **state)
{
    (void)state;
    struct pel_environment env = black_water(), without = env;
    env.motes = law;
    double drawn = 0, wanted = 0;
    for (int k = 0; k < 3; k++) {
        struct pel_camera c = towards(6.0 + 5.0 * k, 100.0, 60.0);
        double around = scalar_irradiance(&without, 6.0 + 5.0 * k);
        float *on = green(&env, &c), *off = green(&without, &c);
        double side = (c.tan_right - c.tan_left) / SIDE;
        double light = 0, want = sent(&env, &c, around);
        for (int i = 0; i < SIDE * SIDE; i++) {
            light += (double)(on[i] - off[i]) * side * side;
        }
        print_message("%.0f m: %.4g of particles, by the list and the light "
                      "around %.4g\n",
                      6.0 + 5.0 * k, light, want);
        drawn += light / want / 3;
        wanted += 1.0 / 3;
        free(on);
        free(off);
    }
    /* The mean cosine of this sky's light is 0.86 or so, of the shader's 0.8;
     * the way down falls a little faster than the vertical. */
    print_message("%.3f of what is wanted\n", drawn / wanted);
    assert_true(fabs(drawn / wanted - 1) < 0.12);
}

/* --- their number --------------------------------------------------------- */

static double spread_out(const struct pel_camera *c, float *light, float least,
                         int at)
{
    double sum = 0;
    int stack[4096], n = 0;
    stack[n++] = at;
    while (n > 0) {
        int i = stack[--n], x = i % SIDE, y = i / SIDE;
        if (light[i] <= least) {
            continue;
        }
        sum += (double)light[i] * solid_angle(c, i);
        light[i] = 0;
        const int next[4] = { x > 0 ? i - 1 : i, x + 1 < SIDE ? i + 1 : i,
                              y > 0 ? i - SIDE : i,
                              y + 1 < SIDE ? i + SIDE : i };
        for (int k = 0; k < 4 && n < 4090; k++) {
            stack[n++] = next[k];
        }
    }
    return sum;
}

/* Spots that send more than some light, over the picture's solid angle, against
 * the law: larger ones than d(r) at the distance r. */
static void as_many_as_the_law_says(void **state)
{
    (void)state;
    struct pel_environment env = black_water(), without = env;
    /* Of so few that spots seldom meet. */
    env.motes = (struct pel_mote_water){ 500, 4, 8e-3 };
    double found = 0, wanted = 0;
    for (int k = 0; k < 8; k++) {
        env.time_s = without.time_s = 1000.0 * k; /* others have come */
        struct pel_camera c = towards(8.0, 90.0, 50.0);
        double around = scalar_irradiance(&without, 8.0);
        float *on = green(&env, &c), *off = green(&without, &c);
        double side = (c.tan_right - c.tan_left) / SIDE, all = 0;
        for (int i = 0; i < SIDE * SIDE; i++) {
            on[i] -= off[i];
            all += solid_angle(&c, i);
        }
        /* As one of 1.5 mm, 1 m away. */
        double white = around * PEL_MOTE_WHITE / 16.0;
        double least = white * 2.25e-6 * exp(-EXTINCTION);
        const float faint = (float)(0.02 * least / (side * side));
        for (int i = 0; i < SIDE * SIDE; i++) {
            found += on[i] > faint && spread_out(&c, on, faint, i) > least;
        }
        for (double r = 0.18; r < 12; r *= 1.01) {
            double d = sqrt(least / white * exp(EXTINCTION * r)) * r;
            wanted += d < 8e-3 ? all * pow(r, 3) * 0.01 *
                                     pel_motes_larger(&env.motes, d)
                               : 0;
        }
        free(on);
        free(off);
    }
    print_message("%.0f spots, by the law %.0f\n", found, wanted);
    /* Three deviations of their number, and a tenth for those that meet, lie
     * across the edge or before the nearest. */
    assert_true(fabs(found - wanted) < 3 * sqrt(wanted) + 0.1 * wanted);
}

/* The same bits where there are none, and in both wrappers. */
static void nothing_where_there_are_none(void **state)
{
    (void)state;
    struct pel_environment none = black_water(), some = none;
    some.motes = law;
    struct pel_camera c = towards(5.0, 90.0, 60.0);
    float *first = green(&none, &c), *with = green(&some, &c);
    float *again = green(&none, &c);
    assert_memory_equal(first, again, sizeof *first * SIDE * SIDE);
    assert_memory_not_equal(first, with, sizeof *first * SIDE * SIDE);
    pel_renderer_destroy(renderer);
    renderer = test_renderer("compute");
    float *other = green(&some, &c);
    assert_memory_equal(with, other, sizeof *first * SIDE * SIDE);
    free(first);
    free(with);
    free(again);
    free(other);
}

/* What lies behind a bottom is not seen: little of 0.25 m before it. */
static void nothing_behind_the_bottom(void **state)
{
    (void)state;
    struct pel_environment deep = black_water(), near_ = deep;
    deep.motes = near_.motes = law;
    near_.water.depth_m = 5.25;
    struct pel_camera c = towards(5.0, 180.0, 60.0);
    double sum[2] = { 0 };
    float *far = green(&deep, &c), *close = green(&near_, &c);
    for (int i = 0; i < SIDE * SIDE; i++) {
        sum[0] += (double)far[i];
        sum[1] += (double)close[i];
    }
    print_message("%.3f of the light before a bottom 0.25 m away\n",
                  sum[1] / sum[0]);
    assert_true(sum[0] > 0 && sum[1] < 0.3 * sum[0]);
    free(far);
    free(close);
}

int main(void)
{
    test_sea(0.0, 0.0, 3, &calm);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_bright_as_the_light_around),
        cmocka_unit_test(as_many_as_the_law_says),
        cmocka_unit_test(nothing_behind_the_bottom),
        cmocka_unit_test(nothing_where_there_are_none),
    };
    int failed = cmocka_run_group_tests(tests, begin_renderer, end_renderer);
    pel_sea_finish(&calm);
    return failed;
}
