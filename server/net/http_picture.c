/* Answers with a picture, or with several of one frame. */
#include <stdio.h>
#include <string.h>

#include "formats.h"
#include "json.h"
#include "net/http_client.h"

#define BOUNDARY "pelagos-frame"

typedef void (*add_header)(void *to, const char *name, const char *value);

static void add_to_response(void *to, const char *name, const char *value)
{
    MHD_add_response_header(to, name, value);
}

static void add_to_text(void *to, const char *name, const char *value)
{
    g_string_append_printf(to, "%s: %s\r\n", name, value);
}

/* What the pictures of a frame have in common. */
static void add_moment(add_header add, void *to, const struct pel_frame *frame)
{
    char text[64], stale[PEL_STALE_TEXT];
    snprintf(text, sizeof text, "%llu", (unsigned long long)frame->number);
    add(to, "X-Pelagos-Frame", text);
    pel_json_number(frame->time_s, text);
    add(to, "X-Pelagos-Time", text);
    snprintf(text, sizeof text, "%llu", (unsigned long long)frame->revision);
    add(to, "X-Pelagos-Revision", text);
    add(to, "X-Pelagos-Stale", pel_stale_text(frame->stale, stale));
    if (frame->in_ground) {
        add(to, "X-Pelagos-Ground", "inside");
    }
    if (frame->host_frame != 0) {
        snprintf(text, sizeof text, "%u", frame->host_frame);
        add(to, "X-Pelagos-Host-Frame", text);
    }
}

static void add_cost(add_header add, void *to, const struct pel_frame *frame)
{
    char text[64];
    snprintf(text, sizeof text, "%.3f", frame->render_ms);
    add(to, "X-Pelagos-Render-Ms", text);
    snprintf(text, sizeof text, "%.3f", frame->encode_ms);
    add(to, "X-Pelagos-Encode-Ms", text);
    snprintf(text, sizeof text, "%u", frame->device);
    add(to, "X-Pelagos-Device", text);
}

/* --- one picture ---------------------------------------------------------- */

static void unref_frame(void *frame)
{
    pel_frame_unref(frame);
}

static void on_frame(void *user, enum pel_err err,
                     const struct pel_fault *fault, struct pel_frame *frame)
{
    struct client *client = user;
    client->waiting = false;
    client->frame_id = 0;
    pel_claim_give(&client->pictures);
    if (err != PEL_OK) {
        pel_http_send_fault(client, 0, fault);
    } else {
        const struct MHD_IoVec all = { frame->data, frame->size };
        struct MHD_Response *response =
            pel_http_pieces(&all, 1, unref_frame, pel_frame_ref(frame));
        add_to_response(response, "Content-Type",
                        pel_format_of(frame->format)->mime);
        add_to_response(response, "Cache-Control", "no-store");
        add_moment(add_to_response, response, frame);
        add_cost(add_to_response, response, frame);
        pel_http_hold(client, frame->size);
        pel_http_queue(client, 200, response);
    }
    pel_http_resume(client);
}

static enum pel_err claim(struct client *client, size_t pictures,
                          struct pel_fault *fault)
{
    return pel_claim_take(client->server->context.claims, PEL_CLAIM_PICTURES,
                          &client->who, pictures, &client->pictures, fault);
}

/* After asking; the answer may have come already. */
static enum MHD_Result await(struct client *client, enum pel_err err,
                             uint64_t id, const struct pel_fault *fault)
{
    if (err != PEL_OK) {
        client->waiting = false;
        pel_claim_give(&client->pictures);
        return pel_http_send_fault(client, 0, fault);
    }
    if (client->waiting) {
        client->frame_id = id;
        pel_frames_rank(pel_http_frames(client), id, client->who.rank);
        pel_http_suspend(client);
    }
    return MHD_YES;
}

enum MHD_Result pel_http_send_frame(struct client *client,
                                    struct pel_http_answer *answer)
{
    struct pel_fault fault;
    uint64_t id = 0;
    client->waiting = true;
    enum pel_err err = claim(client, 1, &fault);
    err = err ? err
              : pel_frames_request(pel_http_frames(client), answer->frame,
                                   on_frame, client, &id, &fault);
    pel_http_answer_finish(answer);
    return await(client, err, id, &fault);
}

/* --- HEAD ----------------------------------------------------------------- */

static ssize_t no_body(void *user, uint64_t at, char *buffer, size_t size)
{
    (void)user;
    (void)at;
    (void)buffer;
    (void)size;
    return MHD_CONTENT_READER_END_OF_STREAM;
}

static enum pel_err check_all(struct pel_frames *frames,
                              const struct pel_http_answer *answer,
                              const char **type, struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    switch (answer->kind) {
    case PEL_HTTP_FRAME:
        *type = pel_format_of(answer->frame->format)->mime;
        return pel_frames_check(frames, answer->frame, fault);
    case PEL_HTTP_FRAMES:
        *type = "multipart/mixed; boundary=" BOUNDARY;
        for (size_t i = 0; i < answer->frames->n_frames && err == PEL_OK; i++) {
            err = pel_frames_check(frames, answer->frames->frames[i], fault);
        }
        return err;
    case PEL_HTTP_MJPEG:
        *type = PEL_MJPEG_TYPE;
        return PEL_OK;
    case PEL_HTTP_TS:
        *type = PEL_TS_TYPE;
        return PEL_OK;
    default:
        *type = "application/json";
        return PEL_OK;
    }
}

