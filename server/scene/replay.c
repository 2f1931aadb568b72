#include "scene/replay.h"

#include <glib.h>
#include <math.h>
#include <string.h>

#include "base/clock.h"

#define MOST_AT_ONCE_S 5.0        /* a ship steps through the sea */
#define KEEP_AFTER_NS 150000000LL /* of work since the last still */
#define LOOK_EVERY 64             /* entries, for `stop` */

/* Simulated time without a setting of the clock. */
struct stretch {
    double from_s, to_s, position_s;
};

/* Where a segment begins. */
struct place {
    struct pel_replay_moment at;
    size_t entries; /* of all before it */
};

/* A state on the way, and where the log goes on from it. */
struct kept {
    struct pel_replay_moment at;
    size_t segment;
    struct pel_logfile_place place;
    struct pel_still still;
};

struct pel_replay {
    char *directory;
    struct pel_recording recording;
    atomic_bool *stop;
    _Atomic double *part;
    struct pel_scene *scene;
    GArray *stretches;    /* of struct stretch */
    struct place *places; /* of each segment */
    size_t commands;
    struct pel_logfile *log; /* of the segment at hand; NULL: none */
    size_t segment;
    Pelagos__LogEntry *next; /* read and not done yet; NULL: none */
    struct pel_replay_moment at;
    struct kept kept[PEL_REPLAY_STILLS];
    size_t kept_count;
    int64_t kept_ns, keep_after_ns;
};

static int order(struct pel_replay_moment a, struct pel_replay_moment b)
{
    return a.stretch != b.stretch
               ? (a.stretch > b.stretch ? 1 : -1)
               : (a.time_s > b.time_s) - (a.time_s < b.time_s);
}

static struct stretch *stretch_of(const struct pel_replay *r, size_t i)
{
    return &g_array_index(r->stretches, struct stretch, i);
}

static void tell(const struct pel_replay *r, double part)
{
    if (r->part) {
        atomic_store(r->part, part);
    }
}

static enum pel_err stopped(const struct pel_replay *r, struct pel_fault *fault)
{
    return r->stop && atomic_load(r->stop)
               ? pel_fault_set(fault, PEL_ERR_CONFLICT, "it was called off")
               : PEL_OK;
}

/* --- segments ------------------------------------------------------------- */

static void drop_segment(struct pel_replay *r)
{
    if (r->next) {
        pelagos__log_entry__free_unpacked(r->next, NULL);
    }
    r->next = NULL;
    pel_logfile_close(r->log);
    r->log = NULL;
}

static enum pel_err damaged(const struct pel_replay *r, enum pel_err err,
                            const struct pel_fault *why,
                            struct pel_fault *fault)
{
    g_autofree char *name =
        g_path_get_basename(r->recording.segments[r->segment].path);
    return pel_fault_set(fault, err, "%.80s: %.200s", name, why->message);
}

/* The next entry to r->next; NULL at the segment's end. */
static enum pel_err read_next(struct pel_replay *r, struct pel_fault *fault)
{
    struct pel_fault why;
    if (r->next || !r->log) {
        return PEL_OK;
    }
    enum pel_err err = pel_logfile_next(r->log, &r->next, &why);
    return err ? damaged(r, err, &why, fault) : PEL_OK;
}

/* A recording that goes on gives its files other names: the one of that number
 * now. */
static enum pel_err find_again(struct pel_replay *r, size_t i,
                               struct pel_fault *fault)
{
    struct pel_recording_segment *s = &r->recording.segments[i];
    struct pel_recording now;
    enum pel_err err = pel_recording_find(
        r->directory, s->recording ? s->recording : "", &now, fault);
    if (err) {
        return err;
    }
    err = PEL_ERR_NOT_FOUND;
    for (size_t k = 0; k < now.count && err; k++) {
        if (now.segments[k].number == s->number) {
            g_free(s->path);
            s->path = g_strdup(now.segments[k].path);
            err = PEL_OK;
        }
    }
    pel_recording_finish(&now);
    return err ? pel_fault_set(fault, err,
                               "segment %u of the recording was removed",
                               s->number)
               : PEL_OK;
}

