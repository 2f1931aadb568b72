/* CIGI 3.3 datagrams: from bytes to packets and back, by the one table
 * cigi_fields.def. Pure functions, any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum pel_cigi_kind {
#define CIGI_PACKET(name, id, size, from, text) PEL_CIGI_KIND_##name,
#define CIGI_FIELD(...)
#include "bridges/cigi_fields.def"
#undef CIGI_PACKET
#undef CIGI_FIELD
    PEL_CIGI_KIND_COUNT, /* a packet that is not in the table */
};

/* PEL_CIGI_WAVE is the head of packet WAVE, PEL_CIGI_WAVE_HEIGHT a field. */
enum pel_cigi_field {
#define CIGI_PACKET(name, id, size, from, text) PEL_CIGI_##name,
#define CIGI_FIELD(packet, name, ...) PEL_CIGI_##packet##_##name,
#include "bridges/cigi_fields.def"
#undef CIGI_PACKET
#undef CIGI_FIELD
    PEL_CIGI_FIELD_COUNT,
};

enum pel_cigi_type {
    PEL_CIGI_HEAD, /* the row begins a packet */
    PEL_CIGI_U8,
    PEL_CIGI_I8,
    PEL_CIGI_U16,
    PEL_CIGI_U32,
    PEL_CIGI_F32,
    PEL_CIGI_F64,
    PEL_CIGI_BITS, /* `bits` of a byte, from `shift` up */
};

enum pel_cigi_grade {
    PEL_CIGI_HONOURED,
    PEL_CIGI_APPROXIMATED,
    PEL_CIGI_IGNORED,
};

struct pel_cigi_row {
    enum pel_cigi_type type;
    uint8_t offset, shift, bits;
    const char *text, *unit;
    enum pel_cigi_grade grade;
    const char *note;
};
/* One row a field, in the order of enum pel_cigi_field. */
extern const struct pel_cigi_row pel_cigi_rows[PEL_CIGI_FIELD_COUNT];

struct pel_cigi_info {
    const char *text;
    uint8_t id, size;          /* size: smallest legal */
    bool from_host;            /* else from the image generator */
    enum pel_cigi_field first; /* its head row; fields follow */
};
extern const struct pel_cigi_info pel_cigi_packets[PEL_CIGI_KIND_COUNT];

#define PEL_CIGI_MAX_FIELDS 32

/* One packet decoded. Integers are exact; values[0], the head's, is unused. */
struct pel_cigi_packet {
    enum pel_cigi_kind kind;
    uint8_t id;
    double values[PEL_CIGI_MAX_FIELDS];
};

static inline double pel_cigi_get(const struct pel_cigi_packet *packet,
                                  enum pel_cigi_field field)
{
    return packet->values[field - pel_cigi_packets[packet->kind].first];
}

static inline void pel_cigi_set(struct pel_cigi_packet *packet,
                                enum pel_cigi_field field, double value)
{
    packet->values[field - pel_cigi_packets[packet->kind].first] = value;
}

/* A packet of this kind, every field 0. */
struct pel_cigi_packet pel_cigi_packet_of(enum pel_cigi_kind kind);

enum pel_cigi_error {
    PEL_CIGI_GOOD,
    PEL_CIGI_SHORT,   /* less than the packet it must begin with */
    PEL_CIGI_FIRST,   /* does not begin with it, or has it twice */
    PEL_CIGI_VERSION, /* not 3.2 or 3.3 */
    PEL_CIGI_ORDER,   /* the byte swap mark is neither order's */
    PEL_CIGI_SIZE,    /* a packet's size: no multiple of 8, below its least, or
                       * more than is left */
    PEL_CIGI_NUMBER,  /* NaN or infinity in a field that is not ignored */
    PEL_CIGI_ERROR_COUNT,
};
const char *pel_cigi_error_name(enum pel_cigi_error error);

struct pel_cigi_reader {
    const uint8_t *at, *end;
    bool little; /* the sender's byte order */
};

/* Tests a whole datagram that has to begin with packet `first` (IG_CONTROL or
 * START_OF_FRAME); the reader then gives its packets. `bytes` must outlive
 * it. */
enum pel_cigi_error pel_cigi_open(const uint8_t *bytes, size_t size,
                                  enum pel_cigi_kind first,
                                  struct pel_cigi_reader *out);

/* Whether a datagram that does not open begins as those of another version do
 * (1, 2, 3.0, 3.1, 4), and which. */
bool pel_cigi_foreign(const uint8_t *bytes, size_t size, unsigned *major,
                      unsigned *minor);

/* The next packet; false at the end. Bytes beyond the known size of a packet
 * are skipped. */
bool pel_cigi_next(struct pel_cigi_reader *reader, struct pel_cigi_packet *out);

/* Writes a packet at its least size; returns that, or 0 when `room` is less.
 * Values are rounded to the field's type and kept to its range. */
size_t pel_cigi_put(const struct pel_cigi_packet *packet, bool little,
                    uint8_t *out, size_t room);
