/* What is drawn of clouds (optics/clouds.h): their field, what they leave of
 * the lights' beams over it, and what they add before a view's sky and leave of
 * it, at the nodes of a lattice coarser than its pixels'. Render thread only.
 */
#pragma once

#include <epoxy/gl.h>

#include "optics/clouds.h"
#include "render/renderer.h"

struct pel_block_view;

/* What their shade depends on. */
#define PEL_CLOUD_KEYS (6 + 3 * PEL_LIGHTS)

struct pel_cloud_map {
    GLuint field;
    enum pel_cloud_genus genus;
    uint32_t seed;
    GLuint shade, shade_fbo;
    GLuint shade_program[PEL_LIGHTS]; /* by how many give light */
    double key[PEL_CLOUD_KEYS];
    GLuint scape, scape_fbo;
    GLsizei width, height; /* of the last */
};

/* GPU when a program does not compile. Without clouds nothing is made. */
PEL_CHECK enum pel_err pel_cloud_map_need(struct pel_cloud_map *map,
                                          const struct pel_environment *env,
                                          const char *shader_dir,
                                          struct pel_fault *fault);

/* Makes field and shade current on their units. A new genus or seed takes some
 * tenths of a second. The block of the frame is bound; bind_eye: that of an eye
 * with the axes of env's clouds. */
void pel_cloud_map_bind(struct pel_cloud_map *map,
                        const struct pel_environment *env,
                        void (*bind_eye)(void *user, double height_m),
                        void *user);

/* Draws them before the sky of *view, which is bound, by `program`
 * (cloudscape.frag), and makes that current on its unit. env: its flashes. */
void pel_cloud_map_scape(struct pel_cloud_map *map, GLuint program,
                         const struct pel_environment *env,
                         const struct pel_camera *camera,
                         const struct pel_block_view *view);

void pel_cloud_map_finish(struct pel_cloud_map *map);
