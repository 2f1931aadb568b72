/* Land and bottom as drawn against the height field that soundings answer
 * from, and against a flat bottom. */
#include "optics/atmosphere.h"
#include "optics/waterslope.h"
#include "render/coast.h"
#include "render/render_testkit.h"
#include "render/sky.h"

static struct pel_sea sea;

static struct pel_environment over(const struct pel_seabed *bed)
{
    return test_over(test_environment(&sea, 3), bed, 1000);
}

static void squares_hold_their_highest(void **state)
{
    (void)state;
    uint64_t random = 5;
    static float heights[37 * 21];
    for (int i = 0; i < 37 * 21; i++) {
        heights[i] = (float)test_random(&random, -50, 50);
    }
    const struct pel_seabed *bed = NULL;
    struct pel_seabed_tops tops;
    assert_int_equal(pel_seabed_create(37, 21, 0, 0, 1, heights, &bed, NULL),
                     PEL_OK);
    assert_int_equal(pel_seabed_tops_init(&tops, bed), PEL_OK);
    for (int k = 0; k < tops.levels; k++) {
        for (int i = 0; i < 37 * 21; i++) {
            /* Each square that the node borders on. */
            for (int corner = 0; corner < 4; corner++) {
                int x = (i % 37 - (corner & 1)) >> (k + 1);
                int y = (i / 37 - (corner >> 1)) >> (k + 1);
                x = x < 0 ? 0 : x < tops.columns[k] ? x : tops.columns[k] - 1;
                y = y < 0 ? 0 : y < tops.rows[k] ? y : tops.rows[k] - 1;
                assert_true(tops.highest[tops.first[k] +
                                         (size_t)(y * tops.columns[k] + x)] >=
                            heights[i]);
            }
        }
    }
    assert_true((double)tops.highest[tops.first[tops.levels - 1]] ==
                bed->highest_m);
    pel_seabed_tops_finish(&tops);
    pel_seabed_unref(bed);
}

/* Every pixel of land lies on the field that queries answer from. */
static void land_is_where_the_field_is(void **state)
{
    (void)state;
    const struct pel_seabed *bed = test_bed(test_island);
    struct pel_environment env = over(bed);
    struct pel_camera camera =
        test_camera((struct test_look){ 25, 10, -4, 0, 60, 320, 200 });
    const char *const shadings[] = { "fragment", "compute" };
    for (int s = 0; s < 2; s++) {
        struct pel_renderer *r = test_renderer(shadings[s]);
        struct pel_picture *p =
            test_draw(r, &env, &camera, TEST_ALL_LAYERS | PEL_LAYER_FRESNEL);
        int land = 0;
        for (int i = 0; i < 320 * 200; i++) {
            struct pel_vec3 d = test_ray(&camera, i % 320 + 0.5, i / 320 + 0.5);
            double t = (double)p->depth[i], arc = t * hypot(d.x, d.y);
            double z = 25 + t * d.z + arc * arc / (2 * PEL_EARTH_RADIUS);
            if (!isfinite(t) || (double)p->fresnel[i] != 0 || z < 1) {
                continue; /* sky, and sea, which has a reflectance */
            }
            double h = pel_seabed_drawn(bed, t * d.x, t * d.y, -99);
            land++;
            /* What a line of sight that grazes a ridge is followed to. */
            if (!(fabs(z - h) < 0.03)) {
                fail_msg("%s: %d, %d: drawn at %f m, is at %f m, range %f",
                         shadings[s], i % 320, i / 320, z, h, t);
            }
        }
        assert_true(land > 500);
        pel_picture_release(p);
        pel_renderer_destroy(r);
    }
    pel_seabed_unref(bed);
}

/* Mean red radiance of the pixels well above the waves, and their number. */
static double land_radiance(struct pel_renderer *r, enum pel_bottom bottom,
                            const enum pel_bottom *land, int *count)
{
    const struct pel_seabed *bed = test_bed(test_island);
    struct pel_environment env = over(bed);
    struct pel_camera camera =
        test_camera((struct test_look){ 25, 10, -4, 0, 60, 160, 100 });
    const struct pel_water_desc desc = { .chlorophyll_mg_m3 = 0.2,
                                         .salinity_g_kg = 35,
                                         .temperature_c = 15,
                                         .depth_m = 1000,
                                         .bottom = bottom,
                                         .has_land = land != NULL,
                                         .land = land ? *land : 0 };
    assert_int_equal(pel_water_resolve(&desc, &env.water, NULL), PEL_OK);
    struct pel_picture *p =
        test_draw(r, &env, &camera, TEST_ALL_LAYERS | PEL_LAYER_FRESNEL);
    double sum = 0;
    *count = 0;
    for (int i = 0; i < 160 * 100; i++) {
        struct pel_vec3 d = test_ray(&camera, i % 160 + 0.5, i / 160 + 0.5);
        double t = (double)p->depth[i], arc = t * hypot(d.x, d.y);
        double z = 25 + t * d.z + arc * arc / (2 * PEL_EARTH_RADIUS);
        if (isfinite(t) && (double)p->fresnel[i] == 0 && z > 4) {
            sum += (double)p->radiance[4 * i];
            ++*count;
        }
    }
    pel_picture_release(p);
    pel_seabed_unref(bed);
    return sum / *count;
}

