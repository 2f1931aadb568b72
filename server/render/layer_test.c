#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "render/renderer.h"

static const unsigned all_layers =
    PEL_LAYER_COLOR | PEL_LAYER_RADIANCE | PEL_LAYER_SUN | PEL_LAYER_SKY |
    PEL_LAYER_WATER | PEL_LAYER_AIR | PEL_LAYER_DEPTH | PEL_LAYER_NORMAL |
    PEL_LAYER_FRESNEL | PEL_LAYER_SLOPE_VARIANCE | PEL_WATER_PART_LAYERS;

static struct pel_picture *draw(struct pel_renderer *r, unsigned layers)
{
    static struct pel_sea sea;
    const struct pel_sea_desc desc = {
        .wind_mps = 9, .fetch_m = 2e5, .gamma = 3.3, .seed = 3, .wave_count = 60
    };
    assert_int_equal(pel_sea_build(&desc, &sea), PEL_OK);
    const struct pel_environment env = { .time_s = 7,
                                         .sea = &sea,
                                         .sun = { 0.2, 0.9, 0.387298 },
                                         .wind_mps = 9,
                                         .visibility_m = 20000,
                                         .water = pel_water_deep(0.3) };
    const struct pel_draw d = {
        .camera = { .altitude_m = 9,
                    .world_from_camera = { { 1, 0, 0 },
                                           { 0, 0, 1 },
                                           { 0, -1, 0 } },
                    .tan_left = -0.5,
                    .tan_right = 0.5,
                    .tan_top = 0.4,
                    .tan_bottom = -0.6,
                    .width = 128,
                    .height = 128,
                    .auto_exposure = true },
        .layers = layers
    };
    assert_int_equal(pel_renderer_submit(r, &env, &d, 1), PEL_OK);
    struct pel_picture *p = pel_renderer_collect(r, 20000000000);
    assert_non_null(p);
    return p;
}

static struct pel_renderer *create(const char *shading)
{
    struct pel_renderer *r = NULL;
    const struct pel_renderer_options o = { .device = "software",
                                            .shading = shading };
    assert_int_equal(pel_renderer_create(&o, &r, NULL), PEL_OK);
    return r;
}

/* The parts are added in the shader in another order: a few units in the last
 * place of single precision. */
static void parts_make_the_radiance(void **state)
{
    (void)state;
    struct pel_renderer *r = create("fragment");
    struct pel_picture *p = draw(r, all_layers);
    int sea = 0;
    for (int i = 0; i < 128 * 128; i++) {
        for (int c = 0; c < 3; c++) {
            double sum = (double)p->sun[4 * i + c] + p->sky[4 * i + c] +
                         p->water[4 * i + c] + p->air[4 * i + c];
            double whole = p->radiance[4 * i + c];
            assert_true(fabs(sum - whole) <= 1e-5 * whole + 1e-9);
            assert_true(p->sun[4 * i + c] >= 0 && p->water[4 * i + c] >= 0);
            double water = 0.0;
            for (int k = 0; k < PEL_WATER_PARTS; k++) {
                assert_true(p->water_part[k][4 * i + c] >= 0);
                water += p->water_part[k][4 * i + c];
            }
            whole = p->water[4 * i + c];
            assert_true(fabs(water - whole) <= 1e-5 * whole + 1e-9);
        }
        if (isfinite(p->depth[i])) {
            sea++;
            assert_true(p->normal[4 * i + 3] > 0.0f &&
                        p->normal[4 * i + 3] <= 1);
            assert_true(p->slope_variance[2 * i] >= 0.0f);
            assert_true(p->water[4 * i + 2] > 0.0f);
        }
    }
    assert_true(sea > 128 * 60);
    pel_picture_release(p);
    pel_renderer_destroy(r);
}

#define PIXELS (128 * 128)

/* Same function in a fragment and in a compute wrapper, layers or not. */
static void wrappers_agree(void **state)
{
    (void)state;
    static uint8_t color[PIXELS * 4];
    static float layers[PEL_LAYERS][PIXELS * 4];
    struct pel_renderer *r = create("fragment");
    struct pel_picture *p = draw(r, all_layers);
    memcpy(color, p->rgba, sizeof color);
    for (int i = 0; i < PEL_LAYERS; i++) {
        const struct pel_layer_info *l = &pel_layer_table[i];
        const float *from = pel_picture_layer(p, l);
        /* F̄ starts inside its pixel. */
        size_t floats =
            (size_t)l->floats * PIXELS - (l->bit == PEL_LAYER_FRESNEL ? 3 : 0);
        memcpy(layers[i], from, floats * sizeof(float));
    }
    pel_picture_release(p);
    pel_renderer_destroy(r);
    r = create("compute");
    p = draw(r, all_layers);
    assert_memory_equal(p->rgba, color, sizeof color);
    for (int i = 0; i < PEL_LAYERS; i++) {
        const struct pel_layer_info *l = &pel_layer_table[i];
        const float *y = pel_picture_layer(p, l);
        for (int k = 0; k < PIXELS; k++) {
            for (size_t n = 0; n < strlen(l->channels); n++) {
                size_t at = (size_t)(k * l->floats) + n;
                assert_true(memcmp(&layers[i][at], &y[at], sizeof(float)) == 0);
            }
        }
    }
    pel_picture_release(p);
    p = draw(r, PEL_LAYER_COLOR);
    assert_memory_equal(p->rgba, color, sizeof color);
    assert_null(pel_picture_layer(p, &pel_layer_table[0]));
    pel_picture_release(p);
    pel_renderer_destroy(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_make_the_radiance),
        cmocka_unit_test(wrappers_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
