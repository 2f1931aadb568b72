#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "formats.h"
#include "frames/core.h"

enum pel_err pel_request_refuse(struct pel_frames *frames,
                                struct pel_fault *fault, enum pel_err code,
                                const char *path, const char *message)
{
    frames->stats.requests_refused++;
    pel_fault_set(fault, code, "%s", message);
    if (fault) {
        snprintf(fault->path, sizeof fault->path, "%s", path);
    }
    return code;
}

static enum pel_err refuse_range(struct pel_frames *frames,
                                 struct pel_fault *fault, const char *path,
                                 double value, const char *unit, double minimum,
                                 double maximum)
{
    frames->stats.requests_refused++;
    pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE, "%s = %g is outside %g .. %g %s",
                  path, value, minimum, maximum, unit);
    if (fault) {
        snprintf(fault->path, sizeof fault->path, "%s", path);
        snprintf(fault->value, sizeof fault->value, "%g", value);
        fault->unit = unit;
        fault->minimum = minimum;
        fault->maximum = maximum;
    }
    return PEL_ERR_OUT_OF_RANGE;
}

static Pelagos__FrameFormat format_of(const Pelagos__FrameRequest *r)
{
    return r->has_format ? r->format : PELAGOS__FRAME_FORMAT__JPEG;
}

/* Layers of a request as bits; 0: there is an unknown one. */
static unsigned read_layers(const Pelagos__FrameRequest *request)
{
    unsigned layers = 0;
    for (size_t i = 0; i < request->n_layers; i++) {
        const struct pel_layer_info *layer = pel_layer_find(request->layers[i]);
        if (!layer) {
            return 0;
        }
        layers |= layer->bit;
    }
    return layers ? layers : PEL_LAYER_RADIANCE;
}

static bool view_exists(struct pel_frames *frames, const char *view)
{
    const struct pel_snapshot *s = pel_shown_snapshot(frames);
    bool exists = view && pel_snapshot_find_view(s, view) >= 0;
    pel_snapshot_unref(s);
    return exists;
}

static bool is_radar(struct pel_frames *frames, const char *view)
{
    const struct pel_snapshot *s = pel_shown_snapshot(frames);
    int index = view ? pel_snapshot_find_view(s, view) : -1;
    bool radar = index >= 0 && s->views[index].radar.on;
    pel_snapshot_unref(s);
    return radar;
}

size_t pel_request_bytes(const struct pel_snapshot *s,
                         const Pelagos__FrameRequest *r)
{
    int index = pel_snapshot_find_view(s, r->view);
    const struct pel_view_state *v = index >= 0 ? &s->views[index] : NULL;
    size_t width = r->has_width ? r->width : v ? v->width : 0;
    size_t height = r->has_height ? r->height : v ? v->height : 0;
    return width * height * pel_layer_bytes(pel_request_layers(r));
}

uint64_t pel_request_pixels(const struct pel_snapshot *s,
                            const struct pel_frame_request *r)
{
    int index = pel_snapshot_find_view(s, r->view);
    const struct pel_view_state *v = index >= 0 ? &s->views[index] : NULL;
    uint64_t width = r->width ? r->width : v ? v->width : 0;
    return width * (r->height ? r->height : v ? v->height : 0);
}

/* One picture alone may take what a set may. */
static enum pel_err check_memory(struct pel_frames *frames,
                                 const Pelagos__FrameRequest *r,
                                 struct pel_fault *fault)
{
    const struct pel_snapshot *s = pel_shown_snapshot(frames);
    size_t bytes = pel_request_bytes(s, r);
    pel_snapshot_unref(s);
    char message[160];
    if (bytes <= PEL_FRAME_SET_BYTES) {
        return PEL_OK;
    }
    snprintf(message, sizeof message,
             "these layers take %zu MiB before they are encoded, and a "
             "picture may have %zu: ask for fewer, or for fewer pixels",
             (bytes >> 20) + 1, PEL_FRAME_SET_BYTES >> 20);
    return pel_request_refuse(frames, fault, PEL_ERR_INVALID, "layers",
                              message);
}

