#include "base/log.h"

#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/text.h"

static _Atomic int max_level = PEL_LOG_INFO;

void pel_log_set_level(enum pel_log_level level)
{
    atomic_store(&max_level, (int)level);
}

static void write_record(enum pel_log_level level, const char *id,
                         const char *format, va_list args, unsigned held)
{
    static const char *const names[] = { "error", "warning", "info", "debug" };
    static const int priorities[] = { 3, 4, 6, 7 };
    char text[1024];
    vsnprintf(text, sizeof text, format, args);
    pel_text_clean(text); /* a record is one line, whatever it quotes */
    char more[48] = "";
    if (held > 0) {
        snprintf(more, sizeof more, " (and %u like it before)", held);
    }
    char prefix[8] = "";
    if (getenv("JOURNAL_STREAM")) {
        snprintf(prefix, sizeof prefix, "<%d>", priorities[level]);
    }
    /* One call, so that records of different threads do not interleave. */
    fprintf(stderr, "%s%s %s %s%s\n", prefix, names[level], id, text, more);
}

void pel_log(enum pel_log_level level, const char *id, const char *format, ...)
{
    if ((int)level > atomic_load(&max_level)) {
        return;
    }
    va_list args;
    va_start(args, format);
    write_record(level, id, format, args, 0);
    va_end(args);
}

void pel_log_limited(struct pel_log_limit *state, enum pel_log_level level,
                     const char *id, const char *format, ...)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* all limits */
    long long now = pel_now_ns();
    pthread_mutex_lock(&lock);
    bool hold = state->last_ns != 0 && now - state->last_ns < 1000000000LL;
    unsigned held = state->held;
    state->held = hold ? held + 1 : 0;
    if (!hold) {
        state->last_ns = now;
    }
    pthread_mutex_unlock(&lock);
    if (hold || (int)level > atomic_load(&max_level)) {
        return;
    }
    va_list args;
    va_start(args, format);
    write_record(level, id, format, args, held);
    va_end(args);
}
