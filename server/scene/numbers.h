/* The numbers of the scene's sea, or of what an edit would make of it. Control
 * thread. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"
#include "scene/scene.h"

/* Gets the answer, or the fault where err; both are the caller's. */
typedef void (*pel_spectrum_done)(void *user, enum pel_err err,
                                  const struct pel_fault *fault,
                                  const Pelagos__Spectrum *answer);

/* Answers the query on a thread of its own, where a sea that is not in force is
 * built for it; nothing of the scene changes. Faults as of a patch, and those
 * of the query's own fields: at once, and then `done` is not called; else it is
 * called once, never from here. At most 128 wait, BUSY beyond. */
PEL_CHECK enum pel_err pel_scene_ask_spectrum(
    struct pel_scene *scene, const Pelagos__SpectrumQuery *query,
    pel_spectrum_done done, void *user, struct pel_fault *fault);

/* The same, waiting for the answer: for tests. Free *out with
 * pelagos__spectrum__free_unpacked(). */
PEL_CHECK enum pel_err pel_scene_spectrum(struct pel_scene *scene,
                                          const Pelagos__SpectrumQuery *query,
                                          Pelagos__Spectrum **out,
                                          struct pel_fault *fault);
