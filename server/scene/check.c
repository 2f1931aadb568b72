#include "scene/check.h"

#include <glib.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "fault.h"
#include "fields.h"
#include "json.h"
#include "message.h"
#include "ranges.h"
#include "scene/helm.h"
#include "scene/lamps.h"
#include "scene/lookup.h"
#include "scene/presets.h"
#include "scene/snapshot.h"
#include "scene/sun.h"
#include "scene/track.h"
#include "scene/waypoints.h"

#define PATH_SIZE 192
#define MIN_ANGLE_DEG 0.01 /* so that its width is far above rounding */
#define MAX_PIXELS (4096.0 * 4096.0)

static enum pel_err check_count(size_t count, size_t limit, const char *path,
                                struct pel_fault *fault)
{
    if (count <= limit) {
        return PEL_OK;
    }
    char value[24], what[64];
    g_snprintf(value, sizeof value, "%zu", count);
    g_snprintf(what, sizeof what, "would have %zu elements; at most %zu", count,
               limit);
    pel_fault_refuse(PEL_ERR_OUT_OF_RANGE, path, value, what, fault);
    if (fault) {
        fault->minimum = 0;
        fault->maximum = (double)limit;
    }
    return PEL_ERR_OUT_OF_RANGE;
}

static bool good_view_name(const char *name)
{
    size_t length = strlen(name);
    return length > 0 && length < PEL_NAME_SIZE &&
           strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                        "abcdefghijklmnopqrstuvwxyz0123456789_-") == length;
}

static enum pel_err check_frustum(const Pelagos__View *view,
                                  struct pel_fault *fault)
{
    const Pelagos__Frustum *f = view->frustum;
    char path[PATH_SIZE];
    g_snprintf(path, sizeof path, "views.%s.frustum", view->name);
    if (!f->has_left || !f->has_right || !f->has_top || !f->has_bottom) {
        return pel_fault_refuse(PEL_ERR_INVALID, path, NULL,
                                "needs all of left, right, top and bottom",
                                fault);
    }
    if (!(f->left + MIN_ANGLE_DEG <= f->right) ||
        !(f->bottom + MIN_ANGLE_DEG <= f->top)) {
        return pel_fault_refuse(
            PEL_ERR_INVALID, path, NULL,
            "needs left < right and bottom < top, 0.01 deg apart", fault);
    }
    return PEL_OK;
}

static enum pel_err check_meter(const Pelagos__State *state,
                                const Pelagos__View *view,
                                struct pel_fault *fault)
{
    char path[PATH_SIZE];
    g_snprintf(path, sizeof path, "views.%s.meter", view->name);
    if (!good_view_name(view->meter)) {
        return pel_fault_refuse(PEL_ERR_INVALID, path, view->meter,
                                "needs a name of 1 to 64 of A-Z a-z 0-9 _ -",
                                fault);
    }
    int alike = 0;
    for (size_t i = 0; i < state->n_views; i++) {
        alike += state->views[i]->meter &&
                 strcmp(state->views[i]->meter, view->meter) == 0;
    }
    return alike <= PEL_METER_SIGHTS
               ? PEL_OK
               : pel_fault_refuse(PEL_ERR_CONFLICT, path, view->meter,
                                  "is the meter of more than 12 views", fault);
}

static enum pel_err check_view(const Pelagos__State *state, size_t index,
                               struct pel_lookup *entities,
                               struct pel_fault *fault)
{
    const Pelagos__View *view = state->views[index];
    char path[PATH_SIZE], value[24], what[96];
    if (!view->name || !good_view_name(view->name)) {
        return pel_fault_refuse(PEL_ERR_INVALID, "views", view->name,
                                "needs names of 1 to 64 of A-Z a-z 0-9 _ -",
                                fault);
    }
    if (view->has_entity) {
        Pelagos__Entity like = PELAGOS__ENTITY__INIT;
        like.has_id = true;
        like.id = view->entity;
        if (!pel_lookup_find(entities, &like.base)) {
            g_snprintf(path, sizeof path, "views.%s.entity", view->name);
            g_snprintf(value, sizeof value, "%u", view->entity);
            g_snprintf(what, sizeof what,
                       "names entity %u, which is not there: add it, or give "
                       "the view another",
                       view->entity);
            return pel_fault_refuse(PEL_ERR_CONFLICT, path, value, what, fault);
        }
    }
    enum pel_err placed = pel_view_place_check(state, view, fault);
    if (placed) {
        return placed;
    }
    if (view->meter) {
        enum pel_err err = check_meter(state, view, fault);
        if (err) {
            return err;
        }
    }
    if ((double)view->width * view->height > MAX_PIXELS) {
        g_snprintf(path, sizeof path, "views.%s.width", view->name);
        return pel_fault_refuse(PEL_ERR_OUT_OF_RANGE, path, NULL,
                                "times height is more than 16777216 pixels",
                                fault);
    }
    return view->frustum ? check_frustum(view, fault) : PEL_OK;
}

