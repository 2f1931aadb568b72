#include "bridges/ais.h"

#include <math.h>
#include <string.h>

#define KNOT_MPS (1852.0 / 3600.0)

/* Bits of a payload; reading past the end gives zeros, so callers test the
 * length of the message first. */
struct bits {
    const char *payload;
    size_t count;
};

static uint32_t unsigned_bits(const struct bits *b, size_t start, size_t width)
{
    uint32_t value = 0;
    for (size_t i = start; i < start + width; i++) {
        unsigned six = 0;
        if (i < b->count) {
            six = (unsigned)(b->payload[i / 6] - '0');
            six = six > 40 ? six - 8 : six;
        }
        value = value << 1 | ((six >> (5 - i % 6)) & 1);
    }
    return value;
}

static int32_t signed_bits(const struct bits *b, size_t start, size_t width)
{
    int64_t value = unsigned_bits(b, start, width);
    if (value >> (width - 1)) {
        value -= (int64_t)1 << width;
    }
    return (int32_t)value;
}

/* Adds `count` six-bit characters to `out`, which has room for them; false:
 * one of them was '@', the end. */
static bool text_bits(const struct bits *b, size_t start, size_t count,
                      char *out)
{
    size_t end = strlen(out);
    for (size_t i = 0; i < count; i++) {
        uint32_t six = unsigned_bits(b, start + i * 6, 6);
        if (six == 0) {
            return false;
        }
        out[end++] = (char)(six < 32 ? six + 64 : six);
        out[end] = 0;
    }
    return true;
}

/* The name, of an aid to navigation with what stands at the message's end. */
static void read_name(const struct bits *b, size_t start, size_t more_at,
                      char out[PEL_AIS_NAME + 1])
{
    out[0] = 0;
    if (text_bits(b, start, 20, out) && more_at && b->count > more_at) {
        size_t more = (b->count - more_at) / 6;
        text_bits(b, more_at, more < 14 ? more : 14, out);
    }
    for (size_t end = strlen(out); end > 0 && out[end - 1] == ' ';) {
        out[--end] = 0;
    }
}

/* A field of an integer of `width` bits at `at`, times `unit`; at 0: the
 * message has none. */
struct place {
    uint16_t at;
    uint8_t width;
    double unit;
};

/* Where the fields of each message lie. A new type is a row here and a line
 * in proto/nmea.in.md. */
