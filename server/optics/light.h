/* The lights of the sky: bodies so far away that their light falls from one
 * direction. Each has its own sky light, glitter and shadow, and pictures show
 * the sum. This is their only list; a new light needs a number in
 * shaders/lib/blocks.h, a row in light.c and its position in scene/snapshot.c.
 * Any thread. */
#pragma once

#include "base/vec.h"
#include "optics/atmosphere.h"
#include "shaders/lib/blocks.h"

/* Constants of a light. Spectral values are at 680, 550, 440 nm. */
struct pel_light_body {
    const char *name;
    struct pel_rgb irradiance; /* normal to the beam above the air at full
                                  strength, W m⁻² nm⁻¹ */
    double angular_radius_rad;
    double solid_angle_sr;
    /* Darkening towards the limb by √(1 − r²) to the power of this (Hestroffer
     * and Magnan 1998); 0: evenly bright. */
    struct pel_rgb limb;
};
extern const struct pel_light_body pel_light_bodies[PEL_LIGHTS];

/* A light at a moment. */
struct pel_light {
    struct pel_vec3 direction; /* unit, towards it */
    double strength;           /* of the body's irradiance, ≥ 0 */
};

/* The Sun alone, at full strength in this direction; the others give none. */
void pel_lights_of_sun(struct pel_vec3 direction,
                       struct pel_light out[PEL_LIGHTS]);
