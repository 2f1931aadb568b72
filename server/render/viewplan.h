/* What a view is before it is drawn: its pixels, its mesh, and the blocks that
 * the shaders read of it. Render thread only. */
#ifndef PELAGOS_RENDER_VIEWPLAN_H
#define PELAGOS_RENDER_VIEWPLAN_H

#include <epoxy/gl.h>

#include "render/band.h"
#include "render/disc.h"
#include "render/mesh.h"
#include "render/programs.h"
#include "render/renderer.h"
#include "render/undermap.h"

struct pel_renderer;

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

/* A vertex of the mesh, as mesh.comp writes it. */
#define PEL_VERTEX_BYTES 32

/* One that is drawn; its cameras stand above the sea's zero. */
struct pel_view {
    const struct pel_draw *draw;
    unsigned asked; /* layers that are shaded */
    int border;     /* pixels more at each edge, for the eye's loss of detail */
    struct pel_camera whole, wide, part; /* with border; and margin; its band */
    struct pel_band band;
    double height_m, table_height_m; /* of the eye, and of its light's tables */
    struct pel_lens_place lens;
    double share; /* pel_space_share */
    bool high;    /* it has the form of render/spacemap.h alone */
    const struct pel_sea_programs *programs;
    struct pel_block_view block;
    struct pel_block_eye eye;
    struct pel_disc_box discs[PEL_LIGHTS];
};

/* Whether something comes between its light and its colour (pel_view_layers).
 */
bool pel_view_is_late(const struct pel_view *v);

/* From `draw` and `border`: all up to `high`, and `block`; the renderer's
 * margin. What decides how a pixel is drawn is planned for the whole picture.
 */
void pel_view_plan_pixels(struct pel_renderer *r,
                          const struct pel_environment *env,
                          struct pel_view *v);

/* The mesh of its pixels, after them; `under`: of an eye below the surface;
 * `like` as in pel_mesh_plan. */
void pel_view_plan_mesh(const struct pel_renderer *r,
                        const struct pel_environment *env,
                        const struct pel_view *v, bool under,
                        const struct pel_mesh *like, struct pel_mesh *mesh);

/* Its block `eye`, with that mesh. */
void pel_view_fill_eye(const struct pel_environment *env,
                       const struct pel_mesh *mesh, struct pel_view *v);

/* Height above the sea of the eye that its exposure is metered by, and that
 * meter's blocks. */
double pel_view_meter_height(const struct pel_environment *env,
                             const struct pel_camera *c);
void pel_view_fill_meter(const struct pel_environment *env,
                         const struct pel_camera *c, struct pel_block_eye *eye,
                         struct pel_block_sighted *sights);

/* Copied into the frame's memory and bound: a uniform block; and for an eye
 * above a place the bottom, the sea, ship waves. */
void pel_view_bind(struct pel_renderer *r, GLuint block, const void *data,
                   size_t size);
void pel_view_bind_seabed(struct pel_renderer *r,
                          const struct pel_environment *env,
                          const struct pel_camera *c);
void pel_view_bind_sea(struct pel_renderer *r,
                       const struct pel_environment *env,
                       const struct pel_camera *c);
/* The mesh as hardware shades it. */
void pel_view_bind_net(const struct pel_renderer *r, GLuint vertices);
void pel_view_bind_wakes(struct pel_renderer *r,
                         const struct pel_environment *env,
                         const struct pel_view *v);

/* Its view and eye, its exposure metered. */
void pel_view_bind_eye(struct pel_renderer *r,
                       const struct pel_environment *env,
                       const struct pel_view *v);

/* What the colour of a draw comes back as. */
enum pel_ycbcr pel_view_ycbcr(const struct pel_renderer *r,
                              const struct pel_draw *draw);

#endif
