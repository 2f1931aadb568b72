#include "bridges/cigi.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/metrics.h"
#include "bridges/cigi_metrics.h"
#include "bridges/cigi_parts.h"
#include "bridges/cigi_sensor.h"
#include "bridges/cigi_shapes.h"
#include "scene/simclock.h"

struct pel_cigi_options pel_cigi_default_options(void)
{
    return (struct pel_cigi_options){
        .listen = "127.0.0.1:8000",
        .rate_hz = 60,
        .silence_s = 2,
    };
}

/* --- answers ------------------------------------------------------------- */

static void answer(struct pel_cigi *cigi,
                   const struct pel_cigi_packet *const *questions, size_t count)
{
    if (count == 0) {
        return;
    }
    struct pel_cigi_moment moment = {
        .snapshot = pel_scene_snapshot(cigi->scene),
        .world = &cigi->world,
        .time_s = pel_scene_time(cigi->scene),
        .host_frame = cigi->host_frame,
    };
    pel_cigi_answers_ask(cigi->answers, &moment, questions, count);
    pel_snapshot_unref(moment.snapshot);
}

static void answer_periodic(struct pel_cigi *cigi)
{
    const struct pel_cigi_packet *due[PEL_CIGI_MAX_PERIODIC];
    answer(cigi, due,
           pel_cigi_periodic_due(&cigi->periodic, cigi->ig_frame, due));
}

/* --- the host's session -------------------------------------------------- */

static void begin_session(struct pel_cigi *cigi)
{
    pel_cigi_periodic_clear(&cigi->periodic);
    pel_cigi_world_init(&cigi->world);
    cigi->led = cigi->lead_pending = true;
    cigi->exercise =
        (struct pel_cigi_exercise){ .all = cigi->options.exercises };
    const struct pel_snapshot *s = pel_scene_snapshot(cigi->scene);
    if (s->mode != PEL_CLOCK_HOST) {
        cigi->mode_before = s->mode;
    }
    pel_snapshot_unref(s);
    pel_scene_set_stale(cigi->scene, PEL_STALE_CIGI, false);
    pel_cigi_answers_clear(cigi->answers);
    cigi->wanted_database = 0;
    cigi->period_s = 1 / cigi->options.rate_hz;
    cigi->host_time_s = cigi->seen_s = pel_scene_time(cigi->scene);
}

static void load_database(struct pel_cigi *cigi, int wanted)
{
    bool ours = cigi->options.database == 0 || wanted == cigi->options.database;
    if (wanted > 0 && wanted != cigi->wanted_database) {
        cigi->database = ours ? -wanted : -128;
        cigi->database_state = ours ? DATABASE_LOADING : DATABASE_NONE;
        cigi->database_ns = cigi->heard_ns;
        static struct pel_log_limit limit;
        pel_log_limited(&limit, ours ? PEL_LOG_INFO : PEL_LOG_WARNING,
                        "CIG-004", "the CIGI host asks for database %d%s",
                        wanted, ours ? "" : ", which is not here");
    } else if (cigi->database_state == DATABASE_LOADING &&
               (wanted == 0 || cigi->heard_ns - cigi->database_ns > LOAD_NS)) {
        cigi->database = -cigi->database;
        cigi->database_state = DATABASE_LOADED;
    }
    cigi->wanted_database = wanted;
}

/* Whether this frame is to be applied: newer than all before, or of a host
 * that began anew. */
static bool in_order(struct pel_cigi *cigi, uint32_t frame, int64_t now_ns)
{
    int32_t ahead = (int32_t)(frame - cigi->host_frame);
    int64_t silence_ns = now_ns - cigi->heard_ns;
    if (!cigi->led) {
        return true;
    }
    if (ahead <= 0 && (silence_ns > RESTART_NS || ahead <= -RESTART_FRAMES)) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_INFO, "CIG-005",
                        "the CIGI host begins anew at frame %u", frame);
        cigi->led = false;
        return true;
    }
    cigi->counters.duplicate += ahead == 0;
    cigi->counters.late += ahead < 0;
    cigi->counters.lost += ahead > 1 ? (uint64_t)ahead - 1 : 0;
    return ahead > 0;
}

