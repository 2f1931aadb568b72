/* What an eye loses of detail by little light (optics/vision.h): between
 * shading and tone the light of a picture is spread by a Gaussian of one angle
 * everywhere, into a texture that tone reads instead of the radiance. Lamps are
 * added after it. The picture is drawn with as many pixels beyond its edges as
 * that needs, so that bands, tiles and windows of one lattice agree to the bit.
 * Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "render/renderer.h"
#include "render/targets.h"

struct pel_acuity {
    GLuint programs[2]; /* along rows, across them */
    GLuint textures[2]; /* after each */
    GLuint fbos[2];
    uint32_t width, height;
};

/* Pixels beyond each edge of a picture of these layers that are to be drawn,
 * up to PEL_ACUITY_BORDER; 0: none of this happens. More than 0 for an EYE
 * while the Sun is lower than 2° under the horizon. Any thread. */
int pel_acuity_border(const struct pel_environment *env,
                      const struct pel_camera *camera, unsigned layers);

/* The meter of a fixed EV is to tell what the eye is adapted to. Any thread. */
void pel_acuity_meter(const struct pel_environment *env,
                      const struct pel_camera *camera,
                      struct pel_block_sighted *sights);

/* Makes the programs. GPU. */
PEL_CHECK enum pel_err pel_acuity_need(struct pel_acuity *a,
                                       const char *shader_dir,
                                       struct pel_fault *fault);
void pel_acuity_finish(struct pel_acuity *a);

/* Spreads the radiance of these targets, of which width x height pixels are
 * used; all but the outermost `border` are asked for. Returns the texture. The
 * blocks frame, view and exposure are bound. */
GLuint pel_acuity_run(struct pel_acuity *a, const struct pel_targets *targets,
                      GLsizei width, GLsizei height, GLint border);
