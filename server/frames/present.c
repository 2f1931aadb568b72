#include "frames/present.h"

#include <math.h>
#include <stdbool.h>

/* Before anything is known: three frames at 30 Hz. */
#define FIRST_MS 100.0
#define LOOK 16    /* pictures between two looks at how late they are */
#define SHARE 0.98 /* of the pictures have come by then */

void pel_present_begin(struct pel_present *p)
{
    *p = (struct pel_present){ .delay_ms = FIRST_MS };
}

void pel_present_anew(struct pel_present *p)
{
    p->ready_ms.count = 0;
}

void pel_present_feed(struct pel_present *p, double ready_ms)
{
    pel_window_add(&p->ready_ms, ready_ms);
    if (p->ready_ms.count % LOOK != 0) {
        return;
    }
    double slowest_ms = pel_window_rank(&p->ready_ms, SHARE);
    double delay_ms = fmin(slowest_ms, PEL_PRESENT_MOST_MS) + PEL_DELIVERY_MS;
    bool anew = p->ready_ms.count == LOOK;
    p->delay_ms = anew ? delay_ms : fmax(delay_ms, p->delay_ms * (15.0 / 16));
}
