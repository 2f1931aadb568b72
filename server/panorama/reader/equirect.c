#include "panorama/reader/equirect.h"

#include <math.h>
#include <stdlib.h>

#include "panorama/panorama.h"

enum pel_err pel_equirect_begin(struct pel_equirect *e, int columns, int rows,
                                struct pel_fault *fault)
{
    if (columns < PEL_PANORAMA_LEAST_COLUMNS ||
        columns > PEL_EQUIRECT_MOST_COLUMNS || columns != 2 * rows) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%d × %d pixels; a panorama is twice as wide as "
                             "high, %d to %d pixels",
                             columns, rows, PEL_PANORAMA_LEAST_COLUMNS,
                             PEL_EQUIRECT_MOST_COLUMNS);
    }
    *e = (struct pel_equirect){ .file_columns = columns,
                                .file_rows = rows,
                                .shrink = 1 };
    while (columns / e->shrink > PEL_PANORAMA_MOST_COLUMNS) {
        e->shrink *= 2;
    }
    /* What is left over at the right and below is less than a texel. */
    e->rows = rows / e->shrink;
    e->columns = 2 * e->rows;
    e->values =
        calloc(3 * (size_t)e->columns * (size_t)e->rows, sizeof *e->values);
    return e->values ? PEL_OK
                     : pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
}

void pel_equirect_add(struct pel_equirect *e, int row, const float *rgb)
{
    int to = row / e->shrink;
    if (to >= e->rows) {
        return;
    }
    float share = 1.0f / (float)(e->shrink * e->shrink);
    float *line = e->values + 3 * (size_t)to * (size_t)e->columns;
    for (int x = 0; x < e->columns * e->shrink; x++) {
        for (int i = 0; i < 3; i++) {
            float v = rgb[3 * x + i];
            if (v > 0 && isfinite(v)) {
                line[3 * (x / e->shrink) + i] += v * share;
            }
        }
    }
}
