/* The one scene: state, edit, test, commit. Control thread only.
 *
 * The state is a Pelagos__State with every field that has a default present;
 * a commit replaces it whole and makes a new snapshot. The edit is in the
 * journal beside the state file (journal.h) before anybody is told of it. The
 * state file itself is written (write, fsync, rename) by a thread after the
 * commit, but not twice within a second; where that fails, again every 5 s. */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "base/metrics.h"
#include "pelagos.pb-c.h"
#include "scene/geodesy.h"
#include "scene/snapshot.h"

struct pel_scene;

struct pel_scene_options {
    const char *state_path; /* NULL: not kept */
    int wave_count;         /* trochoids of a sea, 20..256 */
    const char *spectra;    /* directory of measured spectra; NULL: none */
    const char *bathymetry; /* directory of height fields; NULL: none */
    const char *models;     /* directory of models; NULL: none */
    const char *panoramas;  /* directory of skies; NULL: none */
    const char *weather;    /* directory of weather fields; NULL: none */
    /* Of a debrief: it has no timers and does nothing ahead, so that any one
     * thread may use it. Its clock is to be stepped. */
    bool apart;
    /* Of a node of an exercise: what the file keeps is said by
     * pel_scene_keep_sealed alone, and there is no journal. */
    bool sealed;
    /* Edits that the journal cannot keep take effect all the same; else they
     * are refused (FULL). */
    bool journal_goes_on;
};

/* Loads options->state_path and its journal if it exists (a file that does not
 * load is kept beside it as *.bad, reported, and defaults are used), else the
 * default scene: one entity, id 1 `ownship`, and one view, `bridge`, on it.
 * Waits for the files that it names. CONFLICT: another daemon has that state;
 * NOT_FOUND, IO: a directory or the state's place cannot be used; *fault names
 * the option. */
PEL_CHECK enum pel_err pel_scene_create(const struct pel_scene_options *options,
                                        struct pel_scene **out,
                                        struct pel_fault *fault);

/* Writes the file and ends; NULL allowed. False: the last edits could be kept
 * neither in it nor in the journal. */
bool pel_scene_destroy(struct pel_scene *scene);

/* Applies the patch or nothing. On refusal *fault (NULL allowed) names path,
 * value, unit and range. A patch that touches the pose or the rates of an
 * entity first reckons it to its new pose_time (the present time where the
 * patch gives none), so that what it does not name goes on from where the ship
 * is. A patch of clock.time carries the poses along. A file that the patch
 * names is read here, and its sea is built by who looks at it first: for what
 * names neither, and for tests; else pel_scene_submit. FULL: the disk has no
 * room to keep it. */
PEL_CHECK enum pel_err pel_scene_patch(struct pel_scene *scene,
                                       const Pelagos__Patch *patch,
                                       struct pel_fault *fault);

/* Whether pel_scene_patch would refuse it now, files apart. */
PEL_CHECK enum pel_err pel_scene_test(struct pel_scene *scene,
                                      const Pelagos__Patch *patch,
                                      struct pel_fault *fault);

/* How a patch ends that may have to wait. fault: where err, else empty. */
typedef void (*pel_scene_done)(void *user, enum pel_err err,
                               const struct pel_fault *fault);

struct pel_scene_wish {
    const Pelagos__Patch *patch; /* copied where it waits */
    /* Who asks: patches of one source take effect in the order in which they
     * came. NULL: no source in particular. */
    const void *source;
    bool if_unchanged; /* refused where another edit comes before it: CONFLICT,
                        * and fault.path is PEL_SCENE_REVISION */
};
#define PEL_SCENE_REVISION "revision"

/* pel_scene_patch as the control thread of a daemon does it: a patch that asks
 * for another sea or another bottom is committed when a thread has built or
 * read it, one that touches sea, seabed or origin after those, and all others
 * at once. What waits is committed in its order, several in one moment: of a
 * slider's many seas the newest is built. The log of commands has each at the
 * moment when it took effect. `done` (NULL allowed) is called once; false: it
 * has been. At most 256 wait, BUSY beyond. */
bool pel_scene_submit(struct pel_scene *scene,
                      const struct pel_scene_wish *wish, pel_scene_done done,
                      void *user);

/* Nobody of this source waits any more; its patches are committed all the same.
 */
