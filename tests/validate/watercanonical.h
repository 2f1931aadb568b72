/* Parts of `make validate-water`: the canonical problems of Mobley et al. 1993
 * (Applied Optics 32, 7484). */
#pragma once

#include <stdbool.h>
#include <stdio.h>

#include "optics/ordinates.h"

/* Problems 1, 2 and 6 against the averages of their seven models: the median
 * of how far the program is off. */
double canonical_published(FILE *md, struct pel_ordinates *o);

/* Water in layers, below a sky, below waves, as problems 3, 4 and 5 have them,
 * against photons (watercolumn.h), for which no published number is at hand.
 * Whether its bounds are kept. */
bool check_columns(FILE *md, bool quick);
