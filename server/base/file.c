#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/openat2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

static enum pel_err system_fault(const char *verb, const char *path, int why,
                                 struct pel_fault *fault)
{
    return pel_fault_set(
        fault, why == ENOENT || why == ENOTDIR ? PEL_ERR_NOT_FOUND : PEL_ERR_IO,
        "cannot %s %.160s: %s", verb, path, strerror(why));
}

static const char *kind_of(mode_t mode)
{
    return S_ISDIR(mode)                    ? "a directory"
           : S_ISFIFO(mode)                 ? "a FIFO"
           : S_ISSOCK(mode)                 ? "a socket"
           : S_ISCHR(mode) || S_ISBLK(mode) ? "a device"
                                            : "something else";
}

static enum pel_err check_regular(const char *path, const struct stat *is,
                                  struct pel_fault *fault)
{
    return S_ISREG(is->st_mode)
               ? PEL_OK
               : pel_fault_set(fault, PEL_ERR_INVALID,
                               "%.160s is %s; it must be a regular file", path,
                               kind_of(is->st_mode));
}

/* The system's own name of what a descriptor is of, which is none of a link. */
static ssize_t name_of(int fd, char link[32], char out[PATH_MAX])
{
    snprintf(link, 32, "/proc/self/fd/%d", fd);
    ssize_t size = readlink(link, out, PATH_MAX);
    return size < PATH_MAX ? size : -1;
}

static bool lies_in(int directory, int fd)
{
    char link[32], outer[PATH_MAX], inner[PATH_MAX];
    ssize_t outer_size = name_of(directory, link, outer);
    ssize_t inner_size = name_of(fd, link, inner);
    if (outer_size == 1) {
        outer_size = 0; /* "/" */
    }
    return outer_size >= 0 && inner_size >= outer_size &&
           memcmp(outer, inner, (size_t)outer_size) == 0 &&
           (inner_size == outer_size || inner[outer_size] == '/');
}

/* The descriptor of what is there, or -1, with errno: EXDEV where it is not
 * in the directory. */
static int find_beneath(int directory, const char *name)
{
    struct open_how how = { .flags = O_PATH | O_CLOEXEC,
                            .resolve =
                                RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS };
    int fd = (int)syscall(SYS_openat2, directory, name, &how, sizeof how);
    if (fd >= 0 || errno == ENOENT || errno == ENOTDIR || errno == EACCES) {
        return fd;
    }
    /* A kernel or a supervisor without openat2, or a link with a whole path,
     * which may lead back into the directory. */
    fd = openat(directory, name, O_PATH | O_CLOEXEC);
    if (fd >= 0 && !lies_in(directory, fd)) {
        close(fd);
        errno = EXDEV;
        return -1;
    }
    return fd;
}

enum pel_err pel_file_find_in(const char *directory, const char *name, int *out,
                              struct pel_fault *fault)
{
    int folder = open(directory, O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) {
        return system_fault("read", directory, errno, fault);
    }
    *out = find_beneath(folder, name);
    int why = errno;
    close(folder);
    if (*out >= 0) {
        return PEL_OK;
    }
    if (why == EXDEV) {
        const char *last = strrchr(name, '/');
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%.80s is a link out of %.80s; put the file "
                             "itself there",
                             last ? last + 1 : name, directory);
    }
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    return system_fault("read", path, why, fault);
}

/* Of a descriptor that reads nothing, one that reads: the same file. Before it
 * is opened its kind is known, since opening some devices does something. */
