/* The state file: State as JSON, replaced whole; the generation before it stays
 * beside it, for when it is damaged. While it is open a lock on
 * PATH.lock keeps every other daemon from it; the system frees the lock however
 * the process ends. Control thread. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"

/* The file's first member, stateVersion: one more where a program from before
 * could not read what this one writes, or would read it wrongly. A new field
 * needs no new version: a daemon that does not know it keeps the file aside
 * (PATH.bad). Version 2 has stateChecksum, CRC-32C of the file with eight
 * zeroes for it, which may be left out, and stateLineage, which a journal says
 * too that belongs to the file. */
#define PEL_STATE_VERSION 2

/* Behind the file's name: the generation before it. */
#define PEL_STATE_BEFORE ".prev"

struct pel_store;

/* CONFLICT: another process has it. IO: the state could not be written here.
 * *fault says what to do. */
PEL_CHECK enum pel_err pel_store_open(const char *path, struct pel_store **out,
                                      struct pel_fault *fault);
void pel_store_close(struct pel_store *store); /* NULL allowed */

/* Reads, fills and tests the file. NOT_FOUND: there is none. IO: it cannot be
 * read or put aside, or is of a newer version, and then stays as it is. Any
 * other error: it does not load; it lies in *aside too now (PATH.bad, or
 * PATH.bad.2 to .99 where there are older ones: base/aside.h), which is the
 * caller's, g_free. */
PEL_CHECK enum pel_err pel_store_load(struct pel_store *store,
                                      Pelagos__State **out, char **aside,
                                      struct pel_fault *fault);

/* The same of the generation before it, PATH.prev, for when it does not load;
 * *older_s: how much earlier it was written, in seconds. */
PEL_CHECK enum pel_err pel_store_load_before(struct pel_store *store,
                                             Pelagos__State **out,
                                             double *older_s,
                                             struct pel_fault *fault);

/* The file lies in *aside now (PATH.aside, numbered as the others), g_free;
 * NULL: it could not be moved, or there is none. */
char *pel_store_set_aside(struct pel_store *store);

/* The name that the file and its journal share: as loaded, or else new; never
 * NULL. And as loaded; NULL: not known. */
const char *pel_store_lineage(const struct pel_store *store);
const char *pel_store_loaded_lineage(const struct pel_store *store);

/* Writes PATH by temporary file, fsync, rename and fsync of the directory:
 * after a crash either the old or the new state is there. The file that was
 * there becomes PATH.prev, unless it did not load. */
PEL_CHECK enum pel_err pel_store_save(struct pel_store *store,
                                      const Pelagos__State *state,
                                      struct pel_fault *fault);
