/* A hull seen through a flat sea, pixel by pixel, against rays that meet its
 * outline; and its maps. */
#include "render/hullmap.h"

#include "models/shape.h"
#include "optics/atmosphere.h"
#include "optics/brdf.h"
#include "render/modelpaint.h"
#include "render/render_testkit.h"
#include "render/sky.h"

#define HALF_LENGTH 30.0
#define DRAUGHT 3.0
#define ALBEDO 0.4

/* Half its section, from the deck's edge down: two steep sides of the bilge,
 * then what no ray from above meets. */
static const double section[][2] = {
    { 8, 0.2 }, { 8, 0 }, { 7.8, -1.2 }, { 7.0, -2.4 }, { 5, -DRAUGHT }
};
#define CORNERS (sizeof section / sizeof *section)

static struct pel_sea sea;

struct making {
    struct pel_shape shape;
    int paint, node;
};

static struct pel_model_vertex corner(double x, double side, size_t i)
{
    return (struct pel_model_vertex){
        .position = { (float)x, (float)(side * section[i][0]),
                      (float)section[i][1] }
    };
}

/* Corners counterclockwise from outside; clockwise where it is turned. */
static void strip(struct making *m, struct pel_model_vertex a,
                  struct pel_model_vertex b, struct pel_model_vertex c,
                  struct pel_model_vertex d, bool turned)
{
    const struct pel_model_vertex t[][3] = {
        { a, turned ? c : b, turned ? b : c },
        { a, turned ? d : c, turned ? c : d },
    };
    for (int i = 0; i < 2; i++) {
        pel_shape_triangle(&m->shape, t[i], m->paint, m->node);
    }
}

static const struct pel_model *pontoon(void)
{
    struct making m = { .shape = { .name = "pontoon" } };
    struct pel_model_draft draft;
    struct pel_fault fault = { 0 };
    const struct pel_model *model = NULL;
    const struct pel_model_material paint = { .name = "paint",
                                              .albedo = { ALBEDO, ALBEDO,
                                                          ALBEDO },
                                              .roughness = 1,
                                              .texture = -1 };
    m.paint = pel_shape_material(&m.shape, &paint);
    m.node = pel_shape_node(&m.shape, "pontoon");
    const double l = HALF_LENGTH;
    for (size_t i = 0; i + 1 < CORNERS; i++) {
        for (int side = -1; side < 2; side += 2) {
            strip(&m, corner(l, side, i), corner(-l, side, i),
                  corner(-l, side, i + 1), corner(l, side, i + 1), side > 0);
        }
        for (int end = -1; end < 2; end += 2) {
            strip(&m, corner(end * l, -1, i), corner(end * l, -1, i + 1),
                  corner(end * l, 1, i + 1), corner(end * l, 1, i), end > 0);
        }
    }
    size_t last = CORNERS - 1;
    strip(&m, corner(-l, 1, 0), corner(-l, -1, 0), corner(l, -1, 0),
          corner(l, 1, 0), false);
    strip(&m, corner(-l, -1, last), corner(-l, 1, last), corner(l, 1, last),
          corner(l, -1, last), false);
    assert_int_equal(pel_shape_finish(&m.shape, &draft, &fault), PEL_OK);
    assert_int_equal(pel_model_create(&draft.model, &model, &fault), PEL_OK);
    pel_model_draft_clear(&draft);
    pel_shape_clear(&m.shape);
    return model;
}

/* Half the breadth at a height. */
static double breadth(double z)
{
    size_t i = 0;
    while (i + 2 < CORNERS && z < section[i + 1][1]) {
        i++;
    }
    double share = (z - section[i][1]) / (section[i + 1][1] - section[i][1]);
    return section[i][0] + share * (section[i + 1][0] - section[i][0]);
}

