/* The modes of the tiles on which a ship's waves stand (wake.h), and what
 * straight pieces of its track put into them. The same bits on every
 * processor. Immutable once made, any thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/err.h"
#include "ocean/hullform.h"
#include "ocean/lanes.h"
#include "ocean/wake.h"

/* Packets count in full in this share of a tile's side about its middle, and
 * less and less up to the second: an edge would diffract waves back into the
 * tile. */
#define PEL_WAKE_WHOLE 0.30
#define PEL_WAKE_HELD 0.47

/* Modes side by side, each for the waves that travel along k and along −k. */
struct pel_wake_bunch {
    pel_lanes m, n;   /* mode numbers */
    pel_lanes ux, uy; /* k/|k| */
    pel_lanes k;      /* rad/m */
    pel_lanes turns;  /* ω / 2π */
    pel_lanes group;  /* m/s */
    pel_lanes gain;   /* of a source: share of the tile, depth, spline, 1/L² */
};

struct pel_wake_amplitudes { /* of a bunch */
    pel_lanes re, im, back_re, back_im;
};

struct pel_wake_band {
    double length_m; /* the tile's side */
    double slowest_mps, fastest_mps;
    int bunch_count;
    struct pel_wake_bunch *bunch;
};

/* What hulls of these measures have in common in water of this depth. Without
 * the far tile its waves are the next one's, and the first is one like that. */
struct pel_wake_basin {
    struct pel_hull hull;
    double depth_m;
    bool far;
    struct pel_hull_form form;
    struct pel_wake_band band[PEL_WAKE_TILES];
};

/* One for all that ask for the same at a time; put it back. NO_MEMORY. */
PEL_CHECK enum pel_err pel_wake_basin_get(const struct pel_hull *hull,
                                          double depth_m, bool far,
                                          const struct pel_wake_basin **out);
void pel_wake_basin_put(const struct pel_wake_basin *basin); /* NULL: none */

/* A piece of track: straight, at constant speed. */
struct pel_wake_leg {
    double begin_s, end_s;
    double x, y;   /* at its end */
    double vx, vy; /* m/s */
};

/* Adds what the legs have put into a band's modes, as it is at time_s (not
 * before their ends). place: the tile's middle, beyond whose border packets are
 * left out; NULL: they are all within. but: the middle of another of this side
 * that has what is in it; NULL: none. */
void pel_wake_band_add(const struct pel_wake_basin *basin, int band,
                       const struct pel_wake_leg *legs, int count,
                       double time_s, const struct pel_vec2 *place,
                       const struct pel_vec2 *but,
                       struct pel_wake_amplitudes *to);

/* Those of `from` as they are later_s on. */
void pel_wake_band_turn(const struct pel_wake_band *band,
                        const struct pel_wake_amplitudes *from, double later_s,
                        struct pel_wake_amplitudes *to);
