#include "scene/edit.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "fault.h"
#include "fields.h"
#include "message.h"
#include "path.h"
#include "scene/geodesy.h"
#include "scene/helm.h"
#include "scene/lookup.h"
#include "scene/presets.h"
#include "scene/reckon.h"
#include "scene/snapshot.h"
#include "scene/track.h"

/* Elements a patch may bring, entries of `remove`: what costs time is bounded
 * before the limits of the scene are tested. */
#define MAX_PATCHED 1024

/* Ships keep their true course from edit to edit; but from here on to the pole,
 * where north turns fast, their great circle. */
#define POLAR_LATITUDE 85.0

static void fill_scalars(ProtobufCMessage *message)
{
    for (unsigned i = 0; i < message->descriptor->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &message->descriptor->fields[i];
        if (field->label != PROTOBUF_C_LABEL_REPEATED &&
            field->type != PROTOBUF_C_TYPE_MESSAGE) {
            pel_message_default(message, field);
        }
    }
}

static void fill_lamps(Pelagos__Entity *entity)
{
    if (entity->light) {
        fill_scalars(&entity->light->base);
        for (size_t i = 0; i < entity->light->n_sectors; i++) {
            fill_scalars(&entity->light->sectors[i]->base);
        }
    }
    if (entity->searchlight) {
        fill_scalars(&entity->searchlight->base);
    }
    if (entity->signal) {
        fill_scalars(&entity->signal->base);
    }
}

static void fill_place(Pelagos__View *view)
{
    if (view->at) {
        fill_scalars(&view->at->base);
    }
    if (view->look_at) {
        fill_scalars(&view->look_at->base);
    }
    if (view->orbit) {
        fill_scalars(&view->orbit->base);
    }
    if (view->satellite) {
        fill_scalars(&view->satellite->base);
    }
    for (size_t i = 0; i < view->n_waypoints; i++) {
        fill_scalars(&view->waypoints[i]->base);
    }
}

void pel_state_fill(Pelagos__State *state, double time_s)
{
    const ProtobufCMessageDescriptor *type = &pelagos__state__descriptor;
    for (unsigned i = 0; i < type->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        if (field->label != PROTOBUF_C_LABEL_REPEATED &&
            field->type == PROTOBUF_C_TYPE_MESSAGE) {
            fill_scalars(pel_message_child(&state->base, field));
        }
    }
    for (size_t i = 0; i < state->sea->n_swell; i++) {
        fill_scalars(&state->sea->swell[i]->base);
    }
    for (size_t i = 0; i < state->sea->n_wave; i++) {
        fill_scalars(&state->sea->wave[i]->base);
    }
    for (size_t i = 0; i < state->sea->n_areas; i++) {
        fill_scalars(&state->sea->areas[i]->base);
    }
    if (state->sea->field) {
        fill_scalars(&state->sea->field->base);
    }
    for (size_t i = 0; i < state->sky->n_fog; i++) {
        fill_scalars(&state->sky->fog[i]->base);
    }
    for (size_t i = 0; i < state->exercise->n_events; i++) {
        fill_scalars(&state->exercise->events[i]->base);
    }
    for (size_t i = 0; i < state->n_entities; i++) {
        Pelagos__Entity *entity = state->entities[i];
        fill_scalars(&entity->base);
        if (!entity->has_pose_time) {
            entity->has_pose_time = true;
            entity->pose_time = time_s;
        }
        if (entity->helm && !entity->helm->has_entity) {
            entity->helm->has_entity = true;
            entity->helm->entity = entity->id;
        }
        if (entity->helm) {
            fill_scalars(&entity->helm->base);
        }
        fill_lamps(entity);
    }
    for (size_t i = 0; i < state->n_views; i++) {
        fill_scalars(&state->views[i]->base);
        if (state->views[i]->sensor) {
            fill_scalars(&state->views[i]->sensor->base);
        }
        if (state->views[i]->radar) {
            fill_scalars(&state->views[i]->radar->base);
        }
        fill_place(state->views[i]);
    }
    state->has_revision = true;
}