/* Simulated seconds from the last frame applied to this one. */
static double seconds_to(struct pel_cigi *cigi, uint32_t frame, bool stamped,
                         uint32_t timestamp)
{
    double frames = (double)(frame - cigi->host_frame);
    double seconds = frames / cigi->options.rate_hz;
    if (stamped && cigi->stamped) {
        seconds = (double)(timestamp - cigi->timestamp) * TICK_S;
        if (seconds <= MAX_STEP_S && frames > 0) {
            cigi->period_s += 0.1 * (seconds / frames - cigi->period_s);
        }
    }
    return seconds <= MAX_STEP_S ? seconds : 1 / cigi->options.rate_hz;
}

/* Simulated time that the scene goes to; never back. A host without timestamps
 * that held its frames up goes on from where time is by now. */
static double time_of_frame(struct pel_cigi *cigi, double now_s)
{
    double ahead = cigi->host_time_s - now_s;
    bool is_set = ahead < -EXTRAPOLATE_S - 0.5 || ahead > MAX_STEP_S;
    if (is_set || (ahead < 0 && !cigi->stamped)) {
        cigi->host_time_s = now_s;
    }
    return fmin(fmax(cigi->host_time_s, now_s), PEL_MAX_TIME_S);
}

/* Where an exercise was loaded or rewound, simulated time was set back, and the
 * host's goes with it. Returns what it is. */
static double follow_back(struct pel_cigi *cigi)
{
    double now_s = pel_scene_time(cigi->scene);
    cigi->host_time_s -= fmax(cigi->seen_s - now_s, 0);
    cigi->seen_s = now_s;
    return now_s;
}

static void step_to(struct pel_cigi *cigi, double time_s)
{
    struct pel_fault fault;
    double now_s = pel_scene_time(cigi->scene);
    if (time_s > now_s &&
        pel_scene_step_to(cigi->scene, time_s, &fault) != PEL_OK) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_WARNING, "CIG-006",
                        "simulated time could not be advanced: %s",
                        fault.message);
    }
}

static bool host_leads(struct pel_cigi *cigi)
{
    const struct pel_snapshot *s = pel_scene_snapshot(cigi->scene);
    bool leads = s->mode == PEL_CLOCK_HOST;
    pel_snapshot_unref(s);
    return leads;
}

/* --- one datagram -------------------------------------------------------- */

static void refuse_edit(struct pel_cigi *cigi, const char *path,
                        const char *why)
{
    static struct pel_log_limit limit;
    pel_log_limited(&limit, PEL_LOG_WARNING, "CIG-002",
                    "an edit by CIGI was refused: %s %s", path, why);
    cigi->counters.refused_edits++;
}

/* Commits the patch, and has the sea that it asks for built and committed
 * later; false: refused whole, which is told where this is the last word. */
static bool commit(struct pel_cigi *cigi, const Pelagos__Patch *patch,
                   bool last_word)
{
    struct pel_fault fault = { 0 };
    const Pelagos__Patch *rest = patch, *sea = NULL;
    enum pel_err err = PEL_OK;
    if (patch->state->sea || patch->n_remove > 0) {
        err = pel_scene_test(cigi->scene, patch, &fault);
        sea = pel_cigi_edit_split(cigi->edit, &rest);
    }
    if (!err && rest) {
        err = pel_scene_patch(cigi->scene, rest, &fault);
    }
    if (err && last_word) {
        refuse_edit(cigi, fault.path, fault.message);
    }
    if (err) {
        return false;
    }
    if (sea) {
        pel_cigi_sea_ask(cigi->sea, sea);
    }
    cigi->counters.edits++;
    return true;
}

/* The entities that the datagrams brought get their types' models. */
static void give_shapes(struct pel_cigi *cigi,
                        const struct pel_cigi_reader *readers, size_t count)
{
    struct pel_cigi_packet p;
    for (size_t i = 0; cigi->shapes && i < count; i++) {
        struct pel_cigi_reader reader = readers[i];
        while (pel_cigi_next(&reader, &p)) {
            if (p.kind == PEL_CIGI_KIND_ENTITY_CONTROL) {
                pel_cigi_shapes_take(
                    cigi->shapes,
                    (uint32_t)pel_cigi_get(&p, PEL_CIGI_ENTITY_CONTROL_ID),
                    (unsigned)pel_cigi_get(&p, PEL_CIGI_ENTITY_CONTROL_TYPE),
                    pel_cigi_get(&p, PEL_CIGI_ENTITY_CONTROL_STATE) == 2);
            }
        }
    }
    pel_cigi_shapes_commit(cigi->shapes);
}

