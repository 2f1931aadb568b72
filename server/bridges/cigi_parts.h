/* Inside of the CIGI bridge: what it keeps, between cigi.c (datagrams, frames,
 * the host's session) and cigi_socket.c. Control thread. */
#pragma once

#include <netinet/in.h>

#include <glib.h>

#include "bridges/cigi.h"
#include "bridges/cigi_answers.h"
#include "bridges/cigi_exercise.h"
#include "bridges/cigi_periodic.h"
#include "bridges/cigi_sea.h"
#include "bridges/cigi_world.h"
#include "bridges/endpoint.h"
#include "scene/scene.h"

#define MAX_DATAGRAM 65536
#define BATCH 64         /* datagrams that become one edit */
#define MAX_ANSWER 16384 /* bytes of a datagram to the host */
#define RECEIVE_BUFFER (4 << 20)
#define TURN_NS 2000000LL /* then the loop serves others */
#define RESTART_NS 500000000LL
#define RESTART_FRAMES 1000 /* further back than any delay */
#define TICK_S 1e-5         /* of timestamps */
#define MAX_STEP_S 10.0     /* a longer one is a jump, and one frame is taken */
#define EXTRAPOLATE_S 1.0
#define LOAD_NS 1000000000LL /* a host that never says 0 is told by then */

enum database_state { DATABASE_NONE, DATABASE_LOADING, DATABASE_LOADED };

struct pel_cigi {
    struct pel_cigi_options options;
    struct pel_scene *scene;
    struct pel_allow allow;
    int fd, timer_fd;
    uint16_t port;
    guint fd_source, timer_source;
    struct pel_cigi_counters counters;

    struct sockaddr_storage host;
    socklen_t host_size;             /* 0: nobody to send to */
    struct pel_target *host_target;  /* NULL: who was heard */
    struct sockaddr_storage speaker; /* who leads */
    bool shown;                      /* in the metrics */

    unsigned told_versions; /* bits: hosts of them were told */
    bool unsent;            /* the newest frame */
    bool refused;           /* the newest host frame's packets were */
    bool led;               /* a host is heard; the rest is its session's */
    bool lead_pending;      /* clock.mode is still to be set */
    enum pel_clock_mode mode_before; /* the host, FREE, PACED or STEPPED */
    bool little;
    unsigned minor, mode;
    int64_t opened_ns, heard_ns;
    int64_t told_ns; /* the first frame since the host was heard; 0: none */
    uint32_t host_frame, ig_frame, timestamp;
    bool stamped;
    double host_time_s;  /* simulated time of host_frame */
    double applied_s;    /* that the scene had when it took effect */
    double seen_s;       /* that the scene had when it was looked at last */
    double period_s;     /* of the host's frames, smoothed */
    uint32_t on_the_way; /* frames the host had not heard of */

    int database, wanted_database; /* as sent, as the host asks for it */
    enum database_state database_state;
    int64_t database_ns;

    struct pel_cigi_world world;
    struct pel_cigi_edit *edit;
    struct pel_cigi_exercise exercise;
    struct pel_cigi_sea *sea;
    struct pel_cigi_shapes *shapes; /* NULL: no table of types */
    struct pel_cigi_periodic periodic;
    struct pel_cigi_answers *answers;
    struct pel_cigi_reader batch[BATCH]; /* into `in`: not applied yet */
    size_t batch_count, in_used;
    bool batch_first, batch_reset;
    uint8_t in[4 * MAX_DATAGRAM], out[MAX_ANSWER];
};

/* Puts a datagram to those that become the next edit; false: malformed, or not
 * new. Its bytes stay until pel_cigi_apply. */
bool pel_cigi_take(struct pel_cigi *cigi, const uint8_t *bytes, size_t size);

/* Makes the edit of what was taken. */
void pel_cigi_apply(struct pel_cigi *cigi);

/* cigi_socket.c */
PEL_CHECK enum pel_err pel_cigi_open_sockets(struct pel_cigi *cigi,
                                             struct pel_fault *fault);
void pel_cigi_close_sockets(struct pel_cigi *cigi);
