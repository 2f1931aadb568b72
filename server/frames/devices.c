#include "frames/devices.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "render/context.h"

/* Shares between their start and pixels. */
#define MAX_SHARES 2
/* A view's work beside its pixels, in these. */
#define VIEW_PIXELS 65536.0
/* How fast what was seen is forgotten. */
#define LEARN 0.1
#define LEAST_FACTOR 0.1
#define MOST_FACTOR 10.0

struct device {
    struct pel_renderloop *loop;
    uint64_t views;
    double ms_per_pixel; /* of a usual view; 0: not known */
};

struct pel_devices {
    struct device device[PEL_MAX_DEVICES];
    struct pel_renderloop *loops[PEL_MAX_DEVICES];
    size_t count;
    /* By the view's index: its time beside that of a usual one. A guess, after
     * views came or went. */
    double factor[PEL_MAX_VIEWS];
    char text[PEL_MAX_DEVICES * 64];
    char names[PEL_MAX_DEVICES][16]; /* as renderers are told */
};

/* --- which there are ------------------------------------------------------ */

static enum pel_err add_name(struct pel_devices *devices, const char *name,
                             size_t length, struct pel_fault *fault)
{
    if (devices->count == PEL_MAX_DEVICES) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "device: at most %d devices draw together",
                             PEL_MAX_DEVICES);
    }
    snprintf(devices->names[devices->count++], sizeof devices->names[0], "%.*s",
             (int)length, name);
    return PEL_OK;
}

static enum pel_err read_list(struct pel_devices *devices, const char *list,
                              struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    if (strcmp(list, "all") == 0) {
        unsigned numbers[PEL_MAX_DEVICES];
        size_t count = pel_context_hardware(numbers, PEL_MAX_DEVICES);
        for (size_t i = 0; i < count && err == PEL_OK; i++) {
            char name[16];
            snprintf(name, sizeof name, "%u", numbers[i]);
            err = add_name(devices, name, strlen(name), fault);
        }
        return count > 0 ? err : add_name(devices, "auto", 4, fault);
    }
    for (const char *at = list; err == PEL_OK; at++) {
        size_t length = strcspn(at, ",");
        err = add_name(devices, at, length, fault);
        at += length;
        if (*at == 0) {
            break;
        }
    }
    return err;
}

/* --- life ------------------------------------------------------------------
 */

enum pel_err pel_devices_create(const struct pel_devices_options *o,
                                struct pel_encoder_pool *pool,
                                struct pel_mailbox *box,
                                struct pel_devices **out,
                                struct pel_fault *fault)
{
    struct pel_devices *devices = calloc(1, sizeof *devices);
    if (!devices) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    for (int i = 0; i < PEL_MAX_VIEWS; i++) {
        devices->factor[i] = 1;
    }
    enum pel_err err = read_list(devices, o->list ? o->list : "auto", fault);
    size_t started = 0;
    while (err == PEL_OK && started < devices->count) {
        struct pel_renderer_options own = o->renderer;
        own.device = devices->names[started];
        if (o->lose_only >= 0 && o->lose_only != (int)started) {
            own.lose_after = 0;
        }
        err = pel_renderloop_create(&own, (unsigned)started, pool, box,
                                    &devices->loops[started], fault);
        devices->device[started].loop = devices->loops[started];
        started += err == PEL_OK;
    }
    devices->count = started;
    for (size_t i = 0; i < started; i++) {
        struct pel_fault why = { 0 };
        enum pel_err own = pel_renderloop_wait(devices->loops[i],
                                               devices->loops, started, &why);
        if (own != PEL_OK && err == PEL_OK) {
            err = own;
            pel_fault_set(fault, own, "%.300s", why.message);
        }
    }
    if (err != PEL_OK) {
        if (pel_devices_stop(devices)) {
            pel_devices_destroy(devices);
        }
        return err;
    }
    *out = devices;
    return PEL_OK;
}

bool pel_devices_stop(struct pel_devices *devices)
{
    bool joined = true;
    for (size_t i = 0; i < devices->count; i++) {
        joined = pel_renderloop_stop(devices->loops[i]) && joined;
    }
    return joined;
}

void pel_devices_destroy(struct pel_devices *devices)
{
    for (size_t i = 0; devices && i < devices->count; i++) {
        pel_renderloop_destroy(devices->loops[i]);
    }
    free(devices);
}

/* --- what they are and do --------------------------------------------------
 */

size_t pel_devices_count(const struct pel_devices *devices)
{
    return devices->count;
}

