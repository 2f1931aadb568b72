#include "base/watch.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

#include "base/clock.h"
#include "base/log.h"

#define MINUTE_NS 60000000000LL
#define HOUR_NS (60 * MINUTE_NS)
#define WAITED_NS 50000000LL
#define OTHER 0

struct site {
    const char *what;
    uint64_t count, stalls, hogs;
    int64_t own_ns, own_cpu_ns; /* in the dispatch at hand */
    int64_t stalled_ns, longest_ns, longest_cpu_ns;
    struct pel_watch_told told;
};

static struct {
    struct site sites[PEL_WATCH_NAMES];
    int count;
    int now;             /* index of what is being done, -1: the loop itself */
    int64_t turn_ns;     /* the clock when that began, */
    int64_t turn_cpu_ns; /* and the thread's own */
    int64_t wake_ns, cpu_ns, begin_ns, begin_cpu_ns, named_ns;
} watch;
static _Thread_local bool watched;

static int64_t processor_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

void pel_watch_begin(void)
{
    memset(&watch, 0, sizeof watch);
    watch.sites[OTHER].what = "other";
    watch.count = 1;
    watch.now = -1;
    watched = true;
    pel_watch_wake();
}

void pel_watch_end(void)
{
    watched = false;
}

static int site_of(const char *what)
{
    for (int i = 0; i < watch.count; i++) {
        if (watch.sites[i].what == what ||
            strcmp(watch.sites[i].what, what) == 0) {
            return i;
        }
    }
    if (watch.count == PEL_WATCH_NAMES) {
        return OTHER;
    }
    watch.sites[watch.count].what = what;
    return watch.count++;
}

bool pel_watch_tells(struct pel_watch_told *told, int64_t took_ns,
                     int64_t cpu_ns, int64_t now_ns)
{
    if ((cpu_ns <= PEL_WATCH_LIMIT_NS && took_ns < WAITED_NS) ||
        (told->rest_ns > 0 && now_ns - told->at_ns < told->rest_ns)) {
        return false;
    }
    told->at_ns = now_ns;
    told->rest_ns = told->rest_ns == 0            ? MINUTE_NS
                    : 2 * told->rest_ns < HOUR_NS ? 2 * told->rest_ns
                                                  : HOUR_NS;
    return true;
}

static void stalled(struct site *site, int64_t took_ns, int64_t now_ns)
{
    int64_t cpu_ns = processor_ns() - watch.cpu_ns;
    site->stalls++;
    site->stalled_ns += took_ns;
    site->longest_ns = took_ns > site->longest_ns ? took_ns : site->longest_ns;
    if (pel_watch_tells(&site->told, took_ns, cpu_ns, now_ns)) {
        pel_info("CTL-001",
                 "the control thread was busy for %.1f ms with \"%s\" (%.1f ms "
                 "of processor since it woke), %llu times by now: meanwhile "
                 "nobody else was answered",
                 (double)took_ns * 1e-6, site->what, (double)cpu_ns * 1e-6,
                 (unsigned long long)site->stalls);
    }
}

/* What was done until now_ns is that of `watch.now`. */
static void turn(int64_t now_ns, int64_t cpu_ns)
{
    if (watch.now >= 0) {
        watch.sites[watch.now].own_ns += now_ns - watch.turn_ns;
        watch.sites[watch.now].own_cpu_ns += cpu_ns - watch.turn_cpu_ns;
    }
    watch.turn_ns = now_ns;
    watch.turn_cpu_ns = cpu_ns;
}

struct pel_watch_scope pel_watch_enter(const char *what)
{
    struct pel_watch_scope scope = { -1 };
    if (!watched) {
        return scope;
    }
    int64_t now_ns = pel_now_ns(), cpu_ns = processor_ns();
    turn(now_ns, cpu_ns);
    scope.before = watch.now;
    if (watch.now < 0) {
        watch.begin_ns = now_ns;
        watch.begin_cpu_ns = cpu_ns;
    }
    watch.now = site_of(what);
    watch.sites[watch.now].count++;
    return scope;
}

