#include "optics/thermal.h"

#include <complex.h>
#include <math.h>

#define LOW_UM 8.0
#define HIGH_UM 12.0
#define STEPS 64         /* even */
#define C1 1.191042972e8 /* 2 h c², W µm⁴ m⁻² sr⁻¹ */
#define C2 1.438776877e4 /* h c / k, µm K */

static double planck(double um, double kelvin)
{
    return C1 / (pow(um, 5) * expm1(C2 / (um * kelvin)));
}

double pel_thermal_radiance(double kelvin)
{
    double h = (HIGH_UM - LOW_UM) / STEPS, sum = 0;
    for (int i = 0; i <= STEPS; i++) {
        double weight = i == 0 || i == STEPS ? 1 : i % 2 ? 4 : 2;
        sum += weight * planck(LOW_UM + h * i, kelvin);
    }
    return sum * h / 3;
}

double pel_thermal_temperature(double radiance)
{
    double low = 100, high = 2000;
    for (int i = 0; i < 60; i++) {
        double middle = 0.5 * (low + high);
        if (pel_thermal_radiance(middle) < radiance) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return 0.5 * (low + high);
}

/* Water's index n + i k, from 8 µm on (Hale and Querry 1973, table I). */
static const struct {
    double um, n, k;
} water[] = {
    { 8.0, 1.291, 0.0343 },  { 8.2, 1.286, 0.0351 },  { 8.4, 1.281, 0.0361 },
    { 8.6, 1.275, 0.0372 },  { 8.8, 1.269, 0.0385 },  { 9.0, 1.262, 0.0399 },
    { 9.2, 1.255, 0.0415 },  { 9.4, 1.247, 0.0433 },  { 9.6, 1.239, 0.0454 },
    { 9.8, 1.229, 0.0479 },  { 10.0, 1.218, 0.0508 }, { 10.5, 1.185, 0.0662 },
    { 11.0, 1.153, 0.0968 }, { 11.5, 1.126, 0.142 },  { 12.0, 1.111, 0.199 },
};
#define ROWS ((int)(sizeof water / sizeof *water))

static double reflectance(double complex index, double cosine)
{
    double complex inside = csqrt(1 - (1 - cosine * cosine) / (index * index));
    double complex s = (cosine - index * inside) / (cosine + index * inside);
    double complex p = (index * cosine - inside) / (index * cosine + inside);
    return 0.5 * (creal(s * conj(s)) + creal(p * conj(p)));
}

double pel_thermal_emissivity(double cosine)
{
    double sum = 0, all = 0;
    for (int i = 0; i < ROWS; i++) {
        double from = water[i > 0 ? i - 1 : 0].um,
               to = water[i < ROWS - 1 ? i + 1 : i].um;
        double weight = (to - from) * planck(water[i].um, 288);
        sum += weight * (1 - reflectance(water[i].n + I * water[i].k, cosine));
        all += weight;
    }
    return sum / all;
}

#define SLOPES 24 /* each way */
#define REACH 4.0 /* standard deviations */

void pel_thermal_level(double out[PEL_THERMAL_LEVELS])
{
    for (int i = 0; i < PEL_THERMAL_LEVELS; i++) {
        out[i] = pel_thermal_emissivity((double)i / (PEL_THERMAL_LEVELS - 1));
    }
}

static double between(const double level[PEL_THERMAL_LEVELS], double cosine)
{
    double at = fmin(cosine, 1) * (PEL_THERMAL_LEVELS - 1);
    int i = (int)fmin(at, PEL_THERMAL_LEVELS - 2);
    return level[i] + (at - i) * (level[i + 1] - level[i]);
}

struct pel_thermal_rough
pel_thermal_rough(double cosine, double variance,
                  const double level[PEL_THERMAL_LEVELS])
{
    double deviation = sqrt(fmax(variance, 1e-10));
    double sine = sqrt(fmax(1 - cosine * cosine, 0));
    double shown = 0, sent = 0, back = 0, up = 0;
    for (int i = -SLOPES; i <= SLOPES; i++) {
        for (int j = 0; j <= SLOPES; j++) {
            double a = REACH * i / SLOPES, b = REACH * j / SLOPES;
            double x = -deviation * a, y = -deviation * b;
            /* Not normalised: the facet's area is the normal's length. */
            double faces = x * sine + cosine;
            if (faces <= 0) {
                continue;
            }
            double weight = exp(-0.5 * (a * a + b * b)) * (j ? 2 : 1) * faces;
            double length2 = 1 + x * x + y * y;
            double e = between(level, faces / sqrt(length2));
            shown += weight;
            sent += weight * e;
            back += weight * (1 - e);
            up += weight * (1 - e) * fmax(2 * faces / length2 - cosine, 0);
        }
    }
    return (struct pel_thermal_rough){ sent / shown, up / back };
}

/* Over water [Pa] (Buck 1981). */
static double saturated_pa(double kelvin)
{
    double c = kelvin - PEL_KELVIN;
    return 611.21 * exp(17.502 * c / (240.97 + c));
}

struct pel_thermal_air pel_thermal_air(double kelvin, double humidity,
                                       double visibility_m, double cloud)
{
    double pa = humidity * saturated_pa(kelvin);
    double per_cm3 = pa / (1.380649e-23 * kelvin) * 1e-6;
    double own = (1.25e-22 + 1.67e-19 * exp(-7.87e-3 * 1000)) *
                 exp(1800 * (1 / kelvin - 1 / 296.0));
    double vapour = own * per_cm3 * (pa / 101325) * 100;
    double share = pel_clamp(
        0.12 + 0.88 * log(1e4 / visibility_m) / log(1e4 / 500.0), 0.12, 1);
    double clear = 0.24 + 2.98e-8 * pow(0.01 * pa, 2) * exp(3000 / kelvin);
    clear = fmin(clear, 1);
    return (struct pel_thermal_air){
        .kelvin = kelvin,
        .extinction = vapour + 3e-5 + share * 3.912 / visibility_m,
        .zenith = clear + (1 - clear) * cloud,
    };
}

double pel_thermal_masses(double sine)
{
    double s = pel_clamp(sine, 0, 1), deg = asin(s) / PEL_DEG;
    return fmin(1 / (s + 0.50572 * pow(deg + 6.07995, -1.6364)), 38);
}

double pel_thermal_sky(const struct pel_thermal_air *air, double sine)
{
    double through = pow(1 - air->zenith, pel_thermal_masses(sine));
    return (1 - through) * pel_thermal_radiance(air->kelvin);
}

double pel_thermal_sunned(double sine, double facing, double wind_mps)
{
    if (sine <= 0 || facing <= 0) {
        return 0;
    }
    double beam = 1361 * pow(0.7, pow(pel_thermal_masses(sine), 0.678));
    return 0.6 * beam * facing / (5.7 + 3.8 * wind_mps);
}
