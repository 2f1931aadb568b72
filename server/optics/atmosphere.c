#include "optics/atmosphere.h"

#include <math.h>
#include <stdbool.h>

#define R PEL_EARTH_RADIUS
#define TOP (PEL_ATMOSPHERE_RADIUS - PEL_EARTH_RADIUS)

/* Ozone of 300 DU (1 DU = 2.687e20 molecules/m²) under a triangle of area
 * 15 km; cross-sections [m²] at 680, 550, 440 nm and 233 K: Serdyuchenko et
 * al. 2014, 10 nm means as in Bruneton 2017. */
#define OZONE_PEAK_DENSITY (300.0 * 2.687e20 / 15000.0)
static const struct pel_rgb ozone_cross_section = { 1.209e-25, 3.500e-25,
                                                    1.582e-26 };

#define SKY_STEPS 64
#define MULTIPLE_ZENITHS 8
#define MULTIPLE_AZIMUTHS 4 /* over half a turn */
#define MULTIPLE_STEPS 16
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

/* --- geometry ------------------------------------------------------------ */

/* Height at distance t along a ray from height h, without cancellation. */
static double height_along(double h, double mu, double t)
{
    double r = R + h;
    double rise = t * (t + 2.0 * r * mu); /* r_t² − r² */
    return fmax(h + rise / (sqrt(fmax(r * r + rise, 0)) + r), 0);
}

static double distance_to_top(double h, double mu)
{
    double r = R + h;
    double c = (TOP - h) * (PEL_ATMOSPHERE_RADIUS + r);
    return -r * mu + sqrt(fmax(r * r * mu * mu + c, 0));
}

/* Negative where the ray does not meet the ground. */
static double distance_to_ground(double h, double mu)
{
    double r = R + h;
    double c = h * (R + r);
    double disc = r * r * mu * mu - c;
    if (mu >= 0 || disc < 0) {
        return -1;
    }
    return c / (-r * mu + sqrt(disc));
}

static double horizon_cosine(double h)
{
    return -sqrt(h * (2.0 * R + h)) / (R + h);
}

static double clamp_height(double height_m)
{
    return pel_clamp(height_m, 0, TOP);
}

