#include "render/arena.h"

#include <stdint.h>
#include <string.h>

#include "base/log.h"

static enum pel_err allocate(struct pel_arena *a, size_t capacity)
{
    const GLbitfield bits =
        GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    /* Every part starts on the alignment of what is bound from it. */
    capacity = (capacity + a->alignment - 1) / a->alignment * a->alignment;
    size_t size = capacity * PEL_ARENA_FRAMES;
    glDeleteBuffers(1, &a->buffer);
    glCreateBuffers(1, &a->buffer);
    glNamedBufferStorage(a->buffer, (GLsizeiptr)size, NULL, bits);
    glObjectLabel(GL_BUFFER, a->buffer, -1, "arena");
    a->map = glMapNamedBufferRange(a->buffer, 0, (GLsizeiptr)size, bits);
    a->capacity = a->map ? capacity : 0;
    return a->map ? PEL_OK : PEL_ERR_GPU;
}

enum pel_err pel_arena_init(struct pel_arena *a, size_t capacity)
{
    *a = (struct pel_arena){ 0 };
    GLint uniform = 256, storage = 256, texels = 16;
    glGetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &uniform);
    glGetIntegerv(GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT, &storage);
    glGetIntegerv(GL_TEXTURE_BUFFER_OFFSET_ALIGNMENT, &texels);
    /* All are powers of two. */
    a->alignment = (size_t)(uniform | storage | texels);
    while (a->alignment & (a->alignment - 1)) {
        a->alignment &= a->alignment - 1;
    }
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &a->texels);
    return allocate(a, capacity);
}

static void wait_part(struct pel_arena *a, int part)
{
    if (a->fences[part]) {
        glClientWaitSync(a->fences[part], GL_SYNC_FLUSH_COMMANDS_BIT,
                         UINT64_C(5000000000));
        glDeleteSync(a->fences[part]);
        a->fences[part] = NULL;
    }
}

void pel_arena_finish(struct pel_arena *a)
{
    for (int i = 0; i < PEL_ARENA_FRAMES; i++) {
        if (a->fences[i]) {
            glDeleteSync(a->fences[i]);
        }
    }
    glDeleteTextures(1, &a->texels);
    glDeleteBuffers(1, &a->buffer);
    *a = (struct pel_arena){ 0 };
}

enum pel_err pel_arena_begin(struct pel_arena *a, size_t capacity)
{
    a->part = (a->part + 1) % PEL_ARENA_FRAMES;
    a->used = 0;
    if (capacity > a->capacity) {
        for (int i = 0; i < PEL_ARENA_FRAMES; i++) {
            wait_part(a, i);
        }
        return allocate(a, capacity);
    }
    wait_part(a, a->part);
    return PEL_OK;
}

void pel_arena_end(struct pel_arena *a)
{
    a->fences[a->part] = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
}

bool pel_arena_put(struct pel_arena *a, const void *data, size_t size,
                   size_t *offset)
{
    size_t start = (a->used + a->alignment - 1) / a->alignment * a->alignment;
    if (start + size > a->capacity) {
        pel_error("RND-030", "uniform arena of %zu bytes is too small",
                  a->capacity);
        return false;
    }
    *offset = (size_t)a->part * a->capacity + start;
    memcpy(a->map + *offset, data, size);
    a->used = start + size;
    return true;
}

size_t pel_arena_bind(struct pel_arena *a, GLenum target, GLuint index,
                      const void *data, size_t size)
{
    size_t offset = 0;
    if (pel_arena_put(a, data, size, &offset)) {
        glBindBufferRange(target, index, a->buffer, (GLintptr)offset,
                          (GLsizeiptr)size);
    }
    return offset;
}

void pel_arena_texels(struct pel_arena *a, GLuint texture, GLuint unit,
                      const void *data, size_t size)
{
    size_t offset = 0;
    if (pel_arena_put(a, data, size, &offset)) {
        glTextureBufferRange(texture, GL_RGBA32F, a->buffer, (GLintptr)offset,
                             (GLsizeiptr)size);
        glBindTextureUnit(unit, texture);
    }
}
