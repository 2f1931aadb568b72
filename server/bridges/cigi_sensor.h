/* What CIGI's sensors answer: where their trackers stand. Control thread. */
#pragma once

#include "bridges/cigi_query.h"
#include "bridges/cigi_world.h"

/* One Sensor Response, or extended one, of each sensor that is on and tracks;
 * moves the trackers on to the moment. A target is the entity that was nearest
 * the view's axis when the tracker was switched to targets or ships; it is lost
 * when it leaves the picture. The gate is what a ship's length of 100 m would
 * fill, 8 pixels at least. Returns how many were emitted. */
size_t pel_cigi_sensor_answers(struct pel_cigi_world *world,
                               const struct pel_snapshot *s, double time_s,
                               uint32_t host_frame, pel_cigi_emit emit,
                               void *user);

/* Sensors that are on. */
unsigned pel_cigi_sensors_on(const struct pel_cigi_world *world);