/* Makes and commits the patch of `count` datagrams; false: refused, and nothing
 * has changed. */
static bool edit(struct pel_cigi *cigi, const struct pel_cigi_reader *readers,
                 size_t count, double time_s, bool lead, bool reset)
{
    struct pel_cigi_world before = cigi->world;
    struct pel_cigi_packet p;
    const struct pel_snapshot *s = pel_scene_snapshot(cigi->scene);
    pel_cigi_edit_begin(cigi->edit, &cigi->world, pel_scene_state(cigi->scene),
                        s, time_s, lead);
    if (reset) {
        pel_cigi_edit_reset(cigi->edit);
    }
    for (size_t i = 0; i < count; i++) {
        struct pel_cigi_reader reader = readers[i];
        while (pel_cigi_next(&reader, &p)) {
            if (p.kind != PEL_CIGI_KIND_COUNT &&
                pel_cigi_packets[p.kind].from_host) {
                pel_cigi_edit_take(cigi->edit, &p);
            }
        }
    }
    const Pelagos__Patch *patch = pel_cigi_edit_end(cigi->edit);
    pel_snapshot_unref(s);
    bool good = !cigi->edit->refused;
    if (!good && count <= 1) {
        refuse_edit(cigi, "", "a bad number, or too many elements");
    } else if (good && patch) {
        good = commit(cigi, patch, count <= 1);
    }
    cigi->counters.skipped_packets += good ? cigi->edit->skipped : 0;
    if (!good) {
        cigi->world = before;
    } else {
        give_shapes(cigi, readers, count);
    }
    return good;
}

/* Clamped entities get their heights of this moment. */
static void find_heights_below(struct pel_cigi *cigi, double time_s)
{
    const struct pel_snapshot *s = pel_scene_snapshot(cigi->scene);
    pel_cigi_sea_find_heights(cigi->sea, s, time_s);
    pel_snapshot_unref(s);
}

static void on_sea_refused(void *user, const struct pel_fault *fault)
{
    struct pel_cigi *cigi = user;
    refuse_edit(cigi, fault->path, fault->message);
    cigi->refused = true;
}

static void on_sea_known(void *user)
{
    struct pel_cigi *cigi = user;
    if (cigi->led) {
        edit(cigi, NULL, 0, pel_scene_time(cigi->scene), false, false);
    }
}

static void ask(struct pel_cigi *cigi, struct pel_cigi_reader reader)
{
    static struct pel_cigi_packet questions[PEL_CIGI_MAX_QUESTIONS];
    static const struct pel_cigi_packet *list[PEL_CIGI_MAX_QUESTIONS];
    size_t count = 0;
    struct pel_cigi_packet p;
    while (pel_cigi_next(&reader, &p)) {
        if (!pel_cigi_is_question(p.kind)) {
            continue;
        }
        enum pel_cigi_turn turn =
            pel_cigi_periodic_take(&cigi->periodic, &p, cigi->ig_frame);
        cigi->counters.skipped_packets += turn == PEL_CIGI_NEVER;
        if (turn != PEL_CIGI_NOW) {
            continue;
        }
        if (count == PEL_CIGI_MAX_QUESTIONS) {
            pel_cigi_answers_lose(cigi->answers, 1);
            continue;
        }
        questions[count] = p;
        list[count] = &questions[count];
        count++;
    }
    answer(cigi, list, count);
}

/* What a datagram says of exercises, after its edit: a load replaces it. */
static void lead_exercises(struct pel_cigi *cigi, struct pel_cigi_reader reader)
{
    struct pel_cigi_packet p;
    struct pel_cigi_component c;
    struct pel_fault fault = { 0 };
    while (pel_cigi_next(&reader, &p)) {
        if (p.kind != PEL_CIGI_KIND_COMPONENT &&
            p.kind != PEL_CIGI_KIND_SHORT_COMPONENT) {
            continue;
        }
        pel_cigi_read_component(&p, &c);
        enum pel_err err = pel_cigi_exercise_take(&cigi->exercise, &c, &fault);
        if (err == PEL_ERR_NOT_FOUND) {
            cigi->counters.skipped_packets++;
        } else if (err) {
            refuse_edit(cigi, fault.path, fault.message);
            cigi->refused = true;
        }
    }
}

