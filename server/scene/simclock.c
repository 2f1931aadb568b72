#include "scene/simclock.h"

#include <math.h>

void pel_simclock_set(struct pel_simclock *clock, enum pel_clock_mode mode,
                      double rate, double time_s, int64_t now_ns)
{
    *clock = (struct pel_simclock){ mode, rate, time_s, now_ns };
}

double pel_simclock_at(const struct pel_simclock *clock, int64_t now_ns)
{
    double time_s = clock->base_s;
    if (clock->mode == PEL_CLOCK_FREE) {
        time_s += (double)(now_ns - clock->base_ns) * 1e-9 * clock->rate;
    }
    return fmin(time_s, PEL_MAX_TIME_S);
}
