/* Light between objects, and how far they stand out of the curved sea, against
 * rays and geometry. */
#include "render/renderer.h"

#include "models/builtin.h"
#include "models/model.h"
#include "models/shape.h"
#include "optics/lamp.h"
#include "optics/light.h"
#include "optics/wet.h"
#include "render/modelpaint.h"
#include "render/render_testkit.h"

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

/* Level, at the sea's zero, its bow at `heading` degrees. */
static struct pel_object standing(const struct pel_model *model, uint32_t id,
                                  double east_m, double north_m, double heading)
{
    double h = heading * PEL_DEG;
    return (struct pel_object){
        .id = id,
        .model = model,
        .east_m = east_m,
        .north_m = north_m,
        .world_from_model = { { sin(h), cos(h), 0 },
                              { -cos(h), sin(h), 0 },
                              { 0, 0, 1 } },
    };
}

static struct pel_vec3 turn(const struct pel_object *o, struct pel_vec3 v)
{
    const struct pel_mat3 *m = &o->world_from_model;
    return (struct pel_vec3){ pel_vec3_dot(m->x, v), pel_vec3_dot(m->y, v),
                              pel_vec3_dot(m->z, v) };
}

/* From a place of the world, not nearer than least_m. */
static bool meets(const struct pel_object *o, struct pel_vec3 from,
                  struct pel_vec3 d, double least_m, struct pel_model_hit *hit)
{
    const struct pel_vec3 at = { from.x + least_m * d.x - o->east_m,
                                 from.y + least_m * d.y - o->north_m,
                                 from.z + least_m * d.z - o->altitude_m };
    return pel_model_cast(o->model, turn(o, at), turn(o, d), 3000.0, hit);
}

/* Matt walls across the bow's axis, 20 m apart and wide, from z_m up. */
static const struct pel_model *walls(float z_m, float albedo)
{
    struct pel_shape shape = { .name = "walls" };
    struct pel_model_draft draft;
    struct pel_fault fault = { 0 };
    const struct pel_model *model = NULL;
    const struct pel_model_material paint = { .name = "paint",
                                              .albedo = { albedo, albedo,
                                                          albedo },
                                              .roughness = 1,
                                              .texture = -1,
                                              .two_sided = true };
    int material = pel_shape_material(&shape, &paint);
    int node = pel_shape_node(&shape, "walls");
    for (int i = 0; i < 2; i++) {
        float x = 20.0f * (float)i;
        const struct pel_model_vertex v[] = {
            { .position = { x, 10, z_m } },
            { .position = { x, -10, z_m } },
            { .position = { x, -10, z_m + 8 } },
            { .position = { x, 10, z_m + 8 } },
        };
        pel_shape_triangle(&shape,
                           (struct pel_model_vertex[]){ v[0], v[1], v[2] },
                           material, node);
        pel_shape_triangle(&shape,
                           (struct pel_model_vertex[]){ v[0], v[2], v[3] },
                           material, node);
    }
    assert_int_equal(pel_shape_finish(&shape, &draft, &fault), PEL_OK);
    assert_int_equal(pel_model_create(&draft.model, &model, &fault), PEL_OK);
    pel_model_draft_clear(&draft);
    pel_shape_clear(&shape);
    return model;
}

/* Candelas of a lamp on a matt wall: albedo / pi I cos / d², its gloss (a few
 * hundredths) aside; from behind nothing. */
