#include "optics/seawater.h"

#include <math.h>
#include <stddef.h>

#include "base/vec.h"

/* 380 to 700 nm in steps of 5, 1/m. */
#define WATER_FIRST_NM 380.0
static const double water_absorption[] = {
    0.01137, 0.00941, 0.00851, 0.00813, 0.00663, 0.0053,  0.00473, 0.00444,
    0.00454, 0.00478, 0.00495, 0.0053,  0.00635, 0.00751, 0.00922, 0.00962,
    0.00979, 0.01011, 0.0106,  0.0114,  0.0127,  0.0136,  0.0150,  0.0173,
    0.0204,  0.0256,  0.0325,  0.0396,  0.0409,  0.0417,  0.0434,  0.0452,
    0.0474,  0.0511,  0.0565,  0.0596,  0.0619,  0.0642,  0.0695,  0.0772,
    0.0896,  0.1100,  0.1351,  0.1672,  0.2224,  0.2577,  0.2644,  0.2678,
    0.2755,  0.2834,  0.2916,  0.3012,  0.3108,  0.325,   0.340,   0.371,
    0.410,   0.429,   0.439,   0.448,   0.465,   0.486,   0.516,   0.559,
    0.624,
};

/* Phytoplankton, a = A C^E: Bricaud et al. 1998, table 2, at some of its
 * wavelengths; straight lines between these are within 3 % of the others. */
static const struct {
    double nm, a, e;
} algae[] = {
    { 400, 0.0240515, 0.687735 },   { 410, 0.0287352, 0.683414 },
    { 420, 0.032834, 0.666439 },    { 430, 0.0359357, 0.647841 },
    { 440, 0.037824, 0.626633 },    { 450, 0.0349905, 0.599299 },
    { 460, 0.0328336, 0.596114 },   { 470, 0.0309118, 0.597029 },
    { 480, 0.0280519, 0.589011 },   { 490, 0.0253719, 0.607395 },
    { 500, 0.0209906, 0.652915 },   { 510, 0.0161767, 0.721246 },
    { 520, 0.0126114, 0.793886 },   { 530, 0.0102702, 0.850035 },
    { 540, 0.00847894, 0.9036376 }, { 550, 0.00702755, 0.9311673 },
    { 560, 0.00567919, 0.9345194 }, { 570, 0.00498617, 0.9298118 },
    { 580, 0.00508712, 0.893336 },  { 590, 0.00539004, 0.858931 },
    { 600, 0.00521658, 0.841018 },  { 610, 0.00548048, 0.854777 },
    { 620, 0.00608558, 0.870417 },  { 630, 0.00662103, 0.86376 },
    { 640, 0.00713341, 0.852402 },  { 650, 0.00777566, 0.815461 },
    { 656, 0.00903046, 0.815501 },  { 660, 0.0108322, 0.823337 },
    { 664, 0.0134507, 0.82256 },    { 668, 0.0162698, 0.814107 },
    { 672, 0.0180721, 0.811783 },   { 676, 0.0179744, 0.816196 },
    { 680, 0.016057, 0.8284 },      { 684, 0.0124842, 0.861145 },
    { 688, 0.00854401, 0.9022806 }, { 692, 0.00548901, 0.9417016 },
    { 696, 0.00359814, 0.9821707 }, { 700, 0.00248126, 1.028608 },
};
enum { ALGAE = sizeof algae / sizeof *algae };

/* Fall of the absorption with wavelength, 1/nm: dissolved matter, Bricaud,
 * Morel and Prieur 1981; detritus, Bricaud et al. 1998. */
#define DISSOLVED_SLOPE 0.014
#define DETRITUS_SLOPE 0.011

/* Suspended minerals, m²/g: absorption at 443 nm with its fall, and scattering,
 * Babin et al. 2003 (both papers), their coastal means; backscattered fraction,
 * Twardowski et al. 2001, of inorganic particles. */
#define MINERAL_ABSORPTION 0.041
#define MINERAL_SLOPE 0.0123
#define MINERAL_SCATTERING 0.51
#define MINERAL_BACK 0.02

double pel_seawater_absorption(double nm)
{
    const int last = sizeof water_absorption / sizeof *water_absorption - 1;
    double at = pel_clamp((nm - WATER_FIRST_NM) / 5.0, 0.0, last);
    int i = (int)fmin(at, last - 1);
    return water_absorption[i] +
           (at - i) * (water_absorption[i + 1] - water_absorption[i]);
}

static double phytoplankton(double c, double nm)
{
    int i = 0;
    while (i < ALGAE - 2 && algae[i + 1].nm <= nm) {
        i++;
    }
    double part = pel_clamp(
        (nm - algae[i].nm) / (algae[i + 1].nm - algae[i].nm), 0.0, 1.0);
    double a = algae[i].a + part * (algae[i + 1].a - algae[i].a);
    return a * pow(c, algae[i].e + part * (algae[i + 1].e - algae[i].e));
}

double pel_water_index(double s, double t, double nm)
{
    return 1.31405 + (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t * t) * s -
           2.02e-6 * t * t + (15.868 + 0.01155 * s - 0.00423 * t) / nm -
           4382.0 / (nm * nm) + 1.1455e6 / (nm * nm * nm);
}

/* Density of sea water [kg/m³] at the surface: UNESCO 1981, EOS-80. */
static double density(double s, double t)
{
    double pure =
        999.842594 +
        t * (6.793952e-2 +
             t * (-9.09529e-3 +
                  t * (1.001685e-4 + t * (-1.120083e-6 + t * 6.536332e-9))));
    double a =
        0.824493 +
        t * (-4.0899e-3 + t * (7.6438e-5 + t * (-8.2467e-7 + t * 5.3875e-9)));
    double b = -5.72466e-3 + t * (1.0227e-4 - t * 1.6546e-6);
    return pure + s * (a + sqrt(s) * b + s * 4.8314e-4);
}

