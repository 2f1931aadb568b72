/* libpelagos: the C client of pelagosd.
 *
 * Connect, then call: each call sends one request and waits for its reply.
 * Messages are those of pelagos.proto (pelagos.pb-c.h, protobuf-c); what a
 * call hands out belongs to the caller, who frees it with the message's own
 * pelagos__…__free_unpacked(message, NULL).
 *
 * Threads: a client belongs to one thread at a time; different clients are
 * independent. Time: every call ends within the client's time-out, after which
 * (as after any other failure of the connection) the client is only good for
 * pel_client_close. A refusal by the daemon leaves it usable. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "pelagos.pb-c.h"

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define PEL_CLIENT_API __attribute__((visibility("default")))
#define PEL_CLIENT_CHECK __attribute__((warn_unused_result))
#else
#define PEL_CLIENT_API
#define PEL_CLIENT_CHECK
#endif

/* Where pelagosd listens unless told otherwise. */
#define PEL_CLIENT_DEFAULT_SERVER "tcp:127.0.0.1:7878"
/* The environment variable that overrides it. */
#define PEL_CLIENT_SERVER_VARIABLE "PELAGOS_SERVER"
/* The token of pelagosd --token-file, itself or the file it is in: connecting
 * gives it by itself. */
#define PEL_CLIENT_TOKEN_VARIABLE "PELAGOS_TOKEN"
#define PEL_CLIENT_TOKEN_FILE_VARIABLE "PELAGOS_TOKEN_FILE"
/* A file of certificates (PEM) that TLS trusts instead of the system's. */
#define PEL_CLIENT_CA_VARIABLE "PELAGOS_CA"

/* Why a call failed. The first nine are ErrorCode of the schema: the daemon
 * refused. From 100 on the request did not get an answer. */
enum pel_client_code {
    PEL_CLIENT_OK = 0,
    PEL_CLIENT_MALFORMED = 1,
    PEL_CLIENT_NOT_FOUND = 2,
    PEL_CLIENT_OUT_OF_RANGE = 3,
    PEL_CLIENT_INVALID = 4,
    PEL_CLIENT_CONFLICT = 5,
    PEL_CLIENT_BUSY = 6,
    PEL_CLIENT_INTERNAL = 7,
    PEL_CLIENT_UNAUTHORIZED = 8,
    PEL_CLIENT_FORBIDDEN = 9,
    PEL_CLIENT_BAD_ADDRESS = 100, /* not tcp:HOST:PORT, tls: or unix:PATH */
    PEL_CLIENT_UNREACHABLE = 101, /* nothing listens there */
    PEL_CLIENT_TIMEOUT = 102,     /* no reply in time */
    PEL_CLIENT_CLOSED = 103,      /* the connection broke */
    PEL_CLIENT_PROTOCOL = 104,    /* the answer cannot be read */
};

/* What went wrong, in words for people and fields for programs. `path`,
 * `value` and `unit` are empty where they do not apply; minimum > maximum: no
 * range. */
struct pel_client_error {
    enum pel_client_code code;
    char path[96];  /* field at fault, `sea.windSpeed` */
    char value[64]; /* what was refused */
    char unit[16];
    double minimum, maximum;
    char message[256];
};

struct pel_client;

/* Connects to `address`: "tcp:HOST:PORT", "tcp:[IPV6]:PORT", the same with
 * "tls:" (where pelagosd has --tls-cert), "unix:PATH", or NULL for
 * $PELAGOS_SERVER and, without that, the default. Where the environment has a
 * token it is given; a wrong one is UNAUTHORIZED. timeout_ms (1 ..) bounds this
 * and every later call. `error` may be NULL here and below. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_connect(const char *address, int timeout_ms, struct pel_client **out,
                   struct pel_client_error *error);

/* Gives the token by hand, before anything else; UNAUTHORIZED: it is wrong, and
 * the connection is over. A daemon that asks for none takes any. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_login(struct pel_client *client, const char *token,
                 struct pel_client_error *error);

/* Closes and frees; NULL allowed. */
PEL_CLIENT_API void pel_client_close(struct pel_client *client);

/* The address in use, "tcp:127.0.0.1:7878"; lives as long as the client. */
PEL_CLIENT_API const char *pel_client_address(const struct pel_client *client);

