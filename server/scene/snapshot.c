#include "scene/snapshot.h"

#include <string.h>

#include "base/watch.h"
#include "models/model.h"
#include "ocean/foam.h"
#include "ocean/restquery.h"
#include "optics/moon.h"
#include "scene/build.h"
#include "scene/ephemeris.h"
#include "scene/place.h"
#include "scene/reckon.h"
#include "scene/sharedsea.h"
#include "scene/sun.h"
#include "scene/wakes.h"
#include "scene/washes.h"

int pel_snapshot_find_view(const struct pel_snapshot *s, const char *name)
{
    for (size_t i = 0; i < s->view_count; i++) {
        if (strcmp(s->views[i].name, name) == 0) {
            return (int)i;
        }
    }
    return -1;
}

const struct pel_sailing *pel_snapshot_ship(const struct pel_snapshot *s,
                                            size_t index)
{
    for (size_t i = 0; i < s->ship_count; i++) {
        if (s->ships[i].entity == index) {
            return &s->ships[i];
        }
    }
    return NULL;
}

void pel_snapshot_ship_motion(const struct pel_snapshot *s,
                              const struct pel_ship *ship, double time_s,
                              struct pel_ship_motion *out)
{
    if (pel_ship_asks(ship, time_s)) {
        PEL_WATCH("own ship");
        pel_ship_at(ship, time_s, pel_snapshot_sea(s), out);
    } else {
        pel_ship_at(ship, time_s, NULL, out);
    }
}

static void ship_at(const struct pel_snapshot *s,
                    const struct pel_sailing *sailing, double time_s,
                    struct pel_entity_state *out)
{
    struct pel_ship_motion m;
    pel_snapshot_ship_motion(s, &sailing->ship, time_s, &m);
    *out = s->entities[sailing->entity];
    out->east_m = m.east_m;
    out->north_m = m.north_m;
    out->altitude_m = m.heave.x + s->sea_level_m;
    out->heading_rad = m.heading_rad;
    out->pitch_rad = m.pitch.x;
    out->roll_rad = m.roll.x;
    out->speed_mps = fabs(m.speed_mps);
    out->course_rad = m.heading_rad + (m.speed_mps < 0 ? PEL_PI : 0);
    out->turn_rate_rps = m.turn_rate_rps;
    out->pose_time_s = time_s;
}

/* Where the wind has brought it. */
static void drift_to(const struct pel_snapshot *s, double time_s,
                     double pose_time_s, struct pel_entity_state *e)
{
    const struct pel_adrift what = { e->leeway, e->mooring_m, e->id,
                                     s->wind_mps, s->wind_to_rad };
    double east = 0, north = 0, bow = 0;
    if (e->mooring_m > 0) {
        pel_reckon_swing(&what, time_s, &east, &north, &bow);
        e->heading_rad =
            e->model->class < PEL_MODEL_LATERAL_PORT ? bow : e->heading_rad;
    } else if (e->leeway > 0) {
        pel_reckon_drift(&what, time_s - pose_time_s, &east, &north);
    }
    e->east_m += east;
    e->north_m += north;
}

/* As deep and as inclined as the sea at the points of its hull asks: what own
 * ship follows late and with its own periods, it follows at once, so that its
 * pose is a function of the moment alone. */
static void float_at(const struct pel_snapshot *s, double time_s,
                     const struct pel_wakes *wakes, struct pel_entity_state *e)
{
    PEL_WATCH("afloat");
    const struct pel_ship hull = { .orders = { .length_m = e->model->length_m,
                                               .beam_m = e->model->beam_m },
                                   .wakes = wakes,
                                   .self = e->id };
    const struct pel_ship_motion at = { .east_m = e->east_m,
                                        .north_m = e->north_m,
                                        .heading_rad = e->heading_rad };
    double sea[3];
    pel_ship_sea(&hull, &at, time_s, pel_snapshot_sea(s), sea);
    e->altitude_m = sea[0] + s->sea_level_m;
    e->pitch_rad = sea[1];
    e->roll_rad = sea[2];
}

