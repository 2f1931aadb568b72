#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "bridges/cigi_pose.h"
#include "bridges/cigi_world.h"
#include "scene/geodesy.h"

#define MAX_SPEED_MPS 200.0
#define MAX_TURN_DPS 90.0

static void set_pose(Pelagos__Entity *e, double latitude, double longitude,
                     double altitude_m, double time_s)
{
    e->has_latitude = e->has_longitude = e->has_altitude = true;
    e->latitude = latitude;
    e->longitude = longitude;
    e->altitude = altitude_m;
    e->has_pose_time = true;
    e->pose_time = time_s;
}

static void set_attitude(Pelagos__Entity *e, double heading, double pitch,
                         double roll)
{
    e->has_heading = e->has_pitch = e->has_roll = true;
    e->heading = pel_cigi_wrap(heading);
    e->pitch = pitch;
    e->roll = roll;
}

static struct pel_cigi_follower *follower_of(struct pel_cigi_edit *edit,
                                             uint32_t id, bool make)
{
    struct pel_cigi_follower *spare = NULL;
    for (size_t i = 0; i < PEL_CIGI_FOLLOWERS; i++) {
        struct pel_cigi_follower *f = &edit->world->followers[i];
        if (f->used && f->id == id) {
            return f;
        }
        spare = !f->used && !spare ? f : spare;
    }
    if (!make || !spare) {
        return NULL;
    }
    *spare = (struct pel_cigi_follower){ .used = true, .id = id };
    return spare;
}

static void attach(struct pel_cigi_edit *edit, const struct pel_cigi_packet *p)
{
    uint32_t id = (uint32_t)pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_ID);
    uint32_t parent = (uint32_t)pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_PARENT);
    struct pel_cigi_follower *f =
        parent == id ? NULL : follower_of(edit, id, true);
    if (!f) {
        edit->skipped++;
        return;
    }
    const struct pel_cigi_follower was = *f;
    bool goes_on = was.how == PEL_CIGI_ON_PARENT && was.parent == parent;
    *f = (struct pel_cigi_follower){
        .used = true,
        .id = id,
        .how = PEL_CIGI_ON_PARENT,
        .rated_s = edit->time_s,
        .parent = parent,
        .offset_m = { pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_LATITUDE),
                      pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_LONGITUDE),
                      pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_ALTITUDE) },
        .roll_deg = pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_ROLL),
        .pitch_deg = pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_PITCH),
        .yaw_deg = pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_YAW),
    };
    if (goes_on) { /* its rates hold until the next ones */
        memcpy(f->rate_mps, was.rate_mps, sizeof f->rate_mps);
        f->roll_dps = was.roll_dps;
        f->pitch_dps = was.pitch_dps;
        f->yaw_dps = was.yaw_dps;
    }
}

/* Clamped to the sea, or no follower any more. */
static void clamp_to_sea(struct pel_cigi_edit *edit, uint32_t id, bool clamped,
                         bool conformal, double height_m)
{
    struct pel_cigi_follower *f = follower_of(edit, id, clamped);
    if (!clamped) {
        if (f) {
            f->used = false;
        }
        return;
    }
    if (!f) {
        edit->skipped++;
        return;
    }
    *f = (struct pel_cigi_follower){
        .used = true,
        .id = id,
        .how = conformal ? PEL_CIGI_ON_SLOPE : PEL_CIGI_ON_SEA,
        .height_m = height_m,
        .known = f->known && f->how != PEL_CIGI_ON_PARENT,
        .sea_m = f->sea_m,
        .normal = f->normal,
    };
}

void pel_cigi_take_entity(struct pel_cigi_edit *edit,
                          const struct pel_cigi_packet *p)
{
    uint32_t id = (uint32_t)pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_ID);
    double clamp = pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_CLAMP);
    double altitude_m = pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_ALTITUDE);
    if (pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_ATTACH) != 0) {
        attach(edit, p);
        return;
    }
    Pelagos__Entity *e = pel_cigi_edit_entity(edit, id);
    if (!e) {
        return;
    }
    set_pose(e, pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_LATITUDE),
             pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_LONGITUDE), altitude_m,
             edit->time_s);
    set_attitude(e, pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_YAW),
                 pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_PITCH),
                 pel_cigi_get(p, PEL_CIGI_ENTITY_CONTROL_ROLL));
    clamp_to_sea(edit, id, clamp == 1 || clamp == 2, clamp == 2, altitude_m);
}

