/* The past of an exercise: marks, and the edits between them. Where they grow
 * too large every second mark goes, and the edits after it belong to the one
 * before; so a rewind goes as far as ever, and takes longer. */
#include <math.h>
#include <stdlib.h>

#include "scene/exercise_parts.h"
#include "scene/ship.h"

#define MOST_BYTES (64u << 20)

struct edit {
    double clock_s, time_s;
    GBytes *patch;
};

struct mark {
    double time_s;
    GBytes *state;
    GArray *edits; /* of struct edit: after it */
};

struct pel_exercise_past {
    GPtrArray *marks; /* oldest first */
    size_t bytes;
};

static void edit_clear(gpointer data)
{
    g_bytes_unref(((struct edit *)data)->patch);
}

static void mark_free(gpointer data)
{
    struct mark *mark = data;
    g_bytes_unref(mark->state);
    g_array_free(mark->edits, TRUE);
    g_free(mark);
}

static GBytes *pack(const ProtobufCMessage *message)
{
    size_t size = protobuf_c_message_get_packed_size(message);
    uint8_t *data = g_malloc(size + 1);
    protobuf_c_message_pack(message, data);
    return g_bytes_new_take(data, size);
}

static struct mark *mark_at(const struct pel_exercise_past *past, guint i)
{
    return g_ptr_array_index(past->marks, i);
}

struct pel_exercise_past *pel_exercise_past_create(void)
{
    struct pel_exercise_past *past = g_new0(struct pel_exercise_past, 1);
    past->marks = g_ptr_array_new_with_free_func(mark_free);
    return past;
}

void pel_exercise_past_destroy(struct pel_exercise_past *past)
{
    if (past) {
        g_ptr_array_free(past->marks, TRUE);
        g_free(past);
    }
}

static void forget(struct pel_exercise_past *past, struct mark *mark,
                   guint from)
{
    for (guint k = from; k < mark->edits->len; k++) {
        past->bytes -=
            g_bytes_get_size(g_array_index(mark->edits, struct edit, k).patch);
    }
    g_array_set_size(mark->edits, from);
}

/* Every second mark goes, but the last. */
static void thin(struct pel_exercise_past *past)
{
    for (guint i = 1; i + 1 < past->marks->len; i++) {
        struct mark *before = mark_at(past, i - 1), *mark = mark_at(past, i);
        for (guint k = 0; k < mark->edits->len; k++) {
            struct edit edit = g_array_index(mark->edits, struct edit, k);
            g_bytes_ref(edit.patch);
            g_array_append_val(before->edits, edit);
        }
        past->bytes -= g_bytes_get_size(mark->state);
        g_ptr_array_remove_index(past->marks, i);
    }
}

/* Edits alone may be too many: then the oldest are out of reach. */
static void bound(struct pel_exercise_past *past)
{
    while (past->bytes > MOST_BYTES && past->marks->len > 2) {
        size_t before = past->bytes;
        thin(past);
        if (past->bytes > before / 4 * 3) {
            struct mark *oldest = mark_at(past, 0);
            forget(past, oldest, 0);
            past->bytes -= g_bytes_get_size(oldest->state);
            g_ptr_array_remove_index(past->marks, 0);
        }
    }
}

void pel_exercise_past_mark(struct pel_exercise_past *past, double time_s,
                            const Pelagos__State *state)
{
    struct mark *mark = g_new(struct mark, 1);
    mark->time_s = time_s;
    mark->state = pack(&state->base);
    mark->edits = g_array_new(FALSE, FALSE, sizeof(struct edit));
    g_array_set_clear_func(mark->edits, edit_clear);
    past->bytes += g_bytes_get_size(mark->state);
    g_ptr_array_add(past->marks, mark);
    bound(past);
}

void pel_exercise_past_add(struct pel_exercise_past *past, double clock_s,
                           double time_s, const Pelagos__Patch *patch)
{
    if (past->marks->len == 0) {
        return;
    }
    struct edit edit = { clock_s, time_s, pack(&patch->base) };
    past->bytes += g_bytes_get_size(edit.patch);
    g_array_append_val(mark_at(past, past->marks->len - 1)->edits, edit);
}

