/* Tiles never claim fewer waves than a pixel in them resolves. */
#include "render/tiles.h"

#include "optics/atmosphere.h"
#include "render/rendertest.h"
#include "render/uniforms.h"

static struct pel_sea sea;
static const struct pel_filtering filtering = { .n_min = 1.0, .anisotropy = 1 };
static short tiles[PEL_MAX_TILES];

/* Length of a pixel on the sea as shaders/lib/sea.glsl has it, where the ray
 * meets the sphere raised by rise_m; 0 when it does not. */
static double footprint(const struct pel_camera *c, double x, double y,
                        double rise_m)
{
    struct pel_vec3 d = test_ray(c, x, y);
    double r = PEL_EARTH_RADIUS + c->altitude_m;
    double to = PEL_EARTH_RADIUS + rise_m;
    double b = r * d.z, k = (r - to) * (r + to), root = b * b - k;
    if (b >= 0.0 || root < 0.0 || k <= 0.0) {
        return 0.0;
    }
    double t = k / (-b + sqrt(root));
    double incidence = -(d.z + t * (d.x * d.x + d.y * d.y) / PEL_EARTH_RADIUS);
    double axis = t * -pel_vec3_dot(d, c->world_from_camera.z);
    double px = pel_pixel_pitch(c->tan_left, c->tan_right, c->width);
    return axis * px / fmax(incidence, 0.002);
}

static int resolved(double length_m)
{
    int count = 0;
    for (int i = 0; i < sea.count; i++) {
        double lambda = 2.0 * PEL_PI / hypot(sea.waves[i].kx, sea.waves[i].ky);
        count = lambda > PEL_FILTER_DEFAULT.n_min * length_m ? i + 1 : count;
    }
    return count;
}

static void plan(const struct pel_camera *c)
{
    double px = pel_pixel_pitch(c->tan_left, c->tan_right, c->width);
    double py = pel_pixel_pitch(c->tan_bottom, c->tan_top, c->height);
    pel_tiles_plan(c, c->altitude_m, fmin(px, py), &filtering, &sea, tiles);
}

static void no_tile_claims_too_few(void **state)
{
    (void)state;
    uint64_t random = 7;
    int wrong = 0, checked = 0, saved = 0;
    for (int i = 0; i < 300; i++) {
        const struct test_look look = {
            .height_m = pow(20000.0, test_random(&random, 0.0, 1.0)),
            .heading = test_random(&random, 0.0, 360.0),
            .pitch = test_random(&random, -90.0, 10.0),
            .roll = test_random(&random, -180.0, 180.0),
            .fov = test_random(&random, 1.0, 150.0),
            .width = 500,
            .height = 300,
        };
        if (i % 15 == 0) {
            test_sea(test_random(&random, 1.0, 25.0), i % 30 ? 0.0 : 3.0,
                     (uint32_t)i, &sea);
        }
        struct pel_camera c = test_camera(look);
        plan(&c);
        double rise = fmin(sea.max_height_m, 5.0 * sqrt(sea.m0));
        int across = ((int)c.width + PEL_TILE - 1) / PEL_TILE;
        for (int k = 0; k < 400; k++) {
            int x = (int)test_random(&random, 0.0, c.width);
            int y = (int)test_random(&random, 0.0, c.height);
            double up = test_random(&random, -rise, rise);
            double length =
                footprint(&c, x + 0.5, y + 0.5, fmin(up, c.altitude_m - 0.01));
            if (length <= 0.0) {
                continue;
            }
            int claimed = tiles[y / PEL_TILE * across + x / PEL_TILE];
            checked++;
            saved += claimed <= 20;
            if (claimed < resolved(length) && wrong++ < 5) {
                printf("height %.1f pitch %.1f roll %.1f fov %.1f pixel %d %d "
                       "rise %.2f: %d waves, resolves %d\n",
                       look.height_m, look.pitch, look.roll, look.fov, x, y, up,
                       claimed, resolved(length));
            }
        }
    }
    printf("%d pixels; %d in tiles of few waves\n", checked, saved);
    assert_int_equal(wrong, 0);
    assert_true(saved > checked / 10); /* or tiles are for nothing */
}

/* From below the highest crest a pixel may be as near as one likes. */
static void a_low_eye_takes_all(void **state)
{
    (void)state;
    test_sea(15.0, 0.0, 1, &sea);
    struct pel_camera c =
        test_camera((struct test_look){ 1.0, 0.0, 0.0, 0.0, 60.0, 200, 130 });
    plan(&c);
    for (int i = 0; i < 4 * 3; i++) {
        assert_int_equal(tiles[i], sea.count);
    }
}

static void a_flat_sea_takes_none(void **state)
{
    (void)state;
    test_sea(0.0, 0.0, 1, &sea);
    struct pel_camera c =
        test_camera((struct test_look){ 6.0, 0.0, -10.0, 0.0, 60.0, 128, 64 });
    plan(&c);
    assert_int_equal(tiles[0], 0);
    assert_int_equal(tiles[1], 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_tile_claims_too_few),
        cmocka_unit_test(a_low_eye_takes_all),
        cmocka_unit_test(a_flat_sea_takes_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
