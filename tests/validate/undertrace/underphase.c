#include "underphase.h"

#define PI UNDER_PI

/* 1 - cos of the smallest angle told from straight on (0.0003°), and ln of the
 * range to 2. */
#define LEAST 1e-11
#define RANGE 26.021586

static double index_of(double slope)
{
    return 1.01 + 0.1542 * (slope - 3);
}

/* sin² of half the angle times 4 / (3 (n - 1)²). */
static double delta_of(double slope, double half2)
{
    double n = index_of(slope), delta = 4 * half2 / (3 * (n - 1) * (n - 1));
    /* There the closed forms are 0 / 0. */
    return fabs(delta - 1) < 1e-5 ? 1 + 1e-5 : delta;
}

double under_fournier_forand(double slope, double angle)
{
    double half = sin(angle / 2), half2 = half * half, nu = (3 - slope) / 2;
    double d = delta_of(slope, half2), dn = pow(d, nu);
    double d180 = delta_of(slope, 1), dn180 = pow(d180, nu), c = cos(angle);
    return (nu * (1 - d) - (1 - dn) + (d * (1 - dn) - nu * (1 - d)) / half2) /
               (4 * PI * (1 - d) * (1 - d) * dn) +
           (1 - dn180) / (16 * PI * (d180 - 1) * dn180) * (3 * c * c - 1);
}

double under_fournier_forand_below(double slope, double angle)
{
    double half = sin(angle / 2), half2 = half * half, nu = (3 - slope) / 2;
    double d = delta_of(slope, half2), dn = pow(d, nu);
    double d180 = delta_of(slope, 1), dn180 = pow(d180, nu);
    return ((1 - dn * d) - (1 - dn) * half2) / ((1 - d) * dn) +
           (1 - dn180) / (8 * (d180 - 1) * dn180) * cos(angle) * sin(angle) *
               sin(angle);
}

double under_fournier_forand_slope(double back)
{
    double low = 3.01, high = 4.95;
    for (int i = 0; i < 60; i++) {
        double middle = (low + high) / 2;
        if (1 - under_fournier_forand_below(middle, PI / 2) < back) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return (low + high) / 2;
}

static double of_particles(enum under_kind kind, double parameter, double less)
{
    if (kind == UNDER_FOURNIER_FORAND) {
        return under_fournier_forand(parameter, 2 * asin(sqrt(less / 2)));
    }
    double g = parameter, x = (1 - g) * (1 - g) + 2 * g * less;
    return (1 - g * g) / (4 * PI * x * sqrt(x));
}

static double less_at(int i)
{
    return i == UNDER_CELLS ? 2 : LEAST * exp(RANGE * i / UNDER_CELLS);
}

void under_phase_init(struct under_phase *phase, enum under_kind kind,
                      double parameter, double molecules, double depolarization)
{
    double q = (1 - depolarization) / (1 + depolarization), sum = 0;
    if (kind == UNDER_FOURNIER_FORAND) {
        parameter = under_fournier_forand_slope(parameter);
    }
    phase->mean_cosine = 0;
    phase->back = 0;
    for (int i = 0; i <= UNDER_CELLS; i++) {
        double less = less_at(i), c = 1 - less;
        phase->value[i] =
            (1 - molecules) * of_particles(kind, parameter, less) +
            molecules * (1 + q * c * c) / (4 * PI * (1 + q / 3));
        if (i > 0) {
            double from = less_at(i - 1), middle = (from + less) / 2;
            double share =
                PI * (phase->value[i - 1] + phase->value[i]) * (less - from);
            sum += share;
            phase->mean_cosine -= share * middle;
            phase->back += middle > 1 ? share : 0;
        }
        phase->below[i] = sum;
    }
    /* What is missing turns by less than the least. */
    phase->mean_cosine += 1;
    for (int i = 0; i <= UNDER_CELLS; i++) {
        phase->below[i] += 1 - sum;
    }
}

double under_phase_at(const struct under_phase *phase, double cosine)
{
    double less = 1 - cosine;
    if (less <= LEAST) {
        return phase->value[0];
    }
    double x = log(less / LEAST) * (UNDER_CELLS / RANGE);
    int i = x < UNDER_CELLS - 1 ? (int)x : UNDER_CELLS - 1;
    double f = x - i < 1 ? x - i : 1;
    return phase->value[i] + f * (phase->value[i + 1] - phase->value[i]);
}

double under_phase_turn(const struct under_phase *phase, double number)
{
    if (number < phase->below[0]) {
        return 0;
    }
    int low = 0, high = UNDER_CELLS;
    while (low + 1 < high) {
        int middle = (low + high) / 2;
        if (phase->below[middle] <= number) {
            low = middle;
        } else {
            high = middle;
        }
    }
    double f =
        (number - phase->below[low]) / (phase->below[high] - phase->below[low]);
    double from = less_at(low);
    return from + fmin(f, 1) * (less_at(high) - from);
}

struct under_vec under_turned(struct under_vec d, double less, double azimuth)
{
    /* An orthonormal base (Duff et al. 2017). */
    double sign = copysign(1, d.z), a = -1 / (sign + d.z), b = d.x * d.y * a;
    struct under_vec e = { 1 + sign * d.x * d.x * a, sign * b, -sign * d.x };
    struct under_vec f = { b, sign + d.y * d.y * a, -d.y };
    double sine = sqrt(fmax(0, less * (2 - less))), cosine = 1 - less;
    double p = sine * cos(azimuth), q = sine * sin(azimuth);
    struct under_vec t = { cosine * d.x + p * e.x + q * f.x,
                           cosine * d.y + p * e.y + q * f.y,
                           cosine * d.z + p * e.z + q * f.z };
    double length = sqrt(under_dot(t, t));
    return (struct under_vec){ t.x / length, t.y / length, t.z / length };
}
