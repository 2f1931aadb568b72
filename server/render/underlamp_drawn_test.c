/* Lamps in the water: their beams scattered once and what they light on the
 * bottom, against a quadrature of its own: I p(ν) b e^(-c (d + t)) / d² along
 * the sight, I cos θ A e^(-c (d + s)) / (π d²) at its end. */
#include "optics/lamp.h"
#include "optics/light.h"
#include "render/render_testkit.h"

enum { SIDE = 32 };
#define ABSORPTION 0.06
#define SCATTERING 0.14
#define ASYMMETRY 0.5 /* no peak to leave out: c is all there is */
#define CANDELA 2000.0
#define DEEP_M 10.0

static struct pel_sea calm;

static struct pel_environment night(double depth_m)
{
    struct pel_environment env = test_environment(&calm, 5.0);
    env.lights[0].direction = test_sun(-30.0, 200.0);
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        env.water.absorption[i] = ABSORPTION;
        env.water.scattering[i] = SCATTERING;
        env.water.asymmetry[i] = ASYMMETRY;
        env.water.molecular[i] = env.water.back[i] = 0.0;
        env.water.albedo[i] = 0.3;
    }
    env.water.depth_m = depth_m;
    return env;
}

/* Luminances of what the lamp adds. */
static void added(struct pel_environment *env, const struct pel_camera *c,
                  const struct pel_lamp *lamp, double out[SIDE * SIDE])
{
    double m[9];
    pel_lights_colours(env->lights, 1, false, m);
    struct pel_picture *p[2];
    for (int k = 0; k < 2; k++) {
        env->lamps = lamp;
        env->lamp_count = (size_t)k;
        p[k] = test_draw(renderer, env, c, PEL_LAYER_RADIANCE);
    }
    static const double weight[3] = { 0.2126, 0.7152, 0.0722 };
    for (int i = 0; i < SIDE * SIDE; i++) {
        out[i] = 0;
        for (int k = 0; k < 9; k++) {
            out[i] += weight[k / 3] * m[k] *
                      ((double)p[1]->radiance[4 * i + k % 3] -
                       (double)p[0]->radiance[4 * i + k % 3]);
        }
    }
    pel_picture_release(p[0]);
    pel_picture_release(p[1]);
}

/* Its strength at a place from it, over the square of the way, by the water. */
static double falls(const struct pel_lamp *lamp, struct pel_vec3 from_lamp)
{
    double away = sqrt(pel_vec3_dot(from_lamp, from_lamp));
    double turn =
        acos(pel_clamp(pel_vec3_dot(from_lamp, lamp->ahead) / away, -1, 1));
    double beam =
        lamp->beam_rad > 0 ? exp2(-pow(turn / lamp->beam_rad, 2)) : 1.0;
    return CANDELA * beam * exp(-(ABSORPTION + SCATTERING) * away) /
           (away * away);
}

static double wanted(const struct pel_lamp *lamp, struct pel_vec3 sight,
                     double depth_m)
{
    const double g = ASYMMETRY, c = ABSORPTION + SCATTERING;
    /* To the bottom, or until nothing is left; upwards to the surface. */
    double s = sight.z < 0   ? (depth_m - DEEP_M) / -sight.z
               : sight.z > 0 ? DEEP_M / sight.z
                             : 1e9;
    bool bottom = sight.z < 0 && s < 100;
    s = fmin(s, 100);
    const struct pel_vec3 at = { lamp->east_m, lamp->north_m,
                                 lamp->altitude_m + DEEP_M };
    const int steps = 40000;
    double sum = 0;
    for (int i = 0; i < steps; i++) {
        double t = s * (i + 0.5) / steps;
        struct pel_vec3 from =
            pel_vec3_add(pel_vec3_scale(sight, t), pel_vec3_scale(at, -1));
        /* Light goes on along `from` and turns to the eye, along -sight. */
        double nu = -pel_vec3_dot(from, sight) / sqrt(pel_vec3_dot(from, from));
        double phase =
            (1 - g * g) / (4 * PEL_PI * pow(1 + g * g - 2 * g * nu, 1.5));
        sum += falls(lamp, from) * SCATTERING * phase * exp(-c * t) * s / steps;
    }
    if (bottom) {
        struct pel_vec3 from =
            pel_vec3_add(pel_vec3_scale(sight, s), pel_vec3_scale(at, -1));
        sum += falls(lamp, from) * -from.z / sqrt(pel_vec3_dot(from, from)) *
               0.3 / PEL_PI * exp(-c * s);
    }
    return sum;
}

