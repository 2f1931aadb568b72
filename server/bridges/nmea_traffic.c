#include "bridges/nmea_traffic.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "base/vec.h"
#include "bridges/ais_out.h"
#include "bridges/nmea_targets.h"
#include "scene/fleet.h"
#include "scene/geodesy.h"

#define MILE_M 1852.0
#define KNOT_MPS (MILE_M / 3600.0)
#define RADAR_M (24 * MILE_M)
#define UNKNOWN 15
#define MOST_A_CONTACT 300  /* bytes of its sentences */
#define STATIC_EVERY_S 10.0 /* names, sizes, aids; ITU: 6 and 3 minutes */

static const struct {
    bool has, aid;
    uint8_t type;
} types[PEL_MODEL_CLASSES] = {
    [PEL_MODEL_CONTAINER_SHIP] = { true, false, 70 },
    [PEL_MODEL_TANKER] = { true, false, 80 },
    [PEL_MODEL_BULK_CARRIER] = { true, false, 70 },
    [PEL_MODEL_CARGO_SHIP] = { true, false, 70 },
    [PEL_MODEL_FERRY] = { true, false, 60 },
    [PEL_MODEL_CRUISE_SHIP] = { true, false, 60 },
    [PEL_MODEL_TUG] = { true, false, 52 },
    [PEL_MODEL_FISHING_BOAT] = { true, false, 30 },
    [PEL_MODEL_SAILING_YACHT] = { true, false, 36 },
    [PEL_MODEL_MOTOR_YACHT] = { true, false, 37 },
    [PEL_MODEL_PILOT_LAUNCH] = { true, false, 50 },
    [PEL_MODEL_PATROL_BOAT] = { true, false, 55 },
    [PEL_MODEL_WARSHIP] = { true, false, 35 },
    [PEL_MODEL_WORK_SHIP] = { true, false, 90 },
    [PEL_MODEL_RIB] = { true, false, 90 },
    [PEL_MODEL_USV] = { true, false, 90 },
    [PEL_MODEL_LIFEBOAT] = { true, false, 51 },
    [PEL_MODEL_LATERAL_PORT] = { true, true, 24 },
    [PEL_MODEL_LATERAL_STARBOARD] = { true, true, 25 },
    [PEL_MODEL_CARDINAL_NORTH] = { true, true, 20 },
    [PEL_MODEL_CARDINAL_EAST] = { true, true, 21 },
    [PEL_MODEL_CARDINAL_SOUTH] = { true, true, 22 },
    [PEL_MODEL_CARDINAL_WEST] = { true, true, 23 },
    [PEL_MODEL_SAFE_WATER] = { true, true, 29 },
    [PEL_MODEL_SPECIAL_MARK] = { true, true, 30 },
    [PEL_MODEL_ISOLATED_DANGER] = { true, true, 28 },
    [PEL_MODEL_BEACON] = { true, true, 15 },
    [PEL_MODEL_LIGHT_FLOAT] = { true, true, 31 },
};

bool pel_nmea_ais_type(int model_class, bool *aid, uint8_t *type)
{
    if (model_class < 0 || model_class >= PEL_MODEL_CLASSES) {
        return false;
    }
    *aid = types[model_class].aid;
    *type = types[model_class].type;
    return types[model_class].has;
}

uint32_t pel_nmea_mmsi_of(uint32_t entity, bool aid)
{
    return (aid ? 992000000U : 200000000U) + entity;
}

/* --- the radar ------------------------------------------------------------ */

