/* Weather reports of aerodromes: METAR and SPECI (WMO-No. 306, FM 15 and 16;
 * the United States' form of it with statute miles and inches of mercury). Pure
 * functions, any thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "bounds.h"

enum pel_metar_fog {
    PEL_METAR_NO_FOG,
    PEL_METAR_FOG,     /* FG, FZFG */
    PEL_METAR_SHALLOW, /* MIFG: below 2 m */
    PEL_METAR_PATCHES, /* BCFG, PRFG, VCFG */
};

struct pel_metar {
    bool has_wind, has_direction; /* no direction: variable, or calm */
    double wind_mps, gust_mps;    /* gust 0: none */
    double direction_deg;         /* true, it comes from */
    bool has_visibility, ten_km;  /* the latter: at least 10 km */
    double visibility_m;
    enum pel_metar_fog fog;
    /* mm/h of water, by WMO's bounds of light, moderate and heavy. */
    double rain_mm_h, snow_mm_h;
    bool thunder, hail;
    bool has_clouds; /* said, were it that there are none */
    int octas;       /* of the layer that covers most; of equals the lowest */
    double base_m;
    bool towering, thunderclouds; /* TCU, CB */
    bool has_temperature, has_dew_point, has_pressure;
    double temperature_c, dew_point_c, pressure_hpa;
    int ignored; /* groups that were understood and say nothing here: runway
                    visual range, what follows pressure */
};

/* Longest text, bytes. */
#define PEL_METAR_MOST PEL_BOUND_METAR_BYTES

/* Reads a report, all or nothing. INVALID: *fault (NULL allowed) names
 * sky.metar, the group, and what may stand there; *out is undefined. */
PEL_CHECK enum pel_err pel_metar_parse(const char *text, struct pel_metar *out,
                                       struct pel_fault *fault);
