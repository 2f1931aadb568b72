/* Presets: changes of the state under a name. Control thread. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"

/* Of a state: no more than PEL_BOUND_PRESETS, names well formed and each
 * once. OUT_OF_RANGE, INVALID, CONFLICT. */
PEL_CHECK enum pel_err pel_presets_check(const Pelagos__State *state,
                                         struct pel_fault *fault);

/* The change that a preset makes, its values within their ranges, however the
 * state looks: MALFORMED, NOT_FOUND, INVALID, OUT_OF_RANGE, with the path
 * `presets.NAME.patch`. INVALID too where it changes presets. Free *out with
 * pelagos__patch__free_unpacked(). */
PEL_CHECK enum pel_err pel_preset_patch(const Pelagos__Preset *preset,
                                        Pelagos__Patch **out,
                                        struct pel_fault *fault);

/* The same of all those that a patch brings. */
PEL_CHECK enum pel_err pel_presets_brought(const Pelagos__State *patch,
                                           struct pel_fault *fault);

/* Tests them ahead, so that the same is quick afterwards. Any thread. */
void pel_presets_learn(const Pelagos__State *patch);
