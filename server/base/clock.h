/* Time of this machine. Simulated time is the scene's (scene/simclock.h). */
#pragma once

#include <stdint.h>

/* CLOCK_MONOTONIC in nanoseconds; any thread. */
int64_t pel_now_ns(void);

/* Nanoseconds since 1970 by this machine's clock, which may be set; any
 * thread. */
int64_t pel_unix_ns(void);
