/* What the parts of the discrete ordinates share (optics/ordinates.h): one
 * mode's work, in the scaled problem. */
#pragma once

#include "optics/ordinates.h"

#define N_MAX (2 * PEL_ORDINATES_MAX) /* directions in each hemisphere */
#define BACK_CELLS 512 /* of the phase function from −1 to BACK_TO */
#define BACK_TO 0.25   /* turned by more than two critical angles */

struct pel_ordinates {
    int nodes; /* in each range */
    int n;     /* directions in each hemisphere; the first `nodes` leave */
    int terms; /* of the phase function */
    double tolerance;
    double mu[N_MAX], weight[N_MAX];
    double reflected[N_MAX]; /* by the surface, from below */
    double air_mu[PEL_ORDINATES_MAX];
    /* The phase function last met. */
    struct pel_phase phase;
    double chi[N_MAX + 1];
    double back[BACK_CELLS + 2];
    /* One mode's work. */
    double moment[N_MAX];          /* (2l + 1) χ_l */
    double legendre[N_MAX][N_MAX]; /* [l][direction] */
    double odd[N_MAX * N_MAX], even[N_MAX * N_MAX];
    double vectors[N_MAX * N_MAX];
    double k[N_MAX];
    double sum[N_MAX * N_MAX], difference[N_MAX * N_MAX]; /* S and D */
    double matrix[4 * N_MAX * N_MAX], right[2 * N_MAX];
    int pivot[2 * N_MAX];
    /* e^(−λτ) times these solves the equation with the Sun's source. */
    double beam_sum[N_MAX], beam_difference[N_MAX];
};

/* One medium and light in the scaled problem. */
struct pel_ordinates_problem {
    double omega, tau; /* scaled albedo and depth */
    double peak;
    double albedo;
    double sun_mu, rate; /* rate = 1 / sun_mu, moved off every eigenvalue */
    double beam;
    const struct pel_ordinates_light *light;
    int mode;
};

/* Λ_l^m(μ) = √((l−m)!/(l+m)!) P_l^m for l < terms. */
void pel_ordinates_legendre(int m, int terms, double mu, double *out,
                            int stride);

/* Delta-M: the peak f = χ_terms is taken as not scattered at all. */
void pel_ordinates_scale(struct pel_ordinates *o,
                         const struct pel_medium *medium,
                         struct pel_ordinates_problem *p);

/* Eigenvalues k and the matrices that lead from the eigenmodes (σ, δ) to sum
 * and difference of upward and downward radiance: with P and Q the
 * symmetrised operators of the odd and even terms, P = C Cᵀ,
 * Cᵀ Q C = V k² Vᵀ, S = T⁻¹ C V, D = T⁻¹ C⁻ᵀ V, T = √(μ w). Then
 * σ' = δ − V ᵀC⁻¹ q_d, δ' = k² σ − VᵀCᵀ q_s. */
void pel_ordinates_eigenmodes(struct pel_ordinates *o,
                              const struct pel_ordinates_problem *p);

/* The particular solution for the Sun's beam, ∝ e^(−λτ), in eigenmodes. */
void pel_ordinates_beam_modes(struct pel_ordinates *o,
                              struct pel_ordinates_problem *p);

/* λ = 1/μ0 may meet an eigenvalue, where the particular solution has a pole
 * that the homogeneous one takes away: a millionth aside both are finite. */
void pel_ordinates_leave_resonance(const struct pel_ordinates *o,
                                   struct pel_ordinates_problem *p);

/* The 2n equations for what decays from above (first n unknowns) and from
 * below: L₋ = R L₊ + L_in at the surface, a Lambertian bottom. */
void pel_ordinates_boundary(struct pel_ordinates *o,
                            const struct pel_ordinates_problem *p,
                            double albedo);

/* Right side of these for one beam of irradiance 1 and no sky; total_s,
 * total_d: half the sum and half the difference that its particular solution
 * makes at each node, rate as of pel_ordinates_leave_resonance. */
void pel_ordinates_beam_right(const struct pel_ordinates *o,
                              const struct pel_ordinates_problem *p,
                              double albedo, double mu, double rate,
                              const double *total_s, const double *total_d,
                              double *right);

/* ∫₀^τ e^(−k(τ−t)) e^(−t/μ) dt/μ. */
double pel_ordinates_from_below(double k, double mu, double tau);

double pel_ordinates_largest(const double *v, int count);
