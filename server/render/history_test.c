/* A picture does not depend on what was drawn before it: scenes of every kind,
 * each drawn as fragments by a renderer of its own, against the same by one
 * renderer that draws them all, in several orders and several a frame, by both
 * wrappers, bit for bit. */
#include "render/probe.h"
#include "render/render_testkit.h"
#include "render/waterprobe.h"

enum {
    DEEP,
    COAST,
    COAST_FFT,
    SHALLOW,
    NIGHT,
    FROM_BELOW,
    LAYERS,
    COAST_LAYERS,
    STALE,
    LARGE,
    TIDE,
    SCENES, /* a prime: any step walks through all of them */
};

struct scene {
    struct pel_environment env;
    struct pel_camera camera;
    unsigned layers;
};

struct kept {
    size_t size;
    uint8_t *bytes;
};

static struct pel_sea calm, rough, cascades;
static const struct pel_seabed *island, *bank;
static struct scene scenes[SCENES];
/* By fragments; in compute, the same on software, where both wrappers give the
 * same bits. */
static struct kept alone[SCENES], alone_in_compute[SCENES];

/* East of the origin, where a crest stands higher than the lowest eye. */
static double under_a_crest(const struct pel_sea *sea, double time_s)
{
    struct pel_surface_sample s = { 0 };
    double east_m = 0;
    while (s.height_m < PEL_LEAST_EYE_M + 0.5 && east_m < 2000) {
        pel_sea_sample(sea, ++east_m, 0, time_s, &s);
    }
    assert_true(east_m < 2000);
    return east_m;
}

static void fill_scenes(void)
{
    const struct pel_environment deep = test_environment(&calm, 3),
                                 wild = test_environment(&rough, 9),
                                 fft = test_environment(&cascades, 5);
    const struct test_look ahead = { 12, 10, -4, 0, 60, 224, 160 };
    const struct test_look away = { 6, 200, -3, 7, 90, 320, 96 };
    const struct test_look far_down = { 500, 10, -30, 0, 50, 130, 190 };
    const unsigned parts = pel_layers_from(PEL_LAYER_FROM_WATER);
    scenes[DEEP] = (struct scene){ deep, test_camera(ahead), PEL_LAYER_COLOR };
    scenes[COAST] = scenes[DEEP];
    scenes[COAST].env = test_over(deep, island, 1000);
    scenes[COAST_FFT] =
        (struct scene){ test_over(fft, island, 1000), test_camera(far_down),
                        PEL_LAYER_COLOR };
    scenes[SHALLOW] = (struct scene){ test_over(deep, bank, 8),
                                      test_camera(away), PEL_LAYER_RADIANCE };
    scenes[SHALLOW].env.caustics = true;
    scenes[NIGHT] = (struct scene){ fft, test_camera(away), PEL_LAYER_COLOR };
    scenes[NIGHT].env.lights[PEL_LIGHT_SUN].direction = test_sun(-7, 250);
    scenes[NIGHT].env.visibility_m = 3000;
    scenes[FROM_BELOW] =
        (struct scene){ wild, test_camera(ahead), PEL_LAYER_COLOR };
    scenes[FROM_BELOW].camera.altitude_m = PEL_LEAST_EYE_M;
    scenes[FROM_BELOW].camera.east_m = under_a_crest(&rough, wild.time_s);
    scenes[LAYERS] =
        (struct scene){ wild, test_camera(far_down), TEST_ALL_LAYERS | parts };
    scenes[COAST_LAYERS] = scenes[COAST];
    scenes[COAST_LAYERS].layers = TEST_ALL_LAYERS | PEL_LAYER_WATER | parts;
    scenes[STALE] = scenes[DEEP];
    scenes[STALE].env.stale = PEL_STALE_CIGI | PEL_STALE_NMEA;
    scenes[STALE].env.clouds =
        (struct pel_clouds){ 0.6, PEL_CLOUD_CUMULUS, 900, 550, 12, 3, 1 };
    scenes[LARGE] = scenes[COAST];
    scenes[LARGE].camera =
        test_camera((struct test_look){ 3, 30, -8, 0, 70, 400, 256 });
    scenes[TIDE] = scenes[COAST];
    scenes[TIDE].env.fog_count = 2;
    scenes[TIDE].env.fog[0] =
        (struct pel_fog){ .extinction = 4e-4, .top_m = 60, .soft_m = 20 };
    scenes[TIDE].env.fog[1] = (struct pel_fog){
        .extinction = 0.02, .top_m = 40, .radius_m = 300, .north_m = 400
    };
    scenes[NIGHT].env.fog_count = 1;
    scenes[NIGHT].env.fog[0] =
        (struct pel_fog){ .extinction = 1e-3, .top_m = 50, .soft_m = 20 };
    scenes[TIDE].env.sea_level_m = 4;
    scenes[TIDE].env.clouds =
        (struct pel_clouds){ 1, PEL_CLOUD_STRATUS, 350, 400, 12, 3, 2 };
    /* The maps of all orders take most of the time. */
    for (int i = 0; i < SCENES; i++) {
        scenes[i].env.orders = i == LAYERS ? PEL_ORDERS_ALL : PEL_ORDERS_TWO;
    }
}

