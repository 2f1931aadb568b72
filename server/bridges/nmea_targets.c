#include "bridges/nmea_targets.h"

#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/vec.h"
#include "bridges/nmea_fleet.h"
#include "bridges/nmea_out.h"
#include "scene/geodesy.h"

#define SECOND_NS 1000000000LL
#define AIS_LIFE_NS (600 * SECOND_NS)
#define RADAR_LIFE_NS (60 * SECOND_NS)
/* Two of the longest intervals of a position report, 3 min (at anchor, aids to
 * navigation): whose place a newcomer may take. */
#define STALE_NS (360 * SECOND_NS)
/* A position of 0.1 minute does not move a target that has a better one. */
#define FINE_NS (360 * SECOND_NS)
#define TLL_NS (10 * SECOND_NS)
#define MAX_SPEED_MPS 200
#define STEERAGE_MPS 0.5 /* below it a course says nothing of the heading */

static uint64_t key_of(bool radar, uint32_t number)
{
    return ((uint64_t)radar << 32 | number) + 1;
}

static bool is_radar(const struct pel_nmea_target *t)
{
    return (t->key - 1) >> 32 != 0;
}

/* --- names ---------------------------------------------------------------- */

static const struct pel_nmea_name *known_name(const struct pel_nmea_targets *t,
                                              uint64_t key)
{
    for (size_t i = 0; i < PEL_NMEA_NAMES; i++) {
        if (t->names[i].key == key) {
            return &t->names[i];
        }
    }
    return NULL;
}

static struct pel_nmea_target *find(struct pel_nmea_targets *t, uint64_t key)
{
    for (size_t i = 0; i < PEL_NMEA_TARGETS; i++) {
        if (t->targets[i].key == key) {
            return &t->targets[i];
        }
    }
    return NULL;
}

/* The place of what is said without a position. */
static struct pel_nmea_name *place_of_name(struct pel_nmea_targets *t,
                                           uint64_t key)
{
    struct pel_nmea_name *place = &t->names[0];
    for (size_t i = 0; i < PEL_NMEA_NAMES; i++) {
        if (t->names[i].key == key) {
            t->names[i].used = ++t->name_clock;
            return &t->names[i];
        }
        if (t->names[i].used < place->used) { /* a free one has 0 */
            place = &t->names[i];
        }
    }
    *place = (struct pel_nmea_name){ .key = key, .used = ++t->name_clock };
    return place;
}

static void keep_name(struct pel_nmea_targets *t, uint64_t key,
                      const char *name)
{
    struct pel_nmea_name *place = place_of_name(t, key);
    snprintf(place->name, sizeof place->name, "%s", name);
    struct pel_nmea_target *target = find(t, key);
    if (target && strcmp(target->name, name) != 0) {
        snprintf(target->name, sizeof target->name, "%s", name);
        target->renamed = t->renamed = true;
    }
}

static bool same_ship(const struct pel_ais_ship *a,
                      const struct pel_ais_ship *b)
{
    return a->type == b->type && a->is_virtual == b->is_virtual &&
           a->bow_m == b->bow_m && a->stern_m == b->stern_m &&
           a->port_m == b->port_m && a->starboard_m == b->starboard_m &&
           a->draught_m == b->draught_m;
}

static void keep_ship(struct pel_nmea_targets *t, uint64_t key,
                      const struct pel_ais_ship *ship)
{
    place_of_name(t, key)->ship = *ship;
    struct pel_nmea_target *target = find(t, key);
    if (target && !same_ship(&target->ship, ship)) {
        target->ship = *ship;
        target->reshaped = t->reshaped = true;
    }
}

/* --- places --------------------------------------------------------------- */

/* Square of the chord between two places on a unit sphere: grows with the
 * distance, which is all that is asked. */
static double apart(double lat_a, double lon_a, double lat_b, double lon_b)
{
    double north = sin((lat_b - lat_a) * PEL_DEG / 2);
    double east = sin((lon_b - lon_a) * PEL_DEG / 2);
    return north * north +
           cos(lat_a * PEL_DEG) * cos(lat_b * PEL_DEG) * east * east;
}

