/* Threads whose answers a client waits for, beside threads that compute. Linux
 * with lazy preemption lets a thread that was woken wait for the next tick, 1
 * to 10 ms, while another computes on its core, whatever their nice values;
 * three ways around that:
 *
 * - real time (SCHED_RR, where the system permits it) for the few threads that
 *   answer, for a bounded share of their time;
 * - a nudge: an interrupt to the cores where this process computes, on the
 *   return from which the kernel schedules anew;
 * - a beat: nudges each millisecond while clients ask, where the system does
 * not permit real time. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/err.h"

enum pel_realtime { PEL_REALTIME_AUTO, PEL_REALTIME_OFF, PEL_REALTIME_ON };

/* SCHED_RR priorities, the lowest there are: below whatever else is real time
 * on the machine. */
enum pel_urgency { PEL_URGENT_ANSWERS = 1, PEL_URGENT_CONTROL = 2 };

/* Whether threads of this process may ask for real time: AUTO is where it is
 * permitted, ON fails with IO and what to do where it is not. *real
 * says what it came to. Before the first pel_urgent_begin, which does nothing
 * without it; main thread. */
PEL_CHECK enum pel_err pel_urgent_init(enum pel_realtime mode, bool *real,
                                       struct pel_fault *fault);

/* An urgent thread, its own to use: real time until it has used more than
 * PEL_URGENT_SHARE of the time that passes, by PEL_URGENT_BURST_NS, and again
 * when it has half of that to its credit. Threads that it starts are not
 * urgent. */
#define PEL_URGENT_SHARE 0.4
#define PEL_URGENT_BURST_NS 20000000
struct pel_urgent {
    int priority; /* 0: never real time */
    bool real;
    int64_t credit_ns, wall_ns, cpu_ns;
};
void pel_urgent_begin(struct pel_urgent *self, enum pel_urgency priority);
/* After each piece of work, at most a millisecond of it. */
void pel_urgent_account(struct pel_urgent *self);
/* pel_urgent_account's rule alone, for a thread that has used cpu_ns by
 * wall_ns: whether it may be real time now. */
bool pel_urgent_credit(struct pel_urgent *self, int64_t wall_ns,
                       int64_t cpu_ns);

/* What urgent threads may use of the processors for one kind of askers: `share`
 * of a core, and a burst. Who spends more owes it. Plain functions; one thread
 * at a time. */
struct pel_allowance {
    double share;
    int64_t burst_ns;
    int64_t left_ns, seen_ns; /* these and `begun`: the functions' own */
    bool begun;
};
bool pel_allowance_has(struct pel_allowance *self, int64_t now_ns);
void pel_allowance_spend(struct pel_allowance *self, int64_t used_ns);

/* Processor time of the calling thread. */
int64_t pel_thread_cpu_ns(void);

/* Interrupts the cores where other threads of this process run; some
 * microseconds, 15 on a virtual machine. Any thread. */
void pel_nudge(void);

/* A client has asked and is likely to ask again: the beat goes on for
 * PEL_BEAT_NS. Nothing where real time is permitted, and before
 * pel_urgent_init. Microseconds; any thread. */
#define PEL_BEAT_NS 300000000
void pel_beat(void);
/* Beats so far. */
unsigned long pel_beats(void);
