/* Answers of the protobuf sessions: at once, or when they are there. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/reserve.h"
#include "cluster/cluster.h"
#include "net/command.h"
#include "net/frame_reply.h"
#include "net/session_parts.h"
#include "net/surfacewire.h"
#include "scene/almanac.h"
#include "scene/catalogue.h"
#include "scene/edit.h"
#include "scene/led.h"
#include "wire.h"

#define SHARED_NS 3000000

/* NULL: the debrief is not open. */
static struct pel_frames *frames_of(const struct job *job)
{
    const struct pel_sessions *all = job->session->all;
    return !job->of_debrief ? all->frames
           : all->debrief   ? pel_debrief_frames(all->debrief)
                            : NULL;
}

/* Frames are called off; surface answers find that nobody waits. */
void pel_session_cancel(struct session *self)
{
    for (guint i = 0; i < self->jobs->len; i++) {
        struct job *job = g_ptr_array_index(self->jobs, i);
        if (job->is_picture) {
            if (frames_of(job)) {
                pel_frames_cancel(frames_of(job), job->picture_id);
            }
            pel_claim_give(&job->claim);
            g_free(job);
        } else {
            job->session = NULL;
            if (job->series) {
                pel_series_cancel(job->series);
            }
        }
    }
    g_ptr_array_set_size(self->jobs, 0);
}

/* --- replies -------------------------------------------------------------- */

/* Something is about to be added to what waits. */
static void note_waiting(struct session *self)
{
    if (self->out.bytes == 0) {
        self->progress_ns = pel_now_ns();
    }
    pel_fdsource_wake_at(self->source, 0);
}

static void send_bytes(struct session *self, uint8_t *data, size_t size)
{
    note_waiting(self);
    pel_outbox_add(&self->out, data, size);
}

void pel_session_send_fault(struct session *self, bool has_id, uint64_t id,
                            const struct pel_fault *fault)
{
    self->all->errors++;
    size_t size = 0;
    uint8_t *data = pel_fault_reply(has_id, id, fault, &size);
    send_bytes(self, data, size);
}

/* notice: of an edit, or NULL. */
static void send_noticed(struct session *self, bool has_id, uint64_t id,
                         Pelagos__Reply__ResultCase which, const void *message,
                         char *notice)
{
    Pelagos__Reply reply = PELAGOS__REPLY__INIT;
    reply.notice = notice;
    reply.has_id = has_id;
    reply.id = id;
    reply.result_case = which;
    /* All messages that a reply may be are one union of pointers. */
    reply.state = (Pelagos__State *)message;
    size_t size = 0;
    uint8_t *data = pel_wire_pack(&reply.base, &size);
    send_bytes(self, data, size);
}

/* A reply that is a message of its own, of that case. */
static void send_message(struct session *self, bool has_id, uint64_t id,
                         Pelagos__Reply__ResultCase which, const void *message)
{
    send_noticed(self, has_id, id, which, message, NULL);
}

static void send_edited(struct session *self, bool has_id, uint64_t id,
                        char *notice)
{
    Pelagos__State state;
    pel_role_seen(pel_role_of_rank(self->who.rank),
                  pel_scene_state(self->all->scene), &state);
    send_noticed(self, has_id, id, PELAGOS__REPLY__RESULT_STATE, &state,
                 notice);
}

void pel_session_send_state(struct session *self, bool has_id, uint64_t id)
{
    send_edited(self, has_id, id, NULL);
}

/* The state packed, for all of a rank who watch: as old as the last one that
 * was sent of this revision, of 3 ms ago at most. */
static const struct pel_packed_state *packed(struct pel_sessions *all,
                                             enum pel_rank rank)
{
    struct pel_packed_state *kept = &all->packed[rank];
    int64_t now_ns = pel_now_ns();
    const Pelagos__State *state = pel_scene_state(all->scene);
    if (!kept->bytes || kept->revision != state->revision ||
        now_ns - kept->at_ns > SHARED_NS) {
        Pelagos__State seen;
        pel_role_seen(pel_role_of_rank(rank), state, &seen);
        free(kept->bytes);
        kept->size = pelagos__state__get_packed_size(&seen);
        kept->bytes = pel_sure_malloc(kept->size + 1);
        pelagos__state__pack(&seen, kept->bytes);
        kept->revision = state->revision;
        kept->at_ns = now_ns;
    }
    return kept;
}

