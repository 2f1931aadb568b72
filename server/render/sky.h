/* Tables of the atmosphere, the light on the sea, and the environment it
 * reflects. Each table is a function of its key and kept until the key
 * changes, so that what is drawn does not depend on what was drawn before.
 * Render thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stdint.h>

#include "render/nightmap.h"
#include "render/panoramamap.h"
#include "render/programs.h"
#include "render/renderer.h"
#include "render/waterlight.h"

#define PEL_SKY_EYES 16
/* What a table depends on: lights, visibility, height. */
#define PEL_SKY_KEYS (6 * PEL_LIGHTS + 2 + PEL_NIGHT_KEYS + PEL_PANORAMA_KEYS)
/* And the light on the sea. */
#define PEL_SKY_CLOUD_KEYS 8
#define PEL_SKY_FOG_KEYS (1 + 8 * PEL_FOGS)
#define PEL_SKY_LIGHT_KEYS                                                     \
    (PEL_SKY_KEYS + 5 + PEL_SKY_CLOUD_KEYS + PEL_SKY_FOG_KEYS)
#define PEL_SKY_MAP_SIZE 128

struct pel_sky_table {
    double key[PEL_SKY_KEYS];
    GLuint radiance; /* a layer for each light */
    GLuint haze, fbos[PEL_LIGHTS];
    uint64_t last_used;
    bool made;
};

struct pel_sky {
    GLuint transmittance_program;
    GLuint table_program[PEL_SKY_LOOKS];
    GLuint light_program[PEL_LIGHT_PROGRAMS]; /* pel_light_program */
    GLuint reflection_program[PEL_SKY_LOOKS][PEL_LIGHT_PROGRAMS];
    GLuint second_program[PEL_LIGHT_PROGRAMS]; /* waves seen in waves */
    GLuint veiled_program[PEL_LIGHT_PROGRAMS];
    GLuint transmittance, transmittance_fbo;
    GLuint airlight; /* light scattered before (optics/airlight.h) */
    struct pel_worker_pool *pool;
    double air_key;
    bool air_made;
    struct pel_sky_table sea;
    struct pel_sky_table eyes[PEL_SKY_EYES];
    GLuint reflection, reflection_fbo;
    GLuint second, second_fbo;
    struct pel_water_light water;
    struct pel_night_textures night;
    struct pel_panorama_map panorama;
    GLuint light; /* buffer, block `light` */
    double light_key[PEL_SKY_LIGHT_KEYS];
    bool light_made;
    uint64_t uses;
};

PEL_CHECK enum pel_err pel_sky_init(struct pel_sky *sky, const char *shader_dir,
                                    struct pel_fault *fault);
void pel_sky_finish(struct pel_sky *sky);

enum pel_sky_look pel_sky_look(const struct pel_environment *env);

/* Makes the programs for these lights, night, clouds and fog. GPU. */
PEL_CHECK enum pel_err pel_sky_need(struct pel_sky *sky,
                                    const struct pel_environment *env,
                                    const char *shader_dir,
                                    struct pel_fault *fault);

/* A light's direction as the tables see it: on a lattice of 0.005°. */
struct pel_vec3 pel_sky_quantize(struct pel_vec3 direction);

/* Height of the tables for an eye at height_m. */
double pel_sky_quantize_height(double height_m);

/* Brings the air, the sea-level table, the light and the reflection map up to
 * date. The water must be (pel_water_light_update), the block `frame` bound; an
 * `eye` block for PEL_SKY_SEA_HEIGHT is bound by `bind_eye`, called only when
 * needed. */
#define PEL_SKY_SEA_HEIGHT 2.0
void pel_sky_update(struct pel_sky *sky, const struct pel_environment *env,
                    void (*bind_eye)(void *user, double height_m), void *user);

/* Makes the table of an eye current on its units. The `eye` block must be
 * bound with the same (quantised) height. */
void pel_sky_bind_eye(struct pel_sky *sky, const struct pel_environment *env,
                      double height_m);
