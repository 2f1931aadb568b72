#include "ocean/seastate.h"

#include "base/vec.h"
#include "ocean/directional.h"
#include "ocean/spectrum.h"

#define MOST_WIND 30.0

double pel_beaufort_wind(double number)
{
    return 0.836 * pow(number, 1.5);
}

double pel_douglas_height(double degree)
{
    static const double middle[] = { 0,    0.05, 0.3, 0.875, 1.875,
                                     3.25, 5,    7.5, 11.5,  14 };
    double d = pel_clamp(degree, 0, 9);
    int i = d < 9 ? (int)d : 8;
    return middle[i] + (d - i) * (middle[i + 1] - middle[i]);
}

/* How many of the bounds a number has reached. */
static unsigned reached(const double *bounds, int count, double value)
{
    unsigned found = 0;
    for (int i = 0; i < count; i++) {
        found += value >= bounds[i];
    }
    return found;
}

unsigned pel_beaufort_of(double wind_mps)
{
    static const double from[] = { 0.3,  1.6,  3.4,  5.5,  8.0,  10.8,
                                   13.9, 17.2, 20.8, 24.5, 28.5, 32.7 };
    return reached(from, sizeof from / sizeof *from, wind_mps);
}

unsigned pel_douglas_of(double height_m)
{
    /* 0 is glassy: below what is seen, a centimetre. */
    static const double from[] = { 0.01, 0.1, 0.5, 1.25, 2.5, 4, 6, 9, 14 };
    return reached(from, sizeof from / sizeof *from, height_m);
}

static double height(struct pel_sea_desc *d, double wind_mps)
{
    d->wind_mps = wind_mps;
    if (pel_spectrum_is_whole(d)) {
        return 4.0 * sqrt(pel_spectrum_m0(d, 0, INFINITY));
    }
    struct pel_directional *spectrum;
    if (pel_directional_create(d, &spectrum)) {
        return INFINITY; /* ends at no wind */
    }
    struct pel_band_moments all;
    pel_directional_moments(spectrum, 0, INFINITY, &all);
    pel_directional_destroy(spectrum);
    return 4.0 * sqrt(all.m0);
}

double pel_wind_for_height(const struct pel_sea_desc *desc, double height_m)
{
    struct pel_sea_desc d = *desc;
    d.swell_count = 0;
    d.rain_mm_h = 0;
    if (!pel_spectrum_uses(d.kind, PEL_USES_WIND)) {
        d.kind = PEL_SPECTRUM_PIERSON_MOSKOWITZ;
    }
    double lo = 0, hi = MOST_WIND;
    if (!(height_m > 0)) {
        return 0;
    }
    if (height(&d, hi) < height_m) {
        return hi;
    }
    for (int i = 0; i < 15; i++) {
        double mid = 0.5 * (lo + hi);
        if (height(&d, mid) < height_m) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    return 0.5 * (lo + hi);
}
