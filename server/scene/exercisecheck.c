/* Whether a text is an exercise. */
#include <glib.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bounds.h"
#include "fault.h"
#include "json.h"
#include "message.h"
#include "ranges.h"
#include "scene/check.h"
#include "scene/edit.h"
#include "scene/exercise.h"
#include "scene/exercise_parts.h"
#include "scene/exercisewhen.h"

#define PATH_SIZE 192
#define MOST_TEXT 4096
#define MOST_WHENS 8

static enum pel_err refuse(enum pel_err code, struct pel_fault *fault,
                           const char *value, const char *what,
                           const char *path_format, ...)
    __attribute__((format(printf, 5, 6)));
static enum pel_err refuse(enum pel_err code, struct pel_fault *fault,
                           const char *value, const char *what,
                           const char *path_format, ...)
{
    char path[PATH_SIZE];
    va_list args;
    va_start(args, path_format);
    g_vsnprintf(path, sizeof path, path_format, args);
    va_end(args);
    return pel_fault_refuse(code, path, value, what, fault);
}

/* The fault of a part, by its place in the whole. */
static enum pel_err within(enum pel_err err, const char *prefix,
                           struct pel_fault *fault)
{
    if (err && fault) {
        struct pel_fault part = *fault;
        bool named = part.path[0] && g_str_has_prefix(part.message, part.path);
        g_snprintf(fault->path, sizeof fault->path, "%s%s%s", prefix,
                   part.path[0] ? "." : "", part.path);
        g_snprintf(fault->message, sizeof fault->message, "%s%s%s", prefix,
                   named ? "." : ": ", part.message);
    }
    return err;
}

bool pel_exercise_good_name(const char *name)
{
    size_t length = name ? strlen(name) : 0;
    return length > 0 && length <= 64 &&
           strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                        "abcdefghijklmnopqrstuvwxyz0123456789_-") == length;
}

static enum pel_err check_text(const char *text, const char *path,
                               struct pel_fault *fault)
{
    const char *what = NULL;
    size_t length = text ? strlen(text) : 0;
    if (length > MOST_TEXT) {
        what = "is longer than 4096 bytes";
    } else if (text && !g_utf8_validate(text, (gssize)length, NULL)) {
        what = "is not UTF-8";
    }
    for (const char *p = text; p && !what && *p; p++) {
        unsigned char c = (unsigned char)*p;
        if ((c < 0x20 && c != '\n') || c == 0x7f) {
            what = "holds a control character; only new lines may be";
        }
    }
    return what ? refuse(PEL_ERR_INVALID, fault, NULL, what, "%s", path)
                : PEL_OK;
}

/* Ranges, apart from the texts for people, the state and the patches, which
 * are tested as such. */
static enum pel_err check_ranges(const Pelagos__Exercise *exercise,
                                 struct pel_fault *fault)
{
    Pelagos__Exercise *bare =
        (Pelagos__Exercise *)pel_message_copy(&exercise->base);
    enum pel_err err = check_text(bare->title, "title", fault);
    if (!err) {
        err = check_text(bare->description, "description", fault);
    }
    g_clear_pointer(&bare->title, free);
    g_clear_pointer(&bare->description, free);
    if (bare->state) {
        pelagos__state__free_unpacked(bare->state, NULL);
        bare->state = NULL;
    }
    for (size_t i = 0; !err && i < bare->n_events; i++) {
        Pelagos__ExerciseEvent *event = bare->events[i];
        char path[PATH_SIZE];
        g_snprintf(path, sizeof path, "events.%zu.text", i);
        err = check_text(event->text, path, fault);
        g_clear_pointer(&event->text, free);
        if (event->patch) {
            pelagos__patch__free_unpacked(event->patch, NULL);
            event->patch = NULL;
        }
    }
    if (!err) {
        err = pel_message_check(&bare->base, "", fault);
    }
    pelagos__exercise__free_unpacked(bare, NULL);
    return err;
}

