/* Objects on the sea: without any, the same bits as before; seams; either
 * wrapper; what is seen where, against the model's own ray casts; where the sea
 * begins, against surface queries. */
#include "render/renderer.h"

#include "models/builtin.h"
#include "render/render_testkit.h"

#define MASK_LAYERS (PEL_LAYER_RADIANCE | PEL_LAYER_DEPTH | PEL_LAYER_ID)

static struct pel_sea sea;

static const struct pel_model *model_of(const char *name)
{
    const struct pel_builtin what = { .name = name };
    const struct pel_model *model = NULL;
    struct pel_fault fault = { 0 };
    if (pel_builtin_make(&what, &model, &fault) != PEL_OK) {
        fail_msg("%s", fault.message);
    }
    return model;
}

/* Degrees; level, at a height above the sea's zero. */
static struct pel_object standing(const struct pel_model *model, uint32_t id,
                                  double east_m, double north_m,
                                  double height_m, double heading)
{
    double h = heading * PEL_DEG;
    return (struct pel_object){
        .id = id,
        .model = model,
        .east_m = east_m,
        .north_m = north_m,
        .altitude_m = height_m,
        .world_from_model = { { sin(h), cos(h), 0 },
                              { -cos(h), sin(h), 0 },
                              { 0, 0, 1 } },
    };
}

struct kept {
    uint32_t width, height;
    uint8_t *rgba;
    float *radiance, *depth, *id;
};

/* Zeros where there is nothing. */
static void *copy(const void *from, size_t size)
{
    void *to = calloc(1, size);
    if (!to) {
        abort();
    }
    if (from) {
        memcpy(to, from, size);
    }
    return to;
}

static struct kept keep(struct pel_picture *p)
{
    size_t n = (size_t)p->width * p->height;
    struct kept k = { p->width,
                      p->height,
                      copy(p->rgba, 4 * n),
                      copy(p->radiance, 16 * n),
                      copy(p->depth, 4 * n),
                      copy(p->id, 4 * n) };
    pel_picture_release(p);
    return k;
}

static void drop(struct kept *k)
{
    free(k->rgba);
    free(k->radiance);
    free(k->depth);
    free(k->id);
}

static void assert_same(const struct kept *a, const struct kept *b)
{
    size_t n = (size_t)a->width * a->height;
    assert_memory_equal(a->rgba, b->rgba, 4 * n);
    assert_memory_equal(a->radiance, b->radiance, 16 * n);
    assert_memory_equal(a->depth, b->depth, 4 * n);
}

#define LAYERS (TEST_ALL_LAYERS | PEL_LAYER_ID)
#define LIGHT (PEL_LAYER_COLOR | PEL_LAYER_RADIANCE)

static void without_objects_the_same_bits(void **state)
{
    (void)state;
    test_sea(8.0, 0.0, 1, &sea);
    struct pel_environment env = test_environment(&sea, 20.0);
    struct pel_camera c =
        test_camera((struct test_look){ 6.0, 20.0, -4.0, 0.0, 60.0, 320, 180 });
    struct kept before = keep(test_draw(renderer, &env, &c, LAYERS));
    const struct pel_model *model = model_of("rib");
    const struct pel_object object = standing(model, 3, 10, 25, 0, 70);
    env.objects = &object;
    env.object_count = 1;
    struct kept with = keep(test_draw(renderer, &env, &c, LAYERS));
    assert_memory_not_equal(before.rgba, with.rgba, (size_t)320 * 180 * 4);
    env.object_count = 0;
    struct kept after = keep(test_draw(renderer, &env, &c, LAYERS));
    assert_same(&before, &after);
    drop(&before);
    drop(&with);
    drop(&after);
    pel_model_unref(model);
}

/* Views of objects keep their place in their textures, larger ones leave it. */
static void other_objects_leave_no_trace(void **state)
{
    (void)state;
    test_sea(3.0, 0.0, 1, &sea);
    struct pel_environment env = test_environment(&sea, 20.0);
    struct pel_camera c =
        test_camera((struct test_look){ 6.0, 0.0, -4.0, 0.0, 60.0, 320, 180 });
    const struct pel_model *models[2] = { model_of("ferry"), model_of("rib") };
    const struct pel_object large = standing(models[0], 3, 0, 200, 0, 70);
    const struct pel_object small = standing(models[1], 4, 4, 60, 0, 20);
    struct kept pictures[3];
    for (int i = 0; i < 3; i++) {
        env.objects = i == 1 ? &large : &small;
        env.object_count = 1;
        pictures[i] = keep(test_draw(renderer, &env, &c, LAYERS));
    }
    assert_same(&pictures[0], &pictures[2]);
    for (int i = 0; i < 3; i++) {
        drop(&pictures[i]);
    }
    pel_model_unref(models[0]);
    pel_model_unref(models[1]);
}

