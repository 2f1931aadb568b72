/* Files of heights, read by pelagos-seabed and placed in the scene. Files are
 * made here; what other programs write is read in tests/seabed_test.py. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/vec.h"
#include "scene/geodesy.h"
#include "scene/missing.h"
#include "scene/scene_testkit.h"

static char folder[] = "/tmp/pelagos-ground-XXXXXX";

static FILE *open_file(const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    return file;
}

/* A plane over degrees: 100 m a degree east, -300 m a degree north, -12 m at
 * 52.6 N, 5.2 E. */
static double plane(double lat, double lon)
{
    return -12 + 100 * (lon - 5.2) - 300 * (lat - 52.6);
}

/* An Esri grid of 160 × 120 cells of 1/960° about that place. */
static void write_grid(const char *name, double sign, double none_above)
{
    const int columns = 160, rows = 120;
    const double cell = 1.0 / 960, west = 5.2 - 80 * cell,
                 south = 52.6 - 60 * cell;
    FILE *f = open_file(name);
    fprintf(f,
            "ncols %d\nnrows %d\nxllcorner %.12f\nyllcorner %.12f\n"
            "cellsize %.12f\nNODATA_value -9999\n",
            columns, rows, west, south, cell);
    for (int y = rows - 1; y >= 0; y--) {
        for (int x = 0; x < columns; x++) {
            double h = plane(south + (y + 0.5) * cell, west + (x + 0.5) * cell);
            fprintf(f, "%.6f ", h > none_above ? -9999 : sign * h);
        }
        fprintf(f, "\n");
    }
    fclose(f);
}

static int write_files(void **state)
{
    (void)state;
    if (!mkdtemp(folder)) {
        return -1;
    }
    write_grid("shore.asc", 1, 1e9);
    write_grid("depths.asc", -1, 1e9);
    write_grid("holes.asc", 1, -10);
    fputs("no raster", open_file("text.tif"));
    return 0;
}

static int remove_files(void **state)
{
    (void)state;
    char command[300];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command);
}

static struct pel_scene *make(const char *state_path, const char *directory)
{
    return make_scene((struct pel_scene_options){
        .state_path = state_path, .wave_count = 60, .bathymetry = directory });
}

static double depth_at(struct pel_scene *scene, double lat, double lon)
{
    const Pelagos__Origin *o = pel_scene_state(scene)->origin;
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    double east_m, north_m;
    pel_geo_to_local(o->latitude, o->longitude, lat, lon, &east_m, &north_m);
    double depth_m = pel_snapshot_depth(s, east_m, north_m);
    pel_snapshot_unref(s);
    return depth_m;
}

/* Two bilinear resamplings of a plane: what is left is that meridians
 * converge within a cell, and decimals of the file. */
#define NEAR_M 0.002

static void check_plane(struct pel_scene *scene, double offset_m)
{
    for (int i = 0; i < 60; i++) {
        double lat = 52.6 + 0.05 * sin(2.0 * i);
        double lon = 5.2 + 0.07 * sin(3.0 * i + 1);
        double depth_m = depth_at(scene, lat, lon);
        if (!(fabs(depth_m + plane(lat, lon) + offset_m) < NEAR_M)) {
            fail_msg("%f %f: %f m, not %f m", lat, lon, depth_m,
                     -plane(lat, lon) - offset_m);
        }
    }
}

static void a_file_is_placed_by_its_georeference(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL, folder);
    must(scene, "{\"seabed\":{\"file\":\"shore.asc\"}}");
    check_plane(scene, 0);
    assert_true(isnan(depth_at(scene, 52.7, 5.2)));
    must(scene, "{\"seabed\":{\"offset\":-1.25}}");
    check_plane(scene, -1.25);
    must(scene, "{\"seabed\":{\"file\":\"depths.asc\",\"values\":\"DEPTH\","
                "\"offset\":0}}");
    check_plane(scene, 0);
    pel_scene_destroy(scene);
}

static void it_stays_in_place_when_the_origin_moves(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL, folder);
    must(scene, "{\"seabed\":{\"file\":\"shore.asc\"}}");
    must(scene, "{\"origin\":{\"latitude\":52.9,\"longitude\":6.1}}");
    check_plane(scene, 0);
    struct pel_fault fault;
    assert_int_equal(patch(scene, "{\"origin\":{\"latitude\":40}}", &fault),
                     PEL_ERR_INVALID);
    assert_non_null(strstr(fault.message, "km from the scene's origin"));
    check_plane(scene, 0);
    pel_scene_destroy(scene);
}

