/* What HTTP and the sessions have in common: commands tested against the
 * schema, and answers as messages. Control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <protobuf-c/protobuf-c.h>

#include "base/err.h"
#include "frames/frames.h"
#include "pelagos.pb-c.h"
#include "scene/numbers.h"

/* Tests every number that is present in a command, to any depth: finite, and
 * in the range of the schema's comment, and every enum: known. Faults name the
 * path inside the command (`points.3.east`). */
PEL_CHECK enum pel_err pel_command_check(const ProtobufCMessage *command,
                                         struct pel_fault *fault);

/* Reads the text of one number field (`name`: JSON name) of a message type:
 * decimal, finite, whole where the field is, in the schema's range. */
PEL_CHECK enum pel_err
pel_command_number(const ProtobufCMessageDescriptor *type, const char *name,
                   const char *text, double *out, struct pel_fault *fault);

/* Sets *fault (NULL allowed) with path and value as given and a message that
 * begins with the path; returns code. */
enum pel_err pel_fault_value(struct pel_fault *fault, enum pel_err code,
                             const char *path, const char *value,
                             const char *message);

/* Checks a query (at most 10,000 points, each with both coordinates) and hands
 * it to pel_frames_surface as a query of `asker`'s, whose next query may be
 * predicted (NULL: none), and of that rank, to be answered in that form (NULL:
 * samples). */
PEL_CHECK enum pel_err pel_command_surface(
    struct pel_frames *frames, const Pelagos__SurfaceQuery *query,
    const void *asker, enum pel_rank rank, const struct pel_surface_form *form,
    pel_surface_callback done, void *user, struct pel_fault *fault);

/* Tests a spectrum query, the patch in it as any other, and asks the scene
 * (pel_scene_ask_spectrum). */
PEL_CHECK enum pel_err pel_command_spectrum(struct pel_scene *scene,
                                            const Pelagos__SpectrumQuery *query,
                                            pel_spectrum_done done, void *user,
                                            struct pel_fault *fault);

/* Samples as a message; free with pel_surface_message_free. */
Pelagos__Surface *pel_surface_message(double time_s,
                                      const struct pel_surface_sample *samples,
                                      size_t count);
void pel_surface_message_free(Pelagos__Surface *surface);

/* Checks the query's numbers and asks; as pel_frames_optics. */
PEL_CHECK enum pel_err pel_command_optics(struct pel_frames *frames,
                                          const Pelagos__OpticsQuery *query,
                                          pel_optics_callback done, void *user,
                                          struct pel_fault *fault);

/* The delimited bytes of a Reply with an Error; malloc()ed. */
uint8_t *pel_fault_reply(bool has_id, uint64_t id,
                         const struct pel_fault *fault, size_t *size);
