/* Textures of a model's materials as the objects' shaders read them: texels of
 * four words behind the triangles' (lib/paint.glsl). Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "models/model.h"
#include "shaders/lib/blocks.h"

/* Reflectances at our wavelengths that look under a high Sun like this linear
 * colour, 0..1. */
void pel_model_reflectance(const float colour[3], float out[3]);

/* Whether a material is alpha-tested. */
bool pel_model_has_holes(const struct pel_model *model);

/* How many texels of four words they take; 0: no material has any. */
size_t pel_model_paint_size(const struct pel_model *model);

/* Writes them, the first of which is texel `first` of its buffer, and puts
 * texel and size of each material's into words 6 and 7 of its
 * PEL_OBJECT_MATERIAL_TEXELS, 0 where it has none. A texture is resampled to
 * powers of two, multiplied by the material's colour, and halved down to one
 * texel; square roots of reflectances in bytes, in the fourth the share that is
 * no hole. `out` 0: no memory. */
bool pel_model_paint_write(const struct pel_model *model, uint32_t first,
                           uint32_t *out, float *materials);
