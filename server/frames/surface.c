#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "frames/core.h"

static size_t parts_of(size_t count)
{
    return (count + PEL_SURFACE_SLICE - 1) / PEL_SURFACE_SLICE;
}

static void query_free(struct pel_surface_query *query)
{
    if (query) {
        pel_snapshot_unref(query->snapshot);
        for (size_t i = 0; query->parts && i < parts_of(query->count); i++) {
            free(query->parts[i].text);
        }
        free(query->parts);
        free(query->text);
        free(query->points);
        free(query->samples);
        free(query);
    }
}

static enum pel_err check(struct pel_frames *frames,
                          const struct pel_surface_wish *wish,
                          struct pel_fault *fault)
{
    if (frames->stopping) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT, "the daemon is stopping");
    }
    if (wish->count > PEL_MAX_SURFACE_POINTS) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%zu points are more than %d", wish->count,
                             PEL_MAX_SURFACE_POINTS);
    }
    if (wish->has_time && !(wish->time_s >= 0 && wish->time_s <= 1e9)) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "time = %g is outside 0 .. 1e+09 s", wish->time_s);
    }
    for (size_t i = 0; i < wish->count; i++) {
        struct pel_vec2 p = wish->points_m[i];
        if (!(fabs(p.x) <= PEL_FARTHEST_M && fabs(p.y) <= PEL_FARTHEST_M)) {
            return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                                 "point %zu is outside -2.1e7 .. 2.1e7 m", i);
        }
    }
    if (frames->surface_count == PEL_MAX_SURFACE_QUERIES) {
        return pel_fault_set(fault, PEL_ERR_BUSY,
                             "%d surface queries are waiting already",
                             PEL_MAX_SURFACE_QUERIES);
    }
    return PEL_OK;
}

/* --- the moments of frames ------------------------------------------------ */

void pel_surface_keep(struct pel_frames *frames, const struct pel_job *job)
{
    const struct pel_shared_sea *seas[2] = { job->snapshot->sea, NULL };
    struct pel_shown *moments = frames->shown;
    if (frames->sealed.snapshot && job->number == frames->sealed.number &&
        job->environment.time_s != frames->sealed.time_s) {
        return; /* of another time than its frame */
    }
    for (size_t i = 0; i < PEL_MAX_SHOWN; i++) {
        if (moments[i].snapshot && moments[i].number == job->number) {
            return; /* another job of the same frame */
        }
    }
    pel_snapshot_unref(moments[PEL_MAX_SHOWN - 1].snapshot);
    memmove(moments + 1, moments, (PEL_MAX_SHOWN - 1) * sizeof *moments);
    moments[0] =
        (struct pel_shown){ job->number, pel_snapshot_ref(job->snapshot),
                            job->environment.time_s };
    /* A sea may be large: of each but the newest two every frame goes. */
    for (size_t i = 1; i < PEL_MAX_SHOWN && moments[i].snapshot; i++) {
        const struct pel_shared_sea *sea = moments[i].snapshot->sea;
        seas[1] = seas[1] || sea == seas[0] ? seas[1] : sea;
        if (sea != seas[0] && sea != seas[1]) {
            pel_snapshot_unref(moments[i].snapshot);
            memmove(moments + i, moments + i + 1,
                    (PEL_MAX_SHOWN - 1 - i) * sizeof *moments);
            moments[PEL_MAX_SHOWN - 1] = (struct pel_shown){ 0 };
            i--;
        }
    }
}

static void forget_moments(struct pel_frames *frames)
{
    for (size_t i = 0; i < PEL_MAX_SHOWN; i++) {
        pel_snapshot_unref(frames->shown[i].snapshot);
        frames->shown[i] = (struct pel_shown){ 0 };
    }
}

/* The clock's time, or a moment near it that was prepared; and what the asker
 * will want next is prepared. */
