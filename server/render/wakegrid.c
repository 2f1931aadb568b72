#include "render/wakegrid.h"

#include <math.h>

#include "base/vec.h"

_Static_assert(PEL_WAKE_LAYERS <= 24, "bits of a float's whole numbers");

/* What rounding may take a place off its cell, of the grid's side. */
#define SLACK 1e-3

static int cell_of(double at, double low, double per_m)
{
    return (int)pel_clamp((at - low) * per_m, 0, PEL_WAKE_CELLS - 1);
}

void pel_wake_grid_fill(size_t layers, struct pel_block_wakes *out)
{
    double low[2] = { HUGE_VAL, HUGE_VAL }, high[2] = { -HUGE_VAL, -HUGE_VAL };
    for (size_t i = 0; i < layers; i++) {
        const struct pel_vec4 *p = &out->wakes[i].place;
        double at[2] = { (double)p->x, (double)p->y };
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], at[k] - PEL_WAKE_FADED * (double)p->w);
            high[k] = fmax(high[k], at[k] + PEL_WAKE_FADED * (double)p->w);
        }
    }
    double slack[2], per_m[2];
    for (int k = 0; k < 2 && layers > 0; k++) {
        slack[k] = SLACK * (high[k] - low[k]);
        low[k] -= slack[k];
        per_m[k] = PEL_WAKE_CELLS / (high[k] + slack[k] - low[k]);
    }
    for (size_t i = 0; i < layers; i++) {
        const struct pel_vec4 *p = &out->wakes[i].place;
        double x = (double)p->x, y = (double)p->y;
        double rx = PEL_WAKE_FADED * (double)p->w + slack[0];
        double ry = PEL_WAKE_FADED * (double)p->w + slack[1];
        int east = cell_of(x + rx, low[0], per_m[0]);
        int north = cell_of(y + ry, low[1], per_m[1]);
        for (int row = cell_of(y - ry, low[1], per_m[1]); row <= north; row++) {
            for (int column = cell_of(x - rx, low[0], per_m[0]); column <= east;
                 column++) {
                int cell = row * PEL_WAKE_CELLS + column;
                (&out->wake_cells[cell / 4].x)[cell % 4] += (float)(1u << i);
            }
        }
    }
    if (layers > 0) {
        out->wake_grid = (struct pel_vec4){ (float)low[0], (float)low[1],
                                            (float)per_m[0], (float)per_m[1] };
    }
}