static void where_there_is_no_data_there_is_no_depth(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL, folder);
    must(scene, "{\"seabed\":{\"file\":\"holes.asc\"}}");
    assert_true(fabs(depth_at(scene, 52.61, 5.19) - -plane(52.61, 5.19)) <
                NEAR_M);
    assert_true(isnan(depth_at(scene, 52.58, 5.21))); /* -4 m in the file */
    pel_scene_destroy(scene);
}

static void without_a_file_it_is_flat(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL, NULL);
    must(scene, "{\"water\":{\"depth\":17}}");
    assert_true(depth_at(scene, 52.6, 5.2) == 17);
    must(scene, "{\"seabed\":{\"file\":\"\"}}");
    pel_scene_destroy(scene);
}

static void put(FILE *f, const char *name, const char *type, int size,
                const void *value)
{
    fwrite(name, 1, strlen(name) + 1, f);
    fwrite(type, 1, strlen(type) + 1, f);
    fwrite(&size, 4, 1, f);
    fwrite(value, 1, (size_t)size, f);
}

/* An OpenEXR of 40 × 30 floats in channel Y, not compressed, byte by byte as
 * the format's description has it. */
static void write_exr(const char *name)
{
    static const char channels[] = "Y\0\2\0\0\0\0\0\0\0\1\0\0\0\1\0\0\0";
    const int window[] = { 0, 0, 39, 29 };
    const float one = 1, middle[] = { 0, 0 };
    FILE *f = open_file(name);
    fwrite("\x76\x2f\x31\x01\2\0\0\0", 1, 8, f);
    put(f, "channels", "chlist", sizeof channels, channels);
    put(f, "compression", "compression", 1, "");
    put(f, "dataWindow", "box2i", 16, window);
    put(f, "displayWindow", "box2i", 16, window);
    put(f, "lineOrder", "lineOrder", 1, "");
    put(f, "pixelAspectRatio", "float", 4, &one);
    put(f, "screenWindowCenter", "v2f", 8, middle);
    put(f, "screenWindowWidth", "float", 4, &one);
    fputc(0, f);
    long long first = ftell(f) + 30 * 8;
    for (int y = 0; y < 30; y++) {
        long long at = first + y * (8 + 160);
        fwrite(&at, 8, 1, f);
    }
    for (int y = 0; y < 30; y++) {
        const int head[] = { y, 160 };
        fwrite(head, 4, 2, f);
        for (int x = 0; x < 40; x++) {
            float height = (float)(-3 + 0.125 * x - 0.25 * y);
            fwrite(&height, 4, 1, f);
        }
    }
    fclose(f);
}

static void an_exr_is_placed_by_the_schema(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL, folder);
    struct pel_fault fault;
    write_exr("pit.exr");
    assert_int_equal(
        patch(scene, "{\"seabed\":{\"file\":\"pit.exr\"}}", &fault),
        PEL_ERR_INVALID);
    assert_non_null(strstr(fault.message, "seabed.spacing"));
    assert_int_equal(patch(scene,
                           "{\"seabed\":{\"file\":\"pit.exr\",\"spacing\":2}}",
                           &fault),
                     PEL_ERR_INVALID);
    assert_non_null(strstr(fault.message, "latitude, longitude and spacing"));
    must(scene, "{\"seabed\":{\"file\":\"pit.exr\",\"latitude\":52.6,"
                "\"longitude\":5.2,\"spacing\":2}}");
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    /* Column x lies 2 (x − 19.5) m east, row y 2 (14.5 − y) m north. */
    for (int x = 1; x < 39; x += 5) {
        for (int y = 1; y < 29; y += 4) {
            double depth =
                pel_snapshot_depth(s, 2 * (x - 19.5), 2 * (14.5 - y));
            assert_true(fabs(depth - (3 - 0.125 * x + 0.25 * y)) < 1e-4);
        }
    }
    assert_true(isnan(pel_snapshot_depth(s, 41, 0)));
    pel_snapshot_unref(s);
    pel_scene_destroy(scene);
}

