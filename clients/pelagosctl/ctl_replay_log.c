/* replay of a command log: the recorded commands on a stepped clock, and the
 * frames they give. */
#include "pelagosctl/ctl.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <time.h>

#include <glib.h>
#include <glib/gstdio.h>

#include "base/clock.h"
#include "base/err.h"
#include "pelagosctl/log_run.h"
#include "pelog.h"

#define MAX_TIMES 10000
#define MOST_AT_ONCE_S 5.0
#define PACE_S 0.04 /* between two steps of the clock while waiting */

struct play {
    struct ctl *ctl;
    const char *name; /* of the segment that is read */
    struct pel_log_reader reader;
    double time_s;           /* simulated, of the daemon */
    double every_s;          /* 0: no frames in a row */
    size_t next;             /* of the row: every_s * next */
    double times[MAX_TIMES]; /* rising */
    bool drawn[MAX_TIMES];
    size_t time_count, time_next;
    const char *folder, *view;
    bool begun;
    bool sails;   /* a ship moves by itself: no long steps */
    double speed; /* 0: as fast as it goes */
    int64_t start_ns;
    double start_s;
    size_t commands, frames;
};

/* --- what is asked of the daemon ------------------------------------------ */

static enum ctl_exit go_to(struct play *play, double time_s)
{
    struct pel_client_error error;
    while (play->sails && time_s - play->time_s > MOST_AT_ONCE_S) {
        double next_s = play->time_s + MOST_AT_ONCE_S;
        if (pel_client_step_to(play->ctl->client, next_s, NULL, &error)) {
            return ctl_report(play->ctl, &error);
        }
        play->time_s = next_s;
    }
    if (pel_client_step_to(play->ctl->client, time_s, NULL, &error)) {
        return ctl_report(play->ctl, &error);
    }
    play->time_s = time_s;
    return CTL_DONE;
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

static bool sails(const Pelagos__State *state)
{
    bool on = state->own_ship && state->own_ship->on;
    for (size_t i = 0; i < state->n_entities && !on; i++) {
        on = state->entities[i]->helm && state->entities[i]->helm->on;
    }
    return on;
}

/* The recorded patch, but the clock stays in our hands, and what the weather
 * did is in the log. */
static enum ctl_exit send_patch(struct play *play, Pelagos__Patch *patch)
{
    Pelagos__State own_state = PELAGOS__STATE__INIT;
    Pelagos__Clock own_clock = PELAGOS__CLOCK__INIT;
    Pelagos__State *state = patch->state;
    Pelagos__Clock *clock = state ? state->clock : NULL;
    if (state && state->sea && state->sea->field) {
        state->sea->field->has_leads = 1;
        state->sea->field->leads = 0;
    }
    if (clock || removes_clock(patch)) {
        patch->state = state ? state : &own_state;
        patch->state->clock = clock ? clock : &own_clock;
        patch->state->clock->has_mode = 1;
        patch->state->clock->mode = PELAGOS__CLOCK_MODE__STEPPED;
    }
    Pelagos__State *now = NULL;
    enum ctl_exit status = ctl_patch(play->ctl, patch, &now);
    if (status != CTL_DONE) {
        ctl_print(stderr, "  entry %zu of %s\n", play->reader.entries,
                  play->name);
    } else {
        play->time_s = now->clock->time;
        play->sails = sails(now);
        pelagos__state__free_unpacked(now, NULL);
    }
    if (state && !clock) {
        state->clock = NULL;
    }
    patch->state = state;
    return status;
}

/* Takes every helm away, so that the ships' steps begin anew with the next
 * patch, as they did when the head was written. */
static enum ctl_exit leave_helms(struct play *play)
{
    g_autoptr(GPtrArray) paths = g_ptr_array_new_with_free_func(g_free);
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State *now = NULL;
    struct pel_client_error error;
    if (pel_client_get(play->ctl->client, &now, &error)) {
        return ctl_report(play->ctl, &error);
    }
    g_ptr_array_add(paths, g_strdup("own_ship"));
    for (size_t i = 0; i < now->n_entities; i++) {
        if (now->entities[i]->helm) {
            g_ptr_array_add(paths, g_strdup_printf("entities.%u.helm",
                                                   now->entities[i]->id));
        }
    }
    pelagos__state__free_unpacked(now, NULL);
    patch.n_remove = paths->len;
    patch.remove = (char **)paths->pdata;
    return send_patch(play, &patch);
}

/* Everything as a whole state of the log says, whatever the daemon showed
 * before. */
static enum ctl_exit begin(struct play *play, Pelagos__State *state)
{
    char *parts[16];
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    enum ctl_exit status = leave_helms(play);
    if (status != CTL_DONE) {
        return status;
    }
    patch.n_remove = 0;
    patch.remove = parts;
    patch.state = state;
    state->has_revision = 0;
    const ProtobufCMessageDescriptor *type = &pelagos__state__descriptor;
    for (unsigned i = 0; i < type->n_fields && i < G_N_ELEMENTS(parts); i++) {
        if (type->fields[i].type == PROTOBUF_C_TYPE_MESSAGE) {
            parts[patch.n_remove++] = (char *)type->fields[i].name;
        }
    }
    return send_patch(play, &patch);
}

/* --- frames --------------------------------------------------------------- */

static enum ctl_exit save_frame(struct play *play, double time_s)
{
    Pelagos__FrameRequest request = PELAGOS__FRAME_REQUEST__INIT;
    Pelagos__Frame *frame = NULL;
    struct pel_client_error error;
    g_autoptr(GError) failure = NULL;
    request.view = (char *)play->view;
    request.has_format = request.has_time = 1;
    request.format = PELAGOS__FRAME_FORMAT__PNG;
    request.time = time_s;
    if (pel_client_frame(play->ctl->client, &request, &frame, &error)) {
        return ctl_report(play->ctl, &error);
    }
    g_autofree char *path = g_strdup_printf(
        "%s/%05zu-%s-%.3f.png", play->folder, play->frames, play->view, time_s);
    bool saved = g_file_set_contents(path, (const char *)frame->data.data,
                                     (gssize)frame->data.len, &failure);
    pelagos__frame__free_unpacked(frame, NULL);
    play->frames++;
    return saved ? CTL_DONE : ctl_say(CTL_FAILED, "%s", failure->message);
}

/* The next moment before `end_s` of which a frame is wanted; INFINITY. */
static double next_frame(struct play *play, double end_s)
{
    if (play->every_s > 0) {
        double from = ceil(play->time_s / play->every_s);
        play->next = MAX(play->next, (size_t)fmax(from, 0));
        double at = play->every_s * (double)play->next;
        return at < end_s ? at : INFINITY;
    }
    while (play->time_next < play->time_count) {
        double at = play->times[play->time_next];
        if (at >= play->time_s && !play->drawn[play->time_next]) {
            return at < end_s ? at : INFINITY;
        }
        play->time_next++;
    }
    return INFINITY;
}

static enum ctl_exit pace(struct play *play, double time_s)
{
    while (play->speed > 0 && !ctl_interrupted) {
        double spent_s = (double)(pel_now_ns() - play->start_ns) * 1e-9;
        double now_s = play->start_s + spent_s * play->speed;
        if (now_s >= time_s) {
            break;
        }
        if (now_s > play->time_s) {
            enum ctl_exit status = go_to(play, now_s);
            if (status != CTL_DONE) {
                return status;
            }
        }
        double wait_s = fmin(PACE_S, (time_s - now_s) / play->speed);
        g_usleep((gulong)(wait_s * 1e6) + 1);
    }
    return ctl_interrupted ? CTL_FAILED : CTL_DONE;
}

/* Frames of moments before end_s: a frame of time T shows every command that
 * was recorded up to and at T. */
static enum ctl_exit draw(struct play *play, double end_s)
{
    double at;
    while (play->folder && isfinite(at = next_frame(play, end_s))) {
        enum ctl_exit status = pace(play, at);
        if (status == CTL_DONE && at > play->time_s) {
            status = go_to(play, at);
        }
        if (status == CTL_DONE) {
            status = save_frame(play, at);
        }
        if (status != CTL_DONE) {
            return status;
        }
        if (play->every_s > 0) {
            play->next++;
        } else {
            play->drawn[play->time_next++] = true;
        }
    }
    return CTL_DONE;
}

static enum ctl_exit advance(struct play *play, double end_s)
{
    enum ctl_exit status = draw(play, end_s);
    if (status == CTL_DONE) {
        status = pace(play, end_s);
    }
    return status == CTL_DONE ? go_to(play, end_s) : status;
}

/* --- the log -------------------------------------------------------------- */

static void time_was_set(struct play *play)
{
    play->next = play->time_next = 0;
    play->start_ns = pel_now_ns();
    play->start_s = play->time_s;
}

/* A further segment's state, or one on the way, is the one that the log has led
 * to: it is set all the same, as own ship's steps begin anew with it. */
static enum ctl_exit take_state(struct play *play, double time_s,
                                Pelagos__State *state)
{
    enum ctl_exit status = CTL_DONE;
    if (play->begun && time_s > play->time_s) {
        status = advance(play, time_s);
    }
    bool back = play->begun && time_s < play->time_s;
    if (status == CTL_DONE) {
        status = begin(play, state);
    }
    if (back) {
        time_was_set(play);
    }
    if (!play->begun) {
        play->start_ns = pel_now_ns();
        play->start_s = play->time_s;
        play->begun = true;
    }
    return status;
}

static void say_head(const struct play *play, const Pelagos__LogHead *head)
{
    if (!play->begun && !ctl_flag(play->ctl, "quiet")) {
        ctl_print(stderr, "recorded %s by %s on %s, --waves %u\n",
                  head->began ? head->began : "", head->program,
                  head->device ? head->device : "", head->waves);
    }
}

static void say_missed(const struct play *play, const Pelagos__LogEntry *entry)
{
    if (entry->missed > 0 && !ctl_flag(play->ctl, "quiet")) {
        ctl_print(
            stderr,
            "%s lacks the commands of %llu frames before %.3f s, and goes "
            "on with the whole state\n",
            play->name, (unsigned long long)entry->missed, entry->time);
    }
}

static enum ctl_exit take(struct play *play, Pelagos__LogEntry *entry)
{
    enum ctl_exit status = CTL_DONE;
    switch (entry->command_case) {
    case PELAGOS__LOG_ENTRY__COMMAND_HEAD:
        say_head(play, entry->head);
        return take_state(play, entry->time, entry->head->state);
    case PELAGOS__LOG_ENTRY__COMMAND_STATE:
        say_missed(play, entry);
        return take_state(play, entry->time, entry->state);
    case PELAGOS__LOG_ENTRY__COMMAND_STEP:
        status =
            entry->time > play->time_s ? advance(play, entry->time) : CTL_DONE;
        break;
    case PELAGOS__LOG_ENTRY__COMMAND_PATCH:
        if (entry->time > play->time_s) {
            status = advance(play, entry->time);
        }
        if (status == CTL_DONE) {
            double before_s = play->time_s;
            status = send_patch(play, entry->patch);
            if (play->time_s != before_s) { /* the clock was set */
                time_was_set(play);
            }
        }
        break;
    default:
        break;
    }
    play->commands++;
    return status;
}

static enum ctl_exit read_times(struct play *play, const char *list)
{
    g_auto(GStrv) words = g_strsplit(list, ",", MAX_TIMES + 1);
    for (char **word = words; *word; word++) {
        double *at = &play->times[play->time_count];
        if (play->time_count == MAX_TIMES || !ctl_parse_number(*word, at) ||
            *at < 0 || *at > 1e9 || (play->time_count > 0 && *at <= at[-1])) {
            return ctl_say(CTL_USAGE,
                           "--at %s: rising times in seconds, at most %d, "
                           "are wanted",
                           list, MAX_TIMES);
        }
        play->time_count++;
    }
    return CTL_DONE;
}

static enum ctl_exit read_options(struct play *play)
{
    struct ctl *ctl = play->ctl;
    enum ctl_exit status = CTL_DONE;
    static const char *const others[] = { "to", "loop", "no-clock" };
    for (size_t i = 0; i < G_N_ELEMENTS(others); i++) {
        if (ctl_value(ctl, others[i])) {
            return ctl_say(CTL_USAGE,
                           "--%s is for logs of NMEA, and %s is a "
                           "command log",
                           others[i], ctl->args[0]);
        }
    }
    play->folder = ctl_value(ctl, "frames");
    play->view = ctl_value(ctl, "view");
    play->view = play->view ? play->view : "bridge";
    if (ctl_value(ctl, "speed") &&
        ctl_number(ctl, "speed", 0.01, 100, &play->speed)) {
        return CTL_USAGE;
    }
    if (ctl_value(ctl, "at")) {
        status = read_times(play, ctl_value(ctl, "at"));
    } else {
        play->every_s = 1;
        status = ctl_number(ctl, "every", 0.001, 1e6, &play->every_s);
    }
    if (status == CTL_DONE && play->folder &&
        g_mkdir_with_parents(play->folder, 0777) != 0) {
        return ctl_say(CTL_FAILED, "%s: %s", play->folder, strerror(errno));
    }
    return status;
}

/* A row of frames ends with the log, its last moment included; moments that
 * were asked for by name may lie behind it. */
static enum ctl_exit finish(struct play *play)
{
    return draw(play, play->every_s > 0 ? nextafter(play->time_s, INFINITY)
                                        : INFINITY);
}

static enum ctl_exit play_segment(struct play *play,
                                  const struct log_segment *segment)
{
    struct pel_fault fault;
    Pelagos__LogEntry *entry = NULL;
    enum ctl_exit status = CTL_DONE;
    play->name = segment->name;
    if (pel_log_open(&play->reader, segment->data, segment->size, &fault)) {
        return ctl_say(CTL_FAILED, "%s: %s", segment->name, fault.message);
    }
    while (status == CTL_DONE) {
        if (pel_log_next(&play->reader, &entry, &fault)) {
            return ctl_say(CTL_FAILED, "%s: %s", segment->name, fault.message);
        }
        if (!entry) {
            break;
        }
        status = take(play, entry);
        pelagos__log_entry__free_unpacked(entry, NULL);
    }
    return status;
}

static enum ctl_exit play_all(struct play *play, const struct log_run *run)
{
    enum ctl_exit status = ctl_connect(play->ctl);
    for (size_t i = 0; i < run->count && status == CTL_DONE; i++) {
        status = play_segment(play, &run->segments[i]);
    }
    return status == CTL_DONE ? finish(play) : status;
}

enum ctl_exit ctl_replay_log(struct ctl *ctl)
{
    struct log_run run;
    g_autofree struct play *play = g_new0(struct play, 1);
    play->ctl = ctl;
    enum ctl_exit status =
        log_run_open((const char *const *)ctl->args, ctl->arg_count, &run);
    if (status == CTL_DONE) {
        status = read_options(play);
    }
    if (status == CTL_DONE) {
        ctl_catch_signals();
        status = play_all(play, &run);
    }
    log_run_finish(&run);
    if (status == CTL_DONE && ctl_flag(ctl, "json")) {
        printf("{\"commands\":%zu,\"time\":%.17g,\"frames\":%zu}\n",
               play->commands, play->time_s, play->frames);
    } else if (status == CTL_DONE && !ctl_flag(ctl, "quiet")) {
        printf("%zu commands to %.3f s, %zu frames\n", play->commands,
               play->time_s, play->frames);
    }
    return status;
}
