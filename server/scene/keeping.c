/* The state on the disk: what is read at the start, the journal of edits, and
 * the state file, written by a thread. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/trial.h"
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
                            Pelagos__State **out, bool *loaded,
                            struct pel_fault *fault)
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
    } else if (err != PEL_ERR_NOT_FOUND && pel_trial()) {
        pel_trial_note("--state: %s does not load: %s; a start keeps it as %s, "
                       "and begins with %s",
                       options->state_path, why.message, aside,
                       *out ? "its journal" : "defaults");
    } else if (err != PEL_ERR_NOT_FOUND) {
        pel_error("SCN-002",
                  "%s does not load: %s; it is kept as %s, and the scene "
                  "begins with %s",
                  options->state_path, why.message, aside,
                  *out ? "its journal" : "defaults");
    }
    *loaded = *out != NULL;
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

static Pelagos__State *sealed_state(const struct pel_scene *scene)
{
    return pelagos__state__unpack(NULL, scene->sealed.size,
                                  scene->sealed.bytes);
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
    scene->sealed.time_from_ns =
        pel_now_ns() + (int64_t)(PEL_SEALED_TIME_S * 1e9);
}

static enum pel_err save_now(struct pel_scene *scene)
{
    struct pel_fault fault;
    Pelagos__State *copy = scene->sealed.bytes ? sealed_state(scene) : NULL;
    const Pelagos__State *state = copy ? copy : kept_state(scene, &copy);
    enum pel_err err = pel_store_save(scene->store, state, &fault);
    scene->sealed.unsaved = scene->sealed.unsaved && err;
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

static void save_soon(struct pel_scene *scene);

static void saved(struct pel_task *task, bool dropped)
{
    struct save *save = (struct save *)task;
    struct pel_scene *scene = save->scene;
    scene->saving = false;
    scene->sealed.unsaved = scene->sealed.unsaved || dropped || save->err;
    if (!dropped) {
        count_save(scene, save->err, &save->fault);
        if (save->err || scene->save_again) {
            save_soon(scene);
        }
    }
    g_free(save->bytes);
    g_free(save);
}

static void pack_state(struct pel_scene *scene, struct save *save)
{
    Pelagos__State *copy;
    const Pelagos__State *state = kept_state(scene, &copy);
    save->size = pelagos__state__get_packed_size(state);
    save->bytes = g_malloc(save->size + 1);
    pelagos__state__pack(state, save->bytes);
    if (copy) {
        pelagos__state__free_unpacked(copy, NULL);
    }
}

static void begin_save(struct pel_scene *scene)
{
    struct save *save = g_new0(struct save, 1);
    save->task.work = do_save;
    save->task.done = saved;
    save->scene = scene;
    if (scene->sealed.bytes) {
        save->size = scene->sealed.size;
        save->bytes = g_memdup2(scene->sealed.bytes, save->size);
        scene->sealed.unsaved = false;
    } else {
        pack_state(scene, save);
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

static void save_soon(struct pel_scene *scene)
{
    scene->save_again = true;
    if (scene->store && scene->save_timer == 0 && !scene->saving) {
        int64_t wait_ns = scene->save_from_ns - pel_now_ns();
        scene->save_timer =
            g_timeout_add(wait_ns > 0 ? (guint)(wait_ns / 1000000) + 1 : 0,
                          on_save_timer, scene);
    }
}

void pel_scene_save_soon(struct pel_scene *scene)
{
    if (!scene->sealed.on) {
        save_soon(scene);
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

void pel_scene_begin_keeping(struct pel_scene *scene, const char *path,
                             bool sealed, bool loaded)
{
    Pelagos__State *copy;
    scene->saver = pel_worker_create("state file");
    bool saved_now = save_now(scene) == PEL_OK;
    if (sealed) {
        scene->sealed.on = true;
        scene->sealed.loaded = loaded ? g_strdup(path) : NULL;
        if (saved_now) {
            pel_journal_remove(path); /* the file has it now */
        }
        return;
    }
    if (!saved_now) {
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
    if (scene->sealed.on) {
        bool whole = !scene->sealed.unsaved || save_now(scene) == PEL_OK;
        g_free(scene->sealed.loaded);
        g_free(scene->sealed.bytes);
        return whole;
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

/* --- of a node of an exercise --------------------------------------------- */

bool pel_scene_keeps_sealed(const struct pel_scene *scene)
{
    return scene->sealed.on;
}

void pel_scene_keep_sealed(struct pel_scene *scene, const uint8_t *bytes,
                           size_t size, uint64_t revision)
{
    if (!scene->sealed.on) {
        return;
    }
    bool first = !scene->sealed.bytes;
    bool edited = first || scene->sealed.revision != revision;
    if (!edited && scene->sealed.size == size &&
        memcmp(scene->sealed.bytes, bytes, size) == 0) {
        return;
    }
    g_free(scene->sealed.bytes);
    scene->sealed.bytes = g_memdup2(bytes, size);
    scene->sealed.size = size;
    scene->sealed.revision = revision;
    scene->sealed.unsaved = true;
    g_clear_pointer(&scene->sealed.loaded, g_free);
    if (edited || pel_now_ns() >= scene->sealed.time_from_ns) {
        save_soon(scene);
    }
}

void pel_scene_set_aside(struct pel_scene *scene)
{
    if (!scene->sealed.loaded) {
        return;
    }
    g_autofree char *aside = pel_store_set_aside(scene->store);
    pel_warn("SCN-020",
             "the state of %s gives way to the exercise's, of which the file "
             "becomes a copy; what it held %s%s",
             scene->sealed.loaded, aside ? "is kept as " : "could not be kept",
             aside ? aside : "");
    g_clear_pointer(&scene->sealed.loaded, g_free);
}
