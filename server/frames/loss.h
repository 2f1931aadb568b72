/* What a render loop does when the device is lost (reset, withdrawn, its driver
 * gone wrong): the renderer goes, another is made from what the processor
 * holds, and what was under way is drawn again. Render thread only. */
#pragma once

#include "frames/renderloop_parts.h"

/* So often a picture is drawn again; then it fails, with PEL_ERR_GPU. */
#define PEL_LOSS_MOST_AGAIN 4

/* That this renderer's device draws; 1: the software device, after losses. */
void pel_loss_note_device(struct pel_renderloop *loop, int at);

/* A draw of a job that is not large, whose memory is held and which is not
 * submitted, is to be made again. */
void pel_loss_put_again(struct pel_renderloop *loop, struct pel_job_draw *part);

/* The device is lost: makes a renderer anew; loop->again holds what to submit
 * again. It waits while there is no device; loop->renderer is NULL only where
 * the loop is to stop. */
void pel_loss_recover(struct pel_renderloop *loop);

/* Asks whether it is lost, and recovers; true: it was, or is to stop. */
bool pel_loss_noticed(struct pel_renderloop *loop);