/* The outermost ends: whose it was. */
static void judge(int64_t now_ns, int64_t now_cpu_ns)
{
    int64_t took_ns = now_ns - watch.begin_ns;
    int64_t cpu_ns = now_cpu_ns - watch.begin_cpu_ns;
    struct site *most = &watch.sites[OTHER], *hog = most;
    for (int i = 0; i < watch.count; i++) {
        struct site *site = &watch.sites[i];
        most = site->own_ns > most->own_ns ? site : most;
        hog = site->own_cpu_ns > hog->own_cpu_ns ? site : hog;
    }
    if (took_ns > PEL_WATCH_LIMIT_NS) {
        stalled(most, took_ns, now_ns);
    }
    hog->hogs += cpu_ns > PEL_WATCH_LIMIT_NS;
    hog->longest_cpu_ns =
        cpu_ns > hog->longest_cpu_ns ? cpu_ns : hog->longest_cpu_ns;
    for (int i = 0; i < watch.count; i++) {
        watch.sites[i].own_ns = watch.sites[i].own_cpu_ns = 0;
    }
    watch.named_ns += took_ns;
}

void pel_watch_leave(const struct pel_watch_scope *scope)
{
    if (!watched || watch.now < 0) {
        return;
    }
    int64_t now_ns = pel_now_ns(), cpu_ns = processor_ns();
    turn(now_ns, cpu_ns);
    watch.now = scope->before;
    if (watch.now < 0) {
        judge(now_ns, cpu_ns);
    }
}

void pel_watch_sleep(void)
{
    int64_t now_ns = pel_now_ns();
    int64_t rest_ns = now_ns - watch.wake_ns - watch.named_ns;
    if (watched && watch.now < 0 && rest_ns > PEL_WATCH_LIMIT_NS) {
        stalled(&watch.sites[OTHER], rest_ns, now_ns);
    }
}

void pel_watch_wake(void)
{
    watch.named_ns = 0;
    watch.cpu_ns = processor_ns();
    watch.wake_ns = pel_now_ns();
}

static const struct site *find(const char *what)
{
    for (int i = 0; i < watch.count; i++) {
        if (strcmp(watch.sites[i].what, what) == 0) {
            return &watch.sites[i];
        }
    }
    return NULL;
}

uint64_t pel_watch_count(const char *what)
{
    const struct site *site = find(what);
    return site ? site->count : 0;
}

uint64_t pel_watch_stalls(const char *what)
{
    const struct site *site = find(what);
    return site ? site->stalls : 0;
}

uint64_t pel_watch_busy(const char *what)
{
    const struct site *site = find(what);
    return site ? site->hogs : 0;
}

int64_t pel_watch_spent_ns(void)
{
    return watched && watch.now >= 0 ? processor_ns() - watch.begin_cpu_ns : 0;
}

void pel_watch_collect(void *user, struct pel_metrics_page *page)
{
    (void)user;
    for (int i = 0; i < watch.count; i++) {
        const struct site *site = &watch.sites[i];
        char label[64];
        snprintf(label, sizeof label, "what=\"%s\"", site->what);
        pel_metric(page, "pelagos_control_work_total", PEL_METRIC_COUNTER,
                   "Things that the control thread did, by name.", label,
                   (double)site->count);
        pel_metric(page, "pelagos_control_stalls_total", PEL_METRIC_COUNTER,
                   "Those that kept it from everything else for more than a "
                   "millisecond.",
                   label, (double)site->stalls);
        pel_metric(page, "pelagos_control_stall_seconds_total",
                   PEL_METRIC_COUNTER, "How long they did.", label,
                   (double)site->stalled_ns * 1e-9);
        pel_metric(page, "pelagos_control_stall_longest_seconds",
                   PEL_METRIC_GAUGE, "The longest of them.", label,
                   (double)site->longest_ns * 1e-9);
        pel_metric(page, "pelagos_control_processor_stalls_total",
                   PEL_METRIC_COUNTER,
                   "Things that took the control thread more than a "
                   "millisecond of processor.",
                   label, (double)site->hogs);
        pel_metric(page, "pelagos_control_processor_longest_seconds",
                   PEL_METRIC_GAUGE,
                   "The most processor that the control thread took for one "
                   "of them.",
                   label, (double)site->longest_cpu_ns * 1e-9);
    }
}
