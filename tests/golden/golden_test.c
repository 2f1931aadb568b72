/* Sixteen scenes against the pictures that were judged good.
 *   golden_test           compares with tests/golden/NAME.png
 *   golden_test --write   draws them anew (make golden): look at each
 * Those that fail are written beside a difference, ten times as bright, to
 * build/golden/. */
#include <spng.h>
#include <sys/stat.h>

#include "encode/encode.h"
#include "optics/moon.h"
#include "render/render_testkit.h"

#define FOLDER "tests/golden"
#define FAILED "build/golden"
#define WIDTH 256
#define HEIGHT 144
#define BYTES (WIDTH * HEIGHT * 4)
#define BLOCK 16

/* On the device of tests/golden/device the bits are the same: threads and
 * vector widths do not count. Another processor may fuse multiplications where
 * this one does not, so some last bits may differ. */
#define SAME_MEAN 0.05
#define SAME_WORST 3
/* On any other device: sines, filters and roots differ by 1e-4 or so, and
 * specks of glitter move by a pixel. Whole blocks of 16 × 16 px keep their mean
 * to two hundredths, where a wrong sky, water, wave height or horizon moves
 * it by a tenth. */
#define OTHER_MEAN 2.0
#define OTHER_BLOCK 5.0

struct scene {
    const char *name;
    struct pel_sea_desc sea;
    struct pel_water_desc water;
    struct test_look look;
    double sun_elevation, sun_azimuth, visibility_m;
    double (*bed)(double east_m, double north_m); /* NULL: level */
    struct pel_sensor sensor;
    unsigned stale;
    int vision; /* PEL_VISION_* */
    struct {
        double elevation, azimuth, lit;
    } moon; /* lit: 0: none */
};

#define WIND(speed) .wind_mps = (speed), .direction_rad = 0.4
#define REST .fetch_m = 2e5, .gamma = 3.3, .seed = 11, .wave_count = 60
#define FFT .synthesiser = PEL_SYNTHESISER_FFT
#define LOOK(height, heading, pitch, fov)                                      \
    {                                                                          \
        height, heading, pitch, 0.0, fov, WIDTH, HEIGHT                        \
    }
/* Degrees, azimuth clockwise from north; metres. */
#define LIGHT(elevation, azimuth, visibility)                                  \
    .sun_elevation = (elevation), .sun_azimuth = (azimuth),                    \
    .visibility_m = (visibility)
#define DEEP(c)                                                                \
    {                                                                          \
        .chlorophyll_mg_m3 = (c), .depth_m = 1000.0                            \
    }
#define TROPICAL(depth)                                                        \
    {                                                                          \
        .kind = PEL_WATER_NAMED, .name = PEL_WATER_TROPICAL,                   \
        .depth_m = (depth), .bottom = PEL_BOTTOM_SAND                          \
    }

/* A bank at 3 m that falls to 15 m in the east, with caustics. */
static double reef(double east_m, double north_m)
{
    return -3 - fmin(fmax(0.1 * east_m, 0), 12) + 1e-3 * north_m;
}

