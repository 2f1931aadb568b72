#include "base/urgent.h"

#include <linux/membarrier.h>
#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <glib.h>

#include "base/clock.h"

/* Set once before other threads begin. */
static bool permitted;

/* --- real time ------------------------------------------------------------ */

static bool set_class(int priority)
{
    const struct sched_param parameter = { .sched_priority = priority };
    int policy = priority > 0 ? SCHED_RR : SCHED_OTHER;
    return pthread_setschedparam(pthread_self(), policy, &parameter) == 0;
}

/* What this thread starts begins as any other thread does. */
static bool set_urgent(int priority)
{
    const struct sched_param parameter = { .sched_priority = priority };
    return sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &parameter) ==
           0;
}

static bool try_real_time(void)
{
    struct rlimit limit;
    if (getrlimit(RLIMIT_RTPRIO, &limit) == 0 &&
        limit.rlim_cur < PEL_URGENT_CONTROL &&
        limit.rlim_max >= PEL_URGENT_CONTROL) {
        limit.rlim_cur = PEL_URGENT_CONTROL;
        (void)setrlimit(RLIMIT_RTPRIO, &limit);
    }
    return set_urgent(PEL_URGENT_CONTROL) && set_class(0);
}

/* --- a beat --------------------------------------------------------------- */

#define BEAT_NS 1000000

static struct {
    pthread_mutex_t lock;
    pthread_cond_t asked;
    atomic_bool there, rests;
    _Atomic int64_t until_ns;
    atomic_ulong count;
} beat = { .lock = PTHREAD_MUTEX_INITIALIZER,
           .asked = PTHREAD_COND_INITIALIZER };

static bool wanted(void)
{
    return pel_now_ns() < atomic_load(&beat.until_ns);
}

static void *keep_beating(void *unused)
{
    const struct timespec rest = { .tv_nsec = BEAT_NS };
    (void)unused;
    for (;;) {
        pthread_mutex_lock(&beat.lock);
        atomic_store(&beat.rests, true);
        while (!wanted()) {
            pthread_cond_wait(&beat.asked, &beat.lock);
        }
        atomic_store(&beat.rests, false);
        pthread_mutex_unlock(&beat.lock);
        while (wanted()) {
            nanosleep(&rest, NULL);
            pel_nudge();
            atomic_fetch_add(&beat.count, 1);
        }
    }
    return NULL;
}

/* It stays until the process ends; without a thread there is none. */
static void begin_beat(void)
{
    pthread_t thread;
    if (!atomic_load(&beat.there) &&
        pthread_create(&thread, NULL, keep_beating, NULL) == 0) {
        pthread_setname_np(thread, "beat");
        pthread_detach(thread);
        atomic_store(&beat.there, true);
    }
}

void pel_beat(void)
{
    if (permitted || !atomic_load_explicit(&beat.there, memory_order_relaxed)) {
        return;
    }
    atomic_store(&beat.until_ns, pel_now_ns() + PEL_BEAT_NS);
    if (atomic_load(&beat.rests)) {
        /* Without the lock, which who waits here must not wait for: one that
         * comes just before the wait is lost, and the next one is not. */
        pthread_cond_signal(&beat.asked);
    }
}

unsigned long pel_beats(void)
{
    return atomic_load(&beat.count);
}

/* --- the process ---------------------------------------------------------- */

static void nothing(gpointer task, gpointer user)
{
    (void)task;
    (void)user;
}

/* GLib gives all threads of its pools, among them those that serve RTSP and
 * encode, the class of the thread that makes the first pool. */
static void begin_pools(void)
{
    g_thread_pool_free(g_thread_pool_new(nothing, NULL, 1, FALSE, NULL), TRUE,
                       TRUE);
}

enum pel_err pel_urgent_init(enum pel_realtime mode, bool *real,
                             struct pel_fault *fault)
{
    begin_pools();
    permitted = mode != PEL_REALTIME_OFF && try_real_time();
    *real = permitted;
    if (!permitted) {
        begin_beat();
    }
    if (mode == PEL_REALTIME_ON && !permitted) {
        return pel_fault_set(fault, PEL_ERR_IO,
                             "--realtime on: the system does not permit it; "
                             "give LimitRTPRIO=%d (systemd), ulimit -r %d or "
                             "CAP_SYS_NICE",
                             PEL_URGENT_CONTROL, PEL_URGENT_CONTROL);
    }
    return PEL_OK;
}

int64_t pel_thread_cpu_ns(void)
{
    struct timespec used;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
    return (int64_t)used.tv_sec * 1000000000 + used.tv_nsec;
}

void pel_urgent_begin(struct pel_urgent *self, enum pel_urgency priority)
{
    *self = (struct pel_urgent){
        .priority = permitted ? (int)priority : 0,
        .credit_ns = PEL_URGENT_BURST_NS,
        .wall_ns = pel_now_ns(),
        .cpu_ns = pel_thread_cpu_ns(),
    };
    self->real = self->priority > 0 && set_urgent(self->priority);
}

bool pel_urgent_credit(struct pel_urgent *self, int64_t wall_ns, int64_t cpu_ns)
{
    double earned = (double)(wall_ns - self->wall_ns) * PEL_URGENT_SHARE;
    double credit =
        (double)self->credit_ns + earned - (double)(cpu_ns - self->cpu_ns);
    credit = fmin(fmax(credit, -PEL_URGENT_BURST_NS), PEL_URGENT_BURST_NS);
    self->credit_ns = (int64_t)credit;
    self->wall_ns = wall_ns;
    self->cpu_ns = cpu_ns;
    return self->credit_ns > (self->real ? 0 : PEL_URGENT_BURST_NS / 2);
}

void pel_urgent_account(struct pel_urgent *self)
{
    if (self->priority == 0) {
        return;
    }
    bool may = pel_urgent_credit(self, pel_now_ns(), pel_thread_cpu_ns());
    if (may != self->real) {
        self->real = may ? set_urgent(self->priority) : !set_class(0);
    }
}

bool pel_allowance_has(struct pel_allowance *self, int64_t now_ns)
{
    double earned = (double)(now_ns - self->seen_ns) * self->share;
    double left = (double)self->left_ns + earned, most = (double)self->burst_ns;
    self->left_ns = (int64_t)(self->begun ? fmin(left, most) : most);
    self->begun = true;
    self->seen_ns = now_ns;
    return self->left_ns > 0;
}

void pel_allowance_spend(struct pel_allowance *self, int64_t used_ns)
{
    self->left_ns -= used_ns;
}

/* --- a nudge -------------------------------------------------------------- */

void pel_nudge(void)
{
    static atomic_int state; /* 1: may; −1: the kernel has none */
    int now = atomic_load_explicit(&state, memory_order_relaxed);
    if (now == 0) {
        now = syscall(SYS_membarrier, MEMBARRIER_CMD_REGISTER_PRIVATE_EXPEDITED,
                      0, 0) == 0
                  ? 1
                  : -1;
        atomic_store_explicit(&state, now, memory_order_relaxed);
    }
    if (now > 0) {
        syscall(SYS_membarrier, MEMBARRIER_CMD_PRIVATE_EXPEDITED, 0, 0);
    }
}
