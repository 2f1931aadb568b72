/* What scatters and absorbs in sea water, each by itself, at any wavelength
 * from 400 to 700 nm (shorter ones, which Raman scattering asks for: algae as
 * at 400 nm, water as at 380 nm below that): the water and its salt,
 * phytoplankton, other particles, dissolved matter, minerals. Where only
 * chlorophyll is known the others follow it as in Case 1 waters, far from
 * shores. docs/physics/water.md lists the sources. Any thread. */
#pragma once

#include <stdbool.h>

#define PEL_SEAWATER_NM_MIN 400.0
#define PEL_SEAWATER_NM_MAX 700.0

struct pel_seawater {
    double chlorophyll_mg_m3;                   /* > 0 */
    bool has_dissolved, has_detritus, has_back; /* else by chlorophyll */
    double dissolved_per_m; /* absorption of dissolved matter at 440 nm */
    double dissolved_slope; /* its fall with wavelength, 1/nm; 0: the usual */
    double detritus_per_m;  /* of particles that are not algae, at 440 nm */
    double detritus_slope;  /* 1/nm; 0: the usual */
    double minerals_g_m3;   /* suspended, besides these */
    double back;            /* backscattered fraction of the particles */
    double salinity_g_kg, temperature_c;
};

/* At one wavelength, 1/m. */
struct pel_iop {
    double water, phytoplankton, dissolved, detritus; /* absorption */
    double molecular, particles;                      /* scattering */
    double back; /* backscattered fraction of `particles`, 1 */
};

struct pel_iop pel_seawater_iop(const struct pel_seawater *water, double nm);

/* Their sums: absorption, scattering, backscattering [1/m]. */
double pel_iop_absorption(const struct pel_iop *iop);
double pel_iop_scattering(const struct pel_iop *iop);
double pel_iop_backscattering(const struct pel_iop *iop);

/* Absorption of pure water [1/m]: Pope and Fry 1997, table 3, linear between
 * its rows of 5 nm. */
double pel_seawater_absorption(double nm);

/* Scattering by the molecules of water and salt [1/m]: Zhang, Hu and He
 * 2009; half of it goes back. */
double pel_seawater_molecular(double nm, double salinity_g_kg,
                              double temperature_c);

/* Refractive index against vacuum for air's refraction left out: Quan and Fry
 * 1995, eq. 3. */
double pel_water_index(double salinity_g_kg, double temperature_c,
                       double wavelength_nm);