static ProtobufCMessage *add(Pelagos__State *state, const char *list)
{
    return pel_message_append(
        &state->base,
        pel_field_by_name(&pelagos__state__descriptor, list, strlen(list)));
}

static void name(ProtobufCMessage *message, const char *text)
{
    pel_message_set_string(
        message, pel_field_by_name(message->descriptor, "name", 4), text);
}

Pelagos__State *pel_state_default(void)
{
    Pelagos__State *state =
        (Pelagos__State *)pel_message_new(&pelagos__state__descriptor);
    Pelagos__Entity *entity = (Pelagos__Entity *)add(state, "entities");
    entity->has_id = true;
    entity->id = 1;
    name(&entity->base, "ownship");
    Pelagos__View *view = (Pelagos__View *)add(state, "views");
    view->has_entity = true;
    view->entity = 1;
    name(&view->base, "bridge");
    pel_state_fill(state, 0);
    return state;
}

/* --- merging -------------------------------------------------------------- */

static void merge(ProtobufCMessage *to, const ProtobufCMessage *from);

static void merge_list(ProtobufCMessage *to, const ProtobufCMessage *from,
                       const ProtobufCFieldDescriptor *field)
{
    size_t count;
    ProtobufCMessage **list = pel_message_list(from, field, &count);
    const ProtobufCFieldDescriptor *key = pel_field_key(field->descriptor);
    if (!key) {
        pel_message_clear(to, field);
    }
    struct pel_lookup there;
    if (key) {
        pel_lookup_begin(&there, to, field);
    }
    for (size_t i = 0; i < count; i++) {
        ProtobufCMessage *element =
            key ? pel_lookup_find(&there, list[i]) : NULL;
        merge(element ? element : pel_message_append(to, field), list[i]);
    }
}

/* Every list below State is one of messages. */
static void merge(ProtobufCMessage *to, const ProtobufCMessage *from)
{
    for (unsigned i = 0; i < from->descriptor->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &from->descriptor->fields[i];
        const void *value = pel_message_member(from, field);
        if (!pel_message_has(from, field)) {
            continue;
        }
        if (field->label == PROTOBUF_C_LABEL_REPEATED) {
            merge_list(to, from, field);
        } else if (field->type == PROTOBUF_C_TYPE_MESSAGE) {
            merge(pel_message_child(to, field),
                  *(ProtobufCMessage *const *)value);
        } else if (field->type == PROTOBUF_C_TYPE_STRING) {
            pel_message_set_string(to, field, *(char *const *)value);
        } else {
            memcpy(pel_message_member(to, field), value,
                   pel_message_value_size(field));
            pel_message_mark(to, field);
        }
    }
}

/* --- poses ---------------------------------------------------------------- */

static double wrapped(double degrees)
{
    double turned = fmod(degrees, 360.0);
    turned = turned < 0 ? turned + 360.0 : turned;
    return turned < 360.0 ? turned : 0;
}

/* Brings a place to where the wind of `state` takes it, in its plane. */
static void drift(const Pelagos__State *state, Pelagos__Entity *e,
                  double seconds)
{
    const struct pel_adrift what = {
        .leeway = e->leeway,
        .mooring_m = e->mooring,
        .wind_mps = state->sea->wind_speed,
        .wind_to_rad =
            remainder(-90 - state->sea->wind_direction, 360) * PEL_DEG,
    };
    double lat0 = state->origin->latitude, lon0 = state->origin->longitude;
    double east, north, x, y;
    pel_reckon_drift(&what, seconds, &east, &north);
    if (e->leeway > 0 && e->afloat && e->model && (east != 0 || north != 0)) {
        pel_geo_to_local(lat0, lon0, e->latitude, e->longitude, &x, &y);
        pel_geo_from_local(lat0, lon0, x + east, y + north, &e->latitude,
                           &e->longitude);
    }
}