static struct pel_lamp beam(double east_m, double north_m, double up_m,
                            struct pel_vec3 ahead, double half_deg)
{
    struct pel_vec3 side =
        pel_vec3_normalize(pel_vec3_cross(ahead, (struct pel_vec3){ 0, 0, 1 }));
    return (struct pel_lamp){
        .entity = PEL_NO_ENTITY,
        .east_m = east_m,
        .north_m = north_m,
        .altitude_m = up_m - DEEP_M,
        .intensity_cd = { CANDELA, CANDELA, CANDELA },
        .ahead = pel_vec3_normalize(ahead),
        .up = pel_vec3_cross(side, pel_vec3_normalize(ahead)),
        .arc_rad = 2 * PEL_PI,
        .spread_rad = 0.5 * PEL_PI,
        .beam_rad = half_deg * PEL_DEG,
    };
}

static void against_a_quadrature(void **state)
{
    (void)state;
    const struct {
        const char *what;
        struct pel_lamp lamp;
        double depth_m, pitch;
    } cases[] = {
        { "beside the eye, a beam of 40 deg",
          beam(0.6, 0.0, 0.4, (struct pel_vec3){ -0.05, 1, 0 }, 20), 1000, 0 },
        { "beside the eye, 90 deg",
          beam(-0.6, 0.0, 0.4, (struct pel_vec3){ 0.05, 1, 0 }, 45), 1000, 0 },
        { "across the sight, a beam of 8 deg",
          beam(-4.0, 5.0, 0.2, (struct pel_vec3){ 1, 0.1, 0 }, 4), 1000, 0 },
        { "all round, 4 m ahead",
          beam(0.7, 4.0, 0.3, (struct pel_vec3){ 0, 1, 0 }, 0), 1000, 0 },
        { "on the bottom 3 m below",
          beam(0.6, 0.0, 0.4, (struct pel_vec3){ 0, 1, -0.8 }, 35), 13, -40 },
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct pel_environment env = night(cases[k].depth_m);
        struct pel_camera c = test_camera((struct test_look){
            -DEEP_M, 0, cases[k].pitch, 0, 60, SIDE, SIDE });
        c.auto_exposure = false;
        c.exposure_ev = 0.0;
        double got[SIDE * SIDE], most = 0, worst = 0, all = 0, sum = 0;
        added(&env, &c, &cases[k].lamp, got);
        double want[SIDE * SIDE];
        for (int i = 0; i < SIDE * SIDE; i++) {
            struct pel_vec3 to = test_ray(&c, i % SIDE + 0.5, i / SIDE + 0.5);
            want[i] = wanted(&cases[k].lamp, to, cases[k].depth_m);
            most = fmax(most, want[i]);
        }
        for (int i = 0; i < SIDE * SIDE; i++) {
            sum += want[i];
            all += got[i];
            if (want[i] > 0.05 * most) {
                worst = fmax(worst, fabs(got[i] / want[i] - 1));
            }
        }
        print_message("%s: %.3g cd/m2 at most, worst pixel %.2f %%, all %+.2f "
                      "%%\n",
                      cases[k].what, most, 100 * worst, 100 * (all / sum - 1));
        /* Of pixels that have a twentieth of the brightest. 28 places a sight;
         * the phase function by 64 steps. */
        assert_true(worst < 0.03 && fabs(all / sum - 1) < 0.02);
    }
}

/* A lamp in the air lights no water, and without lamps nothing changes. */
static void none_in_the_air(void **state)
{
    (void)state;
    struct pel_environment env = night(20.0);
    struct pel_lamp high =
        beam(0, 5, DEEP_M + 2, (struct pel_vec3){ 0, 0.1, -1 }, 20);
    struct pel_camera c =
        test_camera((struct test_look){ -DEEP_M, 0, 0, 0, 60, SIDE, SIDE });
    c.auto_exposure = false;
    double more[SIDE * SIDE];
    added(&env, &c, &high, more);
    for (int i = 0; i < SIDE * SIDE; i++) {
        assert_true(more[i] == 0.0);
    }
}

int main(void)
{
    test_sea(0.0, 0.0, 3, &calm);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(against_a_quadrature),
        cmocka_unit_test(none_in_the_air),
    };
    int failed = cmocka_run_group_tests(tests, begin_renderer, end_renderer);
    pel_sea_finish(&calm);
    return failed;
}
