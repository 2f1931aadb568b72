#include "net/http_client.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "cluster/cluster.h"
#include "json.h"
#include "net/command.h"
#include "net/http_hangup.h"
#include "net/http_share.h"
#include "net/http_view.h"
#include "net/surfacewire.h"
#include "scene/almanac.h"
#include "scene/catalogue.h"
#include "scene/led.h"
#include "scene/soundings.h"

/* What pages of other origins may read of an answer, beside what browsers give
 * them anyway, and send with a request. */
#define EXPOSED                                                                \
    "Location, ETag, Link, Allow, Retry-After, WWW-Authenticate, "             \
    "X-Pelagos-Ignored, X-Pelagos-Notice, X-Pelagos-Ground, "                  \
    "X-Pelagos-Frame, X-Pelagos-Time, "                                        \
    "X-Pelagos-Revision, X-Pelagos-Stale, X-Pelagos-Host-Frame, "              \
    "X-Pelagos-Unix, X-Pelagos-Render-Ms, X-Pelagos-Encode-Ms, "               \
    "X-Pelagos-Device"
#define SENT                                                                   \
    "Authorization, Content-Type, Accept, If-Match, If-None-Match, Range, "    \
    "Cache-Control, Pragma, X-Requested-With"
#define PREFLIGHT_S "600"

int64_t pel_http_after(double s)
{
    return pel_now_ns() + (int64_t)(s * 1e9);
}

void pel_http_kick(struct pel_http_server *server)
{
    server->run_again = true;
    g_main_context_wakeup(NULL);
}

void pel_http_resume(struct client *client)
{
    if (client->suspended && !client->waiting) {
        client->suspended = false;
        MHD_resume_connection(client->connection);
        pel_http_kick(client->server);
    }
}

void pel_http_suspend(struct client *client)
{
    if (!client->suspended) {
        client->suspended = true;
        MHD_suspend_connection(client->connection);
    }
    if (client->gone) {
        pel_http_probe_soon(client->server);
    }
}

static void add(struct MHD_Response *response, const char *name,
                const char *value)
{
    MHD_add_response_header(response, name, value);
}

static void add_safety(const struct client *client, int status,
                       struct MHD_Response *response)
{
    add(response, "X-Content-Type-Options", "nosniff");
    add(response, "Cross-Origin-Resource-Policy",
        client->origin ? "cross-origin" : "same-origin");
    if (client->origin) {
        add(response, "Access-Control-Allow-Origin", client->origin);
        add(response, "Access-Control-Expose-Headers", EXPOSED);
    }
    if (client->server->context.origins) {
        add(response, "Vary", "Origin"); /* for caches between */
    }
    if (client->ignored[0]) {
        add(response, "X-Pelagos-Ignored", client->ignored);
    }
    if (client->notice[0] && status == 200) {
        add(response, "X-Pelagos-Notice", client->notice);
    }
    add(response, "Referrer-Policy", "no-referrer");
}

enum MHD_Result pel_http_queue(struct client *client, int status,
                               struct MHD_Response *response)
{
    struct pel_http_server *server = client->server;
    if (status < PEL_HTTP_STATUS_MAX) {
        server->answers[status]++;
    }
    if (client->phase != PHASE_CLOSED) {
        client->phase = PHASE_ANSWER;
        client->deadline_ns = pel_http_after(server->limits.http_answer_s);
    }
    add_safety(client, status, response);
    if (client->changes && status < 300 &&
        pel_scene_volatile(server->context.scene)) {
        add(response, "X-Pelagos-Volatile", "the disk is full");
    }
    enum MHD_Result result =
        MHD_queue_response(client->connection, (unsigned)status, response);
    MHD_destroy_response(response);
    return result;
}

