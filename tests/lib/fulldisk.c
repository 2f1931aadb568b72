/* LD_PRELOAD: while the file that FULL_DISK names exists, no regular file gets
 * a block more: ENOSPC, as from a file system that is full. What is written to
 * standard error is not meant. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

static bool is_full(void)
{
    const char *name = getenv("FULL_DISK");
    return name && access(name, F_OK) == 0;
}

static bool fits(int fd, size_t size)
{
    struct stat is;
    return fstat(fd, &is) != 0 || !S_ISREG(is.st_mode) ||
           is.st_size + (off_t)size <= (off_t)is.st_blocks * 512;
}

ssize_t write(int fd, const void *data, size_t size)
{
    static ssize_t (*real)(int, const void *, size_t);
    if (!real) {
        *(void **)&real = dlsym(RTLD_NEXT, "write");
    }
    if (fd > 2 && size > 0 && !fits(fd, size) && is_full()) {
        errno = ENOSPC;
        return -1;
    }
    return real(fd, data, size);
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
    if (fd > 2 && size > 0 && !fits(fd, size) && is_full()) {
        errno = ENOSPC;
        return -1;
    }
    return real(fd, parts, count);
}

int fallocate(int fd, int mode, off_t from, off_t size)
{
    static int (*real)(int, int, off_t, off_t);
    if (!real) {
        *(void **)&real = dlsym(RTLD_NEXT, "fallocate");
    }
    if (is_full()) {
        errno = ENOSPC;
        return -1;
    }
    return real(fd, mode, from, size);
}
