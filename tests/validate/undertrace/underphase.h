/* Phase functions of sea water, 1/sr, each with the integral 1 over the sphere,
 * tabulated over the logarithm of u = 1 - cos of the angle turned. */
#ifndef UNDERPHASE_H
#define UNDERPHASE_H

#include "../seatrace/searandom.h"

#define UNDER_PI 3.14159265358979323846

enum { UNDER_CELLS = 16384 };

/* Directions: x towards the Sun's azimuth, z up. */
struct under_vec {
    double x, y, z;
};

static inline double under_dot(struct under_vec a, struct under_vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* What particles do: */
enum under_kind {
    UNDER_FOURNIER_FORAND,   /* parameter: the backscattered fraction */
    UNDER_HENYEY_GREENSTEIN, /* parameter: the mean cosine */
};

struct under_phase {
    double value[UNDER_CELLS + 1];
    double below[UNDER_CELLS + 1]; /* share turned by less */
    double mean_cosine, back;      /* back: share turned by more than 90° */
};

/* Of particles mixed with molecules, which have the share `molecules` (0..1) of
 * all scattering and 1 + q cos², q = (1 - depolarization) / (1 +
 * depolarization): 0.09 is Morel 1974, 0.039 Zhang et al. 2009; isotropic at
 * 1. */
void under_phase_init(struct under_phase *phase, enum under_kind kind,
                      double parameter, double molecules,
                      double depolarization);

double under_phase_at(const struct under_phase *phase, double cosine);

/* 1 - cos of a turn, for a number in [0, 1). */
double under_phase_turn(const struct under_phase *phase, double number);

/* Fournier and Forand's function of the angle and the share turned by less, in
 * closed form (Fournier and Jonasz 1999; Forand and Fournier 1999, as in
 * Mobley, Sundman and Boss 2002, eq. 3 to 7); the size distribution's slope of
 * a backscattered fraction, with n = 1.01 + 0.1542 (slope - 3) there. */
double under_fournier_forand(double slope, double angle);
double under_fournier_forand_below(double slope, double angle);
double under_fournier_forand_slope(double back);

/* The unit vector that d turned by 1 - cos = `less` is, at an azimuth. */
struct under_vec under_turned(struct under_vec d, double less, double azimuth);

#endif
