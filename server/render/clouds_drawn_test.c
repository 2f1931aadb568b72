/* Clouds as they are drawn: before a low Sun a thin one in the shadow of a
 * thick one is dark, too; their tile is not seen again beside itself. */
#include "render/render_testkit.h"

#define WIDE 480
#define HIGH 270
#define NEAR 3 /* pixels each way that a pixel is compared with */
#define ABOUT ((2 * NEAR + 1) * (2 * NEAR + 1))

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double green(const struct pel_picture *p, int x, int y)
{
    return (double)p->radiance[4 * (y * WIDE + x) + 1];
}

/* Pixels that are more than a tenth brighter than the median about them, where
 * the middle half of these differs by less than 8 %, as on a cloud's side and
 * not at its rim; and how much of it they are at most. */
static int count_beads(const struct pel_picture *p, double *most)
{
    int count = 0;
    *most = 0;
    for (int y = NEAR; y < HIGH - NEAR; y++) {
        for (int x = NEAR; x < WIDE - NEAR; x++) {
            double about[ABOUT];
            size_t n = 0;
            for (int j = -NEAR; j <= NEAR; j++) {
                for (int i = -NEAR; i <= NEAR; i++) {
                    about[n++] = green(p, x + i, y + j);
                }
            }
            qsort(about, n, sizeof *about, by_size);
            double times = green(p, x, y) / about[n / 2];
            bool even = about[3 * n / 4] < 1.08 * about[n / 4];
            *most = even && times > *most ? times : *most;
            count += even && times > 1.1;
        }
    }
    return count;
}

static struct pel_sea sea;

static struct pel_environment cumulus(uint32_t seed)
{
    struct pel_environment env = test_environment(&sea, 100);
    const struct pel_cloud_kind *kind = pel_cloud_kind(PEL_CLOUD_CUMULUS);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(11, 30);
    env.clouds = (struct pel_clouds){ .cover = 0.5,
                                      .genus = PEL_CLOUD_CUMULUS,
                                      .base_m = kind->base_m,
                                      .thickness_m = kind->thickness_m,
                                      .east_mps = 1e-9, /* tiles lie so */
                                      .seed = seed };
    return env;
}

static void nothing_shines_through(void **state)
{
    (void)state;
    int count = 0;
    double most = 0;
    for (uint32_t seed = 1; seed <= 4; seed++) {
        struct pel_environment env = cumulus(seed);
        const struct pel_camera c =
            test_camera((struct test_look){ 5, 10, 17, 0, 50, WIDE, HIGH });
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
        double here;
        count += count_beads(p, &here);
        most = here > most ? here : most;
        pel_picture_release(p);
    }
    print_message("of four skies %.3f %% of the pixels are brighter than about "
                  "them by a tenth, at most by %.0f %%\n",
                  100.0 * count / (4.0 * WIDE * HIGH), 100 * (most - 1));
    /* 0.090; 0.290 where they are lit as if they stood alone. */
    assert_true(count < 0.0015 * 4 * WIDE * HIGH);
}

static struct pel_picture *look_up(double east_m)
{
    struct pel_environment env = cumulus(1);
    struct pel_camera c =
        test_camera((struct test_look){ 5, 30, 60, 0, 50, WIDE, HIGH });
    c.east_m = east_m;
    return test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
}

/* Share of the pixels that differ by more than `much`. */
static double changed(const struct pel_picture *a, const struct pel_picture *b,
                      double much)
{
    int count = 0;
    for (int y = 0; y < HIGH; y++) {
        for (int x = 0; x < WIDE; x++) {
            double was = green(a, x, y);
            count += fabs(green(b, x, y) - was) > much * was;
        }
    }
    return (double)count / (WIDE * HIGH);
}

static void tile_is_not_seen_again(void **state)
{
    (void)state;
    double tile_m = pel_cloud_kind(PEL_CLOUD_CUMULUS)->tile_m;
    const double east_m[] = { 0.05, PEL_CLOUD_PERIOD * tile_m + 0.05, -0.05,
                              tile_m + 0.05, 5 * tile_m + 0.05 };
    struct pel_picture *p[5];
    double share[5];
    for (int i = 0; i < 5; i++) {
        p[i] = look_up(east_m[i]);
        /* The fine structure is another at each tile. */
        share[i] = changed(p[0], p[i], i < 3 ? 0.01 : 0.3);
    }
    print_message("beyond the origin of the clouds by -0.05 m instead of "
                  "0.05 %.2f %% of the pixels differ; by %.0f tiles more "
                  "%.2f %%, much by one %.0f %%, by five %.0f %%\n",
                  100 * share[2], PEL_CLOUD_PERIOD, 100 * share[1],
                  100 * share[3], 100 * share[4]);
    /* A tenth of a metre of rims; places rounded to 0.15 m. */
    assert_true(share[1] < 0.01 && share[2] < 0.05);
    /* 2 and 3 % where the tile is seen again as it was. */
    assert_true(share[3] > 0.3 && share[4] > 0.3);
    for (int i = 0; i < 5; i++) {
        pel_picture_release(p[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_shines_through),
        cmocka_unit_test(tile_is_not_seen_again),
    };
    renderer = test_renderer(NULL);
    test_sea(8.0, 0.0, 3, &sea);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    pel_sea_finish(&sea);
    pel_renderer_destroy(renderer);
    return failed;
}
