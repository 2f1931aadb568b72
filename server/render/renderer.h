/* Draws the sea. One renderer, one EGL context, one thread: every function
 * here is called from the thread that created it, except pel_picture_release.
 *
 * A picture is a function of (environment, camera) and nothing else: no
 * history, no frame counter, no random numbers. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "encode/jpegcode.h"
#include "optics/clouds.h"
#include "optics/fog.h"
#include "optics/lamp.h"
#include "optics/motes.h"
#include "optics/watertable.h"
#include "proto/layers.h"
#include "render/filtering.h"
#include "scene/snapshot.h"
#include "scene/wakes.h"

struct pel_renderer;
struct pel_wash; /* ocean/wash.h */

struct pel_renderer_options {
    const char *device;     /* "auto", "software" or an EGL device number */
    const char *shader_dir; /* NULL: the embedded shaders */
    const char *shading;    /* NULL or "auto", "fragment", "compute" */
    bool debug;             /* GL debug output to the log */
    unsigned lose_after;    /* pretends that the device is lost after so many
                               pictures, for tests; 0: never */
    bool lose_for_good;     /* and that it cannot be had again */
    struct pel_filtering filtering;
};

PEL_CHECK enum pel_err pel_renderer_create(const struct pel_renderer_options *o,
                                           struct pel_renderer **out,
                                           struct pel_fault *fault);
void pel_renderer_destroy(struct pel_renderer *r); /* NULL allowed */
/* The same, and rest(user) between pieces of what the device holds: a driver
 * that gives memory back lets no other device of the process take commands
 * meanwhile, and what takes 12 ms at once makes their frames late. */
void pel_renderer_leave(struct pel_renderer *r, void (*rest)(void *user),
                        void *user);

/* GL_RENDERER and GL_VERSION in one line; lives as long as the renderer. */
const char *pel_renderer_description(const struct pel_renderer *r);
bool pel_renderer_is_software(const struct pel_renderer *r);

/* How pixels are shaded: both wrappers, fragments and compute, hold the same
 * functions. "auto" goes by the kind of device: a software device shades as
 * fragments, hardware in compute, or as fragments where its driver does not
 * compile that. On software both give the same bits; on hardware pictures
 * differ by rounding (docs/benchmarks.md has what each costs). */
bool pel_renderer_in_compute(const struct pel_renderer *r);

/* Programs of all renderers that the driver holds (render/shader.h); any
 * thread. */
unsigned pel_renderer_programs(void);

/* Shared by the views of one frame. */
struct pel_environment {
    double time_s;
    const struct pel_sea *sea;
    double sea_level_m; /* of its zero above altitude 0 */
    unsigned stale;     /* of enum pel_stale: the colour layer says so */
    struct pel_light lights[PEL_LIGHTS]; /* by body; inside: pel_lights_order */
    int lit, discs;                      /* found inside by it */
    struct pel_night_sky night;          /* zero: none */
    const struct pel_panorama *panorama; /* the sky; NULL: computed */
    double panorama_scale;               /* cd/m2 of its value 1 */
    double panorama_azimuth_rad;         /* of its middle, clockwise of north */
    double wind_mps, wind_to_rad;
    double visibility_m;         /* with rain and snow */
    double rain_mm_h, snow_mm_h; /* whose drops near the eye are drawn */
    struct pel_clouds clouds;
    /* Whence the clouds are seen that the sea mirrors, in metres of the air
     * that they drift with: own ship's place. */
    double clouds_x_m, clouds_y_m;
    struct pel_fog fog[PEL_FOG_MAX];
    int fog_count;
    double own_east_m, own_north_m; /* whence fog is seen that it mirrors */
    /* Of the map that cameras stand on, for what is seen from high up. */
    double origin_latitude_rad, origin_longitude_rad;
    bool continents; /* are drawn there, where their files are */
    /* Winds over the Earth, which the sea from high up has, at the time asked
     * for; NULL: the scene's everywhere. */
    const struct pel_weather *weather;
    double weather_unix_s;
    struct pel_water_body water;
    enum pel_water_orders orders;
    /* Depths to have the water's light for, over a bottom that is not flat;
     * levels 0: that of `water` alone. */
    struct pel_water_depths depths;
    const struct pel_seabed *seabed; /* NULL: flat, at the water's depth */
    struct pel_mote_water motes; /* particles that an eye under water sees */
    bool caustics;               /* the waves focus light on it */
    bool sparkle;                /* of the glitter: blocks.h */
    const struct pel_object *objects; /* things on the sea that are drawn */
    size_t object_count;
    const struct pel_lamp *lamps; /* lit, optics/lamp.h */
    size_t lamp_count;
    /* What flashes light within clouds; storm: there may be some. */
    struct pel_lightning_glow glows[PEL_LIGHTNING_GLOWS];
    size_t glow_count;
    bool storm;
    const struct pel_wake_moment *wakes; /* ship waves; NULL: none */
    const struct pel_wash *wash;         /* of ships; NULL: none */
    /* For tests: leaves out the air between the sea and the eye; looks for the
     * height field in every pixel, where it cannot be seen too. */
    bool no_air, coast_everywhere, nowhere_still;
    int high; /* the form of what is seen from high up: 1 always, -1 never */
    /* Cover by drops near the eye in black, that of all of them; one kind of
     * them alone, from 1 (optics/falling.h). */
    bool fall_bare;
    int fall_only;
};

