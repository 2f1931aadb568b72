#include "optics/waterbody.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "base/vec.h"
#include "optics/brdf.h"

const double pel_water_wavelength_nm[PEL_WATER_WAVELENGTHS] = { 680, 550, 440 };

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

/* Backscattered fraction of coastal particles: Petzold 1972, as averaged by
 * Mobley 1994, sec. 3.8; of San Diego harbour: Mobley 1994, table 3.11. */
#define PARTICLE_BACK 0.0183
#define HARBOUR_BACK 0.020

/* San Diego harbour at 514 nm, 1/m: Petzold 1972, station 2240. */
#define HARBOUR_NM 514.0
#define HARBOUR_ABSORPTION 0.366
#define HARBOUR_SCATTERING 1.824

/* Fall of what dissolved and detrital matter absorb, 1/nm: Bricaud, Morel and
 * Prieur 1981. */
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

/* Constituents by chlorophyll alone. */
static struct pel_seawater case1(double chlorophyll,
                                 const struct pel_water_desc *desc)
{
    return (struct pel_seawater){
        .chlorophyll_mg_m3 =
            pel_clamp(chlorophyll, PEL_CHLOROPHYLL_MIN, PEL_CHLOROPHYLL_MAX),
        .salinity_g_kg = desc->salinity_g_kg,
        .temperature_c = desc->temperature_c,
    };
}

/* The chlorophyll of Case 1 water that is as clear at 550 nm. */
static double chlorophyll_like(enum pel_jerlov type,
                               const struct pel_water_desc *desc)
{
    double low = log(PEL_CHLOROPHYLL_MIN), high = log(PEL_CHLOROPHYLL_MAX);
    double wanted = pel_jerlov_attenuation(type, 1);
    for (int n = 0; n < 40; n++) {
        double middle = 0.5 * (low + high);
        struct pel_seawater w = case1(exp(middle), desc);
        struct pel_iop iop = pel_seawater_iop(&w, pel_water_wavelength_nm[1]);
        if (pel_kirk_attenuation(pel_iop_absorption(&iop),
                                 pel_iop_scattering(&iop)) < wanted) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return exp(0.5 * (low + high));
}

/* What is measured at the three wavelengths, at another: v e^(s λ) between two
 * of them, and beyond them as between the nearest two. */
static double between(const double v[PEL_WATER_WAVELENGTHS], double nm)
{
    const double *at = pel_water_wavelength_nm;
    int i = nm > at[1] ? 0 : 1;
    double part = (nm - at[i + 1]) / (at[i] - at[i + 1]);
    return pow(fmax(v[i], 1e-9), part) * pow(fmax(v[i + 1], 1e-9), 1.0 - part);
}

/* Scattering of the Case 1 water that is as clear in the green, of coasts with
 * Petzold's backscattered fraction; absorption such that Kirk's K_d is
 * Jerlov's, but never less than pure water's. Algae take of it what they would
 * in that water, dissolved matter the rest. */
static struct pel_iop jerlov_iop(enum pel_jerlov type,
                                 const struct pel_water_desc *desc, double nm)
{
    struct pel_seawater like = case1(chlorophyll_like(type, desc), desc);
    double rest[PEL_WATER_WAVELENGTHS];
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        struct pel_iop at = pel_seawater_iop(&like, pel_water_wavelength_nm[i]);
        double k = pel_jerlov_attenuation(type, i);
        double half = 0.5 * KIRK * pel_iop_scattering(&at);
        rest[i] = fmax(sqrt(k * k + half * half) - half - at.water, 0.0);
    }
    struct pel_iop out = pel_seawater_iop(&like, nm);
    double left = between(rest, nm);
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        left = nm == pel_water_wavelength_nm[i] ? rest[i] : left;
    }
    out.phytoplankton = fmin(out.phytoplankton, left);
    out.dissolved = left - out.phytoplankton;
    out.detritus = 0.0;
    if (type >= PEL_JERLOV_1C) {
        out.back = PARTICLE_BACK;
    }
    return out;
}

static struct pel_iop harbour_iop(const struct pel_water_desc *desc, double nm)
{
    struct pel_iop out = {
        .water = pel_seawater_absorption(nm),
        .molecular = pel_seawater_molecular(nm, desc->salinity_g_kg,
                                            desc->temperature_c),
        .back = HARBOUR_BACK,
    };
    out.dissolved = (HARBOUR_ABSORPTION - pel_seawater_absorption(HARBOUR_NM)) *
                    exp(-YELLOW_SLOPE * (nm - HARBOUR_NM));
    out.particles = HARBOUR_SCATTERING * HARBOUR_NM / nm - out.molecular;
    return out;
}

