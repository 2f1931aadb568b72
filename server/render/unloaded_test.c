/* Programs that nobody has used for a while are given back, and pictures that
 * need them again have the same bits; where one cannot be made again the
 * renderer counts as lost. */
#define TEST_ANTIALIASING true
#include <ftw.h>
#include <malloc.h>
#include <unistd.h>

#include "render/render_testkit.h"
#include "render/shader.h"

enum { SIDE = 96, KINDS = 9 };
static struct pel_sea fft, trochoids;
static const struct pel_seabed *bed;

/* Of as many kinds of pictures, which have few programs in common. */
static struct pel_picture *draw(struct pel_renderer *r, int kind)
{
    struct pel_environment env =
        test_environment(kind % 2 ? &trochoids : &fft, 5.0);
    double height_m = 12;
    env.seabed = kind == 2 ? bed : NULL;
    env.visibility_m = kind == 3 ? 2000 : 40000;
    env.fog_count = kind == 4;
    env.fog[0] = (struct pel_fog){ .extinction = 0.002, .top_m = 20 };
    if (kind == 5) {
        height_m = -3;
    }
    if (kind == 6) {
        env.clouds.cover = 0.5;
    }
    if (kind == 7) {
        height_m = 50000;
    }
    const struct pel_camera c = test_camera((struct test_look){
        height_m, 40, kind == 7 ? -60 : -5, 0, 60, SIDE, SIDE });
    return test_draw(r, &env, &c,
                     kind == 8 ? TEST_ALL_LAYERS : PEL_LAYER_COLOR);
}

static size_t held_bytes(void)
{
    struct mallinfo2 m = mallinfo2();
    return m.uordblks + m.hblkhd;
}

static void pictures_are_the_same(void **state)
{
    (void)state;
    static uint8_t wanted[KINDS][4 * SIDE * SIDE];
    pel_program_limits(1000, 3600);
    for (int round = 0; round < 2; round++) { /* tables are made in the first */
        for (int i = 0; i < KINDS; i++) {
            struct pel_picture *p = draw(renderer, i);
            memcpy(wanted[i], p->rgba, sizeof wanted[i]);
            pel_picture_release(p);
        }
    }
    const unsigned all = pel_renderer_programs();
    const size_t before = held_bytes();
    pel_program_limits(1, 0);
    for (int i = 0; i < 2 * KINDS; i++) {
        const int kind = i * 5 % KINDS;
        struct pel_picture *p = draw(renderer, kind);
        if (memcmp(wanted[kind], p->rgba, sizeof wanted[kind]) != 0) {
            fail_msg("kind %d has other bits", kind);
        }
        pel_picture_release(p);
        assert_int_equal(pel_renderer_programs(), 1);
    }
    const double freed = (double)before - (double)held_bytes();
    print_message("%u programs; each that is unloaded gives back %.0f kB\n",
                  all, freed / 1e3 / (all - 1));
    assert_true(all > 30);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    /* 1.7 MB, NVIDIA's driver 0.2; a sanitizer's allocator does not count for
     * mallinfo. */
    assert_true(freed >
                (pel_renderer_is_software(renderer) ? 500e3 : 50e3) * all);
#endif
    assert_false(pel_renderer_lost(renderer));
    pel_program_limits(PEL_PROGRAM_MOST, PEL_PROGRAM_IDLE_S);
}

/* What has just been used stays, however many there are. */
static void what_is_in_use_stays(void **state)
{
    (void)state;
    pel_program_limits(1, 3600);
    for (int i = 0; i < 2; i++) {
        pel_picture_release(draw(renderer, i));
    }
    const unsigned two = pel_renderer_programs();
    assert_true(two > 10);
    for (int i = 0; i < 2; i++) {
        pel_picture_release(draw(renderer, i));
    }
    assert_int_equal(pel_renderer_programs(), two);
    pel_program_limits(PEL_PROGRAM_MOST, PEL_PROGRAM_IDLE_S);
}

/* A folder of shaders, to take one away. */
static char folder[] = "/tmp/pelagos-unloaded-XXXXXX";

static int copy_one(const char *path, const struct stat *info, int type,
                    struct FTW *place)
{
    char to[512];
    (void)info;
    (void)place;
    snprintf(to, sizeof to, "%s%s", folder, path + strlen("shaders"));
    if (type == FTW_D) {
        return strcmp(path, "shaders") ? mkdir(to, 0700) : 0;
    }
    char *real = realpath(path, NULL);
    int failed = !real || symlink(real, to);
    free(real);
    return failed;
}

static int remove_one(const char *path, const struct stat *info, int type,
                      struct FTW *place)
{
    (void)info;
    (void)type;
    (void)place;
    return remove(path);
}

static void a_program_that_is_gone_is_a_loss(void **state)
{
    (void)state;
    char path[512];
    pel_renderer_destroy(renderer);
    renderer = NULL;
    assert_int_equal(pel_renderer_programs(), 0);
    assert_non_null(mkdtemp(folder));
    assert_int_equal(nftw("shaders", copy_one, 8, FTW_PHYS), 0);
    const struct pel_renderer_options options = { .device = test_device(),
                                                  .shading = "fragment",
                                                  .shader_dir = folder };
    struct pel_fault fault = { 0 };
    assert_int_equal(pel_renderer_create(&options, &renderer, &fault), PEL_OK);
    pel_picture_release(draw(renderer, 0));
    pel_program_limits(1, 0);
    pel_picture_release(draw(renderer, 0));
    assert_false(pel_renderer_lost(renderer));
    snprintf(path, sizeof path, "%s/backdrop.frag", folder);
    assert_int_equal(unlink(path), 0);
    pel_picture_release(draw(renderer, 0));
    assert_true(pel_renderer_lost(renderer));
    pel_program_limits(PEL_PROGRAM_MOST, PEL_PROGRAM_IDLE_S);
    nftw(folder, remove_one, 8, FTW_DEPTH | FTW_PHYS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_the_same),
        cmocka_unit_test(what_is_in_use_stays),
        cmocka_unit_test(a_program_that_is_gone_is_a_loss),
    };
    test_fft_sea(9.0, 3, &fft);
    test_sea(9.0, 0.0, 3, &trochoids);
    bed = test_bed(test_island);
    int failed = cmocka_run_group_tests(tests, begin_renderer, end_renderer);
    pel_sea_finish(&fft);
    pel_sea_finish(&trochoids);
    pel_seabed_unref(bed);
    return failed;
}
