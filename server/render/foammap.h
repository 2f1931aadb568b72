/* The tables of whitecaps on the GPU (ocean/foam.h, shaders/lib/foam.glsl).
 * Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "ocean/foam.h"

/* Zeroed before its first use. */
struct pel_foam_map {
    GLuint table, grain;
    struct pel_sea_desc desc; /* of the table's sea */
};

/* Makes the tables those of the sea and binds them for shading; nothing where
 * the sea has no foam, but where there is `wash` its structure. */
void pel_foam_map_bind(struct pel_foam_map *map, const struct pel_sea *sea,
                       bool wash);
void pel_foam_map_finish(struct pel_foam_map *map);
