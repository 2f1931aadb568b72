/* How high a wind sea is that the wind has raised over a fetch, and how long a
 * fetch that takes: inverse of the spectra JONSWAP and Elfouhaily (spectrum.h,
 * directional.h), within 0.3 % of their heights from 5 m/s, 1.5 % at 2 m/s. By
 * dimensions g H / U² is a function of g F / U² alone: of JONSWAP; Elfouhaily's
 * short waves have a scale of their own, so its law is a table by the wind too.
 * Any thread. */
#pragma once

#include "ocean/sea.h"

#define PEL_GROWTH_LEAST_FETCH_M 1e3
#define PEL_GROWTH_MOST_FETCH_M 2e6

struct pel_growth_law {
    enum pel_spectrum_kind kind; /* JONSWAP or ELFOUHAILY */
    double gamma;                /* JONSWAP's */
    double factor; /* of JONSWAP: g H / U² at g F / U² = 1; else not read */
};

/* Prepares the law; Elfouhaily's takes 0.1 s the first time. */
void pel_growth_of(enum pel_spectrum_kind kind, double gamma,
                   struct pel_growth_law *out);

/* Significant height [m] that a wind of wind_mps ≥ 0 raises over fetch_m. */
double pel_growth_height(const struct pel_growth_law *law, double wind_mps,
                         double fetch_m);

/* Fetch [m] over which it raises that height: between the two bounds above,
 * continuous in both. The least that has the height, so at most that of a fully
 * developed sea. */
double pel_growth_fetch(const struct pel_growth_law *law, double wind_mps,
                        double height_m);

/* Period [s] of the peak; 0 without wind. */
double pel_growth_peak(const struct pel_growth_law *law, double wind_mps,
                       double fetch_m);