static bool is_segment(const struct pel_replay *r,
                       const struct pel_recording_segment *s)
{
    const Pelagos__LogHead *head = r->next ? r->next->head : NULL;
    return head && head->segment == s->number &&
           g_strcmp0(head->recording, s->recording) == 0;
}

/* Opens the file; its head is r->next. */
static enum pel_err load(struct pel_replay *r, size_t i,
                         struct pel_fault *fault)
{
    const struct pel_recording_segment *s = &r->recording.segments[i];
    for (int again = 0;; again++) {
        struct pel_fault why;
        drop_segment(r);
        r->segment = i;
        enum pel_err err = pel_recording_open(s, &r->log, &why);
        if (err && (again > 0 || err != PEL_ERR_NOT_FOUND)) {
            return damaged(r, err, &why, fault);
        }
        if (!err) {
            err = read_next(r, fault);
            if (err || is_segment(r, s)) {
                return err;
            }
        }
        if (again > 0) {
            return pel_fault_set(fault, PEL_ERR_CONFLICT,
                                 "the recording's files changed meanwhile; "
                                 "open it again");
        }
        err = find_again(r, i, fault);
        if (err) {
            return err;
        }
    }
}

/* --- moments -------------------------------------------------------------- */

static void begin_stretch(struct pel_replay *r, double time_s)
{
    struct stretch fresh = { time_s, time_s, 0 };
    if (r->stretches->len > 0) {
        const struct stretch *last = stretch_of(r, r->stretches->len - 1);
        fresh.position_s = last->position_s + (last->to_s - last->from_s);
    }
    g_array_append_val(r->stretches, fresh);
}

double pel_replay_position(const struct pel_replay *r,
                           struct pel_replay_moment m)
{
    const struct stretch *s = stretch_of(r, m.stretch);
    return s->position_s + (m.time_s - s->from_s);
}

static struct pel_replay_moment end_of(const struct pel_replay *r)
{
    unsigned last = r->stretches->len - 1;
    return (struct pel_replay_moment){ last, stretch_of(r, last)->to_s };
}

double pel_replay_length(const struct pel_replay *r)
{
    return pel_replay_position(r, end_of(r));
}

struct pel_replay_moment pel_replay_at_position(const struct pel_replay *r,
                                                double position_s)
{
    unsigned i = r->stretches->len - 1;
    while (i > 0 && stretch_of(r, i)->position_s > position_s) {
        i--;
    }
    const struct stretch *s = stretch_of(r, i);
    double time_s = s->from_s + fmax(position_s - s->position_s, 0);
    return (struct pel_replay_moment){ i, fmin(time_s, s->to_s) };
}

struct pel_replay_moment pel_replay_at_time(const struct pel_replay *r,
                                            double time_s)
{
    struct pel_replay_moment best = { 0, stretch_of(r, 0)->from_s };
    double nearest = INFINITY;
    for (unsigned i = 0; i < r->stretches->len; i++) {
        const struct stretch *s = stretch_of(r, i);
        double there = fmin(fmax(time_s, s->from_s), s->to_s);
        if (fabs(there - time_s) <= nearest) {
            nearest = fabs(there - time_s);
            best = (struct pel_replay_moment){ i, there };
        }
    }
    return best;
}

/* The moment of an entry that is about to be done, *at being that of the one
 * before it: a head may follow another time. */
static struct pel_replay_moment moment_of(struct pel_replay_moment at,
                                          const Pelagos__LogEntry *entry)
{
    bool back = entry->time < at.time_s;
    return (struct pel_replay_moment){ at.stretch + back, entry->time };
}

/* --- the first reading ---------------------------------------------------- */