/* A black bottom is deep water's; the land beside it is sand, unless somebody
 * says what it is. */
static void land_is_no_black_bottom(void **state)
{
    (void)state;
    struct pel_renderer *r = test_renderer("fragment");
    const enum pel_bottom rock = PEL_BOTTOM_ROCK, black = PEL_BOTTOM_BLACK;
    int count, same;
    double sand = land_radiance(r, PEL_BOTTOM_SAND, NULL, &count);
    assert_true(count > 100 && sand > 0);
    assert_true(land_radiance(r, PEL_BOTTOM_BLACK, NULL, &same) == sand);
    assert_int_equal(same, count);
    double dark = land_radiance(r, PEL_BOTTOM_BLACK, &rock, &same);
    /* Albedos of 0.49 and 0.10, and the same air in front of them. */
    assert_true(dark < 0.5 * sand);
    assert_true(land_radiance(r, PEL_BOTTOM_SAND, &rock, &same) == dark);
    assert_true(land_radiance(r, PEL_BOTTOM_SAND, &black, &same) < dark);
    pel_renderer_destroy(r);
}

#define LOOKS 5
#define LOOK_WIDTH 256
#define LOOK_HEIGHT 192
#define LOOK_BYTES ((size_t)4 * LOOK_WIDTH * LOOK_HEIGHT)

static void draw_looks(const struct pel_environment *env, uint8_t *out)
{
    static const struct test_look looks[LOOKS] = {
        { 6, 0, -3, 0, 60, LOOK_WIDTH, LOOK_HEIGHT },
        { 60, 20, -15, 10, 50, LOOK_WIDTH, LOOK_HEIGHT },
        { 400, 90, -60, 0, 60, LOOK_WIDTH, LOOK_HEIGHT },
        { 4, 200, -2, 0, 90, LOOK_WIDTH, LOOK_HEIGHT },
        { 900, 10, -25, 0, 40, LOOK_WIDTH, LOOK_HEIGHT },
    };
    struct pel_renderer *r = test_renderer("fragment");
    for (int i = 0; i < LOOKS; i++) {
        struct pel_camera camera = test_camera(looks[i]);
        struct pel_picture *p = test_draw(r, env, &camera, PEL_LAYER_COLOR);
        memcpy(out + (size_t)i * LOOK_BYTES, p->rgba, LOOK_BYTES);
        pel_picture_release(p);
    }
    pel_renderer_destroy(r);
}

/* Only the tiles of the plan know of the field. */
static void the_plan_leaves_nothing_out(void **state)
{
    (void)state;
    const struct pel_seabed *bed = test_bed(test_island);
    struct pel_environment env = over(bed);
    uint8_t *a = malloc(LOOKS * LOOK_BYTES), *b = malloc(LOOKS * LOOK_BYTES);
    draw_looks(&env, a);
    env.coast_everywhere = true;
    draw_looks(&env, b);
    for (size_t i = 0; i < LOOKS; i++) {
        double sum = 0, worst = 0;
        for (size_t k = i * LOOK_BYTES; k < (i + 1) * LOOK_BYTES; k++) {
            double d = abs(a[k] - b[k]);
            sum += d;
            worst = fmax(worst, d);
        }
        print_message("look %zu: mean %.4f, worst %.0f of 255\n", i,
                      sum / LOOK_BYTES, worst);
        /* A bottom that gives 1/255 of its light is left out. */
        assert_true(sum / LOOK_BYTES < 0.005);
    }
    free(a);
    free(b);
    pel_seabed_unref(bed);
}

