#include "ocean/bins.h"

#include <math.h>

#include "base/vec.h"
#include "ocean/hash.h"

#define FIRST 1e-4 /* of the energy: where bins begin */
#define EVEN_FROM 1e-3

void pel_bins_measure(const double *energy, const double *slope, int steps,
                      double *measure)
{
    double roots = 0, root = 0;
    int first = 0, even_from = 0;
    for (int i = 0; i < steps; i++) {
        first += energy[i + 1] < FIRST * energy[steps];
        even_from += energy[i + 1] < EVEN_FROM * energy[steps];
    }
    for (int i = first; i < steps; i++) {
        roots += sqrt(energy[i + 1] - energy[i]);
    }
    double rising = slope[steps] - slope[first];
    for (int i = 0; i <= steps; i++) {
        double even = fmax(i - even_from, 0) / (steps - even_from);
        measure[i] =
            PEL_BINS_ROOT * root / roots +
            PEL_BINS_SLOPE * fmax(slope[i] - slope[first], 0) / rising +
            (1.0 - PEL_BINS_ROOT - PEL_BINS_SLOPE) * even;
        root += i >= first && i < steps ? sqrt(energy[i + 1] - energy[i]) : 0;
    }
}

double pel_bins_bound(const double *measure, int steps, int n, int i,
                      uint32_t seed)
{
    if (i >= n) {
        return steps;
    }
    double u = pel_hash01(seed, PEL_STREAM_FREQUENCY, (uint32_t)i);
    double m = i <= 0 ? 0 : (i + 0.4 * (u - 0.5)) / n;
    int lo = 0, hi = steps;
    while (hi - lo > 1) {
        int mid = (lo + hi) / 2;
        if (measure[mid] <= m) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    double a = measure[lo], z = measure[hi];
    return lo + (z > a ? pel_clamp((m - a) / (z - a), 0, 1) : 0);
}

double pel_bins_at(const double *sum, int steps, double place)
{
    int i = (int)place;
    return i >= steps ? sum[steps]
                      : sum[i] + (place - i) * (sum[i + 1] - sum[i]);
}