static enum pel_err read_segment(struct pel_replay *r, size_t i,
                                 struct pel_fault *fault)
{
    enum pel_err err = load(r, i, fault);
    struct pel_replay_moment at = { 0 };
    for (size_t n = 0; !err && r->next; n++) {
        const Pelagos__LogEntry *e = r->next;
        if (r->stretches->len == 0 || e->time < end_of(r).time_s) {
            begin_stretch(r, e->time);
        }
        stretch_of(r, r->stretches->len - 1)->to_s = e->time;
        at = end_of(r);
        if (n == 0) {
            r->places[i] = (struct place){ at, r->commands };
        }
        r->commands++;
        double now_s = pel_logfile_place(r->log).time_s;
        if (now_s != e->time) {
            begin_stretch(r, now_s);
        }
        pelagos__log_entry__free_unpacked(r->next, NULL);
        r->next = NULL;
        err = n % LOOK_EVERY == 0 ? stopped(r, fault) : PEL_OK;
        if (!err) {
            err = read_next(r, fault);
        }
    }
    return err;
}

static enum pel_err read_all(struct pel_replay *r, struct pel_fault *fault)
{
    uint64_t done = 0;
    enum pel_err err = PEL_OK;
    for (size_t i = 0; i < r->recording.count && !err; i++) {
        err = read_segment(r, i, fault);
        done += r->recording.segments[i].bytes;
        tell(r, (double)done / ((double)r->recording.bytes + 1));
    }
    return err;
}

/* --- playing -------------------------------------------------------------- */

/* Everything goes on with a whole state of r->next, which is taken over. */
static enum pel_err begin_with(struct pel_replay *r, Pelagos__State **state,
                               struct pel_fault *fault)
{
    Pelagos__State *whole = *state;
    whole->clock->time = r->next->time;
    whole->clock->has_time = true;
    *state = NULL;
    return pel_scene_begin_anew(r->scene, whole, fault);
}

static enum pel_err begin_at(struct pel_replay *r, size_t segment,
                             struct pel_fault *fault)
{
    struct pel_fault why;
    enum pel_err err = load(r, segment, fault);
    if (err) {
        return err;
    }
    err = begin_with(r, &r->next->head->state, &why);
    pelagos__log_entry__free_unpacked(r->next, NULL);
    r->next = NULL;
    r->at = r->places[segment].at;
    return err ? damaged(r, err, &why, fault) : PEL_OK;
}

static bool sails(const Pelagos__State *state)
{
    bool on = state->own_ship && state->own_ship->on;
    for (size_t i = 0; i < state->n_entities && !on; i++) {
        on = state->entities[i]->helm && state->entities[i]->helm->on;
    }
    return on;
}

static enum pel_err step_to(struct pel_replay *r, double time_s,
                            struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    bool slow = time_s > r->at.time_s + MOST_AT_ONCE_S &&
                sails(pel_scene_state(r->scene));
    while (slow && !err && time_s - r->at.time_s > MOST_AT_ONCE_S) {
        r->at.time_s += MOST_AT_ONCE_S;
        err = pel_scene_step_to(r->scene, r->at.time_s, fault);
        err = err ? err : stopped(r, fault);
    }
    if (!err && time_s > r->at.time_s) {
        r->at.time_s = time_s;
        err = pel_scene_step_to(r->scene, time_s, fault);
    }
    return err;
}

static bool removes_clock(const Pelagos__Patch *patch)
{
    for (size_t i = 0; i < patch->n_remove; i++) {
        if (strncmp(patch->remove[i], "clock", 5) == 0) {
            return true;
        }
    }
    return false;
}

/* The recorded patch, but the clock stays in our hands. */
static enum pel_err do_patch(struct pel_replay *r, Pelagos__Patch *patch,
                             struct pel_fault *fault)
{
    Pelagos__State own_state = PELAGOS__STATE__INIT;
    Pelagos__Clock own_clock = PELAGOS__CLOCK__INIT;
    Pelagos__State *state = patch->state;
    Pelagos__Clock *clock = state ? state->clock : NULL;
    if (clock || removes_clock(patch)) {
        patch->state = state ? state : &own_state;
        patch->state->clock = clock ? clock : &own_clock;
        patch->state->clock->has_mode = 1;
        patch->state->clock->mode = PELAGOS__CLOCK_MODE__STEPPED;
    }
    enum pel_err err = pel_scene_patch(r->scene, patch, fault);
    if (state && !clock) {
        state->clock = NULL;
    }
    patch->state = state;
    double now_s = pel_scene_time(r->scene);
    if (now_s != r->at.time_s) {
        r->at = (struct pel_replay_moment){ r->at.stretch + 1, now_s };
    }
    return err;
}

