#include "render/modelpool.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render/hullmap.h"
#include "render/modelpaint.h"

enum { VERTICES, TRIANGLES, MATERIALS, BUFFERS };

static const GLuint units[BUFFERS] = { PEL_UNIT_OBJECT_VERTICES,
                                       PEL_UNIT_OBJECT_TRIANGLES,
                                       PEL_UNIT_OBJECT_MATERIALS };

/* --- a model's texels ----------------------------------------------------- */

/* Its place on an octahedron (Meyer et al. 2010). */
static void octahedral(const float n[3], float out[2])
{
    float sum = fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2]);
    float x = n[0] / fmaxf(sum, 1e-12f), y = n[1] / fmaxf(sum, 1e-12f);
    out[0] = n[2] >= 0 ? x : copysignf(1 - fabsf(y), x);
    out[1] = n[2] >= 0 ? y : copysignf(1 - fabsf(x), y);
}

/* Four bytes as a float's, whose exponent is that of a normal number: of the
 * last, which is least, 1 to 126 of 127 steps (lib/objects.glsl: openness). */
static float packed(const struct pel_model_open *o)
{
    uint32_t bits = o->above | (uint32_t)o->below << 8 |
                    (uint32_t)o->own_above << 16 |
                    (uint32_t)(1 + o->own_below * 125 / 255) << 24;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void write_vertices(const struct pel_model *m, float *out)
{
    static const struct pel_model_open all = { 255, 255, 0, 0 };
    for (size_t i = 0; i < m->vertex_count; i++) {
        const struct pel_model_vertex *v = &m->vertices[i];
        memcpy(out, v->position, sizeof v->position);
        out[3] = packed(m->open ? &m->open[i] : &all);
        octahedral(v->normal, out + 4);
        out[6] = v->uv[0];
        out[7] = v->uv[1];
        out += 4 * PEL_OBJECT_VERTEX_TEXELS;
    }
}

/* Three corners and a material each, behind all of them the paint; returns
 * their number. */
static uint32_t write_level(const struct pel_pool_model *p, int level,
                            uint32_t *out)
{
    const struct pel_model_level *l = &p->model->levels[level];
    uint32_t count = 0;
    for (size_t i = 0; i < l->part_count; i++) {
        const struct pel_model_part *part = &l->parts[i];
        const uint32_t *from = &p->model->indices[part->first];
        for (uint32_t k = 0; k + 2 < part->count; k += 3, count++) {
            for (int j = 0; j < 3; j++) {
                *out++ = p->first_vertex + from[k + (uint32_t)j];
            }
            *out++ = p->first_material + part->material;
        }
    }
    return count;
}

static size_t triangles_of(const struct pel_model *m)
{
    size_t count = 0;
    for (int i = 0; i < m->level_count; i++) {
        for (size_t k = 0; k < m->levels[i].part_count; k++) {
            count += m->levels[i].parts[k].count / 3;
        }
    }
    return count;
}

static bool is_one_sided(const struct pel_model *m)
{
    bool two_sided = false;
    for (size_t i = 0; i < m->material_count; i++) {
        two_sided = two_sided || m->materials[i].two_sided;
    }
    return !two_sided;
}

static void write_materials(const struct pel_model *m, float *out)
{
    for (size_t i = 0; i < m->material_count; i++) {
        const struct pel_model_material *from = &m->materials[i];
        pel_model_reflectance(from->albedo, out);
        out[3] = from->metallic;
        out[4] = from->roughness;
        out[5] = from->two_sided;
        out[6] = out[7] = 0;
        out += 4 * PEL_OBJECT_MATERIAL_TEXELS;
    }
}

/* --- the buffers -----------------------------------------------------------
 */

int pel_model_pool_find(const struct pel_model_pool *pool,
                        const struct pel_model *model)
{
    for (size_t i = 0; i < pool->count; i++) {
        if (pool->models[i].model == model) {
            return (int)i;
        }
    }
    return -1;
}

static void free_buffers(struct pel_model_pool *pool)
{
    glDeleteTextures(BUFFERS, pool->texels);
    glDeleteBuffers(BUFFERS, pool->buffers);
    glDeleteTextures(1, &pool->hulls);
    memset(pool->texels, 0, sizeof pool->texels);
    memset(pool->buffers, 0, sizeof pool->buffers);
    pool->hulls = 0;
}

static void *map_buffer(struct pel_model_pool *pool, int which, GLenum format,
                        size_t texels)
{
    static const char *const labels[BUFFERS] = { "model vertices",
                                                 "model triangles",
                                                 "model materials" };
    GLsizeiptr size = (GLsizeiptr)(texels ? texels : 1) * 16;
    glCreateBuffers(1, &pool->buffers[which]);
    glNamedBufferStorage(pool->buffers[which], size, NULL, GL_MAP_WRITE_BIT);
    glObjectLabel(GL_BUFFER, pool->buffers[which], -1, labels[which]);
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &pool->texels[which]);
    glTextureBuffer(pool->texels[which], format, pool->buffers[which]);
    return glMapNamedBufferRange(pool->buffers[which], 0, size,
                                 GL_MAP_WRITE_BIT);
}

