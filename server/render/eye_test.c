/* The eye: exposure, tone curve and glare of drawn pictures. The curve and the
 * glare against their twins in optics/colour.c; what a picture into the Sun may
 * burn out, that its disc and its sky's colour are there, that dusk is darker
 * than day, that views of one meter match. */
#include "optics/colour.h"
#include "optics/vision.h"
#include "render/render_testkit.h"
#include "render/sky.h"

static struct pel_sea sea;
static double rec709[9];
static const double balance[3] = { PEL_TONE_RED, PEL_TONE_GREEN,
                                   PEL_TONE_BLUE };

static struct pel_environment into_sun(double elevation, double visibility_m)
{
    struct pel_environment env = test_environment(&sea, 10.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(elevation, 0.0);
    env.visibility_m = visibility_m;
    pel_colour_matrix(env.lights[PEL_LIGHT_SUN].direction.z, rec709);
    return env;
}

/* Exposed linear Rec. 709 of a pixel's radiance, without tone. */
static void exposed(const float light[4], double ev, double out[3])
{
    for (int c = 0; c < 3; c++) {
        out[c] = 0.0;
        for (int i = 0; i < 3; i++) {
            out[c] += rec709[3 * c + i] * (double)light[i];
        }
        out[c] *= pel_colour_exposure_scale(ev);
    }
}

static double encoded(double v)
{
    double e = v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
    return 255.0 * pel_clamp(e, 0.0, 1.0);
}

static double decoded(uint8_t code)
{
    double v = code / 255.0;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static double luminance(const double c[3])
{
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

/* --- twins --------------------------------------------------------------- */

/* Codes of colour that are off by more than one, of a picture with glare. */
static int off_by_more(double elevation, double ev, int tone, double share)
{
    struct pel_environment env = into_sun(elevation, 40000.0);
    struct pel_camera c =
        test_camera((struct test_look){ 6.0, 3.0, 5.0, 2.0, 50.0, 96, 64 });
    c.auto_exposure = false;
    c.exposure_ev = ev;
    c.tone = tone;
    c.glare = share;
    struct pel_picture *p =
        test_draw(renderer, &env, &c, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
    struct pel_atmosphere air;
    const struct pel_atmosphere_desc desc = { env.visibility_m };
    pel_atmosphere_init(&desc, &air);
    struct pel_vec3 sun = pel_sky_quantize(env.lights[PEL_LIGHT_SUN].direction);
    struct pel_rgb beam = pel_atmosphere_sun_irradiance(&air, 6.0, sun);
    int wrong = 0;
    for (uint32_t i = 0; i < c.width * c.height; i++) {
        struct pel_vec3 dir =
            test_ray(&c, i % c.width + 0.5, (double)(i / c.width) + 0.5);
        double away = 1.0 - pel_vec3_dot(dir, sun);
        double veil = share * pel_glare_spread(away);
        const float light[4] = {
            p->radiance[4 * i] + (float)(veil * beam.r),
            p->radiance[4 * i + 1] + (float)(veil * beam.g),
            p->radiance[4 * i + 2] + (float)(veil * beam.b),
        };
        double x[3], shown[3];
        exposed(light, ev, x);
        for (int k = 0; k < 3; k++) {
            x[k] =
                fmax(x[k], 0.0) * (tone == PEL_TONE_FILMIC ? balance[k] : 1.0);
            shown[k] = fmin(x[k], 1.0);
        }
        if (tone == PEL_TONE_FILMIC) {
            pel_tone_filmic(x, shown);
        }
        for (int k = 0; k < 3; k++) {
            /* Half a code of dither, half of rounding; the table of the Sun's
             * transmittance is good to 1 %, a tenth of a code or two. */
            wrong += fabs(p->rgba[4 * i + (uint32_t)k] - encoded(shown[k])) >
                     1.0 + (share > 0.0 ? 0.5 : 0.02);
        }
    }
    pel_picture_release(p);
    return wrong;
}

static void pictures_are_the_reference(void **state)
{
    (void)state;
    test_sea(8.0, 0.0, 1, &sea);
    assert_int_equal(off_by_more(20.0, 14.5, PEL_TONE_FILMIC, 0.0), 0);
    assert_int_equal(off_by_more(20.0, 14.5, PEL_TONE_LINEAR, 0.0), 0);
    assert_int_equal(off_by_more(2.0, 11.0, PEL_TONE_FILMIC, 0.0), 0);
    assert_int_equal(off_by_more(8.0, 14.5, PEL_TONE_FILMIC, 0.1), 0);
    assert_int_equal(off_by_more(-6.0, 6.0, PEL_TONE_FILMIC, 0.1), 0);
}

/* --- the Sun ahead -------------------------------------------------------- */

static double burnt(double elevation)
{
    struct pel_environment env = into_sun(elevation, 40000.0);
    struct pel_camera c =
        test_camera((struct test_look){ 6.0, 0.0, -4.0, 0.0, 60.0, 320, 240 });
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_COLOR);
    int count = 0;
    for (int i = 0; i < 320 * 240; i++) {
        const uint8_t *v = p->rgba + (ptrdiff_t)4 * i;
        count += v[0] >= 250 || v[1] >= 250 || v[2] >= 250;
    }
    pel_picture_release(p);
    return count / (320.0 * 240.0);
}

static void little_burns_out(void **state)
{
    (void)state;
    static const double winds[] = { 2.0, 8.0, 15.0 };
    static const double suns[] = { 2.0, 5.0, 8.0, 20.0, 60.0 };
    double worst = 0.0;
    for (int w = 0; w < 3; w++) {
        test_fft_sea(winds[w], 1, &sea);
        printf("%4g m/s, any channel at 250 or above:", winds[w]);
        for (int s = 0; s < 5; s++) {
            double share = burnt(suns[s]);
            printf(" %.2f %% at %g°%s", 100 * share, suns[s], s < 4 ? "," : "");
            worst = fmax(worst, share);
        }
        printf("\n");
        pel_sea_finish(&sea);
    }
    assert_true(worst <= 0.02);
}

struct disc {
    double least_inside, most_around; /* luminance as displayed, codes */
};

/* Around the Sun in the middle of the picture, 40 pixels a degree. */
static struct disc look_at_disc(double elevation, double visibility_m)
{
    enum { SIDE = 160 };
    struct pel_environment env = into_sun(elevation, visibility_m);
    struct pel_camera c = test_camera(
        (struct test_look){ 6.0, 0.0, elevation, 0.0, 4.0, SIDE, SIDE });
    /* Exposed as one that looks ahead. */
    struct pel_camera ahead =
        test_camera((struct test_look){ 6.0, 0.0, -4.0, 0.0, 60.0, 320, 240 });
    c.sight_count = 1;
    c.sights[0] =
        (struct pel_sight){ ahead.world_from_camera, ahead.altitude_m,
                            ahead.tan_left,          ahead.tan_right,
                            ahead.tan_top,           ahead.tan_bottom };
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_COLOR);
    struct pel_vec3 sun = pel_sky_quantize(env.lights[PEL_LIGHT_SUN].direction);
    double radius = pel_light_bodies[PEL_LIGHT_SUN].angular_radius_rad;
    struct disc d = { 255.0, 0.0 };
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        struct pel_vec3 dir =
            test_ray(&c, i % SIDE + 0.5, (double)(i / SIDE) + 0.5);
        double off =
            sqrt(fmax(2.0 - 2.0 * pel_vec3_dot(dir, sun), 0.0)) / radius;
        const uint8_t *v = p->rgba + 4 * (size_t)i;
        const double l[3] = { v[0], v[1], v[2] };
        if (off < 0.9) {
            d.least_inside = fmin(d.least_inside, luminance(l));
        } else if (off > 1.2 && dir.z > 0.0) {
            d.most_around = fmax(d.most_around, luminance(l));
        }
    }
    pel_picture_release(p);
    return d;
}

static void the_disc_is_a_disc(void **state)
{
    (void)state;
    static const double suns[] = { 2.0, 5.0, 8.0, 20.0 };
    static const double airs[] = { 300000.0, 40000.0, 20000.0 };
    test_sea(8.0, 0.0, 1, &sea);
    for (int a = 0; a < 3; a++) {
        for (int s = 0; s < 4; s++) {
            struct disc d = look_at_disc(suns[s], airs[a]);
            printf("%3g km, Sun %2g°: %.1f inside, %.1f around\n",
                   airs[a] / 1000, suns[s], d.least_inside, d.most_around);
            /* Dither is one code; an edge of six is seen. */
            assert_true(d.least_inside - d.most_around >= 6.0);
        }
    }
}

/* --- colour --------------------------------------------------------------- */

static double lab_f(double t)
{
    return t > 216.0 / 24389.0 ? cbrt(t) : (24389.0 / 27.0 * t + 16.0) / 116.0;
}

/* CIE 1976, D65. */
static void lab(const double c[3], double out[3])
{
    double x = 0.4124564 * c[0] + 0.3575761 * c[1] + 0.1804375 * c[2];
    double z = 0.0193339 * c[0] + 0.1191920 * c[1] + 0.9503041 * c[2];
    double y = 0.2126729 * c[0] + 0.7151522 * c[1] + 0.0721750 * c[2];
    double fx = lab_f(x / 0.95047), fy = lab_f(y), fz = lab_f(z / 1.08883);
    out[0] = 116.0 * fy - 16.0;
    out[1] = 500.0 * (fx - fy);
    out[2] = 200.0 * (fy - fz);
}

/* Between the picture at 30° above the horizon and the radiance there, brought
 * to the same luminance. */
static double off_colour(double elevation, double heading)
{
    enum { SIDE = 32 };
    struct pel_environment env = into_sun(elevation, 40000.0);
    struct pel_camera c = test_camera(
        (struct test_look){ 6.0, heading, 30.0, 0.0, 4.0, SIDE, SIDE });
    struct pel_camera ahead = test_camera(
        (struct test_look){ 6.0, heading, 0.0, 0.0, 60.0, 320, 240 });
    c.sight_count = 1;
    c.sights[0] =
        (struct pel_sight){ ahead.world_from_camera, ahead.altitude_m,
                            ahead.tan_left,          ahead.tan_right,
                            ahead.tan_top,           ahead.tan_bottom };
    struct pel_picture *p =
        test_draw(renderer, &env, &c, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
    double shown[3] = { 0.0 }, want[3] = { 0.0 };
    for (int i = 0; i < SIDE * SIDE; i++) {
        double x[3];
        exposed(p->radiance + (ptrdiff_t)4 * i, p->exposure_ev, x);
        for (int k = 0; k < 3; k++) {
            shown[k] += decoded(p->rgba[4 * i + k]) / (SIDE * SIDE);
            want[k] += x[k] / (SIDE * SIDE);
        }
    }
    pel_picture_release(p);
    double scale = luminance(shown) / luminance(want), a[3], b[3];
    for (int k = 0; k < 3; k++) {
        want[k] *= scale;
    }
    lab(shown, a);
    lab(want, b);
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

static void the_sky_keeps_its_colour(void **state)
{
    (void)state;
    static const double suns[] = { -6.0, 2.0, 5.0, 8.0, 20.0, 60.0 };
    double worst = 0.0;
    test_sea(8.0, 0.0, 1, &sea);
    for (int s = 0; s < 6; s++) {
        for (double heading = 0.0; heading <= 180.0; heading += 90.0) {
            worst = fmax(worst, off_colour(suns[s], heading));
        }
    }
    printf("sky at 30°: at most %.2f ΔE off its own colour\n", worst);
    assert_true(worst <= 5.0);
}

/* --- from day to night ---------------------------------------------------- */

static void night_falls(void **state)
{
    (void)state;
    for (double wind = 2.0; wind <= 15.0; wind += 6.5) {
        test_sea(wind, 0.0, 1, &sea);
        for (double heading = 0.0; heading <= 180.0; heading += 45.0) {
            struct pel_camera c = test_camera(
                (struct test_look){ 6.0, heading, -4.0, 0.0, 60.0, 64, 48 });
            double before = 100.0, dusk = 100.0, noon = 0.0;
            for (double e = 60.0; e >= -18.0; e -= 3.0) {
                struct pel_environment env = into_sun(e, 40000.0);
                struct pel_picture *p =
                    test_draw(renderer, &env, &c, PEL_LAYER_COLOR);
                double mean = 0.0;
                for (int i = 0; i < 64 * 48; i++) {
                    const uint8_t *v = p->rgba + (ptrdiff_t)4 * i;
                    const double l[3] = { decoded(v[0]), decoded(v[1]),
                                          decoded(v[2]) };
                    mean += 100.0 * luminance(l) / (64.0 * 48.0);
                }
                if (p->exposure_ev >= before || (e < -4.0 && mean >= dusk)) {
                    printf("%g m/s, %g° off, Sun %g°: EV %.2f after %.2f, "
                           "luminance %.1f %% after %.1f %%\n",
                           wind, heading, e, p->exposure_ev, before, mean,
                           dusk);
                }
                assert_true(p->exposure_ev < before);
                /* Twilight is darker than noon, and from step to step; just
                 * after sunset the sky may shine brighter than the Sun's
                 * last red, and night is all but black. */
                assert_true(e >= 0.0 || mean < noon);
                assert_true(e >= -4.0 || mean < dusk ||
                            (e < -14.0 && mean < 2.0));
                before = p->exposure_ev;
                dusk = mean;
                noon = e > 59.0 ? mean : noon;
                pel_picture_release(p);
            }
        }
    }
}

/* --- an eye by little light ------------------------------------------------
 */

/* The eye's picture from the radiance, below the twin's own light. */
static void an_eye_is_the_reference(void **state)
{
    (void)state;
    double dusk = 100.0;
    test_sea(6.0, 0.0, 1, &sea);
    for (double e = 4.0; e >= -14.0; e -= 6.0) {
        struct pel_environment env = into_sun(e, 40000.0);
        struct pel_camera c =
            test_camera((struct test_look){ 6.0, 3.0, 5.0, 2.0, 50.0, 96, 64 });
        double rods[3], mean = 0.0;
        int off = 0;
        pel_colour_rods(env.lights[PEL_LIGHT_SUN].direction.z, rods);
        c.vision = PEL_VISION_EYE;
        c.glare = 0.0;
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
        double scale = pel_colour_exposure_scale(p->exposure_ev);
        for (int i = 0; i < 96 * 64; i++) {
            const float *light = p->radiance + (ptrdiff_t)4 * i;
            double x[3], seen[3], shown[3], s = 0.0;
            exposed(light, p->exposure_ev, x);
            for (int k = 0; k < 3; k++) {
                x[k] /= scale;
                s += rods[k] * (double)light[k];
            }
            pel_vision_seen(x, s, seen);
            for (int k = 0; k < 3; k++) {
                seen[k] = fmax(seen[k] * scale * balance[k], 0.0);
            }
            pel_tone_filmic(seen, shown);
            mean += luminance(shown) / (96.0 * 64.0);
            for (int k = 0; k < 3; k++) {
                double code = p->rgba[4 * i + k];
                off += fabs(code - encoded(shown[k])) > 1.5;
            }
        }
        printf("eye, Sun %g°: EV %.2f, luminance %.2f %%, %d codes off\n", e,
               p->exposure_ev, 100.0 * mean, off);
        assert_int_equal(off, 0);
        assert_true(mean < dusk);
        dusk = mean;
        pel_picture_release(p);
    }
}

/* Means of what a screen shows of rows, of its white. */
static double shown_rows(const struct pel_picture *p, uint32_t top,
                         uint32_t bottom)
{
    double sum = 0.0;
    for (uint32_t i = top * p->width; i < bottom * p->width; i++) {
        const uint8_t *v = p->rgba + (size_t)4 * i;
        const double l[3] = { decoded(v[0]), decoded(v[1]), decoded(v[2]) };
        sum += luminance(l) / ((bottom - top) * p->width);
    }
    return sum;
}

/* The end of nautical twilight: the sea is dark, the horizon is to be told, and
 * the picture is darker than one of civil twilight by far. */
static void late_dusk_is_dark(void **state)
{
    (void)state;
    double before = 1.0;
    test_sea(6.0, 0.0, 1, &sea);
    for (double e = -6.0; e >= -18.0; e -= 6.0) {
        struct pel_environment env = into_sun(e, 40000.0);
        struct pel_camera c = test_camera(
            (struct test_look){ 8.0, -30.0, 0.0, 0.0, 60.0, 160, 96 });
        c.vision = PEL_VISION_EYE;
        struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_COLOR);
        double sky = shown_rows(p, 38, 44), water = shown_rows(p, 54, 70);
        printf("eye, Sun %g°: EV %.2f, sky above the horizon %.2f %%, sea "
               "%.2f %%\n",
               e, p->exposure_ev, 100.0 * sky, 100.0 * water);
        assert_true(sky > 1.7 * water && water < before);
        assert_true(e > -12.0 || water < 0.008);
        before = e < -6.0 ? water : 0.25 * water;
        pel_picture_release(p);
    }
    pel_sea_finish(&sea);
}

/* --- views of one meter ----------------------------------------------------
 */

static void views_of_a_meter_match(void **state)
{
    (void)state;
    enum { VIEWS = 5 };
    struct pel_camera c[VIEWS];
    struct pel_environment env = into_sun(8.0, 40000.0);
    test_sea(8.0, 0.0, 1, &sea);
    env.sea = &sea;
    double apart[VIEWS], least = 100.0, most = -100.0;
    for (int i = 0; i < VIEWS; i++) {
        c[i] = test_camera(
            (struct test_look){ 15.0, 45.0 * (i - 2), 0.0, 0.0, 45.0, 64, 48 });
        struct pel_picture *p =
            test_draw(renderer, &env, &c[i], PEL_LAYER_COLOR);
        apart[i] = p->exposure_ev;
        least = fmin(least, apart[i]);
        most = fmax(most, apart[i]);
        pel_picture_release(p);
    }
    struct pel_sight all[VIEWS];
    for (int i = 0; i < VIEWS; i++) {
        all[i] = (struct pel_sight){ c[i].world_from_camera, c[i].altitude_m,
                                     c[i].tan_left,          c[i].tan_right,
                                     c[i].tan_top,           c[i].tan_bottom };
    }
    double first = 0.0;
    for (int i = 0; i < VIEWS; i++) {
        c[i].sight_count = VIEWS;
        memcpy(c[i].sights, all, sizeof all);
        struct pel_picture *p =
            test_draw(renderer, &env, &c[i], PEL_LAYER_COLOR);
        first = i == 0 ? p->exposure_ev : first;
        assert_true(p->exposure_ev == first); /* to the bit */
        pel_picture_release(p);
    }
    printf("EV of five windows: %.2f to %.2f apart, %.2f together\n", least,
           most, first);
    assert_true(most - least > 0.5);
    assert_true(first > least && first <= most);
}

/* --- cameras beside an eye -------------------------------------------------
 */

/* Software devices have programs for cameras alone: they draw what those do
 * that know of eyes, to the bit. */
static void cameras_beside_an_eye(void **state)
{
    (void)state;
    test_sea(9.0, 0.0, 1, &sea);
    for (double sun = 20.0; sun >= -10.0; sun -= 30.0) {
        struct pel_environment env = into_sun(sun, 40000.0);
        struct pel_camera c = test_camera(
            (struct test_look){ 8.0, 10.0, -5.0, 3.0, 60.0, 160, 96 });
        c.antialiasing = true;
        struct pel_draw draws[2] = {
            { .camera = c, .layers = PEL_LAYER_COLOR },
            { .camera = c, .layers = PEL_LAYER_COLOR },
        };
        draws[1].camera.vision = PEL_VISION_EYE;
        pel_renderer_destroy(renderer);
        renderer = test_renderer(NULL); /* that has seen no eye */
        struct pel_picture *alone =
            test_draw(renderer, &env, &c, PEL_LAYER_COLOR);
        const size_t size = (size_t)4 * c.width * c.height;
        uint8_t *rgba = malloc(size);
        memcpy(rgba, alone->rgba, size);
        pel_picture_release(alone);
        assert_int_equal(pel_renderer_submit(renderer, &env, draws, 2), PEL_OK);
        for (int i = 0; i < 2; i++) {
            struct pel_picture *p = pel_renderer_collect(renderer, 60000000000);
            assert_non_null(p);
            /* By day an eye sees what a camera does. */
            assert_int_equal(memcmp(p->rgba, rgba, size) == 0,
                             i == 0 || sun > 0.0);
            pel_picture_release(p);
        }
        free(rgba);
    }
    pel_sea_finish(&sea);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_the_reference),
        cmocka_unit_test(little_burns_out),
        cmocka_unit_test(the_disc_is_a_disc),
        cmocka_unit_test(the_sky_keeps_its_colour),
        cmocka_unit_test(night_falls),
        cmocka_unit_test(an_eye_is_the_reference),
        cmocka_unit_test(late_dusk_is_dark),
        cmocka_unit_test(views_of_a_meter_match),
        cmocka_unit_test(cameras_beside_an_eye),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
