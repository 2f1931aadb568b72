/* Textures of objects: what the layer `albedo` shows near, far, past the edge
 * of the texture, by either wrapper. */
#include "render/modelpaint.h"

#include "models/shape.h"
#include "render/render_testkit.h"

#define SIDE 256

static struct pel_sea sea;

/* A wall 20 m wide and 12 m high across the bow's axis, u to the right as the
 * stern sees it. */
static const struct pel_model *
wall_with(const struct pel_model_texture *texture, float turns, float cutoff)
{
    struct pel_shape shape = { .name = "wall" };
    struct pel_model_draft draft;
    struct pel_fault fault = { 0 };
    const struct pel_model *model = NULL;
    struct pel_model_material material = { .name = "painted",
                                           .albedo = { 1, 1, 1 },
                                           .roughness = 1,
                                           .alpha_cutoff = cutoff,
                                           .two_sided = true };
    material.texture = texture ? pel_shape_texture(&shape, texture) : -1;
    int paint = pel_shape_material(&shape, &material);
    int node = pel_shape_node(&shape, "wall");
    const struct pel_model_vertex v[] = {
        { .position = { 0, 10, 0 }, .uv = { 0, 0 } },
        { .position = { 0, -10, 0 }, .uv = { turns, 0 } },
        { .position = { 0, -10, 12 }, .uv = { turns, 1 } },
        { .position = { 0, 10, 12 }, .uv = { 0, 1 } },
    };
    pel_shape_triangle(&shape, (struct pel_model_vertex[]){ v[0], v[1], v[2] },
                       paint, node);
    pel_shape_triangle(&shape, (struct pel_model_vertex[]){ v[0], v[2], v[3] },
                       paint, node);
    assert_int_equal(pel_shape_finish(&shape, &draft, &fault), PEL_OK);
    assert_int_equal(pel_model_create(&draft.model, &model, &fault), PEL_OK);
    pel_model_draft_clear(&draft);
    pel_shape_clear(&shape);
    return model;
}

static const struct pel_model *wall(const struct pel_model_texture *texture,
                                    float turns)
{
    return wall_with(texture, turns, 0.0f);
}

/* Its albedo where a camera 6 m high looks north at it; width x width. */
static void look(const struct pel_model *model, double away_m, uint32_t width,
                 float *out)
{
    struct pel_environment env = test_environment(&sea, 0.0);
    const struct pel_object object = {
        .id = 3,
        .model = model,
        .north_m = away_m,
        .world_from_model = { { 0, 1, 0 }, { -1, 0, 0 }, { 0, 0, 1 } },
    };
    env.objects = &object;
    env.object_count = 1;
    struct pel_camera c = test_camera(
        (struct test_look){ 6.0, 0.0, 0.0, 0.0, 40.0, width, width });
    struct pel_picture *p =
        test_draw(renderer, &env, &c, PEL_LAYER_ALBEDO | PEL_LAYER_ID);
    for (uint32_t i = 0; i < width * width; i++) {
        bool there = p->id[i] == 4.0f;
        for (int k = 0; k < 3; k++) {
            out[3 * i + (uint32_t)k] =
                there ? p->layer[PEL_AT_ALBEDO][4 * i + (uint32_t)k] : -1.0f;
        }
    }
    pel_picture_release(p);
}

