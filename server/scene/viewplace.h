/* Where a view's camera stands, and whither it looks before its own yaw, pitch
 * and roll turn it: the schema's View.entity, at, orbit, satellite, waypoints
 * and lookAt. A function of the snapshot and of simulated time. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "base/vec.h"
#include "pelagos.pb-c.h"

struct pel_snapshot;
struct pel_way; /* waypoints.h */

enum pel_stand {
    PEL_STAND_CARRIED, /* by an entity, or at the origin */
    PEL_STAND_AT,
    PEL_STAND_ORBIT,
    PEL_STAND_SATELLITE,
    PEL_STAND_WAY,
};

/* Degrees, metres above altitude 0. */
struct pel_geo_place {
    double latitude, longitude, height_m;
};

struct pel_view_place {
    enum pel_stand stand;
    struct pel_geo_place at; /* of the camera; of an orbit's middle, where
                                `about` is none; a satellite's height */
    double east_m, north_m;  /* of `at`, in the local frame */
    double turned_rad;       /* there: pel_geo_turn */
    int about;               /* entity in an orbit's middle, -1: none */
    double radius_m, elevation_rad;
    double angle_rad, rate_rps; /* at simulated time 0, and its rate: of an
                                   orbit the bearing, of a satellite the angle
                                   from the node */
    double inclination_rad, node_rad;
    struct pel_way *way;
    bool looks; /* at something: */
    int target; /* an entity, -1: a place */
    struct pel_geo_place target_at;
};

/* Of a view of a state that is tested. What it holds is to be given back. */
void pel_view_place_of(const Pelagos__State *state, const Pelagos__View *view,
                       struct pel_view_place *out);
void pel_view_place_ref(const struct pel_view_place *place);
void pel_view_place_unref(const struct pel_view_place *place);

/* Whether a view stands somewhere: in one place only, and whole. CONFLICT,
 * INVALID, OUT_OF_RANGE. */
PEL_CHECK enum pel_err pel_view_place_check(const Pelagos__State *state,
                                            const Pelagos__View *view,
                                            struct pel_fault *fault);

/* A camera's stance: place in the local frame, altitude, velocity over ground,
 * and right, forward and up in the local frame's axes before yaw. */
struct pel_stance {
    double east_m, north_m, altitude_m;
    struct pel_vec3 velocity_mps;
    struct pel_mat3 axes;
};

/* Of view `index` at time_s; in_waves: what carries it or what it looks at
 * floats in ship waves too, which waits for them. */
void pel_view_stance(const struct pel_snapshot *s, size_t index, double time_s,
                     bool in_wakes, struct pel_stance *out);
