#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "frames/window.h"

void pel_window_add(struct pel_window *window, double value)
{
    window->values[window->count++ % PEL_STATS_WINDOW] = (float)value;
}

static int compare(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

double pel_window_rank(const struct pel_window *window, double share)
{
    float sorted[PEL_STATS_WINDOW];
    size_t count = window->count < PEL_STATS_WINDOW ? (size_t)window->count
                                                    : PEL_STATS_WINDOW;
    if (count == 0) {
        return 0;
    }
    memcpy(sorted, window->values, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, compare);
    size_t rank = (size_t)ceil(share * (double)count);
    return sorted[rank > 0 ? rank - 1 : 0];
}
