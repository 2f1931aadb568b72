/* The daemon's options: one table for the command line, the key file, help,
 * manual page, completion and example. Main thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/err.h"

#define PEL_OPTION_TEXT 256
#define PEL_OPTIONS_MOST 128

enum pel_option_kind {
    PEL_OPTION_TEXT_KIND, /* any text */
    PEL_OPTION_ADDRESS,   /* ADDRESS:PORT, [IPV6]:PORT or off */
    PEL_OPTION_TARGET,    /* the same, or NAME:PORT */
    PEL_OPTION_LIST,      /* elements with commas between, or off */
    PEL_OPTION_PATH,      /* a file, or off */
    PEL_OPTION_DOUBLE,    /* or a word of `choices`, each with its value */
    PEL_OPTION_INT,
    PEL_OPTION_CHOICE, /* index of the word in `choices` */
    PEL_OPTION_FLAG,
};

/* Values, as the table fills them. Texts are "" where the option is off. */
struct pel_options {
    char http[PEL_OPTION_TEXT], tcp[PEL_OPTION_TEXT];
    char unix_path[PEL_OPTION_TEXT];
    char http_hosts[PEL_OPTION_TEXT], allow_origin[PEL_OPTION_TEXT];
    char trust_proxy[PEL_OPTION_TEXT];
    char whep_ports[PEL_OPTION_TEXT], whep_servers[PEL_OPTION_TEXT];
    char whep_peers[PEL_OPTION_TEXT];
    char rtsp[PEL_OPTION_TEXT];
    char token_file[PEL_OPTION_TEXT];
    char tls_cert[PEL_OPTION_TEXT], tls_key[PEL_OPTION_TEXT];
    bool plain;
    char modbus[PEL_OPTION_TEXT], modbus_allow[PEL_OPTION_TEXT];
    int modbus_order, modbus_clients, modbus_framing;
    char modbus_units[PEL_OPTION_TEXT], modbus_safe[PEL_OPTION_TEXT];
    int modbus_heartbeat_ms, modbus_extrapolate_ms;
    char console[PEL_OPTION_TEXT], console_table[PEL_OPTION_TEXT];
    int console_order, console_unit, console_timeout_ms, console_stale_ms;
    double console_rate;
    char nmea[PEL_OPTION_TEXT], nmea_allow[PEL_OPTION_TEXT];
    char nmea_tcp[PEL_OPTION_TEXT];
    int nmea_entity, nmea_wind, nmea_checksum, nmea_targets;
    char nmea_out[PEL_OPTION_TEXT];
    double nmea_out_rate;
    int nmea_out_targets;
    bool nmea_ais;
    char cigi[PEL_OPTION_TEXT], cigi_host[PEL_OPTION_TEXT];
    char cigi_allow[PEL_OPTION_TEXT], cigi_entities[PEL_OPTION_TEXT];
    int cigi_database;
    double cigi_rate, cigi_silence_s;
    int cigi_gone;
    char state[PEL_OPTION_TEXT], record[PEL_OPTION_TEXT];
    double record_segment_mib;
    int record_keep, journal_full;
    double record_days;
    int waves;
    char spectra[PEL_OPTION_TEXT], bathymetry[PEL_OPTION_TEXT];
    char weather[PEL_OPTION_TEXT];
    char panoramas[PEL_OPTION_TEXT], recordings[PEL_OPTION_TEXT];
    char exercises[PEL_OPTION_TEXT];
    char models[PEL_OPTION_TEXT];
    char exercise[PEL_OPTION_TEXT], exercise_node[PEL_OPTION_TEXT];
    char exercise_address[PEL_OPTION_TEXT];
    char exercise_cert[PEL_OPTION_TEXT], exercise_key[PEL_OPTION_TEXT];
    char exercise_ca[PEL_OPTION_TEXT];
    int exercise_rank;
    bool exercise_spare;
    int exercise_stray;
    double exercise_clock_ms;
    char device[PEL_OPTION_TEXT];
    double fps, quality; /* quality: 0 is auto */
    int encoder_threads;
    char video_encoder[PEL_OPTION_TEXT];
    char shader_dir[PEL_OPTION_TEXT];
    bool gl_debug;
    int gl_lose, gl_lose_device;
    bool gl_lose_for_good;
    int shading, reflection;
    int realtime;   /* enum pel_realtime */
    int log_level;  /* enum pel_log_level */
    int log_format; /* enum pel_log_format */
    /* Where the value of each row of the table is from: a file's path, "the
     * command line"; NULL: its default. Those of argv, and static ones. */
    const char *from[PEL_OPTIONS_MOST];
};

