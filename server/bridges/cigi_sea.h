/* What a CIGI host's edits want of the sea and what takes too long for the
 * control thread: another sea, which a thread builds before it is committed,
 * and the heights below clamped entities in a sea of FFT or of ship waves. Of
 * both the newest
 * alone is worked for, so that a host that changes its wind or moves a buoy
 * with each frame is never behind. Control thread. */
#pragma once

#include <stdbool.h>

#include "bridges/cigi_world.h"
#include "scene/scene.h"

struct pel_cigi_sea;

struct pel_cigi_sea_calls {
    /* A sea was refused when it was built. */
    void (*refused)(void *user, const struct pel_fault *fault);
    /* Heights are known for followers of the world: edit anew. */
    void (*known)(void *user);
    void *user;
};

struct pel_cigi_sea *
pel_cigi_sea_create(struct pel_scene *scene, struct pel_cigi_world *world,
                    const struct pel_cigi_sea_calls *calls);
void pel_cigi_sea_destroy(struct pel_cigi_sea *self); /* NULL allowed */

/* Commits a patch of sea.* alone when its sea is built; while one is, the later
 * ones become one. */
void pel_cigi_sea_ask(struct pel_cigi_sea *self, const Pelagos__Patch *patch);

/* Asks for the heights below all clamped followers at time_s, where they take
 * a thread; while it works, the newest question waits. */
void pel_cigi_sea_find_heights(struct pel_cigi_sea *self,
                               const struct pel_snapshot *snapshot,
                               double time_s);

/* Waits until neither is under way: for tests. */
void pel_cigi_sea_settle(struct pel_cigi_sea *self);
