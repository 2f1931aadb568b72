/* Simulated time. One owner, the scene. */
#pragma once

#include <stdint.h>

#include "scene/snapshot.h"

#define PEL_MAX_TIME_S 1e9

struct pel_simclock {
    enum pel_clock_mode mode;
    double rate;
    double base_s;   /* simulated time at base_ns */
    int64_t base_ns; /* CLOCK_MONOTONIC */
};

/* From time_s at now_ns on, with this mode and rate. */
void pel_simclock_set(struct pel_simclock *clock, enum pel_clock_mode mode,
                      double rate, double time_s, int64_t now_ns);

/* Simulated time [s] at now_ns; never above PEL_MAX_TIME_S. */
double pel_simclock_at(const struct pel_simclock *clock, int64_t now_ns);
