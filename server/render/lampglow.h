/* Lamps mirrored by the sea: which of them, as shading reads them, and in which
 * tiles of a picture. Render thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdint.h>

#include "render/renderer.h"
#include "shaders/lib/blocks.h"

#define PEL_GLOWS 32 /* the bits of a tile's mask */

struct pel_glow_candidate; /* lampglow.c */

struct pel_lamp_glow {
    GLuint buffer, texels;
    uint32_t *words;
    struct pel_glow_candidate *glows; /* room for those of a picture */
};

/* Intensities at 680, 550 and 440 nm of a colour by the matrix *m of
 * optics/colour.h and its inverse: as nearly as positive ones can, and exactly
 * as bright. */
void pel_lamp_spectral(const double m[9], const double inverse[9],
                       const double colour_cd[3], double out[3]);
void pel_lamp_inverse(const double m[9], double out[9]);

/* Those that shine most at the eye's place, as many as PEL_GLOWS, whatever the
 * view looks at; and of each tile of the camera's picture, whose rows are drawn
 * from `first_row` on after `margin` pixels, those that slopes up to
 * PEL_LAMP_SLOPES standard deviations may mirror there. Binds them. The camera
 * stands above the sea's zero. */
void pel_lamp_glow_bind(struct pel_lamp_glow *g,
                        const struct pel_environment *env,
                        const struct pel_camera *camera, uint32_t first_row,
                        int margin);

/* Those in the water that shine most where an eye in it is, in the same form,
 * at most PEL_UNDER_LAMPS; their number. */
int pel_lamp_glow_below(const struct pel_environment *env,
                        const struct pel_camera *camera,
                        float out[PEL_UNDER_LAMPS * PEL_GLOW_TEXELS][4]);
bool pel_lamp_glow_any_below(const struct pel_environment *env);

void pel_lamp_glow_finish(struct pel_lamp_glow *g);
