/* Several devices of one process give their commands in turn. NVIDIA's driver
 * has locks in its calls, and threads that draw on different devices at once
 * wait for each other at each of them: four H100 drew 0.33 times what one does,
 * in turn 1.9 times (docs/benchmarks.md). Who has waited longest is next.
 * Render threads. */
#pragma once

#include <stdbool.h>

/* That a renderer on hardware stands (1), or is gone (-1). */
void pel_turn_count(int change);

/* Waits for the turn; false, and at once, where there is one device. */
bool pel_turn_begin(void);
void pel_turn_end(bool had);