/* r->next, which is no head; frees it. */
static enum pel_err do_next(struct pel_replay *r, struct pel_fault *fault)
{
    struct pel_fault why;
    enum pel_err err = step_to(r, r->next->time, &why);
    if (!err && r->next->command_case == PELAGOS__LOG_ENTRY__COMMAND_PATCH) {
        err = do_patch(r, r->next->patch, &why);
    }
    if (!err && r->next->command_case == PELAGOS__LOG_ENTRY__COMMAND_STATE) {
        r->at = moment_of(r->at, r->next);
        err = begin_with(r, &r->next->state, &why);
    }
    pelagos__log_entry__free_unpacked(r->next, NULL);
    r->next = NULL;
    if (err && !(r->stop && atomic_load(r->stop))) {
        struct pel_fault at;
        pel_fault_set(&at, err, "entry %zu: %.160s",
                      pel_logfile_place(r->log).entries, why.message);
        return damaged(r, err, &at, fault);
    }
    return err ? stopped(r, fault) : PEL_OK;
}

/* Whether the next entry is to be done on the way to a moment. */
static bool is_due(const struct pel_replay *r, struct pel_replay_moment to)
{
    const Pelagos__LogEntry *e = r->next;
    bool sets_clock = pel_logfile_place(r->log).time_s != e->time;
    return order(moment_of(r->at, e), to) <= 0 &&
           (!sets_clock || r->at.stretch < to.stretch);
}

/* --- states on the way ---------------------------------------------------- */

static int kept_order(const void *a, const void *b)
{
    return order(((const struct kept *)a)->at, ((const struct kept *)b)->at);
}

/* Every second one makes room for those to come. */
static void thin_out(struct pel_replay *r)
{
    qsort(r->kept, r->kept_count, sizeof *r->kept, kept_order);
    size_t left = 0;
    for (size_t i = 0; i < r->kept_count; i++) {
        if (i % 2 == 0) {
            r->kept[left++] = r->kept[i];
        } else {
            pel_still_finish(&r->kept[i].still);
        }
    }
    r->kept_count = left;
    r->keep_after_ns *= 2;
}

static void keep(struct pel_replay *r)
{
    int64_t now_ns = pel_now_ns();
    if (now_ns - r->kept_ns < r->keep_after_ns) {
        return;
    }
    r->kept_ns = now_ns;
    if (r->kept_count == PEL_REPLAY_STILLS) {
        thin_out(r);
    }
    struct kept *k = &r->kept[r->kept_count++];
    k->at = r->at;
    k->segment = r->segment;
    k->place = pel_logfile_place(r->log);
    pel_still_take(r->scene, &k->still);
}

static enum pel_err go_on_from(struct pel_replay *r, const struct kept *k,
                               struct pel_fault *fault)
{
    if (!r->log || r->segment != k->segment) {
        enum pel_err err = load(r, k->segment, fault);
        if (err) {
            return err;
        }
    }
    if (r->next) {
        pelagos__log_entry__free_unpacked(r->next, NULL);
        r->next = NULL;
    }
    pel_logfile_go(r->log, k->place);
    r->at = k->at;
    struct pel_still still = pel_still_copy(&k->still);
    pel_scene_show_still(r->scene, &still);
    return PEL_OK;
}

/* The nearest state before the moment: where it is, one on the way, or a
 * segment's head. */
