/* What water is made of, for light: absorption, scattering and how it turns
 * light at 680, 550 and 440 nm (in this order), depth and bottom, from any of
 * the ways in which people describe water. Every number's source is beside it
 * in waterbody.c and in docs/physics/water.md. Any thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "optics/raman.h"
#include "optics/seawater.h"
#include "optics/transport.h"

#define PEL_WATER_WAVELENGTHS 3
extern const double pel_water_wavelength_nm[PEL_WATER_WAVELENGTHS];

/* How the water is described; the other members are then not read. */
enum pel_water_kind {
    PEL_WATER_CHLOROPHYLL, /* constituents; what is not given by chlorophyll */
    PEL_WATER_JERLOV,
    PEL_WATER_NAMED,
    PEL_WATER_COEFFICIENTS,
};

/* Jerlov 1976: ocean I..III, coast 1C..9C. */
enum pel_jerlov {
    PEL_JERLOV_I,
    PEL_JERLOV_IA,
    PEL_JERLOV_IB,
    PEL_JERLOV_II,
    PEL_JERLOV_III,
    PEL_JERLOV_1C,
    PEL_JERLOV_3C,
    PEL_JERLOV_5C,
    PEL_JERLOV_7C,
    PEL_JERLOV_9C,
    PEL_JERLOV_COUNT,
};

enum pel_water_name {
    PEL_WATER_TROPICAL,       /* Jerlov IA */
    PEL_WATER_NORTH_ATLANTIC, /* Jerlov II */
    PEL_WATER_BALTIC,         /* Jerlov 3C */
    PEL_WATER_HARBOUR,        /* Petzold's San Diego harbour */
    PEL_WATER_NAME_COUNT,
};

/* How particles turn light (optics/phase.h). */
enum pel_particles {
    PEL_PARTICLES_FOURNIER_FORAND,
    PEL_PARTICLES_HENYEY_GREENSTEIN, /* g by the backscattered fraction */
    PEL_PARTICLES_COUNT,
};

enum pel_bottom {
    PEL_BOTTOM_BLACK,
    PEL_BOTTOM_SAND,
    PEL_BOTTOM_MUD,
    PEL_BOTTOM_ROCK,
    PEL_BOTTOM_CORAL,
    PEL_BOTTOM_ALBEDO, /* given */
    PEL_BOTTOM_COUNT,
};

#define PEL_CHLOROPHYLL_MIN 0.01
#define PEL_CHLOROPHYLL_MAX 30.0
#define PEL_CONSTITUENT_MAX 20.0 /* absorption at 440 nm, 1/m */
#define PEL_SLOPE_MAX 0.05
#define PEL_MINERALS_MAX 100.0
#define PEL_SALINITY_MAX 42.0
#define PEL_TEMPERATURE_MIN (-2.0)
#define PEL_TEMPERATURE_MAX 40.0
#define PEL_SALINITY_USUAL 35.0 /* where none is given */
#define PEL_TEMPERATURE_USUAL 15.0

struct pel_water_desc {
    enum pel_water_kind kind;
    double chlorophyll_mg_m3; /* PEL_CHLOROPHYLL_MIN..MAX */
    /* With chlorophyll, as in optics/seawater.h: */
    bool has_dissolved, has_detritus;
    double dissolved_per_m, detritus_per_m; /* 0..PEL_CONSTITUENT_MAX */
    double dissolved_slope, detritus_slope; /* 0..PEL_SLOPE_MAX; 0: usual */
    double minerals_g_m3;                   /* 0..PEL_MINERALS_MAX */
    /* Of every kind: */
    bool has_back;
    double back; /* PEL_PHASE_BACK_MIN..MAX; with coefficients, instead of
                    asymmetry */
    enum pel_particles phase;
    enum pel_jerlov jerlov;
    enum pel_water_name name;
    double absorption[PEL_WATER_WAVELENGTHS]; /* 1/m; ranges of transport.h */
    double scattering[PEL_WATER_WAVELENGTHS]; /* 1/m */
    double asymmetry[PEL_WATER_WAVELENGTHS];
    double salinity_g_kg; /* 0..PEL_SALINITY_MAX */
    double temperature_c; /* PEL_TEMPERATURE_MIN..MAX */
    double depth_m;       /* PEL_DEPTH_MIN..MAX */
    bool raman;           /* light of shorter waves becomes this one's */
    enum pel_bottom bottom;
    double albedo[PEL_WATER_WAVELENGTHS]; /* with PEL_BOTTOM_ALBEDO, 0..1 */
    bool has_land;
    enum pel_bottom land; /* beside the water; else as the bottom, and sand
                             where that is black; not PEL_BOTTOM_ALBEDO */
};

