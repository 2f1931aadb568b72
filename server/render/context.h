/* A windowless OpenGL 4.5 core context through EGL. Render thread only. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"

struct pel_context {
    void *display; /* EGLDisplay */
    void *context; /* EGLContext */
    bool software;
    bool tells_loss;       /* pel_context_lost knows */
    char description[256]; /* GL_RENDERER, GL_VERSION */
};

/* Numbers of the EGL devices that are hardware and open, at most `most`; their
 * count. Any thread. */
size_t pel_context_hardware(unsigned *numbers, size_t most);

/* Makes a context on `device` ("auto": hardware if there is any, "software",
 * or the number of an EGL device) current on this thread. */
PEL_CHECK enum pel_err pel_context_init(struct pel_context *context,
                                        const char *device, bool debug,
                                        struct pel_fault *fault);
/* Whether the device was reset or withdrawn: what the context holds is gone,
 * and calls do nothing from then on. A new one has to be made. */
bool pel_context_lost(const struct pel_context *context);
void pel_context_finish(struct pel_context *context);