/* Changes the time-out of the calls to come [ms]. */
PEL_CLIENT_API void pel_client_set_timeout(struct pel_client *client,
                                           int timeout_ms);

/* The socket, to wait on in a loop of the caller's; read through
 * pel_client_next_state only, until nothing is new: TLS may have more than the
 * socket shows. */
PEL_CLIENT_API int pel_client_fd(const struct pel_client *client);

/* The whole state, with clock.time of this moment. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_get(struct pel_client *client, Pelagos__State **out,
               struct pel_client_error *error);

/* Changes the state: all of the patch or nothing. *out (NULL allowed): the
 * state after it. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_patch(struct pel_client *client, const Pelagos__Patch *patch,
                 Pelagos__State **out, struct pel_client_error *error);

/* What the last edit switched off without having been asked to, in a sentence;
 * "": nothing. Until the client's next call. */
PEL_CLIENT_API const char *pel_client_notice(const struct pel_client *client);

/* One picture. (*out)->data holds a whole JPEG, PNG or EXR file. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_frame(struct pel_client *client,
                 const Pelagos__FrameRequest *request, Pelagos__Frame **out,
                 struct pel_client_error *error);

/* Pictures of one frame, 1 to 64, by one call: of one state at one simulated
 * time, with one number, whatever else the daemon does; all of them or none, in
 * the order of the request ((*out)->frames[i]->data: a whole file each). Free
 * *out with pelagos__frames__free_unpacked(). */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_frames(struct pel_client *client,
                  const Pelagos__FramesRequest *request, Pelagos__Frames **out,
                  struct pel_client_error *error);

/* Which sea is asked for, and what of it. */
struct pel_client_sea {
    const double *time_s; /* simulated time, 0..1e9; NULL: the clock's, or the
                           * frame's */
    uint64_t frame;       /* number of one of the last 64 frames: the sea that
                           * it shows; 0: the present one */
    bool acceleration;    /* of the water too [m/s2] */
    bool foam;            /* its share of the water too */
};

/* Height, normal and velocity (and acceleration, foam) of the sea surface at
 * `count` points (1..10,000) given as east, north [m] from the scene's origin.
 * sea: NULL for the present one. The answers are in the order of the points.
 * Above 3,000 points it takes several requests, all for the time of the first.
 */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_surface(struct pel_client *client, const double (*east_north_m)[2],
                   size_t count, const struct pel_client_sea *sea,
                   Pelagos__Surface **out, struct pel_client_error *error);

/* The numbers of the sea in force, or of the one that query->patch would make;
 * the scene stays as it is. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_spectrum(struct pel_client *client,
                    const Pelagos__SpectrumQuery *query,
                    Pelagos__Spectrum **out, struct pel_client_error *error);

/* The models that there are, or the one of query->name. Free *out with
 * pelagos__models__free_unpacked(). */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_models(struct pel_client *client, const Pelagos__ModelsQuery *query,
                  Pelagos__Models **out, struct pel_client_error *error);

/* The recordings on the server, after `command` (NULL: it is only asked). Free
 * *out with pelagos__recordings__free_unpacked(). */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code pel_client_recordings(
    struct pel_client *client, const Pelagos__RecordingCommand *command,
    Pelagos__Recordings **out, struct pel_client_error *error);

/* What the debrief is after `command`, which may say nothing: opening a
 * recording and going to a moment take their time (`busy`). Free *out with
 * pelagos__debrief__free_unpacked(). */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_debrief(struct pel_client *client,
                   const Pelagos__DebriefCommand *command,
                   Pelagos__Debrief **out, struct pel_client_error *error);

/* Lists, loads, starts, pauses, rewinds and stops exercises. Free *out with
 * pelagos__exercise_status__free_unpacked(). */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code pel_client_exercise(
    struct pel_client *client, const Pelagos__ExerciseCommand *command,
    Pelagos__ExerciseStatus **out, struct pel_client_error *error);

/* The nodes that show the exercise; no name: the server is none of them. Free
 * *out with pelagos__cluster__free_unpacked(). */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_cluster(struct pel_client *client, Pelagos__Cluster **out,
                   struct pel_client_error *error);

