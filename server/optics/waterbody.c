#include "optics/waterbody.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "base/vec.h"
#include "optics/brdf.h"

const double pel_water_wavelength_nm[PEL_WATER_WAVELENGTHS] = { 680, 550, 440 };

/* Absorption of pure water, 1/m: Pope and Fry 1997, table 3. */
static const double a_water[PEL_WATER_WAVELENGTHS] = { 0.465, 0.0565, 0.00635 };
/* Phytoplankton a_ph = A C^E, 1/m: Bricaud et al. 1998, table 2. */
static const double a_ph[PEL_WATER_WAVELENGTHS] = { 0.0161, 0.0070, 0.0378 };
static const double e_ph[PEL_WATER_WAVELENGTHS] = { 0.8284, 0.9312, 0.6266 };

/* Jerlov 1976, table XXVII, 1/m, at 675, 700; 550; 425, 450 nm. */
static const struct {
    const char *word;
    double attenuation[5];
} jerlov[PEL_JERLOV_COUNT] = {
    [PEL_JERLOV_I] = { "I", { 0.42, 0.56, 0.063, 0.022, 0.019 } },
    [PEL_JERLOV_IA] = { "IA", { 0.43, 0.57, 0.067, 0.031, 0.026 } },
    [PEL_JERLOV_IB] = { "IB", { 0.435, 0.58, 0.072, 0.042, 0.036 } },
    [PEL_JERLOV_II] = { "II", { 0.465, 0.61, 0.089, 0.081, 0.068 } },
    [PEL_JERLOV_III] = { "III", { 0.52, 0.66, 0.12, 0.16, 0.135 } },
    [PEL_JERLOV_1C] = { "1C", { 0.51, 0.65, 0.12, 0.36, 0.25 } },
    [PEL_JERLOV_3C] = { "3C", { 0.56, 0.71, 0.19, 0.54, 0.39 } },
    [PEL_JERLOV_5C] = { "5C", { 0.65, 0.80, 0.30, 0.78, 0.56 } },
    [PEL_JERLOV_7C] = { "7C", { 0.78, 0.92, 0.46, 1.2, 0.89 } },
    [PEL_JERLOV_9C] = { "9C", { 0.92, 1.1, 0.63, 1.9, 1.6 } },
};

/* Backscattered fraction of particles: Petzold 1972, as averaged by Mobley
 * 1994, sec. 3.8; of San Diego harbour: Mobley 1994, table 3.11. */
#define PARTICLE_BACK 0.0183
#define HARBOUR_BACK 0.020

/* San Diego harbour at 514 nm, 1/m: Petzold 1972, station 2240. */
#define HARBOUR_NM 514.0
#define HARBOUR_ABSORPTION 0.366
#define HARBOUR_SCATTERING 1.824
#define WATER_ABSORPTION_514 0.0361 /* Pope and Fry 1997, interpolated */

/* Fall of the absorption of dissolved and detrital matter with wavelength,
 * 1/nm: Bricaud, Morel and Prieur 1981. */
#define YELLOW_SLOPE 0.014

/* Irradiance reflectance, read from graphs and rounded; single bottoms differ
 * by a factor of two. Sand and mud: Werdell and Roesler 2003, figs. 4F, 4E;
 * coral: Hochberg, Atkinson and Andréfouët 2003, brown corals; rock: grey
 * stone under a film of algae, estimated. */
static const struct {
    const char *word;
    double albedo[PEL_WATER_WAVELENGTHS];
} bottoms[PEL_BOTTOM_COUNT] = {
    [PEL_BOTTOM_BLACK] = { "black", { 0.0, 0.0, 0.0 } },
    [PEL_BOTTOM_SAND] = { "sand", { 0.49, 0.36, 0.25 } },
    [PEL_BOTTOM_MUD] = { "mud", { 0.12, 0.08, 0.05 } },
    [PEL_BOTTOM_ROCK] = { "rock", { 0.10, 0.10, 0.07 } },
    [PEL_BOTTOM_CORAL] = { "coral", { 0.06, 0.11, 0.05 } },
    [PEL_BOTTOM_ALBEDO] = { "albedo", { 0.0 } }, /* that of the description */
};

