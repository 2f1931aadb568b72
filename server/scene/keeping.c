/* The state on the disk: what is read at the start, the journal of edits, and
 * the state file, written by a thread. */
#include <stdlib.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"
#include "scene/edit.h"
#include "scene/scene_parts.h"

#define SAVE_INTERVAL_NS 1000000000 /* from one write to the next */
#define SAVE_AGAIN_NS 5000000000    /* after one that failed */

/* What the journal has that the file has not. */
static enum pel_err take_journal(const char *path, Pelagos__State **state,
                                 struct pel_fault *fault)
{
    struct pel_fault why;
    unsigned edits;
    enum pel_err err = pel_journal_load(path, state, &edits, &why);
    if (err == PEL_ERR_CONFLICT) {
        return pel_fault_set(fault, PEL_ERR_IO,
                             "--state: %.80s.journal: %.120s; start that one, "
                             "or name another file",
                             path, why.message);
    }
    if (err) {
        pel_error("SCN-015", "%s.journal was used up to edit %u: %s", path,
                  edits, why.message);
    } else if (edits > 0) {
        pel_info("SCN-016",
                 "%u edits of %s.journal that the state file did not hold, to "
                 "revision %llu",
                 edits, path, (unsigned long long)(*state)->revision);
    }
    return PEL_OK;
}

enum pel_err pel_scene_load(struct pel_store *store,
                            const struct pel_scene_options *options,
                            Pelagos__State **out, struct pel_fault *fault)
{
    struct pel_fault why;
    g_autofree char *aside = NULL;
    *out = NULL;
    enum pel_err err =
        store ? pel_store_load(store, out, &aside, &why) : PEL_ERR_NOT_FOUND;
    if (err == PEL_ERR_IO) {
        return pel_fault_set(fault, err, "--state: %.240s", why.message);
    }
    if (err != PEL_ERR_NOT_FOUND &&
        take_journal(options->state_path, out, fault)) {
        if (*out) {
            pelagos__state__free_unpacked(*out, NULL);
        }
        return PEL_ERR_IO;
    }
    if (err == PEL_OK) {
        pel_info("SCN-001", "revision %llu of the scene loaded from %s",
                 (unsigned long long)(*out)->revision, options->state_path);
    } else if (err != PEL_ERR_NOT_FOUND) {
        pel_error("SCN-002",
                  "%s does not load: %s; it is kept as %s, and the scene "
                  "begins with %s",
                  options->state_path, why.message, aside,
                  *out ? "its journal" : "defaults");
    }
    if (!*out) {
        *out = pel_state_default();
    }
    return PEL_OK;
}

/* The state as the file is to keep it; *copy is to be freed, or NULL. */
static const Pelagos__State *kept_state(struct pel_scene *scene,
                                        Pelagos__State **copy)
{
    const Pelagos__State *state = pel_scene_state(scene);
    *copy = pel_missing_restored(&scene->missing, state);
    return *copy ? *copy : state;
}

/* A write of the state file, by a thread: a disk takes its time. */
struct save {
    struct pel_task task;
    struct pel_scene *scene;
    uint8_t *bytes; /* the state, packed */
    size_t size;
    enum pel_err err;
    struct pel_fault fault;
};

static void count_save(struct pel_scene *scene, enum pel_err err,
                       const struct pel_fault *fault)
{
    if (err && scene->failed_saves == scene->told_saves) {
        pel_error("SCN-003",
                  "the state was not saved, and will be tried again: %s",
                  fault->message);
    } else if (!err && scene->failed_saves > scene->told_saves) {
        pel_info("SCN-014", "the state is saved again");
    }
    scene->failed_saves += err != PEL_OK;
    scene->saves += !err;
    scene->told_saves = err ? scene->told_saves : scene->failed_saves;
    scene->save_from_ns =
        pel_now_ns() + (err ? SAVE_AGAIN_NS : SAVE_INTERVAL_NS);
}

