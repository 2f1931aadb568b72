#include "ocean/report.h"

#include "base/vec.h"
#include "ocean/directional.h"

static struct pel_sea_moments moments(const struct pel_directional *spectrum,
                                      double k_lo, double *east, double *north)
{
    struct pel_band_moments m;
    pel_directional_moments(spectrum, k_lo, INFINITY, &m);
    *east = m.east;
    *north = m.north;
    return (struct pel_sea_moments){ m.m0, { m.along, m.cross, m.mixed } };
}

void pel_spectrum_row(const struct pel_directional *spectrum, double omega,
                      struct pel_spectrum_row *out)
{
    *out = (struct pel_spectrum_row){ 0 };
    double k = pel_dispersion_k(omega, spectrum->depth_m);
    double place = (log(k) - spectrum->log_k0) / spectrum->step;
    if (!(place >= 0 && place < PEL_DIRECTIONAL_NODES - 1)) {
        return;
    }
    int i = (int)place;
    double f = place - i;
    struct pel_node_moments a, b;
    pel_directional_node(spectrum, i, &a);
    pel_directional_node(spectrum, i + 1, &b);
    double energy = a.energy + f * (b.energy - a.energy);
    double east = a.c1 + f * (b.c1 - a.c1), north = a.s1 + f * (b.s1 - a.s1);
    const double h = 1e-4; /* dω/d ln k */
    double slope = (pel_dispersion_depth(k * exp(h), spectrum->depth_m) -
                    pel_dispersion_depth(k * exp(-h), spectrum->depth_m)) /
                   (2.0 * h);
    out->density = energy / slope;
    out->mean_to_rad = atan2(north, east);
    out->r1 = energy > 0 ? hypot(east, north) / energy : 0;
}

static double density_at(const struct pel_directional *spectrum, double log_k)
{
    struct pel_spectrum_row row;
    double omega = pel_dispersion_depth(exp(log_k), spectrum->depth_m);
    pel_spectrum_row(spectrum, omega, &row);
    return row.density;
}

/* The greatest S(ω): the best node, then a parabola through its neighbours. */
static double peak_omega(const struct pel_directional *spectrum)
{
    double best = 0, step = spectrum->step;
    int at = 0;
    for (int i = 1; i < PEL_DIRECTIONAL_CUT; i++) {
        double s = density_at(spectrum, spectrum->log_k0 + step * i);
        if (s > best) {
            best = s;
            at = i;
        }
    }
    if (!(best > 0)) {
        return 0;
    }
    double log_k = spectrum->log_k0 + step * at;
    double left = density_at(spectrum, log_k - step);
    double right = density_at(spectrum, log_k + step);
    double bend = left - 2.0 * best + right;
    double shift = bend < 0 ? 0.5 * (left - right) / bend : 0;
    return pel_dispersion_depth(exp(log_k + step * pel_clamp(shift, -1, 1)),
                                spectrum->depth_m);
}

void pel_sea_report(const struct pel_sea *sea,
                    const struct pel_directional *spectrum, double wavelength_m,
                    struct pel_sea_report *out)
{
    double east, north, unused;
    *out = (struct pel_sea_report){ 0 };
    out->spectrum = moments(spectrum, 0, &east, &north);
    out->mean_to_rad = atan2(north, east);
    out->peak_omega = peak_omega(spectrum);
    out->drawn = (struct pel_sea_moments){
        sea->m0,
        { sea->slope_variance_along, sea->slope_variance_cross,
          sea->slope_covariance },
    };
    if (wavelength_m > 0) {
        double rms = pel_sea_rms_below(sea, wavelength_m);
        out->spectrum_below =
            moments(spectrum, 2.0 * PEL_PI / wavelength_m, &unused, &unused);
        out->drawn_below =
            (struct pel_sea_moments){ rms * rms,
                                      pel_sea_slopes_below(sea, wavelength_m) };
    }
}

enum pel_err pel_sea_parts(const struct pel_sea_desc *desc,
                           struct pel_sea_parts *out)
{
    struct pel_sea_desc own = *desc;
    struct pel_directional *spectrum;
    struct pel_band_moments all;
    *out = (struct pel_sea_parts){ 0 };
    for (int i = 0; i < desc->swell_count; i++) {
        double rms = desc->swell[i].height_m / 4.0;
        out->swell_m0 += rms * rms;
    }
    own.swell_count = own.single_count = 0;
    own.rain_mm_h = 0;
    enum pel_err err = pel_directional_create(&own, &spectrum);
    if (err) {
        return err;
    }
    pel_directional_continuous(spectrum, 0, INFINITY, &all);
    double omega = peak_omega(spectrum);
    out->wind_sea_m0 = all.m0;
    if (omega > 0 && desc->wind_mps > 0 &&
        desc->kind != PEL_SPECTRUM_MEASURED) {
        double k = pel_dispersion_k(omega, spectrum->depth_m);
        out->wave_age = omega / k / desc->wind_mps;
    }
    pel_directional_destroy(spectrum);
    return PEL_OK;
}