static enum pel_err check_area(const Pelagos__ExerciseArea *area,
                               const char *path, struct pel_fault *fault)
{
    double corners[PEL_EXERCISE_CORNERS][2];
    if (!area) {
        return PEL_OK;
    }
    bool circle = area->has_latitude && area->has_longitude && area->has_radius;
    bool part = area->has_latitude || area->has_longitude || area->has_radius;
    if (area->corners ? part : !circle) {
        return refuse(PEL_ERR_INVALID, fault, NULL,
                      "needs latitude, longitude and radius, or corners alone",
                      "%s", path);
    }
    if (area->corners && pel_exercise_corners(area->corners, corners) < 0) {
        return refuse(PEL_ERR_INVALID, fault, area->corners,
                      "must be 3 to 16 pairs of latitude -90 .. 90 and "
                      "longitude -180 .. 180, as \"52.60 5.20, 52.61 5.20, "
                      "52.61 5.22\"",
                      "%s.corners", path);
    }
    return PEL_OK;
}

static bool has_entity(const Pelagos__State *state, uint32_t id)
{
    for (size_t i = 0; i < state->n_entities; i++) {
        if (state->entities[i]->id == id) {
            return true;
        }
    }
    return false;
}

static const Pelagos__ExerciseEvent *event_of(const Pelagos__Exercise *exercise,
                                              const char *name)
{
    for (size_t i = 0; i < exercise->n_events; i++) {
        if (exercise->events[i]->name &&
            strcmp(exercise->events[i]->name, name) == 0) {
            return exercise->events[i];
        }
    }
    return NULL;
}

static enum pel_err check_entity(const Pelagos__State *state, bool given,
                                 uint32_t id, const char *path,
                                 struct pel_fault *fault)
{
    char value[16];
    if (!given || has_entity(state, id)) {
        return PEL_OK;
    }
    g_snprintf(value, sizeof value, "%u", id);
    return refuse(PEL_ERR_NOT_FOUND, fault, value,
                  "names an entity that neither the state nor an event has; "
                  "add it to state.entities",
                  "%s", path);
}

static bool asks_distance(const Pelagos__ExerciseWhen *w)
{
    return w->has_range_below || w->has_range_above || w->has_cpa_below ||
           w->has_tcpa_below;
}

static bool asks_entity(const Pelagos__ExerciseWhen *w)
{
    return w->has_north_of || w->has_south_of || w->has_east_of ||
           w->has_west_of || w->inside || w->outside || w->has_speed_below ||
           w->has_speed_above || w->has_under_keel_below;
}

/* `state` has every entity that there ever is. */
static enum pel_err check_when(const Pelagos__Exercise *exercise,
                               const Pelagos__ExerciseEvent *event,
                               const Pelagos__ExerciseWhen *w,
                               const Pelagos__State *state, const char *path,
                               struct pel_fault *fault)
{
    char below[PATH_SIZE];
    if (!w->has_at && !w->after && !asks_entity(w) && !asks_distance(w)) {
        return refuse(PEL_ERR_INVALID, fault, NULL,
                      "has no condition; give one of at, after, northOf, "
                      "inside, rangeBelow, …",
                      "%s", path);
    }
    if (w->after && (!event_of(exercise, w->after) ||
                     event_of(exercise, w->after) == event)) {
        return refuse(PEL_ERR_NOT_FOUND, fault, w->after,
                      "must be the name of another event", "%s.after", path);
    }
    if (w->has_delay && !w->after) {
        return refuse(PEL_ERR_INVALID, fault, NULL, "needs `after` beside it",
                      "%s.delay", path);
    }
    if (asks_distance(w) != (w->has_other != 0)) {
        return refuse(PEL_ERR_INVALID, fault, NULL,
                      w->has_other
                          ? "needs rangeBelow, rangeAbove, cpaBelow or "
                            "tcpaBelow beside it"
                          : "is missing: rangeBelow, rangeAbove, "
                            "cpaBelow and tcpaBelow are to it",
                      "%s.other", path);
    }
    if (w->has_other &&
        w->other == (w->has_entity ? w->entity : exercise->own_ship)) {
        return refuse(PEL_ERR_INVALID, fault, NULL,
                      "must be another than the entity itself", "%s.other",
                      path);
    }
    g_snprintf(below, sizeof below, "%s.inside", path);
    enum pel_err err = check_area(w->inside, below, fault);
    if (!err) {
        g_snprintf(below, sizeof below, "%s.outside", path);
        err = check_area(w->outside, below, fault);
    }
    if (!err) {
        g_snprintf(below, sizeof below, "%s.entity", path);
        err = check_entity(state, w->has_entity, w->entity, below, fault);
    }
    if (!err) {
        g_snprintf(below, sizeof below, "%s.other", path);
        err = check_entity(state, w->has_other, w->other, below, fault);
    }
    return err;
}