void pel_cigi_take_conformal(struct pel_cigi_edit *edit,
                             const struct pel_cigi_packet *p)
{
    uint32_t id = (uint32_t)pel_cigi_get(p, PEL_CIGI_CONFORMAL_ID);
    Pelagos__Entity *e = pel_cigi_edit_entity(edit, id);
    if (!e) {
        return;
    }
    set_pose(e, pel_cigi_get(p, PEL_CIGI_CONFORMAL_LATITUDE),
             pel_cigi_get(p, PEL_CIGI_CONFORMAL_LONGITUDE), 0, edit->time_s);
    set_attitude(e, pel_cigi_get(p, PEL_CIGI_CONFORMAL_YAW), 0, 0);
    clamp_to_sea(edit, id, true, true, 0);
}

/* --- poses as they will be ----------------------------------------------- */

/* Local place and heading of an entity after this edit; false: it is not
 * there. */
static bool pose_after(const struct pel_cigi_edit *edit, uint32_t id,
                       struct pel_vec3 *at, struct pel_mat3 *axes)
{
    const struct pel_snapshot *s = edit->snapshot;
    struct pel_entity_state now = { 0 };
    int index = pel_cigi_find_entity(s, id);
    const Pelagos__Entity *with = NULL;
    for (size_t i = 0; i < edit->state.n_entities; i++) {
        if (edit->entity_list[i]->id == id) {
            with = edit->entity_list[i];
        }
    }
    if (index < 0 && !with) {
        return false;
    }
    if (index >= 0) {
        pel_snapshot_entity_at(s, (size_t)index, edit->time_s, &now);
    }
    if (with && with->has_latitude) {
        double latitude = s->origin_latitude_rad / PEL_DEG;
        double longitude = s->origin_longitude_rad / PEL_DEG;
        pel_geo_to_local(
            latitude, longitude, pel_clamp(with->latitude, -90, 90),
            remainder(with->longitude, 360), &now.east_m, &now.north_m);
        now.altitude_m = with->altitude;
    }
    if (with && with->has_heading) {
        now.heading_rad =
            with->heading * PEL_DEG +
            pel_geo_convergence(s->origin_latitude_rad / PEL_DEG,
                                s->origin_longitude_rad / PEL_DEG,
                                pel_clamp(with->latitude, -90, 90),
                                remainder(with->longitude, 360));
        now.pitch_rad = with->pitch * PEL_DEG;
        now.roll_rad = with->roll * PEL_DEG;
    }
    *at = (struct pel_vec3){ now.east_m, now.north_m, now.altitude_m };
    *axes = pel_cigi_axes(now.heading_rad, now.pitch_rad, now.roll_rad);
    return true;
}

static void place_attached(struct pel_cigi_edit *edit,
                           const struct pel_cigi_follower *f)
{
    double s = edit->time_s - f->rated_s;
    struct pel_vec3 at, offset = { f->offset_m[0] + s * f->rate_mps[0],
                                   f->offset_m[1] + s * f->rate_mps[1],
                                   f->offset_m[2] + s * f->rate_mps[2] };
    struct pel_mat3 parent, whole;
    if (!pose_after(edit, f->parent, &at, &parent)) {
        edit->skipped++;
        return;
    }
    Pelagos__Entity *e = pel_cigi_edit_entity(edit, f->id);
    if (!e) {
        return;
    }
    /* The child's own axes, written in its parent's: north is forward there,
     * east right, up the reverse of down. */
    struct pel_mat3 own =
        pel_cigi_axes((f->yaw_deg + s * f->yaw_dps) * PEL_DEG,
                      (f->pitch_deg + s * f->pitch_dps) * PEL_DEG,
                      (f->roll_deg + s * f->roll_dps) * PEL_DEG);
    struct pel_vec3 *from[] = { &own.x, &own.y, &own.z };
    struct pel_vec3 *to[] = { &whole.x, &whole.y, &whole.z };
    for (int i = 0; i < 3; i++) {
        struct pel_vec3 in_parent = { from[i]->y, from[i]->x, -from[i]->z };
        *to[i] = pel_mat3_apply(&parent, in_parent);
    }
    at = pel_vec3_add(at, pel_mat3_apply(&parent, offset));
    double latitude, longitude, heading, pitch, roll;
    pel_cigi_geodetic(edit->snapshot, at, &latitude, &longitude);
    pel_cigi_angles(&whole, &heading, &pitch, &roll);
    set_pose(e, latitude, longitude, at.z, edit->time_s);
    set_attitude(e, pel_cigi_true_deg(edit->snapshot, at, heading),
                 pitch / PEL_DEG, roll / PEL_DEG);
}