void pel_scene_forget(struct pel_scene *scene, const void *source);

/* The same, and they are not committed. */
void pel_scene_withdraw(struct pel_scene *scene, const void *source);

/* How many seas or files were prepared for patches. */
uint64_t pel_scene_prepared(const struct pel_scene *scene);

/* Waits until nothing waits: for tests and programs without a main loop. */
void pel_scene_settle(struct pel_scene *scene);

/* Somebody begins, or ends, to try patches one after the other: meanwhile the
 * last sea that was tried is kept, so that those that differ in something else
 * do not build it anew. */
void pel_scene_tries(struct pel_scene *scene, bool begin);

/* The snapshot that the scene would have after the patch, NULL for the one it
 * has, at the present time; the scene stays as it is. Its sea is built by who
 * looks at it first. Faults as of pel_scene_patch. pel_snapshot_unref. */
PEL_CHECK enum pel_err pel_scene_try_snapshot(struct pel_scene *scene,
                                              const Pelagos__Patch *patch,
                                              const struct pel_snapshot **out,
                                              struct pel_fault *fault);

/* What the state file named and was not found at the start; the scene's. */
struct pel_missing;
/* The faults in keeping the state, now or at the start, each in a sentence that
 * says the cure. */
#define PEL_TROUBLES_MOST 4
struct pel_trouble {
    const char *what; /* "journal", "state" */
    char words[640];
};
struct pel_troubles {
    size_t count;
    struct pel_trouble items[PEL_TROUBLES_MOST];
};
void pel_scene_troubles(const struct pel_scene *scene,
                        struct pel_troubles *out);

/* Whether an edit took effect that no file has: a kill now would lose it. */
bool pel_scene_volatile(const struct pel_scene *scene);

/* FULL: the disk had no room for the last edit and has none yet, as far as is
 * known. For who answers an edit before it takes effect. */
PEL_CHECK enum pel_err pel_scene_keeps(const struct pel_scene *scene,
                                       struct pel_fault *fault);

const struct pel_missing *pel_scene_missing(const struct pel_scene *scene);

/* Whether there is a directory of measured spectra. */
bool pel_scene_has_spectra(const struct pel_scene *scene);

/* The state with clock.time of now; owned by the scene, valid until its next
 * call. */
const Pelagos__State *pel_scene_state(struct pel_scene *scene);

/* A new reference to the snapshot of the last commit. */
const struct pel_snapshot *pel_scene_snapshot(struct pel_scene *scene);

/* Simulated time now [s]. FREE: follows CLOCK_MONOTONIC × rate. */
double pel_scene_time(struct pel_scene *scene);

/* While ownShip.on a step is 10 s at most, here and below.
 *
 * Advances simulated time: STEPPED by commands, PACED by the frame path, HOST
 * by the host. seconds 0..3600, OUT_OF_RANGE otherwise; CONFLICT when FREE. */
PEL_CHECK enum pel_err pel_scene_step(struct pel_scene *scene, double seconds,
                                      struct pel_fault *fault);

/* Advances simulated time to time_s, bit for bit: from the present time to
 * 1e9, OUT_OF_RANGE otherwise; CONFLICT when FREE. */
PEL_CHECK enum pel_err pel_scene_step_to(struct pel_scene *scene, double time_s,
                                         struct pel_fault *fault);

/* The step that a client asks for: by `seconds` or, where present, to
 * `until`. */
PEL_CHECK enum pel_err pel_scene_command_step(struct pel_scene *scene,
                                              const Pelagos__ClockStep *step,
                                              struct pel_fault *fault);

/* The same as the control thread of a daemon does it: where an act of that time
 * waits for its sea or its file (below), the step stops at that moment and goes
 * on from there by itself. `done` (NULL allowed) is called once; false: it has
 * been. CONFLICT: the clock was set meanwhile. While a step is held others are
 * BUSY, and those of the two calls above are held too, and nobody is told. */
bool pel_scene_submit_step(struct pel_scene *scene,
                           const Pelagos__ClockStep *step, pel_scene_done done,
                           void *user);
bool pel_scene_holds(const struct pel_scene *scene);

/* What the scene has accepted at simulated time time_s: a patch, or (NULL) a
 * step to that time. Called after it took effect and before the commit
 * callbacks; one listener, NULL for none. It must not change the scene. */