/* --- seams ---------------------------------------------------------------- */

static struct pel_camera cut_camera(const struct pel_camera *whole,
                                    const uint32_t box[4])
{
    struct pel_camera c = *whole;
    double px = (whole->tan_right - whole->tan_left) / whole->width;
    double py = (whole->tan_top - whole->tan_bottom) / whole->height;
    c.tan_left = whole->tan_left + px * box[0];
    c.tan_right = whole->tan_left + px * box[2];
    c.tan_top = whole->tan_top - py * box[1];
    c.tan_bottom = whole->tan_top - py * box[3];
    c.width = box[2] - box[0];
    c.height = box[3] - box[1];
    c.auto_exposure = false;
    return c;
}

static int differ(const struct kept *whole, const struct kept *part,
                  const uint32_t box[4])
{
    int wrong = 0;
    for (uint32_t y = box[1]; y < box[3]; y++) {
        for (uint32_t x = box[0]; x < box[2]; x++) {
            size_t i = (size_t)y * whole->width + x;
            size_t k = (size_t)(y - box[1]) * part->width + x - box[0];
            wrong += memcmp(whole->radiance + 4 * i, part->radiance + 4 * k,
                            16) != 0 ||
                     whole->id[i] != part->id[k] ||
                     memcmp(whole->rgba + 4 * i, part->rgba + 4 * k, 4) != 0;
        }
    }
    return wrong;
}

static int seams(void)
{
    static const uint32_t boxes[][4] = { { 0, 0, 200, 192 },
                                         { 160, 0, 384, 192 },
                                         { 0, 100, 384, 192 },
                                         { 131, 70, 201, 121 } };
    const struct pel_model *ship = model_of("ferry"), *rib = model_of("rib");
    const struct pel_object objects[] = {
        standing(ship, 3, 60, 900, 0.3, 70),
        standing(rib, 4, 12, 40, 0.1, 200),
        standing(rib, 5, -8, 25, 0.2, 40),
    };
    struct pel_environment env = test_environment(&sea, 50.0);
    env.objects = objects;
    env.object_count = 3;
    struct pel_camera c =
        test_camera((struct test_look){ 9.0, 5.0, -7.0, 6.0, 60.0, 384, 192 });
    c.auto_exposure = false;
    c.exposure_ev = 14.0;
    struct kept whole = keep(test_draw(renderer, &env, &c, LAYERS));
    int wrong = 0;
    for (size_t i = 0; i < sizeof boxes / sizeof *boxes; i++) {
        struct pel_camera part = cut_camera(&c, boxes[i]);
        struct kept k = keep(test_draw(renderer, &env, &part, LAYERS));
        int n = differ(&whole, &k, boxes[i]);
        printf("part %zu: %d pixels differ\n", i, n);
        wrong += n;
        drop(&k);
    }
    /* Bands. */
    for (uint32_t y = 0; y < c.height; y += PEL_BAND_ROWS) {
        const struct pel_draw draw = {
            .camera = c, .layers = LAYERS, .first_row = y, .rows = PEL_BAND_ROWS
        };
        assert_int_equal(pel_renderer_submit(renderer, &env, &draw, 1), PEL_OK);
        while (!pel_renderer_band_done(renderer, 1000000000)) {
        }
    }
    struct pel_picture *p = pel_renderer_collect(renderer, 60000000000);
    assert_non_null(p);
    struct kept banded = keep(p);
    static const uint32_t all[4] = { 0, 0, 384, 192 };
    int n = differ(&whole, &banded, all);
    printf("bands: %d pixels differ\n", n);
    drop(&banded);
    drop(&whole);
    pel_model_unref(ship);
    pel_model_unref(rib);
    return wrong + n;
}