enum MHD_Result pel_http_send(struct client *client,
                              struct pel_http_answer *answer)
{
    struct MHD_Response *response;
    if (pel_http_write_later(client, answer)) {
        return MHD_YES;
    }
    const struct MHD_IoVec all = { answer->owned ? answer->owned : answer->body,
                                   answer->size };
    response =
        pel_http_pieces(&all, 1, answer->owned ? free : NULL, answer->owned);
    answer->owned = NULL;
    add(response, "Cache-Control",
        answer->cache  ? answer->cache
        : answer->page ? "no-cache"
                       : "no-store");
    if (answer->type) {
        add(response, "Content-Type", answer->type);
    }
    if (answer->page) {
        add(response, "Content-Security-Policy",
            "default-src 'self'; img-src 'self' blob:; media-src 'self' blob:; "
            "base-uri 'none'; "
            "form-action 'none'; frame-ancestors 'none'");
    }
    if (answer->allow) {
        add(response, "Allow", answer->allow);
    }
    if (answer->preflight) {
        add(response, "Access-Control-Allow-Methods", answer->preflight);
        add(response, "Access-Control-Allow-Headers", SENT);
        add(response, "Access-Control-Max-Age", PREFLIGHT_S);
        /* A browser whose page is of the internet asks this too. */
        add(response, "Access-Control-Allow-Private-Network", "true");
    }
    if (answer->tag[0]) {
        add(response, "ETag", answer->tag);
    }
    if (answer->location[0]) {
        add(response, "Location", answer->location);
    }
    if (answer->retry_after_s) {
        add(response, "Retry-After", "1");
    }
    if (answer->upgrade) {
        add(response, "Upgrade", "websocket");
    }
    if (answer->challenge) {
        add(response, "WWW-Authenticate", "Bearer realm=\"pelagos\"");
    }
    if (answer->challenge_basic) {
        add(response, "WWW-Authenticate", "Basic realm=\"pelagos\"");
    }
    if (answer->close) {
        add(response, "Connection", "close");
    }
    int status = answer->status;
    if (!answer->page) {
        pel_http_hold(client, answer->size);
    }
    pel_http_answer_finish(answer);
    return pel_http_queue(client, status, response);
}

enum MHD_Result pel_http_send_fault(struct client *client, int status,
                                    const struct pel_fault *fault)
{
    struct pel_http_answer answer = { .kind = PEL_HTTP_WHOLE };
    pel_http_problem(&answer, status, fault);
    return pel_http_send(client, &answer);
}

/* --- the surface, light ----------------------------------------------------
 */

static void end_reader(void *user)
{
    pel_http_shut(user);
}

void pel_http_hold(struct client *client, size_t bytes)
{
    client->unread.end = end_reader;
    client->unread.user = client;
    pel_claim_unread(client->server->context.claims, &client->who, bytes,
                     &client->unread);
}

struct waiter *pel_http_wait_begin(struct client *client)
{
    struct waiter *waiter = g_new0(struct waiter, 1);
    waiter->client = client;
    client->waiter = waiter;
    client->waiting = true;
    return waiter;
}

/* Whose waiter this was; NULL: gone. */
struct client *pel_http_wait_end(struct waiter *waiter)
{
    struct client *client = waiter->client;
    pel_claim_give(&waiter->claim);
    g_free(waiter);
    if (client) {
        client->waiter = NULL;
        client->waiting = false;
    }
    return client;
}

/* Of an error; 0: the one that it has everywhere. */
static int status_of(const struct waiter *waiter, enum pel_err err)
{
    return err == PEL_ERR_NOT_FOUND ? waiter->not_found : 0;
}

/* After the command was given; the answer may have come already. */
static enum MHD_Result wait_on(struct client *client, struct waiter *waiter,
                               enum pel_err err, const struct pel_fault *fault)
{
    if (err != PEL_OK) {
        int status = status_of(waiter, err);
        pel_http_wait_end(waiter);
        return pel_http_send_fault(client, status, fault);
    }
    if (client->waiting) {
        pel_http_suspend(client);
    }
    return MHD_YES;
}

static void send_json(struct client *client, const ProtobufCMessage *message)
{
    struct pel_http_answer answer = { .kind = PEL_HTTP_WHOLE };
    pel_http_copy(&answer, 200, message);
    pel_http_send(client, &answer);
}

/* What was waited for is there, or why it is not. */
static void wait_answer(struct waiter *waiter, enum pel_err err,
                        const struct pel_fault *fault,
                        const ProtobufCMessage *answer)
{
    int status = status_of(waiter, err);
    struct client *client = pel_http_wait_end(waiter);
    if (!client) {
        return;
    }
    if (err != PEL_OK) {
        pel_http_send_fault(client, status, fault);
    } else {
        send_json(client, answer);
    }
    pel_http_resume(client);
}

