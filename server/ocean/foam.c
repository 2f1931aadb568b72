#include "ocean/foam.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ocean/cascade.h"
#include "ocean/ringwaves.h"

#define SIDE PEL_FOAM_SIDE
#define LEVELS PEL_FOAM_LEVELS
#define REACH PEL_FOAM_REACH

/* Grid of the whole z on which foam is given, before it is blurred. */
#define FINE 176
#define FINE_REACH 7.7
#define FINE_STEP (2.0 * FINE_REACH / FINE)

/* Radii of the mean. */
#define RADII 128
#define HIGHEST 8.0

double pel_foam_of_wind(double wind_mps)
{
    double u = wind_mps;
    if (!(u > 3.70)) {
        return 0;
    }
    double monahan = 3.84e-6 * pow(u, 3.41);
    double callaghan =
        u < 10.18 ? 3.18e-5 * pow(u - 3.70, 3) : 4.82e-6 * pow(u + 1.98, 3);
    return sqrt(monahan * callaghan);
}

double pel_foam_share(double x)
{
    return 1.0 / (1.0 + exp(-x * (1.5976 + 0.070565 * x * x)));
}

double pel_foam_share_inverse(double p)
{
    double odds = log(p / (1.0 - p));
    double x = 0.6 * odds;
    for (int i = 0; i < 30; i++) {
        double f = x * (1.5976 + 0.070565 * x * x) - odds;
        double next = x - f / (1.5976 + 3 * 0.070565 * x * x);
        /* Each turn doubles the digits: there are no more of them. */
        bool there = fabs(next - x) <= 1e-14 * fabs(x);
        x = next;
        if (there) {
            break;
        }
    }
    return x;
}

/* --- the waves that break --------------------------------------------------
 */

struct band {
    double variance; /* of X */
    double omega;    /* mean, weighted by it */
};

bool pel_foam_breaks(const struct pel_wave *w)
{
    return hypot(w->kx, w->ky) * PEL_FOAM_SHORTEST_M <= 2.0 * PEL_PI;
}

static struct band band_of(const struct pel_sea *sea)
{
    struct band b = { 0 };
    for (int i = 0; sea->cascades && i < PEL_FOAM_CASCADES; i++) {
        const struct pel_cascade *c = &sea->cascades->cascade[i];
        double step = 2.0 * PEL_PI / c->length_m;
        for (int j = 0; j < PEL_CASCADE_MODES; j++) {
            const float *h = c->h0[j];
            int m = j % PEL_CASCADE_N, n = j / PEL_CASCADE_N;
            m = m < PEL_CASCADE_N / 2 ? m : m - PEL_CASCADE_N;
            n = n < PEL_CASCADE_N / 2 ? n : n - PEL_CASCADE_N;
            double p = 2.0 * ((double)h[0] * h[0] + (double)h[1] * h[1]);
            double x = p * step * step * (m * m + n * n);
            b.variance += x;
            b.omega += x * 2.0 * PEL_PI * c->mode[j][0];
        }
    }
    for (int i = 0; !sea->cascades && i < sea->count; i++) {
        const struct pel_wave *w = &sea->waves[i];
        double kh = hypot(w->kx, w->ky) * w->amplitude;
        b.variance += pel_foam_breaks(w) ? 0.5 * kh * kh : 0;
        b.omega += pel_foam_breaks(w) ? 0.5 * kh * kh * w->omega : 0;
    }
    b.omega = b.variance > 0 ? b.omega / b.variance : 0;
    return b;
}

double pel_foam_left(const struct pel_sea *sea, const struct pel_filter *filter,
                     double footprint_m)
{
    double resolved = 0;
    for (int i = 0; sea->cascades && i < PEL_FOAM_CASCADES; i++) {
        const struct pel_cascade *c = &sea->cascades->cascade[i];
        struct pel_slopes kept = pel_cascade_kept(
            c, log2(footprint_m / c->texel_m) + pel_filter_slope_bias(filter));
        resolved += kept.along + kept.cross;
    }
    for (int i = 0; !sea->cascades && i < sea->count; i++) {
        const struct pel_wave *w = &sea->waves[i];
        double k = hypot(w->kx, w->ky);
        double lengths = 2.0 * PEL_PI / (footprint_m * k);
        if (pel_foam_breaks(w) && lengths > filter->n_min) {
            double kh = k * w->amplitude * pel_filter_gain(filter, lengths);
            resolved += 0.5 * kh * kh;
        }
    }
    double all = sea->foam ? sea->foam->deviation * sea->foam->deviation : 0;
    double left = all > 0 ? 1.0 - resolved / all : 1.0;
    return pel_clamp(left, PEL_FOAM_ALWAYS_LEFT, 1.0);
}

