/* Land and water at places that everybody knows, from Debian's coastlines. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <unistd.h>

#include <cmocka.h>

#include "continents/continents.h"

#define DIRECTORY "/usr/share/gmt-gshhg"

static const struct {
    double latitude, longitude;
    int land;
} places[] = {
    { 48.2, 16.4, 1 },   /* Vienna */
    { 0, -160, 0 },      /* Pacific */
    { -25, 135, 1 },     /* Australia */
    { 72, -40, 1 },      /* Greenland */
    { -89.9, 10, 1 },    /* the South Pole's ice, */
    { -89.9, -170, 1 },  /* east and west of the date line */
    { 89.9, 100, 0 },    /* the Arctic */
    { 67, 179.5, 1 },    /* Chukotka, on either side of the date line */
    { 67, -179.5, 1 },   /* */
    { 60, 179.9, 0 },    /* the Bering Sea */
    { 60, -179.9, 0 },   /* */
    { 42, 51, 0 },       /* the Caspian, a lake */
    { 36.5, 18, 0 },     /* the Ionian Sea */
    { 55.7, 11.0, 0 },   /* the Great Belt */
    { 51.5, -0.1, 1 },   /* London, on both sides of 0° */
    { 51.5, 0.3, 1 },    /* */
    { 5, 0.5, 0 },       /* the Gulf of Guinea */
    { -54.5, -36.5, 1 }, /* South Georgia */
};

static void places_are_known(void **state)
{
    (void)state;
    struct pel_continents *c = NULL;
    struct pel_fault fault = { 0 };
    if (access(DIRECTORY "/binned_GSHHS_l.nc", R_OK)) {
        print_message("no " DIRECTORY ": install gmt-gshhg-low\n");
        skip();
    }
    static const char *const files[] = { "binned_GSHHS_l.nc",
                                         "binned_GSHHS_i.nc" };
    for (int f = 0; f < 2; f++) {
        if (pel_continents_load(DIRECTORY, files[f], &c, &fault)) {
            fail_msg("%s", fault.message);
        }
        double land = 0, all = 0;
        for (int y = 0; y < PEL_CONTINENT_ROWS; y++) {
            double weight =
                sin((y + 0.5) * 3.14159265358979 / PEL_CONTINENT_ROWS);
            for (int x = 0; x < PEL_CONTINENT_COLUMNS; x++) {
                land += weight * c->share[y * PEL_CONTINENT_COLUMNS + x] / 255;
                all += weight;
            }
        }
        print_message("%s: %.2f %% land\n", files[f], 100 * land / all);
        /* 29.2 % with Antarctica's ice and lakes, 0.5 % of these. */
        assert_true(fabs(land / all - 0.289) < 0.005);
        for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
            int x = (int)((places[i].longitude + 180) / 360 *
                          PEL_CONTINENT_COLUMNS),
                y = (int)((places[i].latitude + 90) / 180 * PEL_CONTINENT_ROWS);
            int share = c->share[y * PEL_CONTINENT_COLUMNS + x];
            if (places[i].land != (share > 127)) {
                fail_msg("%g %g: %d", places[i].latitude, places[i].longitude,
                         share);
            }
        }
        pel_continents_free(c);
    }
}

static void files_that_are_none(void **state)
{
    (void)state;
    struct pel_continents *c = NULL;
    struct pel_fault fault = { 0 };
    assert_int_equal(
        pel_continents_load("/usr/share", "nothing.nc", &c, &fault),
        PEL_ERR_NOT_FOUND);
    assert_int_equal(pel_continents_load("/etc", "passwd", &c, &fault),
                     PEL_ERR_INVALID);
}

/* By the rule: each a cover, none brighter than ice or darker than woods, none
 * with an edge. */
static void ground_is_smooth(void **state)
{
    (void)state;
    double before[3] = { 0 };
    for (double latitude = -90; latitude <= 90; latitude += 0.5) {
        for (double longitude = -180; longitude <= 180; longitude += 0.5) {
            double a[3];
            pel_land_albedo(latitude, longitude, a);
            for (int k = 0; k < 3; k++) {
                assert_true(a[k] > 0.02 && a[k] < 0.81);
                assert_true(longitude == -180 || fabs(a[k] - before[k]) < 0.12);
                before[k] = a[k];
            }
        }
        double west[3], east[3];
        pel_land_albedo(latitude, -180, west);
        pel_land_albedo(latitude, 180, east);
        assert_true(fabs(west[1] - east[1]) < 1e-12);
    }
    double sahara[3], congo[3];
    pel_land_albedo(23, 10, sahara);
    pel_land_albedo(0, 22, congo);
    assert_true(sahara[0] > 5 * congo[0] && sahara[0] > 2 * sahara[2]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places_are_known),
        cmocka_unit_test(files_that_are_none),
        cmocka_unit_test(ground_is_smooth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
