/* The exposure of a view and the glare in its lens: meter.comp. Render thread
 * only. */
#pragma once

#include <epoxy/gl.h>

#include "base/err.h"
#include "shaders/lib/blocks.h"

struct pel_meter {
    GLuint program[PEL_LIGHTS]; /* by the number of lights, less one */
    GLuint exposure;            /* buffer, block `exposure` */
};

PEL_CHECK enum pel_err pel_meter_init(struct pel_meter *m,
                                      const char *shader_dir,
                                      struct pel_fault *fault);
/* Makes the program for so many lights. GPU. */
PEL_CHECK enum pel_err pel_meter_need(struct pel_meter *m, int lit,
                                      const char *shader_dir,
                                      struct pel_fault *fault);
void pel_meter_finish(struct pel_meter *m);

/* Fills and binds the block `exposure`. The blocks frame, eye, light, windows
 * and the tables of the eye are bound. */
void pel_meter_run(struct pel_meter *m, int lit);
