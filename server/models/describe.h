/* What NAME.json beside a model's file says of it: the schema's
 * ModelDescription. Any thread. */
#pragma once

#include "models/model.h"

enum pel_axis { /* as the schema's ModelAxis */
                PEL_AXIS_X,
                PEL_AXIS_MINUS_X,
                PEL_AXIS_Y,
                PEL_AXIS_MINUS_Y,
                PEL_AXIS_Z,
                PEL_AXIS_MINUS_Z,
                PEL_AXIS_NONE, /* not said */
};

#define PEL_DESCRIPTION_MOST 65536 /* bytes of the file */

/* Metres; 0 where it is not said. */
struct pel_model_description {
    enum pel_model_class class;
    enum pel_axis bow, up;
    double scale, length_m, beam_m, height_m;
    double draught_m; /* NAN: not said */
    size_t eye_count, light_count;
    struct pel_model_eye eyes[PEL_MODEL_MOST_EYES];
    struct pel_model_light lights[PEL_MODEL_MOST_LIGHTS];
};

/* One that says nothing. */
void pel_model_description_init(struct pel_model_description *out);

/* Reads the text. MALFORMED, NOT_FOUND (no such field), INVALID,
 * OUT_OF_RANGE: *fault names field, value and range. */
PEL_CHECK enum pel_err
pel_model_description_read(const char *text, size_t length,
                           struct pel_model_description *out,
                           struct pel_fault *fault);