static void sides_by_depth(void **state)
{
    (void)state;
    static float below[PEL_HULL_LENGTH * PEL_HULL_BREADTH];
    static float sides[2 * PEL_HULL_LENGTH * PEL_HULL_ROWS];
    const struct pel_model *model = pontoon();
    pel_hull_below(model, below);
    pel_hull_sides(model, sides);
    for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
        size_t row = i / PEL_HULL_LENGTH % PEL_HULL_ROWS;
        double z = -DRAUGHT * (1 - ((double)row + 0.5) / PEL_HULL_ROWS);
        assert_true(fabs((double)sides[i] + breadth(z)) < 1e-4);
    }
    for (size_t i = 0; i < PEL_HULL_BREADTH; i++) {
        double y = 16 * (((double)i + 0.5) / PEL_HULL_BREADTH - 0.5);
        double z = (double)below[i * PEL_HULL_LENGTH + PEL_HULL_LENGTH / 3];
        assert_true(fabs(y) < 5 ? fabs(z + DRAUGHT) < 1e-4
                                : fabs(fabs(y) - breadth(z)) < 1e-4);
    }
    pel_model_unref(model);
}

/* --- through the water ---------------------------------------------------- */

#define INDEX 1.34
#define FADE 0.2 /* 1/m, of water that scatters next to nothing */
#define NORTH 40.0

struct seen {
    double way, deep;
    struct pel_vec3 normal; /* of the hull there */
};

/* From the place `y` m north on the sea along d, a hull abeam: its section to
 * the south is met. */
static bool meets(double y, struct pel_vec3 d, struct seen *out)
{
    *out = (struct seen){ .way = HUGE_VAL };
    for (size_t i = 1; i + 1 < CORNERS; i++) {
        const double *a = section[i], *b = section[i + 1];
        double ay = NORTH - a[0], by = NORTH - b[0];
        /* Outward of the edge, times its length. */
        double n = -(a[1] - b[1]), m = -(by - ay);
        double facing = n * d.y + m * d.z;
        double way = (n * (ay - y) + m * a[1]) / facing, z = way * d.z;
        if (facing < 0 && way > 0 && z <= a[1] && z >= b[1] && way < out->way) {
            out->way = way;
            out->deep = -z;
            out->normal = pel_vec3_normalize((struct pel_vec3){ 0, n, m });
        }
    }
    return out->way < HUGE_VAL;
}

static struct pel_vec3 refracted(struct pel_vec3 d)
{
    double down = sqrt(1 - (1 - d.z * d.z) / (INDEX * INDEX));
    return (struct pel_vec3){ d.x / INDEX, d.y / INDEX, -down };
}

/* Of the irradiance of a uniform sky on the sea, what comes to the hull. */
static double sky_share(const struct seen *at)
{
    enum { N = 40 };
    double sum = 0;
    for (int i = 0; i < N; i++) {
        double sine2 = (i + 0.5) / N; /* of the angle in the air */
        double sine = sqrt(sine2) / INDEX, down = sqrt(1 - sine * sine);
        double through = (1 - pel_fresnel_exact(sqrt(1 - sine2), INDEX)) *
                         exp(-FADE * at->deep / down) / down;
        for (int k = 0; k < N; k++) {
            double turn = 2 * PEL_PI * (k + 0.5) / N;
            const struct pel_vec3 to = { sine * cos(turn), sine * sin(turn),
                                         down };
            sum += fmax(pel_vec3_dot(to, at->normal), 0) * through;
        }
    }
    return sum / N / N;
}

struct daylight {
    struct pel_vec3 sun;
    double beam, sky; /* irradiance, normal and level */
};

static double radiance(const struct seen *at, const struct daylight *light,
                       double sight)
{
    const float grey[3] = { ALBEDO, ALBEDO, ALBEDO };
    float albedo[3];
    pel_model_reflectance(grey, albedo);
    struct pel_vec3 beam = refracted(pel_vec3_scale(light->sun, -1));
    double direct = light->beam * light->sun.z *
                    (1 - pel_fresnel_exact(light->sun.z, INDEX)) *
                    fmax(-pel_vec3_dot(beam, at->normal), 0) / -beam.z *
                    exp(-FADE * at->deep / -beam.z);
    return (double)albedo[1] / PEL_PI * (direct + light->sky * sky_share(at)) *
           exp(-FADE * at->way) * (1 - pel_fresnel_exact(sight, INDEX)) /
           (INDEX * INDEX);
}

