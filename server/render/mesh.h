/* The mesh of the sea around an eye: rings about its nadir, columns of equal
 * azimuth. Rings and columns depend on the eye, the sea and the pixel's angle
 * only; a view chooses which of them it draws. Pure computation, no GL.
 *
 * It replaces the paper's screen-space grid: cells are as wide on the screen
 * (cell_px pixels) and as long as the height of the waves that they lose
 * allows, but they do not turn with the camera, and reach under and behind it.
 */
#pragma once

#include <stddef.h>

#include "ocean/filter.h"
#include "ocean/sea.h"
#include "scene/snapshot.h"
#include "shaders/lib/blocks.h"

#define PEL_MESH_MAX_RINGS 4096
#define PEL_MESH_MAX_VERTICES 1000000

/* Root mean square height that a sea loses when it is drawn by cells of a
 * length: waves that the filter w_p drops, and what straight lines between
 * vertices cut off the others, tabulated over lengths in equal steps of their
 * logarithm. Made once for a sea. */
#define PEL_MESH_LOSSES 96
struct pel_mesh_losses {
    double cell_m[PEL_MESH_LOSSES], rms_m[PEL_MESH_LOSSES]; /* both rising */
    unsigned serial; /* of this table, from 1 on: no other has it */
};
void pel_mesh_losses(const struct pel_sea *sea, const struct pel_filter *filter,
                     struct pel_mesh_losses *out);

/* What rings depend on. */
struct pel_mesh_eye {
    double height_m; /* of the eye above mean sea level, > 0 */
    double pixel;    /* tangent of one pixel on the axis */
    double cell_px;  /* width of a cell, pixels */
    const struct pel_sea *sea;
    const struct pel_mesh_losses *losses; /* of this sea */
};

struct pel_mesh_ring {
    float radius_m; /* arc from the nadir */
    float cell_m;   /* length of the cells here, for the filter w_p */
};

/* Rings [first_ring, first_ring + rings) by columns [first_column, …). */
struct pel_mesh_block {
    int first_ring, rings, first_column, columns;
    int base; /* its first vertex */
};

/* What the rings of a mesh were laid by; all 0: not laid. */
struct pel_mesh_laid {
    double height_m, pixel, start_m, rise_m, column_rad, coarser;
    unsigned losses;
};

struct pel_mesh {
    struct pel_mesh_laid laid;
    int columns_around; /* columns in a full circle */
    double column_rad;
    int ring_count;
    struct pel_mesh_ring rings[PEL_MESH_MAX_RINGS];
    int block_count;
    struct pel_mesh_block blocks[PEL_MESH_MAX_BLOCKS];
    int vertex_count;
};

/* Lays out rings and blocks for a camera. Radius of the Earth as in
 * optics/atmosphere.h. `like`: a mesh that perhaps has the same rings, which
 * take longest, then they are copied; NULL: none; also `out` itself, planned
 * before or zeroed. */
void pel_mesh_plan(const struct pel_mesh_eye *eye,
                   const struct pel_camera *camera, const struct pel_mesh *like,
                   struct pel_mesh *out);

/* Removes from a planned mesh what a part of the same camera's picture cannot
 * see; rings and columns do not change. */
void pel_mesh_narrow(const struct pel_mesh_eye *eye,
                     const struct pel_camera *part, struct pel_mesh *mesh);
