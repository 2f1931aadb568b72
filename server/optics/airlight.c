#include "optics/airlight.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "optics/airsolver.h"
#include "optics/linear.h"

/* --- places -------------------------------------------------------------- */

double pel_airlight_sun(double sun_mu)
{
    double elevation = asin(pel_clamp(sun_mu, -1, 1));
    double u = (elevation + PEL_AIR_SUN_MIDDLE) / PEL_AIR_SUN_WIDTH;
    return pel_clamp((asinh(u) - PEL_AIR_SUN_FIRST) /
                         (PEL_AIR_SUN_LAST - PEL_AIR_SUN_FIRST),
                     0, 1);
}

double pel_airlight_height(const struct pel_atmosphere *a, double height_m)
{
    double x =
        PEL_AIR_SHARE_MIE *
            sqrt(fmax(1.0 - exp(-height_m / a->mie_height_m), 0)) +
        PEL_AIR_SHARE_RAYLEIGH * (1.0 - exp(-height_m / a->rayleigh_height_m)) +
        (1.0 - PEL_AIR_SHARE_MIE - PEL_AIR_SHARE_RAYLEIGH) * height_m /
            PEL_AIR_TOP;
    return pel_clamp(x, 0, 1);
}

static double height_at(const struct pel_atmosphere *a, double x)
{
    double low = 0, high = PEL_AIR_TOP;
    for (int i = 0; i < 60; i++) {
        double middle = 0.5 * (low + high);
        if (pel_airlight_height(a, middle) < x) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return x > 0 ? 0.5 * (low + high) : 0;
}

struct pel_rgb pel_airlight_at(const struct pel_airlight *l,
                               const struct pel_atmosphere *a, double height_m,
                               double sun_mu, double zenith_rad,
                               double cos_azimuth)
{
    double f[4], sum[3] = { 0, 0, 0 };
    double half = sqrt(fmax(0.5 - 0.5 * cos_azimuth, 0));
    int at[4] = {
        pel_air_cell(pel_airlight_sun(sun_mu), SUNS, &f[0]),
        pel_air_cell(pel_airlight_height(a, height_m), HEIGHTS, &f[1]),
        pel_air_cell(zenith_rad / PEL_PI, ZENITHS, &f[2]),
        pel_air_cell(half, AZIMUTHS, &f[3]),
    };
    for (int k = 0; k < 16; k++) {
        double w = 1;
        int i[4];
        for (int d = 0; d < 4; d++) {
            int next = k >> d & 1;
            w *= next ? f[d] : 1.0 - f[d];
            i[d] = at[d] + next;
        }
        const float *v = l->log2[i[0]][i[1]][i[2]][i[3]];
        for (int c = 0; c < 3; c++) {
            sum[c] += w * (double)v[c];
        }
    }
    return (struct pel_rgb){ exp2(sum[0]), exp2(sum[1]), exp2(sum[2]) };
}

/* --- phase functions ----------------------------------------------------- */

/* Legendre moments of the aerosols' phase function: the first KEPT its own,
 * the rest such that the sum is closest to it by share over all angles, as in
 * the delta-fit of Hu et al. 2000 without the delta: within 5 % beyond 40°, a
 * peak blurred by some 7°, which only light scattered twice and more sees. A
 * series that is only faded out is negative straight back. */
static void moments(double g, double chi[TERMS])
{
    enum { N = 128, KEPT = 3, FREE = TERMS - KEPT };
    double nu[N], w[N], normal[FREE * FREE] = { 0 }, right[FREE] = { 0 };
    int pivot[FREE];
    pel_gauss_legendre(N, -1, 1, nu, w);
    memset(chi, 0, TERMS * sizeof *chi);
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < N; i++) {
            double phase = 4 * PEL_PI * pel_phase_mie(nu[i], g), p[TERMS];
            double before = 0, at = 1, rest = phase;
            for (int l = 0; l < TERMS; l++) {
                p[l] = (2 * l + 1) * at;
                if (pass == 0 && l < KEPT) {
                    chi[l] += 0.5 * w[i] * phase * at;
                }
                rest -= l < KEPT ? chi[l] * p[l] : 0;
                double next = ((2 * l + 1) * nu[i] * at - l * before) / (l + 1);
                before = at;
                at = next;
            }
            for (int l = 0; pass == 1 && l < FREE; l++) {
                double share = w[i] * p[KEPT + l] / (phase * phase);
                right[l] += share * rest;
                for (int m = 0; m < FREE; m++) {
                    normal[l * FREE + m] += share * p[KEPT + m];
                }
            }
        }
    }
    pel_lu_solve(normal, FREE, pivot, right);
    memcpy(chi + KEPT, right, sizeof right);
}

