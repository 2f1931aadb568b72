/* What a state needs before it can be committed, and what takes too long for
 * the control thread: its sea, built, its bottom, read, and its entities'
 * models, made or read. */
#pragma once

#include "pelagos.pb-c.h"
#include "scene/build.h"
#include "scene/fleet.h"
#include "scene/ground.h"
#include "scene/skyfile.h"
#include "scene/weatherfile.h"
#include "scene/worker.h"

/* Where files lie; NULL: nowhere. */
struct pel_files {
    const char *bathymetry, *models, *panoramas, *weather;
    bool forgiving; /* entities may go without their models, the sky
                       without its picture, the sea without its weather */
};

/* The sea, the bottom and the models of a state. Zeroed: none. */
struct pel_resources {
    struct pel_fleet fleet;
    struct pel_shared_sea *sea;
    struct pel_ground ground;
    struct pel_sky_file sky;
    struct pel_weather_file weather;
};
void pel_resources_finish(struct pel_resources *resources);
/* The same with references of their own. */
struct pel_resources pel_resources_ref(const struct pel_resources *resources);

/* Whether `state`, tested, has this very sea and this bottom, and no models
 * but these. */
bool pel_resources_fits(const struct pel_resources *resources,
                        const Pelagos__State *state,
                        const struct pel_sea_means *means);

/* The sea, the bottom and the models of `state`, tested: those of `present`
 * where they are the same. Reads files, and waits for them; the sea is built
 * lazily (sharedsea.h). Any thread. */
PEL_CHECK enum pel_err pel_resources_get(const Pelagos__State *state,
                                         const struct pel_sea_means *means,
                                         const struct pel_files *files,
                                         const struct pel_resources *present,
                                         struct pel_resources *out,
                                         struct pel_fault *fault);

/* One state's preparation: pushed to a worker; `done` is called on the control
 * thread. `means` and `files` outlive it. */
struct pel_preparation {
    struct pel_task task; /* first */
    void (*done)(void *user, struct pel_preparation *ready);
    void *user;
    bool dropped; /* the worker ended before it */
    enum pel_err err;
    struct pel_fault fault;
    struct pel_resources got; /* built; where !err && !dropped */
    /* Its own: */
    Pelagos__State *state;
    const struct pel_sea_means *means;
    const struct pel_files *files;
    struct pel_resources present;
};

/* Begins; takes `state` over and keeps what it needs of `present`. */
struct pel_preparation *pel_preparation_begin(
    struct pel_worker *worker, Pelagos__State *state,
    const struct pel_sea_means *means, const struct pel_files *files,
    const struct pel_resources *present,
    void (*done)(void *user, struct pel_preparation *ready), void *user);
void pel_preparation_free(struct pel_preparation *preparation); /* after done */
