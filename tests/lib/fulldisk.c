/* LD_PRELOAD: while the file that FULL_DISK names exists, no regular file gets
 * a block more: ENOSPC, as from a file system that is full. Where that file
 * holds a word, the fault is another: EROFS, a file system that has become
 * read-only; EIO, a disk that fails, also what was accepted before; SHORT, half
 * of each write is taken until nothing is. What is written to standard error is
 * not meant. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#define SHORT (-1)

/* 0: none. */
static int fault(void)
{
    const char *name = getenv("FULL_DISK");
    int fd = name ? open64(name, O_RDONLY | O_CLOEXEC) : -1;
    if (fd < 0) {
        return 0;
    }
    char word[8] = { 0 };
    ssize_t size = read(fd, word, sizeof word - 1);
    close(fd);
    return size < 3                         ? ENOSPC
           : strncmp(word, "EROFS", 5) == 0 ? EROFS
           : strncmp(word, "EIO", 3) == 0   ? EIO
           : strncmp(word, "SHORT", 5) == 0 ? SHORT
                                            : ENOSPC;
}

static bool regular(int fd)
{
    struct stat is;
    return fd > 2 && fstat(fd, &is) == 0 && S_ISREG(is.st_mode);
}

static bool fits(int fd, size_t size)
{
    struct stat is;
    return fstat(fd, &is) != 0 || !S_ISREG(is.st_mode) ||
           is.st_size + (off_t)size <= (off_t)is.st_blocks * 512;
}

/* How much of `size` bytes is taken; -1, with errno: nothing. */
static ssize_t taken(int fd, size_t size)
{
    int why = size > 0 && regular(fd) ? fault() : 0;
    if (why == 0 || (why == ENOSPC && fits(fd, size))) {
        return (ssize_t)size;
    }
    if (why == SHORT && size > 1) {
        return (ssize_t)(size / 2);
    }
    errno = why == SHORT ? ENOSPC : why;
    return -1;
}

ssize_t write(int fd, const void *data, size_t size)
{
    static ssize_t (*real)(int, const void *, size_t);
    if (!real) {
        *(void **)&real = dlsym(RTLD_NEXT, "write");
    }
    ssize_t most = taken(fd, size);
    return most < 0 ? -1 : real(fd, data, (size_t)most);
}

/* GStreamer's way. */
ssize_t writev(int fd, const struct iovec *parts, int count)
{
    static ssize_t (*real)(int, const struct iovec *, int);
    size_t size = 0;
    if (!real) {
        *(void **)&real = dlsym(RTLD_NEXT, "writev");
    }
    for (int i = 0; i < count; i++) {
        size += parts[i].iov_len;
    }
    ssize_t most = taken(fd, size);
    if (most < 0) {
        return -1;
    }
    return (size_t)most < size ? write(fd, parts[0].iov_base, parts[0].iov_len)
                               : real(fd, parts, count);
}

int fallocate(int fd, int mode, off_t from, off_t size)
{
    static int (*real)(int, int, off_t, off_t);
    if (!real) {
        *(void **)&real = dlsym(RTLD_NEXT, "fallocate");
    }
    int why = fault();
    if (why) {
        errno = why == SHORT ? ENOSPC : why;
        return -1;
    }
    return real(fd, mode, from, size);
}

int open(const char *path, int flags, ...)
{
    static int (*real)(const char *, int, ...);
    va_list more;
    va_start(more, flags);
    mode_t mode = flags & (O_CREAT | __O_TMPFILE) ? va_arg(more, mode_t) : 0;
    va_end(more);
    if (!real) {
        *(void **)&real = dlsym(RTLD_NEXT, "open");
    }
    if ((flags & O_ACCMODE) != O_RDONLY && strncmp(path, "/dev/", 5) != 0 &&
        fault() == EROFS) {
        errno = EROFS;
        return -1;
    }
    return real(path, flags, mode);
}

int rename(const char *from, const char *to)
{
    static int (*real)(const char *, const char *);
    if (!real) {
        *(void **)&real = dlsym(RTLD_NEXT, "rename");
    }
    int why = fault();
    if (why == EROFS || why == EIO) {
        errno = why;
        return -1;
    }
    return real(from, to);
}

static int sync_fault(int fd)
{
    return regular(fd) && fault() == EIO ? EIO : 0;
}

int fsync(int fd)
{
    static int (*real)(int);
    if (!real) {
        *(void **)&real = dlsym(RTLD_NEXT, "fsync");
    }
    return (errno = sync_fault(fd)) ? -1 : real(fd);
}

int fdatasync(int fd)
{
    static int (*real)(int);
    if (!real) {
        *(void **)&real = dlsym(RTLD_NEXT, "fdatasync");
    }
    return (errno = sync_fault(fd)) ? -1 : real(fd);
}