/* Place, heading and course; `with`: what the patch sets then, or NULL. */
static void reckon_place(const Pelagos__Entity *with, Pelagos__Entity *e,
                         double seconds)
{
    double east, north, lat, lon;
    if (with && with->has_latitude && with->has_longitude &&
        with->has_heading && with->has_course) {
        return; /* all that is reckoned here */
    }
    pel_reckon_move(e->speed, e->course * PEL_DEG, e->turn_rate * PEL_DEG,
                    seconds, &east, &north);
    if (east != 0 || north != 0) {
        pel_geo_from_local(e->latitude, e->longitude, east, north, &lat, &lon);
        if (fmax(fabs(lat), fabs(e->latitude)) > POLAR_LATITUDE) {
            double turned =
                pel_geo_turn(e->latitude, e->longitude, lat, lon) / PEL_DEG;
            e->heading = wrapped(e->heading - turned);
            e->course = wrapped(e->course - turned);
        }
        e->latitude = lat;
        e->longitude = lon;
    }
    if (e->turn_rate != 0) {
        e->heading = wrapped(e->heading + e->turn_rate * seconds);
        e->course = wrapped(e->course + e->turn_rate * seconds);
    }
}

/* Brings a pose to time_s as the snapshot of `state` would, and stamps it. That
 * is the state before the edit: what the edit removes still moved it. */
static void reckon_to(const Pelagos__State *state, Pelagos__Entity *e,
                      const Pelagos__Entity *with, double time_s, double most_s)
{
    double seconds = pel_reckon_seconds(e->pose_time, time_s, most_s);
    reckon_place(with, e, seconds);
    if (!pel_helm_on(state, e)) {
        drift(state, e, time_s - e->pose_time);
    }
    e->altitude = pel_clamp(e->altitude + e->climb_rate * seconds, PEL_LOWEST_M,
                            PEL_HIGHEST_M);
    e->pitch = pel_clamp(e->pitch + e->pitch_rate * seconds, -90, 90);
    e->roll = remainder(e->roll + e->roll_rate * seconds, 360);
    e->has_pose_time = true;
    e->pose_time = time_s;
}

static void reckon(const Pelagos__State *state, Pelagos__Entity *e,
                   double time_s, double most_s)
{
    reckon_to(state, e, NULL, time_s, most_s);
}

static bool touches_pose(const Pelagos__Entity *e)
{
    return e->has_latitude || e->has_longitude || e->has_altitude ||
           e->has_heading || e->has_pitch || e->has_roll || e->has_speed ||
           e->has_course || e->has_turn_rate || e->has_pose_time ||
           e->has_climb_rate || e->has_pitch_rate || e->has_roll_rate;
}

/* What has drifted so far stays where it is. */
static bool touches_drift(const Pelagos__Entity *e)
{
    return e->has_leeway || e->has_mooring || e->has_afloat || e->model;
}

static void find_entities(struct pel_lookup *lookup,
                          const Pelagos__State *state)
{
    pel_lookup_begin(
        lookup, &state->base,
        pel_field_by_name(&pelagos__state__descriptor, "entities", 8));
}

static Pelagos__Entity *entity_of(struct pel_lookup *entities,
                                  const Pelagos__Entity *like)
{
    return (Pelagos__Entity *)pel_lookup_find(entities, &like->base);
}

/* Before the edit: poses that it touches are brought to their new time. A NaN
 * or a time out of range leaves the pose: the test will refuse it. */
static void reckon_patched(const Pelagos__State *from, Pelagos__State *state,
                           const Pelagos__State *patch, double time_s,
                           double most_s)
{
    struct pel_lookup entities;
    find_entities(&entities, state);
    for (size_t i = 0; i < patch->n_entities; i++) {
        const Pelagos__Entity *with = patch->entities[i];
        Pelagos__Entity *entity = entity_of(&entities, with);
        double at = with->has_pose_time ? with->pose_time : time_s;
        if (entity && (touches_pose(with) || touches_drift(with)) &&
            isfinite(at)) {
            reckon_to(from, entity, with, at, most_s);
        }
    }
}

