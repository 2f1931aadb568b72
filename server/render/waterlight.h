/* The light that leaves the water, as a texture over the line of sight: from
 * optics/watertable.h, times the light of Sun and sky that the light pass
 * finds. Render thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stdint.h>

#include "optics/watertable.h"
#include "render/renderer.h"

/* Texture units: of the map while shading, of its parts in the light pass. */
enum {
    PEL_UNIT_WATER = 9,
    PEL_UNIT_WATER_SUN = 9,
    PEL_UNIT_WATER_SKY = 10,
};

/* Tables are built for Suns this far apart, and interpolated: a moving Sun
 * costs one table (some 10 ms) each two minutes. */
#define PEL_WATER_SUN_STEP_DEG 0.5

struct pel_water_light {
    GLuint sun, sky, map;       /* arrays; map as in shaders/lib/water.glsl */
    struct pel_water_body body; /* of the tables */
    struct pel_water_depths depths;
    double sun_z;
    /* At nodes[0], nodes[1], for each depth. */
    struct pel_water_table tables[2][PEL_WATER_LEVELS_MAX];
    int nodes[2];     /* zenith / step; −1: none */
    uint64_t version; /* counts changes of sun and sky */
};

void pel_water_light_init(struct pel_water_light *w);
void pel_water_light_finish(struct pel_water_light *w);

/* Brings `sun` and `sky` up to date with the water, its depths and the Sun's
 * zenith cosine; a function of these alone. */
void pel_water_light_update(struct pel_water_light *w,
                            const struct pel_environment *env);

/* The depths that are made for an environment. */
struct pel_water_depths
pel_water_light_depths(const struct pel_environment *env);
