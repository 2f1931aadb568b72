/* Antialiasing of outlines, after a picture's pixels show what their middles
 * see: shaders/outline_find.comp lists pixels whose neighbours see triangles
 * that are apart, shaders/outline.comp those of them that an outline cuts, with
 * the parts on either side, and shaders/outline_mix.comp mixes the light that
 * they and their neighbours were given. Render thread. */
#pragma once

#include "render/mesh.h"
#include "render/pass.h"
#include "render/targets.h"

/* Pixels beyond each edge of a picture whose triangles its outlines need. */
#define PEL_EDGES_MARGIN 1

/* The camera that sees `margin` more pixels at each edge. */
struct pel_camera pel_edges_camera(const struct pel_camera *c, int margin);

/* Tells the program in use the blocks of the mesh, at these locations. */
void pel_edges_tell_blocks(const struct pel_mesh *mesh, GLint count,
                           GLint blocks, GLint bases);

/* Whether neighbours to the left and right may be those that lie above and
 * below in some pixel of the camera's picture. */
bool pel_edges_sideways(const struct pel_camera *c);

/* From which numbers on which difference between those of triangles may mean
 * that PEL_OUTLINE_HIDDEN rings lie between theirs: two for each column of all
 * of them but one, which the two may share in. */
void pel_edges_apart(const struct pel_mesh *mesh,
                     GLuint apart[PEL_OUTLINE_BLOCKS][2]);

/* Lists the pixels of a region, from two corners, that outlines cut, by the
 * triangles of its picture. */
void pel_edges_list(const struct pel_programs *p, const struct pel_targets *t,
                    const struct pel_mesh *mesh, bool sideways,
                    const GLint region[4]);

/* Mixes their light in every layer of light that a picture of these layers
 * stores, and in the colour where that is `toned`. */
void pel_edges_mix(const struct pel_programs *p, const struct pel_targets *t,
                   unsigned asked, bool toned);
