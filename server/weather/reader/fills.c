/* Fill values that nobody declared. */
#include <math.h>

#include "weather/reader/forecast.h"

#define FEW 3 /* nodes that have one number by chance */

/* The least number and the next, and how many nodes have the least. */
struct end {
    double value, next;
    size_t count;
};

/* `sign` 1: from below, -1: from above. */
static struct end end_of(const double *plane, size_t nodes, double sign)
{
    struct end e = { INFINITY, INFINITY, 0 };
    for (size_t i = 0; i < nodes; i++) {
        double v = sign * plane[i]; /* false for NAN */
        if (v < e.value) {
            e = (struct end){ v, e.value, 1 };
        } else if (v == e.value) {
            e.count++;
        } else if (v < e.next) {
            e.next = v;
        }
    }
    e.value *= sign;
    e.next *= sign;
    return e;
}

/* By how much a fill value is apart from the rest, beside half of that. Of
 * periods and directions, which models have in few classes, more. */
static double least_gap(enum pel_cf_quantity quantity)
{
    switch (quantity) {
    case PEL_CF_MPS:
    case PEL_CF_M:
        return 5;
    case PEL_CF_S:
        return 12;
    default:
        return INFINITY;
    }
}

bool pel_forecast_find_fill(enum pel_cf_quantity quantity, const double *plane,
                            size_t nodes, double *value, size_t *count)
{
    const struct end low = end_of(plane, nodes, 1);
    const struct end high = end_of(plane, nodes, -1);
    const struct end *ends[] = { &low, &high };
    for (size_t i = 0; i < 2; i++) {
        const struct end *e = ends[i], *other = ends[1 - i];
        double gap = fabs(e->next - e->value);
        double rest = fabs(other->value - e->next);
        bool far = e->value != 0 && rest > 0 && gap > 0.5 * rest &&
                   gap > least_gap(quantity);
        /* A turn is of 0 to 360 or of -180 to 180: no field has both. */
        if (quantity == PEL_CF_DEG) {
            bool beyond =
                e->value > 360.5 || (e->value < 0 && other->value > 180);
            double all = fabs(other->value - e->value);
            far = beyond && gap > (all > 361 ? 5 : 30);
        }
        if (isfinite(gap) && far && e->count >= FEW) {
            *value = e->value;
            *count = e->count;
            return true;
        }
    }
    return false;
}
