/* What the sea from high up is drawn with (lib/space.glsl): the light on it by
 * the elevation of a light, made once for an air, a water and a sea; the air
 * that an eye sees; programs. Render thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>

#include "render/renderer.h"
#include "render/sky.h"
#include "render/spacegeometry.h"
#include "render/windmap.h"

#define PEL_SPACE_EYES 4
#define PEL_SPACE_KEYS (8 * PEL_LIGHTS + 5)
#define PEL_SPACE_SUN_KEYS 6

/* The air of an eye. */
struct pel_space_air {
    double key[PEL_SPACE_KEYS];
    GLuint radiance, through, fbos[PEL_LIGHTS];
    uint64_t last_used;
    bool made;
};

struct pel_space_program {
    char *defines;
    GLuint program;
};

/* Zeroed before its first use. */
struct pel_space_map {
    GLuint air_program, meter_program[2][PEL_LIGHTS]; /* the second by winds */
    struct pel_space_program *programs;
    int program_count;
    struct pel_space_air eyes[PEL_SPACE_EYES];
    uint64_t uses;
    GLuint skies, waters, seconds; /* a layer for each elevation */
    GLuint frame, eye;             /* buffers, while those are made */
    GLuint land, ground;           /* continents; 0: none */
    bool land_sought;
    struct pel_vec4 suns[2 * PEL_SPACE_SUNS];
    double sun_key[PEL_SPACE_SUN_KEYS];
    bool suns_made;
    struct pel_wind_map winds;
};

void pel_space_map_finish(struct pel_space_map *m);

/* The share of this form in what an eye so high above the sea sees: 0 the low
 * form alone, 1 this alone, between them both are drawn. What is not light has
 * the form of the larger share. */
double pel_space_share(const struct pel_environment *env, double height_m);
bool pel_space_is(const struct pel_environment *env, double height_m);

/* The environment with the lights that anything in sight of such an eye has, in
 * the order of the shaders. */
struct pel_environment pel_space_environment(const struct pel_environment *env,
                                             double height_m);

struct pel_space_geometry
pel_space_geometry_for(const struct pel_environment *env,
                       const struct pel_camera *camera, double height_m);

/* Makes what does not depend on eyes. GPU, NO_MEMORY. The blocks `frame` and
 * `light` and tables of the sky are others' afterwards: pel_sky_update finds
 * its own again. */
PEL_CHECK enum pel_err pel_space_need(struct pel_space_map *m,
                                      const char *shader_dir,
                                      struct pel_fault *fault);
void pel_space_suns(struct pel_space_map *m, struct pel_sky *sky,
                    const struct pel_environment *env);

/* A program of shaders/space.frag, made when it is first asked for; 0 with a
 * fault where it cannot be. The meter's for so many lights, with winds or
 * without. */
GLuint pel_space_program(struct pel_space_map *m, const char *shader_dir,
                         const char *defines, struct pel_fault *fault);
PEL_CHECK enum pel_err pel_space_need_meter(struct pel_space_map *m, int lit,
                                            bool winds, const char *shader_dir,
                                            struct pel_fault *fault);

/* Brings continents to the device, where some are wanted and not there yet; the
 * first waits for their file. */
void pel_space_continents(struct pel_space_map *m,
                          const struct pel_environment *env);

void pel_fill_space(const struct pel_space_map *m,
                    const struct pel_environment *env,
                    const struct pel_space_geometry *g,
                    struct pel_block_space *out);

/* Makes the air of the eye current, and binds what the programs read. The
 * blocks `frame` and `space` are bound; *env is of pel_space_environment. */
void pel_space_bind(struct pel_space_map *m, const struct pel_sky *sky,
                    const struct pel_environment *env,
                    const struct pel_block_space *block);
