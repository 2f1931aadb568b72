/* Rain and snow near the eye in pictures: what they cover, against a sum over
 * the drops of Marshall and Palmer; that they leave the mean light as it is;
 * how long streaks are and how they lean; seams, wrappers, sizes, order. */
#include "render/render_testkit.h"

enum { WIDE = 192, HIGH = 144 };
#define DROPS 800
static struct pel_sea sea;

/* Of drops up to 8 mm: what their shadows take, 1/m. */
static double shadows(double rate)
{
    double sum = 0;
    for (int i = 0; i < DROPS; i++) {
        double d = 0.01 * (i + 0.5);
        double n = 8000.0 * exp(-4.1 * pow(rate, -0.21) * d) * 0.01;
        sum += 1e-6 * 0.785398 * d * d * n;
    }
    return sum;
}

/* The same of flakes by their melted diameter, Sekhon and Srivastava 1970, of
 * 0.17 g/cm3 over their diameter in mm. */
static double shadows_of_snow(double rate)
{
    double sum = 0;
    for (int i = 0; i < 2000; i++) {
        double d = 0.01 * (i + 0.5);
        double n = 2500.0 * pow(rate, -0.94) *
                   exp(-2.29 * pow(rate, -0.45) * d) * 0.01;
        sum += 1e-6 * 0.785398 * d * d * d / 0.17 * n;
    }
    return sum;
}

/* The mean diameter, mm, of the largest that are a quarter of the shadows. */
static double large(double rate)
{
    double part = 0, weighed = 0, whole = 1e6 * shadows(rate);
    for (int i = DROPS - 1; i >= 0 && part < 0.25 * whole; i--) {
        double d = 0.01 * (i + 0.5);
        double n = 8000.0 * exp(-4.1 * pow(rate, -0.21) * d) * 0.01;
        part += 0.785398 * d * d * n;
        weighed += 0.785398 * d * d * n * d;
    }
    return weighed / part;
}

/* Gunn and Kinzer 1949, table II, m/s, by steps of 0.4 mm from 0.4 on. */
static double falls_at(double d)
{
    static const double v[] = { 1.62, 3.27, 4.64, 5.65, 6.49,
                                7.27, 7.82, 8.26, 8.60, 8.83 };
    double at = fmin(fmax(d / 0.4 - 1, 0), 8.99);
    int i = (int)at;
    return v[i] + (at - i) * (v[i + 1] - v[i]);
}

static struct pel_environment weather(double rain, double snow, double wind,
                                      double time_s)
{
    struct pel_environment env = test_environment(&sea, time_s);
    env.rain_mm_h = rain;
    env.snow_mm_h = snow;
    env.wind_mps = wind;
    env.wind_to_rad = 0; /* east */
    return env;
}

/* Of a picture of the sky, what is covered of each pixel: fall_bare. */
static double *covered(struct pel_environment env, const struct pel_camera *c)
{
    size_t n = (size_t)c->width * c->height;
    double *cover = malloc(n * sizeof *cover);
    assert_non_null(cover);
    struct pel_environment dry = env;
    dry.rain_mm_h = dry.snow_mm_h = 0;
    struct pel_picture *p = test_draw(renderer, &dry, c, PEL_LAYER_RADIANCE);
    for (size_t i = 0; i < n; i++) {
        cover[i] = (double)p->radiance[4 * i + 1];
    }
    pel_picture_release(p);
    env.fall_bare = true;
    p = test_draw(renderer, &env, c, PEL_LAYER_RADIANCE);
    for (size_t i = 0; i < n; i++) {
        cover[i] = 1 - (double)p->radiance[4 * i + 1] / cover[i];
    }
    pel_picture_release(p);
    return cover;
}

static double mean_of(const double *x, size_t n)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum += x[i] / (double)n;
    }
    return sum;
}

