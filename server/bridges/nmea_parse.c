#include "bridges/nmea_parse.h"

#include <math.h>
#include <string.h>

#define MAX_FIELDS 80
#define KNOT_MPS (1852.0 / 3600.0)
#define FOOT_M 0.3048

/* The fields after the address; `bad` sticks when one cannot be read. */
struct fields {
    const char *text[MAX_FIELDS];
    size_t length[MAX_FIELDS];
    size_t count;
    bool bad;
};

static void split(struct fields *f, const char *text, size_t length)
{
    *f = (struct fields){ 0 };
    const char *end = text + length;
    while (f->count < MAX_FIELDS) {
        const char *comma = memchr(text, ',', (size_t)(end - text));
        f->text[f->count] = text;
        f->length[f->count] = (size_t)((comma ? comma : end) - text);
        f->count++;
        if (!comma) {
            return;
        }
        text = comma + 1;
    }
    f->bad = true;
}

/* The character of a one-letter field, 0 when empty or not there. */
static char letter(struct fields *f, size_t i)
{
    if (i >= f->count || f->length[i] == 0) {
        return 0;
    }
    if (f->length[i] > 1) {
        f->bad = true;
    }
    return f->text[i][0];
}

/* A decimal number: [+-]digits[.digits]; NaN when empty or not there. Not
 * strtod: that takes inf, nan, hexadecimal and the locale's point. */
static double number(struct fields *f, size_t i)
{
    if (i >= f->count || f->length[i] == 0) {
        return NAN;
    }
    const char *p = f->text[i];
    const char *end = p + f->length[i];
    bool negative = *p == '-';
    p += *p == '-' || *p == '+';
    double mantissa = 0, scale = 1;
    size_t digits = 0;
    bool point = false;
    for (; p < end; p++) {
        if (*p == '.' && !point) {
            point = true;
        } else if (*p >= '0' && *p <= '9') {
            mantissa = mantissa * 10 + (*p - '0');
            scale = point ? scale * 10 : scale;
            digits++;
        } else {
            digits = 0;
            break;
        }
    }
    if (digits == 0 || digits > 15) { /* 15 are exact in a double */
        f->bad = true;
        return NAN;
    }
    return (negative ? -mantissa : mantissa) / scale;
}

/* A whole number of 0..limit; -1 when empty. */
static int whole(struct fields *f, size_t i, int limit)
{
    double value = number(f, i);
    if (isnan(value)) {
        return -1;
    }
    if (value < 0 || value > limit || value != floor(value)) {
        f->bad = true;
        return -1;
    }
    return (int)value;
}

/* dddmm.mmm and its hemisphere letter in fields i and i + 1 [deg]. Devices that
 * round their minutes write 60.000 just below a whole degree. */
static double coordinate(struct fields *f, size_t i, char positive,
                         char negative, double limit)
{
    double value = number(f, i);
    char side = letter(f, i + 1);
    if (isnan(value)) {
        return NAN;
    }
    double degrees = floor(value / 100);
    double minutes = value - degrees * 100;
    double angle = degrees + minutes / 60;
    if (value < 0 || minutes > 60 || angle > limit ||
        (side != positive && side != negative)) {
        f->bad = true;
        return NAN;
    }
    return side == negative ? -angle : angle;
}

static void position(struct fields *f, size_t i, struct pel_nmea_sentence *s)
{
    s->latitude = coordinate(f, i, 'N', 'S', 90);
    s->longitude = coordinate(f, i + 2, 'E', 'W', 180);
}

/* hhmmss.sss to seconds of the day. */
static double time_of_day(struct fields *f, size_t i)
{
    double value = number(f, i);
    if (isnan(value)) {
        return NAN;
    }
    double hours = floor(value / 10000);
    double minutes = floor(value / 100) - hours * 100;
    double seconds = value - hours * 10000 - minutes * 100;
    if (value < 0 || hours > 23 || minutes > 59 || seconds >= 61) {
        f->bad = true;
        return NAN;
    }
    return hours * 3600 + minutes * 60 + seconds;
}

/* ddmmyy, or yyyymmdd as Bridge Command writes it. */
static void date(struct fields *f, size_t i, struct pel_nmea_sentence *s)
{
    int value = whole(f, i, 99991231);
    if (value < 0) {
        return;
    }
    if (f->length[i] == 8) {
        s->year = value / 10000;
        s->month = value / 100 % 100;
        s->day = value % 100;
    } else {
        s->day = value / 10000;
        s->month = value / 100 % 100;
        s->year = value % 100 + (value % 100 >= 80 ? 1900 : 2000);
    }
    if (s->day < 1 || s->day > 31 || s->month < 1 || s->month > 12) {
        f->bad = true;
    }
}