/* The place for a newcomer at a position; NULL: all others are nearer. `own`
 * NULL: there is no own ship. */
static struct pel_nmea_target *place_for(struct pel_nmea_targets *t,
                                         double latitude, double longitude,
                                         const struct pel_nmea_report *own,
                                         int64_t now_ns)
{
    struct pel_nmea_target *oldest = &t->targets[0], *farthest = NULL;
    double most =
        own ? apart(own->latitude, own->longitude, latitude, longitude) : 0;
    for (size_t i = 0; i < PEL_NMEA_TARGETS; i++) {
        struct pel_nmea_target *target = &t->targets[i];
        if (target->key == 0) {
            return target;
        }
        oldest = target->heard_ns < oldest->heard_ns ? target : oldest;
        double distance = own ? apart(own->latitude, own->longitude,
                                      target->latitude, target->longitude)
                              : 0;
        if (distance > most) {
            most = distance;
            farthest = target;
        }
    }
    struct pel_nmea_target *place =
        !own || now_ns - oldest->heard_ns > STALE_NS ? oldest : farthest;
    if (place) {
        t->counters->evicted++;
    } else {
        t->counters->refused++;
    }
    return place;
}

static struct pel_nmea_target *settle(struct pel_nmea_targets *t,
                                      const struct pel_nmea_target_report *r,
                                      const struct pel_nmea_report *own,
                                      int64_t now_ns)
{
    uint64_t key = key_of(r->radar, r->number);
    struct pel_nmea_target *target =
        place_for(t, r->latitude, r->longitude, own, now_ns);
    if (!target) {
        return NULL;
    }
    const struct pel_nmea_name *said = known_name(t, key);
    *target = (struct pel_nmea_target){
        .key = key,
        .heading = NAN,
        .station = r->station,
        .reshaped = true,
        .drawn_ns = now_ns,
    };
    t->reshaped = true;
    if (said) {
        target->ship = said->ship;
    }
    if (said && said->name[0]) {
        snprintf(target->name, sizeof target->name, "%s", said->name);
    } else if (r->radar) {
        snprintf(target->name, sizeof target->name, "radar-%02u", r->number);
    } else {
        snprintf(target->name, sizeof target->name, "mmsi-%09u", r->number);
    }
    return target;
}

/* --- edits ---------------------------------------------------------------- */

static bool patch(struct pel_nmea_targets *t, const Pelagos__Patch *what)
{
    struct pel_fault fault;
    if (pel_scene_patch(t->scene, what, &fault) == PEL_OK) {
        t->counters->edits++;
        return true;
    }
    static struct pel_log_limit limit;
    pel_log_limited(&limit, PEL_LOG_WARNING, "NME-007",
                    "targets of AIS or radar were refused: %s %s", fault.path,
                    fault.message);
    t->counters->refused_edits++;
    return false;
}

static void remove_target(struct pel_nmea_targets *t,
                          struct pel_nmea_target *target)
{
    char path[32];
    char *paths = path;
    snprintf(path, sizeof path, "entities.%zu",
             PEL_NMEA_TARGET_ID + (size_t)(target - t->targets));
    Pelagos__Patch what = PELAGOS__PATCH__INIT;
    what.n_remove = 1;
    what.remove = &paths;
    if (pel_scene_patch(t->scene, &what, NULL) != PEL_OK) {
        t->counters->refused_edits++; /* a client has removed it already */
    }
    *target = (struct pel_nmea_target){ 0 };
}

/* Range and bearing to a position; false: there is no own ship. */
static bool resolve(struct pel_nmea_target_report *r,
                    const struct pel_nmea_report *own)
{
    if (!r->polar) {
        return true;
    }
    if (!own || isnan(r->range_m) || isnan(r->bearing)) {
        return false;
    }
    double bearing = r->bearing + (r->bearing_true ? 0 : own->heading);
    pel_geo_from_local(
        own->latitude, own->longitude, r->range_m * sin(bearing * PEL_DEG),
        r->range_m * cos(bearing * PEL_DEG), &r->latitude, &r->longitude);
    return true;
}

