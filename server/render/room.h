/* Memory of the device that grows with what is asked of it. Render thread. */
#ifndef PELAGOS_RENDER_ROOM_H
#define PELAGOS_RENDER_ROOM_H

#include <epoxy/gl.h>
#include <stddef.h>

/* What is no larger stays, however little of it is used. */
#define PEL_ROOM_KEPT ((size_t)32 << 20)

/* Makes *buffer hold so many bytes, or less than it does where that is less
 * than a quarter; what was in it is lost then. Both 0 before the first call. */
static inline void pel_room_fit(GLuint *buffer, size_t *capacity, size_t bytes,
                                const char *label)
{
    if (bytes > *capacity ||
        (*capacity > PEL_ROOM_KEPT && bytes < *capacity / 4)) {
        glDeleteBuffers(1, buffer);
        glCreateBuffers(1, buffer);
        glNamedBufferStorage(*buffer, (GLsizeiptr)bytes, NULL, 0);
        glObjectLabel(GL_BUFFER, *buffer, -1, label);
        *capacity = bytes;
    }
}

#endif
