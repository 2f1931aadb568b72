/* Protobuf sessions: length-delimited Requests in, Replies out, over TCP and
 * a Unix socket. Control thread.
 *
 * Requests are taken in order; replies come when they are ready and carry the
 * request's id. A message that cannot be read gets an Error and the end of the
 * session; a command that is refused gets an Error and the session goes on.
 * Where there is a token a session over TCP begins with Login.
 * While replies wait for a slow reader nothing more is read from it. Closing
 * the sending side ends the session: requests in flight are cancelled. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/metrics.h"
#include "frames/frames.h"
#include "net/net.h"
#include "net/series.h"
#include "net/token.h"
#include "scene/exercise.h"
#include "scene/scene.h"

struct pel_sessions;

enum pel_transport {
    PEL_TRANSPORT_TCP,
    PEL_TRANSPORT_UNIX,
    PEL_TRANSPORT_COUNT,
};

/* token: what clients over TCP must give; NULL: nothing. Borrowed. */
struct pel_sessions *pel_sessions_create(const struct pel_net_limits *limits,
                                         struct pel_scene *scene,
                                         struct pel_frames *frames,
                                         struct pel_debrief *debrief,
                                         struct pel_token *token);
/* Where what is under way is counted; NULL: nowhere. */
void pel_sessions_claims(struct pel_sessions *all, struct pel_claims *claims);
/* Tokens have changed: the sessions of those that do not hold end. */
void pel_sessions_revoke(struct pel_sessions *all);

/* What makes series of answers. */
void pel_sessions_series(struct pel_sessions *all, struct pel_series *series);
/* What answers commands about exercises; NULL: nothing does. */
void pel_sessions_exercises(struct pel_sessions *all,
                            struct pel_exercises *exercises);
/* Whose nodes a session may ask for; NULL: it is told of none. */
struct pel_cluster;
void pel_sessions_cluster(struct pel_sessions *all,
                          struct pel_cluster *cluster);

void pel_sessions_destroy(struct pel_sessions *sessions); /* NULL allowed */

/* Takes over a non-blocking socket, or returns false: all places are taken and
 * no session has been idle for long enough to make room. Where there is a token
 * places are given at Login, by its role; until then a client has one of those
 * for strangers. */
bool pel_sessions_accept(struct pel_sessions *sessions, int fd,
                         enum pel_transport transport);

/* As pel_listener_on_starved wants it: of those over TCP. */
bool pel_sessions_starved(struct pel_sessions *sessions);

/* No more requests are taken (CONFLICT), for a drain. */
void pel_sessions_stop(struct pel_sessions *sessions);

/* Requests waiting for an answer, in all sessions. */
unsigned pel_sessions_in_flight(const struct pel_sessions *sessions);

/* The scene has changed: watchers are told. */
void pel_sessions_changed(struct pel_sessions *sessions);

void pel_sessions_collect(const struct pel_sessions *sessions,
                          struct pel_metrics_page *page);