/* The report's target, its place in the table taken; NULL: the report changes
 * nothing. A position worse than the one known is taken out of the report. */
static struct pel_nmea_target *admit(struct pel_nmea_targets *t,
                                     struct pel_nmea_target_report *r,
                                     const struct pel_nmea_report *own,
                                     bool *is_new, int64_t now_ns)
{
    if (!resolve(r, own) || isnan(r->latitude) || isnan(r->longitude) ||
        fabs(r->latitude) > 90) {
        t->counters->ignored++;
        return NULL;
    }
    struct pel_nmea_target *target = find(t, key_of(r->radar, r->number));
    *is_new = !target;
    if (!target) {
        target = settle(t, r, own, now_ns);
    }
    if (!target) {
        return NULL;
    }
    target->heard_ns = now_ns;
    if (r->coarse && target->fine_ns && now_ns - target->fine_ns <= FINE_NS) {
        return NULL;
    }
    if (r->polar && target->tll_ns && now_ns - target->tll_ns <= TLL_NS) {
        r->latitude = r->longitude = NAN;
        return target;
    }
    target->fine_ns = r->coarse ? target->fine_ns : now_ns;
    target->tll_ns = r->radar && !r->polar ? now_ns : target->tll_ns;
    target->latitude = r->latitude;
    target->longitude = r->longitude;
    return target;
}

/* Who reports, and from its antenna's position to its middle's. */
static void settle_ship(struct pel_nmea_targets *t,
                        struct pel_nmea_target *target,
                        struct pel_nmea_target_report *r)
{
    if (!r->coarse && r->station != target->station) {
        target->station = r->station; /* 27 does not say which class */
        target->reshaped = t->reshaped = true;
    }
    if (!isnan(r->heading)) {
        target->heading = r->heading;
    } else if (!isnan(r->course) && r->speed > STEERAGE_MPS) {
        target->heading = r->course;
    }
    if (!isnan(r->latitude)) {
        pel_nmea_to_middle(&target->ship, target->heading, &r->latitude,
                           &r->longitude);
    }
}

/* The schema's numbers are those of AIS; reserved ones say nothing. */
static Pelagos__NavigationStatus status_of(int ais)
{
    return protobuf_c_enum_descriptor_get_value(
               &pelagos__navigation_status__descriptor, ais)
               ? (Pelagos__NavigationStatus)ais
               : PELAGOS__NAVIGATION_STATUS__UNDEFINED;
}

/* Adds to what earlier reports of the same edit have filled in. */
static void fill(Pelagos__Entity *e, const struct pel_nmea_target_report *r,
                 bool is_new)
{
    bool moves = !isnan(r->course) && r->speed <= MAX_SPEED_MPS;
    if (!isnan(r->latitude)) {
        e->has_latitude = e->has_longitude = 1;
        e->latitude = r->latitude;
        e->longitude = r->longitude;
    }
    if (is_new || !isnan(r->altitude)) {
        e->has_altitude = 1;
        e->altitude = isnan(r->altitude) ? 0 : r->altitude;
    }
    if (is_new || r->polar || !r->radar) { /* TLL alone says no motion */
        e->has_speed = e->has_course = e->has_turn_rate = 1;
        e->speed = moves ? r->speed : 0;
        e->course = isnan(r->course) ? 0 : r->course;
        e->turn_rate = isnan(r->turn_rate) ? 0 : r->turn_rate;
    }
    if (is_new || !isnan(r->heading) || (moves && r->speed > STEERAGE_MPS)) {
        e->has_heading = 1;
        e->heading = isnan(r->heading) ? e->course : r->heading;
    }
    if (r->status >= 0) {
        e->has_navigation_status = 1;
        e->navigation_status = status_of(r->status);
    }
    if (is_new && !r->radar) {
        e->has_lights = 1;
        e->lights = PELAGOS__LAMP_SWITCH__AUTO;
    }
}

