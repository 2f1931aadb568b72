/* Requests of a CIGI host that are answered again and again. One thread at a
 * time. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bridges/cigi_packet.h"

#define PEL_CIGI_MAX_PERIODIC 256

struct pel_cigi_periodic {
    struct {
        bool used;
        unsigned period;      /* frames */
        uint32_t first_frame; /* of the IG */
        struct pel_cigi_packet question;
    } list[PEL_CIGI_MAX_PERIODIC];
};

enum pel_cigi_turn {
    PEL_CIGI_NOW,   /* asked once: answer it */
    PEL_CIGI_LATER, /* kept, or put in the place of the one of its id */
    PEL_CIGI_NEVER, /* too many are kept */
};

/* Takes a request of the host; a period of 0 ends the one of its kind and id.
 * ig_frame: the last one sent. */
enum pel_cigi_turn pel_cigi_periodic_take(struct pel_cigi_periodic *periodic,
                                          const struct pel_cigi_packet *p,
                                          uint32_t ig_frame);

/* Those to be answered with frame ig_frame into due[PEL_CIGI_MAX_PERIODIC];
 * their number. They stay in `periodic`. */
size_t pel_cigi_periodic_due(const struct pel_cigi_periodic *periodic,
                             uint32_t ig_frame,
                             const struct pel_cigi_packet **due);

void pel_cigi_periodic_clear(struct pel_cigi_periodic *periodic);
