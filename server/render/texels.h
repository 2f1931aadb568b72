/* Buffers that shaders read as texels of four floats: software devices read
 * the members of storage buffers one by one and lane by lane. Render thread
 * only. */
#pragma once

#include <epoxy/gl.h>
#include <stddef.h>

#include "render/uniforms.h"

struct pel_texels {
    GLuint buffer, texture;
};

/* `data`: NULL where pel_texels_set is to fill it. */
void pel_texels_init(struct pel_texels *t, const char *label, const void *data,
                     size_t size);
void pel_texels_finish(struct pel_texels *t);

/* For frames that are submitted from now on. */
void pel_texels_set(const struct pel_texels *t, const void *data, size_t size);

/* What shading knows of the sea besides its fields. */
struct pel_sea_texels {
    struct pel_texels facets, variance, waves;
};

void pel_sea_texels_init(struct pel_sea_texels *t);
void pel_sea_texels_finish(struct pel_sea_texels *t);
void pel_sea_texels_variance(
    struct pel_sea_texels *t,
    const struct pel_variance table[PEL_VARIANCE_COUNT],
    const struct pel_variance breaking[PEL_VARIANCE_COUNT]);

/* All but the waves, in their units. */
void pel_sea_texels_bind(const struct pel_sea_texels *t);
