#include "optics/atmosphere.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "optics/airgeometry.h"
#include "optics/airlight.h"

#define R PEL_EARTH_RADIUS
#define TOP PEL_AIR_TOP

/* Ozone of 300 DU (1 DU = 2.687e20 molecules/m²) under a triangle of area
 * 15 km; cross-sections [m²] at 680, 550, 440 nm and 233 K: Serdyuchenko et
 * al. 2014, 10 nm means as in Bruneton 2017. */
#define OZONE_PEAK_DENSITY (300.0 * 2.687e20 / 15000.0)
static const struct pel_rgb ozone_cross_section = { 1.209e-25, 3.500e-25,
                                                    1.582e-26 };

#define SKY_STEPS 64
#define IRRADIANCE_ZENITHS 16
#define IRRADIANCE_AZIMUTHS 10 /* over half a turn */

static struct pel_rgb rgb_add(struct pel_rgb a, struct pel_rgb b)
{
    return (struct pel_rgb){ a.r + b.r, a.g + b.g, a.b + b.b };
}

static struct pel_rgb rgb_mul(struct pel_rgb a, struct pel_rgb b)
{
    return (struct pel_rgb){ a.r * b.r, a.g * b.g, a.b * b.b };
}

static struct pel_rgb rgb_scale(struct pel_rgb a, double s)
{
    return (struct pel_rgb){ a.r * s, a.g * s, a.b * s };
}

/* --- transmittance ------------------------------------------------------- */

static double clamp_height(double height_m)
{
    return pel_clamp(height_m, 0, TOP);
}

static double ozone_density(const struct pel_atmosphere *a, double h)
{
    return fmax(0, 1.0 - fabs(h - a->ozone_center_m) / a->ozone_width_m);
}

/* Gauss–Legendre, four points. */
static const double gauss_node[4] = { 0.06943184420297371, 0.33000947820757187,
                                      0.66999052179242813,
                                      0.93056815579702629 };
static const double gauss_weight[4] = { 0.17392742256872693,
                                        0.32607257743127307,
                                        0.32607257743127307,
                                        0.17392742256872693 };

/* Distance at which a rising ray from height h passes height `to`, within
 * 0..way. */
static double distance_to_height(double h, double mu, double to, double way)
{
    double r = R + h;
    double c = (to - h) * (to + R + r);
    if (c <= 0) {
        return 0;
    }
    return fmin(c / (r * mu + sqrt(r * r * mu * mu + c)), way);
}

/* The ozone column between the kinks of its profile, where it is smooth. */
static double rising_ozone(const struct pel_atmosphere *a, double h, double mu,
                           double way)
{
    enum { PANELS = 2 };
    double sum = 0;
    for (int side = -1; side <= 0; side++) {
        double low = a->ozone_center_m + side * a->ozone_width_m;
        double from = distance_to_height(h, mu, low, way);
        double to = distance_to_height(h, mu, low + a->ozone_width_m, way);
        for (int i = 0; i < PANELS; i++) {
            for (int j = 0; j < 4; j++) {
                double t = from + (to - from) * (i + gauss_node[j]) / PANELS;
                sum += gauss_weight[j] * (to - from) / PANELS *
                       ozone_density(a, pel_height_along(h, mu, t));
            }
        }
    }
    return sum;
}

/* Columns over `way` metres of a rising ray (mu ≥ 0), in panels that widen
 * with the distance. */
static struct pel_columns rising_columns(const struct pel_atmosphere *a,
                                         double h, double mu, double way)
{
    enum { PANELS = 16 };
    struct pel_columns c = { 0, 0, rising_ozone(a, h, mu, way) };
    for (int i = 0; i < PANELS; i++) {
        double from = way * i * i / (PANELS * PANELS);
        double length = way * (2 * i + 1) / (PANELS * PANELS);
        for (int j = 0; j < 4; j++) {
            double ht = pel_height_along(h, mu, from + gauss_node[j] * length);
            double w = gauss_weight[j] * length;
            c.rayleigh += w * exp(-ht / a->rayleigh_height_m);
            c.mie += w * exp(-ht / a->mie_height_m);
        }
    }
    return c;
}

