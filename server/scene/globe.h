/* The Earth as it is drawn: about an eye the map is laid on a sphere, so that
 * the horizon dips and what is far sinks (shaders/mesh.comp). Pure functions,
 * any thread. Local frame of scene/snapshot.h; offsets are straight lines from
 * the eye, east, north and up. */
#pragma once

#include "base/vec.h"
#include "optics/atmosphere.h"

/* The place on the map, and the altitude there, of what lies at `offset`. */
struct pel_vec3 pel_globe_at(struct pel_vec3 eye, struct pel_vec3 offset);

/* The inverse, to 1000 km. */
struct pel_vec3 pel_globe_offset(struct pel_vec3 eye, struct pel_vec3 at);