static const struct scene scenes[] = {
    { "bridge-trochoids",
      { WIND(8), REST },
      DEEP(0.2),
      LOOK(12, 20, -4, 60),
      LIGHT(35, 60, 40e3) },
    { "low-sun-glitter-fft",
      { .kind = PEL_SPECTRUM_JONSWAP, WIND(7), FFT, REST },
      DEEP(0.3),
      LOOK(6, 90, -3, 60),
      LIGHT(8, 92, 40e3) },
    { "lagoon-2m",
      { WIND(2.5), REST },
      { .kind = PEL_WATER_JERLOV,
        .jerlov = PEL_JERLOV_IA,
        .depth_m = 5.0,
        .bottom = PEL_BOTTOM_SAND },
      LOOK(2, 200, -12, 60),
      LIGHT(60, 70, 60e3) },
    { "storm-fft",
      { WIND(22), FFT, REST },
      DEEP(1.0),
      LOOK(15, 110, -4, 60),
      LIGHT(25, 300, 9e3) },
    { "swell-30m",
      { WIND(5), .swell_count = 1, .swell = { { 4.0, 13.0, 1.2, 0.15 } },
        REST },
      DEEP(0.1),
      LOOK(30, 250, -8, 60),
      LIGHT(20, 200, 60e3) },
    { "shallow-tma-300m",
      { .kind = PEL_SPECTRUM_TMA, .depth_m = 12.0, WIND(11), FFT, REST },
      { .kind = PEL_WATER_NAMED,
        .name = PEL_WATER_BALTIC,
        .depth_m = 12.0,
        .bottom = PEL_BOTTOM_MUD },
      LOOK(300, 40, -20, 55),
      LIGHT(45, 160, 30e3) },
    { "glitter-2km",
      { WIND(12), REST },
      DEEP(0.2),
      LOOK(2000, 180, -35, 60),
      LIGHT(40, 180, 80e3) },
    { "horizon-8km-fft",
      { WIND(6), FFT, REST },
      DEEP(0.05),
      LOOK(8000, 270, -8, 70),
      LIGHT(15, 262, 150e3) },
    { "twilight-fft",
      { WIND(5), FFT, REST },
      DEEP(0.3),
      LOOK(10, 285, 4, 65),
      LIGHT(-4, 290, 40e3) },
    { "night-trochoids",
      { WIND(9), REST },
      DEEP(0.3),
      LOOK(10, 285, -2, 65),
      LIGHT(-12, 290, 40e3) },
    { "fog-harbour",
      { WIND(6), REST },
      { .kind = PEL_WATER_NAMED, .name = PEL_WATER_HARBOUR, .depth_m = 15.0 },
      LOOK(8, 0, -3, 60),
      LIGHT(30, 40, 700) },
    { "elfouhaily-nadir-1km",
      { .kind = PEL_SPECTRUM_ELFOUHAILY, WIND(4), FFT, REST },
      DEEP(0.2),
      LOOK(1000, 0, -80, 60),
      LIGHT(70, 20, 100e3) },
    { "island-fft",
      { WIND(6), FFT, REST },
      TROPICAL(400.0),
      LOOK(25, 8, -3, 60),
      LIGHT(35, 120, 40e3),
      .bed = test_island },
    { "bank-caustics-trochoids",
      { WIND(4), REST },
      TROPICAL(1000.0),
      LOOK(12, 60, -30, 50),
      LIGHT(50, 100, 40e3),
      .bed = reef },
    { "sensor-fft",
      { WIND(8), FFT, REST },
      DEEP(0.2),
      LOOK(12, 20, -4, 60),
      LIGHT(35, 60, 40e3),
      .sensor = { PEL_SENSOR_ON, -0.9, 0.95, 0.08, true, 0x12345678 } },
    { "moon-fft",
      { WIND(6), FFT, REST },
      DEEP(0.2),
      LOOK(12, 60, 8, 60),
      LIGHT(-9, 300, 40e3),
      .moon = { 22, 70, 0.7 } },
    { "eye-dusk-fft",
      { WIND(6), FFT, REST },
      DEEP(0.2),
      LOOK(9, 285, -0.5, 5),
      LIGHT(-12, 290, 40e3),
      .vision = PEL_VISION_EYE },
    { "stale-trochoids",
      { WIND(8), REST },
      DEEP(0.2),
      LOOK(12, 200, -4, 60),
      LIGHT(20, 60, 40e3),
      .stale = PEL_STALE_CIGI | PEL_STALE_NMEA },
};
#define SCENES (sizeof scenes / sizeof *scenes)

static bool same_device;