static void refusals_say_why_and_change_nothing(void **state)
{
    (void)state;
    static const struct {
        const char *json, *words;
    } cases[] = {
        { "{\"seabed\":{\"file\":\"none.tif\"}}", "no such file" },
        { "{\"seabed\":{\"file\":\"../shore.asc\"}}", "without /" },
        { "{\"seabed\":{\"file\":\".hidden\"}}", "name of a file" },
        { "{\"seabed\":{\"file\":\"text.tif\"}}", "no raster that is read" },
        { "{\"seabed\":{\"offset\":101}}", "-100 to 100 m" },
        { "{\"seabed\":{\"spacing\":0}}", "0.1 to 10000 m" },
    };
    struct pel_scene *scene = make(NULL, folder);
    must(scene, "{\"seabed\":{\"file\":\"shore.asc\"}}");
    uint64_t revision = pel_scene_state(scene)->revision;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct pel_fault fault;
        assert_int_not_equal(patch(scene, cases[i].json, &fault), PEL_OK);
        if (!strstr(fault.message, cases[i].words) ||
            strncmp(fault.path, "seabed", 6) != 0) {
            fail_msg("%s: %s: %s", cases[i].json, fault.path, fault.message);
        }
    }
    assert_true(pel_scene_state(scene)->revision == revision);
    check_plane(scene, 0);
    pel_scene_destroy(scene);
    scene = make(NULL, NULL);
    struct pel_fault fault;
    assert_int_equal(
        patch(scene, "{\"seabed\":{\"file\":\"shore.asc\"}}", &fault),
        PEL_ERR_CONFLICT);
    assert_non_null(strstr(fault.message, "--bathymetry"));
    pel_scene_destroy(scene);
}

static void a_restart_reads_it_again_or_goes_on_without(void **state)
{
    (void)state;
    char path[256], old[256], new[256];
    snprintf(path, sizeof path, "%s/state", folder);
    snprintf(old, sizeof old, "%s/moved.asc", folder);
    snprintf(new, sizeof new, "%s/gone.asc", folder);
    write_grid("moved.asc", 1, 1e9);
    struct pel_scene *scene = make(path, folder);
    must(scene, "{\"seabed\":{\"file\":\"moved.asc\"}}");
    pel_scene_destroy(scene);
    scene = make(path, folder);
    check_plane(scene, 0);
    pel_scene_destroy(scene);
    assert_int_equal(rename(old, new), 0);
    scene = make(path, folder);
    assert_null(pel_scene_state(scene)->seabed->file);
    const struct pel_missing *missing = pel_scene_missing(scene);
    assert_string_equal(missing->fields[PEL_MISSING_SEABED].name, "moved.asc");
    assert_non_null(
        strstr(missing->fields[PEL_MISSING_SEABED].reason, "no such file"));
    /* Other edits leave it in the file: it may come back. */
    must(scene, "{\"seabed\":{\"offset\":0.5},\"sea\":{\"seed\":77}}");
    pel_scene_destroy(scene);
    assert_int_equal(rename(new, old), 0);
    scene = make(path, folder);
    assert_string_equal(pel_scene_state(scene)->seabed->file, "moved.asc");
    assert_int_equal(pel_scene_state(scene)->sea->seed, 77);
    check_plane(scene, 0.5);
    pel_scene_destroy(scene);
    /* One that says it anew is obeyed. */
    assert_int_equal(rename(old, new), 0);
    scene = make(path, folder);
    must(scene, "{\"seabed\":{\"file\":null}}");
    assert_null(pel_scene_missing(scene)->fields[PEL_MISSING_SEABED].name);
    pel_scene_destroy(scene);
    assert_int_equal(rename(new, old), 0);
    scene = make(path, folder);
    assert_null(pel_scene_state(scene)->seabed->file);
    pel_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_is_placed_by_its_georeference),
        cmocka_unit_test(it_stays_in_place_when_the_origin_moves),
        cmocka_unit_test(where_there_is_no_data_there_is_no_depth),
        cmocka_unit_test(without_a_file_it_is_flat),
        cmocka_unit_test(an_exr_is_placed_by_the_schema),
        cmocka_unit_test(refusals_say_why_and_change_nothing),
        cmocka_unit_test(a_restart_reads_it_again_or_goes_on_without),
    };
    return cmocka_run_group_tests(tests, write_files, remove_files);
}