static void a_level_field_is_a_flat_bottom(void **state)
{
    (void)state;
    const struct pel_seabed *bed = test_bed(test_bank);
    struct pel_environment env = over(bed), flat = over(NULL);
    env.water.depth_m = flat.water.depth_m = 8;
    struct pel_camera camera =
        test_camera((struct test_look){ 12, 60, -25, 0, 40, 128, 96 });
    struct pel_renderer *r = test_renderer("fragment");
    struct pel_picture *a = test_draw(r, &env, &camera, PEL_LAYER_RADIANCE);
    struct pel_picture *b = test_draw(r, &flat, &camera, PEL_LAYER_RADIANCE);
    for (int c = 0; c < 3; c++) {
        double by_field = 0, by_depth = 0;
        for (int i = 0; i < 128 * 96; i++) {
            by_field += (double)a->radiance[4 * i + c];
            by_depth += (double)b->radiance[4 * i + c];
        }
        /* Waves change the depth under them, and levels of depth are mixed. */
        assert_true(fabs(by_field / by_depth - 1) < 0.02);
    }
    pel_picture_release(a);
    pel_picture_release(b);
    pel_renderer_destroy(r);
    pel_seabed_unref(bed);
}

static double three_metres(double east_m, double north_m)
{
    return -3 + 1e-9 * (east_m + north_m);
}

/* The waves move light about on the bottom; they make none. */
static void caustics_keep_the_mean(void **state)
{
    (void)state;
    const struct pel_seabed *bed = test_bed(three_metres);
    struct pel_environment env = over(bed);
    struct pel_camera camera =
        test_camera((struct test_look){ 40, 0, -60, 0, 60, 192, 192 });
    struct pel_renderer *r = test_renderer("fragment");
    double mean[2] = { 0 }, deviation = 0;
    float *even = malloc(sizeof *even * 192 * 192);
    for (int on = 0; on < 2; on++) {
        env.caustics = on;
        struct pel_picture *p = test_draw(r, &env, &camera, PEL_LAYER_BOTTOM);
        for (int i = 0; i < 192 * 192; i++) {
            double green = (double)p->bottom[4 * i + 1];
            mean[on] += green / (192 * 192);
            if (on) {
                deviation += fabs(green - (double)even[i]) / (192 * 192);
            } else {
                even[i] = (float)green;
            }
        }
        pel_picture_release(p);
    }
    print_message("mean %.4f, deviation %.3f of it\n", mean[1] / mean[0],
                  deviation / mean[0]);
    /* Rays that cross all the same are cut short: 3 %. */
    assert_true(fabs(mean[1] / mean[0] - 1) < 0.03);
    assert_true(deviation > 0.05 * mean[0]);
    free(even);
    pel_renderer_destroy(r);
    pel_seabed_unref(bed);
}

/* Mean light of the bottom, by wavelength, 6 m under an eye that looks down. */
static void look_down(struct pel_renderer *r, double (*height)(double, double),
                      double mean[3])
{
    const struct pel_seabed *bed = test_bed(height);
    struct pel_environment env = over(bed);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(35.0, 90.0);
    env.no_air = true;
    struct pel_camera camera =
        test_camera((struct test_look){ 30, 0, -90, 0, 8, 48, 48 });
    struct pel_picture *p = test_draw(r, &env, &camera, PEL_LAYER_BOTTOM);
    for (int c = 0; c < 3; c++) {
        mean[c] = 0;
        for (int i = 0; i < 48 * 48; i++) {
            mean[c] += (double)p->bottom[4 * i + c];
        }
        mean[c] /= 48 * 48;
    }
    pel_picture_release(p);
    pel_seabed_unref(bed);
}

#define TILT 0.466 /* 25° */

static double six_metres(double east_m, double north_m)
{
    return -6 + 1e-9 * (east_m + north_m);
}

static double to_the_sun(double east_m, double north_m)
{
    return -6 - TILT * east_m + 1e-9 * north_m;
}

static double from_the_sun(double east_m, double north_m)
{
    return -6 + TILT * east_m + 1e-9 * north_m;
}

/* What the twin says of a place under unit sunlight without a sky: all of it,
 * and the part that was not scattered. */
struct computed {
    double bottom, straight, kept;
};