/* --- transmittance ------------------------------------------------------- */

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
                       ozone_density(a, height_along(h, mu, t));
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
            double ht = height_along(h, mu, from + gauss_node[j] * length);
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
        return rising_columns(a, h, mu, distance_to_top(h, mu));
    }
    /* From the lowest point, once forward and once back. */
    double r = R + h;
    double least = r * sqrt(fmax(1.0 - mu * mu, 0));
    double low = clamp_height(least - R);
    struct pel_columns f = rising_columns(a, low, 0, distance_to_top(low, 0));
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
    if (mu < horizon_cosine(h)) {
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
            mu = pel_clamp(mu, horizon_cosine(h), 1);
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
    double mu = fmax(sun_mu, horizon_cosine(h));
    double top = column_top(), rho = sqrt(h * (2.0 * R + h));
    double least = TOP - h, fi, fj;
    double x = (distance_to_top(h, mu) - least) / (rho + top - least);
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
    double x = (sun_mu - horizon_cosine(h)) / PEL_SUN_ANGULAR_RADIUS;
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
    p.height = height_along(h, mu, t);
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

/* Light that reaches height h along one direction after one scattering taken
 * as isotropic, or one reflection by the ground, per unit solar irradiance
 * (Hillaire 2020, eq. 6), and how much of uniform light would (eq. 8). */
static void multiple_ray(const struct pel_atmosphere *a, double h, double mu,
                         double sun_mu, double nu, double weight,
                         struct pel_rgb *second, struct pel_rgb *factor)
{
    double ground = distance_to_ground(h, mu);
    double way = ground >= 0 ? ground : distance_to_top(h, mu);
    struct pel_rgb through = { weight, weight, weight };
    double from = 0;
    for (int i = 0; i < MULTIPLE_STEPS; i++) {
        double q = (i + 1.0) / MULTIPLE_STEPS;
        double to = way * q * q;
        struct point p = ray_point(a, h, mu, sun_mu, nu, 0.5 * (from + to));
        struct pel_rgb scatter = { p.rayleigh.r + p.mie, p.rayleigh.g + p.mie,
                                   p.rayleigh.b + p.mie };
        struct pel_rgb share =
            rgb_mul(scatter, step_rgb(p.extinction, to - from, &through));
        struct pel_rgb sun = sun_transmittance(a, p.height, p.sun_mu);
        *factor = rgb_add(*factor, share);
        *second =
            rgb_add(*second, rgb_scale(rgb_mul(share, sun), 0.25 / PEL_PI));
        from = to;
    }
    if (ground >= 0) {
        double at = ((R + h) * sun_mu + ground * nu) / R;
        double lit = fmax(at, 0) * PEL_SEA_ALBEDO / PEL_PI;
        struct pel_rgb sun = sun_transmittance(a, 0, at);
        *second = rgb_add(*second, rgb_scale(rgb_mul(through, sun), lit));
    }
}

static struct pel_rgb multiple_at(const struct pel_atmosphere *a, double h,
                                  double sun_mu)
{
    struct pel_rgb second = { 0, 0, 0 }, factor = { 0, 0, 0 };
    double across = sqrt(fmax(1.0 - sun_mu * sun_mu, 0));
    double horizon = horizon_cosine(h);
    for (int i = 0; i < MULTIPLE_ZENITHS; i++) {
        /* Half of them above the horizon, half below, dmu = 2|x| dx: finest
         * at the horizon, where air and twilight are. */
        double x = 1.0 - 2.0 * (i + 0.5) / MULTIPLE_ZENITHS;
        double side = x > 0 ? 1.0 - horizon : 1.0 + horizon;
        double mu = horizon + side * x * fabs(x);
        double weight = side * 2.0 * fabs(x);
        double sine = sqrt(1.0 - mu * mu);
        for (int j = 0; j < MULTIPLE_AZIMUTHS; j++) {
            double phi = PEL_PI * (j + 0.5) / MULTIPLE_AZIMUTHS;
            double nu = mu * sun_mu + sine * across * cos(phi);
            multiple_ray(a, h, mu, sun_mu, nu, weight, &second, &factor);
        }
    }
    double n = MULTIPLE_ZENITHS * MULTIPLE_AZIMUTHS;
    return (struct pel_rgb){
        second.r / n / (1.0 - fmin(factor.r / n, 0.98)),
        second.g / n / (1.0 - fmin(factor.g / n, 0.98)),
        second.b / n / (1.0 - fmin(factor.b / n, 0.98)),
    };
}

/* x in 0..1 stands for the cosine s|s|, s from −0.6 to 1: finest where the
 * Sun sets. */
static double multiple_sun_mu(double x)
{
    double s = -0.6 + 1.6 * x;
    return s * fabs(s);
}

static void fill_multiple(struct pel_atmosphere *a)
{
    for (int i = 0; i < PEL_MULTIPLE_HEIGHTS; i++) {
        double x = (double)i / (PEL_MULTIPLE_HEIGHTS - 1);
        for (int j = 0; j < PEL_MULTIPLE_SUNS; j++) {
            double s = multiple_sun_mu((double)j / (PEL_MULTIPLE_SUNS - 1));
            a->multiple[i][j] = multiple_at(a, TOP * x * x, s);
        }
    }
}

struct pel_rgb pel_atmosphere_multiple(const struct pel_atmosphere *a,
                                       double height_m, double sun_mu)
{
    double fi, fj;
    double s = sun_mu < 0 ? -sqrt(-sun_mu) : sqrt(sun_mu);
    int i = cell(sqrt(clamp_height(height_m) / TOP), PEL_MULTIPLE_HEIGHTS, &fi);
    int j = cell((s + 0.6) / 1.6, PEL_MULTIPLE_SUNS, &fj);
    const struct pel_rgb *lower = &a->multiple[i][j];
    const struct pel_rgb *upper = &a->multiple[i + 1][j];
    struct pel_rgb below =
        rgb_add(rgb_scale(lower[0], 1 - fj), rgb_scale(lower[1], fj));
    struct pel_rgb above =
        rgb_add(rgb_scale(upper[0], 1 - fj), rgb_scale(upper[1], fj));
    return rgb_add(rgb_scale(below, 1 - fi), rgb_scale(above, fi));
}

/* --- the sky ------------------------------------------------------------- */

static struct pel_rgb sky_from(const struct pel_atmosphere *a, double h,
                               double mu, double sun_mu, double nu)
{
    double ground = distance_to_ground(h, mu);
    double way = ground >= 0 ? ground : distance_to_top(h, mu);
    double rayleigh = pel_phase_rayleigh(nu), mie = pel_phase_mie(nu, a->mie_g);
    struct pel_rgb radiance = { 0, 0, 0 }, through = { 1, 1, 1 };
    double from = 0;
    for (int i = 0; i < SKY_STEPS; i++) {
        double q = (i + 1.0) / SKY_STEPS;
        double to = way * q * q;
        struct point p = ray_point(a, h, mu, sun_mu, nu, 0.5 * (from + to));
        struct pel_rgb sun = sun_transmittance(a, p.height, p.sun_mu);
        struct pel_rgb gain = pel_atmosphere_multiple(a, p.height, p.sun_mu);
        struct pel_rgb once = rgb_scale(p.rayleigh, rayleigh);
        struct pel_rgb all = p.rayleigh;
        once = rgb_add(
            once, (struct pel_rgb){ p.mie * mie, p.mie * mie, p.mie * mie });
        all = rgb_add(all, (struct pel_rgb){ p.mie, p.mie, p.mie });
        struct pel_rgb source = rgb_add(rgb_mul(once, sun), rgb_mul(all, gain));
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
    return sky_from(a, h, mu, sun_mu, nu);
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
            struct pel_rgb l = sky_from(a, 0, mu, sun_mu, nu);
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
    double mu = fmax(sun.z, horizon_cosine(h));
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

void pel_atmosphere_tabulate(struct pel_atmosphere *a)
{
    fill_columns(a);
    fill_multiple(a);
}