double pel_exercise_past_earliest(const struct pel_exercise_past *past)
{
    return past->marks->len > 0 ? mark_at(past, 0)->time_s : INFINITY;
}

size_t pel_exercise_past_bytes(const struct pel_exercise_past *past)
{
    return past->bytes;
}

/* --- back ----------------------------------------------------------------- */

static enum pel_err hold(struct pel_scene *scene, struct pel_fault *fault)
{
    Pelagos__Clock clock = PELAGOS__CLOCK__INIT;
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    if (pel_scene_state(scene)->clock->mode == PELAGOS__CLOCK_MODE__STEPPED) {
        return PEL_OK;
    }
    clock.has_mode = true;
    clock.mode = PELAGOS__CLOCK_MODE__STEPPED;
    state.clock = &clock;
    patch.state = &state;
    return pel_scene_patch(scene, &patch, fault);
}

static enum pel_err step_to(struct pel_scene *scene, double clock_s,
                            struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    double now_s;
    while (!err && (now_s = pel_scene_time(scene)) < clock_s) {
        err = pel_scene_step_to(scene, fmin(now_s + PEL_SHIP_AHEAD_S, clock_s),
                                fault);
    }
    return err;
}

static enum pel_err to_mark(const struct mark *mark, struct pel_scene *scene,
                            struct pel_fault *fault)
{
    gsize size;
    const void *data = g_bytes_get_data(mark->state, &size);
    Pelagos__State *to = pelagos__state__unpack(NULL, size, data);
    struct pel_exercise_beginning back;
    enum pel_err err = hold(scene, fault);
    if (!err) {
        pel_exercise_back(to, pel_scene_state(scene), &back);
        err = pel_scene_patch(scene, &back.patch, fault);
        pel_exercise_beginning_finish(&back);
    }
    pelagos__state__free_unpacked(to, NULL);
    return err;
}

/* As the edit was; an edit of the clock leaves it held. */
static enum pel_err again(const struct edit *edit, struct pel_scene *scene,
                          struct pel_fault *fault)
{
    gsize size;
    const void *data = g_bytes_get_data(edit->patch, &size);
    enum pel_err err = step_to(scene, edit->clock_s, fault);
    if (err) {
        return err;
    }
    Pelagos__Patch *patch = pelagos__patch__unpack(NULL, size, data);
    if (patch->state && patch->state->clock) {
        patch->state->clock->has_mode = false;
    }
    err = pel_scene_patch(scene, patch, fault);
    pelagos__patch__free_unpacked(patch, NULL);
    return err ? err : hold(scene, fault);
}

/* The last mark that is not after time_s; those after it go. */
static struct mark *last_mark(struct pel_exercise_past *past, double time_s)
{
    struct mark *last = mark_at(past, past->marks->len - 1);
    while (past->marks->len > 1 && last->time_s > time_s) {
        forget(past, last, 0);
        past->bytes -= g_bytes_get_size(last->state);
        g_ptr_array_remove_index(past->marks, past->marks->len - 1);
        last = mark_at(past, past->marks->len - 1);
    }
    return last;
}

enum pel_err pel_exercise_past_return(struct pel_exercise_past *past,
                                      struct pel_scene *scene, double time_s,
                                      struct pel_fault *fault)
{
    struct mark *mark = last_mark(past, time_s);
    enum pel_err err = to_mark(mark, scene, fault);
    guint k = 0;
    for (; !err && k < mark->edits->len; k++) {
        const struct edit *edit = &g_array_index(mark->edits, struct edit, k);
        if (edit->time_s > time_s) {
            break;
        }
        err = again(edit, scene, fault);
    }
    if (err) {
        return err;
    }
    forget(past, mark, k);
    const Pelagos__ExerciseRun *run = pel_scene_state(scene)->exercise;
    return run->phase == PELAGOS__EXERCISE_PHASE__RUNNING
               ? step_to(scene, run->offset + time_s, fault)
               : PEL_OK;
}
