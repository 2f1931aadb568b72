/* Patches that put a scene into another state as a whole. */
#include <stdlib.h>
#include <string.h>

#include "message.h"
#include "scene/exercise_parts.h"
#include "scene/helm.h"

static void empty(struct pel_exercise_beginning *out, const Pelagos__State *to)
{
    pelagos__patch__init(&out->patch);
    out->remove = g_ptr_array_new_with_free_func(g_free);
    out->patch.state =
        to ? (Pelagos__State *)pel_message_copy(&to->base)
           : (Pelagos__State *)pel_message_new(&pelagos__state__descriptor);
    out->patch.state->has_revision = false;
}

static void removes(struct pel_exercise_beginning *out, const char *path)
{
    g_ptr_array_add(out->remove, g_strdup(path));
}

static void seal(struct pel_exercise_beginning *out)
{
    out->patch.n_remove = out->remove->len;
    out->patch.remove = (char **)out->remove->pdata;
}

void pel_exercise_beginning_finish(struct pel_exercise_beginning *beginning)
{
    pelagos__state__free_unpacked(beginning->patch.state, NULL);
    g_ptr_array_free(beginning->remove, TRUE);
}

static bool has_entity(const Pelagos__State *state, uint32_t id)
{
    for (size_t i = 0; i < state->n_entities; i++) {
        if (state->entities[i]->has_id && state->entities[i]->id == id) {
            return true;
        }
    }
    return false;
}

static const Pelagos__View *view_of(const Pelagos__State *state,
                                    const char *name)
{
    for (size_t i = 0; i < state->n_views; i++) {
        if (state->views[i]->name && strcmp(state->views[i]->name, name) == 0) {
            return state->views[i];
        }
    }
    return NULL;
}

static Pelagos__Clock *clock_of(Pelagos__State *state)
{
    if (!state->clock) {
        state->clock =
            (Pelagos__Clock *)pel_message_new(&pelagos__clock__descriptor);
    }
    return state->clock;
}

/* Views on entities that are not there any more cannot stay; those that come
 * are made anew. */
static void remove_views(const Pelagos__State *to, const Pelagos__State *from,
                         struct pel_exercise_beginning *out)
{
    for (size_t i = 0; i < from->n_views; i++) {
        const Pelagos__View *view = from->views[i];
        if (view_of(to, view->name) ||
            (view->has_entity && !has_entity(to, view->entity))) {
            g_ptr_array_add(out->remove,
                            g_strdup_printf("views.%s", view->name));
        }
    }
}

static void remove_parts(struct pel_exercise_beginning *out)
{
    static const char *const parts[] = {
        "clock.utc", "clock.reckoning", "origin",  "sea",      "water",
        "sky",       "seabed",          "ownShip", "entities", "exercise"
    };
    for (size_t i = 0; i < G_N_ELEMENTS(parts); i++) {
        removes(out, parts[i]);
    }
}

void pel_exercise_begin(const Pelagos__Exercise *exercise,
                        const Pelagos__State *from,
                        struct pel_exercise_beginning *out)
{
    empty(out, exercise->state);
    Pelagos__Clock *clock = clock_of(out->patch.state);
    remove_parts(out);
    if (exercise->state && exercise->state->n_views > 0) {
        removes(out, "views");
    } else {
        remove_views(out->patch.state, from, out);
    }
    if (!clock->has_time) {
        clock->has_time = true;
        clock->time = 0;
    }
    clock->has_mode = false;
    seal(out);
}

void pel_exercise_back(const Pelagos__State *to, const Pelagos__State *from,
                       struct pel_exercise_beginning *out)
{
    empty(out, to);
    clock_of(out->patch.state)->has_mode = false;
    if (out->patch.state->sources) {
        pelagos__sources__free_unpacked(out->patch.state->sources, NULL);
        out->patch.state->sources = NULL;
    }
    pel_message_clear(&out->patch.state->base,
                      protobuf_c_message_descriptor_get_field_by_name(
                          &pelagos__state__descriptor, "presets"));
    remove_parts(out);
    remove_views(to, from, out);
    seal(out);
}

/* --- ships under way --------------------------------------------------------
 */

/* A pose, as the state has it now. */
static void put_pose(const Pelagos__Entity *from, Pelagos__Entity *to)
{
    to->has_id = to->has_latitude = to->has_longitude = to->has_altitude = true;
    to->has_heading = to->has_pitch = to->has_roll = to->has_speed = true;
    to->has_course = to->has_turn_rate = to->has_pose_time = true;
    to->id = from->id;
    to->latitude = from->latitude;
    to->longitude = from->longitude;
    to->altitude = from->altitude;
    to->heading = from->heading;
    to->pitch = from->pitch;
    to->roll = from->roll;
    to->speed = from->speed;
    to->course = from->course;
    to->turn_rate = from->turn_rate;
    to->pose_time = from->pose_time;
}

static void put_rates(const Pelagos__OwnShip *from, Pelagos__OwnShip *to)
{
    to->has_on = to->has_heave_rate = to->has_pitch_rate = true;
    to->has_roll_rate = true;
    to->on = true;
    to->heave_rate = from->heave_rate;
    to->pitch_rate = from->pitch_rate;
    to->roll_rate = from->roll_rate;
}

static void put_helm(const Pelagos__State *state, const Pelagos__OwnShip *helm,
                     Pelagos__State *out, Pelagos__Entity *to)
{
    Pelagos__OwnShip *mine =
        (Pelagos__OwnShip *)pel_message_new(&pelagos__own_ship__descriptor);
    put_rates(helm, mine);
    if (helm == state->own_ship) {
        out->own_ship = mine;
    } else {
        to->helm = mine;
    }
}

void pel_exercise_put_ships(const Pelagos__State *state, Pelagos__State *out)
{
    const ProtobufCFieldDescriptor *list =
        protobuf_c_message_descriptor_get_field_by_name(out->base.descriptor,
                                                        "entities");
    for (size_t i = 0; i < state->n_entities; i++) {
        const Pelagos__OwnShip *helm = pel_helm_on(state, state->entities[i]);
        if (helm) {
            Pelagos__Entity *to =
                (Pelagos__Entity *)pel_message_append(&out->base, list);
            put_pose(state->entities[i], to);
            put_helm(state, helm, out, to);
        }
    }
}