static const struct layout {
    uint8_t type;
    bool coarse;
    uint16_t least_bits, most_bits;      /* the latter with six of padding */
    struct place longitude, latitude;    /* signed; deg */
    struct place speed, course, heading; /* m/s, deg, deg */
    struct place altitude;               /* m */
    uint16_t status_at;                  /* four bits; 0: none */
    uint16_t turn_rate_at, part_at, name_at, more_name_at; /* 0: none */
    struct place kind;                                     /* of ship or aid */
    uint16_t size_at, draught_at, virtual_at;              /* 0: none */
} layouts[] = {
#define FINE (1 / 600000.0)
#define COARSE (1 / 600.0)
#define CLASS_A(type)                                                          \
    {                                                                          \
        type, false, 168, 174, { 61, 28, FINE }, { 89, 27, FINE },             \
            { 50, 10, KNOT_MPS / 10 }, { 116, 12, 0.1 }, { 128, 9, 1 }, { 0 }, \
            38, 42, 0, 0, 0, { 0 }, 0, 0, 0                                    \
    }
#define CLASS_B(type, least, most, name, ...)                                  \
    {                                                                          \
        type, false, least, most, { 57, 28, FINE }, { 85, 27, FINE },          \
            { 46, 10, KNOT_MPS / 10 }, { 112, 12, 0.1 }, { 124, 9, 1 }, { 0 }, \
            0, 0, 0, name, 0, __VA_ARGS__                                      \
    }
    CLASS_A(1),
    CLASS_A(2),
    CLASS_A(3),
    { .type = 4,
      .least_bits = 168,
      .most_bits = 174,
      .longitude = { 79, 28, FINE },
      .latitude = { 107, 27, FINE } },
    { .type = 5,
      .least_bits = 232,
      .most_bits = 430,
      .name_at = 112,
      .kind = { 232, 8, 1 },
      .size_at = 240,
      .draught_at = 294 },
    { .type = 9,
      .least_bits = 168,
      .most_bits = 174,
      .longitude = { 61, 28, FINE },
      .latitude = { 89, 27, FINE },
      .speed = { 50, 10, KNOT_MPS },
      .course = { 116, 12, 0.1 },
      .altitude = { 38, 12, 1 } },
    CLASS_B(18, 168, 174, 0, { 0 }, 0, 0, 0),
    CLASS_B(19, 263, 318, 143, { 263, 8, 1 }, 271, 0, 0),
    { .type = 21,
      .least_bits = 272,
      .most_bits = 366,
      .longitude = { 164, 28, FINE },
      .latitude = { 192, 27, FINE },
      .name_at = 43,
      .more_name_at = 272,
      .kind = { 38, 5, 1 },
      .size_at = 219,
      .virtual_at = 269 },
    { .type = 24,
      .least_bits = 160,
      .most_bits = 174,
      .part_at = 38,
      .name_at = 40,
      .kind = { 40, 8, 1 },
      .size_at = 132 },
    { .type = 27,
      .coarse = true,
      .least_bits = 96,
      .most_bits = 102,
      .longitude = { 44, 18, COARSE },
      .latitude = { 62, 17, COARSE },
      .speed = { 79, 6, KNOT_MPS },
      .course = { 85, 9, 1 },
      .status_at = 40 },
};

/* All bits set is "not available" of speeds and altitudes. */
static double quantity(const struct bits *b, const struct place *p)
{
    uint32_t value = p->at ? unsigned_bits(b, p->at, p->width) : 0;
    return p->at && value != (1U << p->width) - 1 ? value * p->unit : NAN;
}

/* 360 and more is "not available". */
static double angle(const struct bits *b, const struct place *p)
{
    double deg = quantity(b, p);
    return deg < 359.95 ? deg : NAN;
}

static void position(const struct bits *b, const struct layout *l,
                     struct pel_ais *out)
{
    double longitude =
        signed_bits(b, l->longitude.at, l->longitude.width) * l->longitude.unit;
    double latitude =
        signed_bits(b, l->latitude.at, l->latitude.width) * l->latitude.unit;
    out->has_position_report = true;
    out->coarse = l->coarse;
    if (fabs(longitude) <= 180 && fabs(latitude) <= 90) {
        out->longitude = longitude;
        out->latitude = latitude;
    }
}

/* ROT_AIS = 4.733 sqrt(ROT in deg/min); ±127: more, without an indicator;
 * -128: not known. */
static double turn_rate(int32_t rot_ais)
{
    if (rot_ais < -126 || rot_ais > 126) {
        return NAN;
    }
    double root = rot_ais / 4.733;
    return copysign(root * root, root) / 60;
}

/* Type and size; a message may end before them. */
static void read_ship(const struct bits *b, const struct layout *l,
                      struct pel_ais *out)
{
    struct pel_ais_ship *ship = &out->ship;
    size_t at = l->size_at;
    if (b->count < at + 30) {
        return;
    }
    out->has_ship = true;
    ship->type = (uint8_t)unsigned_bits(b, l->kind.at, l->kind.width);
    ship->is_virtual = l->virtual_at && unsigned_bits(b, l->virtual_at, 1);
    if (l->part_at && out->mmsi / 10000000 == 98) {
        return; /* of a ship's boat: the ship's number instead */
    }
    ship->bow_m = unsigned_bits(b, at, 9);
    ship->stern_m = unsigned_bits(b, at + 9, 9);
    ship->port_m = unsigned_bits(b, at + 18, 6);
    ship->starboard_m = unsigned_bits(b, at + 24, 6);
    if (l->draught_at) {
        ship->draught_m = unsigned_bits(b, l->draught_at, 8) * 0.1;
    }
}

