/* GStreamer's end of one WHEP session: appsrc, RTP, webrtcbin. Making, naming
 * terms and ending take milliseconds to seconds: a thread that may wait does
 * them. Pictures are pushed by the control thread between the two. */
#pragma once

#include <stdint.h>

#include "base/allow.h"
#include "base/err.h"
#include "frames/frames.h"
#include "net/whepoffer.h"

struct pel_whep_peer;

/* Where media come from. Strings are borrowed. */
struct pel_whep_places {
    const char *address;         /* numeric; NULL: every one of this machine */
    uint16_t port_min, port_max; /* UDP; 0: any free one */
    /* stun://HOST:PORT, turn(s)://USER:PASSWORD@HOST:PORT; NULL: none */
    const char *const *servers;
    /* Where candidates are sent checks beside the asker's, where there are
     * servers */
    struct pel_allow peers;
};

enum pel_whep_event {
    PEL_WHEP_CONNECTED, /* media can go */
    PEL_WHEP_LOST,      /* for good */
    PEL_WHEP_KEY,       /* it asks for a key frame */
};

/* Any thread, GStreamer's mostly; not after pel_whep_peer_close. */
typedef void (*pel_whep_told)(void *user, enum pel_whep_event event);

/* Waits. *answer: to the whole offer, with every candidate; g_free().
 * NOT_FOUND: GStreamer or a part of it is not installed; INVALID: webrtcbin
 * refuses the offer; BUSY: no candidate came in time. */
PEL_CHECK enum pel_err pel_whep_peer_open(const struct pel_whep_places *places,
                                          const struct pel_whep_offer *offer,
                                          pel_whep_told told, void *user,
                                          struct pel_whep_peer **out,
                                          char **answer,
                                          struct pel_fault *fault);
void pel_whep_peer_close(struct pel_whep_peer *peer); /* waits; NULL allowed */

/* Does not wait. */
void pel_whep_peer_push(struct pel_whep_peer *peer, struct pel_frame *frame);
/* Pictures that were pushed and are not on their way yet. */
unsigned pel_whep_peer_queued(const struct pel_whep_peer *peer);
/* CLOCK_MONOTONIC when it was last heard [ns]; any thread. */
int64_t pel_whep_peer_heard_ns(const struct pel_whep_peer *peer);
