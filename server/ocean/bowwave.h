/* The bow wave of a ship in steady motion, from its speed, draught and half
 * angle of entrance (Noblesse, Delhommeau, Guilbaud, Hendrix and Yang 2008,
 * J. Fluid Mech. 600; the boundary of its regimes as measured by Delhommeau,
 * Guilbaud, David, Yang and Noblesse 2009, J. Fluid Mech. 620): wedge-shaped
 * bows without bulb, rake or flare, deep water. Pure functions, any thread. */
#pragma once

struct pel_bow_wave {
    /* Z of the crest above the calm sea: 2.2/(1 + F_D) U²/g tan α/cos α with
     * F_D = U/√(g D), but no higher than U²/2g, since at the crest no more
     * than all of the speed is gone (Bernoulli). */
    double height_m;
    double crest_m; /* of the crest behind the stem: 1.1/(1 + F_D) U²/g */
    /* Of the wave without that bound over U²/2g: 4.4 tan α/cos α/(1 + F_D). Up
     * to 1 the wave is steady, a sheet that overturns; above it breaks, without
     * end, before the stem and beside it. */
    double excess;
    /* How much of it breaks, 0..1: none where its steepness as a crest of
     * length 4 crest_m, π/2 · Z/X, is below Stokes's 0.443, α = 8.0°; nor where
     * the water is slow (PEL_BOW_SLOW_MPS: it draws in no air that is seen,
     * Kleiss and Melville 2010). */
    double breaks;
};

#define PEL_BOW_SLOW_MPS 1.5
#define PEL_BOW_QUICK_MPS 3.3 /* all */

/* speed_mps ahead, <= 0: none; draught_m > 0; alpha_rad 0..1.4. */
struct pel_bow_wave pel_bow_wave_of(double speed_mps, double draught_m,
                                    double alpha_rad);

/* A waterline's half-breadths in the middles of as many parts of its length,
 * from the stem aft. */
#define PEL_BOW_STATIONS 24

/* Half-breadth so far aft of the stem; beyond the stern as there. */
double pel_bow_half_m(const double half_m[PEL_BOW_STATIONS], double long_m,
                      double aft_m);
/* The wave of that waterline, of its mean angle from the stem to the crest:
 * *alpha_rad, 1.2 at most. long_m > 0. */
struct pel_bow_wave pel_bow_wave_at(const double half_m[PEL_BOW_STATIONS],
                                    double long_m, double draught_m,
                                    double speed_mps, double *alpha_rad);
