/* Streams into the Modbus server and a real scene, without sockets. The first
 * byte chooses: as they are, or cut into PDUs (a length byte before each) that
 * get a right header, to get past it. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "bridges/modbus.h"
#include "scene/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static struct pel_modbus *open_server(void)
{
    struct pel_scene_options scene_options = { .wave_count = 20 };
    struct pel_modbus_options options = pel_modbus_default_options();
    struct pel_scene *scene;
    struct pel_modbus *modbus;
    pel_log_set_level(PEL_LOG_ERROR);
    options.listen = NULL;
    if (pel_scene_create(&scene_options, &scene, NULL) != PEL_OK ||
        pel_modbus_create(&options, scene, &modbus, NULL) != PEL_OK) {
        abort();
    }
    return modbus;
}

/* Every answer must be whole: a header and as many bytes as it says. */
static void check_answers(const uint8_t *answer, long size)
{
    while (size > 0) {
        long length = size >= 9 ? 6 + (answer[4] << 8 | answer[5]) : size + 1;
        if (length > size || answer[2] != 0 || answer[3] != 0) {
            abort();
        }
        answer += length;
        size -= length;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct pel_modbus *modbus;
    static uint8_t answer[1 << 16];
    if (!modbus) {
        modbus = open_server();
    }
    if (size == 0) {
        return 0;
    }
    struct pel_modbus_session *s = pel_modbus_session_open(modbus);
    const uint8_t *p = data + 1, *end = data + size;
    if (data[0] % 2 == 0) {
        /* Answers of 64 KiB at most: 8 bytes in can be 260 out. */
        size_t take = size - 1 < 2000 ? size - 1 : 2000;
        check_answers(
            answer, pel_modbus_session_feed(s, p, take, answer, sizeof answer));
    }
    while (data[0] % 2 == 1 && p < end) {
        size_t length = *p++ % 253 + 1;
        length = length < (size_t)(end - p) ? length : (size_t)(end - p);
        if (length == 0) {
            break;
        }
        uint8_t adu[260] = { 0, 1, 0, 0, 0, (uint8_t)(length + 1), 1 };
        memcpy(adu + 7, p, length);
        check_answers(answer, pel_modbus_session_feed(s, adu, length + 7,
                                                      answer, sizeof answer));
        p += length;
    }
    pel_modbus_session_close(s);
    return 0;
}
