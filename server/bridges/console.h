/* The Modbus client: polls the registers of a console and sets fields of the
 * scene through a table. Control thread; nothing here waits. */
#pragma once

#include <stdint.h>

#include "base/err.h"
#include "base/metrics.h"
#include "bridges/console_table.h"
#include "scene/scene.h"

enum pel_console_state {
    PEL_CONSOLE_NEVER, /* no whole poll yet */
    PEL_CONSOLE_LIVE,
    PEL_CONSOLE_STALE, /* no whole poll for options.stale_ms */
};

struct pel_console_options {
    const char *server;     /* "127.0.0.1:502", "plc.example:502" */
    const char *table_path; /* the file; or: */
    const char *table;      /* its text, where table_path is NULL */
    enum pel_modbus_order order;
    double rate_hz;              /* polls a second, 0.1..100 */
    int unit;                    /* 0..255 */
    int timeout_ms;              /* of a connection, of an answer, 10..10000 */
    int stale_ms;                /* 100..60000 */
    struct pel_metrics *metrics; /* may be NULL */
};

struct pel_console_options pel_console_default_options(void);

struct pel_console_counters {
    uint64_t connections, failures; /* made; lost or not made */
    uint64_t polls, requests;       /* whole; answered */
    uint64_t exceptions, timeouts, malformed;
    uint64_t edits, refused_edits, out_of_range, stale;
};

/* Reads the table and begins to connect. An unreachable console is no
 * error: the connection is tried again after 0.25 s, then twice as long each
 * time, at most 8 s. INVALID: options or table; IO: the table cannot be read.
 */
struct pel_console;
PEL_CHECK enum pel_err
pel_console_create(const struct pel_console_options *options,
                   struct pel_scene *scene, struct pel_console **out,
                   struct pel_fault *fault);
void pel_console_destroy(struct pel_console *console); /* NULL allowed */

enum pel_console_state pel_console_state(const struct pel_console *console);
const struct pel_console_counters *
pel_console_counters(const struct pel_console *console);