enum MHD_Result pel_http_send_head(struct client *client,
                                   struct pel_http_answer *answer)
{
    struct pel_fault fault;
    const char *type = NULL;
    enum pel_err err =
        check_all(pel_http_frames(client), answer, &type, &fault);
    pel_http_answer_finish(answer);
    if (err != PEL_OK) {
        return pel_http_send_fault(client, 0, &fault);
    }
    /* How long it would be only drawing could tell. */
    struct MHD_Response *response = MHD_create_response_from_callback(
        MHD_SIZE_UNKNOWN, 1, no_body, NULL, NULL);
    add_to_response(response, "Content-Type", type);
    add_to_response(response, "Cache-Control", "no-store");
    return pel_http_queue(client, 200, response);
}

/* --- several, as multipart/mixed ------------------------------------------ */

/* The heads of the parts, and the pictures between them. */
struct parts {
    size_t count;
    struct pel_frame *pictures[PEL_MAX_VIEWS];
    char *heads[PEL_MAX_VIEWS];
};

static void free_parts(void *pointer)
{
    struct parts *parts = pointer;
    for (size_t i = 0; i < parts->count; i++) {
        pel_frame_unref(parts->pictures[i]);
        g_free(parts->heads[i]);
    }
    g_free(parts);
}

static char *head_of(const struct pel_frame *picture, bool first)
{
    GString *text = g_string_new(first ? "" : "\r\n");
    char size[32];
    snprintf(size, sizeof size, "%zu", picture->size);
    g_string_append(text, "--" BOUNDARY "\r\n");
    add_to_text(text, "Content-Type", pel_format_of(picture->format)->mime);
    add_to_text(text, "Content-Length", size);
    g_string_append_printf(
        text, "Content-Disposition: attachment; filename=\"%s.%s\"\r\n",
        picture->view, pel_format_of(picture->format)->ending);
    add_to_text(text, "X-Pelagos-View", picture->view);
    add_moment(add_to_text, text, picture);
    add_cost(add_to_text, text, picture);
    g_string_append(text, "\r\n");
    return g_string_free(text, FALSE);
}

static struct MHD_Response *make_parts(struct pel_frame *const *pictures,
                                       size_t count)
{
    static const char end[] = "\r\n--" BOUNDARY "--\r\n";
    struct MHD_IoVec pieces[2 * PEL_MAX_VIEWS + 1];
    struct parts *parts = g_new0(struct parts, 1);
    parts->count = count;
    for (size_t i = 0; i < count; i++) {
        parts->pictures[i] = pel_frame_ref(pictures[i]);
        parts->heads[i] = head_of(pictures[i], i == 0);
        pieces[2 * i] =
            (struct MHD_IoVec){ parts->heads[i], strlen(parts->heads[i]) };
        pieces[2 * i + 1] =
            (struct MHD_IoVec){ pictures[i]->data, pictures[i]->size };
    }
    pieces[2 * count] = (struct MHD_IoVec){ end, sizeof end - 1 };
    return pel_http_pieces(pieces, 2 * count + 1, free_parts, parts);
}

static size_t size_of(struct pel_frame *const *pictures, size_t count)
{
    size_t size = 0;
    for (size_t i = 0; i < count; i++) {
        size += pictures[i]->size;
    }
    return size;
}

static void on_frames(void *user, enum pel_err err,
                      const struct pel_fault *fault,
                      struct pel_frame *const *pictures, size_t count)
{
    struct client *client = user;
    client->waiting = false;
    client->frame_id = 0;
    pel_claim_give(&client->pictures);
    struct pel_fault own;
    struct MHD_Response *response =
        err == PEL_OK ? make_parts(pictures, count) : NULL;
    if (response) {
        add_to_response(response, "Content-Type",
                        "multipart/mixed; boundary=" BOUNDARY);
        add_to_response(response, "Cache-Control", "no-store");
        add_moment(add_to_response, response, pictures[0]);
        pel_http_hold(client, size_of(pictures, count));
        pel_http_queue(client, 200, response);
    } else {
        if (err == PEL_OK) {
            pel_fault_set(&own, PEL_ERR_NO_MEMORY, "out of memory");
            fault = &own;
        }
        pel_http_send_fault(client, 0, fault);
    }
    pel_http_resume(client);
}

enum MHD_Result pel_http_send_frames(struct client *client,
                                     struct pel_http_answer *answer)
{
    struct pel_fault fault;
    uint64_t id = 0;
    client->waiting = true;
    enum pel_err err = claim(client, answer->frames->n_frames, &fault);
    err = err ? err
              : pel_frames_request_set(pel_http_frames(client), answer->frames,
                                       on_frames, client, &id, &fault);
    pel_http_answer_finish(answer);
    return await(client, err, id, &fault);
}
