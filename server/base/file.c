#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
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

static enum pel_err open_regular(const char *path, int *out, struct stat *is,
                                 struct pel_fault *fault)
{
    /* Before it is opened: opening some devices does something. */
    if (stat(path, is)) {
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

enum pel_err pel_file_read(const char *path, size_t most, char **out,
                           size_t *size, struct pel_fault *fault)
{
    struct stat is;
    int fd, why;
    enum pel_err err = open_regular(path, &fd, &is, fault);
    if (err) {
        return err;
    }
    if (is.st_size < 0 || (unsigned long long)is.st_size > most) {
        close(fd);
        return too_large(path, most, fault);
    }
    /* Files of /proc and the like say that they are empty. */
    size_t room = is.st_size > 0 ? (size_t)is.st_size : most;
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

enum pel_err pel_file_inside(const char *directory, const char *path,
                             struct pel_fault *fault)
{
    char *real = realpath(path, NULL);
    char *whole = real ? realpath(directory, NULL) : NULL;
    size_t length = whole ? strlen(whole) : 0;
    bool out =
        real && (!whole || strncmp(real, whole, length) != 0 ||
                 (real[length] != '/' && real[length] != '\0' && length > 1));
    free(whole);
    free(real);
    const char *name = strrchr(path, '/');
    return out ? pel_fault_set(fault, PEL_ERR_INVALID,
                               "%.80s is a link out of %.80s; put the file "
                               "itself there",
                               name ? name + 1 : path, directory)
               : PEL_OK;
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