/* `state` is that of the beginning. */
static enum pel_err check_ships(const Pelagos__Exercise *exercise,
                                const Pelagos__State *state,
                                struct pel_fault *fault)
{
    char path[PATH_SIZE];
    enum pel_err err =
        check_entity(state, true, exercise->own_ship, "ownShip", fault);
    for (size_t i = 0; !err && i < exercise->n_ships; i++) {
        g_snprintf(path, sizeof path, "ships.%u.id", exercise->ships[i]->id);
        err = check_entity(state, true, exercise->ships[i]->id, path, fault);
    }
    return err;
}

static enum pel_err check_limit(const Pelagos__Exercise *exercise,
                                const Pelagos__ExerciseLimit *limit,
                                struct pel_fault *fault)
{
    char path[PATH_SIZE], value[16];
    if (limit->has_ship && pel_exercise_ship_index(exercise, limit->ship) < 0) {
        g_snprintf(value, sizeof value, "%u", limit->ship);
        return refuse(PEL_ERR_NOT_FOUND, fault, value,
                      "must be ownShip or one of ships; add it to ships",
                      "limits.%s.ship", limit->name);
    }
    g_snprintf(path, sizeof path, "limits.%s.area", limit->name);
    return check_area(limit->area, path, fault);
}

static enum pel_err check_event(const Pelagos__Exercise *exercise, size_t index,
                                const Pelagos__State *state,
                                struct pel_fault *fault)
{
    const Pelagos__ExerciseEvent *event = exercise->events[index];
    char path[PATH_SIZE];
    if (event->n_when < 1 || event->n_when > MOST_WHENS) {
        return refuse(PEL_ERR_INVALID, fault, NULL,
                      "must have 1 to 8 conditions", "events.%s.when",
                      event->name);
    }
    for (size_t i = 0; i < event->n_when; i++) {
        g_snprintf(path, sizeof path, "events.%s.when.%zu", event->name, i);
        enum pel_err err =
            check_when(exercise, event, event->when[i], state, path, fault);
        if (err) {
            return err;
        }
    }
    return PEL_OK;
}

static enum pel_err check_ship_numbers(const Pelagos__Exercise *exercise,
                                       struct pel_fault *fault)
{
    char value[24];
    if (exercise->n_ships >= PEL_EXERCISE_SHIPS) {
        g_snprintf(value, sizeof value, "%zu", exercise->n_ships);
        return refuse(PEL_ERR_OUT_OF_RANGE, fault, value,
                      "must have at most 7 elements, beside ownShip", "ships");
    }
    for (size_t i = 0; i < exercise->n_ships; i++) {
        const Pelagos__ExerciseShip *ship = exercise->ships[i];
        if (!ship->has_id) {
            return refuse(PEL_ERR_INVALID, fault, NULL,
                          "is missing: the number of an entity", "ships.%zu.id",
                          i);
        }
        if (pel_exercise_ship_index(exercise, ship->id) != (int)i + 1) {
            g_snprintf(value, sizeof value, "%u", ship->id);
            return refuse(PEL_ERR_INVALID, fault, value,
                          "must be another than ownShip and the other ships",
                          "ships.%zu.id", i);
        }
    }
    return PEL_OK;
}