bool pel_ais_decode(const char *payload, size_t length, struct pel_ais *out)
{
    struct bits b = { payload, length * 6 };
    if (b.count < 38) {
        return false;
    }
    uint32_t type = unsigned_bits(&b, 0, 6);
    const struct layout *l = NULL;
    for (size_t i = 0; i < sizeof layouts / sizeof layouts[0]; i++) {
        const struct layout *row = &layouts[i];
        if (row->type == type && b.count >= row->least_bits &&
            b.count <= row->most_bits) {
            l = row;
        }
    }
    if (!l) {
        return false;
    }
    *out = (struct pel_ais){
        .type = (int)type,
        .mmsi = unsigned_bits(&b, 8, 30),
        .status = l->status_at ? (int)unsigned_bits(&b, l->status_at, 4) : -1,
        .latitude = NAN,
        .longitude = NAN,
        .altitude = quantity(&b, &l->altitude),
        .speed = quantity(&b, &l->speed),
        .course = angle(&b, &l->course),
        .heading = angle(&b, &l->heading),
        .turn_rate = l->turn_rate_at
                         ? turn_rate(signed_bits(&b, l->turn_rate_at, 8))
                         : NAN,
    };
    if (l->longitude.at) {
        position(&b, l, out);
    }
    /* Of the parts of type 24 A alone has a name, B alone the ship. */
    uint32_t part = l->part_at ? unsigned_bits(&b, l->part_at, 2) : 0;
    if (l->name_at && part == 0) {
        read_name(&b, l->name_at, l->more_name_at, out->name);
    }
    if (l->size_at && part == (l->part_at ? 1 : 0)) {
        read_ship(&b, l, out);
    }
    return true;
}

static int find_slot(struct pel_ais_assembler *a,
                     const struct pel_nmea_sentence *s)
{
    int oldest = 0;
    for (int i = 0; i < PEL_AIS_SLOTS; i++) {
        if (a->slots[i].count == s->ais.count &&
            a->slots[i].sequence == s->ais.sequence &&
            a->slots[i].channel == s->ais.channel) {
            return i;
        }
        if (a->slots[i].count == 0 ||
            (a->slots[oldest].count != 0 &&
             a->clock - a->slots[i].age > a->clock - a->slots[oldest].age)) {
            oldest = i;
        }
    }
    return s->ais.index == 1 ? oldest : -1;
}

enum pel_ais_part pel_ais_assemble(struct pel_ais_assembler *a,
                                   const struct pel_nmea_sentence *s,
                                   const char **payload, size_t *length)
{
    size_t size = strlen(s->ais.payload);
    if (s->ais.count == 1) {
        *payload = s->ais.payload;
        *length = size;
        return PEL_AIS_WHOLE;
    }
    int i = find_slot(a, s);
    if (i < 0) {
        return PEL_AIS_DROPPED;
    }
    if (s->ais.index == 1) {
        a->slots[i].count = s->ais.count;
        a->slots[i].sequence = s->ais.sequence;
        a->slots[i].channel = s->ais.channel;
        a->slots[i].next = 1;
        a->slots[i].length = 0;
        a->slots[i].age = ++a->clock;
    }
    if (a->slots[i].next != s->ais.index ||
        a->slots[i].length + size > PEL_AIS_MAX_PAYLOAD) {
        a->slots[i].count = 0;
        return PEL_AIS_DROPPED;
    }
    memcpy(a->slots[i].payload + a->slots[i].length, s->ais.payload, size);
    a->slots[i].length += size;
    if (a->slots[i].next++ < a->slots[i].count) {
        return PEL_AIS_WAIT;
    }
    a->slots[i].count = 0;
    *payload = a->slots[i].payload;
    *length = a->slots[i].length;
    return PEL_AIS_WHOLE;
}
