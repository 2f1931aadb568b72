/* The moments of the sea that ships under helms ask for: those about now stay
 * computed (pel_sea_hold), since orders begin a motion anew. */
#pragma once

#include "ocean/sea.h"

/* Computes and holds those from time_s on, steps of step_s: of an FFT sea some
 * tens of milliseconds where none of them is there. Any thread. */
void pel_ships_hold_sea(const struct pel_sea *sea, double time_s,
                        double step_s);