typedef void (*pel_scene_listener)(void *user, double time_s,
                                   const Pelagos__Patch *patch);
/* The state that the listener begins with, as pel_scene_state: own ship goes
 * on from it, so that a replay from this state has the same motion. */
const Pelagos__State *pel_scene_listen(struct pel_scene *scene,
                                       pel_scene_listener listener, void *user);

/* Who acts at moments of simulated time (exercise.h, weatherlead.h): at most
 * two, the first that came acts first at one moment. While somebody does, a
 * step is 10 s at most. */
struct pel_scene_acts {
    /* The next moment after the last, INFINITY: none; until_s: how far
     * simulated time is about to come. */
    double (*next)(void *user, double until_s);
    /* It is that moment: the scene may be edited, by pel_scene_act_patch. */
    void (*act)(void *user, double time_s);
    /* Whether what it did at the last moment still waits: until then a step is
     * held there. */
    bool (*waits)(void *user);
    /* As a listener. */
    pel_scene_listener heard;
    void *user;
    /* A log leads the scene from now on, or it leads itself again (led.h), from
     * the time at which its clock stands; may edit it then. NULL: neither
     * matters. */
    void (*led)(void *user, bool on);
};
void pel_scene_add_acts(struct pel_scene *scene,
                        const struct pel_scene_acts *acts);
void pel_scene_remove_acts(struct pel_scene *scene, const void *user);

/* Time is led through what has been: nobody acts until it is over. */
void pel_scene_repeat(struct pel_scene *scene, bool begin);
bool pel_scene_repeats(const struct pel_scene *scene);

/* Acts at each moment that a clock which runs by itself has passed. Edits do so
 * first. */
void pel_scene_catch_up(struct pel_scene *scene);

/* An edit that takes effect at time_s, the present time or the moment at which
 * somebody acts, whatever the clock shows by then. `done` as of
 * pel_scene_submit: a patch that asks for another sea or a file waits for it.
 * at_once: not where time goes by steps; who looks at the sea first builds it.
 * Its source is `user`, that of its acts (pel_scene_forget). */
bool pel_scene_act_patch(struct pel_scene *scene, const Pelagos__Patch *patch,
                         double time_s, bool at_once, pel_scene_done done,
                         void *user);

/* The newest frame of a simulator host that the scene shows, 0: no host
 * leads. Not part of the state: it goes with pictures and streams. */
void pel_scene_set_host_frame(struct pel_scene *scene, uint32_t number);
uint32_t pel_scene_host_frame(const struct pel_scene *scene);

/* Whether one input is silent: edits `sources` where it changed. */
void pel_scene_set_stale(struct pel_scene *scene, enum pel_stale source,
                         bool stale);

/* Called after every commit, in order of registration; at most 16. */
void pel_scene_on_commit(struct pel_scene *scene, void (*callback)(void *user),
                         void *user);

/* Begins anew with `state`, which it takes over: a whole one, as a log's head
 * has, and its clock stands. Faults as of a patch; the scene is as it was. */
PEL_CHECK enum pel_err pel_scene_begin_anew(struct pel_scene *scene,
                                            Pelagos__State *state,
                                            struct pel_fault *fault);

/* --- the state file of a node of an exercise -------------------------------
 */

/* Whether there is one. */
bool pel_scene_keeps_sealed(const struct pel_scene *scene);

/* The state of the last sealed frame, packed. The file has it within
 * PEL_SEALED_EDIT_S of an edit, within PEL_SEALED_TIME_S where only time has
 * gone on; both from the end of the write before. */
#define PEL_SEALED_EDIT_S 1.0
#define PEL_SEALED_TIME_S 10.0
void pel_scene_keep_sealed(struct pel_scene *scene, const uint8_t *bytes,
                           size_t size, uint64_t revision);

/* The state that was loaded at the start gives way to the exercise's: its file
 * is kept beside as PATH.aside (or .aside.2 to .9, of which the four oldest and
 * the newest stay). Does so once. */
void pel_scene_set_aside(struct pel_scene *scene);

/* Metrics of the state file; user is the scene (pel_metrics_collect). */
void pel_scene_collect(void *user, struct pel_metrics_page *page);
