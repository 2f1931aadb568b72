#include "optics/brdf.h"

#include <math.h>

/* Directions closer to the horizon are taken as on it. */
#define LEAST_COSINE 1e-9

double pel_fresnel_exact(double cos_theta, double n)
{
    double ci = pel_clamp(cos_theta, 0, 1);
    double ct = sqrt(1.0 - (1.0 - ci * ci) / (n * n));
    double s = (ci - n * ct) / (ci + n * ct);
    double p = (n * ci - ct) / (n * ci + ct);
    return 0.5 * (s * s + p * p);
}

static double normal_reflectance(double n)
{
    double r = (n - 1.0) / (n + 1.0);
    return r * r;
}

double pel_fresnel_schlick(double cos_theta, double n)
{
    double r = normal_reflectance(n);
    double m = 1.0 - pel_clamp(cos_theta, 0, 1);
    return r + (1.0 - r) * m * m * m * m * m;
}

double pel_ross_slope_density(double zx, double zy, double var_x, double var_y)
{
    return exp(-0.5 * (zx * zx / var_x + zy * zy / var_y)) /
           (2.0 * PEL_PI * sqrt(var_x * var_y));
}

double pel_sharpened(struct pel_vec2 own, struct pel_vec2 whole, double var_x,
                     double var_y, double disc, double fold)
{
    double q = own.x * own.x / (var_x + disc) + own.y * own.y / (var_y + disc);
    double total = var_x + var_y;
    double part = fold * total / (total + 2.0 * disc);
    double both = own.x * whole.x + own.y * whole.y;
    double w = part * (whole.x * whole.x + whole.y * whole.y);
    double c = part * both;
    double own2 = fmax(own.x * own.x + own.y * own.y, 1e-12);
    double along = w / 3.0 + 2.0 / 3.0 * c * both / own2;
    double area = (1.0 + w - c) * (1.0 + w - c / 3.0) / ((1.0 + w) * (1.0 + w));
    return exp(fmin(0.5 * q * along / (1.0 + along), 16.0)) * area * area *
           (1.0 + 4.0 / 3.0 * fold * total) / sqrt((1.0 + w) * (1.0 + w / 3.0));
}

double pel_own_slope(const struct pel_patch *patch, struct pel_vec2 s,
                     struct pel_vec2 *own)
{
    const struct pel_vec3 *a = &patch->along, *b = &patch->across;
    const struct pel_vec3 *n = &patch->normal;
    const double *j = patch->pressed;
    double rise = 1.0 / (s.x * a->z + s.y * b->z + n->z);
    double dx = (s.x * a->x + s.y * b->x + n->x) * rise - n->x / n->z;
    double dy = (s.x * a->y + s.y * b->y + n->y) * rise - n->y / n->z;
    *own = (struct pel_vec2){ j[0] * dx + j[1] * dy, j[2] * dx + j[3] * dy };
    return rise * rise * rise * (j[0] * j[3] - j[1] * j[2]);
}

double pel_ross_lambda(double a)
{
    const double root_pi = 1.7724538509055160273;
    if (a > 6.0) {
        return 0; /* below 1e-18 */
    }
    double numerator = exp(-a * a) - a * root_pi * erfc(a);
    return fmax(numerator, 0) / (2.0 * a * root_pi);
}

/* tan²θ cos²φ = x²/z², tan²θ sin²φ = y²/z²: no angle is ever needed. */
double pel_ross_a(struct pel_vec3 dir, double var_x, double var_y)
{
    double spread = var_x * dir.x * dir.x + var_y * dir.y * dir.y;
    return fmax(dir.z, LEAST_COSINE) / sqrt(2.0 * spread);
}

double pel_ross_visible_density(double zx, double zy, struct pel_vec3 view,
                                double var_x, double var_y)
{
    /* v·f / f_z with eq. 6. */
    double facing = view.z - view.x * zx - view.y * zy;
    double lambda = pel_ross_lambda(pel_ross_a(view, var_x, var_y));
    return pel_ross_slope_density(zx, zy, var_x, var_y) * fmax(facing, 0) /
           ((1.0 + lambda) * fmax(view.z, LEAST_COSINE));
}

/* brdf · cos θ_l: eq. 15 for L_sun Ω_sun = 1. */
static double reflected(struct pel_vec3 view, struct pel_vec3 light,
                        double var_x, double var_y)
{
    if (!(view.z > 0) || !(light.z > 0)) {
        return 0;
    }
    struct pel_vec3 h = pel_vec3_normalize(pel_vec3_add(view, light));
    double p = pel_ross_slope_density(-h.x / h.z, -h.y / h.z, var_x, var_y);
    double f = pel_fresnel_schlick(pel_vec3_dot(view, h), PEL_WATER_INDEX);
    double shadow = 1.0 + pel_ross_lambda(pel_ross_a(view, var_x, var_y)) +
                    pel_ross_lambda(pel_ross_a(light, var_x, var_y));
    double hz2 = h.z * h.z;
    return p * f / (4.0 * hz2 * hz2 * fmax(view.z, LEAST_COSINE) * shadow);
}

