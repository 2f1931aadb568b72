/* The sampling study of Iwasaki et al. 2003, section 6.1 (figs. 7, 8), with
 * the code that makes the maps: error against the number of planes, of
 * directions, and the size of the maps. */
#pragma once

#include <stdbool.h>
#include <stdio.h>

/* Appends tables to `md`, writes `json` for tests/validate/water_plot.py.
 * quick: only as the maps are made. Returns the worst error with what the maps
 * are made with, of the maximum. */
double put_sampling(FILE *md, FILE *json, bool quick);
