/* The state file: State as JSON, replaced whole. Control thread. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"

/* Reads, fills and tests the file. NOT_FOUND: there is none. IO: the system
 * does not let us read it. Any other error: it does not load; it has then been
 * renamed to PATH.bad. */
PEL_CHECK enum pel_err pel_store_load(const char *path, Pelagos__State **out,
                                      struct pel_fault *fault);

/* Writes PATH by temporary file, fsync, rename and fsync of the directory:
 * after a crash either the old or the new state is there. */
PEL_CHECK enum pel_err pel_store_save(const char *path,
                                      const Pelagos__State *state,
                                      struct pel_fault *fault);