static enum pel_err save_now(struct pel_scene *scene)
{
    struct pel_fault fault;
    Pelagos__State *copy;
    const Pelagos__State *state = kept_state(scene, &copy);
    enum pel_err err = pel_store_save(scene->store, state, &fault);
    if (copy) {
        pelagos__state__free_unpacked(copy, NULL);
    }
    count_save(scene, err, &fault);
    return err;
}

static void do_save(struct pel_task *task)
{
    struct save *save = (struct save *)task;
    Pelagos__State *state =
        pelagos__state__unpack(NULL, save->size, save->bytes);
    save->err = pel_store_save(save->scene->store, state, &save->fault);
    pelagos__state__free_unpacked(state, NULL);
}

static void saved(struct pel_task *task, bool dropped)
{
    struct save *save = (struct save *)task;
    struct pel_scene *scene = save->scene;
    scene->saving = false;
    if (!dropped) {
        count_save(scene, save->err, &save->fault);
        if (save->err || scene->save_again) {
            pel_scene_save_soon(scene);
        }
    }
    g_free(save->bytes);
    g_free(save);
}

static void begin_save(struct pel_scene *scene)
{
    struct save *save = g_new0(struct save, 1);
    Pelagos__State *copy;
    const Pelagos__State *state = kept_state(scene, &copy);
    save->task.work = do_save;
    save->task.done = saved;
    save->scene = scene;
    save->size = pelagos__state__get_packed_size(state);
    save->bytes = g_malloc(save->size + 1);
    pelagos__state__pack(state, save->bytes);
    if (copy) {
        pelagos__state__free_unpacked(copy, NULL);
    }
    scene->saving = true;
    scene->save_again = false;
    pel_worker_push(scene->saver, &save->task);
}

static gboolean on_save_timer(gpointer user)
{
    struct pel_scene *scene = user;
    PEL_WATCH("state file");
    scene->save_timer = 0;
    begin_save(scene);
    return G_SOURCE_REMOVE;
}

void pel_scene_save_soon(struct pel_scene *scene)
{
    scene->save_again = true;
    if (scene->store && scene->save_timer == 0 && !scene->saving) {
        int64_t wait_ns = scene->save_from_ns - pel_now_ns();
        scene->save_timer =
            g_timeout_add(wait_ns > 0 ? (guint)(wait_ns / 1000000) + 1 : 0,
                          on_save_timer, scene);
    }
}

void pel_scene_keep(struct pel_scene *scene, double time_s,
                    const Pelagos__Patch *patch)
{
    if (!scene->journal) {
        return;
    }
    pel_journal_add(scene->journal, time_s, patch, scene->state);
    if (pel_journal_is_full(scene->journal)) {
        Pelagos__State *copy;
        pel_journal_turn(scene->journal, kept_state(scene, &copy));
        if (copy) {
            pelagos__state__free_unpacked(copy, NULL);
        }
    }
}

void pel_scene_begin_keeping(struct pel_scene *scene, const char *path)
{
    Pelagos__State *copy;
    scene->saver = pel_worker_create("state file");
    if (save_now(scene)) {
        pel_scene_save_soon(scene);
    }
    scene->journal =
        pel_journal_create(path, kept_state(scene, &copy), scene->saver);
    if (copy) {
        pelagos__state__free_unpacked(copy, NULL);
    }
}

bool pel_scene_end_keeping(struct pel_scene *scene)
{
    if (!scene->store) {
        return true;
    }
    pel_worker_destroy(scene->saver);
    if (scene->save_timer != 0) {
        g_source_remove(scene->save_timer);
    }
    bool whole = save_now(scene) == PEL_OK;
    bool kept = pel_journal_close(scene->journal, whole);
    if (!whole) {
        pel_error("SCN-017", "the state file lacks the last edits%s",
                  kept ? "; its journal has them, for the next start"
                       : ", and so does its journal: they are lost");
    }
    return kept;
}