/* The water as transport sees it. */
struct pel_water_body {
    double absorption[PEL_WATER_WAVELENGTHS]; /* 1/m */
    double scattering[PEL_WATER_WAVELENGTHS]; /* 1/m */
    double asymmetry[PEL_WATER_WAVELENGTHS];  /* these three as in pel_medium */
    double molecular[PEL_WATER_WAVELENGTHS];
    double back[PEL_WATER_WAVELENGTHS];
    double albedo[PEL_WATER_WAVELENGTHS];
    double depth_m;
    double index[PEL_WATER_WAVELENGTHS]; /* of refraction, for what the surface
                                            reflects: pel_water_index */
    struct pel_raman raman[PEL_WATER_WAVELENGTHS];
    double land[PEL_WATER_WAVELENGTHS]; /* albedo; last: no light in the water
                                           depends on it */
};

/* What a description that pel_water_resolve takes has at a wavelength. Jerlov's
 * types, names and coefficients are known at a few wavelengths and
 * interpolated as exponentials. */
struct pel_iop pel_water_iop(const struct pel_water_desc *desc, double nm);

/* The same as transport sees it; `body` as resolved from it (its depth, and
 * its bottom between the three wavelengths). */
struct pel_medium pel_water_medium_at(const struct pel_water_desc *desc,
                                      const struct pel_water_body *body,
                                      double nm);

/* What it does with light that becomes that of wavelength `nm`; nothing where
 * the description has no `raman`. */
struct pel_raman pel_water_raman_at(const struct pel_water_desc *desc,
                                    const struct pel_water_body *body,
                                    double nm);

/* Attenuation of downward irradiance of a Jerlov type at wavelength i [1/m]:
 * Jerlov 1976, table XXVII, linear between its wavelengths. */
double pel_jerlov_attenuation(enum pel_jerlov type, int i);

/* The same of a water with a, b by Kirk 1984, Sun at the zenith:
 * K_d = √(a² + 0.235 a b). */
double pel_kirk_attenuation(double absorption, double scattering);

/* Fills *out. OUT_OF_RANGE for a value outside its range or not finite,
 * INVALID for an unknown word; *fault (NULL allowed) names the member. On
 * failure *out is not touched. */
PEL_CHECK enum pel_err pel_water_resolve(const struct pel_water_desc *desc,
                                         struct pel_water_body *out,
                                         struct pel_fault *fault);

/* Case 1 water of a chlorophyll concentration (clamped to its range), 1000 m
 * deep over a black bottom. */
struct pel_water_body pel_water_deep(double chlorophyll_mg_m3);

/* The body at wavelength i of pel_water_wavelength_nm. */
struct pel_medium pel_water_medium(const struct pel_water_body *body, int i);

/* Depth below which the bottom cannot be seen: 1/255 of its light returns,
 * by pel_kirk_attenuation of the clearest wavelength [m]. */
double pel_water_visible_m(const struct pel_water_body *body);

/* Words for the enums (`IA`, `north-atlantic`, `sand`); NULL past the last. */
const char *pel_jerlov_word(int i);
const char *pel_water_name_word(int i);
const char *pel_particles_word(int i);
const char *pel_bottom_word(int i);
