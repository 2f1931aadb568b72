/* pel_sea_filtered over the cascades; see ocean/filter.h. `left` is not
 * filled. */
#pragma once

#include "ocean/filter.h"

struct pel_cascades;

PEL_CHECK enum pel_err pel_cascades_filtered(const struct pel_cascades *c,
                                             const struct pel_filter *filter,
                                             double footprint_m,
                                             const struct pel_vec2 *points,
                                             size_t n, double time_s,
                                             struct pel_filtered *out);