/* The sea below at the edit's time; one of FFT or ship waves as it was when
 * last looked at, which takes a thread some milliseconds (cigi_sea.h). */
static void sea_below(const struct pel_cigi_edit *edit,
                      const struct pel_cigi_follower *f, struct pel_vec3 at,
                      struct pel_surface_sample *out)
{
    struct pel_vec2 point = { at.x, at.y };
    if (!pel_snapshot_transforms(edit->snapshot)) {
        pel_snapshot_surface(edit->snapshot, &point, 1, edit->time_s, false,
                             out);
        return;
    }
    *out = (struct pel_surface_sample){
        .height_m = f->known ? f->sea_m : edit->snapshot->sea_level_m,
        .normal = f->known ? f->normal : (struct pel_vec3){ 0, 0, 1 },
    };
}

/* Height, and for a conformal one pitch and roll, from the sea of before this
 * edit. */
static void place_clamped(struct pel_cigi_edit *edit,
                          const struct pel_cigi_follower *f)
{
    struct pel_vec3 at;
    struct pel_mat3 axes;
    struct pel_surface_sample sample;
    if (!pose_after(edit, f->id, &at, &axes)) {
        edit->skipped++;
        return;
    }
    Pelagos__Entity *e = pel_cigi_edit_entity(edit, f->id);
    if (!e) {
        return;
    }
    sea_below(edit, f, at, &sample);
    e->has_altitude = true;
    e->altitude = sample.height_m + f->height_m;
    e->has_pose_time = true;
    e->pose_time = edit->time_s;
    if (f->how == PEL_CIGI_ON_SLOPE) {
        double heading = atan2(axes.x.x, axes.x.y);
        struct pel_vec3 n = sample.normal;
        double ahead = n.x * sin(heading) + n.y * cos(heading);
        double right = n.x * cos(heading) - n.y * sin(heading);
        double pitch = atan2(-ahead, n.z);
        e->has_pitch = e->has_roll = true;
        e->pitch = pitch / PEL_DEG;
        e->roll = atan2(right, hypot(ahead, n.z)) / PEL_DEG;
    }
}

void pel_cigi_place_followers(struct pel_cigi_edit *edit)
{
    for (size_t i = 0; i < PEL_CIGI_FOLLOWERS; i++) {
        const struct pel_cigi_follower *f = &edit->world->followers[i];
        if (f->used && f->how != PEL_CIGI_ON_PARENT) {
            place_clamped(edit, f);
        }
    }
    for (size_t i = 0; i < PEL_CIGI_FOLLOWERS; i++) {
        const struct pel_cigi_follower *f = &edit->world->followers[i];
        if (f->used && f->how == PEL_CIGI_ON_PARENT) {
            place_attached(edit, f);
        }
    }
}

/* --- rates --------------------------------------------------------------- */

static void remember_rated(struct pel_cigi_world *world, uint32_t id)
{
    for (size_t i = 0; i < world->rated_count; i++) {
        if (world->rated[i] == id) {
            return;
        }
    }
    if (world->rated_count < PEL_MAX_ENTITIES) {
        world->rated[world->rated_count++] = id;
    }
}

static double turn(const struct pel_cigi_packet *p, enum pel_cigi_field field)
{
    return pel_clamp(pel_cigi_get(p, field), -MAX_TURN_DPS, MAX_TURN_DPS);
}

/* An attached entity's: along its parent's axes, or its own; it moves on it
 * from where it is by now. */
