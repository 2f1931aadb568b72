/* The table of a console: which of its registers are read, and which fields of
 * the scene they set. proto/modbus_client.md describes the file. Pure
 * functions, any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "registers.h"

#define PEL_CONSOLE_MAX_ROWS 256
#define PEL_CONSOLE_MAX_FILE 65536 /* bytes */
#define PEL_CONSOLE_MAX_WORDS 125  /* registers of one request */
#define PEL_CONSOLE_MAX_BITS 2000  /* coils or discrete inputs of one */

struct pel_console_row {
    enum pel_register_space space;
    int unit;         /* that is asked; -1: the console's own */
    uint16_t address; /* of its first register, from 0 */
    enum pel_register_type type;
    enum pel_modbus_order order;
    char path[96];
    double scale, offset;    /* field = register * scale + offset */
    double minimum, maximum; /* the field is held within these */
    double deadband;         /* smaller changes of the field are left out */
    bool has_stale;
    double stale; /* field while the console is silent */
};

/* Registers that one request reads: rows first .. first + count - 1. */
struct pel_console_group {
    enum pel_register_space space;
    int unit;
    uint16_t address;
    unsigned words; /* registers, or bits */
    size_t first, count;
};

struct pel_console_table {
    size_t row_count, group_count;
    struct pel_console_row
        rows[PEL_CONSOLE_MAX_ROWS]; /* by unit, space, address */
    struct pel_console_group groups[PEL_CONSOLE_MAX_ROWS];
};

/* Reads the text of a table; `order` for rows that name none. INVALID names the
 * line: not a row, registers beyond 65535, two rows for one path, a path that
 * is no field with a number, more than PEL_CONSOLE_MAX_ROWS rows, no row. */
PEL_CHECK enum pel_err pel_console_table_read(const char *text, size_t size,
                                              enum pel_modbus_order order,
                                              struct pel_console_table *out,
                                              struct pel_fault *fault);

/* The request for a group: 12 bytes of ADU. */
size_t pel_console_request(const struct pel_console_group *group,
                           uint16_t transaction, uint8_t unit, uint8_t adu[12]);

enum pel_console_answer {
    PEL_CONSOLE_MORE, /* not whole yet */
    PEL_CONSOLE_VALUES,
    PEL_CONSOLE_EXCEPTION, /* the console refused: *code */
    PEL_CONSOLE_WRONG,     /* not the answer to this request: close */
};

/* Looks at the bytes that have come since the request. VALUES: `words` holds
 * group->words registers or bits (0, 1). */
enum pel_console_answer
pel_console_answer(const struct pel_console_group *group, uint16_t transaction,
                   uint8_t unit, const uint8_t *bytes, size_t size,
                   uint16_t *words, unsigned *code);

/* The field's value of a row whose registers are words[0..]; NaN where a float
 * register holds none. */
double pel_console_value(const struct pel_console_row *row,
                         const uint16_t *words);
