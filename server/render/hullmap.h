/* A model's hull as maps of what the sea meets: its lowest surface over its
 * plan, and its sides by depth. Any thread. */
#pragma once

#include "models/model.h"

/* Heights of the model's lowest surface at the middles of PEL_HULL_LENGTH times
 * PEL_HULL_BREADTH texels over its plan, m, row by row from its least x and y;
 * PEL_NO_HULL where it has none, or only one under water outside of what the
 * waterline encloses. */
void pel_hull_below(const struct pel_model *model, float *out);

/* Half breadths, m, at the middles of PEL_HULL_LENGTH times PEL_HULL_ROWS
 * texels over its length and from its lowest point to the waterline, row by row
 * from there: the least y, to starboard, then the least -y; PEL_NO_HULL where
 * the model has nothing. In the steep sides, which the map from below holds in
 * a texel or less, these are fine. */
void pel_hull_sides(const struct pel_model *model, float *out);