void pel_snapshot_entity_level(const struct pel_snapshot *s, size_t index,
                               double time_s, struct pel_entity_state *out)
{
    const struct pel_entity_state *at = &s->entities[index];
    const struct pel_sailing *sailing = pel_snapshot_ship(s, index);
    if (sailing) {
        ship_at(s, sailing, time_s, out);
        return;
    }
    double seconds =
        pel_reckon_seconds(at->pose_time_s, time_s, s->reckoning_s);
    double east, north, turned = at->turn_rate_rps * seconds;
    pel_reckon_move(at->speed_mps, at->course_rad, at->turn_rate_rps, seconds,
                    &east, &north);
    *out = *at;
    out->east_m += east;
    out->north_m += north;
    out->heading_rad = at->heading_rad + turned;
    out->course_rad = at->course_rad + turned;
    out->altitude_m = pel_clamp(at->altitude_m + at->climb_mps * seconds,
                                PEL_LOWEST_M, PEL_HIGHEST_M);
    out->pitch_rad = pel_clamp(at->pitch_rad + at->pitch_rate_rps * seconds,
                               -PEL_PI / 2, PEL_PI / 2);
    out->roll_rad = at->roll_rad + at->roll_rate_rps * seconds;
    out->pose_time_s = at->pose_time_s + seconds;
    if (at->afloat && at->model) {
        drift_to(s, time_s, at->pose_time_s, out);
    }
}

static void entity_at(const struct pel_snapshot *s, size_t index, double time_s,
                      const struct pel_wakes *wakes,
                      const struct pel_place *place,
                      struct pel_entity_state *out)
{
    pel_snapshot_entity_level(s, index, time_s, out);
    if (place && place->far) {
        pel_place_carry(s, place, out);
    }
    if (out->afloat && out->model && !pel_snapshot_ship(s, index)) {
        float_at(s, time_s, wakes, out);
    }
}

void pel_snapshot_entity_at(const struct pel_snapshot *s, size_t index,
                            double time_s, struct pel_entity_state *out)
{
    entity_at(s, index, time_s, NULL, NULL, out);
}

void pel_snapshot_entity_in_wakes(const struct pel_snapshot *s, size_t index,
                                  double time_s, struct pel_entity_state *out)
{
    entity_at(s, index, time_s, s->wakes, NULL, out);
}

void pel_snapshot_entity_seen(const struct pel_snapshot *s, size_t index,
                              double time_s, bool in_wakes,
                              const struct pel_place *place,
                              struct pel_entity_state *out)
{
    entity_at(s, index, time_s, in_wakes ? s->wakes : NULL, place, out);
}

static bool goes_on(const struct pel_entity_state *e)
{
    return e->speed_mps != 0 || e->turn_rate_rps != 0 || e->climb_mps != 0 ||
           e->pitch_rate_rps != 0 || e->roll_rate_rps != 0;
}

unsigned pel_snapshot_stale(const struct pel_snapshot *s, double time_s)
{
    unsigned stale = s->stale;
    for (size_t i = 0; i < s->entity_count; i++) {
        const struct pel_entity_state *e = &s->entities[i];
        if (goes_on(e) && fabs(time_s - e->pose_time_s) > s->reckoning_s &&
            !pel_snapshot_ship(s, i)) {
            stale |= PEL_STALE_POSES;
        }
    }
    return stale;
}

/* The sea, and what ships leave of its short waves: of places beside their wash
 * the bits are the sea's. */
static void query_in_wash(const struct pel_snapshot *s,
                          const struct pel_wash *wash,
                          const struct pel_vec2 *points, size_t n,
                          double time_s, bool moving,
                          struct pel_surface_sample *out)
{
    const struct pel_sea *sea = pel_snapshot_sea(s);
    (moving ? pel_sea_query_moving : pel_sea_query)(sea, points, n, time_s,
                                                    out);
    enum { AT_ONCE = 64 };
    size_t which[AT_ONCE], found = 0;
    struct pel_vec2 at[AT_ONCE];
    struct pel_surface_sample there[AT_ONCE];
    for (size_t i = 0; i < n && wash; i++) {
        if (pel_wash_near(wash, points[i].x, points[i].y)) {
            which[found] = i;
            at[found++] = points[i];
        }
        if (found == AT_ONCE || i + 1 == n) {
            pel_rest_query(sea, at, found, time_s, moving, wash, there);
            for (; found > 0; found--) {
                out[which[found - 1]] = there[found - 1];
            }
        }
    }
}

/* As without wakes, at the places that the wakes carry there, and they on top.
 */
