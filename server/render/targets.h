/* What a picture is drawn into. Pictures are drawn into one corner of targets
 * that grow as they must, and start anew when many pictures in a row left most
 * of them unused. Render thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stdint.h>

#include "render/readback.h"

/* Zeroed before its first use. */
struct pel_targets {
    uint32_t width, height;
    unsigned small_draws;
    GLuint triangles, depth_test, color;
    GLuint keys; /* buffer of shaders/search.comp; 0 between pictures */
    GLuint hdr[PEL_HDR_ATTACHMENTS]; /* radiance first; others when wanted */
    GLuint surface_fbo;              /* triangle numbers and depth test */
    GLuint light_fbo;  /* radiance, tested against the surface's depth */
    GLuint layers_fbo; /* all of hdr, likewise */
    GLuint parts[PEL_WATER_PARTS], parts_fbo; /* of the water's light */
    GLuint color_fbo;
};

/* Formats of hdr, in the order of the shaders' outputs. */
extern const GLenum pel_hdr_formats[PEL_HDR_ATTACHMENTS];

/* Makes room for a picture; `layers` also for what is more than radiance,
 * `parts` for the water's light taken apart. */
void pel_targets_fit(struct pel_targets *t, uint32_t width, uint32_t height,
                     bool layers, bool parts);
void pel_targets_finish(struct pel_targets *t);
