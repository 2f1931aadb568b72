#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "scene/numbers.h"
#include "scene/scene_testkit.h"

static struct pel_scene *make(const char *state_path, const char *spectra)
{
    return make_scene((struct pel_scene_options){
        .state_path = state_path, .wave_count = 60, .spectra = spectra });
}

static double significant_height(struct pel_scene *scene)
{
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    double hs = 4 * sqrt(pel_snapshot_sea(s)->m0);
    pel_snapshot_unref(s);
    return hs;
}

static void the_wind_has_other_names(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL, NULL);
    must(scene, "{\"sea\":{\"beaufort\":5}}");
    const Pelagos__Sea *sea = pel_scene_state(scene)->sea;
    assert_true(fabs(sea->wind_speed - 0.836 * pow(5, 1.5)) < 1e-12);
    assert_false(sea->has_beaufort);
    /* WMO's ranges at 10 m, knots made m/s with one decimal. */
    static const double ranges[][2] = { { 0.3, 1.5 },   { 1.6, 3.3 },
                                        { 3.4, 5.4 },   { 5.5, 7.9 },
                                        { 8.0, 10.7 },  { 10.8, 13.8 },
                                        { 13.9, 17.1 }, { 17.2, 20.7 },
                                        { 20.8, 24.4 }, { 24.5, 28.4 } };
    for (int b = 1; b <= 10; b++) {
        char json[64];
        snprintf(json, sizeof json, "{\"sea\":{\"beaufort\":%d}}", b);
        must(scene, json);
        double wind = pel_scene_state(scene)->sea->wind_speed;
        assert_true(wind > ranges[b - 1][0] && wind < ranges[b - 1][1]);
    }
    /* Degrees of Douglas: within WMO code table 3700. */
    static const double heights[][2] = { { 0.0, 0.1 },  { 0.1, 0.5 },
                                         { 0.5, 1.25 }, { 1.25, 2.5 },
                                         { 2.5, 4.0 },  { 4.0, 6.0 },
                                         { 6.0, 9.0 } };
    for (int d = 1; d <= 7; d++) {
        char json[64];
        snprintf(json, sizeof json, "{\"sea\":{\"douglas\":%d}}", d);
        must(scene, json);
        double hs = significant_height(scene);
        assert_true(hs > heights[d - 1][0] && hs < heights[d - 1][1]);
    }
    static const char *const spectra[] = { "PIERSON_MOSKOWITZ", "JONSWAP",
                                           "TMA", "ELFOUHAILY", "OMEGA2" };
    for (int i = 0; i < 5; i++) {
        char json[128];
        snprintf(json, sizeof json,
                 "{\"sea\":{\"douglas\":3,\"spectrum\":\"%s\"}}", spectra[i]);
        must(scene, json);
        sea = pel_scene_state(scene)->sea;
        assert_false(sea->has_douglas);
        double hs = significant_height(scene);
        print_message("Douglas 3, %s: wind %.1f m/s, Hs %.3f m\n", spectra[i],
                      sea->wind_speed, hs);
        /* Of the band that is drawn; the middle of 0.5 to 1.25 m. */
        assert_true(fabs(hs - 0.875) < 0.01);
    }
    struct pel_fault fault;
    assert_int_equal(patch(scene, "{\"sea\":{\"beaufort\":11}}", &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "sea.beaufort");
    assert_int_equal(
        patch(scene, "{\"sea\":{\"beaufort\":3,\"douglas\":3}}", &fault),
        PEL_ERR_CONFLICT);
    assert_true(
        fabs(pel_scene_state(scene)->sea->wind_speed - sea->wind_speed) == 0);
    pel_scene_destroy(scene);
}

