/* The Modbus register table of registers.def, and the numbers of its
 * registers. Constant data and pure functions: any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"

#define PEL_PROBE_U32 0x01020304u
#define PEL_PROBE_F32 3.5

/* Registers of each space that can be read, from address 0. */
#define PEL_HOLDING_COUNT 240
#define PEL_INPUT_COUNT 60
#define PEL_DISCRETE_COUNT 7
#define PEL_COIL_COUNT 2

/* Order of a 32-bit value's bytes on the wire, A the most significant; of a
 * 64-bit value's alike. */
enum pel_modbus_order {
    PEL_MODBUS_ABCD, /* most significant register first */
    PEL_MODBUS_CDAB, /* least significant register first */
    PEL_MODBUS_BADC, /* as ABCD, bytes swapped in each register */
    PEL_MODBUS_DCBA, /* as CDAB, bytes swapped in each register */
};

enum pel_register_space {
    PEL_SPACE_HOLDING,
    PEL_SPACE_INPUT,
    PEL_SPACE_DISCRETE,
    PEL_SPACE_COIL,
};

enum pel_register_type {
    PEL_TYPE_BIT,
    PEL_TYPE_U16,
    PEL_TYPE_I16,
    PEL_TYPE_U32,
    PEL_TYPE_I32,
    PEL_TYPE_F32,
    PEL_TYPE_F64,
};

/* What stands behind a register. */
enum pel_register_source {
    PEL_SOURCE_PATH, /* the schema's field */
    PEL_SOURCE_PROBE_U32,
    PEL_SOURCE_PROBE_F32,
    PEL_SOURCE_HEARTBEAT,
    PEL_SOURCE_COMMIT,
    PEL_SOURCE_SUN_FROM_CLOCK,
    PEL_SOURCE_REVISION,
    PEL_SOURCE_FRAME,
    PEL_SOURCE_TIME,
    PEL_SOURCE_FPS,
    PEL_SOURCE_RENDER_MS,
    PEL_SOURCE_SOURCE,
    PEL_SOURCE_CLIENTS,
    PEL_SOURCE_HEARTBEAT_AGE,
    PEL_SOURCE_COMMITS,
    PEL_SOURCE_REFUSED,
    PEL_SOURCE_MALFORMED,
    PEL_SOURCE_NMEA_SENTENCES,
    PEL_SOURCE_NMEA_ERRORS,
    PEL_SOURCE_SHIP_LATITUDE,
    PEL_SOURCE_SHIP_LONGITUDE,
    PEL_SOURCE_SHIP_HEADING,
    PEL_SOURCE_SUN_AZIMUTH,
    PEL_SOURCE_SUN_ELEVATION,
    PEL_SOURCE_ALARM,
    PEL_SOURCE_ALARM_SOURCE,
    PEL_SOURCE_ALARM_NMEA,
    PEL_SOURCE_ALARM_FRAMES,
    PEL_SOURCE_ALARM_CIGI,
    PEL_SOURCE_ALARM_CONSOLE,
    PEL_SOURCE_STAGED,
    PEL_SOURCE_EXERCISE_TO,
    PEL_SOURCE_EXERCISE_CHOICE,
    PEL_SOURCE_EXERCISE_ACTION,
    PEL_SOURCE_EXERCISE,
    PEL_SOURCE_EXERCISE_TIME,
    PEL_SOURCE_EXERCISE_FIRED,
    PEL_SOURCE_EXERCISE_EVENTS,
    PEL_SOURCE_EXERCISES,
    PEL_SOURCE_EXERCISE_FACTS,
    PEL_SOURCE_EXERCISE_GROUNDINGS,
    PEL_SOURCE_EXERCISE_COLLISIONS,
};

struct pel_register {
    enum pel_register_space space;
    uint16_t address; /* of its first register, from 0 */
    enum pel_register_type type;
    double scale; /* field = register times scale */
    enum pel_register_source source;
    const char *path; /* PATH: `views[2].yaw` is the third view's yaw */
    const char *unit; /* INPUT; fields have the schema's */
    const char *doc;
};

/* Sorted by space, then address. */
extern const struct pel_register pel_registers[];
extern const size_t pel_register_count;

/* Registers a value takes: 1, 2 or 4. */
size_t pel_register_words(enum pel_register_type type);

/* Whether clients may write it. */
bool pel_register_writable(const struct pel_register *reg);

/* The row that holds `address`, or NULL: reserved. */
const struct pel_register *pel_register_at(enum pel_register_space space,
                                           unsigned address);

/* A number to registers and back. Encoding rounds to the nearest the type can
 * hold and saturates; NaN is NaN in a float, the least value (signed) or the
 * greatest (unsigned) of an integer. */
void pel_register_encode(enum pel_register_type type,
                         enum pel_modbus_order order, double value,
                         uint16_t *words);
double pel_register_decode(enum pel_register_type type,
                           enum pel_modbus_order order, const uint16_t *words);

/* The schema's path with `name` in the place of `[n]`; *view is n, or -1 for
 * a path without. INVALID: it does not fit. */
PEL_CHECK enum pel_err pel_register_path(const struct pel_register *reg,
                                         const char *name, char *out,
                                         size_t size, int *view);
