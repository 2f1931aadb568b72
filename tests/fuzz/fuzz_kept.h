/* For sources of readers, whose memory is freed by the end of their process: a
 * target includes such a source behind
 *   #define malloc(n) fuzz_keep(malloc(n))
 *   #define calloc(n, s) fuzz_keep(calloc(n, s))
 *   #define free(p) fuzz_drop(p)
 * and calls fuzz_release after each input. */
#pragma once

#include <stddef.h>
#include <stdlib.h>

static struct {
    void *of[1024];
    size_t count;
} fuzz_kept;

static inline void *fuzz_keep(void *p)
{
    if (p && fuzz_kept.count == sizeof fuzz_kept.of / sizeof *fuzz_kept.of) {
        abort();
    }
    if (p) {
        fuzz_kept.of[fuzz_kept.count++] = p;
    }
    return p;
}

static inline void fuzz_drop(void *p)
{
    for (size_t i = 0; p && i < fuzz_kept.count; i++) {
        if (fuzz_kept.of[i] == p) {
            fuzz_kept.of[i] = fuzz_kept.of[--fuzz_kept.count];
            break;
        }
    }
    free(p);
}

static inline void fuzz_release(void)
{
    while (fuzz_kept.count > 0) {
        free(fuzz_kept.of[--fuzz_kept.count]);
    }
}