const char *pel_devices_describe(struct pel_devices *devices)
{
    if (devices->count == 1) {
        return pel_renderloop_device(devices->loops[0]);
    }
    size_t used = 0;
    for (size_t i = 0; i < devices->count && used < sizeof devices->text; i++) {
        used += (size_t)snprintf(
            devices->text + used, sizeof devices->text - used, "%s%zu: %s",
            i ? "; " : "", i, pel_renderloop_device(devices->loops[i]));
    }
    return devices->text;
}

/* The first that has a device, or the first. */
static struct pel_renderloop *leader(const struct pel_devices *devices)
{
    for (size_t i = 0; i < devices->count; i++) {
        if (pel_renderloop_stands(devices->loops[i])) {
            return devices->loops[i];
        }
    }
    return devices->loops[0];
}

bool pel_devices_software(const struct pel_devices *devices)
{
    return pel_renderloop_is_software(leader(devices));
}

size_t pel_devices_standing(const struct pel_devices *devices)
{
    size_t count = 0;
    for (size_t i = 0; i < devices->count; i++) {
        count += pel_renderloop_stands(devices->loops[i]);
    }
    return count > 0 ? count : 1;
}

bool pel_devices_room(const struct pel_devices *devices)
{
    bool standing = false, room = false;
    for (size_t i = 0; i < devices->count; i++) {
        const struct pel_renderloop *loop = devices->loops[i];
        bool stands = pel_renderloop_stands(loop);
        standing = standing || stands;
        room = room || (stands && pel_renderloop_shares(loop) < MAX_SHARES);
    }
    return room ||
           (!standing && pel_renderloop_shares(devices->loops[0]) < MAX_SHARES);
}

void pel_devices_push_optics(struct pel_devices *devices,
                             struct pel_optics_query *query)
{
    pel_renderloop_push_optics(leader(devices), query);
}

void pel_devices_set_band(struct pel_devices *devices, uint64_t pixels)
{
    for (size_t i = 0; i < devices->count; i++) {
        pel_renderloop_set_band(devices->loops[i], pixels);
    }
}

void pel_devices_released(struct pel_devices *devices,
                          const struct pel_job_draw *part)
{
    pel_renderloop_released(devices->loops[part->device], part);
}

static const struct pel_renderloop *
silent_longest(const struct pel_devices *devices)
{
    const struct pel_renderloop *silent = devices->loops[0];
    for (size_t i = 1; i < devices->count; i++) {
        if (pel_renderloop_progress_ns(devices->loops[i]) <
            pel_renderloop_progress_ns(silent)) {
            silent = devices->loops[i];
        }
    }
    return silent;
}

int64_t pel_devices_progress_ns(const struct pel_devices *devices)
{
    return pel_renderloop_progress_ns(silent_longest(devices));
}

bool pel_devices_compute(const struct pel_devices *devices)
{
    return pel_renderloop_computes(silent_longest(devices));
}

bool pel_devices_in_compute(const struct pel_devices *devices)
{
    return pel_renderloop_in_compute(leader(devices));
}

void pel_devices_stats(struct pel_devices *devices, size_t device,
                       struct pel_device_stats *out)
{
    const struct device *d = &devices->device[device];
    *out = (struct pel_device_stats){
        .name = pel_renderloop_device(d->loop),
        .standing = pel_renderloop_stands(d->loop),
        .views = d->views,
        .ms_per_mpixel = d->ms_per_pixel * 1e6,
    };
    pel_renderloop_losses(d->loop, &out->losses);
}

/* --- spreading --------------------------------------------------------------
 */

static double pixels_of(const struct pel_job *job, size_t draw)
{
    const struct pel_camera *c = &job->draws[draw].camera;
    return job->parts[draw].radar ? 0
                                  : (double)c->width * c->height + VIEW_PIXELS;
}

/* Of a device that has drawn nothing yet: as the others. */
static double speed(const struct pel_devices *devices, size_t device)
{
    if (devices->device[device].ms_per_pixel > 0) {
        return devices->device[device].ms_per_pixel;
    }
    double sum = 0;
    int known = 0;
    for (size_t i = 0; i < devices->count; i++) {
        sum += devices->device[i].ms_per_pixel;
        known += devices->device[i].ms_per_pixel > 0;
    }
    return known > 0 ? sum / known : 1e-6;
}

/* Indices of the draws, the dearest first. */
static size_t by_cost(const struct pel_devices *devices,
                      const struct pel_job *job, uint8_t *order, double *cost)
{
    for (size_t i = 0; i < job->draw_count; i++) {
        double own = pixels_of(job, i) * devices->factor[job->parts[i].view];
        size_t at = i;
        while (at > 0 && cost[order[at - 1]] < own) {
            order[at] = order[at - 1];
            at--;
        }
        order[at] = (uint8_t)i;
        cost[i] = own;
    }
    return job->draw_count;
}