static struct daylight daylight_of(const struct pel_environment *env,
                                   struct pel_vec3 sun)
{
    static struct pel_atmosphere air;
    const struct pel_atmosphere_desc desc = { env->visibility_m };
    pel_atmosphere_init(&desc, &air);
    assert_int_equal(pel_atmosphere_tabulate(&air, NULL, NULL), PEL_OK);
    struct daylight light = { sun,
                              pel_atmosphere_sun_irradiance(&air, 0.0, sun).g,
                              pel_atmosphere_sky_irradiance(&air, sun).g };
    pel_atmosphere_finish(&air);
    return light;
}

static struct pel_environment clear_water(double sun_azimuth)
{
    struct pel_environment env = test_environment(&sea, 0.0);
    env.visibility_m = 300000.0;
    env.lights[PEL_LIGHT_SUN].direction = test_sun(30.0, sun_azimuth);
    for (int i = 0; i < 3; i++) {
        env.water.absorption[i] = FADE;
        env.water.scattering[i] = 1e-6;
        env.water.molecular[i] = 0;
    }
    return env;
}

#define WIDE 64
#define HIGH 180

/* Pixels whose middle and both lines beside meet one face of the hull. */
static void compare(double sun_azimuth)
{
    struct pel_environment env = clear_water(sun_azimuth);
    const struct pel_model *model = pontoon();
    const struct pel_object object = {
        .id = 3,
        .model = model,
        .north_m = NORTH,
        .world_from_model = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } },
    };
    env.objects = &object;
    env.object_count = 1;
    struct pel_camera c = test_camera(
        (struct test_look){ 30.0, 0.0, -44.0, 0.0, 1.0, WIDE, HIGH });
    struct daylight light =
        daylight_of(&env, pel_sky_quantize(test_sun(30.0, sun_azimuth)));
    struct pel_picture *p =
        test_draw(renderer, &env, &c, PEL_LAYER_WATER | PEL_LAYER_ID);
    double worst = 0, sum[2] = { 0 };
    int count = 0;
    for (uint32_t i = 0; i < WIDE * HIGH; i++) {
        struct seen at[3];
        bool all = p->id[i] == 0;
        struct pel_vec3 d = { 0 };
        for (int k = 2; k >= 0; k--) {
            d = test_ray(&c, i % WIDE + 0.5,
                         i / WIDE + (k == 0   ? 0.5
                                     : k == 1 ? -2.5
                                              : 3.5));
            double y = c.altitude_m * d.y / -d.z;
            all = all && y < NORTH - 8 && meets(y, refracted(d), &at[k]);
        }
        if (!all || fabs(at[1].normal.z - at[2].normal.z) > 1e-6) {
            continue;
        }
        double want = radiance(&at[0], &light, -d.z);
        double is = (double)p->layer[PEL_AT_WATER][4 * i + 1];
        worst = fmax(worst, fabs(is / want - 1));
        sum[0] += is;
        sum[1] += want;
        count++;
    }
    pel_picture_release(p);
    pel_model_unref(model);
    printf("Sun at %.0f: %d pixels, mean %+.1f %%, worst %.1f %%\n",
           sun_azimuth, count, 100 * (sum[0] / sum[1] - 1), 100 * worst);
    assert_true(count > 1000);
    /* The sky is not uniform, and its light on walls is known to 6 %: of a
     * sixth of the light. A half of a layer is 0.05 %. */
    assert_true(fabs(sum[0] / sum[1] - 1) < 0.015);
    assert_true(worst < 0.02);
}

static void lit_by_the_sun(void **state)
{
    (void)state;
    test_sea(0.0, 0.0, 1, &sea);
    compare(180.0);
    compare(240.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sides_by_depth),
        cmocka_unit_test(lit_by_the_sun),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
