#include "optics/radar.h"

#include <math.h>
#include <stdlib.h>

#define LIGHT 299792458.0
#define BOLTZMANN 1.380649e-23
#define TURN (2 * PEL_PI)
#define EARTH43_M 8.5e6
#define TEXTURE 1.2 /* of clutter by slopes: its logarithm */

static double cell_m(const struct pel_radar *r)
{
    return 0.5 * LIGHT * r->pulse_s;
}

/* --- the radar equation --------------------------------------------------- */

/* Of 1 m² at 1 m, over noise. */
static double strength(const struct pel_radar *r)
{
    double gain = 26000 / (r->beam_rad / PEL_DEG * PEL_RADAR_TALL_DEG);
    double noise = BOLTZMANN * 290 * (1.2 / r->pulse_s) * PEL_RADAR_NOISE;
    double wave = PEL_RADAR_WAVE_M;
    return PEL_RADAR_POWER_W * gain * gain * wave * wave /
           (pow(4 * PEL_PI, 3) * noise * PEL_RADAR_LOSS);
}

/* Rain, both ways (ITU-R P.838-3 at 9.4 GHz, horizontal). */
static double through_rain(const struct pel_radar *r, double range_m)
{
    double db_km = r->rain_mm_h > 0 ? 0.0107 * pow(r->rain_mm_h, 1.26) : 0;
    return pow(10, -0.1 * db_km * 2 * range_m * 1e-3);
}

double pel_radar_echo(const struct pel_radar *r, double range_m, double sigma,
                      double height_m)
{
    double reach =
        PEL_RADAR_HORIZON * (sqrt(r->height_m) + sqrt(fmax(height_m, 0)));
    if (range_m >= reach) {
        return 0;
    }
    double lift = 4 * PEL_PI * r->height_m * fmax(height_m, 0) /
                  (PEL_RADAR_WAVE_M * range_m);
    double near = fmin(lift, 1), near2 = near * near;
    double range2 = range_m * range_m;
    return strength(r) * sigma * near2 * near2 * through_rain(r, range_m) /
           (range2 * range2);
}

double pel_radar_sea(const struct pel_radar *r, double grazing_rad,
                     double off_wind_rad)
{
    const double wave = PEL_RADAR_WAVE_M;
    double h = fmax(r->wave_m, 1e-3), g = fmax(grazing_rad, 1e-5);
    double rough = (14.4 * wave + 5.5) * g * h / wave;
    double rough4 = pow(rough, 4);
    double power = 1.1 / pow(wave + 0.015, 0.4);
    double wind = 8.67 * pow(h, 0.4);
    double interference = rough4 / (1 + rough4);
    double upwind =
        exp(0.2 * cos(off_wind_rad) * (1 - 2.8 * g) * pow(wave + 0.015, -0.4));
    double speed = pow(1.94 * wind / (1 + wind / 15.4), power);
    return 3.9e-6 * wave * pow(g, 0.4) * interference * upwind * speed;
}

double pel_radar_clutter(const struct pel_radar *r, double range_m,
                         double bearing_rad)
{
    double far = fmax(range_m, r->height_m);
    double grazing = asin(r->height_m / far) - far / (2 * EARTH43_M);
    if (grazing <= 0) {
        return 0;
    }
    double area = far * r->beam_rad * cell_m(r) / cos(fmin(grazing, 1.5));
    /* The wind comes from the other side. */
    double from = 1.5 * PEL_PI - r->wind_to_rad;
    double sigma0 = pel_radar_sea(r, grazing, bearing_rad - from);
    return strength(r) * sigma0 * area * through_rain(r, far) / pow(far, 4);
}

double pel_radar_rain(const struct pel_radar *r, double range_m)
{
    if (r->rain_mm_h <= 0) {
        return 0;
    }
    double z = 200 * pow(r->rain_mm_h, 1.6) * 1e-18;
    double per_m3 = pow(PEL_PI, 5) * 0.93 * z / pow(PEL_RADAR_WAVE_M, 4);
    double tall = fmin(range_m * PEL_RADAR_TALL_DEG * PEL_DEG, 3000);
    double volume = range_m * r->beam_rad * tall * cell_m(r) * 0.5;
    return strength(r) * per_m3 * volume * through_rain(r, range_m) /
           pow(fmax(range_m, 20), 4);
}

