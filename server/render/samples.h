/* What the samples of pixels show of objects, for their silhouettes: the
 * nearest triangle at each of four places in a pixel, and which of them are not
 * behind the sea. A pixel's light is the mean of its samples; its middle, of
 * the layers that are no light, is rasterised beside them. Render thread only.
 */
#pragma once

#include <epoxy/gl.h>

#include "render/programs.h"
#include "render/tiles.h"

/* Zeroed before its first use. */
struct pel_samples {
    uint32_t width, height;
    GLuint numbers, depths, fbo; /* entity and triangle, as render/objects.h */
    GLuint cover, cover_fbo;     /* bits of samples that show objects */
    GLuint shown;                /* depth: 0 where none is, else 1 */
    GLuint raster[2];            /* programs; the second leaves out holes */
    GLuint any, sight, hide;
    bool by_keys; /* `sight` is in compute and reads the sea from keys */
};

/* GPU with a fault when a program does not compile. */
PEL_CHECK enum pel_err pel_samples_need(struct pel_samples *s,
                                        const struct pel_programs *programs,
                                        bool holed, struct pel_fault *fault);
void pel_samples_finish(struct pel_samples *s);

/* Ready to draw objects' triangles into a picture of so many pixels, of which
 * the rectangle may show some: the program that does is in use. */
void pel_samples_begin(struct pel_samples *s, GLsizei width, GLsizei height,
                       const GLint box[4]);

/* Afterwards: which samples the sea does not hide. Binds what shading reads. */
void pel_samples_sight(struct pel_samples *s, const GLint box[4]);

/* Takes pixels that objects fill out of what is drawn behind PEL_HIDDEN_DEPTH,
 * by the depths of `fbo`; `middles`: only if their middles show one too. */
#define PEL_HIDDEN_DEPTH 1e-10f
void pel_samples_hide(struct pel_samples *s, GLuint fbo, const GLint box[4],
                      bool middles);