enum pel_err pel_request_check(struct pel_frames *frames,
                               const Pelagos__FrameRequest *r,
                               struct pel_fault *fault)
{
    if (frames->stopping) {
        return pel_request_refuse(frames, fault, PEL_ERR_CONFLICT, "",
                                  "the daemon is stopping");
    }
    if (r->has_width && (r->width < 16 || r->width > 4096)) {
        return refuse_range(frames, fault, "width", r->width, "px", 16, 4096);
    }
    if (r->has_height && (r->height < 16 || r->height > 4096)) {
        return refuse_range(frames, fault, "height", r->height, "px", 16, 4096);
    }
    if (r->has_time && !(r->time >= 0 && r->time <= 1e9)) {
        return refuse_range(frames, fault, "time", r->time, "s", 0, 1e9);
    }
    if (r->has_quality && (r->quality < 1 || r->quality > 100)) {
        return refuse_range(frames, fault, "quality", r->quality, "", 1, 100);
    }
    const struct pel_format *format = pel_format_of(format_of(r));
    char words[256];
    if (!format) {
        snprintf(words, sizeof words, "format is none of %s", pel_format_names);
        return pel_request_refuse(frames, fault, PEL_ERR_INVALID, "format",
                                  words);
    }
    if (r->n_layers > PEL_LAYERS || read_layers(r) == 0) {
        snprintf(words, sizeof words, "layers are %s", pel_layer_names);
        return pel_request_refuse(frames, fault, PEL_ERR_INVALID, "layers",
                                  words);
    }
    if (r->n_layers > 0 && !(format->uses & PEL_FORMAT_LAYERS)) {
        char linear[128];
        pel_format_names_of(PEL_FORMAT_LAYERS, linear, sizeof linear);
        snprintf(words, sizeof words,
                 "%s has no layers: set format to %s or leave them out",
                 format->name, linear);
        return pel_request_refuse(frames, fault, PEL_ERR_INVALID, "layers",
                                  words);
    }
    if (!view_exists(frames, r->view)) {
        pel_request_refuse(frames, fault, PEL_ERR_NOT_FOUND, "view",
                           "no such view");
        if (fault) {
            const char *view = r->view ? r->view : "";
            snprintf(fault->value, sizeof fault->value, "%s", view);
            snprintf(fault->message, sizeof fault->message,
                     "there is no view called \"%.64s\"", view);
        }
        return PEL_ERR_NOT_FOUND;
    }
    if (format->uses & (PEL_FORMAT_LAYERS | PEL_FORMAT_TRUTH) &&
        is_radar(frames, r->view)) {
        return pel_request_refuse(frames, fault, PEL_ERR_INVALID, "format",
                                  "a radar's picture has no layers: ask for "
                                  "JPEG or PNG");
    }
    return check_memory(frames, r, fault);
}

unsigned pel_request_layers(const Pelagos__FrameRequest *r)
{
    const struct pel_format *format = pel_format_of(format_of(r));
    unsigned uses = format ? format->uses : 0;
    return uses & PEL_FORMAT_LAYERS  ? read_layers(r)
           : uses & PEL_FORMAT_TRUTH ? PEL_LAYER_ID
                                     : PEL_LAYER_COLOR;
}

unsigned pel_requests_free(const struct pel_frames *frames)
{
    return PEL_MAX_REQUESTS - frames->stats.requests_waiting;
}

