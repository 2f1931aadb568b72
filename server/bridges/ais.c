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

static void text_bits(const struct bits *b, size_t start, char out[21])
{
    size_t end = 0;
    for (size_t i = 0; i < 20; i++) {
        uint32_t six = unsigned_bits(b, start + i * 6, 6);
        if (six == 0) { /* '@': the end */
            break;
        }
        out[i] = (char)(six < 32 ? six + 64 : six);
        end = out[i] == ' ' ? end : i + 1;
    }
    out[end] = 0;
}

/* Speed, longitude, latitude, course and heading lie together in all position
 * reports, at different starts. */
static void position_report(const struct bits *b, size_t speed_at,
                            struct pel_ais *out)
{
    size_t at = speed_at + 11; /* 10 bits of speed, 1 of accuracy */
    uint32_t speed = unsigned_bits(b, speed_at, 10);
    double longitude = signed_bits(b, at, 28) / 600000.0;
    double latitude = signed_bits(b, at + 28, 27) / 600000.0;
    uint32_t course = unsigned_bits(b, at + 55, 12);
    uint32_t heading = unsigned_bits(b, at + 67, 9);
    out->has_position_report = true;
    if (speed < 1023) {
        out->speed = speed / 10.0 * KNOT_MPS;
    }
    if (fabs(longitude) <= 180 && fabs(latitude) <= 90) {
        out->longitude = longitude;
        out->latitude = latitude;
    }
    if (course < 3600) {
        out->course = course / 10.0;
    }
    if (heading < 360) {
        out->heading = heading;
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

bool pel_ais_decode(const char *payload, size_t length, struct pel_ais *out)
{
    struct bits b = { payload, length * 6 };
    if (b.count < 38) {
        return false;
    }
    *out = (struct pel_ais){
        .type = (int)unsigned_bits(&b, 0, 6),
        .mmsi = unsigned_bits(&b, 8, 30),
        .latitude = NAN,
        .longitude = NAN,
        .speed = NAN,
        .course = NAN,
        .heading = NAN,
        .turn_rate = NAN,
    };
    switch (out->type) {
    case 1:
    case 2:
    case 3:
        if (b.count < 168) {
            return false;
        }
        position_report(&b, 50, out);
        out->turn_rate = turn_rate(signed_bits(&b, 42, 8));
        return true;
    case 5:
        if (b.count < 232) {
            return false;
        }
        text_bits(&b, 112, out->name);
        return true;
    case 18:
        if (b.count < 168) {
            return false;
        }
        position_report(&b, 46, out);
        return true;
    case 19:
        if (b.count < 263) {
            return false;
        }
        position_report(&b, 46, out);
        text_bits(&b, 143, out->name);
        return true;
    case 24:
        if (b.count < 160) {
            return false;
        }
        if (unsigned_bits(&b, 38, 2) == 0) {
            text_bits(&b, 40, out->name);
        }
        return true;
    default:
        return false;
    }
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
