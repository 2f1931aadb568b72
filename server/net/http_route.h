/* What an HTTP request means: from a request as data to an answer as data.
 * No sockets and no library, so that tests and fuzzers call it directly.
 * Control thread (it reads and edits the scene). */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/metrics.h"
#include "frames/debrief.h"
#include "frames/frames.h"
#include "net/claims.h"
#include "net/hls.h"
#include "net/http_request.h"
#include "net/series.h"
#include "net/token.h"
#include "pelagos.pb-c.h"
#include "scene/exercise.h"
#include "scene/scene.h"

struct pel_http_context {
    struct pel_scene *scene;
    const struct pel_frames *frames; /* NULL: no picture is ever drawn */
    struct pel_debrief *debrief;     /* NULL: there is none */
    struct pel_exercises *exercises; /* NULL: none */
    struct pel_cluster *cluster;     /* NULL: none */
    struct pel_series *series;       /* NULL: nobody asks for any */
    struct pel_metrics *metrics;
    const char *const *hosts; /* as pel_http_host_is_ours */
    /* Other origins whose pages may ask for pictures, NULL-terminated; NULL:
     * none */
    const char *const *origins;
    const char *const
        *proxies;              /* whose X-Forwarded-For is believed, likewise */
    struct pel_token *token;   /* what clients must give; NULL: nothing */
    struct pel_claims *claims; /* what they have under way; NULL: any */
    size_t body_limit;         /* bytes; eight times that for /v1/surface */
    bool stopping;             /* /healthz says so */
    bool ready;                /* /readyz does */
};

enum pel_http_kind {
    PEL_HTTP_WHOLE,    /* status, type and body are there */
    PEL_HTTP_FRAME,    /* carry out `frame`, answer with the picture */
    PEL_HTTP_FRAMES,   /* carry out `frames`, answer with the pictures */
    PEL_HTTP_MJPEG,    /* stream `view` */
    PEL_HTTP_TS,       /* stream `view` in `profile` */
    PEL_HTTP_HLS,      /* the playlist of `view` in `profile`, as `hls` says */
    PEL_HTTP_HLS_FILE, /* `file`, which a playlist names */
    PEL_HTTP_WHEP, /* offer the body for `view` in `profile`, answer with SDP */
    PEL_HTTP_WHEP_END,   /* end the session `file` */
    PEL_HTTP_LIVE,       /* a WebSocket: 101, then `live` */
    PEL_HTTP_SURFACE,    /* carry out `surface`, answer with JSON */
    PEL_HTTP_OPTICS,     /* carry out `optics`, answer with JSON */
    PEL_HTTP_SPECTRUM,   /* carry out `spectrum`, answer with JSON */
    PEL_HTTP_ALMANAC,    /* carry out `almanac`, answer with JSON */
    PEL_HTTP_SOUNDINGS,  /* carry out `soundings`, answer with floats */
    PEL_HTTP_MODELS,     /* list the models, answer with JSON */
    PEL_HTTP_SERIES,     /* carry out `series`, answer with its file */
    PEL_HTTP_PATCH,      /* commit `patch`, answer with the state */
    PEL_HTTP_STEP,       /* carry out `step`, answer with the state */
    PEL_HTTP_RECORDINGS, /* list the recordings, answer with JSON */
    PEL_HTTP_PLACE,      /* carry out `place`, answer with the Cluster */
    PEL_HTTP_EXERCISE,   /* carry out `exercise`, answer as `shows` says */
};

/* Above so many bytes a body is read, or an answer written, by a thread: less
 * takes some 0.1 ms. */
#define PEL_HTTP_AT_ONCE 4096