struct pel_vec2 pel_foam_trochoids(const struct pel_sea *sea,
                                   const struct pel_filter *filter,
                                   double footprint_m, struct pel_vec2 at,
                                   double time_s)
{
    struct pel_vec2 z = { 0, 0 };
    for (int i = 0; i < sea->count; i++) {
        const struct pel_wave *w = &sea->waves[i];
        double k = hypot(w->kx, w->ky);
        double lengths = 2.0 * PEL_PI / (footprint_m * k);
        if (!pel_foam_breaks(w) || lengths <= filter->n_min) {
            continue;
        }
        double kh = k * w->amplitude * pel_filter_gain(filter, lengths);
        double p = w->kx * at.x + w->ky * at.y +
                   remainder(w->phase - w->omega * time_s, 2.0 * PEL_PI);
        z.x += kh * cos(p) / sea->foam->deviation;
        z.y += kh * sin(p) / sea->foam->deviation;
    }
    return z;
}

/* --- foam of a known z -----------------------------------------------------
 */

double pel_foam_age(const struct pel_foam *foam, double x, double y)
{
    double r = hypot(x, y);
    if (!(r > foam->threshold)) {
        return -1;
    }
    double half = acos(foam->threshold / r), since = atan2(-y, x);
    if (fabs(since) <= half) {
        return 0;
    }
    double lag = since - half;
    return (lag < 0 ? lag + 2.0 * PEL_PI : lag) / foam->omega;
}

/* ∫ e^{−u/t} and ∫ e^{−u/t} cos(half + u) from 0 to `to`. */
static void trail(double t, double half, double to, double out[2])
{
    double e = exp(-to / t), d = 1.0 / (1.0 + t * t);
    out[0] = t * (1.0 - e);
    /* of e^{−u/t + i(half + u)} */
    out[1] = t * d *
             ((cos(half) - t * sin(half)) -
              e * (cos(half + to) - t * sin(half + to)));
}

/* Mean of e^{−age/life} over the sea where it broke since the last crest: over
 * the area of the water at rest times 1 − `steep` x, what crests are pressed
 * together by. */
static double mean_of(double threshold, double omega, double life_s,
                      double steep)
{
    double sum = 0, step = (HIGHEST - threshold) / RADII;
    for (int i = 0; i < RADII; i++) {
        double r = threshold + step * (i + 0.5), half = acos(threshold / r);
        double t[2];
        trail(omega * life_s, half, 2.0 * PEL_PI - 2.0 * half, t);
        double whole = 2.0 * half + t[0], cosines = 2.0 * sin(half) + t[1];
        sum += step * r * exp(-0.5 * r * r) * (whole - steep * r * cosines);
    }
    return sum / (2.0 * PEL_PI);
}

/* Crests of steeper seas than waves can be are not pressed to nothing. */
static double steepness(const struct pel_foam *foam)
{
    return fmin(foam->deviation, 0.2);
}

/* Foam that has been drawn out into streaks no longer follows the crests. */
static double spread_of(double wind_mps)
{
    double x = pel_clamp((wind_mps - PEL_FOAM_STREAK_FROM) /
                             (PEL_FOAM_STREAK_WHOLE - PEL_FOAM_STREAK_FROM),
                         0, 1);
    return PEL_FOAM_STREAK_SHARE * x * x * (3.0 - 2.0 * x);
}

/* 0 with no wind to tear water off crests, or where no whitecaps are wanted. */
static double blown_of(const struct pel_sea_desc *d)
{
    double x =
        (d->wind_mps - PEL_SPRAY_FROM) / (PEL_SPRAY_WHOLE - PEL_SPRAY_FROM);
    return pel_clamp(x, 0, 1) * fmin(d->whitecaps, 1.0);
}

