/* The mesh on the device: its vertices displaced, its strips drawn, by the
 * program in use. Render thread only. */
#pragma once

#include "render/mesh.h"

/* All blocks in one dispatch of mesh.comp. */
void pel_mesh_displace(const struct pel_mesh *mesh);

/* The nearest of so many triangles at each pixel, of each view a layer, by
 * search.comp. The caller waits for what it writes. */
void pel_mesh_search(int triangles, unsigned views);

/* An instance a strip, by surface.vert. */
void pel_mesh_draw(const struct pel_mesh *mesh);
