/* The Modbus client's two inputs: a table (first byte even), or bytes that a
 * console answers with (odd). */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "bridges/console_table.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static struct pel_console_table table;

static void read_answers(const uint8_t *data, size_t size)
{
    static const char text[] = "holding 5 f32 sea.windSpeed\n"
                               "holding 7 i16 sea.fetch\n"
                               "coil 3 bit sea.gamma\n"
                               "coil 4 bit entities.1.heading\n";
    uint16_t words[PEL_CONSOLE_MAX_BITS];
    unsigned code;
    if (pel_console_table_read(text, sizeof text - 1, PEL_MODBUS_ABCD, &table,
                               NULL)) {
        abort();
    }
    uint8_t *exact = malloc(size > 0 ? size : 1);
    if (!exact) {
        abort();
    }
    memcpy(exact, data, size);
    for (size_t g = 0; g < table.group_count; g++) {
        const struct pel_console_group *group = &table.groups[g];
        uint8_t question[12];
        (void)pel_console_request(group, 1, 1, question);
        if (pel_console_answer(group, 1, 1, exact, size, words, &code) !=
            PEL_CONSOLE_VALUES) {
            continue;
        }
        for (size_t i = group->first; i < group->first + group->count; i++) {
            const struct pel_console_row *row = &table.rows[i];
            double value =
                pel_console_value(row, words + (row->address - group->address));
            if (isinf(value)) {
                abort();
            }
        }
    }
    free(exact);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0) {
        return 0;
    }
    if (data[0] % 2) {
        read_answers(data + 1, size - 1);
        return 0;
    }
    if (pel_console_table_read((const char *)data + 1, size - 1,
                               PEL_MODBUS_ABCD, &table, NULL) == PEL_OK) {
        for (size_t i = 0; i < table.group_count; i++) {
            const struct pel_console_group *g = &table.groups[i];
            if (g->words == 0 || g->words > PEL_CONSOLE_MAX_BITS ||
                g->address + g->words > 65536 ||
                g->first + g->count > table.row_count) {
                abort();
            }
        }
    }
    return 0;
}
