/* For tests that walk at random: how far, from which seed, and a clock that
 * stands until it is moved. It replaces the C library's for the whole program,
 * GLib's timers with it. One user a program; include it in one file. */
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static struct {
    bool stands;
    int64_t now_ns;
    uint64_t random;
} walk;

/* PELAGOS_STEPS, else `usual`. */
static inline unsigned long walk_steps(unsigned long usual)
{
    const char *text = getenv("PELAGOS_STEPS");
    return text ? strtoul(text, NULL, 10) : usual;
}

/* By PELAGOS_SEED (1), the same on every machine. */
static inline void walk_seed(void)
{
    const char *text = getenv("PELAGOS_SEED");
    walk.random = text ? strtoull(text, NULL, 10) + 1 : 2;
}

/* 0 .. n - 1 (xorshift64*). */
static inline unsigned below(unsigned n)
{
    walk.random ^= walk.random >> 12;
    walk.random ^= walk.random << 25;
    walk.random ^= walk.random >> 27;
    return (unsigned)((walk.random * 0x2545F4914F6CDD1D) >> 33) % n;
}

__attribute__((visibility("default"))) int clock_gettime(clockid_t id,
                                                         struct timespec *out)
{
    if (walk.stands && id == CLOCK_MONOTONIC) {
        *out = (struct timespec){ walk.now_ns / 1000000000,
                                  walk.now_ns % 1000000000 };
        return 0;
    }
    return (int)syscall(SYS_clock_gettime, id, out);
}

/* From now on time is what walk_wait makes of it. */
static inline void walk_stop_clock(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    walk.now_ns = now.tv_sec * 1000000000LL + now.tv_nsec;
    walk.stands = true;
}

static inline void walk_wait(double seconds)
{
    walk.now_ns += (int64_t)(seconds * 1e9);
}

/* Before threads are joined: they count by the kernel's. */
static inline void walk_start_clock(void)
{
    walk.stands = false;
}
