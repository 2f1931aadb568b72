/* Pictures of sensors that do not show the eye's light (scene/snapshot.h: low
 * light, thermal): what they need of the shading, and the pass that makes the
 * colour of it (shaders/sense.frag). Nothing of it exists before the first.
 * Render thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>

#include "render/programs.h"
#include "render/renderer.h"

/* Zeroed before its first use. */
struct pel_sensing {
    GLuint programs[PEL_LIGHT_KINDS][2]; /* low light, thermal */
    GLuint rough, heats;                 /* tables of heat */
};
void pel_sensing_finish(struct pel_sensing *s);

/* Whether this pass makes the camera's colour. */
bool pel_sensing_is(const struct pel_camera *c);

/* What is to be shaded instead of these layers. */
unsigned pel_sensing_layers(const struct pel_camera *c, unsigned layers);

/* Makes the program. GPU. */
PEL_CHECK enum pel_err pel_sensing_need(struct pel_sensing *s,
                                        const struct pel_programs *programs,
                                        const struct pel_camera *c,
                                        struct pel_fault *fault);

/* Draws the colour into the bound framebuffer, from the planes (by PEL_AT_*) of
 * those layers. The camera's altitude is above the sea's zero; the blocks view,
 * eye, frame and exposure are bound. */
void pel_sensing_run(struct pel_sensing *s, const struct pel_programs *programs,
                     const struct pel_environment *env,
                     const struct pel_camera *c, const GLuint *planes);