static enum pel_err open_found(int found, const char *path, int *out,
                               struct stat *is, struct pel_fault *fault)
{
    char link[32];
    enum pel_err err = fstat(found, is)
                           ? system_fault("read", path, errno, fault)
                           : check_regular(path, is, fault);
    if (err) {
        return err;
    }
    snprintf(link, sizeof link, "/proc/self/fd/%d", found);
    *out = open(link, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    return *out < 0 ? system_fault("read", path, errno, fault) : PEL_OK;
}

static enum pel_err open_regular(const char *path, int *out, struct stat *is,
                                 struct pel_fault *fault)
{
    if (stat(path, is)) { /* before it is opened, as above */
        return system_fault("read", path, errno, fault);
    }
    enum pel_err err = check_regular(path, is, fault);
    if (err) {
        return err;
    }
    int fd = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (fd < 0) {
        return system_fault("read", path, errno, fault);
    }
    err = fstat(fd, is) ? system_fault("read", path, errno, fault)
                        : check_regular(path, is, fault);
    if (err) {
        close(fd);
        return err;
    }
    *out = fd;
    return PEL_OK;
}

enum pel_err pel_file_open(const char *path, int *out, struct pel_fault *fault)
{
    struct stat is;
    return open_regular(path, out, &is, fault);
}

static enum pel_err open_in(const char *directory, const char *name, int *out,
                            struct stat *is, struct pel_fault *fault)
{
    char path[PATH_MAX];
    int found;
    enum pel_err err = pel_file_find_in(directory, name, &found, fault);
    if (!err) {
        snprintf(path, sizeof path, "%s/%s", directory, name);
        err = open_found(found, path, out, is, fault);
        close(found);
    }
    return err;
}

enum pel_err pel_file_open_in(const char *directory, const char *name, int *out,
                              struct pel_fault *fault)
{
    struct stat is;
    return open_in(directory, name, out, &is, fault);
}

static enum pel_err too_large(const char *path, size_t most,
                              struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                         "%.160s has more than %zu bytes", path, most);
}

/* Up to `room` bytes; errno in *why where it fails. */
static size_t read_all(int fd, char *bytes, size_t room, int *why)
{
    size_t used = 0;
    ssize_t got = 1;
    *why = 0;
    while (used < room && got > 0) {
        got = read(fd, bytes + used, room - used);
        if (got > 0) {
            used += (size_t)got;
        } else if (got < 0 && errno == EINTR) {
            got = 1;
        } else if (got < 0) {
            *why = errno;
        }
    }
    return used;
}

/* Closes fd. */
static enum pel_err read_whole(int fd, const struct stat *is, const char *path,
                               size_t most, char **out, size_t *size,
                               struct pel_fault *fault)
{
    int why;
    if (is->st_size < 0 || (unsigned long long)is->st_size > most) {
        close(fd);
        return too_large(path, most, fault);
    }
    /* Files of /proc and the like say that they are empty. */
    size_t room = is->st_size > 0 ? (size_t)is->st_size : most;
    room = room < most ? room + 1 : most + 1; /* one more: it has grown */
    char *bytes = malloc(room + 1);
    if (!bytes) {
        close(fd);
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    size_t used = read_all(fd, bytes, room, &why);
    close(fd);
    if (why || used > most) {
        free(bytes);
        return why ? system_fault("read", path, why, fault)
                   : too_large(path, most, fault);
    }
    bytes[used] = '\0';
    *out = bytes;
    *size = used;
    return PEL_OK;
}

enum pel_err pel_file_read(const char *path, size_t most, char **out,
                           size_t *size, struct pel_fault *fault)
{
    struct stat is;
    int fd;
    enum pel_err err = open_regular(path, &fd, &is, fault);
    return err ? err : read_whole(fd, &is, path, most, out, size, fault);
}

enum pel_err pel_file_read_in(const char *directory, const char *name,
                              size_t most, char **out, size_t *size,
                              struct pel_fault *fault)
{
    struct stat is;
    char path[PATH_MAX];
    int fd;
    enum pel_err err = open_in(directory, name, &fd, &is, fault);
    snprintf(path, sizeof path, "%s/%s", directory, name);
    return err ? err : read_whole(fd, &is, path, most, out, size, fault);
}

bool pel_file_write(int fd, const void *data, size_t size)
{
    const char *bytes = data;
    while (size > 0) {
        ssize_t wrote = write(fd, bytes, size);
        if (wrote == 0 || (wrote < 0 && errno != EINTR)) {
            errno = wrote == 0 ? ENOSPC : errno;
            return false;
        }
        if (wrote > 0) {
            bytes += wrote;
            size -= (size_t)wrote;
        }
    }
    return true;
}
