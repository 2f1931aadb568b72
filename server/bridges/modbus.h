/* Modbus/TCP server: the registers of proto/registers.def on the scene.
 * Control thread only; the map for people is proto/registers.md.
 *
 * Writes are staged, readable back at once, and take effect together in one
 * edit: when 1 is written to the commit register, alone or inside a
 * write-multiple request. A value out of range gets exception 03, an address
 * that is not there (or half a 32-bit value) exception 02, and then nothing of
 * the request is staged. Each unit has a stage, for all connections, as a
 * client may connect anew for each write (mbpoll does), and a heartbeat.
 *
 * libmodbus makes the answers; it owns no socket of a client. ADUs are framed
 * here without blocking: whole within request_ms of their first byte, protocol
 * id 0, length 2..254, a unit that is ours. A connection that sends anything
 * else, or takes no answer for 5 s, is closed, counted and logged. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "registers.h"

struct pel_exercises;
struct pel_metrics;
struct pel_modbus;
struct pel_scene;

/* What the input registers and alarms show of the daemon's other parts. */
struct pel_modbus_status {
    uint64_t frame_number;
    double frames_per_s, render_ms;
    bool frames_stalled; /* no frame for 2 s */
    bool nmea_stale;
    uint64_t nmea_sentences, nmea_errors;
};

struct pel_modbus_options {
    const char *listen; /* ADDRESS:PORT; NULL: no socket, feed only */
    const char *allow;  /* peers, `10.0.0.7,192.168.1.0/24`; NULL: loopback.
                         * Any other `listen` than loopback needs it */
    bool rtu;           /* frames of RTU in the stream: modbus_rtu.h */
    enum pel_modbus_order order; /* of units that say no other */
    const char *units;           /* pel_modbus_units_read (modbus_units.h) */
    int max_clients;             /* 1..256 */
    /* A request that is not whole so long after its first byte closes its
     * connection: a transparent serial converter at 1200 baud needs 2.2 s for
     * the longest of 260 bytes. */
    int request_ms;
    int heartbeat_ms;   /* silence that makes the source stale, 100..60000 */
    int extrapolate_ms; /* then the scene reckons on for so long, 0..60000 */
    const char *safe;   /* then it stops, and these fields are set:
                         * pel_modbus_safe_read */
    struct pel_metrics *metrics;     /* NULL: none are shown */
    struct pel_exercises *exercises; /* NULL: there are none */
    /* Fills the status; NULL: zeros. */
    void (*status)(void *user, struct pel_modbus_status *status);
    void *user;
};

/* 127.0.0.1:1502, ABCD, any unit, 32 clients, requests whole in 5000 ms,
 * heartbeats within 1000 ms, then 5000 ms. */
struct pel_modbus_options pel_modbus_default_options(void);

enum pel_modbus_source {
    PEL_MODBUS_NEVER, /* no heartbeat yet: no watch either */
    PEL_MODBUS_LIVE,
    PEL_MODBUS_STALE, /* silent; the ship is reckoned on */
    PEL_MODBUS_HELD,  /* silent for longer; its ship stopped where it was, and
                       * the safe values were set */
};

struct pel_modbus_counters {
    uint64_t accepted, refused_clients, requests;
    uint64_t exceptions[12]; /* by code: 1 function, 2 address, 3 value, ... */
    uint64_t malformed;      /* bad protocol id, length or form */
    uint64_t late;           /* ADUs not whole in time */
    uint64_t stalled;        /* answers not taken in time */
    uint64_t wrong_unit;
    uint64_t commits, refused_commits, heartbeats, stale;
};

/* Listens in the default GMainContext. Errors: IO (port taken), INVALID. */
PEL_CHECK enum pel_err
pel_modbus_create(const struct pel_modbus_options *options,
                  struct pel_scene *scene, struct pel_modbus **out,
                  struct pel_fault *fault);
void pel_modbus_destroy(struct pel_modbus *modbus); /* NULL allowed */

const struct pel_modbus_counters *
pel_modbus_counters(const struct pel_modbus *modbus);
size_t pel_modbus_clients(const struct pel_modbus *modbus);
/* Of the first unit. */
enum pel_modbus_source pel_modbus_source(const struct pel_modbus *modbus);

/* The port bound (useful after port 0), 0 without a socket. */
uint16_t pel_modbus_port(const struct pel_modbus *modbus);

/* A connection without a socket, for tests and fuzzing: the bytes of a stream
 * go in, the answers come out. */
struct pel_modbus_session;
struct pel_modbus_session *pel_modbus_session_open(struct pel_modbus *modbus);
void pel_modbus_session_close(struct pel_modbus_session *session);

/* Returns the size of the answers written to `answer` (as many as fit), or -1
 * when the stream is not Modbus and must be closed. */
long pel_modbus_session_feed(struct pel_modbus_session *session,
                             const uint8_t *bytes, size_t size, uint8_t *answer,
                             size_t answer_size);