/* Associated Legendre functions √((l−m)!/(l+m)!) P_l^m for l = m.. */
static void legendre(int m, double mu, double q[TERMS])
{
    double sine = sqrt(fmax(1.0 - mu * mu, 0));
    double first = 1;
    for (int i = 1; i <= m; i++) {
        first *= sqrt((2.0 * i - 1) / (2.0 * i)) * sine;
    }
    for (int l = 0; l < TERMS; l++) {
        double two = l - 2 >= m ? q[l - 2] : 0;
        q[l] = l < m    ? 0
               : l == m ? first
                        : ((2 * l - 1) * mu * q[l - 1] -
                           sqrt((l - 1.0) * (l - 1.0) - m * m) * two) /
                              sqrt((double)l * l - m * m);
    }
}

static void fill_kernel(const struct pel_air_solver *s, double mu,
                        kernel *rayleigh, kernel *mie)
{
    for (int m = 0; m < TERMS; m++) {
        double to[TERMS], from[TERMS];
        legendre(m, mu, to);
        for (int j = 0; j < DIRECTIONS; j++) {
            legendre(m, s->mu[j], from);
            double sum = 0;
            for (int l = m; l < TERMS; l++) {
                sum += (l + 0.5) * s->chi[l] * to[l] * from[l];
            }
            (*mie)[m][j] = (float)(sum * s->weight[j]);
            double r = m == 0 ? 0.5 * to[0] * from[0] : 0;
            r += m <= 2 ? 2.5 * 0.1 * to[2] * from[2] : 0;
            (*rayleigh)[m][j] = (float)(r * s->weight[j]);
        }
    }
}

/* --- from light to the source of the next order -------------------------- */

typedef float modes[DIRECTIONS][TERMS][ROW];

/* Cosine series in azimuth of the light at a height. */
static void fourier(const struct pel_air_solver *s, suns (*light)[AIR_TURNS],
                    modes out)
{
    for (int i = 0; i < DIRECTIONS; i++) {
        for (int m = 0; m < TERMS; m++) {
            float *to = out[i][m];
            memset(to, 0, sizeof out[i][m]);
            for (int j = 0; j < AIR_TURNS; j++) {
                float w = s->cosine[j][m] * (m ? 2.0f : 1.0f) / AIR_TURNS;
                const float *from = light[i][j];
                for (int k = 0; k < ROW; k++) {
                    to[k] += w * from[k];
                }
            }
        }
    }
}

/* Both phase functions in the proportion of a height, a mode of one direction.
 */
static void scatter(const struct pel_air_solver *s, int level,
                    const kernel *rayleigh, const kernel *mie, modes light,
                    int m, float out[ROW])
{
    memset(out, 0, sizeof(float) * ROW);
    for (int j = 0; j < DIRECTIONS; j++) {
        float w[4] = { 0, 0, 0, 0 };
        for (int c = 0; c < 3; c++) {
            w[c] = (float)s->scatter[level][c][0] * (*rayleigh)[m][j] +
                   (float)s->scatter[level][c][1] * (*mie)[m][j];
        }
        const float *from = light[j][m];
        for (int n = 0; n < SUNS; n++) {
            for (int c = 0; c < 4; c++) {
                out[4 * n + c] += w[c] * from[4 * n + c];
            }
        }
    }
}

/* Moves a row over the Suns to where straight lines between its values lie
 * beside a curve through them as often above as below: by a twelfth of their
 * second difference where the curve is a parabola; less, because in haze it is
 * bent most where the Sun sets, in a part of a step. */
static void bend(float *v, size_t stride)
{
    float before = v[0];
    for (int n = 1; n + 1 < SUNS; n++) {
        float here = v[n * stride];
        v[n * stride] =
            here - (v[(n + 1) * stride] - 2.0f * here + before) / 32.0f;
        before = here;
    }
}

/* The size of a source is a mean over directions and wavelengths. */
static void fill_size(struct pel_air_solver *s, int level,
                      suns (*source)[AIR_TURNS])
{
    for (int n = 0; n < SUNS; n++) {
        double sum = 0;
        for (int i = 0; i < DIRECTIONS; i++) {
            for (int j = 0; j < AIR_TURNS; j++) {
                const float *v = source[i][j] + 4 * n;
                sum += (double)(fabsf(v[0]) + fabsf(v[1]) + fabsf(v[2])) *
                       s->weight[i];
            }
        }
        s->level[level][n] = (float)log2(fmax(sum / (6.0 * AIR_TURNS), 1e-30));
        s->scale[level][n] = exp2f(-s->level[level][n]);
    }
    bend(s->level[level], 1);
}

