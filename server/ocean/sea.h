/* The sea surface: a sum of trochoids drawn from a directional spectrum.
 * Immutable once built, so every thread may read it. Everything is a function
 * of (sea, simulated time).
 *
 * Frame: x east, y north, z up, metres from the scene's origin; directions are
 * mathematical, the way waves travel to, radians from east towards north. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "base/vec.h"
#include "shaders/lib/blocks.h"

#define PEL_GRAVITY 9.81 /* m/s², as the 2010 paper */
#define PEL_SEA_MAX_WAVES 256
#define PEL_SEA_MAX_SWELLS 8

enum pel_spectrum_kind {
#define PEL_SPECTRUM(ID, uses, whole, add) PEL_SPECTRUM_##ID,
#include "ocean/spectra.def"
    PEL_SPECTRA
};

/* What of a sea's description a spectrum depends on; sets are sums. */
enum {
#define PEL_SPECTRUM_NUMBER(ID, ...) PEL_USE_AT_##ID,
#include "ocean/spectra.def"
    PEL_SPECTRUM_NUMBERS
};
enum pel_spectrum_uses {
#define PEL_SPECTRUM_NUMBER(ID, ...) PEL_USES_##ID = 1 << PEL_USE_AT_##ID,
#include "ocean/spectra.def"
    PEL_USES_RECORD = 1 << PEL_SPECTRUM_NUMBERS, /* `measured` */
};

/* A directional spectrum as a buoy reports it. */
#define PEL_MEASURED_MOST 128
struct pel_measured {
    int count;                              /* 3..PEL_MEASURED_MOST */
    double frequency_hz[PEL_MEASURED_MOST]; /* rising, 0.005..2 */
    double density[PEL_MEASURED_MOST];      /* m²/Hz, ≥ 0 */
    /* r1, r2 (0..1) and the mean directions of the first and second moment,
     * mathematical, that the waves travel to. */
    double r1[PEL_MEASURED_MOST], r2[PEL_MEASURED_MOST];
    double alpha1_rad[PEL_MEASURED_MOST], alpha2_rad[PEL_MEASURED_MOST];
};

enum pel_synthesiser {
    PEL_SYNTHESISER_TROCHOIDS, /* Bruneton et al. 2010 */
    PEL_SYNTHESISER_FFT,       /* cascades, see cascade.h */
    PEL_SYNTHESISERS
};

struct pel_swell_desc {
    double height_m;      /* significant wave height, 0..15 */
    double period_s;      /* peak period, 3..30 */
    double direction_rad; /* travels to */
    double spread_rad;    /* standard deviation of direction, > 0 */
};

/* One wave of its own: a trochoid, or the cascades' nearest mode. */
struct pel_single_desc {
    double height_m;      /* crest to trough, 0..15 */
    double period_s;      /* 1..30 */
    double direction_rad; /* travels to */
    double phase_rad;     /* at the origin at time 0; 0: a crest */
};
#define PEL_SEA_MAX_SINGLES 8

/* Where short waves are higher or lower (ocean/areas.h): a circle about its
 * place, or a polygon with corners relative to it. */
#define PEL_SEA_MAX_AREAS PEL_AREA_LIMIT
struct pel_area_desc {
    double east_m, north_m; /* at time_s */
    double radius_m;        /* of a circle, 1..1e5 */
    int corner_count;       /* 0: a circle; 3..PEL_AREA_CORNERS */
    struct pel_vec2 corner[PEL_AREA_CORNERS];
    double velocity_east_mps, velocity_north_mps; /* −50..50 */
    double time_s;
    double edge_m; /* over which it goes over into the sea, 1..1e4 */
    double factor; /* of the short waves' heights, 0..2 */
};

