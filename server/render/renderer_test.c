/* The renderer on the software device: the same bytes for the same scene, no
 * seam between parts of a frustum, sane numbers for any scene, no popping, and
 * its limits. */
#define TEST_ANTIALIASING true
#include "render/renderer.h"

#include <pthread.h>

#include "render/readback.h"
#include "render/render_testkit.h"

static struct pel_sea sea;

static size_t layer_bytes(const struct pel_picture *p, int channels)
{
    return (size_t)p->width * p->height * (size_t)channels;
}

static void assert_same(const struct pel_picture *a,
                        const struct pel_picture *b)
{
    assert_memory_equal(a->rgba, b->rgba, layer_bytes(a, 4));
    assert_memory_equal(a->radiance, b->radiance, layer_bytes(a, 16));
    assert_memory_equal(a->depth, b->depth, layer_bytes(a, 4));
    assert_memory_equal(a->normal, b->normal, layer_bytes(a, 16));
    assert_true(a->exposure_ev == b->exposure_ev);
}

/* A thread has one renderer: another takes its place. */
static void use_renderer(const char *shading)
{
    pel_renderer_destroy(renderer);
    renderer = test_renderer(shading);
}

/* A picture that outlives its renderer. */
struct copy {
    struct pel_picture picture;
    void *pixels;
};

static struct copy copy_of(const struct pel_picture *p)
{
    size_t n = layer_bytes(p, 1);
    struct copy c = { *p, malloc(40 * n) };
    assert_non_null(c.pixels);
    uint8_t *to = c.pixels;
    c.picture.radiance = memcpy(to, p->radiance, 16 * n);
    c.picture.normal = memcpy(to + 16 * n, p->normal, 16 * n);
    c.picture.depth = memcpy(to + 32 * n, p->depth, 4 * n);
    c.picture.rgba = memcpy(to + 36 * n, p->rgba, 4 * n);
    return c;
}

static void same_scene_same_bytes(void **state)
{
    (void)state;
    static struct pel_sea other_sea;
    test_sea(9.0, 2.0, 4, &sea);
    test_sea(18.0, 0.0, 5, &other_sea);
    struct pel_environment env = test_environment(&sea, 123.4);
    struct pel_camera c =
        test_camera((struct test_look){ 6.0, 30.0, -4.0, 3.0, 60.0, 160, 96 });
    struct pel_picture *first = test_draw(renderer, &env, &c, TEST_ALL_LAYERS);
    struct pel_picture *again = test_draw(renderer, &env, &c, TEST_ALL_LAYERS);
    assert_same(first, again);
    pel_picture_release(again);

    /* Other seas, Suns, airs, eyes and sizes in between leave no trace. */
    for (int i = 0; i < 3; i++) {
        struct pel_environment other = test_environment(&other_sea, 7.0 + i);
        other.lights[PEL_LIGHT_SUN].direction = test_sun(2.0 + 20.0 * i, 200.0);
        other.visibility_m = 3000.0 + 1e5 * i;
        other.water = pel_water_deep(5.0);
        struct pel_camera elsewhere = test_camera(
            (struct test_look){ 40.0 * i + 2.0, 100.0, -30.0 * i, 0.0, 90.0,
                                200 + 30 * (unsigned)i, 64 });
        pel_picture_release(test_draw(renderer, &other, &elsewhere,
                                      i ? TEST_ALL_LAYERS : PEL_LAYER_COLOR));
    }
    again = test_draw(renderer, &env, &c, TEST_ALL_LAYERS);
    assert_same(first, again);
    pel_picture_release(again);

    /* Beside others of the same frame, too. */
    struct pel_draw draws[3] = { { .layers = TEST_ALL_LAYERS },
                                 { .layers = TEST_ALL_LAYERS },
                                 { .layers = PEL_LAYER_COLOR } };
    for (int i = 0; i < 3; i++) {
        draws[i].camera = test_camera((struct test_look){
            30.0, 30.0, -14.0, 3.0, 60.0, 100 + 100 * (unsigned)i, 70 });
    }
    draws[1].camera = c;
    assert_int_equal(pel_renderer_submit(renderer, &env, draws, 3), PEL_OK);
    for (int i = 0; i < 3; i++) {
        struct pel_picture *p = pel_renderer_collect(renderer, 60000000000);
        assert_non_null(p);
        if (i == 1) {
            assert_same(first, p);
        }
        pel_picture_release(p);
    }

    struct copy kept = copy_of(first);
    pel_picture_release(first);
    use_renderer(NULL);
    again = test_draw(renderer, &env, &c, TEST_ALL_LAYERS);
    assert_same(&kept.picture, again);
    pel_picture_release(again);
    free(kept.pixels);
}

