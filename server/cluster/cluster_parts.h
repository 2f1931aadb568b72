/* Inside of the cluster. Control thread. */
#pragma once

#include <glib.h>

#include "cluster/cluster.h"
#include "cluster/seals.h"

#define PEL_DIGEST_SIZE 32
#define PEL_SEAL_WINDOW 512

struct pel_cluster_node {
    Pelagos__ClusterNode *said; /* the last */
    int64_t heard_ns;           /* when that was another */
    /* The same by pel_cluster.listened_ns; while it shows the exercise. */
    bool spoke;
    int64_t spoke_ns;
    int64_t limit_ns; /* how long it may say nothing, as it said then */
    int64_t began_ns; /* since then without a pause */
};

/* A state as a seal's digest is of it. */
struct pel_packed {
    uint8_t *bytes; /* NULL: none */
    size_t size;
};

struct pel_cluster {
    struct pel_cluster_options options;
    char *name, *address, *program;
    struct pel_scene *scene;
    struct pel_frames *frames;
    struct pel_seals *seals;
    Pelagos__ClusterRole role;
    Pelagos__ClusterMaster *master; /* who is, as far as known; NULL: nobody */
    bool alike;                     /* our pictures are the head's to the bit */
    uint8_t canary[PEL_DIGEST_SIZE]; /* of the picture that each node draws */
    uint64_t canary_id;              /* of the request; 0: none */
    guint settled;                   /* idle source, after that */
    bool asking;    /* the store, for something that decides who we are */
    bool following; /* the state is that of frame `number` of the log */
    bool strayed;
    uint64_t term;     /* with which we ask to take over */
    char *silent;      /* from whom; NULL: never yet */
    int64_t silent_ns; /* how long he was silent then */
    uint64_t goal;     /* frames that there are, of one who joins */
    guint patience;    /* timer */
    guint beats;       /* timer */
    guint retry;       /* timer; 0: none */
    int64_t joined_ns;

    /* The last sealed frame. */
    uint64_t number;
    const struct pel_snapshot *snapshot;
    double time_s;
    uint64_t present_unix_ns;
    uint32_t host_frame;
    double quality; /* scale of its live views; 0: nobody has said */
    uint8_t digest[PEL_DIGEST_SIZE];
    struct pel_packed packed; /* its state; where it is not kept, nothing */
    int64_t sealed_ns; /* when we came to know of it, or of another master */

    /* The master's. */
    GSource *tick;
    int64_t next_tick_ns;
    bool overdue;       /* a frame is due, and the one before not sealed */
    GPtrArray *entries; /* Pelagos__LogEntry accepted since the last frame */
    struct {
        bool on;
        uint64_t number;
        const struct pel_snapshot *snapshot;
        double time_s;
        uint64_t present_unix_ns;
        uint32_t host_frame;
        uint8_t digest[PEL_DIGEST_SIZE];
        struct pel_packed packed;
        GPtrArray *entries; /* what the frame has */
        double quality;
        int64_t begun_ns;
        Pelagos__ClusterHead *head; /* goes to the store after it; NULL: none */
    } pending;
    int64_t head_ns; /* of the last head */

    GPtrArray *nodes; /* struct pel_cluster_node */
    bool unlike;      /* our --quality is another than the seals', said */
    bool full;        /* there is no room for another, and that was said */
    uint64_t unlisted;
    uint64_t beat, quarters, seconds;
    double quickest_ms; /* from a seal to our knowing of it, lately */
    double quickest_next_ms;

    /* How long the store has told us things: pauses of it count little, so
     * that nobody is taken for gone because the store, or we, stood. */
    int64_t told_ns; /* when it did last */
    int64_t listened_ns;
    int64_t since_ns; /* of that, when we began to join */

    struct {
        Pelagos__ClusterPlaces *known; /* NULL: not yet */
        uint64_t version, revision;    /* of the store */
        GQueue edits;                  /* struct edit of placing.c */
        bool putting;                  /* the first of them, or who draws */
        int64_t put_ns;
        uint64_t moves;
    } placing;
    GHashTable *warmed; /* names of placed views */
    uint64_t warm_id;   /* of the request; 0: none */

    float sealed_ms[PEL_SEAL_WINDOW];
    uint64_t sealed, gaps, differences, takeovers, stepped_down, joins, coasted;
    double worst_gap_ms;
};

/* cluster.c */
bool pel_cluster_is_name(const char *name);
/* The store tells something. */
void pel_cluster_hear(struct pel_cluster *c);
/* This node takes part, and the store has told something lately. */
bool pel_cluster_is_current(const struct pel_cluster *c);
int64_t pel_cluster_unix_ns(const struct pel_cluster *c);
void pel_cluster_digest(const Pelagos__State *state,
                        uint8_t out[PEL_DIGEST_SIZE]);
/* The same, and the state packed, where somebody keeps what is sealed; what
 * *packed was is freed. */
