/* The numbers of the scene's sea, or of what an edit would make of it. Control
 * thread. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"
#include "scene/scene.h"

/* Answers the query; nothing of the scene changes. Faults as of a patch, and
 * those of the query's own fields. Free *out with
 * pelagos__spectrum__free_unpacked(). Up to 100 ms of work, for the cascades of
 * a sea that is not in force. */
PEL_CHECK enum pel_err pel_scene_spectrum(struct pel_scene *scene,
                                          const Pelagos__SpectrumQuery *query,
                                          Pelagos__Spectrum **out,
                                          struct pel_fault *fault);
