/* Inside of the scene: what scene.c keeps, and what submit.c makes of patches
 * that wait. Control thread. */
#pragma once

#include <glib.h>

#include "scene/catalogue.h"
#include "scene/journal.h"
#include "scene/missing.h"
#include "scene/prepare.h"
#include "scene/scene.h"
#include "scene/simclock.h"
#include "scene/store.h"
#include "scene/worker.h"

#define PEL_MAX_CALLBACKS 16
#define PEL_MAX_ACTS 2

/* Files that a start found damaged. */
struct pel_loss {
    const char *what; /* "state", "journal" */
    char *kept;       /* where the file is kept; NULL: nowhere */
    char words[480];
};

/* Findings of a start. */
struct pel_loaded {
    bool any; /* a state, not the default one */
    struct pel_journal_found journal;
    size_t loss_count;
    struct pel_loss losses[2];
};

struct pel_scene {
    struct pel_store *store; /* NULL: the state is not kept */
    struct pel_missing missing;
    struct pel_sea_means means;
    char *spectra;          /* what means.spectra points to */
    struct pel_files files; /* directories of our own */
    Pelagos__State *state;  /* clock.time as of the last look at it */
    Pelagos__State *former; /* of no use but as memory; NULL: none */
    struct pel_simclock clock;
    struct pel_resources has; /* what the snapshot was made with */
    const struct pel_snapshot *snapshot;
    unsigned tries;                  /* pel_scene_tries */
    struct pel_shared_sea *tried;    /* of the last one that was another sea */
    struct pel_worker *worker;       /* of patches that wait */
    struct pel_worker *numbers;      /* of spectra */
    struct pel_worker *shapes;       /* of lists of models */
    struct pel_catalogue *catalogue; /* that thread's; NULL: none yet */
    GPtrArray *waiting;              /* struct waiting, oldest first */
    guint batch;                     /* so many of them are being prepared */
    uint64_t prepared;               /* batches */
    struct pel_worker *saver;        /* of the state file and the journal */
    struct pel_journal *journal;     /* NULL: the state is not kept */
    bool journal_goes_on;            /* pel_scene_options */
    char save_why[160];              /* of the last save that failed */
    size_t loss_count;
    struct pel_loss losses[2];
    guint save_timer;        /* 0: nothing to write */
    bool saving, save_again; /* the file is being written; and then */
    int64_t save_from_ns;    /* not before */
    uint64_t saves, failed_saves;
    uint64_t told_saves; /* failed ones that are over */
    bool apart;          /* pel_scene_options */
    struct {
        bool on;        /* pel_scene_options.sealed, and there is a file */
        char *loaded;   /* path of the file that was loaded; NULL: none */
        uint8_t *bytes; /* the last sealed state; NULL: none yet */
        size_t size;
        uint64_t revision;    /* of it */
        bool unsaved;         /* the file has not these bytes */
        int64_t time_from_ns; /* not before, where only time has gone on */
    } sealed;
    guint ship_timer;               /* 0: no helm is on */
    struct pel_worker *ship_worker; /* does the ships' steps ahead */
    bool ship_ahead;                /* it is at work */
    uint32_t host_frame;
    pel_scene_listener listener; /* may be NULL */
    void *listener_user;
    struct pel_scene_acts acts[PEL_MAX_ACTS]; /* next NULL: none */
    bool acting, repeats;
    struct {
        bool on; /* a step is, until what somebody acts by is there */
        enum pel_clock_mode mode;
        double at_s, to_s;
        pel_scene_done done; /* may be NULL */
        void *user;
    } held;
    struct {
        bool on, playing; /* playing: an edit of the log is being done */
        char *cure;       /* for who edits all the same */
    } led;
    struct {
        GQueue *waiting; /* of answers, oldest first; NULL: there is no gate */
        uint64_t number; /* of the frame that is under way */
    } gate;
    size_t callback_count;
    struct {
        void (*call)(void *user);
        void *user;
    } callbacks[PEL_MAX_CALLBACKS];
};

/* The state as of time_s. */
void pel_scene_refresh(struct pel_scene *scene, double time_s);

/* The state after the patch, tested; pel_scene_put_by. */
PEL_CHECK enum pel_err pel_scene_edited(struct pel_scene *scene,
                                        const Pelagos__Patch *patch,
                                        double time_s, Pelagos__State **out,
                                        struct pel_fault *fault);

/* Commits `next`, made by `patch` at time_s, now_ns, and writes it to the log;
 * or it is freed. `ready` (NULL allowed): what was prepared for it. */
PEL_CHECK enum pel_err
pel_scene_commit(struct pel_scene *scene, Pelagos__State *next,
                 const Pelagos__Patch *patch, const struct pel_resources *ready,
                 double time_s, int64_t now_ns, struct pel_fault *fault);

/* Keeps a state (NULL: nothing) that is of no use but as the memory of the
 * next one. */
void pel_scene_put_by(struct pel_scene *scene, Pelagos__State *state);

/* After one or more of those. */
void pel_scene_notify_commit(struct pel_scene *scene);

/* keeping.c. The state to start with: the file's and the journal's, or the
 * default one. */
PEL_CHECK enum pel_err pel_scene_load(struct pel_store *store,
                                      const struct pel_scene_options *options,
                                      Pelagos__State **out,
                                      struct pel_loaded *loaded,
                                      struct pel_fault *fault);
/* The file is there from the start: one that is missing later was removed, and
 * its journal with it. */
void pel_scene_begin_keeping(struct pel_scene *scene,
                             const struct pel_scene_options *options,
                             const struct pel_loaded *loaded);
/* False: the last edits are lost. */
bool pel_scene_end_keeping(struct pel_scene *scene);
/* Into the journal: a patch that leads to `state`, or (NULL) a step, before it
 * takes effect. FULL: it must not. */
PEL_CHECK enum pel_err pel_scene_keep(struct pel_scene *scene, double time_s,
                                      const Pelagos__Patch *patch,
                                      const Pelagos__State *state,
                                      struct pel_fault *fault);
/* After it took effect. */
void pel_scene_kept(struct pel_scene *scene);
/* Has the state file written. */
void pel_scene_save_soon(struct pel_scene *scene);

/* Another snapshot, with its ships (all of them) further on. */
void pel_scene_take_ships(struct pel_scene *scene,
                          const struct pel_sailing *ships);

/* ship_ahead.c: has the ships' steps of the next seconds done by a thread,
 * where that is due. */
void pel_scene_step_ahead(struct pel_scene *scene, double time_s);

/* Goes on with the step that is held, where nothing holds it any more; over:
 * the daemon stops, and it ends here. */
void pel_scene_go_on(struct pel_scene *scene, bool over);

/* Acts at each moment up to time_s. */
void pel_scene_act_until(struct pel_scene *scene, double time_s);

/* Whether this source is one of those that act. */
bool pel_scene_acts_by(const struct pel_scene *scene, const void *source);

/* led.c: whether a log leads the scene, and not the one who asks. */
PEL_CHECK enum pel_err pel_scene_refuse_led(const struct pel_scene *scene,
                                            struct pel_fault *fault);

/* gate.c. Answers an edit (done NULL allowed), or has it wait for its seal:
 * true. */
bool pel_scene_answer(struct pel_scene *scene, const void *source,
                      pel_scene_done done, void *user, enum pel_err err,
                      const struct pel_fault *fault);
void pel_scene_gate_forget(struct pel_scene *scene, const void *source);

/* submit.c */
void pel_scene_begin_waiting(struct pel_scene *scene);
void pel_scene_end_waiting(struct pel_scene *scene);
