/* What a state file names and this start does not find: the scene goes on
 * without, the state file keeps it. Control thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "pelagos.pb-c.h"

enum pel_missing_kind {
    PEL_MISSING_SEABED,   /* seabed.file */
    PEL_MISSING_SPECTRUM, /* sea.measured, by sea.spectrum MEASURED */
    PEL_MISSING_COUNT
};

/* Zeroed: nothing is missing. */
struct pel_missing {
    struct {
        char *name; /* what was named; NULL: it is not missing */
        char reason[256];
    } fields[PEL_MISSING_COUNT];
};
void pel_missing_finish(struct pel_missing *missing);

/* The schema's path of what is missing. */
const char *pel_missing_path(enum pel_missing_kind kind);

/* Whether the state names such a file. */
bool pel_missing_may(enum pel_missing_kind kind, const Pelagos__State *state);

/* Notes it, for the reason in `why`, and makes the state one without it. */
void pel_missing_note(struct pel_missing *missing, enum pel_missing_kind kind,
                      Pelagos__State *state, const struct pel_fault *why);

/* An edit that says it anew: what it says holds. */
void pel_missing_edited(struct pel_missing *missing,
                        const Pelagos__Patch *patch);

/* The state as the file is to keep it: a copy with what is missing, to be
 * freed; NULL: nothing is, the state itself. */
Pelagos__State *pel_missing_restored(const struct pel_missing *missing,
                                     const Pelagos__State *state);