static void cover_is_the_drops(void **state)
{
    (void)state;
    static const double rates[] = { 2, 10, 50 };
    struct pel_camera c =
        test_camera((struct test_look){ 20, 0, 16, 0, 24, WIDE, HIGH });
    test_sea(3.0, 0.0, 3, &sea);
    for (size_t i = 0; i < 3; i++) {
        double seen = 0, square = 0;
        for (int t = 0; t < 12; t++) {
            double *a = covered(weather(rates[i], 0, 0, 3 + 1.7 * t), &c);
            double mean = mean_of(a, (size_t)WIDE * HIGH);
            seen += mean / 12;
            for (int k = 0; k < WIDE * HIGH; k++) {
                square += (a[k] - mean) * (a[k] - mean) / (12.0 * WIDE * HIGH);
            }
            free(a);
        }
        double ours = shadows(rates[i]) * 15;
        print_message("%2.0f mm/h: cover %.5f, by drops %.5f (%+.1f %%), "
                      "deviation %.5f\n",
                      rates[i], seen, ours, 100 * (seen / ours - 1),
                      sqrt(square));
        assert_true(fabs(seen / ours - 1) < 0.1);
        assert_true(sqrt(square) > 0.01 * ours);
    }
    double snow = 0;
    for (int t = 0; t < 12; t++) {
        double *a = covered(weather(0, 1, 0, 3 + 1.7 * t), &c);
        snow += mean_of(a, (size_t)WIDE * HIGH) / 12;
        free(a);
    }
    double ours = shadows_of_snow(1) * 15;
    print_message("snow, 1 mm/h: cover %.5f, by flakes %.5f (%+.1f %%)\n", snow,
                  ours, 100 * (snow / ours - 1));
    assert_true(fabs(snow / ours - 1) < 0.1);
    pel_sea_finish(&sea);
}

/* Where everything behind is alike, streaks redistribute light. */
static void light_is_kept(void **state)
{
    (void)state;
    struct pel_camera c =
        test_camera((struct test_look){ 20, 0, 16, 0, 24, WIDE, HIGH });
    test_sea(3.0, 0.0, 3, &sea);
    for (int snows = 0; snows < 2; snows++) {
        double more = 0, moved = 0;
        for (int t = 0; t < 12; t++) {
            struct pel_environment env =
                weather(snows ? 0 : 50, snows ? 5 : 0, 4, 3 + 1.7 * t);
            struct pel_environment dry = weather(0, 0, 4, 3 + 1.7 * t);
            struct pel_picture *p =
                test_draw(renderer, &dry, &c, PEL_LAYER_RADIANCE);
            static double light[WIDE * HIGH];
            for (int i = 0; i < WIDE * HIGH; i++) {
                light[i] = (double)p->radiance[4 * i + 1];
            }
            pel_picture_release(p);
            p = test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
            for (int i = 0; i < WIDE * HIGH; i++) {
                double change = (double)p->radiance[4 * i + 1] / light[i] - 1;
                more += change / (12.0 * WIDE * HIGH);
                moved += fabs(change) / (12.0 * WIDE * HIGH);
            }
            pel_picture_release(p);
        }
        print_message("%s: mean light %+.2e, moved %.2e\n",
                      snows ? "snow" : "rain", more, moved);
        assert_true(moved > 1e-4);
        assert_true(fabs(more) < 0.1 * moved);
    }
    pel_sea_finish(&sea);
}

/* Degrees from the vertical, by the structure tensor. */
static double lean_of(const double *a)
{
    double xx = 0, xy = 0, yy = 0;
    for (int y = 1; y < HIGH - 1; y++) {
        for (int x = 1; x < WIDE - 1; x++) {
            double gx = a[y * WIDE + x + 1] - a[y * WIDE + x - 1];
            double gy = a[(y + 1) * WIDE + x] - a[(y - 1) * WIDE + x];
            xx += gx * gx;
            xy += gx * gy;
            yy += gy * gy;
        }
    }
    return -0.5 * atan2(2 * xy, xx - yy) / PEL_DEG;
}

