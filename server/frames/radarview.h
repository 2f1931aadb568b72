/* The picture of a view that is a radar's: from a snapshot, on the thread of an
 * encoder (optics/radar.h has what it shows). */
#pragma once

#include <stdatomic.h>

#include "base/err.h"
#include "frames/job.h"

/* Makes part->picture, if no output of the part has yet; NO_MEMORY, CONFLICT
 * (cancelled). Waits for the sea and for other radar pictures: encoder threads
 * alone. */
PEL_CHECK enum pel_err pel_radar_view_draw(struct pel_job_draw *part,
                                           const atomic_bool *cancel);

/* Frees it. */
void pel_radar_view_release(struct pel_job_draw *part);

/* The same picture alone, width × height pixels of RGBA; cancel: NULL allowed.
 */
PEL_CHECK enum pel_err pel_radar_view_show(const struct pel_snapshot *s,
                                           size_t view, double time_s,
                                           uint32_t width, uint32_t height,
                                           const atomic_bool *cancel,
                                           uint8_t *rgba);
