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
