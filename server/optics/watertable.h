/* The light that leaves the water, all orders, as a table for brute-force
 * renderers (tests/validate; the shaders' maps are made from waterkernel.h):
 * radiance before the surface's own Fresnel factor as a function of the
 * line of sight, for one Sun and one water. */
#pragma once

#include "base/err.h"
#include "optics/atmosphere.h"
#include "optics/waterbody.h"
#include "shaders/lib/blocks.h"

#define PEL_WATER_TABLE_SIZE 32

/* What happened to the light in the water. */
enum pel_water_part {
    PEL_WATER_SINGLE = PEL_PART_SINGLE, /* scattered once */
    PEL_WATER_SECOND = PEL_PART_SECOND, /* scattered twice */
    PEL_WATER_HIGHER =
        PEL_PART_HIGHER, /* more often, or mirrored by the surface from below */
    PEL_WATER_BOTTOM =
        PEL_PART_BOTTOM, /* reflected by the bottom, scattered or not */
    PEL_WATER_PARTS,
};

/* Depths that tables are made for: `levels` of them, 1..PEL_WATER_LEVELS_MAX,
 * level with each other on a logarithmic scale from first_m to last_m
 * (PEL_DEPTH_MIN..MAX); one level: first_m. Looked up as in
 * shaders/lib/water.glsl. */
struct pel_water_depths {
    int levels;
    double first_m, last_m;
};

/* Depth of level i of a set [m]. */
double pel_water_depth(const struct pel_water_depths *depths, int i);

/* Texels [zenith][azimuth] of r, g, b (680, 550, 440 nm) and 0, for a linear
 * filter with clamped edges:
 *   u = (½ + 31 (1 + cos φ) / 2) / 32, φ between the line of sight and the
 *       Sun in azimuth, 0 looking towards it;
 *   v = (½ + 31 sin θ) / 32, θ the zenith angle, above the flat surface, of
 *       the direction to the eye.
 * The radiance just above the surface is, with the surface's reflectance F
 * (Fresnel's, or the mean F̄ of a rough one),
 *   L_w = (1 − F) (E_sun · sun + E_sky · sky),
 * E_sun normal to the beam, E_sky horizontal. Sun below the horizon: as at
 * the horizon, where `sun` is 0. */
struct pel_water_table {
    float sun[PEL_WATER_TABLE_SIZE][PEL_WATER_TABLE_SIZE][4]; /* 1/sr */
    float sky[PEL_WATER_TABLE_SIZE][PEL_WATER_TABLE_SIZE][4]; /* 1/sr */
};

/* Sky radiance by direction, any unit: only its shape counts, the table is for
 * a unit of its horizontal irradiance. Zenith i·90°/23, azimuth from the Sun's
 * j·180°/16; the other half is its mirror image. */
#define PEL_WATER_SKY_ZENITHS 24
#define PEL_WATER_SKY_AZIMUTHS 17
struct pel_water_sky {
    struct pel_rgb radiance[PEL_WATER_SKY_ZENITHS][PEL_WATER_SKY_AZIMUTHS];
};

/* The clear sky at sea level (tabulated atmosphere), about 3 ms. */
void pel_water_sky_clear(const struct pel_atmosphere *air,
                         double sun_zenith_rad, struct pel_water_sky *out);

/* Builds the table for a Sun at sun_zenith_rad (0..π, NaN: π/2) and a sky
 * (NULL: equally bright everywhere, half the cost). About 8 ms on one core
 * with a NULL sky. Within 1/255 of the table's maximum of the reference
 * (PEL_ORDINATES_REFERENCE nodes), the texels and what a linear filter makes
 * of them. The body must be one pel_water_resolve made. NO_MEMORY. Any
 * thread. */
PEL_CHECK enum pel_err pel_water_table_build(const struct pel_water_body *body,
                                             double sun_zenith_rad,
                                             const struct pel_water_sky *sky,
                                             struct pel_water_table *out);

/* What leaves the water towards the unit vector `view` through a facet of unit
 * normal `normal` (facing the view), before the facet's Fresnel factor, with
 * the Sun in direction `sun` and its light on the sea: twin of leaving_water
 * in shaders/lib/water.glsl. The table is of that Sun. */
struct pel_rgb pel_water_table_leaving(const struct pel_water_table *table,
                                       struct pel_vec3 view,
                                       struct pel_vec3 normal,
                                       struct pel_vec3 sun,
                                       struct pel_rgb sun_irradiance,
                                       struct pel_rgb sky_irradiance);

/* What a linear filter fetches from `texels` (sun or sky of a table): twin of
 * the shader's fetch. sin_zenith 0..1, cos_azimuth −1..1. */
struct pel_rgb pel_water_table_fetch(
    const float texels[PEL_WATER_TABLE_SIZE][PEL_WATER_TABLE_SIZE][4],
    double sin_zenith, double cos_azimuth);
