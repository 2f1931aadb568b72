/* What the renderer's passes share; none of it is for others
 * (render/renderer.h). Render thread only. */
#ifndef PELAGOS_RENDER_RENDERERSTATE_H
#define PELAGOS_RENDER_RENDERERSTATE_H

#include <epoxy/gl.h>

#include "render/acuity.h"
#include "render/arena.h"
#include "render/cloudmap.h"
#include "render/context.h"
#include "render/fallmap.h"
#include "render/filtering.h"
#include "render/foammap.h"
#include "render/lampglow.h"
#include "render/lampmap.h"
#include "render/mesh.h"
#include "render/meter.h"
#include "render/motemap.h"
#include "render/objects.h"
#include "render/panemap.h"
#include "render/probe.h"
#include "render/programs.h"
#include "render/readback.h"
#include "render/seabedmap.h"
#include "render/sensing.h"
#include "render/shoremap.h"
#include "render/sky.h"
#include "render/spacemap.h"
#include "render/stages.h"
#include "render/statistics.h"
#include "render/targets.h"
#include "render/texels.h"
#include "render/tiles.h"
#include "render/together.h"
#include "render/undermap.h"
#include "render/wakemap.h"
#include "render/waterprobe.h"
#include "render/wavefield.h"
#include "render/ycbcr.h"

struct pel_renderer {
    struct pel_context context;
    const char *shader_dir;
    unsigned lose_after;               /* of the options */
    const struct pel_environment *env; /* of the frame that is drawn */
    struct pel_cloud_map clouds;
    struct pel_fall_map falls;
    struct pel_pane_map panes;
    struct pel_lamp_map lamps;
    struct pel_lamp_glow glows;
    struct pel_acuity acuity;
    struct pel_under_map under;
    struct pel_mote_map motes;
    bool lost;
    bool drew; /* a frame, so that what all frames need is there */
    struct pel_filtering filtering;
    struct pel_filter filter; /* its bounds */
    struct pel_readback readback;
    struct pel_arena arena;
    struct pel_sky sky;
    struct pel_space_map space;
    struct pel_targets targets;
    struct pel_stage_timer timing;
    GLuint vao, vertices;
    GLuint vertex_texels; /* the same buffer as a texture */
    int vertex_capacity;
    struct pel_sea_texels tables;
    struct pel_programs programs;
    int64_t eyes_until_ns; /* programs for eyes and sensors too */
    struct pel_meter meter;
    struct pel_together together;
    struct pel_ycbcr_pass ycbcr;
    struct pel_sensing sensing;
    struct pel_prober prober;
    struct pel_water_prober water_prober;
    struct pel_wavefield wavefield;
    struct pel_foam_map foam;
    struct pel_wake_map wakes;
    struct pel_shore_map shore;
    struct pel_statistics statistics;
    struct pel_mesh *mesh;
    struct pel_seabed_map seabed;
    struct pel_objects objects;
    uint32_t tiles[PEL_MAX_TILES]; /* of the view being drawn */
    bool any_coast, any_objects;
    /* Of tiles that no ship waves and no wash reach; NULL: none. */
    const struct pel_sea_programs *still;
    int margin; /* of its triangles around its pixels: render/edges.h */
};

/* Groups of `size` that cover `count`. */
static inline GLuint pel_groups(int count, int size)
{
    return (GLuint)((count + size - 1) / size);
}

#endif
