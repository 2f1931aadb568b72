/* Models from files, by a process of their own (pelagos-model, beside the
 * program or in ../libexec/pelagos): the library that reads meshes, and what
 * bad files do to it, stay out of the daemon. */
#pragma once

#include "models/describe.h"
#include "models/modelwire.h"

#define PEL_MODEL_LOAD_MS 5000

/* Endings of files that are read, "glb gltf obj …", NULL at the end. */
extern const char *const pel_model_endings[];
bool pel_model_is_file(const char *name); /* by its ending */

struct pel_model_source {
    const char *directory;   /* of pelagosd --models; NULL: none */
    const char *file;        /* its path in it: "ferry/ferry.glb" */
    double length_m, beam_m; /* that it is made to have; 0: its own */
};

/* Reads the file and, where there is one, the description beside it; waits, at
 * most PEL_MODEL_LOAD_MS. `notes`: what was left out, for people. CONFLICT (no
 * directory), INVALID (the path; what is in the file), NOT_FOUND,
 * OUT_OF_RANGE, MALFORMED, IO, NO_MEMORY: *fault says what is wrong. Any
 * thread. */
PEL_CHECK enum pel_err pel_model_load(const struct pel_model_source *source,
                                      const struct pel_model **out,
                                      char notes[PEL_MODEL_NOTES],
                                      struct pel_fault *fault);