static void draw(const struct scene *scene, uint8_t *rgba)
{
    static struct pel_sea sea;
    struct pel_water_body water;
    assert_int_equal(pel_sea_build(&scene->sea, &sea), PEL_OK);
    struct pel_water_desc desc = scene->water;
    desc.salinity_g_kg = PEL_SALINITY_USUAL;
    desc.temperature_c = PEL_TEMPERATURE_USUAL;
    assert_int_equal(pel_water_resolve(&desc, &water, NULL), PEL_OK);
    struct pel_environment env = test_environment(&sea, 41.5);
    env.lights[PEL_LIGHT_SUN].direction =
        test_sun(scene->sun_elevation, scene->sun_azimuth);
    if (scene->moon.lit > 0) {
        env.lights[PEL_LIGHT_MOON] =
            pel_light_moon(test_sun(scene->moon.elevation, scene->moon.azimuth),
                           env.lights[PEL_LIGHT_SUN].direction, scene->moon.lit,
                           PEL_MOON_DISTANCE);
    }
    env.visibility_m = scene->visibility_m;
    env.water = water;
    env.seabed = scene->bed ? test_bed(scene->bed) : NULL;
    env.caustics = scene->bed != NULL;
    env.sparkle = true;
    env.stale = scene->stale;
    struct pel_camera camera = test_camera(scene->look);
    camera.sensor = scene->sensor;
    camera.vision = scene->vision;
    struct pel_picture *p = test_draw(renderer, &env, &camera, PEL_LAYER_COLOR);
    memcpy(rgba, p->rgba, BYTES);
    pel_picture_release(p);
    pel_seabed_unref(env.seabed);
    pel_sea_finish(&sea);
}

static void path_of(const char *folder, const char *name, const char *ending,
                    char path[256])
{
    snprintf(path, 256, "%s/%s%s", folder, name, ending);
}

static void write_png(const char *path, const uint8_t *rgba)
{
    const struct pel_encode_input in = { .rgba = rgba,
                                         .width = WIDTH,
                                         .height = HEIGHT };
    struct pel_bytes png;
    assert_int_equal(pel_png_encode(&in, &png), PEL_OK);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(png.data, 1, png.size, file) != png.size ||
        fclose(file) != 0) {
        fail_msg("cannot write %s", path);
    }
    pel_bytes_finish(&png);
}

static void read_png(const char *path, uint8_t *rgba)
{
    FILE *file = fopen(path, "rb");
    if (!file) {
        fail_msg("%s is not there: run from the top of the tree, or draw it "
                 "with `make golden`",
                 path);
    }
    spng_ctx *png = spng_ctx_new(0);
    spng_set_png_file(png, file);
    size_t size = 0;
    int err = spng_decoded_image_size(png, SPNG_FMT_RGBA8, &size);
    if (err == 0 && size == BYTES) {
        err = spng_decode_image(png, rgba, BYTES, SPNG_FMT_RGBA8, 0);
    }
    spng_ctx_free(png);
    fclose(file);
    if (err != 0 || size != BYTES) {
        fail_msg("%s is no picture of %d × %d", path, WIDTH, HEIGHT);
    }
}

struct difference {
    double mean, block; /* of all samples; of the means of the worst block */
    int worst;
};

static struct difference compare(const uint8_t *a, const uint8_t *b)
{
    struct difference d = { 0 };
    double blocks[HEIGHT / BLOCK][WIDTH / BLOCK][3] = { 0 };
    for (int i = 0; i < BYTES; i++) {
        if (i % 4 == 3) {
            continue;
        }
        int off = a[i] - b[i], x = i / 4 % WIDTH, y = i / 4 / WIDTH;
        d.mean += abs(off) / (3.0 * WIDTH * HEIGHT);
        d.worst = abs(off) > d.worst ? abs(off) : d.worst;
        blocks[y / BLOCK][x / BLOCK][i % 4] += off / (double)(BLOCK * BLOCK);
    }
    for (int i = 0; i < WIDTH / BLOCK * (HEIGHT / BLOCK) * 3; i++) {
        d.block = fmax(d.block, fabs((&blocks[0][0][0])[i]));
    }
    return d;
}

static void leave_behind(const char *name, const uint8_t *got,
                         const uint8_t *want)
{
    static uint8_t apart[BYTES];
    char path[256];
    mkdir("build", 0777);
    mkdir(FAILED, 0777);
    for (int i = 0; i < BYTES; i++) {
        int off = i % 4 == 3 ? 255 : 10 * abs(got[i] - want[i]);
        apart[i] = (uint8_t)(off > 255 ? 255 : off);
    }
    path_of(FAILED, name, ".png", path);
    write_png(path, got);
    path_of(FAILED, name, "-difference.png", path);
    write_png(path, apart);
}