/* In the share of who asks. */
static enum pel_err claim(struct waiter *waiter, enum pel_claim_kind kind,
                          struct pel_fault *fault)
{
    const struct client *client = waiter->client;
    return pel_claim_take(client->server->context.claims, kind, &client->who, 1,
                          &waiter->claim, fault);
}

static void on_surface(void *user, enum pel_err err,
                       const struct pel_fault *fault,
                       struct pel_surface_answer *answer)
{
    if (err != PEL_OK) {
        wait_answer(user, err, fault, NULL);
        return;
    }
    struct client *client = pel_http_wait_end(user);
    if (client) {
        struct pel_http_answer out = { .status = 200,
                                       .type = "application/json",
                                       .owned = answer->text,
                                       .body = answer->text,
                                       .size = answer->size };
        answer->text = NULL;
        pel_http_send(client, &out);
        pel_http_resume(client);
    }
}

enum MHD_Result pel_http_send_surface(struct client *client,
                                      struct pel_http_answer *answer)
{
    struct pel_fault fault;
    struct waiter *waiter = pel_http_wait_begin(client);
    enum pel_err err = claim(waiter, PEL_CLAIM_SURFACES, &fault);
    err = err ? err
              : pel_command_surface(client->server->frames, answer->surface,
                                    NULL, client->who.rank, &pel_surface_json,
                                    on_surface, waiter, &fault);
    pel_http_forget_later(client, answer);
    return wait_on(client, waiter, err, &fault);
}

static void on_optics(void *user, enum pel_err err,
                      const struct pel_fault *fault,
                      const Pelagos__Optics *answer)
{
    wait_answer(user, err, fault, err == PEL_OK ? &answer->base : NULL);
}

enum MHD_Result pel_http_send_optics(struct client *client,
                                     struct pel_http_answer *answer)
{
    struct pel_fault fault;
    struct waiter *waiter = pel_http_wait_begin(client);
    enum pel_err err = claim(waiter, PEL_CLAIM_OPTICS, &fault);
    err = err ? err
              : pel_command_optics(client->server->frames, answer->optics,
                                   on_optics, waiter, &fault);
    pel_http_answer_finish(answer);
    return wait_on(client, waiter, err, &fault);
}

/* The file, or of several a tar. */
static void send_files(struct client *client, const Pelagos__Spectrum *answer)
{
    const Pelagos__SpectrumFile *first = answer->files[0];
    struct pel_http_answer out = { .status = 200 };
    if (answer->n_files > 1) {
        out.type = "application/x-tar";
        out.owned = pel_http_tar(answer, &out.size);
    } else {
        out.type = strcmp(first->type, "application/netcdf") == 0
                       ? "application/netcdf"
                       : "text/plain; charset=utf-8";
        out.owned = g_memdup2(first->content.data, first->content.len);
        out.size = first->content.len;
    }
    out.body = out.owned;
    pel_http_send(client, &out);
}

static void on_spectrum(void *user, enum pel_err err,
                        const struct pel_fault *fault,
                        const Pelagos__Spectrum *answer)
{
    if (err == PEL_OK && answer->n_files > 0) {
        struct client *client = pel_http_wait_end(user);
        if (client) {
            send_files(client, answer);
            pel_http_resume(client);
        }
        return;
    }
    wait_answer(user, err, fault, err == PEL_OK ? &answer->base : NULL);
}

enum MHD_Result pel_http_send_spectrum(struct client *client,
                                       struct pel_http_answer *answer)
{
    struct pel_fault fault;
    struct waiter *waiter = pel_http_wait_begin(client);
    waiter->not_found = 400; /* a record that the question names */
    enum pel_err err = claim(waiter, PEL_CLAIM_QUESTIONS, &fault);
    err = err ? err
              : pel_command_spectrum(client->server->context.scene,
                                     answer->spectrum, on_spectrum, waiter,
                                     &fault);
    pel_http_answer_finish(answer);
    return wait_on(client, waiter, err, &fault);
}

