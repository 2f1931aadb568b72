/* Numbers that are no heights: fill values which a file does not declare. */
#include <math.h>
#include <stdio.h>

#include "seabed/reader/meaning.h"

/* Beyond the deepest sea and the highest mountain, whichever way it grows. */
#define MOST_M 11500.0
#define FILL 9999.0F     /* with a sign, where nobody tells of another */
#define MOST_BY_CHANCE 3 /* nodes that are it */

static enum pel_err refuse(double worst, const struct pel_raster_said *said,
                           const char *why, struct pel_fault *fault)
{
    char cure[160];
    if (said->netcdf) {
        snprintf(cure, sizeof cure,
                 "ncatted -a missing_value,%.40s,o,%c,%.9g FILE",
                 *said->name ? said->name : "VARIABLE",
                 said->type ? said->type : 'f', worst);
    } else {
        snprintf(cure, sizeof cure, "gdal_edit.py -a_nodata %.9g FILE", worst);
    }
    return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                         "it has %g, %s: a fill value that is not declared? "
                         "Say it, as by %s",
                         worst, why, cure);
}

/* 99, 999.9 and the like: all of its digits are one of 7, 8, 9. */
static bool is_usual(double v)
{
    static const double digits[] = { 7, 8, 9 };
    for (size_t i = 0; i < sizeof digits / sizeof *digits; i++) {
        double n = 0, unit = 1;
        for (int whole = 1; whole <= 4; whole++, unit *= 10) {
            n += digits[i] * unit;
            double tenths = n + 0.1 * digits[i];
            double cents = tenths + 0.01 * digits[i];
            if (whole >= 2 && (fabs(v - n) < 1e-4 || fabs(v - tenths) < 1e-3 ||
                               fabs(v - cents) < 1e-3)) {
                return true;
            }
        }
    }
    return false;
}

/* The end of the numbers, by a sign from below or above: whether more nodes are
 * it than lie between it and the middle of all, as they do where it has been
 * resampled with its neighbours. */
static bool stands_apart(const float *from, size_t count, double end,
                         double other)
{
    size_t at = 0, between = 0, rest = 0;
    double middle = 0.5 * (end + other);
    for (size_t i = 0; i < count; i++) {
        double v = (double)from[i];
        bool near = end < other ? v < middle : v > middle;
        at += v == end;
        between += near && v != end;
        rest += !near && !isnan(v);
    }
    return end != other && at > MOST_BY_CHANCE && at > between / 4 && rest > 0;
}

enum pel_err pel_raster_check_fills(const float *from, size_t count,
                                    double scale, double offset, double metres,
                                    const struct pel_raster_said *said,
                                    struct pel_fault *fault)
{
    char why[64];
    size_t fills = 0;
    double worst = 0, most = 0, ends[2] = { INFINITY, -INFINITY };
    for (size_t i = 0; i < count; i++) {
        double v = (double)from[i];
        double height = (v * scale + offset) * metres;
        fills += fabsf(from[i]) == FILL;
        ends[0] = fmin(ends[0], v); /* false for NaN */
        ends[1] = fmax(ends[1], v);
        if (fabs(height) > most) {
            most = fabs(height);
            worst = v;
        }
    }
    if (most > MOST_M || fills > MOST_BY_CHANCE) {
        snprintf(why, sizeof why, "which is no height or depth (within %g m)",
                 MOST_M);
        return refuse(worst, said, why, fault);
    }
    for (int i = 0; i < 2; i++) {
        bool usual =
            is_usual(fabs(ends[i])) || is_usual(fabs(ends[i] * scale + offset));
        if (usual && stands_apart(from, count, ends[i], ends[1 - i])) {
            return refuse(ends[i], said, "far from all others", fault);
        }
    }
    return PEL_OK;
}
