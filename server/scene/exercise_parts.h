/* Inside of the exercises: what their sources have in common. Control thread,
 * where nothing else is said. */
#pragma once

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

#include "bounds.h"
#include "scene/exercise.h"
#include "scene/exercisewhen.h"

#define PEL_EXERCISE_TICK_S 0.1
#define PEL_EXERCISE_LIMITS 16
#define PEL_EXERCISE_TARGETS 64 /* other entities in the facts */
#define PEL_EXERCISE_SHIPS 8    /* own ships */

/* --- exercisecheck.c: any thread ------------------------------------------ */

bool pel_exercise_good_name(const char *name);

/* --- exercisefile.c ------------------------------------------------------- */

struct pel_exercise_files;

/* Any thread, where nothing else is said. */
struct pel_exercise_files *pel_exercise_files_create(const char *directory);
void pel_exercise_files_destroy(struct pel_exercise_files *files);
/* As the directory has them now, sorted; until the next call. Control thread.
 */
const GPtrArray *pel_exercise_files_names(struct pel_exercise_files *files);
/* By name; what is wrong with one is in its `error`. */
void pel_exercise_files_list(struct pel_exercise_files *files,
                             Pelagos__ExerciseStatus *out);
PEL_CHECK enum pel_err pel_exercise_files_read(struct pel_exercise_files *files,
                                               const char *name,
                                               Pelagos__Exercise **out,
                                               struct pel_fault *fault);
/* As ExerciseRun.digest, of the file as it is now; NULL: *fault says why there
 * is none. Until the next call. Control thread. */
const char *pel_exercise_files_digest(struct pel_exercise_files *files,
                                      const char *name,
                                      struct pel_fault *fault);
/* The exercise is tested first. */
PEL_CHECK enum pel_err
pel_exercise_files_save(struct pel_exercise_files *files, const char *name,
                        const Pelagos__Exercise *exercise,
                        struct pel_fault *fault);
PEL_CHECK enum pel_err
pel_exercise_files_delete(struct pel_exercise_files *files, const char *name,
                          struct pel_fault *fault);
/* What ExerciseRun.digest has of an exercise; g_free. Any thread. */
char *pel_exercise_digest(const Pelagos__Exercise *exercise);
/* The whole of it, by rename; errno where false. */
bool pel_exercise_replace(const char *path, const void *data, size_t size);

/* --- exercisebegin.c: any thread ------------------------------------------ */

/* A patch that makes `from` the exercise's initial state. */
struct pel_exercise_beginning {
    Pelagos__Patch patch; /* its state is ours */
    GPtrArray *remove;
};
void pel_exercise_begin(const Pelagos__Exercise *exercise,
                        const Pelagos__State *from,
                        struct pel_exercise_beginning *out);
void pel_exercise_beginning_finish(struct pel_exercise_beginning *beginning);

/* A patch that makes the scene, whose state is `from`, `to` again, all but the
 * clock's mode, `sources` and `presets`; of its views those stay that `to` does
 * not have and that still can. */
void pel_exercise_back(const Pelagos__State *to, const Pelagos__State *from,
                       struct pel_exercise_beginning *out);

/* What a restart must know of the ships whose helm is on, put into `out`. */
void pel_exercise_put_ships(const Pelagos__State *state, Pelagos__State *out);

/* --- exerciseships.c ------------------------------------------------------ */

/* Own ships, 1 to PEL_EXERCISE_SHIPS. Any thread. */
size_t pel_exercise_ship_count(const Pelagos__Exercise *exercise);
/* The entity of the one with this index: 0 is `ownShip`. Any thread. */
uint32_t pel_exercise_ship(const Pelagos__Exercise *exercise, size_t index);
/* -1: the entity is none of them. Any thread. */
int pel_exercise_ship_index(const Pelagos__Exercise *exercise, uint32_t id);
/* The draught that the exercise gives the entity [m]; NaN: none. Any thread. */
double pel_exercise_draught(const Pelagos__Exercise *exercise, uint32_t id);

/* The facts of every own ship: a sheet each. */
struct pel_exercise_facts;

/* path: the file that those of `ownShip` are written to as well, those of the
 * others beside it; NULL: nowhere. `since`: what is there up to this time is
 * taken over, -1: none of it. */
struct pel_exercise_facts *
pel_exercise_facts_create(const Pelagos__Exercise *exercise, const char *path,
                          double since_s);
void pel_exercise_facts_destroy(struct pel_exercise_facts *facts);
/* Rows of this moment, a whole second. */
void pel_exercise_facts_add(struct pel_exercise_facts *facts,
                            struct pel_exercise_moment *m);
/* Forgets what came after time_s. */
void pel_exercise_facts_cut(struct pel_exercise_facts *facts, double time_s);
/* Those of an own ship, by its index. */
const struct pel_exercise_sheet *
pel_exercise_facts_of(const struct pel_exercise_facts *facts, size_t index);
size_t pel_exercise_facts_bytes(const struct pel_exercise_facts *facts);
/* Removes the files of all own ships but `ownShip`, which another exercise
 * would not write anew. */
void pel_exercise_facts_remove(const Pelagos__Exercise *exercise,
                               const char *path);

/* --- exercisefacts.c ------------------------------------------------------ */

/* The facts of one own ship. */
struct pel_exercise_sheet;

/* ship: its index. path, since_s: as above. */
struct pel_exercise_sheet *
pel_exercise_sheet_create(const Pelagos__Exercise *exercise, size_t ship,
                          const char *path, double since_s);
void pel_exercise_sheet_destroy(struct pel_exercise_sheet *sheet);
void pel_exercise_sheet_add(struct pel_exercise_sheet *sheet,
                            struct pel_exercise_moment *m);
void pel_exercise_sheet_cut(struct pel_exercise_sheet *sheet, double time_s);
/* Whole lines from time_s on, of most bytes at most, with the head where time_s
 * is 0; *more: the time of the next, or NaN. g_free. */
char *pel_exercise_sheet_text(const struct pel_exercise_sheet *sheet,
                              double time_s, size_t most, double *more);
/* Sets what it says of the last row. */
void pel_exercise_sheet_glance(const struct pel_exercise_sheet *sheet,
                               struct pel_exercise_glance *out);
size_t pel_exercise_sheet_bytes(const struct pel_exercise_sheet *sheet);

/* --- exercisepast.c ------------------------------------------------------- */

/* What a rewind needs: states now and then, and every edit since. */
struct pel_exercise_past;

struct pel_exercise_past *pel_exercise_past_create(void);
void pel_exercise_past_destroy(struct pel_exercise_past *past);
/* The state at a mark. */
void pel_exercise_past_mark(struct pel_exercise_past *past, double time_s,
                            const Pelagos__State *state);
/* An edit that took effect at simulated time clock_s, exercise time time_s. */
void pel_exercise_past_add(struct pel_exercise_past *past, double clock_s,
                           double time_s, const Pelagos__Patch *patch);
/* The earliest time; INFINITY: none. */
double pel_exercise_past_earliest(const struct pel_exercise_past *past);
size_t pel_exercise_past_bytes(const struct pel_exercise_past *past);
/* Brings the scene to exercise time time_s, not before the earliest, by edits
 * and steps; what came later is forgotten. The clock is STEPPED then. */
PEL_CHECK enum pel_err pel_exercise_past_return(struct pel_exercise_past *past,
                                                struct pel_scene *scene,
                                                double time_s,
                                                struct pel_fault *fault);
