/* The picture that stands for the sky, on the device. Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "render/renderer.h"
#include "shaders/lib/blocks.h"

struct pel_panorama_map {
    GLuint texture;
    uint64_t id; /* of the picture that it has */
};

/* Brings env->panorama, not NULL, to the device. */
void pel_panorama_map_fit(struct pel_panorama_map *map,
                          const struct pel_environment *env);
void pel_panorama_map_finish(struct pel_panorama_map *map);

/* What the sky's tables depend on; zeros without a picture. */
#define PEL_PANORAMA_KEYS 3
void pel_panorama_key(const struct pel_environment *env,
                      double key[PEL_PANORAMA_KEYS]);

/* Rows from its texels to spectral radiance, the inverse of m, which leads
 * from there to Rec. 709 [cd/m²]; w: its azimuth, texels a radian as log2. */
void pel_panorama_fill(const struct pel_environment *env, const double m[9],
                       struct pel_vec4 out[3]);
