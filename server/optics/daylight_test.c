/* Colours from three wavelengths against colours from sixteen: the sky at each
 * of these by the same transport, ozone by another's measurement, and the
 * standard observer's own table instead of a fit. */
#include "optics/daylight.h"

#include "base/near.h"
#include "base/vec.h"
#include "optics/atmosphere.h"
#include "optics/colour.h"

#define WAVES 18 /* the last two only fill the last three */

/* 400, 420 .. 700 nm: CIE 1931, 2 deg. */
static const double observer[WAVES][3] = {
    { 0.01431, 0.000396, 0.06785 }, { 0.13438, 0.0040, 0.64560 },
    { 0.34828, 0.0230, 1.74706 },   { 0.29080, 0.0600, 1.66920 },
    { 0.09564, 0.13902, 0.81295 },  { 0.00490, 0.3230, 0.27200 },
    { 0.06327, 0.7100, 0.07825 },   { 0.29040, 0.9540, 0.02030 },
    { 0.59450, 0.9950, 0.00390 },   { 0.91630, 0.8700, 0.00165 },
    { 1.06220, 0.6310, 0.00080 },   { 0.85445, 0.3810, 0.00019 },
    { 0.44790, 0.1750, 0.00002 },   { 0.16490, 0.0610, 0.0 },
    { 0.04677, 0.0170, 0.0 },       { 0.01136, 0.0041, 0.0 },
};
/* Absorption by ozone, 1/cm at normal conditions (Leckner 1978); that of 550 nm
 * is 0.085. */
static const double ozone[WAVES] = { 0,     0,     0.003, 0.006, 0.014, 0.030,
                                     0.048, 0.075, 0.103, 0.120, 0.125, 0.105,
                                     0.079, 0.057, 0.036, 0.023 };
#define OZONE_550 0.085

#define SUNS 4
#define VIEWS 5
static const double suns[SUNS] = { -6, -3, 2, 30 };
static const double views[VIEWS] = { 3, 15, 45, 90, 135 };
static double light[WAVES][SUNS][VIEWS], three[3][SUNS][VIEWS];

static struct pel_vec3 upwards(double degrees)
{
    return (struct pel_vec3){ 0, cos(degrees * PEL_DEG),
                              sin(degrees * PEL_DEG) };
}

static void see(const struct pel_atmosphere *a, double (*r)[VIEWS],
                double (*g)[VIEWS], double (*b)[VIEWS])
{
    for (int s = 0; s < SUNS; s++) {
        for (int v = 0; v < VIEWS; v++) {
            struct pel_rgb l =
                pel_atmosphere_sky(a, 5.0, upwards(views[v]), upwards(suns[s]));
            r[s][v] = l.r;
            g[s][v] = l.g;
            b[s][v] = l.b;
        }
    }
}

static double sun_at(double nm)
{
    double x = (nm - PEL_DAYLIGHT_FIRST_NM) / PEL_DAYLIGHT_STEP_NM;
    int i = (int)x;
    return pel_sun_spectrum[i] +
           (x - i) * (pel_sun_spectrum[i + 1] - pel_sun_spectrum[i]);
}

static void sixteen_skies(void)
{
    struct pel_atmosphere base, a;
    const struct pel_atmosphere_desc desc = { 40000.0 };
    pel_atmosphere_init(&desc, &base);
    a = base;
    assert_int_equal(pel_atmosphere_tabulate(&a, NULL, NULL), PEL_OK);
    see(&a, three[0], three[1], three[2]);
    pel_atmosphere_finish(&a);
    for (int i = 0; i < WAVES; i += 3) {
        a = base;
        double *at[3][3] = {
            { &a.rayleigh.r, &a.rayleigh.g, &a.rayleigh.b },
            { &a.ozone.r, &a.ozone.g, &a.ozone.b },
            { &a.solar_irradiance.r, &a.solar_irradiance.g,
              &a.solar_irradiance.b },
        };
        for (int c = 0; c < 3; c++) {
            double nm = 400 + 20 * (i + c);
            *at[0][c] = base.rayleigh.g * pow(550 / nm, 4);
            *at[1][c] = base.ozone.g * ozone[i + c] / OZONE_550;
            *at[2][c] = sun_at(nm);
        }
        assert_int_equal(pel_atmosphere_tabulate(&a, NULL, NULL), PEL_OK);
        see(&a, light[i], light[i + 1], light[i + 2]);
        pel_atmosphere_finish(&a);
    }
}

static void to_rec709(const double xyz[3], double out[3])
{
    out[0] = 3.2404542 * xyz[0] - 1.5371385 * xyz[1] - 0.4985314 * xyz[2];
    out[1] = -0.9692660 * xyz[0] + 1.8760108 * xyz[1] + 0.0415560 * xyz[2];
    out[2] = 0.0556434 * xyz[0] - 0.2040259 * xyz[1] + 1.0572252 * xyz[2];
}

/* Red is the hardest, as 680 nm shows little of what 600 nm has: +45 % at 3 and
 * +80 % at 6 deg below the horizon if the Sun's own spectrum is taken between
 * the samples, which makes a dusk mauve. */
static void test_skies(void **state)
{
    (void)state;
    sixteen_skies();
    for (int s = 0; s < SUNS; s++) {
        double m[9];
        pel_colour_matrix(sin(suns[s] * PEL_DEG), m);
        for (int v = 0; v < VIEWS; v++) {
            double xyz[3] = { 0 }, want[3], got[3];
            for (int i = 0; i < WAVES; i++) {
                for (int c = 0; c < 3; c++) {
                    xyz[c] += 683 * 20 * observer[i][c] * light[i][s][v];
                }
            }
            to_rec709(xyz, want);
            for (int c = 0; c < 3; c++) {
                got[c] = m[3 * c] * three[0][s][v] +
                         m[3 * c + 1] * three[1][s][v] +
                         m[3 * c + 2] * three[2][s][v];
            }
            double red = got[0] / got[1] / (want[0] / want[1]) - 1;
            double blue = (got[2] / got[1] - want[2] / want[1]) /
                          fmax(want[2] / want[1], 1);
            double green = got[1] / want[1] - 1;
            print_message("Sun %3.0f, view %3.0f: %.2f 1 %.2f, from three %.2f "
                          "1 %.2f: red %+.1f %%, blue %+.1f %%, green %+.1f "
                          "%%\n",
                          suns[s], views[v], want[0] / want[1],
                          want[2] / want[1], got[0] / got[1], got[2] / got[1],
                          100 * red, 100 * blue, 100 * green);
            /* The two measurements of ozone differ by 15 to 25 % beyond 610 nm,
             * which long paths multiply. */
            assert_near(red, 0, suns[s] < -5 ? 0.4 : 0.25);
            assert_near(blue, 0, 0.05);
            assert_near(green, 0, 0.05);
        }
    }
}

/* Where no air is, light is the Sun's: towards high Suns it nearly is. */
static void test_noon(void **state)
{
    (void)state;
    struct pel_daylight noon;
    pel_daylight(1.0, &noon);
    for (int i = 8; i < 34; i++) { /* 445 to 695 nm */
        assert_near(noon.at[i] / noon.sample[1] * 1.850 / pel_sun_spectrum[i],
                    1, 0.08);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_noon),
        cmocka_unit_test(test_skies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
