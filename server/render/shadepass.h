/* From the nearest triangle of each pixel to its light and colour: sea, sky,
 * coasts, objects, and the pixels that outlines cut. Render thread only. */
#ifndef PELAGOS_RENDER_SHADEPASS_H
#define PELAGOS_RENDER_SHADEPASS_H

#include <epoxy/gl.h>
#include <stdbool.h>

#include "render/disc.h"
#include "render/programs.h"
#include "scene/snapshot.h"

struct pel_environment;
struct pel_renderer;

/* All passes of the layers asked for (PEL_LAYER_*), as fragments. *c is the
 * band's camera, discs those of PEL_LIGHTS lights. */
void pel_shade_fragments(struct pel_renderer *r, const struct pel_camera *c,
                         const struct pel_disc_box *discs,
                         const struct pel_sea_programs *p, unsigned asked);

/* The same in compute, always with the colour. */
void pel_shade_dispatches(struct pel_renderer *r, const struct pel_camera *c,
                          const struct pel_sea_programs *p, unsigned asked);

/* Whether these layers are shaded with the colour. */
bool pel_shade_tones(const struct pel_renderer *r, unsigned asked);

/* Whether any of these layers is what the middles of pixels show. */
bool pel_shade_middles(unsigned asked);

/* The pixels, from two corners, of the triangles' picture that lie in tiles
 * with objects. */
void pel_shade_box(const struct pel_renderer *r, const struct pel_camera *c,
                   GLint box[4]);

/* Display colours from the radiance in a texture. */
void pel_shade_tone(struct pel_renderer *r, const struct pel_camera *c,
                    GLuint light);

/* The same of a sensor's picture (render/sensing.h). */
void pel_shade_sense(struct pel_renderer *r, const struct pel_environment *env,
                     const struct pel_camera *c);

#endif
