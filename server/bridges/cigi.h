/* CIGI 3.3 on UDP: an image generator for one simulator host. Each datagram of
 * the host is one edit of the scene and a step of its time; requests are
 * answered from the sea of that moment. proto/cigi.md says what each field
 * does. Control thread only.
 *
 * The host leads simulated time (clock.mode HOST, set when it is first heard):
 * by its timestamps where they are valid, else by its frame numbers at
 * `rate_hz`. Datagrams that are late or double are counted and dropped; where
 * the host's are missing, time goes on by itself for at most 1 s. A host
 * unheard for 2 s is gone and `sources.cigiStale`; the next datagram begins
 * anew, from any allowed address. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "bridges/cigi_packet.h"

struct pel_cigi;
struct pel_exercises;
struct pel_metrics;
struct pel_scene;

struct pel_cigi_options {
    const char *listen;   /* ADDRESS:PORT of UDP; NULL: no socket, feed only */
    const char *host;     /* ADDRESS:PORT that is sent to, from the start on;
                           * NULL: the sender of the newest datagram */
    const char *allow;    /* as pel_nmea_options */
    const char *entities; /* a table of types (cigi_types.h); NULL: none */
    int database;         /* number that can be loaded, 1..127; 0: any */
    double rate_hz;       /* Start of Frame, 1..240 */
    double silence_s;     /* the host is gone after it, 0.5..3600 */
    bool hold;            /* time stands while the host is gone; else clock.mode
                           * becomes what it was before the host, and what had
                           * rates stands */
    struct pel_exercises *exercises; /* NULL: there are none */
    struct pel_metrics *metrics;     /* NULL: none are shown */
};

/* 127.0.0.1:8000, any database, 60 Hz, 2 s. */
struct pel_cigi_options pel_cigi_default_options(void);

struct pel_cigi_counters {
    uint64_t datagrams;         /* of allowed senders */
    uint64_t refused_datagrams; /* sender not in the list, too long, or while
                                 * another host leads */
    uint64_t malformed[PEL_CIGI_ERROR_COUNT];
    uint64_t packets[PEL_CIGI_KIND_COUNT];
    uint64_t unknown_packets; /* ids that are not in the table */
    uint64_t skipped_packets; /* without their object, or beyond a limit */
    uint64_t duplicate, late; /* datagrams not applied */
    uint64_t lost;            /* host frames that never came in time */
    uint64_t edits, refused_edits;
    uint64_t frames;         /* Start of Frame sent */
    uint64_t skipped_frames; /* not sent: the process was late */
    uint64_t extrapolated;   /* frames while the host was late */
    uint64_t answers, dropped_answers;
    uint64_t told_dropped; /* times that the log was told of them */
    uint64_t unsent;       /* datagrams that the system refused */
};

struct pel_cigi_status {
    bool connected; /* heard within silence_s */
    uint32_t host_frame, ig_frame;
    int database; /* as in Start of Frame */
    double age_s; /* since the host was heard, -1: never */
};

/* Opens the port in the default GMainContext. Errors: IO (port taken), INVALID
 * (address, allow-list, database, rate). */
PEL_CHECK enum pel_err pel_cigi_create(const struct pel_cigi_options *options,
                                       struct pel_scene *scene,
                                       struct pel_cigi **out,
                                       struct pel_fault *fault);
void pel_cigi_destroy(struct pel_cigi *cigi); /* NULL allowed */

/* Treats bytes as one datagram of the host. */
void pel_cigi_feed(struct pel_cigi *cigi, const uint8_t *bytes, size_t size);

/* Puts one to those that become the next edit: at once with pel_cigi_feed, or
 * when as many have come as an edit takes. `bytes` stay until then. */
void pel_cigi_add(struct pel_cigi *cigi, const uint8_t *bytes, size_t size);

/* Waits for seas that are being built: for tests. */
void pel_cigi_settle(struct pel_cigi *cigi);

/* One frame: what the timer does. Returns the bytes of the datagram that
 * begins with Start of Frame, valid until the next call. */
size_t pel_cigi_frame(struct pel_cigi *cigi, const uint8_t **bytes);

/* The system refused that datagram: its answers come again with the next. */
void pel_cigi_not_sent(struct pel_cigi *cigi);

const struct pel_cigi_counters *pel_cigi_counters(const struct pel_cigi *cigi);
void pel_cigi_status(const struct pel_cigi *cigi,
                     struct pel_cigi_status *status);

/* The port bound (useful after port 0), 0 without a socket. */
uint16_t pel_cigi_port(const struct pel_cigi *cigi);