static void reckon_removed(const Pelagos__State *from, Pelagos__State *state,
                           const char *path, double time_s, double most_s)
{
    struct pel_path_info info;
    const char *dot = strchr(path, '.');
    const char *field = dot ? strchr(dot + 1, '.') : NULL;
    char element[128], id[16];
    if (!field || (size_t)(field - path) >= sizeof element - 3 ||
        pel_path_find(path, &info, NULL) != PEL_OK ||
        info.message != &pelagos__entity__descriptor) {
        return;
    }
    snprintf(element, sizeof element, "%.*s.id", (int)(field - path), path);
    if (strcmp(info.info->name, "name") != 0 &&
        pel_path_get(state, element, id, sizeof id, NULL) == PEL_OK) {
        uint32_t number = (uint32_t)strtoul(id, NULL, 10);
        size_t i = 0;
        while (state->entities[i]->id != number) {
            i++;
        }
        reckon(from, state->entities[i], time_s, most_s);
    }
}

/* --- the edit ------------------------------------------------------------- */

static enum pel_err too_many(const char *path, struct pel_fault *fault)
{
    pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                  "%s: a patch brings at most %d elements", path, MAX_PATCHED);
    pel_fault_at(fault, path, NULL);
    return PEL_ERR_OUT_OF_RANGE;
}

static enum pel_err bounded(const Pelagos__Patch *patch,
                            struct pel_fault *fault)
{
    const Pelagos__State *state = patch->state;
    if (patch->n_remove > MAX_PATCHED) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "a patch removes at most %d paths", MAX_PATCHED);
    }
    if (state && state->n_entities > MAX_PATCHED) {
        return too_many("entities", fault);
    }
    if (state && state->n_views > MAX_PATCHED) {
        return too_many("views", fault);
    }
    if (state && state->n_presets > MAX_PATCHED) {
        return too_many("presets", fault);
    }
    if (state && state->sea && state->sea->n_swell > MAX_PATCHED) {
        return too_many("sea.swell", fault);
    }
    if (state && state->sea && state->sea->n_wave > MAX_PATCHED) {
        return too_many("sea.wave", fault);
    }
    if (state && state->sea && state->sea->n_areas > MAX_PATCHED) {
        return too_many("sea.areas", fault);
    }
    if (state && state->sky && state->sky->n_fog > MAX_PATCHED) {
        return too_many("sky.fog", fault);
    }
    if (state && state->exercise && state->exercise->n_events > MAX_PATCHED) {
        return too_many("exercise.events", fault);
    }
    return PEL_OK;
}

static bool all_have_ids(const Pelagos__State *patch)
{
    size_t i = 0;
    while (i < patch->n_entities && patch->entities[i]->has_id) {
        i++;
    }
    return i == patch->n_entities;
}

/* Gives elements of the patch that only have a name the id of the entity of
 * that name. */
static enum pel_err resolve_names(const Pelagos__State *state,
                                  Pelagos__State *patch,
                                  struct pel_fault *fault)
{
    for (size_t i = 0; i < patch->n_entities; i++) {
        Pelagos__Entity *entity = patch->entities[i];
        char path[160];
        if (entity->has_id) {
            continue;
        }
        snprintf(path, sizeof path, "entities.%.80s",
                 entity->name ? entity->name : "");
        const Pelagos__Entity *match = NULL;
        size_t found = 0;
        for (size_t k = 0; entity->name && k < state->n_entities; k++) {
            const char *other = state->entities[k]->name;
            if (other && strcmp(other, entity->name) == 0) {
                match = state->entities[k];
                found++;
            }
        }
        if (found != 1) {
            enum pel_err err =
                found == 0 ? PEL_ERR_NOT_FOUND : PEL_ERR_CONFLICT;
            pel_fault_set(fault, err, "%s: %s", path,
                          found == 0 ? "no such entity; give an id to add one"
                                     : "several entities have this name; use "
                                       "the id");
            pel_fault_at(fault, path, entity->name);
            return err;
        }
        entity->has_id = true;
        entity->id = match->id;
    }
    for (size_t i = 0; i < patch->n_views; i++) {
        if (!patch->views[i]->name) {
            pel_fault_set(fault, PEL_ERR_INVALID,
                          "views: every element needs its name");
            pel_fault_at(fault, "views", NULL);
            return PEL_ERR_INVALID;
        }
    }
    return pel_presets_brought(patch, fault);
}

/* Whether `patch` makes the element that a path begins with, so that a reset
 * of one of its fields has nothing to do. */
