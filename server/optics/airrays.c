#include <math.h>
#include <stdint.h>
#include <string.h>

#include "optics/airsolver.h"
#include "optics/brdf.h"

/* The aerosols' phase function as the solution sees it [1/sr]. */
static double blurred_phase(const struct pel_air_solver *s, double nu)
{
    double before = 0, p = 1, sum = 0;
    for (int l = 0; l < TERMS; l++) {
        sum += (2 * l + 1) * s->chi[l] * p;
        double next = ((2 * l + 1) * nu * p - l * before) / (l + 1);
        before = p;
        p = next;
    }
    return fmax(sum, 0) / (4 * PEL_PI);
}

/* --- rays ---------------------------------------------------------------- */

void pel_air_between(const struct pel_atmosphere *a, double from, double to,
                     double rayleigh[3], double *mie, double extinction[3])
{
    double dr = pel_mean_density(from, to, a->rayleigh_height_m);
    double dm = pel_mean_density(from, to, a->mie_height_m);
    double ozone = fmax(0, 1.0 - fabs(0.5 * (from + to) - a->ozone_center_m) /
                                     a->ozone_width_m);
    const double br[3] = { a->rayleigh.r, a->rayleigh.g, a->rayleigh.b };
    const double bo[3] = { a->ozone.r, a->ozone.g, a->ozone.b };
    *mie = a->mie_scattering * dm;
    for (int c = 0; c < 3; c++) {
        rayleigh[c] = br[c] * dr;
        extinction[c] = rayleigh[c] + a->mie_extinction * dm + bo[c] * ozone;
    }
}

static void fill_step(const struct pel_air_solver *s, double h, double mu,
                      double from, double length, double through[3],
                      struct step *to)
{
    double t = from + length * pel_air_step_middle(
                                   s->a, pel_height_along(h, mu, from),
                                   pel_height_along(h, mu, from + length));
    double rayleigh[3], mie, extinction[3], above;
    double r = PEL_EARTH_RADIUS + h;
    to->height = pel_height_along(h, mu, t);
    pel_air_between(s->a, pel_height_along(h, mu, from),
                    pel_height_along(h, mu, from + length), rayleigh, &mie,
                    extinction);
    to->level =
        pel_air_cell(pel_airlight_height(s->a, to->height), HEIGHTS, &above);
    to->above = (float)above;
    to->along = (float)(r / (PEL_EARTH_RADIUS + to->height));
    to->across = (float)(t / (PEL_EARTH_RADIUS + to->height));
    to->mie = 0;
    for (int c = 0; c < 3; c++) {
        double passed = exp(-extinction[c] * length);
        double w = through[c] * (1.0 - passed) / fmax(extinction[c], 1e-12);
        double both = rayleigh[c] + mie;
        to->weight[c] = (float)(w * both);
        to->rayleigh[c] = (float)(both > 0 ? rayleigh[c] / both : 0);
        through[c] *= passed;
    }
    to->weight[3] = to->rayleigh[3] = 0;
}

/* --- the sea ------------------------------------------------------------- */

/* Radiance towards `up` of a sea ruffled by 7 m/s under a unit irradiance from
 * `sun`, normal to it: mirrors of all slopes (Cox and Munk 1954, as wide along
 * the wind as across it), with what is hidden or shadowed left out. */
static double mirrored(struct pel_vec3 up, struct pel_vec3 sun)
{
    const double variance = 0.5 * (0.003 + 0.00512 * 7.0);
    struct pel_vec3 h = pel_vec3_normalize(pel_vec3_add(up, sun));
    double h4 = h.z * h.z * h.z * h.z;
    double p = pel_ross_slope_density(h.x / h.z, h.y / h.z, variance, variance);
    double hidden = 1.0 + pel_ross_lambda(pel_ross_a(up, variance, variance)) +
                    pel_ross_lambda(pel_ross_a(sun, variance, variance));
    return p * pel_fresnel_exact(pel_vec3_dot(up, h), PEL_WATER_INDEX) /
           (4.0 * h4 * up.z * hidden);
}

static struct pel_vec3 direction(double mu, double phi)
{
    double sine = sqrt(fmax(1.0 - mu * mu, 0));
    return (struct pel_vec3){ sine * cos(phi), sine * sin(phi), mu };
}

/* Its mean over the share of direction i, j; what is seen lies away from the
 * Sun where the ray comes from: looking down at azimuth φ. */
static double glitter(const struct pel_air_solver *s, double low, double high,
                      int j, double sm)
{
    enum { N = 4 };
    double sum = 0;
    struct pel_vec3 sun = direction(sm, 0);
    for (int k = 0; k < N * N; k++) {
        double mu = low + (high - low) * (k / N + 0.5) / N;
        double phi = s->phi[j] + PEL_PI / AIR_TURNS * ((k % N + 0.5) / N - 0.5);
        sum += mirrored(direction(mu, PEL_PI + phi), sun);
    }
    return sum / (N * N);
}

