#include "render/meshpass.h"

#include <epoxy/gl.h>
#include <string.h>

#include "shaders/lib/blocks.h"

/* Vertices are read in every way after they are written. */
#define VERTEX_BARRIERS                                                        \
    (GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT)

/* Groups that occupy a large device. */
#define SEARCH_GROUPS 1024u

void pel_mesh_displace(const struct pel_mesh *m)
{
    GLint blocks[PEL_MESH_MAX_BLOCKS][4], bases[PEL_MESH_MAX_BLOCKS];
    for (int i = 0; i < m->block_count; i++) {
        const struct pel_mesh_block *b = &m->blocks[i];
        const GLint block[4] = { b->first_ring, b->rings, b->first_column,
                                 b->columns };
        memcpy(blocks[i], block, sizeof block);
        bases[i] = b->base;
    }
    if (m->vertex_count == 0) {
        return;
    }
    glUniform1i(0, m->block_count);
    glUniform4iv(1, m->block_count, blocks[0]);
    glUniform1iv(1 + PEL_MESH_MAX_BLOCKS, m->block_count, bases);
    glDispatchCompute(
        (GLuint)(m->vertex_count + PEL_GROUP_LINE - 1) / PEL_GROUP_LINE, 1, 1);
    glMemoryBarrier(VERTEX_BARRIERS);
}

void pel_mesh_search(int triangles, unsigned views)
{
    /* Seen from high up there are few, of hundreds of rows each. */
    const GLuint groups =
        (GLuint)(triangles + PEL_GROUP_LINE - 1) / PEL_GROUP_LINE;
    const GLuint beside = SEARCH_GROUPS / (groups * views);
    glDispatchCompute(groups, beside < 1 ? 1 : beside, views);
}

void pel_mesh_draw(const struct pel_mesh *m)
{
    for (int i = 0; i < m->block_count; i++) {
        const struct pel_mesh_block *b = &m->blocks[i];
        glUniform4i(0, b->first_ring, b->rings, b->first_column, b->columns);
        glUniform1i(1, b->base);
        glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 2 * b->columns,
                              b->rings - 1);
    }
}