static void pictures_of_objects_have_no_seam(void **state)
{
    (void)state;
    test_sea(8.0, 0.0, 1, &sea);
    int wrong = seams();
    pel_renderer_destroy(renderer);
    renderer = test_renderer("compute");
    wrong += seams();
    pel_renderer_destroy(renderer);
    renderer = test_renderer(NULL);
    assert_int_equal(wrong, 0);
}

/* Tiles of parts begin elsewhere: what a tile's program leaves out shows where
 * it is in one part and not in another. */
static void tiles_hold_all_of_a_shadow(void **state)
{
    (void)state;
    static const uint32_t boxes[][4] = { { 32, 0, 512, 256 },
                                         { 0, 32, 512, 256 },
                                         { 48, 16, 512, 256 } };
    test_sea(10.0, 2.0, 1, &sea);
    const struct pel_model *ship = model_of("ferry"), *tug = model_of("tug");
    const struct pel_object objects[] = { standing(ship, 3, 60, 260, 0.3, 120),
                                          standing(tug, 4, -70, 160, 0.1, 60) };
    int wrong = 0;
    for (int k = 0; k < 3; k++) {
        struct pel_environment env = test_environment(&sea, 20.0 + 7 * k);
        const double azimuths[] = { 15, 70, -60 };
        env.lights[PEL_LIGHT_SUN].direction = test_sun(14.0, azimuths[k]);
        env.objects = objects;
        env.object_count = 2;
        struct pel_camera c = test_camera(
            (struct test_look){ 5.0, 0.0, -6.0, 0.0, 60.0, 512, 256 });
        c.auto_exposure = false;
        c.exposure_ev = 13.0;
        struct kept whole = keep(test_draw(renderer, &env, &c, LIGHT));
        for (size_t i = 0; i < sizeof boxes / sizeof *boxes; i++) {
            struct pel_camera part = cut_camera(&c, boxes[i]);
            struct kept p = keep(test_draw(renderer, &env, &part, LIGHT));
            wrong += differ(&whole, &p, boxes[i]);
            drop(&p);
        }
        drop(&whole);
    }
    pel_model_unref(ship);
    pel_model_unref(tug);
    assert_int_equal(wrong, 0);
}

/* --- what is seen where -----------------------------------------------------
 */

/* Into the model's axes; the sphere's bend over these distances is a
 * millimetre. */
static struct pel_vec3 turn(const struct pel_object *o, struct pel_vec3 v)
{
    const struct pel_mat3 *m = &o->world_from_model;
    return (struct pel_vec3){ pel_vec3_dot(m->x, v), pel_vec3_dot(m->y, v),
                              pel_vec3_dot(m->z, v) };
}

/* Distance to the model along the picture's ray, from the model's own cast. */
static bool cast(const struct pel_object *o, const struct pel_camera *c,
                 struct pel_vec3 ray, struct pel_model_hit *hit)
{
    const struct pel_vec3 from = { c->east_m - o->east_m,
                                   c->north_m - o->north_m,
                                   c->altitude_m - o->altitude_m };
    return pel_model_cast(o->model, turn(o, from), turn(o, ray), 2000.0, hit);
}

/* Above the sea only; a pixel beside an edge of the mask may go either way. */
static void the_mask_is_what_rays_meet(void **state)
{
    (void)state;
    static const char *const names[] = { "tanker", "rib", "sailing-yacht",
                                         "cardinal-north" };
    static const double away[] = { 300, 14, 60, 40 };
    test_sea(0.0, 0.0, 1, &sea);
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        const struct pel_model *model = model_of(names[k]);
        const struct pel_object object =
            standing(model, 41, 0.1 * away[k], away[k], 0, 65);
        struct pel_environment env = test_environment(&sea, 5.0);
        env.objects = &object;
        env.object_count = 1;
        struct pel_camera c = test_camera(
            (struct test_look){ 5.0, 5.0, -4.0, 0.0, 50.0, 320, 180 });
        struct kept p = keep(test_draw(renderer, &env, &c, MASK_LAYERS));
        size_t wrong = 0, seen = 0;
        for (size_t i = 0; i < (size_t)320 * 180; i++) {
            struct pel_vec3 ray =
                test_ray(&c, (double)(i % 320) + 0.5, (double)(i / 320) + 0.5);
            struct pel_model_hit hit = { 0 };
            bool met = cast(&object, &c, ray, &hit);
            double level = ray.z < 0 ? -c.altitude_m / ray.z : HUGE_VAL;
            bool is = met && hit.distance_m < level;
            if (met && !is) {
                /* Sea before it: in the hull there is none. */
                struct pel_vec3 at = pel_vec3_scale(ray, level);
                const struct pel_vec3 water = { c.east_m + at.x - object.east_m,
                                                c.north_m + at.y -
                                                    object.north_m,
                                                0 };
                const struct pel_vec3 down = { 0, 0, -1 };
                struct pel_model_hit below;
                is = pel_model_cast(model, turn(&object, water), down, 50.0,
                                    &below) &&
                     !below.front;
            }
            seen += is;
            wrong += is != (p.id[i] == 42.0f);
        }
        printf("%s: %zu of %zu pixels\n", names[k], wrong, seen);
        assert_true(seen > 300);
        assert_true(wrong <= (size_t)320 * 180 / 200);
        assert_true((double)wrong <= 0.02 * (double)seen + 2);
        drop(&p);
        pel_model_unref(model);
    }
}

