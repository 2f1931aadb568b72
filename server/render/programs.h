/* The programs that draw a picture, made when one first needs them. Render
 * thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>

#include "ocean/sea.h"
#include "render/shader.h"

#define PEL_FAR_WAVES 20 /* far pixels resolve no more than these */

/* What draws one kind of sea; [1] of a pair also writes the layers. */
struct pel_sea_programs {
    GLuint mesh;
    GLuint near[2];    /* fragments, all waves */
    GLuint far[2];     /* fragments, PEL_FAR_WAVES of them */
    GLuint compute[2]; /* sky, sea and colour in one dispatch */
};

struct pel_programs {
    const char *shader_dir;
    bool software;
    bool compute; /* shade in one dispatch instead of three */
    bool settled; /* a picture has been drawn */
    int waves;    /* what the trochoids' programs are made for */
    GLuint surface, tone;
    GLuint backdrop[2]; /* without, with layers */
    struct pel_sea_programs trochoids, cascades;
};

/* `shading` as in pel_renderer_options. GPU when one does not compile. */
PEL_CHECK enum pel_err pel_programs_init(struct pel_programs *p,
                                         const char *shader_dir, bool software,
                                         const char *shading,
                                         struct pel_fault *fault);
void pel_programs_finish(struct pel_programs *p);

/* Makes the programs that this sea wants for a picture with or without
 * layers. */
PEL_CHECK enum pel_err pel_programs_need(struct pel_programs *p,
                                         const struct pel_sea *sea, bool layers,
                                         struct pel_fault *fault);