/* Places a view at a node of the exercise, or without command->node no more;
 * the nodes afterwards, as above. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_place(struct pel_client *client,
                 const Pelagos__ClusterPlaceCommand *command,
                 Pelagos__Cluster **out, struct pel_client_error *error);

/* Numbers of light (query->brdf or query->sky), of the state in force or of
 * what query->patch would make of it; the scene stays as it is. Free *out with
 * pelagos__optics__free_unpacked(). */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_optics(struct pel_client *client, const Pelagos__OpticsQuery *query,
                  Pelagos__Optics **out, struct pel_client_error *error);

/* The same question at each combination of the values of query->sweep's axes,
 * as lists or, by query->format, as a file in (*out)->file. Free *out with
 * pelagos__series__free_unpacked(). */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_series(struct pel_client *client, const Pelagos__SeriesQuery *query,
                  Pelagos__Series **out, struct pel_client_error *error);

/* Advances simulated time by `seconds` (0..3600) in mode STEPPED; CONFLICT in
 * any other. *out (NULL allowed): the state after it. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_step(struct pel_client *client, double seconds, Pelagos__State **out,
                struct pel_client_error *error);

/* Advances simulated time to the very moment time_s, from the present time to
 * 1e9 s; otherwise as pel_client_step. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_step_to(struct pel_client *client, double time_s,
                   Pelagos__State **out, struct pel_client_error *error);

/* Asks for the state now and after each change. The first is in *out; later
 * ones come from pel_client_next_state. Other calls may be made in between: of
 * the states that arrive meanwhile the newest is kept. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_watch(struct pel_client *client, Pelagos__State **out,
                 struct pel_client_error *error);

/* The next state of a watched connection. Nothing new within timeout_ms (-1:
 * waits for ever): PEL_CLIENT_TIMEOUT, and the client stays usable. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_client_next_state(struct pel_client *client, int timeout_ms,
                      Pelagos__State **out, struct pel_client_error *error);

/* --- live pictures -------------------------------------------------------
 *
 * Motion-JPEG over HTTP, on a connection of its own, without a client. */

/* Where pelagosd's HTTP listens unless told otherwise, and the variable of the
 * environment that overrides it. */
#define PEL_LIVE_DEFAULT_URL "http://127.0.0.1:8080"
#define PEL_LIVE_URL_VARIABLE "PELAGOS_URL"

struct pel_live;

struct pel_live_frame {
    uint64_t number;     /* of the frame, counted since the daemon's start */
    double time_s;       /* simulated time */
    uint64_t revision;   /* of the state it shows */
    uint64_t dropped;    /* pictures passed over so far for newer ones */
    uint32_t host_frame; /* of the simulator host that it shows, 0: none */
    bool stale; /* an input of `sources` was silent when it was drawn */
    const uint8_t *data; /* a whole JPEG file, until the next call */
    size_t size;
};

/* Opens the stream of a view at `url` ("http://HOST:PORT", or "https:" through
 * a proxy; NULL: $PELAGOS_URL, else the default), with the environment's token.
 * fps: at most so many pictures (0.1..240;
 * 0: as they are drawn); quality: of JPEG (1..100; 0: the daemon's choice).
 * Ends within timeout_ms; NOT_FOUND: no such view. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_live_open(const char *url, const char *view, double fps, int quality,
              int timeout_ms, struct pel_live **out,
              struct pel_client_error *error);

/* The newest picture that has come; waits at most timeout_ms (-1: for ever)
 * for one that was not handed out yet. TIMEOUT leaves the stream usable;
 * CLOSED: the daemon ended it, or the view was removed. A caller who is slow
 * gets fewer pictures, never old ones. */
PEL_CLIENT_API PEL_CLIENT_CHECK enum pel_client_code
pel_live_next(struct pel_live *live, int timeout_ms,
              struct pel_live_frame *frame, struct pel_client_error *error);

/* Ends and frees; NULL allowed. */
PEL_CLIENT_API void pel_live_close(struct pel_live *live);

/* Name of a code, e.g. "OUT_OF_RANGE"; never NULL. */
PEL_CLIENT_API const char *pel_client_code_name(enum pel_client_code code);

#ifdef __cplusplus
}
#endif