/* --- pictures as bytes ---------------------------------------------------- */

/* Fragments flush numbers that are too small to be normal, compute does not. */
static void flush(float *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        values[i] = fabsf(values[i]) < 1e-30F ? 0.0F : values[i];
    }
}

static struct kept keep(const struct pel_picture *p, unsigned layers)
{
    size_t pixels = (size_t)p->width * p->height, at = 0;
    struct kept k = { pixels * pel_layer_bytes(layers) + sizeof(double), NULL };
    k.bytes = calloc(1, k.size);
    assert_non_null(k.bytes);
    memcpy(k.bytes, &p->exposure_ev, sizeof(double));
    at += sizeof(double);
    if (p->rgba) {
        memcpy(k.bytes + at, p->rgba, 4 * pixels);
        at += 4 * pixels;
    }
    for (int i = 0; i < PEL_LAYERS; i++) {
        const struct pel_layer_info *info = &pel_layer_table[i];
        const float *values = p->layer[i];
        size_t size = sizeof *values * (size_t)pel_layer_stride(info) * pixels;
        if (!(layers & info->bit) || !values || at + size > k.size) {
            continue;
        }
        memcpy(k.bytes + at, values, size);
        flush((float *)(void *)(k.bytes + at), size / sizeof(float));
        at += size;
    }
    return k;
}

/* By a renderer that has drawn nothing before. */
static struct kept draw_alone(const char *shading, const struct scene *s)
{
    struct pel_renderer *r = test_renderer(shading);
    struct pel_picture *p = test_draw(r, &s->env, &s->camera, s->layers);
    struct kept k = keep(p, s->layers);
    pel_picture_release(p);
    pel_renderer_destroy(r);
    return k;
}

static void must_be(const struct pel_picture *p, int scene, int before,
                    const char *shading)
{
    struct kept now = keep(p, scenes[scene].layers);
    const struct kept *then = strcmp(shading, "compute") == 0
                                  ? &alone_in_compute[scene]
                                  : &alone[scene];
    size_t differ = 0;
    assert_int_equal(now.size, then->size);
    for (size_t i = 0; i < now.size; i++) {
        differ += now.bytes[i] != then->bytes[i];
    }
    free(now.bytes);
    if (differ) {
        fail_msg("%s: %zu of %zu bytes of scene %d differ after scene %d",
                 shading, differ, now.size, scene, before);
    }
}

/* --- tests ---------------------------------------------------------------- */

/* Round and round: each scene after the one before it in the list, then after
 * the second before it, and so on, so many times. */
static void in_turns(const char *shading, int steps)
{
    struct pel_renderer *r = test_renderer(shading);
    int before = -1, now = 0;
    for (int i = 0; i < SCENES * steps; i++) {
        const struct scene *s = &scenes[now];
        struct pel_picture *p = test_draw(r, &s->env, &s->camera, s->layers);
        must_be(p, now, before, shading);
        pel_picture_release(p);
        before = now;
        now = (now + 1 + i / SCENES) % SCENES;
    }
    pel_renderer_destroy(r);
}

static void fragments_remember_nothing(void **state)
{
    (void)state;
    in_turns("fragment", 5);
}

static void compute_remembers_nothing(void **state)
{
    (void)state;
    in_turns("compute", 2);
}

