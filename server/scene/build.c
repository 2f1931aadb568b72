#include "scene/build.h"

#include <glib.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "fault.h"
#include "optics/thermal.h"
#include "scene/geodesy.h"
#include "scene/ground.h"
#include "scene/helm.h"
#include "scene/lamps.h"
#include "scene/sharedsea.h"
#include "scene/skyplace.h"
#include "scene/sun.h"
#include "scene/track.h"
#include "scene/wakes.h"
#include "scene/washes.h"

struct snapshot {
    struct pel_snapshot public; /* first: what the pointer points to */
    atomic_uint refs;
    struct pel_entity_state entities[PEL_MAX_ENTITIES];
    struct pel_view_state views[PEL_MAX_VIEWS];
};

/* A place in the plane of an origin: geodesics of a microsecond each, which an
 * edit of one entity among 256 need not compute for all of them again. */
struct plane {
    double of[4]; /* the origin, the place [deg] */
    double east_m, north_m, turned_rad;
    bool known;
};
static _Thread_local struct plane planes[PEL_MAX_ENTITIES];

/* Of the entity at that index. */
static struct plane in_plane(const Pelagos__Origin *origin, double lat,
                             double lon, size_t index)
{
    const double of[4] = { origin->latitude, origin->longitude, lat, lon };
    struct plane *kept = &planes[index];
    if (!kept->known || memcmp(kept->of, of, sizeof of) != 0) {
        memcpy(kept->of, of, sizeof of);
        kept->turned_rad = pel_geo_to_plane(of[0], of[1], lat, lon,
                                            &kept->east_m, &kept->north_m);
        kept->known = true;
    }
    return *kept;
}

static void place_entity(const Pelagos__Origin *origin,
                         const Pelagos__Entity *from, size_t index,
                         struct pel_entity_state *to)
{
    const struct plane at =
        in_plane(origin, from->latitude, from->longitude, index);
    double turned = at.turned_rad;
    to->id = from->id;
    to->east_m = at.east_m;
    to->north_m = at.north_m;
    to->altitude_m = from->altitude;
    to->heading_rad = from->heading * PEL_DEG + turned;
    to->pitch_rad = from->pitch * PEL_DEG;
    to->roll_rad = from->roll * PEL_DEG;
    to->speed_mps = from->speed;
    to->course_rad = from->course * PEL_DEG + turned;
    to->turn_rate_rps = from->turn_rate * PEL_DEG;
    to->climb_mps = from->climb_rate;
    to->pitch_rate_rps = from->pitch_rate * PEL_DEG;
    to->roll_rate_rps = from->roll_rate * PEL_DEG;
    to->pose_time_s = from->pose_time;
    to->afloat = from->afloat;
    to->leeway = from->leeway;
    to->mooring_m = from->mooring;
}

static void open_view(const Pelagos__View *from, struct pel_view_state *to)
{
    if (from->frustum) {
        to->tan_left = tan(from->frustum->left * PEL_DEG);
        to->tan_right = tan(from->frustum->right * PEL_DEG);
        to->tan_top = tan(from->frustum->top * PEL_DEG);
        to->tan_bottom = tan(from->frustum->bottom * PEL_DEG);
        return;
    }
    to->tan_right = tan(0.5 * from->field_of_view * PEL_DEG);
    to->tan_left = -to->tan_right;
    to->tan_top = to->tan_right * from->height / from->width;
    to->tan_bottom = -to->tan_top;
}

