#include "scene/viewplace.h"

#include <math.h>
#include <stdio.h>

#include "fault.h"
#include "scene/geodesy.h"
#include "scene/globe.h"
#include "scene/place.h"
#include "scene/snapshot.h"
#include "scene/waypoints.h"

#define EARTH_TURN_RPS 7.292115e-5
#define EARTH_MEAN_M 6371008.8
#define EARTH_MU 3.986004418e14 /* m3/s2 */
#define EARTH_F (1 / 298.257223563)

/* What is nearer than this is aimed at as it is drawn, on the globe about the
 * eye (globe.h), from below the height where that is another. */
#define AIM_M 1e5
#define AIM_BELOW_M 2e4
#define RATE_S 0.05 /* of velocities */

static int index_of(const Pelagos__State *state, uint32_t id)
{
    for (size_t i = 0; i < state->n_entities; i++) {
        if (state->entities[i]->id == id) {
            return (int)i;
        }
    }
    return -1;
}

static void place_at(const Pelagos__State *state, double latitude,
                     double longitude, double height_m,
                     struct pel_view_place *out)
{
    double lat0 = state->origin->latitude, lon0 = state->origin->longitude;
    out->at = (struct pel_geo_place){ latitude, longitude, height_m };
    pel_geo_to_local(lat0, lon0, latitude, longitude, &out->east_m,
                     &out->north_m);
    out->turned_rad = pel_geo_turn(lat0, lon0, latitude, longitude);
}

static void place_orbit(const Pelagos__State *state, const Pelagos__Orbit *o,
                        struct pel_view_place *out)
{
    out->stand = PEL_STAND_ORBIT;
    if (o->has_entity) {
        out->about = index_of(state, o->entity);
        out->at.height_m = o->height;
    } else {
        place_at(state, o->latitude, o->longitude, o->height, out);
    }
    out->radius_m = o->radius;
    out->elevation_rad = o->elevation * PEL_DEG;
    out->angle_rad = o->azimuth * PEL_DEG;
    out->rate_rps = o->has_period ? 2 * PEL_PI / o->period : 0;
}

static void place_satellite(const Pelagos__Satellite *o,
                            struct pel_view_place *out)
{
    double r = EARTH_MEAN_M + o->height;
    out->stand = PEL_STAND_SATELLITE;
    out->at.height_m = o->height;
    out->inclination_rad = o->inclination * PEL_DEG;
    out->node_rad = o->node * PEL_DEG;
    out->angle_rad = o->phase * PEL_DEG;
    out->rate_rps =
        o->has_period ? 2 * PEL_PI / o->period : sqrt(EARTH_MU / (r * r * r));
}

void pel_view_place_of(const Pelagos__State *state, const Pelagos__View *view,
                       struct pel_view_place *out)
{
    *out = (struct pel_view_place){ .about = -1, .target = -1 };
    if (view->at) {
        out->stand = PEL_STAND_AT;
        place_at(state, view->at->latitude, view->at->longitude,
                 view->at->has_height ? view->at->height : view->up, out);
    } else if (view->orbit) {
        place_orbit(state, view->orbit, out);
    } else if (view->satellite) {
        place_satellite(view->satellite, out);
    } else if (view->n_waypoints > 0) {
        out->stand = PEL_STAND_WAY;
        out->way = pel_way_of(view->waypoints, view->n_waypoints);
    }
    const Pelagos__LookAt *look = view->look_at;
    if (look) {
        out->looks = true;
        out->target_at =
            (struct pel_geo_place){ look->latitude, look->longitude,
                                    look->height };
        out->target = look->has_entity ? index_of(state, look->entity) : -1;
    }
}

void pel_view_place_ref(const struct pel_view_place *place)
{
    pel_way_ref(place->way);
}

void pel_view_place_unref(const struct pel_view_place *place)
{
    pel_way_unref(place->way);
}

/* --- whether it is whole ---------------------------------------------------
 */

