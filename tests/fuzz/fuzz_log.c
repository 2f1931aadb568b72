/* Command logs: what the reader lets through is applied to a scene. The first
 * byte chooses: as they are, or behind the magic bytes. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz_scene.h"
#include "pelog.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void read_log(const uint8_t *data, size_t size, bool mend)
{
    struct pel_log_reader reader;
    struct pel_fault fault;
    Pelagos__LogEntry *entry;
    if (mend ? pel_log_mend(&reader, data, size, &fault)
             : pel_log_open(&reader, data, size, &fault)) {
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
    /* As it is, without checksums, or as entries that have them. */
    struct pel_log_writer writer;
    uint8_t first[PEL_LOG_BEGIN_SIZE];
    size_t framed_size, at = 0;
    pel_log_begin(&writer, first);
    uint8_t *framed = pel_log_frame(&writer, data + 1, size - 1, &framed_size);
    uint8_t *log = malloc(sizeof first + size + framed_size);
    if (!log) {
        abort();
    }
    if (data[0] % 4 == 1) {
        memcpy(log, PEL_LOG_MAGIC_BEFORE, PEL_LOG_MAGIC_SIZE);
        at = PEL_LOG_MAGIC_SIZE;
    } else if (data[0] % 4 == 3) {
        memcpy(log, first, sizeof first);
        memcpy(log + sizeof first, framed, framed_size);
        at = sizeof first + framed_size;
    }
    memcpy(log + at, data + 1, size - 1);
    read_log(log, at + size - 1, false);
    read_log(log, at + size - 1, true);
    free(framed);
    free(log);
    return 0;
}
