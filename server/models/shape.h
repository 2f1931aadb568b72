/* A shape in the making: triangles corner by corner, then a model of them.
 * What makes shapes (builtin.c, reader/) fills one of these. One thread each.
 *
 * Without memory a shape remembers it, ignores what follows, and
 * pel_shape_finish says so. */
#pragma once

#include "models/model.h"

struct pel_shape {
    char name[PEL_MODEL_NAME];
    enum pel_model_class class;
    /* Three corners a triangle; a normal of length 0 is made from the
     * triangles around. */
    size_t triangle_count;
    struct pel_model_vertex *corners;
    struct pel_shape_tag {
        uint16_t material, node;
    } * tags; /* one a triangle */
    size_t material_count, node_count, texture_count;
    struct pel_model_material *materials;
    char (*nodes)[PEL_MODEL_NAME];
    struct pel_model_texture *textures; /* whose pixels are the caller's */
    size_t eye_count, light_count;
    struct pel_model_eye eyes[PEL_MODEL_MOST_EYES];
    struct pel_model_light lights[PEL_MODEL_MOST_LIGHTS];
    /* 0: from the triangles. */
    double length_m, beam_m, draught_m, height_m;
    size_t room[4]; /* allocated of triangles, materials, nodes, textures */
    bool failed;    /* out of memory */
};

/* Index of the material equal to *m, added if there is none. */
int pel_shape_material(struct pel_shape *s, const struct pel_model_material *m);
/* Index of a new node; a long name is cut between characters of UTF-8. */
int pel_shape_node(struct pel_shape *s, const char *name);
int pel_shape_texture(struct pel_shape *s, const struct pel_model_texture *t);
void pel_shape_triangle(struct pel_shape *s,
                        const struct pel_model_vertex corners[3], int material,
                        int node);
void pel_shape_clear(struct pel_shape *s); /* frees what it holds */

/* A model as arrays of its own on the heap, before it is checked: levels,
 * vertices, parts; bvh, columns, box and sizes are not set. */
struct pel_model_draft {
    struct pel_model model; /* its pointers are the draft's */
    void *owned[8];
};
void pel_model_draft_clear(struct pel_model_draft *draft);

/* Normals (smooth across edges of less than 40 degrees), vertices without
 * doubles, parts by material and then node, levels of detail. Triangles
 * without an area are left out. INVALID (no triangles), OUT_OF_RANGE (more
 * than the limits of model.h), NO_MEMORY. */
PEL_CHECK enum pel_err pel_shape_finish(const struct pel_shape *s,
                                        struct pel_model_draft *out,
                                        struct pel_fault *fault);

/* A model from a draft, which it copies, after every number in it has been
 * checked: what the draft came from need not be trusted. Sizes of 0 are taken
 * from the triangles. MALFORMED, OUT_OF_RANGE, NO_MEMORY. */
PEL_CHECK enum pel_err pel_model_create(const struct pel_model *draft,
                                        const struct pel_model **out,
                                        struct pel_fault *fault);
