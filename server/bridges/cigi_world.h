/* What CIGI packets mean for the scene: each datagram becomes one patch.
 * Control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bridges/cigi_packet.h"
#include "pelagos.pb-c.h"
#include "scene/snapshot.h"

#define PEL_CIGI_REGIONS 16
#define PEL_CIGI_FOLLOWERS 64
#define PEL_CIGI_VIEWS PEL_MAX_VIEWS
#define PEL_CIGI_REMOVALS 192
#define PEL_CIGI_SENSORS 64

/* A swell train or a single wave as the schema has it. */
#define PEL_CIGI_TRAINS PEL_SEA_MAX_SWELLS
struct pel_cigi_train {
    bool used;
    unsigned key; /* train of Component Control, or wave id */
    double height_m, period_s, from_deg;
    double spread_deg; /* of swell */
    double phase_deg;  /* of a wave */
};

/* Commanded weather and water, of the world or of a region. */
struct pel_cigi_conditions {
    bool has_visibility, has_wind;             /* Atmosphere, components */
    bool has_layer_visibility, has_layer_wind; /* Weather: goes before them */
    bool has_chlorophyll, has_level, has_whitecaps, has_swell, has_waves;
    double visibility_m, layer_visibility_m;
    double wind_mps, wind_deg, layer_wind_mps, layer_wind_deg;
    double chlorophyll_mg_m3, level_m, whitecaps; /* 0: off, 1: on */
    struct pel_cigi_train swell[PEL_CIGI_TRAINS];
    struct pel_cigi_train waves[PEL_CIGI_TRAINS];
};

struct pel_cigi_region {
    bool used, active;
    unsigned id;
    double latitude, longitude, x_m, y_m, radius_m, rotation_deg;
    double transition_m;
    struct pel_cigi_conditions conditions;
};

/* A region as an area of the sea (cigi_areas.c); padding is zero. */
struct pel_cigi_area {
    double east_m, north_m, radius_m, edge_m, factor;
    char corners[256]; /* as Area.corners; empty: a circle */
};

/* A layer of Weather Control that is seen (cigi_layers.c). */
#define PEL_CIGI_LAYERS 8
struct pel_cigi_layer {
    bool used, regional;
    unsigned layer, region;
    int type; /* of clouds, as the ICD numbers them */
    double coverage, base_m, thickness_m, band_m, visibility_m;
};

/* An entity whose pose is made anew with each datagram. */
struct pel_cigi_follower {
    bool used;
    uint32_t id;
    enum { PEL_CIGI_ON_PARENT, PEL_CIGI_ON_SEA, PEL_CIGI_ON_SLOPE } how;
    uint32_t parent;
    double offset_m[3]; /* body axes of the parent */
    double rate_mps[3]; /* of the offset */
    double roll_dps, pitch_dps, yaw_dps;
    double rated_s;  /* when they began */
    double height_m; /* above the sea */
    bool known;      /* the sea below it, of late (cigi_sea.h) */
    double sea_m;
    struct pel_vec3 normal;
    double roll_deg, pitch_deg, yaw_deg;
};

/* Where a sensor's tracker stands, as Sensor Response numbers it. */
enum pel_cigi_lock {
    PEL_CIGI_SEARCHING,
    PEL_CIGI_TRACKING,
    PEL_CIGI_LOSING,
    PEL_CIGI_LOST,
};

/* A sensor that the host has spoken of. */
struct pel_cigi_sensor {
    bool used, on, extended; /* extended: so are its responses */
    unsigned view, id, track;
    bool has_target;
    uint32_t target; /* entity */
    enum pel_cigi_lock lock;
};

struct pel_cigi_view_memo {
    bool used;
    bool has_sensor; /* the view shows `sensor` */
    unsigned sensor;
    unsigned id, group;
    bool wants_entity; /* not there yet */
    uint32_t entity;
};

/* What the scene had before the host commanded it. */
struct pel_cigi_before {
    double visibility_m, wind_mps, wind_deg, chlorophyll_mg_m3, level_m;
    double whitecaps;
    struct pel_cigi_train swell[PEL_CIGI_TRAINS], waves[PEL_CIGI_TRAINS];
};

