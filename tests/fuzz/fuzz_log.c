/* Command logs: what the reader lets through is applied to a scene. The first
 * byte chooses: as they are, or behind the magic bytes. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz_scene.h"
#include "pelog.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void read_log(const uint8_t *data, size_t size)
{
    struct pel_log_reader reader;
    struct pel_fault fault;
    Pelagos__LogEntry *entry;
    if (pel_log_open(&reader, data, size, &fault)) {
        return;
    }
    while (pel_log_next(&reader, &entry, &fault) == PEL_OK && entry) {
        if (!(entry->time >= 0 && entry->time <= 1e9)) {
            abort();
        }
        if (entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_PATCH) {
            fuzz_edit(entry->patch);
        }
        pelagos__log_entry__free_unpacked(entry, NULL);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0) {
        return 0;
    }
    uint8_t *log = malloc(size + PEL_LOG_MAGIC_SIZE);
    if (!log) {
        abort();
    }
    size_t magic = data[0] % 2 ? PEL_LOG_MAGIC_SIZE : 0;
    memcpy(log, PEL_LOG_MAGIC, PEL_LOG_MAGIC_SIZE);
    memcpy(log + magic, data + 1, size - 1);
    read_log(log, magic + size - 1);
    free(log);
    return 0;
}
