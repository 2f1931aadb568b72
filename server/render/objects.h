/* Entities that have a model, drawn. Their triangles are rasterised into a
 * picture of numbers (entity, triangle) after the sea: the nearest that is not
 * behind the sea, or that stands behind sea in its own hull. Shading cuts the
 * triangle by the pixel's ray again, as it does the sea's. Render thread only.
 *
 * Nothing here costs anything as long as no picture shows an object: textures
 * and programs are made for the first that does. */
#pragma once

#include <epoxy/gl.h>

#include "render/arena.h"
#include "render/mirror.h"
#include "render/modelpool.h"
#include "render/programs.h"
#include "render/renderer.h"
#include "render/samples.h"
#include "render/sky.h"

#define PEL_OBJECT_SHADOWS 8

struct pel_object_place {
    struct pel_vec4 texels[PEL_OBJECT_PLACE_TEXELS];
};

/* An entity that a picture may show, or whose mirror image or shadow. Those
 * that look largest from the eye have a rank, which is the layer of their
 * shadow, and of the first ones of their mirrored view. */
struct pel_object_drawn {
    int object, model, level; /* in the environment, the pool, the model */
    int mirror_level, shadow_level; /* of detail, of its other views */
    int slot;  /* of its place: the rank, or one behind them */
    bool seen; /* itself */
    bool shades;
    int shadow_px; /* its side */
    bool mirrored;
    struct pel_mirror_view image;
    float in_mirror[4], in_shade[4], in_water[4]; /* pixels of the lattice with
                                                  either, or the hull */
    float taper[3]; /* of the first (objectplan.c) */
};

/* Zeroed before its first use. */
struct pel_objects {
    struct pel_model_pool pool;
    GLuint places;                /* texels of entities */
    GLuint surroundings, ambient; /* map; buffer of their light by normal */
    double light_key[PEL_SKY_LIGHT_KEYS];
    bool light_made;
    GLuint surroundings_program, ambient_program;
    enum pel_programs_light light; /* that its programs are for */
    bool lamps;                    /* likewise */
    /* The sea from a texture, from keys; the second leaves out holes. */
    GLuint raster[2], raster_keys[2];
    /* As fragments: what middles show, light of samples; without land that
     * may hide them, in seas of either kind. */
    GLuint shade[2][3][PEL_SHADE_COUNT];
    struct pel_samples samples;
    struct pel_mirrors mirrors;
    GLuint shadow_program[2], shadows, shadow_fbos[PEL_OBJECT_SHADOWS];
    uint32_t width, height;
    GLuint seen, depth, fbo;
    /* Of the picture being drawn. */
    int drawn_count;
    struct pel_object_drawn drawn[PEL_MAX_ENTITIES];
    struct pel_object_place near[PEL_OBJECT_SHADOWS]; /* by rank */
};

void pel_objects_finish(struct pel_objects *o);

/* Brings the buffers to hold every model of `env`; *programs learn whether
 * these are textured. NO_MEMORY with a fault. */
PEL_CHECK enum pel_err pel_objects_fit(struct pel_objects *o,
                                       const struct pel_environment *env,
                                       struct pel_programs *programs,
                                       struct pel_fault *fault);

/* Makes the programs that draw this kind of picture. GPU with a fault. */
PEL_CHECK enum pel_err pel_objects_need(struct pel_objects *o,
                                        const struct pel_environment *env,
                                        const struct pel_programs *programs,
                                        enum pel_shading kind,
                                        struct pel_fault *fault);

/* What shades the objects of a tile as fragments: the light of their samples,
 * or what pixels' middles show; `fft`: in a sea of cascades. */
GLuint pel_objects_program(const struct pel_objects *o, bool sampled,
                           unsigned tile, enum pel_shading kind, bool fft);

/* Tells the program in use what objects do to the sea of a tile; `one`: it is
 * one for a tile near one object alone. */
void pel_objects_use(const struct pel_objects *o, unsigned tile, bool one);

/* Room in the arena for the objects of a picture. */
size_t pel_objects_bytes(const struct pel_environment *env);

/* Triangles of all that is in sight, by a program like object.vert's, into what
 * is bound. */
void pel_objects_draw(const struct pel_objects *o,
                      const struct pel_block_view *view, GLuint program);

/* What of `env` the picture of this camera may show, its altitude above the
 * sea's zero; `through`: also what is seen elsewhere, through the surface;
 * marks its tiles (render/tiles.h). False: from here nothing can be
 * seen in any direction, so that pictures of one lattice agree. */
bool pel_objects_plan(struct pel_objects *o, const struct pel_environment *env,
                      const struct pel_camera *camera, bool through,
                      uint32_t *tiles);

/* The light that surrounds objects: `sky` is up to date. */
void pel_objects_light(struct pel_objects *o, const struct pel_sky *sky);

/* Rasterises what was planned over the sea's triangles (of targets.triangles,
 * bound to its unit, or the keys), and binds what shading reads. Blocks `eye`
 * and `view` are bound, *view is the latter; the camera is the whole picture's.
 * `box`: pixels of the picture being drawn that may show any; `middles`: what
 * the middles of pixels show is asked for. Leaves the viewport changed. */
void pel_objects_raster(struct pel_objects *o,
                        const struct pel_environment *env,
                        const struct pel_camera *camera,
                        const struct pel_block_view *view, const GLint box[4],
                        struct pel_arena *arena, bool keys, bool middles);
