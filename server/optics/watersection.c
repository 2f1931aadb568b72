#include "optics/watersection.h"

#include <math.h>

#include "base/vec.h"

/* How far the level ends reach, m: farther than light. */
#define FAR 1e7

struct pel_section pel_section_level(double depth_m)
{
    return (struct pel_section){ .knots = 1, .depth_m = { depth_m } };
}

enum pel_err pel_section_plane(double slope, double azimuth_rad, double view_mu,
                               double depth_m, double deepest_m,
                               struct pel_section *out)
{
    double run = depth_m * sqrt(1.0 - view_mu * view_mu) / view_mu;
    double met = run * cos(azimuth_rad), here = depth_m - slope * met;
    if (here <= 0.0 || slope < 0.0 || deepest_m <= depth_m) {
        return PEL_ERR_INVALID;
    }
    if (slope == 0.0) {
        *out = pel_section_level(depth_m);
        return PEL_OK;
    }
    *out = (struct pel_section){
        .azimuth_rad = azimuth_rad,
        .knots = 2,
        .along_m = { -here / slope, (deepest_m - here) / slope },
        .depth_m = { 0.0, deepest_m },
    };
    return PEL_OK;
}

double pel_section_depth(const struct pel_section *p, double along_m)
{
    int last = p->knots - 1;
    if (along_m <= p->along_m[0]) {
        return p->depth_m[0];
    }
    for (int k = 0; k < last; k++) {
        double run = p->along_m[k + 1] - p->along_m[k];
        if (along_m < p->along_m[k + 1]) {
            double part = (along_m - p->along_m[k]) / run;
            return p->depth_m[k] + part * (p->depth_m[k + 1] - p->depth_m[k]);
        }
    }
    return p->depth_m[last];
}

/* Meets the straight piece from a to b (along, depth) from its upper side, so
 * that a line that starts on it does not meet it again. */
static bool meet_piece(const double a[2], const double b[2], double along_m,
                       double depth_m, double along, double up,
                       struct pel_section_hit *hit)
{
    double run = b[0] - a[0], rise = a[1] - b[1];
    double facing = up * run - along * rise;
    if (facing >= 0.0) {
        return false;
    }
    double length = ((depth_m - a[1]) * run - (a[0] - along_m) * rise) / facing;
    /* What rounding puts behind a piece in a corner is on it. */
    if (length < -1e-9 * (1.0 + fabs(along_m) + depth_m)) {
        return false;
    }
    length = fmax(length, 0.0);
    double size2 = run * run + rise * rise;
    double place = ((along_m + length * along - a[0]) * run +
                    (a[1] - depth_m + length * up) * rise) /
                   size2;
    if (place < -1e-9 || place > 1.0 + 1e-9) {
        return false;
    }
    double size = sqrt(size2);
    *hit = (struct pel_section_hit){ length, -rise / size, run / size };
    return true;
}

bool pel_section_meet(const struct pel_section *p, double along_m,
                      double depth_m, double along, double up,
                      struct pel_section_hit *hit)
{
    if (p->knots == 1) {
        *hit = (struct pel_section_hit){ (p->depth_m[0] - depth_m) / -up, 0.0,
                                         1.0 };
        return up < 0.0;
    }
    bool met = false;
    int last = p->knots - 1;
    for (int k = 0; k <= p->knots; k++) {
        const double a[2] = {
            k > 0 ? p->along_m[k - 1] : p->along_m[0] - FAR,
            p->depth_m[k > 0 ? k - 1 : 0],
        };
        const double b[2] = {
            k <= last ? p->along_m[k] : p->along_m[last] + FAR,
            p->depth_m[k <= last ? k : last],
        };
        struct pel_section_hit piece;
        if (meet_piece(a, b, along_m, depth_m, along, up, &piece) &&
            (!met || piece.length < hit->length)) {
            *hit = piece;
            met = true;
        }
    }
    return met;
}