void pel_session_send_watched(struct session *self)
{
    const struct pel_packed_state *state = packed(self->all, self->who.rank);
    uint8_t head[2 * (1 + PEL_WIRE_MAX_PREFIX) + 10];
    size_t before = 0;
    if (self->watch_has_id) {
        Pelagos__Reply id = PELAGOS__REPLY__INIT;
        id.has_id = true;
        id.id = self->watch_id;
        before = pelagos__reply__pack(&id, head);
    }
    head[before++] = PELAGOS__REPLY__RESULT_STATE << 3 | 2;
    before += pel_wire_prefix(state->size, head + before);
    uint8_t *out = pel_sure_malloc(PEL_WIRE_MAX_PREFIX + before + state->size);
    uint8_t *to = out + pel_wire_prefix(before + state->size, out);
    memcpy(to, head, before);
    memcpy(to + before, state->bytes, state->size);
    send_bytes(self, out, (size_t)(to - out) + before + state->size);
}

static void send_cluster(struct session *self, bool has_id, uint64_t id)
{
    Pelagos__Cluster *cluster = pel_cluster_status(self->all->cluster);
    send_message(self, has_id, id, PELAGOS__REPLY__RESULT_CLUSTER, cluster);
    pelagos__cluster__free_unpacked(cluster, NULL);
}

void pel_session_cluster(struct session *self, const Pelagos__Request *request)
{
    send_cluster(self, request->has_id, request->id);
}

/* Takes the job out of its session; false: the session is gone. */
static bool job_end(struct job *job)
{
    pel_claim_give(&job->claim);
    if (!job->session) {
        return false;
    }
    g_ptr_array_remove_fast(job->session->jobs, job);
    job->session->active_ns = pel_now_ns();
    return true;
}

/* Whether pictures of so many bytes may wait for the reader too. */
static enum pel_err has_room(const struct session *self, size_t size,
                             struct pel_fault *fault)
{
    size_t waiting = self->out.bytes;
    return waiting > 0 &&
                   waiting + size > self->all->limits.session_output_bytes
               ? pel_fault_set(fault, PEL_ERR_BUSY,
                               "%zu bytes of earlier replies are not read yet",
                               waiting)
               : PEL_OK;
}

/* Ends one for which the session reads nothing more: the session, where it is
 * there and the answer is a good one; a fault has been sent. */
static struct session *owed(struct job *job, enum pel_err err,
                            const struct pel_fault *fault)
{
    struct session *self = job->session;
    if (!job_end(job) || !self) {
        return NULL;
    }
    self->owes = false;
    if (err) {
        pel_session_send_fault(self, job->has_id, job->id, fault);
        return NULL;
    }
    return self;
}

/* Ends it by a message, of that case, where it is a good one. */
static void send_owed(struct job *job, enum pel_err err,
                      const struct pel_fault *fault,
                      Pelagos__Reply__ResultCase which, const void *message)
{
    struct session *self = owed(job, err, fault);
    if (self) {
        send_message(self, job->has_id, job->id, which, message);
    }
    g_free(job);
}

/* It was begun, or refused at once: then it is owed no more. */
static enum pel_err begun(struct job *job, enum pel_err err)
{
    if (err) {
        job->session->owes = false;
        g_ptr_array_remove_fast(job->session->jobs, job);
        pel_claim_give(&job->claim);
        g_free(job);
    }
    return err;
}

static void on_frame(void *user, enum pel_err err,
                     const struct pel_fault *fault, struct pel_frame *frame)
{
    struct job *job = user;
    struct session *self = job->session;
    if (job_end(job)) {
        struct pel_fault full;
        if (err == PEL_OK) {
            err = has_room(self, frame->size, &full);
            fault = &full;
        }
        if (err == PEL_OK) {
            note_waiting(self);
            pel_frame_reply_add(&self->out, job->has_id, job->id, frame);
        } else {
            pel_session_send_fault(self, job->has_id, job->id, fault);
        }
    }
    g_free(job);
}

static void on_surface(void *user, enum pel_err err,
                       const struct pel_fault *fault,
                       struct pel_surface_answer *answer)
{
    struct job *job = user;
    struct session *self = job->session;
    if (job_end(job)) {
        if (err == PEL_OK) {
            send_bytes(self, (uint8_t *)answer->text, answer->size);
            answer->text = NULL;
            self->nudge = true;
        } else {
            pel_session_send_fault(self, job->has_id, job->id, fault);
        }
    }
    g_free(job);
}

