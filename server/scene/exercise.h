/* Exercises for a ship's bridge: what an instructor prepares, runs, stops and
 * rewinds (docs/exercises.md). Files NAME.json by the schema; events that edit
 * the scene, looked at every tenth of a simulated second; facts, logged every
 * second.
 *
 * What has happened is in the state (`exercise`), and each event is a patch as
 * any other: a log of commands has it, and a replay needs nothing of this. The
 * exercise that runs is kept beside the state file (STATE.exercise), its facts
 * too (STATE.exercise.csv), so that a restart goes on with it. Control
 * thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "base/metrics.h"
#include "pelagos.pb-c.h"
#include "scene/scene.h"

struct pel_exercises;

struct pel_exercises_options {
    const char *directory;  /* of the files; NULL: there are none */
    const char *state_path; /* of the scene; NULL: nothing is kept */
};

/* Goes on with the exercise that the scene's state names, where it was kept.
 * NOT_FOUND: there is no such directory. */
PEL_CHECK enum pel_err
pel_exercises_create(const struct pel_exercises_options *options,
                     struct pel_scene *scene, struct pel_exercises **out,
                     struct pel_fault *fault);

/* Before the scene; NULL allowed. */
void pel_exercises_destroy(struct pel_exercises *all);

/* Does what a client asks for; pelagos__exercise_status__free_unpacked(*out).
 * NOT_FOUND, INVALID, OUT_OF_RANGE: the exercise, or the time, is none; *fault
 * names the field as the file has it (`events.fog.when.0.at`). CONFLICT: it
 * contradicts the phase. IO: the file. A LOAD whose sea is built first has the
 * phase READY a little later; a START that comes before waits for it. */
PEL_CHECK enum pel_err
pel_exercises_command(struct pel_exercises *all,
                      const Pelagos__ExerciseCommand *command,
                      Pelagos__ExerciseStatus **out, struct pel_fault *fault);

/* The same, files being read, tested and written by a thread: 200 of 700 KiB
 * take seconds. `done` is called once, here or later, with the status, which is
 * its own, or a fault; edited: the command changed the scene. Commands are done
 * in the order in which they come. */
typedef void (*pel_exercises_done)(void *user, enum pel_err err,
                                   const struct pel_fault *fault,
                                   Pelagos__ExerciseStatus *status,
                                   bool edited);
void pel_exercises_ask(struct pel_exercises *all,
                       const Pelagos__ExerciseCommand *command,
                       pel_exercises_done done, void *user);

/* What a console shows of it. */
struct pel_exercise_glance {
    Pelagos__ExercisePhase phase;
    double time_s;
    uint32_t events, fired; /* those there are; how often they took effect */
    uint32_t facts;         /* lines, of `ownShip` */
    uint32_t groundings, collisions;
};
void pel_exercises_glance(struct pel_exercises *all,
                          struct pel_exercise_glance *out);

/* For interfaces that know numbers alone: an exercise's number is its place in
 * the list by name, from 0. */
size_t pel_exercises_count(struct pel_exercises *all);
/* NULL: none has it. g_free. */
char *pel_exercises_name(struct pel_exercises *all, size_t number);
/* -1: it is none of them; NULL: of the one that is loaded. */
int pel_exercises_number(struct pel_exercises *all, const char *name);

/* Exercise time now [s]. */
double pel_exercises_time(struct pel_exercises *all);

/* Of several daemons with one exercise (server/cluster): why this one does not
 * lead the exercise that the state names, or would not when it took over; NULL:
 * it does or would, or none is loaded. Looks into the directory where that is
 * not known; from then on it has a copy. Until the next call. */
const char *pel_exercises_stand_by(struct pel_exercises *all);

void pel_exercises_collect(void *user, struct pel_metrics_page *page);

/* Reads and tests an exercise; pelagos__exercise__free_unpacked(*out). Faults
 * as above. Any thread. */
PEL_CHECK enum pel_err pel_exercise_read(const char *text, size_t size,
                                         Pelagos__Exercise **out,
                                         struct pel_fault *fault);
/* Tests one that was read. Any thread. */
PEL_CHECK enum pel_err pel_exercise_check(const Pelagos__Exercise *exercise,
                                          struct pel_fault *fault);
