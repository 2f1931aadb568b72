/* Internals of the protobuf sessions: a session as session.c keeps it, answers
 * as session_answers.c gives them. Control thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <glib.h>

#include "frames/debrief.h"
#include "net/claims.h"
#include "net/fdsource.h"
#include "net/outbox.h"
#include "net/roles.h"
#include "net/series.h"
#include "net/session.h"
#include "pelagos.pb-c.h"
#include "unpack.h"

#define PEL_SESSION_COMMANDS 24

struct session;

/* A request whose answer comes later. It outlives its session where the
 * answer cannot be cancelled. */
struct job {
    struct session *session; /* NULL: gone */
    bool has_id;
    uint64_t id;
    struct pel_series_job *series; /* or NULL */
    Pelagos__ExerciseStatus *exercise;
    bool is_picture; /* or several of one frame */
    bool of_debrief;
    uint64_t picture_id;
    struct pel_claim claim;
    char *notice; /* Reply.notice of an edit, or NULL; on_edit frees it */
};

struct session {
    struct pel_sessions *all;
    enum pel_transport transport;
    int fd;
    struct pel_fdsource *source;
    uint8_t *in;
    size_t in_size, in_capacity;
    struct pel_outbox out;
    GPtrArray *jobs; /* of struct job */
    bool watching, watch_due, watch_has_id;
    uint64_t watch_id;
    bool stranger;      /* has not authenticated yet */
    struct pel_who who; /* then NOBODY */
    struct pel_claim unread;
    bool ended;               /* at its next turn: it has read too little */
    bool owes;                /* an answer that later requests wait for */
    bool nudge;               /* a client waits for the next bytes sent */
    bool eof;                 /* the client sends no more */
    bool held;                /* whole messages may wait in `in` */
    bool closing;             /* after the last byte is out */
    int64_t close_by_ns;      /* and then not later than this; 0: not yet */
    int64_t message_since_ns; /* a message has begun; 0: none */
    int64_t progress_ns;      /* the reader took something */
    int64_t active_ns;        /* last request or reply */
};

/* A state as its bytes. */
struct pel_packed_state {
    uint8_t *bytes; /* NULL: none */
    size_t size;
    uint64_t revision;
    int64_t at_ns;
};

struct pel_sessions {
    struct pel_net_limits limits;
    struct pel_scene *scene;
    struct pel_frames *frames;
    struct pel_series *series;
    struct pel_claims *claims;       /* NULL: nothing is counted */
    struct pel_exercises *exercises; /* NULL: none */
    struct pel_cluster *cluster;     /* NULL: none */
    struct pel_debrief *debrief;     /* NULL: none */
    struct pel_token *token;         /* NULL: none is asked for */
    GPtrArray *list;                 /* of struct session */
    struct pel_unpack unpack;        /* the request being taken */
    struct pel_packed_state
        packed[PEL_RANKS]; /* what watchers were sent last */
    bool stopped;
    uint64_t accepted[PEL_TRANSPORT_COUNT], refused[PEL_TRANSPORT_COUNT];
    uint64_t malformed[PEL_TRANSPORT_COUNT], timeouts[PEL_TRANSPORT_COUNT];
    uint64_t requests[PEL_SESSION_COMMANDS], errors, evicted, in_bytes,
        out_bytes;
    uint64_t unauthorized;
};

/* Whole replies, on their way as the reader takes them. */
void pel_session_send_state(struct session *self, bool has_id, uint64_t id);
void pel_session_send_fault(struct session *self, bool has_id, uint64_t id,
                            const struct pel_fault *fault);

/* The state to one who watches it. */
void pel_session_send_watched(struct session *self);

/* Answers with the nodes of the exercise. */
void pel_session_cluster(struct session *self, const Pelagos__Request *request);
/* Places a view, and answers the same when the store has it. */
PEL_CHECK enum pel_err pel_session_place(struct session *self,
                                         const Pelagos__Request *request,
                                         struct pel_fault *fault);
/* Does what is asked of exercises, and answers. */
PEL_CHECK enum pel_err pel_session_exercise(struct session *self,
                                            const Pelagos__Request *request,
                                            struct pel_fault *fault);

/* Answers when the list is there. */
PEL_CHECK enum pel_err pel_session_models(struct session *self,
                                          const Pelagos__Request *request,
                                          struct pel_fault *fault);

/* Answers with the recordings, after what is asked of them. */
PEL_CHECK enum pel_err pel_session_recordings(struct session *self,
                                              const Pelagos__Request *request,
                                              struct pel_fault *fault);
/* Answers with what the debrief is then. */
PEL_CHECK enum pel_err pel_session_debrief(struct session *self,
                                           const Pelagos__Request *request,
                                           struct pel_fault *fault);

/* Answers when the numbers are there. */
PEL_CHECK enum pel_err pel_session_spectrum(struct session *self,
                                            const Pelagos__Request *request,
                                            struct pel_fault *fault);

/* Answers when all its questions are. */
PEL_CHECK enum pel_err pel_session_series(struct session *self,
                                          const Pelagos__Request *request,
                                          struct pel_fault *fault);

PEL_CHECK enum pel_err pel_session_almanac(struct session *self,
                                           const Pelagos__Request *request,
                                           struct pel_fault *fault);

/* Answers when the patch is committed or refused. */
void pel_session_patch(struct session *self, const Pelagos__Request *request);
void pel_session_step(struct session *self, const Pelagos__Request *request);

/* Begins what is answered later: pictures, the surface, light. */
PEL_CHECK enum pel_err pel_session_start(struct session *self,
                                         const Pelagos__Request *request,
                                         struct pel_fault *fault);

/* Cancels those answers. */
void pel_session_cancel(struct session *self);

/* Ends the session at its next turn: it may be in the middle of one. */
void pel_session_end_soon(void *session);

/* session_places.c. Those of the Unix socket and of TCP are counted apart, so
 * that neither keeps the other out. */
unsigned pel_sessions_count(const struct pel_sessions *all,
                            enum pel_transport transport, bool strangers);
/* Whether the session's share of the places of those that are logged in has one
 * more; a session that is idle or of a lower role may end for it. */
PEL_CHECK bool pel_session_find_place(struct session *self,
                                      struct pel_fault *fault);
/* A place for a client without a token yet; the stranger that came first may
 * end for it. */
PEL_CHECK bool pel_sessions_find_stranger_place(struct pel_sessions *all);
