/* When Sun and Moon rise, culminate and set. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"
#include "scene/scene.h"

/* Times are UTC seconds since 1970; NAN: not on that day. */
struct pel_body_day {
    double rise_s, culmination_s, set_s;
    double highest_rad; /* at the culmination; NAN without one */
};

/* The Sun's and the Moon's events in the 24 hours from midnight_s on (UTC) at a
 * place, radians: the upper limb at the horizon, refracted by 34′ and 16′ above
 * the centre; the culmination is where the elevation is greatest. Within 10 s
 * where the body crosses the horizon at more than 5°; in high latitudes as the
 * positions' 0.01° allow. Pure, any thread; some 50 ms for the Moon. */
void pel_almanac_sun(double midnight_s, double latitude_rad,
                     double longitude_rad, struct pel_body_day *out);
void pel_almanac_moon(double midnight_s, double latitude_rad,
                      double longitude_rad, struct pel_body_day *out);

/* Gets the answer, or the fault where err; both are the caller's. */
typedef void (*pel_almanac_done)(void *user, enum pel_err err,
                                 const struct pel_fault *fault,
                                 const Pelagos__Almanac *answer);

/* Answers on a thread of its own, as pel_scene_ask_spectrum. The query's values
 * are tested. Control thread. */
PEL_CHECK enum pel_err pel_scene_ask_almanac(struct pel_scene *scene,
                                             const Pelagos__AlmanacQuery *query,
                                             pel_almanac_done done, void *user,
                                             struct pel_fault *fault);