/* The entity of an edit with this id, or a new one at the list's end. */
static Pelagos__Entity *entity_of(Pelagos__State *state,
                                  Pelagos__Entity *entities, uint32_t id,
                                  char *name)
{
    for (size_t i = 0; i < state->n_entities; i++) {
        if (state->entities[i]->id == id) {
            return state->entities[i];
        }
    }
    Pelagos__Entity *e = &entities[state->n_entities];
    pelagos__entity__init(e);
    e->has_id = 1;
    e->id = id;
    e->name = name;
    state->entities[state->n_entities++] = e;
    return e;
}

static void add_names(struct pel_nmea_targets *t, Pelagos__State *state,
                      Pelagos__Entity *entities)
{
    for (size_t i = 0; t->renamed && i < PEL_NMEA_TARGETS; i++) {
        if (t->targets[i].key != 0 && t->targets[i].renamed) {
            entity_of(state, entities, PEL_NMEA_TARGET_ID + (uint32_t)i,
                      t->targets[i].name);
            t->targets[i].renamed = false;
        }
    }
    t->renamed = false;
}

/* --- shapes --------------------------------------------------------------- */

static void submit_shapes(struct pel_nmea_targets *t);

/* An edit with models has been made, or refused. Targets that went meanwhile
 * must not come back with it. */
static void on_shaped(void *user, enum pel_err err,
                      const struct pel_fault *fault)
{
    struct pel_nmea_targets *t = user;
    t->shaping = false;
    if (err) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_WARNING, "NME-011",
                        "shapes of targets were refused: %s %s", fault->path,
                        fault->message);
        t->counters->refused_edits++;
        for (size_t i = 0; i < PEL_NMEA_TARGETS; i++) {
            t->targets[i].reshaped &= !t->shaped[i]; /* not again and again */
        }
        return;
    }
    t->counters->edits++;
    for (size_t i = 0; i < PEL_NMEA_TARGETS; i++) {
        if (t->shaped[i] && t->targets[i].key == 0) {
            remove_target(t, &t->targets[i]);
        }
    }
    submit_shapes(t); /* what changed meanwhile */
}

static bool has_model(const Pelagos__State *state, uint32_t id)
{
    for (size_t i = 0; i < state->n_entities; i++) {
        if (state->entities[i]->id == id) {
            return state->entities[i]->model != NULL;
        }
    }
    return false;
}

/* The models of one edit: what asks for another sea may wait behind it. */
#define SHAPES_AN_EDIT 8
struct shapes {
    Pelagos__Patch patch;
    Pelagos__State state;
    Pelagos__Entity entities[SHAPES_AN_EDIT];
    Pelagos__Entity *list[SHAPES_AN_EDIT];
    Pelagos__Model models[SHAPES_AN_EDIT];
    char *removals[SHAPES_AN_EDIT];
    char paths[SHAPES_AN_EDIT][32];
};

/* plain: of the kind's own size, which all of a kind share. True: the size that
 * is left out is to come. */
static bool add_shape(struct shapes *s, const Pelagos__State *now,
                      const struct pel_nmea_target *target, uint32_t id,
                      bool plain)
{
    size_t n = s->state.n_entities;
    Pelagos__Model *model = &s->models[n];
    pelagos__model__init(model);
    bool shaped = pel_nmea_shape_of(
        target->station, (uint32_t)(target->key - 1), &target->ship, model);
    bool sized =
        shaped && (model->has_length || model->has_beam || model->has_draught);
    if (plain) {
        model->has_length = model->has_beam = model->has_draught = 0;
    }
    if (has_model(now, id)) { /* else the new one keeps its sizes */
        char *path = s->paths[s->patch.n_remove];
        snprintf(path, sizeof s->paths[0], "entities.%u.model", id);
        s->removals[s->patch.n_remove++] = path;
    } else if (!shaped) {
        return false;
    }
    Pelagos__Entity *e = &s->entities[n];
    pelagos__entity__init(e);
    e->has_id = e->has_afloat = 1;
    e->id = id;
    e->afloat = shaped;
    e->model = shaped ? model : NULL;
    s->list[s->state.n_entities++] = e;
    return plain && sized;
}