/* A magnetic angle's correction: number and E (positive) or W. */
static double east_west(struct fields *f, size_t i)
{
    double value = number(f, i);
    char side = letter(f, i + 1);
    if (!isnan(value) && side != 'E' && side != 'W') {
        f->bad = true;
    }
    return side == 'W' ? -value : value;
}

/* Speed from fields in knots and, when those are empty, km/h. */
static double knots_or_kmh(struct fields *f, size_t knots, size_t kmh)
{
    double value = number(f, knots) * KNOT_MPS;
    double other = number(f, kmh) / 3.6;
    return isnan(value) ? other : value;
}

static void parse_rmc(struct fields *f, struct pel_nmea_sentence *s)
{
    s->utc_s = time_of_day(f, 0);
    s->valid = letter(f, 1) == 'A';
    position(f, 2, s);
    s->speed = number(f, 6) * KNOT_MPS;
    s->course = number(f, 7);
    date(f, 8, s);
    s->variation = east_west(f, 9);
}

static void parse_gga(struct fields *f, struct pel_nmea_sentence *s)
{
    s->utc_s = time_of_day(f, 0);
    position(f, 1, s);
    s->valid = whole(f, 5, 9) > 0;
    s->altitude = number(f, 8);
}

/* The mode has a letter for each satellite system, N: no fix by it. */
static void parse_gns(struct fields *f, struct pel_nmea_sentence *s)
{
    s->utc_s = time_of_day(f, 0);
    position(f, 1, s);
    s->valid = false;
    for (size_t i = 0; f->count > 5 && i < f->length[5]; i++) {
        s->valid = s->valid || f->text[5][i] != 'N';
    }
    s->altitude = number(f, 8);
}

static void parse_gll(struct fields *f, struct pel_nmea_sentence *s)
{
    position(f, 0, s);
    s->utc_s = time_of_day(f, 4);
    char status = letter(f, 5);
    s->valid = status == 'A' || status == 0; /* NMEA 1.5 has no status */
}

static void parse_hdt(struct fields *f, struct pel_nmea_sentence *s)
{
    s->heading = number(f, 0);
}

static void parse_ths(struct fields *f, struct pel_nmea_sentence *s)
{
    s->heading = number(f, 0);
    s->valid = letter(f, 1) != 'V';
}

static void parse_hdm(struct fields *f, struct pel_nmea_sentence *s)
{
    s->magnetic_heading = number(f, 0);
}

/* Time, heading, T, roll, pitch, heave, accuracies. */
static void parse_pashr(struct fields *f, struct pel_nmea_sentence *s)
{
    s->utc_s = time_of_day(f, 0);
    s->heading = number(f, 1);
    if (letter(f, 2) != 'T' && !isnan(s->heading)) {
        f->bad = true;
    }
    s->roll = number(f, 3);
    s->pitch = number(f, 4);
    s->heave = number(f, 5);
}

static void parse_hdg(struct fields *f, struct pel_nmea_sentence *s)
{
    s->magnetic_heading = number(f, 0);
    s->deviation = east_west(f, 1);
    s->variation = east_west(f, 3);
}

static void parse_vtg(struct fields *f, struct pel_nmea_sentence *s)
{
    s->course = number(f, 0);
    s->speed = knots_or_kmh(f, 4, 6);
    s->valid = letter(f, 8) != 'N';
}

static void parse_vhw(struct fields *f, struct pel_nmea_sentence *s)
{
    s->heading = number(f, 0);
    s->magnetic_heading = number(f, 2);
    s->speed = knots_or_kmh(f, 4, 6);
}

static void parse_rot(struct fields *f, struct pel_nmea_sentence *s)
{
    s->turn_rate = number(f, 0) / 60;
    s->valid = letter(f, 1) == 'A';
}

static void parse_zda(struct fields *f, struct pel_nmea_sentence *s)
{
    s->utc_s = time_of_day(f, 0);
    s->day = whole(f, 1, 31);
    s->month = whole(f, 2, 12);
    s->year = whole(f, 3, 9999);
    if (s->day < 1 || s->month < 1 || s->year < 1) { /* empty or zero */
        s->day = s->month = s->year = 0;
    }
}

