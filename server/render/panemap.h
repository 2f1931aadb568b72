/* Drops on a pane half a metre before the camera (views.*.wetLens): they sit,
 * dry and are hit anew, and others run down, take along what they meet and
 * leave beads: a function of the time, the pane and the place on it. Each shows
 * sky and sea turned over, from their maps and not from the picture, so that
 * bands and tiles need nothing of each other. Blended over the radiance. Render
 * thread only. */
#pragma once

#include <epoxy/gl.h>

#include "render/programs.h"
#include "render/renderer.h"

struct pel_pane_map {
    GLuint fbo;
    GLuint programs[PEL_LIGHT_PROGRAMS];
};

/* Whether pictures of these layers (of enum pel_layer) show some. */
bool pel_pane_map_shows(const struct pel_camera *camera, unsigned layers);

/* GPU when the program does not compile. */
PEL_CHECK enum pel_err pel_pane_map_need(struct pel_pane_map *map,
                                         const struct pel_environment *env,
                                         const char *shader_dir,
                                         struct pel_fault *fault);
void pel_pane_map_finish(struct pel_pane_map *map);

/* Over a texture of radiance; the viewport is that of the targets. */
void pel_pane_map_put(struct pel_pane_map *map,
                      const struct pel_environment *env,
                      const struct pel_camera *camera, GLuint light);