static float linear(int code)
{
    double v = code / 255.0;
    return (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
}

static void assert_albedo(const float *seen, const float want[3])
{
    for (int k = 0; k < 3; k++) {
        /* A byte of a square root, a half of a layer. */
        float step = 2.0f * sqrtf(want[k]) / 255.0f + 0.001f;
        assert_true(fabsf(seen[k] - want[k]) < step);
    }
}

/* Left red, right green; repeated three times it is both in turn. */
static void halves(float turns)
{
    static const uint8_t codes[2][3] = { { 188, 40, 40 }, { 40, 160, 60 } };
    static uint8_t texels[6 * 8 * 4];
    static float seen[3 * 96 * 96];
    for (int i = 0; i < 6 * 8; i++) {
        memcpy(&texels[4 * i], codes[i % 8 >= 4], 3);
        texels[4 * i + 3] = 255;
    }
    const struct pel_model_texture t = { 8, 6, texels };
    const struct pel_model *model = wall(&t, turns);
    look(model, 40.0, 96, seen);
    float want[2][3];
    for (int i = 0; i < 2; i++) {
        float colour[3];
        for (int k = 0; k < 3; k++) {
            colour[k] = linear(codes[i][k]);
        }
        pel_model_reflectance(colour, want[i]);
    }
    int counted = 0;
    for (int x = 0; x < 96; x++) {
        double u = 0.5 + 40.0 * tan(20 * PEL_DEG) * (x + 0.5 - 48) / 48 / 20.0;
        double at = fmod(u * (double)turns, 1.0);
        const float *pixel = &seen[3 * (48 * 96 + x)];
        bool middle = fabs(at - 0.25) < 0.12 || fabs(at - 0.75) < 0.12;
        if (pixel[0] >= 0 && middle && u > 0 && u < 1) {
            assert_albedo(pixel, want[at > 0.5]);
            counted++;
        }
    }
    assert_true(counted > 20);
    pel_model_unref(model);
}

static void textures_are_seen(void **state)
{
    (void)state;
    halves(1.0f);
    halves(3.0f);
}

/* A chequer of white and black texels far away is as bright as their mean. */
static void far_textures_are_their_mean(void **state)
{
    (void)state;
    static uint8_t texels[SIDE * SIDE * 4];
    static float seen[3 * 200 * 200];
    for (int i = 0; i < SIDE * SIDE; i++) {
        memset(&texels[4 * i], (i + i / SIDE) % 2 ? 255 : 0, 3);
        texels[4 * i + 3] = 255;
    }
    const struct pel_model_texture t = { SIDE, SIDE, texels };
    const struct pel_model *model = wall(&t, 1.0f);
    float want[3];
    pel_model_reflectance((const float[3]){ 0.5f, 0.5f, 0.5f }, want);
    look(model, 500.0, 200, seen);
    int counted = 0;
    for (int i = 0; i < 200 * 200; i++) {
        if (seen[3 * i] >= 0) {
            assert_albedo(&seen[3 * i], want);
            counted++;
        }
    }
    assert_true(counted >= 30);
    pel_model_unref(model);
}

/* With textures and again without: neither leaves anything behind. */
static void plain_paint_stays(void **state)
{
    (void)state;
    static const uint8_t white[4] = { 255, 255, 255, 255 };
    static float plain[3 * 64 * 64], after[3 * 64 * 64];
    const struct pel_model_texture t = { 1, 1, white };
    const struct pel_model *bare = wall(NULL, 1.0f), *painted = wall(&t, 1.0f);
    look(bare, 60.0, 64, plain);
    look(painted, 60.0, 64, after);
    assert_albedo(&after[3 * (32 * 64 + 32)], &plain[3 * (32 * 64 + 32)]);
    look(bare, 60.0, 64, after);
    assert_memory_equal(plain, after, sizeof plain);
    pel_model_unref(bare);
    pel_model_unref(painted);
}

/* A wall of bars: the layer `id` shows what rays meet, holes left out. */
static void holes_are_where_rays_pass(void **state)
{
    (void)state;
    enum { WIDTH = 128 };
    static uint8_t texels[16 * 16 * 4];
    static float seen[3 * WIDTH * WIDTH];
    for (int i = 0; i < 16 * 16; i++) {
        memset(&texels[4 * i], 200, 3);
        texels[4 * i + 3] = i % 16 / 4 % 2 || i / 16 < 3 ? 200 : 90;
    }
    const struct pel_model_texture t = { 16, 16, texels };
    const struct pel_model *model = wall_with(&t, 2.0f, 0.5f);
    look(model, 30.0, WIDTH, seen);
    int there = 0, holes = 0, wrong = 0;
    for (int y = 0; y < WIDTH / 2; y++) { /* above the sea */
        for (int x = 0; x < WIDTH; x++) {
            double tan_half = tan(20 * PEL_DEG);
            double right = tan_half * (x + 0.5 - WIDTH / 2.0) / (WIDTH / 2.0);
            double up = -tan_half * (y + 0.5 - WIDTH / 2.0) / (WIDTH / 2.0);
            const struct pel_vec3 from = { -30, 0, 6 };
            const struct pel_vec3 way =
                pel_vec3_normalize((struct pel_vec3){ 1, -right, up });
            struct pel_model_hit hit;
            bool met = pel_model_cast(model, from, way, 100.0, &hit);
            bool within = fabs(30 * right) < 10 && 6 + 30 * up < 12;
            bool drawn = seen[3 * (y * WIDTH + x)] >= 0;
            there += met;
            holes += within && !met;
            wrong += met != drawn;
        }
    }
    /* Filtering rounds the 16 corners of holes, a pixel each at most. */
    printf("%d met, %d in holes, %d wrong\n", there, holes, wrong);
    assert_true(there > 1000 && holes > 1000);
    assert_true(wrong <= 16);
    pel_model_unref(model);
}

/* Bars far narrower than a pixel: half of the light behind them is seen. */
static void narrow_holes_let_their_share_by(void **state)
{
    (void)state;
    enum { WIDTH = 96 };
    static uint8_t texels[SIDE * SIDE * 4];
    for (int i = 0; i < SIDE * SIDE; i++) {
        memset(&texels[4 * i], 0, 3); /* black */
        texels[4 * i + 3] = i % 2 ? 255 : 0;
    }
    const struct pel_model_texture t = { SIDE, SIDE, texels };
    const struct pel_model *models[2] = { wall_with(&t, 1.0f, 0.5f),
                                          wall_with(&t, 1.0f, 0.0f) };
    double light[3] = { 0 };
    for (int k = 0; k < 3; k++) {
        struct pel_environment env = test_environment(&sea, 0.0);
        const struct pel_object object = {
            .id = 3,
            .model = models[k % 2],
            .north_m = 60.0,
            .world_from_model = { { 0, 1, 0 }, { -1, 0, 0 }, { 0, 0, 1 } },
        };
        env.objects = &object;
        env.object_count = k < 2;
        struct pel_camera c = test_camera(
            (struct test_look){ 6.0, 0.0, 3.0, 0.0, 10.0, WIDTH, WIDTH });
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
        for (int y = 24; y < 48; y++) { /* of the wall before the sky */
            for (int x = 32; x < 64; x++) {
                light[k] += (double)p->radiance[4 * (y * WIDTH + x) + 1];
            }
        }
        pel_picture_release(p);
    }
    double through = (light[0] - light[1]) / (light[2] - light[1]);
    printf("%.3f of the sky is seen through\n", through);
    assert_true(light[1] < 0.5 * light[2]);
    assert_true(fabs(through - 0.5) < 0.02);
    for (int k = 0; k < 2; k++) {
        pel_model_unref(models[k]);
    }
}

static void in_compute_too(void **state)
{
    pel_renderer_destroy(renderer);
    renderer = test_renderer("compute");
    textures_are_seen(state);
    far_textures_are_their_mean(state);
    holes_are_where_rays_pass(state);
    narrow_holes_let_their_share_by(state);
}

static int begin(void **state)
{
    test_sea(3.0, 0.0, 1, &sea);
    return begin_renderer(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(textures_are_seen),
        cmocka_unit_test(far_textures_are_their_mean),
        cmocka_unit_test(plain_paint_stays),
        cmocka_unit_test(holes_are_where_rays_pass),
        cmocka_unit_test(narrow_holes_let_their_share_by),
        cmocka_unit_test(in_compute_too),
    };
    return cmocka_run_group_tests(tests, begin, end_renderer);
}
