/* What an eye in the water sees (docs/physics/underwater.md): the light of
 * the water about it (optics/underlight.h), the shafts that waves focus, and
 * the pass that draws its pixels: all of them, or those below the line that
 * the surface draws on a dome before the lens. Nothing here costs anything as
 * long as no eye is so low that waves may reach it. Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "optics/underlight.h"
#include "render/arena.h"
#include "render/objects.h"
#include "render/programs.h"
#include "render/renderer.h"
#include "render/sky.h"
#include "render/targets.h"

enum pel_lens_state {
    PEL_LENS_HIGH, /* no wave may reach it */
    PEL_LENS_DRY,  /* in the air, lower than crests */
    PEL_LENS_CROSSED,
    PEL_LENS_WET,
};

/* How a camera lies to the surface. */
struct pel_lens_place {
    enum pel_lens_state state;
    double above_m; /* the surface above the eye, negative: below it */
    struct pel_vec2 slope;
};

/* Asked of the sea only where waves may reach the eye: the answer of an FFT sea
 * costs its transforms on the processor. The camera's altitude is above the
 * sea's zero. */
struct pel_lens_place pel_lens_place(const struct pel_environment *env,
                                     const struct pel_camera *camera);
static inline bool pel_lens_under(const struct pel_lens_place *p)
{
    return p->state >= PEL_LENS_CROSSED;
}

/* One that was made, and what for. */
struct pel_under_program {
    char defines[512];
    GLuint program;
};
#define PEL_UNDER_PROGRAMS 96

/* Zeroed before its first use. */
struct pel_under_map {
    struct pel_under_program programs[PEL_UNDER_PROGRAMS];
    int program_count;
    GLuint map_program;
    GLuint map, shafts;
    GLuint found, found_fbo;                /* what lines of sight meet */
    GLuint normal, foam, back, surface_fbo; /* of the surface that they meet */
    GLuint lamps, lamps_on, lamps_fbo;    /* what lamps add before it, on it */
    GLuint above, above_depth, above_fbo; /* objects through a level surface */
    GLuint above_program;
    uint32_t width, height; /* of these */
    GLuint kernels[2];
    double kernel_depth_m[2]; /* of the water that each is of; 0: none */
    uint64_t used[2], uses;
    struct pel_water_body body; /* of both */
    double deepest_m;
    struct pel_under_medium medium;
    uint64_t version; /* counts changes of these */
    double light_key[PEL_SKY_LIGHT_KEYS + 4];
    bool made;
    int64_t used_ns;
};

void pel_under_map_finish(struct pel_under_map *map);

/* Makes the programs for this kind of picture. GPU. */
PEL_CHECK enum pel_err pel_under_map_need(struct pel_under_map *map,
                                          const struct pel_environment *env,
                                          const struct pel_programs *programs,
                                          enum pel_shading kind,
                                          struct pel_fault *fault);

/* Brings the water's light up to date for a camera, binds it and the block
 * `under`. The sky is up to date, blocks of the frame, the sea and the bottom
 * (pel_fill_seabed) are bound. False: no memory. */
bool pel_under_map_bind(struct pel_under_map *map,
                        const struct pel_environment *env, struct pel_sky *sky,
                        const struct pel_camera *camera,
                        const struct pel_lens_place *place,
                        struct pel_arena *arena);

/* Gives back what a picture under water needs, programs apart, where there has
 * been none for ten seconds: 30 MB and 100 bytes a pixel. */
void pel_under_map_rest(struct pel_under_map *map);

/* The shafts about it: the same, and block `view`. */
void pel_under_map_shafts(struct pel_under_map *map,
                          const struct pel_environment *env,
                          const struct pel_programs *programs);

/* The least extinction of the water that it was made for. [1/m] */
double pel_under_map_least(const struct pel_under_map *map);

/* Draws its pixels into the targets; `asked`: the layers without the colour.
 * The mesh of the eye is in targets.triangles, objects (NULL: none) are
 * rasterised. Leaves the viewport as it was. */
void pel_under_map_draw(struct pel_under_map *map,
                        const struct pel_environment *env,
                        const struct pel_programs *programs,
                        struct pel_targets *targets, unsigned asked,
                        bool crossed, const struct pel_objects *objects,
                        const struct pel_block_view *view);
