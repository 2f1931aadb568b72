#include "frames/debrief.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"
#include "scene/replay.h"
#include "scene/worker.h"

#define PLAY_MS 40
#define CLOSING_MS 50
#define PLAYING_FPS 15.0
#define STANDING_FPS 4.0
#define MOST_BEHIND_S 0.5 /* of real time, while it plays */
#define MAX_LISTS 16

struct pel_debrief {
    struct pel_debrief_options options;
    struct pel_recorder *recorder;
    struct pel_worker *worker;
    Pelagos__Debrief status;
    char *recording, *began, *device, *error; /* status' strings */
    struct pel_replay *replay; /* the worker's while it is busy */
    struct pel_scene *scene;
    struct pel_frames *frames;
    atomic_bool stop;
    _Atomic double part;
    bool working; /* the worker has the replay */
    bool wanted;  /* it is to go on to `goal` then */
    struct pel_replay_moment goal;
    char *reopen; /* recording to open after the end of this one */
    double anchor_s;
    int64_t anchor_ns; /* while it plays: position anchor_s at anchor_ns */
    guint timer;       /* of playing or closing; 0: none */
    struct pel_worker *lister;
    unsigned lists;
    uint64_t opened, failed;
    bool hangs; /* a thread of a renderer that was to end */
};

/* --- status --------------------------------------------------------------- */

static void set_text(char **mine, char **shown, const char *text)
{
    g_free(*mine);
    *mine = g_strdup(text);
    *shown = *mine;
}

static void say_error(struct pel_debrief *d, const char *text)
{
    set_text(&d->error, &d->status.error, text);
}

static void set_state(struct pel_debrief *d, Pelagos__DebriefState state)
{
    d->status.state = state;
    d->status.has_state = true;
}

static void set_rate(struct pel_debrief *d)
{
    if (d->frames) {
        pel_frames_set_max_fps(d->frames,
                               d->status.playing ? PLAYING_FPS : STANDING_FPS);
    }
}

const Pelagos__Debrief *pel_debrief_status(struct pel_debrief *d)
{
    d->status.busy = d->working || d->wanted ||
                     d->status.state == PELAGOS__DEBRIEF_STATE__OPENING;
    d->status.progress = d->status.busy ? atomic_load(&d->part) : 1;
    return &d->status;
}

/* What is known of a recording that was opened. */
static void describe(struct pel_debrief *d)
{
    const struct pel_recording *r = pel_replay_recording(d->replay);
    g_autofree char *name = g_path_get_basename(r->segments[0].path);
    const char *here = pel_frames_device(d->frames);
    set_text(&d->recording, &d->status.recording, name);
    set_text(&d->began, &d->status.began, r->segments[0].began);
    set_text(&d->device, &d->status.device, r->segments[0].device);
    d->status.same_device = g_strcmp0(r->segments[0].device, here) == 0;
    d->status.length = pel_replay_length(d->replay);
    d->status.commands = pel_replay_commands(d->replay);
}

static void note_moment(struct pel_debrief *d)
{
    struct pel_replay_moment at = pel_replay_at(d->replay);
    d->status.time = at.time_s;
    d->status.position = pel_replay_position(d->replay, at);
}

/* --- going to a moment ---------------------------------------------------- */

struct walk {
    struct pel_task task;
    struct pel_debrief *debrief;
    struct pel_replay_moment to;
    enum pel_err err;
    struct pel_fault fault;
    struct pel_still still;
};

static void begin_walk(struct pel_debrief *d);
static void set_playing(struct pel_debrief *d, bool on);

static void do_walk(struct pel_task *task)
{
    struct walk *w = (struct walk *)task;
    w->err = pel_replay_go(w->debrief->replay, w->to, &w->fault);
    pel_replay_still(w->debrief->replay, &w->still);
}

static void walked(struct pel_task *task, bool dropped)
{
    struct walk *w = (struct walk *)task;
    struct pel_debrief *d = w->debrief;
    bool called_off = atomic_load(&d->stop);
    d->working = false;
    atomic_store(&d->stop, false);
    if (!dropped && d->status.state == PELAGOS__DEBRIEF_STATE__OPEN &&
        !(called_off && w->err)) {
        pel_scene_show_still(d->scene, &w->still);
        note_moment(d);
        say_error(d, w->err ? w->fault.message : NULL);
        bool over = d->status.position >= d->status.length;
        if (w->err || (over && !d->wanted)) {
            set_playing(d, false);
        }
    }
    pel_still_finish(&w->still);
    g_free(w);
    if (!dropped && d->wanted) {
        begin_walk(d);
    }
}

