#include "render/binaries.h"

#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

struct binary {
    struct binary *next;
    uint64_t driver; /* of another, it means nothing */
    GLenum format;
    GLsizei size;
    char *key;
    void *bytes;
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct binary *kept;
static size_t kept_bytes;

static uint64_t driver_number(void)
{
    static const GLenum names[] = { GL_VENDOR, GL_RENDERER, GL_VERSION };
    uint64_t number = 0;
    for (int i = 0; i < 3; i++) {
        for (const GLubyte *c = glGetString(names[i]); c && *c; c++) {
            number = number * 31 + *c;
        }
    }
    return number;
}

static struct binary *find(const char *key, uint64_t driver)
{
    struct binary *b = kept;
    while (b && (b->driver != driver || strcmp(b->key, key) != 0)) {
        b = b->next;
    }
    return b;
}

static void discard(struct binary *b)
{
    if (b) {
        free(b->key);
        free(b->bytes);
        free(b);
    }
}

bool pel_binaries_any(void)
{
    pthread_mutex_lock(&lock);
    bool any = kept != NULL;
    pthread_mutex_unlock(&lock);
    return any;
}

bool pel_binaries_link(const char *key, GLuint program)
{
    uint64_t driver = driver_number();
    pthread_mutex_lock(&lock);
    const struct binary *b = find(key, driver);
    pthread_mutex_unlock(&lock); /* what is kept stays */
    if (!b) {
        return false;
    }
    glProgramBinary(program, b->format, b->bytes, b->size);
    GLint ok = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &ok);
    return ok;
}

void pel_binaries_keep(const char *key, GLuint program)
{
    GLint size = 0;
    glGetProgramiv(program, GL_PROGRAM_BINARY_LENGTH, &size);
    struct binary *b = size > 0 ? calloc(1, sizeof *b) : NULL;
    if (!b) {
        return;
    }
    b->driver = driver_number();
    b->key = strdup(key);
    b->bytes = malloc((size_t)size);
    if (b->key && b->bytes) {
        glGetProgramBinary(program, size, &b->size, &b->format, b->bytes);
    }
    pthread_mutex_lock(&lock);
    if (b->size > 0 && !find(key, b->driver) &&
        kept_bytes + (size_t)b->size <= PEL_BINARIES_MOST) {
        kept_bytes += (size_t)b->size;
        b->next = kept;
        kept = b;
        b = NULL;
    }
    pthread_mutex_unlock(&lock);
    discard(b);
}
