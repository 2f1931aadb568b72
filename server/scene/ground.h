/* The height field that a state names. Any thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "pelagos.pb-c.h"
#include "seabed/seabed.h"

/* A height field and what it was made from; zeroed: none. */
struct pel_ground {
    char *key; /* NULL: none */
    const struct pel_seabed *bed;
};

/* The bottom of a tested, complete state, in its local frame: `present` again
 * where it is the same, else read from `directory` (NULL: none is configured),
 * which waits for the file (seabed/load.h). Give *out to pel_ground_finish.
 * On refusal *fault (NULL allowed) says what is wrong with seabed.file. */
PEL_CHECK enum pel_err pel_ground_get(const Pelagos__State *state,
                                      const char *directory,
                                      const struct pel_ground *present,
                                      struct pel_ground *out,
                                      struct pel_fault *fault);
/* Whether `ground` is that of the state. */
bool pel_ground_is(const struct pel_ground *ground,
                   const Pelagos__State *state);
void pel_ground_finish(struct pel_ground *ground);

/* Makes the state one that names no file. */
void pel_ground_forget(Pelagos__State *state);