/* By area, of the triangles that lie under the waterline. */
static void mean_paint(const struct pel_model *m, float out[3])
{
    double sum[3] = { 0 }, all = 0;
    const struct pel_model_level *level = &m->levels[0];
    for (size_t i = 0; i < level->part_count; i++) {
        const struct pel_model_part *part = &level->parts[i];
        float albedo[3];
        pel_model_reflectance(m->materials[part->material].albedo, albedo);
        for (uint32_t k = part->first; k + 2 < part->first + part->count;
             k += 3) {
            const float *p[3];
            for (int j = 0; j < 3; j++) {
                p[j] = m->vertices[m->indices[k + (uint32_t)j]].position;
            }
            if (p[0][2] + p[1][2] + p[2][2] >= 0) {
                continue;
            }
            struct pel_vec3 a = { p[1][0] - p[0][0], p[1][1] - p[0][1],
                                  p[1][2] - p[0][2] };
            struct pel_vec3 b = { p[2][0] - p[0][0], p[2][1] - p[0][1],
                                  p[2][2] - p[0][2] };
            struct pel_vec3 c = pel_vec3_cross(a, b);
            double area = sqrt(pel_vec3_dot(c, c));
            all += area;
            for (int j = 0; j < 3; j++) {
                sum[j] += area * (double)albedo[j];
            }
        }
    }
    for (int j = 0; j < 3; j++) {
        out[j] = (float)(all > 0 ? sum[j] / all : 0);
    }
}

