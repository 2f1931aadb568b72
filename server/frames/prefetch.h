/* Predicts when surface queries about the present will come. A new moment of an
 * FFT sea takes milliseconds of transforms, but simulators query at a steady
 * rate; so the moment of the next query is prefetched, and a query that comes
 * within PEL_PREFETCH_S of it (where the clock runs by itself) is answered for
 * that moment. Each answer carries its time and depends on that time, the sea
 * and the seed alone. Control thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define PEL_PREFETCH_S 0.005 /* real time, before or after */
#define PEL_PREFETCH_ASKERS 4
#define PEL_PREFETCH_MOMENTS 3
#define PEL_PREFETCH_GAPS 5

struct pel_prefetch {
    struct {
        const void *who; /* NULL: none */
        int64_t last_ns;
        int gaps;                          /* number of them known */
        int64_t gap_ns[PEL_PREFETCH_GAPS]; /* newest first */
    } askers[PEL_PREFETCH_ASKERS];
    struct {
        const void *sea; /* NULL: none */
        double time_s;
    } moments[PEL_PREFETCH_MOMENTS]; /* predicted, newest first */
};

/* The time for which a query at time_s about `sea` is answered: the newest
 * moment predicted near it, or time_s itself. `rate`: of simulated time, not 0.
 * The result never precedes an earlier answer's while simulated time runs. */
double pel_prefetch_now(const struct pel_prefetch *self, const void *sea,
                        double time_s, double rate);

/* Records a query by `who` at now_ns, time_s. True when its queries come at a
 * steady interval of 2 to 250 ms and the moment of the next one, *next_s, was
 * not predicted yet: it is from now on, and is best computed from *begin_ns
 * on. */
bool pel_prefetch_next(struct pel_prefetch *self, const void *who,
                       const void *sea, int64_t now_ns, double time_s,
                       double rate, double *next_s, int64_t *begin_ns);