struct pel_http_answer {
    enum pel_http_kind kind;
    int status;
    const char *type; /* Content-Type, static; NULL: no body */
    /* Yet to be written as the body (pel_http_write), ours; or NULL */
    ProtobufCMessage *message;
    uint8_t *packed; /* or this, ours, of `packed_type`; or NULL */
    size_t packed_size;
    const ProtobufCMessageDescriptor *packed_type;
    bool pretty;
    char path[200]; /* for `write` */
    /* Any thread; NULL: the whole as JSON. May refuse. */
    void (*write)(struct pel_http_answer *answer,
                  const ProtobufCMessage *message);
    char *owned;      /* body to free(), or NULL */
    const void *body; /* `owned`, or static data */
    size_t size;
    bool debrief;      /* pictures are of its views, not of the live ones */
    bool close;        /* the connection cannot go on */
    bool page;         /* a file of the page: may be kept, with care */
    const char *cache; /* Cache-Control, static; NULL: as `page` says */
    const char *allow; /* Allow header, static, or NULL */
    /* Access-Control-Allow-Methods, static, of a preflight; else NULL */
    const char *preflight;
    char ignored[200]; /* X-Pelagos-Ignored header, or "" */
    char tag[64];      /* ETag header, or "" */
    char location[96]; /* Location header, or "" */
    int retry_after_s; /* Retry-After header, or 0 */
    Pelagos__FrameRequest *frame;
    Pelagos__FramesRequest *frames;
    Pelagos__SurfaceQuery *surface;
    Pelagos__OpticsQuery *optics;
    Pelagos__SpectrumQuery *spectrum;
    Pelagos__AlmanacQuery *almanac;
    Pelagos__SoundingsQuery *soundings;
    Pelagos__SeriesQuery *series;
    Pelagos__Patch *patch;
    Pelagos__ClusterPlaceCommand *place;
    Pelagos__ExerciseCommand *exercise;
    enum {
        PEL_HTTP_STATUS_OF,   /* the ExerciseStatus */
        PEL_HTTP_EXERCISE_OF, /* the Exercise that it shows */
        PEL_HTTP_SAVED,       /* the one that was saved */
        PEL_HTTP_NOTHING,     /* 204 */
    } shows;
    int not_found; /* of EXERCISE: status of that error; 0: as everywhere */
    Pelagos__ClockStep step;
    bool if_unchanged; /* of PATCH: If-Match named the state of now */
    char view[PEL_NAME_SIZE];
    double fps; /* at most; 0: every frame */
    int quality;
    struct pel_profile profile; /* of LIVE, TS, HLS and WHEP */
    struct pel_hls_wish hls;    /* of HLS: its msn and part */
    char file[48];
    unsigned credit;      /* of LIVE: pictures not acknowledged */
    char accept[32];      /* of LIVE: Sec-WebSocket-Accept */
    bool upgrade;         /* Upgrade header of a 426 */
    bool subprotocol;     /* of LIVE: the viewer offered `pelagos` */
    bool challenge;       /* WWW-Authenticate headers of a 401 */
    bool challenge_basic; /* Basic too: not for a page's own requests */
};

void pel_http_answer_finish(struct pel_http_answer *answer);

/* Whether writing it takes long. */
bool pel_http_is_long(const struct pel_http_answer *answer);
/* Makes a message the body; nothing where there is none. Any thread. */
void pel_http_write(struct pel_http_answer *answer);

/* A body as a message, or why it is none. */
struct pel_http_read {
    enum pel_err err;
    struct pel_fault fault;
    ProtobufCMessage *message; /* NULL: taken, or none */
};

/* By the name that proto/routes.def gives the body. Any thread. */
void pel_http_read(const char *name, const char *body, size_t size,
                   struct pel_http_read *out);
void pel_http_read_finish(struct pel_http_read *read);

/* That name, or NULL: there is no message in the body. *edits: those who may
 * only watch may not ask for it. */
const char *pel_http_about(const struct pel_http_request *request, bool *edits);

/* Judges a request by its head alone, before its body is read. True: go on
 * (body_limit, if not NULL, gets the most bytes of body there may be); false:
 * *answer refuses it and the connection must close if a body was announced. */
bool pel_http_admit(const struct pel_http_context *context,
                    const struct pel_http_request *request, size_t *body_limit,
                    struct pel_http_answer *answer);

/* The answer to an admitted request with its whole body. */
void pel_http_route(const struct pel_http_context *context,
                    const struct pel_http_request *request,
                    struct pel_http_answer *answer);

/* The state as the role reads it, with its revision as tag; or why a patch of
 * it was refused. */
void pel_http_answer_state(const struct pel_http_context *context,
                           enum pel_role role, struct pel_http_answer *answer);
void pel_http_answer_refused(struct pel_http_answer *answer,
                             const struct pel_fault *fault);

/* An answer that says what is wrong, as RFC 9457 problem+json. The fault's
 * code becomes the status unless `status` is not 0. */
void pel_http_problem(struct pel_http_answer *answer, int status,
                      const struct pel_fault *fault);

/* Status of an error code where a name in the URL led to it. */
int pel_http_status(enum pel_err err);