static enum pel_err refuse(enum pel_err err, const Pelagos__View *view,
                           const char *field, const char *value,
                           const char *what, struct pel_fault *fault)
{
    char path[192];
    snprintf(path, sizeof path, "views.%s.%s", view->name, field);
    return pel_fault_refuse(err, path, value, what, fault);
}

/* Named in the order of the schema. */
static enum pel_err check_once(const Pelagos__View *view,
                               struct pel_fault *fault)
{
    const struct {
        const char *name;
        bool has;
    } places[] = { { "entity", view->has_entity },
                   { "at", view->at },
                   { "orbit", view->orbit },
                   { "satellite", view->satellite },
                   { "waypoints", view->n_waypoints > 0 } };
    const char *first = NULL;
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        char what[160];
        if (!places[i].has) {
            continue;
        }
        if (first) {
            snprintf(what, sizeof what,
                     "places the view a second time: remove views.%s.%s, or "
                     "this",
                     view->name, first);
            return refuse(PEL_ERR_CONFLICT, view, places[i].name, NULL, what,
                          fault);
        }
        first = places[i].name;
    }
    return PEL_OK;
}

/* A place, or an entity that is there. */
static enum pel_err check_what(const Pelagos__State *state,
                               const Pelagos__View *view, const char *field,
                               bool latitude, bool longitude, bool has_entity,
                               uint32_t entity, struct pel_fault *fault)
{
    if (has_entity && (latitude || longitude)) {
        return refuse(PEL_ERR_CONFLICT, view, field, NULL,
                      "is of an entity or of a latitude and longitude: remove "
                      "the other",
                      fault);
    }
    if (!has_entity && !(latitude && longitude)) {
        return refuse(PEL_ERR_INVALID, view, field, NULL,
                      "needs both latitude and longitude, or an entity", fault);
    }
    if (has_entity && index_of(state, entity) < 0) {
        char path[64], value[24];
        snprintf(path, sizeof path, "%s.entity", field);
        snprintf(value, sizeof value, "%u", entity);
        return refuse(PEL_ERR_CONFLICT, view, path, value,
                      "names an entity that is not there: add it, or give the "
                      "view another",
                      fault);
    }
    return PEL_OK;
}

static enum pel_err check_waypoints(const Pelagos__View *view,
                                    struct pel_fault *fault)
{
    for (size_t i = 0; i < view->n_waypoints; i++) {
        const Pelagos__Waypoint *p = view->waypoints[i];
        char field[64], value[32];
        if (!p->has_latitude || !p->has_longitude) {
            snprintf(field, sizeof field, "waypoints.%zu", i);
            return refuse(PEL_ERR_INVALID, view, field, NULL,
                          "needs both latitude and longitude", fault);
        }
        if (i > 0 && !(p->time >= view->waypoints[i - 1]->time + 0.001)) {
            snprintf(field, sizeof field, "waypoints.%zu.time", i);
            snprintf(value, sizeof value, "%.17g", p->time);
            return refuse(PEL_ERR_INVALID, view, field, value,
                          "must be later than the waypoint before, by 1 ms at "
                          "least",
                          fault);
        }
    }
    return PEL_OK;
}

enum pel_err pel_view_place_check(const Pelagos__State *state,
                                  const Pelagos__View *view,
                                  struct pel_fault *fault)
{
    const Pelagos__LookAt *look = view->look_at;
    const Pelagos__Orbit *orbit = view->orbit;
    enum pel_err err = check_once(view, fault);
    if (!err && view->at &&
        !(view->at->has_latitude && view->at->has_longitude)) {
        err = refuse(PEL_ERR_INVALID, view, "at", NULL,
                     "needs both latitude and longitude", fault);
    }
    if (!err && look) {
        err = check_what(state, view, "lookAt", look->has_latitude,
                         look->has_longitude, look->has_entity, look->entity,
                         fault);
    }
    if (!err && orbit) {
        err = check_what(state, view, "orbit", orbit->has_latitude,
                         orbit->has_longitude, orbit->has_entity, orbit->entity,
                         fault);
    }
    if (!err && orbit && orbit->has_period && fabs(orbit->period) < 0.1) {
        err = refuse(PEL_ERR_INVALID, view, "orbit.period", NULL,
                     "must be 0.1 s at least, either way round; without one "
                     "the camera stands",
                     fault);
    }
    return err ? err : check_waypoints(view, fault);
}