static void count_packets(struct pel_cigi *cigi, struct pel_cigi_reader reader)
{
    struct pel_cigi_packet p;
    while (pel_cigi_next(&reader, &p)) {
        if (p.kind == PEL_CIGI_KIND_COUNT) {
            cigi->counters.unknown_packets++;
        } else {
            cigi->counters.packets[p.kind]++;
        }
    }
}

/* True: the host has entered Reset/Standby. */
static bool set_mode(struct pel_cigi *cigi, unsigned mode)
{
    bool reset = mode == 0 && cigi->mode != 0;
    if (reset) {
        pel_cigi_periodic_clear(&cigi->periodic);
        cigi->database = cigi->wanted_database = 0;
        cigi->database_state = DATABASE_NONE;
    }
    cigi->mode = mode;
    return reset;
}

/* Datagrams that were waiting together become one edit, at the time that the
 * newest leads to; where that is refused, each is tried alone. */
void pel_cigi_apply(struct pel_cigi *cigi)
{
    const struct pel_cigi_reader *readers = cigi->batch;
    size_t count = cigi->batch_count;
    if (count == 0) {
        return;
    }
    /* Poses are those of the time that the frame leads to. */
    double now_s = follow_back(cigi);
    bool leads = host_leads(cigi) && !cigi->batch_first;
    double time_s = leads ? time_of_frame(cigi, now_s) : now_s;
    bool good[BATCH];
    if (leads) {
        step_to(cigi, time_s); /* the edit is one of that moment */
    }
    bool all = edit(cigi, readers, count, time_s, cigi->lead_pending,
                    cigi->batch_reset);
    cigi->refused = !all;
    for (size_t i = 0; i < count; i++) {
        good[i] = all || (count > 1 && edit(cigi, &readers[i], 1, time_s,
                                            cigi->lead_pending, false));
        cigi->lead_pending = cigi->lead_pending && !good[i];
    }
    if (!leads) {
        cigi->host_time_s = pel_scene_time(cigi->scene);
    }
    cigi->applied_s = cigi->seen_s = pel_scene_time(cigi->scene);
    cigi->batch_count = cigi->in_used = 0;
    cigi->batch_first = cigi->batch_reset = false;
    if (good[count - 1]) {
        pel_scene_set_host_frame(cigi->scene, cigi->host_frame);
    }
    for (size_t i = 0; i < count; i++) {
        if (good[i]) {
            lead_exercises(cigi, readers[i]);
            ask(cigi, readers[i]);
        }
    }
    find_heights_below(cigi, cigi->applied_s);
}

/* Puts a datagram to those that become the next edit. False: not applied, as it
 * is not new. */
static bool take(struct pel_cigi *cigi, const struct pel_cigi_packet *control,
                 struct pel_cigi_reader reader, int64_t now_ns)
{
    uint32_t frame = (uint32_t)pel_cigi_get(control, PEL_CIGI_IG_CONTROL_FRAME);
    uint32_t timestamp =
        (uint32_t)pel_cigi_get(control, PEL_CIGI_IG_CONTROL_TIMESTAMP);
    bool stamped = pel_cigi_get(control, PEL_CIGI_IG_CONTROL_STAMPED) != 0;
    unsigned mode = (unsigned)pel_cigi_get(control, PEL_CIGI_IG_CONTROL_MODE);
    if (!in_order(cigi, frame, now_ns)) {
        return false;
    }
    bool first = !cigi->led;
    if (first || mode != cigi->mode) {
        pel_cigi_apply(
            cigi); /* what came before is of another session or mode */
    }
    if (first) {
        begin_session(cigi);
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_INFO, "CIG-003",
                        "a CIGI host leads from frame %u on, by %s", frame,
                        stamped ? "timestamps" : "frames");
    } else {
        cigi->host_time_s += seconds_to(cigi, frame, stamped, timestamp);
    }
    cigi->heard_ns = now_ns;
    cigi->told_ns = 0;
    cigi->host_frame = frame;
    cigi->timestamp = timestamp;
    cigi->stamped = stamped;
    cigi->on_the_way =
        cigi->ig_frame -
        (uint32_t)pel_cigi_get(control, PEL_CIGI_IG_CONTROL_LAST_IG_FRAME);
    cigi->little = reader.little;
    cigi->minor = (unsigned)pel_cigi_get(control, PEL_CIGI_IG_CONTROL_MINOR);
    bool reset = set_mode(cigi, mode);
    load_database(cigi,
                  (int)pel_cigi_get(control, PEL_CIGI_IG_CONTROL_DATABASE));
    count_packets(cigi, reader);
    cigi->batch[cigi->batch_count++] = reader;
    cigi->batch_first = first;
    cigi->batch_reset = reset;
    if (first || reset) {
        pel_cigi_apply(cigi);
    }
    return true;
}

