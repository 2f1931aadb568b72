#include "bridges/console_table.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "path.h"

#define MAX_LINE 512

/* --- the file ------------------------------------------------------------- */

static bool word_of(const char *const *words, size_t count, const char *text,
                    int *out)
{
    for (size_t i = 0; i < count; i++) {
        if (strcmp(words[i], text) == 0) {
            *out = (int)i;
            return true;
        }
    }
    return false;
}

static bool read_finite(const char *text, double *out)
{
    char *end;
    *out = strtod(text, &end);
    return end != text && *end == 0 && isfinite(*out);
}

/* "scale=0.1" and its like. */
static const char *read_setting(struct pel_console_row *row, char *text)
{
    static const char *const orders[] = { "abcd", "cdab", "badc", "dcba" };
    char *equals = strchr(text, '=');
    const struct {
        const char *name;
        double *value;
    } numbers[] = {
        { "scale", &row->scale },       { "offset", &row->offset },
        { "min", &row->minimum },       { "max", &row->maximum },
        { "deadband", &row->deadband }, { "stale", &row->stale },
    };
    int order;
    if (!equals) {
        return "NAME=VALUE is wanted after the path";
    }
    *equals = 0;
    if (strcmp(text, "order") == 0) {
        if (!word_of(orders, 4, equals + 1, &order)) {
            return "order is abcd, cdab, badc or dcba";
        }
        row->order = (enum pel_modbus_order)order;
        return NULL;
    }
    if (strcmp(text, "unit") == 0) {
        char *end;
        unsigned long unit = strtoul(equals + 1, &end, 10);
        row->unit = (int)unit;
        return equals[1] >= '0' && equals[1] <= '9' && *end == 0 && unit <= 255
                   ? NULL
                   : "unit is a whole number within 0 .. 255";
    }
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        if (strcmp(text, numbers[i].name) == 0) {
            row->has_stale |= numbers[i].value == &row->stale;
            return read_finite(equals + 1, numbers[i].value)
                       ? NULL
                       : "a finite number is wanted after =";
        }
    }
    return "known are scale, offset, min, max, deadband, stale, order and unit";
}

static bool is_number(const char *path)
{
    struct pel_path_info info;
    return pel_path_find(path, &info, NULL) == PEL_OK &&
           info.field->label != PROTOBUF_C_LABEL_REPEATED &&
           (info.field->type == PROTOBUF_C_TYPE_DOUBLE ||
            info.field->type == PROTOBUF_C_TYPE_UINT32 ||
            info.field->type == PROTOBUF_C_TYPE_ENUM ||
            info.field->type == PROTOBUF_C_TYPE_BOOL);
}

static const char *check_row(const struct pel_console_row *row)
{
    bool bits =
        row->space == PEL_SPACE_COIL || row->space == PEL_SPACE_DISCRETE;
    if (bits != (row->type == PEL_TYPE_BIT)) {
        return "coils and discrete inputs are of type bit, and only they";
    }
    if (row->address + pel_register_words(row->type) > 65536) {
        return "its registers end at 65535";
    }
    if (row->minimum > row->maximum || row->deadband < 0) {
        return "min is above max, or deadband negative";
    }
    return NULL;
}

static const char *read_row(char *line, enum pel_modbus_order order,
                            struct pel_console_row *row)
{
    static const char *const spaces[] = { "holding", "input", "discrete",
                                          "coil" };
    static const char *const types[] = { "bit", "u16", "i16", "u32",
                                         "i32", "f32", "f64" };
    char *save, *end;
    char *words[4];
    int space, type;
    for (int i = 0; i < 4; i++) {
        words[i] = strtok_r(i == 0 ? line : NULL, " \t\r", &save);
        if (!words[i]) {
            return "SPACE ADDRESS TYPE PATH are wanted";
        }
    }
    if (!word_of(spaces, 4, words[0], &space)) {
        return "the first word is holding, input, discrete or coil";
    }
    unsigned long address = strtoul(words[1], &end, 10);
    if (*words[1] < '0' || *words[1] > '9' || *end != 0 || address > 65535) {
        return "the address is a whole number within 0 .. 65535";
    }
    if (!word_of(types, 7, words[2], &type)) {
        return "the type is bit, u16, i16, u32, i32, f32 or f64";
    }
    if (strlen(words[3]) >= sizeof row->path || !is_number(words[3])) {
        return "the path names no field with a number";
    }
    *row = (struct pel_console_row){
        .space = (enum pel_register_space)space,
        .unit = -1,
        .address = (uint16_t)address,
        .type = (enum pel_register_type)type,
        .order = order,
        .scale = 1,
        .minimum = -INFINITY,
        .maximum = INFINITY,
    };
    strcpy(row->path, words[3]);
    for (char *word; (word = strtok_r(NULL, " \t\r", &save));) {
        const char *why = read_setting(row, word);
        if (why) {
            return why;
        }
    }
    return check_row(row);
}

static bool has_path(const struct pel_console_table *table, const char *path)
{
    for (size_t i = 0; i < table->row_count; i++) {
        if (strcmp(table->rows[i].path, path) == 0) {
            return true;
        }
    }
    return false;
}

static const char *read_line(struct pel_console_table *table, char *line,
                             enum pel_modbus_order order)
{
    line[strcspn(line, "#")] = 0;
    if (line[strspn(line, " \t\r")] == 0) {
        return NULL;
    }
    if (table->row_count == PEL_CONSOLE_MAX_ROWS) {
        return "a table has at most 256 rows";
    }
    struct pel_console_row row;
    const char *why = read_row(line, order, &row);
    if (!why && has_path(table, row.path)) {
        why = "this path is set by an earlier row";
    }
    if (!why) {
        table->rows[table->row_count++] = row;
    }
    return why;
}