/* Isothermal compressibility [1/Pa]: the secant bulk modulus of EOS-80. */
static double compressibility(double s, double t)
{
    double pure =
        19652.21 +
        t * (148.4206 + t * (-2.327105 + t * (1.360477e-2 - t * 5.155288e-5)));
    double a = 54.6746 + t * (-0.603459 + t * (1.09987e-2 - t * 6.167e-5));
    double b = 7.944e-2 + t * (1.6483e-2 - t * 5.3009e-4);
    return 1e-5 / (pure + s * (a + sqrt(s) * b));
}

/* d ln a_w / dS of the water's activity: Millero and Leung 1976, as fitted by
 * Zhang et al. 2009, eq. A8. */
static double activity_slope(double s, double t)
{
    double a =
        -5.58651e-4 + t * (2.40452e-7 + t * (-3.12165e-9 + t * 2.40808e-11));
    double b =
        1.79613e-5 + t * (-9.9422e-8 + t * (2.08919e-9 - t * 1.39872e-11));
    double c = -2.31065e-6 - t * (1.37674e-9 + t * 1.93316e-11);
    return a + 1.5 * sqrt(s) * b + 2.0 * s * c;
}

double pel_seawater_molecular(double nm, double s, double t)
{
    const double boltzmann = 1.3806503e-23, avogadro = 6.0221417930e23;
    const double mole = 0.018, depolarisation = 0.039;
    /* Ciddor 1996: the index is against air. */
    double um2 = 1e6 / (nm * nm);
    double air =
        1.0 + (5792105.0 / (238.0185 - um2) + 167917.0 / (57.362 - um2)) / 1e8;
    double n = pel_water_index(s, t, nm) * air, n2 = n * n;
    double by_salt =
        (1.779e-4 + t * (-1.05e-6 + t * 1.6e-8) + 0.01155 / nm) * air;
    /* ρ dn²/dρ: Proutiere, Megnassan and Hucteau 1992. */
    double root = (n - 1.0 / n) / 3.0;
    double by_density =
        (n2 - 1.0) * (1.0 + 2.0 / 3.0 * (n2 + 2.0) * root * root);
    double m = nm * 1e-9, m4 = m * m * m * m;
    double cabannes =
        (6.0 + 6.0 * depolarisation) / (6.0 - 7.0 * depolarisation);
    double of_density = 0.5 * boltzmann * (t + 273.15) * compressibility(s, t) *
                        by_density * by_density;
    double of_salt = 2.0 * n2 * s * mole * by_salt * by_salt /
                     (density(s, t) * -activity_slope(s, t) * avogadro);
    double at_90 = PEL_PI * PEL_PI / m4 * cabannes * (of_density + of_salt);
    return 8.0 * PEL_PI / 3.0 * at_90 * (2.0 + depolarisation) /
           (1.0 + depolarisation);
}

/* Particles of Case 1 water: Loisel and Morel 1998 at 550 nm, and with
 * wavelength Morel and Maritorena 2001, eq. 12 to 14. */
static double particles_case1(double c, double nm, double *back)
{
    double l = log10(c);
    double power = c < 2.0 ? fmax(0.5 * (l - 0.3), -1.0) : 0.0;
    double green = 0.416 * pow(c, 0.766), colour = pow(nm / 550.0, power);
    *back = (0.002 + 0.01 * fmax(0.5 - 0.25 * l, 0.0) * colour) / colour;
    return green * colour;
}

struct pel_iop pel_seawater_iop(const struct pel_seawater *w, double nm)
{
    double c = w->chlorophyll_mg_m3;
    struct pel_iop out = {
        .water = pel_seawater_absorption(nm),
        .phytoplankton = phytoplankton(c, nm),
        .molecular =
            pel_seawater_molecular(nm, w->salinity_g_kg, w->temperature_c),
    };
    /* A fifth of water and algae at 440 nm: Morel 1991. */
    double dissolved =
        w->has_dissolved
            ? w->dissolved_per_m
            : 0.2 * (pel_seawater_absorption(440.0) + phytoplankton(c, 440.0));
    double fall =
        w->dissolved_slope > 0.0 ? w->dissolved_slope : DISSOLVED_SLOPE;
    out.dissolved = dissolved * exp(-fall * (nm - 440.0));
    double detritus =
        w->has_detritus ? w->detritus_per_m : 0.0124 * pow(c, 0.724);
    fall = w->detritus_slope > 0.0 ? w->detritus_slope : DETRITUS_SLOPE;
    out.detritus = detritus * exp(-fall * (nm - 440.0)) +
                   w->minerals_g_m3 * MINERAL_ABSORPTION *
                       exp(-MINERAL_SLOPE * (nm - 443.0));
    double algal = particles_case1(c, nm, &out.back);
    double mineral = w->minerals_g_m3 * MINERAL_SCATTERING;
    out.particles = algal + mineral;
    out.back = w->has_back ? w->back
                           : (algal * out.back + mineral * MINERAL_BACK) /
                                 out.particles;
    return out;
}

double pel_iop_absorption(const struct pel_iop *i)
{
    return i->water + i->phytoplankton + i->dissolved + i->detritus;
}

double pel_iop_scattering(const struct pel_iop *i)
{
    return i->molecular + i->particles;
}

double pel_iop_backscattering(const struct pel_iop *i)
{
    return 0.5 * i->molecular + i->back * i->particles;
}
