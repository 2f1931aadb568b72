/* What the render room's tests share: cameras as the scene makes them, seas,
 * a repeatable stream of numbers, pictures copied out of the renderer, height
 * fields and environments over them. */
#pragma once

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "ocean/sea.h"
#include "render/renderer.h"
#include "scene/snapshot.h"
#include "seabed/seabed.h"

/* Of a program's cameras. */
#ifndef TEST_ANTIALIASING
#define TEST_ANTIALIASING false
#endif

/* Angles of a test view, degrees; heading clockwise from north. */
struct test_look {
    double height_m, heading, pitch, roll, fov;
    uint32_t width, height;
};

static inline uint64_t test_random_bits(uint64_t *state)
{
    uint64_t z = *state += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

/* In [low, high). */
static inline double test_random(uint64_t *state, double low, double high)
{
    return low +
           (high - low) * (double)(test_random_bits(state) >> 11) * 0x1p-53;
}

/* A camera through the scene's own code, square pixels. */
static inline struct pel_camera test_camera(struct test_look look)
{
    double tan_x = tan(0.5 * look.fov * PEL_DEG);
    double tan_y = tan_x * look.height / look.width;
    const struct pel_view_state view = {
        .entity = -1,
        .up_m = look.height_m,
        .yaw_rad = look.heading * PEL_DEG,
        .pitch_rad = look.pitch * PEL_DEG,
        .roll_rad = look.roll * PEL_DEG,
        .tan_left = -tan_x,
        .tan_right = tan_x,
        .tan_top = tan_y,
        .tan_bottom = -tan_y,
        .width = look.width,
        .height = look.height,
        .auto_exposure = true,
        .glare = 0.01,
        .antialiasing = TEST_ANTIALIASING,
    };
    const struct pel_snapshot snapshot = { .view_count = 1, .views = &view };
    struct pel_camera camera;
    pel_snapshot_camera(&snapshot, 0, 0.0, 0, 0, &camera);
    return camera;
}

/* Unit direction of the place (x, y) of a picture, pixels from the top left. */
static inline struct pel_vec3 test_ray(const struct pel_camera *c, double x,
                                       double y)
{
    double px = (c->tan_right - c->tan_left) / c->width;
    double py = (c->tan_top - c->tan_bottom) / c->height;
    const struct pel_vec3 v = { c->tan_left + px * x, c->tan_top - py * y,
                                -1.0 };
    return pel_vec3_normalize(pel_mat3_apply(&c->world_from_camera, v));
}

/* Pierson–Moskowitz of trochoids. */
static inline struct pel_sea_desc test_wind(double wind_mps, uint32_t seed)
{
    return (struct pel_sea_desc){
        .wind_mps = wind_mps,
        .direction_rad = 0.4,
        .fetch_m = 200000.0,
        .gamma = 3.3,
        .seed = seed,
        .wave_count = 60,
    };
}

/* The same, with a swell of swell_m if that is not 0. */
static inline void test_sea(double wind_mps, double swell_m, uint32_t seed,
                            struct pel_sea *out)
{
    struct pel_sea_desc desc = test_wind(wind_mps, seed);
    desc.swell_count = swell_m > 0.0;
    desc.swell[0] = (struct pel_swell_desc){ swell_m, 12.0, 1.2, 0.2 };
    assert_int_equal(pel_sea_build(&desc, out), PEL_OK);
}

/* The same wind by FFT cascades. */
static inline void test_fft_sea(double wind_mps, uint32_t seed,
                                struct pel_sea *out)
{
    struct pel_sea_desc desc = test_wind(wind_mps, seed);
    desc.synthesiser = PEL_SYNTHESISER_FFT;
    assert_int_equal(pel_sea_build(&desc, out), PEL_OK);
}

/* Elevation and azimuth (clockwise from north) in degrees. */
static inline struct pel_vec3 test_sun(double elevation, double azimuth)
{
    double e = elevation * PEL_DEG, a = azimuth * PEL_DEG;
    return (struct pel_vec3){ cos(e) * sin(a), cos(e) * cos(a), sin(e) };
}

static inline struct pel_environment test_environment(const struct pel_sea *sea,
                                                      double time_s)
{
    return (struct pel_environment){
        .time_s = time_s,
        .sea = sea,
        .lights = { [PEL_LIGHT_SUN] = { .direction = test_sun(30.0, 40.0),
                                        .strength = 1.0 } },
        .lit = 1,
        .discs = 1,
        .wind_mps = sea->desc.wind_mps,
        .wind_to_rad = sea->desc.direction_rad,
        .visibility_m = 40000.0,
        .water = pel_water_deep(0.2),
    };
}

/* TEST_DEVICE names another device than the software one, as --device does. */
static inline const char *test_device(void)
{
    const char *device = getenv("TEST_DEVICE");
    return device ? device : "software";
}

static inline struct pel_renderer *test_renderer(const char *shading)
{
    const struct pel_renderer_options options = { .device = test_device(),
                                                  .shading = shading,
                                                  .debug = true };
    struct pel_fault fault = { 0 };
    struct pel_renderer *r = NULL;
    if (pel_renderer_create(&options, &r, &fault) != PEL_OK) {
        fail_msg("%s", fault.message);
    }
    return r;
}

/* Of a program whose tests share one: cmocka's set-up and tear-down. */
static struct pel_renderer *renderer;

static inline int begin_renderer(void **state)
{
    (void)state;
    renderer = test_renderer(NULL);
    return 0;
}

static inline int end_renderer(void **state)
{
    (void)state;
    pel_renderer_destroy(renderer);
    return 0;
}

#define TEST_ALL_LAYERS                                                        \
    (PEL_LAYER_COLOR | PEL_LAYER_RADIANCE | PEL_LAYER_DEPTH | PEL_LAYER_NORMAL)

/* One picture, waited for; release it. */
static inline struct pel_picture *test_draw(struct pel_renderer *r,
                                            const struct pel_environment *env,
                                            const struct pel_camera *camera,
                                            unsigned layers)
{
    const struct pel_draw draw = { .camera = *camera, .layers = layers };
    assert_int_equal(pel_renderer_submit(r, env, &draw, 1), PEL_OK);
    struct pel_picture *p = pel_renderer_collect(r, 60000000000);
    assert_non_null(p);
    return p;
}

#define TEST_BED_SIDE 64
#define TEST_BED_SPACING 50.0

/* An island of 30 m in a sea of 400 m, 600 m north of the origin, and a bank at
 * 12 m in the east. */
static inline double test_island(double east_m, double north_m)
{
    double r = hypot(east_m - 160, north_m - 600) / 400;
    return east_m > 1000 ? -12 : -400 + 430 / (1 + r * r * r);
}

/* All but level: a field of one height only is none. */
static inline double test_bank(double east_m, double north_m)
{
    return -8 + 1e-9 * (east_m + north_m);
}

/* A field of 64 by 64 nodes, 50 m apart, that begins 800 m south. */
static inline const struct pel_seabed *
test_bed(double (*height)(double east_m, double north_m))
{
    static float heights[TEST_BED_SIDE * TEST_BED_SIDE];
    const double west = -0.5 * TEST_BED_SIDE * TEST_BED_SPACING, south = -800;
    for (int i = 0; i < TEST_BED_SIDE * TEST_BED_SIDE; i++) {
        heights[i] =
            (float)height(west + TEST_BED_SPACING * (i % TEST_BED_SIDE),
                          south + TEST_BED_SPACING * (i / TEST_BED_SIDE));
    }
    const struct pel_seabed *bed = NULL;
    assert_int_equal(pel_seabed_create(TEST_BED_SIDE, TEST_BED_SIDE, west,
                                       south, TEST_BED_SPACING, heights, &bed,
                                       NULL),
                     PEL_OK);
    return bed;
}

/* The environment in tropical water over sand, so deep beyond the field. */
static inline struct pel_environment test_over(struct pel_environment env,
                                               const struct pel_seabed *bed,
                                               double depth_m)
{
    const struct pel_water_desc water = { .kind = PEL_WATER_NAMED,
                                          .name = PEL_WATER_TROPICAL,
                                          .depth_m = depth_m,
                                          .bottom = PEL_BOTTOM_SAND };
    assert_int_equal(pel_water_resolve(&water, &env.water, NULL), PEL_OK);
    env.seabed = bed;
    return env;
}
