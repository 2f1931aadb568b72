/* Where sealed frames go and where they come from: what an exercise of several
 * nodes needs of a store, and no more. This one is etcd's (etcd.h), in keys
 * below the exercise's: `log`, `master`, `head`, `nodes/NAME`, `place`. Control
 * thread; nothing waits. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/err.h"
#include "pelagos.pb-c.h"

struct pel_seals;

/* What the store has of an exercise. Borrowed for a call. */
struct pel_seals_view {
    const Pelagos__ClusterMaster *master; /* NULL: nobody ever was */
    const Pelagos__ClusterHead *head;     /* NULL: no state is there; nor is it
                                           * where it was not asked for */
    uint64_t head_revision;               /* of the store, at the head */
    uint64_t number;                  /* of the last sealed frame; 0: none */
    const Pelagos__SealedFrame *last; /* it; NULL: none */
};

/* Where views are placed. Borrowed for a call. */
struct pel_seals_places {
    const Pelagos__ClusterPlaces *places; /* NULL: none, or none that a daemon
                                           * has put */
    uint64_t version;  /* how often it was put; 0: it is not there */
    uint64_t revision; /* of the store, when that was so */
};

/* What the store tells by itself. */
struct pel_seals_events {
    /* Frame `number` was sealed; each in order, but some may be missing. */
    void (*frame)(void *user, uint64_t number,
                  const Pelagos__SealedFrame *frame, uint64_t revision);
    void (*master)(void *user, const Pelagos__ClusterMaster *master);
    void (*node)(void *user, const Pelagos__ClusterNode *node);
    void (*places)(void *user, const struct pel_seals_places *what);
    /* It does not keep the frames that are asked for any more. */
    void (*lost)(void *user);
    void *user;
};

struct pel_seals_options {
    const char *url;             /* ENDPOINT[,ENDPOINT...]/EXERCISE */
    const char *cert, *key, *ca; /* PEM files; NULL: none */
    struct pel_seals_events events;
};

/* INVALID: the URL. */
PEL_CHECK enum pel_err pel_seals_create(const struct pel_seals_options *options,
                                        struct pel_seals **out,
                                        struct pel_fault *fault);
void pel_seals_destroy(struct pel_seals *seals); /* NULL allowed */

/* How something that was asked ends. yes: it was done; and what the store had
 * when it was not. */
typedef void (*pel_seals_done)(void *user, bool yes, uint64_t revision,
                               const struct pel_seals_view *view);

/* Each of these takes the place of those before that are not answered yet:
 * their `done` is not called. */

/* What there is: yes always. Before it the places are told, then the nodes. */
void pel_seals_look(struct pel_seals *seals, pel_seals_done done, void *user);

/* Begins an exercise that is not there. */
void pel_seals_found(struct pel_seals *seals,
                     const Pelagos__ClusterMaster *master,
                     const Pelagos__ClusterHead *head, pel_seals_done done,
                     void *user);

/* Seals frame `number`, if `master` still is, and the last is the one before.
 */
void pel_seals_put(struct pel_seals *seals,
                   const Pelagos__ClusterMaster *master, uint64_t number,
                   const Pelagos__SealedFrame *frame, pel_seals_done done,
                   void *user);

/* Makes `to` the master, if `from` still is, and the last frame is `number`. */
void pel_seals_take(struct pel_seals *seals, const Pelagos__ClusterMaster *from,
                    uint64_t number, const Pelagos__ClusterMaster *to,
                    pel_seals_done done, void *user);

/* Nobody waits for what was asked any more. */
void pel_seals_drop(struct pel_seals *seals);

/* The same, but what was asked is let to end, so that its connection can be
 * used again. */
void pel_seals_ignore(struct pel_seals *seals);

/* Told by events from now on: the frames after that revision of the store. */
void pel_seals_follow(struct pel_seals *seals, uint64_t after_revision);
/* The same by another way: this one is silent. */
void pel_seals_elsewhere(struct pel_seals *seals);

/* The state for those who join, if `master` still is. */
void pel_seals_head(struct pel_seals *seals,
                    const Pelagos__ClusterMaster *master,
                    const Pelagos__ClusterHead *head);

/* What a node says of itself. if_idle: unless the one before is under way. */
void pel_seals_node(struct pel_seals *seals, const Pelagos__ClusterNode *node,
                    bool if_idle);

/* Puts where views are placed, if that is of `version` still, and `master`
 * (NULL: whoever) is. One at a time, beside what is asked above; it is called
 * off by pel_seals_places_drop. `done`: yes, it was put; and what the store has
 * now. */
typedef void (*pel_seals_placed)(void *user, bool yes,
                                 const struct pel_seals_places *now);
void pel_seals_places(struct pel_seals *seals,
                      const Pelagos__ClusterMaster *master, uint64_t version,
                      const Pelagos__ClusterPlaces *places,
                      pel_seals_placed done, void *user);
void pel_seals_places_drop(struct pel_seals *seals);

/* Values there that no daemon has put (CLU-023): they are passed over. */
uint64_t pel_seals_foreign(const struct pel_seals *seals);

/* Attempts to reach the store, and those that failed. */
void pel_seals_count(const struct pel_seals *seals, uint64_t *attempts,
                     uint64_t *failures);
