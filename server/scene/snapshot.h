/* An immutable picture of the scene for one moment of editing: what the frame
 * path, the queries and the encoders read. Reference counted, any thread.
 *
 * Local frame: x east, y north, z up, metres from the scene's origin; angles
 * in radians, headings clockwise from north. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/vec.h"
#include "bounds.h"
#include "ocean/sea.h"
#include "optics/clouds.h"
#include "optics/fog.h"
#include "optics/light.h"
#include "optics/lightning.h"
#include "optics/motes.h"
#include "optics/nightsky.h"
#include "optics/waterbody.h"
#include "panorama/panorama.h"
#include "scene/ship.h"
#include "scene/viewplace.h"
#include "seabed/seabed.h"
#include "weather/weather.h"

#define PEL_MAX_VIEWS PEL_BOUND_VIEWS
#define PEL_MAX_ENTITIES PEL_BOUND_ENTITIES
#define PEL_MAX_SHIPS 8 /* that helms sail */
#define PEL_NAME_SIZE 65

enum pel_clock_mode {
    PEL_CLOCK_FREE,
    PEL_CLOCK_PACED,
    PEL_CLOCK_STEPPED,
    PEL_CLOCK_HOST,
};

/* Limits of altitude of entities in the schema. */
#define PEL_LOWEST_M (-100.0)
#define PEL_HIGHEST_M 20000.0

/* From the origin to anywhere: half the Earth's girth, and some (the schema's
 * limit of Point). */
#define PEL_FARTHEST_M 2.1e7

struct pel_model;

struct pel_entity_state {
    uint32_t id;
    double east_m, north_m, altitude_m;
    double heading_rad, pitch_rad, roll_rad;
    double speed_mps, course_rad, turn_rate_rps;
    double climb_mps, pitch_rate_rps, roll_rate_rps;
    double pose_time_s;            /* simulated time of the pose above */
    const struct pel_model *model; /* models/model.h; NULL: not drawn */
    bool afloat; /* height, pitch and roll are the sea's at its hull */
    double leeway, mooring_m; /* afloat: scene/reckon.h */
};

/* What it sees (the schema's SensorKind). */
enum pel_sense { PEL_SENSE_VISIBLE, PEL_SENSE_LOW_LIGHT, PEL_SENSE_THERMAL };

/* What a sensor makes of a picture: grey · scale + offset. */
struct pel_sensor {
    enum { PEL_SENSOR_NONE, PEL_SENSOR_ON, PEL_SENSOR_OFF } kind;
    double scale, offset;
    double noise; /* 0..1 of white */
    bool dropout;
    uint32_t seed; /* of noise and dropout: of the moment */
    enum pel_sense sense;
    /* Low light: of the exposure, what one may turn; grey, green, white. */
    double exposure_s, f_number;
    int phosphor;
    /* Thermal: from black, K; 0: by sky, air and sea. */
    double low_k, span_k, netd_k;
    double sea_k, air_k, humidity, cloud;
};

/* What a view's camera has from the view as it is: one list for both, so that
 * a parameter of views is added here alone. EV100 where not automatic; tan_left
 * < tan_right, tan_bottom < tan_top. */
#define PEL_LENS_FIELDS                                                        \
    double tan_left, tan_right, tan_top, tan_bottom;                           \
    uint32_t width, height;                                                    \
    bool auto_exposure;                                                        \
    double exposure_ev;                                                        \
    int tone;          /* PEL_TONE_* */                                        \
    int vision;        /* PEL_VISION_* */                                      \
    double glare;      /* share of light that the lens scatters */             \
    bool antialiasing; /* of what hides what, and of lights' rims */           \
    double shutter_s;  /* 0: PEL_FALL_SHUTTER_S */                             \
    double wet_lens;   /* 0..1 */                                              \
    uint32_t pane;     /* which one: seed of its drops */                      \
    struct pel_sensor sensor;
struct pel_lens {
    PEL_LENS_FIELDS
};
#define PEL_LENS                                                               \
    union {                                                                    \
        struct {                                                               \
            PEL_LENS_FIELDS                                                    \
        };                                                                     \
        struct pel_lens lens; /* the same, to copy */                          \
    }

/* A view that is a radar's (the schema's Radar); pulse_s 0: by range. */
struct pel_radar_set {
    bool on, north_up, rings;
    double range_m, gain, stc, ftc, pulse_s, beam_rad, turn_s, rain_mm_h;
};

struct pel_view_state {
    char name[PEL_NAME_SIZE];
    char meter[PEL_NAME_SIZE]; /* of the views that are exposed alike; "": of
                                  this view alone */
    int entity;                /* index into entities, -1: the world */
    struct pel_view_place place;
    double forward_m, right_m, up_m;
    double yaw_rad, pitch_rad, roll_rad;
    bool level; /* the entity's pitch and roll do not move it */
    struct pel_radar_set radar;
    PEL_LENS;
};

