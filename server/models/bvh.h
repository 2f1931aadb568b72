/* A tree of boxes over triangles, for rays. Immutable, any thread. */
#pragma once

#include "models/model.h"

/* Over `count` triangles of three indices each; NULL: no memory. */
struct pel_bvh *pel_bvh_create(const struct pel_model_vertex *vertices,
                               const uint32_t *indices, size_t count);
void pel_bvh_free(struct pel_bvh *bvh);
size_t pel_bvh_bytes(const struct pel_bvh *bvh);

/* The nearest triangle along the ray for which `solid` holds (NULL: all):
 * its number, distance within (0, most_m], and barycentric weights of its
 * second and third corner. */
struct pel_bvh_hit {
    uint32_t triangle;
    double distance, u, v;
    bool front; /* its corners turn counterclockwise seen from the origin */
};
bool pel_bvh_cast(const struct pel_bvh *bvh, struct pel_vec3 origin,
                  struct pel_vec3 direction, double most,
                  bool (*solid)(const void *user,
                                const struct pel_bvh_hit *hit),
                  const void *user, struct pel_bvh_hit *out);

/* Distance from a point to the nearest triangle. */
double pel_bvh_nearest(const struct pel_bvh *bvh, struct pel_vec3 point);
