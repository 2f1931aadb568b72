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

static double at_range(const struct pel_radar *r,
                       const struct pel_radar_screen *s,
                       const struct pel_radar_scan *scan, double bearing,
                       double share)
{
    double turns = bearing / TURN - floor(bearing / TURN);
    int row = (int)(turns * PEL_RADAR_BEARINGS) % PEL_RADAR_BEARINGS;
    int i = (int)(share * scan->cells);
    const float *power = scan->power + (size_t)row * (size_t)scan->cells;
    double before = 0;
    int back = s->ftc > 0 && i > 8 ? 8 : 0;
    for (int k = 1; k <= back; k++) {
        before += decibels(power[i - k]) / back;
    }
    return video(s, share * r->range_m, decibels(power[i]), before);
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

void pel_radar_show(const struct pel_radar *r, const struct pel_radar_screen *s,
                    double time_s, const struct pel_radar_scan *scan,
                    uint32_t width, uint32_t height, uint32_t first,
                    uint32_t rows, uint8_t *rgba)
{
    double radius = 0.5 * FILLED * (width < height ? width : height);
    for (uint32_t k = first * width; k < (first + rows) * width; k++) {
        double x = (k % width) + 0.5 - 0.5 * width,
               y = 0.5 * height - (k / width) - 0.5;
        double away = hypot(x, y), bearing = atan2(x, y) + s->up_rad;
        uint8_t *to = rgba + 4 * (size_t)k;
        if (away >= radius) {
            double mark =
                scale(bearing, radius, away) + line(away - radius - 0.5);
            put(to, 0.02 + 0.1 * mark, 0.03 + 0.5 * mark, 0.04 + 0.4 * mark);
            continue;
        }
        int64_t turn;
        double age = time_s - pel_radar_passed(r, bearing, time_s, &turn);
        double v = at_range(r, s, scan, bearing, away / radius);
        v *= 0.45 + 0.55 * exp(-2 * age / r->turn_s);
        double ring = 0;
        for (int i = 1; i < s->rings; i++) {
            ring = fmax(ring, line(away - radius * i / s->rings));
        }
        double ahead = isnan(s->heading_rad)
                           ? 0
                           : remainder(bearing - s->heading_rad, TURN);
        double head =
            isnan(s->heading_rad) || fabs(ahead) > 1 ? 0 : line(ahead * away);
        double sweep = exp(-40 * age / r->turn_s);
        put(to, 0.95 * v + 0.10 * ring + 0.35 * head,
            0.01 + 0.88 * v + 0.28 * ring + 0.40 * head + 0.10 * sweep,
            0.03 + 0.15 * v + 0.22 * ring + 0.35 * head + 0.06 * sweep);
    }
}
