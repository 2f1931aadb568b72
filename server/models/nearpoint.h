/* Distances from a point, double precision. */
#pragma once

#include "base/vec.h"

static inline struct pel_vec3 pel_vec3_minus(struct pel_vec3 a,
                                             struct pel_vec3 b)
{
    return (struct pel_vec3){ a.x - b.x, a.y - b.y, a.z - b.z };
}

static inline double pel_vec3_length(struct pel_vec3 a)
{
    return sqrt(pel_vec3_dot(a, a));
}

static inline double pel_segment_distance(struct pel_vec3 p, struct pel_vec3 a,
                                          struct pel_vec3 b)
{
    struct pel_vec3 ab = pel_vec3_minus(b, a), ap = pel_vec3_minus(p, a);
    double l2 = pel_vec3_dot(ab, ab);
    double t = l2 > 0 ? pel_clamp(pel_vec3_dot(ap, ab) / l2, 0, 1) : 0;
    return pel_vec3_length(pel_vec3_minus(ap, pel_vec3_scale(ab, t)));
}

static inline double pel_triangle_distance(struct pel_vec3 p, struct pel_vec3 a,
                                           struct pel_vec3 b, struct pel_vec3 c)
{
    struct pel_vec3 n =
        pel_vec3_cross(pel_vec3_minus(b, a), pel_vec3_minus(c, a));
    double l = pel_vec3_length(n);
    if (l > 0 &&
        pel_vec3_dot(pel_vec3_cross(pel_vec3_minus(b, a), pel_vec3_minus(p, a)),
                     n) >= 0 &&
        pel_vec3_dot(pel_vec3_cross(pel_vec3_minus(c, b), pel_vec3_minus(p, b)),
                     n) >= 0 &&
        pel_vec3_dot(pel_vec3_cross(pel_vec3_minus(a, c), pel_vec3_minus(p, c)),
                     n) >= 0) {
        return fabs(pel_vec3_dot(n, pel_vec3_minus(p, a))) / l;
    }
    return fmin(
        pel_segment_distance(p, a, b),
        fmin(pel_segment_distance(p, b, c), pel_segment_distance(p, c, a)));
}