static enum pel_err begin_before(struct pel_replay *r,
                                 struct pel_replay_moment to,
                                 struct pel_fault *fault)
{
    const struct kept *from = NULL;
    struct pel_replay_moment best = { 0, -INFINITY };
    size_t head = 0;
    bool here = r->log && order(r->at, to) <= 0;
    for (size_t i = 0; i < r->recording.count; i++) {
        if (order(r->places[i].at, to) <= 0) {
            head = i;
            best = r->places[i].at;
        }
    }
    for (size_t i = 0; i < r->kept_count; i++) {
        if (order(r->kept[i].at, to) <= 0 && order(r->kept[i].at, best) > 0) {
            from = &r->kept[i];
            best = from->at;
        }
    }
    if (here && order(r->at, best) >= 0) {
        return PEL_OK;
    }
    r->kept_ns = pel_now_ns();
    return from ? go_on_from(r, from, fault) : begin_at(r, head, fault);
}

enum pel_err pel_replay_go(struct pel_replay *r, struct pel_replay_moment to,
                           struct pel_fault *fault)
{
    if (order(to, end_of(r)) > 0) {
        to = end_of(r);
    }
    enum pel_err err = begin_before(r, to, fault);
    double from_s = pel_replay_position(r, r->at);
    double whole_s = pel_replay_position(r, to) - from_s;
    for (size_t n = 1; !err; n++) {
        err = read_next(r, fault);
        bool more = !err && !r->next && r->segment + 1 < r->recording.count &&
                    order(r->places[r->segment + 1].at, to) <= 0;
        if (more) {
            err = step_to(r, r->places[r->segment + 1].at.time_s, fault);
            err = err ? err : begin_at(r, r->segment + 1, fault);
            continue;
        }
        if (err || !r->next || !is_due(r, to)) {
            break;
        }
        err = do_next(r, fault);
        if (!err && n % LOOK_EVERY == 0) {
            tell(r, (pel_replay_position(r, r->at) - from_s) /
                        fmax(whole_s, 1e-9));
            err = stopped(r, fault);
        }
        if (!err) {
            keep(r);
        }
    }
    if (!err && r->at.stretch == to.stretch) {
        err = step_to(r, to.time_s, fault);
    }
    tell(r, 1);
    return err;
}

struct pel_replay_moment pel_replay_at(const struct pel_replay *r)
{
    return r->at;
}

void pel_replay_still(struct pel_replay *r, struct pel_still *out)
{
    pel_still_take(r->scene, out);
}

const struct pel_recording *pel_replay_recording(const struct pel_replay *r)
{
    return &r->recording;
}

size_t pel_replay_commands(const struct pel_replay *r)
{
    return r->commands;
}

/* --- life ----------------------------------------------------------------- */

enum pel_err pel_replay_open(const struct pel_replay_options *o,
                             struct pel_replay **out, struct pel_fault *fault)
{
    struct pel_replay *r = g_new0(struct pel_replay, 1);
    struct pel_scene_options scene = o->scene;
    *out = NULL;
    r->directory = g_strdup(o->directory);
    r->stop = o->stop;
    r->part = o->part;
    r->keep_after_ns = KEEP_AFTER_NS;
    r->stretches = g_array_new(FALSE, FALSE, sizeof(struct stretch));
    enum pel_err err =
        pel_recording_find(o->directory, o->name, &r->recording, fault);
    if (!err) {
        r->places = g_new0(struct place, r->recording.count);
        err = read_all(r, fault);
    }
    if (!err) {
        scene.apart = true;
        scene.state_path = NULL;
        scene.wave_count = (int)r->recording.segments[0].waves;
        err = pel_scene_create(&scene, &r->scene, fault);
    }
    if (!err) {
        err = begin_at(r, 0, fault);
    }
    if (err) {
        pel_replay_close(r);
        return err;
    }
    *out = r;
    return PEL_OK;
}

void pel_replay_close(struct pel_replay *r)
{
    if (!r) {
        return;
    }
    drop_segment(r);
    for (size_t i = 0; i < r->kept_count; i++) {
        pel_still_finish(&r->kept[i].still);
    }
    (void)pel_scene_destroy(r->scene);
    pel_recording_finish(&r->recording);
    g_array_free(r->stretches, TRUE);
    g_free(r->places);
    g_free(r->directory);
    g_free(r);
}