struct pel_frame_request *pel_request_take(struct pel_frames *frames,
                                           const Pelagos__FrameRequest *r,
                                           pel_frame_callback done, void *user)
{
    struct pel_frame_request *slot = NULL;
    for (int i = 0; i < PEL_MAX_REQUESTS && !slot; i++) {
        slot = frames->requests[i].used ? NULL : &frames->requests[i];
    }
    if (!slot) {
        return NULL;
    }
    *slot = (struct pel_frame_request){
        .used = true,
        .id = ++frames->last_id,
        .order = ++frames->last_order,
        .width = r->has_width ? r->width : 0,
        .height = r->has_height ? r->height : 0,
        .has_time = r->has_time,
        .time_s = r->time,
        .float_samples = r->has_float_samples && r->float_samples,
        .format = format_of(r),
        .quality = r->has_quality ? (int)r->quality : 90,
        .layers = pel_request_layers(r),
        .requested_ns = pel_now_ns(),
        .done = done,
        .user = user,
    };
    snprintf(slot->view, sizeof slot->view, "%s", r->view);
    frames->stats.requests_waiting++;
    pel_schedule_soon(frames);
    return slot;
}

enum pel_err pel_frames_check(struct pel_frames *frames,
                              const Pelagos__FrameRequest *request,
                              struct pel_fault *fault)
{
    return pel_request_check(frames, request, fault);
}

enum pel_err pel_frames_request(struct pel_frames *frames,
                                const Pelagos__FrameRequest *request,
                                pel_frame_callback done, void *user,
                                uint64_t *id, struct pel_fault *fault)
{
    enum pel_err err = pel_request_check(frames, request, fault);
    if (err != PEL_OK) {
        return err;
    }
    const struct pel_frame_request *slot =
        pel_request_take(frames, request, done, user);
    if (!slot) {
        return pel_request_refuse(frames, fault, PEL_ERR_BUSY, "",
                                  "too many pictures are waiting already");
    }
    if (id) {
        *id = slot->id;
    }
    return PEL_OK;
}

void pel_frames_rank(struct pel_frames *frames, uint64_t id, enum pel_rank rank)
{
    const struct pel_frame_request *first = NULL;
    for (int i = 0; i < PEL_MAX_REQUESTS && !first; i++) {
        const struct pel_frame_request *r = &frames->requests[i];
        first = r->used && r->id == id ? r : NULL;
    }
    for (int i = 0; first && i < PEL_MAX_REQUESTS; i++) {
        struct pel_frame_request *r = &frames->requests[i];
        if (r == first || (r->used && first->set && r->set == first->set)) {
            r->rank = rank;
        }
    }
}

/* Work for an output that nobody waits for any more is left. */
static void let_go(struct pel_frames *frames, struct pel_output *output)
{
    for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
        const struct pel_frame_request *r = &frames->requests[i];
        if (r->used && r->output == output) {
            return;
        }
    }
    if (output->stream == 0 && !output->done) {
        frames->stats.pictures_dropped++;
        atomic_store(&output->cancel, true);
    }
}

static void forget(struct pel_frames *frames, struct pel_frame_request *request)
{
    request->used = false;
    request->output = NULL;
    frames->stats.requests_waiting--;
}

void pel_request_forget(struct pel_frames *frames, uint64_t id)
{
    for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
        struct pel_output *output = frames->requests[i].output;
        if (frames->requests[i].used && frames->requests[i].id == id) {
            forget(frames, &frames->requests[i]);
            if (output) {
                let_go(frames, output);
            }
        }
    }
}

void pel_request_finish(struct pel_frames *frames,
                        struct pel_frame_request *request, enum pel_err err,
                        const struct pel_fault *fault, struct pel_frame *frame)
{
    /* The callback may request again and get this very slot. */
    pel_frame_callback done = request->done;
    void *user = request->user;
    forget(frames, request);
    done(user, err, fault, err == PEL_OK ? frame : NULL);
}

void pel_requests_finish_all(struct pel_frames *frames)
{
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_CONFLICT, "the daemon is stopping");
    for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
        if (frames->requests[i].used) {
            pel_request_finish(frames, &frames->requests[i], PEL_ERR_CONFLICT,
                               &fault, NULL);
        }
    }
}