static bool brings_element(const Pelagos__State *patch, const char *path)
{
    char element[160], text[4];
    const char *dot = strchr(path, '.');
    const char *end = dot ? strchr(dot + 1, '.') : NULL;
    if (!patch || !end || (size_t)(end - path) >= sizeof element) {
        return false;
    }
    snprintf(element, sizeof element, "%.*s", (int)(end - path), path);
    return pel_path_get(patch, element, text, sizeof text, NULL) !=
           PEL_ERR_NOT_FOUND;
}

static enum pel_err remove_all(const Pelagos__State *from,
                               Pelagos__State *state,
                               const Pelagos__Patch *patch,
                               const Pelagos__State *brought, double time_s,
                               double most_s, struct pel_fault *fault)
{
    for (size_t i = 0; i < patch->n_remove; i++) {
        const char *path = patch->remove[i];
        struct pel_path_info info;
        enum pel_err err = pel_path_find(path, &info, fault);
        if (!err) {
            reckon_removed(from, state, path, time_s, most_s);
            err = pel_path_remove(state, path, fault);
        }
        if (err == PEL_ERR_NOT_FOUND && info.info &&
            brings_element(brought, path)) {
            err = PEL_OK;
        }
        if (err) {
            return err;
        }
    }
    return PEL_OK;
}

/* Simulated time after the edit, as far as that can be told before it. */
static double time_after(const Pelagos__State *from,
                         const Pelagos__Patch *patch)
{
    const Pelagos__Clock *clock = patch->state ? patch->state->clock : NULL;
    if (clock && clock->has_time) {
        return clock->time;
    }
    for (size_t i = 0; i < patch->n_remove; i++) {
        if (strcmp(patch->remove[i], "clock") == 0 ||
            strcmp(patch->remove[i], "clock.time") == 0) {
            return 0;
        }
    }
    return from->clock->time;
}

/* Poses stay where they are when the clock is set. */
static void carry_poses(Pelagos__State *state, double before, double after,
                        double most_s)
{
    for (size_t i = 0; i < state->n_entities; i++) {
        reckon(state, state->entities[i], before, most_s);
        state->entities[i]->pose_time = after;
        pel_track_drop(state->entities[i]);
    }
}

/* Whether the patch says that this helm is on, or off. */
static bool says_on(const Pelagos__State *brought,
                    const Pelagos__Entity *entity, bool own_ship)
{
    const Pelagos__OwnShip *helm = own_ship ? brought->own_ship : entity->helm;
    return helm && helm->has_on;
}

/* Another wind, or another plane, begins from where things have drifted to. */
static void carry_drift(Pelagos__State *state, const Pelagos__Patch *patch,
                        double time_s, double most_s)
{
    bool blows = patch->state && (patch->state->sea || patch->state->origin);
    for (size_t i = 0; i < patch->n_remove; i++) {
        blows |= strncmp(patch->remove[i], "sea", 3) == 0 ||
                 strncmp(patch->remove[i], "origin", 6) == 0;
    }
    for (size_t i = 0; i < state->n_entities && blows; i++) {
        if (state->entities[i]->leeway > 0) {
            reckon(state, state->entities[i], time_s, most_s);
        }
    }
}

/* A pose that the patch gives a ship turns its helm off, unless it says that
 * the model is to go on from there. */
static void lead(Pelagos__State *state, const Pelagos__State *brought)
{
    struct pel_lookup entities;
    find_entities(&entities, state);
    for (size_t i = 0; i < brought->n_entities && pel_helm_any(state); i++) {
        const Pelagos__Entity *with = brought->entities[i];
        const Pelagos__Entity *is = entity_of(&entities, with);
        Pelagos__OwnShip *helm = is ? pel_helm_on(state, is) : NULL;
        if (helm && touches_pose(with) &&
            !says_on(brought, with, helm == state->own_ship)) {
            helm->on = false;
        }
    }
}

