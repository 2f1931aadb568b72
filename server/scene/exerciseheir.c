/* Several daemons with one exercise: what happened in it is in the state, and
 * so in the log that leads all of them; its events are carried out by the one
 * that takes the edits. The others have a copy of the same file, by the digest
 * that the state names, and go on with it when they take over. */
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "scene/exerciserun.h"
#include "scene/scene_parts.h"

/* How often a file that is lacking is looked for: a disk may take its time. */
#define LOOK_NS (2 * INT64_C(1000000000))

bool pel_exercise_run_named(const struct pel_exercise_run *run)
{
    const Pelagos__ExerciseRun *now = pel_exercise_run_state(run);
    return now->name && now->digest &&
           now->phase != PELAGOS__EXERCISE_PHASE__IDLE &&
           now->phase != PELAGOS__EXERCISE_PHASE__ENDED;
}

void pel_exercise_heir_free(struct pel_exercise_run *run)
{
    if (run->heir) {
        pelagos__exercise__free_unpacked(run->heir, NULL);
        run->heir = NULL;
    }
    g_clear_pointer(&run->heir_digest, g_free);
    g_clear_pointer(&run->lacks, g_free);
}

/* Takes the copy from the directory, or says why there is none. */
static char *take_copy(struct pel_exercise_run *run)
{
    const Pelagos__ExerciseRun *now = pel_exercise_run_state(run);
    struct pel_fault fault;
    const char *digest =
        pel_exercise_files_digest(run->files, now->name, &fault);
    Pelagos__Exercise *copy = NULL;
    if (digest && strcmp(digest, now->digest) != 0) {
        return g_strdup_printf("exercise %s: the file here is another one than "
                               "the master has loaded; copy it to this node",
                               now->name);
    }
    if (!digest ||
        pel_exercise_files_read(run->files, now->name, &copy, &fault)) {
        return g_strdup_printf("exercise %s: %s; copy its file to this node",
                               now->name, fault.message);
    }
    run->heir = copy;
    run->heir_digest = g_strdup(now->digest);
    return NULL;
}

static bool has_heir(const struct pel_exercise_run *run)
{
    return run->heir &&
           strcmp(run->heir_digest, pel_exercise_run_state(run)->digest) == 0;
}

const char *pel_exercises_stand_by(struct pel_exercises *all)
{
    struct pel_exercise_run *run = &all->run;
    if (run->leads || run->loading || !pel_exercise_run_named(run)) {
        pel_exercise_heir_free(run);
        return NULL;
    }
    if (!run->scene->led.on) {
        return run->lacks; /* since it took over */
    }
    int64_t now_ns = pel_now_ns();
    if (!has_heir(run) && (!run->lacks || now_ns >= run->look_ns)) {
        run->look_ns = now_ns + LOOK_NS;
        g_autofree char *before = g_steal_pointer(&run->lacks);
        pel_exercise_heir_free(run);
        run->lacks = take_copy(run);
        if (run->lacks && g_strcmp0(before, run->lacks) != 0) {
            pel_warn("EXR-012",
                     "this node would not go on with the exercise if it took "
                     "over: %s",
                     run->lacks);
        }
    }
    return run->lacks;
}

static void go_on(struct pel_exercise_run *run)
{
    if (!has_heir(run)) {
        pel_exercise_heir_free(run);
        run->lacks = take_copy(run);
    }
    Pelagos__Exercise *copy = g_steal_pointer(&run->heir);
    if (!copy) {
        pel_error("EXR-013",
                  "no event happens any more, from this node's taking over on: "
                  "%s, and load it again",
                  run->lacks);
        return;
    }
    pel_exercise_heir_free(run);
    if (!pel_exercise_run_resume(run, copy, run->scene->clock.base_s)) {
        pelagos__exercise__free_unpacked(copy, NULL); /* changed meanwhile */
    }
}

void pel_exercise_run_led(void *user, bool on)
{
    struct pel_exercise_run *run = user;
    if (on) {
        pel_exercise_run_forget(run);
    } else if (pel_exercise_run_named(run)) {
        go_on(run);
    }
}
