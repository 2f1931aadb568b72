/* The models that pictures show, in buffers that the shaders read: triangles of
 * every level of detail, vertices, materials, textures, hulls seen from below
 * and from the sides. Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "models/model.h"
#include "render/renderer.h"

/* A model's place in the buffers. */
struct pel_pool_model {
    const struct pel_model *model; /* a reference */
    uint32_t first_vertex, first_material;
    uint32_t first_triangle[PEL_MODEL_LEVELS];
    float plan[4];  /* of its hull's texels: xy least, m; zw 1 / extent, 1/m */
    float paint[3]; /* mean albedo of its hull under the waterline */
    bool holed;     /* some material is alpha-tested */
    bool one_sided; /* all its triangles: their backs are not drawn */
};

/* Zeroed before its first use. */
struct pel_model_pool {
    struct pel_pool_model *models; /* layer by layer of the hulls */
    size_t count;
    GLuint buffers[3], texels[3]; /* vertices, triangles, materials */
    GLuint hulls;  /* from below; then, as many layers on, from the sides */
    bool textured; /* some material is */
    bool holed;
};

/* Brings the buffers to hold every model of `env`. NO_MEMORY with a fault. */
PEL_CHECK enum pel_err pel_model_pool_fit(struct pel_model_pool *pool,
                                          const struct pel_environment *env,
                                          struct pel_fault *fault);
void pel_model_pool_bind(const struct pel_model_pool *pool);
void pel_model_pool_finish(struct pel_model_pool *pool);

/* Index of the model; -1: it is not there. */
int pel_model_pool_find(const struct pel_model_pool *pool,
                        const struct pel_model *model);