/* Morel 1974, 1/m, whose sea water scatters 1.3 times as much as pure water;
 * in proportion to its salt (Boss and Pegau 2001). Half of it goes back. */
static double molecular_scattering(double salinity, int i)
{
    return 0.00288 / 1.3 * (1.0 + 0.3 * salinity / 37.0) *
           pow(500.0 / pel_water_wavelength_nm[i], 4.32);
}

double pel_water_index(double s, double t, double nm)
{
    return 1.31405 + (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t * t) * s -
           2.02e-6 * t * t + (15.868 + 0.01155 * s - 0.00423 * t) / nm -
           4382.0 / (nm * nm) + 1.1455e6 / (nm * nm * nm);
}

/* Particles: b = 0.30 C^0.62 · 550/λ (Gordon and Morel 1983). */
static double particle_scattering(double c, int i)
{
    return 0.30 * pow(c, 0.62) * 550.0 / pel_water_wavelength_nm[i];
}

struct pel_case1 pel_water_case1(double chlorophyll, double salinity, int i)
{
    double c = pel_clamp(chlorophyll, PEL_CHLOROPHYLL_MIN, PEL_CHLOROPHYLL_MAX);
    double nm = pel_water_wavelength_nm[i];
    double water = molecular_scattering(salinity, i);
    double particles = particle_scattering(c, i);
    /* b_b/b of particles at 550 nm, and its fall: Morel 1988. */
    double back =
        fmax(0.002 + 0.02 * (0.5 - 0.25 * log10(c)) * 550.0 / nm, 0.002);
    /* Dissolved matter: 0.2 of water and algae at 440 nm, Morel 1991. */
    double yellow = 0.2 * (a_water[2] + a_ph[2] * pow(c, e_ph[2])) *
                    exp(-YELLOW_SLOPE * (nm - 440.0));
    return (struct pel_case1){
        .absorption = a_water[i] + a_ph[i] * pow(c, e_ph[i]) + yellow,
        .scattering = water + particles,
        /* The factor 550/λ of Morel's b_b is in `back`. */
        .backscattering = 0.5 * water + 0.30 * pow(c, 0.62) * back,
    };
}

double pel_jerlov_attenuation(enum pel_jerlov type, int i)
{
    const double *k = jerlov[type].attenuation;
    return i == 0   ? k[0] + (k[1] - k[0]) * (680.0 - 675.0) / 25.0
           : i == 1 ? k[2]
                    : k[3] + (k[4] - k[3]) * (440.0 - 425.0) / 25.0;
}

#define KIRK 0.235 /* 0.425 μ0 − 0.19, Sun at the zenith */

double pel_kirk_attenuation(double a, double b)
{
    return sqrt(a * a + KIRK * a * b);
}

/* The chlorophyll of Case 1 water that is as clear at 550 nm. */
static double chlorophyll_like(enum pel_jerlov type, double salinity)
{
    double low = log(PEL_CHLOROPHYLL_MIN), high = log(PEL_CHLOROPHYLL_MAX);
    double wanted = pel_jerlov_attenuation(type, 1);
    for (int n = 0; n < 50; n++) {
        double middle = 0.5 * (low + high);
        struct pel_case1 w = pel_water_case1(exp(middle), salinity, 1);
        if (pel_kirk_attenuation(w.absorption, w.scattering) < wanted) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return exp(0.5 * (low + high));
}

/* Water sends light back by a phase function that hardly changes past 90°,
 * Henyey and Greenstein's falls there all the way, and what leaves the water
 * was turned by 84° to 180°. So g is chosen to meet the true function at 140°,
 * where it gives the backscattering: b_b = 2π χ β(140°), χ = 1.08 (Maffione
 * and Dana 1997). */
static double asymmetry(double back_fraction)
{
    double phase = back_fraction / (2.0 * PEL_PI * 1.08);
    return pel_hg_asymmetry(cos(140.0 * PEL_DEG), phase);
}

static double mixed_asymmetry(double water, double particles, double back)
{
    return asymmetry((0.5 * water + back * particles) / (water + particles));
}

/* Scattering of the Case 1 water that is as clear in the green; absorption
 * such that Kirk's K_d is Jerlov's, but never less than pure water's. */
static void resolve_jerlov(enum pel_jerlov type, double salinity,
                           struct pel_water_body *out)
{
    double c = chlorophyll_like(type, salinity);
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        double particles = particle_scattering(c, i);
        double water = molecular_scattering(salinity, i);
        double b = particles + water;
        double k = pel_jerlov_attenuation(type, i), half = 0.5 * KIRK * b;
        out->absorption[i] = fmax(sqrt(k * k + half * half) - half, a_water[i]);
        out->scattering[i] = b;
        out->asymmetry[i] = mixed_asymmetry(water, particles, PARTICLE_BACK);
    }
}