/* Whether so many targets have no shape yet that each has one of its kind's own
 * size first: a size takes tenths of a second to make. */
static bool many_without(const struct pel_nmea_targets *t,
                         const Pelagos__State *now)
{
    int count = 0;
    for (size_t i = 0; i < PEL_NMEA_TARGETS; i++) {
        count += t->targets[i].key != 0 && t->targets[i].reshaped &&
                 !has_model(now, PEL_NMEA_TARGET_ID + (uint32_t)i);
    }
    return count > (t->plain ? 0 : SHAPES_AN_EDIT);
}

/* One edit at a time: what changes meanwhile is in the next. */
static void submit_shapes(struct pel_nmea_targets *t)
{
    if (!t->reshaped || t->shaping) {
        return;
    }
    struct shapes s;
    const Pelagos__State *now = pel_scene_state(t->scene);
    pelagos__patch__init(&s.patch);
    pelagos__state__init(&s.state);
    s.patch.state = &s.state;
    s.patch.remove = s.removals;
    s.state.entities = s.list;
    t->reshaped = false;
    t->plain = many_without(t, now);
    for (size_t i = 0; i < PEL_NMEA_TARGETS; i++) {
        struct pel_nmea_target *target = &t->targets[i];
        uint32_t id = PEL_NMEA_TARGET_ID + (uint32_t)i;
        bool waits = target->key != 0 && target->reshaped;
        t->shaped[i] = waits && s.state.n_entities < SHAPES_AN_EDIT &&
                       !(t->plain && has_model(now, id));
        if (t->shaped[i]) {
            target->reshaped = add_shape(&s, now, target, id, t->plain);
        }
        t->reshaped |= target->key != 0 && target->reshaped;
    }
    if (s.state.n_entities > 0) {
        const struct pel_scene_wish wish = { .patch = &s.patch, .source = t };
        t->shaping = true;
        pel_scene_submit(t->scene, &wish, on_shaped, t);
    }
}

void pel_nmea_targets_finish(struct pel_nmea_targets *t)
{
    pel_scene_forget(t->scene, t);
}

static void commit_reports(struct pel_nmea_targets *t, int64_t now_ns)
{
    if (t->pending_count == 0 && !t->renamed) {
        return;
    }
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Entity entities[PEL_NMEA_TARGETS];
    Pelagos__Entity *list[PEL_NMEA_TARGETS];
    struct pel_nmea_report own;
    bool has_own = pel_nmea_out_report_of(t->scene, t->own_ship, &own);
    state.entities = list;
    for (size_t i = 0; i < t->pending_count; i++) {
        struct pel_nmea_target_report *r = &t->pending[i];
        bool is_new;
        struct pel_nmea_target *target =
            admit(t, r, has_own ? &own : NULL, &is_new, now_ns);
        if (target) {
            uint32_t id = PEL_NMEA_TARGET_ID + (uint32_t)(target - t->targets);
            settle_ship(t, target, r);
            fill(entity_of(&state, entities, id, target->name), r, is_new);
        }
    }
    t->pending_count = 0;
    add_names(t, &state, entities);
    if (state.n_entities > 0) {
        Pelagos__Patch what = PELAGOS__PATCH__INIT;
        what.state = &state;
        patch(t, &what);
    }
}

/* --- of a fleet ----------------------------------------------------------- */

#define CHOOSE_NS (SECOND_NS / 4)

/* Places that the table and the scene have for newcomers. */
static size_t room_of(const struct pel_nmea_targets *t)
{
    size_t entities = pel_scene_state(t->scene)->n_entities;
    size_t taken = pel_nmea_targets_count(t) + t->pending_count;
    size_t free_places =
        taken < PEL_NMEA_TARGETS ? PEL_NMEA_TARGETS - taken : 0;
    size_t free_entities =
        entities + t->pending_count < PEL_BOUND_ENTITIES
            ? PEL_BOUND_ENTITIES - entities - t->pending_count
            : 0;
    return MIN(free_places, free_entities);
}