static void every_spectrum_has_its_sea(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL, NULL);
    must(scene, "{\"sea\":{\"spectrum\":\"TMA\",\"depth\":6,"
                "\"windSpeed\":15}}");
    double shallow = significant_height(scene);
    must(scene, "{\"sea\":{\"depth\":null}}");
    assert_true(shallow < 0.8 * significant_height(scene));
    must(scene, "{\"sea\":{\"synthesiser\":\"FFT\"}}");
    const struct pel_snapshot *fft = pel_scene_snapshot(scene);
    assert_non_null(pel_snapshot_sea(fft)->cascades);
    must(scene, "{\"water\":{\"chlorophyll\":1}}");
    const struct pel_snapshot *same = pel_scene_snapshot(scene);
    assert_ptr_equal(fft->sea, same->sea);
    must(scene, "{\"sea\":{\"synthesiser\":\"TROCHOIDS\",\"windSpeed\":0,"
                "\"wave\":[{\"height\":2,\"period\":9}]}}");
    assert_true(fabs(significant_height(scene) - 4 * sqrt(0.5)) < 1e-9);
    must(scene, "{\"sea\":{\"windSpeed\":8,\"wave\":[]}}");
    const struct pel_snapshot *other = pel_scene_snapshot(scene);
    assert_null(pel_snapshot_sea(other)->cascades);
    assert_int_equal(pel_snapshot_sea(other)->count, 60);
    pel_snapshot_unref(fft);
    pel_snapshot_unref(same);
    pel_snapshot_unref(other);
    pel_scene_destroy(scene);
}

/* A buoy's files, as NDBC has them: one record of three frequencies. */
static void put_station(const char *folder)
{
    static const char *const files[][2] = {
        { "data_spec", "0.2 0.500 (0.100) 1.250 (0.200) 0.030 (0.300)" },
        { "swdir", "90.0 (0.100) 180.0 (0.200) 170.0 (0.300)" },
        { "swdir2", "90.0 (0.100) 190.0 (0.200) 170.0 (0.300)" },
        { "swr1", "0.50 (0.100) 0.60 (0.200) 0.40 (0.300)" },
        { "swr2", "0.20 (0.100) 0.30 (0.200) 0.10 (0.300)" },
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[96];
        snprintf(path, sizeof path, "%s/41010.%s", folder, files[i][0]);
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        fprintf(file, "2020 06 08 03 50 %s\n", files[i][1]);
        assert_int_equal(fclose(file), 0);
    }
}

static void remove_station(const char *folder)
{
    static const char *const endings[] = { "data_spec", "swdir", "swdir2",
                                           "swr1", "swr2" };
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        char path[96];
        snprintf(path, sizeof path, "%s/41010.%s", folder, endings[i]);
        unlink(path);
    }
    rmdir(folder);
}

static void areas_become_the_sea(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL, NULL);
    struct pel_fault fault;
    must(scene, "{\"sea\":{\"areas\":[{\"east\":50,\"factor\":0.5},"
                "{\"corners\":\"0 0, 400:0,300.5 -150\",\"course\":90,"
                "\"speed\":3}]}}");
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    const struct pel_sea_desc *d = &pel_snapshot_sea(s)->desc;
    assert_int_equal(d->area_count, 2);
    assert_true(d->area[0].corner_count == 0 && d->area[0].radius_m == 100);
    assert_true(d->area[0].east_m == 50 && d->area[0].factor == 0.5);
    assert_int_equal(d->area[1].corner_count, 3);
    assert_true(d->area[1].corner[2].x == 300.5 &&
                d->area[1].corner[2].y == -150);
    assert_true(fabs(d->area[1].velocity_east_mps - 3) < 1e-12 &&
                fabs(d->area[1].velocity_north_mps) < 1e-12);
    pel_snapshot_unref(s);
    static const char *const wrong[] = { "0 0, 1 1", "0 0, 1 1, 2",
                                         "0 0; 1 1; 2 5", "nan 0, 1 1, 2 2",
                                         "0 0, 1 1, 9e9 2" };
    for (int i = 0; i < 5; i++) {
        char json[96];
        snprintf(json, sizeof json,
                 "{\"sea\":{\"areas\":[{\"corners\":\"%s\"}]}}", wrong[i]);
        assert_int_equal(patch(scene, json, &fault), PEL_ERR_INVALID);
        assert_string_equal(fault.path, "sea.areas.0.corners");
    }
    assert_int_equal(
        patch(scene, "{\"sea\":{\"areas\":[{\"factor\":3}]}}", &fault),
        PEL_ERR_OUT_OF_RANGE);
    must(scene, "{\"sea\":{\"areas\":[]}}");
    s = pel_scene_snapshot(scene);
    assert_int_equal(pel_snapshot_sea(s)->desc.area_count, 0);
    pel_snapshot_unref(s);
    pel_scene_destroy(scene);
}

