/* Uniforms of a frame: mapped memory that is written once and read by the
 * frame's draws. Render thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"

#define PEL_ARENA_FRAMES 3

struct pel_arena {
    GLuint buffer;
    unsigned char *map;
    size_t capacity, used; /* of one frame's part */
    size_t alignment;
    GLuint texels; /* what pel_arena_texels binds */
    int part;      /* 0..PEL_ARENA_FRAMES-1 */
    GLsync fences[PEL_ARENA_FRAMES];
};

PEL_CHECK enum pel_err pel_arena_init(struct pel_arena *a, size_t capacity);
void pel_arena_finish(struct pel_arena *a);

/* Starts the next frame with room for `capacity` bytes: waits until the GPU no
 * longer reads its part. */
PEL_CHECK enum pel_err pel_arena_begin(struct pel_arena *a, size_t capacity);
void pel_arena_end(struct pel_arena *a);

/* Copies data in: its offset in the buffer; false, and an error is logged: the
 * room that pel_arena_begin reserved is used up. */
bool pel_arena_put(struct pel_arena *a, const void *data, size_t size,
                   size_t *offset);

/* Copies data in and binds it to an indexed target (GL_UNIFORM_BUFFER or
 * GL_SHADER_STORAGE_BUFFER). The room was reserved by pel_arena_begin.
 * Returns its offset in the buffer. */
size_t pel_arena_bind(struct pel_arena *a, GLenum target, GLuint index,
                      const void *data, size_t size);

/* The same as texels of four floats of a buffer texture (a->texels, or one of
 * the caller's), in a texture unit; each texture once a draw. */
void pel_arena_texels(struct pel_arena *a, GLuint texture, GLuint unit,
                      const void *data, size_t size);
