/* Views of objects from the eye's image in the sea: what its facets mirror.
 * Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "render/renderer.h"

#define PEL_OBJECT_MIRRORS 4

/* Zeroed before its first use. */
struct pel_mirrors {
    GLuint raster[2], program, mips_program; /* the second leaves out holes */
    GLuint radiance, away, fbos[PEL_OBJECT_MIRRORS];
    GLuint numbers, depth, numbers_fbo; /* of the view being drawn */
    int views;                        /* as far as any was drawn since begin */
    double parts[PEL_OBJECT_MIRRORS]; /* of each that may not be empty; 0: of
                                         a new one, all */
    double part;                      /* the largest of these since begin */
};

/* Of one object: texels 8 to 11 of its place (lib/mirrored.glsl). */
struct pel_mirror_view {
    struct pel_vec3 forward, across, upward;
    double image_m;                 /* of the eye, above it */
    double middle_m;                /* to the points' middle */
    double left, low, per_x, per_y; /* tangents, texture's places a tangent */
    double part;                    /* of the texture, in both directions */
};

PEL_CHECK enum pel_err pel_mirrors_need(struct pel_mirrors *m,
                                        const char *shader_dir, bool textured,
                                        bool holed, const char *light,
                                        struct pel_fault *fault);
/* The next need makes another. */
void pel_mirrors_forget_program(struct pel_mirrors *m);
void pel_mirrors_finish(struct pel_mirrors *m);

/* The view that holds these points, from the eye, the sea's mean level at them
 * sea_m above it; `px`: how large the object looks. False: there is none, the
 * eye's image is too close. Any thread. */
bool pel_mirror_look(const struct pel_vec3 *points, int count, double sea_m,
                     double px, struct pel_mirror_view *out);

/* Draws layer after layer: begin, then `draw` once for each, then end. A view
 * is rasterised to numbers of triangles, then shaded, each texel once. */
void pel_mirrors_begin(struct pel_mirrors *m);
void pel_mirrors_draw(struct pel_mirrors *m, int layer, double part, bool holed,
                      void (*draw)(const void *user, int i), const void *user,
                      int i);
void pel_mirrors_end(struct pel_mirrors *m);