/* Gain and level of CIGI's sensors: half is as exposed. */
static void place_sensor(const Pelagos__Sensor *from, double water_c,
                         struct pel_sensor *to)
{
    double scale = from->auto_gain ? 1 : pow(4, 2 * from->gain - 1);
    double offset = from->auto_gain ? 0 : from->level - 0.5;
    bool thermal = from->kind == PELAGOS__SENSOR_KIND__THERMAL;
    *to = (struct pel_sensor){
        .kind = from->on ? PEL_SENSOR_ON : PEL_SENSOR_OFF,
        .noise = from->noise,
        .dropout = from->dropout,
        .sense = (enum pel_sense)from->kind,
        .exposure_s = from->exposure_time,
        .f_number = from->f_number,
        .phosphor = (int)from->phosphor,
        .netd_k = from->netd,
        .sea_k = PEL_KELVIN + water_c,
        .air_k = PEL_KELVIN +
                 (from->has_air_temperature ? from->air_temperature : water_c),
        .humidity = from->humidity,
        .cloud = from->cloud,
    };
    if (thermal) {
        /* Half white is the sea's temperature. */
        to->span_k = from->has_span    ? from->span
                     : from->auto_gain ? 0
                                       : 20 / scale;
        to->low_k = to->sea_k - (0.5 + offset) * to->span_k;
        scale = 1;
        offset = 0;
    }
    to->scale = from->black_hot ? -scale : scale;
    to->offset = from->black_hot ? 1 - offset : offset;
}

static void place_radar(const Pelagos__Radar *from, double rain_mm_h,
                        struct pel_radar_set *to)
{
    *to = (struct pel_radar_set){
        .on = true,
        .north_up = from->north_up,
        .rings = from->rings,
        .range_m = 1852 * from->range,
        .gain = from->gain,
        .stc = from->stc,
        .ftc = from->ftc,
        .pulse_s = from->has_pulse ? 1e-6 * from->pulse : 0,
        .beam_rad = from->beam_width * PEL_DEG,
        .turn_s = 60 / from->rotation,
        .rain_mm_h = from->has_rain ? from->rain : rain_mm_h,
    };
}

static void place_view(const Pelagos__State *state, const Pelagos__View *from,
                       struct pel_view_state *to)
{
    strncpy(to->name, from->name, sizeof to->name - 1);
    to->entity = -1;
    for (size_t i = 0; from->has_entity && i < state->n_entities; i++) {
        if (state->entities[i]->id == from->entity) {
            to->entity = (int)i;
        }
    }
    pel_view_place_of(state, from, &to->place);
    to->forward_m = from->forward;
    to->right_m = from->right;
    to->up_m = from->up;
    to->yaw_rad = from->yaw * PEL_DEG;
    to->pitch_rad = from->pitch * PEL_DEG;
    to->roll_rad = from->roll * PEL_DEG;
    to->level = from->level;
    to->width = from->width;
    to->height = from->height;
    to->auto_exposure = !from->has_exposure;
    to->exposure_ev = from->exposure;
    to->tone = (int)from->tone;
    to->vision = (int)from->vision;
    to->glare = from->glare;
    to->antialiasing = from->antialiasing;
    to->shutter_s = from->shutter;
    to->wet_lens = from->wet_lens;
    to->pane = 2166136261U; /* FNV-1a of the name */
    for (const char *c = from->name; *c; c++) {
        to->pane = (to->pane ^ (uint8_t)*c) * 16777619U;
    }
    if (from->meter) {
        strncpy(to->meter, from->meter, sizeof to->meter - 1);
    }
    if (from->sensor) {
        place_sensor(from->sensor, state->water->temperature, &to->sensor);
    }
    if (from->radar) {
        place_radar(from->radar, state->sky->rain, &to->radar);
    }
    open_view(from, to);
}

/* Enums that are numbered as in the schema, each to its last name: a name that
 * only one side has is not built (or, of the schema's alone, fails
 * snapshot_test). */