/* Each ship has one helm. */
static enum pel_err check_helm(const Pelagos__State *state,
                               const Pelagos__Entity *entity,
                               struct pel_fault *fault)
{
    const Pelagos__OwnShip *own = state->own_ship;
    char path[PATH_SIZE], value[24];
    if (entity->helm->entity != entity->id) {
        g_snprintf(path, sizeof path, "entities.%u.helm.entity", entity->id);
        g_snprintf(value, sizeof value, "%u", entity->helm->entity);
        return pel_fault_refuse(PEL_ERR_INVALID, path, value,
                                "is the entity that has the helm: leave it out",
                                fault);
    }
    if (entity->helm->on && own && own->on && own->entity == entity->id) {
        g_snprintf(path, sizeof path, "entities.%u.helm.on", entity->id);
        return pel_fault_refuse(PEL_ERR_CONFLICT, path, "true",
                                "is a second helm: ownShip sails this entity",
                                fault);
    }
    return PEL_OK;
}

static enum pel_err check_entity(const Pelagos__State *state, size_t index,
                                 struct pel_fault *fault)
{
    const Pelagos__Entity *entity = state->entities[index];
    if (!entity->has_id) {
        return pel_fault_refuse(PEL_ERR_INVALID, "entities", entity->name,
                                "needs an id for each element", fault);
    }
    if (entity->model && (!entity->model->name || !*entity->model->name)) {
        char path[PATH_SIZE];
        g_snprintf(path, sizeof path, "entities.%u.model.name", entity->id);
        return pel_fault_refuse(PEL_ERR_INVALID, path, NULL,
                                "needs the name of a model; GET /v1/models or "
                                "pelagosctl models lists them",
                                fault);
    }
    enum pel_err err = pel_lamps_check(entity, fault);
    return !err && entity->helm ? check_helm(state, entity, fault) : err;
}

static enum pel_err check_ships(const Pelagos__State *state,
                                struct pel_fault *fault)
{
    size_t count = 0;
    for (size_t i = 0; i < state->n_entities; i++) {
        count += pel_helm_on(state, state->entities[i]) != NULL;
    }
    return count <= PEL_MAX_SHIPS
               ? PEL_OK
               : pel_fault_refuse(PEL_ERR_OUT_OF_RANGE, "entities", NULL,
                                  "would have more than 8 helms that are on",
                                  fault);
}

static enum pel_err check_utc(const Pelagos__Clock *clock,
                              struct pel_fault *fault)
{
    double unix_s;
    enum pel_err err = pel_utc_parse(clock->utc, &unix_s);
    if (err == PEL_ERR_OUT_OF_RANGE) {
        return pel_fault_refuse(err, "clock.utc", clock->utc,
                                "must be in the years 1900 to 2100", fault);
    }
    return err ? pel_fault_refuse(err, "clock.utc", clock->utc,
                                  "must be ISO 8601 with its zone, like "
                                  "2026-06-21T12:00:00Z",
                                  fault)
               : PEL_OK;
}

/* All of `count` values, or none: *present says which. */
static bool whole(const protobuf_c_boolean *const has[], int count,
                  bool *present)
{
    int found = 0;
    for (int i = 0; i < count; i++) {
        found += *has[i] ? 1 : 0;
    }
    *present = found > 0;
    return found == 0 || found == count;
}

