#include "ocean/growth.h"

#include <math.h>
#include <pthread.h>

#include "ocean/directional.h"
#include "ocean/spectrum.h"

/* The table: ln (g F / U²) and ln U. */
#define FIRST log(2.0)
#define STEP 0.125
#define PLACES 128
#define FIRST_WIND log(0.3)
#define WIND_STEP 0.385
#define WINDS 13 /* to 30 m/s */
/* Beyond, pel_spectrum_wind grows no more: spectrum.c's developed sea. */
#define JONSWAP_POWER (0.5 * (4.0 / 3.0 - 0.22))
#define JONSWAP_DEVELOPED 1.892e4

/* ln (g H / U²) of Elfouhaily, rising. Light winds have less than the scale of
 * the others, since viscosity takes their short waves. */
static double table[WINDS][PLACES];
static pthread_once_t table_once = PTHREAD_ONCE_INIT;

static double elfouhaily_height(double wind_mps, double fetch_m)
{
    const double lo = log(0.15 * pel_elfouhaily_peak(wind_mps, fetch_m));
    const double step = 0.04;
    double m0 = 0, s, delta;
    for (int i = 0; i < 200; i++) { /* to 450 times the peak's wave number */
        double k = exp(lo + step * i);
        pel_elfouhaily(k, wind_mps, fetch_m, &s, &delta);
        m0 += step * k * s * pel_wind_over_viscosity(k, wind_mps);
    }
    return 4 * sqrt(m0);
}

static void fill_table(void)
{
    for (int w = 0; w < WINDS; w++) {
        double wind = exp(FIRST_WIND + WIND_STEP * w);
        double scale = wind * wind / PEL_GRAVITY;
        double *row = table[w];
        for (int i = 0; i < PLACES; i++) {
            double x = exp(FIRST + STEP * i);
            row[i] =
                log(fmax(elfouhaily_height(wind, x * scale) / scale, 1e-9));
            /* By the least, so that it has an inverse. */
            row[i] = i > 0 ? fmax(row[i], row[i - 1] + 1e-9) : row[i];
        }
    }
}

static double between(double place, int count, int *below)
{
    place = fmin(fmax(place, 0), count - 1.0001);
    *below = (int)place;
    return place - *below;
}

/* The table's row of a wind. */
struct row {
    int below;
    double f;
};

static struct row row_of(double wind_mps)
{
    struct row r;
    r.f = between((log(wind_mps) - FIRST_WIND) / WIND_STEP, WINDS, &r.below);
    return r;
}

static double in_row(const struct row *r, int place)
{
    return table[r->below][place] +
           r->f * (table[r->below + 1][place] - table[r->below][place]);
}

void pel_growth_of(enum pel_spectrum_kind kind, double gamma,
                   struct pel_growth_law *out)
{
    *out = (struct pel_growth_law){ kind, gamma, 0 };
    if (kind == PEL_SPECTRUM_ELFOUHAILY) {
        pthread_once(&table_once, fill_table);
        return;
    }
    const double wind = 10, fetch = 1e5;
    const struct pel_sea_desc desc = {
        .kind = kind, .wind_mps = wind, .fetch_m = fetch, .gamma = gamma
    };
    double x = PEL_GRAVITY * fetch / (wind * wind);
    double h = 4 * sqrt(pel_spectrum_m0(&desc, 0, INFINITY));
    out->factor = h * PEL_GRAVITY / (wind * wind) / pow(x, JONSWAP_POWER);
}

double pel_growth_height(const struct pel_growth_law *law, double wind_mps,
                         double fetch_m)
{
    if (!(wind_mps > 0)) {
        return 0;
    }
    double scale = wind_mps * wind_mps / PEL_GRAVITY, x = fetch_m / scale;
    if (law->kind != PEL_SPECTRUM_ELFOUHAILY) {
        return scale * law->factor *
               pow(fmin(x, JONSWAP_DEVELOPED), JONSWAP_POWER);
    }
    struct row row = row_of(wind_mps);
    int i;
    double f = between((log(x) - FIRST) / STEP, PLACES, &i);
    return scale *
           exp(in_row(&row, i) + f * (in_row(&row, i + 1) - in_row(&row, i)));
}

static double place_of(const struct row *r, double value)
{
    int lo = 0, hi = PLACES - 1;
    if (!(value > in_row(r, 0))) {
        return 0;
    }
    if (value >= in_row(r, hi)) {
        return hi;
    }
    while (hi - lo > 1) {
        int mid = (lo + hi) / 2;
        if (in_row(r, mid) <= value) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    double low = in_row(r, lo);
    return lo + (value - low) / (in_row(r, hi) - low);
}

double pel_growth_fetch(const struct pel_growth_law *law, double wind_mps,
                        double height_m)
{
    double fetch =
        height_m > 0 ? PEL_GROWTH_MOST_FETCH_M : PEL_GROWTH_LEAST_FETCH_M;
    if (height_m > 0 && wind_mps > 0) {
        double scale = wind_mps * wind_mps / PEL_GRAVITY, x;
        if (law->kind == PEL_SPECTRUM_ELFOUHAILY) {
            struct row row = row_of(wind_mps);
            x = exp(FIRST + STEP * place_of(&row, log(height_m / scale)));
        } else {
            x = pow(height_m / scale / law->factor, 1 / JONSWAP_POWER);
            x = fmin(x, JONSWAP_DEVELOPED);
        }
        fetch = x * scale;
    }
    return fmin(fmax(fetch, PEL_GROWTH_LEAST_FETCH_M), PEL_GROWTH_MOST_FETCH_M);
}

double pel_growth_peak(const struct pel_growth_law *law, double wind_mps,
                       double fetch_m)
{
    if (!(wind_mps > 0)) {
        return 0;
    }
    if (law->kind == PEL_SPECTRUM_ELFOUHAILY) {
        return 2 * PEL_PI /
               pel_dispersion_depth(pel_elfouhaily_peak(wind_mps, fetch_m), 0);
    }
    const struct pel_sea_desc desc = { .kind = law->kind,
                                       .wind_mps = wind_mps,
                                       .fetch_m = fetch_m,
                                       .gamma = law->gamma };
    return 2 * PEL_PI / pel_spectrum_peak(&desc);
}