static void lamps_light_what_they_face(void **state)
{
    (void)state;
    enum { SIDE = 96 };
    const double north_m = 40, albedo = 0.5;
    test_sea(3.0, 0.0, 3, &sea);
    struct pel_environment env = test_environment(&sea, 5.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(-30, 200);
    const struct pel_object object = standing(walls(0, 0.5f), 3, 0, north_m, 0);
    env.objects = &object;
    env.object_count = 1;
    struct pel_lamp lamp = { .entity = PEL_NO_ENTITY,
                             .east_m = 3,
                             .north_m = 31,
                             .altitude_m = 6,
                             .intensity_cd = { 200, 200, 200 },
                             .ahead = { 0, 1, 0 },
                             .up = { 0, 0, 1 },
                             .arc_rad = 2 * PEL_PI,
                             .spread_rad = 0.5 * PEL_PI };
    env.lamps = &lamp;
    env.lamp_count = 1;
    struct pel_camera c =
        test_camera((struct test_look){ 5, 0, 0, 0, 16, SIDE, SIDE });
    double m[9], worst = 0, behind = 0;
    pel_lights_colours(env.lights, 1, false, m);
    for (int back = 0; back < 2; back++) {
        lamp.north_m = back ? north_m + 10 : 31;
        struct pel_picture *p =
            test_draw(renderer, &env, &c,
                      PEL_LAYER_RADIANCE | PEL_LAYER_SUN | PEL_LAYER_ID);
        int seen = 0;
        for (int i = 0; i < SIDE * SIDE; i++) {
            double x = c.tan_left +
                       (c.tan_right - c.tan_left) * (i % SIDE + 0.5) / SIDE,
                   y = c.tan_top -
                       (c.tan_top - c.tan_bottom) * (i / SIDE + 0.5) / SIDE;
            const double up_m = 5 + north_m * y, east_m = north_m * x;
            if (up_m < 2 || up_m > 7.5 || fabs(east_m) > 5) {
                continue;
            }
            double found = 0;
            for (int k = 0; k < 9; k++) {
                static const double weight[3] = { 0.2126, 0.7152, 0.0722 };
                found += weight[k / 3] * m[k] * (double)p->sun[4 * i + k % 3];
            }
            double dx = east_m - 3, dy = 9, dz = up_m - 6;
            double d2 = dx * dx + dy * dy + dz * dz;
            double rule = albedo / PEL_PI * 200 / d2 * dy / sqrt(d2);
            worst = fmax(worst, back ? 0 : fabs(found / rule - 1));
            behind = fmax(behind, back ? found / rule : 0);
            seen++;
        }
        assert_true(seen > 1000);
        pel_picture_release(p);
    }
    print_message("a wall by a lamp: %.3f off, from behind %.1e\n", worst,
                  behind);
    assert_true(worst < 0.05);
    assert_true(behind < 1e-6);
    pel_model_unref(object.model);
    pel_sea_finish(&sea);
}

/* The same wall, once of a thing that swims and once of one that is 50 m up:
 * the Sun's light on it by height, against optics/wet.h. */
static void hulls_are_wet_where_waves_were(void **state)
{
    (void)state;
    enum { SIDE = 128 };
    test_sea(7.0, 0.0, 1, &sea);
    const struct pel_model *models[] = { walls(0, 0.6f), walls(-50, 0.6f) };
    static float light[2][SIDE * SIDE], id[2][SIDE * SIDE];
    struct pel_camera c =
        test_camera((struct test_look){ 4.0, 0.0, 0.0, 0.0, 16.0, SIDE, SIDE });
    for (int k = 0; k < 2; k++) {
        struct pel_environment env = test_environment(&sea, 5.0);
        env.lights[PEL_LIGHT_SUN].direction = test_sun(35.0, 170.0);
        const struct pel_object object = {
            .id = 3,
            .model = models[k],
            .north_m = 30,
            .altitude_m = 50.0 * k,
            .world_from_model = { { 0, 1, 0 }, { -1, 0, 0 }, { 0, 0, 1 } },
        };
        env.objects = &object;
        env.object_count = 1;
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_SUN | PEL_LAYER_ID);
        for (int i = 0; i < SIDE * SIDE; i++) {
            light[k][i] = p->sun[4 * i + 1];
            id[k][i] = p->id[i];
        }
        pel_picture_release(p);
    }
    double deviation = pel_wet_deviation(sea.m0, models[0]->length_m);
    float paint[3];
    pel_model_reflectance((const float[3]){ 0.6f, 0.6f, 0.6f }, paint);
    double dry = (double)paint[1], worst = 0;
    int wet = 0, high = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        struct pel_vec3 ray = test_ray(&c, i % SIDE + 0.5, i / SIDE + 0.5);
        double above = 4 + 30 * ray.z / ray.y;
        if (id[0][i] != 4.0f || id[1][i] != 4.0f || above < 0) {
            continue;
        }
        double share = pel_wet_share(above, deviation);
        double want = 1 + share * (pel_wet_reflectance(dry) / dry - 1);
        double is = (double)light[0][i] / (double)light[1][i];
        worst = fmax(worst, fabs(is - want));
        wet += share > 0.9;
        high += share < 0.01;
    }
    printf("%.2f m of deviation, %d wet, %d dry, worst %.3f\n", deviation, wet,
           high, worst);
    assert_true(wet > 500 && high > 500);
    /* The Sun in the wall's facets, 0.04 of what falls on them, rough or not.
     */
    assert_true(worst < 0.04);
    pel_model_unref(models[0]);
    pel_model_unref(models[1]);
}

