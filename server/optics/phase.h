/* How sea water turns light: the mean of the phase functions of what scatters
 * in it, by their shares. Molecules: Rayleigh's with the depolarisation of
 * Zhang, Hu and He 2009. Particles: Fournier and Forand 1994, as corrected by
 * Fournier and Jonasz 1999, one for each backscattered fraction (Mobley,
 * Sundman and Boss 2002), or Henyey and Greenstein 1941. Each integrates to 1
 * over the sphere [1/sr]; `nu` is the cosine of the scattering angle. Any
 * thread. */
#pragma once

struct pel_phase {
    double molecular; /* share of the molecules, 0..1; the rest: particles */
    double asymmetry; /* their g, by Henyey and Greenstein, where back is 0 */
    double back;      /* their backscattered fraction, by Fournier and Forand:
                         0, or PEL_PHASE_BACK_MIN..MAX */
    double slope;     /* ν = (3 − μ)/2, found by pel_phase_make */
    double scale;     /* δ = scale sin² (half the angle) */
    double tail;      /* of the term in 3 cos² − 1, before 1/(4π) */
};

#define PEL_PHASE_BACK_MIN 0.001
#define PEL_PHASE_BACK_MAX 0.06
/* Molecules: (1 + q ν²) with q = (1 − d)/(1 + d), d = 0.039. */
#define PEL_PHASE_MOLECULAR 0.9249278

/* The function of these shares; 60 steps for the index and the distribution of
 * sizes whose backscattered fraction is `back`, on the line n = 1.01 + 0.1542
 * (μ − 3) of Mobley 2002. */
struct pel_phase pel_phase_make(double molecular, double asymmetry,
                                double back);

double pel_phase_at(const struct pel_phase *p, double nu);

/* Fraction turned by less than the angle, 0..π. */
double pel_phase_within(const struct pel_phase *p, double angle_rad);

/* Legendre moments χ_l = 2π ∫ p P_l dν, l < count ≤ PEL_PHASE_MOMENTS. */
#define PEL_PHASE_MOMENTS 80
void pel_phase_moments(const struct pel_phase *p, int count, double *out);

/* The function as quadratures take it: a narrow peak forward, which hardly
 * turns light, and a rest that is smooth. What is turned by more than
 * PEL_PHASE_PEAK_DEG is all in the rest. Henyey and Greenstein's has no peak.
 */
#define PEL_PHASE_PEAK_DEG 6.0
struct pel_phase_split {
    struct pel_phase whole;
    double peak; /* its share */
    double at,
        power; /* the rest within the angle: at e^(power (1 − θ²/θ_c²)) */
};
struct pel_phase_split pel_phase_split(const struct pel_phase *p);
double pel_phase_rest(const struct pel_phase_split *s, double nu);

/* Tables for looking the function up and for drawing directions from it, over
 * the root of sin (half the angle). Within half a degree they are flat, with
 * the function's mean there. */
#define PEL_PHASE_CELLS 4096
struct pel_phase_table {
    double value[PEL_PHASE_CELLS + 1]; /* 1/sr */
    double below[PEL_PHASE_CELLS + 1]; /* share of smaller angles */
};
void pel_phase_tabulate(const struct pel_phase *p, struct pel_phase_table *out);

/* The value, to 1e-3 of it beyond 0.5°. */
double pel_phase_look_up(const struct pel_phase_table *t, double nu);

/* A cosine drawn by u in 0..1, and the density by which it was [1/sr]. */
double pel_phase_draw(const struct pel_phase_table *t, double u);
double pel_phase_density(const struct pel_phase_table *t, double nu);
