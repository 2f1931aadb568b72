#include "bridges/cigi_world.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/vec.h"
#include "bridges/cigi_pose.h"
#include "path.h"

#define NEW_VIEW_HALF_DEG 30.0 /* the schema's field of view of 60 */

void pel_cigi_world_init(struct pel_cigi_world *world)
{
    *world = (struct pel_cigi_world){
        .air_temperature = 15,
        .pressure = 1013.25,
        .water_temperature = 15,
    };
}

/* Paths of the schema and of entities that are there: nothing to refuse. */
static void set_number(Pelagos__Patch *patch, const Pelagos__State *scene,
                       const char *path, double value)
{
    struct pel_fault fault;
    if (pel_path_set_number(patch, scene, path, value, &fault) != PEL_OK) {
        pel_warn("CIG-011", "a value from CIGI was not set: %s: %s", path,
                 fault.message);
    }
}

Pelagos__Patch *pel_cigi_world_end(const struct pel_cigi_world *world,
                                   const Pelagos__State *scene,
                                   enum pel_clock_mode mode)
{
    static const char *const rates[] = { "speed", "turnRate", "climbRate",
                                         "pitchRate", "rollRate" };
    Pelagos__Patch *patch = pel_patch_new();
    char path[48];
    set_number(patch, scene, "clock.mode", mode);
    for (size_t i = 0; i < scene->n_entities; i++) {
        bool rated = false;
        for (size_t k = 0; k < world->rated_count; k++) {
            rated = rated || world->rated[k] == scene->entities[i]->id;
        }
        if (rated) {
            for (size_t k = 0; k < sizeof rates / sizeof *rates; k++) {
                snprintf(path, sizeof path, "entities.%u.%s",
                         scene->entities[i]->id, rates[k]);
                set_number(patch, scene, path, 0);
            }
        }
    }
    return patch;
}

void pel_cigi_edit_begin(struct pel_cigi_edit *edit,
                         struct pel_cigi_world *world,
                         const Pelagos__State *scene,
                         const struct pel_snapshot *snapshot, double time_s,
                         bool lead)
{
    edit->world = world;
    edit->scene = scene;
    edit->snapshot = snapshot;
    edit->time_s = time_s;
    edit->refused = false;
    edit->skipped = 0;
    edit->searchlight_count = 0;
    pelagos__patch__init(&edit->patch);
    pelagos__state__init(&edit->state);
    pelagos__clock__init(&edit->clock);
    pelagos__sea__init(&edit->sea);
    pelagos__water__init(&edit->water);
    pelagos__sky__init(&edit->sky);
    edit->patch.state = &edit->state;
    edit->patch.remove = edit->removal_list;
    edit->state.entities = edit->entity_list;
    edit->state.views = edit->view_list;
    edit->sea.swell = edit->swell_list;
    edit->sea.wave = edit->wave_list;
    edit->sea.areas = edit->area_list;
    edit->sky.fog = edit->fog_list;
    if (lead) {
        edit->clock.has_mode = true;
        edit->clock.mode = PELAGOS__CLOCK_MODE__HOST;
        edit->state.clock = &edit->clock;
    }
}

Pelagos__Entity *pel_cigi_edit_entity(struct pel_cigi_edit *edit, uint32_t id)
{
    size_t count = edit->state.n_entities;
    for (size_t i = 0; i < count; i++) {
        if (edit->entity_list[i]->id == id) {
            return edit->entity_list[i];
        }
    }
    if (count == PEL_MAX_ENTITIES) {
        edit->refused = true;
        return NULL;
    }
    Pelagos__Entity *entity = &edit->entities[count];
    pelagos__entity__init(entity);
    entity->has_id = true;
    entity->id = id;
    edit->entity_list[count] = entity;
    edit->state.n_entities++;
    return entity;
}

void pel_cigi_edit_remove(struct pel_cigi_edit *edit, const char *format, ...)
{
    size_t count = edit->patch.n_remove;
    if (count == PEL_CIGI_REMOVALS) {
        edit->refused = true;
        return;
    }
    va_list args;
    va_start(args, format);
    vsnprintf(edit->removals[count], sizeof edit->removals[count], format,
              args);
    va_end(args);
    edit->removal_list[count] = edit->removals[count];
    edit->patch.n_remove++;
}

/* --- views --------------------------------------------------------------- */