struct pel_sea_desc {
    enum pel_synthesiser synthesiser;
    enum pel_spectrum_kind kind;
    double wind_mps;      /* at 10 m, 0..30 */
    double direction_rad; /* the wind blows to */
    double fetch_m;       /* JONSWAP, 1e3..2e6 */
    double gamma;         /* JONSWAP peak enhancement, 1..7 */
    double height_m;      /* Bretschneider: significant, 0..15 */
    double period_s;      /* Bretschneider: of the peak, 3..30 */
    uint32_t seed;
    int wave_count; /* trochoids in all, 20..256; 60 in the 2010 paper */
    int swell_count;
    struct pel_swell_desc swell[PEL_SEA_MAX_SWELLS];
    int single_count;
    struct pel_single_desc single[PEL_SEA_MAX_SINGLES];
    double depth_m;   /* of the dispersion, 1..11000; 0: deep water */
    double whitecaps; /* times the wind's coverage (foam.h), 0..4; 0: none */
    double rain_mm_h; /* on the waves (ringwaves.h), 0..150 */
    /* The sea is one of many that follow each other, all with the same modes:
     * FFT alone; frequencies are those of the modes' wave numbers, so that
     * waves keep their phases when the spectrum changes, and amplitudes are
     * continuous in all of it. */
    bool steady;
    struct pel_measured measured;
    int area_count; /* 0..PEL_SEA_MAX_AREAS */
    struct pel_area_desc area[PEL_SEA_MAX_AREAS];
};

/* One trochoid (Bruneton et al. 2010, eq. 2), in phase convention
 * φ = k·x − ω t + phase + what ocean/wander.h adds: displacement =
 * (−k̂ c h sin φ, h cos φ).
 *
 * c, `chop`, is 1 for the exact trochoid and less where the sum of all waves
 * would fold over itself (see pel_sea_build). The slope variance of such a
 * wave is (1 − √(1 − c²k²h²)) / c² = k²h² / (1 + √(1 − c²k²h²)), appendix A
 * with x(s) = s − c h sin(ks); a filter weight w multiplies h. */
struct pel_wave {
    double kx, ky;    /* wavenumber vector, rad/m */
    double amplitude; /* h, m */
    double omega;     /* rad/s */
    double phase;     /* rad, in [0, 2π) */
    double chop;      /* c, 0..1, in 64ths */
    /* ocean/wander.h; all 0: it does not */
    double swing;              /* rad */
    double wander_x, wander_y; /* turns/m */
    double wander_rate;        /* turns/s */
    double wander_start;       /* turns */
};

/* Slope variance along and across the wind, and their covariance. */
struct pel_slopes {
    double along, cross, mixed;
};

struct pel_cascades; /* ocean/cascade.h */
struct pel_foam;     /* ocean/foam.h */
struct pel_shore;    /* ocean/shore.h */

struct pel_sea {
    struct pel_sea_desc desc;
    struct pel_cascades *cascades; /* owned; NULL: the waves below */
    struct pel_foam *foam;         /* owned; NULL: none */
    struct pel_shore *shore;       /* owned; NULL: no wave feels a bottom */
    int count;
    struct pel_wave waves[PEL_SEA_MAX_WAVES]; /* longest wavelength first */
    double m0;                                /* Σ h²/2 of the waves, m² */
    double spectrum_m0; /* ∫∫ S dω dθ of the spectrum itself, m² */
    double slope_variance_along; /* eq. 4, total, along the wind direction */
    double slope_variance_cross;
    double slope_covariance; /* eq. 4's off-diagonal in wind axes */
    struct pel_slopes below; /* of the spectrum below the shortest wave */
    double max_height_m;     /* Σ h: no crest is higher */
    double max_shift_m;      /* Σ c h: no particle strays further sideways */
};

/* Builds the sea. `desc` must be inside its ranges (OUT_OF_RANGE otherwise,
 * also for NaN, *out then unchanged; or NO_MEMORY). Waves are a function of
 * desc alone: the same bits on every call. No wind and no swell give a flat
 * sea, count 0.
 *
 * Wind waves: the spectrum from PEL_SEA_LONGEST peak wavelengths down to
 * PEL_SEA_SHORTEST_M is cut into bins (bins.h). Each bin is one wave that
 * carries the bin's whole energy (h = √(2 E)) and wanders over its frequencies
 * and a sector of directions (wander.h), stratified through the inverse
 * cumulative of the spreading, whose exponent is not let below
 * PEL_SEA_SPREADING_FLOOR. Each swell takes 1 to 8 waves (to 16 without wind)
 * of equal energy.
 *
 * No self-intersection: with B = PEL_SEA_FOLD_SIGMAS · √(Σ k²h²/2) running
 * from the longest wave to the shortest, `chop` is 1 up to B = 0.7 and then
 * keeps the bound of the horizontal compression at
 * f(B) = 0.7 + 0.28 (1 − exp(−(B − 0.7) / 0.28)) < 0.98. */
