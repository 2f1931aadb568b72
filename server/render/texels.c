#include "render/texels.h"

void pel_texels_init(struct pel_texels *t, const char *label, const void *data,
                     size_t size)
{
    glCreateBuffers(1, &t->buffer);
    glNamedBufferStorage(t->buffer, (GLsizeiptr)size, data,
                         GL_DYNAMIC_STORAGE_BIT);
    glObjectLabel(GL_BUFFER, t->buffer, -1, label);
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &t->texture);
    glTextureBuffer(t->texture, GL_RGBA32F, t->buffer);
}

void pel_texels_finish(struct pel_texels *t)
{
    glDeleteTextures(1, &t->texture);
    glDeleteBuffers(1, &t->buffer);
    *t = (struct pel_texels){ 0 };
}

void pel_texels_set(const struct pel_texels *t, const void *data, size_t size)
{
    glNamedBufferSubData(t->buffer, 0, (GLsizeiptr)size, data);
}

void pel_sea_texels_init(struct pel_sea_texels *t)
{
    struct pel_block_facets facets;
    pel_fill_facets(&facets);
    pel_texels_init(&t->facets, "facets", &facets, sizeof facets);
    pel_texels_init(&t->variance, "variance", NULL,
                    2 * sizeof(struct pel_variance[PEL_VARIANCE_COUNT - 1][2]));
    pel_texels_init(&t->waves, "waves", NULL, sizeof(struct pel_block_waves));
    pel_sea_texels_bind(t);
}

void pel_sea_texels_finish(struct pel_sea_texels *t)
{
    pel_texels_finish(&t->facets);
    pel_texels_finish(&t->variance);
    pel_texels_finish(&t->waves);
}

void pel_sea_texels_variance(
    struct pel_sea_texels *t,
    const struct pel_variance table[PEL_VARIANCE_COUNT],
    const struct pel_variance breaking[PEL_VARIANCE_COUNT])
{
    struct pel_variance pairs[2][PEL_VARIANCE_COUNT - 1][2];
    pel_pair_variance(table, pairs[0]);
    pel_pair_variance(breaking, pairs[1]);
    pel_texels_set(&t->variance, pairs, sizeof pairs);
}

void pel_sea_texels_bind(const struct pel_sea_texels *t)
{
    glBindTextureUnit(PEL_UNIT_FACETS, t->facets.texture);
    glBindTextureUnit(PEL_UNIT_VARIANCE, t->variance.texture);
}