struct pel_option {
    const char *name;    /* --name, and the key in the key file */
    const char *section; /* group of the key file, heading of the help */
    enum pel_option_kind kind;
    const char *argument;    /* how the value is shown, "" for a flag */
    const char *initial;     /* default, as it would be given */
    double minimum, maximum; /* of DOUBLE and INT */
    const char *unit;
    /* Tests an element of a LIST: NULL where it is good, else the fault in
     * words. Absent: the user of the option tests it. */
    const char *(*element)(const char *text);
    bool secret;                /* has passwords, which are not printed */
    const char *const *choices; /* NULL-terminated, for CHOICE and DOUBLE */
    const double *values;       /* of the words of a DOUBLE */
    bool live;                  /* SIGHUP changes it, else a restart does */
    size_t offset;              /* in struct pel_options */
    const char *help;           /* a sentence */
};

/* Ends with a NULL name; sections are together. */
extern const struct pel_option pel_option_table[];

/* The same for developers: `name` is a variable of the environment, which is
 * read at a start alone; described by the manual page only. */
extern const struct pel_option pel_developer_table[];

/* What the command line asks for besides values. */
enum pel_options_action {
    PEL_ACTION_RUN,
    PEL_ACTION_HELP,
    PEL_ACTION_VERSION,
    PEL_ACTION_MAN,
    PEL_ACTION_COMPLETION,
    PEL_ACTION_CONFIG,
    PEL_ACTION_CHECK,
};

void pel_options_init(struct pel_options *options); /* defaults */

/* Defaults, then the key file that --config names, then the command line.
 * On refusal *fault's message names option, value and legal range. */
PEL_CHECK enum pel_err pel_options_read(int argc, char **argv,
                                        struct pel_options *options,
                                        enum pel_options_action *action,
                                        struct pel_fault *fault);

/* Sets one option from text; `where` ("--fps", "FILE: [render] fps") begins
 * the message of a refusal. */
PEL_CHECK enum pel_err pel_option_set(const struct pel_option *option,
                                      const char *value, const char *where,
                                      struct pel_options *options,
                                      struct pel_fault *fault);

/* What only the options together say: networks that are not loopback. */
PEL_CHECK enum pel_err pel_options_check(const struct pel_options *options,
                                         struct pel_fault *fault);

/* Whether the option has the same value in both. */
bool pel_option_equal(const struct pel_option *option,
                      const struct pel_options *a, const struct pel_options *b);

/* Says in the log which values differ, and which of them wait for a restart. */
void pel_options_log_changes(const struct pel_options *from,
                             const struct pel_options *to);

/* The elements of a LIST's value as the options keep it, for g_strfreev();
 * NULL: there are none. */
char **pel_options_split(const char *list);

/* Reads a list: blanks around elements go, an empty element or one that is not
 * good is refused, with why. `out` may not be the value. */
PEL_CHECK enum pel_err pel_options_list(const struct pel_option *option,
                                        const char *value,
                                        char out[PEL_OPTION_TEXT], char *why,
                                        size_t why_size);

/* Tests of elements (options_list.c); see `element`. */
const char *pel_options_host(const char *text);
const char *pel_options_origin(const char *text);
const char *pel_options_numeric(const char *text);
const char *pel_options_network(const char *text);
const char *pel_options_relay(const char *text);
const char *pel_options_device(const char *text);
const char *pel_options_outlet(const char *text);

/* The value as it would be given. */
void pel_option_text(const struct pel_option *option,
                     const struct pel_options *options,
                     char out[PEL_OPTION_TEXT]);

/* Splits FIRST-LAST, 1 .. 65535, in order; false: not that. */
bool pel_options_split_ports(const char *text, uint16_t *first, uint16_t *last);

/* Made from the table (options_print.c). */
void pel_options_print_help(FILE *to);
void pel_options_print_man(FILE *to);
void pel_options_print_completion(FILE *to); /* bash */
/* A key file of what is in force, with where each value is from; passwords are
 * left out. */
void pel_options_print_config(FILE *to, const struct pel_options *options);
