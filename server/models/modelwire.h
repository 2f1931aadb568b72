/* What pelagos-model hands to the daemon: a draft of a model in bytes. The
 * reader works on files from anywhere, so the daemon trusts nothing in them:
 * what pel_model_create does not check is checked here. Both ends are on one
 * machine: numbers are in its own order. */
#pragma once

#include <stdio.h>

#include "models/shape.h"

#define PEL_MODEL_WIRE_MAGIC "pelmodl1"
#define PEL_MODEL_NOTES 480 /* bytes of what was left out, with the NUL */
#define PEL_MODEL_WIRE_MOST ((size_t)192 << 20)

/* Writes geometry, materials, textures and nodes of *m; false: errno. */
bool pel_model_wire_write(FILE *to, const struct pel_model *m,
                          const char *notes);

/* A draft whose arrays lie in `bytes`, or are its own: the bytes, aligned as
 * malloc does, must outlive it. Vertices may be changed. MALFORMED, NO_MEMORY.
 */
PEL_CHECK enum pel_err pel_model_wire_read(unsigned char *bytes, size_t size,
                                           struct pel_model_draft *out,
                                           char notes[PEL_MODEL_NOTES],
                                           struct pel_fault *fault);