struct pel_columns pel_atmosphere_columns(const struct pel_atmosphere *a,
                                          double height_m, double mu)
{
    double h = clamp_height(height_m);
    if (mu >= 0) {
        return rising_columns(a, h, mu, pel_distance_to_top(h, mu));
    }
    /* From the lowest point, once forward and once back. */
    double r = R + h;
    double least = r * sqrt(fmax(1.0 - mu * mu, 0));
    double low = clamp_height(least - R);
    struct pel_columns f =
        rising_columns(a, low, 0, pel_distance_to_top(low, 0));
    struct pel_columns b = rising_columns(a, low, 0, -r * mu);
    return (struct pel_columns){ f.rayleigh + b.rayleigh, f.mie + b.mie,
                                 f.ozone + b.ozone };
}

static struct pel_rgb attenuation(const struct pel_atmosphere *a,
                                  struct pel_columns c)
{
    double mie = a->mie_extinction * c.mie;
    return (struct pel_rgb){
        exp(-(a->rayleigh.r * c.rayleigh + a->ozone.r * c.ozone + mie)),
        exp(-(a->rayleigh.g * c.rayleigh + a->ozone.g * c.ozone + mie)),
        exp(-(a->rayleigh.b * c.rayleigh + a->ozone.b * c.ozone + mie)),
    };
}

struct pel_rgb pel_atmosphere_transmittance(const struct pel_atmosphere *a,
                                            double height_m, double mu)
{
    double h = fmax(height_m, 0);
    if (mu < pel_horizon_cosine(h)) {
        return (struct pel_rgb){ 0, 0, 0 };
    }
    if (h > TOP) {
        /* Enter the air where the ray does. */
        double r = R + h;
        double disc = r * r * mu * mu - (h - TOP) * (r + R + TOP);
        if (mu >= 0 || disc < 0) {
            return (struct pel_rgb){ 1, 1, 1 };
        }
        mu = -sqrt(disc) / PEL_ATMOSPHERE_RADIUS;
        h = TOP;
    }
    return attenuation(a, pel_atmosphere_columns(a, h, mu));
}

static double column_top(void)
{
    return sqrt(TOP * (PEL_ATMOSPHERE_RADIUS + R));
}

static void fill_columns(struct pel_atmosphere *a)
{
    double top = column_top();
    for (int i = 0; i < PEL_COLUMN_HEIGHTS; i++) {
        double rho = top * i / (PEL_COLUMN_HEIGHTS - 1);
        double r = sqrt(rho * rho + R * R);
        double h = clamp_height(rho * rho / (r + R));
        double least = TOP - h;
        for (int j = 0; j < PEL_COLUMN_COSINES; j++) {
            double d =
                least + (rho + top - least) * j / (PEL_COLUMN_COSINES - 1);
            double mu = 1;
            if (d > 0) {
                mu = (top * top - rho * rho - d * d) / (2.0 * (R + h) * d);
            }
            mu = pel_clamp(mu, pel_horizon_cosine(h), 1);
            a->columns[i][j] = pel_atmosphere_columns(a, h, mu);
        }
    }
}

static struct pel_columns column_mix(struct pel_columns a, struct pel_columns b,
                                     double f)
{
    return (struct pel_columns){ a.rayleigh + f * (b.rayleigh - a.rayleigh),
                                 a.mie + f * (b.mie - a.mie),
                                 a.ozone + f * (b.ozone - a.ozone) };
}

/* Splits x in 0..1 into a cell of n points and the place inside it. */
static int cell(double x, int n, double *fraction)
{
    double at = pel_clamp(x, 0, 1) * (n - 1);
    int i = (int)at;
    i = i > n - 2 ? n - 2 : i;
    *fraction = at - i;
    return i;
}