void pel_cluster_pack(const struct pel_cluster *c, const Pelagos__State *state,
                      uint8_t digest[PEL_DIGEST_SIZE],
                      struct pel_packed *packed);
void pel_cluster_know_master(struct pel_cluster *c,
                             const Pelagos__ClusterMaster *master);
bool pel_cluster_is_me(const struct pel_cluster *c,
                       const Pelagos__ClusterMaster *master);
/* What a client reads that edits here. */
void pel_cluster_lead(struct pel_cluster *c);
/* Shows the last sealed frame; coasting: further on by elapsed seconds. */
void pel_cluster_show(struct pel_cluster *c, bool coasts, double further_s);
/* The last sealed frame is this now; takes over the snapshot. */
void pel_cluster_advance(struct pel_cluster *c, uint64_t number,
                         const struct pel_snapshot *snapshot, double time_s,
                         uint64_t present_unix_ns, uint32_t host_frame,
                         const uint8_t digest[PEL_DIGEST_SIZE]);

/* keep.c: the last sealed frame, to those who record and keep what is sealed;
 * entries NULL: none; anew: the steps of the ships begin anew with it. */
void pel_cluster_keep(struct pel_cluster *c, Pelagos__LogEntry *const *entries,
                      size_t count, bool anew);
/* The node begins with this state, that of the last sealed frame or before the
 * first one. */
void pel_cluster_keep_begin(struct pel_cluster *c);

/* canary.c: draws that picture, and then joins. */
void pel_cluster_draw_canary(struct pel_cluster *c);

/* follower.c */
/* Begins anew with what the store has. */
void pel_cluster_join(struct pel_cluster *c);
void pel_cluster_on_frame(void *user, uint64_t number,
                          const Pelagos__SealedFrame *frame, uint64_t revision);
void pel_cluster_on_master(void *user, const Pelagos__ClusterMaster *master);
void pel_cluster_on_lost(void *user);
/* Takes over, where the master has been silent for long enough. */
void pel_cluster_be_patient(struct pel_cluster *c);

/* master.c */
void pel_cluster_become_master(struct pel_cluster *c);
void pel_cluster_step_down(struct pel_cluster *c, const char *why);
/* For entries; empty. */
GPtrArray *pel_cluster_entries(void);
/* A frame is due. */
void pel_cluster_seal(struct pel_cluster *c);
/* Ours was sealed. */
void pel_cluster_confirm(struct pel_cluster *c, uint64_t revision);
void pel_cluster_on_command(void *user, double time_s,
                            const Pelagos__Patch *patch);
void pel_cluster_drop_pending(struct pel_cluster *c);
Pelagos__ClusterHead *pel_cluster_head(struct pel_cluster *c, uint64_t number,
                                       const Pelagos__State *state);

/* nodes.c */
void pel_cluster_on_node(void *user, const Pelagos__ClusterNode *node);
/* Once a second whole; else only where views are placed, that it is there. */
void pel_cluster_say(struct pel_cluster *c, bool whole);
struct pel_cluster_node *pel_cluster_find(const struct pel_cluster *c,
                                          const char *name);
/* Whether a node shows the exercise; one that has not been heard of yet does,
 * for some time. */
bool pel_cluster_is_there(const struct pel_cluster *c,
                          const struct pel_cluster_node *node);
bool pel_cluster_is_steady(const struct pel_cluster *c,
                           const struct pel_cluster_node *node);
/* The master of before: if it does not say something at once it is gone. */
void pel_cluster_suspect(struct pel_cluster *c, const char *name);
void pel_cluster_heard(struct pel_cluster *c, const Pelagos__Seal *seal);
/* The longest that a node takes from a seal to its pictures [ns]. */
int64_t pel_cluster_slowest_ns(const struct pel_cluster *c);
/* Scale of live views that the slowest node draws in time, or that is fixed on
 * this one. */
double pel_cluster_quality(const struct pel_cluster *c);
/* How many nodes take over before this one. */
unsigned pel_cluster_order(const struct pel_cluster *c);
void pel_cluster_nodes_free(struct pel_cluster *c);

/* placing.c */
void pel_cluster_on_places(void *user, const struct pel_seals_places *what);
/* Goes on with what is to be put. */
void pel_cluster_place_on(struct pel_cluster *c);
/* How many views are placed; how many of them others draw. */
size_t pel_cluster_place_count(const struct pel_cluster *c, size_t *elsewhere);
/* Where a view is placed; NULL: nowhere. */
const Pelagos__ClusterPlace *pel_cluster_place_of(const struct pel_cluster *c,
                                                  const char *view);
/* A copy for people, with what the store does not have. */
Pelagos__ClusterPlace *pel_cluster_place_copy(const struct pel_cluster *c,
                                              const Pelagos__ClusterPlace *p);
void pel_cluster_places_free(struct pel_cluster *c);

/* warm.c: draws a small picture of each view that this node has, or would take,
 * once, so that its programs are there before a client is. */
void pel_cluster_warm(struct pel_cluster *c);
void pel_cluster_warm_free(struct pel_cluster *c);
