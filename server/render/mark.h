/* The mark of pictures that show silent inputs: an amber border and, where it
 * fits, STALE with the inputs' names on black in the upper left corner. */
#pragma once

#include <epoxy/gl.h>
#include <stdint.h>

/* Draws over the colour attachment of `framebuffer`, whose row 0 is the
 * row first_row of a picture of width x height, and which has `rows`, both from
 * `corner` on; stale: bits of enum pel_stale. Render thread; leaves the scissor
 * test off. */
void pel_mark_stale(GLuint framebuffer, uint32_t width, uint32_t height,
                    uint32_t first_row, uint32_t rows, int corner,
                    unsigned stale);