static enum pel_err check_water(const Pelagos__Water *w,
                                struct pel_fault *fault)
{
    const protobuf_c_boolean *const coefficients[] = {
        &w->has_absorption_680, &w->has_absorption_550, &w->has_absorption_440,
        &w->has_scattering_680, &w->has_scattering_550, &w->has_scattering_440,
    };
    const protobuf_c_boolean *const albedos[] = {
        &w->has_albedo_680,
        &w->has_albedo_550,
        &w->has_albedo_440,
    };
    bool direct, given;
    if (!whole(coefficients, 6, &direct)) {
        return pel_fault_refuse(
            PEL_ERR_INVALID, "water", NULL,
            "needs absorption and scattering at all of 680, 550 and "
            "440 nm, or none of the six",
            fault);
    }
    if (!whole(albedos, 3, &given)) {
        return pel_fault_refuse(
            PEL_ERR_INVALID, "water", NULL,
            "needs albedo at all of 680, 550 and 440 nm, or none", fault);
    }
    if (direct + (w->has_jerlov != 0) + (w->has_named != 0) > 1) {
        return pel_fault_refuse(
            PEL_ERR_CONFLICT, "water", NULL,
            "is described twice: only one of jerlov, named, and "
            "absorption with scattering; remove the other",
            fault);
    }
    return PEL_OK;
}

static enum pel_err check_seabed(const Pelagos__Seabed *s,
                                 struct pel_fault *fault)
{
    const protobuf_c_boolean *const place[] = {
        &s->has_latitude,
        &s->has_longitude,
        &s->has_spacing,
    };
    bool given;
    return whole(place, 3, &given)
               ? PEL_OK
               : pel_fault_refuse(
                     PEL_ERR_INVALID, "seabed", NULL,
                     "needs all of latitude, longitude and spacing, or none",
                     fault);
}

int pel_corners_parse(const char *text, struct pel_vec2 *out)
{
    int count = 0;
    while (*text) {
        double v[2];
        for (int k = 0; k < 2; k++) {
            char *end;
            v[k] = g_ascii_strtod(text, &end);
            if (end == text || !(fabs(v[k]) <= 1e5)) {
                return -1;
            }
            text = end + (k == 0 && *end == ':');
        }
        if (count == PEL_AREA_CORNERS) {
            return -1;
        }
        out[count++] = (struct pel_vec2){ v[0], v[1] };
        text += strspn(text, " ");
        if (*text && *text++ != ',') {
            return -1;
        }
    }
    return count == 0 || count >= 3 ? count : -1;
}

static enum pel_err check_areas(const Pelagos__Sea *sea,
                                struct pel_fault *fault)
{
    enum pel_err err =
        check_count(sea->n_areas, PEL_SEA_MAX_AREAS, "sea.areas", fault);
    for (size_t i = 0; !err && i < sea->n_areas; i++) {
        struct pel_vec2 corners[PEL_AREA_CORNERS];
        const char *text = sea->areas[i]->corners;
        if (text && pel_corners_parse(text, corners) < 0) {
            char path[32];
            g_snprintf(path, sizeof path, "sea.areas.%zu.corners", i);
            err = pel_fault_refuse(
                PEL_ERR_INVALID, path, text,
                "must be 3 to 16 corners, as 0 0, 400 0, 300 150", fault);
        }
    }
    return err;
}

/* Weather that leads the sea. */
static enum pel_err check_field(const Pelagos__Sea *sea,
                                struct pel_fault *fault)
{
    if (!sea->field || !sea->field->file || !*sea->field->file) {
        return PEL_OK;
    }
    if (sea->synthesiser != PELAGOS__SYNTHESISER__FFT) {
        return pel_fault_refuse(PEL_ERR_CONFLICT, "sea.synthesiser",
                                "TROCHOIDS",
                                "has other waves for each weather: with "
                                "sea.field.file it must be FFT",
                                fault);
    }
    return sea->spectrum == PELAGOS__SPECTRUM_KIND__JONSWAP ||
                   sea->spectrum == PELAGOS__SPECTRUM_KIND__ELFOUHAILY
               ? PEL_OK
               : pel_fault_refuse(PEL_ERR_CONFLICT, "sea.spectrum", NULL,
                                  "has no fetch that gives the wind sea its "
                                  "height: with sea.field.file set it to "
                                  "ELFOUHAILY or JONSWAP",
                                  fault);
}

