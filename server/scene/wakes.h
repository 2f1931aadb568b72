/* The waves of the ships of a snapshot, of any moment: from the tracks of its
 * entities and their poses reckoned on. Any thread but the control thread's,
 * which must not wait for them. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "ocean/wake.h"
#include "pelagos.pb-c.h"
#include "scene/snapshot.h"

/* Ships whose waves a picture has: the first of the state. */
#define PEL_WAKES 8

/* What of the state their waves are made from; reference counted. NULL: no
 * entity makes waves. The snapshot has its ships. */
struct pel_wakes *pel_wakes_of(const Pelagos__State *state,
                               const struct pel_snapshot *snapshot);
struct pel_wakes *pel_wakes_ref(struct pel_wakes *wakes);
void pel_wakes_unref(struct pel_wakes *wakes);

/* Writes where a ship under its helm was to its entity of the state. */
void pel_wakes_keep(const struct pel_wakes *wakes, const Pelagos__State *state,
                    double time_s, Pelagos__Entity *entity);

/* The waves of one moment. */
struct pel_wake_moment {
    size_t count;
    uint32_t id[PEL_WAKES]; /* of the entities */
    struct pel_wake wake[PEL_WAKES];
};

/* The waves at time_s, or NULL: none. About a millisecond a ship, or some tens
 * where its past is summed up anew; threads that ask for the same moment share
 * that. pel_wake_moment_unref. */
const struct pel_wake_moment *pel_wakes_at(const struct pel_wakes *wakes,
                                           double time_s);

/* The same without the tiles that have no part in what pel_wakes_before reads
 * for places of `of`: as little of that work as it takes. */
const struct pel_wake_moment *pel_wakes_within(const struct pel_wakes *wakes,
                                               double time_s,
                                               const struct pel_box *of);

/* Does that work ahead, tile by tile while go_on(user); true: it is done. */
bool pel_wakes_prepare(const struct pel_wakes *wakes, double time_s,
                       const struct pel_box *of, bool (*go_on)(void *user),
                       void *user);
void pel_wake_moment_unref(const struct pel_wake_moment *moment);

/* What is kept of moments and pasts, of all scenes together: at most 112 MiB
 * (a moment of eight ships is 24), and besides what is in use. */
#define PEL_WAKES_MOST_BYTES ((size_t)112 << 20)
size_t pel_wakes_bytes(void);

/* Whether there are waves of others than entity `but` within radius_m of a
 * place: so that those far from all need no moment. Any thread. */
#define PEL_WAKES_ALL (-1)
bool pel_wakes_reach(const struct pel_wakes *wakes, int64_t but, double time_s,
                     struct pel_vec2 place, double radius_m);

/* Where what is above a place comes from: the wakes carry water sideways. But:
 * the entity whose own waves are left out. */
struct pel_vec2 pel_wakes_before(const struct pel_wake_moment *moment,
                                 int64_t but, struct pel_vec2 place,
                                 struct pel_wake_shift *there);

/* Adds the wakes to what the sea has at pel_wakes_before. */
void pel_wakes_onto(const struct pel_wake_shift *there,
                    struct pel_surface_sample *sample);
