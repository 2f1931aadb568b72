#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "frames/core.h"

static void query_free(struct pel_surface_query *query)
{
    if (query) {
        pel_snapshot_unref(query->snapshot);
        free(query->points);
        free(query->samples);
        free(query);
    }
}

static enum pel_err check(struct pel_frames *frames,
                          const struct pel_vec2 *points_m, size_t count,
                          bool has_time, double time_s, struct pel_fault *fault)
{
    if (frames->stopping) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT, "the daemon is stopping");
    }
    if (count > PEL_MAX_SURFACE_POINTS) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%zu points are more than 10000", count);
    }
    if (has_time && !(time_s >= 0 && time_s <= 1e9)) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "time = %g is outside 0 .. 1e+09 s", time_s);
    }
    for (size_t i = 0; i < count; i++) {
        if (!(fabs(points_m[i].x) <= 1e6 && fabs(points_m[i].y) <= 1e6)) {
            return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                                 "point %zu is outside -1e6 .. 1e6 m", i);
        }
    }
    if (frames->surface_count == PEL_MAX_SURFACE_QUERIES) {
        return pel_fault_set(fault, PEL_ERR_BUSY,
                             "16 surface queries are waiting already");
    }
    return PEL_OK;
}

enum pel_err pel_frames_surface(struct pel_frames *frames,
                                const struct pel_vec2 *points_m, size_t count,
                                bool has_time, double time_s,
                                pel_surface_callback done, void *user,
                                struct pel_fault *fault)
{
    enum pel_err err = check(frames, points_m, count, has_time, time_s, fault);
    if (err != PEL_OK) {
        frames->stats.requests_refused++;
        return err;
    }
    struct pel_surface_query *query = calloc(1, sizeof *query);
    if (query) {
        query->points = calloc(count + 1, sizeof *query->points);
        query->samples = calloc(count + 1, sizeof *query->samples);
    }
    if (!query || !query->points || !query->samples) {
        query_free(query);
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    if (count > 0) {
        memcpy(query->points, points_m, count * sizeof *points_m);
    }
    query->count = count;
    query->snapshot = pel_scene_snapshot(frames->scene);
    query->time_s = has_time ? time_s : pel_scene_time(frames->scene);
    query->done = done;
    query->user = user;
    frames->surfaces[frames->surface_count++] = query;
    pel_pool_push_surface(frames->pool, query);
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
    query->done(query->user, PEL_OK, NULL, query->time_s, query->samples,
                query->count);
    query_free(query);
}

void pel_surface_finish_all(struct pel_frames *frames)
{
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_CONFLICT, "the daemon is stopping");
    while (frames->surface_count > 0) {
        struct pel_surface_query *query =
            frames->surfaces[--frames->surface_count];
        query->done(query->user, PEL_ERR_CONFLICT, &fault, query->time_s, NULL,
                    0);
        query_free(query);
    }
}
