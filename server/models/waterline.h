/* The waterline of a model that floats upright, by rays to its port side just
 * below the water. Any thread. */
#pragma once

#include "models/model.h"

#define PEL_WATERLINE_PARTS 24

struct pel_model_waterline {
    double stem_m, stern_m;             /* its ends, forward of amidships */
    double half_m[PEL_WATERLINE_PARTS]; /* half-breadths in the middles of
                                           equal parts, from the stem aft */
};

/* False: nothing of it is in the water amid. Some tens of microseconds. */
bool pel_model_waterline(const struct pel_model *model,
                         struct pel_model_waterline *out);
