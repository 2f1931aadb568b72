/* The state on the disk: what is read at the start, the journal of edits, and
 * the state file, written by a thread. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/trial.h"
#include "base/watch.h"
#include "scene/edit.h"
#include "scene/scene_parts.h"

#define SAVE_INTERVAL_NS 1000000000 /* from one write to the next */
#define SAVE_AGAIN_NS 5000000000    /* after one that failed */

/* What the journal has that the file has not. */
static enum pel_err take_journal(const char *path, const char *lineage,
                                 Pelagos__State **state,
                                 struct pel_journal_found *found,
                                 struct pel_fault *fault)
{
    struct pel_fault why;
    enum pel_err err = pel_journal_load(path, lineage, state, found, &why);
    if (err == PEL_ERR_CONFLICT) {
        return pel_fault_set(fault, PEL_ERR_IO,
                             "--state: %.80s.journal: %.120s; start that one, "
                             "or name another file",
                             path, why.message);
    }
    if (err) {
        return pel_fault_set(fault, PEL_ERR_IO,
                             "--state: %.160s; move it away, or make it one "
                             "that can be read",
                             why.message);
    }
    if (found->damaged && pel_trial()) {
        pel_trial_note("--state: %s.journal is damaged: %s; a start keeps it "
                       "as %s",
                       path, found->words, found->kept);
    } else if (found->damaged) {
        pel_error("SCN-015", "%s.journal is damaged: %s; it is %s%s", path,
                  found->words, found->kept ? "kept as " : "not kept",
                  found->kept ? found->kept : "");
    }
    if (found->edits > 0) {
        pel_info("SCN-016",
                 "%u edits of %s.journal that the state file did not hold, to "
                 "revision %llu",
                 found->edits, path, (unsigned long long)(*state)->revision);
    }
    return PEL_OK;
}

static void note_loss(struct pel_loaded *loaded, const char *what, char *kept,
                      const char *words)
{
    struct pel_loss *loss = &loaded->losses[loaded->loss_count++];
    loss->what = what;
    loss->kept = kept;
    g_strlcpy(loss->words, words, sizeof loss->words);
}

/* A state file that does not load. */
struct bad {
    char *aside; /* g_free */
    struct pel_fault why;
    uint64_t before; /* revision of the generation before it, where that... */
    bool has_before; /* ...is used */
    double older_s;
    char why_not[160]; /* it does not load either; "": there is none */
};

/* The generation before it, where that loads. */
static void go_back(struct pel_store *store, Pelagos__State **out,
                    struct bad *bad)
{
    struct pel_fault why;
    enum pel_err err = pel_store_load_before(store, out, &bad->older_s, &why);
    bad->has_before = err == PEL_OK;
    if (bad->has_before) {
        bad->before = (*out)->revision;
    } else if (err != PEL_ERR_NOT_FOUND) {
        g_snprintf(bad->why_not, sizeof bad->why_not,
                   "; the generation before it does not load either: %.100s",
                   why.message);
    }
}

/* What the scene begins with instead; g_free. */
static char *instead_of(const struct bad *bad, const Pelagos__State *state,
                        const char *path)
{
    if (!state) {
        return g_strdup_printf("defaults%s", bad->why_not);
    }
    return bad->has_before && state->revision == bad->before
               ? g_strdup_printf("%s" PEL_STATE_BEFORE
                                 ", written %.1f s before it, revision %llu",
                                 path, bad->older_s,
                                 (unsigned long long)bad->before)
               : g_strdup_printf("its journal, to revision %llu",
                                 (unsigned long long)state->revision);
}

/* Takes bad->aside. */
static void say_bad(struct pel_loaded *loaded, struct bad *bad,
                    const Pelagos__State *state, const char *path)
{
    g_autofree char *instead = instead_of(bad, state, path);
    if (pel_trial()) {
        pel_trial_note("--state: %s does not load: %s; a start keeps it as %s, "
                       "and begins with %s",
                       path, bad->why.message, bad->aside, instead);
        g_free(bad->aside);
        return;
    }
    pel_error("SCN-002",
              "%s does not load: %s; it is kept as %s, and the scene begins "
              "with %s",
              path, bad->why.message, bad->aside, instead);
    g_autofree char *words = g_strdup_printf("%s; the scene began with %s",
                                             bad->why.message, instead);
    note_loss(loaded, "state", bad->aside, words);
}