/* Each scene band by band, with another one between any two. */
static void bands_are_the_whole(void **state)
{
    (void)state;
    struct pel_renderer *r = test_renderer("fragment");
    for (int now = 0; now < SCENES; now++) {
        const struct scene *s = &scenes[now], *o = &scenes[(now + 1) % SCENES];
        struct pel_draw draw = { .camera = s->camera, .layers = s->layers };
        uint32_t height = s->camera.height;
        for (; draw.first_row < height; draw.first_row += PEL_BAND_ROWS) {
            uint32_t left = height - draw.first_row;
            draw.rows = left < PEL_BAND_ROWS ? left : PEL_BAND_ROWS;
            assert_int_equal(pel_renderer_submit(r, &s->env, &draw, 1), PEL_OK);
            if (left > PEL_BAND_ROWS) {
                pel_picture_release(
                    test_draw(r, &o->env, &o->camera, o->layers));
            }
        }
        struct pel_picture *p = pel_renderer_collect(r, 60000000000);
        assert_non_null(p);
        must_be(p, now, -1, "fragment, in bands");
        pel_picture_release(p);
    }
    pel_renderer_destroy(r);
}

/* Views of one moment in one frame, whichever comes first. */
static void views_do_not_see_each_other(void **state)
{
    (void)state;
    static const int views[] = { LARGE, COAST, COAST_LAYERS };
    enum { VIEWS = sizeof views / sizeof *views };
    static const char *const shadings[] = { "fragment", "compute" };
    for (int s = 0; s < 2; s++) {
        struct pel_renderer *r = test_renderer(shadings[s]);
        for (int first = 0; first < VIEWS; first++) {
            struct pel_draw draws[VIEWS];
            for (int i = 0; i < VIEWS; i++) {
                const struct scene *v = &scenes[views[(first + i) % VIEWS]];
                draws[i] = (struct pel_draw){ .camera = v->camera,
                                              .layers = v->layers };
            }
            assert_int_equal(
                pel_renderer_submit(r, &scenes[COAST].env, draws, VIEWS),
                PEL_OK);
            for (int i = 0; i < VIEWS; i++) {
                struct pel_picture *p = pel_renderer_collect(r, 60000000000);
                assert_non_null(p);
                int scene = views[(first + i) % VIEWS];
                must_be(p, scene, -1, shadings[s]);
                pel_picture_release(p);
            }
        }
        pel_renderer_destroy(r);
    }
}

/* Questions to the shaders, of other scenes, between two pictures. */
static void probes_change_nothing(void **state)
{
    (void)state;
    struct pel_renderer *r = test_renderer("fragment");
    for (int i = 0; i < 4; i++) {
        int scene = i % 2 ? COAST : DEEP;
        const struct scene *s = &scenes[scene], *other = &scenes[NIGHT];
        struct pel_picture *p = test_draw(r, &s->env, &s->camera, s->layers);
        must_be(p, scene, -1, "fragment, probed");
        pel_picture_release(p);
        const struct pel_probe probe = { .dir = { 0.6, 0, 0.8 },
                                         .slope_along = 0.03,
                                         .slope_cross = 0.02,
                                         .height_m = 100 };
        const struct pel_geometry at = { .sun_zenith_rad = 0.7,
                                         .view_zenith_rad = 0.4 };
        struct pel_probe_answer answer;
        struct pel_water_parts parts;
        assert_int_equal(
            pel_renderer_probe(r, &other->env, &probe, &answer, NULL), PEL_OK);
        assert_int_equal(
            pel_renderer_probe_water(r, &other->env, &at, &parts, NULL),
            PEL_OK);
    }
    pel_renderer_destroy(r);
}

static int set_up(void **state)
{
    (void)state;
    test_sea(3, 0, 1, &calm);
    test_sea(16, 0, 2, &rough);
    test_fft_sea(7, 3, &cascades);
    island = test_bed(test_island);
    bank = test_bed(test_bank);
    fill_scenes();
    struct pel_renderer *r = test_renderer("fragment");
    bool software = pel_renderer_is_software(r);
    pel_renderer_destroy(r);
    for (int i = 0; i < SCENES; i++) {
        alone[i] = draw_alone("fragment", &scenes[i]);
        alone_in_compute[i] =
            software ? alone[i] : draw_alone("compute", &scenes[i]);
    }
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    for (int i = 0; i < SCENES; i++) {
        if (alone_in_compute[i].bytes != alone[i].bytes) {
            free(alone_in_compute[i].bytes);
        }
        free(alone[i].bytes);
    }
    pel_seabed_unref(island);
    pel_seabed_unref(bank);
    pel_sea_finish(&calm);
    pel_sea_finish(&rough);
    pel_sea_finish(&cascades);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fragments_remember_nothing),
        cmocka_unit_test(compute_remembers_nothing),
        cmocka_unit_test(probes_change_nothing),
        cmocka_unit_test(bands_are_the_whole),
        cmocka_unit_test(views_do_not_see_each_other),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
