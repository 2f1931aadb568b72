/* The mesh's plan: pure computation. */
#include "render/mesh.h"

#include "optics/atmosphere.h"
#include "render/render_testkit.h"
#include "render/uniforms.h"

static struct pel_mesh mesh; /* large */
static struct pel_sea sea;

static double horizon_m(double height_m)
{
    return PEL_EARTH_RADIUS *
           acos(PEL_EARTH_RADIUS / (PEL_EARTH_RADIUS + height_m));
}

static void plan(const struct pel_camera *c)
{
    static struct pel_mesh_losses losses;
    pel_mesh_losses(&sea, &PEL_FILTER_DEFAULT, &losses);
    const struct pel_mesh_eye eye = {
        .height_m = c->altitude_m,
        .pixel = pel_pixel_pitch(c->tan_left, c->tan_right, c->width),
        .cell_px = PEL_CELL_PX_DEFAULT,
        .sea = &sea,
        .losses = &losses,
    };
    pel_mesh_plan(&eye, c, NULL, &mesh);
}

/* Is the place at rest (arc from the nadir, azimuth) in some block's sector
 * and between its rings? */
static bool covered(double radius_m, double azimuth)
{
    for (int i = 0; i < mesh.block_count; i++) {
        const struct pel_mesh_block *b = &mesh.blocks[i];
        double first = mesh.rings[b->first_ring].radius_m;
        double last = mesh.rings[b->first_ring + b->rings - 1].radius_m;
        double turn = azimuth - b->first_column * mesh.column_rad;
        turn -= 2.0 * PEL_PI * floor(turn / (2.0 * PEL_PI));
        if (radius_m >= first && radius_m <= last &&
            turn <= (b->columns - 1) * mesh.column_rad) {
            return true;
        }
    }
    return false;
}

/* Arc from the nadir at which a ray from height_m meets the sphere raised by
 * rise_m for the first time, or −1. */
static double meet(double height_m, double rise_m, struct pel_vec3 dir)
{
    double r = PEL_EARTH_RADIUS + height_m, to = PEL_EARTH_RADIUS + rise_m;
    double c = (r - to) * (r + to), b = r * dir.z;
    double root = b * b - c;
    if (b >= 0.0 || root < 0.0 || c < 0.0) {
        return -1.0;
    }
    double t = c / (-b + sqrt(root));
    return PEL_EARTH_RADIUS * atan2(t * hypot(dir.x, dir.y), r + t * dir.z);
}

static const double heights[] = {
    0.3, 2.0, 6.0, 30.0, 1000.0, 8000.0, 20000.0
};
static const double fields[] = { 1.0, 10.0, 60.0, 150.0 };
/* NOLINTNEXTLINE(bugprone-macro-parentheses): i is declared by it */
#define EACH(i, list) (size_t i = 0; i < sizeof(list) / sizeof *(list); i++)

static void reaches_past_the_horizon(void **state)
{
    (void)state;
    test_sea(10.0, 0.0, 1, &sea);
    for
        EACH(h, heights)
        {
        for
            EACH(f, fields)
            {
                struct pel_camera c = test_camera((struct test_look){
                    heights[h], 70.0, 0.0, 0.0, fields[f], 1024, 768 });
                plan(&c);
                assert_in_range(mesh.vertex_count, 1, PEL_MESH_MAX_VERTICES);
                assert_in_range(mesh.ring_count, 4, PEL_MESH_MAX_RINGS);
                bool on_it = false;
                for (int i = 0; i < mesh.ring_count; i++) {
                    on_it |=
                        mesh.rings[i].radius_m == (float)horizon_m(heights[h]);
                    assert_true(mesh.rings[i].cell_m > 0.0f);
                    if (i > 0) {
                        assert_true(mesh.rings[i].radius_m >=
                                    mesh.rings[i - 1].radius_m);
                    }
                }
                assert_true(on_it);
                const struct pel_mesh_block *last =
                    &mesh.blocks[mesh.block_count - 1];
                int end = last->first_ring + last->rings - 1;
                assert_int_equal(end, mesh.ring_count - 1);
                assert_true(mesh.rings[end].radius_m >
                            1.2 * horizon_m(heights[h]));
            }
        }
}

static void blocks_hold_their_vertices(void **state)
{
    (void)state;
    static const double pitches[] = { -90.0, -60.0, -20.0, 0.0, 15.0 };
    static const double rolls[] = { 0.0, 30.0, 90.0, -170.0 };
    test_sea(20.0, 6.0, 2, &sea);
    for
        EACH(h, heights)
        {
        for
            EACH(f, fields)
            {
            for
                EACH(p, pitches)
                {
                for
                    EACH(r, rolls)
                    {
                        struct pel_camera c = test_camera((struct test_look){
                            heights[h], 200.0, pitches[p], rolls[r], fields[f],
                            640, 480 });
                        plan(&c);
                        assert_true(mesh.vertex_count <= PEL_MESH_MAX_VERTICES);
                        assert_true(mesh.block_count <= PEL_MESH_MAX_BLOCKS);
                        int base = 0;
                        for (int i = 0; i < mesh.block_count; i++) {
                            const struct pel_mesh_block *b = &mesh.blocks[i];
                            assert_int_equal(b->base, base);
                            base += b->rings * b->columns;
                            assert_true(b->rings >= 2 && b->columns >= 2);
                            assert_true(b->first_ring + b->rings <=
                                        mesh.ring_count);
                            assert_in_range(b->first_column, 0,
                                            mesh.columns_around - 1);
                            assert_true(b->columns <= mesh.columns_around + 1);
                            if (i > 0) { /* no gap between neighbours */
                                const struct pel_mesh_block *a = b - 1;
                                assert_int_equal(b->first_ring,
                                                 a->first_ring + a->rings - 1);
                            }
                        }
                        assert_int_equal(base, mesh.vertex_count);
                    }
                }
            }
        }
}

