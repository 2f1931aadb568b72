#include "optics/water.h"

#include <math.h>

#include "optics/brdf.h"
#include "optics/waterbody.h"

/* Air to water for light from Sun and sky, and of light from below kept
 * below by the surface: Mobley 1994, sec. 4.2; Morel and Gentili 1991. */
#define TRANSMITTED_DOWN 0.96
#define REFLECTED_UP 0.48

static double reflectance(double c, int i)
{
    struct pel_case1 w = pel_water_case1(c, i);
    return 0.33 * w.backscattering / w.absorption;
}

struct pel_rgb pel_water_reflectance(double chlorophyll_mg_m3)
{
    double c = chlorophyll_mg_m3;
    return (struct pel_rgb){ reflectance(c, 0), reflectance(c, 1),
                             reflectance(c, 2) };
}

static double leaving(double e, double r)
{
    return e * TRANSMITTED_DOWN * r /
           (PEL_PI * PEL_WATER_INDEX * PEL_WATER_INDEX *
            (1.0 - REFLECTED_UP * r));
}

struct pel_rgb pel_water_radiance(double chlorophyll_mg_m3, struct pel_rgb e)
{
    struct pel_rgb r = pel_water_reflectance(chlorophyll_mg_m3);
    return (struct pel_rgb){ leaving(e.r, r.r), leaving(e.g, r.g),
                             leaving(e.b, r.b) };
}
