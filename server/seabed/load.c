#include "seabed/load.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "seabed/wire.h"

#define PROGRAM "pelagos-seabed"
#define MOST_WORDS 240 /* of the reader's complaint */

extern char **environ;

/* --- the reader ----------------------------------------------------------- */

struct reader {
    pid_t pid;
    int out, err; /* its standard output and error */
    unsigned char *bytes;
    size_t size, capacity;
    char words[MOST_WORDS + 1];
    size_t word_count;
};

static bool find_program(char path[4096])
{
    static const char *const places[] = { "", "../libexec/pelagos/" };
    char own[3072];
    ssize_t length = readlink("/proc/self/exe", own, sizeof own - 1);
    if (length <= 0) {
        return false;
    }
    own[length] = '\0';
    *strrchr(own, '/') = '\0';
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        snprintf(path, 4096, "%s/%s%s", own, places[i], PROGRAM);
        if (access(path, X_OK) == 0) {
            return true;
        }
    }
    return false;
}

static enum pel_err start(struct reader *r, char *const argv[],
                          struct pel_fault *fault)
{
    char program[4096];
    int out[2] = { -1, -1 }, err[2] = { -1, -1 };
    posix_spawn_file_actions_t actions;
    if (!find_program(program)) {
        return pel_fault_set(fault, PEL_ERR_IO,
                             "%s, which reads bathymetry, is not installed",
                             PROGRAM);
    }
    if (pipe2(out, O_CLOEXEC) || pipe2(err, O_CLOEXEC)) {
        int why = errno;
        if (out[0] >= 0) {
            close(out[0]);
            close(out[1]);
        }
        return pel_fault_set(fault, PEL_ERR_IO, "%s: %s", PROGRAM,
                             strerror(why));
    }
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, out[1], 1);
    posix_spawn_file_actions_adddup2(&actions, err[1], 2);
    int failed = posix_spawn(&r->pid, program, &actions, NULL, argv, environ);
    posix_spawn_file_actions_destroy(&actions);
    close(out[1]);
    close(err[1]);
    r->out = out[0];
    r->err = err[0];
    if (failed) {
        r->pid = 0;
        return pel_fault_set(fault, PEL_ERR_IO, "%s: %s", PROGRAM,
                             strerror(failed));
    }
    return PEL_OK;
}

/* Room for more bytes; false: more than a height field can be. */
static bool grow(struct reader *r)
{
    if (r->size < r->capacity) {
        return true;
    }
    size_t capacity = r->capacity ? 4 * r->capacity : 1 << 18;
    capacity = capacity < PEL_SEABED_WIRE_MOST + 1u ? capacity
                                                    : PEL_SEABED_WIRE_MOST + 1u;
    unsigned char *bytes =
        capacity > r->capacity ? realloc(r->bytes, capacity) : NULL;
    if (!bytes) {
        return false;
    }
    r->bytes = bytes;
    r->capacity = capacity;
    return true;
}

/* Takes what is there of one pipe; false: it has ended. */
static bool take(struct reader *r, int fd)
{
    ssize_t got;
    if (fd == r->out) {
        if (!grow(r)) {
            return false;
        }
        got = read(fd, r->bytes + r->size, r->capacity - r->size);
        r->size += got > 0 ? (size_t)got : 0;
    } else {
        char rest[64];
        bool full = r->word_count == MOST_WORDS;
        got = read(fd, full ? rest : r->words + r->word_count,
                   full ? sizeof rest : MOST_WORDS - r->word_count);
        r->word_count += got > 0 && !full ? (size_t)got : 0;
    }
    return got > 0 || (got < 0 && (errno == EINTR || errno == EAGAIN));
}

/* Until both pipes have ended; false: too late. */
static bool listen_to(struct reader *r)
{
    int64_t end_ns = pel_now_ns() + PEL_SEABED_LOAD_MS * 1000000LL;
    struct pollfd fds[] = { { r->out, POLLIN, 0 }, { r->err, POLLIN, 0 } };
    while (fds[0].fd >= 0 || fds[1].fd >= 0) {
        int64_t left_ms = (end_ns - pel_now_ns()) / 1000000;
        if (left_ms <= 0) {
            return false;
        }
        if (poll(fds, 2, (int)left_ms) < 0 && errno != EINTR) {
            return false;
        }
        for (int i = 0; i < 2; i++) {
            if (fds[i].fd >= 0 && fds[i].revents && !take(r, fds[i].fd)) {
                fds[i].fd = -1;
            }
        }
    }
    return true;
}

