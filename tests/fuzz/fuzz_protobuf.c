/* Bytes → frames → Request → JSON, and the patch in it → scene. */
#include <stdint.h>
#include <stdlib.h>

#include "fuzz_scene.h"
#include "message.h"
#include "unpack.h"
#include "wire.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void one_request(const uint8_t *data, size_t size)
{
    static struct pel_unpack unpack;
    if (!unpack.allocator.alloc) {
        pel_unpack_init(&unpack);
    }
    Pelagos__Request *request =
        pelagos__request__unpack(&unpack.allocator, size, data);
    if (!request) {
        pel_unpack_reset(&unpack);
        return;
    }
    pel_message_forget_unknown(&request->base);
    free(pel_json_from_message(&request->base, false));
    if (request->command_case == PELAGOS__REQUEST__COMMAND_PATCH &&
        request->patch) {
        fuzz_edit(request->patch);
    }
    pel_unpack_reset(&unpack);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    size_t offset, length;
    while (pel_wire_next(data, size, PEL_WIRE_MAX_REQUEST, &offset, &length) ==
           PEL_WIRE_MESSAGE) {
        one_request(data + offset, length);
        data += offset + length;
        size -= offset + length;
    }
    return 0;
}
