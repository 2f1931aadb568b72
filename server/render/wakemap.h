/* The waves of ships in a texture, a layer a tile. Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "render/renderer.h"
#include "shaders/lib/blocks.h"

/* Software devices still read the last moment's. */
#define PEL_WAKE_SETS 2

/* Zeroed before its first use. */
struct pel_wake_map {
    GLuint sets[PEL_WAKE_SETS];
    int current;
};

/* Loads the wakes of a moment, where there are any. */
void pel_wake_map_load(struct pel_wake_map *map,
                       const struct pel_environment *env);
/* Binds them for passes that shade; the tiles as seen from a nadir. */
void pel_wake_map_bind(const struct pel_wake_map *map,
                       const struct pel_environment *env, double east_m,
                       double north_m, struct pel_block_wakes *out);
void pel_wake_map_again(const struct pel_wake_map *map);
void pel_wake_map_finish(struct pel_wake_map *map);