void pel_nmea_say_target(struct pel_nmea_writer *w, int number,
                         const char *name, const struct pel_nmea_pose *own,
                         const struct pel_nmea_pose *other, double unix_s)
{
    double east, north;
    pel_geo_to_local(own->latitude, own->longitude, other->latitude,
                     other->longitude, &east, &north);
    double course = other->course * PEL_DEG, mine = own->course * PEL_DEG;
    double ve = other->speed * sin(course) - own->speed * sin(mine);
    double vn = other->speed * cos(course) - own->speed * cos(mine);
    double v2 = ve * ve + vn * vn;
    double after_s = v2 > 1e-4 ? -(east * ve + north * vn) / v2 : 0;
    double nearest = hypot(east + ve * after_s, north + vn * after_s);
    double minutes = pel_clamp(after_s / 60, -999, 999);
    char said[16];
    size_t length = 0;
    for (; *name && length + 1 < sizeof said; name++) {
        bool plain = *name >= ' ' && *name <= '~' && !strchr(",*$!\\^", *name);
        said[length++] = plain ? *name : '-';
    }
    said[length] = 0;
    time_t seconds = (time_t)floor(unix_s);
    struct tm utc;
    gmtime_r(&seconds, &utc);
    pel_nmea_say(w, '$',
                 "RATTM,%02d,%.2f,%.1f,T,%.1f,%.1f,T,%.2f,%.1f,N,%s,T,,"
                 "%02d%02d%02d.%02d,A",
                 number, hypot(east, north) / MILE_M,
                 pel_nmea_bearing(atan2(east, north) / PEL_DEG),
                 other->speed / KNOT_MPS, pel_nmea_bearing(other->course),
                 nearest / MILE_M, minutes, said, utc.tm_hour, utc.tm_min,
                 utc.tm_sec, (int)((unix_s - floor(unix_s)) * 100));
}

/* -1: all are taken. */
static int number_of(struct pel_nmea_radar *r, uint32_t entity)
{
    int vacant = -1;
    for (int i = 0; i < PEL_NMEA_RADAR_TARGETS; i++) {
        if (r->entities[i] == entity + 1) {
            return i;
        }
        vacant = vacant < 0 && !r->entities[i] ? i : vacant;
    }
    if (vacant >= 0) {
        r->entities[vacant] = entity + 1;
    }
    return vacant;
}

static void forget_gone(struct pel_nmea_radar *r, const struct pel_snapshot *s)
{
    for (int i = 0; i < PEL_NMEA_RADAR_TARGETS; i++) {
        bool there = false;
        for (size_t k = 0; k < s->entity_count && !there; k++) {
            there = s->entities[k].id + 1 == r->entities[i];
        }
        r->entities[i] = there ? r->entities[i] : 0;
    }
}

/* --- the scene ------------------------------------------------------------ */

static struct pel_nmea_pose pose_of(const Pelagos__State *state,
                                    const struct pel_entity_state *e)
{
    double lat0 = state->origin->latitude, lon0 = state->origin->longitude;
    struct pel_nmea_pose p = { .speed = e->speed_mps };
    pel_geo_from_local(lat0, lon0, e->east_m, e->north_m, &p.latitude,
                       &p.longitude);
    double turned = pel_geo_convergence(lat0, lon0, p.latitude, p.longitude);
    p.heading = (e->heading_rad - turned) / PEL_DEG;
    p.course = (e->course_rad - turned) / PEL_DEG;
    p.turn_rate = e->turn_rate_rps / PEL_DEG;
    return p;
}

static const Pelagos__Entity *find(const Pelagos__State *state, uint32_t id)
{
    for (size_t i = 0; i < state->n_entities; i++) {
        if (state->entities[i]->id == id) {
            return state->entities[i];
        }
    }
    return NULL;
}

/* Its status as AIS has it. */
static int status_of(const Pelagos__Entity *e)
{
    return e->navigation_status == PELAGOS__NAVIGATION_STATUS__TRAWLING
               ? PELAGOS__NAVIGATION_STATUS__FISHING
           : e->navigation_status == PELAGOS__NAVIGATION_STATUS__PILOTING
               ? PELAGOS__NAVIGATION_STATUS__UNDER_WAY
               : (int)fmin(e->navigation_status,
                           PELAGOS__NAVIGATION_STATUS__UNDEFINED);
}