/* Names, which paths are made of. */
static enum pel_err check_names(const Pelagos__Exercise *exercise,
                                struct pel_fault *fault)
{
    static const char *const wrong =
        "must be 1 to 64 of A-Z a-z 0-9 _ -, and no other's";
    char value[16];
    if (exercise->n_events > PEL_BOUND_EXERCISE_EVENTS) {
        g_snprintf(value, sizeof value, "%zu", exercise->n_events);
        return refuse(PEL_ERR_OUT_OF_RANGE, fault, value,
                      "must have at most 64 elements", "events");
    }
    if (exercise->n_limits > PEL_EXERCISE_LIMITS) {
        g_snprintf(value, sizeof value, "%zu", exercise->n_limits);
        return refuse(PEL_ERR_OUT_OF_RANGE, fault, value,
                      "must have at most 16 elements", "limits");
    }
    for (size_t i = 0; i < exercise->n_events; i++) {
        const Pelagos__ExerciseEvent *event = exercise->events[i];
        if (!pel_exercise_good_name(event->name) ||
            event_of(exercise, event->name) != event) {
            return refuse(PEL_ERR_INVALID, fault, event->name, wrong,
                          "events.%zu.name", i);
        }
    }
    for (size_t i = 0; i < exercise->n_limits; i++) {
        const Pelagos__ExerciseLimit *limit = exercise->limits[i];
        bool twice = false;
        for (size_t k = 0; k < i && limit->name; k++) {
            twice =
                twice || strcmp(exercise->limits[k]->name, limit->name) == 0;
        }
        if (!pel_exercise_good_name(limit->name) || twice) {
            return refuse(PEL_ERR_INVALID, fault, limit->name, wrong,
                          "limits.%zu.name", i);
        }
        if (!limit->has_speed) {
            return refuse(PEL_ERR_INVALID, fault, NULL, "is missing",
                          "limits.%s.speed", limit->name);
        }
    }
    return PEL_OK;
}

/* --- states --------------------------------------------------------------- */

/* What only the instructor's clock decides. */
static enum pel_err check_kept(const Pelagos__Patch *patch, const char *path,
                               bool event, struct pel_fault *fault)
{
    const Pelagos__State *state = patch->state;
    if (state && state->exercise) {
        return refuse(PEL_ERR_INVALID, fault, NULL,
                      "is written by the server; leave it out",
                      "%s.state.exercise", path);
    }
    if (state && state->clock && state->clock->has_mode) {
        return refuse(PEL_ERR_INVALID, fault, NULL,
                      "is left to whoever runs the exercise; leave it out",
                      "%s.state.clock.mode", path);
    }
    if (event && state && state->clock && state->clock->has_time) {
        return refuse(PEL_ERR_INVALID, fault, NULL,
                      "would move the exercise's own time; leave it out",
                      "%s.state.clock.time", path);
    }
    for (size_t i = 0; i < patch->n_remove; i++) {
        if (g_str_has_prefix(patch->remove[i], "clock") ||
            g_str_has_prefix(patch->remove[i], "exercise")) {
            return refuse(PEL_ERR_INVALID, fault, patch->remove[i],
                          "may name neither clock nor exercise", "%s.remove",
                          path);
        }
    }
    return PEL_OK;
}

/* *state becomes what the patch makes of it, tested as a live edit is, files
 * apart. */
static enum pel_err apply(Pelagos__State **state, const Pelagos__Patch *patch,
                          struct pel_fault *fault)
{
    Pelagos__State *next = NULL;
    enum pel_err err = pel_state_apply(*state, patch, &next, fault);
    if (!err) {
        err = pel_state_check(next, fault);
    }
    if (!err) {
        err = pel_sea_settle(next, fault);
    }
    if (!err) {
        pelagos__state__free_unpacked(*state, NULL);
        *state = next;
    } else if (next) {
        pelagos__state__free_unpacked(next, NULL);
    }
    return err;
}