static void rate_attached(struct pel_cigi_edit *edit,
                          const struct pel_cigi_packet *p,
                          struct pel_cigi_follower *f)
{
    double seconds = edit->time_s - f->rated_s;
    struct pel_vec3 rate = { pel_cigi_get(p, PEL_CIGI_RATE_X),
                             pel_cigi_get(p, PEL_CIGI_RATE_Y),
                             pel_cigi_get(p, PEL_CIGI_RATE_Z) };
    for (int i = 0; i < 3; i++) {
        f->offset_m[i] += seconds * f->rate_mps[i];
    }
    f->roll_deg += seconds * f->roll_dps;
    f->pitch_deg += seconds * f->pitch_dps;
    f->yaw_deg += seconds * f->yaw_dps;
    if (pel_cigi_get(p, PEL_CIGI_RATE_LOCAL) != 0) {
        struct pel_mat3 own =
            pel_cigi_axes(f->yaw_deg * PEL_DEG, f->pitch_deg * PEL_DEG,
                          f->roll_deg * PEL_DEG);
        struct pel_vec3 v = pel_mat3_apply(&own, rate);
        rate = (struct pel_vec3){ v.y, v.x, -v.z };
    }
    f->rate_mps[0] = rate.x;
    f->rate_mps[1] = rate.y;
    f->rate_mps[2] = rate.z;
    f->roll_dps = turn(p, PEL_CIGI_RATE_ROLL);
    f->pitch_dps = turn(p, PEL_CIGI_RATE_PITCH);
    f->yaw_dps = turn(p, PEL_CIGI_RATE_YAW);
    f->rated_s = edit->time_s;
}

void pel_cigi_take_rate(struct pel_cigi_edit *edit,
                        const struct pel_cigi_packet *p)
{
    uint32_t id = (uint32_t)pel_cigi_get(p, PEL_CIGI_RATE_ID);
    struct pel_vec3 at;
    struct pel_mat3 axes;
    struct pel_cigi_follower *f = follower_of(edit, id, false);
    if (f && f->how == PEL_CIGI_ON_PARENT &&
        pel_cigi_get(p, PEL_CIGI_RATE_TO_PART) == 0) {
        rate_attached(edit, p, f);
        return;
    }
    if (pel_cigi_get(p, PEL_CIGI_RATE_TO_PART) != 0 ||
        !pose_after(edit, id, &at, &axes)) {
        edit->skipped++;
        return;
    }
    double heading =
        pel_cigi_true_deg(edit->snapshot, at, atan2(axes.x.x, axes.x.y)) *
        PEL_DEG;
    /* North, east, down; or bow, starboard, keel, turned to there. */
    struct pel_vec3 rate = { pel_cigi_get(p, PEL_CIGI_RATE_X),
                             pel_cigi_get(p, PEL_CIGI_RATE_Y),
                             pel_cigi_get(p, PEL_CIGI_RATE_Z) };
    if (pel_cigi_get(p, PEL_CIGI_RATE_LOCAL) != 0) {
        double flat = atan2(axes.x.x, axes.x.y);
        struct pel_vec3 v = pel_mat3_apply(&axes, rate);
        double ahead = v.x * sin(flat) + v.y * cos(flat);
        double right = v.x * cos(flat) - v.y * sin(flat);
        rate = (struct pel_vec3){ ahead * cos(heading) - right * sin(heading),
                                  ahead * sin(heading) + right * cos(heading),
                                  -v.z };
    }
    Pelagos__Entity *e = pel_cigi_edit_entity(edit, id);
    if (!e) {
        return;
    }
    e->has_speed = e->has_course = e->has_turn_rate = true;
    e->has_climb_rate = e->has_pitch_rate = e->has_roll_rate = true;
    e->speed = fmin(hypot(rate.x, rate.y), MAX_SPEED_MPS);
    e->course = pel_cigi_wrap(atan2(rate.y, rate.x) / PEL_DEG);
    e->climb_rate = pel_clamp(-rate.z, -MAX_SPEED_MPS, MAX_SPEED_MPS);
    e->turn_rate = turn(p, PEL_CIGI_RATE_YAW);
    e->pitch_rate = turn(p, PEL_CIGI_RATE_PITCH);
    e->roll_rate = turn(p, PEL_CIGI_RATE_ROLL);
    remember_rated(edit->world, id);
    e->has_pose_time = true;
    e->pose_time = edit->time_s;
}