void pel_cigi_view_name(const struct pel_snapshot *s, unsigned id,
                        char out[PEL_NAME_SIZE])
{
    snprintf(out, PEL_NAME_SIZE, "cigi-%u", id);
    if (id == 0 && s->view_count > 0 && pel_snapshot_find_view(s, out) < 0) {
        memcpy(out, s->views[0].name, PEL_NAME_SIZE);
    }
}

static Pelagos__View *view_called(struct pel_cigi_edit *edit, const char *name)
{
    size_t count = edit->state.n_views;
    for (size_t i = 0; i < count; i++) {
        if (strcmp(edit->view_list[i]->name, name) == 0) {
            return edit->view_list[i];
        }
    }
    if (count == PEL_MAX_VIEWS) {
        edit->refused = true;
        return NULL;
    }
    Pelagos__View *view = &edit->views[count];
    pelagos__view__init(view);
    snprintf(edit->view_names[count], PEL_NAME_SIZE, "%s", name);
    view->name = edit->view_names[count];
    edit->view_list[count] = view;
    edit->state.n_views++;
    return view;
}

Pelagos__View *pel_cigi_edit_view(struct pel_cigi_edit *edit, unsigned id)
{
    char name[PEL_NAME_SIZE];
    pel_cigi_view_name(edit->snapshot, id, name);
    return view_called(edit, name);
}

struct pel_cigi_view_memo *pel_cigi_edit_memo(struct pel_cigi_edit *edit,
                                              unsigned id)
{
    struct pel_cigi_view_memo *spare = NULL;
    for (size_t i = 0; i < PEL_CIGI_VIEWS; i++) {
        struct pel_cigi_view_memo *memo = &edit->world->views[i];
        if (memo->used && memo->id == id) {
            return memo;
        }
        spare = !memo->used && !spare ? memo : spare;
    }
    if (spare) {
        *spare = (struct pel_cigi_view_memo){ .used = true, .id = id };
    }
    return spare;
}

static void control_view(struct pel_cigi_edit *edit, unsigned id,
                         const struct pel_cigi_packet *p)
{
    struct pel_cigi_view_memo *memo = pel_cigi_edit_memo(edit, id);
    Pelagos__View *view = memo ? pel_cigi_edit_view(edit, id) : NULL;
    if (!view) {
        edit->skipped++;
        return;
    }
    const struct {
        enum pel_cigi_field enable, value;
        double sign;
        protobuf_c_boolean *has;
        double *to;
    } parts[] = {
        { PEL_CIGI_VIEW_CONTROL_X_ENABLE, PEL_CIGI_VIEW_CONTROL_X, 1,
          &view->has_forward, &view->forward },
        { PEL_CIGI_VIEW_CONTROL_Y_ENABLE, PEL_CIGI_VIEW_CONTROL_Y, 1,
          &view->has_right, &view->right },
        { PEL_CIGI_VIEW_CONTROL_Z_ENABLE, PEL_CIGI_VIEW_CONTROL_Z, -1,
          &view->has_up, &view->up },
        { PEL_CIGI_VIEW_CONTROL_ROLL_ENABLE, PEL_CIGI_VIEW_CONTROL_ROLL, 1,
          &view->has_roll, &view->roll },
        { PEL_CIGI_VIEW_CONTROL_PITCH_ENABLE, PEL_CIGI_VIEW_CONTROL_PITCH, 1,
          &view->has_pitch, &view->pitch },
        { PEL_CIGI_VIEW_CONTROL_YAW_ENABLE, PEL_CIGI_VIEW_CONTROL_YAW, 1,
          &view->has_yaw, &view->yaw },
    };
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        if (pel_cigi_get(p, parts[i].enable) != 0) {
            *parts[i].has = true;
            *parts[i].to = parts[i].sign * pel_cigi_get(p, parts[i].value);
        }
    }
    memo->wants_entity = true;
    memo->entity = (uint32_t)pel_cigi_get(p, PEL_CIGI_VIEW_CONTROL_ENTITY);
}

static void take_view_control(struct pel_cigi_edit *edit,
                              const struct pel_cigi_packet *p)
{
    unsigned group = (unsigned)pel_cigi_get(p, PEL_CIGI_VIEW_CONTROL_GROUP);
    if (group == 0) {
        control_view(edit,
                     (unsigned)pel_cigi_get(p, PEL_CIGI_VIEW_CONTROL_VIEW), p);
        return;
    }
    bool found = false;
    for (size_t i = 0; i < PEL_CIGI_VIEWS; i++) {
        const struct pel_cigi_view_memo *memo = &edit->world->views[i];
        if (memo->used && memo->group == group) {
            control_view(edit, memo->id, p);
            found = true;
        }
    }
    edit->skipped += !found;
}

