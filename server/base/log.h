/* The log: one line a record on standard error (with journald's priority
 * prefix when it reads us), `<level> TOPIC-NNN text with units`. Any thread. */
#pragma once

enum pel_log_level {
    PEL_LOG_ERROR,
    PEL_LOG_WARNING,
    PEL_LOG_INFO,
    PEL_LOG_DEBUG,
};

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