/* What outlives a datagram. Copied before each one and put back when its
 * patch is refused: no pointers. */
struct pel_cigi_world {
    struct pel_cigi_conditions global, applied;
    struct pel_cigi_before before; /* of what `applied` has */
    struct pel_cigi_region regions[PEL_CIGI_REGIONS];
    struct pel_cigi_area areas[PEL_SEA_MAX_AREAS]; /* the last of sea.areas */
    size_t area_count;
    struct pel_cigi_layer layers[PEL_CIGI_LAYERS];
    size_t fog_count;         /* the last of sky.fog */
    bool clouded;             /* the scene's clouds are ours */
    unsigned lightning_layer; /* the scene's lightning is this layer's, counted
                                 from 1; 0: not ours */
    struct pel_cigi_follower followers[PEL_CIGI_FOLLOWERS];
    struct pel_cigi_view_memo views[PEL_CIGI_VIEWS];
    uint32_t rated[PEL_MAX_ENTITIES]; /* entities that were given rates */
    size_t rated_count;
    bool dated;
    double hour, minute, date; /* of the last Celestial Sphere */
    bool sun_stands;           /* sky.sunAzimuth and sunElevation are ours */
    double humidity, air_temperature, pressure, water_temperature;
    double vertical_wind_mps;
    struct pel_cigi_sensor sensors[PEL_CIGI_SENSORS];
};

/* All empty, and what answers give where nothing was commanded. */
void pel_cigi_world_init(struct pel_cigi_world *world);

/* What the scene becomes when the host is gone: clock.mode `mode`, and every
 * entity that was given rates stands. Free with pelagos__patch__free_unpacked.
 */
Pelagos__Patch *pel_cigi_world_end(const struct pel_cigi_world *world,
                                   const Pelagos__State *scene,
                                   enum pel_clock_mode mode);

/* The patch of one datagram, being made. Large: on the heap. */
struct pel_cigi_edit {
    struct pel_cigi_world *world;
    const Pelagos__State *scene;
    const struct pel_snapshot *snapshot;
    double time_s;    /* simulated time of the datagram's host frame */
    bool refused;     /* more elements than a patch takes, or a bad number */
    unsigned skipped; /* packets without an object, or beyond a limit */
    Pelagos__Patch patch;
    Pelagos__State state;
    Pelagos__Clock clock;
    Pelagos__Sea sea;
    Pelagos__Water water;
    Pelagos__Sky sky;
    Pelagos__Entity entities[PEL_MAX_ENTITIES];
    Pelagos__Entity *entity_list[PEL_MAX_ENTITIES];
    Pelagos__Searchlight searchlights[PEL_CIGI_SENSORS];
    size_t searchlight_count;
    Pelagos__View views[PEL_MAX_VIEWS];
    Pelagos__View *view_list[PEL_MAX_VIEWS];
    Pelagos__Frustum frusta[PEL_MAX_VIEWS];
    Pelagos__Sensor sensors[PEL_MAX_VIEWS];
    char view_names[PEL_MAX_VIEWS][PEL_NAME_SIZE];
    Pelagos__Swell swell[PEL_SEA_MAX_SWELLS];
    Pelagos__Swell *swell_list[PEL_SEA_MAX_SWELLS];
    Pelagos__Wave wave[PEL_SEA_MAX_SINGLES];
    Pelagos__Wave *wave_list[PEL_SEA_MAX_SINGLES];
    Pelagos__Fog fog[PEL_FOG_MAX];
    Pelagos__Fog *fog_list[PEL_FOG_MAX];
    Pelagos__Area area[PEL_SEA_MAX_AREAS];
    Pelagos__Area *area_list[PEL_SEA_MAX_AREAS];
    char removals[PEL_CIGI_REMOVALS][96];
    char *removal_list[PEL_CIGI_REMOVALS];
    char utc[40];
    Pelagos__Patch sea_patch; /* pel_cigi_edit_split */
    Pelagos__State sea_state;
    char *sea_removals[PEL_CIGI_REMOVALS];
};

/* Begins; scene and snapshot are of now and must outlive the edit. With
 * `lead` the patch also sets clock.mode to HOST. */