void pel_air_glitter(struct pel_air_solver *s)
{
    double low = 0;
    for (int i = 0; i < AIR_HALF; i++) {
        double high = low + s->weight[i];
        for (int j = 0; j < AIR_TURNS; j++) {
            for (int n = 0; n < SUNS; n++) {
                double sm = s->sun_mu[n];
                s->glitter[i][j][n] =
                    sm > 0 ? (float)glitter(s, low, high, j, sm) : 0;
            }
        }
        low = high;
    }
}

/* The part of the sky's light from mu that the sea sends up again, as the same
 * sea mirrors it. */
static double albedo(double mu)
{
    enum { N = 12 };
    double sum = 0, z = pel_clamp(mu, 0.01, 1);
    for (int k = 0; k < N * N; k++) {
        /* Finest towards the horizon and across from where it comes from. */
        double x = (k / N + 0.5) / N, y = (k % N + 0.5) / N;
        struct pel_vec3 up = direction(x * x, PEL_PI * (1.0 - y * y));
        sum += x * x * x * y * mirrored(up, direction(z, 0));
    }
    return 8.0 * PEL_PI * sum / (N * N) / z;
}

void pel_air_ray(const struct pel_air_solver *s, double h, double mu,
                 struct ray *ray)
{
    double ground = h > 0 ? pel_distance_to_ground(h, mu) : mu < 0 ? 0 : -1;
    double way = ground >= 0 ? ground : pel_distance_to_top(h, mu);
    double through[3] = { 1, 1, 1 }, from = 0;
    double power = pel_air_step_power(s->a, h, way, AIR_STEPS);
    ray->count = 0;
    for (int k = 0; k < AIR_STEPS; k++) {
        double to = way * pow((k + 1.0) / AIR_STEPS, power);
        ray->count += fmax(fmax(through[0], through[1]), through[2]) > AIR_DARK;
        fill_step(s, h, mu, from, to - from, through, &ray->steps[k]);
        from = to;
    }
    ray->ground = ground >= 0;
    double r = PEL_EARTH_RADIUS + h;
    ray->ground_along = (float)(r / PEL_EARTH_RADIUS);
    ray->ground_across = (float)(fmax(ground, 0) / PEL_EARTH_RADIUS);
    double down = -(r * mu + fmax(ground, 0)) / PEL_EARTH_RADIUS;
    ray->mirror = ray->ground ? (float)albedo(down) : 0;
    for (int c = 0; c < 3; c++) {
        ray->ground_weight[c] = (float)(ray->ground ? through[c] : 0);
    }
    ray->ground_weight[3] = 0;
}

/* --- light scattered once ------------------------------------------------ */

/* Transmittance to the Sun from a height, by the place of columns' rows. */
struct beam {
    double height, horizon, least, scale; /* of the way to the top */
    float row[PEL_COLUMN_COSINES][4];
};

static double column_top(void)
{
    return sqrt(PEL_AIR_TOP * (PEL_ATMOSPHERE_RADIUS + PEL_EARTH_RADIUS));
}

static void fill_beam(const struct pel_atmosphere *a, double h,
                      struct beam *out)
{
    double rho = sqrt(h * (2.0 * PEL_EARTH_RADIUS + h)), f;
    int i = pel_air_cell(rho / column_top(), PEL_COLUMN_HEIGHTS, &f);
    out->height = h;
    out->horizon = pel_horizon_cosine(h);
    out->least = PEL_AIR_TOP - h;
    out->scale = 1.0 / fmax(rho + column_top() - out->least, 1e-9);
    for (int j = 0; j < PEL_COLUMN_COSINES; j++) {
        const struct pel_columns *p = &a->columns[i][j],
                                 *q = &a->columns[i + 1][j];
        double r = p->rayleigh + f * (q->rayleigh - p->rayleigh);
        double m = a->mie_extinction * (p->mie + f * (q->mie - p->mie));
        double o = p->ozone + f * (q->ozone - p->ozone);
        out->row[j][0] = (float)exp(-a->rayleigh.r * r - a->ozone.r * o - m);
        out->row[j][1] = (float)exp(-a->rayleigh.g * r - a->ozone.g * o - m);
        out->row[j][2] = (float)exp(-a->rayleigh.b * r - a->ozone.b * o - m);
        out->row[j][3] = 0;
    }
}