/* How far the hull at a pixel stands out of the sea that a query finds there,
 * m; false: no ray meets it. */
static bool freeboard(const struct pel_environment *env,
                      const struct pel_object *o, const struct pel_camera *c,
                      uint32_t x, uint32_t y, double *out, double *pixel)
{
    struct pel_vec3 ray = test_ray(c, x + 0.5, y + 0.5);
    struct pel_model_hit hit = { 0 };
    if (!cast(o, c, ray, &hit)) {
        return false;
    }
    struct pel_vec3 p = pel_vec3_scale(ray, hit.distance_m);
    struct pel_surface_sample at;
    pel_sea_sample(env->sea, c->east_m + p.x, c->north_m + p.y, env->time_s,
                   &at);
    double bend = (p.x * p.x + p.y * p.y) / (2 * 6360000.0);
    *out = c->altitude_m + p.z + bend - at.height_m;
    *pixel = hit.distance_m * (c->tan_right - c->tan_left) / c->width;
    return true;
}

/* 20 poses: the lowest pixel of the mask in a column stands out of the sea, the
 * next, if the hull goes on there, does not, to 1 cm or a pixel. */
static void the_sea_begins_where_queries_say(void **state)
{
    (void)state;
    const struct pel_model *model = model_of("tanker");
    uint64_t seed = 7;
    size_t edges = 0, wrong = 0;
    double worst = 0;
    for (int k = 0; k < 20; k++) {
        test_sea(4.0 + k % 4 * 3.0, 0.0, (uint32_t)k, &sea);
        struct pel_environment env = test_environment(&sea, 3.0 + k);
        const struct pel_object object =
            standing(model, 0, 20, test_random(&seed, 200, 400),
                     test_random(&seed, -1, 1), test_random(&seed, 40, 140));
        env.objects = &object;
        env.object_count = 1;
        struct pel_camera c = test_camera((struct test_look){
            test_random(&seed, 8, 40), 3.0, -5.0, 0.0, 50.0, 240, 135 });
        struct kept p = keep(test_draw(renderer, &env, &c, MASK_LAYERS));
        for (uint32_t x = 0; x < 240; x++) {
            uint32_t y = 134;
            while (y > 0 && p.id[y * 240 + x] == 0.0f) {
                y--;
            }
            double above, below, pixel;
            if (y == 0 || y == 134 ||
                !freeboard(&env, &object, &c, x, y, &above, &pixel) ||
                !freeboard(&env, &object, &c, x, y + 1, &below, &pixel)) {
                continue;
            }
            double off = fmax(fmax(-above, below), 0);
            edges++;
            wrong += off > fmax(0.01, pixel);
            worst = fmax(worst, off / fmax(0.01, pixel));
        }
        drop(&p);
    }
    printf("%zu of %zu places wrong, worst %.2f px\n", wrong, edges, worst);
    assert_true(edges > 1500);
    /* Waves between the eye and the hull hide some of it. */
    assert_true(wrong <= edges / 500);
    pel_model_unref(model);
}

/* Radiance in red of sea in this picture, the mean over where it shows the
 * sea in both. */