/* Inputs that have fallen silent (the schema's Sources). */
enum pel_stale {
    PEL_STALE_CIGI = 1 << 0,
    PEL_STALE_MODBUS = 1 << 1,
    PEL_STALE_NMEA = 1 << 2,
    PEL_STALE_CONSOLE = 1 << 3,
    PEL_STALE_OTHER = 1 << 4,
    PEL_STALE_POSES = 1 << 5,    /* no input: see pel_snapshot_stale() */
    PEL_STALE_EXERCISE = 1 << 6, /* nor this: no frame is sealed in time */
};

/* A thing on the sea as it is drawn: its model stands at this place, the axes
 * turned by its heading, pitch and roll. */
struct pel_object {
    uint32_t id;
    const struct pel_model *model; /* models/model.h */
    double east_m, north_m, altitude_m;
    struct pel_mat3 world_from_model;
};

/* An entity under its helm. */
struct pel_sailing {
    size_t entity; /* index into the snapshot's */
    uint64_t run;  /* names the motion since it began; never used twice */
    struct pel_ship ship;
};

struct pel_shared_sea; /* build.h */
struct pel_wakes;      /* wakes.h */
struct pel_washes;     /* washes.h */
struct pel_wash_moments;
struct pel_lamp_plan; /* lamps.h */

struct pel_snapshot {
    uint64_t revision;
    enum pel_clock_mode mode;
    double rate;
    double epoch_unix_s; /* UTC at simulated time 0 */
    double reckoning_s;  /* how long poses are reckoned on */
    unsigned stale;      /* of enum pel_stale */
    bool mark_stale;     /* pictures show it */
    double origin_latitude_rad, origin_longitude_rad;
    struct pel_shared_sea *sea;   /* pel_snapshot_sea; the same: one sea */
    double sea_level_m;           /* of the sea's zero above altitude 0 */
    double wind_mps, wind_to_rad; /* mathematical direction it blows to */
    struct pel_water_body water;
    struct pel_water_desc water_desc; /* what it was resolved from */
    enum pel_water_orders water_orders;
    struct pel_mote_water motes;     /* that an eye under water sees */
    const struct pel_seabed *seabed; /* NULL: flat, at the water's depth */
    bool caustics;
    bool sparkle;
    double chlorophyll_mg_m3; /* the field, whatever describes the water */
    bool sun_azimuth_fixed, sun_elevation_fixed; /* else from the time */
    double sun_azimuth_rad, sun_elevation_rad;   /* where fixed */
    bool moon_azimuth_fixed, moon_elevation_fixed, moon_phase_fixed;
    double moon_azimuth_rad, moon_elevation_rad; /* where fixed */
    double moon_lit;                             /* share, where fixed */
    bool stars;
    double visibility_m; /* with rain and snow */
    double rain_mm_h, snow_mm_h;
    /* By place and time, at epoch_unix_s + time + shift; NULL: there is none,
     * the weather is everywhere that of the sea. */
    const struct pel_weather *weather;
    double weather_shift_s;
    const struct pel_panorama *panorama; /* the sky; NULL: computed */
    double panorama_scale, panorama_azimuth_rad;
    bool panorama_sun, panorama_dark; /* it has the Sun; there is none */
    struct pel_clouds clouds;
    struct pel_fog fog[PEL_FOG_MAX];
    int fog_count;
    struct pel_lightning lightning;
    size_t entity_count;
    const struct pel_entity_state *entities;
    struct pel_wakes *wakes;   /* of those that make waves; NULL: none */
    struct pel_washes *washes; /* of those that leave a wash; NULL: none */
    struct pel_wash_moments *wash_moments; /* its own; NULL: none are kept */
    struct pel_lamp_plan *lamps; /* of those that have some; NULL: none */
    size_t view_count;
    const struct pel_view_state *views;
    size_t ship_count;
    const struct pel_sailing *ships; /* the entities that helms move */
};

/* The sea, built by the first that asks, tens of milliseconds where it is of
 * cascades; others that ask wait. It lives as long as the snapshot. Any thread;
 * aborts without memory. */
const struct pel_sea *pel_snapshot_sea(const struct pel_snapshot *s);

const struct pel_snapshot *pel_snapshot_ref(const struct pel_snapshot *s);
void pel_snapshot_unref(const struct pel_snapshot *s); /* NULL allowed */

/* What moves entity `index`; NULL: no helm does. */
const struct pel_sailing *pel_snapshot_ship(const struct pel_snapshot *s,
                                            size_t index);

/* Index of the view called `name`, or -1. */
int pel_snapshot_find_view(const struct pel_snapshot *s, const char *name);

/* Pose of entity `index` at simulated time time_s: reckoned from its speed,
 * course and turn rate (arc of a circle) for at most reckoning_s from its pose;
 * or the ship's motion, for at most 10 s ahead of its last step. One afloat
 * stands in the sea of time_s, without ship waves. */
void pel_snapshot_entity_at(const struct pel_snapshot *s, size_t index,
                            double time_s, struct pel_entity_state *out);

/* The same without what the sea does to one afloat but move it: any thread, at
 * once. */
void pel_snapshot_entity_level(const struct pel_snapshot *s, size_t index,
                               double time_s, struct pel_entity_state *out);

