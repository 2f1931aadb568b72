/* Views by WebRTC for browsers and players, asked for by WHEP (the draft that
 * follows RFC 9725): one offer, one answer with every candidate, media in
 * H.264, or VP8 where the peer takes no other, from the encoder that the other
 * viewers of the view share. A thread of its own, which the first offer starts,
 * names terms with one peer after the other and ends them. A view is drawn for
 * a peer from when it is connected. Control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/metrics.h"
#include "bounds.h"
#include "frames/frames.h"
#include "net/token.h"
#include "net/wheppeer.h"

#define PEL_WHEP_TYPE "application/sdp"
#define PEL_WHEP_PLACE "/v1/whep/"
#define PEL_WHEP_ID 33 /* bytes of a session's name, with its end */

struct pel_whep;

/* `places` is copied, what it points to is borrowed. */
struct pel_whep *pel_whep_create(struct pel_frames *frames,
                                 const struct pel_whep_places *places);
/* Ends every session and waits for it. NULL allowed. */
void pel_whep_destroy(struct pel_whep *whep);

struct pel_whep_wish {
    const char *view;
    struct pel_profile profile; /* its codec is the offer's choice */
    const char *offer;          /* SDP */
    size_t offer_size;
    const char *from; /* the numeric address of who asks; NULL: this machine */
};

/* Called once, later; answer and id NULL with an error. */
typedef void (*pel_whep_done)(void *user, enum pel_err err,
                              const struct pel_fault *fault, const char *answer,
                              const char *id);

/* Errors as pel_whep_offer_read, and then `done` is not called; later also
 * those of pel_whep_peer_open. BUSY: the share of the profile's `who` in
 * PEL_BOUND_WHEP_SESSIONS is connected or has asked just now; else the one that
 * has not connected for longest makes room, and for who steers or instructs one
 * of a lower role. */
PEL_CHECK enum pel_err pel_whep_ask(struct pel_whep *whep,
                                    const struct pel_whep_wish *wish,
                                    pel_whep_done done, void *user,
                                    struct pel_fault *fault);

/* Nobody waits any more for the answer that was asked with this user: `done` is
 * not called, the session ends. False: it was called, or none was asked. */
bool pel_whep_forget(struct pel_whep *whep, const void *user);

/* Ends those whose token does not hold any more. */
void pel_whep_revoke(struct pel_whep *whep, struct pel_token *token);

/* NOT_FOUND; FORBIDDEN: it is another token's, of no lower role. */
PEL_CHECK enum pel_err pel_whep_end(struct pel_whep *whep, const char *id,
                                    const struct pel_who *who,
                                    struct pel_fault *fault);

void pel_whep_collect(const struct pel_whep *whep,
                      struct pel_metrics_page *page);