/* One edit takes them all out. */
static void let_go(struct pel_nmea_targets *t,
                   const struct pel_nmea_choice *choice)
{
    char paths[PEL_NMEA_SWAPS][32];
    char *list[PEL_NMEA_SWAPS];
    Pelagos__Patch what = PELAGOS__PATCH__INIT;
    what.remove = list;
    for (size_t i = 0; i < choice->leave_count; i++) {
        struct pel_nmea_target *target = find(t, choice->leave[i]);
        if (target) {
            list[what.n_remove] = paths[what.n_remove];
            snprintf(paths[what.n_remove++], sizeof paths[0], "entities.%zu",
                     PEL_NMEA_TARGET_ID + (size_t)(target - t->targets));
            *target = (struct pel_nmea_target){ 0 };
            t->counters->evicted++;
        }
    }
    if (what.n_remove > 0 && pel_scene_patch(t->scene, &what, NULL) != PEL_OK) {
        t->counters->refused_edits++; /* a client has removed one already */
    }
}

static void enter(struct pel_nmea_targets *t,
                  const struct pel_nmea_known *known, int64_t now_ns)
{
    if (known->name[0]) {
        keep_name(t, known->key, known->name);
    }
    if (known->has_ship) {
        keep_ship(t, known->key, &known->ship);
    }
    t->pending[t->pending_count++] = pel_nmea_fleet_reckon(known, now_ns);
}

static void choose(struct pel_nmea_targets *t, int64_t now_ns)
{
    struct pel_nmea_drawn drawn[PEL_NMEA_TARGETS];
    struct pel_nmea_choice choice;
    struct pel_nmea_report own;
    size_t count = 0;
    t->chosen_ns = now_ns;
    for (size_t i = 0; i < PEL_NMEA_TARGETS; i++) {
        if (t->targets[i].key != 0) {
            drawn[count++] = (struct pel_nmea_drawn){ t->targets[i].key,
                                                      t->targets[i].drawn_ns };
        }
    }
    bool has_own = pel_nmea_out_report_of(t->scene, t->own_ship, &own);
    pel_nmea_fleet_choose(t->fleet, has_own ? &own : NULL, drawn, count,
                          room_of(t), now_ns, &choice);
    let_go(t, &choice);
    for (size_t i = 0; i < choice.enter_count; i++) {
        enter(t, choice.enter[i], now_ns);
    }
    commit_reports(t, now_ns);
}

/* Keeps a report of AIS; whether the table is to have it too. */
static bool keep_known(struct pel_nmea_targets *t, uint64_t key,
                       const struct pel_nmea_target_report *r, int64_t now_ns)
{
    bool is_new = !pel_nmea_fleet_find(t->fleet, key);
    struct pel_nmea_known *known =
        pel_nmea_fleet_take(t->fleet, key, r, now_ns);
    const struct pel_nmea_name *said =
        known && is_new ? known_name(t, key) : NULL;
    if (said) {
        snprintf(known->name, sizeof known->name, "%s", said->name);
        known->ship = said->ship;
        known->has_ship = true;
    }
    t->counters->refused += !known;
    return known && (find(t, key) || room_of(t) > 0);
}

/* Names and ships wait in the list for those that are not known yet. */
static bool keep_static(struct pel_nmea_targets *t, uint64_t key,
                        const struct pel_ais *ais)
{
    struct pel_nmea_known *known = pel_nmea_fleet_find(t->fleet, key);
    if (known && ais->name[0]) {
        snprintf(known->name, sizeof known->name, "%s", ais->name);
    }
    if (known && ais->has_ship) {
        known->ship = ais->ship;
        known->has_ship = true;
    }
    return known && !find(t, key);
}

void pel_nmea_targets_commit(struct pel_nmea_targets *t, int64_t now_ns)
{
    commit_reports(t, now_ns);
    if (t->fleet && now_ns - t->chosen_ns >= CHOOSE_NS) {
        choose(t, now_ns);
    }
    submit_shapes(t);
}

