/* Lamps in a picture (optics/lamp.h): which a view may show, what of each
 * reaches the eye, and their light as it is spread over pixels. Render thread
 * only.
 *
 * A lamp's illuminance at the eye, E = I T / d² (Allard), is deposited in the
 * radiance of a few pixels with weights that add up to 1 wherever in a pixel it
 * stands; of it the share that the lens scatters is spread as
 * pel_glare_spread. Objects and land hide a lamp by rays from here, the sea by
 * the picture's triangles. */
#pragma once

#include <epoxy/gl.h>

#include "render/arena.h"
#include "render/programs.h"
#include "render/renderer.h"
#include "render/targets.h"

struct pel_lamp_map {
    GLuint spots, spots_texels; /* buffer and its view */
    GLuint fbo;
    GLuint light; /* their own, of a picture */
    uint32_t width, height;
    GLuint find[2][PEL_LIGHT_KINDS]; /* programs, the second by keys */
    GLuint put, alone;               /* `alone`: in compute */
    GLuint tone[2][PEL_LIGHT_KINDS]; /* the second where they are added */
    struct pel_shader_lamp *lamps;
    size_t count; /* of the last view */
};

/* GPU when a program does not compile. Without lamps nothing is made. */
PEL_CHECK enum pel_err pel_lamp_map_need(struct pel_lamp_map *map,
                                         const struct pel_programs *programs,
                                         const struct pel_environment *env,
                                         struct pel_fault *fault);
void pel_lamp_map_finish(struct pel_lamp_map *map);

/* Bytes of the arena that a view takes. */
size_t pel_lamp_map_bytes(const struct pel_environment *env);

/* The lamps that this view may show; the camera stands above the sea's zero.
 * Afterwards, before it is shaded, pel_lamp_map_find: what reaches the eye, by
 * the triangles in `targets`. */
void pel_lamp_map_plan(struct pel_lamp_map *map,
                       const struct pel_environment *env,
                       const struct pel_camera *camera,
                       const struct pel_block_view *view);
void pel_lamp_map_find(struct pel_lamp_map *map,
                       const struct pel_programs *programs,
                       const struct pel_targets *targets,
                       struct pel_arena *arena);

/* Draws them alone and binds that for programs that tone as they shade, which
 * add it before. */
void pel_lamp_map_alone(struct pel_lamp_map *map, bool compute, uint32_t width,
                        uint32_t height);

/* Adds `share` of them to the light in a texture. */
void pel_lamp_map_put(struct pel_lamp_map *map, GLuint light, double share);
