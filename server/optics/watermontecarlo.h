/* Reference for transport.h: the same water by an independent Monte Carlo,
 * which shares the coefficients alone. Paths are followed backwards from the
 * viewer, and every collision and every reflection at the bottom adds the light
 * of each Sun (next-event estimation). Random numbers are a function of seed,
 * path and step. Any thread. */
#pragma once

#include <stdint.h>

#include "optics/transport.h"
#include "optics/watersection.h"

#define PEL_MONTECARLO_SUNS 32

struct pel_estimate {
    double mean, error; /* standard error of the mean */
};

/* Radiance above the surface by order, as struct pel_leaving. */
struct pel_montecarlo_result {
    struct pel_estimate single, second, higher;
    struct pel_estimate bottom_direct, bottom_scattered, total;
};

struct pel_montecarlo_sun {
    double zenith_rad, azimuth_rad; /* of the line of sight from this Sun's */
};

/* `paths` paths from a view of zenith view_zenith_rad, for 1..32 Suns of unit
 * irradiance normal to their beams: out[suns]. `sky` (NULL allowed) gets the
 * total for an isotropic sky of unit horizontal irradiance. Over a `bed` (NULL:
 * level) the medium's depth is not read, and the bottom shades what lies behind
 * it. About a million collisions a second. */
void pel_montecarlo_leaving(const struct pel_medium *medium,
                            const struct pel_section *bed,
                            double view_zenith_rad,
                            const struct pel_montecarlo_sun *suns, int count,
                            uint64_t paths, uint64_t seed,
                            struct pel_montecarlo_result *out,
                            struct pel_estimate *sky);