double pel_foam_spray(const struct pel_foam *foam, double height_m)
{
    double heights = height_m / PEL_SPRAY_HEIGHT_M;
    double mean = heights > 1e-6 ? -expm1(-heights) / heights : 1.0;
    return PEL_SPRAY_EXTINCTION * pow(foam->blown, 3) * mean;
}

static void solve_threshold(struct pel_foam *foam)
{
    double target = foam->coverage * (1.0 - foam->spread);
    double lo = 0.05, hi = 6.5;
    for (int i = 0; i < 40; i++) {
        double mid = 0.5 * (lo + hi);
        if (mean_of(mid, foam->omega, PEL_FOAM_LIFE_S, steepness(foam)) >
            target) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    foam->threshold = 0.5 * (lo + hi);
}

/* Of the sea: what all foam hides, and streaks. */
static double hidden_of(const struct pel_foam *foam)
{
    return foam->coverage * PEL_FOAM_DENSE;
}

static double streaks_of(const struct pel_foam *foam)
{
    return hidden_of(foam) * foam->spread;
}

/* So that all foam together has the mean of PEL_FOAM_DENSE. */
static void solve_thinning(struct pel_foam *foam)
{
    double lo = 0.05, hi = 100;
    for (int i = 0; i < 40; i++) {
        double mid = sqrt(lo * hi);
        foam->thinning_s = mid;
        double life = 1.0 / (1.0 / PEL_FOAM_LIFE_S + 1.0 / mid);
        double dense = PEL_FOAM_FRESH * mean_of(foam->threshold, foam->omega,
                                                life, steepness(foam));
        if (dense < hidden_of(foam) - streaks_of(foam)) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
}

/* --- the table ---------------------------------------------------------------
 */

/* Dense foam times what the water there is pressed together by. */
typedef float fine_grid[FINE][FINE];

static void fill_fine(const struct pel_foam *foam, fine_grid out)
{
    double sum = 0;
    double life = 1.0 / (1.0 / PEL_FOAM_LIFE_S + 1.0 / foam->thinning_s);
    for (int j = 0; j < FINE; j++) {
        double y = -FINE_REACH + FINE_STEP * (j + 0.5);
        for (int i = 0; i < FINE; i++) {
            double x = -FINE_REACH + FINE_STEP * (i + 0.5);
            double age = pel_foam_age(foam, x, y);
            double hidden = age < 0 ? 0 : PEL_FOAM_FRESH * exp(-age / life);
            hidden *= fmax(1.0 - steepness(foam) * x, 0);
            sum += hidden * exp(-0.5 * (x * x + y * y));
            out[j][i] = (float)hidden;
        }
    }
    /* The mean is the exact one. */
    sum *= FINE_STEP * FINE_STEP / (2.0 * PEL_PI);
    double scale = (hidden_of(foam) - streaks_of(foam)) / sum;
    for (int j = 0; j < FINE; j++) {
        for (int i = 0; i < FINE; i++) {
            out[j][i] *= (float)scale;
        }
    }
}

/* Weights of the fine grid around the nodes of the table. */
struct kernel {
    int first[SIDE], count[SIDE];
    float weight[SIDE][FINE];
};

static void fill_kernel(double deviation, struct kernel *k)
{
    for (int n = 0; n < SIDE; n++) {
        double at = -REACH + 2.0 * REACH * n / (SIDE - 1), sum = 0;
        double lo = (at - 4.5 * deviation + FINE_REACH) / FINE_STEP;
        double hi = (at + 4.5 * deviation + FINE_REACH) / FINE_STEP;
        int first = lo > 0 ? (int)lo : 0;
        int end = hi < FINE ? (int)hi : FINE;
        k->first[n] = first;
        k->count[n] = end - first;
        for (int i = first; i < end; i++) {
            double x = -FINE_REACH + FINE_STEP * (i + 0.5) - at;
            double w = exp(-0.5 * x * x / (deviation * deviation));
            k->weight[n][i - first] = (float)w;
            sum += w;
        }
        for (int i = 0; i < k->count[n]; i++) {
            k->weight[n][i] /= (float)sum;
        }
    }
}

static void blur(const float fine[FINE][FINE], const struct kernel *k,
                 float half[FINE][SIDE], float out[SIDE][SIDE])
{
    for (int j = 0; j < FINE; j++) {
        for (int n = 0; n < SIDE; n++) {
            const float *from = &fine[j][k->first[n]];
            float sum = 0;
            for (int i = 0; i < k->count[n]; i++) {
                sum += k->weight[n][i] * from[i];
            }
            half[j][n] = sum;
        }
    }
    for (int m = 0; m < SIDE; m++) {
        memset(out[m], 0, sizeof out[m]);
        for (int i = 0; i < k->count[m]; i++) {
            const float *from = half[k->first[m] + i];
            for (int n = 0; n < SIDE; n++) {
                out[m][n] += k->weight[m][i] * from[n];
            }
        }
    }
}

static double level_deviation(int level)
{
    double least = sqrt(PEL_FOAM_ALWAYS_LEFT);
    return least + (1.0 - least) * level / (LEVELS - 1);
}

struct work {
    fine_grid fine;
    struct kernel kernel;
    float half[FINE][SIDE], hidden[SIDE][SIDE];
};

static void fill_level(struct pel_foam *foam, int level, struct work *w)
{
    fill_kernel(level_deviation(level), &w->kernel);
    blur(w->fine, &w->kernel, w->half, w->hidden);
    for (int m = 0; m < SIDE; m++) {
        for (int n = 0; n < SIDE; n++) {
            double x = -REACH + 2.0 * REACH * n / (SIDE - 1);
            double pressed = fmax(1.0 - steepness(foam) * x, 0.1);
            double hidden = w->hidden[m][n] / pressed + streaks_of(foam);
            foam->table[level][m][n] =
                (float)pel_foam_share_inverse(pel_clamp(hidden, 1e-7, 0.9999));
        }
    }
}

enum pel_err pel_foam_create(const struct pel_sea *sea, struct pel_foam **out)
{
    double coverage = sea->desc.whitecaps *
                      pel_foam_of_wind(sea->desc.wind_mps) *
                      pel_rain_whitecaps(sea->desc.rain_mm_h);
    struct band band = { 0 };
    *out = NULL;
    if (coverage >= PEL_FOAM_LEAST) {
        band = band_of(sea);
    }
    if (!(band.variance > 0)) {
        return PEL_OK;
    }
    struct pel_foam *foam = calloc(1, sizeof *foam);
    struct work *work = malloc(sizeof *work);
    if (!foam || !work) {
        free(foam);
        free(work);
        return PEL_ERR_NO_MEMORY;
    }
    foam->coverage = fmin(coverage, 0.6);
    foam->deviation = sqrt(band.variance / (1.0 - PEL_FOAM_ALWAYS_LEFT));
    foam->omega = band.omega;
    foam->blown = blown_of(&sea->desc);
    foam->spread = spread_of(sea->desc.wind_mps);
    foam->drawn_out =
        1.0 + 2.0 * pel_clamp((sea->desc.wind_mps - 6.0) / 14.0, 0, 1);
    solve_threshold(foam);
    solve_thinning(foam);
    fill_fine(foam, work->fine);
    for (int level = 0; level < LEVELS; level++) {
        fill_level(foam, level, work);
    }
    free(work);
    *out = foam;
    return PEL_OK;
}

/* The place of v among n nodes, below, and how far beyond. */
static int node_below(double v, int n, double *beyond)
{
    double place = pel_clamp(v * (n - 1), 0, n - 1);
    int below = place < n - 1 ? (int)place : n - 2;
    *beyond = place - below;
    return below;
}

double pel_foam_bound(const struct pel_foam *foam, double x, double y,
                      double left)
{
    double least = sqrt(PEL_FOAM_ALWAYS_LEFT), f[3], hidden = 0;
    int i = node_below(0.5 + 0.5 * x / REACH, SIDE, &f[0]);
    int j = node_below(0.5 + 0.5 * y / REACH, SIDE, &f[1]);
    int l = node_below((sqrt(left) - least) / (1.0 - least), LEVELS, &f[2]);
    for (int c = 0; c < 8; c++) {
        double w = (c & 1 ? f[0] : 1 - f[0]) * (c & 2 ? f[1] : 1 - f[1]) *
                   (c & 4 ? f[2] : 1 - f[2]);
        hidden += w * foam->table[l + (c >> 2)][j + (c >> 1 & 1)][i + (c & 1)];
    }
    return hidden;
}

double pel_foam_at(const struct pel_foam *foam, double x, double y, double left)
{
    return pel_foam_share(pel_foam_bound(foam, x, y, left));
}