/* --- where -----------------------------------------------------------------
 */

/* The local frame's axes at a place on Earth, and the origin. */
struct ground {
    double lat0, lon0;
};

static struct ground ground_of(const struct pel_snapshot *s)
{
    return (struct ground){ s->origin_latitude_rad / PEL_DEG,
                            s->origin_longitude_rad / PEL_DEG };
}

static struct pel_vec3 earth_of(const struct pel_geo_place *p)
{
    return pel_geo_earth(p->latitude, p->longitude, p->height_m);
}

static struct pel_vec3 minus(struct pel_vec3 a, struct pel_vec3 b)
{
    return pel_vec3_add(a, pel_vec3_scale(b, -1));
}

static struct pel_geo_place orbit_at(const struct pel_view_place *p,
                                     const struct pel_geo_place *middle,
                                     double time_s)
{
    double angle = p->angle_rad + remainder(p->rate_rps * time_s, 2 * PEL_PI);
    double flat = p->radius_m * cos(p->elevation_rad);
    struct pel_mat3 axes = pel_geo_axes(middle->latitude, middle->longitude);
    struct pel_vec3 arm = { flat * sin(angle), flat * cos(angle),
                            p->radius_m * sin(p->elevation_rad) };
    struct pel_geo_place at;
    pel_geo_of_earth(pel_vec3_add(earth_of(middle), pel_mat3_apply(&axes, arm)),
                     &at.latitude, &at.longitude, &at.height_m);
    return at;
}

/* On the circle as one of reduced latitudes. */
static struct pel_geo_place satellite_at(const struct pel_view_place *p,
                                         double time_s)
{
    double u = p->angle_rad + remainder(p->rate_rps * time_s, 2 * PEL_PI);
    double i = p->inclination_rad;
    double x = cos(u), y = cos(i) * sin(u), z = sin(i) * sin(u);
    double longitude = p->node_rad + atan2(y, x) -
                       remainder(EARTH_TURN_RPS * time_s, 2 * PEL_PI);
    return (struct pel_geo_place){
        atan2(z, (1 - EARTH_F) * hypot(x, y)) / PEL_DEG,
        remainder(longitude, 2 * PEL_PI) / PEL_DEG,
        p->at.height_m,
    };
}

static struct pel_geo_place moving_at(const struct pel_view_place *p,
                                      const struct pel_geo_place *middle,
                                      double time_s, struct pel_way_pose *pose)
{
    if (p->stand == PEL_STAND_ORBIT) {
        return orbit_at(p, middle, time_s);
    }
    if (p->stand == PEL_STAND_SATELLITE) {
        return satellite_at(p, time_s);
    }
    pel_way_at(p->way, time_s, pose);
    return (struct pel_geo_place){ pose->latitude, pose->longitude,
                                   pose->height_m };
}

static struct pel_vec3 within(const struct pel_mat3 *axes, struct pel_vec3 v)
{
    return (struct pel_vec3){ pel_vec3_dot(axes->x, v),
                              pel_vec3_dot(axes->y, v),
                              pel_vec3_dot(axes->z, v) };
}

