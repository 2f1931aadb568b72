#include "ocean/ndbc.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/near.h"
#include "ocean/directional.h"

#define REAL "../shared/data/ndbc"

static const char sample[] =
    "#YY  MM DD hh mm Sep_Freq  < spec_1 (freq_1) ... >\n"
    "2020 06 08 03 50 0.225 0.500 (0.100) 1.250 (0.200) 0.030 (0.300)\n"
    "2020 06 08 02 50 9.999 0.400 (0.100) 1.000 (0.200) 0.020 (0.300)\n";

static void test_parse(void **state)
{
    (void)state;
    double f[PEL_MEASURED_MOST], v[PEL_MEASURED_MOST], at;
    assert_int_equal(pel_ndbc_parse(sample, NAN, true, f, v, &at), 3);
    assert_near(at, 1591588200, 0); /* date -u -d 2020-06-08T03:50 +%s */
    assert_near(v[1], 1.25, 1e-15);
    assert_near(f[2], 0.3, 1e-15);
    assert_int_equal(pel_ndbc_parse(sample, at - 3000, true, f, v, &at), 3);
    assert_near(at, 1591584600, 0);
    assert_near(v[0], 0.4, 1e-15);
    assert_int_equal(pel_ndbc_parse("# only\n\n", NAN, true, f, v, &at), 0);
}

static void test_broken(void **state)
{
    (void)state;
    static const char *const broken[] = {
        "2020 06 08 03 50 0.2 0.5 (0.1) 1.2 0.2)\n",
        "2020 06 08 03 50 0.2 0.5 (0.1",
        "2020 06 08 03 50 0.2 nan (0.1)\n",
        "2020 06 08 03 50 0.2 -0.5 (0.1)\n",
        "2020 13 08 03 50 0.2 0.5 (0.1)\n",
        "2020 06 08 24 50 0.2 0.5 (0.1)\n",
        "2020 06\n",
        "2020 06 08 03 50 0.2 12345678901234567890 (0.1)\n",
        "<html>\n",
    };
    double f[PEL_MEASURED_MOST], v[PEL_MEASURED_MOST], at;
    for (size_t i = 0; i < sizeof broken / sizeof broken[0]; i++) {
        assert_int_equal(pel_ndbc_parse(broken[i], NAN, true, f, v, &at), -1);
    }
    /* More pairs than there is room for. */
    char *text = calloc(1, 4000);
    strcpy(text, "2020 06 08 03 50 0.2");
    for (int i = 0; i <= PEL_MEASURED_MOST; i++) {
        sprintf(text + strlen(text), " 1.0 (%.3f)", 0.01 + 0.001 * i);
    }
    assert_int_equal(pel_ndbc_parse(text, NAN, true, f, v, &at), -1);
    free(text);
}

