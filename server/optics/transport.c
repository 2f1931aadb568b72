#include "optics/transport.h"

#include <math.h>
#include <stdio.h>

#include "base/vec.h"
#include "optics/brdf.h"
#include "optics/linear.h"
#include "optics/ordinates.h"

/* Directions of the second order's quadrature: the phase function's Legendre
 * and Fourier series fall off as g^n, and 0.924^128 is 4e-5. */
#define ZENITHS 64 /* in each hemisphere */
#define AZIMUTHS 128

enum pel_err pel_optics_check(const char *name, const char *unit, double value,
                              double minimum, double maximum,
                              struct pel_fault *fault)
{
    if (value >= minimum && value <= maximum) {
        return PEL_OK;
    }
    pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                  "%s must be from %g to %g %s, not %g", name, minimum, maximum,
                  unit, value);
    if (fault) {
        snprintf(fault->path, sizeof fault->path, "%s", name);
        snprintf(fault->value, sizeof fault->value, "%g", value);
        fault->unit = unit;
        fault->minimum = minimum;
        fault->maximum = maximum;
    }
    return PEL_ERR_OUT_OF_RANGE;
}

enum pel_err pel_medium_check(const struct pel_medium *m,
                              struct pel_fault *fault)
{
    enum pel_err err =
        pel_optics_check("absorption", "1/m", m->absorption, PEL_ABSORPTION_MIN,
                         PEL_COEFFICIENT_MAX, fault);
    if (!err) {
        err = pel_optics_check("scattering", "1/m", m->scattering, 0.0,
                               PEL_COEFFICIENT_MAX, fault);
    }
    if (!err) {
        err = pel_optics_check("asymmetry", "1", m->asymmetry, 0.0,
                               PEL_ASYMMETRY_MAX, fault);
    }
    if (!err) {
        err = pel_optics_check("molecular", "1", m->molecular, 0.0, 1.0, fault);
    }
    if (!err && m->back != 0.0) {
        err = pel_optics_check("back", "1", m->back, PEL_PHASE_BACK_MIN,
                               PEL_PHASE_BACK_MAX, fault);
    }
    if (!err) {
        err = pel_optics_check("depth", "m", m->depth_m, PEL_DEPTH_MIN,
                               PEL_DEPTH_MAX, fault);
    }
    if (!err) {
        err = pel_optics_check("albedo", "1", m->albedo, 0.0, 1.0, fault);
    }
    return err;
}

struct pel_phase pel_medium_phase(const struct pel_medium *m)
{
    return pel_phase_make(m->molecular, m->asymmetry, m->back);
}

double pel_medium_forward(const struct pel_medium *m)
{
    double particles =
        m->back > 0.0 ? 1.0 - m->back : pel_hg_forward_fraction(m->asymmetry);
    return 0.5 * m->molecular + (1.0 - m->molecular) * particles;
}

double pel_medium_mean_cosine(const struct pel_medium *m)
{
    double moments[2];
    struct pel_phase p = pel_medium_phase(m);
    pel_phase_moments(&p, 2, moments);
    return moments[1];
}

double pel_hg_phase(double nu, double g)
{
    double d = 1.0 + g * g - 2.0 * g * nu;
    return (1.0 - g * g) / (4.0 * PEL_PI * d * sqrt(d));
}

double pel_hg_forward_fraction(double g)
{
    if (g < 1e-3) {
        return 0.5 + 0.75 * g; /* + O(g³) */
    }
    /* ∫ (1−g²)/2 (1+g²−2gν)^(−3/2) dν over ν = 0..1. */
    return (1.0 - g * g) / (2.0 * g) *
           (1.0 / (1.0 - g) - 1.0 / sqrt(1.0 + g * g));
}

double pel_hg_asymmetry(double nu, double phase)
{
    double low = 0.0, high = PEL_ASYMMETRY_MAX;
    for (int i = 0; i < 60; i++) {
        double g = 0.5 * (low + high);
        if (pel_hg_phase(nu, g) > phase) {
            low = g;
        } else {
            high = g;
        }
    }
    return 0.5 * (low + high);
}

