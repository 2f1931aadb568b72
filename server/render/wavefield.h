/* The sea as cascades of inverse FFTs in textures: ocean/cascade.h says what is
 * computed. Once a frame, for all its views. Render thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>

#include "ocean/cascade.h"
#include "render/shader.h"

/* The fields of one moment, with their levels of detail. */
struct pel_wavefield_textures {
    GLuint displacement, slopes, fold;
    GLuint breaking; /* of foam.h; 0 until a sea has whitecaps */
};

/* The processor's fields go to two sets in turn: a software device still
 * shades the last frame from the other one. */
#define PEL_WAVEFIELD_SETS 2

struct pel_wavefield_cpu; /* of the transforms on the processor */

struct pel_wavefield {
    /* Before the first run: transforms by ocean/evolve.h instead of compute
     * shaders, which software devices run eight times slower. Displacement of
     * the two agrees within 1e-6 of the significant height. */
    bool on_processor;
    int threads; /* that share them; 0: one a core, four at most */
    bool made, computed;
    GLuint rows_program, columns_program, mips_program;
    GLuint foam_programs[2]; /* the same for what breaks */
    bool foam;               /* whitecaps are wanted: before a run */
    GLuint amplitudes, modes, lines, parameters;
    struct pel_wavefield_cpu *cpu;
    struct pel_wavefield_textures sets[PEL_WAVEFIELD_SETS];
    int current;              /* set of the moment computed last */
    struct pel_sea_desc desc; /* of the modes that are uploaded */
    double time_s;
};

/* Makes the programs and textures that a sea wants; nothing is allocated before
 * the first. NO_MEMORY; GPU when a program does not compile. */
PEL_CHECK enum pel_err pel_wavefield_need(struct pel_wavefield *field,
                                          const char *shader_dir,
                                          const struct pel_sea_desc *desc,
                                          struct pel_fault *fault);
/* Brings the fields to time_s and binds them. */
void pel_wavefield_run(struct pel_wavefield *field,
                       const struct pel_sea_desc *desc,
                       const struct pel_cascades *cascades, double time_s);
void pel_wavefield_finish(struct pel_wavefield *field);
