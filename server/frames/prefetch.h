/* When surface queries about now will come. A new moment of an FFT sea costs
 * milliseconds of transforms, and a simulator asks in step; so the moment of
 * its next question is prepared ahead, and a question that comes within
 * PEL_PREFETCH_S of it (by a clock that runs by itself) is answered for it.
 * Answers stay functions of their time, which they tell. Control thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define PEL_PREFETCH_S 0.005 /* of real time, either way */
#define PEL_PREFETCH_ASKERS 4
#define PEL_PREFETCH_MOMENTS 3
#define PEL_PREFETCH_GAPS 5

struct pel_prefetch {
    struct {
        const void *who; /* NULL: none */
        int64_t last_ns;
        int gaps;                          /* so many are known */
        int64_t gap_ns[PEL_PREFETCH_GAPS]; /* newest first */
    } askers[PEL_PREFETCH_ASKERS];
    struct {
        const void *sea; /* NULL: none */
        double time_s;
    } moments[PEL_PREFETCH_MOMENTS]; /* predicted, newest first */
};

/* The time that a question at time_s about `sea` is answered for: the newest
 * moment predicted near it, or itself. `rate`: of simulated time, not 0. Never
 * before an earlier answer's while simulated time goes on. */
double pel_prefetch_now(const struct pel_prefetch *self, const void *sea,
                        double time_s, double rate);

/* Notes that `who` asked at now_ns, time_s; true when he asks in step, 2 to
 * 250 ms apart, and the moment of his next question, *next_s, is not predicted
 * yet: it is now, and best prepared from *begin_ns on. */
bool pel_prefetch_next(struct pel_prefetch *self, const void *who,
                       const void *sea, int64_t now_ns, double time_s,
                       double rate, double *next_s, int64_t *begin_ns);