void pel_cigi_edit_begin(struct pel_cigi_edit *edit,
                         struct pel_cigi_world *world,
                         const Pelagos__State *scene,
                         const struct pel_snapshot *snapshot, double time_s,
                         bool lead);

/* Everything the host has said is forgotten, and views show what the eye sees;
 * before the packets. */
void pel_cigi_edit_reset(struct pel_cigi_edit *edit);

/* Takes one packet from the host; requests are not for here. */
void pel_cigi_edit_take(struct pel_cigi_edit *edit,
                        const struct pel_cigi_packet *packet);

/* The whole patch, NULL when nothing is to be changed. */
const Pelagos__Patch *pel_cigi_edit_end(struct pel_cigi_edit *edit);

/* Takes what asks for another sea out of the whole patch: that patch, NULL:
 * nothing does. *rest: what is left, NULL: nothing. */
const Pelagos__Patch *pel_cigi_edit_split(struct pel_cigi_edit *edit,
                                          const Pelagos__Patch **rest);

/* Name of the view that a CIGI view id means: `cigi-ID` if there is one; else
 * for 0 the scene's first view; else `cigi-ID`. */
void pel_cigi_view_name(const struct pel_snapshot *s, unsigned id,
                        char out[PEL_NAME_SIZE]);

/* --- between the files of this edit -------------------------------------- */

/* View `id` in the patch, added if it is not there; NULL: too many. */
Pelagos__View *pel_cigi_edit_view(struct pel_cigi_edit *edit, unsigned id);

/* What is remembered of view `id`; NULL: of too many already. */
struct pel_cigi_view_memo *pel_cigi_edit_memo(struct pel_cigi_edit *edit,
                                              unsigned id);

/* Entity `id` in the patch, added if it is not there; NULL: too many. */
Pelagos__Entity *pel_cigi_edit_entity(struct pel_cigi_edit *edit, uint32_t id);

/* Whether entity `id` is there after what the patch says so far. */
bool pel_cigi_entity_will_be(const struct pel_cigi_edit *edit, uint32_t id);

/* Component Control, or Short Component Control with two words. */
struct pel_cigi_component {
    unsigned class, id, instance, state;
    size_t count;     /* data words */
    uint32_t word[6]; /* absent ones 0 */
    double value[6];  /* as floats */
};
void pel_cigi_read_component(const struct pel_cigi_packet *p,
                             struct pel_cigi_component *out);

/* cigi_lights.c: one of class 0. */
void pel_cigi_take_lights(struct pel_cigi_edit *edit,
                          const struct pel_cigi_component *c);

/* A path to remove. */
void pel_cigi_edit_remove(struct pel_cigi_edit *edit, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* cigi_entities.c */
void pel_cigi_take_entity(struct pel_cigi_edit *edit,
                          const struct pel_cigi_packet *p);
void pel_cigi_take_conformal(struct pel_cigi_edit *edit,
                             const struct pel_cigi_packet *p);
void pel_cigi_take_rate(struct pel_cigi_edit *edit,
                        const struct pel_cigi_packet *p);
void pel_cigi_place_followers(struct pel_cigi_edit *edit);

/* cigi_sensor.c */
void pel_cigi_take_sensor(struct pel_cigi_edit *edit,
                          const struct pel_cigi_packet *p);

/* cigi_weather.c */
void pel_cigi_take_environment(struct pel_cigi_edit *edit,
                               const struct pel_cigi_packet *p);

/* cigi_conditions.c */
void pel_cigi_apply_conditions(struct pel_cigi_edit *edit);

/* cigi_layers.c: takes Weather Control's ground fog that has a thickness and
 * its clouds; false: the packet is of neither, or ends them. */
bool pel_cigi_take_layer(struct pel_cigi_edit *edit,
                         const struct pel_cigi_packet *packet);
void pel_cigi_apply_layers(struct pel_cigi_edit *edit);

/* After the wind: regions that have another become areas of the sea, the last
 * of sea.areas. */
void pel_cigi_apply_areas(struct pel_cigi_edit *edit);

/* Chlorophyll that a clarity of 0..100 % stands for, and back. */
double pel_cigi_chlorophyll(double clarity);
double pel_cigi_clarity(double chlorophyll_mg_m3);
