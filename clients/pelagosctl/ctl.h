/* pelagosctl: what its commands share. One command runs in one process, on one
 * thread unless a command says otherwise. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "lib/pelagos.h"

/* Exit statuses; part of the interface, listed in the manual. */
enum ctl_exit {
    CTL_DONE = 0,
    CTL_FAILED = 1,      /* here: a file, a missing encoder, an interruption */
    CTL_USAGE = 2,       /* the command line is wrong */
    CTL_UNREACHABLE = 3, /* pelagosd does not answer */
    CTL_REFUSED = 4,     /* pelagosd refused; nothing was changed */
};

struct ctl_option {
    char letter;       /* 0: long form only */
    const char *name;  /* NULL ends a list */
    const char *arg;   /* word for the value in the help; NULL: a flag. With ...
                        * it may be given again: values with ; between */
    const char *help;  /* a sentence without its full stop */
    const char *words; /* its values, by spaces, or NULL */
};

struct ctl;

/* The one table that parsing, help, manual and completion are made from. */
struct ctl_command {
    const char *name;
    const char *arguments;            /* synopsis after the options */
    const char *summary;              /* one line */
    const char *text;                 /* paragraphs, parted by an empty line */
    const struct ctl_option *options; /* NULL: none of its own */
    const char *const *examples;      /* "command\nwhat it does", or NULL */
    const char *completes; /* "paths", "views", "files": what arguments are */
    size_t least, most;    /* arguments; most SIZE_MAX: any number */
    enum ctl_exit (*run)(struct ctl *ctl);
};

extern const struct ctl_command ctl_commands[]; /* ends with name NULL */
extern const struct ctl_option ctl_global_options[];

#define CTL_MAX_OPTIONS 64

struct ctl {
    const struct ctl_command *command;
    const char *values[CTL_MAX_OPTIONS]; /* global, then own; NULL: absent */
    const char **args;
    size_t arg_count;
    struct pel_client *client; /* from ctl_connect */
};

/* ctl_options.c: the command line. */

/* Parses argv[1..] into *ctl; USAGE after having said why. */
enum ctl_exit ctl_parse(struct ctl *ctl, int argc, char **argv);
const struct ctl_command *ctl_find_command(const char *name);

/* Says that there is no such command, and which is meant; USAGE. */
enum ctl_exit ctl_no_command(const char *name);
/* The option's value; "" for a flag that is set; NULL: absent. */
const char *ctl_value(const struct ctl *ctl, const char *name);
bool ctl_flag(const struct ctl *ctl, const char *name);
/* A number within [minimum, maximum] into *out, which keeps its value when the
 * option is absent; USAGE after having said why. */
enum ctl_exit ctl_number(const struct ctl *ctl, const char *name,
                         double minimum, double maximum, double *out);
/* The whole of `text` as a finite number. */
bool ctl_parse_number(const char *text, double *out);

/* ctl_report.c: errors that say what to do. */

/* printf of texts that others wrote: control characters, which a terminal would
 * obey, and bytes that are no UTF-8 become '?'. */