static void wait_for_commit(struct pel_nmea_targets *t,
                            const struct pel_nmea_target_report *r,
                            int64_t now_ns)
{
    t->pending[t->pending_count++] = *r;
    if (t->pending_count == PEL_NMEA_REPORTS_AN_EDIT) {
        pel_nmea_targets_commit(t, now_ns);
    }
}

void pel_nmea_targets_take_ais(struct pel_nmea_targets *t,
                               const struct pel_ais *ais, int64_t now_ns)
{
    uint64_t key = key_of(false, ais->mmsi);
    bool kept = t->fleet && keep_static(t, key, ais);
    if (ais->name[0] && !kept) {
        keep_name(t, key, ais->name);
    }
    if (ais->has_ship && !kept) {
        keep_ship(t, key, &ais->ship);
    }
    if (!ais->has_position_report) {
        return;
    }
    const struct pel_nmea_target_report report = {
        .station = pel_nmea_station_of(ais->type),
        .number = ais->mmsi,
        .coarse = ais->coarse,
        .latitude = ais->latitude,
        .longitude = ais->longitude,
        .altitude = ais->altitude,
        .speed = ais->speed,
        .course = ais->course,
        .heading = ais->heading,
        .turn_rate = ais->turn_rate,
        .status = ais->status,
    };
    if (!t->fleet || keep_known(t, key, &report, now_ns)) {
        wait_for_commit(t, &report, now_ns);
    }
}

void pel_nmea_targets_take_radar(struct pel_nmea_targets *t,
                                 const struct pel_nmea_sentence *s,
                                 int64_t now_ns)
{
    if (s->target < 0) {
        t->counters->ignored++;
        return;
    }
    uint64_t key = key_of(true, (uint32_t)s->target);
    if (s->target_status == 'L') {
        pel_nmea_targets_commit(t, now_ns);
        struct pel_nmea_target *target = find(t, key);
        if (target) {
            remove_target(t, target);
        }
        return;
    }
    if (s->target_name[0]) {
        keep_name(t, key, s->target_name);
    }
    const struct pel_nmea_target_report report = {
        .radar = true,
        .station = PEL_NMEA_RADAR,
        .number = (uint32_t)s->target,
        .polar = s->kind == PEL_NMEA_TTM,
        .bearing_true = s->bearing_true,
        .latitude = s->latitude,
        .longitude = s->longitude,
        .altitude = NAN,
        .range_m = s->target_range,
        .bearing = s->target_bearing,
        .speed = s->course_true ? s->speed : NAN,
        .course = s->course_true ? s->course : NAN,
        .heading = NAN,
        .turn_rate = NAN,
        .status = -1,
    };
    wait_for_commit(t, &report, now_ns);
}

void pel_nmea_targets_expire(struct pel_nmea_targets *t, int64_t now_ns)
{
    for (size_t i = 0; i < PEL_NMEA_TARGETS; i++) {
        struct pel_nmea_target *target = &t->targets[i];
        int64_t life = is_radar(target) ? RADAR_LIFE_NS : AIS_LIFE_NS;
        if (target->key != 0 && now_ns - target->heard_ns >= life) {
            remove_target(t, target);
        }
    }
    if (t->fleet) {
        commit_reports(t, now_ns);
        pel_nmea_fleet_expire(t->fleet, AIS_LIFE_NS, now_ns);
        choose(t, now_ns);
    }
    submit_shapes(t);
}

size_t pel_nmea_targets_count(const struct pel_nmea_targets *t)
{
    size_t count = 0;
    for (size_t i = 0; i < PEL_NMEA_TARGETS; i++) {
        count += t->targets[i].key != 0;
    }
    return count;
}

size_t pel_nmea_targets_known(const struct pel_nmea_targets *t)
{
    size_t count = t->fleet ? pel_nmea_fleet_count(t->fleet) : 0;
    for (size_t i = 0; i < PEL_NMEA_TARGETS; i++) {
        count +=
            t->targets[i].key != 0 &&
            (!t->fleet || !pel_nmea_fleet_find(t->fleet, t->targets[i].key));
    }
    return count;
}