/* Transmittance to the Sun, with the part of its disc above the horizon. */
static void beam_at(const struct beam *b, double sun_mu, double out[3])
{
    out[0] = out[1] = out[2] = 0;
    if (sun_mu < b->horizon - PEL_SUN_ANGULAR_RADIUS) {
        return;
    }
    double seen = sun_mu > b->horizon + PEL_SUN_ANGULAR_RADIUS
                      ? 1
                      : pel_atmosphere_sun_visible(b->height, sun_mu);
    double way = pel_distance_to_top(b->height, fmax(sun_mu, b->horizon)), f;
    int j = pel_air_cell((way - b->least) * b->scale, PEL_COLUMN_COSINES, &f);
    for (int c = 0; c < 3; c++) {
        double low = (double)b->row[j][c], high = (double)b->row[j + 1][c];
        out[c] = seen * (low + f * (high - low));
    }
}

static double scattering_cosine(const struct pel_air_solver *s, double mu,
                                int j, int n)
{
    double sm = s->sun_mu[n];
    return mu * sm + sqrt((1 - mu * mu) * (1 - sm * sm)) * cos(s->phi[j]);
}

/* One step of all Suns and azimuths. */
static void first_step(const struct pel_air_solver *s, const struct step *p,
                       double nu[AIR_TURNS][SUNS], double mie[AIR_TURNS][SUNS],
                       suns *to)
{
    struct beam beam;
    fill_beam(s->a, p->height, &beam);
    for (int j = 0; j < AIR_TURNS; j++) {
        for (int n = 0; n < SUNS; n++) {
            double v = nu[j][n], lit[3];
            double there = (double)p->along * s->sun_mu[n];
            beam_at(&beam, there + (double)p->across * v, lit);
            double rayleigh = pel_phase_rayleigh(v);
            for (int c = 0; c < 3; c++) {
                double share = (double)p->rayleigh[c];
                double phase = share * rayleigh + (1.0 - share) * mie[j][n];
                to[j][4 * n + c] +=
                    (float)((double)p->weight[c] * phase * lit[c]);
            }
        }
    }
}

static float place_of(const struct pel_air_solver *s, float mu)
{
    float at = (mu + 1.0f) * (0.5f * LUT);
    at = at < 0.0f ? 0.0f : at > LUT - 0.01f ? LUT - 0.01f : at;
    int i = (int)at;
    float x = s->place[i] + (at - (float)i) * (s->place[i + 1] - s->place[i]);
    return x > SUNS - 1.001f ? SUNS - 1.001f : x;
}

static double glitter_at(const struct pel_air_solver *s, int i, int j,
                         double sm)
{
    float x = place_of(s, (float)sm);
    int n = (int)x;
    const float *g = s->glitter[i - AIR_HALF][j] + n;
    return (double)(g[0] + (x - (float)n) * (g[1] - g[0]));
}

static void first_ray(struct pel_air_solver *s, int level, int i)
{
    const struct ray *ray = &s->rays[level][i];
    double nu[AIR_TURNS][SUNS], mie[AIR_TURNS][SUNS], lit[3];
    const double leaving[3] = PEL_SEA_LEAVING;
    suns *to = s->light[level][i];
    for (int j = 0; j < AIR_TURNS; j++) {
        for (int n = 0; n < SUNS; n++) {
            nu[j][n] = scattering_cosine(s, s->mu[i], j, n);
            mie[j][n] = blurred_phase(s, nu[j][n]);
        }
    }
    memset(to, 0, sizeof(suns) * AIR_TURNS);
    for (int k = 0; k < ray->count; k++) {
        first_step(s, &ray->steps[k], nu, mie, to);
    }
    if (!ray->ground) {
        return;
    }
    struct beam beam;
    fill_beam(s->a, 0, &beam);
    for (int j = 0; j < AIR_TURNS; j++) {
        for (int n = 0; n < SUNS; n++) {
            double there = (double)ray->ground_along * s->sun_mu[n] +
                           (double)ray->ground_across * nu[j][n];
            beam_at(&beam, there, lit);
            double glitter = glitter_at(s, i, j, there);
            for (int c = 0; c < 3; c++) {
                double up = leaving[c] * fmax(there, 0) / PEL_PI + glitter;
                to[j][4 * n + c] +=
                    (float)((double)ray->ground_weight[c] * up * lit[c]);
            }
        }
    }
}

/* --- rays of higher orders ----------------------------------------------- */

/* 2^x for |x| < 126 within 2e-7 of itself; exp2f, called, costs a tenth of the
 * whole solution. */
static inline float power_of_two(float x)
{
    int whole = (int)(x + 128.0f) - 128;
    float f = x - (float)whole, power;
    uint32_t bits = (uint32_t)(whole + 127) << 23;
    memcpy(&power, &bits, sizeof power);
    return power * (0.99999994f +
                    f * (0.69315308f +
                         f * (0.24015361f +
                              f * (0.055826318f +
                                   f * (0.0089893397f + f * 0.0018775767f)))));
}

