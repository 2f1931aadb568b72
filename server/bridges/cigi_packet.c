#include "bridges/cigi_packet.h"

#include <math.h>
#include <string.h>

const struct pel_cigi_row pel_cigi_rows[PEL_CIGI_FIELD_COUNT] = {
#define CIGI_PACKET(name, id, size, from, text)                                \
    { PEL_CIGI_HEAD, 0, 0, 0, text, "", PEL_CIGI_HONOURED, "" },
#define CIGI_FIELD(packet, name, type, offset, shift, bits, text, unit, grade,   \
                   note)                                                         \
    {                                                                            \
        PEL_CIGI_##type, offset, shift, bits, text, unit, PEL_CIGI_##grade, note \
    },
#include "bridges/cigi_fields.def"
#undef CIGI_PACKET
#undef CIGI_FIELD
};

#define HOST true
#define IG false
const struct pel_cigi_info pel_cigi_packets[PEL_CIGI_KIND_COUNT] = {
#define CIGI_PACKET(name, id, size, from, text)                                \
    { text, id, size, from, PEL_CIGI_##name },
#define CIGI_FIELD(...)
#include "bridges/cigi_fields.def"
#undef CIGI_PACKET
#undef CIGI_FIELD
};

/* Kind + 1 of an id, 0: not in the table. */
static const uint8_t kind_by_id[256] = {
#define CIGI_PACKET(name, id, size, from, text) [id] = PEL_CIGI_KIND_##name + 1,
#define CIGI_FIELD(...)
#include "bridges/cigi_fields.def"
#undef CIGI_PACKET
#undef CIGI_FIELD
};

static enum pel_cigi_kind kind_of(uint8_t id)
{
    return kind_by_id[id] ? (enum pel_cigi_kind)(kind_by_id[id] - 1)
                          : PEL_CIGI_KIND_COUNT;
}

const char *pel_cigi_error_name(enum pel_cigi_error error)
{
    static const char *const names[PEL_CIGI_ERROR_COUNT] = {
        "good", "short", "first", "version", "order", "size", "number"
    };
    return names[error];
}

struct pel_cigi_packet pel_cigi_packet_of(enum pel_cigi_kind kind)
{
    return (struct pel_cigi_packet){ .kind = kind,
                                     .id = pel_cigi_packets[kind].id };
}

/* --- numbers ------------------------------------------------------------- */

static uint64_t load(const uint8_t *at, size_t size, bool little)
{
    uint64_t value = 0;
    for (size_t i = 0; i < size; i++) {
        value = value << 8 | at[little ? size - 1 - i : i];
    }
    return value;
}

static void store(uint64_t value, uint8_t *at, size_t size, bool little)
{
    for (size_t i = 0; i < size; i++) {
        at[little ? i : size - 1 - i] = (uint8_t)(value >> 8 * i);
    }
}

static double load_field(const struct pel_cigi_row *row, const uint8_t *packet,
                         bool little)
{
    const uint8_t *at = packet + row->offset;
    uint64_t whole;
    uint32_t half;
    float f32;
    double f64;
    switch (row->type) {
    case PEL_CIGI_U8:
        return at[0];
    case PEL_CIGI_I8:
        return (int8_t)at[0];
    case PEL_CIGI_U16:
        return (double)load(at, 2, little);
    case PEL_CIGI_U32:
        return (double)load(at, 4, little);
    case PEL_CIGI_F32:
        half = (uint32_t)load(at, 4, little);
        memcpy(&f32, &half, sizeof f32);
        return f32;
    case PEL_CIGI_F64:
        whole = load(at, 8, little);
        memcpy(&f64, &whole, sizeof f64);
        return f64;
    case PEL_CIGI_BITS:
        return (at[0] >> row->shift) & ((1u << row->bits) - 1);
    case PEL_CIGI_HEAD:
        break;
    }
    return 0;
}

/* Nearest integer within the limits; NaN is the lower one. */
static uint64_t whole_within(double value, double low, double high)
{
    double kept = value > low ? fmin(value, high) : low;
    return (uint64_t)(int64_t)llrint(kept);
}

static void store_field(const struct pel_cigi_row *row, double value,
                        uint8_t *packet, bool little)
{
    uint8_t *at = packet + row->offset;
    uint64_t whole;
    uint32_t half;
    float f32;
    double most;
    switch (row->type) {
    case PEL_CIGI_U8:
        at[0] = (uint8_t)whole_within(value, 0, UINT8_MAX);
        break;
    case PEL_CIGI_I8:
        at[0] = (uint8_t)whole_within(value, INT8_MIN, INT8_MAX);
        break;
    case PEL_CIGI_U16:
        store(whole_within(value, 0, UINT16_MAX), at, 2, little);
        break;
    case PEL_CIGI_U32:
        store(whole_within(value, 0, UINT32_MAX), at, 4, little);
        break;
    case PEL_CIGI_F32:
        f32 = (float)value;
        memcpy(&half, &f32, sizeof half);
        store(half, at, 4, little);
        break;
    case PEL_CIGI_F64:
        memcpy(&whole, &value, sizeof whole);
        store(whole, at, 8, little);
        break;
    case PEL_CIGI_BITS:
        most = (1u << row->bits) - 1;
        at[0] |= (uint8_t)(whole_within(value, 0, most) << row->shift);
        break;
    case PEL_CIGI_HEAD:
        break;
    }
}

/* --- datagrams ----------------------------------------------------------- */

static bool finite_fields(const struct pel_cigi_info *info,
                          const uint8_t *packet, bool little)
{
    for (size_t f = info->first + 1u;
         f < PEL_CIGI_FIELD_COUNT && pel_cigi_rows[f].type != PEL_CIGI_HEAD;
         f++) {
        const struct pel_cigi_row *row = &pel_cigi_rows[f];
        if (row->grade != PEL_CIGI_IGNORED &&
            !isfinite(load_field(row, packet, little))) {
            return false;
        }
    }
    return true;
}

static enum pel_cigi_error test_packet(const uint8_t *at, size_t left,
                                       bool little)
{
    if (left < 8 || at[1] < 8 || at[1] % 8 != 0 || at[1] > left) {
        return PEL_CIGI_SIZE;
    }
    enum pel_cigi_kind kind = kind_of(at[0]);
    if (kind == PEL_CIGI_KIND_COUNT) {
        return PEL_CIGI_GOOD;
    }
    if (at[1] < pel_cigi_packets[kind].size) {
        return PEL_CIGI_SIZE;
    }
    return finite_fields(&pel_cigi_packets[kind], at, little) ? PEL_CIGI_GOOD
                                                              : PEL_CIGI_NUMBER;
}

static enum pel_cigi_error test_head(const uint8_t *bytes, size_t size,
                                     enum pel_cigi_kind first, bool *little)
{
    const struct pel_cigi_info *info = &pel_cigi_packets[first];
    if (size < info->size) {
        return PEL_CIGI_SHORT;
    }
    if (bytes[0] != info->id) {
        return PEL_CIGI_FIRST;
    }
    unsigned minor =
        bytes[first == PEL_CIGI_KIND_IG_CONTROL ? 4 : 5] >> 4; /* b4-7 */
    if (bytes[2] != 3 || (minor != 2 && minor != 3)) {
        return PEL_CIGI_VERSION;
    }
    bool is_big = bytes[6] == 0x80 && bytes[7] == 0;
    *little = bytes[6] == 0 && bytes[7] == 0x80;
    return is_big || *little ? PEL_CIGI_GOOD : PEL_CIGI_ORDER;
}

enum pel_cigi_error pel_cigi_open(const uint8_t *bytes, size_t size,
                                  enum pel_cigi_kind first,
                                  struct pel_cigi_reader *out)
{
    bool little = false;
    enum pel_cigi_error error = test_head(bytes, size, first, &little);
    for (size_t at = 0; at < size && !error; at += bytes[at + 1]) {
        error = test_packet(bytes + at, size - at, little);
        if (!error && at > 0 && bytes[at] == pel_cigi_packets[first].id) {
            error = PEL_CIGI_FIRST;
        }
        if (error) {
            break;
        }
    }
    *out =
        (struct pel_cigi_reader){ bytes, bytes + (error ? 0 : size), little };
    return error;
}

bool pel_cigi_foreign(const uint8_t *bytes, size_t size, unsigned *major,
                      unsigned *minor)
{
    *major = *minor = 0;
    if (size >= 24 && bytes[0] == 1 && bytes[1] == 24 && bytes[2] == 3) {
        *major = 3;
        *minor = bytes[4] >> 4;
    } else if (size >= 16 && bytes[0] == 1 && bytes[1] == 16 &&
               (bytes[2] == 1 || bytes[2] == 2 || bytes[2] == 3)) {
        /* IG Control of 1 and 2 has 16 bytes, and of 3.0 and 3.1 too */
        *major = bytes[2];
    } else if (size >= 24 &&
               ((bytes[0] == 24 && bytes[1] == 0) ||
                (bytes[0] == 0 && bytes[1] == 24)) &&
               bytes[4] == 4) {
        *major = 4; /* size and packet id are 16 bits each: 24, 0 */
        *minor = bytes[7] >> 4;
    }
    return *major != 0 && !(*major == 3 && (*minor == 2 || *minor == 3));
}

bool pel_cigi_next(struct pel_cigi_reader *reader, struct pel_cigi_packet *out)
{
    if (reader->at >= reader->end) {
        return false;
    }
    const uint8_t *at = reader->at;
    reader->at += at[1];
    out->kind = kind_of(at[0]);
    out->id = at[0];
    if (out->kind == PEL_CIGI_KIND_COUNT) {
        return true;
    }
    size_t first = pel_cigi_packets[out->kind].first;
    for (size_t f = first + 1;
         f < PEL_CIGI_FIELD_COUNT && pel_cigi_rows[f].type != PEL_CIGI_HEAD;
         f++) {
        out->values[f - first] =
            load_field(&pel_cigi_rows[f], at, reader->little);
    }
    return true;
}

size_t pel_cigi_put(const struct pel_cigi_packet *packet, bool little,
                    uint8_t *out, size_t room)
{
    const struct pel_cigi_info *info = &pel_cigi_packets[packet->kind];
    if (room < info->size) {
        return 0;
    }
    memset(out, 0, info->size);
    out[0] = info->id;
    out[1] = info->size;
    for (size_t f = info->first + 1u;
         f < PEL_CIGI_FIELD_COUNT && pel_cigi_rows[f].type != PEL_CIGI_HEAD;
         f++) {
        store_field(&pel_cigi_rows[f], packet->values[f - info->first], out,
                    little);
    }
    return info->size;
}