static void on_optics(void *user, enum pel_err err,
                      const struct pel_fault *fault,
                      const Pelagos__Optics *answer)
{
    struct job *job = user;
    struct session *self = job->session;
    if (job_end(job)) {
        if (err == PEL_OK) {
            send_message(self, job->has_id, job->id,
                         PELAGOS__REPLY__RESULT_OPTICS, answer);
        } else {
            pel_session_send_fault(self, job->has_id, job->id, fault);
        }
    }
    g_free(job);
}

static void on_frames(void *user, enum pel_err err,
                      const struct pel_fault *fault,
                      struct pel_frame *const *pictures, size_t count)
{
    struct job *job = user;
    struct session *self = job->session;
    if (job_end(job)) {
        struct pel_fault full;
        size_t size = 0;
        for (size_t i = 0; i < count; i++) {
            size += pictures[i]->size;
        }
        if (err == PEL_OK) {
            err = has_room(self, size, &full);
            fault = &full;
        }
        if (err == PEL_OK) {
            note_waiting(self);
            pel_frames_reply_add(&self->out, job->has_id, job->id, pictures,
                                 count);
        } else {
            pel_session_send_fault(self, job->has_id, job->id, fault);
        }
    }
    g_free(job);
}

/* --- requests ------------------------------------------------------------- */

static enum pel_err ask(struct job *job, const Pelagos__Request *request,
                        struct pel_fault *fault)
{
    struct pel_frames *frames = frames_of(job);
    const struct pel_surface_form form =
        pel_surface_reply(job->has_id, job->id);
    enum pel_err err;
    if (!frames) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "no recording is open for a debrief");
    }
    switch (request->command_case) {
    case PELAGOS__REQUEST__COMMAND_FRAME:
        err = pel_command_check(&request->frame->base, fault);
        return err ? err
                   : pel_frames_request(frames, request->frame, on_frame, job,
                                        &job->picture_id, fault);
    case PELAGOS__REQUEST__COMMAND_FRAMES:
        err = pel_command_check(&request->frames->base, fault);
        return err ? err
                   : pel_frames_request_set(frames, request->frames, on_frames,
                                            job, &job->picture_id, fault);
    case PELAGOS__REQUEST__COMMAND_OPTICS:
        return pel_command_optics(frames, request->optics, on_optics, job,
                                  fault);
    default:
        return pel_command_surface(frames, request->surface, job->session,
                                   job->session->who.rank, &form, on_surface,
                                   job, fault);
    }
}

/* One more of the session's, not among its jobs yet; NULL: BUSY. */
static struct job *new_job(struct session *self,
                           const Pelagos__Request *request,
                           struct pel_fault *fault)
{
    if (self->jobs->len >= self->all->limits.session_requests) {
        pel_fault_set(fault, PEL_ERR_BUSY,
                      "%u requests of this session are waiting",
                      self->jobs->len);
        return NULL;
    }
    struct job *job = g_new0(struct job, 1);
    job->session = self;
    job->has_id = request->has_id;
    job->id = request->id;
    return job;
}

/* In the share of who asks. */
static enum pel_err claim(struct job *job, const Pelagos__Request *request,
                          struct pel_fault *fault)
{
    struct session *self = job->session;
    enum pel_claim_kind kind = PEL_CLAIM_QUESTIONS;
    uint64_t amount = 1;
    switch (request->command_case) {
    case PELAGOS__REQUEST__COMMAND_FRAMES:
        amount = request->frames->n_frames;
        kind = PEL_CLAIM_PICTURES;
        break;
    case PELAGOS__REQUEST__COMMAND_FRAME:
        kind = PEL_CLAIM_PICTURES;
        break;
    case PELAGOS__REQUEST__COMMAND_SURFACE:
        kind = PEL_CLAIM_SURFACES;
        break;
    case PELAGOS__REQUEST__COMMAND_OPTICS:
        kind = PEL_CLAIM_OPTICS;
        break;
    default:
        break;
    }
    return pel_claim_take(self->all->claims, kind, &self->who, amount,
                          &job->claim, fault);
}

