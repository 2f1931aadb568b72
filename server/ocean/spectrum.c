#include "ocean/spectrum.h"

#include <math.h>
#include <stdbool.h>

/* Bruneton et al. 2010, below eq. 1. */
#define PM_ALPHA 8.1e-3
#define PM_BETA 0.74

#define SURFACE_TENSION_K 370.0 /* rad/m */

double pel_dispersion_omega(double k)
{
    double r = k / SURFACE_TENSION_K;
    return sqrt(PEL_GRAVITY * k * (1.0 + r * r));
}

static double pm_omega0(double wind_mps)
{
    return PEL_GRAVITY / (PEL_WIND_20_OVER_10 * wind_mps);
}

static double pm_peak(double wind_mps)
{
    return pow(0.8 * PM_BETA, 0.25) * pm_omega0(wind_mps);
}

static const struct {
    unsigned uses;
    bool whole;
} spectra[PEL_SPECTRA] = {
#define PEL_SPECTRUM(ID, uses, whole, add) { uses, whole },
#include "ocean/spectra.def"
};

bool pel_spectrum_uses(enum pel_spectrum_kind kind, unsigned what)
{
    return spectra[kind].uses & what;
}

bool pel_spectrum_is_whole(const struct pel_sea_desc *desc)
{
    return spectra[desc->kind].whole && !(desc->depth_m > 0) &&
           !(desc->rain_mm_h > 0);
}

/* JONSWAP, and TMA, which is that and a factor for the depth (directional.c):
 * those with a peak that is enhanced. */
static bool fetch_limited(const struct pel_sea_desc *d)
{
    return pel_spectrum_uses(d->kind, PEL_USES_GAMMA);
}

/* The fetch laws hold until the sea is fully developed; beyond, they would
 * raise 6 m of sea from 5 m/s of wind. */
static double effective_fetch(const struct pel_sea_desc *d)
{
    double r = 22.0 / pm_peak(d->wind_mps);
    double developed = PEL_GRAVITY * PEL_GRAVITY / d->wind_mps * r * r * r;
    return fmin(d->fetch_m, developed);
}

/* α, β' ω_p⁴ of S = α g² ω⁻⁵ exp(−b ω⁻⁴), without peak enhancement. */
struct tail {
    double alpha, b;
};

static struct tail wind_tail(const struct pel_sea_desc *d)
{
    if (fetch_limited(d)) {
        double u = d->wind_mps;
        double x = u * u / (effective_fetch(d) * PEL_GRAVITY);
        return (struct tail){ 0.076 * pow(x, 0.22),
                              1.25 * pow(pel_spectrum_peak(d), 4.0) };
    }
    return (struct tail){ PM_ALPHA,
                          PM_BETA * pow(pm_omega0(d->wind_mps), 4.0) };
}

double pel_spectrum_peak(const struct pel_sea_desc *d)
{
    if (!(d->wind_mps > 0)) {
        return 0;
    }
    if (fetch_limited(d)) {
        double f = effective_fetch(d);
        return 22.0 * cbrt(PEL_GRAVITY * PEL_GRAVITY / (d->wind_mps * f));
    }
    return pm_peak(d->wind_mps);
}

/* γ^r of JONSWAP. */
static double enhancement(const struct pel_sea_desc *d, double peak,
                          double omega)
{
    double sigma = omega <= peak ? 0.07 : 0.09;
    double t = (omega / peak - 1.0) / sigma;
    return pow(d->gamma, exp(-0.5 * t * t));
}

double pel_spectrum_wind(const struct pel_sea_desc *d, double omega)
{
    if (!(d->wind_mps > 0) || !(omega > 0)) {
        return 0;
    }
    struct tail t = wind_tail(d);
    double o2 = omega * omega;
    double s = t.alpha * PEL_GRAVITY * PEL_GRAVITY / (o2 * o2 * omega) *
               exp(-t.b / (o2 * o2));
    if (fetch_limited(d)) {
        s *= enhancement(d, pel_spectrum_peak(d), omega);
    }
    return s;
}

double pel_spectrum_spreading(const struct pel_sea_desc *d, double omega)
{
    double peak = pel_spectrum_peak(d);
    if (!(peak > 0)) {
        return 0;
    }
    double r = omega / peak;
    if (r < 1.0) {
        return 6.97 * pow(r, 4.06);
    }
    double age = d->wind_mps * peak / PEL_GRAVITY; /* U / c_p */
    return 9.77 * pow(r, -2.33 - 1.45 * (age - 1.17));
}

double pel_spectrum_direction(double s, double theta)
{
    int sign; /* lgamma() would write it where other threads read */
    double log_n = lgamma_r(s + 1.0, &sign) - lgamma_r(s + 0.5, &sign);
    double n = exp(log_n) / (2.0 * sqrt(PEL_PI));
    return n * pow(fabs(cos(0.5 * theta)), 2.0 * s);
}

/* ∫ α g² ω⁻⁵ exp(−b ω⁻⁴) dω, closed form. */
static double tail_m0(struct tail t, double lo, double hi)
{
    double at_lo = lo > 0 ? exp(-t.b / pow(lo, 4.0)) : 0;
    double at_hi = exp(-t.b / pow(hi, 4.0));
    return t.alpha * PEL_GRAVITY * PEL_GRAVITY / (4.0 * t.b) * (at_hi - at_lo);
}

/* Simpson's rule over ln ω. */
static double simpson_m0(const struct pel_sea_desc *d, double lo, double hi)
{
    enum { PANELS = 256 };
    if (!(hi > lo)) {
        return 0;
    }
    double step = log(hi / lo) / (2 * PANELS);
    double sum = 0;
    for (int i = 0; i <= 2 * PANELS; i++) {
        double omega = lo * exp(step * i);
        double weight = i == 0 || i == 2 * PANELS ? 1 : i % 2 ? 4 : 2;
        sum += weight * omega * pel_spectrum_wind(d, omega);
    }
    return sum * step / 3.0;
}

double pel_spectrum_m0(const struct pel_sea_desc *d, double lo, double hi)
{
    double peak = pel_spectrum_peak(d);
    if (!(peak > 0) || !(hi > lo)) {
        return 0;
    }
    if (!fetch_limited(d)) {
        return tail_m0(wind_tail(d), lo, hi);
    }
    /* Below 0.3 ω_p less than 1e-60 of it; beyond 2 ω_p the enhancement is
     * 1 to the last bit; at ω_p its curvature jumps. */
    double join = 2.0 * peak;
    double from = fmax(lo, 0.3 * peak);
    double sum = simpson_m0(d, from, fmin(hi, peak)) +
                 simpson_m0(d, fmax(from, peak), fmin(hi, join));
    if (hi > join) {
        sum += tail_m0(wind_tail(d), fmax(lo, join), hi);
    }
    return sum;
}