static void begin_walk(struct pel_debrief *d)
{
    struct walk *w = g_new0(struct walk, 1);
    w->task = (struct pel_task){ .work = do_walk, .done = walked };
    w->debrief = d;
    w->to = d->goal;
    d->wanted = false;
    d->working = true;
    pel_worker_push(d->worker, &w->task);
}

/* The newest goal counts; what is under way to an older one is called off
 * where that is of use. */
static void go_to(struct pel_debrief *d, struct pel_replay_moment to,
                  bool at_once)
{
    d->goal = to;
    d->wanted = true;
    if (!d->working) {
        begin_walk(d);
    } else if (at_once) {
        atomic_store(&d->stop, true);
    }
}

static gboolean on_play(gpointer user)
{
    PEL_WATCH("debrief");
    struct pel_debrief *d = user;
    double since_s = (double)(pel_now_ns() - d->anchor_ns) * 1e-9;
    double to_s = d->anchor_s + since_s * d->status.rate;
    double most_s = d->status.position + MOST_BEHIND_S * d->status.rate;
    if (d->working || d->wanted) {
        return G_SOURCE_CONTINUE;
    }
    if (to_s > most_s) { /* it takes longer than it may: time goes slower */
        to_s = most_s;
        d->anchor_s = to_s;
        d->anchor_ns = pel_now_ns();
    }
    go_to(d, pel_replay_at_position(d->replay, to_s), false);
    return G_SOURCE_CONTINUE;
}

static void anchor(struct pel_debrief *d, double position_s)
{
    d->anchor_s = position_s;
    d->anchor_ns = pel_now_ns();
}

static void set_playing(struct pel_debrief *d, bool on)
{
    if (on == (bool)d->status.playing) {
        return;
    }
    d->status.playing = on;
    if (on) {
        d->timer = g_timeout_add(PLAY_MS, on_play, d);
    } else if (d->timer != 0) {
        g_source_remove(d->timer);
        d->timer = 0;
    }
    set_rate(d);
}

/* --- opening -------------------------------------------------------------- */

struct opening {
    struct pel_task task;
    struct pel_debrief *debrief;
    char *directory, *name;
    enum pel_err err;
    struct pel_fault fault;
    struct pel_replay *replay;
    struct pel_scene *scene;
    struct pel_frames *frames;
};

/* The scene that is shown and its renderer. */
static enum pel_err make_views(struct opening *o)
{
    struct pel_debrief *d = o->debrief;
    struct pel_scene_options scene = d->options.scene;
    struct pel_still still;
    scene.apart = true;
    scene.state_path = NULL;
    enum pel_err err = pel_scene_create(&scene, &o->scene, &o->fault);
    if (!err) {
        pel_replay_still(o->replay, &still);
        pel_scene_show_still(o->scene, &still);
        err = pel_frames_create(&d->options.frames, o->scene, &o->frames,
                                &o->fault);
    }
    return err;
}

static void do_open(struct pel_task *task)
{
    struct opening *o = (struct opening *)task;
    struct pel_debrief *d = o->debrief;
    struct pel_replay_options options = {
        .directory = o->directory,
        .name = o->name,
        .scene = d->options.scene,
        .stop = &d->stop,
        .part = &d->part,
    };
    o->err = pel_replay_open(&options, &o->replay, &o->fault);
    if (!o->err) {
        o->err = make_views(o);
    }
    if (o->err) {
        (void)pel_scene_destroy(o->scene);
        pel_replay_close(o->replay);
        o->scene = NULL;
        o->replay = NULL;
    }
}

static void begin_closing(struct pel_debrief *d);

