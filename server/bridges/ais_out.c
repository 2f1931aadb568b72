#include "bridges/ais_out.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

#define KNOT_MPS (1852.0 / 3600.0)
#define MOST_BITS 432
#define FIRST_PART 56 /* characters of a message's first sentence */

struct bits {
    size_t count;
    uint8_t six[MOST_BITS / 6];
};

static void put(struct bits *b, int64_t value, int width)
{
    for (int i = width - 1; i >= 0; i--, b->count++) {
        b->six[b->count / 6] |=
            (uint8_t)((value >> i & 1) << (5 - b->count % 6));
    }
}

/* Capital letters, digits, signs; '@' ends it. */
static void put_text(struct bits *b, const char *text, size_t characters)
{
    size_t length = strlen(text);
    for (size_t i = 0; i < characters; i++) {
        unsigned char c = i < length ? (unsigned char)text[i] : '@';
        c = c >= 'a' && c <= 'z' ? (unsigned char)(c - 32) : c;
        c = c < 32 || c > 95 ? '-' : c;
        put(b, c & 63, 6);
    }
}

/* `value` in units, `none` where it is not a number. */
static void put_number(struct bits *b, double value, double unit, double least,
                       double most, int64_t none, int width)
{
    put(b, isnan(value) ? none : llround(pel_clamp(value / unit, least, most)),
        width);
}

/* 4.733 times the root of degrees a minute. */
static double turn_of(double degrees_s)
{
    return copysign(4.733 * sqrt(fabs(degrees_s) * 60), degrees_s);
}

static double around(double degrees)
{
    double d = fmod(degrees, 360);
    return d < 0 ? d + 360 : d;
}

static void put_place(struct bits *b, const struct pel_ais *a)
{
    const double fine = 1 / 600000.0;
    put(b, 1, 1); /* better than 10 m */
    put_number(b, a->longitude, fine, -180 / fine, 180 / fine, 181 * 600000,
               28);
    put_number(b, a->latitude, fine, -90 / fine, 90 / fine, 91 * 600000, 27);
}

static void put_size(struct bits *b, const struct pel_ais_ship *s)
{
    put_number(b, s->bow_m, 1, 0, 511, 0, 9);
    put_number(b, s->stern_m, 1, 0, 511, 0, 9);
    put_number(b, s->port_m, 1, 0, 63, 0, 6);
    put_number(b, s->starboard_m, 1, 0, 63, 0, 6);
}

static struct bits begin(int type, uint32_t mmsi)
{
    struct bits b = { 0 };
    put(&b, type, 6);
    put(&b, 0, 2); /* not repeated */
    put(&b, mmsi, 30);
    return b;
}

static void say(struct pel_nmea_writer *w, const struct bits *b, int sequence)
{
    char text[MOST_BITS / 6 + 1];
    size_t length = (b->count + 5) / 6;
    int fill = (int)(6 * length - b->count);
    for (size_t i = 0; i < length; i++) {
        text[i] = (char)(b->six[i] + (b->six[i] < 40 ? 48 : 56));
    }
    text[length] = 0;
    if (length <= FIRST_PART) {
        pel_nmea_say(w, '!', "AIVDM,1,1,,A,%s,%d", text, fill);
        return;
    }
    pel_nmea_say(w, '!', "AIVDM,2,1,%d,A,%.*s,0", sequence, FIRST_PART, text);
    pel_nmea_say(w, '!', "AIVDM,2,2,%d,A,%s,%d", sequence, text + FIRST_PART,
                 fill);
}

void pel_ais_say_position(struct pel_nmea_writer *w, const struct pel_ais *a,
                          int second)
{
    struct bits b = begin(1, a->mmsi);
    put(&b, a->status, 4);
    put_number(&b, turn_of(a->turn_rate), 1, -126, 126, -128, 8);
    put_number(&b, a->speed, KNOT_MPS / 10, 0, 1022, 1023, 10);
    put_place(&b, a);
    put_number(&b, fmod(round(around(a->course) * 10), 3600), 1, 0, 3599, 3600,
               12);
    put_number(&b, fmod(round(around(a->heading)), 360), 1, 0, 359, 511, 9);
    put(&b, second, 6);
    put(&b, 0, 25);
    say(w, &b, 0);
}

void pel_ais_say_ship(struct pel_nmea_writer *w, const struct pel_ais *a,
                      int sequence)
{
    struct bits b = begin(5, a->mmsi);
    put(&b, 0, 2 + 30); /* version, number of the IMO */
    put_text(&b, "", 7);
    put_text(&b, a->name, 20);
    put(&b, a->ship.type, 8);
    put_size(&b, &a->ship);
    put(&b, 1, 4); /* GPS */
    put(&b, 0, 4 + 5);
    put(&b, 24, 5); /* no hour of arrival */
    put(&b, 60, 6);
    put_number(&b, a->ship.draught_m, 0.1, 0, 255, 0, 8);
    put_text(&b, "", 20);
    put(&b, 0, 2);
    say(w, &b, sequence);
}

void pel_ais_say_aid(struct pel_nmea_writer *w, const struct pel_ais *a,
                     int second)
{
    struct bits b = begin(21, a->mmsi);
    put(&b, a->ship.type, 5);
    put_text(&b, a->name, 20);
    put_place(&b, a);
    put_size(&b, &a->ship);
    put(&b, 7, 4); /* surveyed */
    put(&b, second, 6);
    put(&b, 0, 1 + 8 + 1); /* on its place */
    put(&b, a->ship.is_virtual, 1);
    put(&b, 0, 2);
    say(w, &b, 0);
}