double pel_ross_brdf(struct pel_vec3 view, struct pel_vec3 light, double var_x,
                     double var_y)
{
    return reflected(view, light, var_x, var_y) / fmax(light.z, LEAST_COSINE);
}

double pel_ross_sun(struct pel_vec3 view, struct pel_vec3 light, double var_x,
                    double var_y, double min_variance)
{
    return reflected(view, light, fmax(var_x, min_variance),
                     fmax(var_y, min_variance));
}

double pel_seen_steeper(double mu)
{
    return PEL_SEEN_STEEPER / (1.0 + PEL_SEEN_KNEE * mu * mu);
}

double pel_seen_narrower(double mu)
{
    return PEL_SEEN_NARROWER / (1.0 + 0.25 * mu * mu);
}

double pel_escape(double eta, double mu)
{
    if (!(eta > 0)) {
        return 0;
    }
    double steep = 1.0 + PEL_ESCAPE_VIEW * mu;
    double odds = PEL_ESCAPE_ODDS / (steep * steep);
    return 1.0 / (1.0 + odds * pel_ross_lambda(eta / sqrt(2.0)));
}

double pel_glitter(struct pel_vec3 view, struct pel_vec3 light, double var_x,
                   double var_y, double disc, double n, double fold)
{
    if (!(view.z > 0) || !(light.z > 0)) {
        return 0;
    }
    struct pel_vec3 h = pel_vec3_normalize(pel_vec3_add(view, light));
    double vh = pel_vec3_dot(view, h);
    double level = hypot(view.x, view.y), steeper = 0.0, seen = 1.0;
    double mu = sqrt(2.0) * pel_ross_a(view, var_x, var_y);
    if (level > 0) {
        double s = view.z / (mu * level);
        steeper = pel_seen_steeper(mu) * s;
        seen = fmax(1.0 - level * steeper * h.z / vh, 0.0);
        steeper /= level;
        double z = ((view.x * h.x + view.y * h.y) / (h.z * level)) / s -
                   pel_seen_steeper(mu);
        double narrower = pel_seen_narrower(mu);
        seen *= exp(-0.5 * narrower * z * z) * (1.0 + 0.5 * narrower);
    }
    double zx = steeper * view.x - h.x / h.z;
    double zy = steeper * view.y - h.y / h.z;
    struct pel_vec2 facet = { zx, zy };
    double p = seen * pel_sharpened(facet, facet, var_x, var_y, disc, fold) *
               pel_ross_slope_density(zx, zy, var_x + disc, var_y + disc);
    double f = pel_fresnel_exact(vh, n);
    double shown = 1.0 + pel_ross_lambda(pel_ross_a(view, var_x, var_y));
    double lit = pel_escape(sqrt(2.0) * pel_ross_a(light, var_x, var_y), mu);
    double hz2 = h.z * h.z;
    return p * f * lit / (4.0 * hz2 * hz2 * fmax(view.z, LEAST_COSINE) * shown);
}

double pel_mean_fresnel(struct pel_vec3 view, double var_x, double var_y,
                        double n)
{
    enum { STEPS = PEL_MEAN_FRESNEL_STEPS };
    const double step = 2.0 * PEL_MEAN_FRESNEL_REACH / STEPS;
    double seen = 0.0, reflected = 0.0;
    for (int i = 0; i < STEPS; i++) {
        double zx = sqrt(var_x) * ((i + 0.5) * step - PEL_MEAN_FRESNEL_REACH);
        for (int j = 0; j < STEPS; j++) {
            double zy =
                sqrt(var_y) * ((j + 0.5) * step - PEL_MEAN_FRESNEL_REACH);
            double facing = fmax(view.z - view.x * zx - view.y * zy, 0.0);
            double share =
                facing * exp(-0.5 * (zx * zx / var_x + zy * zy / var_y));
            double cosine = facing / sqrt(1.0 + zx * zx + zy * zy);
            seen += share;
            reflected += share * pel_fresnel_exact(cosine, n);
        }
    }
    return reflected / seen;
}

double pel_ross_mean_fresnel(struct pel_vec3 view, double var_x, double var_y)
{
    double across = view.x * view.x + view.y * view.y;
    double variance = 0.5 * (var_x + var_y);
    if (across > 0) {
        variance = (var_x * view.x * view.x + var_y * view.y * view.y) /
                   across; /* eq. 25 */
    }
    double sigma = sqrt(variance);
    double r = normal_reflectance(PEL_WATER_INDEX);
    double m = 1.0 - pel_clamp(view.z, 0, 1);
    return r + (1.0 - r) * pow(m, 5.0 * exp(PEL_MEAN_FRESNEL_FALL * sigma)) /
                   (1.0 + PEL_MEAN_FRESNEL_ROUGH * pow(sigma, 1.5));
}
