/* The height field on the GPU, and its constants for the shaders
 * (shaders/lib/seabed.glsl). Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "render/renderer.h"
#include "render/uniforms.h"
#include "shaders/lib/blocks.h"

/* The highest nodes of squares (blocks.h), one level behind the other. */
struct pel_seabed_tops {
    int levels;
    int columns[PEL_SEABED_TOP_LEVELS], rows[PEL_SEABED_TOP_LEVELS];
    size_t first[PEL_SEABED_TOP_LEVELS]; /* of a level, in `highest` */
    size_t count;
    float *highest;
};

struct pel_seabed_map {
    uint64_t serial;      /* of the field that is there; 0: none */
    GLuint heights, tops; /* texture; buffer */
    double steepest;      /* of its slopes, a tangent */
    struct pel_seabed_tops squares;
};

/* NO_MEMORY. Finish accepts what a failed init left. */
PEL_CHECK enum pel_err pel_seabed_tops_init(struct pel_seabed_tops *tops,
                                            const struct pel_seabed *bed);
void pel_seabed_tops_finish(struct pel_seabed_tops *tops);

/* Makes the map that of the field (NULL: frees it). NO_MEMORY. */
PEL_CHECK enum pel_err pel_seabed_map_fit(struct pel_seabed_map *map,
                                          const struct pel_seabed *bed);
/* Binds the field for shading; other passes use the same binding points. */
void pel_seabed_map_bind(const struct pel_seabed_map *map);
void pel_seabed_map_finish(struct pel_seabed_map *map);

/* Depths at which the water's light is needed over this field. */
struct pel_water_depths pel_seabed_depths(const struct pel_environment *env);

/* What the shaders know for an eye over east_m, north_m. `left`: slope variance
 * that footprints leave (uniforms.h); `beams`: of the lights, just below the
 * surface (waterlight.h). */
void pel_fill_seabed(const struct pel_environment *env,
                     const struct pel_seabed_map *map,
                     const struct pel_variance left[PEL_VARIANCE_COUNT],
                     const double beams[PEL_LIGHTS], double east_m,
                     double north_m, struct pel_block_seabed *out);