static struct pel_iop tropical_iop(const struct pel_water_desc *desc, double nm)
{
    return jerlov_iop(PEL_JERLOV_IA, desc, nm);
}

static struct pel_iop north_atlantic_iop(const struct pel_water_desc *desc,
                                         double nm)
{
    return jerlov_iop(PEL_JERLOV_II, desc, nm);
}

static struct pel_iop baltic_iop(const struct pel_water_desc *desc, double nm)
{
    return jerlov_iop(PEL_JERLOV_3C, desc, nm);
}

/* The waters that have a name: a new one is a row. */
static const struct {
    const char *word;
    struct pel_iop (*iop)(const struct pel_water_desc *desc, double nm);
} named[PEL_WATER_NAME_COUNT] = {
    [PEL_WATER_TROPICAL] = { "tropical", tropical_iop },
    [PEL_WATER_NORTH_ATLANTIC] = { "north-atlantic", north_atlantic_iop },
    [PEL_WATER_BALTIC] = { "baltic", baltic_iop },
    [PEL_WATER_HARBOUR] = { "harbour", harbour_iop },
};

/* Of coefficients only the sums are known: all of it dissolved, and scattered
 * by particles. */
static struct pel_iop coefficients_iop(const struct pel_water_desc *desc,
                                       double nm)
{
    struct pel_iop out = { .dissolved = between(desc->absorption, nm),
                           .particles = between(desc->scattering, nm) };
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        if (nm == pel_water_wavelength_nm[i]) {
            out.dissolved = desc->absorption[i];
            out.particles = desc->scattering[i];
        }
    }
    return out;
}

static struct pel_iop constituents_iop(const struct pel_water_desc *desc,
                                       double nm)
{
    struct pel_seawater w = case1(desc->chlorophyll_mg_m3, desc);
    w.has_dissolved = desc->has_dissolved;
    w.dissolved_per_m = desc->dissolved_per_m;
    w.dissolved_slope = desc->dissolved_slope;
    w.has_detritus = desc->has_detritus;
    w.detritus_per_m = desc->detritus_per_m;
    w.detritus_slope = desc->detritus_slope;
    w.minerals_g_m3 = desc->minerals_g_m3;
    return pel_seawater_iop(&w, nm);
}

struct pel_iop pel_water_iop(const struct pel_water_desc *desc, double nm)
{
    struct pel_iop out =
        desc->kind == PEL_WATER_JERLOV  ? jerlov_iop(desc->jerlov, desc, nm)
        : desc->kind == PEL_WATER_NAMED ? named[desc->name].iop(desc, nm)
        : desc->kind == PEL_WATER_COEFFICIENTS ? coefficients_iop(desc, nm)
                                               : constituents_iop(desc, nm);
    out.back = desc->has_back ? desc->back : out.back;
    return out;
}

/* Henyey and Greenstein's g that sends this fraction back. */
static double asymmetry_of(double back)
{
    double low = 0.0, high = PEL_ASYMMETRY_MAX;
    for (int i = 0; i < 50; i++) {
        double g = 0.5 * (low + high);
        if (1.0 - pel_hg_forward_fraction(g) > back) {
            low = g;
        } else {
            high = g;
        }
    }
    return 0.5 * (low + high);
}

struct pel_medium pel_water_medium_at(const struct pel_water_desc *desc,
                                      const struct pel_water_body *body,
                                      double nm)
{
    struct pel_iop iop = pel_water_iop(desc, nm);
    const double *at = pel_water_wavelength_nm;
    int i = nm > at[1] ? 0 : 1;
    double part = pel_clamp((nm - at[i + 1]) / (at[i] - at[i + 1]), 0.0, 1.0);
    struct pel_medium m = {
        .absorption = pel_iop_absorption(&iop),
        .scattering = pel_iop_scattering(&iop),
        .depth_m = body->depth_m,
        .albedo = body->albedo[i + 1] +
                  part * (body->albedo[i] - body->albedo[i + 1]),
    };
    m.molecular = m.scattering > 0.0 ? iop.molecular / m.scattering : 0.0;
    if (desc->kind == PEL_WATER_COEFFICIENTS && !desc->has_back) {
        m.asymmetry = desc->asymmetry[i + 1] +
                      part * (desc->asymmetry[i] - desc->asymmetry[i + 1]);
    } else if (desc->phase == PEL_PARTICLES_HENYEY_GREENSTEIN) {
        m.asymmetry = asymmetry_of(iop.back);
    } else {
        m.back = pel_clamp(iop.back, PEL_PHASE_BACK_MIN, PEL_PHASE_BACK_MAX);
    }
    return m;
}