/* Layers that are not asked for change nothing in those that are. */
static void layers_do_not_disturb(void **state)
{
    (void)state;
    test_sea(9.0, 0.0, 4, &sea);
    struct pel_environment env = test_environment(&sea, 3.0);
    struct pel_camera c =
        test_camera((struct test_look){ 6.0, 30.0, -4.0, 0.0, 60.0, 128, 96 });
    struct pel_picture *all = test_draw(renderer, &env, &c, TEST_ALL_LAYERS);
    struct pel_picture *color = test_draw(renderer, &env, &c, PEL_LAYER_COLOR);
    struct pel_picture *light =
        test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
    assert_null(color->radiance);
    assert_null(color->depth);
    assert_null(color->normal);
    assert_null(light->rgba);
    /* Two programs: the compiler may round a last bit differently, which the
     * dither may carry across one step of 255. */
    int worst = 0;
    for (size_t i = 0; i < layer_bytes(all, 4); i++) {
        int d = abs(all->rgba[i] - color->rgba[i]);
        worst = d > worst ? d : worst;
        double l = all->radiance[i], m = light->radiance[i];
        assert_true(fabs(l - m) <= 1e-4 * fabs(l) + 1e-9);
    }
    assert_true(worst <= 1);
    pel_picture_release(all);
    pel_picture_release(color);
    pel_picture_release(light);
}

/* --- the seam --------------------------------------------------------------
 */

struct box {
    uint32_t x0, x1, y0, y1;
};

static double by_degrees(double tangent)
{
    return tan(atan(tangent) / PEL_DEG * PEL_DEG);
}

static struct pel_camera cut(const struct pel_camera *whole, struct box b,
                             bool degrees)
{
    double px = (whole->tan_right - whole->tan_left) / whole->width;
    double py = (whole->tan_top - whole->tan_bottom) / whole->height;
    struct pel_camera c = *whole;
    c.width = b.x1 - b.x0;
    c.height = b.y1 - b.y0;
    c.tan_left = whole->tan_left + px * b.x0;
    c.tan_right = whole->tan_left + px * b.x1;
    c.tan_top = whole->tan_top - py * b.y0;
    c.tan_bottom = whole->tan_top - py * b.y1;
    /* Exposed as the whole is. */
    c.sight_count = 1;
    c.sights[0] =
        (struct pel_sight){ whole->world_from_camera, whole->altitude_m,
                            whole->tan_left,          whole->tan_right,
                            whole->tan_top,           whole->tan_bottom };
    if (degrees) {
        c.tan_left = by_degrees(c.tan_left);
        c.tan_right = by_degrees(c.tan_right);
        c.tan_top = by_degrees(c.tan_top);
        c.tan_bottom = by_degrees(c.tan_bottom);
    }
    return c;
}

/* Pixels of a part that differ from the whole's, any layer. */
static int different(const struct pel_picture *whole,
                     const struct pel_picture *part, struct box b)
{
    int count = 0;
    for (uint32_t y = 0; y < part->height; y++) {
        for (uint32_t x = 0; x < part->width; x++) {
            size_t i = (size_t)y * part->width + x;
            size_t j = (size_t)(y + b.y0) * whole->width + x + b.x0;
            bool same =
                memcmp(part->rgba + 4 * i, whole->rgba + 4 * j, 4) == 0 &&
                memcmp(part->radiance + 4 * i, whole->radiance + 4 * j, 16) ==
                    0 &&
                memcmp(part->depth + i, whole->depth + j, 4) == 0 &&
                memcmp(part->normal + 4 * i, whole->normal + 4 * j, 16) == 0;
            if (!same && count++ == 0) {
                printf("  first: %u,%u of the part; depth %.9g %.9g, radiance "
                       "%.9g %.9g\n",
                       x, y, (double)part->depth[i], (double)whole->depth[j],
                       (double)part->radiance[4 * i],
                       (double)whole->radiance[4 * j]);
            }
        }
    }
    return count;
}

