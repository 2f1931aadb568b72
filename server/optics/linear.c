#include "optics/linear.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

void pel_gauss_legendre(int n, double from, double to, double *nodes,
                        double *weights)
{
    double middle = 0.5 * (from + to), half = 0.5 * (to - from);
    for (int i = 0; i < n; i++) {
        double x = cos(PEL_PI * (i + 0.75) / (n + 0.5)), slope = 1.0;
        for (int step = 0; step < 100; step++) {
            double p = 1.0, before = 0.0;
            for (int l = 0; l < n; l++) {
                double next = ((2.0 * l + 1.0) * x * p - l * before) / (l + 1);
                before = p;
                p = next;
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            double dx = p / slope;
            x -= dx;
            if (fabs(dx) < 1e-15) {
                break;
            }
        }
        nodes[i] = middle - half * x;
        weights[i] = 2.0 * half / ((1.0 - x * x) * slope * slope);
    }
}

void pel_cholesky(double *m, int n)
{
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < j; i++) {
            m[i * n + j] = 0.0;
        }
        double d = m[j * n + j];
        for (int k = 0; k < j; k++) {
            d -= m[j * n + k] * m[j * n + k];
        }
        d = sqrt(fmax(d, 1e-14));
        m[j * n + j] = d;
        for (int i = j + 1; i < n; i++) {
            double s = m[i * n + j];
            for (int k = 0; k < j; k++) {
                s -= m[i * n + k] * m[j * n + k];
            }
            m[i * n + j] = s / d;
        }
    }
}

void pel_congruence(const double *m, const double *c, int n, double *out)
{
    double half[PEL_LINEAR_MAX]; /* one row of m C */
    memset(out, 0, (size_t)(n * n) * sizeof *out);
    for (int k = 0; k < n; k++) {
        memset(half, 0, sizeof half);
        for (int l = 0; l < n; l++) {
            for (int j = 0; j <= l; j++) {
                half[j] += m[k * n + l] * c[l * n + j];
            }
        }
        for (int i = 0; i <= k; i++) {
            for (int j = 0; j < n; j++) {
                out[i * n + j] += c[k * n + i] * half[j];
            }
        }
    }
}

void pel_lower_times(const double *c, const double *v, int n, double *out)
{
    memset(out, 0, (size_t)(n * n) * sizeof *out);
    for (int i = 0; i < n; i++) {
        for (int k = 0; k <= i; k++) {
            for (int j = 0; j < n; j++) {
                out[i * n + j] += c[i * n + k] * v[k * n + j];
            }
        }
    }
}

void pel_upper_solve(const double *c, const double *v, int n, double *out)
{
    memcpy(out, v, (size_t)(n * n) * sizeof *out);
    for (int i = n - 1; i >= 0; i--) {
        for (int j = 0; j < n; j++) {
            out[i * n + j] /= c[i * n + i];
        }
        for (int k = 0; k < i; k++) {
            for (int j = 0; j < n; j++) {
                out[k * n + j] -= c[i * n + k] * out[i * n + j];
            }
        }
    }
}

/* Mirrors by Householder that leave a symmetric m with a diagonal d and beside
 * it e; the rows of `basis` become the vectors they are written in. */
static void tridiagonal(double *m, int n, double *d, double *e, double *basis)
{
    double v[PEL_LINEAR_MAX], p[PEL_LINEAR_MAX];
    for (int k = 0; k + 2 < n; k++) {
        double square = 0.0, dot = 0.0;
        for (int i = k + 1; i < n; i++) {
            v[i] = m[k * n + i];
            square += v[i] * v[i];
        }
        double rest = square - v[k + 1] * v[k + 1];
        e[k] = v[k + 1];
        if (rest <= 0.0) {
            continue;
        }
        double alpha = v[k + 1] > 0.0 ? -sqrt(square) : sqrt(square);
        v[k + 1] -= alpha;
        double beta = 2.0 / (rest + v[k + 1] * v[k + 1]);
        e[k] = alpha;
        for (int i = k + 1; i < n; i++) {
            double sum = 0.0;
            for (int j = k + 1; j < n; j++) {
                sum += m[i * n + j] * v[j];
            }
            p[i] = beta * sum;
            dot += p[i] * v[i];
        }
        for (int i = k + 1; i < n; i++) {
            p[i] -= 0.5 * beta * dot * v[i];
        }
        for (int i = k + 1; i < n; i++) {
            for (int j = k + 1; j < n; j++) {
                m[i * n + j] -= v[i] * p[j] + p[i] * v[j];
            }
        }
        memset(p, 0, sizeof p);
        for (int i = k + 1; i < n; i++) {
            for (int j = 0; j < n; j++) {
                p[j] += beta * v[i] * basis[i * n + j];
            }
        }
        for (int i = k + 1; i < n; i++) {
            for (int j = 0; j < n; j++) {
                basis[i * n + j] -= v[i] * p[j];
            }
        }
    }
    for (int k = 0; k < n; k++) {
        d[k] = m[k * n + k];
    }
    if (n > 1) {
        e[n - 2] = m[(n - 2) * n + n - 1];
    }
    e[n - 1] = 0.0;
}

