/* Height fields as the reader process hands them over: what is taken must
 * answer everywhere. The first byte puts the magic bytes in front. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "seabed/wire.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void look(const struct pel_seabed *bed)
{
    double width = bed->columns * bed->spacing_m;
    for (int i = -2; i < 12; i++) {
        double h = 0, east = bed->west_m + width * i / 9.7,
               north = bed->south_m + bed->rows * bed->spacing_m * i / 8.3;
        bool known = pel_seabed_height(bed, east, north, &h);
        double drawn = pel_seabed_drawn(bed, east, north, -1);
        if (!isfinite(h) || !isfinite(drawn) || (known && drawn != h) ||
            h < PEL_SEABED_LOWEST || h > PEL_SEABED_HIGHEST) {
            abort();
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const struct pel_seabed *bed = NULL;
    struct pel_fault fault;
    if (size == 0) {
        return 0;
    }
    unsigned char *bytes = malloc(size + 8);
    if (!bytes) {
        abort();
    }
    size_t magic = data[0] % 2 ? 8 : 0;
    memcpy(bytes, PEL_SEABED_WIRE_MAGIC, 8);
    memcpy(bytes + magic, data + 1, size - 1);
    if (pel_seabed_wire_read(bytes, magic + size - 1, &bed, &fault) == PEL_OK) {
        look(bed);
        pel_seabed_unref(bed);
    }
    free(bytes);
    return 0;
}