#define WIDE 240
#define HIGH 135

/* A tanker between the Sun and a tug: of the pixels of the tug on which the Sun
 * shines without the tanker, those lose it from which a ray to the Sun meets
 * the tanker. The shadow's texels are 0.25 m wide: pixels beside the edge of
 * the shadow may go either way. */
static void one_ship_shades_another(void **state)
{
    (void)state;
    test_sea(0.0, 0.0, 1, &sea);
    const struct pel_model *tug = model_of("tug"), *tanker = model_of("tanker");
    struct pel_environment env = test_environment(&sea, 5.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(12.0, 150.0);
    const struct pel_vec3 to = env.lights[PEL_LIGHT_SUN].direction;
    /* The tanker's house stands before the tug's stern. */
    const struct pel_object objects[] = { standing(tug, 7, 0, 150, 80),
                                          standing(tanker, 8, 140, 139, 60) };
    struct pel_camera c = test_camera(
        (struct test_look){ 14.0, 0.0, -3.0, 0.0, 16.0, WIDE, HIGH });
    static float alone[4 * WIDE * HIGH];
    size_t shaded = 0, lit = 0, wrong = 0;
    for (int both = 0; both < 2; both++) {
        env.objects = objects;
        env.object_count = 1 + (size_t)both;
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_SUN | PEL_LAYER_ID);
        for (size_t i = 0; i < (size_t)WIDE * HIGH; i++) {
            if (!both) {
                alone[i] = p->id[i] == 8.0f ? p->sun[4 * i + 1] : 0;
                continue;
            }
            struct pel_vec3 ray = test_ray(&c, (double)(i % WIDE) + 0.5,
                                           (double)(i / WIDE) + 0.5);
            const struct pel_vec3 eye = { c.east_m, c.north_m, c.altitude_m };
            struct pel_model_hit hit, other;
            if (alone[i] < 1e-4f || p->id[i] != 8.0f ||
                !meets(&objects[0], eye, ray, 0, &hit)) {
                continue;
            }
            struct pel_vec3 at =
                pel_vec3_add(eye, pel_vec3_scale(ray, hit.distance_m));
            bool hidden = meets(&objects[1], at, to, 0, &other);
            shaded += hidden;
            lit += !hidden;
            wrong += hidden != (p->sun[4 * i + 1] < 0.5f * alone[i]);
        }
        pel_picture_release(p);
    }
    printf("%zu in the shadow, %zu not, %zu wrong\n", shaded, lit, wrong);
    assert_true(shaded > 100 && lit > 100);
    assert_true(20 * wrong <= shaded + lit);
    pel_model_unref(tug);
    pel_model_unref(tanker);
}

/* --- beyond the horizon -----------------------------------------------------
 */

#define EARTH_M 6360000.0 /* as everywhere in the program */
#define FAR_WIDE 64
#define FAR_HIGH 512
#define FAR_FOV 0.05

