/* What a device made of a picture (pel_draw.ycbcr), as encoders take it. */
#pragma once

#include "encode/planes.h"
#include "render/renderer.h"

/* Fills `out` with pointers into the picture, valid until it is released;
 * false: the picture came as something else. Any thread. */
bool pel_picture_planes(const struct pel_picture *picture,
                        struct pel_planes_given *out);

/* The same of its scan; NULL: it came as something else. */
const struct pel_jpeg_scan *pel_picture_scan(const struct pel_picture *picture);
