#include "optics/phase.h"

#include <math.h>

#include "base/vec.h"
#include "optics/linear.h"

/* --- Fournier and Forand -------------------------------------------------- */

/* δ = 1 is a removable 0/0: a straight line from one side to the other. */
#define NEAR_ONE 2e-3

struct point {
    double delta, half; /* half: sin² of half the angle */
};

static double forand_at(const struct pel_phase *p, struct point x)
{
    double v = p->slope, d = x.delta, power = pow(d, v), one = 1.0 - d;
    return (v * one - (1.0 - power) + (d * (1.0 - power) - v * one) / x.half) /
           (4.0 * PEL_PI * one * one * power);
}

static double forand_within(const struct pel_phase *p, struct point x)
{
    double v = p->slope, d = x.delta, power = pow(d, v);
    return (1.0 - power * d - (1.0 - power) * x.half) / ((1.0 - d) * power);
}

static double across_one(const struct pel_phase *p, double half,
                         double (*f)(const struct pel_phase *, struct point))
{
    double delta = p->scale * half;
    if (fabs(delta - 1.0) > NEAR_ONE) {
        return f(p, (struct point){ delta, half });
    }
    double low = 1.0 - NEAR_ONE, high = 1.0 + NEAR_ONE;
    double part = (delta - low) / (high - low);
    double below = f(p, (struct point){ low, low / p->scale });
    double above = f(p, (struct point){ high, high / p->scale });
    return below + part * (above - below);
}

#define LEAST_HALF 1e-18 /* sin² of half an angle of 1e-7° */

static double particles_at(const struct pel_phase *p, double nu)
{
    if (p->back > 0.0) {
        double half = fmax(0.5 * (1.0 - nu), LEAST_HALF);
        return across_one(p, half, forand_at) +
               p->tail / (4.0 * PEL_PI) * (3.0 * nu * nu - 1.0);
    }
    double g = p->asymmetry, d = 1.0 + g * g - 2.0 * g * nu;
    return (1.0 - g * g) / (4.0 * PEL_PI * d * sqrt(d));
}

static double particles_within(const struct pel_phase *p, double angle)
{
    double nu = cos(angle), sine = sin(0.5 * angle), half = sine * sine;
    if (p->back > 0.0) {
        return half < LEAST_HALF ? 0.0
                                 : across_one(p, half, forand_within) +
                                       2.0 * p->tail * half * (1.0 - half) * nu;
    }
    double g = p->asymmetry;
    if (g < 1e-3) {
        return 0.5 * (1.0 - nu) + 0.75 * g * (1.0 - nu * nu); /* + O(g²) */
    }
    return (1.0 - g * g) / (2.0 * g) *
           (1.0 / (1.0 - g) - 1.0 / sqrt(1.0 + g * g - 2.0 * g * nu));
}

/* δ and ν of an index and a slope of the sizes; and the term in 3 cos² − 1,
 * so that the whole integrates to 1. */
static void shape(struct pel_phase *p, double mu)
{
    double n = 1.01 + 0.1542 * (mu - 3.0);
    p->slope = 0.5 * (3.0 - mu);
    p->scale = 4.0 / (3.0 * (n - 1.0) * (n - 1.0));
    double power = pow(p->scale, p->slope);
    p->tail = (1.0 - power) / (4.0 * (p->scale - 1.0) * power);
}