static void finish(struct reader *r)
{
    if (r->out >= 0) {
        close(r->out);
        close(r->err);
    }
    free(r->bytes);
}

/* Waits for the end of the process and says how it ended. */
static enum pel_err end(struct reader *r, bool in_time, const char *file,
                        struct pel_fault *fault)
{
    int status = 0;
    if (!in_time) {
        kill(r->pid, SIGKILL);
    }
    while (waitpid(r->pid, &status, 0) < 0 && errno == EINTR) {
    }
    while (r->word_count > 0 && r->words[r->word_count - 1] == '\n') {
        r->word_count--;
    }
    r->words[r->word_count] = '\0';
    if (!in_time) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%.80s: it was not read within %d s", file,
                             PEL_SEABED_LOAD_MS / 1000);
    }
    if (WIFSIGNALED(status)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%.80s: reading it ended with signal %d", file,
                             WTERMSIG(status));
    }
    if (WEXITSTATUS(status) != 0) {
        return pel_fault_set(fault, PEL_ERR_INVALID, "%.80s: %s", file,
                             r->words);
    }
    return PEL_OK;
}

/* --- the source ----------------------------------------------------------- */

static enum pel_err check(const struct pel_seabed_source *s, char path[4096],
                          struct pel_fault *fault)
{
    struct stat is;
    if (!s->directory) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "seabed.file needs pelagosd --bathymetry");
    }
    if (strchr(s->file, '/') || s->file[0] == '.' || s->file[0] == '-' ||
        strlen(s->file) > 200) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "seabed.file must be the name of a file in the "
                             "directory of pelagosd --bathymetry, without /");
    }
    if (snprintf(path, 4096, "%s/%s", s->directory, s->file) >= 4096 ||
        stat(path, &is) || !S_ISREG(is.st_mode)) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "%.80s: no such file in %.120s", s->file,
                             s->directory);
    }
    return PEL_OK;
}

/* Runs the reader; its bytes are in *r. */
static enum pel_err run(const struct pel_seabed_source *s, const char *path,
                        struct reader *r, struct pel_fault *fault)
{
    char places[5][32];
    const double values[] = { s->origin_latitude, s->origin_longitude,
                              s->latitude, s->longitude, s->spacing_m };
    for (int i = 0; i < 5; i++) {
        snprintf(places[i], sizeof *places, "%.12g", values[i]);
    }
    char *argv[] = { (char[]){ PROGRAM },
                     places[0],
                     places[1],
                     s->depths ? (char[]){ "depth" } : (char[]){ "elevation" },
                     (char *)path,
                     s->placed ? places[2] : NULL,
                     places[3],
                     places[4],
                     NULL };
    enum pel_err err = start(r, argv, fault);
    return err ? err : end(r, listen_to(r), s->file, fault);
}

/* The wire's heights, moved by the source's offset. */
static enum pel_err read_field(struct reader *r, double offset_m,
                               const struct pel_seabed **out,
                               struct pel_fault *fault)
{
    for (size_t at = PEL_SEABED_WIRE_HEAD; offset_m != 0 && at + 4 <= r->size;
         at += 4) {
        float height;
        memcpy(&height, r->bytes + at, 4);
        height += (float)offset_m;
        memcpy(r->bytes + at, &height, 4);
    }
    return pel_seabed_wire_read(r->bytes, r->size, out, fault);
}

enum pel_err pel_seabed_load(const struct pel_seabed_source *source,
                             const struct pel_seabed **out,
                             struct pel_fault *fault)
{
    char path[4096];
    struct reader r = { .out = -1, .err = -1 };
    enum pel_err err = check(source, path, fault);
    if (!err) {
        err = run(source, path, &r, fault);
    }
    if (!err) {
        struct pel_fault why;
        err = read_field(&r, source->offset_m, out, &why);
        if (err) {
            pel_fault_set(fault, err, "%.80s: %.160s", source->file,
                          why.message);
        }
    }
    finish(&r);
    return err;
}
