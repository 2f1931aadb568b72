#include "ocean/directional.h"

#define KM 370.0 /* rad/m, slowest wave */
#define CM 0.23  /* m/s, its speed */

static double speed(double k)
{
    return sqrt(PEL_GRAVITY / k * (1.0 + (k / KM) * (k / KM)));
}

/* Drag of Wu 1982: it has no need of the roughness of eq. 66. */
static double friction_velocity(double wind_mps)
{
    return wind_mps * sqrt(1e-3 * (0.8 + 0.065 * wind_mps));
}

double pel_wind_growth(double k, double wind_mps)
{
    const double gain = 0.05;
    double c = speed(k);
    double ratio = friction_velocity(wind_mps) / c;
    return gain * k * c * ratio * ratio;
}

double pel_wind_over_viscosity(double k, double wind_mps)
{
    const double viscosity = 1.05e-6; /* sea water of 20 °C */
    double growth = pel_wind_growth(k, wind_mps);
    return fmax(1.0 - 4.0 * viscosity * k * k / growth, 0.0);
}

/* eq. 37: inverse wave age, 0.84 when fully developed */
static double wave_age(double k0, double fetch_m)
{
    double age = 0.84 * pow(tanh(pow(k0 * fetch_m / 2.2e4, 0.4)), -0.75);
    return fmin(age, 5.0); /* what follows is given up to 5 */
}

double pel_elfouhaily_peak(double wind_mps, double fetch_m)
{
    double k0 = PEL_GRAVITY / (wind_mps * wind_mps);
    double age = wave_age(k0, fetch_m);
    return k0 * age * age;
}

void pel_elfouhaily(double k, double wind_mps, double fetch_m, double *density,
                    double *delta)
{
    double k0 = PEL_GRAVITY / (wind_mps * wind_mps);
    double age = wave_age(k0, fetch_m);
    double kp = k0 * age * age;
    double c = speed(k), cp = speed(kp);
    double friction = friction_velocity(wind_mps);

    double root = sqrt(k / kp) - 1.0;
    double gamma = age < 1.0 ? 1.7 : 1.7 + 6.0 * log10(age);
    double sigma = 0.08 * (1.0 + 4.0 / (age * age * age));
    double peak = exp(-1.25 * (kp / k) * (kp / k)) *
                  pow(gamma, exp(-root * root / (2.0 * sigma * sigma)));
    /* eq. 31, 32, 34: long waves */
    double low =
        0.5 * 6e-3 * sqrt(age) * cp / c * peak * exp(-age / sqrt(10.0) * root);
    /* eq. 40, 41, 44: short waves */
    double l = log(friction / CM);
    double alpha = fmax(0.01 * (1.0 + (l < 0 ? l : 3.0 * l)), 0.0);
    double d = k / KM - 1.0;
    double high = 0.5 * alpha * CM / c * peak * exp(-0.25 * d * d);
    *density = (low + high) / (k * k * k); /* eq. 30 */
    /* eq. 57 */
    *delta = tanh(log(2.0) / 4.0 + 4.0 * pow(c / cp, 2.5) +
                  0.13 * friction / CM * pow(CM / c, 2.5));
}
