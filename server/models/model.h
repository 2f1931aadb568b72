/* The shape of a thing on the sea: triangles with materials, levels of detail,
 * where it floats, what can be seen of it. Immutable and reference counted;
 * any thread.
 *
 * Model's frame, right-handed, metres: x to the bow, y to port, z up; the
 * origin is amidships on the centreline in the waterline. In the local frame
 * of a thing with heading h (clockwise from north), no pitch and roll:
 *   east  = origin + x sin h − y cos h
 *   north = origin + x cos h + y sin h,  altitude = origin + z. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "base/vec.h"

/* Limits: what a model may be, and so what the daemon may be made to hold. */
#define PEL_MODEL_MOST_TRIANGLES 500000 /* of the finest level */
#define PEL_MODEL_MOST_VERTICES 1500000
#define PEL_MODEL_MOST_MATERIALS 256
#define PEL_MODEL_MOST_TEXTURES 64
#define PEL_MODEL_MOST_TEXELS 16777216 /* of all its textures together */
#define PEL_MODEL_MOST_SIDE 8192       /* of one texture */
#define PEL_MODEL_MOST_NODES 4096
#define PEL_MODEL_MOST_LIGHTS 64
#define PEL_MODEL_MOST_EYES 16
#define PEL_MODEL_LEVELS 5
#define PEL_MODEL_NAME 64
#define PEL_MODEL_FILE 513 /* of the whole: a built-in's name, or its file */
#define PEL_MODEL_MOST_SIZE_M 1000.0 /* in any direction */

enum pel_model_class {
#define PEL_MODEL_CLASS(id, text) PEL_MODEL_##id,
#include "models/classes.def"
    PEL_MODEL_CLASSES
};

/* As a vertex buffer takes it: 32 bytes. Normals have length 1 and point
 * outward; texture coordinates as OpenGL's, v upward, repeated. */
struct pel_model_vertex {
    float position[3];
    float normal[3];
    float uv[2];
};

/* Of the light that comes to a vertex, by the cosine, from above the horizontal
 * and from below it: the shares that the model's own form lets by, of 255; and
 * the reflectance that the rest meets, times its share of the whole. */
struct pel_model_open {
    uint8_t above, below, own_above, own_below;
};

/* Metal–rough, linear RGB. Nothing emits. */
struct pel_model_material {
    char name[PEL_MODEL_NAME];
    float albedo[3];    /* times the texture's; of metals: reflectance */
    float metallic;     /* 0..1 */
    float roughness;    /* 0.02..1, of perception: its square is GGX's alpha */
    float alpha_cutoff; /* where the texture's alpha is less there is nothing;
                           0: it has no holes */
    bool two_sided;     /* seen from behind too, the normal turned around */
    int texture;        /* index, or -1 */
};

/* RGBA of eight bits, RGB in sRGB, alpha linear; rows from v = 0 upward. */
struct pel_model_texture {
    int width, height;
    const uint8_t *rgba;
};

/* Triangles of one material in one node: `count` indices from `first`. */
struct pel_model_part {
    uint32_t first, count;
    uint16_t material, node;
};

/* One level of detail; 0 is the model itself. All share the vertices. */
struct pel_model_level {
    size_t part_count;
    const struct pel_model_part *parts;
    size_t triangles;
    float error_m; /* the most that a vertex of level 0 is away from it (of
                      4096), or the size of the largest body it lacks */
};

/* An eye point: where a view stands that looks from this thing. */
struct pel_model_eye {
    char name[PEL_MODEL_NAME];
    struct pel_vec3 at;
};

/* A light: it shines from `from_rad` clockwise to `to_rad`, both from the bow,
 * seen from above (equal: all round). Described, not yet drawn. */
struct pel_model_light {
    char name[PEL_MODEL_NAME];
    struct pel_vec3 at;
    float colour[3]; /* linear RGB, the largest 1 */
    float range_m;   /* nominal */
    float from_rad, to_rad;
};

/* A column of the hull under the waterline: what lifts it. The displaced
 * volume is the sum of area · −bottom. */
struct pel_model_column {
    float x, y;   /* its middle */
    float bottom; /* z of the hull's lowest point in it, < 0 */
    float area;   /* m², waterplane */
};

struct pel_model {
    uint64_t serial; /* no two of a process have the same */
    char name[PEL_MODEL_FILE];
    enum pel_model_class class;
    size_t vertex_count, index_count;
    const struct pel_model_vertex *vertices;
    const struct pel_model_open *open; /* of each vertex, or NULL */
    const uint32_t *indices; /* three a triangle, counterclockwise outside */
    size_t material_count, texture_count, node_count;
    const struct pel_model_material *materials;
    const struct pel_model_texture *textures;
    const char (*nodes)[PEL_MODEL_NAME];
    int level_count; /* 1..PEL_MODEL_LEVELS, each coarser than the last */
    struct pel_model_level levels[PEL_MODEL_LEVELS];
    struct pel_vec3 low, high; /* bounding box */
    double radius_m;           /* of the sphere about the origin */
    /* Of the hull: over all in length and beam; below the waterline; from the
     * waterline to the highest point. */
    double length_m, beam_m, draught_m, height_m;
    size_t column_count, eye_count, light_count;
    const struct pel_model_column *columns;
    const struct pel_model_eye *eyes;
    const struct pel_model_light *lights;
    size_t bytes; /* of memory, textures included */
    const struct pel_bvh *bvh;
};

/* Finds what the model's own form hides of its surroundings (openness.h), if
 * that is not known: a tenth of a second or a few. Before any other thread has
 * the model. NO_MEMORY with a fault. */
PEL_CHECK enum pel_err pel_model_shade(const struct pel_model *model,
                                       struct pel_fault *fault);

const struct pel_model *pel_model_ref(const struct pel_model *model);
void pel_model_unref(const struct pel_model *model); /* NULL allowed */

/* "CONTAINER_SHIP", and words for people: "container ship". Never NULL. */
const char *pel_model_class_name(enum pel_model_class class);
const char *pel_model_class_text(enum pel_model_class class);

/* Where a ray meets the model. */
struct pel_model_hit {
    double distance_m; /* along the ray */
    uint32_t triangle; /* of level 0: its indices begin at 3 · triangle */
    uint16_t material, node;
    struct pel_vec3 normal; /* of the triangle, towards the ray's origin */
    bool front;             /* met from outside */
};

/* The nearest triangle that the ray from `origin` along the unit vector
 * `direction` meets within (0, most_m], in the model's frame; false: none.
 * Texels below the alpha cutoff are holes; backs of one-sided triangles are
 * met too, so that a closed body hides what is in it. Watertight: a ray
 * through an edge meets one of its triangles. (Möller and Trumbore 1997 with
 * edge functions evaluated alike for both neighbours: Woop, Benthin, Wald
 * 2013.) Allocates nothing. */
bool pel_model_cast(const struct pel_model *model, struct pel_vec3 origin,
                    struct pel_vec3 direction, double most_m,
                    struct pel_model_hit *hit);

/* The height of the model's highest surface above the place (x, y), and what
 * it is; false: nothing of it stands there. For HAT and HOT. */
bool pel_model_top(const struct pel_model *model, double x, double y,
                   struct pel_model_hit *hit, double *z);

/* The level to draw where a metre at its distance is `pixels_per_m` wide: the
 * coarsest whose error is below `most_px`. */
int pel_model_level_for(const struct pel_model *model, double pixels_per_m,
                        double most_px);