#define SAME(ours, theirs)                                                     \
    _Static_assert((int)(ours) == (int)(theirs), #ours " as " #theirs)
#define PEL_SPECTRUM(ID, uses, whole, add)                                     \
    SAME(PEL_SPECTRUM_##ID, PELAGOS__SPECTRUM_KIND__##ID);
#include "ocean/spectra.def"
SAME(PEL_SYNTHESISER_TROCHOIDS, PELAGOS__SYNTHESISER__TROCHOIDS);
SAME(PEL_SYNTHESISER_FFT, PELAGOS__SYNTHESISER__FFT);
SAME(PEL_SYNTHESISERS, PELAGOS__SYNTHESISER__FFT + 1);
SAME(PEL_JERLOV_I, PELAGOS__JERLOV_TYPE__I);
SAME(PEL_JERLOV_1C, PELAGOS__JERLOV_TYPE__C1);
SAME(PEL_JERLOV_9C, PELAGOS__JERLOV_TYPE__C9);
SAME(PEL_JERLOV_COUNT, PELAGOS__JERLOV_TYPE__C9 + 1);
SAME(PEL_WATER_TROPICAL, PELAGOS__WATER_NAME__TROPICAL);
SAME(PEL_WATER_NORTH_ATLANTIC, PELAGOS__WATER_NAME__NORTH_ATLANTIC);
SAME(PEL_WATER_BALTIC, PELAGOS__WATER_NAME__BALTIC);
SAME(PEL_WATER_HARBOUR, PELAGOS__WATER_NAME__HARBOUR);
SAME(PEL_WATER_NAME_COUNT, PELAGOS__WATER_NAME__HARBOUR + 1);
SAME(PEL_PARTICLES_FOURNIER_FORAND, PELAGOS__PARTICLE_PHASE__FOURNIER_FORAND);
SAME(PEL_PARTICLES_COUNT, PELAGOS__PARTICLE_PHASE__HENYEY_GREENSTEIN + 1);
SAME(PEL_BOTTOM_BLACK, PELAGOS__BOTTOM__BLACK);
SAME(PEL_BOTTOM_SAND, PELAGOS__BOTTOM__SAND);
SAME(PEL_BOTTOM_MUD, PELAGOS__BOTTOM__MUD);
SAME(PEL_BOTTOM_ROCK, PELAGOS__BOTTOM__ROCK);
SAME(PEL_BOTTOM_CORAL, PELAGOS__BOTTOM__CORAL);
SAME(PEL_BOTTOM_ALBEDO, PELAGOS__BOTTOM__CORAL + 1); /* by its own fields */
SAME(PEL_ORDERS_ALL, PELAGOS__WATER_ORDERS__ALL);
SAME(PEL_ORDERS_TWO, PELAGOS__WATER_ORDERS__TWO);
SAME(PEL_ORDERS_PAPER, PELAGOS__WATER_ORDERS__PAPER);
SAME(PEL_ORDERS_SINGLE, PELAGOS__WATER_ORDERS__SINGLE);
SAME(PEL_ORDERS_COUNT, PELAGOS__WATER_ORDERS__SINGLE + 1);
SAME(PEL_SENSE_VISIBLE, PELAGOS__SENSOR_KIND__VISIBLE);
SAME(PEL_SENSE_LOW_LIGHT, PELAGOS__SENSOR_KIND__LOW_LIGHT);
SAME(PEL_SENSE_THERMAL, PELAGOS__SENSOR_KIND__THERMAL);
SAME(PEL_TONE_FILMIC, PELAGOS__TONE__FILMIC);
SAME(PEL_TONE_LINEAR, PELAGOS__TONE__LINEAR);
SAME(PEL_VISION_CAMERA, PELAGOS__VISION__CAMERA);
SAME(PEL_VISION_EYE, PELAGOS__VISION__EYE);
SAME(PEL_CLOCK_FREE, PELAGOS__CLOCK_MODE__FREE);
SAME(PEL_CLOCK_PACED, PELAGOS__CLOCK_MODE__PACED);
SAME(PEL_CLOCK_STEPPED, PELAGOS__CLOCK_MODE__STEPPED);
SAME(PEL_CLOCK_HOST, PELAGOS__CLOCK_MODE__HOST);

static void place_water(const Pelagos__Water *from,
                        const Pelagos__Seabed *seabed,
                        struct pel_water_desc *desc, struct pel_water_body *to)
{
    *desc = (struct pel_water_desc){
        .kind = from->has_jerlov           ? PEL_WATER_JERLOV
                : from->has_named          ? PEL_WATER_NAMED
                : from->has_absorption_680 ? PEL_WATER_COEFFICIENTS
                                           : PEL_WATER_CHLOROPHYLL,
        .chlorophyll_mg_m3 = from->chlorophyll,
        .has_dissolved = from->has_cdom,
        .dissolved_per_m = from->cdom,
        .dissolved_slope = from->cdom_slope,
        .has_detritus = from->has_detritus,
        .detritus_per_m = from->detritus,
        .detritus_slope = from->detritus_slope,
        .minerals_g_m3 = from->minerals,
        .has_back = from->has_backscatter_ratio,
        .back = from->backscatter_ratio,
        .phase = (enum pel_particles)from->phase,
        .jerlov = (enum pel_jerlov)from->jerlov,
        .name = (enum pel_water_name)from->named,
        .absorption = { from->absorption_680, from->absorption_550,
                        from->absorption_440 },
        .scattering = { from->scattering_680, from->scattering_550,
                        from->scattering_440 },
        .asymmetry = { from->asymmetry_680, from->asymmetry_550,
                       from->asymmetry_440 },
        .salinity_g_kg = from->salinity,
        .temperature_c = from->temperature,
        .depth_m = from->depth,
        .raman = from->raman,
        .bottom = from->has_albedo_680 ? PEL_BOTTOM_ALBEDO
                                       : (enum pel_bottom)from->bottom,
        .albedo = { from->albedo_680, from->albedo_550, from->albedo_440 },
        .has_land = seabed->has_land,
        .land = (enum pel_bottom)seabed->land,
    };
    if (pel_water_resolve(desc, to, NULL)) {
        *to = pel_water_deep(0.2); /* not reached: the state was tested */
    }
}

static void place_sources(const Pelagos__Sources *from,
                          struct pel_snapshot *out)
{
    out->stale = (from->cigi_stale ? PEL_STALE_CIGI : 0) |
                 (from->modbus_stale ? PEL_STALE_MODBUS : 0) |
                 (from->nmea_stale ? PEL_STALE_NMEA : 0) |
                 (from->console_stale ? PEL_STALE_CONSOLE : 0) |
                 (from->other_stale ? PEL_STALE_OTHER : 0);
    out->mark_stale = from->mark;
}

static void fill(const Pelagos__State *state, struct pel_snapshot *out)
{
    out->revision = state->revision;
    out->mode = (enum pel_clock_mode)state->clock->mode;
    out->rate = state->clock->rate;
    if (pel_utc_parse(state->clock->utc, &out->epoch_unix_s)) {
        out->epoch_unix_s = 0; /* not reached: the state was tested */
    }
    out->reckoning_s = state->clock->reckoning;
    out->sea_level_m = state->sea->level;
    place_sources(state->sources, out);
    out->origin_latitude_rad = state->origin->latitude * PEL_DEG;
    out->origin_longitude_rad = state->origin->longitude * PEL_DEG;
    out->wind_mps = state->sea->wind_speed;
    out->wind_to_rad = pel_goes_to(state->sea->wind_direction);
    place_water(state->water, state->seabed, &out->water_desc, &out->water);
    out->water_orders = (enum pel_water_orders)state->water->orders;
    out->motes = (struct pel_mote_water){
        state->water->particles,
        state->water->particle_exponent,
        1e-3 * state->water->particle_largest,
    };
    out->caustics = state->seabed->caustics;
    out->sparkle = state->sea->sparkle;
    out->chlorophyll_mg_m3 = state->water->chlorophyll;
    pel_sky_place(state->sky, out);
    pel_clouds_place(state->sky, out->wind_mps, out->wind_to_rad, &out->clouds);
    pel_fog_place(state, out);
}

static void read_orders(const Pelagos__OwnShip *from,
                        struct pel_ship_orders *to)
{
    double heave_s = pel_ship_heave_period(from->beam);
    *to = (struct pel_ship_orders){
        .rudder_rad = from->rudder * PEL_DEG,
        .throttle = from->throttle,
        .length_m = from->length,
        .beam_m = from->beam,
        .max_speed_mps = from->max_speed,
        .surge_time_s = from->surge_time,
        .turn_gain = from->turn_gain,
        .turn_time = from->turn_time,
        .heave_period_s = from->has_heave_period ? from->heave_period : heave_s,
        .pitch_period_s = from->has_pitch_period ? from->pitch_period : heave_s,
        .roll_period_s = from->has_roll_period
                             ? from->roll_period
                             : pel_ship_roll_period(from->beam),
        .roll_damping = from->roll_damping,
    };
}

/* It begins now, wherever an older pose has been reckoned to. */
static void begin_ship(const Pelagos__State *state, size_t index,
                       const Pelagos__OwnShip *helm,
                       const struct pel_snapshot *s, struct pel_sailing *out)
{
    static _Atomic uint64_t runs;
    struct pel_entity_state e;
    struct pel_ship_orders orders;
    double now_s = state->clock->time;
    pel_snapshot_entity_at(s, index, now_s, &e);
    const struct pel_ship_motion motion = {
        .east_m = e.east_m,
        .north_m = e.north_m,
        .heading_rad = e.heading_rad,
        /* what does not go ahead or astern is not kept */
        .speed_mps = e.speed_mps * cos(e.course_rad - e.heading_rad),
        .turn_rate_rps = e.turn_rate_rps,
        .heave = { e.altitude_m - s->sea_level_m, helm->heave_rate },
        .pitch = { e.pitch_rad, helm->pitch_rate * PEL_DEG },
        .roll = { e.roll_rad, helm->roll_rate * PEL_DEG },
    };
    read_orders(helm, &orders);
    out->entity = index;
    out->run = ++runs;
    pel_ship_start(&out->ship, &orders, &motion, now_s, s->rate);
}

/* Makes room for so many ships that the snapshot has them of its own. */
static struct pel_sailing *new_ships(size_t count)
{
    struct pel_sailing *ships =
        count > 0 ? pel_sure_calloc(count, sizeof *ships) : NULL;
    return ships;
}

static void place_ships(const Pelagos__State *state,
                        const struct pel_sailing *const *going,
                        struct pel_snapshot *out)
{
    size_t index[PEL_MAX_SHIPS], count = 0;
    for (size_t i = 0; i < state->n_entities && count < PEL_MAX_SHIPS; i++) {
        if (pel_helm_on(state, state->entities[i])) {
            index[count++] = i;
        }
    }
    struct pel_sailing *ships = new_ships(count);
    for (size_t k = 0; k < count; k++) {
        size_t i = index[k];
        if (going && going[i]) {
            ships[k] = *going[i];
            ships[k].entity = i;
        } else {
            begin_ship(state, i, pel_helm_on(state, state->entities[i]), out,
                       &ships[k]);
        }
    }
    out->ships = ships;
    out->ship_count = count;
}

/* Ships that go on have done steps ahead in other waves. */
static void meet_wakes(const struct pel_snapshot *s, double now_s)
{
    struct pel_sailing *ships = (struct pel_sailing *)s->ships;
    for (size_t i = 0; i < s->ship_count; i++) {
        struct pel_ship *ship = &ships[i].ship;
        if (ship->wakes != s->wakes) {
            pel_ship_forget(ship, now_s);
        }
        ship->wakes = s->wakes;
        ship->self = s->entities[ships[i].entity].id;
    }
}

const struct pel_snapshot *pel_snapshot_build_going(
    const Pelagos__State *state, struct pel_shared_sea *sea,
    const struct pel_seabed *seabed, const struct pel_panorama *panorama,
    const struct pel_fleet *fleet, const struct pel_weather *weather,
    const struct pel_sailing *const going[PEL_MAX_ENTITIES])
{
    struct snapshot *s = pel_sure_calloc(1, sizeof *s);
    atomic_init(&s->refs, 1);
    atomic_fetch_add(&sea->refs, 1);
    s->public.sea = sea;
    s->public.seabed = pel_seabed_ref(seabed);
    s->public.panorama = pel_panorama_ref(panorama);
    s->public.weather = pel_weather_ref(weather);
    s->public.weather_shift_s =
        state->sea->field ? state->sea->field->shift : 0;
    fill(state, &s->public);
    s->public.entities = s->entities;
    s->public.entity_count = state->n_entities;
    size_t next = 0;
    for (size_t i = 0; i < state->n_entities; i++) {
        const Pelagos__Entity *e = state->entities[i];
        place_entity(state->origin, e, i, &s->entities[i]);
        s->entities[i].model =
            fleet ? pel_model_ref(pel_fleet_of(fleet, e, &next)) : NULL;
    }
    s->public.washes = pel_washes_of(state, &s->public);
    s->public.wash_moments = pel_wash_moments_of(s->public.washes);
    s->public.lamps = pel_lamps_of(state, &s->public);
    s->public.views = s->views;
    s->public.view_count = state->n_views;
    for (size_t i = 0; i < state->n_views; i++) {
        place_view(state, state->views[i], &s->views[i]);
    }
    place_ships(state, going, &s->public);
    s->public.wakes = pel_wakes_of(state, &s->public);
    meet_wakes(&s->public, state->clock->time);
    return &s->public;
}

const struct pel_snapshot *pel_snapshot_build(const Pelagos__State *state,
                                              struct pel_shared_sea *sea,
                                              const struct pel_seabed *seabed)
{
    return pel_snapshot_build_going(state, sea, seabed, NULL, NULL, NULL, NULL);
}

const struct pel_snapshot *
pel_snapshot_with_ships(const struct pel_snapshot *s,
                        const struct pel_sailing *ships)
{
    const struct snapshot *from = (const struct snapshot *)s;
    struct snapshot *to = pel_sure_malloc(sizeof *to);
    *to = (struct snapshot){ .public = from->public };
    memcpy(to->entities, from->entities, sizeof to->entities);
    for (size_t i = 0; i < to->public.entity_count; i++) {
        pel_model_ref(to->entities[i].model);
    }
    memcpy(to->views, from->views, sizeof to->views);
    for (size_t i = 0; i < to->public.view_count; i++) {
        pel_view_place_ref(&to->views[i].place);
    }
    atomic_init(&to->refs, 1);
    atomic_fetch_add(&to->public.sea->refs, 1);
    pel_wakes_ref(to->public.wakes);
    pel_washes_ref(to->public.washes);
    pel_lamps_ref(to->public.lamps);
    to->public.wash_moments = pel_wash_moments_of(to->public.washes);
    pel_seabed_ref(to->public.seabed);
    pel_panorama_ref(to->public.panorama);
    pel_weather_ref(to->public.weather);
    to->public.entities = to->entities;
    to->public.views = to->views;
    struct pel_sailing *own = new_ships(s->ship_count);
    memcpy(own, ships, s->ship_count * sizeof *own);
    to->public.ships = own;
    return &to->public;
}

static double degrees(double radians)
{
    double turned = fmod(radians / PEL_DEG, 360.0);
    turned = turned < 0 ? turned + 360.0 : turned;
    return turned < 360.0 ? turned : 0;
}

/* Where a motion begins, what it began with stays, to the bit: the way into the
 * plane and back rounds, and each restart would move the ship. */
static void put(bool begins, double value, double *out)
{
    if (!begins || fabs(remainder(value - *out, 360)) > 1e-9) {
        *out = value;
    }
}

void pel_ship_mark_to_state(double latitude, double longitude,
                            const struct pel_ship *ship,
                            const struct pel_ship_mark *mark,
                            Pelagos__TrackPoint *out)
{
    pel_geo_from_local(latitude, longitude, mark->east_m, mark->north_m,
                       &out->latitude, &out->longitude);
    double turned =
        pel_geo_convergence(latitude, longitude, out->latitude, out->longitude);
    out->has_time = out->has_latitude = out->has_longitude = true;
    out->has_heading = out->has_push = true;
    out->time = mark->time_s;
    out->heading = degrees(mark->heading_rad - turned);
    out->push = ship->orders.throttle * ship->orders.max_speed_mps;
}

/* Where it was since its orders. */
static void trail_to_state(const struct pel_sailing *sailing, double time_s,
                           Pelagos__State *state)
{
    struct pel_ship_mark marks[PEL_SHIP_TRAIL];
    int count = pel_ship_trail(&sailing->ship, time_s, marks);
    for (int i = 0; i < count; i++) {
        Pelagos__TrackPoint p = PELAGOS__TRACK_POINT__INIT;
        pel_ship_mark_to_state(state->origin->latitude,
                               state->origin->longitude, &sailing->ship,
                               &marks[i], &p);
        pel_track_mark(state->entities[sailing->entity], &p);
    }
}

static void ship_to_state(const struct pel_snapshot *s,
                          const struct pel_sailing *sailing, double time_s,
                          Pelagos__State *state)
{
    struct pel_entity_state at;
    struct pel_ship_motion m;
    Pelagos__Entity *e = state->entities[sailing->entity];
    Pelagos__OwnShip *helm = pel_helm_on(state, e);
    pel_snapshot_entity_at(s, sailing->entity, time_s, &at);
    pel_snapshot_ship_motion(s, &sailing->ship, time_s, &m);
    double lat, lon;
    bool begins = time_s == sailing->ship.start_s && e->pose_time == time_s;
    pel_geo_from_local(state->origin->latitude, state->origin->longitude,
                       at.east_m, at.north_m, &lat, &lon);
    put(begins, lat, &e->latitude);
    put(begins, lon, &e->longitude);
    double turned =
        pel_geo_convergence(state->origin->latitude, state->origin->longitude,
                            e->latitude, e->longitude);
    put(begins, at.altitude_m, &e->altitude);
    put(begins, degrees(at.heading_rad - turned), &e->heading);
    put(begins, at.pitch_rad / PEL_DEG, &e->pitch);
    put(begins, at.roll_rad / PEL_DEG, &e->roll);
    e->speed = at.speed_mps;
    put(begins, degrees(at.course_rad - turned), &e->course);
    put(begins, pel_clamp(at.turn_rate_rps / PEL_DEG, -90, 90), &e->turn_rate);
    e->pose_time = time_s;
    if (helm) {
        put(begins, pel_clamp(m.heave.rate, -100, 100), &helm->heave_rate);
        put(begins, pel_clamp(m.pitch.rate / PEL_DEG, -1e3, 1e3),
            &helm->pitch_rate);
        put(begins, pel_clamp(m.roll.rate / PEL_DEG, -1e3, 1e3),
            &helm->roll_rate);
    }
    if (e->wash) {
        trail_to_state(sailing, time_s, state);
    } else {
        pel_wakes_keep(s->wakes, state, time_s, e);
    }
}

void pel_snapshot_ships_to_state(const struct pel_snapshot *s, double time_s,
                                 Pelagos__State *state)
{
    for (size_t i = 0; i < s->ship_count; i++) {
        if (s->ships[i].entity < state->n_entities) {
            ship_to_state(s, &s->ships[i], time_s, state);
        }
    }
}

const struct pel_snapshot *pel_snapshot_ref(const struct pel_snapshot *s)
{
    atomic_fetch_add(&((struct snapshot *)s)->refs, 1);
    return s;
}

void pel_snapshot_unref(const struct pel_snapshot *s)
{
    struct snapshot *whole = (struct snapshot *)s;
    if (whole && atomic_fetch_sub(&whole->refs, 1) == 1) {
        pel_shared_sea_unref(whole->public.sea);
        pel_wakes_unref(whole->public.wakes);
        pel_wash_moments_destroy(whole->public.wash_moments);
        pel_washes_unref(whole->public.washes);
        pel_lamps_unref(whole->public.lamps);
        pel_seabed_unref(whole->public.seabed);
        pel_panorama_unref(whole->public.panorama);
        pel_weather_unref(whole->public.weather);
        for (size_t i = 0; i < whole->public.entity_count; i++) {
            pel_model_unref(whole->entities[i].model);
        }
        for (size_t i = 0; i < whole->public.view_count; i++) {
            pel_view_place_unref(&whole->views[i].place);
        }
        free((void *)whole->public.ships);
        free(whole);
    }
}
