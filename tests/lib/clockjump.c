/* LD_PRELOAD: the wall clock is off by the seconds in the file that CLOCK_JUMP
 * names. The clock that only goes on is not touched. */
#include <dlfcn.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static long off(void)
{
    const char *name = getenv("CLOCK_JUMP");
    int fd = name ? open(name, O_RDONLY | O_CLOEXEC) : -1;
    char text[32] = { 0 };
    if (fd < 0) {
        return 0;
    }
    long seconds = read(fd, text, sizeof text - 1) > 0 ? atol(text) : 0;
    close(fd);
    return seconds;
}

int clock_gettime(clockid_t which, struct timespec *at)
{
    static int (*real)(clockid_t, struct timespec *);
    if (!real) {
        *(void **)&real = dlsym(RTLD_NEXT, "clock_gettime");
    }
    int status = real(which, at);
    if (status == 0 && which == CLOCK_REALTIME) {
        at->tv_sec += off();
    }
    return status;
}

int gettimeofday(struct timeval *restrict at, void *restrict zone)
{
    (void)zone;
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    at->tv_sec = now.tv_sec;
    at->tv_usec = now.tv_nsec / 1000;
    return 0;
}

time_t time(time_t *out)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (out) {
        *out = now.tv_sec;
    }
    return now.tv_sec;
}