/* Says once for each what a host of another version has to change. */
static void tell_version(struct pel_cigi *cigi, const uint8_t *bytes,
                         size_t size)
{
    unsigned major, minor;
    if (!pel_cigi_foreign(bytes, size, &major, &minor) ||
        (cigi->told_versions & 1u << major)) {
        return;
    }
    cigi->told_versions |= 1u << major;
    pel_warn("CIG-012",
             "datagrams of CIGI %u.%u are dropped: this is CIGI 3.3 (3.2 "
             "too). Set the host to version 3, minor version 3, whose IG "
             "Control is packet 1 of 24 bytes",
             major, minor);
}

bool pel_cigi_take(struct pel_cigi *cigi, const uint8_t *bytes, size_t size)
{
    struct pel_cigi_reader reader;
    struct pel_cigi_packet control;
    int64_t now_ns = pel_now_ns();
    cigi->counters.datagrams++;
    enum pel_cigi_error error =
        pel_cigi_open(bytes, size, PEL_CIGI_KIND_IG_CONTROL, &reader);
    if (error) {
        static struct pel_log_limit limit;
        tell_version(cigi, bytes, size);
        pel_log_limited(&limit, PEL_LOG_DEBUG, "CIG-007",
                        "datagram dropped, %s, %zu bytes",
                        pel_cigi_error_name(error), size);
        cigi->counters.malformed[error]++;
        return false;
    }
    struct pel_cigi_reader head = reader;
    return pel_cigi_next(&head, &control) &&
           take(cigi, &control, reader, now_ns);
}

void pel_cigi_feed(struct pel_cigi *cigi, const uint8_t *bytes, size_t size)
{
    pel_cigi_add(cigi, bytes, size);
    pel_cigi_apply(cigi);
}

void pel_cigi_add(struct pel_cigi *cigi, const uint8_t *bytes, size_t size)
{
    if (cigi->batch_count == BATCH) {
        pel_cigi_apply(cigi);
    }
    pel_cigi_take(cigi, bytes, size);
}

void pel_cigi_settle(struct pel_cigi *cigi)
{
    pel_cigi_sea_settle(cigi->sea);
}

/* --- one frame ----------------------------------------------------------- */

/* The host is late: time goes on by itself, two of its frames behind. */
static void extrapolate(struct pel_cigi *cigi, int64_t now_ns)
{
    double silence_s = (double)(now_ns - cigi->heard_ns) * 1e-9;
    double ahead_s = fmin(silence_s - 2 * cigi->period_s, EXTRAPOLATE_S);
    if (!cigi->led || ahead_s <= 0 || silence_s > EXTRAPOLATE_S + 1 ||
        !host_leads(cigi)) {
        return;
    }
    cigi->counters.extrapolated++;
    (void)follow_back(cigi);
    step_to(cigi, cigi->host_time_s + ahead_s);
    cigi->seen_s = pel_scene_time(cigi->scene);
}

/* Time is given back, and what the host left moving stands. */
static void resume(struct pel_cigi *cigi)
{
    struct pel_fault fault;
    Pelagos__Patch *patch = pel_cigi_world_end(
        &cigi->world, pel_scene_state(cigi->scene), cigi->mode_before);
    if (pel_scene_patch(cigi->scene, patch, &fault) != PEL_OK) {
        pel_warn("CIG-010", "clock.mode could not be set back: %s",
                 fault.message);
    }
    pelagos__patch__free_unpacked(patch, NULL);
}

/* A host may wait for a frame of ours before it goes on: while this thread was
 * held up, nobody was silent. */
static bool is_heard(const struct pel_cigi *cigi, int64_t now_ns)
{
    return cigi->told_ns == 0 ||
           (double)(now_ns - cigi->told_ns) * 1e-9 <= cigi->options.silence_s;
}