static void opened(struct pel_task *task, bool dropped)
{
    struct opening *o = (struct opening *)task;
    struct pel_debrief *d = o->debrief;
    (void)dropped; /* the end takes it from here */
    d->replay = o->replay;
    d->scene = o->scene;
    d->frames = o->frames;
    bool called_off = atomic_exchange(&d->stop, false);
    if (o->err) {
        d->failed++;
        set_state(d, called_off ? PELAGOS__DEBRIEF_STATE__CLOSED
                                : PELAGOS__DEBRIEF_STATE__FAILED);
        say_error(d, called_off ? NULL : o->fault.message);
        d->status.playing = false;
        if (!called_off) {
            pel_warn("FRM-011", "the recording %s was not opened: %s", o->name,
                     o->fault.message);
        }
    } else {
        d->opened++;
        set_state(d, PELAGOS__DEBRIEF_STATE__OPEN);
        describe(d);
        note_moment(d);
        anchor(d, 0);
        set_rate(d);
    }
    g_free(o->directory);
    g_free(o->name);
    g_free(o);
    if (!dropped && d->frames && (called_off || d->reopen)) {
        begin_closing(d);
    } else if (!dropped && d->reopen) {
        g_autofree char *name = g_steal_pointer(&d->reopen);
        struct pel_fault fault;
        Pelagos__DebriefCommand again = PELAGOS__DEBRIEF_COMMAND__INIT;
        again.recording = name;
        if (pel_debrief_do(d, &again, &fault)) {
            say_error(d, fault.message);
        }
    }
}

static void open_recording(struct pel_debrief *d, const char *name)
{
    struct opening *o = g_new0(struct opening, 1);
    o->task = (struct pel_task){ .work = do_open, .done = opened };
    o->debrief = d;
    o->directory = g_strdup(pel_recorder_directory(d->recorder));
    o->name = g_strdup(name);
    atomic_store(&d->part, 0);
    atomic_store(&d->stop, false);
    set_state(d, PELAGOS__DEBRIEF_STATE__OPENING);
    set_text(&d->recording, &d->status.recording, name);
    say_error(d, NULL);
    d->status.time = d->status.position = d->status.length = 0;
    pel_worker_push(d->worker, &o->task);
}

/* --- closing -------------------------------------------------------------- */

struct closing {
    struct pel_task task;
    struct pel_debrief *debrief;
    struct pel_replay *replay;
    struct pel_scene *scene;
    struct pel_frames *frames;
    bool joined, done;
};

static void do_close(struct pel_task *task)
{
    struct closing *c = (struct closing *)task;
    c->done = true;
    c->joined = pel_frames_destroy(c->frames);
    if (c->joined) {
        (void)pel_scene_destroy(c->scene);
    }
    pel_replay_close(c->replay);
}

static void closed(struct pel_task *task, bool dropped)
{
    struct closing *c = (struct closing *)task;
    struct pel_debrief *d = c->debrief;
    if (!c->done) {
        do_close(task);
    }
    d->hangs = d->hangs || !c->joined;
    g_free(c);
    set_state(d, PELAGOS__DEBRIEF_STATE__CLOSED);
    set_text(&d->recording, &d->status.recording, NULL);
    g_autofree char *name = g_steal_pointer(&d->reopen);
    if (name && !dropped) {
        open_recording(d, name);
    }
}

/* When those who watch have heard of it. */
static gboolean on_closing(gpointer user)
{
    PEL_WATCH("debrief");
    struct pel_debrief *d = user;
    if (d->working || !pel_frames_retire(d->frames)) {
        return G_SOURCE_CONTINUE;
    }
    struct closing *c = g_new0(struct closing, 1);
    c->task = (struct pel_task){ .work = do_close, .done = closed };
    c->debrief = d;
    c->replay = d->replay;
    c->scene = d->scene;
    c->frames = d->frames;
    d->replay = NULL;
    d->scene = NULL;
    d->frames = NULL;
    d->timer = 0;
    pel_worker_push(d->worker, &c->task);
    return G_SOURCE_REMOVE;
}

static void begin_closing(struct pel_debrief *d)
{
    set_playing(d, false);
    d->wanted = false;
    atomic_store(&d->stop, d->working);
    set_state(d, PELAGOS__DEBRIEF_STATE__CLOSING);
    say_error(d, NULL);
    (void)pel_frames_retire(d->frames);
    d->timer = g_timeout_add(CLOSING_MS, on_closing, d);
}

static void end(struct pel_debrief *d)
{
    switch (d->status.state) {
    case PELAGOS__DEBRIEF_STATE__OPENING:
        atomic_store(&d->stop, true); /* opened() sees to the rest */
        break;
    case PELAGOS__DEBRIEF_STATE__OPEN:
        begin_closing(d);
        break;
    case PELAGOS__DEBRIEF_STATE__FAILED:
        set_state(d, PELAGOS__DEBRIEF_STATE__CLOSED);
        set_text(&d->recording, &d->status.recording, NULL);
        say_error(d, NULL);
        break;
    default:
        break;
    }
}

/* --- commands ------------------------------------------------------------- */

