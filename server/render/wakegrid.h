/* Where tiles of ship waves lie, so that shaders ask few of them
 * (lib/wake.glsl). Pure computation, any thread. */
#pragma once

#include <stddef.h>

#include "shaders/lib/blocks.h"

/* The grid over the first so many of out->wakes, at most PEL_WAKE_LAYERS. The
 * rest of *out is zero. */
void pel_wake_grid_fill(size_t layers, struct pel_block_wakes *out);
