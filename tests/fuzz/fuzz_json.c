/* Bytes → merge patch → scene; and the patch, as JSON, back again. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz_scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    Pelagos__Patch *patch;
    ProtobufCMessage *again;
    struct pel_fault fault;
    if (pel_json_merge_patch((const char *)data, size, &patch, &fault)) {
        return 0;
    }
    char *text = pel_json_from_message(&patch->base, true);
    if (pel_json_to_message(text, strlen(text), &pelagos__patch__descriptor,
                            &again, &fault)) {
        abort(); /* what we write we read */
    }
    protobuf_c_message_free_unpacked(again, NULL);
    free(text);
    fuzz_edit(patch);
    pelagos__patch__free_unpacked(patch, NULL);
    return 0;
}
