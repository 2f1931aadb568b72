#include "base/helper.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/file.h"

#define MOST_WORDS 240 /* of the helper's complaint */

struct helper {
    pid_t pid;
    int out, err; /* its standard output and error */
    unsigned char *bytes;
    size_t size, capacity, most;
    char words[MOST_WORDS + 1];
    size_t word_count;
};

static bool find_program(const char *name, char path[4096])
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
        snprintf(path, 4096, "%s/%s%s", own, places[i], name);
        if (access(path, X_OK) == 0) {
            return true;
        }
    }
    return false;
}

/* What is handed on of our environment: not the names of proxies, homes,
 * tokens. */
static void choose_environment(char *out[16])
{
    static const char *const names[] = { "LD_LIBRARY_PATH",
                                         "PROJ_DATA",
                                         "PROJ_LIB",
                                         "GDAL_DATA",
                                         "ECCODES_DEFINITION_PATH",
                                         "ASAN_OPTIONS",
                                         "LSAN_OPTIONS",
                                         "TSAN_OPTIONS",
                                         "UBSAN_OPTIONS" };
    size_t count = 0;
    for (char **e = environ; *e; e++) {
        for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
            size_t length = strlen(names[i]);
            if (count < 15 && strncmp(*e, names[i], length) == 0 &&
                (*e)[length] == '=') {
                out[count++] = *e;
            }
        }
    }
    out[count] = NULL;
}

static void close_both(const int ends[2])
{
    if (ends[0] >= 0) {
        close(ends[0]);
        close(ends[1]);
    }
}

/* The input as a file of no name, to be read from its start; -1: errno. */
static int input_of(const struct pel_helper_task *task)
{
    int fd = memfd_create(task->program, MFD_CLOEXEC);
    const char *at = task->input;
    size_t left = task->input_size;
    while (fd >= 0 && left > 0) {
        ssize_t put = write(fd, at, left);
        if (put < 0 && errno != EINTR) {
            int why = errno;
            close(fd);
            errno = why;
            return -1;
        }
        at += put > 0 ? put : 0;
        left -= put > 0 ? (size_t)put : 0;
    }
    if (fd >= 0) {
        lseek(fd, 0, SEEK_SET);
    }
    return fd;
}

static enum pel_err start(struct helper *h, const struct pel_helper_task *task,
                          struct pel_fault *fault)
{
    char program[4096];
    char *environment[16];
    int out[2] = { -1, -1 }, err[2] = { -1, -1 }, in = -1;
    posix_spawn_file_actions_t actions;
    if (!find_program(task->program, program)) {
        return pel_fault_set(fault, PEL_ERR_IO, "%s is not installed",
                             task->program);
    }
    if ((task->input && (in = input_of(task)) < 0) || pipe2(out, O_CLOEXEC) ||
        pipe2(err, O_CLOEXEC)) {
        int why = errno;
        close_both(out);
        if (in >= 0) {
            close(in);
        }
        return pel_fault_set(fault, PEL_ERR_IO, "%s: %s", task->program,
                             strerror(why));
    }
    choose_environment(environment);
    posix_spawn_file_actions_init(&actions);
    if (in >= 0) {
        posix_spawn_file_actions_adddup2(&actions, in, 0);
    } else {
        posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    }
    posix_spawn_file_actions_adddup2(&actions, out[1], 1);
    posix_spawn_file_actions_adddup2(&actions, err[1], 2);
    int failed =
        posix_spawn(&h->pid, program, &actions, NULL, task->argv, environment);
    posix_spawn_file_actions_destroy(&actions);
    close(out[1]);
    close(err[1]);
    if (in >= 0) {
        close(in);
    }
    h->out = out[0];
    h->err = err[0];
    return failed ? pel_fault_set(fault, PEL_ERR_IO, "%s: %s", task->program,
                                  strerror(failed))
                  : PEL_OK;
}

/* Room for more bytes; false: more than an answer can be. */
static bool grow(struct helper *h)
{
    if (h->size < h->capacity) {
        return true;
    }
    size_t capacity = h->capacity ? 4 * h->capacity : 1 << 18;
    capacity = capacity < h->most + 1 ? capacity : h->most + 1;
    unsigned char *bytes =
        capacity > h->capacity ? realloc(h->bytes, capacity) : NULL;
    if (!bytes) {
        return false;
    }
    h->bytes = bytes;
    h->capacity = capacity;
    return true;
}

