/* What of its surroundings a model's own form hides from its surface: for each
 * vertex, by rays over the hemisphere of its normal. */
#pragma once

#include "models/model.h"

/* Fills `out`, of vertex_count, from levels[0] and the tree of boxes; vertices
 * that it does not use, or that lie inside the model, see everything. The
 * waterplane z = 0 is the sea: what lies under it hides nothing from above.
 * Eight to sixteen rays from each corner of a triangle, the same ones for the
 * same model, a microsecond or two each; models of more than 41,000 triangles
 * hide nothing. Any thread. */
void pel_model_openness(const struct pel_model *model,
                        struct pel_model_open *out);
