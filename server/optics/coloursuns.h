/* What colours need of the light of each Sun, from its spectrum
 * (optics/daylight.h): made when the program is built (server/tables.c), since
 * a start would take a seventh of a second of a core for it. */
#pragma once

#define PEL_COLOUR_SUNS 22

/* By the Sun's elevation, rising: rows of X, Y and Z [cd/m²] and of the rods,
 * of light of 1 W m^-2 sr^-1 nm^-1 at 680, 550 and 440 nm. */
struct pel_colour_suns {
    double elevation_deg[PEL_COLOUR_SUNS];
    double weight[PEL_COLOUR_SUNS][12];
};

extern const struct pel_colour_suns pel_colour_suns;

void pel_colour_suns_make(struct pel_colour_suns *out);
