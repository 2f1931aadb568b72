/* NMEA 0183 to the scene: a UDP port whose sentences move one entity, set the
 * wind and, if wanted, show the targets of AIS and radar. Control thread only.
 *
 * Sentences are listed in nmea_sentences.def. Where several give the same
 * value, the first of these that came within the last 10 s counts:
 *   position   RMC, GGA, GNS, GLL, AIS VDO (a void fix keeps the last one)
 *   heading    HDT, THS, PASHR, HDG (+ deviation + variation), HDM (+ the last
 *              known variation), VHW, VDO, the course while faster than 0.5 m/s
 *   course, speed   RMC and VTG, VDO, VHW (through water)
 *   turn rate  ROT, VDO
 *   wind       MWD, MWV true, MWV relative made true by heading, course, speed
 * Heel (roll, starboard down positive), trim (pitch, bow up positive) come from
 * XDR and PASHR, heave (altitude, up positive) from PASHR.
 *
 * The sentences of one datagram are one edit. Poses carry the scene's time of
 * receipt, and the scene reckons onward from them. 60 s after the last fix the
 * ship is stopped where it is, if its speed and rate of turn are still those
 * that NMEA set: a ship that own ship's model, another bridge or a client moves
 * by then is left alone. A log replayed at speed X wants clock.rate X
 * meanwhile, or reckoning falls behind between fixes. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "bridges/nmea_parse.h"
#include "bridges/nmea_targets.h"

struct pel_metrics;
struct pel_nmea;
struct pel_scene;

enum pel_nmea_wind {
    PEL_NMEA_WIND_OFF,   /* the wind of sentences is only counted */
    PEL_NMEA_WIND_GIVEN, /* each sentence that differs from the one before */
    PEL_NMEA_WIND_MEAN,  /* its mean over 120 s of simulated time, each time
                          * that has moved by 0.5 m/s or 5 deg: the waves of
                          * the sea then stay the same through a gust */
};

struct pel_nmea_options {
    const char *listen; /* ADDRESS:PORT of UDP; NULL: no socket, feed only */
    const char *allow;  /* senders, `10.0.0.7,192.168.1.0/24`; NULL: loopback.
                         * Any other `listen` than loopback needs it */
    uint32_t entity;    /* id of the entity moved, 0..65535 */
    enum pel_nmea_wind wind;
    bool no_checksum; /* sentences may lack theirs */
    bool ais;         /* targets become entities 20000 and up: nmea_targets.h */
    int targets; /* of AIS that are kept, PEL_NMEA_TARGETS .. PEL_NMEA_FLEET */
    struct pel_metrics *metrics; /* NULL: none are shown */
};

/* entity 1, wind as given, no AIS targets, 127.0.0.1:10110. */
struct pel_nmea_options pel_nmea_default_options(void);

struct pel_nmea_counters {
    uint64_t datagrams;         /* of allowed senders */
    uint64_t refused_datagrams; /* sender not in the list, or > 4096 bytes */
    uint64_t sentences;         /* read and understood, by kind: */
    uint64_t kinds[PEL_NMEA_KIND_COUNT];
    uint64_t errors[PEL_NMEA_ERROR_COUNT];
    uint64_t out_of_range;  /* values dropped */
    uint64_t void_fixes;    /* position sentences without a fix */
    uint64_t edits;         /* commits to the scene */
    uint64_t refused_edits; /* the scene said no */
    uint64_t ais_messages;  /* decoded */
    uint64_t ais_ignored;   /* other types, unknown parts, damaged */
    uint64_t late;          /* datagrams behind a newer one of the same clock */
    uint64_t unchecked; /* sentences without a checksum, taken all the same */
    uint64_t resynchronised; /* read after what a broken line left */
    struct pel_nmea_target_counters targets;
};

/* Fresh: came within the last 10 s of wall time. */
struct pel_nmea_status {
    bool fix_fresh, heading_fresh, attitude_fresh, wind_fresh;
    bool stale;                 /* had a fix once, has none now */
    double fix_age_s;           /* -1: never had one */
    double depth_m;             /* below transducer plus offset, NaN: unknown */
    double rudder_deg;          /* RSA, starboard positive, NaN: unknown */
    size_t targets;             /* of AIS and radar, shown */
    size_t known;               /* those, and of AIS those not shown */
    uint64_t sentences, errors; /* taken; of any kind */
};

/* Opens the port in the default GMainContext. Errors: IO (port taken), INVALID
 * (address, allow-list, entity). */
PEL_CHECK enum pel_err pel_nmea_create(const struct pel_nmea_options *options,
                                       struct pel_scene *scene,
                                       struct pel_nmea **out,
                                       struct pel_fault *fault);
void pel_nmea_destroy(struct pel_nmea *nmea); /* NULL allowed */

/* Treats bytes as one datagram of an allowed sender. */
void pel_nmea_feed(struct pel_nmea *nmea, const void *bytes, size_t size);

/* Treats bytes as the next of a stream, whose unfinished line is in `lines`. */
void pel_nmea_feed_stream(struct pel_nmea *nmea, struct pel_nmea_lines *lines,
                          const void *bytes, size_t size);

/* What silence changes by now_ns (CLOCK_MONOTONIC): stale marks, the stop,
 * targets that go. A timer does it once a second; tests give times to come. */
void pel_nmea_tick(struct pel_nmea *nmea, int64_t now_ns);

const struct pel_nmea_counters *pel_nmea_counters(const struct pel_nmea *nmea);
void pel_nmea_status(const struct pel_nmea *nmea,
                     struct pel_nmea_status *status);

/* The port bound (useful after port 0), 0 without a socket. */
uint16_t pel_nmea_port(const struct pel_nmea *nmea);
