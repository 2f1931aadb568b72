/* Particles in the water before an eye in it (optics/motes.h): a point each,
 * blended over the light that is drawn. Nothing of it exists before the first
 * picture that has some. Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "optics/motes.h"
#include "render/programs.h"
#include "render/renderer.h"
#include "render/targets.h"

/* Zeroed before its first use. */
struct pel_mote_map {
    GLuint fbo, buffer;
    struct pel_mote *motes; /* room for PEL_MOTE_MOST */
    struct pel_mote_program {
        char defines[512];
        GLuint program;
    } programs[8];
    int program_count;
};

/* A picture of these layers shows some, if its eye is in the water. */
bool pel_mote_map_shows(const struct pel_environment *env, unsigned layers);

/* GPU when a program does not compile, NO_MEMORY. */
PEL_CHECK enum pel_err pel_mote_map_need(struct pel_mote_map *map,
                                         const struct pel_environment *env,
                                         const struct pel_programs *programs,
                                         struct pel_fault *fault);
void pel_mote_map_finish(struct pel_mote_map *map);

/* What a camera sees of them; extinction: the least of its water, 1/m. */
struct pel_mote_view pel_mote_map_view(const struct pel_environment *env,
                                       const struct pel_camera *camera,
                                       double extinction);

/* Draws them into the radiance. The camera is the whole picture's; block
 * `under`, what sights meet (pel_under_map_draw) and the light are bound. */
void pel_mote_map_put(struct pel_mote_map *map,
                      const struct pel_environment *env,
                      const struct pel_programs *programs,
                      const struct pel_camera *camera, double extinction,
                      const struct pel_block_view *view, bool objects,
                      const struct pel_targets *targets);