static bool is_open(const struct pel_debrief *d)
{
    return d->status.state == PELAGOS__DEBRIEF_STATE__OPEN;
}

static enum pel_err open_another(struct pel_debrief *d, const char *name,
                                 struct pel_fault *fault)
{
    if (!pel_recorder_directory(d->recorder)) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "there is no place for recordings: start pelagosd "
                             "with --recordings DIRECTORY");
    }
    if (d->status.state == PELAGOS__DEBRIEF_STATE__CLOSED ||
        d->status.state == PELAGOS__DEBRIEF_STATE__FAILED) {
        open_recording(d, name);
        return PEL_OK;
    }
    g_free(d->reopen);
    d->reopen = g_strdup(name);
    end(d);
    return PEL_OK;
}

enum pel_err pel_debrief_do(struct pel_debrief *d,
                            const Pelagos__DebriefCommand *c,
                            struct pel_fault *fault)
{
    bool moves =
        c->has_time || c->has_position || c->has_playing || c->has_rate;
    if (c->has_close && c->close) {
        g_clear_pointer(&d->reopen, g_free);
        end(d);
        return PEL_OK;
    }
    if (c->recording && moves) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "open the recording first; when it is OPEN, say "
                             "where to go");
    }
    if (c->recording) {
        return open_another(d, c->recording, fault);
    }
    if (moves && !is_open(d)) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "no recording is open for a debrief");
    }
    if (c->has_time && c->has_position) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "time and position are two ways to say one thing");
    }
    if (c->has_rate) {
        d->status.rate = c->rate;
        anchor(d, d->status.position);
    }
    if (c->has_time || c->has_position) {
        struct pel_replay_moment to =
            c->has_time ? pel_replay_at_time(d->replay, c->time)
                        : pel_replay_at_position(d->replay, c->position);
        anchor(d, pel_replay_position(d->replay, to));
        go_to(d, to, true);
    }
    if (c->has_playing) {
        if (c->playing && d->status.position >= d->status.length &&
            !d->wanted) {
            go_to(d, pel_replay_at_position(d->replay, 0), true);
            anchor(d, 0);
        } else if (c->playing && !d->status.playing) {
            anchor(d,
                   d->wanted || d->working ? d->anchor_s : d->status.position);
        }
        set_playing(d, c->playing);
    }
    return PEL_OK;
}

struct pel_scene *pel_debrief_scene(const struct pel_debrief *d)
{
    return is_open(d) ? d->scene : NULL;
}

struct pel_frames *pel_debrief_frames(const struct pel_debrief *d)
{
    return is_open(d) ? d->frames : NULL;
}

/* --- recordings ----------------------------------------------------------- */

struct list {
    struct pel_task task;
    struct pel_debrief *debrief;
    char *directory; /* NULL: none */
    pel_recordings_done done;
    void *user;
    enum pel_err err;
    struct pel_fault fault;
    struct pel_recordings found;
};

static void do_list(struct pel_task *task)
{
    struct list *l = (struct list *)task;
    l->err = l->directory
                 ? pel_recordings_list(l->directory, &l->found, &l->fault)
                 : PEL_OK;
}

static void fill_info(const struct pel_recording *r, const char *writing,
                      Pelagos__RecordingInfo *out)
{
    const struct pel_recording_segment *first = &r->segments[0];
    const struct pel_recording_segment *last = &r->segments[r->count - 1];
    g_autofree char *file = g_path_get_basename(last->path);
    pelagos__recording_info__init(out);
    out->name = g_path_get_basename(first->path);
    out->recording = first->recording;
    out->began = first->began;
    out->program = first->program;
    out->device = first->device;
    out->has_segments = out->has_bytes = out->has_from = out->has_to = true;
    out->segments = (uint32_t)r->count;
    out->bytes = r->bytes;
    out->from = first->from_s;
    out->to = r->to_s;
    out->has_writing = out->writing = g_strcmp0(file, writing) == 0;
    out->error = r->why;
}

