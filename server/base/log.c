#include "base/log.h"

#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/text.h"

static _Atomic int max_level = PEL_LOG_INFO;

void pel_log_set_level(enum pel_log_level level)
{
    atomic_store(&max_level, (int)level);
}

static _Atomic int form = PEL_LOG_AUTO;

void pel_log_set_format(enum pel_log_format format)
{
    atomic_store(&form, (int)format);
}

/* Whether journald reads what this process writes: it names the device and
 * inode of its socket, which a program that we are started by may have
 * redirected (systemd.exec(5)). */
static bool journald_reads(void)
{
    const char *stream = getenv("JOURNAL_STREAM");
    unsigned long long device, inode;
    struct stat own;
    return stream && sscanf(stream, "%llu:%llu", &device, &inode) == 2 &&
           fstat(STDERR_FILENO, &own) == 0 && own.st_dev == device &&
           own.st_ino == inode;
}

static const char *const names[] = { "error", "warning", "info", "debug" };

static void say_time(char out[32], long long unix_ns)
{
    char seconds[24];
    time_t whole = (time_t)(unix_ns / 1000000000);
    struct tm utc;
    gmtime_r(&whole, &utc);
    strftime(seconds, sizeof seconds, "%Y-%m-%dT%H:%M:%S", &utc);
    snprintf(out, 32, "%s.%03dZ", seconds, (int)(unix_ns / 1000000 % 1000));
}

/* `text` is clean: only quotes and backslashes are special. */
static void quote(char *out, size_t size, const char *text)
{
    size_t used = 0;
    for (; *text && used + 3 < size; text++) {
        if (*text == '"' || *text == '\\') {
            out[used++] = '\\';
        }
        out[used++] = *text;
    }
    out[used] = '\0';
}

size_t pel_log_line(char out[PEL_LOG_LINE], enum pel_log_format format,
                    long long unix_ns, enum pel_log_level level, const char *id,
                    char *text, unsigned held)
{
    static const int priorities[] = { 3, 4, 6, 7 };
    char when[32], quoted[2100], more[48] = "";
    int length;
    pel_text_clean(text); /* a record is one line, whatever it quotes */
    if (held > 0) {
        snprintf(more, sizeof more, " (and %u like it before)", held);
    }
    say_time(when, unix_ns);
    switch (format) {
    case PEL_LOG_JSON:
        quote(quoted, sizeof quoted, text);
        snprintf(more, sizeof more, held > 0 ? ",\"held\":%u" : "", held);
        length = snprintf(out, PEL_LOG_LINE,
                          "{\"time\":\"%s\",\"level\":\"%s\",\"id\":\"%s\","
                          "\"text\":\"%s\"%s}\n",
                          when, names[level], id, quoted, more);
        break;
    case PEL_LOG_JOURNAL:
        length = snprintf(out, PEL_LOG_LINE, "<%d>%s %s %s%s\n",
                          priorities[level], names[level], id, text, more);
        break;
    case PEL_LOG_AUTO:
    case PEL_LOG_TEXT:
    default:
        length = snprintf(out, PEL_LOG_LINE, "%s %s %s %s%s\n", when,
                          names[level], id, text, more);
        break;
    }
    return (size_t)length;
}

static void write_record(enum pel_log_level level, const char *id,
                         const char *format, va_list args, unsigned held)
{
    char text[1024], line[PEL_LOG_LINE];
    enum pel_log_format own = (enum pel_log_format)atomic_load(&form);
    if (own == PEL_LOG_AUTO) {
        own = journald_reads() ? PEL_LOG_JOURNAL : PEL_LOG_TEXT;
        atomic_store(&form, (int)own);
    }
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    vsnprintf(text, sizeof text, format, args);
    size_t length =
        pel_log_line(line, own, now.tv_sec * 1000000000LL + now.tv_nsec, level,
                     id, text, held);
    /* One call, so that records of different threads do not interleave. */
    fwrite(line, 1, length, stderr);
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
