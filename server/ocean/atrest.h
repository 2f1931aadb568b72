/* What waves do to the water that rests at a place, some of them apart, for
 * surfaces on which they are changed (restquery.h). */
#pragma once

#include "ocean/cascade.h"

/* East, north, up: displacement, its derivatives by the place at rest,
 * velocity, acceleration. */
struct pel_at_rest {
    double d[3], dx[3], dy[3], v[3], a[3];
};

/* The fields of a moment; moving: with accelerations (0 otherwise). Aborts
 * without memory. */
struct pel_moment;
struct pel_moment *pel_moment_take(const struct pel_cascades *c, double time_s,
                                   bool moving);
void pel_moment_give(const struct pel_cascades *c, struct pel_moment *moment);

/* X, Y of foam.h, of cascade `index` where it is read for the water that rests
 * at (x, y), between texels as shaders read; of a moment of
 * pel_breaking_take. */
struct pel_moment *pel_breaking_take(const struct pel_cascades *c,
                                     double time_s);
struct pel_vec2 pel_breaking_at(const struct pel_cascades *c,
                                const struct pel_moment *moment, double x,
                                double y, int index);

/* Adds what the cascades from `first` to before `end` do to the water that
 * rests at (x, y). */
void pel_moment_at_rest(const struct pel_cascades *c,
                        const struct pel_moment *moment, double x, double y,
                        int first, int end, struct pel_at_rest *out);
