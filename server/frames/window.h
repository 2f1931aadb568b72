/* The last values of a figure, and their ranks. */
#pragma once

#include <stdint.h>

#define PEL_STATS_WINDOW 256

struct pel_window {
    float values[PEL_STATS_WINDOW];
    uint64_t count; /* of all that were added */
};

void pel_window_add(struct pel_window *window, double value);

/* Value below which `share` of the window lies (nearest rank); 0: empty. */
double pel_window_rank(const struct pel_window *window, double share);
