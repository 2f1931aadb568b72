#include "ocean/reader/buoy.h"

#include <math.h>

#include "base/vec.h"

void pel_bands_init(struct pel_bands *b, int count)
{
    b->count = count;
    for (int i = 0; i < count; i++) {
        b->frequency_hz[i] = b->density[i] = b->r1[i] = b->r2[i] = NAN;
        b->alpha1_rad[i] = b->alpha2_rad[i] = NAN;
    }
}

double pel_goes_to_rad(double from_deg)
{
    return remainder(270.0 - from_deg, 360.0) * PEL_DEG;
}

double pel_r1_of_spread(double spread_rad)
{
    return 1 - 0.5 * spread_rad * spread_rad;
}

void pel_bands_fourier(struct pel_bands *b, int i, const double ab[4])
{
    b->r1[i] = hypot(ab[0], ab[1]);
    b->r2[i] = hypot(ab[2], ab[3]);
    b->alpha1_rad[i] = atan2(ab[1], ab[0]);
    b->alpha2_rad[i] = 0.5 * atan2(ab[3], ab[2]);
}

/* The moments of band i as band k of the record. */
static void take_moments(const struct pel_bands *b, int i,
                         struct pel_measured *out, int k)
{
    /* Coefficients of noise may be a little over 1. */
    bool first =
        b->r1[i] >= 0 && b->r1[i] <= 1.01 && isfinite(b->alpha1_rad[i]);
    bool second =
        b->r2[i] >= 0 && b->r2[i] <= 1.01 && isfinite(b->alpha2_rad[i]);
    double r1 = first ? fmin(b->r1[i], 1) : 0;
    out->r1[k] = r1;
    out->alpha1_rad[k] = first ? remainder(b->alpha1_rad[i], 2 * PEL_PI) : 0;
    out->r2[k] = !first ? 0 : second ? fmin(b->r2[i], 1) : r1 * r1 * r1 * r1;
    out->alpha2_rad[k] = first && second
                             ? remainder(b->alpha2_rad[i], 2 * PEL_PI)
                             : out->alpha1_rad[k];
}

enum pel_err pel_bands_take(const struct pel_bands *b, struct pel_measured *out,
                            struct pel_fault *fault)
{
    int n = 0;
    for (int i = 0; i < b->count; i++) {
        /* Some buoys have a band below that of any wave, of their drift. */
        if (!(b->density[i] >= 0) || b->frequency_hz[i] < 0.005) {
            continue;
        }
        out->frequency_hz[n] = b->frequency_hz[i];
        out->density[n] = b->density[i];
        take_moments(b, i, out, n);
        n++;
    }
    out->count = n;
    if (n == 0) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "the record has no density, all of its %d bands "
                             "are missing: choose another measuredTime",
                             b->count);
    }
    return pel_shelf_frequencies(out->frequency_hz, n, fault);
}