static struct pel_clouds overhead;

/* Of the sea and the clouds in force. */
static int seam_here(struct test_look look, bool degrees)
{
    static const struct box boxes[] = {
        { 0, 288, 0, 256 },   { 224, 512, 0, 256 },  { 0, 512, 0, 144 },
        { 0, 512, 112, 256 }, { 300, 377, 90, 171 }, /* odd, in the middle */
    };
    struct pel_environment env = test_environment(&sea, 50.0);
    env.clouds = overhead;
    struct pel_camera c = test_camera(look);
    struct pel_picture *whole = test_draw(renderer, &env, &c, TEST_ALL_LAYERS);
    int wrong = 0;
    for (size_t i = 0; i < sizeof boxes / sizeof *boxes; i++) {
        struct pel_camera part = cut(&c, boxes[i], degrees);
        struct pel_picture *p =
            test_draw(renderer, &env, &part, TEST_ALL_LAYERS);
        int n = different(whole, p, boxes[i]);
        if (n > 0) {
            printf("wind %g, height %g pitch %g roll %g part %zu: %d pixels\n",
                   sea.desc.wind_mps, look.height_m, look.pitch, look.roll, i,
                   n);
        }
        wrong += n;
        pel_picture_release(p);
    }
    pel_picture_release(whole);
    return wrong;
}

static int seam(double wind_mps, struct test_look look, bool degrees)
{
    test_sea(wind_mps, 0.0, 1, &sea);
    return seam_here(look, degrees);
}

static const struct test_look seam_looks[] = {
    { 6.0, 20.0, 0.0, 0.0, 60.0, 512, 256 },
    { 6.0, 200.0, -9.0, 11.0, 60.0, 512, 256 },
    { 30.0, 77.0, -17.0, -23.0, 60.0, 512, 256 },
    { 1000.0, 140.0, -6.0, 4.0, 60.0, 512, 256 },
    { 1000.0, 300.0, -80.0, 60.0, 60.0, 512, 256 },
    { -4.0, 300.0, 25.0, -8.0, 60.0, 512, 256 }, /* from under water */
};

static void tiles_have_no_seam(void **state)
{
    (void)state;
    int wrong = 0;
    for (size_t i = 0; i < sizeof seam_looks / sizeof *seam_looks; i++) {
        wrong += seam(i % 2 ? 5.0 : 15.0, seam_looks[i], i % 2);
    }
    wrong += seam(5.0, seam_looks[0], true);
    wrong += seam(15.0, seam_looks[2], true);
    assert_int_equal(wrong, 0);
}

static void cascades_have_no_seam(void **state)
{
    (void)state;
    int wrong = 0;
    test_fft_sea(12.0, 1, &sea);
    wrong += seam_here(seam_looks[1], true);
    wrong += seam_here(seam_looks[2], false);
    wrong += seam_here(seam_looks[3], true);
    pel_sea_finish(&sea);
    assert_int_equal(wrong, 0);
}

/* A sea that takes the memory of the one before is not taken for it. */
static void cascades_are_not_mixed_up(void **state)
{
    (void)state;
    static const double winds[] = { 5.0, 15.0, 5.0 };
    struct pel_camera c =
        test_camera((struct test_look){ 6.0, 30.0, -10.0, 0.0, 60.0, 96, 64 });
    struct copy kept[3];
    for (int i = 0; i < 3; i++) {
        test_fft_sea(winds[i], 1, &sea);
        struct pel_environment env = test_environment(&sea, 5.0);
        env.wind_mps = 5.0;
        struct pel_picture *p = test_draw(renderer, &env, &c, TEST_ALL_LAYERS);
        kept[i] = copy_of(p);
        pel_picture_release(p);
        pel_sea_finish(&sea);
    }
    assert_same(&kept[0].picture, &kept[2].picture);
    assert_memory_not_equal(kept[0].picture.depth, kept[1].picture.depth,
                            96 * 64 * 4);
    for (int i = 0; i < 3; i++) {
        free(kept[i].pixels);
    }
}

