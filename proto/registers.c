#include "registers.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const struct pel_register pel_registers[] = {
#define HOLDING(address, type, scale, path, doc)                               \
    { PEL_SPACE_HOLDING,                                                       \
      address,                                                                 \
      PEL_TYPE_##type,                                                         \
      scale,                                                                   \
      PEL_SOURCE_PATH,                                                         \
      path,                                                                    \
      NULL,                                                                    \
      doc },
#define CONTROL(address, type, source, doc)                                    \
    { PEL_SPACE_HOLDING,                                                       \
      address,                                                                 \
      PEL_TYPE_##type,                                                         \
      1,                                                                       \
      PEL_SOURCE_##source,                                                     \
      NULL,                                                                    \
      NULL,                                                                    \
      doc },
#define INPUT(address, type, source, unit, doc)                                \
    { PEL_SPACE_INPUT,                                                         \
      address,                                                                 \
      PEL_TYPE_##type,                                                         \
      1,                                                                       \
      PEL_SOURCE_##source,                                                     \
      NULL,                                                                    \
      unit,                                                                    \
      doc },
#define STATUS(address, type, scale, path, doc)                                \
    { PEL_SPACE_INPUT,                                                         \
      address,                                                                 \
      PEL_TYPE_##type,                                                         \
      scale,                                                                   \
      PEL_SOURCE_PATH,                                                         \
      path,                                                                    \
      NULL,                                                                    \
      doc },
#define DISCRETE(address, source, doc)                                         \
    { PEL_SPACE_DISCRETE,  address, PEL_TYPE_BIT, 1,                           \
      PEL_SOURCE_##source, NULL,    NULL,         doc },
#define COIL(address, source, doc)                                             \
    { PEL_SPACE_COIL,      address, PEL_TYPE_BIT, 1,                           \
      PEL_SOURCE_##source, NULL,    NULL,         doc },
#include "registers.def"
};

const size_t pel_register_count =
    sizeof pel_registers / sizeof pel_registers[0];

size_t pel_register_words(enum pel_register_type type)
{
    switch (type) {
    case PEL_TYPE_BIT:
    case PEL_TYPE_U16:
    case PEL_TYPE_I16:
        return 1;
    case PEL_TYPE_U32:
    case PEL_TYPE_I32:
    case PEL_TYPE_F32:
        return 2;
    case PEL_TYPE_F64:
        break;
    }
    return 4;
}

bool pel_register_writable(const struct pel_register *reg)
{
    return (reg->space == PEL_SPACE_HOLDING || reg->space == PEL_SPACE_COIL) &&
           reg->source != PEL_SOURCE_PROBE_U32 &&
           reg->source != PEL_SOURCE_PROBE_F32;
}

const struct pel_register *pel_register_at(enum pel_register_space space,
                                           unsigned address)
{
    for (size_t i = 0; i < pel_register_count; i++) {
        const struct pel_register *reg = &pel_registers[i];
        if (reg->space == space && address >= reg->address &&
            address < reg->address + pel_register_words(reg->type)) {
            return reg;
        }
    }
    return NULL;
}

/* value as an integer of [low, high], NaN as `none`. */
static uint64_t to_integer(double value, double low, double high, double none)
{
    if (isnan(value)) {
        value = none;
    }
    value = round(value);
    value = value < low ? low : value > high ? high : value;
    return (uint64_t)(int64_t)value;
}

static uint64_t to_bits(enum pel_register_type type, double value)
{
    float single;
    uint32_t bits32;
    uint64_t bits64;
    switch (type) {
    case PEL_TYPE_BIT:
        return value != 0;
    case PEL_TYPE_U16:
        return to_integer(value, 0, UINT16_MAX, UINT16_MAX);
    case PEL_TYPE_I16:
        return to_integer(value, INT16_MIN, INT16_MAX, INT16_MIN);
    case PEL_TYPE_U32:
        return to_integer(value, 0, UINT32_MAX, UINT32_MAX);
    case PEL_TYPE_I32:
        return to_integer(value, INT32_MIN, INT32_MAX, INT32_MIN);
    case PEL_TYPE_F32:
        single = (float)value;
        memcpy(&bits32, &single, sizeof bits32);
        return bits32;
    case PEL_TYPE_F64:
        break;
    }
    memcpy(&bits64, &value, sizeof bits64);
    return bits64;
}

static double from_bits(enum pel_register_type type, uint64_t bits)
{
    float single;
    double value;
    uint32_t bits32 = (uint32_t)bits;
    switch (type) {
    case PEL_TYPE_BIT:
    case PEL_TYPE_U16:
    case PEL_TYPE_U32:
        return (double)bits;
    case PEL_TYPE_I16:
        return (int16_t)(uint16_t)bits;
    case PEL_TYPE_I32:
        return (int32_t)bits32;
    case PEL_TYPE_F32:
        memcpy(&single, &bits32, sizeof single);
        return single;
    case PEL_TYPE_F64:
        break;
    }
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* A single register keeps its order whatever the option: Modbus fixes it. */
static uint16_t swap(uint16_t word, enum pel_modbus_order order, size_t count)
{
    bool swapped = order == PEL_MODBUS_BADC || order == PEL_MODBUS_DCBA;
    return swapped && count > 1 ? (uint16_t)(word << 8 | word >> 8) : word;
}

static size_t place(size_t i, enum pel_modbus_order order, size_t count)
{
    bool reversed = order == PEL_MODBUS_CDAB || order == PEL_MODBUS_DCBA;
    return reversed ? count - 1 - i : i;
}

void pel_register_encode(enum pel_register_type type,
                         enum pel_modbus_order order, double value,
                         uint16_t *words)
{
    size_t count = pel_register_words(type);
    uint64_t bits = to_bits(type, value);
    for (size_t i = 0; i < count; i++) {
        uint16_t word = (uint16_t)(bits >> (16 * (count - 1 - i)));
        words[place(i, order, count)] = swap(word, order, count);
    }
}

double pel_register_decode(enum pel_register_type type,
                           enum pel_modbus_order order, const uint16_t *words)
{
    size_t count = pel_register_words(type);
    uint64_t bits = 0;
    for (size_t i = 0; i < count; i++) {
        bits = bits << 16 | swap(words[place(i, order, count)], order, count);
    }
    return from_bits(type, bits);
}

enum pel_err pel_register_path(const struct pel_register *reg, const char *name,
                               char *out, size_t size, int *view)
{
    const char *bracket = strchr(reg->path, '[');
    const char *rest = bracket ? strchr(bracket, ']') : NULL;
    int length;
    *view = -1;
    if (rest) {
        *view = atoi(bracket + 1);
        length = snprintf(out, size, "%.*s.%s%s", (int)(bracket - reg->path),
                          reg->path, name, rest + 1);
    } else {
        length = snprintf(out, size, "%s", reg->path);
    }
    return length < 0 || (size_t)length >= size ? PEL_ERR_INVALID : PEL_OK;
}
