/* Coordinates of a grid with equal steps, from a list of them. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "weather/reader/forecast.h"

/* By how much a coordinate may be off that is printed with some decimals, and
 * then kept in single precision: half a unit of the last. 0: not so printed. */
static double rounding_of(const double *v, size_t count)
{
    double unit = 0.01;
    for (int digits = 2; digits <= 7; digits++, unit /= 10) {
        bool all = true;
        for (size_t i = 0; all && i < count; i++) {
            double off = fabs(v[i] - rint(v[i] / unit) * unit);
            all = off <= FLT_EPSILON * fabs(v[i]) + 1e-12;
        }
        if (all) {
            return 0.5 * unit;
        }
    }
    return 0;
}

/* Longitudes without the jump at the date line. */
static void unroll(double *v, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        double jump = v[i] - v[i - 1];
        if (fabs(jump) > 180) {
            v[i] -= 360 * rint(jump / 360);
        }
    }
}

bool pel_forecast_axis_fit(const double *degrees, size_t count, bool longitude,
                           struct pel_forecast_axis *out)
{
    double *v = count < 2 || count > 100000 ? NULL : calloc(count, sizeof *v);
    double middle = 0.5 * ((double)count - 1), all = 0, sum = 0, most = 0;
    bool finite = v != NULL;
    for (size_t i = 0; finite && i < count; i++) {
        v[i] = degrees[i];
        finite = fabs(v[i]) <= 1000;
    }
    if (!finite) {
        free(v);
        return false;
    }
    double rounding = rounding_of(v, count);
    if (longitude) {
        unroll(v, count);
    }
    /* The line of least squares: one coordinate's rounding moves it little. */
    for (size_t i = 0; i < count; i++) {
        double x = (double)i - middle;
        all += v[i];
        sum += x * v[i];
        most = fmax(most, fabs(v[i]));
    }
    double n = (double)count, mean = all / n;
    double step = sum / (n * (n * n - 1) / 12);

    double off = 0;
    for (size_t i = 0; i < count; i++) {
        off = fmax(off, fabs(v[i] - mean - step * ((double)i - middle)));
    }
    *out = (struct pel_forecast_axis){
        .count = (int)count,
        .first = mean - fabs(step) * middle,
        .step = fabs(step),
        .falling = step < 0,
    };
    free(v);
    double allowed =
        fmin(1.5 * rounding, 0.1 * fabs(step)) + 4 * FLT_EPSILON * most + 1e-9;
    return fabs(step) > 1e-7 && off <= allowed;
}