double pel_radar_ship(double length_m, double beam_m, double draught_m,
                      double aspect_rad, double least)
{
    double kt = 0.6 * length_m * beam_m * fmax(draught_m, 0.1) * 1.025e-3;
    double median = fmax(52 * sqrt(9400) * pow(kt, 1.5), least);
    double abeam = fabs(sin(aspect_rad)), ends = fabs(cos(aspect_rad));
    return median * (1 + 3 * pow(abeam, 24) + 0.6 * pow(ends, 48));
}

/* --- one turn ------------------------------------------------------------- */

double pel_radar_passed(const struct pel_radar *r, double bearing_rad,
                        double time_s, int64_t *turn)
{
    double share = bearing_rad / TURN - floor(bearing_rad / TURN);
    double turns = floor(time_s / r->turn_s - share);
    *turn = (int64_t)turns;
    return (turns + share) * r->turn_s;
}

static double chance(uint32_t seed, uint64_t a, uint64_t b)
{
    uint64_t z = seed * UINT64_C(0x9e3779b97f4a7c15) ^
                 a * UINT64_C(0xbf58476d1ce4e5b9) ^
                 b * UINT64_C(0x94d049bb133111eb);
    for (int i = 0; i < 2; i++) {
        z ^= z >> 31;
        z *= UINT64_C(0xd6e8feb86659fd93);
        z ^= z >> 29;
    }
    return ((double)(z >> 11) + 0.5) * 0x1p-53;
}

enum pel_err pel_radar_scan_create(int cells, struct pel_radar_scan **out)
{
    struct pel_radar_scan *scan = calloc(1, sizeof *scan);
    if (scan) {
        scan->cells = cells;
        scan->power =
            calloc((size_t)cells * PEL_RADAR_BEARINGS, sizeof *scan->power);
        scan->means = calloc(3 * (size_t)cells, sizeof *scan->means);
    }
    if (!scan || !scan->power || !scan->means) {
        pel_radar_scan_destroy(scan);
        return PEL_ERR_NO_MEMORY;
    }
    *out = scan;
    return PEL_OK;
}

void pel_radar_scan_destroy(struct pel_radar_scan *scan)
{
    if (scan) {
        free(scan->power);
        free(scan->means);
        free(scan);
    }
}

static double bearing_of(int row)
{
    return TURN * (row + 0.5) / PEL_RADAR_BEARINGS;
}

/* Pulses that a point gets while the beam passes, of 1.2 kHz. */
static double hits(const struct pel_radar *r)
{
    return fmax(1200 * r->turn_s * r->beam_rad / TURN, 1);
}

static void find_means(const struct pel_radar *r, struct pel_radar_scan *scan)
{
    double from = 1.5 * PEL_PI - r->wind_to_rad;
    for (int i = 0; i < scan->cells; i++) {
        double range = r->range_m / scan->cells * (i + 0.5);
        double *to = scan->means + 3 * (size_t)i;
        to[0] = pel_radar_clutter(r, range, from + 0.5 * PEL_PI);
        double upwind = pel_radar_clutter(r, range, from);
        to[1] = to[0] > 0 ? log(upwind / to[0]) : 0;
        to[2] = pel_radar_rain(r, range);
    }
}

