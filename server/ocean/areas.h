/* Areas of the sea, moving or not, in which waves shorter than
 * PEL_AREA_SHORTER_M are higher or lower: slicks, gusts, water that rain calms.
 * A function of (description, place of the water at rest, simulated time).
 *
 * Short waves are multiplied by a factor, 1 outside all areas, the product of
 * those of areas that lie over each other, 2 at most; their horizontal part by
 * it or by 1, whichever is less, so that the surface folds nowhere where it did
 * not. Twin of shaders/lib/areas.glsl. Any thread. */
#pragma once

#include <stdbool.h>

#include "ocean/sea.h"
#include "shaders/lib/blocks.h"

#define PEL_AREA_MOST PEL_AREA_FACTOR

/* Whether a description of areas is in its ranges. */
bool pel_areas_ok(const struct pel_sea_desc *d);

/* Distance of a place outside the edge's middle, < 0 inside; *away: its
 * gradient. The place is relative to the area's. */
double pel_area_distance(const struct pel_area_desc *area, double x, double y,
                         struct pel_vec2 *away);

/* Where it is at time_s. */
struct pel_vec2 pel_area_place(const struct pel_area_desc *area, double time_s);

/* The factor for water that rests at (x, y); *slope, unless NULL: its
 * gradient, 1/m. */
double pel_areas_factor(const struct pel_sea_desc *d, double x, double y,
                        double time_s, struct pel_vec2 *slope);
