/* Linear algebra for radiative transfer. Matrices are
 * row-major, n × n, n ≤ PEL_LINEAR_MAX. Any thread. */
#pragma once

#define PEL_LINEAR_MAX 128

/* n nodes and weights of Gauss and Legendre on [from, to], to 1e-15. */
void pel_gauss_legendre(int n, double from, double to, double *nodes,
                        double *weights);

/* Overwrites a positive definite m with its lower factor C, m = C Cᵀ; a pivot
 * that rounding has made less than 1e-14 is taken as that. */
void pel_cholesky(double *m, int n);

/* out = Cᵀ m C for a symmetric m and a lower triangle c. */
void pel_congruence(const double *m, const double *c, int n, double *out);

/* out = C v; out = C⁻ᵀ v; column by column, c a lower triangle. */
void pel_lower_times(const double *c, const double *v, int n, double *out);
void pel_upper_solve(const double *c, const double *v, int n, double *out);

/* Eigenvalues and, as columns, eigenvectors of a symmetric m, which is
 * destroyed: Householder's mirrors, then implicit QL. */
void pel_symmetric_eigen(double *m, int n, double *values, double *vectors);

/* Overwrites m with its triangular factors and the row that each step put
 * first; n up to 2 PEL_LINEAR_MAX. pel_lu_apply then solves m x = right in
 * place, for any number of right sides. */
void pel_lu_factor(double *m, int n, int *pivot);
void pel_lu_apply(const double *m, int n, const int *pivot, double *right);

/* Solves m x = right in place by elimination with partial pivots; n up to
 * 2 PEL_LINEAR_MAX. m is destroyed, pivot is room for n. */
void pel_lu_solve(double *m, int n, int *pivot, double *right);
