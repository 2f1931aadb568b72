#include "frames/prefetch.h"

#include <math.h>
#include <string.h>

#define LEAST_GAP_NS 2000000
#define MOST_GAP_NS 250000000
/* Preparing takes some ms of two cores that draw too; earlier would only be in
 * the way of who reads the answer before. */
#define LEAD_NS 8000000

double pel_prefetch_now(const struct pel_prefetch *self, const void *sea,
                        double time_s, double rate)
{
    for (int i = 0; i < PEL_PREFETCH_MOMENTS; i++) {
        if (self->moments[i].sea == sea &&
            fabs(self->moments[i].time_s - time_s) <=
                PEL_PREFETCH_S * fabs(rate)) {
            return self->moments[i].time_s;
        }
    }
    return time_s;
}

/* Who asked longest ago makes room. */
static int place_of(const struct pel_prefetch *self, const void *who)
{
    int oldest = 0;
    for (int i = 0; i < PEL_PREFETCH_ASKERS; i++) {
        if (self->askers[i].who == who) {
            return i;
        }
        if (!self->askers[i].who ||
            (self->askers[oldest].who &&
             self->askers[i].last_ns < self->askers[oldest].last_ns)) {
            oldest = i;
        }
    }
    return oldest;
}

/* The middle one; 0 of none. */
static int64_t middle_gap(const int64_t *gap_ns, int count)
{
    int64_t sorted[PEL_PREFETCH_GAPS];
    for (int i = 0; i < count; i++) {
        int at = i;
        for (; at > 0 && sorted[at - 1] > gap_ns[i]; at--) {
            sorted[at] = sorted[at - 1];
        }
        sorted[at] = gap_ns[i];
    }
    return count > 0 ? sorted[count / 2] : 0;
}

static int64_t note(struct pel_prefetch *self, const void *who, int64_t now_ns)
{
    int at = place_of(self, who);
    int64_t *gap_ns = self->askers[at].gap_ns;
    int *gaps = &self->askers[at].gaps;
    if (self->askers[at].who != who) {
        self->askers[at].who = who;
        *gaps = 0;
    } else {
        memmove(gap_ns + 1, gap_ns, (PEL_PREFETCH_GAPS - 1) * sizeof *gap_ns);
        gap_ns[0] = now_ns - self->askers[at].last_ns;
        *gaps += *gaps < PEL_PREFETCH_GAPS;
    }
    self->askers[at].last_ns = now_ns;
    return middle_gap(gap_ns, *gaps);
}

bool pel_prefetch_next(struct pel_prefetch *self, const void *who,
                       const void *sea, int64_t now_ns, double time_s,
                       double rate, double *next_s, int64_t *begin_ns)
{
    int64_t gap_ns = note(self, who, now_ns);
    if (gap_ns < LEAST_GAP_NS || gap_ns > MOST_GAP_NS) {
        return false;
    }
    double next = time_s + (double)gap_ns * 1e-9 * rate;
    if (pel_prefetch_now(self, sea, next, rate) != next) {
        return false;
    }
    memmove(self->moments + 1, self->moments,
            (PEL_PREFETCH_MOMENTS - 1) * sizeof *self->moments);
    self->moments[0].sea = sea;
    self->moments[0].time_s = next;
    *next_s = next;
    *begin_ns = now_ns + (gap_ns > 2 * LEAD_NS ? gap_ns - LEAD_NS : gap_ns / 2);
    return true;
}
