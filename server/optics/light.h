/* The lights of the sky: bodies so far away that their light falls from one
 * direction. Each has its own sky light, glitter and shadow, and pictures show
 * the sum. This is their only list; a new light needs a number in
 * shaders/lib/blocks.h, a row in light.c and its position in scene/snapshot.c.
 * Any thread. */
#pragma once

#include <stdbool.h>

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
    double radius_rad;         /* 0: the body's */
    struct pel_vec3 source; /* unit, from it towards what lights it; 0: none */
    int body;               /* PEL_LIGHT_*, of ordered lists */
};

/* [rad] */
double pel_light_radius(const struct pel_light *light);

/* The Sun alone, at full strength in this direction; the others give none. */
void pel_lights_of_sun(struct pel_vec3 direction,
                       struct pel_light out[PEL_LIGHTS]);

/* A Moon in this direction, of which the share `lit` of the disc is lit, at
 * distance_m; its bright limb is on the Sun's side. */
struct pel_light pel_light_moon(struct pel_vec3 direction, struct pel_vec3 sun,
                                double lit, double distance_m);

/* Light on the level sea under a clear sky [lx] of the Sun at this sine of
 * elevation, within a factor of two: for what can be left out. */
double pel_light_level(double sine);
/* The same of any light that has its `body`. */
double pel_light_of(const struct pel_light *light);

/* What of the lights a picture shows: the first `lit` give light, the first
 * `discs` may be seen. */
struct pel_lights_shown {
    int lit, discs;
};

/* Puts the lights, given in the order of their bodies, into that in which
 * shaders have them: the Sun first as long as some of its disc is up, or the
 * Moon gives less than PEL_LIGHT_LEAST of the light on the level sea; below
 * the horizon behind a Moon that gives more, and left out when it gives less
 * than that share itself. */
#define PEL_LIGHT_LEAST 2e-4
struct pel_lights_shown pel_lights_order(struct pel_light lights[PEL_LIGHTS]);

/* Of ordered lights, `lit` of them, and of a night's own light: roughly what
 * falls on the level sea [lx]; and the matrix of optics/colour.h for their
 * light, each by its own elevation, mixed by their shares of it. */
double pel_lights_level(const struct pel_light *lights, int lit, bool night);
void pel_lights_colours(const struct pel_light *lights, int lit, bool night,
                        double m[9]);

/* Weights of the scotopic luminance in such light (pel_colour_rods). */
void pel_lights_rods(const struct pel_light *lights, int lit, bool night,
                     double weights[3]);