static enum pel_err check_fog(const Pelagos__Sky *sky, struct pel_fault *fault)
{
    enum pel_err err = check_count(sky->n_fog, PEL_FOG_MAX, "sky.fog", fault);
    for (size_t i = 0; !err && i < sky->n_fog; i++) {
        const Pelagos__Fog *f = sky->fog[i];
        if (f->top < f->bottom + 1) {
            char path[32], value[32];
            g_snprintf(path, sizeof path, "sky.fog.%zu.top", i);
            g_snprintf(value, sizeof value, "%g", f->top);
            err = pel_fault_refuse(PEL_ERR_INVALID, path, value,
                                   "must be 1 m above its bottom at least",
                                   fault);
        }
    }
    return err;
}

static void find_by_keys(struct pel_lookup *lookup, const Pelagos__State *state,
                         const char *list)
{
    pel_lookup_begin(
        lookup, &state->base,
        pel_field_by_name(&pelagos__state__descriptor, list, strlen(list)));
}

/* Entities, and the views that may name them. */
static enum pel_err check_keyed(const Pelagos__State *state,
                                struct pel_fault *fault)
{
    struct pel_lookup entities, views;
    enum pel_err err = PEL_OK;
    for (size_t i = 0; !err && i < state->n_entities; i++) {
        err = check_entity(state, i, fault);
    }
    find_by_keys(&entities, state, "entities");
    const ProtobufCMessage *twin = err ? NULL : pel_lookup_twin(&entities);
    if (twin) {
        char value[24];
        g_snprintf(value, sizeof value, "%u",
                   ((const Pelagos__Entity *)twin)->id);
        return pel_fault_refuse(PEL_ERR_CONFLICT, "entities", value,
                                "has an id twice", fault);
    }
    for (size_t i = 0; !err && i < state->n_views; i++) {
        err = check_view(state, i, &entities, fault);
    }
    find_by_keys(&views, state, "views");
    twin = err ? NULL : pel_lookup_twin(&views);
    return twin ? pel_fault_refuse(PEL_ERR_CONFLICT, "views",
                                   ((const Pelagos__View *)twin)->name,
                                   "has a name twice", fault)
                : err;
}

enum pel_err pel_state_check(const Pelagos__State *state,
                             struct pel_fault *fault)
{
    enum pel_err err =
        check_count(state->n_views, PEL_MAX_VIEWS, "views", fault);
    if (!err) {
        err =
            check_count(state->n_entities, PEL_MAX_ENTITIES, "entities", fault);
    }
    if (!err && state->sea) {
        err = check_count(state->sea->n_swell, PEL_SEA_MAX_SWELLS, "sea.swell",
                          fault);
    }
    if (!err && state->sea) {
        err = check_count(state->sea->n_wave, PEL_SEA_MAX_SINGLES, "sea.wave",
                          fault);
    }
    if (!err && state->sea) {
        err = check_areas(state->sea, fault);
    }
    if (!err && state->sea) {
        err = check_field(state->sea, fault);
    }
    if (!err && state->sky) {
        err = check_fog(state->sky, fault);
    }
    if (!err && state->exercise) {
        err = check_count(state->exercise->n_events, PEL_BOUND_EXERCISE_EVENTS,
                          "exercise.events", fault);
    }
    for (size_t i = 0; !err && i < state->n_views; i++) {
        err = check_count(state->views[i]->n_waypoints, PEL_WAYPOINTS_MOST,
                          "views.waypoints", fault);
    }
    for (size_t i = 0; !err && i < state->n_entities; i++) {
        err = check_count(state->entities[i]->n_track, PEL_TRACK_MOST,
                          "entities.track", fault);
    }
    if (!err) {
        err = pel_message_check(&state->base, "", fault);
    }
    if (!err && state->clock) {
        err = check_utc(state->clock, fault);
    }
    if (!err && state->water) {
        err = check_water(state->water, fault);
    }
    if (!err && state->seabed) {
        err = check_seabed(state->seabed, fault);
    }
    if (!err) {
        err = check_keyed(state, fault);
    }
    if (!err) {
        err = check_ships(state, fault);
    }
    if (!err) {
        err = pel_presets_check(state, fault);
    }
    return err;
}
