#include "render/edges.h"

#include <math.h>
#include <string.h>

struct pel_camera pel_edges_camera(const struct pel_camera *c, int margin)
{
    struct pel_camera wide = *c;
    double across = (c->tan_right - c->tan_left) / c->width * margin;
    double down = (c->tan_top - c->tan_bottom) / c->height * margin;
    wide.tan_left -= across;
    wide.tan_right += across;
    wide.tan_top += down;
    wide.tan_bottom -= down;
    wide.width += 2 * (uint32_t)margin;
    wide.height += 2 * (uint32_t)margin;
    return margin ? wide : *c;
}

void pel_edges_tell_blocks(const struct pel_mesh *mesh, GLint count,
                           GLint blocks, GLint bases)
{
    GLint block[PEL_MESH_MAX_BLOCKS][4], base[PEL_MESH_MAX_BLOCKS];
    for (int i = 0; i < mesh->block_count; i++) {
        const struct pel_mesh_block *b = &mesh->blocks[i];
        const GLint one[4] = { b->first_ring, b->rings, b->first_column,
                               b->columns };
        memcpy(block[i], one, sizeof one);
        base[i] = b->base;
    }
    glUniform1i(count, mesh->block_count);
    if (mesh->block_count > 0) {
        glUniform4iv(blocks, mesh->block_count, block[0]);
        glUniform1iv(bases, mesh->block_count, base);
    }
}

/* An empty list, bound to be written and to be dispatched by. */
static void begin_list(GLuint list, GLuint binding)
{
    static const GLuint none[4] = { 0, 1, 1, 0 };
    glNamedBufferSubData(list, 0, sizeof none, none);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, list);
}

static void dispatch_by(GLuint list)
{
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT |
                    GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, list);
    glDispatchComputeIndirect(0);
}

void pel_edges_apart(const struct pel_mesh *mesh,
                     GLuint apart[PEL_OUTLINE_BLOCKS][2])
{
    int count = mesh->block_count, around = 0;
    while (around < count &&
           mesh->blocks[around].columns > mesh->columns_around) {
        around++;
    }
    around = around && around < count ? around + 1 : around;
    int first = 0;
    for (int i = 0; i < PEL_OUTLINE_BLOCKS; i++) {
        int end = i ? around + (count - around) * i / (PEL_OUTLINE_BLOCKS - 1)
                    : around;
        int least = 1 << 20;
        for (int b = first; b < end; b++) {
            int columns = mesh->blocks[b].columns;
            least = columns < least ? columns : least;
        }
        apart[i][0] =
            first < count ? (GLuint)(2 * mesh->blocks[first].base) : ~0U;
        apart[i][1] = (GLuint)(2 * (PEL_OUTLINE_HIDDEN - 1) * least);
        first = end;
    }
}

/* The rise of lines of sight from pixel to pixel, as shaders/lib/outline.glsl
 * has it; half as much is enough here. */
bool pel_edges_sideways(const struct pel_camera *c)
{
    const struct pel_mat3 *m = &c->world_from_camera;
    const int steps = 8;
    for (int i = 0; i <= steps * steps + 2 * steps; i++) {
        double x = (double)(i % (steps + 1)) / steps,
               y = (double)(i / (steps + 1)) / steps;
        const struct pel_vec3 at = {
            c->tan_left + x * (c->tan_right - c->tan_left),
            c->tan_bottom + y * (c->tan_top - c->tan_bottom), -1.0
        };
        struct pel_vec3 ray = pel_mat3_apply(m, at);
        double far2 = ray.x * ray.x + ray.y * ray.y;
        double across =
            m->x.z - ray.z * (m->x.x * ray.x + m->x.y * ray.y) / far2;
        double up = m->y.z - ray.z * (m->y.x * ray.x + m->y.y * ray.y) / far2;
        if (!(fabs(across) < 0.5 * fabs(up))) {
            return true;
        }
    }
    return false;
}

void pel_edges_list(const struct pel_programs *p, const struct pel_targets *t,
                    const struct pel_mesh *mesh, bool sideways,
                    const GLint region[4])
{
    int wide = region[2] - region[0];
    int down =
        (region[3] - region[1] + PEL_OUTLINE_ROWS - 1) / PEL_OUTLINE_ROWS;
    begin_list(t->suspects, PEL_STORE_SUSPECTS);
    begin_list(t->edges, PEL_STORE_EDGES);
    glBindTextureUnit(PEL_UNIT_TRIANGLES, t->triangles);
    pel_program_use(p->outline_find);
    GLuint apart[PEL_OUTLINE_BLOCKS][2];
    pel_edges_apart(mesh, apart);
    glUniform2uiv(0, PEL_OUTLINE_BLOCKS, apart[0]);
    glUniform4iv(PEL_OUTLINE_BLOCKS, 1, region);
    glUniform1i(PEL_OUTLINE_BLOCKS + 1, sideways);
    glDispatchCompute((GLuint)(wide + PEL_GROUP_LINE - 1) / PEL_GROUP_LINE,
                      (GLuint)down, 1);
    pel_program_use(p->outline);
    pel_edges_tell_blocks(mesh, PEL_UNIFORM_BLOCK_COUNT, PEL_UNIFORM_BLOCKS,
                          PEL_UNIFORM_BASES);
    dispatch_by(t->suspects);
}

void pel_edges_mix(const struct pel_programs *p, const struct pel_targets *t,
                   unsigned asked, bool toned)
{
    const unsigned wanted = pel_layers_of_light() & pel_layers_stored(asked);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_MIXED, t->suspects);
    for (int i = 0; i < PEL_LAYERS; i++) {
        bool radiance = i == PEL_AT_RADIANCE;
        if (!radiance && !(wanted & pel_layer_table[i].bit)) {
            continue;
        }
        glBindImageTexture(PEL_IMAGE_RADIANCE, t->planes[PEL_AT_RADIANCE], 0,
                           GL_FALSE, 0, GL_READ_ONLY, GL_RGBA32F);
        glBindImageTexture(PEL_IMAGE_SLOTS, t->planes[i], 0, GL_FALSE, 0,
                           GL_READ_WRITE, GL_RGBA32F);
        pel_program_use(p->outline_mix);
        dispatch_by(t->edges);
        glBindImageTexture(PEL_IMAGE_COLOR, t->color, 0, GL_FALSE, 0,
                           GL_WRITE_ONLY, GL_RGBA8);
        pel_program_use(p->outline_put[p->lamps]);
        glUniform1i(0, toned && radiance);
        dispatch_by(t->edges);
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    }
}