/* Transmittance to a Sun that need not be above the horizon. */
static struct pel_rgb sun_transmittance(const struct pel_atmosphere *a,
                                        double h, double sun_mu)
{
    double visible = pel_atmosphere_sun_visible(h, sun_mu);
    if (visible <= 0) {
        return (struct pel_rgb){ 0, 0, 0 };
    }
    double mu = fmax(sun_mu, pel_horizon_cosine(h));
    double top = column_top(), rho = sqrt(h * (2.0 * R + h));
    double least = TOP - h, fi, fj;
    double x = (pel_distance_to_top(h, mu) - least) / (rho + top - least);
    int i = cell(rho / top, PEL_COLUMN_HEIGHTS, &fi);
    int j = cell(x, PEL_COLUMN_COSINES, &fj);
    const struct pel_columns *lower = a->columns[i], *upper = a->columns[i + 1];
    struct pel_columns c =
        column_mix(column_mix(lower[j], lower[j + 1], fj),
                   column_mix(upper[j], upper[j + 1], fj), fi);
    return rgb_scale(attenuation(a, c), visible);
}

double pel_atmosphere_sun_visible(double height_m, double sun_mu)
{
    double h = clamp_height(height_m);
    double x = (sun_mu - pel_horizon_cosine(h)) / PEL_SUN_ANGULAR_RADIUS;
    x = pel_clamp(x, -1, 1);
    return 0.5 + 0.75 * x - 0.25 * x * x * x;
}

/* --- scattering ---------------------------------------------------------- */

double pel_phase_rayleigh(double nu)
{
    return 3.0 / (16.0 * PEL_PI) * (1.0 + nu * nu);
}

double pel_phase_mie(double nu, double g)
{
    double g2 = g * g;
    return 3.0 / (8.0 * PEL_PI) * (1.0 - g2) * (1.0 + nu * nu) /
           ((2.0 + g2) * pow(1.0 + g2 - 2.0 * g * nu, 1.5));
}

/* What one point of a ray does to light. */
struct point {
    double height, sun_mu;
    struct pel_rgb rayleigh; /* scattering, 1/m */
    double mie;              /* scattering, 1/m */
    struct pel_rgb extinction;
};

static struct point ray_point(const struct pel_atmosphere *a, double h,
                              double mu, double sun_mu, double nu, double t)
{
    struct point p;
    p.height = pel_height_along(h, mu, t);
    p.sun_mu = pel_clamp(((R + h) * sun_mu + t * nu) / (R + p.height), -1, 1);
    double mie = exp(-p.height / a->mie_height_m);
    p.rayleigh = rgb_scale(a->rayleigh, exp(-p.height / a->rayleigh_height_m));
    p.mie = a->mie_scattering * mie;
    double ozone = ozone_density(a, p.height);
    mie *= a->mie_extinction;
    p.extinction.r = p.rayleigh.r + mie + a->ozone.r * ozone;
    p.extinction.g = p.rayleigh.g + mie + a->ozone.g * ozone;
    p.extinction.b = p.rayleigh.b + mie + a->ozone.b * ozone;
    return p;
}

/* ∫ exp(−σ t) dt over a step, and the light that passes it. */
static double step_integral(double extinction, double length, double *through)
{
    double depth = extinction * length;
    double before = *through;
    *through = before * exp(-depth);
    return depth > 1e-9 ? before * -expm1(-depth) / extinction
                        : before * length;
}

static struct pel_rgb step_rgb(struct pel_rgb extinction, double length,
                               struct pel_rgb *through)
{
    struct pel_rgb s;
    s.r = step_integral(extinction.r, length, &through->r);
    s.g = step_integral(extinction.g, length, &through->g);
    s.b = step_integral(extinction.b, length, &through->b);
    return s;
}

/* --- the sky ------------------------------------------------------------- */

/* A line of sight against the Sun. */
struct sight {
    double height, mu, zenith, sun_mu, nu;
};

/* Light scattered before, at distance t of a line of sight: the vertical has
 * turned there, and with it the azimuths. */