static bool fill_hulls(struct pel_model_pool *pool)
{
    void (*const maps[])(const struct pel_model *,
                         float *) = { pel_hull_below, pel_hull_sides };
    float *texels = malloc(sizeof *texels * PEL_HULL_LENGTH * PEL_HULL_BREADTH);
    if (!texels) {
        return false;
    }
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &pool->hulls);
    glTextureStorage3D(pool->hulls, 1, GL_R32F, PEL_HULL_LENGTH,
                       PEL_HULL_BREADTH, 2 * (GLsizei)pool->count);
    glTextureParameteri(pool->hulls, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(pool->hulls, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTextureParameteri(pool->hulls, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(pool->hulls, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, pool->hulls, -1, "hulls");
    for (size_t i = 0; i < 2 * pool->count; i++) {
        maps[i / pool->count](pool->models[i % pool->count].model, texels);
        glTextureSubImage3D(pool->hulls, 0, 0, 0, (GLint)i, PEL_HULL_LENGTH,
                            PEL_HULL_BREADTH, 1, GL_RED, GL_FLOAT, texels);
    }
    free(texels);
    return true;
}

/* Buffers for the models of the list. */
static bool fill(struct pel_model_pool *pool)
{
    size_t vertices = 0, triangles = 0, materials = 0, paint = 0;
    for (size_t i = 0; i < pool->count; i++) {
        const struct pel_model *m = pool->models[i].model;
        vertices += m->vertex_count;
        triangles += triangles_of(m);
        materials += m->material_count;
        paint += pel_model_paint_size(m);
    }
    pool->textured = paint > 0;
    float *v = map_buffer(pool, VERTICES, GL_RGBA32F,
                          vertices * PEL_OBJECT_VERTEX_TEXELS);
    uint32_t *t = map_buffer(pool, TRIANGLES, GL_RGBA32UI, triangles + paint);
    float *w = map_buffer(pool, MATERIALS, GL_RGBA32F,
                          materials * PEL_OBJECT_MATERIAL_TEXELS);
    bool there = v && t && w;
    uint32_t vertex = 0, triangle = 0, material = 0;
    uint32_t painted = (uint32_t)triangles;
    for (size_t i = 0; i < pool->count && there; i++) {
        struct pel_pool_model *p = &pool->models[i];
        const struct pel_model *m = p->model;
        p->first_vertex = vertex;
        p->first_material = material;
        p->one_sided = is_one_sided(m);
        p->holed = pel_model_has_holes(m);
        pool->holed = pool->holed || p->holed;
        write_vertices(m, v + 4 * PEL_OBJECT_VERTEX_TEXELS * (size_t)vertex);
        write_materials(m,
                        w + 4 * PEL_OBJECT_MATERIAL_TEXELS * (size_t)material);
        there = pel_model_paint_write(m, painted, t + 4 * (size_t)painted,
                                      w + 4 * PEL_OBJECT_MATERIAL_TEXELS *
                                              (size_t)material);
        painted += (uint32_t)pel_model_paint_size(m);
        for (int k = 0; k < m->level_count; k++) {
            p->first_triangle[k] = triangle;
            triangle += write_level(p, k, t + 4 * (size_t)triangle);
        }
        vertex += (uint32_t)m->vertex_count;
        material += (uint32_t)m->material_count;
        mean_paint(m, p->paint);
        p->plan[0] = (float)m->low.x;
        p->plan[1] = (float)m->low.y;
        p->plan[2] = (float)(1 / fmax(m->high.x - m->low.x, 1e-6));
        p->plan[3] = (float)(1 / fmax(m->high.y - m->low.y, 1e-6));
    }
    for (int i = 0; i < BUFFERS; i++) {
        there = glUnmapNamedBuffer(pool->buffers[i]) && there;
    }
    return there && fill_hulls(pool);
}

static void forget(struct pel_model_pool *pool)
{
    free_buffers(pool);
    for (size_t i = 0; i < pool->count; i++) {
        pel_model_unref(pool->models[i].model);
    }
    free(pool->models);
    pool->models = NULL;
    pool->count = 0;
}

/* The list of the models of `env`, once each. */
static bool list(const struct pel_environment *env, struct pel_model_pool *out)
{
    *out = (struct pel_model_pool){ 0 };
    out->models = calloc(env->object_count, sizeof *out->models);
    for (size_t i = 0; i < env->object_count && out->models; i++) {
        const struct pel_model *m = env->objects[i].model;
        if (pel_model_pool_find(out, m) < 0) {
            out->models[out->count++].model = pel_model_ref(m);
        }
    }
    return out->models != NULL;
}

enum pel_err pel_model_pool_fit(struct pel_model_pool *pool,
                                const struct pel_environment *env,
                                struct pel_fault *fault)
{
    bool all = true;
    for (size_t i = 0; i < env->object_count; i++) {
        all = all && pel_model_pool_find(pool, env->objects[i].model) >= 0;
    }
    if (all) {
        return PEL_OK;
    }
    struct pel_model_pool next;
    bool made = list(env, &next) && fill(&next);
    if (!made) {
        forget(&next);
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY,
                             "no memory for the models in a picture");
    }
    forget(pool);
    *pool = next;
    return PEL_OK;
}

void pel_model_pool_bind(const struct pel_model_pool *pool)
{
    for (int i = 0; i < BUFFERS; i++) {
        glBindTextureUnit(units[i], pool->texels[i]);
    }
    glBindTextureUnit(PEL_UNIT_OBJECT_HULLS, pool->hulls);
}

void pel_model_pool_finish(struct pel_model_pool *pool)
{
    forget(pool);
    *pool = (struct pel_model_pool){ 0 };
}