#define PEL_SEA_SHORTEST_M 0.02
#define PEL_SEA_LONGEST 4.0
#define PEL_SEA_SPREADING_FLOOR 2.0
#define PEL_SEA_FOLD_SIGMAS 5.5
PEL_CHECK enum pel_err pel_sea_build(const struct pel_sea_desc *desc,
                                     struct pel_sea *out);

/* Squares of `chop`, weighted by slope variance: of the finest waves, and by
 * how much it is more of waves that hold a slope variance v (along and across
 * together) from the finest up: finest + more v. */
struct pel_folding {
    double finest, more;
};
struct pel_folding pel_sea_folding(const struct pel_sea *sea);

/* Adds the single waves of sea->desc as trochoids of exact height, period,
 * direction and phase; used by pel_sea_build. */
void pel_sea_add_singles(struct pel_sea *sea);

/* Lays a built sea over a bottom (ocean/shore.h), once. NO_MEMORY: *sea is
 * unchanged. */
struct pel_shore_bottom;
PEL_CHECK enum pel_err pel_sea_lay(struct pel_sea *sea,
                                   const struct pel_shore_bottom *bottom);

/* Frees what a built sea owns. */
void pel_sea_finish(struct pel_sea *sea);

struct pel_surface_sample {
    double height_m;
    struct pel_vec3 normal;
    struct pel_vec3 velocity_mps;
    struct pel_vec3 acceleration_mps2; /* NaN where it was not asked for */
    /* Of the bottom below mean sea level; NaN here: a caller that knows the
     * bottom sets it. */
    double depth_m;
    struct pel_vec2 rest_m; /* of the particle: where it rests, within 0.1 mm */
    /* Mean share of the water that dense foam hides; NaN here: pel_foam_query
     * sets it. */
    double foam;
};

/* The surface above the horizontal place (x, y) at time_s: solves
 * x0 + D(x0) = X by damped Newton steps until it is met within 1 µm, and
 * gives height, exact normal and velocity of the particle there. Fields of FFT
 * cascades are single, and so is what is summed over their texels: 0.1 µm at
 * 4 m/s of wind, 1.2 µm at 18 m/s of what double sums give. Never fails for
 * finite input. */
void pel_sea_sample(const struct pel_sea *sea, double x_m, double y_m,
                    double time_s, struct pel_surface_sample *out);

/* Displacement (dx, dy, dz) of the particle that rests at (x, y). */
struct pel_vec3 pel_sea_displace(const struct pel_sea *sea, double x_m,
                                 double y_m, double time_s);

/* Root mean square height of the waves shorter than wavelength_m. */
double pel_sea_rms_below(const struct pel_sea *sea, double wavelength_m);

/* Slope variance of the waves shorter than wavelength_m, with what the
 * spectrum has below the shortest wave drawn. */
struct pel_slopes pel_sea_slopes_below(const struct pel_sea *sea,
                                       double wavelength_m);

/* Longest wavelength whose waves, with all shorter ones, keep within rms_m:
 * continuous in rms_m; DBL_MAX when all do. */
double pel_sea_droppable(const struct pel_sea *sea, double rms_m);

/* pel_sea_sample at n places of one moment; out[i] answers points[i]. Bit for
 * bit the same as n single calls. */
void pel_sea_query(const struct pel_sea *sea, const struct pel_vec2 *points,
                   size_t n, double time_s, struct pel_surface_sample *out);

/* The same with the acceleration of the water particle, ∂²D/∂t² at its rest
 * position. On an FFT sea a
 * moment's fields are a sixth dearer. */
void pel_sea_query_moving(const struct pel_sea *sea,
                          const struct pel_vec2 *points, size_t n,
                          double time_s, struct pel_surface_sample *out);

/* Computes ahead what a query (moving: with accelerations) about time_s would
 * wait for, piece by piece while go_on(user); true: it will not wait. Answers
 * are the same with and without. */
bool pel_sea_prepare(const struct pel_sea *sea, double time_s, bool moving,
                     bool (*go_on)(void *user), void *user);

/* What is prepared for these moments stays, whatever else is asked, until other
 * ones are named or none is asked for in seconds. */
#define PEL_SEA_HELD 4
void pel_sea_hold(const struct pel_sea *sea,
                  const double times_s[PEL_SEA_HELD]);