/* Directions are counted as at the ray's start: along what a ray crosses of
 * the air the vertical turns by less than 3°. In three loops, of which
 * compilers make vectors of the second. */
static void scattered(const struct pel_air_solver *s, const struct ray *ray,
                      int i, int j, float sm, float nu, float sum[4])
{
    int sun[AIR_STEPS];
    float between[AIR_STEPS], size[AIR_STEPS];
    for (int k = 0; k < ray->count; k++) {
        const struct step *p = &ray->steps[k];
        float x = place_of(s, p->along * sm + p->across * nu);
        int n = (int)x;
        float f = x - (float)n;
        const float *low = s->level[p->level] + n;
        const float *high = s->level[p->level + 1] + n;
        float below = low[0] + f * (low[1] - low[0]);
        float above = high[0] + f * (high[1] - high[0]);
        sun[k] = n;
        between[k] = f;
        size[k] = below + p->above * (above - below);
    }
    for (int k = 0; k < ray->count; k++) {
        size[k] = power_of_two(size[k]);
    }
    for (int k = 0; k < ray->count; k++) {
        const struct step *p = &ray->steps[k];
        float f = between[k], high = size[k] * p->above, low = size[k] - high;
        const float *a = s->source[p->level][i][j] + 4 * sun[k];
        const float *b = s->source[p->level + 1][i][j] + 4 * sun[k];
        float a1 = low * f, a0 = low - a1, b1 = high * f, b0 = high - b1;
        for (int c = 0; c < 4; c++) {
            sum[c] += p->weight[c] *
                      (a0 * a[c] + a1 * a[4 + c] + b0 * b[c] + b1 * b[4 + c]);
        }
    }
}

/* Sky light of the same order that the sea mirrors, and what it scatters. */
static void from_ground(const struct pel_air_solver *s, const struct ray *ray,
                        int i, int j, float sm, float nu, float sum[4])
{
    float x = place_of(s, ray->ground_along * sm + ray->ground_across * nu);
    int n = (int)x;
    float f = x - (float)n;
    const float *sky = s->light[0][i - AIR_HALF][j] + 4 * n;
    for (int c = 0; c < 4; c++) {
        float seen = ray->mirror * (sky[c] + f * (sky[4 + c] - sky[c])) +
                     s->leaving[n][c] +
                     f * (s->leaving[n + 1][c] - s->leaving[n][c]);
        sum[c] += ray->ground_weight[c] * seen;
    }
}

static void higher_ray(struct pel_air_solver *s, int level, int i)
{
    const struct ray *ray = &s->rays[level][i];
    for (int j = 0; j < AIR_TURNS; j++) {
        for (int n = 0; n < SUNS; n++) {
            float sum[4] = { 0, 0, 0, 0 };
            float sm = (float)s->sun_mu[n];
            float nu = (float)scattering_cosine(s, s->mu[i], j, n);
            scattered(s, ray, i, j, sm, nu, sum);
            memcpy(s->light[level][i][j] + 4 * n, sum, sizeof sum);
        }
    }
}

static void finish_ray(struct pel_air_solver *s, int level, int i)
{
    const struct ray *ray = &s->rays[level][i];
    for (int j = 0; j < AIR_TURNS; j++) {
        for (int n = 0; n < SUNS; n++) {
            float *to = s->light[level][i][j] + 4 * n;
            if (ray->ground) {
                from_ground(s, ray, i, j, (float)s->sun_mu[n],
                            (float)scattering_cosine(s, s->mu[i], j, n), to);
            }
            for (int c = 0; c < 4; c++) {
                s->sum[level][i][j][4 * n + c] += to[c];
            }
        }
    }
}

void pel_air_light(void *user, int member, int at)
{
    struct pel_air_solver *s = user;
    (void)member;
    if (s->order == 1) {
        first_ray(s, at / DIRECTIONS, at % DIRECTIONS);
    } else {
        higher_ray(s, at / DIRECTIONS, at % DIRECTIONS);
    }
}

void pel_air_ground(void *user, int member, int at)
{
    (void)member;
    finish_ray(user, at / DIRECTIONS, at % DIRECTIONS);
}

/* What the sky's irradiance makes of light out of the water. */
void pel_air_leaving(struct pel_air_solver *s)
{
    const double leaving[3] = PEL_SEA_LEAVING;
    for (int n = 0; n < SUNS; n++) {
        for (int c = 0; c < 3; c++) {
            double sum = 0;
            for (int i = 0; i < AIR_HALF; i++) {
                for (int j = 0; j < AIR_TURNS; j++) {
                    sum += s->mu[i] * s->weight[i] *
                           (double)s->light[0][i][j][4 * n + c];
                }
            }
            s->leaving[n][c] = (float)(leaving[c] * 2.0 * sum / AIR_TURNS);
        }
    }
}
