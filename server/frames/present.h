/* When a live frame is to be shown: as late as the slowest of the last pictures
 * were there, so that nearly all have come, and what networks and decoders need
 * (proto/live.md, "Several windows"). Times of pictures in ms from the frame's
 * stamp to their bytes. */
#pragma once

#include "frames/window.h"

/* What networks and decoders may take: a frame time and some. */
#define PEL_DELIVERY_MS 40.0

/* From the stamp to the time of presentation, without delivery, however slow
 * pictures were: who draws for longer is late. */
#define PEL_PRESENT_MOST_MS 2000.0

struct pel_present {
    struct pel_window ready_ms;
    double delay_ms; /* from the stamp, delivery too */
};

void pel_present_begin(struct pel_present *p);

/* At another scale pictures take another time: forgets those that were. */
void pel_present_anew(struct pel_present *p);

/* A picture of a live frame is there. The delay grows with the next look, and
 * shrinks by a sixteenth at most, so that pictures are shown evenly. */
void pel_present_feed(struct pel_present *p, double ready_ms);
