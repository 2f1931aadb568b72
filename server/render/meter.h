/* The exposure of a view and the glare in its lens: meter.comp. Render thread
 * only. */
#pragma once

#include <epoxy/gl.h>

#include "base/err.h"
#include "render/programs.h"
#include "shaders/lib/blocks.h"

struct pel_meter {
    /* In the air, under water; pel_light_program. */
    GLuint program[2][PEL_LIGHT_PROGRAMS];
    GLuint together[PEL_LIGHT_PROGRAMS]; /* of views that are drawn together */
    GLuint exposure; /* buffer, block `exposure` of each of those */
};

void pel_meter_init(struct pel_meter *m);
/* Makes the program for these lights; `under`: for a lens that water may reach.
 * GPU. */
PEL_CHECK enum pel_err pel_meter_need(struct pel_meter *m,
                                      const struct pel_environment *env,
                                      bool under, const char *shader_dir,
                                      struct pel_fault *fault);
void pel_meter_finish(struct pel_meter *m);

/* Fills and binds the block `exposure`. The blocks frame, eye, light, windows
 * and the tables of the eye are bound, and what pel_under_map_bind binds. */
void pel_meter_run(struct pel_meter *m, const struct pel_environment *env,
                   bool under);
/* The same for views that are drawn together (render/together.h), by the
 * windows of each; without the barrier that who reads the block needs. */
PEL_CHECK enum pel_err
pel_meter_need_together(struct pel_meter *m, const struct pel_environment *env,
                        const char *shader_dir, struct pel_fault *fault);
void pel_meter_run_together(struct pel_meter *m,
                            const struct pel_environment *env, GLuint views);
/* The same by another program of meter.comp. */
void pel_meter_use(struct pel_meter *m, GLuint program);
