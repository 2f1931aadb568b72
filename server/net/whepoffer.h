/* SDP of WHEP peers (RFC 8866, RFC 8829): from an offer only what was checked
 * is kept, and the offer that GStreamer sees is written anew from that. No
 * sockets, no GStreamer. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"

#define PEL_WHEP_LINES 16      /* of media (m=) in an offer */
#define PEL_WHEP_CANDIDATES 16 /* that are kept */

/* A thing that the peer wants to receive. */
struct pel_whep_line {
    char kind[16]; /* "audio", "video", "application" */
    char proto[32];
    char format[32]; /* the first one */
    char mid[36];    /* "": it names none */
};

struct pel_whep_offer {
    struct pel_whep_line lines[PEL_WHEP_LINES];
    size_t line_count;
    size_t video;     /* which of them gets the pictures */
    unsigned payload; /* RTP's payload type of H.264 there, 0..127 */
    unsigned rtx;     /* the type of its retransmissions (RFC 4588); 0: none */
    char profile[8];  /* profile-level-id, six hexadecimal digits, or "" */
    char ufrag[260], password[260];
    char fingerprint[112]; /* "sha-256 AB:CD…" */
    char setup[12];        /* "actpass", "active", "passive" */
    /* UDP, numeric addresses; without "candidate:" */
    char candidates[PEL_WHEP_CANDIDATES][144];
    size_t candidate_count;
};

/* MALFORMED: not SDP, more lines than there is room for; INVALID: it wants no
 * H.264 with packetization-mode=1, or its end of DTLS or ICE is missing. The
 * text need not end. */
PEL_CHECK enum pel_err pel_whep_offer_read(const char *text, size_t size,
                                           struct pel_whep_offer *out,
                                           struct pel_fault *fault);

/* One more candidate: whoever asked is at this numeric address, at a port that
 * only his own packets tell. Relays let packets of an address in when they know
 * of it, and browsers hide theirs. Nothing where there is no room. */
void pel_whep_offer_add_asker(struct pel_whep_offer *offer,
                              const char *address);

/* The offer of that one video line alone; g_free(). `candidates`: with those
 * of the peer. */
char *pel_whep_offer_write(const struct pel_whep_offer *offer, bool candidates);

/* The answer to the whole offer from one to that line alone: each other line
 * is refused; g_free(). NULL: that answer has no video. `epoch`: RTP's time
 * stamp at 1970-01-01 UTC (RFC 7273); NULL: it is not known. */
char *pel_whep_answer_write(const struct pel_whep_offer *offer,
                            const char *answer, const uint32_t *epoch);