static void they_lean(void **state)
{
    (void)state;
    struct pel_camera c =
        test_camera((struct test_look){ 20, 0, 4, 0, 4, WIDE, HIGH });
    test_sea(3.0, 0.0, 3, &sea);
    for (int k = 0; k < 4; k++) {
        double wind = 4.0 * k, lean = 0;
        for (int t = 0; t < 8; t++) {
            struct pel_environment env = weather(10, 0, wind, 3 + 1.7 * t);
            env.fall_only = 4;
            double *a = covered(env, &c);
            lean += lean_of(a) / 8;
            free(a);
        }
        double rule = atan(wind / falls_at(large(10))) / PEL_DEG;
        print_message("wind %2.0f m/s: %.1f deg, rule %.1f\n", wind, lean,
                      rule);
        assert_true(fabs(lean - rule) < 3);
    }
    /* The eye's own motion as much as the wind. */
    struct pel_environment env = weather(10, 0, 0, 5);
    env.fall_only = 4;
    c.velocity_mps.x = -8;
    double *a = covered(env, &c);
    double rule = atan(8 / falls_at(large(10))) / PEL_DEG;
    print_message("eye at 8 m/s: %.1f deg, rule %.1f\n", lean_of(a), rule);
    assert_true(fabs(lean_of(a) - rule) < 3);
    free(a);
    pel_sea_finish(&sea);
}

/* The longest is that of a drop a metre away. */
static void they_are_long(void **state)
{
    (void)state;
    struct pel_camera c =
        test_camera((struct test_look){ 20, 0, 14, 0, 24, WIDE, HIGH });
    double pixel = (c.tan_right - c.tan_left) / WIDE;
    test_sea(3.0, 0.0, 3, &sea);
    int most = 0;
    for (int t = 0; t < 24; t++) {
        struct pel_environment env = weather(3, 0, 0, 3 + 1.7 * t);
        env.fall_only = 4;
        double *a = covered(env, &c), top = 0, low = 1;
        for (int i = 0; i < WIDE * HIGH; i++) {
            top = fmax(top, a[i]);
            low = fmin(low, a[i]);
        }
        for (int x = 0; x < WIDE; x++) {
            int run = 0;
            for (int y = 0; y < HIGH; y++) {
                bool in = a[y * WIDE + x] > low + 0.3 * (top - low);
                run = in ? run + 1 : 0;
                /* Not where the picture cuts it. */
                bool whole = y + 1 < HIGH && y >= run;
                most = whole && run > most ? run : most;
            }
        }
        free(a);
    }
    double rule = falls_at(large(3)) / 60 / pixel;
    print_message("longest %d px, speed times exposure a metre away %.1f px\n",
                  most, rule);
    /* The nearest of some hundreds is 0.9 to 1.1 m away; two may meet. */
    assert_true(most / rule > 0.85 && most / rule < 1.3);
    pel_sea_finish(&sea);
}