void pel_cigi_edit_reset(struct pel_cigi_edit *edit)
{
    for (size_t i = 0; i < PEL_CIGI_VIEWS; i++) {
        const struct pel_cigi_view_memo *memo = &edit->world->views[i];
        char name[PEL_NAME_SIZE];
        pel_cigi_view_name(edit->snapshot, memo->id, name);
        if (memo->used && memo->has_sensor &&
            pel_snapshot_find_view(edit->snapshot, name) >= 0) {
            pel_cigi_edit_remove(edit, "views.%s.sensor", name);
        }
    }
    /* What was commanded ends: pel_cigi_apply_conditions takes it back. */
    const struct pel_cigi_conditions applied = edit->world->applied;
    const struct pel_cigi_before before = edit->world->before;
    const size_t fog_count = edit->world->fog_count;
    const bool clouded = edit->world->clouded;
    if (edit->world->lightning_layer) {
        edit->sky.has_lightning = true;
        edit->sky.lightning = 0;
        edit->state.sky = &edit->sky;
    }
    pel_cigi_world_init(edit->world);
    edit->world->applied = applied;
    edit->world->before = before;
    edit->world->fog_count = fog_count;
    edit->world->clouded = clouded;
}

/* The frustum the view has now, degrees. */
static void present_frustum(const struct pel_cigi_edit *edit, const char *name,
                            Pelagos__Frustum *out)
{
    int index = pel_snapshot_find_view(edit->snapshot, name);
    double side = tan(NEW_VIEW_HALF_DEG * PEL_DEG), top = side * 9 / 16;
    struct pel_view_state v = {
        .tan_left = -side, .tan_right = side, .tan_top = top, .tan_bottom = -top
    };
    if (index >= 0) {
        v = edit->snapshot->views[index];
    }
    pelagos__frustum__init(out);
    out->has_left = out->has_right = out->has_top = out->has_bottom = true;
    out->left = atan(v.tan_left) / PEL_DEG;
    out->right = atan(v.tan_right) / PEL_DEG;
    out->top = atan(v.tan_top) / PEL_DEG;
    out->bottom = atan(v.tan_bottom) / PEL_DEG;
}

static void take_view_definition(struct pel_cigi_edit *edit,
                                 const struct pel_cigi_packet *p)
{
    unsigned id = (unsigned)pel_cigi_get(p, PEL_CIGI_VIEW_DEFINITION_VIEW);
    struct pel_cigi_view_memo *memo = pel_cigi_edit_memo(edit, id);
    Pelagos__View *view = memo ? pel_cigi_edit_view(edit, id) : NULL;
    if (!view) {
        edit->skipped++;
        return;
    }
    memo->group = (unsigned)pel_cigi_get(p, PEL_CIGI_VIEW_DEFINITION_GROUP);
    Pelagos__Frustum *f = &edit->frusta[view - edit->views];
    if (!view->frustum) {
        present_frustum(edit, view->name, f);
    }
    const struct {
        enum pel_cigi_field enable, value;
        double *to;
    } sides[] = {
        { PEL_CIGI_VIEW_DEFINITION_LEFT_ENABLE, PEL_CIGI_VIEW_DEFINITION_LEFT,
          &f->left },
        { PEL_CIGI_VIEW_DEFINITION_RIGHT_ENABLE, PEL_CIGI_VIEW_DEFINITION_RIGHT,
          &f->right },
        { PEL_CIGI_VIEW_DEFINITION_TOP_ENABLE, PEL_CIGI_VIEW_DEFINITION_TOP,
          &f->top },
        { PEL_CIGI_VIEW_DEFINITION_BOTTOM_ENABLE,
          PEL_CIGI_VIEW_DEFINITION_BOTTOM, &f->bottom },
    };
    for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
        if (pel_cigi_get(p, sides[i].enable) != 0) {
            *sides[i].to = pel_cigi_get(p, sides[i].value);
            view->frustum = f;
        }
    }
}