static size_t bytes_of_layers(unsigned layers, const struct pel_camera *c)
{
    return pel_layer_bytes(layers) * c->width * c->height;
}

/* The picture in bands, with another picture of another moment and size drawn
 * between any two. */
static struct pel_picture *draw_in_bands(const struct pel_environment *env,
                                         const struct pel_camera *c,
                                         unsigned layers, uint32_t rows)
{
    struct pel_draw draw = { .camera = *c, .layers = layers };
    struct pel_environment other = *env;
    struct pel_camera small =
        test_camera((struct test_look){ 12.0, 70.0, -8.0, 3.0, 50.0, 80, 60 });
    other.time_s += 3.0;
    for (uint32_t y = 0; y < c->height; y += rows) {
        if (y > 0) {
            pel_picture_release(
                test_draw(renderer, &other, &small, PEL_LAYER_COLOR));
        }
        draw.first_row = y;
        draw.rows = c->height - y < rows ? c->height - y : rows;
        assert_int_equal(pel_renderer_submit(renderer, env, &draw, 1), PEL_OK);
        assert_int_equal(pel_renderer_in_flight(renderer),
                         y + draw.rows == c->height);
        while (!pel_renderer_band_done(renderer, 1000000)) {
        }
    }
    struct pel_picture *p = NULL;
    while (!(p = pel_renderer_collect(renderer, 1000000000))) {
    }
    return p;
}

static int bands(const struct pel_environment *env, struct pel_camera *c)
{
    const unsigned asked[] = {
        PEL_LAYER_COLOR,
        PEL_LAYER_RADIANCE,
        TEST_ALL_LAYERS | pel_layers_from(PEL_LAYER_FROM_WATER),
    };
    int wrong = 0;
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++) {
        struct pel_picture *whole = test_draw(renderer, env, c, asked[i]);
        for (uint32_t rows = PEL_BAND_ROWS; rows < 3 * PEL_BAND_ROWS;
             rows += PEL_BAND_ROWS) {
            struct pel_picture *p = draw_in_bands(env, c, asked[i], rows);
            /* All layers lie in one buffer, in one order. */
            const void *from = whole->rgba ? (const void *)whole->rgba
                                           : (const void *)whole->radiance;
            const void *to =
                p->rgba ? (const void *)p->rgba : (const void *)p->radiance;
            bool same = !memcmp(from, to, bytes_of_layers(asked[i], c)) &&
                        memcmp(&whole->exposure_ev, &p->exposure_ev,
                               sizeof p->exposure_ev) == 0;
            if (!same) {
                printf("layers %x in bands of %u rows differ\n", asked[i],
                       rows);
            }
            wrong += !same;
            pel_picture_release(p);
        }
        pel_picture_release(whole);
    }
    return wrong;
}

static void bands_are_the_whole(void **state)
{
    (void)state;
    int wrong = 0;
    for (size_t i = 0; i < sizeof seam_looks / sizeof *seam_looks; i++) {
        struct test_look look = seam_looks[i];
        look.width = 320;
        look.height = 250; /* the last band is less than a tile */
        struct pel_camera c = test_camera(look);
        if (i % 2) {
            test_fft_sea(12.0, 1, &sea);
        } else {
            test_sea(15.0, 0.0, 1, &sea);
        }
        struct pel_environment env = test_environment(&sea, 50.0);
        env.stale = i == 1 ? PEL_STALE_CIGI | PEL_STALE_NMEA : 0;
        if (i == 0) { /* the Sun on the edge of two bands */
            env.lights[PEL_LIGHT_SUN].direction = test_ray(&c, 100.0, 64.0);
        }
        c.sensor.kind = i == 2;
        c.sensor.scale = 0.5;
        c.sensor.noise = i == 2 ? 0.1 : 0;
        wrong += bands(&env, &c);
        pel_sea_finish(&sea);
    }
    assert_int_equal(wrong, 0);
}