static void on_soundings(void *user, enum pel_err err,
                         const struct pel_fault *fault, float *depth_m,
                         size_t count)
{
    if (err != PEL_OK) {
        wait_answer(user, err, fault, NULL);
        return;
    }
    struct client *client = pel_http_wait_end(user);
    if (!client) {
        free(depth_m);
        return;
    }
    struct pel_http_answer out = { .status = 200,
                                   .type = "application/octet-stream",
                                   .owned = (char *)depth_m,
                                   .body = depth_m,
                                   .size = count * sizeof *depth_m };
    pel_http_send(client, &out);
    pel_http_resume(client);
}

enum MHD_Result pel_http_send_soundings(struct client *client,
                                        struct pel_http_answer *answer)
{
    struct pel_fault fault;
    struct waiter *waiter = pel_http_wait_begin(client);
    enum pel_err err = claim(waiter, PEL_CLAIM_QUESTIONS, &fault);
    err = err ? err
              : pel_scene_ask_soundings(client->server->context.scene,
                                        answer->soundings, on_soundings, waiter,
                                        &fault);
    pel_http_answer_finish(answer);
    return wait_on(client, waiter, err, &fault);
}

static void on_almanac(void *user, enum pel_err err,
                       const struct pel_fault *fault,
                       const Pelagos__Almanac *answer)
{
    wait_answer(user, err, fault, err == PEL_OK ? &answer->base : NULL);
}

enum MHD_Result pel_http_send_almanac(struct client *client,
                                      struct pel_http_answer *answer)
{
    struct pel_fault fault;
    struct waiter *waiter = pel_http_wait_begin(client);
    enum pel_err err = claim(waiter, PEL_CLAIM_QUESTIONS, &fault);
    err = err ? err
              : pel_scene_ask_almanac(client->server->context.scene,
                                      answer->almanac, on_almanac, waiter,
                                      &fault);
    pel_http_answer_finish(answer);
    return wait_on(client, waiter, err, &fault);
}

static void on_place(void *user, enum pel_err err,
                     const struct pel_fault *fault)
{
    struct client *client = ((struct waiter *)user)->client;
    Pelagos__Cluster *cluster =
        err || !client ? NULL
                       : pel_cluster_status(client->server->context.cluster);
    wait_answer(user, err, fault, cluster ? &cluster->base : NULL);
    if (cluster) {
        pelagos__cluster__free_unpacked(cluster, NULL);
    }
}

enum MHD_Result pel_http_send_place(struct client *client,
                                    struct pel_http_answer *answer)
{
    struct pel_fault fault = { .minimum = 1 };
    struct waiter *waiter = pel_http_wait_begin(client);
    enum pel_err err =
        pel_cluster_place(client->server->context.cluster, answer->place,
                          on_place, waiter, &fault);
    pel_http_answer_finish(answer);
    return wait_on(client, waiter, err, &fault);
}

static void on_series(void *user, enum pel_err err,
                      const struct pel_fault *fault,
                      struct pel_series_answer *answer)
{
    struct client *client = pel_http_wait_end(user);
    if (!client) {
        return;
    }
    if (err != PEL_OK) {
        pel_http_send_fault(client, err == PEL_ERR_NOT_FOUND ? 400 : 0, fault);
    } else {
        struct pel_http_answer out = { .status = 200,
                                       .type = answer->type,
                                       .owned = answer->data,
                                       .body = answer->data,
                                       .size = answer->size };
        answer->data = NULL;
        pel_http_send(client, &out);
    }
    pel_http_resume(client);
}

enum MHD_Result pel_http_send_series(struct client *client,
                                     struct pel_http_answer *answer)
{
    struct pel_fault fault;
    const struct pel_series_form form = { .who = client->who };
    struct waiter *waiter = pel_http_wait_begin(client);
    waiter->not_found = 400; /* an axis that the question names */
    enum pel_err err =
        pel_series_ask(client->server->context.series, answer->series, &form,
                       on_series, waiter, &waiter->series, &fault);
    pel_http_answer_finish(answer);
    return wait_on(client, waiter, err, &fault);
}

static void answer_exercise(struct pel_http_answer *answer,
                            Pelagos__ExerciseStatus *status)
{
    Pelagos__Exercise **exercise = answer->shows == PEL_HTTP_SAVED
                                       ? &answer->exercise->exercise
                                       : &status->exercise;
    if (answer->shows == PEL_HTTP_STATUS_OF) {
        pel_http_message(answer, 200, &status->base, false);
        return;
    }
    if (answer->shows == PEL_HTTP_NOTHING) {
        answer->status = 204;
    } else {
        pel_http_message(answer, 200, &g_steal_pointer(exercise)->base, true);
    }
    pelagos__exercise_status__free_unpacked(status, NULL);
}

