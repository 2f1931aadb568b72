#include "optics/water.h"

#include <math.h>

#include "optics/brdf.h"

/* At 680, 550, 440 nm. */
static const double wavelength_nm[3] = { 680, 550, 440 };
/* Absorption of pure water, 1/m: Pope and Fry 1997, table 3. */
static const double a_water[3] = { 0.465, 0.0565, 0.00635 };
/* Phytoplankton a_ph = A C^E, 1/m: Bricaud et al. 1998, table 2. */
static const double a_ph[3] = { 0.0161, 0.0070, 0.0378 };
static const double e_ph[3] = { 0.8284, 0.9312, 0.6266 };

/* Air to water for light from Sun and sky, and of light from below kept
 * below by the surface: Mobley 1994, sec. 4.2; Morel and Gentili 1991. */
#define TRANSMITTED_DOWN 0.96
#define REFLECTED_UP 0.48

static double reflectance(double c, int i)
{
    double nm = wavelength_nm[i];
    /* Sea water: Morel 1974. Half of it goes back. */
    double b_water = 0.00288 * pow(500.0 / nm, 4.32);
    /* Particles: b = 0.30 C^0.62 · 550/λ, and b_b/b: Morel 1988. */
    double b = 0.30 * pow(c, 0.62);
    double back = 0.002 + 0.02 * (0.5 - 0.25 * log10(c)) * 550.0 / nm;
    /* Dissolved matter: 0.2 of water and algae at 440 nm, Morel 1991. */
    double yellow = 0.2 * (a_water[2] + a_ph[2] * pow(c, e_ph[2])) *
                    exp(-0.014 * (nm - 440.0));
    double a = a_water[i] + a_ph[i] * pow(c, e_ph[i]) + yellow;
    double bb = 0.5 * b_water + b * fmax(back, 0.002);
    return 0.33 * bb / a;
}

struct pel_rgb pel_water_reflectance(double chlorophyll_mg_m3)
{
    double c = pel_clamp(chlorophyll_mg_m3, 0.01, 30);
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
