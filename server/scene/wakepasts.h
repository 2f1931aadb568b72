/* What tracks have left in the water up to an epoch (pel_wake_past), kept for
 * all scenes: what they were made from says which they are, so what is kept
 * changes no result. Any thread. */
#pragma once

#include <stddef.h>

#include "ocean/wake.h"

struct pel_wake_kept;

/* The past of a track cut at epoch_s; made, some tens of milliseconds, where it
 * is not kept, by whoever is first; others wait. pel_wake_kept_put. */
struct pel_wake_kept *pel_wake_kept_take(const struct pel_wake_track *track,
                                         double epoch_s, double depth_m);
void pel_wake_kept_put(struct pel_wake_kept *kept);
const struct pel_wake_past *
pel_wake_kept_past(const struct pel_wake_kept *kept);

/* Has it made by a thread of its own, where it is not kept; returns at once. */
void pel_wake_kept_soon(const struct pel_wake_track *track, double epoch_s,
                        double depth_m);

/* Of all that are kept and made. */
size_t pel_wake_kept_bytes(void);

/* Waits until that thread has made what it was asked for; for tests. */
void pel_wake_kept_settle(void);

/* How many were made by those who wanted them at once, and how many by that
 * thread; for tests. */
void pel_wake_kept_counts(unsigned long *waited_for, unsigned long *ahead);
