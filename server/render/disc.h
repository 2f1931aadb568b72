/* Where in a picture the Sun's disc may lie, so that only pixels there compute
 * it. */
#pragma once

#include <stdbool.h>

#include "render/renderer.h"

struct pel_disc_box { /* pixels, from the top left corner */
    int x, y, width, height;
};

/* A box around the disc of a Sun towards `sun` (unit, world axes) and its
 * softened edge; false: none of it is in the picture. Any thread. */
bool pel_disc_place(const struct pel_camera *c, struct pel_vec3 sun,
                    struct pel_disc_box *out);
