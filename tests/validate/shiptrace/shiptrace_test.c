/* The reference against known answers: a flat sea, a wall, a plate under
 * water. */
#include "shiplight.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define DEGREE (3.14159265358979323846 / 180)

static struct ship_scene scene;

/* A rectangle, and the same again turned round. */
static void quad(struct ship_triangle *t, const double corner[4][3])
{
    static const int which[2][3] = { { 0, 1, 2 }, { 0, 2, 3 } };
    for (int i = 0; i < 2; i++) {
        for (int j = 0; j < 3; j++) {
            memcpy(t[i].corner[j], corner[which[i][j]], sizeof(double[3]));
        }
        t[i].albedo = 0.5;
    }
}

/* Flat, the Sun 30 degrees high behind the wall, or beside the plate. */
static void set(const double corner[4][3], double azimuth)
{
    memset(&scene, 0, sizeof(scene));
    sea_surface_sinusoid(&scene.surface, 0, 10, 1, 2);
    struct ship_triangle *t = calloc(2, sizeof(*t));
    quad(t, corner);
    ship_mesh_init(&scene.mesh, t, 2);
    scene.suns = 1;
    scene.index = 1.34;
    scene.sky[0].sun[0] = cos(30 * DEGREE) * cos(azimuth);
    scene.sky[0].sun[1] = cos(30 * DEGREE) * sin(azimuth);
    scene.sky[0].sun[2] = sin(30 * DEGREE);
    for (int c = 0; c < SHIP_CHANNELS; c++) {
        scene.irradiance[c] = 1;
        scene.fade[c] = 0.2;
    }
    float *sky = &scene.sky[0].radiance[0][0][0];
    for (size_t i = 0; i < sizeof(scene.sky[0].radiance) / sizeof(*sky); i++) {
        sky[i] = 0.1f;
    }
}

static void reset(void)
{
    sea_surface_finish(&scene.surface);
    ship_mesh_finish(&scene.mesh);
}

static void look(double x, struct ship_sight *mean, int rays)
{
    const double eye[3] = { 0, 0, 10 };
    double *to = (double *)mean;
    struct sea_random random;
    sea_random_init(&random, 1);
    memset(mean, 0, sizeof(*mean));
    for (int i = 0; i < rays; i++) {
        double d[3] = { x, 0, -10 }, length = hypot(x, 10);
        struct ship_sight one;
        for (int j = 0; j < 3; j++) {
            d[j] /= length;
        }
        ship_look(&scene, eye, d, &random, &one);
        for (size_t j = 0; j < sizeof(one) / sizeof(double); j++) {
            to[j] += ((const double *)&one)[j] / rays;
        }
    }
}

/* Of 6 m at 100 m; its mirror image ends where the sight is 10 / 16 of the way,
 * its shadow 6 / tan 30 before it. */
static const double wall[4][3] = {
    { 100, -50, 0 }, { 100, 50, 0 }, { 100, 50, 6 }, { 100, -50, 6 }
};

static void mirror_and_shadow(void **state)
{
    (void)state;
    struct ship_sight s;
    set(wall, 0);
    look(62.2, &s, 1);
    assert_true(s.mirrors == 0);
    look(62.8, &s, 1);
    assert_true(s.mirrors == 1);
    double edge = 100 - 6 / tan(30 * DEGREE);
    look(edge - 0.5, &s, 100);
    assert_float_equal(s.sunny[0], 1, 1e-9);
    look(edge + 0.5, &s, 100);
    assert_true(s.sunny[0] == 0);
    look(edge, &s, 20000);
    assert_float_equal(s.sunny[0], 0.5, 0.02);
    look(110, &s, 1);
    assert_true(s.direct == 1);
    reset();
}

/* Seen at 45 degrees in Fresnel's share; in full sky of 0.1 and no Sun, seen
 * from the side that the Sun does not light: the sky's half, the sea's less. */
static void brightness(void **state)
{
    (void)state;
    struct ship_sight s;
    set(wall, 0);
    look(80, &s, 40000);
    double cosine = 10 / hypot(80, 10);
    double share = sea_fresnel(cosine, 1.34);
    assert_float_equal(s.sky[0][1], share * 0.1, 1e-6);
    double body = s.with[0][1] / share;
    /* Matt 0.5 and gloss of some 0.02 to 0.06; of the lower half F is mirrored,
     * between 0.02 and all. */
    assert_true(body > 0.5 * 0.05 && body < 0.5 * 0.08);
    reset();
}

/* A level plate 4 m down, lit by the Sun: albedo E T cos F e^-cd, exactly. */
static void plate(void **state)
{
    (void)state;
    const double corner[4][3] = { { -300, -300, -4 },
                                  { 300, -300, -4 },
                                  { 300, 300, -4 },
                                  { -300, 300, -4 } };
    struct ship_sight s;
    set(corner, 1);
    float *sky = &scene.sky[0].radiance[0][0][0];
    memset(sky, 0, sizeof(scene.sky[0].radiance));
    look(10, &s, 200);
    double n = 1.34, eye = cos(45 * DEGREE), sun = sin(30 * DEGREE);
    double sight = 4 / sqrt(1 - (1 - eye * eye) / (n * n));
    double beam = 4 / sqrt(1 - (1 - sun * sun) / (n * n));
    double light = 0.5 / 3.14159265358979 * sun * (1 - sea_fresnel(sun, n)) *
                   exp(-0.2 * (beam + sight)) * (1 - sea_fresnel(eye, n)) /
                   (n * n);
    assert_float_equal(s.wet, 1, 1e-9);
    assert_float_equal(s.hull[0][1] / light, 1, 1e-3);
    /* Of the water's light what turns above the plate is left. */
    double whole = 0.2 * (sight + beam);
    look(10, &s, 40000);
    assert_float_equal(s.lit[0][1], 1 - exp(-whole), 0.01);
    reset();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mirror_and_shadow),
        cmocka_unit_test(brightness),
        cmocka_unit_test(plate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
