/* NMEA 0183: bytes to typed sentences. No state but the caller's line buffer,
 * no allocation, any thread.
 *
 * A sentence is `$` or `!`, talker and type, fields, `*hh`, CR and LF, with an
 * optional tag block `\...*hh\` before it. It begins at the line's last `$` or
 * `!`: what a broken line before it left is passed over. A receiver's suffix
 * after the checksum (`,station,time`) is passed over too, and so are blanks.
 * The checksum is always required. Sentences longer than 82 characters are out
 * of the standard but common: lines of up to 256 are read. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bounds.h"

#define PEL_NMEA_MAX_SENTENCE PEL_BOUND_NMEA_SENTENCE_BYTES
#define PEL_NMEA_MAX_TRANSDUCERS 16

enum pel_nmea_kind {
    PEL_NMEA_OTHER, /* good checksum, not one of ours */
#define NMEA_SENTENCE(kind, address, parse, take, text) PEL_NMEA_##kind,
#include "bridges/nmea_sentences.def"
#undef NMEA_SENTENCE
    PEL_NMEA_KIND_COUNT
};

enum pel_nmea_error {
    PEL_NMEA_OK,
    PEL_NMEA_NO_START,     /* has no $ or !, or a tag block without an end */
    PEL_NMEA_TOO_LONG,     /* more than PEL_NMEA_MAX_SENTENCE characters */
    PEL_NMEA_BAD_BYTE,     /* outside printable ASCII */
    PEL_NMEA_NO_CHECKSUM,  /* no `*hh` at the end */
    PEL_NMEA_BAD_CHECKSUM, /* `*hh` is another sum than the bytes' */
    PEL_NMEA_BAD_FIELD,    /* a field of a known sentence cannot be read */
    PEL_NMEA_ERROR_COUNT
};

/* NaN: the field is empty. Angles deg, true unless said; speeds m/s; depths
 * and heights m; latitude north, longitude east positive. The numbers from
 * latitude to target_bearing stand together: clear() makes them NaN. */
struct pel_nmea_sentence {
    double latitude, longitude;
    double utc_s; /* of the day: RMC, GGA, GNS, GLL, ZDA */
    double heading, magnetic_heading, deviation, variation;
    double course, speed; /* over ground; VHW: through water; TTM: target's */
    double turn_rate;     /* deg/s, to starboard positive */
    double altitude;
    double roll, pitch, heave; /* PASHR; starboard down, bow up, up positive */
    double wind_direction;     /* MWD, MDA: true, blows from */
    double wind_angle;         /* MWV, VWT, VWR: from the bow, clockwise */
    double wind_speed;
    double rudder; /* RSA: starboard or single, starboard positive */
    double depth, depth_offset;
    double target_range, target_bearing; /* m; deg */
    enum pel_nmea_kind kind;
    char talker[3];       /* "" of a maker's own sentence */
    bool valid;           /* status A, or fix quality > 0; true without one */
    bool resynchronised;  /* something stood before its beginning */
    int year, month, day; /* 0: empty. RMC, ZDA */
    bool wind_true;       /* MWV T, VWT; not MWV R, VWR */
    struct pel_nmea_transducer {
        char type, unit;
        double value; /* NaN: empty */
        char name[16];
    } transducers[PEL_NMEA_MAX_TRANSDUCERS];
    size_t transducer_count;
    int target;           /* TTM, TLL: number, -1 empty */
    bool bearing_true;    /* target_bearing is from north, not from the bow */
    bool course_true;     /* course and speed are over ground, not relative */
    char target_name[21]; /* "" empty */
    char target_status;   /* L lost, Q being acquired, T tracked; 0 empty */
    struct {
        int count, index, sequence; /* sequence -1: none */
        char channel;               /* 0: none */
        char payload[PEL_NMEA_MAX_SENTENCE];
        int fill;
    } ais; /* VDM, VDO */
};

/* Reads one line without its CR LF. `out` is whole on OK only. */
enum pel_nmea_error pel_nmea_parse(const char *line, size_t length,
                                   struct pel_nmea_sentence *out);

/* Name of a kind ("RMC") and of an error ("bad_checksum"), for metrics. */
const char *pel_nmea_kind_name(enum pel_nmea_kind kind);
const char *pel_nmea_error_name(enum pel_nmea_error error);

/* Cuts a stream into lines. Zero it before first use. */
struct pel_nmea_lines {
    char text[PEL_NMEA_MAX_SENTENCE + 1];
    size_t length;
    bool overlong; /* the rest of the line is thrown away */
};

typedef void (*pel_nmea_line_fn)(void *user, const char *line, size_t length);

/* Calls `fn` for each line completed by CR or LF, without them; empty lines
 * are skipped. Of a line longer than PEL_NMEA_MAX_SENTENCE its first
 * PEL_NMEA_MAX_SENTENCE + 1 characters are given, so that it is counted. */
void pel_nmea_lines_feed(struct pel_nmea_lines *lines, const char *bytes,
                         size_t size, pel_nmea_line_fn fn, void *user);

/* Gives what is left without a line end (the end of a datagram or a file). */
void pel_nmea_lines_end(struct pel_nmea_lines *lines, pel_nmea_line_fn fn,
                        void *user);
