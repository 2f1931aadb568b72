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

static void rotate(double *a, double *b, int count, double cosine, double sine)
{
    for (int i = 0; i < count; i++) {
        double x = a[i], y = b[i];
        a[i] = cosine * x - sine * y;
        b[i] = sine * x + cosine * y;
    }
}

/* One rotation that makes m[p][q] vanish; rows of `vectors` turn with it. */
static void annul(double *m, int n, int p, int q, double *vectors)
{
    double apq = m[p * n + q];
    double theta = (m[q * n + q] - m[p * n + p]) / (2.0 * apq);
    double t = 1.0 / (fabs(theta) + sqrt(theta * theta + 1.0));
    t = theta < 0.0 ? -t : t;
    double cosine = 1.0 / sqrt(t * t + 1.0), sine = t * cosine;
    double app = m[p * n + p] - t * apq, aqq = m[q * n + q] + t * apq;
    rotate(m + p * n, m + q * n, n, cosine, sine);
    for (int i = 0; i < n; i++) {
        m[i * n + p] = m[p * n + i];
        m[i * n + q] = m[q * n + i];
    }
    m[p * n + p] = app;
    m[q * n + q] = aqq;
    m[p * n + q] = m[q * n + p] = 0.0;
    rotate(vectors + p * n, vectors + q * n, n, cosine, sine);
}

void pel_symmetric_eigen(double *m, int n, double *values, double *vectors)
{
    memset(vectors, 0, (size_t)(n * n) * sizeof *vectors);
    for (int i = 0; i < n; i++) {
        vectors[i * n + i] = 1.0;
    }
    for (int sweep = 0; sweep < 30; sweep++) {
        int turned = 0;
        for (int p = 0; p < n; p++) {
            for (int q = p + 1; q < n; q++) {
                double scale = sqrt(fabs(m[p * n + p] * m[q * n + q]));
                if (fabs(m[p * n + q]) > 1e-15 * scale + 1e-300) {
                    annul(m, n, p, q, vectors);
                    turned++;
                }
            }
        }
        if (!turned) {
            break;
        }
    }
    for (int i = 0; i < n; i++) {
        values[i] = m[i * n + i];
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

void pel_lu_solve(double *m, int n, int *pivot, double *right)
{
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++) {
            best = fabs(m[i * n + k]) > fabs(m[best * n + k]) ? i : best;
        }
        pivot[k] = best;
        if (best != k) {
            swap_rows(m, n, k, best);
            double x = right[k];
            right[k] = right[best];
            right[best] = x;
        }
        double inverse = m[k * n + k] != 0.0 ? 1.0 / m[k * n + k] : 0.0;
        for (int i = k + 1; i < n; i++) {
            double f = m[i * n + k] * inverse;
            if (f == 0.0) {
                continue;
            }
            for (int j = k + 1; j < n; j++) {
                m[i * n + j] -= f * m[k * n + j];
            }
            right[i] -= f * right[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        double s = right[i];
        for (int j = i + 1; j < n; j++) {
            s -= m[i * n + j] * right[j];
        }
        right[i] = m[i * n + i] != 0.0 ? s / m[i * n + i] : 0.0;
    }
}
