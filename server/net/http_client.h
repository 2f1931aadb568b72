/* Internals of the HTTP server: connections as http_server.c keeps them,
 * answers as http_answer.c, http_stream.c and http_picture.c send them. They
 * know libmicrohttpd; nothing else does. Control thread. */
#pragma once

#include <netinet/in.h>
#include <stdbool.h>
#include <stdint.h>

#include <glib.h>
#include <microhttpd.h>

#include "net/claims.h"
#include "net/http_server.h"
#include "net/liveviewer.h"
#include "net/mjpeg.h"
#include "net/tsviewer.h"
#include "net/whep.h"
#include "scene/edit.h"
#include "scene/worker.h"

#define PEL_HTTP_STATUS_MAX 600

enum phase {
    PHASE_HEADERS, /* from the connection's begin or the last answer */
    PHASE_BODY,
    PHASE_ANSWER,
    PHASE_STREAM,
    PHASE_CLOSED, /* shut down, the library has yet to notice */
};

/* Where a connection comes from. */
struct pel_http_source {
    struct in6_addr address; /* IPv4 as mapped */
    bool loopback;           /* all of it is counted together */
    bool proxy;              /* names the client with each request */
};

/* One connection, and the request that it is busy with. */
struct client {
    struct pel_http_server *server;
    struct MHD_Connection *connection;
    int fd;
    struct pel_http_source source;
    struct pel_who who; /* of the last request; NOBODY before its head */
    bool placed;        /* counts among the connections: a head was admitted */
    bool reserve;       /* has one of the last places: see http_share.h */
    bool open;          /* asks for what is public: /healthz */
    bool gone;          /* the client sends no more */
    bool interim;       /* it takes interim answers: HTTP/1.1 */
    bool probed;        /* whether it reads, in this request */
    struct pel_claim pictures, unread;
    bool changes; /* the request that is answered is an edit */
    enum phase phase;
    int64_t deadline_ns;
    int64_t since_ns;  /* waiting for headers; the oldest makes room */
    uint64_t consumed; /* bytes received when the last request was done */
    uint64_t read;     /* bytes that the library had taken at the last look */
    bool first;        /* nothing has been answered yet */

    char *target, *authority; /* as struct pel_http_request has them */
    /* In the library's memory, until the head is read: see http_head.h. */
    const char *target_at, *version_at;
    GString *body;
    size_t body_limit;
    struct pel_http_read *parsed; /* the body, where a thread has read it */
    const char *method;           /* the library's, of this request */
    bool edits;                   /* what watch may not ask for */
    bool queued;                  /* for another turn: pel_http_take_later */
    const char *origin;           /* an allowed one that asks, or NULL */
    char ignored[200];            /* as struct pel_http_answer has it */
    char notice[PEL_NOTICE];      /* X-Pelagos-Notice of an edit, or "" */
    bool suspended;
    bool of_debrief;   /* the pictures that it asks for */
    bool waiting;      /* for frame or surface */
    uint64_t frame_id; /* of a picture or a set; 0: neither */
    struct waiter *waiter;

    struct pel_live_wish wish;
    struct pel_live_viewer *live;               /* a WebSocket, or NULL */
    struct MHD_UpgradeResponseHandle *upgraded; /* the socket is ours */
};

/* A surface query cannot be cancelled, so this outlives its client. */
struct waiter {
    struct client *client;         /* NULL: gone */
    struct pel_series_job *series; /* or NULL */
    int not_found;     /* status of that error here; 0: as everywhere */
    bool if_unchanged; /* an edit of the present revision, or of none */
    struct pel_http_answer *ready; /* waits for its seal, or for what it is to
                                    * say of exercises; else NULL */
    struct pel_claim claim;
};

struct daemon_source;

struct pel_http_server {
    struct pel_net_limits limits;
    struct pel_http_context context;
    struct pel_frames *frames;
    struct MHD_Daemon *daemon;
    struct daemon_source *source;
    bool run_again;
    unsigned turns_at_once; /* of the library, without waiting */
    bool closing;
    guint sweeper;
    int hangups; /* an epoll that tells of clients that have gone */
    struct pel_fdsource *hangup_source;
    guint probing; /* those who send no more while they wait; 0: nobody */
    GPtrArray *clients;
    struct pel_worker *edit_worker, *question_worker; /* http_later.c */
    unsigned reading; /* bodies of edits, by that worker */
    GQueue takers;    /* of struct client: to be answered in another turn */
    GSource *taking;  /* wakes for them */
    struct pel_mjpeg_stats mjpeg;
    struct pel_live_stats live;
    struct pel_ts_stats ts;
    struct pel_hls *hls;
    struct pel_whep *whep;
    uint64_t answers[PEL_HTTP_STATUS_MAX];
    uint64_t accepted, refused, evicted, malformed, timeouts, vanished;
};

/* The moment that many seconds from now [ns, CLOCK_MONOTONIC]. */
int64_t pel_http_after(double s);

/* What draws the pictures that the client asks for; NULL: the debrief is no
 * more. */
struct pel_frames *pel_http_frames(const struct client *client);

/* Lets the library look at its connections at the loop's next turn: after a
 * resume it would otherwise wait for the network. */
void pel_http_kick(struct pel_http_server *server);