void ctl_print(FILE *out, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* "pelagosctl: …" by ctl_print on standard error; returns `status`. */
enum ctl_exit ctl_say(enum ctl_exit status, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* An error of libpelagos, with range, unit, nearest path and hint. */
enum ctl_exit ctl_report(struct ctl *ctl, const struct pel_client_error *error);
/* A fault found here while reading a path or a value. */
struct pel_fault;
enum ctl_exit ctl_report_fault(struct ctl *ctl, const struct pel_fault *fault);
/* Connects to --server; every other command of the client follows. */
enum ctl_exit ctl_connect(struct ctl *ctl);
/* Sends the patch and says on standard error what it switched off besides;
 * *out (NULL allowed): the state after it. */
enum ctl_exit ctl_patch(struct ctl *ctl, const Pelagos__Patch *patch,
                        Pelagos__State **out);
/* ctl_connect and the state. */
enum ctl_exit ctl_fetch(struct ctl *ctl, Pelagos__State **out);

/* nearest.c: the word of `words` that `text` was meant to be; NULL: none is
 * near. Edit distance with neighbours swapped (Damerau). */
const char *ctl_nearest(const char *text, const char *const *words,
                        size_t count);

/* beside.c: the path of a program beside this one, of its libexec or of the
 * PATH; NULL: there is none; g_free(). */
char *ctl_beside(const char *program);

/* flatten.c: a state as its leaves, in the schema's order. */
struct ctl_leaf {
    char *path;
    char *value;
    const char *unit; /* "" for numbers without one and for words */
    bool quoted;      /* a string or a word: quotes in JSON */
};
struct ctl_leaves {
    struct ctl_leaf *items;
    size_t count;
};
struct ctl_leaves ctl_flatten(const Pelagos__State *state);
void ctl_leaves_free(struct ctl_leaves *leaves);
/* A path as ctl_flatten spells it: `view.` to `views.`, names of entities to
 * ids, wind_speed to windSpeed; g_free(). */
char *ctl_canonical_path(const Pelagos__State *state, const char *path);
/* Whether `path` is `prefix` or lies below it. */
bool ctl_path_below(const char *path, const char *prefix);
/* "path = value unit" or, for JSON, {"path":…,"value":…}, and a line end. */
void ctl_print_leaf(FILE *out, const struct ctl_leaf *leaf, bool json);
/* `text` as a JSON string. */
void ctl_print_string(FILE *out, const char *text);

/* ctl_state.c: adds PATH=VALUE to the patch; USAGE after having said why.
 * *path: the PATH, g_free(). */
enum ctl_exit ctl_assign(struct ctl *ctl, Pelagos__Patch *patch,
                         const Pelagos__State *now, const char *text,
                         char **path);

/* ctl_help.c, ctl_completion.c */
void ctl_print_help(FILE *out, const struct ctl_command *command);
void ctl_print_manual(FILE *out);
enum ctl_exit ctl_completion(struct ctl *ctl);
enum ctl_exit ctl_complete(struct ctl *ctl);
enum ctl_exit ctl_help(struct ctl *ctl);
enum ctl_exit ctl_manual(struct ctl *ctl);

/* The commands. */
enum ctl_exit ctl_get(struct ctl *ctl);
enum ctl_exit ctl_set(struct ctl *ctl);
enum ctl_exit ctl_unset(struct ctl *ctl);
enum ctl_exit ctl_watch(struct ctl *ctl);
enum ctl_exit ctl_views(struct ctl *ctl);
enum ctl_exit ctl_step(struct ctl *ctl);
enum ctl_exit ctl_frame(struct ctl *ctl);
enum ctl_exit ctl_surface(struct ctl *ctl);
enum ctl_exit ctl_replay(struct ctl *ctl);
/* replay, where the file is a command log. */
enum ctl_exit ctl_replay_log(struct ctl *ctl);
enum ctl_exit ctl_spectrum(struct ctl *ctl);
enum ctl_exit ctl_plot(struct ctl *ctl);
enum ctl_exit ctl_record(struct ctl *ctl);
enum ctl_exit ctl_exercise(struct ctl *ctl);
enum ctl_exit ctl_cluster(struct ctl *ctl);
enum ctl_exit ctl_models(struct ctl *ctl);
enum ctl_exit ctl_recordings(struct ctl *ctl);
enum ctl_exit ctl_debrief(struct ctl *ctl);
enum ctl_exit ctl_model(struct ctl *ctl);
enum ctl_exit ctl_preset(struct ctl *ctl);
enum ctl_exit ctl_bench(struct ctl *ctl);
enum ctl_exit ctl_optics(struct ctl *ctl);
enum ctl_exit ctl_dataset(struct ctl *ctl);
/* ctl_series.c: where --sweep is given, asks the series of the question that
 * *query has, and prints or writes it as --format and --output say. */
enum ctl_exit ctl_series(struct ctl *ctl, Pelagos__SeriesQuery *query);
/* One of its options is given. */
bool ctl_wants_series(const struct ctl *ctl);
/* Into a file, or to standard output where `file` is NULL. */
enum ctl_exit ctl_put(const char *file, const void *data, size_t size);
#define CTL_SERIES_OPTIONS                                                       \
    { 0, "sweep", "AXIS...",                                                     \
      "The question at each value of NAME=FIRST:LAST:STEP or NAME=VALUE,…, a " \
      "number of the question or of the state; again for another axis",          \
      NULL },                                                                    \
        { 0, "format", "FORM", "Of the table or file (csv)",                     \
          "csv json netcdf" },                                                   \
    {                                                                            \
        'o', "output", "FILE",                                                   \
            "Into a file, its format by its ending (.csv, .json, "               \
            ".nc)",                                                              \
            NULL                                                                 \
    }
/* optics brdf, optics sky. */
enum ctl_exit ctl_light(struct ctl *ctl);

/* ctl_way.c: has the view go the way of --waypoints; simulated times of its
 * beginning and end. */
enum ctl_exit ctl_way(struct ctl *ctl, const char *view, double *first_s,
                      double *last_s);

/* ctl_sequence.c: record, where FILE is one of a numbered sequence. `request`
 * has the view and the size. */
bool ctl_sequence_is(const char *path);
enum ctl_exit ctl_record_sequence(struct ctl *ctl, double fps, size_t wanted,
                                  const Pelagos__FrameRequest *request);

/* Set by SIGINT and SIGTERM once ctl_catch_signals has been called: commands
 * that run on end their loop and tidy up. */
extern volatile int ctl_interrupted;
void ctl_catch_signals(void);