static void dropped_bands_leave_nothing(void **state)
{
    (void)state;
    test_sea(8.0, 0.0, 1, &sea);
    struct pel_environment env = test_environment(&sea, 5.0);
    struct pel_camera c =
        test_camera((struct test_look){ 6.0, 30.0, -10.0, 0.0, 60.0, 96, 192 });
    struct pel_picture *before = test_draw(renderer, &env, &c, TEST_ALL_LAYERS);
    for (int i = 0; i < 200; i++) {
        struct pel_draw draw = { .camera = c,
                                 .layers = PEL_LAYER_COLOR,
                                 .rows = PEL_BAND_ROWS };
        assert_int_equal(pel_renderer_submit(renderer, &env, &draw, 1), PEL_OK);
        pel_renderer_drop_bands(renderer);
    }
    struct pel_picture *after = test_draw(renderer, &env, &c, TEST_ALL_LAYERS);
    assert_same(before, after);
    pel_picture_release(before);
    pel_picture_release(after);
}

/* A picture of layers alone, after one of colour and before others: whatever
 * is read back in between, each shows its own view. */
static void layers_follow_their_views(void **state)
{
    (void)state;
    test_fft_sea(5.0, 1, &sea);
    struct pel_environment env = test_environment(&sea, 0.0);
    struct pel_camera c[4];
    double mean[2][4] = { { 0.0 } };
    for (int i = 0; i < 4; i++) {
        c[i] = test_camera((struct test_look){
            2.0, 90.0 * i, i == 3 ? 90.0 : 0.0, 0.0, 100.0, 64, 64 });
    }
    for (int k = 0; k < 2; k++) {
        /* Once with, once without a colour that is read first. */
        unsigned also = k ? PEL_LAYER_COLOR : 0;
        use_renderer(NULL);
        pel_picture_release(test_draw(renderer, &env, &c[3], PEL_LAYER_COLOR));
        for (int i = 0; i < 4; i++) {
            struct pel_picture *p =
                test_draw(renderer, &env, &c[i], PEL_LAYER_RADIANCE | also);
            for (int j = 0; j < 4 * 64 * 64; j++) {
                mean[k][i] += p->radiance[j];
            }
            pel_picture_release(p);
        }
    }
    for (int i = 0; i < 4; i++) {
        assert_true(mean[0][i] == mean[1][i]);
        assert_true(i == 0 || mean[0][i] != mean[0][0]);
    }
    pel_sea_finish(&sea);
}

/* Nodes of their lattice, and shade on the sea, from below and above. */
static void clouds_have_no_seam(void **state)
{
    (void)state;
    overhead = (struct pel_clouds){ 0.6, PEL_CLOUD_CUMULUS, 700, 550, 9, 4, 1 };
    /* Five pixels from node to node. */
    const struct test_look up = { 6, 77, 4, -13, 20, 512, 256 },
                           down = { 3000, 77, -4, -13, 20, 512, 256 };
    int wrong = seam(12.0, up, false) + seam(12.0, down, true) +
                seam(12.0, seam_looks[1], true);
    use_renderer("compute");
    wrong += seam(12.0, up, true);
    use_renderer(NULL);
    overhead = (struct pel_clouds){ 0 };
    assert_int_equal(wrong, 0);
}

static void tiles_have_no_seam_in_compute(void **state)
{
    (void)state;
    use_renderer("compute");
    int wrong = seam(15.0, seam_looks[1], true);
    struct test_look look = seam_looks[0];
    look.height = 250;
    struct pel_camera c = test_camera(look);
    struct pel_environment env = test_environment(&sea, 50.0);
    wrong += bands(&env, &c);
    use_renderer(NULL);
    assert_int_equal(wrong, 0);
}