static bool is_due(const struct pel_nmea_traffic *t, uint32_t entity)
{
    uint64_t every = (uint64_t)fmax(1, round(STATIC_EVERY_S * t->rate_hz));
    return t->report == 0 || (t->report + entity) % every == 0;
}

static void say_ais(const struct pel_nmea_traffic *t,
                    const struct pel_entity_state *e, const char *name,
                    int status, const struct pel_nmea_pose *p, double unix_s,
                    struct pel_nmea_writer *w)
{
    bool aid;
    uint8_t type;
    const struct pel_model *m = e->model;
    if (!pel_nmea_ais_type((int)m->class, &aid, &type)) {
        return;
    }
    struct pel_ais a = {
        .mmsi = pel_nmea_mmsi_of(e->id, aid),
        .status = status,
        .latitude = p->latitude,
        .longitude = p->longitude,
        .speed = p->speed,
        .course = p->course,
        .heading = p->heading,
        .turn_rate = p->turn_rate,
        .ship = { .type = type,
                  .bow_m = m->length_m / 2,
                  .stern_m = m->length_m / 2,
                  .port_m = m->beam_m / 2,
                  .starboard_m = m->beam_m / 2,
                  .draught_m = m->draught_m },
    };
    int second = (int)fmod(floor(unix_s), 60);
    snprintf(a.name, sizeof a.name, "%.20s", name);
    if (!aid) {
        pel_ais_say_position(w, &a, second);
    }
    if (!aid && is_due(t, e->id)) {
        pel_ais_say_ship(w, &a, (int)(e->id % 10));
    }
    if (aid && is_due(t, e->id)) {
        pel_ais_say_aid(w, &a, second);
    }
}

static bool is_ours(const struct pel_nmea_traffic *t,
                    const struct pel_entity_state *e)
{
    bool heard = e->id >= PEL_NMEA_TARGET_ID &&
                 e->id < PEL_NMEA_TARGET_ID + PEL_NMEA_TARGETS;
    return e->model && e->id != t->entity && !heard;
}

void pel_nmea_traffic_say(const struct pel_nmea_traffic *t,
                          struct pel_scene *scene, struct pel_nmea_radar *radar,
                          struct pel_nmea_writer *w,
                          void (*flush)(void *user, struct pel_nmea_writer *w),
                          void *user)
{
    const Pelagos__State *state = pel_scene_state(scene);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    double time_s = state->clock->time, unix_s = s->epoch_unix_s + time_s;
    struct pel_nmea_pose own = { 0 };
    struct pel_entity_state e;
    bool found = false;
    for (size_t i = 0; i < s->entity_count && !found; i++) {
        if (s->entities[i].id == t->entity) {
            pel_snapshot_entity_level(s, i, time_s, &e);
            own = pose_of(state, &e);
            found = true;
        }
    }
    forget_gone(radar, s);
    for (size_t i = 0; i < s->entity_count && found; i++) {
        if (!is_ours(t, &s->entities[i])) {
            continue;
        }
        pel_snapshot_entity_level(s, i, time_s, &e);
        struct pel_nmea_pose p = pose_of(state, &e);
        const Pelagos__Entity *known = find(state, e.id);
        const char *name = known && known->name ? known->name : "";
        double east, north;
        pel_geo_to_local(own.latitude, own.longitude, p.latitude, p.longitude,
                         &east, &north);
        int number =
            t->kind & PEL_NMEA_TRAFFIC_TTM && hypot(east, north) < RADAR_M
                ? number_of(radar, e.id)
                : -1;
        if (number >= 0) {
            pel_nmea_say_target(w, number, name, &own, &p, unix_s);
        }
        if (t->kind & PEL_NMEA_TRAFFIC_AIS) {
            say_ais(t, &e, name, known ? status_of(known) : UNKNOWN, &p, unix_s,
                    w);
        }
        if (w->used + MOST_A_CONTACT > w->size) {
            flush(user, w);
        }
    }
    if (w->used > 0) {
        flush(user, w);
    }
    pel_snapshot_unref(s);
}
