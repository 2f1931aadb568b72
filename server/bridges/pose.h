/* The pose of an entity at this moment, as an edit of part of it must start
 * from: a patch gives its pose the present time, so what it leaves out would
 * be the place of the last fix. Control thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "pelagos.pb-c.h"

struct pel_scene;

/* Sets latitude, longitude, heading and pose_time of *out to what the scene
 * reckons for now (pose_time always). False: no such entity. */
bool pel_bridge_reckon(struct pel_scene *scene, uint32_t id,
                       Pelagos__Entity *out);