static double red_of_sea(const struct kept *k, const struct kept *other)
{
    double sum = 0;
    int count = 0;
    for (size_t i = 0; i < (size_t)k->width * k->height; i++) {
        if (k->id[i] == 0 && other->id[i] == 0) {
            sum += (double)k->radiance[4 * i];
            count++;
        }
    }
    return sum / count;
}

/* A red hull, looked down on: in clear water its bottom is seen, and it adds
 * red; in water that lets no light through it does not. */
static void hulls_are_seen_through_the_water(void **state)
{
    (void)state;
    test_sea(0.0, 0.0, 1, &sea);
    const struct pel_model *model = model_of("fishing-boat");
    const struct pel_object object = standing(model, 3, 0, 9, 0, 90);
    struct pel_environment env = test_environment(&sea, 20.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(60.0, 180.0);
    struct pel_camera c = test_camera(
        (struct test_look){ 14.0, 0.0, -65.0, 0.0, 50.0, 240, 160 });
    double found[2];
    for (int dark = 0; dark < 2; dark++) {
        for (int i = 0; dark && i < 3; i++) {
            env.water.absorption[i] = 100;
        }
        env.objects = &object;
        env.object_count = 1;
        struct kept with = keep(test_draw(renderer, &env, &c, MASK_LAYERS));
        env.object_count = 0;
        struct kept without = keep(test_draw(renderer, &env, &c, MASK_LAYERS));
        found[dark] = red_of_sea(&with, &with) - red_of_sea(&without, &with);
        drop(&with);
        drop(&without);
    }
    printf(
        "red that a red hull adds to the sea beside it: %.2e; to black water "
        "%.2e\n",
        found[0], found[1]);
    /* The boat's mirror image and shadow are in both. */
    assert_true(found[0] > 1.1 * found[1]);
    pel_model_unref(model);
}

/* A hull hides no more of the sky's mirror image than there is: beside one that
 * stands between the eye and a low Sun's side of the sky the sea is dark, but
 * has light. */
static void no_sea_is_black_beside_a_hull(void **state)
{
    (void)state;
    test_sea(8.0, 0.0, 1, &sea);
    const struct pel_model *model = model_of("tanker");
    const struct pel_object object = standing(model, 0, 0, 150, 0, 80);
    struct pel_environment env = test_environment(&sea, 20.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(20.0, 60.0);
    struct pel_camera c =
        test_camera((struct test_look){ 12.0, 0.0, -4.0, 0.0, 60.0, 320, 180 });
    env.objects = &object;
    env.object_count = 1;
    struct kept with = keep(test_draw(renderer, &env, &c, MASK_LAYERS));
    double mean = 0, least = 1e30;
    size_t count = 0, n = (size_t)with.width * with.height;
    for (size_t i = n / 2; i < n; i++) {
        if (with.id[i] == 0) {
            mean += (double)with.radiance[4 * i + 1];
            least = fmin(least, (double)with.radiance[4 * i + 1]);
            count++;
        }
    }
    mean /= (double)count;
    printf("sea beside a hull: mean %.3g, least %.3g\n", mean, least);
    assert_true(count > n / 4);
    /* A dark hull mirrors a tenth of what the sky does. */
    assert_true(least > 0.05 * mean);
    drop(&with);
    pel_model_unref(model);
}

/* --- silhouettes
 * ---------------------------------------------------------- */

#define FINE 8 /* times as many pixels a side */
#define COARSE_WIDTH 96
#define COARSE_HEIGHT 54

static struct kept draw_fine(const struct pel_environment *env, uint32_t times)
{
    struct pel_camera c = test_camera(
        (struct test_look){ 5.0, 2.0, 2.0, 0.0, 45.0, COARSE_WIDTH * times,
                            COARSE_HEIGHT * times });
    c.antialiasing = false;
    return keep(test_draw(renderer, env, &c, MASK_LAYERS));
}

/* Pixels that a silhouette cuts hold the mean of what a picture of many
 * times as many pixels shows there: to 0.6 of what its middle alone would
 * be off by, since four samples know the share to an eighth or so, a middle
 * to a half. */
static void silhouettes_are_mixed(void **state)
{
    (void)state;
    test_sea(0.0, 0.0, 1, &sea);
    const struct pel_model *model = model_of("sailing-yacht");
    const struct pel_object object = standing(model, 0, 2, 45, 0, 65);
    struct pel_environment env = test_environment(&sea, 5.0);
    env.objects = &object;
    env.object_count = 1;
    struct kept coarse = draw_fine(&env, 1), fine = draw_fine(&env, FINE);
    double mixed = 0, middles = 0;
    size_t edges = 0;
    for (uint32_t i = 0; i < COARSE_WIDTH * COARSE_HEIGHT; i++) {
        uint32_t x = i % COARSE_WIDTH, y = i / COARSE_WIDTH;
        double mean = 0;
        int met = 0;
        for (uint32_t k = 0; k < FINE * FINE; k++) {
            size_t at = (size_t)(y * FINE + k / FINE) * fine.width + x * FINE +
                        k % FINE;
            mean += (double)fine.radiance[4 * at] / (FINE * FINE);
            met += fine.id[at] > 0;
        }
        if (met == 0 || met == FINE * FINE) {
            continue;
        }
        size_t middle =
            (size_t)(y * FINE + FINE / 2) * fine.width + x * FINE + FINE / 2;
        edges++;
        mixed += pow((double)coarse.radiance[4 * (size_t)i] - mean, 2);
        middles += pow((double)fine.radiance[4 * middle] - mean, 2);
    }
    printf("%zu pixels: off by %.3f of what their middles are\n", edges,
           sqrt(mixed / middles));
    assert_true(edges > 100);
    assert_true(mixed < 0.36 * middles);
    drop(&coarse);
    drop(&fine);
    pel_model_unref(model);
}

/* --- the sea's outlines
 * ------------------------------------------------------ */

static struct kept draw_crests(const struct pel_environment *env,
                               const struct pel_object *object,
                               bool antialiasing)
{
    struct pel_environment here = *env;
    struct pel_camera c =
        test_camera((struct test_look){ 4.0, 0.0, 0.0, 0.0, 60.0, 320, 180 });
    c.antialiasing = antialiasing;
    here.objects = object;
    here.object_count = object ? 1 : 0;
    return keep(test_draw(renderer, &here, &c, MASK_LAYERS));
}

/* The sea's outlines are antialiased in a scene with objects as in one without:
 * to the left of a buoy on the right, its image and its shadow. Programs for
 * objects may round in other ways on hardware. */
static void outlines_do_not_mind_objects(void **state)
{
    (void)state;
    test_sea(16.0, 0.0, 7, &sea);
    const struct pel_model *model = model_of("cardinal-north");
    const struct pel_object object = standing(model, 0, 12, 30, 0, 0);
    struct pel_environment env = test_environment(&sea, 30.0);
    struct kept plain = draw_crests(&env, NULL, true);
    struct kept jagged = draw_crests(&env, NULL, false);
    struct kept with = draw_crests(&env, &object, true);
    int cut = 0, off = 0, seen = 0;
    for (uint32_t i = 0; i < with.width * with.height; i++) {
        float all = with.radiance[4 * (size_t)i];
        float sea_only = plain.radiance[4 * (size_t)i];
        seen += with.id[i] != 0;
        if (i % with.width < with.width / 2) {
            cut += fabsf(jagged.radiance[4 * (size_t)i] - sea_only) >
                   0.02F * sea_only;
            off += fabsf(all - sea_only) > 1e-4F * sea_only;
        }
    }
    printf("%d pixels cut by outlines, %d of another light beside a buoy of %d "
           "pixels\n",
           cut, off, seen);
    assert_true(seen > 0);
    assert_true(cut > 200);
    assert_int_equal(off, 0);
    drop(&plain);
    drop(&jagged);
    drop(&with);
    pel_model_unref(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_sea_is_black_beside_a_hull),
        cmocka_unit_test(silhouettes_are_mixed),
        cmocka_unit_test(outlines_do_not_mind_objects),
        cmocka_unit_test(without_objects_the_same_bits),
        cmocka_unit_test(other_objects_leave_no_trace),
        cmocka_unit_test(pictures_of_objects_have_no_seam),
        cmocka_unit_test(tiles_hold_all_of_a_shadow),
        cmocka_unit_test(the_mask_is_what_rays_meet),
        cmocka_unit_test(the_sea_begins_where_queries_say),
        cmocka_unit_test(hulls_are_seen_through_the_water),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