static void compute(const struct pel_environment *env,
                    const struct pel_geometry *at,
                    const struct pel_slope_place *place,
                    struct computed out[PEL_WATER_WAVELENGTHS])
{
    static struct pel_water_kernel levels[12];
    static bool made;
    const struct pel_water_depths depths = { 12, 0.25,
                                             pel_water_visible_m(&env->water) };
    if (!made) {
        assert_int_equal(pel_water_kernel_build(&env->water, &depths,
                                                PEL_ORDERS_ALL, levels),
                         PEL_OK);
        made = true;
    }
    struct pel_slope_light light[PEL_WATER_WAVELENGTHS];
    struct pel_interface f = pel_interface_at(at);
    pel_slope_light(&env->water, &depths, levels, at, place, light);
    for (int c = 0; c < PEL_WATER_WAVELENGTHS; c++) {
        struct pel_medium m = pel_water_medium(&env->water, c);
        double way =
            (m.absorption + m.scattering) * (1.0 / f.sun_mu + 1.0 / f.view_mu);
        out[c] = (struct computed){
            .bottom = light[c].bottom,
            .straight = f.beam * f.leaving * m.albedo / PEL_PI * f.sun_mu *
                        exp(-way * place->depth_m) * place->gain,
            .kept = pel_slope_change(&m, PEL_ORDERS_ALL, place).kept,
        };
    }
}

static double channel(struct pel_rgb v, int c)
{
    return c == 0 ? v.r : c == 1 ? v.g : v.b;
}

/* The light of slopes, drawn, against the twin that was held to the Monte
 * Carlo: the Sun's straight light by its irradiance, all else as a level bottom
 * has it, changed as the twin changes it but for the skylight's share, which
 * takes the cosine of the slope in place of the Sun's gain. */
static void slopes_are_drawn_as_computed(void **state)
{
    (void)state;
    struct pel_environment env = over(NULL);
    const struct pel_geometry at = { 55 * PEL_DEG, 0.0, 0.0 };
    struct pel_interface f = pel_interface_at(&at);
    double sunward = sqrt(1.0 - f.sun_mu * f.sun_mu) / f.sun_mu;
    struct pel_vec3 sun = pel_sky_quantize(test_sun(35.0, 90.0));
    static struct pel_atmosphere air;
    const struct pel_atmosphere_desc desc = { env.visibility_m };
    pel_atmosphere_init(&desc, &air);
    assert_int_equal(pel_atmosphere_tabulate(&air, NULL, NULL), PEL_OK);
    struct pel_rgb beam = pel_atmosphere_sun_irradiance(&air, 0.0, sun);
    struct pel_rgb sky = pel_atmosphere_sky_irradiance(&air, sun);
    pel_atmosphere_finish(&air);
    struct pel_renderer *r = test_renderer("fragment");
    double level[3], drawn[2][3];
    look_down(r, six_metres, level);
    look_down(r, to_the_sun, drawn[0]);
    look_down(r, from_the_sun, drawn[1]);
    pel_renderer_destroy(r);
    const struct pel_slope_place flat = { 6, 6, 0, 1, 1 };
    struct computed even[3], steep[3];
    compute(&env, &at, &flat, even);
    for (int k = 0; k < 2; k++) {
        double tilt = k ? -TILT : TILT, up = 1.0 / hypot(1.0, TILT);
        const struct pel_slope_place place = { 6, 6, TILT,
                                               (1.0 + tilt * sunward) * up, 1 };
        compute(&env, &at, &place, steep);
        for (int c = 1; c < 3; c++) {
            double straight = channel(beam, c) * even[c].straight;
            double direct = channel(beam, c) * sun.z;
            double share = direct / (direct + channel(sky, c));
            double gain = share * place.gain + (1 - share) * up;
            double kept = steep[c].kept;
            double around = (steep[c].bottom - steep[c].straight) /
                            (1 + kept * (place.gain - 1)) /
                            (even[c].bottom - even[c].straight);
            double want =
                (straight * place.gain +
                 (level[c] - straight) * around * (1 + kept * (gain - 1))) /
                level[c];
            double got = drawn[k][c] / level[c];
            print_message("%s the Sun, %s: drawn %.3f, computed %.3f\n",
                          k ? "from" : "to", c == 1 ? "green" : "blue", got,
                          want);
            /* The waves turn the lines of sight; the air lies between. */
            assert_true(fabs(got - want) < 0.015 * want);
        }
    }
}

static int set_up(void **state)
{
    (void)state;
    test_sea(3, 0, 1, &sea);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(squares_hold_their_highest),
        cmocka_unit_test(land_is_where_the_field_is),
        cmocka_unit_test(land_is_no_black_bottom),
        cmocka_unit_test(the_plan_leaves_nothing_out),
        cmocka_unit_test(a_level_field_is_a_flat_bottom),
        cmocka_unit_test(caustics_keep_the_mean),
        cmocka_unit_test(slopes_are_drawn_as_computed),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