enum pel_err pel_session_start(struct session *self,
                               const Pelagos__Request *request,
                               struct pel_fault *fault)
{
    struct job *job = new_job(self, request, fault);
    if (!job) {
        return PEL_ERR_BUSY;
    }
    job->is_picture =
        request->command_case == PELAGOS__REQUEST__COMMAND_FRAME ||
        request->command_case == PELAGOS__REQUEST__COMMAND_FRAMES;
    job->of_debrief =
        request->command_case == PELAGOS__REQUEST__COMMAND_FRAME &&
        request->frame->has_debrief && request->frame->debrief;
    g_ptr_array_add(self->jobs, job);
    enum pel_err err = claim(job, request, fault);
    err = err ? err : ask(job, request, fault);
    if (err == PEL_OK && job->picture_id) {
        pel_frames_rank(frames_of(job), job->picture_id, self->who.rank);
    }
    if (err != PEL_OK) {
        g_ptr_array_remove_fast(self->jobs, job);
        pel_claim_give(&job->claim);
        g_free(job);
    }
    return err;
}

/* Of a patch or a step. */
static void on_edit(void *user, enum pel_err err, const struct pel_fault *fault)
{
    struct job *job = user;
    struct session *self = owed(job, err, fault);
    if (self) {
        send_edited(self, job->has_id, job->id, job->notice);
    }
    g_free(job->notice);
    g_free(job);
}

/* An answer that the session's later requests wait for. */
static struct job *owe(struct session *self, const Pelagos__Request *request)
{
    struct job *job = g_new0(struct job, 1);
    job->session = self;
    job->has_id = request->has_id;
    job->id = request->id;
    g_ptr_array_add(self->jobs, job);
    self->owes = true;
    return job;
}

void pel_session_patch(struct session *self, const Pelagos__Request *request)
{
    const struct pel_scene_wish wish = { .patch = request->patch };
    struct job *job = owe(self, request);
    char notice[PEL_NOTICE];
    pel_state_notice(pel_scene_state(self->all->scene), request->patch, notice);
    job->notice = notice[0] ? g_strdup(notice) : NULL;
    pel_scene_submit(self->all->scene, &wish, on_edit, job);
}

void pel_session_step(struct session *self, const Pelagos__Request *request)
{
    struct job *job = owe(self, request);
    pel_scene_submit_step(self->all->scene, request->step, on_edit, job);
}

static void on_place(void *user, enum pel_err err,
                     const struct pel_fault *fault)
{
    struct job *job = user;
    struct session *self = owed(job, err, fault);
    if (self) {
        send_cluster(self, job->has_id, job->id);
    }
    g_free(job);
}

enum pel_err pel_session_place(struct session *self,
                               const Pelagos__Request *request,
                               struct pel_fault *fault)
{
    struct job *job = owe(self, request);
    enum pel_err err = pel_cluster_place(self->all->cluster, request->place,
                                         on_place, job, fault);
    return begun(job, err);
}

/* --- exercises ------------------------------------------------------------ */

static void on_exercise(void *user, enum pel_err err,
                        const struct pel_fault *fault)
{
    struct job *job = user;
    Pelagos__ExerciseStatus *status = job->exercise;
    send_owed(job, err, fault, PELAGOS__REPLY__RESULT_EXERCISE, status);
    if (status) {
        pelagos__exercise_status__free_unpacked(status, NULL);
    }
}

static void on_command(void *user, enum pel_err err,
                       const struct pel_fault *fault,
                       Pelagos__ExerciseStatus *status, bool edited)
{
    struct job *job = user;
    job->exercise = status;
    if (!err && edited && job->session &&
        pel_scene_await(job->session->all->scene, NULL, on_exercise, job)) {
        return; /* until it is sealed */
    }
    on_exercise(job, err, fault);
}

enum pel_err pel_session_exercise(struct session *self,
                                  const Pelagos__Request *request,
                                  struct pel_fault *fault)
{
    if (!self->all->exercises) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "there are no exercises here");
    }
    pel_exercises_ask(self->all->exercises, request->exercise, on_command,
                      owe(self, request));
    return PEL_OK;
}

static void on_spectrum(void *user, enum pel_err err,
                        const struct pel_fault *fault,
                        const Pelagos__Spectrum *answer)
{
    send_owed(user, err, fault, PELAGOS__REPLY__RESULT_SPECTRUM, answer);
}

