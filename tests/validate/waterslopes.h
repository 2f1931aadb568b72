/* Light in the water over bottoms that are not level, against Monte Carlo. */
#pragma once

#include <stdbool.h>
#include <stdio.h>

/* Writes the tables to `md`; the largest rms deviation of what is drawn over
 * planes of at most 30° beyond the noise of the photons [1], or negative when
 * out of memory. */
double put_slopes(FILE *md, bool quick);
