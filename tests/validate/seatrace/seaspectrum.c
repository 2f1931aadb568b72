#include "seaspectrum.h"

#include <math.h>

#define PI 3.14159265358979323846
#define GRAVITY 9.81
/* Elfouhaily et al. 1997: where gravity and surface tension are equal. */
#define K_CAPILLARY 370.0
#define C_CAPILLARY 0.23
/* Kinematic viscosity of sea water at 20 degrees, m2/s. */
#define VISCOSITY 1.05e-6

static double omega_of(double k)
{
    double r = k / K_CAPILLARY;
    return sqrt(GRAVITY * k * (1 + r * r));
}

/* Drag of Wu 1982. */
static double friction_velocity(double wind_mps)
{
    return wind_mps * sqrt((0.8 + 0.065 * wind_mps) * 1e-3);
}

/* Pierson and Moskowitz 1964, S(omega) = alpha g2 / omega5
 * exp(-0.74 (g / (V omega))4), with the wind at 20 m of the neutral profile,
 * 1.0625 times that at 10 m. Frequencies become wave numbers by gravity's
 * dispersion, omega2 = g k: the tail then is alpha / (2 k3) down to the
 * shortest wave, as the sea is defined; with surface tension the
 * mean-square slope would be 2 to 3 % less. Spreading: Hasselmann, Dunckel and
 * Ewing 1980, the exponent held at 2 from below, as the sea is defined. */
static void pierson_moskowitz(struct sea_spectrum *spectrum, int i, double k)
{
    double v = 1.0625 * spectrum->wind_mps;
    double omega = sqrt(GRAVITY * k);
    spectrum->elevation[i] = 0.0081 * GRAVITY * GRAVITY / pow(omega, 5) *
                             exp(-0.74 * pow(GRAVITY / (v * omega), 4)) *
                             GRAVITY / (2 * omega);
    double peak = pow(4 * 0.74 / 5, 0.25) * GRAVITY / v;
    double over_speed = spectrum->wind_mps * peak / GRAVITY;
    double mu = -2.33 - 1.45 * (over_speed - 1.17);
    double f = omega / peak;
    double s = f < 1.05 ? 6.97 * pow(f, 4.06) : 9.77 * pow(f, mu);
    s = fmax(s, 2);
    spectrum->spread[i] = s;
    spectrum->norm[i] = exp(lgamma(s + 1) - lgamma(s + 0.5)) / (2 * sqrt(PI));
}

/* Elfouhaily, Chapron, Katsaros and Vandemark 1997, eq. 30 to 57; times the
 * share that the wind keeps up against viscosity, 1 - 4 nu k2 / beta with
 * beta = 0.05 omega (u star / c)2 (Plant 1982), as the sea is defined. */
static void elfouhaily(struct sea_spectrum *spectrum, int i, double k)
{
    double u = spectrum->wind_mps;
    double reach = GRAVITY * spectrum->fetch_m / (u * u);
    double age = 0.84 * pow(tanh(pow(reach / 2.2e4, 0.4)), -0.75);
    double k_peak = GRAVITY / (u * u) * age * age;
    double star = friction_velocity(u);
    double c = omega_of(k) / k;
    double c_peak = omega_of(k_peak) / k_peak;
    double root = sqrt(k / k_peak) - 1;

    double gamma = age < 1 ? 1.7 : 1.7 + 6 * log10(age);
    double sigma = 0.08 * (1 + 4 / (age * age * age));
    double peaked = pow(gamma, exp(-root * root / (2 * sigma * sigma)));
    double low = exp(-1.25 * (k_peak / k) * (k_peak / k)) * peaked;
    double b_long =
        0.5 * 6e-3 * sqrt(age) * c_peak / c * low * exp(-age / sqrt(10) * root);
    double alpha =
        1e-2 * (1 + (star < C_CAPILLARY ? 1 : 3) * log(star / C_CAPILLARY));
    double off = k / K_CAPILLARY - 1;
    double b_short =
        0.5 * fmax(alpha, 0) * C_CAPILLARY / c * low * exp(-0.25 * off * off);
    double growth = 0.05 * omega_of(k) * (star / c) * (star / c);
    double kept = fmax(0, 1 - 4 * VISCOSITY * k * k / growth);
    spectrum->elevation[i] = (b_long + b_short) / (k * k * k) * kept;
    spectrum->spread[i] =
        tanh(0.25 * log(2) + 4 * pow(c / c_peak, 2.5) +
             0.13 * star / C_CAPILLARY * pow(C_CAPILLARY / c, 2.5));
    spectrum->norm[i] = 1 / (2 * PI);
}

void sea_spectrum_init(struct sea_spectrum *spectrum, enum sea_kind kind,
                       double wind_mps, double fetch_m, double shortest_m)
{
    spectrum->kind = kind;
    spectrum->wind_mps = wind_mps;
    spectrum->fetch_m = fetch_m;
    double v = 1.0625 * wind_mps;
    double omega = pow(4 * 0.74 / 5, 0.25) * GRAVITY / v;
    spectrum->k_peak = omega * omega / GRAVITY;
    spectrum->k_low = spectrum->k_peak / 8;
    spectrum->k_high = 2 * PI / shortest_m;
    spectrum->log_low = log(spectrum->k_low);
    spectrum->log_step =
        (log(spectrum->k_high) - spectrum->log_low) / (SEA_TABLE - 1);
    for (int i = 0; i < SEA_TABLE; i++) {
        double k = exp(spectrum->log_low + i * spectrum->log_step);
        if (kind == SEA_PIERSON_MOSKOWITZ) {
            pierson_moskowitz(spectrum, i, k);
        } else {
            elfouhaily(spectrum, i, k);
        }
    }
}

static double between(const double *table, int i, double part)
{
    return table[i] + part * (table[i + 1] - table[i]);
}

double sea_spectrum_density(const struct sea_spectrum *spectrum, double k,
                            double cos_angle)
{
    if (k < spectrum->k_low || k > spectrum->k_high) {
        return 0;
    }
    double at = (log(k) - spectrum->log_low) / spectrum->log_step;
    int i = (int)fmin(fmax(at, 0), SEA_TABLE - 2);
    double part = at - i;
    double spread = between(spectrum->spread, i, part);
    double norm = between(spectrum->norm, i, part);
    double shape = spectrum->kind == SEA_PIERSON_MOSKOWITZ
                       ? pow(fmax(0.5 + 0.5 * cos_angle, 0), spread)
                       : 1 + spread * (2 * cos_angle * cos_angle - 1);
    return between(spectrum->elevation, i, part) / k * norm * shape;
}

struct sea_moments sea_spectrum_moments(const struct sea_spectrum *spectrum,
                                        double k_from, double k_to)
{
    enum { RINGS = 4000, ANGLES = 180 };
    struct sea_moments sum = { 0 };
    double step = log(k_to / k_from) / RINGS;
    for (int i = 0; i < RINGS; i++) {
        double k = k_from * exp((i + 0.5) * step);
        for (int j = 0; j < ANGLES; j++) {
            double angle = 2 * PI * (j + 0.5) / ANGLES;
            double c = cos(angle);
            double e = sea_spectrum_density(spectrum, k, c) * k * k * step * 2 *
                       PI / ANGLES;
            sum.m0 += e;
            sum.along += e * k * k * c * c;
            sum.cross += e * k * k * (1 - c * c);
        }
    }
    return sum;
}
