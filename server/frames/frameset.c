/* Pictures of one frame: requests that begin in one job, or not at all. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "frames/core.h"

struct member {
    struct pel_frame_set *set;
    uint64_t id; /* of its request */
    struct pel_frame *picture;
};

struct pel_frame_set {
    struct pel_frames *frames;
    uint64_t id; /* the first request's */
    bool begun;
    size_t count, waiting;
    pel_frame_set_callback done;
    void *user;
    struct member members[];
};

size_t pel_set_count(const struct pel_frame_set *set)
{
    return set->count;
}

bool pel_set_begun(const struct pel_frame_set *set)
{
    return set->begun;
}

void pel_set_begin(struct pel_frame_set *set)
{
    set->begun = true;
}

/* What is still waited for is waited for no more. */
static void set_free(struct pel_frame_set *set)
{
    for (size_t i = 0; i < set->count; i++) {
        pel_request_forget(set->frames, set->members[i].id);
        pel_frame_unref(set->members[i].picture);
    }
    free(set);
}

static void finish(struct pel_frame_set *set)
{
    struct pel_frame *pictures[PEL_MAX_VIEWS];
    for (size_t i = 0; i < set->count; i++) {
        pictures[i] = set->members[i].picture;
    }
    set->done(set->user, PEL_OK, NULL, pictures, set->count);
    set_free(set);
}

static void on_picture(void *user, enum pel_err err,
                       const struct pel_fault *fault, struct pel_frame *picture)
{
    struct member *member = user;
    struct pel_frame_set *set = member->set;
    if (err != PEL_OK) {
        set->done(set->user, err, fault, NULL, 0);
        set_free(set);
        return;
    }
    member->picture = pel_frame_ref(picture);
    if (--set->waiting == 0) {
        finish(set);
    }
}

static enum pel_err check_one(struct pel_frames *frames,
                              const Pelagos__FrameRequest *r, size_t index,
                              struct pel_fault *fault)
{
    struct pel_fault own;
    enum pel_err err = pel_request_check(frames, r, &own);
    if (err == PEL_OK && r->has_time) {
        err = pel_request_refuse(frames, &own, PEL_ERR_INVALID, "time",
                                 "pictures of one frame have one time: give "
                                 "it beside them");
    }
    if (err != PEL_OK && fault) {
        char path[sizeof fault->path];
        *fault = own;
        snprintf(path, sizeof path, "frames.%zu%s%.60s", index,
                 *own.path ? "." : "", own.path);
        memcpy(fault->path, path, sizeof path);
    }
    return err;
}

static enum pel_err check(struct pel_frames *frames,
                          const Pelagos__FramesRequest *request,
                          struct pel_fault *fault)
{
    size_t bytes = 0;
    if (request->n_frames < 1 || request->n_frames > PEL_MAX_VIEWS) {
        return pel_request_refuse(frames, fault, PEL_ERR_INVALID, "frames",
                                  "a set has 1 to 64 pictures");
    }
    if (request->has_time && !(request->time >= 0 && request->time <= 1e9)) {
        return pel_request_refuse(frames, fault, PEL_ERR_OUT_OF_RANGE, "time",
                                  "time is outside 0 .. 1e9 s");
    }
    const struct pel_snapshot *s = pel_shown_snapshot(frames);
    enum pel_err err = PEL_OK;
    for (size_t i = 0; i < request->n_frames && err == PEL_OK; i++) {
        err = check_one(frames, request->frames[i], i, fault);
        bytes += err == PEL_OK ? pel_request_bytes(s, request->frames[i]) : 0;
    }
    pel_snapshot_unref(s);
    if (err == PEL_OK && bytes > PEL_FRAME_SET_BYTES) {
        err = pel_request_refuse(frames, fault, PEL_ERR_INVALID, "frames",
                                 "the pictures of a set may have 256 MiB "
                                 "together, 4 bytes a pixel or what the "
                                 "layers take: ask for fewer or smaller ones");
    }
    if (err == PEL_OK && pel_requests_free(frames) < request->n_frames) {
        err = pel_request_refuse(frames, fault, PEL_ERR_BUSY, "",
                                 "too many pictures are waiting already");
    }
    return err;
}

enum pel_err pel_frames_request_set(struct pel_frames *frames,
                                    const Pelagos__FramesRequest *request,
                                    pel_frame_set_callback done, void *user,
                                    uint64_t *id, struct pel_fault *fault)
{
    enum pel_err err = check(frames, request, fault);
    if (err != PEL_OK) {
        return err;
    }
    size_t count = request->n_frames;
    struct pel_frame_set *set =
        calloc(1, sizeof *set + count * sizeof set->members[0]);
    if (!set) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    set->frames = frames;
    set->count = set->waiting = count;
    set->done = done;
    set->user = user;
    for (size_t i = 0; i < count; i++) {
        Pelagos__FrameRequest one = *request->frames[i];
        one.has_time = request->has_time;
        one.time = request->time;
        struct member *member = &set->members[i];
        struct pel_frame_request *slot =
            pel_request_take(frames, &one, on_picture, member);
        member->set = slot->set = set;
        member->id = slot->id;
    }
    set->id = set->members[0].id;
    if (id) {
        *id = set->id;
    }
    return PEL_OK;
}

void pel_frames_cancel(struct pel_frames *frames, uint64_t id)
{
    for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
        struct pel_frame_request *r = &frames->requests[i];
        if (r->used && r->set && r->set->id == id) {
            set_free(r->set);
            return;
        }
    }
    pel_request_forget(frames, id);
}
