/* The textures and framebuffers that pictures are drawn into. A picture uses
 * one corner of them; they grow when needed, and are made anew, smaller, after
 * many pictures in a row that used little of them. Render thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stdint.h>

#include "render/pass.h"

/* Zeroed before its first use. */
struct pel_targets {
    uint32_t width, height;
    unsigned small_draws;
    GLuint triangles, depth_test, color;
    GLuint keys; /* buffer of shaders/search.comp; 0 between pictures */
    GLuint suspects, edges; /* buffers of shaders/outline*.comp; the first also
                               holds mixed light */
    /* Of layers, by PEL_AT_*: the radiance, others when first asked for. */
    GLuint planes[PEL_LAYERS];
    GLuint surface_fbo; /* triangle numbers and depth test */
    GLuint light_fbo;   /* radiance, tested against the surface's depth */
    GLuint layers_fbo;  /* that and the layers of a pass, likewise */
    GLuint color_fbo;
    GLuint both_fbo; /* radiance and colour */
};

/* Of a layer's texture, by PEL_AT_*. */
GLenum pel_plane_format(int layer);

/* Makes room for a picture of these layers (of enum pel_layer). */
void pel_targets_fit(struct pel_targets *t, uint32_t width, uint32_t height,
                     unsigned asked);

/* The framebuffer that a pass of fragments draws into. */
GLuint pel_targets_attach(struct pel_targets *t, const struct pel_pass *pass);

void pel_targets_finish(struct pel_targets *t);
/* Gives large ones back. */
void pel_targets_rest(struct pel_targets *t);
