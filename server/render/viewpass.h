/* The passes of one view: from its camera to its pixels on their way back.
 * Render thread only, between pel_arena_begin and pel_arena_end of the frame,
 * after everything that its views share. */
#ifndef PELAGOS_RENDER_VIEWPASS_H
#define PELAGOS_RENDER_VIEWPASS_H

#include "render/renderer.h"
#include "render/rendererstate.h"

/* Draws it and begins to read it back; GPU on errors of the driver. */
PEL_CHECK enum pel_err pel_view_draw(struct pel_renderer *r,
                                     const struct pel_environment *env,
                                     const struct pel_draw *draw);

#endif
