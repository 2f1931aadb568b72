/* A turn of the radar as a plan position indicator shows it. */
#include <math.h>

#include "optics/radar.h"

#define TURN (2 * PEL_PI)
#define SPAN_DB 22.0
#define NEAREST_M 50.0
/* The whole of a screen's radius that the picture fills. */
#define FILLED 0.94

static double decibels(float power)
{
    return 10 * log10((double)power + 1e-3);
}

/* 0..1 of brightness; `before`: mean of what came just before, decibels. */
static double video(const struct pel_radar_screen *s, double range_m, double db,
                    double before)
{
    double sea = s->stc * 90 - 30 * log10(fmax(range_m, NEAREST_M) / NEAREST_M);
    db -= s->stc > 0 ? fmax(sea, 0) : 0;
    db -= s->ftc * fmax(before, 0);
    return pel_clamp((db - 5 - 60 * (0.5 - s->gain)) / SPAN_DB, 0, 1);
}

/* Of a cell as it came. */
static double cell_video(const struct pel_radar *r,
                         const struct pel_radar_screen *s, const float *power,
                         int i, int cells)
{
    double before = 0;
    int back = s->ftc > 0 && i > 8 ? 8 : 0;
    for (int k = 1; k <= back; k++) {
        before += decibels(power[i - k]) / back;
    }
    return video(s, (i + 0.5) / cells * r->range_m, decibels(power[i]), before);
}

static void put(uint8_t *to, double red, double green, double blue)
{
    to[0] = (uint8_t)(255 * pel_clamp(red, 0, 1) + 0.5);
    to[1] = (uint8_t)(255 * pel_clamp(green, 0, 1) + 0.5);
    to[2] = (uint8_t)(255 * pel_clamp(blue, 0, 1) + 0.5);
    to[3] = 255;
}

static double line(double off_px)
{
    return pel_clamp(1.2 - fabs(off_px), 0, 1);
}

/* Marks of 10° around the picture, longer each 30°. */
static double scale(double bearing, double radius_px, double away_px)
{
    double deg = bearing / PEL_DEG;
    double off = fabs(remainder(deg, 10)), wide = fabs(remainder(deg, 30));
    double length = wide < 2 ? 10 : 5;
    return away_px > radius_px && away_px < radius_px + length
               ? line(off * PEL_DEG * away_px)
               : 0;
}

struct glow {
    double afterglow, sweep;
};

static void fade(const struct pel_radar *r, double time_s,
                 struct glow glow[PEL_RADAR_BEARINGS])
{
    for (int row = 0; row < PEL_RADAR_BEARINGS; row++) {
        int64_t turn;
        double bearing = TURN * (row + 0.5) / PEL_RADAR_BEARINGS;
        double age = time_s - pel_radar_passed(r, bearing, time_s, &turn);
        glow[row].afterglow = 0.45 + 0.55 * exp(-2 * age / r->turn_s);
        glow[row].sweep = exp(-40 * age / r->turn_s);
    }
}

void pel_radar_show(const struct pel_radar *r, const struct pel_radar_screen *s,
                    double time_s, const struct pel_radar_scan *scan,
                    uint32_t width, uint32_t height, uint32_t first,
                    uint32_t rows, uint8_t *rgba)
{
    double radius = 0.5 * FILLED * (width < height ? width : height);
    double ahead = isnan(s->heading_rad) ? 0 : s->heading_rad - s->up_rad;
    double east = sin(ahead), north = cos(ahead);
    struct glow glow[PEL_RADAR_BEARINGS];
    fade(r, time_s, glow);
    for (uint32_t k = first * width; k < (first + rows) * width; k++) {
        double x = (k % width) + 0.5 - 0.5 * width,
               y = 0.5 * height - (k / width) - 0.5;
        double away = sqrt(x * x + y * y);
        uint8_t *to = rgba + 4 * (size_t)k;
        if (away >= radius) {
            double mark = line(away - radius - 0.5) +
                          (away < radius + 12
                               ? scale(atan2(x, y) + s->up_rad, radius, away)
                               : 0);
            put(to, 0.02 + 0.1 * mark, 0.03 + 0.5 * mark, 0.04 + 0.4 * mark);
            continue;
        }
        double turns = (atan2(x, y) + s->up_rad) / TURN;
        int row = (int)((turns - floor(turns)) * PEL_RADAR_BEARINGS) %
                  PEL_RADAR_BEARINGS;
        int i = (int)(away / radius * scan->cells);
        double v =
            glow[row].afterglow *
            cell_video(r, s, scan->power + (size_t)row * (size_t)scan->cells, i,
                       scan->cells);
        double ring = s->rings && away > 0.5 * radius / s->rings
                          ? line(remainder(away, radius / s->rings))
                          : 0;
        double head = !isnan(s->heading_rad) && x * east + y * north > 0
                          ? line(x * north - y * east)
                          : 0;
        put(to, 0.95 * v + 0.10 * ring + 0.35 * head,
            0.01 + 0.88 * v + 0.28 * ring + 0.40 * head +
                0.10 * glow[row].sweep,
            0.03 + 0.15 * v + 0.22 * ring + 0.35 * head +
                0.06 * glow[row].sweep);
    }
}