static void watch_host(struct pel_cigi *cigi, int64_t now_ns)
{
    if (!cigi->led || is_heard(cigi, now_ns)) {
        return;
    }
    pel_warn("CIG-008", "the CIGI host is silent since frame %u; time %s",
             cigi->host_frame, cigi->options.hold ? "stands" : "goes on");
    cigi->led = false;
    pel_cigi_periodic_clear(&cigi->periodic);
    if (!cigi->host_target) {
        cigi->host_size = 0;
    }
    pel_scene_set_host_frame(cigi->scene, 0);
    if (!cigi->options.hold && host_leads(cigi)) {
        resume(cigi);
    }
    pel_scene_set_stale(cigi->scene, PEL_STALE_CIGI, true);
}

struct letter {
    struct pel_cigi *cigi;
    size_t used;
};

static bool put_one(void *user, const struct pel_cigi_packet *answer)
{
    struct letter *l = user;
    size_t more = pel_cigi_put(answer, l->cigi->little, l->cigi->out + l->used,
                               MAX_ANSWER - l->used);
    l->used += more;
    return more > 0;
}

/* Where trackers stand belongs to this frame alone: first, as there is room. */
static size_t put_sensors(struct pel_cigi *cigi, size_t used)
{
    struct letter letter = { cigi, used };
    if (cigi->led) {
        const struct pel_snapshot *s = pel_scene_snapshot(cigi->scene);
        pel_cigi_sensor_answers(&cigi->world, s, pel_scene_time(cigi->scene),
                                cigi->host_frame, put_one, &letter);
        pel_snapshot_unref(s);
    }
    return letter.used;
}

size_t pel_cigi_frame(struct pel_cigi *cigi, const uint8_t **bytes)
{
    int64_t now_ns = pel_now_ns();
    watch_host(cigi, now_ns);
    cigi->told_ns = cigi->told_ns == 0 ? now_ns : cigi->told_ns;
    extrapolate(cigi, now_ns);
    cigi->ig_frame++;
    pel_cigi_answers_begin(cigi->answers, !cigi->unsent);
    cigi->unsent = false;
    answer_periodic(cigi);
    struct pel_cigi_packet p = pel_cigi_packet_of(PEL_CIGI_KIND_START_OF_FRAME);
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_MAJOR, 3);
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_MINOR, cigi->minor);
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_DATABASE, cigi->database);
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_MODE, cigi->mode);
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_STATUS, cigi->refused);
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_STAMPED, 1);
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_MAGIC, 0x8000);
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_FRAME, cigi->ig_frame);
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_TIMESTAMP,
                 (uint32_t)((now_ns - cigi->opened_ns) / 10000));
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_LAST_HOST_FRAME, cigi->host_frame);
    size_t used = pel_cigi_put(&p, cigi->little, cigi->out, MAX_ANSWER);
    used = put_sensors(cigi, used);
    const struct pel_cigi_packet *next;
    while ((next = pel_cigi_answers_peek(cigi->answers))) {
        size_t more = pel_cigi_put(next, cigi->little, cigi->out + used,
                                   MAX_ANSWER - used);
        if (more == 0) {
            break;
        }
        used += more;
        pel_cigi_answers_pop(cigi->answers);
    }
    cigi->counters.answers = pel_cigi_answers_made(cigi->answers);
    cigi->counters.dropped_answers = pel_cigi_answers_dropped(cigi->answers);
    cigi->counters.told_dropped += pel_cigi_answers_tell(cigi->answers, now_ns);
    cigi->counters.frames++;
    *bytes = cigi->out;
    return used;
}

/* --- metrics ------------------------------------------------------------- */