static void work_source(void *user, int member, int level)
{
    struct pel_air_solver *s = user;
    modes *light = malloc(sizeof *light);
    float row[ROW];
    (void)member;
    if (!light) {
        s->failed = true;
        return;
    }
    suns(*to)[AIR_TURNS] = s->source[level];
    fourier(s, s->light[level], *light);
    memset(to, 0, sizeof s->source[level]);
    for (int i = 0; i < DIRECTIONS; i++) {
        for (int m = 0; m < TERMS; m++) {
            scatter(s, level, &s->rayleigh[i], &s->mie[i], *light, m, row);
            for (int j = 0; j < AIR_TURNS; j++) {
                for (int k = 0; k < ROW; k++) {
                    to[i][j][k] += s->cosine[j][m] * row[k];
                }
            }
        }
    }
    fill_size(s, level, to);
    for (int i = 0; i < DIRECTIONS; i++) {
        for (int j = 0; j < AIR_TURNS; j++) {
            for (int k = 0; k < ROW; k++) {
                to[i][j][k] *= s->scale[level][k / 4];
            }
        }
    }
    free(light);
}

/* --- the table ----------------------------------------------------------- */

static void work_table(void *user, int member, int level)
{
    struct pel_air_solver *s = user;
    modes *light = malloc(sizeof *light);
    (void)member;
    if (!light) {
        s->failed = true;
        return;
    }
    fourier(s, s->sum[level], *light);
    for (int z = 0; z < ZENITHS; z++) {
        float at[AZIMUTHS][ROW] = { 0 }, row[ROW];
        for (int m = 0; m < TERMS; m++) {
            scatter(s, level, &s->rayleigh_seen[z], &s->mie_seen[z], *light, m,
                    row);
            for (int j = 0; j < AZIMUTHS; j++) {
                double phi = 2.0 * asin((double)j / (AZIMUTHS - 1));
                float w = (float)cos(m * phi);
                for (int k = 0; k < ROW; k++) {
                    at[j][k] += w * row[k];
                }
            }
        }
        for (int j = 0; j < AZIMUTHS; j++) {
            for (int n = 0; n < SUNS; n++) {
                for (int c = 0; c < 4; c++) {
                    s->out->log2[n][level][z][j][c] =
                        log2f(fmaxf(at[j][4 * n + c], 1e-30f));
                }
            }
        }
    }
    for (int z = 0; z < ZENITHS; z++) {
        for (int j = 0; j < AZIMUTHS; j++) {
            for (int c = 0; c < 3; c++) {
                bend(&s->out->log2[0][level][z][j][c],
                     sizeof s->out->log2[0] / sizeof(float));
            }
        }
    }
    free(light);
}

/* Mean light of each height in this order. */
static void fill_mean(struct pel_air_solver *s)
{
    memcpy(s->mean[0], s->mean[1], sizeof s->mean[0]);
    memset(s->mean[1], 0, sizeof s->mean[1]);
    for (int l = 0; l < HEIGHTS; l++) {
        for (int i = 0; i < DIRECTIONS; i++) {
            for (int j = 0; j < AIR_TURNS; j++) {
                for (int k = 0; k < ROW; k++) {
                    s->mean[1][l][k] +=
                        s->weight[i] * (double)s->light[l][i][j][k];
                }
            }
        }
        for (int k = 0; k < ROW; k++) {
            s->total[l][k] += s->mean[1][l][k];
        }
    }
}

/* How much of the light all further orders are, most, where they fall as the
 * last one did. */
static double rest(const struct pel_air_solver *s)
{
    double most = 0;
    for (int l = 0; l < HEIGHTS; l++) {
        for (int k = 0; k < ROW; k++) {
            if (s->sun_mu[k / 4] < -0.09) {
                continue; /* hardly seen */
            }
            double ratio = s->mean[1][l][k] / fmax(s->mean[0][l][k], 1e-30);
            ratio = pel_clamp(ratio, 0, 0.9);
            double sum = fmax(s->total[l][k], 1e-30);
            most = fmax(most, s->mean[1][l][k] * ratio / (1 - ratio) / sum);
        }
    }
    return most;
}