struct pel_interface pel_interface_at(const struct pel_geometry *geometry)
{
    const double n = PEL_WATER_INDEX;
    double sun_sine = sin(geometry->sun_zenith_rad) / n;
    double view_sine = sin(geometry->view_zenith_rad) / n;
    double sun_air = fmax(cos(geometry->sun_zenith_rad), 0.0);
    double view_air = fmax(cos(geometry->view_zenith_rad), 0.0);
    struct pel_interface f = {
        .sun_mu = sqrt(1.0 - sun_sine * sun_sine),
        .view_mu = sqrt(1.0 - view_sine * view_sine),
    };
    f.scatter_nu = sun_sine * view_sine * cos(geometry->azimuth_rad) -
                   f.sun_mu * f.view_mu;
    f.beam = (1.0 - pel_fresnel_exact(sun_air, n)) * sun_air / f.sun_mu;
    f.leaving = (1.0 - pel_fresnel_exact(view_air, n)) / (n * n);
    return f;
}

static double extinction(const struct pel_medium *m)
{
    return m->absorption + m->scattering;
}

double pel_transport_single(const struct pel_medium *m,
                            const struct pel_geometry *geometry,
                            enum pel_extinction kind)
{
    struct pel_interface f = pel_interface_at(geometry);
    /* c (1 − ω0 c_f) = a + b (1 − c_f) = a + b_b. */
    double c =
        kind == PEL_EXTINCTION_FULL
            ? extinction(m)
            : m->absorption + m->scattering * (1.0 - pel_medium_forward(m));
    struct pel_phase phase = pel_medium_phase(m);
    double beta = m->scattering * pel_phase_at(&phase, f.scatter_nu);
    double horizontal = f.beam * f.sun_mu;
    return f.leaving * horizontal * beta / ((f.sun_mu + f.view_mu) * c) *
           -expm1(-m->depth_m * c * (1.0 / f.sun_mu + 1.0 / f.view_mu));
}

/* (1 − e^(−x)) / x. */
static double mean_decay(double x)
{
    return fabs(x) < 1e-8 ? 1.0 - 0.5 * x : -expm1(-x) / x;
}

double pel_transport_first_path(const struct pel_medium *m, double sun_mu,
                                double z, double mu)
{
    double c = extinction(m), sun = exp(-c * z / sun_mu);
    if (mu > 0.0) {
        /* I's difference of exponentials over 1 − sec θ_io cos θ, with the
         * larger one taken out so that neither overflows. */
        double x = c * z * (1.0 / mu - 1.0 / sun_mu);
        return x >= 0.0 ? z / mu * sun * mean_decay(x)
                        : z / mu * exp(-c * z / mu) * mean_decay(-x);
    }
    double rate = c * (1.0 / sun_mu - 1.0 / mu);
    return -(m->depth_m - z) / mu * sun * mean_decay(rate * (m->depth_m - z));
}

/* ∫₀^d e^(−sz) dz. */
static double decayed(double s, double d)
{
    return d * mean_decay(s * d);
}

/* (f(s) − f(s + x)) / x for f = decayed. */
static double decayed_slope(double s, double x, double d)
{
    if (fabs(x) > 1e-4 * s) {
        return (decayed(s, d) - decayed(s + x, d)) / x;
    }
    double t = s + 0.5 * x, u = t * d;
    return u < 1e-3 ? d * d * (0.5 - u / 3.0)
                    : (-expm1(-u) - u * exp(-u)) / (t * t);
}

double pel_transport_second_path(const struct pel_medium *m, double sun_mu,
                                 double view_mu, double mu)
{
    double c = extinction(m), d = m->depth_m;
    double s = c * (1.0 / view_mu + 1.0 / sun_mu);
    if (mu > 0.0) {
        return decayed_slope(s, c * (1.0 / mu - 1.0 / sun_mu), d) / mu;
    }
    double y = c * (1.0 / sun_mu - 1.0 / mu);
    /* e^(−sz) less what began below the bottom. */
    double x = (y - s) * d;
    double below = x >= 0.0 ? d * exp(-s * d) * mean_decay(x)
                            : d * exp(-y * d) * mean_decay(-x);
    return (decayed(s, d) - below) / (-mu * y);
}