/* Indices of the draws: those of one place, which share their light, together.
 */
static void by_place(const struct pel_job *job, uint8_t *order)
{
    size_t count = 0;
    for (size_t place = 0; place < job->place_count; place++) {
        for (size_t i = 0; i < job->draw_count; i++) {
            if (job->parts[i].place == place) {
                order[count++] = (uint8_t)i;
            }
        }
    }
}

/* The device that would be done with it first, of those that would begin it
 * soon if there are any. */
static size_t soonest(const struct pel_devices *devices, const double *ready_ms,
                      double cost)
{
    size_t best = devices->count;
    double best_ms = 0;
    bool best_full = true;
    for (size_t i = 0; i < devices->count; i++) {
        const struct pel_renderloop *loop = devices->loops[i];
        double ms = ready_ms[i] + cost * speed(devices, i);
        bool full = pel_renderloop_shares(loop) >= MAX_SHARES;
        bool better = full == best_full ? ms < best_ms : best_full;
        if (pel_renderloop_stands(loop) && (best == devices->count || better)) {
            best = i;
            best_ms = ms;
            best_full = full;
        }
    }
    return best < devices->count ? best : 0;
}

void pel_devices_push(struct pel_devices *devices, struct pel_job *job)
{
    uint8_t order[PEL_MAX_VIEWS] = { 0 }, device_of[PEL_MAX_VIEWS] = { 0 };
    double cost[PEL_MAX_VIEWS] = { 0 }, ready_ms[PEL_MAX_DEVICES] = { 0 };
    size_t count = by_cost(devices, job, order, cost);
    for (size_t i = 0; i < devices->count; i++) {
        ready_ms[i] =
            (double)pel_renderloop_work(devices->loops[i]) * speed(devices, i);
    }
    if (job->large) {
        size_t device = soonest(devices, ready_ms, cost[order[0]]);
        pel_renderloop_push_large(devices->loops[device], job);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        size_t draw = order[i], device = soonest(devices, ready_ms, cost[draw]);
        ready_ms[device] += cost[draw] * speed(devices, device);
        device_of[draw] = (uint8_t)device;
    }
    uint8_t in_places[PEL_MAX_VIEWS];
    by_place(job, in_places);
    for (size_t d = 0; d < devices->count; d++) {
        struct pel_share *share = &job->shares[d];
        share->job = job;
        share->count = 0;
        for (size_t k = 0; k < count; k++) {
            size_t i = in_places[k];
            if (device_of[i] == d) {
                share->draws[share->count++] = (uint8_t)i;
            }
        }
    }
    /* The job is theirs from the first push on, but for the shares' counts. */
    bool has[PEL_MAX_DEVICES];
    for (size_t d = 0; d < devices->count; d++) {
        has[d] = job->shares[d].count > 0;
    }
    for (size_t d = 0; d < devices->count; d++) {
        if (has[d]) {
            pel_renderloop_push(devices->loops[d], &job->shares[d]);
        }
    }
}

/* Towards what was seen, by at most twice what was known: the first picture of
 * a size or of a renderer pays for programs and buffers. */
static double learn(double known, double seen)
{
    double most = known > 0 ? 2 * known : seen;
    return known > 0 ? known + LEARN * (fmin(seen, most) - known) : seen;
}

/* One that drew nothing of late is thought to be as fast as the fastest, little
 * by little: or what it once took would keep it idle for good. */
static void forgive(struct pel_devices *devices, const bool *drew)
{
    double best = 0;
    for (size_t i = 0; i < devices->count; i++) {
        double own = devices->device[i].ms_per_pixel;
        best = own > 0 && (best == 0 || own < best) ? own : best;
    }
    for (size_t i = 0; i < devices->count; i++) {
        double *own = &devices->device[i].ms_per_pixel;
        if (!drew[i] && *own > best) {
            *own += LEARN * (best - *own);
        }
    }
}

void pel_devices_note(struct pel_devices *devices, const struct pel_job *job)
{
    bool drew[PEL_MAX_DEVICES] = { false };
    for (size_t i = 0; i < job->draw_count; i++) {
        const struct pel_job_draw *part = &job->parts[i];
        if (part->err != PEL_OK || part->radar || !(part->render_ms > 0)) {
            continue;
        }
        double seen = part->render_ms / pixels_of(job, i);
        double *factor = &devices->factor[part->view];
        struct device *d = &devices->device[part->device];
        drew[part->device] = true;
        d->views++;
        d->ms_per_pixel = learn(d->ms_per_pixel, seen / *factor);
        *factor = pel_clamp(learn(*factor, seen / d->ms_per_pixel),
                            LEAST_FACTOR, MOST_FACTOR);
    }
    forgive(devices, drew);
}
