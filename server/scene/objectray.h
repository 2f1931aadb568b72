/* Rays that meet things on the sea as they are drawn: on a sphere about the
 * ray's origin (globe.h), each upright where it stands on the map. Any thread.
 */
#pragma once

#include "scene/snapshot.h"

struct pel_object_hit {
    uint32_t id; /* of the entity */
    double range_m;
    struct pel_vec3 normal; /* unit, east, north, up, towards the origin */
};

/* The nearest of `count` objects that the ray from `from` along the unit vector
 * `along` meets within (least_m, most_m]; `but`: this entity is passed over,
 * -1: none. False: none is met. */
bool pel_objects_cast(const struct pel_object *objects, size_t count, long but,
                      struct pel_vec3 from, struct pel_vec3 along,
                      double least_m, double most_m,
                      struct pel_object_hit *out);