static void put(const char *directory, const char *ending, const char *text)
{
    char path[256];
    snprintf(path, sizeof path, "%s/X1.%s", directory, ending);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static void test_files(void **state)
{
    (void)state;
    char directory[] = "/tmp/pelagos-ndbc-XXXXXX";
    assert_non_null(mkdtemp(directory));
    put(directory, "data_spec", sample);
    put(directory, "swdir",
        "2020 06 08 03 50 90.0 (0.100) 180.0 (0.200) 999.0 (0.300)\n");
    put(directory, "swdir2",
        "2020 06 08 03 50 90.0 (0.100) 190.0 (0.200) 999.0 (0.300)\n");
    put(directory, "swr1",
        "2020 06 08 03 50 0.50 (0.100) 0.60 (0.200) 999.00 (0.300)\n");
    put(directory, "swr2",
        "2020 06 08 03 50 0.20 (0.100) 0.30 (0.200) 999.00 (0.300)\n");
    struct pel_measured m;
    struct pel_fault fault;
    double at;
    assert_int_equal(pel_ndbc_read(directory, "X1", NAN, &m, &at, &fault),
                     PEL_OK);
    assert_int_equal(m.count, 3);
    assert_near(fabs(m.alpha1_rad[0]), PEL_PI, 1e-12); /* from the east */
    assert_near(m.alpha1_rad[1], PEL_PI / 2, 1e-12);   /* from the south */
    assert_near(m.r1[1], 0.6, 1e-12);
    assert_near(m.r1[2], 0, 0);

    struct pel_measured untouched = m;
    assert_int_equal(
        pel_ndbc_read(directory, "X1", at + 6000, &m, NULL, &fault),
        PEL_ERR_NOT_FOUND);
    assert_int_equal(
        pel_ndbc_read(directory, "X1", at - 3600, &m, NULL, &fault),
        PEL_ERR_NOT_FOUND); /* no directions then */
    assert_int_equal(pel_ndbc_read(directory, "X2", NAN, &m, NULL, &fault),
                     PEL_ERR_NOT_FOUND);
    static const char too_long[] = "123456789012345678901234567890123";
    const char *const names[] = { "", "../X1", "a/b", "X1.swdir", too_long };
    for (size_t i = 0; i < 5; i++) {
        assert_int_equal(
            pel_ndbc_read(directory, names[i], NAN, &m, NULL, &fault),
            PEL_ERR_INVALID);
    }
    put(directory, "swr1",
        "2020 06 08 03 50 1.50 (0.100) 0.60 (0.200) 0.10 (0.300)\n");
    assert_int_equal(pel_ndbc_read(directory, "X1", NAN, &m, NULL, &fault),
                     PEL_ERR_MALFORMED);
    put(directory, "swr1", "2020 06 08 03 50 0.50 (0.100) 0.60 (0.200)\n");
    assert_int_equal(pel_ndbc_read(directory, "X1", NAN, &m, NULL, &fault),
                     PEL_ERR_MALFORMED);
    assert_memory_equal(&m, &untouched, sizeof m);
    static const char *const endings[] = { "data_spec", "swdir", "swdir2",
                                           "swr1", "swr2" };
    for (int i = 0; i < 5; i++) {
        char path[256];
        snprintf(path, sizeof path, "%s/X1.%s", directory, endings[i]);
        unlink(path);
    }
    rmdir(directory);
}

/* Every record of a real buoy becomes a sea whose Hs, over the buoy's band, is
 * the station's own, which is given to 0.1 m. */
static void test_station(void **state)
{
    (void)state;
    FILE *summary = fopen(REAL "/41010.spec", "r");
    if (!summary) {
        print_message("%s is not there: skipped\n", REAL);
        skip();
        return;
    }
    char line[256];
    int seen = 0;
    double worst = 0, sum = 0, tail = 0;
    while (fgets(line, sizeof line, summary)) {
        int y, mo, d, h, mi;
        double hs;
        if (sscanf(line, "%d %d %d %d %d %lf", &y, &mo, &d, &h, &mi, &hs) !=
            6) {
            continue;
        }
        char stamp[64];
        double f[PEL_MEASURED_MOST], v[PEL_MEASURED_MOST], at;
        snprintf(stamp, sizeof stamp, "%d %d %d %d %d 0 1.0 (0.1)", y, mo, d, h,
                 mi);
        pel_ndbc_parse(stamp, NAN, true, f, v, &at);
        struct pel_sea_desc desc = { .kind = PEL_SPECTRUM_MEASURED,
                                     .wave_count = 60 };
        struct pel_fault fault;
        enum pel_err err =
            pel_ndbc_read(REAL, "41010", at, &desc.measured, NULL, &fault);
        if (err == PEL_ERR_NOT_FOUND) {
            continue; /* a summary without its spectrum */
        }
        assert_int_equal(err, PEL_OK);
        struct pel_directional *s;
        assert_int_equal(pel_directional_create(&desc, &s), PEL_OK);
        struct pel_band_moments in, all;
        int last = desc.measured.count - 1;
        double top = 2 * PEL_PI * desc.measured.frequency_hz[last];
        pel_directional_moments(s, 0, top * top / PEL_GRAVITY, &in);
        pel_directional_moments(s, 0, INFINITY, &all);
        double ours = 4 * sqrt(in.m0);
        worst = fmax(worst, fabs(ours - hs));
        sum += ours - hs;
        tail = fmax(tail, sqrt(all.m0 / in.m0) - 1);
        seen++;
        pel_directional_destroy(s);
    }
    fclose(summary);
    print_message("%d records: Hs within %.2f m of the station's, %.3f m on "
                  "average; the tail beyond the buoy's band adds up to %.0f "
                  "%%\n",
                  seen, worst, sum / seen, 100 * tail);
    assert_true(seen > 100);
    /* The summary has one decimal; NDBC's own sum of density times bandwidth is
     * up to 0.10 m and on average 0.018 m away from it. */
    assert_true(worst < 0.12);
    assert_true(fabs(sum / seen) < 0.025);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parse),
        cmocka_unit_test(test_broken),
        cmocka_unit_test(test_files),
        cmocka_unit_test(test_station),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