static void collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_cigi *cigi = user;
    struct pel_cigi_status s;
    pel_cigi_collect_counters(&cigi->counters, page);
    if (cigi->shapes) {
        pel_metric(
            page, "pelagos_cigi_unknown_types_total", PEL_METRIC_COUNTER,
            "Entities of a CIGI type that --cigi-entities does not name.", NULL,
            (double)pel_cigi_shapes_counters(cigi->shapes).unknown);
    }
    pel_cigi_status(cigi, &s);
    pel_metric(page, "pelagos_cigi_connected", PEL_METRIC_GAUGE,
               "1 while a CIGI host was heard within 2 s.", NULL, s.connected);
    pel_metric(page, "pelagos_cigi_host_age_seconds", PEL_METRIC_GAUGE,
               "Time since the CIGI host was heard; -1: never.", NULL, s.age_s);
    pel_metric(page, "pelagos_cigi_host_frame", PEL_METRIC_GAUGE,
               "Newest host frame applied.", NULL, s.host_frame);
    pel_metric(page, "pelagos_cigi_host_time_seconds", PEL_METRIC_GAUGE,
               "Simulated time that the newest host frame led to.", NULL,
               cigi->applied_s);
    pel_metric(page, "pelagos_cigi_frames_on_the_way", PEL_METRIC_GAUGE,
               "Frames of ours that the host had not heard of when it sent.",
               NULL, (double)cigi->on_the_way);
    pel_metric(page, "pelagos_cigi_sensors_on", PEL_METRIC_GAUGE,
               "Sensors that the CIGI host switched on.", NULL,
               pel_cigi_sensors_on(&cigi->world));
}

/* --- life ---------------------------------------------------------------- */

enum pel_err pel_cigi_create(const struct pel_cigi_options *options,
                             struct pel_scene *scene, struct pel_cigi **out,
                             struct pel_fault *fault)
{
    if (options->database < 0 || options->database > 127) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "cigi-database: %d is not in 0..127",
                             options->database);
    }
    if (!(options->rate_hz >= 1 && options->rate_hz <= 240)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "cigi-rate: %g is not in 1..240 Hz",
                             options->rate_hz);
    }
    if (!(options->silence_s >= 0.5 && options->silence_s <= 3600)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "cigi-silence: %g is not in 0.5..3600 s",
                             options->silence_s);
    }
    struct pel_cigi *cigi = g_new0(struct pel_cigi, 1);
    cigi->options = *options;
    cigi->scene = scene;
    cigi->fd = cigi->timer_fd = -1;
    cigi->minor = 3;
    cigi->opened_ns = pel_now_ns();
    cigi->edit = g_new0(struct pel_cigi_edit, 1);
    cigi->answers = pel_cigi_answers_create(options->listen != NULL);
    pel_cigi_world_init(&cigi->world);
    const struct pel_cigi_sea_calls calls = { on_sea_refused, on_sea_known,
                                              cigi };
    cigi->sea = pel_cigi_sea_create(scene, &cigi->world, &calls);
    enum pel_err err = pel_allow_parse(options->allow, &cigi->allow, fault);
    if (!err && options->entities) {
        err = pel_cigi_shapes_create(options->entities, scene, &cigi->shapes,
                                     fault);
    }
    if (!err && options->listen) {
        err = pel_cigi_open_sockets(cigi, fault);
    }
    if (err) {
        pel_cigi_destroy(cigi);
        return err;
    }
    if (options->metrics) {
        pel_metrics_add(options->metrics, collect, cigi);
        cigi->shown = true;
    }
    *out = cigi;
    return PEL_OK;
}

void pel_cigi_destroy(struct pel_cigi *cigi)
{
    if (!cigi) {
        return;
    }
    /* Who starts again with this state has no host yet. */
    if (cigi->heard_ns != 0 && host_leads(cigi)) {
        resume(cigi);
    }
    if (cigi->shown) {
        pel_metrics_remove(cigi->options.metrics, collect, cigi);
    }
    pel_cigi_close_sockets(cigi);
    pel_cigi_shapes_destroy(cigi->shapes);
    pel_cigi_sea_destroy(cigi->sea);
    g_free(cigi->edit);
    pel_cigi_answers_destroy(cigi->answers);
    g_free(cigi);
}

void pel_cigi_not_sent(struct pel_cigi *cigi)
{
    cigi->unsent = true;
    cigi->counters.unsent++;
}

const struct pel_cigi_counters *pel_cigi_counters(const struct pel_cigi *cigi)
{
    return &cigi->counters;
}

void pel_cigi_status(const struct pel_cigi *cigi,
                     struct pel_cigi_status *status)
{
    *status = (struct pel_cigi_status){
        .connected = cigi->led && is_heard(cigi, pel_now_ns()),
        .host_frame = cigi->host_frame,
        .ig_frame = cigi->ig_frame,
        .database = cigi->database,
        .age_s = cigi->heard_ns ? (double)(pel_now_ns() - cigi->heard_ns) * 1e-9
                                : -1,
    };
}

uint16_t pel_cigi_port(const struct pel_cigi *cigi)
{
    return cigi->port;
}