static void add_rest(struct pel_air_solver *s)
{
    for (int l = 0; l < HEIGHTS; l++) {
        float more[ROW];
        for (int k = 0; k < ROW; k++) {
            double ratio = s->mean[1][l][k] / fmax(s->mean[0][l][k], 1e-30);
            ratio = pel_clamp(ratio, 0, 0.9);
            more[k] = (float)(ratio / (1.0 - ratio));
        }
        for (int i = 0; i < DIRECTIONS; i++) {
            for (int j = 0; j < AIR_TURNS; j++) {
                for (int k = 0; k < ROW; k++) {
                    s->sum[l][i][j][k] += more[k] * s->light[l][i][j][k];
                }
            }
        }
    }
}

static void fill_places(struct pel_air_solver *s)
{
    for (int l = 0; l < HEIGHTS; l++) {
        double rayleigh[3], mie, extinction[3];
        s->heights[l] = height_at(s->a, (double)l / (HEIGHTS - 1));
        pel_air_between(s->a, s->heights[l], s->heights[l], rayleigh, &mie,
                        extinction);
        for (int c = 0; c < 3; c++) {
            s->scatter[l][c][0] = rayleigh[c] / (rayleigh[c] + mie);
            s->scatter[l][c][1] = mie / (rayleigh[c] + mie);
        }
    }
    for (int n = 0; n < SUNS; n++) {
        double x = (double)n / (SUNS - 1);
        double u =
            PEL_AIR_SUN_FIRST + x * (PEL_AIR_SUN_LAST - PEL_AIR_SUN_FIRST);
        s->sun_mu[n] = sin(fmin(
            PEL_AIR_SUN_WIDTH * sinh(u) - PEL_AIR_SUN_MIDDLE, 0.5 * PEL_PI));
    }
    for (int i = 0; i <= LUT; i++) {
        s->place[i] =
            (float)(pel_airlight_sun(2.0 * i / LUT - 1.0) * (SUNS - 1));
    }
    pel_gauss_legendre(AIR_HALF, 0, 1, s->mu, s->weight);
    for (int i = 0; i < AIR_HALF; i++) {
        s->mu[AIR_HALF + i] = -s->mu[i];
        s->weight[AIR_HALF + i] = s->weight[i];
    }
    for (int j = 0; j < AIR_TURNS; j++) {
        s->phi[j] = PEL_PI * (j + 0.5) / AIR_TURNS;
        for (int m = 0; m < TERMS; m++) {
            s->cosine[j][m] = (float)cos(m * s->phi[j]);
        }
    }
}

static void fill_solver(struct pel_air_solver *s)
{
    fill_places(s);
    moments(s->a->mie_g, s->chi);
    for (int i = 0; i < DIRECTIONS; i++) {
        fill_kernel(s, s->mu[i], &s->rayleigh[i], &s->mie[i]);
    }
    for (int z = 0; z < ZENITHS; z++) {
        fill_kernel(s, cos(PEL_PI * z / (ZENITHS - 1)), &s->rayleigh_seen[z],
                    &s->mie_seen[z]);
    }
    pel_air_glitter(s);
    for (int l = 0; l < HEIGHTS; l++) {
        for (int i = 0; i < DIRECTIONS; i++) {
            pel_air_ray(s, s->heights[l], s->mu[i], &s->rays[l][i]);
        }
    }
}

static void alone(void *pool, int count,
                  void (*work)(void *user, int member, int i), void *user)
{
    (void)pool;
    for (int i = 0; i < count; i++) {
        work(user, 0, i);
    }
}

enum pel_err pel_airlight_build(const struct pel_atmosphere *a,
                                pel_airlight_share *share, void *pool,
                                struct pel_airlight *out)
{
    struct pel_air_solver *s = calloc(1, sizeof *s);
    if (!s) {
        return PEL_ERR_NO_MEMORY;
    }
    s->a = a;
    s->out = out;
    share = share ? share : alone;
    fill_solver(s);
    for (s->order = 1;
         s->order <= 3 || (s->order <= AIR_ORDERS && rest(s) > AIR_REST);
         s->order++) {
        if (s->order > 1) {
            share(pool, HEIGHTS, work_source, s);
        }
        share(pool, HEIGHTS * DIRECTIONS, pel_air_light, s);
        pel_air_leaving(s);
        share(pool, HEIGHTS * DIRECTIONS, pel_air_ground, s);
        fill_mean(s);
    }
    add_rest(s);
    share(pool, HEIGHTS, work_table, s);
    enum pel_err err = s->failed ? PEL_ERR_NO_MEMORY : PEL_OK;
    free(s);
    return err;
}
