#include "service.h"

#include <glib.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <systemd/sd-daemon.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"

#define WANTED_DESCRIPTORS 8192
#define NEEDED_DESCRIPTORS 256
/* Sockets and the loop take 20, a device, an encoder and a reader of files some
 * more, and somebody is to be served. */
#define LEAST_DESCRIPTORS 64
#define NEEDED_MEMORY ((rlim_t)1 << 30)

static unsigned count_descriptors(void)
{
    unsigned count = 0;
    GDir *dir = g_dir_open("/proc/self/fd", 0, NULL);
    while (dir && g_dir_read_name(dir)) {
        count++;
    }
    if (dir) {
        g_dir_close(dir);
        count--; /* the directory itself */
    }
    return count;
}

static enum pel_err check_descriptors(rlim_t limit, struct pel_fault *fault)
{
    unsigned open = count_descriptors();
    if (limit >= (rlim_t)open + LEAST_DESCRIPTORS) {
        return PEL_OK;
    }
    return pel_fault_set(
        fault, PEL_ERR_IO,
        "%llu file descriptors are allowed and %u are open already, and it "
        "needs %d more, to serve many clients %d: `ulimit -n %d`, or "
        "LimitNOFILE=%d in the unit",
        (unsigned long long)limit, open, LEAST_DESCRIPTORS, NEEDED_DESCRIPTORS,
        WANTED_DESCRIPTORS, WANTED_DESCRIPTORS);
}

enum pel_err pel_service_limits(struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit) == 0) {
        rlim_t want = limit.rlim_max < WANTED_DESCRIPTORS ? limit.rlim_max
                                                          : WANTED_DESCRIPTORS;
        if (limit.rlim_cur < want) {
            limit.rlim_cur = want;
            if (setrlimit(RLIMIT_NOFILE, &limit) != 0) {
                pel_warn(
                    "DMN-010",
                    "the limit of file descriptors could not be raised; many "
                    "clients at once may be refused (LimitNOFILE, ulimit "
                    "-n)");
            }
        }
        err = check_descriptors(limit.rlim_cur, fault);
        if (!err && limit.rlim_cur < NEEDED_DESCRIPTORS) {
            pel_warn("DMN-011",
                     "only %llu descriptors are allowed; %d are "
                     "wanted (LimitNOFILE, ulimit -n)",
                     (unsigned long long)limit.rlim_cur, NEEDED_DESCRIPTORS);
        }
    }
    if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
        limit.rlim_cur < NEEDED_MEMORY) {
        pel_warn("DMN-012",
                 "address space is limited to %llu MiB, and "
                 "OpenGL does not survive a refused allocation; use a cgroup",
                 (unsigned long long)(limit.rlim_cur >> 20));
    }
    return err;
}

/* --- the first frame ----------------------------------------------------- */

struct warm_up {
    int64_t started_ns;
    void (*ready)(void *user);
    void *user;
};

static void say_no_frame(const struct pel_fault *fault)
{
    pel_warn("DMN-004", "no first frame: %s", fault->message);
}

static void warm_up_done(void *user, enum pel_err err,
                         const struct pel_fault *fault, struct pel_frame *frame)
{
    struct warm_up *warm_up = user;
    double ms = (double)(pel_now_ns() - warm_up->started_ns) * 1e-6;
    if (err == PEL_OK) {
        pel_info("DMN-003",
                 "first frame %.0f ms after the start (%.0f ms of "
                 "drawing)",
                 ms, frame->render_ms);
    } else {
        say_no_frame(fault);
    }
    warm_up->ready(warm_up->user);
    free(warm_up);
}

static gboolean warm_up_nothing(gpointer user)
{
    PEL_WATCH("service");
    struct warm_up *warm_up = user;
    warm_up->ready(warm_up->user);
    free(warm_up);
    return G_SOURCE_REMOVE;
}

void pel_service_warm_up(struct pel_frames *frames, struct pel_scene *scene,
                         int64_t started_ns, void (*ready)(void *user),
                         void *user)
{
    struct warm_up *warm_up = g_new0(struct warm_up, 1);
    *warm_up = (struct warm_up){ started_ns, ready, user };
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    char view[PEL_NAME_SIZE] = "";
    if (s->view_count > 0) {
        g_strlcpy(view, s->views[0].name, sizeof view);
    }
    pel_snapshot_unref(s);
    Pelagos__FrameRequest request = PELAGOS__FRAME_REQUEST__INIT;
    request.view = view;
    request.has_width = request.has_height = true;
    request.width = 64;
    request.height = 36;
    struct pel_fault fault;
    if (view[0] == 0) {
        pel_info("DMN-005", "the scene has no view to draw first");
        g_idle_add(warm_up_nothing, warm_up);
    } else if (pel_frames_request(frames, &request, warm_up_done, warm_up, NULL,
                                  &fault) != PEL_OK) {
        say_no_frame(&fault);
        g_idle_add(warm_up_nothing, warm_up);
    }
}

/* --- systemd ------------------------------------------------------------- */

struct pel_service {
    struct pel_frames *frames;
    guint watchdog, status;
};

/* Idle or drawing is alive; only a frame that does not end is not. */
static gboolean feed_watchdog(gpointer user)
{
    PEL_WATCH("service");
    struct pel_service *service = user;
    if (!pel_frames_stuck(service->frames)) {
        sd_notify(0, "WATCHDOG=1");
    }
    return G_SOURCE_CONTINUE;
}

static gboolean report_status(gpointer user)
{
    PEL_WATCH("service");
    struct pel_service *service = user;
    struct pel_frames_stats s;
    pel_frames_get_stats(service->frames, &s);
    sd_notifyf(0, "STATUS=%llu frames, %u live views, %.1f ms a view",
               (unsigned long long)s.frames_drawn, s.subscriptions,
               s.render_ms_median);
    return G_SOURCE_CONTINUE;
}

struct pel_service *pel_service_ready(struct pel_frames *frames)
{
    struct pel_service *service = g_new0(struct pel_service, 1);
    uint64_t watchdog_us = 0;
    service->frames = frames;
    sd_notify(0, "READY=1\nSTATUS=ready");
    if (sd_watchdog_enabled(0, &watchdog_us) > 0) {
        guint ms = (guint)(watchdog_us / 3000);
        service->watchdog = g_timeout_add(ms, feed_watchdog, service);
    }
    if (getenv("NOTIFY_SOCKET")) {
        service->status = g_timeout_add_seconds(10, report_status, service);
    }
    return service;
}

void pel_service_stopping(struct pel_service *service)
{
    if (service) {
        sd_notify(0, "STOPPING=1");
        if (service->watchdog) {
            g_source_remove(service->watchdog);
        }
        if (service->status) {
            g_source_remove(service->status);
        }
        g_free(service);
    }
}
