/* The Earth's winds for the sea from high up (lib/spacesea.glsl: wind_at), and
 * how rough the scene's sea would be under each wind: slope variances by the
 * scene's own spectrum (ocean/directional.h), whitecaps by its own rule.
 * Nothing of it exists before the first view of a scene that has winds. Render
 * thread only. */
#pragma once

#include <epoxy/gl.h>

#include "render/renderer.h"
#include "weather/weather.h"

/* Zeroed before its first use. */
struct pel_wind_map {
    GLuint winds;    /* two layers: those of two times of a field */
    uint64_t serial; /* of the field */
    int first;       /* the number of the first of its times */
    GLuint rough;    /* by speed: slopes, foam; crests */
    struct pel_sea_desc rough_desc; /* of the sea that it is of */
    /* Slope variance along, across, by speed. */
    double slopes[PEL_WIND_SPEEDS][2];
};

/* Brings both to the environment, whose `weather` is not NULL: 20 ms when
 * another of its times begins, 0.1 s for another spectrum. NO_MEMORY. */
PEL_CHECK enum pel_err pel_wind_map_need(struct pel_wind_map *m,
                                         const struct pel_environment *env);
void pel_wind_map_bind(const struct pel_wind_map *m);

/* Afterwards: space_winds of the block `space`. */
struct pel_vec4 pel_wind_map_place(const struct pel_wind_map *m,
                                   const struct pel_environment *env);

void pel_wind_map_finish(struct pel_wind_map *m);