static void parse_mwv(struct fields *f, struct pel_nmea_sentence *s)
{
    s->wind_angle = number(f, 0);
    char reference = letter(f, 1);
    s->wind_true = reference == 'T';
    s->wind_speed = number(f, 2);
    s->valid = letter(f, 4) == 'A';
    switch (letter(f, 3)) {
    case 'N':
        s->wind_speed *= KNOT_MPS;
        break;
    case 'K':
        s->wind_speed /= 3.6;
        break;
    case 'S':
        s->wind_speed *= 1609.344 / 3600;
        break;
    case 'M':
        break;
    default:
        f->bad = f->bad || !isnan(s->wind_speed);
    }
    if (!isnan(s->wind_angle) && reference != 'T' && reference != 'R') {
        f->bad = true;
    }
}

/* m/s of the first of `count` speeds that is there, each with its unit behind
 * it: N, M or K. */
static double speed_of(struct fields *f, size_t i, int count)
{
    for (; count-- > 0; i += 2) {
        double value = number(f, i);
        if (isnan(value)) {
            continue;
        }
        switch (letter(f, i + 1)) {
        case 'N':
            return value * KNOT_MPS;
        case 'M':
            return value;
        case 'K':
            return value / 3.6;
        default:
            f->bad = true;
        }
    }
    return NAN;
}

/* 0 to 180 to port (L) or starboard (R); ahead and astern need no side. */
static void wind_to_side(struct fields *f, bool is_true,
                         struct pel_nmea_sentence *s)
{
    double angle = number(f, 0);
    char side = letter(f, 1);
    s->wind_true = is_true;
    s->wind_angle = side == 'L' && angle > 0 ? 360 - angle : angle;
    s->wind_speed = speed_of(f, 2, 3);
    bool middle = !side && (angle == 0 || angle == 180);
    if (!isnan(angle) &&
        (angle < 0 || angle > 180 || (side != 'L' && side != 'R' && !middle))) {
        f->bad = true;
    }
}

static void parse_vwr(struct fields *f, struct pel_nmea_sentence *s)
{
    wind_to_side(f, false, s);
}

static void parse_vwt(struct fields *f, struct pel_nmea_sentence *s)
{
    wind_to_side(f, true, s);
}

/* Pressure, temperatures and humidity are before it. */
static void parse_mda(struct fields *f, struct pel_nmea_sentence *s)
{
    s->wind_direction = number(f, 12);
    s->wind_speed = speed_of(f, 16, 2);
    if (!isnan(s->wind_direction) && letter(f, 13) != 'T') {
        f->bad = true;
    }
}

static void parse_mwd(struct fields *f, struct pel_nmea_sentence *s)
{
    s->wind_direction = number(f, 0);
    /* Knots first: their last digit is the finer one. */
    double mps = number(f, 6);
    s->wind_speed = number(f, 4) * KNOT_MPS;
    if (isnan(s->wind_speed)) {
        s->wind_speed = mps;
    }
}

/* Copies a field's text, cut to size - 1 characters. */
static void text(struct fields *f, size_t i, char *out, size_t size)
{
    size_t length = i < f->count ? f->length[i] : 0;
    length = length < size ? length : size - 1;
    if (length > 0) {
        memcpy(out, f->text[i], length);
    }
    out[length] = 0;
}

static void parse_xdr(struct fields *f, struct pel_nmea_sentence *s)
{
    for (size_t i = 0; i + 3 < f->count; i += 4) {
        if (s->transducer_count == PEL_NMEA_MAX_TRANSDUCERS) {
            return;
        }
        struct pel_nmea_transducer *t = &s->transducers[s->transducer_count];
        t->type = letter(f, i);
        t->value = number(f, i + 1);
        t->unit = letter(f, i + 2);
        text(f, i + 3, t->name, sizeof t->name);
        s->transducer_count++;
    }
}

static void parse_rsa(struct fields *f, struct pel_nmea_sentence *s)
{
    s->rudder = number(f, 0);
    s->valid = letter(f, 1) == 'A';
}

static void parse_dpt(struct fields *f, struct pel_nmea_sentence *s)
{
    s->depth = number(f, 0);
    s->depth_offset = number(f, 1);
}

static void parse_dbt(struct fields *f, struct pel_nmea_sentence *s)
{
    double feet = number(f, 0) * FOOT_M;
    s->depth = number(f, 2);
    if (isnan(s->depth)) {
        s->depth = feet;
    }
}

