/* Bytes → frames → Request → JSON, and the patch in it → scene. */
#include <stdint.h>
#include <stdlib.h>

#include "fuzz_scene.h"
#include "message.h"
#include "unpack.h"
#include "wire.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What we write we read. */
static void write_again(const ProtobufCMessage *message)
{
    size_t size, offset, length;
    uint8_t *bytes = pel_wire_pack(message, &size);
    if (pel_wire_next(bytes, size, size, &offset, &length) !=
            PEL_WIRE_MESSAGE ||
        offset + length != size ||
        pel_wire_next(bytes, size - 1, size, &offset, &length) !=
            PEL_WIRE_MORE) {
        abort();
    }
    free(bytes);
}

static void one_request(const uint8_t *data, size_t size)
{
    struct pel_unpack unpack;
    pel_unpack_init(&unpack);
    Pelagos__Request *request =
        pelagos__request__unpack(&unpack.allocator, size, data);
    if (!request) {
        pel_unpack_finish(&unpack);
        return;
    }
    pel_message_forget_unknown(&request->base);
    free(pel_json_from_message(&request->base, false));
    if (request->command_case == PELAGOS__REQUEST__COMMAND_PATCH &&
        request->patch) {
        fuzz_edit(request->patch);
    }
    write_again(&request->base);
    pel_unpack_finish(&unpack);
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