static void a_buoy_becomes_the_sea(void **state)
{
    (void)state;
    struct pel_fault fault;
    struct pel_scene *scene = make(NULL, NULL);
    assert_int_equal(
        patch(scene, "{\"sea\":{\"spectrum\":\"MEASURED\"}}", &fault),
        PEL_ERR_CONFLICT); /* no directory */
    pel_scene_destroy(scene);
    char buoys[] = "/tmp/pelagos-buoys-XXXXXX";
    assert_non_null(mkdtemp(buoys));
    put_station(buoys);
    char path[] = "/tmp/pelagos-seas-XXXXXX";
    close(mkstemp(path));
    unlink(path);
    scene = make(path, buoys);
    must(scene, "{\"sea\":{\"spectrum\":\"MEASURED\",\"measured\":\"41010\","
                "\"measuredTime\":\"2020-06-08T03:40:00Z\"}}");
    /* Trapezoids over the band, and a tail above it that goes on as f^-5 from
     * so little that it adds less than 1 %. */
    double m0 = 0.1 * (0.5 * (0.5 + 1.25) + 0.5 * (1.25 + 0.03));
    assert_true(fabs(significant_height(scene) - 4 * sqrt(m0)) < 0.04);
    const struct pel_snapshot *before = pel_scene_snapshot(scene);
    must(scene, "{\"sea\":{\"gamma\":2}}");
    assert_true(significant_height(scene) ==
                4 * sqrt(pel_snapshot_sea(before)->m0));
    pel_snapshot_unref(before);
    assert_int_equal(
        patch(scene, "{\"sea\":{\"measured\":\"../41010\"}}", &fault),
        PEL_ERR_INVALID);
    assert_string_equal(fault.path, "sea.measured");
    assert_int_equal(patch(scene,
                           "{\"sea\":{\"measuredTime\":"
                           "\"2021-06-08T03:40:00Z\"}}",
                           &fault),
                     PEL_ERR_NOT_FOUND);
    assert_int_equal(
        patch(scene, "{\"sea\":{\"measuredTime\":\"noon\"}}", &fault),
        PEL_ERR_INVALID);
    assert_string_equal(fault.path, "sea.measuredTime");
    pel_scene_destroy(scene);

    /* Kept over a restart; without its files the scene still starts. */
    scene = make(path, buoys);
    assert_int_equal(pel_scene_state(scene)->sea->spectrum,
                     PELAGOS__SPECTRUM_KIND__MEASURED);
    pel_scene_destroy(scene);
    scene = make(path, NULL);
    assert_int_equal(pel_scene_state(scene)->sea->spectrum,
                     PELAGOS__SPECTRUM_KIND__PIERSON_MOSKOWITZ);
    pel_scene_destroy(scene);
    unlink(path);
    remove_station(buoys);
}

static Pelagos__Spectrum *ask(struct pel_scene *scene,
                              const Pelagos__SpectrumQuery *query)
{
    Pelagos__Spectrum *out;
    struct pel_fault fault;
    if (pel_scene_spectrum(scene, query, &out, &fault)) {
        fail_msg("%s", fault.message);
    }
    return out;
}