static void query_in_wakes(const struct pel_snapshot *s,
                           const struct pel_wake_moment *moment,
                           const struct pel_wash *wash,
                           const struct pel_vec2 *points, size_t n,
                           double time_s, bool moving,
                           struct pel_surface_sample *out)
{
    enum { AT_ONCE = 64 };
    struct pel_vec2 at[AT_ONCE];
    struct pel_wake_shift there[AT_ONCE];
    for (size_t first = 0; first < n; first += AT_ONCE) {
        size_t count = n - first < AT_ONCE ? n - first : AT_ONCE;
        for (size_t i = 0; i < count; i++) {
            at[i] = pel_wakes_before(moment, PEL_WAKES_ALL, points[first + i],
                                     &there[i]);
        }
        query_in_wash(s, wash, at, count, time_s, moving, out + first);
        for (size_t i = 0; i < count; i++) {
            pel_wakes_onto(&there[i], &out[first + i]);
        }
    }
}

void pel_snapshot_surface(const struct pel_snapshot *s,
                          const struct pel_vec2 *points, size_t n,
                          double time_s, bool moving,
                          struct pel_surface_sample *out)
{
    PEL_WATCH("surface");
    const struct pel_box of = pel_box_of(points, n);
    const struct pel_wake_moment *moment =
        pel_wakes_within(s->wakes, time_s, &of);
    const struct pel_wash *wash = pel_snapshot_wash(s, time_s);
    if (moment) {
        query_in_wakes(s, moment, wash, points, n, time_s, moving, out);
        pel_wake_moment_unref(moment);
    } else {
        query_in_wash(s, wash, points, n, time_s, moving, out);
    }
    pel_wash_destroy(wash);
    for (size_t i = 0; i < n; i++) {
        out[i].height_m += s->sea_level_m;
        out[i].depth_m = pel_snapshot_depth(s, points[i].x, points[i].y);
    }
}

void pel_snapshot_foam(const struct pel_snapshot *s, size_t n, double time_s,
                       struct pel_surface_sample *samples)
{
    const struct pel_wash *wash = pel_snapshot_wash(s, time_s);
    pel_foam_query(pel_snapshot_sea(s), wash, n, time_s, samples);
    pel_wash_destroy(wash);
    for (size_t i = 0; i < n; i++) {
        if (samples[i].depth_m + samples[i].height_m < 0) {
            samples[i].foam = 0; /* dry */
        }
    }
}

bool pel_snapshot_transforms(const struct pel_snapshot *s)
{
    return s->wakes || s->sea->desc.synthesiser == PEL_SYNTHESISER_FFT;
}

bool pel_snapshot_prepare(const struct pel_snapshot *s, double time_s,
                          bool moving, const struct pel_box *of,
                          bool (*go_on)(void *user), void *user)
{
    /* What others are at is left to them. */
    bool sea =
        pel_sea_prepare(pel_snapshot_sea(s), time_s, moving, go_on, user);
    bool wakes = pel_wakes_prepare(s->wakes, time_s, of, go_on, user);
    bool wash = go_on(user);
    if (wash) {
        pel_wash_destroy(pel_snapshot_wash(s, time_s));
    }
    return sea && wakes && wash;
}

double pel_snapshot_depth(const struct pel_snapshot *s, double east_m,
                          double north_m)
{
    double height_m = -s->water.depth_m;
    return s->seabed &&
                   !pel_seabed_height(s->seabed, east_m, north_m, &height_m)
               ? NAN
               : -height_m;
}

struct pel_vec3 pel_snapshot_sun(const struct pel_snapshot *s, double time_s)
{
    double azimuth, elevation;
    pel_sun_position(s->epoch_unix_s + time_s, s->origin_latitude_rad,
                     s->origin_longitude_rad, &azimuth, &elevation);
    if (s->sun_azimuth_fixed) {
        azimuth = s->sun_azimuth_rad;
    }
    if (s->sun_elevation_fixed) {
        elevation = s->sun_elevation_rad;
    }
    return (struct pel_vec3){ sin(azimuth) * cos(elevation),
                              cos(azimuth) * cos(elevation), sin(elevation) };
}

static void place_sun(const struct pel_snapshot *s, double time_s,
                      struct pel_light *out)
{
    *out = (struct pel_light){ .direction = pel_snapshot_sun(s, time_s),
                               .strength = 1.0 };
}