bool pel_cigi_entity_will_be(const struct pel_cigi_edit *edit, uint32_t id)
{
    for (size_t i = 0; i < edit->state.n_entities; i++) {
        if (edit->entity_list[i]->id == id) {
            return true;
        }
    }
    char path[32];
    snprintf(path, sizeof path, "entities.%u", id);
    for (size_t i = 0; i < edit->patch.n_remove; i++) {
        if (strcmp(edit->removal_list[i], path) == 0) {
            return false;
        }
    }
    return pel_cigi_find_entity(edit->snapshot, id) >= 0;
}

/* CIGI's own ship is entity 0: when the host first brings it, the views on the
 * scene's own ship go over to it, unless it has an entity 0 of its own. */
static void board_own_ship(struct pel_cigi_edit *edit)
{
    const struct pel_snapshot *s = edit->snapshot;
    if (pel_cigi_find_entity(s, 0) >= 0 || !pel_cigi_entity_will_be(edit, 0)) {
        return;
    }
    for (size_t i = 0; i < s->view_count; i++) {
        int on = s->views[i].entity;
        if (on >= 0 && s->entities[on].id == edit->scene->own_ship->entity) {
            Pelagos__View *view = view_called(edit, s->views[i].name);
            if (view) {
                view->has_entity = true;
                view->entity = 0;
            }
        }
    }
}

/* An entity carries it from now on, wherever it stood. */
static void take_from_place(struct pel_cigi_edit *edit, const char *name)
{
    static const char *const paths[] = {
        [PEL_STAND_AT] = "views.%s.at",
        [PEL_STAND_ORBIT] = "views.%s.orbit",
        [PEL_STAND_SATELLITE] = "views.%s.satellite",
        [PEL_STAND_WAY] = "views.%s.waypoints",
    };
    int index = pel_snapshot_find_view(edit->snapshot, name);
    enum pel_stand stand = index < 0 ? PEL_STAND_CARRIED
                                     : edit->snapshot->views[index].place.stand;
    if (stand != PEL_STAND_CARRIED) {
        pel_cigi_edit_remove(edit, paths[stand], name);
    }
}

/* Views whose entity is there by now are hung on it. */
static void hang_views(struct pel_cigi_edit *edit)
{
    for (size_t i = 0; i < PEL_CIGI_VIEWS; i++) {
        struct pel_cigi_view_memo *memo = &edit->world->views[i];
        if (!memo->used || !memo->wants_entity ||
            !pel_cigi_entity_will_be(edit, memo->entity)) {
            continue;
        }
        Pelagos__View *view = pel_cigi_edit_view(edit, memo->id);
        if (view) {
            view->has_entity = true;
            view->entity = memo->entity;
            memo->wants_entity = false;
            take_from_place(edit, view->name);
        }
    }
}

/* The entity goes: a view on it, or on an orbit about it, stays where it is
 * now; one that looks at it looks ahead. */
static void free_views(struct pel_cigi_edit *edit, uint32_t id)
{
    const struct pel_snapshot *s = edit->snapshot;
    for (size_t i = 0; i < s->view_count; i++) {
        const struct pel_view_place *place = &s->views[i].place;
        int on = s->views[i].entity, about = place->about;
        bool circles = about >= 0 && s->entities[about].id == id;
        if (place->target >= 0 && s->entities[place->target].id == id) {
            pel_cigi_edit_remove(edit, "views.%s.lookAt", s->views[i].name);
        }
        if (!circles && (on < 0 || s->entities[on].id != id)) {
            continue;
        }
        struct pel_camera c;
        double heading, pitch, roll;
        pel_snapshot_camera(s, i, edit->time_s, 0, 0, &c);
        struct pel_mat3 axes = { pel_vec3_scale(c.world_from_camera.z, -1),
                                 c.world_from_camera.x,
                                 pel_vec3_scale(c.world_from_camera.y, -1) };
        pel_cigi_angles(&axes, &heading, &pitch, &roll);
        Pelagos__View *view = view_called(edit, s->views[i].name);
        if (!view) {
            return;
        }
        pel_cigi_edit_remove(
            edit, circles ? "views.%s.orbit" : "views.%s.entity", view->name);
        view->has_entity = false;
        view->has_forward = view->has_right = view->has_up = true;
        view->has_yaw = view->has_pitch = view->has_roll = true;
        view->forward = pel_clamp(c.north_m, -1e5, 1e5);
        view->right = pel_clamp(c.east_m, -1e5, 1e5);
        view->up = c.altitude_m;
        view->yaw = heading / PEL_DEG;
        view->pitch = pitch / PEL_DEG;
        view->roll = roll / PEL_DEG;
    }
}