static void on_exercise(void *user, enum pel_err err,
                        const struct pel_fault *fault,
                        Pelagos__ExerciseStatus *status, bool edited)
{
    struct waiter *waiter = user;
    struct pel_http_answer *answer = waiter->ready;
    int not_found = err == PEL_ERR_NOT_FOUND ? answer->not_found : 0;
    struct client *client = pel_http_wait_end(waiter);
    if (err) {
        pel_http_problem(answer, not_found, fault);
    } else {
        answer_exercise(answer, status);
    }
    if (client) {
        client->server->malformed += answer->status == 400;
        (void)(edited ? pel_http_send_sealed(client, answer)
                      : pel_http_send(client, answer));
        pel_http_resume(client);
    } else {
        pel_http_answer_finish(answer);
    }
    g_free(answer);
}

enum MHD_Result pel_http_send_exercise(struct client *client,
                                       struct pel_http_answer *answer)
{
    struct waiter *waiter = pel_http_wait_begin(client);
    waiter->ready = g_memdup2(answer, sizeof *answer);
    pel_exercises_ask(client->server->context.exercises, answer->exercise,
                      on_exercise, waiter);
    if (client->waiting) {
        pel_http_suspend(client);
    }
    return MHD_YES;
}

static void on_models(void *user, enum pel_err err,
                      const struct pel_fault *fault,
                      const Pelagos__Models *answer)
{
    wait_answer(user, err, fault, err == PEL_OK ? &answer->base : NULL);
}

enum MHD_Result pel_http_send_models(struct client *client,
                                     struct pel_http_answer *answer)
{
    struct pel_fault fault;
    struct waiter *waiter = pel_http_wait_begin(client);
    enum pel_err err = claim(waiter, PEL_CLAIM_QUESTIONS, &fault);
    err = err ? err
              : pel_scene_ask_models(client->server->context.scene, NULL,
                                     on_models, waiter, &fault);
    pel_http_answer_finish(answer);
    return wait_on(client, waiter, err, &fault);
}

static void on_recordings(void *user, enum pel_err err,
                          const struct pel_fault *fault,
                          const Pelagos__Recordings *answer)
{
    wait_answer(user, err, fault, err == PEL_OK ? &answer->base : NULL);
}

enum MHD_Result pel_http_send_recordings(struct client *client,
                                         struct pel_http_answer *answer)
{
    struct pel_fault fault;
    struct waiter *waiter = pel_http_wait_begin(client);
    enum pel_err err = claim(waiter, PEL_CLAIM_QUESTIONS, &fault);
    err = err ? err
              : pel_debrief_ask_recordings(client->server->context.debrief,
                                           on_recordings, waiter, &fault);
    pel_http_answer_finish(answer);
    return wait_on(client, waiter, err, &fault);
}

/* Of a patch or a step. */
static void on_edit(void *user, enum pel_err err, const struct pel_fault *fault)
{
    bool if_unchanged = ((struct waiter *)user)->if_unchanged;
    struct client *client = pel_http_wait_end(user);
    struct pel_http_answer answer = { .kind = PEL_HTTP_WHOLE };
    if (!client) {
        return;
    }
    if (err == PEL_OK) {
        pel_http_answer_state(&client->server->context,
                              pel_role_of_rank(client->who.rank), &answer);
    } else if (if_unchanged && strcmp(fault->path, PEL_SCENE_REVISION) == 0) {
        pel_http_problem(&answer, 412, fault);
    } else {
        pel_http_answer_refused(&answer, fault);
        client->server->malformed += answer.status == 400;
    }
    pel_http_send(client, &answer);
    pel_http_resume(client);
}