/* The numbers are those of the sea that is drawn, and of its spectrum. */
static void the_sea_has_numbers(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL, NULL);
    must(scene, "{\"sea\":{\"spectrum\":\"JONSWAP\",\"windSpeed\":11,"
                "\"windDirection\":200}}");
    Pelagos__SpectrumQuery query = PELAGOS__SPECTRUM_QUERY__INIT;
    query.has_wavelength = query.has_frequencies = query.has_directions = true;
    query.wavelength = 2;
    query.frequencies = 200;
    query.directions = 72;
    query.lowest = 0.3;
    query.highest = 20;
    Pelagos__Spectrum *s = ask(scene, &query);
    const struct pel_snapshot *now = pel_scene_snapshot(scene);
    double hs = significant_height(scene);
    assert_true(fabs(s->drawn->significant_height - hs) < 1e-12);
    assert_true(fabs(s->spectrum->significant_height - hs) < 1e-3 * hs);
    assert_true(s->drawn->slope_along ==
                pel_snapshot_sea(now)->slope_variance_along);
    assert_true(fabs(s->drawn_below->significant_height -
                     4 * pel_sea_rms_below(pel_snapshot_sea(now), 2)) < 1e-12);
    assert_true(s->drawn_below->slope_along < s->drawn->slope_along);
    assert_true(fabs(s->mean_direction - 200) < 1e-6);
    pel_snapshot_unref(now);
    /* Tp = 2π/ω_p of JONSWAP: 22 (g²/(U F))^(1/3). */
    double peak = 22 * cbrt(9.81 * 9.81 / (11 * 2e5));
    assert_true(fabs(s->peak_period - 2 * 3.14159265 / peak) < 0.01);
    double sum = 0, all = 0, step = log(20 / 0.3) / 199;
    for (size_t i = 0; i < s->n_rows; i++) {
        const Pelagos__SpectrumRow *r = s->rows[i];
        assert_int_equal(r->n_directional, 72);
        sum += r->omega * r->density * step;
        for (size_t k = 0; k < 72; k++) {
            all += r->omega * r->directional[k] * step * 3.14159265 / 36;
        }
    }
    assert_true(fabs(4 * sqrt(sum) - hs) < 0.01 * hs);
    assert_true(fabs(all - sum) < 1e-3 * sum);
    pelagos__spectrum__free_unpacked(s, NULL);
    pel_scene_destroy(scene);
}

/* Another sea is asked about and not made. */
static void numbers_change_nothing(void **state)
{
    (void)state;
    struct pel_scene *scene = make(NULL, NULL);
    double hs = significant_height(scene);
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State with = PELAGOS__STATE__INIT;
    Pelagos__Sea sea = PELAGOS__SEA__INIT;
    patch.state = &with;
    with.sea = &sea;
    sea.has_wind_speed = sea.has_synthesiser = true;
    sea.wind_speed = 16;
    sea.synthesiser = PELAGOS__SYNTHESISER__FFT;
    Pelagos__SpectrumQuery query = PELAGOS__SPECTRUM_QUERY__INIT;
    query.patch = &patch;
    Pelagos__Spectrum *s = ask(scene, &query);
    assert_true(s->drawn->significant_height > 3 * hs);
    assert_true(fabs(s->drawn->significant_height -
                     s->spectrum->significant_height) < 0.02 * hs);
    assert_int_equal(s->n_rows, 0);
    assert_null(s->drawn_below);
    pelagos__spectrum__free_unpacked(s, NULL);
    assert_true(significant_height(scene) == hs);
    assert_true(pel_scene_state(scene)->sea->wind_speed == 8);
    sea.wind_speed = 31;
    struct pel_fault fault;
    assert_int_equal(pel_scene_spectrum(scene, &query, &s, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "sea.windSpeed");
    sea.wind_speed = 0;
    s = ask(scene, &query);
    assert_true(s->drawn->significant_height == 0);
    assert_false(s->has_peak_period);
    pelagos__spectrum__free_unpacked(s, NULL);
    pel_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_wind_has_other_names),
        cmocka_unit_test(every_spectrum_has_its_sea),
        cmocka_unit_test(areas_become_the_sea),
        cmocka_unit_test(a_buoy_becomes_the_sea),
        cmocka_unit_test(the_sea_has_numbers),
        cmocka_unit_test(numbers_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
