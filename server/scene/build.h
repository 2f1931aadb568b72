/* Making a snapshot from a tested, complete state. Control thread; seas any
 * thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "pelagos.pb-c.h"
#include "scene/fleet.h"
#include "scene/snapshot.h"

/* A sea that several snapshots share, built lazily: many patches may
 * come before the first picture or query of it. */
struct pel_ground; /* ground.h */
struct pel_shared_sea;

/* What a sea is made with besides the state. */
struct pel_sea_means {
    int wave_count;
    const char *spectra; /* directory of measured spectra; NULL: none */
};

/* The sea that the state asks for over this bottom: `present` (NULL allowed)
 * with another reference where it is the same, else a new one. `ground` NULL:
 * for numbers, whatever the bottom. *fault (NULL allowed) says why no sea could
 * be made; a measured spectrum is read here. */
PEL_CHECK enum pel_err pel_shared_sea_get(const Pelagos__State *state,
                                          const struct pel_sea_means *means,
                                          const struct pel_ground *ground,
                                          struct pel_shared_sea *present,
                                          struct pel_shared_sea **out,
                                          struct pel_fault *fault);
/* Whether `sea` is the one that the state asks for over this bottom. */
bool pel_shared_sea_is(const struct pel_shared_sea *sea,
                       const Pelagos__State *state,
                       const struct pel_sea_means *means,
                       const struct pel_ground *ground);
/* Whether that one would be of the same measured spectrum, or of none. */
bool pel_shared_sea_same_record(const struct pel_shared_sea *sea,
                                const Pelagos__State *state);
struct pel_shared_sea *pel_shared_sea_ref(struct pel_shared_sea *sea);

/* Whether it is built, so that looking at it takes no time. Any thread. */
bool pel_shared_sea_built(const struct pel_shared_sea *sea);

/* Any thread; aborts without memory. */
const struct pel_sea *pel_shared_sea_value(struct pel_shared_sea *sea);

/* The description that a sea of `state` is built from, a measured spectrum
 * left out. */
void pel_sea_describe(const Pelagos__State *state, int wave_count,
                      struct pel_sea_desc *out);

/* Mathematical direction (radians from east) that waves or wind go to, of the
 * compass direction (degrees from north) that they come from. */
double pel_goes_to(double from_deg);
void pel_shared_sea_unref(struct pel_shared_sea *sea); /* NULL allowed */

/* A snapshot with one reference; takes its own of the sea, of the bottom
 * (NULL: flat), of the sky's picture (NULL: none), of the models (NULL: none)
 * and of the weather (NULL: none). A ship whose helm is on goes on
 * from the one in `going` (by the index of its entity; NULL, all or one: none)
 * or else begins at clock.time with the pose of its entity then. */
const struct pel_snapshot *pel_snapshot_build_going(
    const Pelagos__State *state, struct pel_shared_sea *sea,
    const struct pel_seabed *seabed, const struct pel_panorama *panorama,
    const struct pel_fleet *fleet, const struct pel_weather *weather,
    const struct pel_sailing *const going[PEL_MAX_ENTITIES]);

/* The same snapshot with its ships, all of them, further on. */
const struct pel_snapshot *
pel_snapshot_with_ships(const struct pel_snapshot *s,
                        const struct pel_sailing *ships);

/* The motion of a ship of the snapshot. Any thread. */
void pel_snapshot_ship_motion(const struct pel_snapshot *s,
                              const struct pel_ship *ship, double time_s,
                              struct pel_ship_motion *out);

/* A mark of its way as the state keeps it; the origin in degrees. */
void pel_ship_mark_to_state(double latitude, double longitude,
                            const struct pel_ship *ship,
                            const struct pel_ship_mark *mark,
                            Pelagos__TrackPoint *out);

/* Writes the ships' motion at time_s as the poses of their entities and the
 * rates of their helms; `state` is what the snapshot was built from, or like
 * it. */
void pel_snapshot_ships_to_state(const struct pel_snapshot *s, double time_s,
                                 Pelagos__State *state);

/* pel_snapshot_build_going from the state's pose. */
const struct pel_snapshot *pel_snapshot_build(const Pelagos__State *state,
                                              struct pel_shared_sea *sea,
                                              const struct pel_seabed *seabed);
