/* GLSL programs from the embedded, flattened shaders (or, while developing,
 * from a folder). Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "base/err.h"

/* Line `flat` of the flattened text and what follows came from `number` on of
 * file `name`. */
struct pel_shader_line {
    int flat, number;
    const char *name;
};

struct pel_shader_source {
    const char *name;
    const char *text;
    const struct pel_shader_line *lines;
    int line_count;
};

/* Generated; ends with a NULL name. */
extern const struct pel_shader_source pel_shader_sources[];

/* A shader of a folder with its includes, each once, as the build flattens the
 * embedded ones: free() it. NULL: a file cannot be read, or no memory. */
char *pel_shader_read(const char *dir, const char *name);

/* Links the named shaders (stage by suffix .vert .frag .comp; `second` NULL
 * for compute). `defines` is inserted after #version, NULL for none. GPU with
 * the compiler's words, traced to file and line, when it fails. */
PEL_CHECK enum pel_err pel_program_create(const char *shader_dir,
                                          const char *first, const char *second,
                                          const char *defines, GLuint *out,
                                          struct pel_fault *fault);