/* One sweep of implicitly shifted QL over l..last. */
static void sweep(double *d, double *e, int n, int l, int last, double *basis)
{
    double g = (d[l + 1] - d[l]) / (2.0 * e[l]);
    double sine = 1.0, cosine = 1.0, moved = 0.0;
    g = d[last] - d[l] + e[l] / (g + copysign(sqrt(g * g + 1.0), g));
    for (int i = last - 1; i >= l; i--) {
        double f = sine * e[i], b = cosine * e[i], r = hypot(f, g);
        e[i + 1] = r;
        if (r == 0.0) {
            d[i + 1] -= moved;
            e[last] = 0.0;
            return;
        }
        sine = f / r;
        cosine = g / r;
        g = d[i + 1] - moved;
        r = (d[i] - g) * sine + 2.0 * cosine * b;
        moved = sine * r;
        d[i + 1] = g + moved;
        g = cosine * r - b;
        double *x = basis + i * n, *y = x + n;
        for (int j = 0; j < n; j++) {
            double old = x[j];
            x[j] = cosine * old - sine * y[j];
            y[j] = sine * old + cosine * y[j];
        }
    }
    d[l] -= moved;
    e[l] = g;
    e[last] = 0.0;
}

void pel_symmetric_eigen(double *m, int n, double *values, double *vectors)
{
    double e[PEL_LINEAR_MAX];
    memset(vectors, 0, (size_t)(n * n) * sizeof *vectors);
    for (int i = 0; i < n; i++) {
        vectors[i * n + i] = 1.0;
    }
    tridiagonal(m, n, values, e, vectors);
    for (int l = 0; l < n; l++) {
        for (int tries = 0; tries < 60; tries++) {
            int last = l;
            while (last + 1 < n &&
                   fabs(e[last]) >
                       1e-16 * (fabs(values[last]) + fabs(values[last + 1]))) {
                last++;
            }
            if (last == l) {
                break;
            }
            sweep(values, e, n, l, last, vectors);
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++) {
            double x = vectors[i * n + j];
            vectors[i * n + j] = vectors[j * n + i];
            vectors[j * n + i] = x;
        }
    }
}

static void swap_rows(double *m, int n, int a, int b)
{
    for (int j = 0; j < n; j++) {
        double x = m[a * n + j];
        m[a * n + j] = m[b * n + j];
        m[b * n + j] = x;
    }
}

void pel_lu_factor(double *m, int n, int *pivot)
{
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++) {
            best = fabs(m[i * n + k]) > fabs(m[best * n + k]) ? i : best;
        }
        pivot[k] = best;
        if (best != k) {
            swap_rows(m, n, k, best);
        }
        double inverse = m[k * n + k] != 0.0 ? 1.0 / m[k * n + k] : 0.0;
        for (int i = k + 1; i < n; i++) {
            double f = m[i * n + k] *= inverse;
            if (f == 0.0) {
                continue;
            }
            for (int j = k + 1; j < n; j++) {
                m[i * n + j] -= f * m[k * n + j];
            }
        }
    }
}

void pel_lu_apply(const double *m, int n, const int *pivot, double *right)
{
    for (int k = 0; k < n; k++) {
        double x = right[pivot[k]];
        right[pivot[k]] = right[k];
        right[k] = x;
    }
    for (int i = 0; i < n; i++) {
        double s = right[i];
        for (int j = 0; j < i; j++) {
            s -= m[i * n + j] * right[j];
        }
        right[i] = s;
    }
    for (int i = n - 1; i >= 0; i--) {
        double s = right[i];
        for (int j = i + 1; j < n; j++) {
            s -= m[i * n + j] * right[j];
        }
        right[i] = m[i * n + i] != 0.0 ? s / m[i * n + i] : 0.0;
    }
}

void pel_lu_solve(double *m, int n, int *pivot, double *right)
{
    pel_lu_factor(m, n, pivot);
    pel_lu_apply(m, n, pivot, right);
}
