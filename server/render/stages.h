/* Times of the stages of a frame. Render thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stdint.h>

#include "render/renderer.h"

struct pel_stage_timer {
    bool software;
    bool on; /* stages are waited for and timed */
    int64_t last_ns;
    GLuint queries[2];
    double ms[PEL_STAGE_COUNT]; /* since they were last zeroed */
};

void pel_stage_timer_init(struct pel_stage_timer *t, bool software);
void pel_stage_timer_finish(struct pel_stage_timer *t);

/* Waits for the device, then times what is given to it in between, ms: on
 * hardware by the GPU's own clock; a software device runs behind its queries,
 * so there by the wall clock around a finish. */
void pel_timer_begin(struct pel_stage_timer *t);
double pel_timer_end(struct pel_stage_timer *t);

/* The same where timing is on: a stage ends and the next one begins. */
void pel_stage_begin(struct pel_stage_timer *t);
void pel_stage_end(struct pel_stage_timer *t, enum pel_stage stage);
