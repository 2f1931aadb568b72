/* Bytes → merge patch, and what was read → JSON. */
#include <stdint.h>
#include <stdlib.h>

#include "json.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    Pelagos__Patch *patch;
    struct pel_fault fault;
    if (pel_json_merge_patch((const char *)data, size, &patch, &fault) ==
        PEL_OK) {
        free(pel_json_from_message(&patch->base, true));
        pelagos__patch__free_unpacked(patch, NULL);
    }
    return 0;
}