/* What shaders write and readback copies for these layers: those that are made
 * here from the depth take it; the colour is none of them. */
unsigned pel_layers_stored(unsigned layers);

/* Floats from pixel to pixel of a layer, at least its channels. */
int pel_layer_stride(const struct pel_layer_info *layer);

/* Bytes a pixel takes in the buffers of these layers. */
size_t pel_layer_bytes(unsigned layers);

/* What a colour layer may come back as: its pixels, or planes of luma and of
 * chroma at half of the resolution, BT.601, as libyuv makes them to the bit, or
 * what libjpeg-turbo codes of these, to the bit, too. */
enum pel_ycbcr {
    PEL_YCBCR_NONE,
    PEL_YCBCR_JPEG,  /* full range; y, cb, cr */
    PEL_YCBCR_VIDEO, /* studio range; y, pairs of cb and cr */
    PEL_YCBCR_CODED, /* the first, and of these a JPEG's scan alone */
};

/* With camera.antialiasing light is the mean of pixels that outlines cut;
 * layers that are no light are always what their middles see. */
struct pel_draw {
    struct pel_camera camera;
    unsigned layers; /* of enum pel_layer, at least one */
    void *user;      /* returned with the picture */
    /* Planes will do where it is the only layer: devices that shade in compute
     * make them, of whole pictures; others, and if in doubt, pixels. */
    enum pel_ycbcr ycbcr;
    int quality; /* of what is coded, 1..PEL_JPEG_BEST */
    /* A band of the camera's picture, bit for bit as it is in the whole; a
     * multiple of PEL_BAND_ROWS, but for the last rows. 0 rows: all. */
    uint32_t first_row, rows;
};
#define PEL_BAND_ROWS 64

/* Stages of a frame, for the benchmark and the metrics. */
enum pel_stage {
    PEL_STAGE_WAVES,  /* transforms of the cascades, once a frame */
    PEL_STAGE_SKY,    /* once a frame */
    PEL_STAGE_MESH,   /* displacing vertices */
    PEL_STAGE_RASTER, /* thin G-buffer */
    PEL_STAGE_SHADE,
    PEL_STAGE_TONE,
    PEL_STAGE_READBACK,
    PEL_STAGE_COUNT,
};
const char *pel_stage_name(enum pel_stage stage);

/* Pixels in mapped readback buffers, top row first, tightly packed. Pointers
 * of layers that were not asked for are NULL. */
struct pel_picture {
    void *user;
    uint32_t width, height;
    double exposure_ev;  /* EV100 used, also where it was automatic */
    const uint8_t *rgba; /* 4 bytes a pixel, sRGB, alpha 255; or NULL: */
    /* y, cb, cr, or y, pairs and NULL, of whole blocks of 16x16 pixels: beyond
     * the picture its last column and row again. */
    enum pel_ycbcr ycbcr;
    const uint8_t *planes[3];
    int strides[3];            /* bytes from row to row */
    struct pel_jpeg_scan scan; /* where it is coded; it has no planes then */
    /* By PEL_AT_* and by name, pel_layer_stride floats a pixel; the fourth of
     * three is 1. What is made from the depth is NULL. */
    union {
        const float *layer[PEL_LAYERS];
        struct {
#define PEL_LAYER(ID, member, name, channels, samples, unit, from, text)       \
    const float *member;
#include "proto/layers.def"
        };
    };
    int64_t drawn_ns; /* CLOCK_MONOTONIC when the pixels were there */
    double render_ms; /* wall time from submission to the pixels */
};

