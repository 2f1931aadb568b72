/* The mesh of the sea around an eye: rings about its nadir, columns of equal
 * azimuth. Rings and columns depend on the eye, the sea and the pixel's angle
 * only; a view chooses which of them it draws. Pure computation, no GL.
 *
 * It replaces the paper's screen-space grid: cells are as large on the
 * screen (cell_px pixels on calm water), but they do not turn with the camera,
 * reach under and behind it, and stay fine enough for waves that a grazing
 * screen cell would drop. */
#pragma once

#include <stddef.h>

#include "ocean/sea.h"
#include "scene/snapshot.h"
#include "shaders/lib/blocks.h"

#define PEL_MESH_MAX_RINGS 4096
#define PEL_MESH_MAX_VERTICES 1000000

/* Root mean square height of the waves shorter than a wavelength, tabulated:
 * wavelengths in equal steps of their logarithm. Made once for a sea. */
#define PEL_MESH_HEIGHTS 96
struct pel_mesh_heights {
    double wavelength_m[PEL_MESH_HEIGHTS], rms_m[PEL_MESH_HEIGHTS];
};
void pel_mesh_heights(const struct pel_sea *sea, struct pel_mesh_heights *out);

/* What rings depend on. */
struct pel_mesh_eye {
    double height_m; /* of the eye above mean sea level, > 0 */
    double pixel;    /* tangent of one pixel on the axis */
    double cell_px;  /* side of a cell on calm water, pixels */
    double n_max;    /* the filter's upper bound, wavelengths per cell */
    const struct pel_sea *sea;
    const struct pel_mesh_heights *heights; /* of this sea */
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

struct pel_mesh {
    int columns_around; /* columns in a full circle */
    double column_rad;
    int ring_count;
    struct pel_mesh_ring rings[PEL_MESH_MAX_RINGS];
    int block_count;
    struct pel_mesh_block blocks[PEL_MESH_MAX_BLOCKS];
    int vertex_count;
};

/* Lays out rings and blocks for a camera. Radius of the Earth as in
 * optics/atmosphere.h. */
void pel_mesh_plan(const struct pel_mesh_eye *eye,
                   const struct pel_camera *camera, struct pel_mesh *out);

/* Removes from a planned mesh what a part of the same camera's picture cannot
 * see; rings and columns do not change. */
void pel_mesh_narrow(const struct pel_mesh_eye *eye,
                     const struct pel_camera *part, struct pel_mesh *mesh);