/* Takes what is there of one pipe; false: it has ended. */
static bool take(struct helper *h, int fd)
{
    ssize_t got;
    if (fd == h->out) {
        if (!grow(h)) {
            return false;
        }
        got = read(fd, h->bytes + h->size, h->capacity - h->size);
        h->size += got > 0 ? (size_t)got : 0;
    } else {
        char rest[64];
        bool full = h->word_count == MOST_WORDS;
        got = read(fd, full ? rest : h->words + h->word_count,
                   full ? sizeof rest : MOST_WORDS - h->word_count);
        h->word_count += got > 0 && !full ? (size_t)got : 0;
    }
    return got > 0 || (got < 0 && (errno == EINTR || errno == EAGAIN));
}

/* Until both pipes have ended or there is too much; false: too late. */
static bool listen_to(struct helper *h, int64_t end_ns)
{
    struct pollfd fds[] = { { h->out, POLLIN, 0 }, { h->err, POLLIN, 0 } };
    while (h->size <= h->most && (fds[0].fd >= 0 || fds[1].fd >= 0)) {
        int64_t left_ms = (end_ns - pel_now_ns()) / 1000000;
        if (left_ms <= 0) {
            return false;
        }
        if (poll(fds, 2, (int)left_ms) < 0 && errno != EINTR) {
            return false;
        }
        for (int i = 0; i < 2; i++) {
            if (fds[i].fd >= 0 && fds[i].revents && !take(h, fds[i].fd)) {
                fds[i].fd = -1;
            }
        }
    }
    return true;
}

/* One that has closed its pipes ends at once, or does not mean to: a file may
 * have taken it over. False: too late. */
static bool wait_for(const struct helper *h, int64_t end_ns, int *status)
{
    static const struct timespec slice = { .tv_nsec = 1000000 };
    while (waitpid(h->pid, status, WNOHANG) == 0) {
        if (pel_now_ns() > end_ns) {
            return false;
        }
        nanosleep(&slice, NULL);
    }
    return true;
}

/* Waits for the end of the process and says how it ended. */
static enum pel_err end(struct helper *h, bool in_time, int64_t end_ns,
                        const struct pel_helper_task *task,
                        struct pel_fault *fault)
{
    int status = 0;
    bool too_much = h->size > h->most;
    in_time = in_time && (too_much || wait_for(h, end_ns, &status));
    if (!in_time || too_much) {
        kill(h->pid, SIGKILL);
        while (waitpid(h->pid, &status, 0) < 0 && errno == EINTR) {
        }
    }
    while (h->word_count > 0 && h->words[h->word_count - 1] == '\n') {
        h->word_count--;
    }
    h->words[h->word_count] = '\0';
    if (!in_time) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%.80s: it was not read within %d s",
                             task->subject, task->within_ms / 1000);
    }
    if (too_much) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%.80s: reading it gave more than %zu bytes",
                             task->subject, h->most);
    }
    if (WIFSIGNALED(status)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%.80s: reading it ended with signal %d",
                             task->subject, WTERMSIG(status));
    }
    if (WEXITSTATUS(status) != 0) {
        return pel_fault_set(fault, PEL_ERR_INVALID, "%.80s: %s", task->subject,
                             h->words);
    }
    return PEL_OK;
}

enum pel_err pel_helper_run(const struct pel_helper_task *task,
                            unsigned char **out, size_t *size,
                            struct pel_fault *fault)
{
    struct helper h = { .out = -1, .err = -1, .most = task->most_bytes };
    int64_t end_ns = pel_now_ns() + task->within_ms * 1000000LL;
    enum pel_err err = start(&h, task, fault);
    if (!err) {
        err = end(&h, listen_to(&h, end_ns), end_ns, task, fault);
    }
    if (h.out >= 0) {
        close(h.out);
        close(h.err);
    }
    if (err) {
        free(h.bytes);
        h.bytes = NULL;
    }
    *out = h.bytes;
    *size = h.size;
    return err;
}

static bool well_formed(const char *file)
{
    for (const char *name = file;; name++) {
        if (*name == '.' || *name == '-' || *name == '/' || !*name) {
            return false;
        }
        size_t length = strcspn(name, "/");
        if (length > NAME_MAX) {
            return false;
        }
        name += length;
        if (!*name) {
            return true;
        }
    }
}

enum pel_err pel_helper_find(const char *directory, const char *file,
                             struct pel_fault *fault)
{
    struct stat is = { 0 };
    struct pel_fault why;
    int found;
    if (!well_formed(file)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%.60s: it must be the path of a file below "
                             "%.60s, of names of at most 255 bytes that do "
                             "not begin with . or -",
                             file, directory);
    }
    enum pel_err err = pel_file_find_in(directory, file, &found, &why);
    if (!err) {
        err = fstat(found, &is) ? PEL_ERR_IO : PEL_OK;
        close(found);
    }
    if (err == PEL_ERR_INVALID) {
        return pel_fault_set(fault, err, "%s", why.message);
    }
    return err || !S_ISREG(is.st_mode)
               ? pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                               "%.80s: no such file in %.120s", file, directory)
               : PEL_OK;
}
