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

/* The device is lost: peers that have one draw what waits here, and a renderer
 * is made anew; else loop->again holds what to submit again. It waits while
 * there is no device and no peer has one. loop->renderer is NULL where the loop
 * is to stop, or peers draw for it. */
void pel_loss_recover(struct pel_renderloop *loop);

/* While loop->renderer is NULL, now and then: peers draw, or it stands again.
 * After PEL_MANY_LOSSES it is made anew only where no peer has a device. */
void pel_loss_return(struct pel_renderloop *loop);

/* Asks whether it is lost, and recovers; true: it was, or there is none. */
bool pel_loss_noticed(struct pel_renderloop *loop);