/* Submits drawing of `count` views of one moment (1..PEL_MAX_VIEWS) and their
 * readback, and returns without waiting for the pixels. BUSY when too many
 * pictures are in flight or unreleased; GPU on errors of the driver. */
PEL_CHECK enum pel_err pel_renderer_submit(struct pel_renderer *r,
                                           const struct pel_environment *env,
                                           const struct pel_draw *draws,
                                           size_t count);

/* A picture of many pixels in bands, so that others are drawn between them:
 * pel_renderer_submit of one draw with the bands from the top to the bottom, of
 * one picture at a time. It counts as submitted with its last band. Every band
 * takes the work that does not depend on pixels anew. */

/* Whether the device has finished the last band, after waiting wait_ns. */
bool pel_renderer_band_done(struct pel_renderer *r, int64_t wait_ns);

/* Gives up a picture whose last band was not submitted. */
void pel_renderer_drop_bands(struct pel_renderer *r);

/* Next finished picture in order of submission; NULL when none is finished
 * after waiting wait_ns (0: polls). It stays mapped until released. */
struct pel_picture *pel_renderer_collect(struct pel_renderer *r,
                                         int64_t wait_ns);

/* The places of the picture's pixels, east, north, up, from its depth, which it
 * must have: 3 floats a pixel, metres. East and north are those of the map that
 * surface queries ask by, from the origin plus *east_m and *north_m, which are
 * multiples of PEL_POSITION_STEP_M near the camera, 0 as long as it is within
 * half of that; up is above
 * altitude 0, as their answers. *env: what it was drawn in. So a float
 * is good to 4 mm within 65 km of the camera, wherever that is. Any thread. */
#define PEL_POSITION_STEP_M 131072.0
/* Height of eyes below which some plans of pictures do not go. */
#define PEL_LEAST_EYE_M 0.3
void pel_picture_position(const struct pel_picture *picture,
                          const struct pel_camera *camera,
                          const struct pel_environment *env, float *xyz);
void pel_picture_position_origin(const struct pel_camera *camera,
                                 double *east_m, double *north_m);

/* Pictures submitted and not yet collected. */
size_t pel_renderer_in_flight(const struct pel_renderer *r);

/* Whether the device is lost, with what was submitted and not yet collected:
 * this renderer draws no more. Collected pictures stay as they are. */
bool pel_renderer_lost(struct pel_renderer *r);

/* Gives up what was submitted and not collected, oldest first: fills in `user`
 * of its draws, at most `most`; their count. Bands are dropped. */
size_t pel_renderer_abandon(struct pel_renderer *r, void **users, size_t most);

/* Nothing is drawn for a while: what large pictures took and small ones do not
 * need goes back. Programs and what shows the sea stay. */
void pel_renderer_rest(struct pel_renderer *r);

/* Whether all pictures were released, so that it may be destroyed. */
bool pel_renderer_unused(const struct pel_renderer *r);

/* Releases the buffers; any thread. */
void pel_picture_release(struct pel_picture *picture);

/* Milliseconds of each stage of the last measured frame, summed over its
 * views; measuring makes frames wait for every stage, so it is off until
 * asked for. */
void pel_renderer_measure(struct pel_renderer *r, bool on);
void pel_renderer_stage_ms(const struct pel_renderer *r,
                           double ms[PEL_STAGE_COUNT]);

/* What leaves the water of `env` for a unit of sunlight, by the maps that
 * colour the picture (render/waterprobe.h): waits for the answer. GPU on errors
 * of the driver. */
struct pel_water_parts;
PEL_CHECK enum pel_err
pel_renderer_probe_water(struct pel_renderer *r,
                         const struct pel_environment *env,
                         const struct pel_geometry *at,
                         struct pel_water_parts *out, struct pel_fault *fault);

/* One query of the shading functions (render/probe.h); waits for the answer,
 * some milliseconds, more when the Sun, the air or the water are not those of
 * the last frame. GPU or NO_MEMORY with a fault. */
struct pel_probe;
struct pel_probe_answer;
PEL_CHECK enum pel_err pel_renderer_probe(struct pel_renderer *r,
                                          const struct pel_environment *env,
                                          const struct pel_probe *probe,
                                          struct pel_probe_answer *out,
                                          struct pel_fault *fault);
