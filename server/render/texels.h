/* Buffers that shaders read as texels of four floats: software devices read
 * the members of storage buffers one by one and lane by lane. Render thread
 * only. */
#pragma once

#include <epoxy/gl.h>
#include <stddef.h>

struct pel_texels {
    GLuint buffer, texture;
};

/* `data`: NULL where pel_texels_set is to fill it. */
void pel_texels_init(struct pel_texels *t, const char *label, const void *data,
                     size_t size);
void pel_texels_finish(struct pel_texels *t);

/* For frames that are submitted from now on. */
void pel_texels_set(const struct pel_texels *t, const void *data, size_t size);
