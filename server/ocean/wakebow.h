/* The crest of the bow wave beside the hull, which a thin ship's linear wave
 * has not: what is missing to the height of bowwave.h is added to the tile with
 * the hull, so that pictures and queries have it from the same splines. As high
 * as that tile resolves it: ridges are at least three texels long each way from
 * the crest and two and a half wide, and lower by as much as they are longer.
 * Any thread. */
#pragma once

#include "ocean/wake.h"

#define PEL_WAKE_BOW_S 2.0 /* of the past, whose mean speed counts */
/* Of the draught: of what is higher the most is a thin sheet and spray. */
#define PEL_WAKE_BOW_MOST 0.6

struct pel_wake_raised {
    const struct pel_wake_bow *bow;
    double x_m, y_m, ex, ey; /* of the stem; unit vector to where it goes */
    double speed_mps, high_m;
    double crest_m, before_m, behind_m, beside_m; /* of the ridge */
    double share;                                 /* that is resolved */
};

/* All but the place. False: it raises none. */
bool pel_wake_bow_of(const struct pel_wake_track *track, double speed_mps,
                     const struct pel_wake_tile *tile,
                     struct pel_wake_raised *out);
/* Beside the hull, to port, at the crest. */
struct pel_vec2 pel_wake_bow_crest(const struct pel_wake_raised *raised);
/* Raises the tile's texels where the water stands at thin_m at the crests. */
void pel_wake_bow_add(const struct pel_wake_raised *raised, double thin_m,
                      const struct pel_wake_tile *tile);
