/* Views of one eye that are drawn together: each stage of all of them is one
 * dispatch, whose layers are the views, and writes their colours into their
 * readback buffers. Driver and device take for them little more than for one of
 * as many pixels. A picture has the same bits whatever it is drawn with: what
 * can be drawn so always is. Shading in compute only; render thread only. */
#ifndef PELAGOS_RENDER_TOGETHER_H
#define PELAGOS_RENDER_TOGETHER_H

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "render/viewplan.h"
#include "render/ycbcr.h"
#include "shaders/lib/blocks.h"

/* Zeroed before its first use. */
struct pel_together {
    bool off;                            /* its programs do not compile here */
    GLuint search, find, outline, clear; /* programs */
    GLuint vertices, texels;             /* the same as a texture */
    GLuint keys, suspects, edges, radiance; /* buffers, by pixels */
    size_t vertex_capacity, pixel_capacity; /* of all views */
    unsigned small_draws;
    struct pel_view_together *views; /* PEL_TOGETHER_MOST, when first needed */
    size_t count;                    /* of those planned */
    /* What those are read back to, from pel_together_reserve to the drawing. */
    struct pel_readback_slot *slots[PEL_TOGETHER_MOST];
    struct pel_ycbcr_view planes[PEL_TOGETHER_MOST];
    bool any_planes;
    /* Where what their shaders read is in the arena, from then, too. */
    size_t views_at, rings_at, rings_bytes;
};

/* Whether this view of an environment is drawn so: the open sea by day, its
 * colour and nothing else of it, with nothing between it and the glass. */
bool pel_together_can(const struct pel_renderer *r,
                      const struct pel_environment *env,
                      const struct pel_draw *draw);

/* Makes the programs that a view wants that can. Where they do not compile it
 * is off from then on, unless compute was asked for. GPU, NO_MEMORY. */
PEL_CHECK enum pel_err pel_together_need(struct pel_renderer *r,
                                         const struct pel_environment *env,
                                         const struct pel_draw *draw,
                                         struct pel_fault *fault);

/* Plans as many of the next `count` draws as can be drawn together, without GL;
 * their number, 0: the first cannot. */
size_t pel_together_plan(struct pel_renderer *r,
                         const struct pel_environment *env,
                         const struct pel_draw *draws, size_t count);

/* Memory of the device and of the host for those planned, and what shaders read
 * of them in its place. It may take the driver a millisecond a view, and is not
 * for a device's turn (render/turn.h). NO_MEMORY. */
PEL_CHECK enum pel_err pel_together_reserve(struct pel_renderer *r);

/* Draws what memory was reserved for and begins to read it back. */
void pel_together_draw(struct pel_renderer *r,
                       const struct pel_environment *env);

/* Gives back what many or large views took. */
void pel_together_rest(struct pel_together *t);
void pel_together_finish(struct pel_together *t);

#endif
