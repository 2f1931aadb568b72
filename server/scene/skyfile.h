/* The picture of the sky that a state names. Any thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "panorama/panorama.h"
#include "pelagos.pb-c.h"

/* A picture and what it was made from; zeroed: none. */
struct pel_sky_file {
    char *key; /* NULL: none */
    const struct pel_panorama *picture;
};

/* That of a tested, complete state: `present` again where it is the same, else
 * read from `directory` (NULL: none is configured), which waits for the file
 * (panorama/panorama.h). Give *out to pel_sky_file_finish. `forgiving`: a file
 * that cannot be read is reported (SCN-018), and the sky is the computed one.
 * On refusal *fault (NULL allowed) says what is wrong with sky.file. */
PEL_CHECK enum pel_err pel_sky_file_get(const Pelagos__State *state,
                                        const char *directory, bool forgiving,
                                        const struct pel_sky_file *present,
                                        struct pel_sky_file *out,
                                        struct pel_fault *fault);
/* Whether `file` is that of the state. */
bool pel_sky_file_is(const struct pel_sky_file *file,
                     const Pelagos__State *state);
struct pel_sky_file pel_sky_file_ref(const struct pel_sky_file *file);
void pel_sky_file_finish(struct pel_sky_file *file);