struct directions {
    double sun_sine, view_sine, view_cos_azimuth, view_sin_azimuth;
};

/* ∫ p(α) p(α') dφ at zenith cosine mu (> 0 downward), `count` azimuths. */
static double azimuth_sum(const struct pel_interface *f,
                          const struct directions *d,
                          const struct pel_phase_split *p, double mu,
                          const double *circle, int count)
{
    double sine = sqrt(fmax(1.0 - mu * mu, 0.0)), sum = 0.0;
    for (int j = 0; j < count; j++) {
        double cosine = circle[2 * j], sin_azimuth = circle[2 * j + 1];
        double from_sun = mu * f->sun_mu + sine * d->sun_sine * cosine;
        double to_view =
            -mu * f->view_mu + sine * d->view_sine *
                                   (cosine * d->view_cos_azimuth +
                                    sin_azimuth * d->view_sin_azimuth);
        sum += pel_phase_rest(p, from_sun) * pel_phase_rest(p, to_view);
    }
    return sum * 2.0 * PEL_PI / count;
}

static void fill_circle(double *circle, int count)
{
    for (int j = 0; j < count; j++) {
        double azimuth = 2.0 * PEL_PI * (j + 0.5) / count;
        circle[2 * j] = cos(azimuth);
        circle[2 * j + 1] = sin(azimuth);
    }
}

static struct directions directions_of(const struct pel_geometry *geometry)
{
    return (struct directions){
        .sun_sine = sin(geometry->sun_zenith_rad) / PEL_WATER_INDEX,
        .view_sine = sin(geometry->view_zenith_rad) / PEL_WATER_INDEX,
        .view_cos_azimuth = cos(geometry->azimuth_rad),
        .view_sin_azimuth = sin(geometry->azimuth_rad),
    };
}

double pel_transport_second(const struct pel_medium *m,
                            const struct pel_geometry *geometry)
{
    struct pel_interface f = pel_interface_at(geometry);
    struct directions d = directions_of(geometry);
    struct pel_phase whole = pel_medium_phase(m);
    struct pel_phase_split split = pel_phase_split(&whole);
    double mu[ZENITHS], weight[ZENITHS], circle[2 * AZIMUTHS];
    pel_gauss_legendre(ZENITHS, 0.0, 1.0, mu, weight);
    fill_circle(circle, AZIMUTHS);
    /* Once by the peak, before or after, that is straight on. */
    double sum =
        split.peak * pel_phase_rest(&split, f.scatter_nu) *
        (pel_transport_second_path(m, f.sun_mu, f.view_mu, f.sun_mu) +
         pel_transport_second_path(m, f.sun_mu, f.view_mu, -f.view_mu));
    for (int i = 0; i < ZENITHS; i++) {
        for (int side = -1; side <= 1; side += 2) {
            double down = side * mu[i];
            sum += weight[i] *
                   azimuth_sum(&f, &d, &split, down, circle, AZIMUTHS) *
                   pel_transport_second_path(m, f.sun_mu, f.view_mu, down);
        }
    }
    return f.leaving * f.beam * m->scattering * m->scattering * sum / f.view_mu;
}

