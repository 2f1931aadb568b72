/* The network: HTTP (people, browsers, scripts) and length-delimited protobuf
 * over TCP and a Unix socket (simulators, programs). Everything happens on the
 * control thread, in the default GLib main context; nothing here blocks.
 *
 * A command changes the scene or is refused with a fault; slow and vanished
 * clients cost bounded memory; every limit is in struct pel_net_limits. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/allow.h"
#include "base/err.h"
#include "base/metrics.h"
#include "cluster/cluster.h"
#include "frames/debrief.h"
#include "frames/frames.h"
#include "scene/exercise.h"
#include "scene/scene.h"

struct pel_net;

struct pel_net_limits {
    unsigned http_connections;  /* at once, 1..4096 */
    unsigned http_per_source;   /* of one address that is not loopback */
    unsigned http_per_loopback; /* of 127.0.0.0/8 and ::1 together; an eighth
                                 * is not for streams */
    size_t http_body_bytes;     /* of a JSON body, 1 KiB..1 MiB */
    double http_header_s;       /* from connecting to the end of the headers */
    double http_body_s;         /* from there to the end of the body */
    double http_idle_s;         /* between two requests of one connection */
    double http_stall_s;        /* a reader that takes nothing */
    double http_answer_s;       /* a whole answer that is not a stream */
    unsigned sessions;          /* protobuf, of TCP and of Unix each */
    unsigned session_requests;  /* in flight in one session */
    size_t session_message_bytes; /* of one request */
    size_t session_output_bytes;  /* waiting for one slow reader */
    double session_login_s;       /* from connecting to the token */
    double session_message_s;     /* from a message's first byte to its last */
    double session_stall_s;       /* a reader that takes nothing */
};

/* Of bounds.def; http_idle_s 15, http_stall_s 30. */
void pel_net_limits_default(struct pel_net_limits *limits);

struct pel_net_options {
    const char *http_address; /* numeric IPv4 or IPv6; NULL: no HTTP */
    uint16_t http_port;       /* 0: any free one */
    const char *tcp_address;  /* as http_address; NULL: no protobuf on TCP */
    uint16_t tcp_port;
    const char *rtsp_address; /* as http_address; NULL: no RTSP */
    uint16_t rtsp_port;
    const char *unix_path;  /* NULL: no Unix socket; made with mode 0600 */
    bool allow_remote;      /* else an address that is not loopback is refused;
                             * means something with a token only */
    const char *token_path; /* clients of HTTP, TCP and RTSP must give this
                             * file's token (net/token.h); NULL: nothing */
    const char *tls_cert_path, *tls_key_path; /* PEM; TCP and RTSP speak TLS
                                               * only; NULL: none */
    /* Names besides `localhost` and plain addresses that a Host header may
     * give (a proxy's), NULL-terminated; NULL: none. */
    const char *const *http_hosts;
    /* Other origins whose pages may ask for pictures; NULL: none. */
    const char *const *http_origins;
    /* Numeric addresses whose X-Forwarded-For is believed; NULL: none. */
    const char *const *http_proxies;
    /* Of WebRTC: UDP ports (0: any), servers of STUN and TURN as in
     * wheppeer.h; NULL: none. Media come from http_address. */
    uint16_t whep_port_min, whep_port_max;
    const char *const *whep_servers;
    struct pel_allow whep_peers;     /* as pel_whep_places */
    struct pel_exercises *exercises; /* NULL: none */
    struct pel_cluster *cluster;     /* NULL: none */
    struct pel_metrics *metrics; /* shown at /metrics; joined by the net's */
    struct pel_debrief *debrief;
    struct pel_net_limits limits;
};

/* Binds and listens. Errors: INVALID (an address), CONFLICT (not loopback
 * without allow_remote and token; a Unix path in use or not a socket), IO
 * (bind), and those of pel_token_create and pel_tls_create. The strings of
 * *options must live as long as the net; the scene must not be edited after the
 * net's end. */
PEL_CHECK enum pel_err pel_net_create(const struct pel_net_options *options,
                                      struct pel_scene *scene,
                                      struct pel_frames *frames,
                                      struct pel_net **out,
                                      struct pel_fault *fault);

/* Reads the tokens and the certificate again; what cannot be read stays as it
 * was, and the log says why. Clients whose token is gone, or has a lower role
 * now, end; those of other tokens notice nothing. */
void pel_net_reload(struct pel_net *net);

/* The first picture is drawn: /readyz says that clients may be sent here. */
void pel_net_ready(struct pel_net *net);

/* Refuses new clients and new requests from now on; `done` is called once no
 * request is under way (streams and idle clients do not count), or within_ms
 * later. */
void pel_net_drain(struct pel_net *net, int within_ms, void (*done)(void *user),
                   void *user);

/* Closes every client and the sockets, cancels their requests, removes the
 * Unix path. Call before pel_frames_destroy. NULL allowed. */
void pel_net_destroy(struct pel_net *net);

/* The ports bound, for port 0 in the options; 0 where off. */
uint16_t pel_net_http_port(const struct pel_net *net);
uint16_t pel_net_tcp_port(const struct pel_net *net);