/* Rows of a picture in which a tanker is seen: the first, and one after the
 * last. */
static void rows_of(double eye_m, double away_m, double pitch,
                    const struct pel_model *model, int out[2], double *px)
{
    const struct pel_object object = standing(model, 7, 0, away_m, 90);
    struct pel_environment env = test_environment(&sea, 5.0);
    env.objects = &object;
    env.object_count = 1;
    struct pel_camera c = test_camera((struct test_look){
        eye_m, 0.0, pitch, 0.0, FAR_FOV, FAR_WIDE, FAR_HIGH });
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_ID);
    out[0] = FAR_HIGH;
    out[1] = 0;
    for (int i = 0; i < FAR_WIDE * FAR_HIGH; i++) {
        if (p->id[i] == 8.0f) {
            out[0] = i / FAR_WIDE < out[0] ? i / FAR_WIDE : out[0];
            out[1] = i / FAR_WIDE + 1;
        }
    }
    *px = (c.tan_top - c.tan_bottom) / c.height;
    pel_picture_release(p);
}

/* The model's highest point in what the picture's columns show, m. */
static double highest(const struct pel_model *model, double half_m)
{
    double most = 0, z;
    struct pel_model_hit hit;
    for (double x = -half_m; x <= half_m; x += 0.1) {
        for (double y = -22; y <= 22; y += 0.1) {
            most = pel_model_top(model, x, y, &hit, &z) ? fmax(most, z) : most;
        }
    }
    return most;
}

/* Elevation of a point at an arc's distance, rad. */
static double elevation(double eye_m, double away_m, double height_m)
{
    double arc = away_m / EARTH_M;
    return atan2((EARTH_M + height_m) * cos(arc) - (EARTH_M + eye_m),
                 (EARTH_M + height_m) * sin(arc));
}

/* On a sphere without refraction, in a flat sea: the first row is the top of
 * the ship, the last its waterline or, beyond the horizon, the horizon. Thin
 * things beside the middles of pixels, and the sea's mesh of facets, are the
 * tolerance. */
static void ships_sink_behind_the_horizon(void **state)
{
    (void)state;
    static const double eyes[] = { 4, 15 }, aways[] = { 10000, 20000 };
    test_sea(0.0, 0.0, 1, &sea);
    const struct pel_model *model = model_of("tanker");
    for (int k = 0; k < 4; k++) {
        double eye = eyes[k / 2], away = aways[k % 2], px;
        double dip = acos(EARTH_M / (EARTH_M + eye));
        double beyond = away - dip * EARTH_M;
        double hidden =
            beyond > 0 ? EARTH_M / cos(beyond / EARTH_M) - EARTH_M : 0;
        double top = highest(model, away * tan(0.5 * FAR_FOV * PEL_DEG));
        double pitch = elevation(eye, away, 0.5 * (top + hidden));
        int rows[2];
        rows_of(eye, away, pitch / PEL_DEG, model, rows, &px);
        double low = beyond > 0 ? -dip : elevation(eye, away - 21, 0);
        double high = elevation(eye, away, top);
        double first = 0.5 * FAR_HIGH - tan(high - pitch) / px;
        double last = 0.5 * FAR_HIGH - tan(low - pitch) / px;
        double share = 1 - (rows[1] - rows[0]) * px * away / top;
        printf("eye %2.0f m, %2.0f km: rows %d to %d, by geometry %.1f to "
               "%.1f; hidden %.1f %%, by geometry %.1f %%\n",
               eye, away / 1000, rows[0], rows[1], first, last, 100 * share,
               100 * hidden / top);
        assert_float_equal(rows[0], first, 1.5);
        assert_float_equal(rows[1], last, 1.5);
    }
    pel_model_unref(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lamps_light_what_they_face),
        cmocka_unit_test(hulls_are_wet_where_waves_were),
        cmocka_unit_test(one_ship_shades_another),
        cmocka_unit_test(ships_sink_behind_the_horizon),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