/* The same in the waves of other ships too, where it is afloat: what is drawn.
 * Waits for them; not the control thread. */
void pel_snapshot_entity_in_wakes(const struct pel_snapshot *s, size_t index,
                                  double time_s, struct pel_entity_state *out);

/* As a place has it (place.h; NULL: the local frame), in_wakes as above, which
 * waits, or not. */
struct pel_place;
void pel_snapshot_entity_seen(const struct pel_snapshot *s, size_t index,
                              double time_s, bool in_wakes,
                              const struct pel_place *place,
                              struct pel_entity_state *out);

/* The entities that have a model at time_s, as a place has them, at most
 * PEL_MAX_ENTITIES; returns their number. Their models live as long as the
 * snapshot. Asks the sea where one is afloat, and ship waves: not the control
 * thread. */
size_t pel_snapshot_objects(const struct pel_snapshot *s, double time_s,
                            const struct pel_place *place,
                            struct pel_object out[PEL_MAX_ENTITIES]);

/* Columns: right, forward and up of a body, in axes that are right, forward
 * and up of what carries it (east, north, up for the world). Heading first
 * (clockwise), then pitch (bow up), then roll (right side down). */
struct pel_mat3 pel_attitude(double heading_rad, double pitch_rad,
                             double roll_rad);

/* An entity's state as an object, whether it has a model or not. */
void pel_entity_object(const struct pel_entity_state *e,
                       struct pel_object *out);

/* The surface at n places at time_s, heights above altitude 0: pel_sea_query
 * (moving: pel_sea_query_moving) with the sea's level, and the bottom's depth
 * below altitude 0. */
void pel_snapshot_surface(const struct pel_snapshot *s,
                          const struct pel_vec2 *points, size_t n,
                          double time_s, bool moving,
                          struct pel_surface_sample *out);

/* Sets the foam of samples of pel_snapshot_surface at the same moment
 * (pel_foam_query). */
void pel_snapshot_foam(const struct pel_snapshot *s, size_t n, double time_s,
                       struct pel_surface_sample *samples);

/* The inputs that are stale, and with PEL_STALE_POSES whether an entity that
 * moves stands at time_s since its pose is older than reckoning_s. */
unsigned pel_snapshot_stale(const struct pel_snapshot *s, double time_s);

/* Whether a moment's first query waits for transforms (an FFT sea, ship waves),
 * which the control thread leaves to others; and pel_sea_prepare for it, of
 * places within `of`. */
bool pel_snapshot_transforms(const struct pel_snapshot *s);
bool pel_snapshot_prepare(const struct pel_snapshot *s, double time_s,
                          bool moving, const struct pel_box *of,
                          bool (*go_on)(void *user), void *user);

/* "cigi,nmea" of the bits of `stale`, "none" of 0. */
#define PEL_STALE_TEXT 48
const char *pel_stale_text(unsigned stale, char out[PEL_STALE_TEXT]);

/* Depth of the bottom below altitude 0 [m], negative on land, NaN where
 * its height field has no data. */
double pel_snapshot_depth(const struct pel_snapshot *s, double east_m,
                          double north_m);

/* Unit vector towards the Sun's centre (no refraction) at time_s. */
struct pel_vec3 pel_snapshot_sun(const struct pel_snapshot *s, double time_s);

/* Every light at time_s, in the order of optics/light.h. */
void pel_snapshot_lights(const struct pel_snapshot *s, double time_s,
                         struct pel_light out[PEL_LIGHTS]);

/* The night sky at time_s, below the Sun that is given; none (not on) by day or
 * without sky.stars. */
void pel_snapshot_night(const struct pel_snapshot *s, double time_s,
                        struct pel_vec3 sun, struct pel_night_sky *out);

/* What a meter looks through: an eye's frustum in the world. */
struct pel_sight {
    struct pel_mat3 world_from_camera;
    double altitude_m;
    double tan_left, tan_right, tan_top, tan_bottom;
};

/* A camera in the world. Camera axes: x right, y up, z backwards (GL). */
struct pel_camera {
    double east_m, north_m, altitude_m;
    struct pel_vec3 velocity_mps; /* of what carries it, without the waves' */
    struct pel_mat3 world_from_camera;
    PEL_LENS; /* sensor.seed too */
    /* Of the views of its meter, in their order, as they are in the state; 0:
     * what the camera itself sees. */
    int sight_count;
    struct pel_sight sights[PEL_METER_SIGHTS];
};

/* Camera of view `index` at time_s. width or height 0: the view's own; when
 * their ratio differs from the view's, the vertical field follows the width. */
void pel_snapshot_camera(const struct pel_snapshot *s, size_t index,
                         double time_s, uint32_t width, uint32_t height,
                         struct pel_camera *out);
/* The place whose light such a camera has, its square (place.h). */
struct pel_place pel_snapshot_view_square(const struct pel_snapshot *s,
                                          size_t index, double time_s,
                                          const struct pel_camera *camera);
/* Places such a camera in the ship waves; not the control thread. */
void pel_snapshot_camera_in_wakes(const struct pel_snapshot *s, size_t index,
                                  double time_s, struct pel_camera *camera);