struct pel_raman pel_water_raman_at(const struct pel_water_desc *desc,
                                    const struct pel_water_body *body,
                                    double nm)
{
    struct pel_raman out = { 0 };
    if (desc->raman) {
        out.strength = pel_raman_strength(nm);
        out.from = pel_water_medium_at(desc, body, pel_raman_excitation_nm(nm));
    }
    return out;
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

struct limit {
    const char *name, *unit;
    double value, minimum, maximum;
};

/* What stands in the description by itself, whatever its kind reads. */
static enum pel_err check_constituents(const struct pel_water_desc *desc,
                                       struct pel_fault *fault)
{
    const struct limit limits[] = {
        { "cdom", "1/m", desc->has_dissolved ? desc->dissolved_per_m : 0.0, 0.0,
          PEL_CONSTITUENT_MAX },
        { "cdomSlope", "1/nm", desc->dissolved_slope, 0.0, PEL_SLOPE_MAX },
        { "detritus", "1/m", desc->has_detritus ? desc->detritus_per_m : 0.0,
          0.0, PEL_CONSTITUENT_MAX },
        { "detritusSlope", "1/nm", desc->detritus_slope, 0.0, PEL_SLOPE_MAX },
        { "minerals", "g/m3", desc->minerals_g_m3, 0.0, PEL_MINERALS_MAX },
        { "backscatterRatio", "1",
          desc->has_back ? desc->back : PEL_PHASE_BACK_MIN, PEL_PHASE_BACK_MIN,
          PEL_PHASE_BACK_MAX },
    };
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        const struct limit *l = &limits[i];
        enum pel_err err = pel_optics_check(l->name, l->unit, l->value,
                                            l->minimum, l->maximum, fault);
        if (err) {
            return err;
        }
    }
    return (unsigned)desc->phase < PEL_PARTICLES_COUNT
               ? PEL_OK
               : unknown("phase", (int)desc->phase, fault);
}

static enum pel_err check_kind(const struct pel_water_desc *desc,
                               struct pel_fault *fault)
{
    switch (desc->kind) {
    case PEL_WATER_CHLOROPHYLL:
        return pel_optics_check("chlorophyll", "mg/m3", desc->chlorophyll_mg_m3,
                                PEL_CHLOROPHYLL_MIN, PEL_CHLOROPHYLL_MAX,
                                fault);
    case PEL_WATER_JERLOV:
        return (unsigned)desc->jerlov < PEL_JERLOV_COUNT
                   ? PEL_OK
                   : unknown("jerlov", (int)desc->jerlov, fault);
    case PEL_WATER_NAMED:
        return (unsigned)desc->name < PEL_WATER_NAME_COUNT
                   ? PEL_OK
                   : unknown("name", (int)desc->name, fault);
    case PEL_WATER_COEFFICIENTS:
        return PEL_OK;
    }
    return unknown("kind", (int)desc->kind, fault);
}

/* Everything but depth, index and land. */
static void fill_water(const struct pel_water_desc *desc,
                       struct pel_water_body *body)
{
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        struct pel_medium m =
            pel_water_medium_at(desc, body, pel_water_wavelength_nm[i]);
        body->absorption[i] = m.absorption;
        body->scattering[i] = m.scattering;
        body->asymmetry[i] = m.asymmetry;
        body->molecular[i] = m.molecular;
        body->back[i] = m.back;
    }
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
    err = check_kind(desc, fault);
    if (!err) {
        err = check_constituents(desc, fault);
    }
    if (err) {
        return err;
    }
    fill_water(desc, &body);
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
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        body.raman[i] =
            pel_water_raman_at(desc, &body, pel_water_wavelength_nm[i]);
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
    const struct pel_water_desc desc = {
        .chlorophyll_mg_m3 = chlorophyll,
        .salinity_g_kg = PEL_SALINITY_USUAL,
        .temperature_c = PEL_TEMPERATURE_USUAL,
    };
    fill_water(&desc, &body);
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
        .molecular = body->molecular[i],
        .back = body->back[i],
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

const char *pel_particles_word(int i)
{
    static const char *const words[PEL_PARTICLES_COUNT] = {
        [PEL_PARTICLES_FOURNIER_FORAND] = "fournier-forand",
        [PEL_PARTICLES_HENYEY_GREENSTEIN] = "henyey-greenstein",
    };
    return i >= 0 && i < PEL_PARTICLES_COUNT ? words[i] : NULL;
}

const char *pel_bottom_word(int i)
{
    return i >= 0 && i < PEL_BOTTOM_COUNT ? bottoms[i].word : NULL;
}