static void parse_ttm(struct fields *f, struct pel_nmea_sentence *s)
{
    s->target = whole(f, 0, 999);
    char unit = letter(f, 9);
    double unit_m = unit == 'K' ? 1000 : unit == 'S' ? 1609.344 : 1852;
    s->target_range = number(f, 1) * unit_m;
    s->target_bearing = number(f, 2);
    s->bearing_true = letter(f, 3) != 'R';
    s->speed = number(f, 4) * unit_m / 3600;
    s->course = number(f, 5);
    s->course_true = letter(f, 6) != 'R';
    text(f, 10, s->target_name, sizeof s->target_name);
    s->target_status = letter(f, 11);
}

static void parse_tll(struct fields *f, struct pel_nmea_sentence *s)
{
    s->target = whole(f, 0, 999);
    position(f, 1, s);
    text(f, 5, s->target_name, sizeof s->target_name);
    s->utc_s = time_of_day(f, 6);
    s->target_status = letter(f, 7);
}

static void parse_vdm(struct fields *f, struct pel_nmea_sentence *s)
{
    s->ais.count = whole(f, 0, 9);
    s->ais.index = whole(f, 1, 9);
    s->ais.sequence = whole(f, 2, 9);
    s->ais.channel = letter(f, 3);
    s->ais.fill = whole(f, 5, 5);
    if (s->ais.count < 1 || s->ais.index < 1 || s->ais.fill < 0 ||
        s->ais.index > s->ais.count || f->length[4] == 0) {
        f->bad = true;
        return;
    }
    /* Six bits a character: '0'..'W' and '`'..'w'. */
    for (size_t i = 0; i < f->length[4]; i++) {
        char c = f->text[4][i];
        if (c < '0' || (c > 'W' && c < '`') || c > 'w') {
            f->bad = true;
            return;
        }
        s->ais.payload[i] = c;
    }
}

static const struct format {
    const char *address;
    void (*parse)(struct fields *f, struct pel_nmea_sentence *s);
} formats[PEL_NMEA_KIND_COUNT] = {
    [PEL_NMEA_OTHER] = { "", NULL },
#define NMEA_SENTENCE(kind, address, parse, take, text)                        \
    [PEL_NMEA_##kind] = { address, parse_##parse },
#include "bridges/nmea_sentences.def"
#undef NMEA_SENTENCE
};

const char *pel_nmea_kind_name(enum pel_nmea_kind kind)
{
    return kind == PEL_NMEA_OTHER ? "other" : formats[kind].address;
}

const char *pel_nmea_error_name(enum pel_nmea_error error)
{
    static const char *const names[PEL_NMEA_ERROR_COUNT] = {
        [PEL_NMEA_OK] = "ok",
        [PEL_NMEA_NO_START] = "no_start",
        [PEL_NMEA_TOO_LONG] = "too_long",
        [PEL_NMEA_BAD_BYTE] = "bad_byte",
        [PEL_NMEA_NO_CHECKSUM] = "no_checksum",
        [PEL_NMEA_BAD_CHECKSUM] = "bad_checksum",
        [PEL_NMEA_BAD_FIELD] = "bad_field",
    };
    return names[error];
}

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9') {
        return c - '0';
    }
    if (c >= 'A' && c <= 'F') {
        return c - 'A' + 10;
    }
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* Bytes that devices leave behind a sentence, and pad datagrams with. */
static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\0';
}

/* The end of the sentence that begins at p: behind `*hh`, where the line ends
 * or a receiver's suffix begins; NULL: no checksum. */
static const char *end_of_sum(const char *p, const char *end)
{
    const char *star = memchr(p, '*', (size_t)(end - p));
    bool whole = star && end - star >= 3 && hex_digit(star[1]) >= 0 &&
                 hex_digit(star[2]) >= 0;
    const char *next = whole ? star + 3 : end;
    while (next < end && is_blank(*next)) {
        next++;
    }
    return whole && (next == end || *next == ',') ? star + 3 : NULL;
}