enum pel_err pel_session_spectrum(struct session *self,
                                  const Pelagos__Request *request,
                                  struct pel_fault *fault)
{
    struct job *job = owe(self, request);
    enum pel_err err = claim(job, request, fault);
    err = err ? err
              : pel_command_spectrum(self->all->scene, request->spectrum,
                                     on_spectrum, job, fault);
    return begun(job, err);
}

static void on_models(void *user, enum pel_err err,
                      const struct pel_fault *fault,
                      const Pelagos__Models *answer)
{
    send_owed(user, err, fault, PELAGOS__REPLY__RESULT_MODELS, answer);
}

enum pel_err pel_session_models(struct session *self,
                                const Pelagos__Request *request,
                                struct pel_fault *fault)
{
    struct job *job = owe(self, request);
    enum pel_err err = claim(job, request, fault);
    err = err ? err
              : pel_scene_ask_models(self->all->scene, request->models->name,
                                     on_models, job, fault);
    return begun(job, err);
}

static void on_series(void *user, enum pel_err err,
                      const struct pel_fault *fault,
                      struct pel_series_answer *answer)
{
    struct job *job = user;
    struct session *self = job->session;
    if (job_end(job)) {
        struct pel_fault full;
        if (err == PEL_OK) {
            err = has_room(self, answer->size, &full);
            fault = &full;
        }
        if (err == PEL_OK) {
            send_bytes(self, (uint8_t *)answer->data, answer->size);
            answer->data = NULL;
        } else {
            pel_session_send_fault(self, job->has_id, job->id, fault);
        }
    }
    g_free(job);
}

enum pel_err pel_session_series(struct session *self,
                                const Pelagos__Request *request,
                                struct pel_fault *fault)
{
    struct job *job = new_job(self, request, fault);
    if (!job) {
        return PEL_ERR_BUSY;
    }
    const struct pel_series_form form = {
        .reply = true, .has_id = job->has_id, .id = job->id, .who = self->who
    };
    enum pel_err err = pel_series_ask(self->all->series, request->series, &form,
                                      on_series, job, &job->series, fault);
    if (err) {
        g_free(job);
        return err;
    }
    g_ptr_array_add(self->jobs, job);
    return PEL_OK;
}

static void on_almanac(void *user, enum pel_err err,
                       const struct pel_fault *fault,
                       const Pelagos__Almanac *answer)
{
    send_owed(user, err, fault, PELAGOS__REPLY__RESULT_ALMANAC, answer);
}

enum pel_err pel_session_almanac(struct session *self,
                                 const Pelagos__Request *request,
                                 struct pel_fault *fault)
{
    enum pel_err err = pel_command_check(&request->almanac->base, fault);
    if (err) {
        return err;
    }
    struct job *job = owe(self, request);
    err = claim(job, request, fault);
    err = err ? err
              : pel_scene_ask_almanac(self->all->scene, request->almanac,
                                      on_almanac, job, fault);
    return begun(job, err);
}

static void on_recordings(void *user, enum pel_err err,
                          const struct pel_fault *fault,
                          const Pelagos__Recordings *answer)
{
    send_owed(user, err, fault, PELAGOS__REPLY__RESULT_RECORDINGS, answer);
}

static enum pel_err no_debrief(struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                         "there are no recordings here");
}

enum pel_err pel_session_recordings(struct session *self,
                                    const Pelagos__Request *request,
                                    struct pel_fault *fault)
{
    struct pel_debrief *debrief = self->all->debrief;
    enum pel_err err = debrief ? PEL_OK : no_debrief(fault);
    if (!err && request->command_case == PELAGOS__REQUEST__COMMAND_RECORDING) {
        err = pel_debrief_record(debrief, request->recording, fault);
    }
    if (err) {
        return err;
    }
    struct job *job = owe(self, request);
    err = pel_debrief_ask_recordings(debrief, on_recordings, job, fault);
    return begun(job, err);
}

enum pel_err pel_session_debrief(struct session *self,
                                 const Pelagos__Request *request,
                                 struct pel_fault *fault)
{
    struct pel_debrief *debrief = self->all->debrief;
    enum pel_err err = debrief
                           ? pel_command_check(&request->debrief->base, fault)
                           : no_debrief(fault);
    if (!err) {
        err = pel_debrief_do(debrief, request->debrief, fault);
    }
    if (!err) {
        send_message(self, request->has_id, request->id,
                     PELAGOS__REPLY__RESULT_DEBRIEF,
                     pel_debrief_status(debrief));
    }
    return err;
}