enum pel_err pel_scene_load(struct pel_store *store,
                            const struct pel_scene_options *options,
                            Pelagos__State **out, struct pel_loaded *loaded,
                            struct pel_fault *fault)
{
    struct bad bad = { 0 };
    *out = NULL;
    *loaded = (struct pel_loaded){ 0 };
    enum pel_err err = store ? pel_store_load(store, out, &bad.aside, &bad.why)
                             : PEL_ERR_NOT_FOUND;
    if (err == PEL_ERR_IO) {
        return pel_fault_set(fault, err, "--state: %.240s", bad.why.message);
    }
    if (err && err != PEL_ERR_NOT_FOUND) {
        go_back(store, out, &bad);
    }
    if (err != PEL_ERR_NOT_FOUND &&
        take_journal(options->state_path, pel_store_loaded_lineage(store), out,
                     &loaded->journal, fault)) {
        if (*out) {
            pelagos__state__free_unpacked(*out, NULL);
        }
        g_free(bad.aside);
        return PEL_ERR_IO;
    }
    if (err == PEL_OK) {
        pel_info("SCN-001", "revision %llu of the scene loaded from %s",
                 (unsigned long long)(*out)->revision, options->state_path);
    } else if (err != PEL_ERR_NOT_FOUND) {
        say_bad(loaded, &bad, *out, options->state_path);
    }
    if (loaded->journal.damaged) {
        note_loss(loaded, "journal", loaded->journal.kept,
                  loaded->journal.words);
    }
    loaded->any = *out != NULL;
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
        g_strlcpy(scene->save_why, fault->message, sizeof scene->save_why);
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

/* last: of this daemon; the generation before it holds the same then, so that
 * a disk that damages either loses nothing. */
static enum pel_err save_now(struct pel_scene *scene, bool last)
{
    struct pel_fault fault, unused;
    Pelagos__State *copy = scene->sealed.bytes ? sealed_state(scene) : NULL;
    const Pelagos__State *state = copy ? copy : kept_state(scene, &copy);
    enum pel_err err = pel_store_save(scene->store, state, &fault);
    scene->sealed.unsaved = scene->sealed.unsaved && err;
    if (!err && last) {
        (void)!pel_store_save(scene->store, state, &unused);
    }
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

/* Restarts a journal that is full: from the present state, which has every edit
 * that was answered. */
static void turn_journal(void *user)
{
    struct pel_scene *scene = user;
    if (scene->journal && pel_journal_is_full(scene->journal)) {
        Pelagos__State *copy;
        pel_journal_turn(scene->journal, kept_state(scene, &copy));
        if (copy) {
            pelagos__state__free_unpacked(copy, NULL);
        }
    }
}

/* Silent inputs are found again after a start. */
static bool says_sources_only(const Pelagos__Patch *patch)
{
    return patch && patch->n_remove == 0 && patch->state &&
           patch->state->sources &&
           protobuf_c_message_get_packed_size(&patch->state->base) ==
               2 + protobuf_c_message_get_packed_size(
                       &patch->state->sources->base);
}

static enum pel_err full(const struct pel_scene *scene, struct pel_fault *fault)
{
    char why[400];
    return pel_fault_set(fault, PEL_ERR_FULL, "the edit cannot be kept: %.200s",
                         pel_journal_trouble(scene->journal, why, sizeof why)
                             ? why
                             : "the disk is full");
}

enum pel_err pel_scene_keep(struct pel_scene *scene, double time_s,
                            const Pelagos__Patch *patch,
                            const Pelagos__State *state,
                            struct pel_fault *fault)
{
    if (!scene->journal ||
        pel_journal_add(scene->journal, time_s, patch, state)) {
        return PEL_OK;
    }
    if (scene->journal_goes_on || says_sources_only(patch)) {
        return PEL_OK;
    }
    turn_journal(scene);
    return full(scene, fault);
}

enum pel_err pel_scene_keeps(const struct pel_scene *scene,
                             struct pel_fault *fault)
{
    return pel_journal_refuses(scene->journal) ? full(scene, fault) : PEL_OK;
}

void pel_scene_kept(struct pel_scene *scene)
{
    turn_journal(scene);
}

void pel_scene_begin_keeping(struct pel_scene *scene,
                             const struct pel_scene_options *options,
                             const struct pel_loaded *loaded)
{
    const char *path = options->state_path;
    Pelagos__State *copy;
    scene->saver = pel_worker_create("state file");
    scene->journal_goes_on = options->journal_goes_on;
    bool saved_now = save_now(scene, false) == PEL_OK;
    if (options->sealed) {
        scene->sealed.on = true;
        scene->sealed.loaded = loaded->any ? g_strdup(path) : NULL;
        if (saved_now) {
            pel_journal_remove(path); /* the file has it now */
        }
        return;
    }
    if (!saved_now) {
        pel_scene_save_soon(scene);
    }
    const struct pel_journal_cares cares = { options->journal_goes_on,
                                             turn_journal, scene };
    scene->journal = pel_journal_create(path, pel_store_lineage(scene->store),
                                        kept_state(scene, &copy),
                                        &loaded->journal, &cares, scene->saver);
    if (copy) {
        pelagos__state__free_unpacked(copy, NULL);
    }
}

bool pel_scene_volatile(const struct pel_scene *scene)
{
    return pel_journal_lacks(scene->journal);
}

/* --- what is wrong -------------------------------------------------------- */

static void add(struct pel_troubles *out, const char *what, const char *format,
                ...) G_GNUC_PRINTF(3, 4);

static void add(struct pel_troubles *out, const char *what, const char *format,
                ...)
{
    struct pel_trouble *one = &out->items[out->count++];
    va_list args;
    va_start(args, format);
    one->what = what;
    g_vsnprintf(one->words, sizeof one->words, format, args);
    va_end(args);
}

void pel_scene_troubles(const struct pel_scene *scene, struct pel_troubles *out)
{
    char why[400];
    out->count = 0;
    if (pel_journal_trouble(scene->journal, why, sizeof why)) {
        add(out, "journal", "%s", why);
    }
    if (scene->failed_saves > scene->told_saves) {
        add(out, "state", "the state file cannot be written: %s",
            scene->save_why);
    }
    for (size_t i = 0; i < scene->loss_count; i++) {
        const struct pel_loss *loss = &scene->losses[i];
        /* The file stays until somebody has looked at it and moves it away. */
        if (!loss->kept) {
            add(out, loss->what, "the %s was damaged at the start: %s",
                loss->what, loss->words);
        } else if (access(loss->kept, F_OK) == 0) {
            add(out, loss->what,
                "the %s was damaged at the start: %s; it is kept as %s, until "
                "you move that away",
                loss->what, loss->words, loss->kept);
        }
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
        bool whole = !scene->sealed.unsaved || save_now(scene, true) == PEL_OK;
        g_free(scene->sealed.loaded);
        g_free(scene->sealed.bytes);
        return whole;
    }
    bool whole = save_now(scene, true) == PEL_OK;
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
