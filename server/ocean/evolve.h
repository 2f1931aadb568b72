/* The cascades at a moment: their modes turned on, and transformed into the
 * fields of cascade.h. Vectorised single precision; the phase is exact. What
 * is drawn on the software device and what queries read come from here. */
#pragma once

#include "ocean/cascade.h"

struct pel_evolve_work; /* scratch of one thread, about 4 MB */

/* A cascade's modes in the order in which they are read, about 1 MB; NULL: no
 * memory. Made once its amplitudes are drawn; the cascade's. */
struct pel_evolve_modes;
struct pel_evolve_modes *pel_evolve_modes_create(const struct pel_cascade *c);
void pel_evolve_modes_destroy(struct pel_evolve_modes *modes); /* NULL too */

struct pel_evolve_work *pel_evolve_work_create(void); /* NULL: no memory */
void pel_evolve_work_destroy(struct pel_evolve_work *work); /* NULL allowed */

/* Where the fields of one cascade go, N · N texels each, row after row, laid
 * out as in struct pel_cascade_fields; NULL: not wanted. The first three go
 * together, and what is wanted must have no gap: rest, velocity, surge. */
struct pel_evolve_target {
    float (*displacement)[4];
    float (*slopes)[4];
    float *fold;
    float (*velocity)[4];
    float (*surge)[2];
    float (*breaking)[2]; /* X, Y of foam.h; by itself */
};

/* Fields of cascade `index` at time_s (|time_s| ≤ 1e9). Any thread; the same
 * bits on every processor, and whatever else is wanted. */
void pel_evolve(const struct pel_cascades *all, int index, double time_s,
                struct pel_evolve_work *work,
                const struct pel_evolve_target *out);

/* The next level of detail of a field of `channels` (1, 2 or 4) floats: n · n
 * texels, n even, become means of 2 × 2. */
void pel_evolve_halve(const float *from, int n, int channels, float *to);