struct pel_phase pel_phase_make(double molecular, double asymmetry, double back)
{
    struct pel_phase p = { molecular, asymmetry, back, 0.0, 0.0, 0.0 };
    if (back <= 0.0) {
        return p;
    }
    double low = 3.01, high = 4.8;
    for (int i = 0; i < 60; i++) {
        double middle = 0.5 * (low + high);
        shape(&p, middle);
        if (1.0 - particles_within(&p, 0.5 * PEL_PI) < back) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return p;
}

/* --- the mixture ---------------------------------------------------------- */

#define MOLECULAR_TOTAL (4.0 * PEL_PI * (1.0 + PEL_PHASE_MOLECULAR / 3.0))

double pel_phase_at(const struct pel_phase *p, double nu)
{
    double molecules = (1.0 + PEL_PHASE_MOLECULAR * nu * nu) / MOLECULAR_TOTAL;
    return p->molecular < 1.0 ? p->molecular * molecules +
                                    (1.0 - p->molecular) * particles_at(p, nu)
                              : molecules;
}

double pel_phase_within(const struct pel_phase *p, double angle)
{
    double nu = cos(angle), q = PEL_PHASE_MOLECULAR / 3.0;
    double molecules =
        2.0 * PEL_PI * (1.0 - nu + q * (1.0 - nu * nu * nu)) / MOLECULAR_TOTAL;
    return p->molecular < 1.0
               ? p->molecular * molecules +
                     (1.0 - p->molecular) * particles_within(p, angle)
               : molecules;
}

/* By parts, ∫ P_l dF = P_l(−1) − ∫ F dP_l/dθ dθ, because the share F within
 * an angle is smooth where the function itself rises without end; θ = π s⁴. */
static void forand_moments(const struct pel_phase *p, int count, double *out)
{
    enum { NODES = 96 };
    double s[NODES], weight[NODES];
    pel_gauss_legendre(NODES, 0.0, 1.0, s, weight);
    for (int l = 0; l < count; l++) {
        out[l] = l % 2 ? -1.0 : 1.0;
    }
    for (int i = 0; i < NODES; i++) {
        double cube = s[i] * s[i] * s[i], angle = PEL_PI * cube * s[i];
        double x = cos(angle);
        double step = particles_within(p, angle) * sin(angle) * weight[i] *
                      4.0 * PEL_PI * cube;
        double before = 1.0, now = x, slope_before = 0.0, slope = 1.0;
        for (int l = 1; l < count; l++) {
            out[l] += step * slope;
            double next = ((2 * l + 1) * x * now - l * before) / (l + 1);
            double slope_next = slope_before + (2 * l + 1) * now;
            before = now;
            now = next;
            slope_before = slope;
            slope = slope_next;
        }
    }
}

void pel_phase_moments(const struct pel_phase *p, int count, double *out)
{
    if (p->back > 0.0 && p->molecular < 1.0) {
        forand_moments(p, count, out);
    } else {
        double power = 1.0;
        for (int l = 0; l < count; l++) {
            out[l] = power;
            power *= p->asymmetry;
        }
    }
    const double second =
        2.0 * PEL_PHASE_MOLECULAR / (5.0 * (3.0 + PEL_PHASE_MOLECULAR));
    for (int l = 0; l < count; l++) {
        double molecules = l == 0 ? 1.0 : l == 2 ? second : 0.0;
        out[l] = p->molecular * molecules + (1.0 - p->molecular) * out[l];
    }
}

/* --- peak and rest -------------------------------------------------------- */

#define PEAK (PEL_PHASE_PEAK_DEG * PEL_DEG)

struct pel_phase_split pel_phase_split(const struct pel_phase *p)
{
    enum { NODES = 16 };
    struct pel_phase_split s = { *p, 0.0, 0.0, 0.0 };
    if (p->back <= 0.0 || p->molecular >= 1.0) {
        return s;
    }
    const double step = 1e-3;
    s.at = pel_phase_at(p, cos(PEAK));
    s.power = -log(pel_phase_at(p, cos(PEAK * (1.0 + step))) /
                   pel_phase_at(p, cos(PEAK * (1.0 - step)))) /
              (4.0 * step);
    double angle[NODES], weight[NODES], rest = 0.0;
    pel_gauss_legendre(NODES, 0.0, PEAK, angle, weight);
    for (int i = 0; i < NODES; i++) {
        rest += 2.0 * PEL_PI * weight[i] * sin(angle[i]) *
                pel_phase_rest(&s, cos(angle[i]));
    }
    s.peak = fmax(pel_phase_within(p, PEAK) - rest, 0.0);
    return s;
}

double pel_phase_rest(const struct pel_phase_split *s, double nu)
{
    if (s->at <= 0.0 || nu < cos(PEAK)) {
        return pel_phase_at(&s->whole, nu);
    }
    /* θ² to 1e-4 of it, and to all orders at 0. */
    double half = fmax(0.5 * (1.0 - nu), 0.0);
    double square = 4.0 * half * (1.0 + half / 3.0);
    return s->at * exp(s->power * (1.0 - square / (PEAK * PEAK)));
}

/* --- tables --------------------------------------------------------------- */

static double cell_of(double nu)
{
    return sqrt(sqrt(fmax(0.5 * (1.0 - nu), 0.0))) * PEL_PHASE_CELLS;
}

/* sin² of half the angle where a cell begins. */
static double half_of(int cell)
{
    double s = (double)cell / PEL_PHASE_CELLS;
    s *= s;
    return s * s;
}

/* The first cells, which are one. */
#define FLAT 270

void pel_phase_tabulate(const struct pel_phase *p, struct pel_phase_table *out)
{
    for (int i = 0; i <= PEL_PHASE_CELLS; i++) {
        double half = half_of(i);
        out->value[i] = pel_phase_at(p, 1.0 - 2.0 * fmax(half, LEAST_HALF));
        out->below[i] = i == PEL_PHASE_CELLS
                            ? 1.0
                            : pel_phase_within(p, 2.0 * asin(sqrt(half)));
    }
    /* It rises without end, and a few paths would carry most of the light. */
    double flat = out->below[FLAT] / (4.0 * PEL_PI * half_of(FLAT));
    for (int i = 0; i <= FLAT; i++) {
        out->value[0] = flat;
        out->below[i] = out->below[FLAT] * half_of(i) / half_of(FLAT);
    }
}

static double share_of(const struct pel_phase_table *t, int cell)
{
    return t->below[cell + 1] - t->below[cell];
}

static double solid_angle(int cell)
{
    return 4.0 * PEL_PI * (half_of(cell + 1) - half_of(cell));
}

double pel_phase_look_up(const struct pel_phase_table *t, double nu)
{
    double at = cell_of(nu);
    int i = (int)fmin(at, PEL_PHASE_CELLS - 1);
    return i < FLAT ? t->value[0]
                    : t->value[i] + (at - i) * (t->value[i + 1] - t->value[i]);
}

double pel_phase_draw(const struct pel_phase_table *t, double u)
{
    int low = 0, high = PEL_PHASE_CELLS;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (t->below[middle] <= u) {
            low = middle;
        } else {
            high = middle;
        }
    }
    double share = share_of(t, low);
    double part = share > 0.0 ? (u - t->below[low]) / share : 0.5;
    double half = half_of(low) + part * (half_of(high) - half_of(low));
    return 1.0 - 2.0 * fmin(half, 1.0);
}

double pel_phase_density(const struct pel_phase_table *t, double nu)
{
    int i = (int)fmin(cell_of(nu), PEL_PHASE_CELLS - 1);
    return share_of(t, i) / solid_angle(i);
}
