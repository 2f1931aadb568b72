/* The models that there are: built in, and files of pelagosd --models. Control
 * thread. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"
#include "scene/scene.h"

/* Gets the answer, or the fault where err; both are the caller's. */
typedef void (*pel_models_done)(void *user, enum pel_err err,
                                const struct pel_fault *fault,
                                const Pelagos__Models *answer);

/* Lists them on a thread: makes and reads those that are not known yet, and
 * files that have changed, for 4 s and one file more at most; what is left then
 * is listed by name alone. `name`: only this one, NULL: all. `done` is called
 * once, never from here, unless this fails: BUSY, 16 ask already. */
PEL_CHECK enum pel_err pel_scene_ask_models(struct pel_scene *scene,
                                            const char *name,
                                            pel_models_done done, void *user,
                                            struct pel_fault *fault);

/* What is known of models so far; the scene's own. */
struct pel_catalogue;
void pel_catalogue_free(struct pel_catalogue *catalogue); /* NULL allowed */