static double now(struct pel_frames *frames,
                  const struct pel_surface_wish *wish,
                  const struct pel_surface_query *query)
{
    const struct pel_snapshot *s = query->snapshot;
    double time_s = pel_shown_time(frames), next_s;
    int64_t begin_ns;
    if (!wish->asker || wish->rank >= PEL_RANK_WATCH ||
        s->mode != PEL_CLOCK_FREE || !(s->rate > 0) ||
        !pel_snapshot_transforms(s)) {
        return time_s;
    }
    double answered_s =
        pel_prefetch_now(&frames->prefetch, s->sea, time_s, s->rate);
    if (pel_prefetch_next(&frames->prefetch, wish->asker, s->sea, pel_now_ns(),
                          time_s, s->rate, &next_s, &begin_ns)) {
        /* About where it asked now. */
        const struct pel_box of = pel_box_of(wish->points_m, wish->count);
        pel_surface_pool_prepare(frames->surface_pool, s, next_s, wish->moving,
                                 &of, begin_ns);
    }
    frames->stats.surfaces_prefetched += answered_s != time_s;
    return answered_s;
}

/* Which snapshot and when: of the frame asked for, or of now. */
static enum pel_err find_moment(struct pel_frames *frames,
                                const struct pel_surface_wish *wish,
                                struct pel_surface_query *query,
                                struct pel_fault *fault)
{
    if (wish->frame == 0) {
        query->snapshot = pel_shown_snapshot(frames);
        query->time_s =
            wish->has_time ? wish->time_s : now(frames, wish, query);
        return PEL_OK;
    }
    for (size_t i = 0; i < PEL_MAX_SHOWN; i++) {
        const struct pel_shown *m = &frames->shown[i];
        if (m->snapshot && m->number == wish->frame) {
            query->snapshot = pel_snapshot_ref(m->snapshot);
            query->time_s = m->time_s;
            return PEL_OK;
        }
    }
    pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                  "frame %llu is not among the last frames",
                  (unsigned long long)wish->frame);
    memcpy(fault->path, "frame", sizeof "frame");
    return PEL_ERR_NOT_FOUND;
}

/* --- queries -------------------------------------------------------------- */

enum pel_err pel_frames_surface(struct pel_frames *frames,
                                const struct pel_surface_wish *wish,
                                pel_surface_callback done, void *user,
                                struct pel_fault *fault)
{
    struct pel_surface_query *query = NULL;
    enum pel_err err = check(frames, wish, fault);
    if (!err) {
        query = calloc(1, sizeof *query);
        if (query) {
            query->points = calloc(wish->count + 1, sizeof *query->points);
            query->samples = calloc(wish->count + 1, sizeof *query->samples);
            query->parts =
                calloc(parts_of(wish->count) + 1, sizeof *query->parts);
            query->count = wish->count;
        }
        err = query && query->points && query->samples && query->parts
                  ? find_moment(frames, wish, query, fault)
                  : pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    if (err) {
        frames->stats.requests_refused++;
        query_free(query);
        return err;
    }
    if (wish->count > 0) {
        memcpy(query->points, wish->points_m,
               wish->count * sizeof *wish->points_m);
    }
    if (wish->form) {
        query->form = *wish->form;
    }
    query->time_s = wish->has_time ? wish->time_s : query->time_s;
    query->moving = wish->moving;
    query->foam = wish->foam;
    query->rank = wish->rank;
    query->done = done;
    query->user = user;
    frames->surfaces[frames->surface_count++] = query;
    frames->stats.surfaces++;
    pel_surface_pool_push(frames->surface_pool, query);
    return PEL_OK;
}

static void forget(struct pel_frames *frames, struct pel_surface_query *query)
{
    unsigned last = --frames->surface_count;
    for (unsigned i = 0; i < last; i++) {
        if (frames->surfaces[i] == query) {
            frames->surfaces[i] = frames->surfaces[last];
            break;
        }
    }
}

void pel_surface_answer(struct pel_frames *frames,
                        struct pel_surface_query *query)
{
    forget(frames, query);
    struct pel_surface_answer answer = {
        .time_s = query->time_s,
        .samples = query->samples,
        .count = query->count,
        .text = query->text,
        .size = query->size,
    };
    query->done(query->user, PEL_OK, NULL, &answer);
    query->text = answer.text;
    query->samples = answer.samples;
    query_free(query);
}

void pel_surface_finish_all(struct pel_frames *frames)
{
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_CONFLICT, "the daemon is stopping");
    forget_moments(frames);
    while (frames->surface_count > 0) {
        struct pel_surface_query *query =
            frames->surfaces[--frames->surface_count];
        query->done(query->user, PEL_ERR_CONFLICT, &fault, NULL);
        query_free(query);
    }
}
