/* The sea as cascades of inverse FFTs on the GPU: ocean/cascade.h says what is
 * computed. Once a frame, for all its views. Render thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>

#include "ocean/cascade.h"
#include "render/shader.h"

/* Texture units of the fields, as in shaders/lib/cascades.glsl. */
enum {
    PEL_UNIT_DISPLACEMENT = 6,
    PEL_UNIT_SLOPES = 7,
    PEL_UNIT_FOLD = 8,
};

struct pel_wavefield {
    GLuint rows_program, columns_program, mips_program;
    GLuint amplitudes, modes, lines, parameters;
    GLuint displacement, slopes, fold;
    struct pel_sea_desc desc; /* of the modes that are uploaded */
    double time_s;
    bool made, computed;
};

/* Nothing is allocated before the first run. */
PEL_CHECK enum pel_err pel_wavefield_run(struct pel_wavefield *field,
                                         const char *shader_dir,
                                         const struct pel_sea_desc *desc,
                                         const struct pel_cascades *cascades,
                                         double time_s,
                                         struct pel_fault *fault);
void pel_wavefield_finish(struct pel_wavefield *field);
