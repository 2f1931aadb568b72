/* One exercise on several nodes: every daemon shows the same frames of the same
 * log (docs/cluster.md). One of them, the master, takes the inputs; each frame
 * is what its scene accepted since the one before, and is shown by all, and its
 * commands answered, when the store has it and not earlier. The others are led
 * by the log. Where the master falls silent another one goes on.
 *
 * Control thread. */
#pragma once

#include "base/err.h"
#include "base/metrics.h"
#include "frames/frames.h"
#include "pelagos.pb-c.h"
#include "scene/exercise.h"
#include "scene/scene.h"
#include "scene/sealedlog.h"

struct pel_cluster;

struct pel_cluster_options {
    const char *url;             /* as pel_seals_options */
    const char *cert, *key, *ca; /* PEM; NULL: none */
    const char *name;            /* of this node; NULL: the machine's */
    const char *address;         /* where clients reach it */
    int rank;                    /* the lowest takes over first; -1: never */
    bool spare;                  /* takes views of nodes that are gone */
    double rate_hz;              /* of frames, 1 to 240 */
    const char *program;         /* "pelagosd 0.2.0" */
    int wave_count;
    struct pel_sealedlog *log; /* is told of every sealed frame; NULL: nobody
                                * records */
    struct pel_exercises *exercises; /* borrowed; NULL: none */
    uint64_t stray;  /* for tests: the frame after which this node has another
                      * state; 0: none */
    double ahead_ms; /* for tests: of our clock, before the machine's */
};

/* Looks for the exercise; meanwhile the scene is led and pictures are stale.
 * Whoever is first begins the exercise with its scene. INVALID: the URL, the
 * name. */
PEL_CHECK enum pel_err
pel_cluster_create(const struct pel_cluster_options *options,
                   struct pel_scene *scene, struct pel_frames *frames,
                   struct pel_cluster **out, struct pel_fault *fault);

/* Before the frames and the scene; NULL allowed. */
void pel_cluster_destroy(struct pel_cluster *cluster);

/* The rate from the next frame on. */
void pel_cluster_set_rate(struct pel_cluster *cluster, double rate_hz);

/* Who is there, as seen from here; NULL: of a daemon by itself.
 * pelagos__cluster__free_unpacked. */
Pelagos__Cluster *pel_cluster_status(struct pel_cluster *cluster);

/* Places a view at a node, or without one no more, whichever node this is: the
 * store has it when `done` is called, exactly once. Refusals that are known at
 * once are returned instead: CONFLICT: no exercise, or this node joins it;
 * NOT_FOUND: the view; INVALID: the node's name. `done`: NOT_FOUND: it was not
 * placed; BUSY: too many are, or the store does not answer. */
typedef void (*pel_cluster_done)(void *user, enum pel_err err,
                                 const struct pel_fault *fault);
PEL_CHECK enum pel_err
pel_cluster_place(struct pel_cluster *cluster,
                  const Pelagos__ClusterPlaceCommand *command,
                  pel_cluster_done done, void *user, struct pel_fault *fault);

/* Who draws a view; *here: this node may be asked for it: it draws it now, or
 * nobody in particular does. Of a daemon by itself (NULL) always; never while
 * this node is not up to date. pelagos__cluster_place__free_unpacked. */
Pelagos__ClusterPlace *pel_cluster_placed(struct pel_cluster *cluster,
                                          const char *view, bool *here);

/* Metrics `pelagos_cluster_...`; user: the cluster. */
void pel_cluster_collect(void *user, struct pel_metrics_page *page);
