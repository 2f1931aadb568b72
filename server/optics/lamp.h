/* Lamps: points that give light, each with an intensity by direction. What a
 * list of them is made of is the scene's matter, what a picture shows of it the
 * renderer's. Any thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/vec.h"

#define PEL_MAX_LAMPS 1024
#define PEL_NO_ENTITY UINT32_MAX

/* A lamp at a moment, lit. Places and axes as scene/snapshot.h has them: x
 * east, y north, z up. */
struct pel_lamp {
    uint32_t entity; /* id of what carries it; PEL_NO_ENTITY: nothing does */
    double east_m, north_m, altitude_m;
    /* Where it is brightest: linear Rec. 709 whose luminance is in candela.
     * A saturated colour may have a negative part. */
    double intensity_cd[3];
    struct pel_vec3 ahead, up; /* unit, at right angles; bearings count from
                                  ahead, clockwise seen from above */
    /* It shines from this bearing clockwise over the arc (2 π: all round), and
     * falls to nothing evenly over the cut-off beyond each end. */
    double from_rad, arc_rad, cutoff_rad;
    double spread_rad; /* above and below the level of `up`: full up to this,
                          half at twice this, as a bell beyond; π/2: every
                          height */
    double beam_rad;   /* > 0: a beam instead, a bell about `ahead` that has
                          half its strength at this angle */
    double size_m;     /* diameter of what is seen to glow */
    bool unseen;       /* itself, size_m wide; what it lights and what mirrors
                          it are seen */
    int mirrors;       /* for how many, itself among them, the sea mirrors it
                          and things are lit by it; 0: itself; -1: for none */
};

/* Share of its intensity towards a unit direction from it, 0 .. 1. */
double pel_lamp_towards(const struct pel_lamp *lamp, struct pel_vec3 direction);

/* Luminous intensity of a light that is seen at the nominal range [nautical
 * miles] where the air lets the share `per_mile` through a mile: COLREGS Annex
 * I, section 8 (per_mile 0.8, threshold 2e-7 lx); marks' lights: IALA E-200-2
 * (per_mile 0.74). [cd] */
double pel_lamp_intensity(double range_nm, double per_mile);
