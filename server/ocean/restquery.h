/* Queries of a sea whose waves are changed where the water rests: by areas
 * (areas.h), by the bottom (shore.h). Any thread. */
#pragma once

#include "ocean/sea.h"

struct pel_wash; /* wash.h */

/* pel_sea_query and pel_sea_displace of such a sea, and the wash of ships where
 * it is not NULL. The slopes of what changes
 * the waves count in the normal; that an area moves does not count in
 * velocities. */
void pel_rest_query(const struct pel_sea *sea, const struct pel_vec2 *points,
                    size_t n, double time_s, bool moving,
                    const struct pel_wash *wash,
                    struct pel_surface_sample *out);
struct pel_vec3 pel_rest_displace(const struct pel_sea *sea, double x_m,
                                  double y_m, double time_s);