/* Both wrappers around one shading function. */
static void compute_draws_the_same_sea(void **state)
{
    (void)state;
    test_sea(10.0, 0.0, 1, &sea);
    struct pel_environment env = test_environment(&sea, 50.0);
    struct pel_camera c = test_camera(seam_looks[1]);
    struct pel_picture *drawn = test_draw(renderer, &env, &c, TEST_ALL_LAYERS);
    struct copy kept = copy_of(drawn);
    const struct pel_picture *a = &kept.picture;
    pel_picture_release(drawn);
    use_renderer("compute");
    struct pel_picture *b = test_draw(renderer, &env, &c, TEST_ALL_LAYERS);
    size_t off = 0, pixels = layer_bytes(a, 1);
    for (size_t i = 0; i < pixels; i++) {
        assert_true(isinf(a->depth[i]) == isinf(b->depth[i]));
        for (size_t k = 0; k < 3; k++) {
            double x = a->radiance[4 * i + k], y = b->radiance[4 * i + k];
            if (fabs(x - y) > 1e-3 * fabs(x) + 1e-7) {
                off++;
                break;
            }
        }
    }
    /* The same text in two programs: a compiler may round differently. */
    printf("%zu of %zu pixels differ by more than 0.1 %%\n", off, pixels);
    pel_picture_release(b);
    free(kept.pixels);
    use_renderer(NULL);
    assert_true(off <= pixels / 500);
}

/* --- sane numbers -----------------------------------------------------------
 */

/* Mostly up to 20 km, now and then at the sea's level or under it. */
static double some_height(int i, uint64_t *random)
{
    if (i % 5 == 0) {
        return i % 10 ? -test_random(random, 0.0, 100.0) : 0.0;
    }
    return 20000.0 * pow(test_random(random, 0.0, 1.0), 4.0);
}

static void no_scene_gives_nonsense(void **state)
{
    (void)state;
    uint64_t random = 11;
    for (int i = 0; i < 60; i++) {
        double swell = i % 3 ? 0.0 : test_random(&random, 0.1, 15.0);
        double wind = i % 10 ? test_random(&random, 0.0, 30.0) : 0.0;
        if (i % 5 == 4) {
            test_fft_sea(wind, (uint32_t)i, &sea);
        } else {
            test_sea(wind, swell, (uint32_t)i, &sea);
        }
        struct pel_environment env =
            test_environment(&sea, test_random(&random, 0.0, 1e5));
        double elevation = i % 7 ? test_random(&random, -18.0, 90.0) : 90.0;
        env.lights[PEL_LIGHT_SUN].direction =
            test_sun(elevation, test_random(&random, 0.0, 360.0));
        env.visibility_m = 200.0 * pow(1500.0, test_random(&random, 0.0, 1.0));
        env.water =
            pel_water_deep(0.01 * pow(3000.0, test_random(&random, 0, 1)));
        env.water.depth_m = pow(10.0, test_random(&random, -1, 3));
        const struct test_look look = {
            .height_m = some_height(i, &random),
            .heading = test_random(&random, 0.0, 360.0),
            .pitch = i % 6 ? test_random(&random, -90.0, 90.0)
                           : (i % 12 ? -90.0 : 90.0),
            .roll = test_random(&random, -180.0, 180.0),
            .fov = i % 4 ? test_random(&random, 1.0, 150.0)
                         : (i % 8 ? 1.0 : 150.0),
            .width = 96,
            .height = 64,
        };
        struct pel_camera c = test_camera(look);
        struct pel_picture *p = test_draw(renderer, &env, &c, TEST_ALL_LAYERS);
        assert_true(p->exposure_ev >= PEL_METER_LEAST &&
                    p->exposure_ev <= 15.0);
        int bad = 0;
        for (size_t k = 0; k < layer_bytes(p, 1); k++) {
            const float *n = p->normal + 4 * k;
            double length = sqrt((double)n[0] * n[0] + (double)n[1] * n[1] +
                                 (double)n[2] * n[2]);
            bool surface = !isinf(p->depth[k]);
            bad += !(p->depth[k] > 0.0f) || p->rgba[4 * k + 3] != 255;
            bad += surface ? !(fabs(length - 1.0) < 1e-3) : length != 0.0;
            for (size_t j = 0; j < 3; j++) {
                float l = p->radiance[4 * k + j];
                bad += !(l >= 0.0f) || isinf(l);
            }
        }
        if (bad > 0) {
            printf("scene %d: %d numbers; wind %.1f swell %.1f sun %.1f height "
                   "%.2f pitch %.1f fov %.1f visibility %.0f\n",
                   i, bad, sea.desc.wind_mps, swell, elevation, look.height_m,
                   look.pitch, look.fov, env.visibility_m);
        }
        pel_picture_release(p);
        pel_sea_finish(&sea);
        assert_int_equal(bad, 0);
    }
}

