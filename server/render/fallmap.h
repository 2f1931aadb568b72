/* Drops and flakes near the eye (optics/falling.h) over the radiance of a
 * picture. Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "render/programs.h"
#include "render/renderer.h"
#include "render/targets.h"

struct pel_fall_map {
    GLuint fbo;
    GLuint fallen[3][PEL_LIGHT_PROGRAMS]; /* of rain, of snow, of both */
    GLuint falling[PEL_LIGHT_PROGRAMS];
};

/* Whether pictures of these layers (of enum pel_layer) show some. */
bool pel_fall_map_shows(const struct pel_environment *env, unsigned layers);

/* GPU when the program does not compile. Dry, nothing is made. */
PEL_CHECK enum pel_err pel_fall_map_need(struct pel_fall_map *map,
                                         const struct pel_environment *env,
                                         const char *shader_dir,
                                         struct pel_fault *fault);
void pel_fall_map_finish(struct pel_fall_map *map);

/* The viewport is that of the targets. */
void pel_fall_map_put(struct pel_fall_map *map,
                      const struct pel_environment *env,
                      const struct pel_camera *camera,
                      const struct pel_block_view *view,
                      const struct pel_targets *targets);
