/* Pictures' colours as planes of luma and chroma, made by the device where
 * encoders take nothing else: 1.5 bytes a pixel are read back instead of 4, and
 * no processor converts them. Shading in compute only; but for the layout,
 * which is pure, render thread only. */
#ifndef PELAGOS_RENDER_YCBCR_H
#define PELAGOS_RENDER_YCBCR_H

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "render/jpegcoder.h"
#include "render/readback.h"
#include "shaders/lib/blocks.h"

/* Planes behind each other: bytes from row to row, and where each begins; pairs
 * are one. None of what is coded, but for its size. */
struct pel_ycbcr_layout {
    int count;
    size_t stride[3], offset[3];
    size_t size; /* of all, bytes */
};
struct pel_ycbcr_layout pel_ycbcr_layout(enum pel_ycbcr form, uint32_t width,
                                         uint32_t height);

/* Zeroed before its first use. */
struct pel_ycbcr_pass {
    GLuint one, together; /* programs */
    GLuint colors;        /* of views together, and the EV100 of each */
    size_t capacity;      /* its bytes */
    struct pel_jpeg_coder coder;
};

/* Makes the programs for single views or those that are drawn together, of the
 * form. GPU, NO_MEMORY. */
PEL_CHECK enum pel_err pel_ycbcr_need(struct pel_ycbcr_pass *p, bool together,
                                      enum pel_ycbcr form,
                                      const char *shader_dir,
                                      struct pel_fault *fault);
void pel_ycbcr_finish(struct pel_ycbcr_pass *p);

/* Of views that are drawn together. */
struct pel_ycbcr_view {
    enum pel_ycbcr form;
    int quality; /* of what is coded */
    uint32_t width, height;
    size_t at;        /* found here: bytes into the colours */
    size_t planes_at; /* the same of what is coded: into the coder's planes */
    const struct pel_readback_slot *slot;
};

/* Gives each its place in memory that shaders write colours into, top row
 * first, and behind them the EV100. */
void pel_ycbcr_fit(struct pel_ycbcr_pass *p, struct pel_ycbcr_view *views,
                   size_t count);
/* Binds their places at PEL_STORE_PICTURES. */
void pel_ycbcr_begin(struct pel_ycbcr_pass *p,
                     const struct pel_ycbcr_view *views, size_t count);
/* From there into their slots, as planes or as they are. */
void pel_ycbcr_end(struct pel_ycbcr_pass *p, const struct pel_ycbcr_view *views,
                   size_t count);

/* From a texture, `aside` pixels from its first row and column, into the slot;
 * its EV100 is not written. */
void pel_ycbcr_one(struct pel_ycbcr_pass *p, GLuint colors, int aside,
                   struct pel_ycbcr_view *view);

#endif