enum MHD_Result pel_http_send_patched(struct client *client,
                                      struct pel_http_answer *answer)
{
    const struct pel_scene_wish wish = {
        .patch = answer->patch,
        .if_unchanged = answer->if_unchanged,
    };
    struct pel_scene *scene = client->server->context.scene;
    pel_state_notice(pel_scene_state(scene), answer->patch, client->notice);
    struct waiter *waiter = pel_http_wait_begin(client);
    waiter->if_unchanged = answer->if_unchanged;
    bool waits = pel_scene_submit(scene, &wish, on_edit, waiter);
    pel_http_forget_later(client, answer);
    if (waits) {
        pel_http_suspend(client);
    }
    return MHD_YES;
}

enum MHD_Result pel_http_send_stepped(struct client *client,
                                      struct pel_http_answer *answer)
{
    struct waiter *waiter = pel_http_wait_begin(client);
    bool waits = pel_scene_submit_step(client->server->context.scene,
                                       &answer->step, on_edit, waiter);
    pel_http_answer_finish(answer);
    if (waits) {
        pel_http_suspend(client);
    }
    return MHD_YES;
}

static void on_sealed(void *user, enum pel_err err,
                      const struct pel_fault *fault)
{
    struct pel_http_answer *answer = ((struct waiter *)user)->ready;
    struct client *client = pel_http_wait_end(user);
    if (client && err) {
        pel_http_send_fault(client, 0, fault);
    } else if (client) {
        pel_http_send(client, answer);
    }
    pel_http_answer_finish(answer); /* what was sent is empty */
    g_free(answer);
    if (client) {
        pel_http_resume(client);
    }
}

enum MHD_Result pel_http_send_sealed(struct client *client,
                                     struct pel_http_answer *answer)
{
    struct waiter *waiter = pel_http_wait_begin(client);
    waiter->ready = g_memdup2(answer, sizeof *answer);
    if (!pel_scene_await(client->server->context.scene, NULL, on_sealed,
                         waiter)) {
        g_free(waiter->ready);
        pel_http_wait_end(waiter);
        return pel_http_send(client, answer);
    }
    pel_http_suspend(client);
    return MHD_YES;
}

struct pel_frames *pel_http_frames(const struct client *client)
{
    return client->of_debrief
               ? pel_debrief_frames(client->server->context.debrief)
               : client->server->frames;
}

/* --- HLS ------------------------------------------------------------------ */

static void on_hls(void *user, enum pel_err err, const struct pel_fault *fault,
                   const struct pel_hls_answer *answer)
{
    struct client *client = pel_http_wait_end(user);
    if (!client) {
        return;
    }
    if (err != PEL_OK) {
        pel_http_send_fault(client, 0, fault);
    } else {
        struct pel_http_answer out = { .status = 200,
                                       .type = answer->type,
                                       .cache = answer->cache,
                                       .size = answer->size };
        out.owned = g_memdup2(answer->data, answer->size);
        out.body = out.owned;
        pel_http_send(client, &out);
    }
    pel_http_resume(client);
}

enum MHD_Result pel_http_send_hls(struct client *client,
                                  struct pel_http_answer *answer)
{
    struct waiter *waiter = pel_http_wait_begin(client);
    if (answer->kind == PEL_HTTP_HLS_FILE) {
        pel_hls_file(client->server->hls, answer->file, on_hls, waiter);
    } else {
        struct pel_hls_wish *wish = &answer->hls;
        wish->profile = answer->profile;
        g_strlcpy(wish->view, answer->view, sizeof wish->view);
        pel_hls_playlist(client->server->hls, wish, on_hls, waiter);
    }
    pel_http_answer_finish(answer);
    if (client->waiting) {
        pel_http_suspend(client);
    }
    return MHD_YES;
}

void pel_http_call_off(struct client *client)
{
    if (client->queued) {
        g_queue_remove(&client->server->takers, client);
        client->queued = false;
    }
    if (client->frame_id && pel_http_frames(client)) {
        pel_frames_cancel(pel_http_frames(client), client->frame_id);
        client->frame_id = 0;
    }
    if (client->waiter &&
        (pel_hls_forget(client->server->hls, client->waiter) ||
         pel_whep_forget(client->server->whep, client->waiter))) {
        pel_http_wait_end(client->waiter);
    }
    if (client->waiter) {
        client->waiter->client = NULL;
        if (client->waiter->series) {
            pel_series_cancel(client->waiter->series);
        }
        client->waiter = NULL;
    }
    client->waiting = false;
    pel_claim_give(&client->pictures);
}
