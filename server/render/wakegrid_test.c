/* A tile is in the mask of every place that it reaches, by the shader's own
 * arithmetic in single precision. */
#include "render/wakegrid.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static uint32_t seed = 1;

static double any(double low, double high)
{
    seed = seed * 1664525u + 1013904223u;
    return low + (high - low) * (seed >> 8) / 16777216.0;
}

static unsigned near(const struct pel_block_wakes *b, float x, float y)
{
    float u = (x - b->wake_grid.x) * b->wake_grid.z;
    float v = (y - b->wake_grid.y) * b->wake_grid.w;
    if (!(u >= 0 && v >= 0 && u < PEL_WAKE_CELLS && v < PEL_WAKE_CELLS)) {
        return 0;
    }
    int cell = (int)v * PEL_WAKE_CELLS + (int)u;
    return (unsigned)(&b->wake_cells[cell / 4].x)[cell % 4];
}

static bool reaches(const struct pel_vec4 *p, float x, float y)
{
    return fmaxf(fabsf(x - p->x), fabsf(y - p->y)) <
           (float)PEL_WAKE_FADED * p->w;
}

static void every_tile_is_found(void **state)
{
    (void)state;
    for (int round = 0; round < 200; round++) {
        static struct pel_block_wakes b;
        int layers = 1 + (int)any(0, PEL_WAKE_LAYERS - 0.01);
        assert_true(layers > 0);
        double spread = exp(any(3, 11)), asked = 0, needed = 0;
        memset(&b, 0, sizeof b);
        for (int i = 0; i < layers; i++) {
            b.wakes[i].place =
                (struct pel_vec4){ (float)any(-spread, spread),
                                   (float)any(-spread, spread), 1,
                                   (float)exp(any(5.5, 8.5)) };
        }
        pel_wake_grid_fill(layers, &b);
        for (int n = 0; n < 4000; n++) {
            const struct pel_vec4 *p = &b.wakes[n % layers].place;
            double r = 0.5 * (double)p->w;
            float x = (float)((double)p->x + any(-r, r));
            float y = (float)((double)p->y + any(-r, r));
            unsigned bits = near(&b, x, y);
            for (int i = 0; i < layers; i++) {
                bool reached = reaches(&b.wakes[i].place, x, y);
                assert_true(!reached || bits >> i & 1);
                asked += bits >> i & 1;
                needed += reached;
            }
        }
        assert_true(asked < 3 * needed); /* small ones are in few cells */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_tile_is_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
