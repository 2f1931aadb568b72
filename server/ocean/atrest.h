/* What waves do to the water that rests at a place, long and short ones apart,
 * for surfaces on which the short ones are changed (areas.h). */
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

/* Adds what the two coarser cascades do to out[0], the finer ones to out[1]. */
void pel_moment_at_rest(const struct pel_cascades *c,
                        const struct pel_moment *moment, double x, double y,
                        struct pel_at_rest out[2]);
