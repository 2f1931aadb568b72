/* Reports of the weather: read, never beyond their end. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "scene/metar.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct pel_metar m;
    char *text = malloc(size + 1);
    memcpy(text, data, size);
    text[size] = 0;
    if (pel_metar_parse(text, &m, NULL) == PEL_OK &&
        (m.wind_mps < 0 || m.visibility_m < 0 || m.octas < 0 || m.octas > 8)) {
        abort();
    }
    free(text);
    return 0;
}
