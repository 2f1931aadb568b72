/* The box of pixels in which a light's disc may lie; only these compute it. */
#pragma once

#include <stdbool.h>

#include "render/renderer.h"

struct pel_disc_box { /* pixels, from the top left corner */
    int x, y, width, height;
};

/* A box around a disc of this angular radius towards `to` (unit, world axes)
 * and its softened edge; false: none of it is in the picture. Any thread. */
bool pel_disc_place(const struct pel_camera *c, struct pel_vec3 to,
                    double radius_rad, struct pel_disc_box *out);