/* --- in time
 * ------------------------------------------------------------------ */

struct steadiness {
    double mean_step, pop; /* greatest relative changes */
};

static double luminance(const float *light)
{
    return 0.2 * light[0] + 0.7 * light[1] + 0.1 * light[2];
}

/* The camera moves by `step` metres (up and forward) a frame through a sea that
 * stands still: what changes is the parallax and the filter. The far half of
 * the sea, whose waves are smaller than pixels, must hardly change. */
static struct steadiness steady(double height_m, double step, int frames)
{
    enum { W = 160, H = 120 };
    static float before[W * H];
    struct steadiness s = { 0 };
    struct pel_environment env = test_environment(&sea, 5.0);
    double mean_before = 0.0;
    for (int f = 0; f < frames; f++) {
        struct pel_camera c = test_camera((struct test_look){
            height_m + step * f, 150.0, 0.0, 0.0, 40.0, W, H });
        c.north_m = -step * f;
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
        double mean = 0.0, far_mean = 0.0;
        for (int i = 0; i < W * H; i++) {
            mean += luminance(p->radiance + 4 * (size_t)i) / (W * H);
        }
        const int first = (H / 2 + 3) * W, last = (H / 2 + H / 16) * W;
        for (int i = first; i < last; i++) {
            far_mean += luminance(p->radiance + 4 * (size_t)i) / (last - first);
        }
        for (int i = 0; i < W * H; i++) {
            float l = (float)luminance(p->radiance + 4 * (size_t)i);
            if (f > 0 && i >= first && i < last) {
                s.pop = fmax(s.pop, fabs(l - before[i]) / far_mean);
            }
            before[i] = l;
        }
        if (f > 0) {
            s.mean_step = fmax(s.mean_step, fabs(mean / mean_before - 1.0));
        }
        mean_before = mean;
        pel_picture_release(p);
    }
    return s;
}

static void nothing_pops_when_the_camera_moves(void **state)
{
    (void)state;
    static const double heights[] = { 10.0, 100.0, 1000.0 };
    test_sea(8.0, 0.0, 3, &sea);
    for (size_t i = 0; i < 3; i++) {
        /* A thousandth of the height a frame: the far sea shifts by less than
         * a tenth of a pixel. */
        struct steadiness s = steady(heights[i], 1e-3 * heights[i], 12);
        printf(
            "%6g m: mean luminance steps %.5f, far pixels %.4f of the mean\n",
            heights[i], s.mean_step, s.pop);
        assert_true(s.mean_step < 0.004);
        assert_true(s.pop < 0.03);
    }
}

/* --- exposure
 * ------------------------------------------------------------------ */

static double inverse_srgb(uint8_t code)
{
    double v = code / 255.0;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

/* Mean green, with no curve. */
static double brightness(double ev)
{
    struct pel_environment env = test_environment(&sea, 5.0);
    struct pel_camera c =
        test_camera((struct test_look){ 6.0, 220.0, 30.0, 0.0, 30.0, 64, 48 });
    c.auto_exposure = false;
    c.exposure_ev = ev;
    c.tone = PEL_TONE_LINEAR;
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_COLOR);
    assert_true(p->exposure_ev == ev);
    double sum = 0.0;
    for (size_t i = 0; i < 64 * 48; i++) {
        sum += inverse_srgb(p->rgba[4 * i + 1]) / (64 * 48);
    }
    pel_picture_release(p);
    return sum;
}

static void a_stop_doubles_the_light(void **state)
{
    (void)state;
    test_sea(5.0, 0.0, 1, &sea);
    double middle = brightness(14.0);
    double brighter = brightness(13.0), darker = brightness(15.0);
    printf("13, 14, 15 EV: %.4f %.4f %.4f\n", brighter, middle, darker);
    /* Dithered, so the mean is not cut to 1/255; the curve's inverse is not
     * straight over a step, which the dark end feels most. */
    assert_float_equal(brighter / middle, 2.0, 0.02);
    assert_float_equal(middle / darker, 2.0, 0.04);
}