/* Begins and ends what is answered later; the end gives NULL where the client
 * is gone. */
struct waiter *pel_http_wait_begin(struct client *client);
struct client *pel_http_wait_end(struct waiter *waiter);

/* Leaves the connection alone until pel_http_resume; nothing for one that is
 * suspended. */
void pel_http_suspend(struct client *client);

/* Lets a suspended connection go on; nothing for any other, nor for one that
 * waits for an answer. */
void pel_http_resume(struct client *client);

/* Answers the request, whose body is there. */
enum MHD_Result pel_http_take(struct client *client);

/* http_later.c: leaves the request to another turn of the loop, where this one
 * has taken its time or others wait so; true: it is suspended until then. */
bool pel_http_take_later(struct client *client);
void pel_http_begin_later(struct pel_http_server *server);
void pel_http_end_later(struct pel_http_server *server);

/* http_later.c: has a long body read by a thread, which then takes the request;
 * false: it is short, or read. */
bool pel_http_read_later(struct client *client,
                         const struct pel_http_request *request);
/* Has a long answer written by a thread, which then sends it; false: it is
 * short, and written. Takes *answer over. */
bool pel_http_write_later(struct client *client,
                          struct pel_http_answer *answer);
/* Has a large answer freed by a thread. */
void pel_http_forget_later(struct client *client,
                           struct pel_http_answer *answer);

/* Sends a whole answer and finishes it. In the library's handler, or while
 * the connection is suspended; a long one is written first, and the connection
 * stays suspended until then. */
enum MHD_Result pel_http_send(struct client *client,
                              struct pel_http_answer *answer);

/* A response of pieces of memory, which drop(what) frees in the end, on any
 * thread; NULL: no memory, and they are freed. http_pieces.c */
struct MHD_Response *pel_http_pieces(const struct MHD_IoVec *pieces,
                                     size_t count,
                                     MHD_ContentReaderFreeCallback drop,
                                     void *what);

/* The same with a response of the library's, which it takes over. */
enum MHD_Result pel_http_queue(struct client *client, int status,
                               struct MHD_Response *response);

/* The same for problem+json about a fault. */
enum MHD_Result pel_http_send_fault(struct client *client, int status,
                                    const struct pel_fault *fault);

/* Answers that take their time: the connection is suspended until the picture
 * or the surface is there, or streams until the viewer leaves. They finish
 * *answer. */
enum MHD_Result pel_http_send_frame(struct client *client,
                                    struct pel_http_answer *answer);
/* What GET would say of a picture or a stream, without drawing it. */
enum MHD_Result pel_http_send_head(struct client *client,
                                   struct pel_http_answer *answer);
enum MHD_Result pel_http_send_frames(struct client *client,
                                     struct pel_http_answer *answer);
enum MHD_Result pel_http_send_optics(struct client *client,
                                     struct pel_http_answer *answer);
enum MHD_Result pel_http_send_surface(struct client *client,
                                      struct pel_http_answer *answer);
enum MHD_Result pel_http_send_models(struct client *client,
                                     struct pel_http_answer *answer);
enum MHD_Result pel_http_send_recordings(struct client *client,
                                         struct pel_http_answer *answer);
enum MHD_Result pel_http_send_spectrum(struct client *client,
                                       struct pel_http_answer *answer);
enum MHD_Result pel_http_send_soundings(struct client *client,
                                        struct pel_http_answer *answer);
enum MHD_Result pel_http_send_almanac(struct client *client,
                                      struct pel_http_answer *answer);
enum MHD_Result pel_http_send_place(struct client *client,
                                    struct pel_http_answer *answer);
/* Commands of exercises, whose files a thread reads. */
enum MHD_Result pel_http_send_exercise(struct client *client,
                                       struct pel_http_answer *answer);
enum MHD_Result pel_http_send_series(struct client *client,
                                     struct pel_http_answer *answer);
/* Files of a spectrum as a POSIX tar; g_free(). http_tar.c */
char *pel_http_tar(const Pelagos__Spectrum *spectrum, size_t *size);
/* An answer that is ready, when what it did to the scene is sealed. */
enum MHD_Result pel_http_send_sealed(struct client *client,
                                     struct pel_http_answer *answer);
enum MHD_Result pel_http_send_stepped(struct client *client,
                                      struct pel_http_answer *answer);
enum MHD_Result pel_http_send_patched(struct client *client,
                                      struct pel_http_answer *answer);
/* A playlist or a file of one. */
enum MHD_Result pel_http_send_hls(struct client *client,
                                  struct pel_http_answer *answer);
/* http_whep.c: the answer to an offer, or the end of a session. */
enum MHD_Result pel_http_send_whep(struct client *client,
                                   struct pel_http_answer *answer);
enum MHD_Result pel_http_send_stream(struct client *client,
                                     struct pel_http_answer *answer);

/* Switches to WebSocket; the viewer begins when the answer is out. */
enum MHD_Result pel_http_send_live(struct client *client,
                                   const struct pel_http_answer *answer);
/* Ends it and gives the socket back; nothing for any other client. */
void pel_http_end_live(struct client *client);

/* The client has so many bytes of an answer to read, until it has. */
void pel_http_hold(struct client *client, size_t bytes);

/* Cancels the picture or the surface that the connection waits for. */
void pel_http_call_off(struct client *client);