/* The entity in an orbit's middle, as high as the sea where it floats. */
static struct pel_geo_place middle_of(const struct pel_snapshot *s,
                                      const struct pel_view_place *p,
                                      double time_s, struct pel_vec3 *velocity)
{
    *velocity = (struct pel_vec3){ 0, 0, 0 };
    if (p->stand != PEL_STAND_ORBIT || p->about < 0) {
        return p->at;
    }
    struct ground g = ground_of(s);
    struct pel_entity_state e;
    size_t index = (size_t)p->about;
    pel_snapshot_entity_level(s, index, time_s, &e);
    bool floats = (e.afloat && e.model) || pel_snapshot_ship(s, index);
    struct pel_geo_place at = {
        .height_m = p->at.height_m + (floats ? s->sea_level_m : e.altitude_m)
    };
    pel_geo_from_local(g.lat0, g.lon0, e.east_m, e.north_m, &at.latitude,
                       &at.longitude);
    *velocity = (struct pel_vec3){ e.speed_mps * sin(e.course_rad),
                                   e.speed_mps * cos(e.course_rad),
                                   floats ? 0 : e.climb_mps };
    return at;
}

/* --- whither ---------------------------------------------------------------
 */

/* Level axes that look along a direction; straight up or down: `heading` is
 * where the picture's lower, or upper, edge points. */
static struct pel_mat3 facing(struct pel_vec3 to, double heading_rad)
{
    double flat = hypot(to.x, to.y);
    return pel_attitude(flat > 1e-9 ? atan2(to.x, to.y) : heading_rad,
                        atan2(to.z, flat), 0);
}

/* From the eye, in the local frame's axes there, to what is at a place of the
 * local frame and on Earth. */
static struct pel_vec3 sight(const struct pel_snapshot *s,
                             const struct pel_stance *eye,
                             struct pel_vec3 target,
                             const struct pel_geo_place *target_at)
{
    struct ground g = ground_of(s);
    struct pel_vec3 from = { eye->east_m, eye->north_m, eye->altitude_m };
    double apart = hypot(target.x - from.x, target.y - from.y);
    if (apart < AIM_M && from.z < AIM_BELOW_M &&
        hypot(from.x, from.y) < PEL_PLACE_MAP_M) {
        return pel_globe_offset(from, target);
    }
    struct pel_geo_place at = { .height_m = from.z };
    pel_geo_from_local(g.lat0, g.lon0, from.x, from.y, &at.latitude,
                       &at.longitude);
    struct pel_mat3 axes =
        pel_geo_local_axes(g.lat0, g.lon0, at.latitude, at.longitude);
    return within(&axes, minus(earth_of(target_at), earth_of(&at)));
}

static void look(const struct pel_snapshot *s, const struct pel_view_place *p,
                 double time_s, bool in_wakes, struct pel_stance *out)
{
    struct ground g = ground_of(s);
    struct pel_geo_place at = p->target_at;
    struct pel_vec3 target = { 0, 0, at.height_m };
    if (p->target >= 0) {
        struct pel_entity_state e;
        (in_wakes ? pel_snapshot_entity_in_wakes
                  : pel_snapshot_entity_at)(s, (size_t)p->target, time_s, &e);
        target = (struct pel_vec3){ e.east_m, e.north_m,
                                    at.height_m + e.altitude_m };
        at.height_m = target.z;
        pel_geo_from_local(g.lat0, g.lon0, target.x, target.y, &at.latitude,
                           &at.longitude);
    } else {
        pel_geo_to_local(g.lat0, g.lon0, at.latitude, at.longitude, &target.x,
                         &target.y);
    }
    struct pel_vec3 ahead = out->axes.y;
    out->axes = facing(sight(s, out, target, &at), atan2(ahead.x, ahead.y));
}