/* --- limits
 * --------------------------------------------------------------------- */

static void count_rest(void *user)
{
    ++*(int *)user;
}

/* As a lost device does while others draw: each buffer of pixels is a piece of
 * its own, and a renderer made after it draws as before. */
static void leaves_in_pieces(void **state)
{
    (void)state;
    use_renderer(NULL);
    test_sea(9.0, 0.0, 4, &sea);
    const struct pel_environment env = test_environment(&sea, 3.0);
    const struct pel_camera camera =
        test_camera((struct test_look){ 9, 0, -8, 0, 60, 64, 40 });
    struct pel_picture *p = test_draw(renderer, &env, &camera, TEST_ALL_LAYERS);
    struct copy before = copy_of(p);
    pel_picture_release(p);
    int unused = 0, used = 0;
    pel_renderer_leave(renderer, count_rest, &used);
    pel_renderer_leave(test_renderer(NULL), count_rest, &unused);
    assert_true(unused >= 20);
    assert_int_equal(used, unused + 1);
    renderer = test_renderer(NULL);
    p = test_draw(renderer, &env, &camera, TEST_ALL_LAYERS);
    assert_same(p, &before.picture);
    pel_picture_release(p);
    free(before.pixels);
}

static void *release_all(void *user)
{
    struct pel_picture **pictures = user;
    for (int i = 0; i < PEL_READBACK_SLOTS; i++) {
        pel_picture_release(pictures[i]);
    }
    return NULL;
}

static void full_is_busy_until_released(void **state)
{
    (void)state;
    static struct pel_picture *pictures[PEL_READBACK_SLOTS];
    test_sea(0.0, 0.0, 1, &sea);
    struct pel_environment env = test_environment(&sea, 5.0);
    const struct pel_draw draw = {
        .camera =
            test_camera((struct test_look){ 6.0, 0.0, 0.0, 0.0, 30.0, 8, 8 }),
        .layers = PEL_LAYER_COLOR,
        .user = pictures,
    };
    for (int i = 0; i < PEL_READBACK_SLOTS; i++) {
        assert_int_equal(pel_renderer_submit(renderer, &env, &draw, 1), PEL_OK);
        assert_int_equal(pel_renderer_in_flight(renderer), i + 1);
    }
    assert_int_equal(pel_renderer_submit(renderer, &env, &draw, 1),
                     PEL_ERR_BUSY);
    for (int i = 0; i < PEL_READBACK_SLOTS; i++) {
        pictures[i] = pel_renderer_collect(renderer, 60000000000);
        assert_non_null(pictures[i]);
        assert_ptr_equal(pictures[i]->user, pictures);
    }
    assert_null(pel_renderer_collect(renderer, 0));
    assert_int_equal(pel_renderer_in_flight(renderer), 0);
    /* Collected is not released: still no room. */
    assert_int_equal(pel_renderer_submit(renderer, &env, &draw, 1),
                     PEL_ERR_BUSY);
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, release_all, pictures), 0);
    pthread_join(thread, NULL);
    pel_picture_release(test_draw(renderer, &env, &draw.camera, draw.layers));
    pel_picture_release(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_scene_same_bytes),
        cmocka_unit_test(layers_do_not_disturb),
        cmocka_unit_test(tiles_have_no_seam),
        cmocka_unit_test(cascades_have_no_seam),
        cmocka_unit_test(clouds_have_no_seam),
        cmocka_unit_test(bands_are_the_whole),
        cmocka_unit_test(dropped_bands_leave_nothing),
        cmocka_unit_test(cascades_are_not_mixed_up),
        cmocka_unit_test(layers_follow_their_views),
        cmocka_unit_test(tiles_have_no_seam_in_compute),
        cmocka_unit_test(compute_draws_the_same_sea),
        cmocka_unit_test(no_scene_gives_nonsense),
        cmocka_unit_test(nothing_pops_when_the_camera_moves),
        cmocka_unit_test(a_stop_doubles_the_light),
        cmocka_unit_test(full_is_busy_until_released),
        cmocka_unit_test(leaves_in_pieces),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
