#include "seabed/wire.h"

#include <stdlib.h>
#include <string.h>

void pel_seabed_wire_head(int columns, int rows, double west_m, double south_m,
                          double spacing_m,
                          unsigned char out[PEL_SEABED_WIRE_HEAD])
{
    const uint32_t counts[] = { (uint32_t)columns, (uint32_t)rows };
    const double metres[] = { west_m, south_m, spacing_m };
    memcpy(out, PEL_SEABED_WIRE_MAGIC, 8);
    memcpy(out + 8, counts, 8);
    memcpy(out + 16, metres, 24);
}

enum pel_err pel_seabed_wire_read(const unsigned char *bytes, size_t size,
                                  const struct pel_seabed **out,
                                  struct pel_fault *fault)
{
    uint32_t counts[2];
    double metres[3];
    if (size < PEL_SEABED_WIRE_HEAD ||
        memcmp(bytes, PEL_SEABED_WIRE_MAGIC, 8) != 0) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED, "not a height field");
    }
    memcpy(counts, bytes + 8, 8);
    memcpy(metres, bytes + 16, 24);
    if (counts[0] > PEL_SEABED_MOST || counts[1] > PEL_SEABED_MOST ||
        size - PEL_SEABED_WIRE_HEAD != (size_t)4 * counts[0] * counts[1]) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "%u × %u heights in %zu bytes", counts[0],
                             counts[1], size);
    }
    /* Where the heights begin need not suit floats. */
    float *heights = malloc(size - PEL_SEABED_WIRE_HEAD + 1);
    if (!heights) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    memcpy(heights, bytes + PEL_SEABED_WIRE_HEAD, size - PEL_SEABED_WIRE_HEAD);
    enum pel_err err =
        pel_seabed_create((int)counts[0], (int)counts[1], metres[0], metres[1],
                          metres[2], heights, out, fault);
    free(heights);
    return err;
}
