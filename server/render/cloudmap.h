/* The field of clouds as a texture (optics/clouds.h). Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "optics/clouds.h"

struct pel_cloud_map {
    GLuint field;
    enum pel_cloud_genus genus;
    uint32_t seed;
};

/* Makes it current on its unit; where there are none, does nothing. A new genus
 * or seed takes some tenths of a second. */
void pel_cloud_map_bind(struct pel_cloud_map *map,
                        const struct pel_clouds *clouds);
void pel_cloud_map_finish(struct pel_cloud_map *map);
