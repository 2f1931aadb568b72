/* The wash of ships: the turbulent wake, in which short waves are lower, foam
 * of the bow wave and of the screw, bubbles. A function of (track, time); no
 * history.
 *
 * Water that a ship passed at τ lies where it was left, is t − τ old at t, and
 * belongs to a line of nodes, newest first: of what the stern left, pushed aft
 * by the screw, or forward where it turns astern; of what the stem left. Across
 * a line bands have a half-width each:
 *   wake    B/2 (1 + 256 x/L)^(1/5), x sailed since: the beam at the stern, and
 *           far from it 4 B (x/4L)^(1/5) in all (Milgram, Skop, Peltzer,
 *           Griffin 1993 for the power; Zilman, Zapolski, Marom 2004 for 4 B at
 *           4 L)
 *   foam    S' = −S/τ + R e^{−a/T}: what the surface has, and what bubbles that
 *           rise from the screw's depth, or from where the bow wave plunges,
 *           bring to it
 *   bow     of the wave of bowwave.h: where its sheet falls or its front
 *           breaks, a streak that goes outward; between it and the hull what
 *           the front has left
 *   race    w = √(U² + C V²) − U behind an actuator disc of thrust loading C
 *           (Rankine and Froude), V the speed at which the push is the drag
 *
 * Places are of the water at rest, as areas' (ocean/areas.h). Twin of
 * shaders/lib/wash.glsl. Immutable once indexed; any thread. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "base/vec.h"
#include "ocean/bowwave.h"
#include "shaders/lib/blocks.h"

#define PEL_WASH_POINTS 500    /* of a track, at most */
#define PEL_WASH_KEPT_S 1200.0 /* older water is as all other */
#define PEL_WASH_CALM 0.7      /* of short waves' heights is lost at most */
#define PEL_WASH_CALM_LIFE_S 600.0
#define PEL_WASH_BUBBLES_LIFE_S 150.0
#define PEL_WASH_LOADING 1.5 /* C */
#define PEL_WASH_CELLS 128   /* of the index, a side at most */

struct pel_wash_point {
    double time_s;
    double x_m, y_m;    /* of amidships */
    double heading_rad; /* clockwise from north; NAN: as it goes */
    double push_mps;    /* V from here on, < 0 astern; NAN: as it goes */
};

#define PEL_WASH_STATIONS PEL_BOW_STATIONS
struct pel_wash_ship {
    double length_m, beam_m, draught_m; /* > 0 */
    /* Waterline: where its ends are forward of amidships, and half-breadths in
     * the middles of as many parts from the stem aft. */
    double stem_m, stern_m;
    double half_m[PEL_WASH_STATIONS];
    int count; /* of points, rising in time */
    struct pel_wash_point point[PEL_WASH_POINTS];
};

/* Between a node and the next of its line everything is linear. */
struct pel_wash_node {
    double x_m, y_m, tx, ty; /* unit vector towards the next */
    double half_m, calm;     /* wake; what short waves lose amid, 0..1 */
    double core_m, core;     /* foam amid; share of the water, 0..1 */
    double side_m, side_half_m, side; /* foam on both sides, its middle off */
    double bubbles;                   /* 0..1 amid */
    bool begins;                      /* a line */
};

struct pel_wash {
    atomic_uint users;
    size_t count, room;
    struct pel_wash_node *node;
    double west_m, south_m, cells_per_m;
    int columns, rows;
    uint32_t
        *cell; /* rows of columns: first entry of the list << 10 | number */
    size_t listed;
    uint32_t *list; /* nodes that begin a piece which a cell may touch */
};

/* What it does to the water at a place. */
struct pel_washed {
    double up;      /* short waves are times */
    double foam;    /* mean share that dense foam hides, 0..1 */
    double bubbles; /* 0..1 */
};

/* A waterline of parabolic ends, an entrance of 0.3 and a run of 0.15 of the
 * length, where no other is known. */
void pel_wash_waterline(struct pel_wash_ship *ship);

/* NO_MEMORY. */
PEL_CHECK enum pel_err pel_wash_create(struct pel_wash **out);
/* One more user, who destroys it too. */
const struct pel_wash *pel_wash_ref(const struct pel_wash *wash);
void pel_wash_destroy(const struct pel_wash *wash); /* NULL: none */

/* Adds the lines of a ship at time_s: points that are later have no part in
 * them, and the last one is at time_s. NO_MEMORY. */
PEL_CHECK enum pel_err pel_wash_add(struct pel_wash *wash,
                                    const struct pel_wash_ship *ship,
                                    double time_s);

/* After the last ship. NO_MEMORY. */
PEL_CHECK enum pel_err pel_wash_index(struct pel_wash *wash);

/* At the water that rests at (x, y), as a footprint sees it. */
struct pel_washed pel_wash_at(const struct pel_wash *wash, double x, double y,
                              double footprint_m);
/* Whether there is any within PEL_WASH_NEAR_M of the place, at least. */
#define PEL_WASH_NEAR_M 12.0
bool pel_wash_near(const struct pel_wash *wash, double x, double y);
/* `up` of no footprint; *slope: its gradient, 1/m. */
double pel_wash_factor(const struct pel_wash *wash, double x, double y,
                       struct pel_vec2 *slope);

/* As shaders read it: words of wash.glsl, 12 floats a node from the eye's nadir
 * on, the list, the cells. NULL: how many there are. */
size_t pel_wash_words(const struct pel_wash *wash, double east_m,
                      double north_m, uint32_t *out);

/* The parts. Half-width of the wake; the bow wave, of the waterline's mean
 * angle from the stem to the wave's crest; speed of the race over the water's;
 * how far it has come in age_s where the ship lies still: a round jet's, 6.2 w
 * D/x beyond 6.2 D (Rajaratnam 1976); share of foam left of what was there and
 * of what rises. */
double pel_wash_half_m(double beam_m, double length_m, double sailed_m);
struct pel_bow_wave pel_wash_bow(const struct pel_wash_ship *ship,
                                 double speed_mps, double *alpha_rad);
double pel_wash_race_mps(double speed_mps, double push_mps);
double pel_wash_reach_m(double race_mps, double screw_m, double age_s);
double pel_wash_foam_left(double age_s, double rising_s);
