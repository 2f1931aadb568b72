/* The exercise that is loaded: its clock, its events, its past. Control
 * thread. */
#pragma once

#include "scene/exercise_parts.h"

struct pel_exercise_run {
    struct pel_scene *scene;
    struct pel_exercise_files *files;
    char *kept_path, *facts_path; /* NULL: nothing is kept */
    bool leads;               /* an exercise is loaded, and the state ours */
    bool own;                 /* the edit under way is ours */
    bool returning;           /* a rewind is under way */
    bool loading, start_then; /* its initial state waits for its sea */
    char *name;
    Pelagos__Exercise *exercise;
    char *digest;
    int64_t tick;   /* the last that was looked at */
    double floor_s; /* of the last edit or step: none comes before it */
    GBytes *asked;  /* an edit of ours that waits; NULL: none */
    size_t event;   /* the next of this moment to be carried out */
    bool firing;
    enum {
        PEL_DUE_NOT,
        PEL_DUE_FIRE,
        PEL_DUE_LEAVE
    } due[PEL_BOUND_EXERCISE_EVENTS];
    enum pel_err load_err; /* of the last load, where it is over */
    struct pel_fault load_fault;
    guint timer; /* 0: time does not go by itself */
    struct pel_exercise_past *past;
    struct pel_exercise_facts *facts;
    struct pel_exercise_moment moment;
    uint64_t fired, refused;
    /* While another node leads it: the exercise, with which this one would go
     * on; NULL: `lacks` says why not, NULL: nor is there any. */
    Pelagos__Exercise *heir;
    char *heir_digest, *lacks;
    int64_t look_ns; /* not before then again, where one was lacking */
};

struct pel_exercises {
    struct pel_exercise_files *files;
    struct pel_worker *worker; /* of files */
    struct pel_exercise_run run;
};

void pel_exercise_run_init(struct pel_exercise_run *run,
                           struct pel_scene *scene,
                           struct pel_exercise_files *files,
                           const char *state_path);
void pel_exercise_run_finish(struct pel_exercise_run *run);

/* What the scene's state says of it. */
const Pelagos__ExerciseRun *
pel_exercise_run_state(const struct pel_exercise_run *run);
/* Exercise time now. */
double pel_exercise_run_time(const struct pel_exercise_run *run);

/* Takes the exercise over, whatever comes of it. */
PEL_CHECK enum pel_err pel_exercise_run_load(struct pel_exercise_run *run,
                                             const char *name,
                                             Pelagos__Exercise *exercise,
                                             struct pel_fault *fault);
/* Goes on with the one that the state names, from simulated time clock_s, up to
 * which everything has been looked at; false: it is another, and the caller's.
 */
bool pel_exercise_run_resume(struct pel_exercise_run *run,
                             Pelagos__Exercise *exercise, double clock_s);
/* Lets it go. */
void pel_exercise_run_forget(struct pel_exercise_run *run);
PEL_CHECK enum pel_err pel_exercise_run_start(struct pel_exercise_run *run,
                                              struct pel_fault *fault);
PEL_CHECK enum pel_err pel_exercise_run_pause(struct pel_exercise_run *run,
                                              struct pel_fault *fault);
PEL_CHECK enum pel_err pel_exercise_run_rewind(struct pel_exercise_run *run,
                                               double time_s,
                                               struct pel_fault *fault);
PEL_CHECK enum pel_err pel_exercise_run_stop(struct pel_exercise_run *run,
                                             struct pel_fault *fault);

/* --- exerciseheir.c ------------------------------------------------------- */

/* As pel_scene_acts.led, of a run. */
void pel_exercise_run_led(void *user, bool on);
/* Whether the state names an exercise that is not over. */
bool pel_exercise_run_named(const struct pel_exercise_run *run);
void pel_exercise_heir_free(struct pel_exercise_run *run);