static struct pel_rgb scattered_before(const struct pel_atmosphere *a,
                                       const struct sight *s,
                                       const struct point *p, double t)
{
    double across = sqrt(fmax(1.0 - s->mu * s->mu, 0));
    double turned = atan2(t * across, R + s->height + t * s->mu);
    double zenith = pel_clamp(s->zenith - turned, 0, PEL_PI);
    double sines = sin(zenith) * sqrt(fmax(1.0 - p->sun_mu * p->sun_mu, 0));
    double cosine = (s->nu - cos(zenith) * p->sun_mu) / fmax(sines, 1e-9);
    return pel_airlight_at(a->airlight, a, p->height, p->sun_mu, zenith,
                           pel_clamp(cosine, -1, 1));
}

static struct pel_rgb sky_from(const struct pel_atmosphere *a,
                               const struct sight *s)
{
    double ground = pel_distance_to_ground(s->height, s->mu);
    double way = ground >= 0 ? ground : pel_distance_to_top(s->height, s->mu);
    double rayleigh = pel_phase_rayleigh(s->nu);
    double mie = pel_phase_mie(s->nu, a->mie_g);
    struct pel_rgb radiance = { 0, 0, 0 }, through = { 1, 1, 1 };
    double power = pel_air_step_power(a, s->height, way, SKY_STEPS), from = 0;
    for (int i = 0; i < SKY_STEPS; i++) {
        double to = way * pow((i + 1.0) / SKY_STEPS, power);
        double t = 0.5 * (from + to);
        struct point p = ray_point(a, s->height, s->mu, s->sun_mu, s->nu, t);
        struct pel_rgb sun = sun_transmittance(a, p.height, p.sun_mu);
        struct pel_rgb before = scattered_before(a, s, &p, t);
        struct pel_rgb once = rgb_scale(p.rayleigh, rayleigh);
        struct pel_rgb all = p.rayleigh;
        once = rgb_add(
            once, (struct pel_rgb){ p.mie * mie, p.mie * mie, p.mie * mie });
        all = rgb_add(all, (struct pel_rgb){ p.mie, p.mie, p.mie });
        struct pel_rgb source =
            rgb_add(rgb_mul(once, sun), rgb_mul(all, before));
        struct pel_rgb step = step_rgb(p.extinction, to - from, &through);
        radiance = rgb_add(radiance, rgb_mul(source, step));
        from = to;
    }
    return rgb_mul(radiance, a->solar_irradiance);
}

struct pel_rgb pel_atmosphere_sky(const struct pel_atmosphere *a,
                                  double height_m, struct pel_vec3 dir,
                                  struct pel_vec3 sun)
{
    double h = fmax(height_m, 0);
    double mu = pel_clamp(dir.z, -1, 1), sun_mu = pel_clamp(sun.z, -1, 1);
    double nu = pel_clamp(pel_vec3_dot(dir, sun), -1, 1);
    if (h > TOP) {
        double r = R + h;
        double disc = r * r * mu * mu - (h - TOP) * (r + R + TOP);
        if (mu >= 0 || disc < 0) {
            return (struct pel_rgb){ 0, 0, 0 };
        }
        double t = -r * mu - sqrt(disc);
        sun_mu = (r * sun_mu + t * nu) / PEL_ATMOSPHERE_RADIUS;
        mu = -sqrt(disc) / PEL_ATMOSPHERE_RADIUS;
        h = TOP;
    }
    const struct sight sight = { h, mu, acos(mu), sun_mu, nu };
    return sky_from(a, &sight);
}

