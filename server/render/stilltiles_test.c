/* Tiles that no ship waves and no wash reach have programs without either: the
 * same bits as with them everywhere. */
#include "render/stilltiles.h"

#include "ocean/wash.h"
#include "render/render_testkit.h"
#include "scene/wakes.h"

#define NOW 600.0
#define SPEED 6.17

static struct pel_wake_moment wakes;
static struct pel_wash *wash;

/* A ship that came from the south and is 500 m ahead of the origin, to the
 * east. */
static int make(void **state)
{
    (void)state;
    static struct pel_wake_track track;
    struct pel_wake *wake;
    struct pel_wash_ship ship = { 100, 15, 5, .count = 2 };
    track.hull = (struct pel_hull){ 100, 15, 5, 0.7 };
    track.count = 2;
    pel_wash_waterline(&ship);
    for (int i = 0; i < 2; i++) {
        double t = i * NOW, x = 300, y = 500 - SPEED * (NOW - t);
        track.point[i] = (struct pel_wake_point){ t, x, y };
        ship.point[i] = (struct pel_wash_point){ t, x, y, 0, NAN };
    }
    assert_int_equal(pel_wake_create(&track, NOW, 0, &wake), PEL_OK);
    wakes.count = 1;
    wakes.wake[0] = *wake;
    free(wake); /* its texels stay */
    assert_int_equal(pel_wash_create(&wash), PEL_OK);
    assert_int_equal(pel_wash_add(wash, &ship, NOW), PEL_OK);
    assert_int_equal(pel_wash_index(wash), PEL_OK);
    return 0;
}

static int finish(void **state)
{
    (void)state;
    for (int k = 0; k < PEL_WAKE_TILES; k++) {
        free(wakes.wake[0].tile[k].texels);
    }
    pel_wash_destroy(wash);
    return 0;
}

/* Across, with the ship ahead; to the left of it; from a height; rolled. */
static const struct test_look looks[] = {
    { 15, 0, -6, 0, 60, 512, 256 },
    { 6, -60, -2, 0, 60, 512, 256 },
    { 900, 40, -40, 0, 60, 512, 256 },
    { 30, 150, -10, 25, 90, 512, 256 },
};

static int count_still(const struct pel_environment *env,
                       const struct pel_camera *c)
{
    static uint32_t tiles[PEL_MAX_TILES];
    int count = 0;
    memset(tiles, 0, sizeof tiles);
    bool any = pel_still_tiles(env, c, tiles);
    for (uint32_t i = 0; i < (c->width / PEL_TILE) * (c->height / PEL_TILE);
         i++) {
        count += (tiles[i] & PEL_TILE_STILL) != 0;
    }
    assert_int_equal(any, count > 0);
    return count;
}

/* Pixels that differ from the picture without such tiles; *marked: tiles. */
static int differ(struct pel_environment *env, struct pel_camera *c,
                  int *marked)
{
    *marked = count_still(env, c);
    env->nowhere_still = true;
    struct pel_picture *all =
        test_draw(renderer, env, c, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
    env->nowhere_still = false;
    struct pel_picture *some =
        test_draw(renderer, env, c, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
    int wrong = 0;
    for (size_t i = 0; i < (size_t)c->width * c->height; i++) {
        wrong += memcmp(all->rgba + 4 * i, some->rgba + 4 * i, 4) != 0 ||
                 memcmp(all->radiance + 4 * i, some->radiance + 4 * i, 16) != 0;
    }
    pel_picture_release(all);
    pel_picture_release(some);
    return wrong;
}

static void try_sea(double wind, bool fft, double whitecaps)
{
    struct pel_sea sea;
    struct pel_sea_desc desc = test_wind(wind, 3);
    desc.kind = PEL_SPECTRUM_ELFOUHAILY;
    desc.synthesiser = fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS;
    desc.whitecaps = whitecaps;
    assert_int_equal(pel_sea_build(&desc, &sea), PEL_OK);
    int least = INT_MAX, most = 0, bad = 0;
    for (int with = 1; with < 4; with++) {
        for (size_t i = 0; i < sizeof looks / sizeof *looks; i++) {
            struct pel_environment env = test_environment(&sea, NOW);
            struct pel_camera c = test_camera(looks[i]);
            int marked;
            env.wakes = with & 1 ? &wakes : NULL;
            env.wash = with & 2 ? wash : NULL;
            int wrong = differ(&env, &c, &marked);
            if (wrong) {
                printf("look %zu, with %d: %d pixels of others\n", i, with,
                       wrong);
            }
            bad += wrong;
            least = marked < least ? marked : least;
            most = marked > most ? marked : most;
        }
    }
    printf("wind %g, %s: %d to %d of 32 tiles are still\n", wind,
           fft ? "cascades" : "trochoids", least, most);
    assert_int_equal(bad, 0);
    assert_true(most >= 16 && least < 32);
    pel_sea_finish(&sea);
}

static void programs_give_the_same_bits(void **state)
{
    (void)state;
    renderer = test_renderer("fragment");
    try_sea(6, true, 0);
    try_sea(12, true, 1);
    try_sea(12, false, 1);
    pel_renderer_destroy(renderer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(programs_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, make, finish);
}