/* Orbit, satellite and waypoints: a place on Earth that moves. */
static void stand_moving(const struct pel_snapshot *s,
                         const struct pel_view_place *p, double time_s,
                         struct pel_stance *out)
{
    struct ground g = ground_of(s);
    struct pel_way_pose pose = { 0 };
    struct pel_vec3 carried;
    struct pel_geo_place middle = middle_of(s, p, time_s, &carried);
    struct pel_geo_place before = moving_at(p, &middle, time_s - RATE_S, &pose);
    struct pel_geo_place after = moving_at(p, &middle, time_s + RATE_S, &pose);
    struct pel_geo_place at = moving_at(p, &middle, time_s, &pose);
    struct pel_mat3 axes =
        pel_geo_local_axes(g.lat0, g.lon0, at.latitude, at.longitude);
    struct pel_vec3 moved =
        within(&axes, minus(earth_of(&after), earth_of(&before)));
    pel_geo_to_local(g.lat0, g.lon0, at.latitude, at.longitude, &out->east_m,
                     &out->north_m);
    out->altitude_m = at.height_m;
    out->velocity_mps =
        pel_vec3_add(carried, pel_vec3_scale(moved, 0.5 / RATE_S));
    if (p->stand == PEL_STAND_ORBIT) {
        struct pel_vec3 in_map = { 0, 0, middle.height_m };
        pel_geo_to_local(g.lat0, g.lon0, middle.latitude, middle.longitude,
                         &in_map.x, &in_map.y);
        /* From straight above, the middle's north is up. */
        double turned =
            pel_geo_turn(g.lat0, g.lon0, middle.latitude, middle.longitude);
        out->axes = facing(sight(s, out, in_map, &middle), turned);
    } else if (p->stand == PEL_STAND_SATELLITE) {
        out->axes = pel_attitude(atan2(moved.x, moved.y), 0, 0);
    } else {
        double turned = pel_geo_turn(g.lat0, g.lon0, at.latitude, at.longitude);
        out->axes = pel_attitude(pose.heading_rad + turned, pose.pitch_rad,
                                 pose.roll_rad);
    }
}

/* As it is seen from its own place. */
static void entity_there(const struct pel_snapshot *s, size_t index,
                         double time_s, bool in_wakes,
                         struct pel_entity_state *out)
{
    struct pel_place place;
    pel_snapshot_entity_level(s, index, time_s, out);
    place = pel_place_square(out->east_m, out->north_m);
    if (place.far) {
        pel_place_settle(s, &place);
    }
    pel_snapshot_entity_seen(s, index, time_s, in_wakes, &place, out);
}

static void stand_carried(const struct pel_snapshot *s,
                          const struct pel_view_state *view, double time_s,
                          bool in_wakes, struct pel_stance *out)
{
    struct pel_entity_state carrier = { 0 };
    if (view->entity >= 0) {
        entity_there(s, (size_t)view->entity, time_s, in_wakes, &carrier);
    }
    out->axes =
        pel_attitude(carrier.heading_rad, view->level ? 0 : carrier.pitch_rad,
                     view->level ? 0 : carrier.roll_rad);
    struct pel_vec3 arm = pel_mat3_apply(
        &out->axes,
        (struct pel_vec3){ view->right_m, view->forward_m, view->up_m });
    out->east_m = carrier.east_m + arm.x;
    out->north_m = carrier.north_m + arm.y;
    out->altitude_m = carrier.altitude_m + arm.z;
    out->velocity_mps =
        (struct pel_vec3){ carrier.speed_mps * sin(carrier.course_rad),
                           carrier.speed_mps * cos(carrier.course_rad),
                           carrier.climb_mps };
}

void pel_view_stance(const struct pel_snapshot *s, size_t index, double time_s,
                     bool in_wakes, struct pel_stance *out)
{
    const struct pel_view_state *view = &s->views[index];
    const struct pel_view_place *p = &view->place;
    *out = (struct pel_stance){ 0 };
    if (p->stand == PEL_STAND_CARRIED) {
        stand_carried(s, view, time_s, in_wakes, out);
    } else if (p->stand == PEL_STAND_AT) {
        out->east_m = p->east_m;
        out->north_m = p->north_m;
        out->altitude_m = p->at.height_m;
        out->axes = pel_attitude(p->turned_rad, 0, 0);
    } else {
        stand_moving(s, p, time_s, out);
    }
    if (p->looks) {
        look(s, p, time_s, in_wakes, out);
    }
}
