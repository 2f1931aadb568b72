/* A navigation radar of 3.2 cm: what comes back, by the radar equation, and one
 * turn of its antenna as echoes by bearing and range (docs/physics/sensors.md).
 * Plain functions of their arguments; any thread. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "base/vec.h"

#define PEL_RADAR_WAVE_M 0.032
#define PEL_RADAR_POWER_W 10e3
#define PEL_RADAR_TALL_DEG 22.0 /* the beam's vertical width */
#define PEL_RADAR_LOSS 2.5      /* of the whole, a factor */
#define PEL_RADAR_NOISE 3.16    /* the receiver's noise figure, a factor */
#define PEL_RADAR_HORIZON                                                      \
    4124.0 /* m of range a root of a metre of height: 4/3                      \
              of the Earth's radius */

struct pel_radar {
    double range_m;  /* of the picture's edge */
    double pulse_s;  /* its length */
    double beam_rad; /* horizontal width of the beam, half power */
    double turn_s;   /* a turn of the antenna */
    double height_m; /* of the antenna above the sea, > 0 */
    double rain_mm_h;
    double wave_m;      /* mean height of the waves, 0.63 of the significant */
    double wind_to_rad; /* mathematical direction */
    uint32_t seed;
};

/* All of these are powers over the receiver's mean noise, of one pulse. */

/* The echo of `sigma` m² at a height above the sea: free space times
 * min(1, (4π h1 h2 / λ r))⁴ for its reflection in the sea, attenuated by rain,
 * 0 behind the horizon. */
double pel_radar_echo(const struct pel_radar *r, double range_m, double sigma,
                      double height_m);

/* Reflectivity of the sea, horizontal polarisation, by the grazing angle and
 * the angle between the sight and where the wind comes from (Horst, Dyer and
 * Tuley 1978, the "GIT" model) [m²/m²]. */
double pel_radar_sea(const struct pel_radar *r, double grazing_rad,
                     double off_wind_rad);

/* Mean of what the sea sends from a cell: beam times half a pulse. Bearing
 * clockwise from north. */
double pel_radar_clutter(const struct pel_radar *r, double range_m,
                         double bearing_rad);

/* Mean of what rain sends (Z = 200 R^1.6) from a cell of air below 3 km. */
double pel_radar_rain(const struct pel_radar *r, double range_m);

/* When the antenna last passed a bearing by time_s: it looks north at times
 * that are whole turns. *turn: their number. */
double pel_radar_passed(const struct pel_radar *r, double bearing_rad,
                        double time_s, int64_t *turn);

/* A point that sends echoes; swerling: fluctuates from turn to turn. */
struct pel_radar_point {
    double bearing_rad, range_m, height_m, sigma;
    uint32_t id; /* no two alike, for its fluctuation */
    int64_t turn;
};

/* One picture in bearings and ranges, power over noise, means included; rows
 * of PEL_RADAR_BEARINGS from north, clockwise. */
#define PEL_RADAR_BEARINGS 1024
struct pel_radar_scan {
    int cells; /* of range */
    float *power;
    /* Of each cell: the sea's mean across the wind, the logarithm of what it is
     * times upwind, rain's mean. */
    double *means;
};

/* NO_MEMORY. */
PEL_CHECK enum pel_err pel_radar_scan_create(int cells,
                                             struct pel_radar_scan **out);
void pel_radar_scan_destroy(struct pel_radar_scan *scan);

/* Clears it to noise and rain, and the sea's clutter where `heave` is; in the
 * turns at time_s. `heave` gives, or is NULL: the sea's slope towards the radar
 * in standard deviations at bearing, range and turn: it makes clutter
 * exp(1.2 s - 0.72) times its mean, which leaves it. */
typedef double pel_radar_heave(void *user, double bearing_rad, double range_m,
                               int64_t turn);
void pel_radar_fill(const struct pel_radar *r, double time_s,
                    pel_radar_heave *heave, void *user,
                    struct pel_radar_scan *scan);

/* Adds a point where the antenna's last pass was in the point's turn: over the
 * beam (Gaussian, both ways) and half a pulse of range; Swerling's case 1. */
void pel_radar_add(const struct pel_radar *r, double time_s,
                   const struct pel_radar_point *p,
                   struct pel_radar_scan *scan);

/* Land: `height` answers metres above the sea at bearing and range. Cells that
 * higher ones hide send nothing, what lies behind land neither. */
typedef double pel_radar_land(void *user, double bearing_rad, double range_m,
                              int64_t turn);
void pel_radar_add_land(const struct pel_radar *r, double time_s,
                        pel_radar_land *land, void *user,
                        struct pel_radar_scan *scan);

/* Radar cross section, m², of a ship so large (Skolnik: 52 √f D^1.5, f MHz, D
 * thousand tonnes; no less than `least`), seen at `aspect` from her bow: the
 * median, 6 dB more within some degrees of abeam, 2 dB more at the ends. */
double pel_radar_ship(double length_m, double beam_m, double draught_m,
                      double aspect_rad, double least);

/* The picture: gain, suppression of sea (stc) and rain (ftc), 0..1. */
struct pel_radar_screen {
    double gain, stc, ftc;
    double up_rad;      /* bearing at the top */
    double heading_rad; /* NaN: no line */
    int rings;
};
/* Rows [first, first + rows) of a picture so wide and high. */
void pel_radar_show(const struct pel_radar *r, const struct pel_radar_screen *s,
                    double time_s, const struct pel_radar_scan *scan,
                    uint32_t width, uint32_t height, uint32_t first,
                    uint32_t rows, uint8_t *rgba);