/* The entity that the patch's element means: by its number, or by its name. */
static const Pelagos__Entity *meant(const Pelagos__State *state,
                                    const Pelagos__Entity *with)
{
    for (size_t i = 0; i < state->n_entities; i++) {
        const Pelagos__Entity *e = state->entities[i];
        if (with->has_id
                ? e->id == with->id
                : with->name && e->name && strcmp(e->name, with->name) == 0) {
            return e;
        }
    }
    return NULL;
}

void pel_state_notice(const Pelagos__State *from, const Pelagos__Patch *patch,
                      char out[PEL_NOTICE])
{
    const Pelagos__State *brought = patch->state;
    out[0] = '\0';
    if (!brought || !pel_helm_any(from)) {
        return;
    }
    for (size_t i = 0; i < brought->n_entities && !out[0]; i++) {
        const Pelagos__Entity *with = brought->entities[i];
        const Pelagos__Entity *is =
            touches_pose(with) ? meant(from, with) : NULL;
        const Pelagos__OwnShip *helm = is ? pel_helm_on(from, is) : NULL;
        if (helm && !says_on(brought, with, helm == from->own_ship)) {
            char path[PEL_HELM_PATH];
            pel_helm_path(from, is->id, path);
            snprintf(out, PEL_NOTICE,
                     "entity %u is led by poses now and %s.on is false: "
                     "rudder and engine move her no longer. With %s.on true "
                     "in the same edit her model goes on from there",
                     is->id, path, path);
        }
    }
}

/* The tracks of the entities that the patch moved. */
static void follow(const Pelagos__State *from, Pelagos__State *state,
                   const Pelagos__State *brought, double reckoning_s)
{
    struct pel_lookup before, after;
    find_entities(&before, from);
    find_entities(&after, state);
    for (size_t i = 0; i < brought->n_entities; i++) {
        const Pelagos__Entity *with = brought->entities[i];
        const Pelagos__Entity *was = entity_of(&before, with);
        Pelagos__Entity *is = entity_of(&after, with);
        bool turned = with->has_wake || with->has_wash;
        if (was && is && (touches_pose(with) || turned)) {
            struct pel_track_pose pose = pel_track_pose_of(was);
            pel_track_go_on(&pose, is, reckoning_s);
        }
    }
}

enum pel_err pel_state_apply_onto(Pelagos__State *old,
                                  const Pelagos__State *from,
                                  const Pelagos__Patch *patch,
                                  Pelagos__State **out, struct pel_fault *fault)
{
    *out = NULL;
    Pelagos__State *state = (Pelagos__State *)pel_message_copy_onto(
        old ? &old->base : NULL, &from->base);
    enum pel_err err = bounded(patch, fault);
    if (err) {
        pelagos__state__free_unpacked(state, NULL);
        return err;
    }
    /* A copy where names are to be resolved, which then stand in it as ids. */
    bool named = patch->state && !all_have_ids(patch->state);
    Pelagos__State *brought =
        named ? (Pelagos__State *)pel_message_copy(&patch->state->base)
              : patch->state;
    double time_s = time_after(from, patch);
    double most_s = from->clock->reckoning; /* the patch may remove the clock */
    if (time_s != from->clock->time && isfinite(time_s)) {
        carry_poses(state, from->clock->time, time_s, most_s);
    }
    if (isfinite(time_s)) {
        carry_drift(state, patch, time_s, most_s);
    }
    err = remove_all(from, state, patch, brought, time_s, most_s, fault);
    if (!err && brought) {
        err = resolve_names(state, brought, fault);
    }
    if (!err && brought) {
        reckon_patched(from, state, brought, time_s, most_s);
        merge(&state->base, &brought->base);
    }
    if (!err && brought) {
        lead(state, brought);
        if (time_s == from->clock->time) {
            follow(from, state, brought, most_s);
        }
    }
    if (named) {
        pelagos__state__free_unpacked(brought, NULL);
    }
    if (err) {
        pelagos__state__free_unpacked(state, NULL);
        return err;
    }
    pel_state_fill(state, time_s);
    *out = state;
    return PEL_OK;
}

enum pel_err pel_state_apply(const Pelagos__State *from,
                             const Pelagos__Patch *patch, Pelagos__State **out,
                             struct pel_fault *fault)
{
    return pel_state_apply_onto(NULL, from, patch, out, fault);
}
