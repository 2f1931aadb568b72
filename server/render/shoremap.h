/* What waves over a bottom are (ocean/shore.h), for the shaders. Render thread
 * only. */
#pragma once

#include <epoxy/gl.h>

#include "ocean/shore.h"

/* Zeroed before its first use. */
struct pel_shore_map {
    GLuint nodes;
    uint64_t serial; /* whose they are */
};

/* The shore's nodes, for the programs of a sea of cascades or of trochoids, and
 * where the nadir of an eye lies in them. */
void pel_shore_map_bind(struct pel_shore_map *map,
                        const struct pel_shore *shore, bool cascades,
                        double east_m, double north_m,
                        struct pel_block_shore *out);
void pel_shore_map_finish(struct pel_shore_map *map);
