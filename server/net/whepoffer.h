/* SDP of WHEP peers (RFC 8866, RFC 8829): from an offer only what was checked
 * is kept, and the offer that GStreamer sees is written anew from that. No
 * sockets, no GStreamer. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/allow.h"
#include "base/err.h"

#define PEL_WHEP_LINES 16      /* of media (m=) in an offer */
#define PEL_WHEP_CANDIDATES 16 /* that are kept */
#define PEL_WHEP_TARGETS 3     /* of them that are sent checks */

/* A thing that the peer wants to receive. */
struct pel_whep_line {
    char kind[16]; /* "audio", "video", "application" */
    char proto[32];
    char format[32]; /* the first one */
    char map[40];    /* its rtpmap, "opus/48000/2"; "": it has none */
    char mid[36];    /* "": it names none */
    bool off;        /* given up by the offer itself: port 0 */
    bool grouped;    /* shares the transport of the pictures (RFC 9143) */
};

/* A peer's end of ICE and DTLS. */
struct pel_whep_transport {
    char ufrag[260], password[260];
    char fingerprint[112]; /* "sha-256 AB:CD…" */
    char setup[12];        /* "actpass", "active", "passive" */
    /* UDP, numeric addresses; without "candidate:" */
    char candidates[PEL_WHEP_CANDIDATES][144];
    size_t candidate_count;
};

struct pel_whep_offer {
    struct pel_whep_line lines[PEL_WHEP_LINES];
    size_t line_count;
    size_t video;     /* which of them gets the pictures */
    size_t tagged;    /* whose transport is used: the first of its group */
    bool in_group;    /* of a=group:BUNDLE */
    bool vp8;         /* it takes no H.264 */
    unsigned payload; /* RTP's payload type of the pictures there, 0..127 */
    unsigned rtx;     /* the type of its retransmissions (RFC 4588); 0: none */
    char profile[8];  /* profile-level-id, six hexadecimal digits, or "" */
    struct pel_whep_transport transport;
};

/* MALFORMED: not SDP, more lines than there is room for; INVALID: it wants
 * neither H.264 with packetization-mode=1 nor VP8, its end of DTLS or ICE is
 * missing, or its transport is of a line that cannot be answered. The text need
 * not end. */
PEL_CHECK enum pel_err pel_whep_offer_read(const char *text, size_t size,
                                           struct pel_whep_offer *out,
                                           struct pel_fault *fault);

/* Leaves the candidates that may be sent checks, PEL_WHEP_TARGETS at most:
 * those at the numeric address of who asked (NULL: this machine, whose are
 * those at any address of its own) and in the networks of `peers`.
 * Where none is at the asker's address (browsers hide theirs) there is one more
 * with it and a port that only his own packets tell: relays let packets of an
 * address in when they know of it. */
void pel_whep_offer_keep(struct pel_whep_offer *offer, const char *asker,
                         const struct pel_allow *peers);

/* The offer of that one video line alone; g_free(). `candidates`: with those
 * of the peer. */
char *pel_whep_offer_write(const struct pel_whep_offer *offer, bool candidates);

/* The answer to the whole offer from one to that line alone; g_free(). Other
 * lines of RTP in its group are inactive, as the group's first must not be
 * refused, whatever it is, and those outside are refused. NULL: that answer has
 * no video. `epoch`: RTP's time stamp at 1970-01-01 UTC (RFC 7273); NULL: it is
 * not known. */
char *pel_whep_answer_write(const struct pel_whep_offer *offer,
                            const char *answer, const uint32_t *epoch);