/* Halves are the whole, both wrappers draw it, whatever was drawn before. */
static void no_seam(void **state)
{
    (void)state;
    static const char *const shadings[] = { "fragment", "compute" };
    static uint8_t first[256 * 192 * 4];
    test_sea(7.0, 0.0, 3, &sea);
    struct pel_camera whole =
        test_camera((struct test_look){ 9, 70, 3, 7, 50, 256, 192 });
    whole.auto_exposure = false;
    whole.exposure_ev = 13;
    for (int s = 0; s < 4; s++) {
        struct pel_environment env = weather(20, 1, 9, s == 1 ? 4.5 : 7.2);
        struct pel_renderer *r = test_renderer(shadings[s / 2]);
        struct pel_picture *p =
            test_draw(r, &env, &whole, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
        if (s == 0) {
            memcpy(first, p->rgba, sizeof first);
        } else if (s == 1) {
            assert_memory_not_equal(first, p->rgba, sizeof first);
        } else if (pel_renderer_is_software(r)) {
            assert_memory_equal(first, p->rgba, sizeof first);
        }
        for (int half = 0; half < 2; half++) {
            struct pel_camera part = whole;
            double middle = 0.5 * (whole.tan_left + whole.tan_right);
            part.width = 128;
            *(half ? &part.tan_left : &part.tan_right) = middle;
            struct pel_picture *q =
                test_draw(r, &env, &part, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
            for (uint32_t y = 0; y < 192; y++) {
                size_t at = 128 * (size_t)half + 256 * (size_t)y;
                assert_memory_equal(q->radiance + (size_t)4 * 128 * y,
                                    p->radiance + 4 * at,
                                    128 * 4 * sizeof(float));
            }
            pel_picture_release(q);
        }
        pel_picture_release(p);
        pel_renderer_destroy(r);
    }
    pel_sea_finish(&sea);
}

/* Of two windows side by side, what both see. */
static void windows_have_one_rain(void **state)
{
    (void)state;
    struct pel_camera left = test_camera(
                          (struct test_look){ 20, 0, 12, 0, 24, WIDE, HIGH }),
                      right = test_camera(
                          (struct test_look){ 20, 12, 12, 5, 24, WIDE, HIGH });
    test_sea(3.0, 0.0, 3, &sea);
    struct pel_environment env = weather(10, 1, 6, 5);
    double *a = covered(env, &left), *b = covered(env, &right);
    double n = 0, sa = 0, sb = 0, aa = 0, ab = 0, bb = 0;
    const struct pel_mat3 *m = &right.world_from_camera;
    for (int i = 0; i < WIDE * HIGH; i++) {
        struct pel_vec3 to = test_ray(&left, i % WIDE + 0.5, i / WIDE + 0.5);
        double ahead = -pel_vec3_dot(to, m->z);
        int x = (int)floor((pel_vec3_dot(to, m->x) / ahead - right.tan_left) /
                           (right.tan_right - right.tan_left) * WIDE),
            y = (int)floor((right.tan_top - pel_vec3_dot(to, m->y) / ahead) /
                           (right.tan_top - right.tan_bottom) * HIGH);
        if (x >= 0 && x < WIDE && y >= 0 && y < HIGH) {
            double p = a[i], q = b[y * WIDE + x];
            n++;
            sa += p;
            sb += q;
            aa += p * p;
            ab += p * q;
            bb += q * q;
        }
    }
    double alike =
        (ab - sa * sb / n) / sqrt((aa - sa * sa / n) * (bb - sb * sb / n));
    print_message("%.0f pixels in both, correlation %.3f\n", n, alike);
    assert_true(n > 0.3 * WIDE * HIGH && alike > 0.8);
    free(a);
    free(b);
    pel_sea_finish(&sea);
}

/* Twice as large, averaged, is the picture. */
static void sizes_agree(void **state)
{
    (void)state;
    struct pel_camera c =
        test_camera((struct test_look){ 20, 0, 16, 0, 24, WIDE, HIGH });
    struct pel_camera twice = c;
    twice.width *= 2;
    twice.height *= 2;
    test_sea(3.0, 0.0, 3, &sea);
    struct pel_environment env = weather(10, 0, 3, 5);
    double *a = covered(env, &c), *b = covered(env, &twice);
    double n = WIDE * HIGH, sa = 0, sb = 0, aa = 0, ab = 0, bb = 0;
    for (int i = 0; i < WIDE * HIGH; i++) {
        const double *at = b + 4 * WIDE * (i / WIDE) + 2 * (i % WIDE);
        double mean = 0.25 * (at[0] + at[1] + at[2 * WIDE] + at[2 * WIDE + 1]);
        sa += a[i] / n;
        sb += mean / n;
        aa += a[i] * a[i] / n;
        ab += a[i] * mean / n;
        bb += mean * mean / n;
    }
    double alike = (ab - sa * sb) / sqrt((aa - sa * sa) * (bb - sb * sb));
    print_message("means %.5f and %.5f, correlation %.3f\n", sa, sb, alike);
    assert_true(fabs(sa / sb - 1) < 0.02 && alike > 0.85);
    free(a);
    free(b);
    pel_sea_finish(&sea);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cover_is_the_drops),
        cmocka_unit_test(light_is_kept),
        cmocka_unit_test(they_lean),
        cmocka_unit_test(they_are_long),
        cmocka_unit_test(windows_have_one_rain),
        cmocka_unit_test(sizes_agree),
        cmocka_unit_test(no_seam), /* makes other renderers current */
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