/* What a pixel sees was displaced from a place at rest no farther away than
 * the displacements that count (five standard deviations, as the plan has it):
 * that place must be in the mesh. */
static int missed(const struct pel_camera *c, uint64_t *random, int samples,
                  struct test_look look)
{
    double rise = fmin(sea.max_height_m, 5.0 * sqrt(sea.m0));
    int lost = 0;
    for (int i = 0; i < samples; i++) {
        struct pel_vec3 d = test_ray(c, test_random(random, 0.0, c->width),
                                     test_random(random, 0.0, c->height));
        double up = test_random(random, -rise, rise);
        double r = meet(c->altitude_m, fmin(up, c->altitude_m - 0.01), d);
        /* Behind the horizon only crests are seen, and the mesh ends where
         * none is high enough. */
        if (r < 0.0 || r > horizon_m(c->altitude_m)) {
            continue;
        }
        double side = test_random(random, 0.0, 2.0 * PEL_PI);
        double length = rise * sqrt(test_random(random, 0.0, 1.0));
        double azimuth = atan2(d.y, d.x);
        double x = r * cos(azimuth) + length * cos(side);
        double y = r * sin(azimuth) + length * sin(side);
        if (!covered(hypot(x, y), atan2(y, x))) {
            if (lost++ == 0) {
                printf("height %g pitch %g roll %g fov %g: no vertex for "
                       "(%.2f, %.2f) m, crest %.2f m\n",
                       look.height_m, look.pitch, look.roll, look.fov, x, y,
                       up);
            }
        }
    }
    return lost;
}

static void all_that_is_seen_is_in_it(void **state)
{
    (void)state;
    uint64_t random = 1;
    int lost = 0;
    for (int i = 0; i < 400; i++) {
        const struct test_look look = {
            .height_m = 0.3 * pow(20000.0 / 0.3, test_random(&random, 0, 1)),
            .heading = test_random(&random, 0.0, 360.0),
            .pitch = test_random(&random, -90.0, 30.0),
            .roll = test_random(&random, -180.0, 180.0),
            .fov = i % 4 == 0 ? 150.0 : test_random(&random, 1.0, 120.0),
            .width = 640,
            .height = 360,
        };
        if (i % 20 == 0) {
            test_sea(test_random(&random, 1.0, 25.0),
                     i % 40 ? 0.0 : test_random(&random, 1.0, 10.0),
                     (uint32_t)i, &sea);
        }
        struct pel_camera c = test_camera(look);
        plan(&c);
        lost += missed(&c, &random, 300, look);
    }
    assert_int_equal(lost, 0);
}

/* Neighbours that share an eye and a pixel draw one mesh: same columns, same
 * rings where both have them. */
static void neighbours_share_rings(void **state)
{
    (void)state;
    static struct pel_mesh first;
    test_sea(12.0, 2.0, 3, &sea);
    for
        EACH(h, heights)
        {
            struct pel_camera whole = test_camera((struct test_look){
                heights[h], 10.0, -8.0, 5.0, 60.0, 1024, 512 });
            struct pel_camera part = whole;
            double px = (whole.tan_right - whole.tan_left) / whole.width;
            part.width = 300;
            part.tan_right = whole.tan_left + 300.0 * px;
            plan(&whole);
            first = mesh;
            plan(&part);
            assert_int_equal(mesh.columns_around, first.columns_around);
            assert_int_equal(mesh.ring_count, first.ring_count);
            assert_memory_equal(mesh.rings, first.rings,
                                sizeof *mesh.rings * (size_t)mesh.ring_count);
            assert_true(mesh.vertex_count < first.vertex_count);
        }
}

/* The narrowest frusta that are legal, where whole circles of columns as fine
 * as their pixels would be: straight up, straight down and level. */
static void needles_are_bounded(void **state)
{
    (void)state;
    static const double pitches[] = { 90.0, -90.0, 0.0, -45.0 };
    test_sea(30.0, 15.0, 4, &sea);
    for (int i = 0; i < 4 * 7; i++) {
        struct pel_camera c = test_camera((struct test_look){
            heights[i % 7], 0.0, pitches[i / 7], 0.0, 0.01, 4096, 4096 });
        plan(&c);
        assert_in_range(mesh.vertex_count, 0, PEL_MESH_MAX_VERTICES);
        int sum = 0;
        for (int b = 0; b < mesh.block_count; b++) {
            sum += mesh.blocks[b].rings * mesh.blocks[b].columns;
        }
        assert_int_equal(sum, mesh.vertex_count);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reaches_past_the_horizon),
        cmocka_unit_test(blocks_hold_their_vertices),
        cmocka_unit_test(all_that_is_seen_is_in_it),
        cmocka_unit_test(neighbours_share_rings),
        cmocka_unit_test(needles_are_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
