/* The log: one line a record on standard error, `<level> TOPIC-NNN text with
 * units`, after the time, or after journald's priority where it reads us, which
 * has a time of its own. Any thread. */
#pragma once

#include <stddef.h>

enum pel_log_level {
    PEL_LOG_ERROR,
    PEL_LOG_WARNING,
    PEL_LOG_INFO,
    PEL_LOG_DEBUG,
};

/* As the option --log-format orders them. */
enum pel_log_format {
    PEL_LOG_AUTO, /* JOURNAL where JOURNAL_STREAM names standard error */
    PEL_LOG_TEXT, /* 2026-11-28T23:14:51.123Z info DMN-001 text */
    PEL_LOG_JSON, /* {"time":"…","level":"info","id":"DMN-001","text":"…"} */
    PEL_LOG_JOURNAL, /* <6>info DMN-001 text */
};

/* AUTO at start. Before other threads log. */
void pel_log_set_format(enum pel_log_format format);

/* One record as it is written, with the end of its line. unix_ns: its time.
 * Control characters in `text` are made harmless. */
#define PEL_LOG_LINE 3072
size_t pel_log_line(char out[PEL_LOG_LINE], enum pel_log_format format,
                    long long unix_ns, enum pel_log_level level, const char *id,
                    char *text, unsigned held);

/* Records above this level are dropped; INFO at start. */
void pel_log_set_level(enum pel_log_level level);

/* `id` is stable for ever, e.g. "SCN-003": people search for it. */
void pel_log(enum pel_log_level level, const char *id, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* At most one record of this call site a second; the next one says how many
 * were held back. `state` is a static struct of the call site. */
struct pel_log_limit {
    long long last_ns;
    unsigned held;
};
void pel_log_limited(struct pel_log_limit *state, enum pel_log_level level,
                     const char *id, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

#define pel_error(...) pel_log(PEL_LOG_ERROR, __VA_ARGS__)
#define pel_warn(...) pel_log(PEL_LOG_WARNING, __VA_ARGS__)
#define pel_info(...) pel_log(PEL_LOG_INFO, __VA_ARGS__)
#define pel_debug(...) pel_log(PEL_LOG_DEBUG, __VA_ARGS__)
