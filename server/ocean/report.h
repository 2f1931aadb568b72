/* The numbers of a sea, from what it is drawn from. */
#pragma once

#include <stddef.h>

#include "base/err.h"
#include "ocean/sea.h"

struct pel_sea_moments {
    double m0; /* m² */
    struct pel_slopes slopes;
};

struct pel_sea_report {
    struct pel_sea_moments spectrum, drawn; /* of all waves */
    struct pel_sea_moments spectrum_below, drawn_below;
    double peak_omega;  /* rad/s, of the greatest S(ω); 0: a flat sea */
    double mean_to_rad; /* mathematical, weighted by energy */
};

struct pel_spectrum_row {
    double density;     /* S(ω), m² s/rad */
    double mean_to_rad; /* mathematical */
    double r1;          /* 0..1 */
};

struct pel_directional;

/* The report of a built sea with its spectrum (pel_directional_create of
 * sea->desc); `below` for waves shorter than wavelength_m > 0. */
void pel_sea_report(const struct pel_sea *sea,
                    const struct pel_directional *spectrum, double wavelength_m,
                    struct pel_sea_report *out);

struct pel_sea_parts {
    double wind_sea_m0, swell_m0; /* m² */
    double wave_age; /* c/U of the wind sea's peak; 0: no wind, or none */
};

/* What of a sea is the wind's, without rain, and what is swell. NO_MEMORY. */
PEL_CHECK enum pel_err pel_sea_parts(const struct pel_sea_desc *desc,
                                     struct pel_sea_parts *out);

/* The spectrum at omega > 0 rad/s over all directions. */
void pel_spectrum_row(const struct pel_directional *spectrum, double omega,
                      struct pel_spectrum_row *out);