static void resolve_harbour(double salinity, struct pel_water_body *out)
{
    (void)salinity; /* measured as it was */
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        double nm = pel_water_wavelength_nm[i];
        out->absorption[i] =
            a_water[i] + (HARBOUR_ABSORPTION - WATER_ABSORPTION_514) *
                             exp(-YELLOW_SLOPE * (nm - HARBOUR_NM));
        out->scattering[i] = HARBOUR_SCATTERING * HARBOUR_NM / nm;
        out->asymmetry[i] = asymmetry(HARBOUR_BACK);
    }
}

static void resolve_tropical(double salinity, struct pel_water_body *out)
{
    resolve_jerlov(PEL_JERLOV_IA, salinity, out);
}

static void resolve_north_atlantic(double salinity, struct pel_water_body *out)
{
    resolve_jerlov(PEL_JERLOV_II, salinity, out);
}

static void resolve_baltic(double salinity, struct pel_water_body *out)
{
    resolve_jerlov(PEL_JERLOV_3C, salinity, out);
}

/* The waters that have a name: a new one is a row. */
static const struct {
    const char *word;
    void (*resolve)(double salinity, struct pel_water_body *out);
} named[PEL_WATER_NAME_COUNT] = {
    [PEL_WATER_TROPICAL] = { "tropical", resolve_tropical },
    [PEL_WATER_NORTH_ATLANTIC] = { "north-atlantic", resolve_north_atlantic },
    [PEL_WATER_BALTIC] = { "baltic", resolve_baltic },
    [PEL_WATER_HARBOUR] = { "harbour", resolve_harbour },
};

static void resolve_case1(double chlorophyll, double salinity,
                          struct pel_water_body *out)
{
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        struct pel_case1 w = pel_water_case1(chlorophyll, salinity, i);
        out->absorption[i] = w.absorption;
        out->scattering[i] = w.scattering;
        out->asymmetry[i] = asymmetry(w.backscattering / w.scattering);
    }
}

static enum pel_err unknown(const char *what, int value,
                            struct pel_fault *fault)
{
    pel_fault_set(fault, PEL_ERR_INVALID, "no %s of number %d", what, value);
    if (fault) {
        snprintf(fault->path, sizeof fault->path, "%s", what);
    }
    return PEL_ERR_INVALID;
}

static enum pel_err resolve_water(const struct pel_water_desc *desc,
                                  struct pel_water_body *out,
                                  struct pel_fault *fault)
{
    double c = desc->chlorophyll_mg_m3, salinity = desc->salinity_g_kg;
    switch (desc->kind) {
    case PEL_WATER_CHLOROPHYLL:
        resolve_case1(c, salinity, out);
        return pel_optics_check("chlorophyll", "mg/m3", c, PEL_CHLOROPHYLL_MIN,
                                PEL_CHLOROPHYLL_MAX, fault);
    case PEL_WATER_JERLOV:
        if ((unsigned)desc->jerlov >= PEL_JERLOV_COUNT) {
            return unknown("jerlov", (int)desc->jerlov, fault);
        }
        resolve_jerlov(desc->jerlov, salinity, out);
        return PEL_OK;
    case PEL_WATER_NAMED:
        if ((unsigned)desc->name >= PEL_WATER_NAME_COUNT) {
            return unknown("name", (int)desc->name, fault);
        }
        named[desc->name].resolve(salinity, out);
        return PEL_OK;
    case PEL_WATER_COEFFICIENTS:
        for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
            out->absorption[i] = desc->absorption[i];
            out->scattering[i] = desc->scattering[i];
            out->asymmetry[i] = desc->asymmetry[i];
        }
        return PEL_OK;
    }
    return unknown("kind", (int)desc->kind, fault);
}