static int by_place(const void *a, const void *b)
{
    const struct pel_console_row *x = a, *y = b;
    int space = (int)x->space - (int)y->space;
    if (x->unit != y->unit) {
        return x->unit - y->unit;
    }
    return space != 0 ? space : (int)x->address - (int)y->address;
}

/* Neighbours are read together; gaps are not read, as a console may refuse an
 * address that it does not have. */
static void group_rows(struct pel_console_table *table)
{
    for (size_t i = 0; i < table->row_count; i++) {
        const struct pel_console_row *row = &table->rows[i];
        struct pel_console_group *last =
            table->group_count > 0 ? &table->groups[table->group_count - 1]
                                   : NULL;
        unsigned end = row->address + (unsigned)pel_register_words(row->type);
        unsigned most = row->type == PEL_TYPE_BIT ? PEL_CONSOLE_MAX_BITS
                                                  : PEL_CONSOLE_MAX_WORDS;
        bool joins = last && last->space == row->space &&
                     last->unit == row->unit &&
                     row->address <= last->address + last->words &&
                     end - last->address <= most;
        if (!joins) {
            last = &table->groups[table->group_count++];
            *last = (struct pel_console_group){ .space = row->space,
                                                .unit = row->unit,
                                                .address = row->address,
                                                .first = i };
        }
        unsigned words = end - last->address;
        last->words = words > last->words ? words : last->words;
        last->count++;
    }
}

enum pel_err pel_console_table_read(const char *text, size_t size,
                                    enum pel_modbus_order order,
                                    struct pel_console_table *out,
                                    struct pel_fault *fault)
{
    const char *end = text + size;
    *out = (struct pel_console_table){ 0 };
    for (int number = 1; text < end; number++) {
        char line[MAX_LINE];
        const char *stop = memchr(text, '\n', (size_t)(end - text));
        stop = stop ? stop : end;
        size_t length = (size_t)(stop - text);
        const char *why = "longer than 511 characters";
        if (length < sizeof line) {
            memcpy(line, text, length);
            line[length] = 0;
            why = strlen(line) == length ? read_line(out, line, order)
                                         : "not a line of text";
        }
        if (why) {
            return pel_fault_set(fault, PEL_ERR_INVALID, "line %d: %s", number,
                                 why);
        }
        text = stop + 1;
    }
    if (out->row_count == 0) {
        return pel_fault_set(fault, PEL_ERR_INVALID, "the table has no row");
    }
    qsort(out->rows, out->row_count, sizeof *out->rows, by_place);
    group_rows(out);
    return PEL_OK;
}

/* --- the wire ------------------------------------------------------------- */

static uint8_t function_of(enum pel_register_space space)
{
    switch (space) {
    case PEL_SPACE_COIL:
        return 1;
    case PEL_SPACE_DISCRETE:
        return 2;
    case PEL_SPACE_HOLDING:
        return 3;
    case PEL_SPACE_INPUT:
        break;
    }
    return 4;
}

static bool is_bits(const struct pel_console_group *group)
{
    return group->space == PEL_SPACE_COIL || group->space == PEL_SPACE_DISCRETE;
}

static void put16(uint8_t *at, unsigned value)
{
    at[0] = (uint8_t)(value >> 8);
    at[1] = (uint8_t)value;
}

static unsigned get16(const uint8_t *at)
{
    return (unsigned)at[0] << 8 | at[1];
}

size_t pel_console_request(const struct pel_console_group *group,
                           uint16_t transaction, uint8_t unit, uint8_t adu[12])
{
    put16(adu, transaction);
    put16(adu + 2, 0);
    put16(adu + 4, 6);
    adu[6] = unit;
    adu[7] = function_of(group->space);
    put16(adu + 8, group->address);
    put16(adu + 10, group->words);
    return 12;
}

enum pel_console_answer
pel_console_answer(const struct pel_console_group *group, uint16_t transaction,
                   uint8_t unit, const uint8_t *bytes, size_t size,
                   uint16_t *words, unsigned *code)
{
    uint8_t function = function_of(group->space);
    size_t data = is_bits(group) ? (group->words + 7) / 8 : 2 * group->words;
    if (size < 9) {
        return PEL_CONSOLE_MORE;
    }
    bool refused = bytes[7] == (function | 0x80);
    size_t length = refused ? 3 : 3 + data;
    if (get16(bytes) != transaction || get16(bytes + 2) != 0 ||
        get16(bytes + 4) != length || bytes[6] != unit ||
        (!refused && (bytes[7] != function || bytes[8] != data)) ||
        size > 6 + length) {
        return PEL_CONSOLE_WRONG;
    }
    if (refused) {
        *code = bytes[8];
        return PEL_CONSOLE_EXCEPTION;
    }
    if (size < 6 + length) {
        return PEL_CONSOLE_MORE;
    }
    for (unsigned i = 0; i < group->words; i++) {
        words[i] = is_bits(group) ? (uint16_t)(bytes[9 + i / 8] >> (i % 8) & 1)
                                  : (uint16_t)get16(bytes + 9 + 2 * (size_t)i);
    }
    return PEL_CONSOLE_VALUES;
}

double pel_console_value(const struct pel_console_row *row,
                         const uint16_t *words)
{
    double value = pel_register_decode(row->type, row->order, words);
    value = value * row->scale + row->offset;
    return isfinite(value) ? pel_clamp(value, row->minimum, row->maximum) : NAN;
}