/* None by the clock where the Sun is not by it. */
static void place_moon(const struct pel_snapshot *s, double time_s,
                       struct pel_light *out)
{
    if (s->sun_elevation_fixed && !s->moon_elevation_fixed) {
        *out = (struct pel_light){ .direction = { 0, 0, -1 } };
        return;
    }
    struct pel_moon_place at;
    pel_ephemeris_moon(s->epoch_unix_s + time_s, s->origin_latitude_rad,
                       s->origin_longitude_rad, &at);
    double azimuth = atan2(at.direction.x, at.direction.y);
    double elevation = asin(pel_clamp(at.direction.z, -1.0, 1.0));
    if (s->moon_azimuth_fixed) {
        azimuth = s->moon_azimuth_rad;
    }
    if (s->moon_elevation_fixed) {
        elevation = s->moon_elevation_rad;
    }
    const struct pel_vec3 to = { sin(azimuth) * cos(elevation),
                                 cos(azimuth) * cos(elevation),
                                 sin(elevation) };
    *out = pel_light_moon(to, pel_snapshot_sun(s, time_s),
                          s->moon_phase_fixed ? s->moon_lit : at.lit,
                          s->moon_elevation_fixed ? PEL_MOON_DISTANCE
                                                  : at.distance_m);
}

void pel_snapshot_lights(const struct pel_snapshot *s, double time_s,
                         struct pel_light out[PEL_LIGHTS])
{
    static void (*const place[PEL_LIGHTS])(const struct pel_snapshot *, double,
                                           struct pel_light *) = {
        [PEL_LIGHT_SUN] = place_sun,
        [PEL_LIGHT_MOON] = place_moon,
    };
    for (int i = 0; i < PEL_LIGHTS; i++) {
        place[i](s, time_s, &out[i]);
    }
}

void pel_snapshot_night(const struct pel_snapshot *s, double time_s,
                        struct pel_vec3 sun, struct pel_night_sky *out)
{
    double below = -asin(pel_clamp(sun.z, -1.0, 1.0)) / PEL_DEG;
    double x = pel_clamp(0.25 * (below - 1.0), 0.0, 1.0);
    *out = (struct pel_night_sky){ .on = s->stars && below > 1.0 };
    if (out->on) {
        pel_ephemeris_night(s->epoch_unix_s + time_s, s->origin_latitude_rad,
                            s->origin_longitude_rad, out);
        out->on = true;
        out->stars = x * x * (3.0 - 2.0 * x);
    }
}

struct pel_mat3 pel_attitude(double heading_rad, double pitch_rad,
                             double roll_rad)
{
    double sh = sin(heading_rad), ch = cos(heading_rad);
    double sp = sin(pitch_rad), cp = cos(pitch_rad);
    double sr = sin(roll_rad), cr = cos(roll_rad);
    struct pel_vec3 right = { ch, -sh, 0 };
    struct pel_vec3 forward = { sh * cp, ch * cp, sp };
    struct pel_vec3 up = { -sh * sp, -ch * sp, cp };
    return (struct pel_mat3){
        pel_vec3_add(pel_vec3_scale(right, cr), pel_vec3_scale(up, -sr)),
        forward,
        pel_vec3_add(pel_vec3_scale(up, cr), pel_vec3_scale(right, sr)),
    };
}

void pel_entity_object(const struct pel_entity_state *e, struct pel_object *out)
{
    struct pel_mat3 m = pel_attitude(e->heading_rad, e->pitch_rad, e->roll_rad);
    *out = (struct pel_object){
        .id = e->id,
        .model = e->model,
        .east_m = e->east_m,
        .north_m = e->north_m,
        .altitude_m = e->altitude_m,
        .world_from_model = { m.y, pel_vec3_scale(m.x, -1), m.z },
    };
}

size_t pel_snapshot_objects(const struct pel_snapshot *s, double time_s,
                            const struct pel_place *place,
                            struct pel_object out[PEL_MAX_ENTITIES])
{
    size_t count = 0;
    for (size_t i = 0; i < s->entity_count && count < PEL_MAX_ENTITIES; i++) {
        struct pel_entity_state e;
        if (!s->entities[i].model) {
            continue;
        }
        entity_at(s, i, time_s, s->wakes, place, &e);
        pel_entity_object(&e, &out[count++]);
    }
    return count;
}