struct pel_rgb pel_atmosphere_sky_irradiance(const struct pel_atmosphere *a,
                                             struct pel_vec3 sun)
{
    struct pel_rgb sum = { 0, 0, 0 };
    double sun_mu = pel_clamp(sun.z, -1, 1);
    double across = sqrt(1.0 - sun_mu * sun_mu);
    for (int i = 0; i < IRRADIANCE_ZENITHS; i++) {
        /* mu dmu with mu = x²: finer towards the horizon. */
        double x = (i + 0.5) / IRRADIANCE_ZENITHS;
        double mu = x * x, sine = sqrt(1.0 - mu * mu);
        double weight = mu * 2.0 * x / IRRADIANCE_ZENITHS;
        for (int j = 0; j < IRRADIANCE_AZIMUTHS; j++) {
            double phi = PEL_PI * (j + 0.5) / IRRADIANCE_AZIMUTHS;
            double nu = mu * sun_mu + sine * across * cos(phi);
            const struct sight sight = { 0, mu, acos(mu), sun_mu, nu };
            struct pel_rgb l = sky_from(a, &sight);
            sum = rgb_add(sum, rgb_scale(l, weight));
        }
    }
    return rgb_scale(sum, 2.0 * PEL_PI / IRRADIANCE_AZIMUTHS);
}

struct pel_rgb pel_atmosphere_sun_irradiance(const struct pel_atmosphere *a,
                                             double height_m,
                                             struct pel_vec3 sun)
{
    double h = fmax(height_m, 0);
    double visible = pel_atmosphere_sun_visible(h, sun.z);
    double mu = fmax(sun.z, pel_horizon_cosine(h));
    struct pel_rgb t = pel_atmosphere_transmittance(a, h, mu);
    return rgb_scale(rgb_mul(a->solar_irradiance, t), visible);
}

void pel_atmosphere_init(const struct pel_atmosphere_desc *desc,
                         struct pel_atmosphere *a)
{
    double visibility = desc->visibility_m;
    if (!(visibility >= 200)) {
        visibility = isnan(visibility) ? 40000 : 200;
    }
    visibility = fmin(visibility, 300000);
    a->airlight = NULL;
    a->solar_irradiance = (struct pel_rgb)PEL_SUN_IRRADIANCE;
    /* 1.24062e-6 λ⁻⁴, λ in µm. */
    a->rayleigh = (struct pel_rgb){ 1.24062e-6 / pow(0.680, 4),
                                    1.24062e-6 / pow(0.550, 4),
                                    1.24062e-6 / pow(0.440, 4) };
    a->rayleigh_height_m = 8000;
    a->mie_extinction = fmax(3.912 / visibility - a->rayleigh.g, 0);
    /* What stands in the air beside the published aerosol is sea salt, which
     * absorbs little: maritime air of Hess, Koepke and Schult 1998 (OPAC). */
    double published = fmin(a->mie_extinction, 4.44e-6);
    a->mie_scattering =
        0.9 * published + 0.98 * (a->mie_extinction - published);
    a->mie_height_m = 1200;
    if (a->mie_extinction * a->mie_height_m > PEL_FOG_DEPTH) {
        a->mie_height_m = PEL_FOG_DEPTH / a->mie_extinction;
    }
    a->mie_g = 0.8;
    a->ozone = rgb_scale(ozone_cross_section, OZONE_PEAK_DENSITY);
    a->ozone_center_m = 25000;
    a->ozone_width_m = 15000;
}

enum pel_err pel_atmosphere_tabulate(struct pel_atmosphere *a,
                                     pel_airlight_share *share, void *pool)
{
    fill_columns(a);
    a->airlight = malloc(sizeof *a->airlight);
    enum pel_err err = a->airlight
                           ? pel_airlight_build(a, share, pool, a->airlight)
                           : PEL_ERR_NO_MEMORY;
    if (err != PEL_OK) {
        pel_atmosphere_finish(a);
    }
    return err;
}

enum pel_err pel_atmosphere_take_table(struct pel_atmosphere *a,
                                       const struct pel_airlight *table)
{
    fill_columns(a);
    a->airlight = malloc(sizeof *a->airlight);
    if (!a->airlight) {
        return PEL_ERR_NO_MEMORY;
    }
    *a->airlight = *table;
    return PEL_OK;
}

void pel_atmosphere_finish(struct pel_atmosphere *a)
{
    free(a->airlight);
    a->airlight = NULL;
}
