/* Linked programs as the driver's own binaries, kept for the life of the
 * process: a renderer that is made anew after a loss of the device links none
 * of them again. Any thread with a current context. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>

/* Bytes of binaries that are kept at most; what comes later is not. */
#define PEL_BINARIES_MOST (64 << 20)

/* Links `program` from what was kept under `key` by this driver; false: there
 * is nothing, or the driver wants it compiled. */
bool pel_binaries_link(const char *key, GLuint program);

/* Whether any is kept: some renderer of the process has had its programs. */
bool pel_binaries_any(void);

/* Keeps a linked program that had GL_PROGRAM_BINARY_RETRIEVABLE_HINT. Without
 * memory, or where the driver gives no binaries, nothing is kept. */
void pel_binaries_keep(const char *key, GLuint program);