static void fill_index(double salinity, double temperature,
                       double index[PEL_WATER_WAVELENGTHS])
{
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        index[i] =
            pel_water_index(salinity, temperature, pel_water_wavelength_nm[i]);
    }
}

enum pel_err pel_water_resolve(const struct pel_water_desc *desc,
                               struct pel_water_body *out,
                               struct pel_fault *fault)
{
    enum pel_err err = pel_optics_check("salinity", "g/kg", desc->salinity_g_kg,
                                        0.0, PEL_SALINITY_MAX, fault);
    if (!err) {
        err = pel_optics_check("temperature", "degC", desc->temperature_c,
                               PEL_TEMPERATURE_MIN, PEL_TEMPERATURE_MAX, fault);
    }
    if (err) {
        return err;
    }
    struct pel_water_body body = {
        .depth_m = desc->depth_m,
    };
    fill_index(desc->salinity_g_kg, desc->temperature_c, body.index);
    err = resolve_water(desc, &body, fault);
    if (err) {
        return err;
    }
    if ((unsigned)desc->bottom >= PEL_BOTTOM_COUNT) {
        return unknown("bottom", (int)desc->bottom, fault);
    }
    if (desc->has_land && (unsigned)desc->land >= PEL_BOTTOM_ALBEDO) {
        return unknown("land", (int)desc->land, fault);
    }
    enum pel_bottom land = desc->has_land                     ? desc->land
                           : desc->bottom == PEL_BOTTOM_BLACK ? PEL_BOTTOM_SAND
                                                              : desc->bottom;
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        body.land[i] = land == PEL_BOTTOM_ALBEDO ? desc->albedo[i]
                                                 : bottoms[land].albedo[i];
        body.albedo[i] = desc->bottom == PEL_BOTTOM_ALBEDO
                             ? desc->albedo[i]
                             : bottoms[desc->bottom].albedo[i];
        struct pel_medium medium = pel_water_medium(&body, i);
        err = pel_medium_check(&medium, fault);
        if (err) {
            return err;
        }
    }
    *out = body;
    return PEL_OK;
}

struct pel_water_body pel_water_deep(double chlorophyll)
{
    struct pel_water_body body = {
        .depth_m = 1000.0,
    };
    fill_index(PEL_SALINITY_USUAL, PEL_TEMPERATURE_USUAL, body.index);
    resolve_case1(chlorophyll, PEL_SALINITY_USUAL, &body);
    memcpy(body.land, bottoms[PEL_BOTTOM_SAND].albedo, sizeof body.land);
    return body;
}

double pel_water_visible_m(const struct pel_water_body *body)
{
    double clearest = HUGE_VAL;
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        clearest = fmin(clearest, pel_kirk_attenuation(body->absorption[i],
                                                       body->scattering[i]));
    }
    return 0.5 * log(255.0) / clearest;
}

struct pel_medium pel_water_medium(const struct pel_water_body *body, int i)
{
    return (struct pel_medium){
        .absorption = body->absorption[i],
        .scattering = body->scattering[i],
        .asymmetry = body->asymmetry[i],
        .depth_m = body->depth_m,
        .albedo = body->albedo[i],
    };
}

const char *pel_jerlov_word(int i)
{
    return i >= 0 && i < PEL_JERLOV_COUNT ? jerlov[i].word : NULL;
}

const char *pel_water_name_word(int i)
{
    return i >= 0 && i < PEL_WATER_NAME_COUNT ? named[i].word : NULL;
}

const char *pel_bottom_word(int i)
{
    return i >= 0 && i < PEL_BOTTOM_COUNT ? bottoms[i].word : NULL;
}
