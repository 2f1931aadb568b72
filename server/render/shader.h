/* GLSL programs from the embedded, flattened shaders (or, while developing,
 * from a folder). Render thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>

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
 * for compute). `shader_dir` and the names live as long as the context.
 * `defines` is inserted after #version, NULL for none. GPU with the compiler's
 * words, traced to file and line, when it fails. */
PEL_CHECK enum pel_err pel_program_create(const char *shader_dir,
                                          const char *first, const char *second,
                                          const char *defines, GLuint *out,
                                          struct pel_fault *fault);
void pel_program_delete(GLuint program); /* 0 is none */

/* Programs that are created from now on in this context may still be compiled
 * when pel_program_create is back, several at a time, where the driver does
 * that. Not those of a folder. A context that ends waits for the driver's
 * threads, so: until they are not wanted any more, which takes as long. */
void pel_program_side_by_side(void);
void pel_program_one_by_one(void);
/* Waits for them. GPU, as pel_program_create, of the first that fails; then
 * pel_program_failed, and the next context's are made one by one. */
PEL_CHECK enum pel_err pel_program_settle(struct pel_fault *fault);

/* Whether shading reads waves and mesh from storage buffers of their own: on
 * hardware that has bindings for them, of which OpenGL promises eight. */
bool pel_sea_is_stored(bool software);

/* What shaders are told of it: PEL_HARDWARE, and then PEL_STORED. */
const char *pel_hardware_defines(bool software);

/* What weeks of weathers, lights and traffic have needed once would never be
 * given back: a software device keeps 1 to 2 MB of a program. A view of the
 * open sea has some 20, a wall of many kinds of views 40. So of each context's
 * programs beyond `most` those that nobody has used for `idle_s` [s] are
 * unloaded, the longest unused first, while pictures are drawn. Any thread, for
 * all contexts. */
#define PEL_PROGRAM_MOST 32
#define PEL_PROGRAM_IDLE_S 120.0
void pel_program_limits(unsigned most, double idle_s);
unsigned pel_program_count(void); /* of all contexts; any thread */

/* Draws with `program` from now on, 0: with none. One that was unloaded is made
 * again, and its uniforms are zero: set them after this. */
void pel_program_use(GLuint program);

/* Whether one could not be: what was drawn with this context is not right. */
bool pel_program_failed(void);

/* For a context that ends, on its thread. */
void pel_program_forget_all(void);
