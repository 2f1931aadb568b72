/* Inside of pelagos-model: a mesh's file becomes a shape in the model's frame.
 */
#pragma once

#include <stdint.h>

#include "models/describe.h"
#include "models/modelwire.h"

/* What was asked. */
struct pel_mesh_request {
    const char *path; /* "./ferry/ferry.glb", in the working directory */
    enum pel_axis bow, up;
    double scale, length_m; /* 0: not said */
    double draught_m;       /* < 0: not said */
};

/* Sentences about what was left out, the first that have room. */
struct pel_mesh_notes {
    char text[PEL_MODEL_NOTES];
};
void pel_mesh_note(struct pel_mesh_notes *notes, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Reads the file into *shape, in the frame of models/model.h. INVALID,
 * OUT_OF_RANGE: *fault says why. */
PEL_CHECK enum pel_err pel_mesh_read(const struct pel_mesh_request *request,
                                     struct pel_shape *shape,
                                     struct pel_mesh_notes *notes,
                                     struct pel_fault *fault);

/* A glTF file may need extensions that the library passes over and then makes
 * rubbish of: INVALID where it requires such a one. */
PEL_CHECK enum pel_err pel_gltf_check(const char *path,
                                      struct pel_fault *fault);

/* Decodes a PNG or a JPEG, made smaller by whole factors until no side is above
 * `most`; rows from below. OUT_OF_RANGE: it says that it has more than 16384
 * pixels a side, or 2^28 in all, and nothing was allocated for it. INVALID:
 * neither form, or damaged. *out's pixels are never freed. */
PEL_CHECK enum pel_err pel_picture_read(const uint8_t *bytes, size_t size,
                                        int most, struct pel_model_texture *out,
                                        struct pel_fault *fault);