void pel_radar_fill(const struct pel_radar *r, double time_s,
                    pel_radar_heave *heave, void *user,
                    struct pel_radar_scan *scan)
{
    double step = r->range_m / scan->cells, many = 1 / sqrt(hits(r));
    double from = 1.5 * PEL_PI - r->wind_to_rad;
    find_means(r, scan);
    for (int row = 0; row < PEL_RADAR_BEARINGS; row++) {
        int64_t turn;
        double bearing = bearing_of(row), upwind = cos(bearing - from);
        pel_radar_passed(r, bearing, time_s, &turn);
        uint64_t sector = (uint64_t)(bearing / (0.5 * r->beam_rad));
        for (int i = 0; i < scan->cells; i++) {
            const double *mean = scan->means + 3 * (size_t)i;
            double range = step * (i + 0.5), sea = 0, rain = 0;
            uint64_t cell = (uint64_t)(range / fmax(cell_m(r), step));
            uint64_t place = (uint64_t)turn << 40 | sector << 20 | cell;
            uint64_t pixel =
                (uint64_t)turn << 40 | (uint64_t)row << 20 | (uint64_t)i;
            if (mean[0] > 0.005) {
                double s = heave ? TEXTURE * heave(user, bearing, range, turn) -
                                       0.5 * TEXTURE * TEXTURE
                                 : 0;
                sea = -mean[0] * exp(mean[1] * upwind + s) *
                      log(chance(r->seed, place, 1));
            }
            if (mean[2] > 0) {
                rain = -mean[2] * log(chance(r->seed, place, 2));
            }
            /* Noise of many pulses is nearly a Gaussian: here the sum of three
             * even chances, of variance 1. */
            double g =
                2 * (chance(r->seed, pixel, 3) + chance(r->seed, pixel, 4) +
                     chance(r->seed, pixel, 5) - 1.5);
            scan->power[(size_t)row * (size_t)scan->cells + (size_t)i] =
                (float)(sea + rain + fmax(1 + many * g, 0));
        }
    }
}

void pel_radar_add(const struct pel_radar *r, double time_s,
                   const struct pel_radar_point *p, struct pel_radar_scan *scan)
{
    double step = r->range_m / scan->cells;
    double mean = pel_radar_echo(r, p->range_m, p->sigma, p->height_m);
    double echo = -mean * log(chance(r->seed, p->id, (uint64_t)p->turn + 7));
    int first = (int)floor(p->range_m / step);
    int last = (int)floor((p->range_m + cell_m(r)) / step);
    int middle = (int)floor(p->bearing_rad / TURN * PEL_RADAR_BEARINGS);
    int reach = (int)ceil(2 * r->beam_rad / TURN * PEL_RADAR_BEARINGS) + 1;
    for (int k = middle - reach; k <= middle + reach && echo > 0; k++) {
        int row = ((k % PEL_RADAR_BEARINGS) + PEL_RADAR_BEARINGS) %
                  PEL_RADAR_BEARINGS;
        int64_t turn;
        pel_radar_passed(r, bearing_of(row), time_s, &turn);
        if (turn != p->turn) {
            continue;
        }
        double off =
            remainder(bearing_of(row) - p->bearing_rad, TURN) / r->beam_rad;
        double seen = echo * exp(-5.545 * off * off);
        for (int i = first < 0 ? 0 : first; i <= last && i < scan->cells; i++) {
            scan->power[(size_t)row * (size_t)scan->cells + (size_t)i] +=
                (float)seen;
        }
    }
}

void pel_radar_add_land(const struct pel_radar *r, double time_s,
                        pel_radar_land *land, void *user,
                        struct pel_radar_scan *scan)
{
    double step = r->range_m / scan->cells;
    for (int row = 0; row < PEL_RADAR_BEARINGS; row++) {
        int64_t turn;
        double bearing = bearing_of(row), highest = -INFINITY;
        float *power = scan->power + (size_t)row * (size_t)scan->cells;
        pel_radar_passed(r, bearing, time_s, &turn);
        for (int i = 0; i < scan->cells; i++) {
            double range = step * (i + 0.5);
            double h = land(user, bearing, range, turn);
            double angle =
                (fmax(h, 0) - r->height_m) / range - range / (2 * EARTH43_M);
            if (angle < highest) {
                power[i] = fminf(power[i], 1.5F);
                continue;
            }
            if (h > 0) {
                double rise =
                    i > 0
                        ? pel_clamp((angle - fmax(highest, -1)) * range / step,
                                    0.02, 1)
                        : 0.1;
                double area = range * r->beam_rad * fmax(step, cell_m(r));
                uint64_t place = (uint64_t)row << 20 | (uint64_t)i;
                double sigma = 0.03 * rise * area;
                double fade = 0.3 - 0.7 * log(chance(r->seed, place, 11));
                power[i] += (float)(fade * strength(r) * sigma *
                                    through_rain(r, range) / pow(range, 4));
                highest = angle;
            }
        }
    }
}