double pel_transport_second_sampled(const struct pel_medium *m,
                                    const struct pel_geometry *geometry,
                                    int planes, int zeniths)
{
    struct pel_interface f = pel_interface_at(geometry);
    struct directions d = directions_of(geometry);
    struct pel_phase whole = pel_medium_phase(m);
    struct pel_phase_split split = pel_phase_split(&whole);
    double circle[4 * 256], total = 0.0;
    planes = planes < 1 ? 1 : planes > 64 ? 64 : planes;
    zeniths = zeniths < 2 ? 2 : zeniths > 256 ? 256 : zeniths;
    fill_circle(circle, 2 * zeniths);
    /* Planes at equal steps of what the way in and out lets through. */
    double s = extinction(m) * (1.0 / f.view_mu + 1.0 / f.sun_mu);
    double reach = -expm1(-s * m->depth_m);
    for (int i = -2; i < zeniths; i++) {
        double theta = PEL_PI * (i + 0.5) / zeniths;
        double mu = i == -2 ? f.sun_mu : i == -1 ? -f.view_mu : cos(theta);
        double paths = 0.0;
        for (int k = 0; k < planes; k++) {
            double z = -log1p(-reach * (k + 0.5) / planes) / s;
            paths += exp(z * extinction(m) / f.sun_mu) *
                     pel_transport_first_path(m, f.sun_mu, z, mu);
        }
        double turned =
            i < 0 ? split.peak * pel_phase_rest(&split, f.scatter_nu)
                  : azimuth_sum(&f, &d, &split, mu, circle, 2 * zeniths) *
                        sin(theta) * PEL_PI / zeniths;
        total += turned * paths * reach / (planes * s);
    }
    return f.leaving * f.beam * m->scattering * m->scattering * total /
           f.view_mu;
}

double pel_transport_bottom(const struct pel_medium *m,
                            const struct pel_geometry *geometry)
{
    struct pel_interface f = pel_interface_at(geometry);
    double way = 1.0 / f.sun_mu + 1.0 / f.view_mu;
    return f.leaving * f.beam * f.sun_mu * m->albedo / PEL_PI *
           exp(-extinction(m) * m->depth_m * way);
}

static enum pel_err higher_orders(const struct pel_medium *m,
                                  const struct pel_geometry *geometry,
                                  struct pel_leaving *out)
{
    enum { NODES = PEL_ORDINATES_REFERENCE };
    struct pel_ordinates *o = pel_ordinates_create(NODES, 1e-7);
    if (!o) {
        return PEL_ERR_NO_MEMORY;
    }
    struct pel_interface f = pel_interface_at(geometry);
    struct pel_ordinates_light light = {
        .sun_zenith_rad = geometry->sun_zenith_rad,
        .sun = 1.0,
    };
    double modes[2 * NODES], dark = 0.0;
    int count = 0;
    pel_ordinates_solve(o, m, &light, &f.view_mu, 1, modes, &count, &dark);
    double without = dark + pel_ordinates_single(o, m, f.beam, f.sun_mu,
                                                 f.view_mu, f.scatter_nu);
    for (int i = 1; i < count; i++) {
        without += modes[i] * cos(i * geometry->azimuth_rad);
    }
    pel_ordinates_destroy(o);
    double two = out->single + out->second;
    out->higher = fmax(f.leaving * without - two, 0.0);
    double bottom = f.leaving * (modes[0] - dark);
    out->bottom_scattered = fmax(bottom - out->bottom_direct, 0.0);
    return PEL_OK;
}

enum pel_extinction pel_orders_extinction(enum pel_water_orders orders)
{
    return orders == PEL_ORDERS_PAPER || orders == PEL_ORDERS_SINGLE
               ? PEL_EXTINCTION_REDUCED
               : PEL_EXTINCTION_FULL;
}

enum pel_err pel_transport_leaving(const struct pel_medium *m,
                                   const struct pel_geometry *geometry,
                                   enum pel_water_orders orders,
                                   struct pel_leaving *out)
{
    enum pel_err err = PEL_OK;
    *out = (struct pel_leaving){
        .single =
            pel_transport_single(m, geometry, pel_orders_extinction(orders)),
        .second = orders == PEL_ORDERS_SINGLE
                      ? 0.0
                      : pel_transport_second(m, geometry),
        .bottom_direct = pel_transport_bottom(m, geometry),
    };
    if (orders == PEL_ORDERS_ALL) {
        err = higher_orders(m, geometry, out);
    }
    out->total = out->single + out->second + out->higher + out->bottom_direct +
                 out->bottom_scattered;
    return err;
}
