/* Coarser levels of a mesh by collapsing edges. */
#pragma once

#include "models/shape.h"

struct pel_decimate_mesh {
    const struct pel_model_vertex *vertices;
    size_t vertex_count, triangle_count;
    uint32_t *indices;          /* changed in place */
    struct pel_shape_tag *tags; /* one a triangle, likewise */
};

/* A mesh that is being collapsed, edge by edge, each time the one whose
 * collapse moves the surface least. Vertices stay where they are, each is one
 * of the original's; borders of open meshes stay borders;
 * closed bodies stay closed; small bodies vanish whole. NULL: no memory. */
struct pel_decimate;
struct pel_decimate *pel_decimate_begin(const struct pel_decimate_mesh *mesh);

/* Goes on until at most `triangles` are left or nothing can go; writes the
 * rest into the mesh's arrays (whose room must be that of the original) and
 * their number into *out; into *least_m what its error is at least: the
 * size of the largest body that has vanished, the most that a line between
 * colours has moved at once. False: no memory. */
bool pel_decimate_to(struct pel_decimate *d, size_t triangles,
                     struct pel_decimate_mesh *out, double *least_m);
void pel_decimate_end(struct pel_decimate *d); /* NULL allowed */