/* Finds the text between the last `$` or `!` and `*hh`; tests frame and sum. */
static enum pel_nmea_error unwrap(const char **line, size_t *length,
                                  bool *resynchronised)
{
    const char *p = *line;
    while (*length > 0 && is_blank(p[*length - 1])) {
        --*length;
    }
    const char *end = p + *length;
    if (*length > PEL_NMEA_MAX_SENTENCE) {
        return PEL_NMEA_TOO_LONG;
    }
    if (p < end && *p == '\\') { /* a tag block: time stamps, line counts */
        p = memchr(p + 1, '\\', (size_t)(end - p - 1));
        if (!p) {
            return PEL_NMEA_NO_START;
        }
        p++;
    }
    const char *begin = NULL;
    for (const char *q = p; q < end; q++) {
        begin = *q == '$' || *q == '!' ? q : begin;
    }
    if (!begin) {
        return PEL_NMEA_NO_START;
    }
    *resynchronised = begin > p;
    for (p = begin + 1; p < end; p++) {
        if (*p < 0x20 || *p > 0x7e) {
            return PEL_NMEA_BAD_BYTE;
        }
    }
    p = begin + 1;
    end = end_of_sum(p, end);
    if (!end) {
        return PEL_NMEA_NO_CHECKSUM;
    }
    unsigned sum = 0;
    for (const char *q = p; q < end - 3; q++) {
        sum ^= (unsigned char)*q;
    }
    if ((int)sum != hex_digit(end[-2]) * 16 + hex_digit(end[-1])) {
        return PEL_NMEA_BAD_CHECKSUM;
    }
    *line = p;
    *length = (size_t)(end - 3 - p);
    return PEL_NMEA_OK;
}

static void clear(struct pel_nmea_sentence *s)
{
    static const double empty = NAN;
    memset(s, 0, sizeof *s);
    s->valid = true;
    for (size_t at = offsetof(struct pel_nmea_sentence, latitude);
         at <= offsetof(struct pel_nmea_sentence, target_bearing);
         at += sizeof empty) {
        memcpy((char *)s + at, &empty, sizeof empty);
    }
    s->target = -1;
}

/* Which of ours an address of five letters is: a formatter behind any talker,
 * or (P) a maker's own sentence. PASHR has messages with a name in the first
 * field, which are not ours. */
static enum pel_nmea_kind kind_of(const char *address, const char *rest,
                                  size_t length)
{
    bool makers = address[0] == 'P';
    for (int kind = 1; kind < PEL_NMEA_KIND_COUNT; kind++) {
        const char *ours = formats[kind].address;
        size_t size = makers ? 5 : 3;
        if (strlen(ours) != size || memcmp(address + 5 - size, ours, size)) {
            continue;
        }
        if (kind == PEL_NMEA_PASHR && length > 0 && rest[0] >= 'A') {
            return PEL_NMEA_OTHER;
        }
        return (enum pel_nmea_kind)kind;
    }
    return PEL_NMEA_OTHER;
}

enum pel_nmea_error pel_nmea_parse(const char *line, size_t length,
                                   struct pel_nmea_sentence *out)
{
    bool resynchronised = false;
    enum pel_nmea_error error = unwrap(&line, &length, &resynchronised);
    if (error) {
        return error;
    }
    clear(out);
    out->resynchronised = resynchronised;
    const char *comma = memchr(line, ',', length);
    size_t address = comma ? (size_t)(comma - line) : length;
    if (address != 5) {
        return PEL_NMEA_OK;
    }
    const char *rest = comma ? comma + 1 : line + length;
    size_t rest_length = comma ? length - address - 1 : 0;
    enum pel_nmea_kind kind = kind_of(line, rest, rest_length);
    if (line[0] != 'P') {
        memcpy(out->talker, line, 2);
    }
    if (kind == PEL_NMEA_OTHER) {
        return PEL_NMEA_OK;
    }
    /* `!` starts packed data only: anything else is a `$` gone bad, and the sum
     * does not cover it. */
    if (line[-1] == '!' && kind != PEL_NMEA_VDM && kind != PEL_NMEA_VDO) {
        return PEL_NMEA_NO_START;
    }
    struct fields fields;
    split(&fields, rest, rest_length);
    if (!fields.bad) {
        formats[kind].parse(&fields, out);
    }
    if (fields.bad) {
        return PEL_NMEA_BAD_FIELD;
    }
    out->kind = kind;
    return PEL_NMEA_OK;
}

void pel_nmea_lines_feed(struct pel_nmea_lines *lines, const char *bytes,
                         size_t size, pel_nmea_line_fn fn, void *user)
{
    for (size_t i = 0; i < size; i++) {
        if (bytes[i] == '\n' || bytes[i] == '\r') {
            pel_nmea_lines_end(lines, fn, user);
        } else if (!lines->overlong) {
            lines->text[lines->length++] = bytes[i];
            lines->overlong = lines->length > PEL_NMEA_MAX_SENTENCE;
        }
    }
}

void pel_nmea_lines_end(struct pel_nmea_lines *lines, pel_nmea_line_fn fn,
                        void *user)
{
    if (lines->length > 0) {
        fn(user, lines->text, lines->length);
    }
    lines->length = 0;
    lines->overlong = false;
}
