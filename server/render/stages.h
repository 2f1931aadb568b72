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

/* Waits for the device, then measures the commands given between the two calls,
 * ms: on hardware by timer queries; on a software device, whose queries measure
 * submission only, by wall time around a glFinish. */
void pel_timer_begin(struct pel_stage_timer *t);
double pel_timer_end(struct pel_stage_timer *t);

/* The same where timing is on: a stage ends and the next one begins. */
void pel_stage_begin(struct pel_stage_timer *t);
void pel_stage_end(struct pel_stage_timer *t, enum pel_stage stage);