static void forget_entity(struct pel_cigi_edit *edit, uint32_t id)
{
    for (size_t i = 0; i < PEL_CIGI_FOLLOWERS; i++) {
        struct pel_cigi_follower *f = &edit->world->followers[i];
        f->used = f->used && f->id != id;
    }
    for (size_t i = 0; i < edit->state.n_entities; i++) {
        if (edit->entities[i].id == id) {
            edit->entities[i] = edit->entities[--edit->state.n_entities];
            break;
        }
    }
}

static void destroy_one(struct pel_cigi_edit *edit, uint32_t id)
{
    forget_entity(edit, id);
    if (pel_cigi_find_entity(edit->snapshot, id) >= 0 &&
        pel_cigi_entity_will_be(edit, id)) {
        free_views(edit, id);
        pel_cigi_edit_remove(edit, "entities.%u", id);
    }
}

/* With all that hangs on it. */
static void destroy_entity(struct pel_cigi_edit *edit, uint32_t id)
{
    uint32_t doomed[PEL_CIGI_FOLLOWERS + 1] = { id };
    size_t count = 1;
    for (size_t next = 0; next < count; next++) {
        for (size_t i = 0; i < PEL_CIGI_FOLLOWERS; i++) {
            struct pel_cigi_follower *f = &edit->world->followers[i];
            if (f->used && f->how == PEL_CIGI_ON_PARENT &&
                f->parent == doomed[next] && f->id != id) {
                doomed[count++] = f->id;
                f->used = false;
            }
        }
    }
    while (count > 0) {
        destroy_one(edit, doomed[--count]);
    }
}

/* --- all ----------------------------------------------------------------- */

void pel_cigi_edit_take(struct pel_cigi_edit *edit,
                        const struct pel_cigi_packet *p)
{
    switch (p->kind) {
    case PEL_CIGI_KIND_ENTITY_CONTROL:
        if (pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_STATE) == 2) {
            destroy_entity(
                edit, (uint32_t)pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_ID));
        } else {
            pel_cigi_take_entity(edit, p);
        }
        break;
    case PEL_CIGI_KIND_CONFORMAL:
        pel_cigi_take_conformal(edit, p);
        break;
    case PEL_CIGI_KIND_RATE:
        pel_cigi_take_rate(edit, p);
        break;
    case PEL_CIGI_KIND_VIEW_CONTROL:
        take_view_control(edit, p);
        break;
    case PEL_CIGI_KIND_VIEW_DEFINITION:
        take_view_definition(edit, p);
        break;
    case PEL_CIGI_KIND_SENSOR:
        pel_cigi_take_sensor(edit, p);
        break;
    default:
        pel_cigi_take_environment(edit, p);
        break;
    }
}

static const Pelagos__Patch *whole(const struct pel_cigi_edit *edit)
{
    bool any = edit->state.clock || edit->state.sea || edit->state.water ||
               edit->state.sky || edit->state.n_entities > 0 ||
               edit->state.n_views > 0 || edit->patch.n_remove > 0;
    return any ? &edit->patch : NULL;
}

const Pelagos__Patch *pel_cigi_edit_end(struct pel_cigi_edit *edit)
{
    pel_cigi_place_followers(edit);
    pel_cigi_apply_conditions(edit);
    board_own_ship(edit);
    hang_views(edit);
    return whole(edit);
}

const Pelagos__Patch *pel_cigi_edit_split(struct pel_cigi_edit *edit,
                                          const Pelagos__Patch **rest)
{
    size_t kept = 0;
    pelagos__patch__init(&edit->sea_patch);
    pelagos__state__init(&edit->sea_state);
    edit->sea_patch.state = &edit->sea_state;
    edit->sea_patch.remove = edit->sea_removals;
    edit->sea_state.sea = edit->state.sea;
    edit->state.sea = NULL;
    for (size_t i = 0; i < edit->patch.n_remove; i++) {
        char *path = edit->removal_list[i];
        if (strncmp(path, "sea.", 4) == 0) {
            edit->sea_removals[edit->sea_patch.n_remove++] = path;
        } else {
            edit->removal_list[kept++] = path;
        }
    }
    edit->patch.n_remove = kept;
    *rest = whole(edit);
    return edit->sea_state.sea || edit->sea_patch.n_remove > 0
               ? &edit->sea_patch
               : NULL;
}
