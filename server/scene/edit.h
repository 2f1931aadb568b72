/* Edits of a State: copy, remove, merge, stamp poses. No tests of values: that
 * is check.h. Control thread. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"

/* Every singular part of the state there, every absent field that has a
 * default set to it; poses without a time get time_s. */
void pel_state_fill(Pelagos__State *state, double time_s);

/* The scene of a first start: entity 1, `ownship`, and the view `bridge`. */
Pelagos__State *pel_state_default(void);

/* A patched copy of `from` (complete, with clock.time of now). Faults:
 * NOT_FOUND, CONFLICT (a name that is not unique), INVALID (no key),
 * OUT_OF_RANGE (too many elements). */
PEL_CHECK enum pel_err pel_state_apply(const Pelagos__State *from,
                                       const Pelagos__Patch *patch,
                                       Pelagos__State **out,
                                       struct pel_fault *fault);

/* The same, made of `old` (message.h), which is given up even where the patch
 * is refused. */
PEL_CHECK enum pel_err pel_state_apply_onto(Pelagos__State *old,
                                            const Pelagos__State *from,
                                            const Pelagos__Patch *patch,
                                            Pelagos__State **out,
                                            struct pel_fault *fault);

#define PEL_NOTICE 240

/* Names the part of the state that the patch switches off without saying so, in
 * a sentence; "": nothing. So far: the helm of a ship that the patch gives a
 * pose or a rate. */
void pel_state_notice(const Pelagos__State *from, const Pelagos__Patch *patch,
                      char out[PEL_NOTICE]);