/* The scene as the exercise begins it, on the default one. */
static enum pel_err begin_state(const Pelagos__Exercise *exercise,
                                Pelagos__State **out, struct pel_fault *fault)
{
    struct pel_exercise_beginning beginning;
    Pelagos__State *state = pel_state_default();
    pel_exercise_begin(exercise, state, &beginning);
    Pelagos__Patch bare = PELAGOS__PATCH__INIT;
    bare.state = exercise->state;
    enum pel_err err =
        exercise->state ? check_kept(&bare, "", false, fault) : PEL_OK;
    if (err && fault) { /* ".state.…" */
        memmove(fault->path, fault->path + 1, strlen(fault->path));
        memmove(fault->message, fault->message + 1, strlen(fault->message));
    }
    if (!err) {
        err = within(apply(&state, &beginning.patch, fault), "state", fault);
    }
    pel_exercise_beginning_finish(&beginning);
    if (err) {
        pelagos__state__free_unpacked(state, NULL);
        return err;
    }
    *out = state;
    return PEL_OK;
}

/* Adds what an event brings and removes nothing, so that later ones find it. */
static enum pel_err check_patch(const Pelagos__ExerciseEvent *event,
                                Pelagos__State **state, struct pel_fault *fault)
{
    char path[PATH_SIZE];
    if (!event->patch ||
        (!event->patch->state && event->patch->n_remove == 0)) {
        return refuse(PEL_ERR_INVALID, fault, NULL,
                      "is missing: what changes then", "events.%s.patch",
                      event->name);
    }
    g_snprintf(path, sizeof path, "events.%s.patch", event->name);
    enum pel_err err = check_kept(event->patch, path, true, fault);
    if (err) {
        return err;
    }
    if (event->patch->n_remove == 0) {
        g_snprintf(path, sizeof path, "events.%s.patch.state", event->name);
    }
    Pelagos__State *next = (Pelagos__State *)pel_message_copy(&(*state)->base);
    err = within(apply(&next, event->patch, fault), path, fault);
    pelagos__state__free_unpacked(next, NULL);
    if (!err && event->patch->state) {
        Pelagos__Patch adds = PELAGOS__PATCH__INIT;
        adds.state = event->patch->state;
        err = within(apply(state, &adds, fault), path, fault);
    }
    return err;
}

static enum pel_err check_states(const Pelagos__Exercise *exercise,
                                 struct pel_fault *fault)
{
    Pelagos__State *state;
    enum pel_err err = begin_state(exercise, &state, fault);
    if (err) {
        return err;
    }
    err = check_ships(exercise, state, fault);
    for (size_t i = 0; !err && i < exercise->n_events; i++) {
        err = check_patch(exercise->events[i], &state, fault);
    }
    for (size_t i = 0; !err && i < exercise->n_events; i++) {
        err = check_event(exercise, i, state, fault);
    }
    for (size_t i = 0; !err && i < exercise->n_limits; i++) {
        err = check_limit(exercise, exercise->limits[i], fault);
    }
    pelagos__state__free_unpacked(state, NULL);
    return err;
}

enum pel_err pel_exercise_check(const Pelagos__Exercise *exercise,
                                struct pel_fault *fault)
{
    enum pel_err err = check_names(exercise, fault);
    if (!err) {
        err = check_ship_numbers(exercise, fault);
    }
    if (!err) {
        err = check_ranges(exercise, fault);
    }
    return err ? err : check_states(exercise, fault);
}

enum pel_err pel_exercise_read(const char *text, size_t size,
                               Pelagos__Exercise **out, struct pel_fault *fault)
{
    ProtobufCMessage *message = NULL;
    *out = NULL;
    enum pel_err err = pel_json_to_message(
        text, size, &pelagos__exercise__descriptor, &message, fault);
    if (err) {
        return err;
    }
    Pelagos__Exercise *exercise = (Pelagos__Exercise *)message;
    err = pel_exercise_check(exercise, fault);
    if (err) {
        pelagos__exercise__free_unpacked(exercise, NULL);
        return err;
    }
    *out = exercise;
    return PEL_OK;
}