static void scene_is_golden(void **state)
{
    const struct scene *scene = *state;
    static uint8_t got[BYTES], want[BYTES];
    char path[256];
    draw(scene, got);
    path_of(FOLDER, scene->name, ".png", path);
    read_png(path, want);
    struct difference d = compare(got, want);
    bool good = same_device ? d.mean <= SAME_MEAN && d.worst <= SAME_WORST
                            : d.mean <= OTHER_MEAN && d.block <= OTHER_BLOCK;
    print_message("%s: mean %.3f, block %.2f, worst %d of 255%s\n", scene->name,
                  d.mean, d.block, d.worst,
                  same_device ? "" : " (another device)");
    if (!good) {
        leave_behind(scene->name, got, want);
        fail_msg("%s is not what it was: see " FAILED "; if it is better now, "
                 "look at it and `make golden`",
                 scene->name);
    }
}

/* The other way of shading, too, keeps to what is asked of another device. */
static void compute_is_golden(void **state)
{
    (void)state;
    static uint8_t got[BYTES], want[BYTES];
    char path[256];
    pel_renderer_destroy(renderer);
    renderer = test_renderer("compute");
    for (int i = 0; i < 2; i++) {
        draw(&scenes[i], got);
        path_of(FOLDER, scenes[i].name, ".png", path);
        read_png(path, want);
        struct difference d = compare(got, want);
        print_message("%s by compute: mean %.3f, block %.2f\n", scenes[i].name,
                      d.mean, d.block);
        if (d.mean > OTHER_MEAN || d.block > OTHER_BLOCK) {
            leave_behind(scenes[i].name, got, want);
            fail_msg("%s by compute differs", scenes[i].name);
        }
    }
}

/* A comparison that lets everything pass would be none. */
static void others_are_told_apart(void **state)
{
    (void)state;
    static uint8_t a[BYTES], b[BYTES];
    char path[256];
    int pairs = 0;
    for (size_t i = 0; i < SCENES; i++) {
        for (size_t k = 0; k < i; k++) {
            path_of(FOLDER, scenes[i].name, ".png", path);
            read_png(path, a);
            path_of(FOLDER, scenes[k].name, ".png", path);
            read_png(path, b);
            struct difference d = compare(a, b);
            assert_true(d.mean > OTHER_MEAN || d.block > OTHER_BLOCK);
            pairs++;
        }
    }
    assert_int_equal(pairs, SCENES * (SCENES - 1) / 2);
}

static void read_device(void)
{
    char line[256] = "";
    FILE *file = fopen(FOLDER "/device", "r");
    if (file) {
        same_device = fgets(line, sizeof line, file) != NULL;
        fclose(file);
    }
    line[strcspn(line, "\n")] = '\0';
    same_device = strcmp(line, pel_renderer_description(renderer)) == 0;
}

static int set_up(void **state)
{
    (void)state;
    renderer = test_renderer("fragment");
    read_device();
    return 0;
}

static int write_all(void)
{
    static uint8_t rgba[BYTES];
    char path[256];
    renderer = test_renderer("fragment");
    for (size_t i = 0; i < SCENES; i++) {
        draw(&scenes[i], rgba);
        path_of(FOLDER, scenes[i].name, ".png", path);
        write_png(path, rgba);
        printf("%s\n", path);
    }
    FILE *file = fopen(FOLDER "/device", "w");
    if (!file ||
        fprintf(file, "%s\n", pel_renderer_description(renderer)) < 0 ||
        fclose(file) != 0) {
        return 1;
    }
    pel_renderer_destroy(renderer);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--write") == 0) {
        return write_all();
    }
    struct CMUnitTest tests[SCENES + 2];
    for (size_t i = 0; i < SCENES; i++) {
        tests[i] = (struct CMUnitTest){ .name = scenes[i].name,
                                        .test_func = scene_is_golden,
                                        .initial_state = (void *)&scenes[i] };
    }
    tests[SCENES] = (struct CMUnitTest)cmocka_unit_test(others_are_told_apart);
    tests[SCENES + 1] = (struct CMUnitTest)cmocka_unit_test(compute_is_golden);
    return cmocka_run_group_tests(tests, set_up, end_renderer);
}