static void answer(struct list *l)
{
    Pelagos__Recordings all = PELAGOS__RECORDINGS__INIT;
    const char *writing = pel_recorder_name(l->debrief->recorder);
    g_autofree Pelagos__RecordingInfo *infos =
        g_new0(Pelagos__RecordingInfo, l->found.count + 1);
    g_autofree Pelagos__RecordingInfo **list =
        g_new0(Pelagos__RecordingInfo *, l->found.count + 1);
    for (size_t i = 0; i < l->found.count; i++) {
        fill_info(&l->found.items[i], writing, &infos[i]);
        list[i] = &infos[i];
    }
    all.n_recordings = l->found.count;
    all.recordings = list;
    all.has_more = all.has_possible = true;
    all.more = l->found.more;
    all.possible = l->directory != NULL;
    all.writing = (char *)writing;
    l->done(l->user, PEL_OK, NULL, &all);
    for (size_t i = 0; i < l->found.count; i++) {
        g_free(infos[i].name);
    }
}

static void listed(struct pel_task *task, bool dropped)
{
    struct list *l = (struct list *)task;
    l->debrief->lists--;
    if (dropped) {
        l->err = pel_fault_set(&l->fault, PEL_ERR_CONFLICT,
                               "the daemon is stopping");
    }
    if (l->err) {
        l->done(l->user, l->err, &l->fault, NULL);
    } else {
        answer(l);
    }
    pel_recordings_finish(&l->found);
    g_free(l->directory);
    g_free(l);
}

enum pel_err pel_debrief_ask_recordings(struct pel_debrief *d,
                                        pel_recordings_done done, void *user,
                                        struct pel_fault *fault)
{
    if (d->lists == MAX_LISTS) {
        return pel_fault_set(fault, PEL_ERR_BUSY,
                             "%d lists of recordings are waited for already",
                             MAX_LISTS);
    }
    struct list *l = g_new0(struct list, 1);
    l->task = (struct pel_task){ .work = do_list, .done = listed };
    l->debrief = d;
    l->directory = g_strdup(pel_recorder_directory(d->recorder));
    l->done = done;
    l->user = user;
    d->lists++;
    pel_worker_push(d->lister, &l->task);
    return PEL_OK;
}

enum pel_err pel_debrief_record(struct pel_debrief *d,
                                const Pelagos__RecordingCommand *c,
                                struct pel_fault *fault)
{
    bool stop = c->has_stop && c->stop;
    if (stop == (c->start != NULL)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "give either start, with a name or \"\", or stop");
    }
    return stop ? pel_recorder_stop(d->recorder, fault)
                : pel_recorder_start(d->recorder, c->start, fault);
}

/* --- life ----------------------------------------------------------------- */

struct pel_debrief *
pel_debrief_create(const struct pel_debrief_options *options,
                   struct pel_recorder *recorder)
{
    struct pel_debrief *d = g_new0(struct pel_debrief, 1);
    d->options = *options;
    d->options.frames.max_fps = STANDING_FPS;
    d->options.frames.lose_after = 0;
    d->recorder = recorder;
    d->worker = pel_worker_create("debrief");
    d->lister = pel_worker_create("recordings");
    pelagos__debrief__init(&d->status);
    d->status.has_time = d->status.has_position = d->status.has_length = true;
    d->status.has_playing = d->status.has_rate = d->status.has_busy = true;
    d->status.has_progress = d->status.has_commands = true;
    d->status.has_same_device = true;
    d->status.rate = 1;
    set_state(d, PELAGOS__DEBRIEF_STATE__CLOSED);
    return d;
}

bool pel_debrief_destroy(struct pel_debrief *d)
{
    if (!d) {
        return true;
    }
    atomic_store(&d->stop, true);
    if (d->timer != 0) {
        g_source_remove(d->timer);
    }
    pel_worker_destroy(d->lister);
    pel_worker_destroy(d->worker);
    bool joined = pel_frames_destroy(d->frames) && !d->hangs;
    if (joined) {
        (void)pel_scene_destroy(d->scene);
        pel_replay_close(d->replay);
    }
    g_free(d->reopen);
    g_free(d->recording);
    g_free(d->began);
    g_free(d->device);
    g_free(d->error);
    g_free(d);
    return joined;
}

void pel_debrief_collect(void *user, struct pel_metrics_page *page)
{
    struct pel_debrief *d = user;
    pel_metric(page, "pelagos_debrief_open", PEL_METRIC_GAUGE,
               "1 while a recording is open for a debrief.", NULL,
               is_open(d) ? 1 : 0);
    pel_metric(page, "pelagos_debrief_opened_total", PEL_METRIC_COUNTER,
               "Recordings that were opened for a debrief.", NULL,
               (double)d->opened);
    pel_metric(page, "pelagos_debrief_failed_total", PEL_METRIC_COUNTER,
               "Recordings that could not be opened.", NULL, (double)d->failed);
}
