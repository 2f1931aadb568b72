/* The passes of one view: from its camera to its pixels on their way back.
 * Render thread only, between pel_arena_begin and pel_arena_end of the frame,
 * after everything that its views share. */
#ifndef PELAGOS_RENDER_VIEWPASS_H
#define PELAGOS_RENDER_VIEWPASS_H

#include "render/renderer.h"
#include "render/rendererstate.h"

/* Uniform blocks and rings of one view, with alignment. */
#define PEL_VIEW_UNIFORM_BYTES                                                 \
    (sizeof(struct pel_block_waves) + sizeof(struct pel_block_view) +          \
     sizeof(struct pel_block_eye) * 6 +                                        \
     (sizeof(struct pel_block_seabed) + sizeof(struct pel_block_wakes)) * 2 +  \
     sizeof(struct pel_block_under) + sizeof(struct pel_block_sighted) +       \
     sizeof(struct pel_block_shore) + 3 * sizeof(struct pel_block_frame) +     \
     sizeof(struct pel_block_space) +                                          \
     sizeof(struct pel_mesh_ring) * PEL_MESH_MAX_RINGS * 2 + 4096)

/* Of the arena, for a view of it: uniforms, and the moment's wash. */
size_t pel_view_bytes(const struct pel_environment *env);

/* Whether outlines are mixed in it. */
bool pel_view_edges(const struct pel_renderer *r, const struct pel_camera *c);

/* The layers that are shaded: those asked for, and the radiance where outlines
 * are mixed, objects as fragments lie before what is behind them, or something
 * comes between light and colour; `late`: of an eye that is in the water or at
 * its surface (pel_lens_under), or whose view has two forms (pel_space_share).
 */
unsigned pel_view_layers(const struct pel_renderer *r,
                         const struct pel_environment *env,
                         const struct pel_draw *draw, bool late);

/* What is shaded of them at once. */
unsigned pel_view_at_once(const struct pel_environment *env,
                          const struct pel_draw *draw, unsigned asked,
                          bool late);

/* At an altitude above the sea's zero, in metres. */
bool pel_view_above_clouds(const struct pel_environment *env,
                           double altitude_m);

/* Draws it and begins to read it back; GPU on errors of the driver. */
PEL_CHECK enum pel_err pel_view_draw(struct pel_renderer *r,
                                     const struct pel_environment *env,
                                     const struct pel_draw *draw);

#endif
