#include "render/shader.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/log.h"
#include "render/binaries.h"

#define MOST_SHADER (1 << 20) /* bytes of a file */
#define MOST_FILES 128
#define MOST_NAME 64

static const struct pel_shader_source *find_source(const char *name)
{
    for (const struct pel_shader_source *s = pel_shader_sources; s->name; s++) {
        if (strcmp(s->name, name) == 0) {
            return s;
        }
    }
    return NULL;
}

static bool append(char **text, size_t *size, const char *more, size_t length)
{
    char *grown = realloc(*text, *size + length + 1);
    if (!grown) {
        return false;
    }
    *text = grown;
    memcpy(*text + *size, more, length);
    *size += length;
    grown[*size] = '\0';
    return true;
}

/* A text that is put together from files, each of which it has once. */
struct flat {
    const char *dir;
    char *text;
    size_t size;
    int count;
    char names[MOST_FILES][MOST_NAME]; /* of files that are in it */
};

static bool has_file(const struct flat *flat, const char *name)
{
    for (int i = 0; i < flat->count; i++) {
        if (strcmp(flat->names[i], name) == 0) {
            return true;
        }
    }
    return false;
}

/* Appends file `name` with its includes; false when one cannot be read. */
static bool read_flat(struct flat *flat, const char *name)
{
    char path[512];
    if (has_file(flat, name)) {
        return true;
    }
    if (flat->count == MOST_FILES || strlen(name) >= MOST_NAME) {
        return false;
    }
    bool inner_file = flat->count > 0;
    strcpy(flat->names[flat->count++], name);
    snprintf(path, sizeof path, "%s/%s", flat->dir, name);
    char *file = NULL;
    size_t length = 0;
    if (pel_file_read(path, MOST_SHADER, &file, &length, NULL)) {
        /* lib/layers.glsl is made by the build. */
        const struct pel_shader_source *made = find_source(name);
        return inner_file && made &&
               append(&flat->text, &flat->size, made->text, strlen(made->text));
    }
    bool ok = true;
    for (const char *line = file; ok && *line;) {
        const char *end = strchrnul(line, '\n');
        end += *end == '\n';
        char inner[256];
        const char *word = line + strspn(line, " \t");
        ok = sscanf(word, "#include \"%255[^\"]\"", inner) == 1
                 ? read_flat(flat, inner)
                 : append(&flat->text, &flat->size, line, (size_t)(end - line));
        line = end;
    }
    free(file);
    return ok;
}

char *pel_shader_read(const char *dir, const char *name)
{
    struct flat flat = { .dir = dir };
    if (!read_flat(&flat, name)) {
        free(flat.text);
        return NULL;
    }
    return flat.text;
}

static void log_compiler_words(const char *name, const char *words)
{
    const struct pel_shader_source *s = find_source(name);
    int flat = 0;
    /* Mesa and NVIDIA write "0:LINE" and "0(LINE)". */
    if (sscanf(words, "%*d%*1[:(]%d", &flat) == 1 && s) {
        const struct pel_shader_line *at = &s->lines[0];
        for (int i = 0; i < s->line_count && s->lines[i].flat <= flat; i++) {
            at = &s->lines[i];
        }
        pel_error("RND-010", "%s: at %s:%d", name, at->name,
                  at->number + flat - at->flat);
    }
    for (int size = 0; *words; words += size + (words[size] != '\0')) {
        size = (int)strcspn(words, "\n");
        pel_error("RND-011", "%s: %.*s", name, size, words);
    }
}

static enum pel_err compile(const char *dir, const char *name,
                            const char *defines, GLuint *out,
                            struct pel_fault *fault)
{
    char *loaded = NULL;
    const struct pel_shader_source *source = find_source(name);
    const char *text = source ? source->text : NULL;
    if (dir) {
        text = loaded = pel_shader_read(dir, name);
    }
    if (!text) {
        free(loaded);
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND, "no shader %s in %s",
                             name, dir ? dir : "the program");
    }
    const char *suffix = strrchr(name, '.');
    GLenum stage = strcmp(suffix, ".vert") == 0   ? GL_VERTEX_SHADER
                   : strcmp(suffix, ".frag") == 0 ? GL_FRAGMENT_SHADER
                                                  : GL_COMPUTE_SHADER;
    /* #version must stay first: the defines go behind its line. */
    const char *body = strchr(text, '\n') + 1;
    const char *parts[] = { text, defines ? defines : "", body };
    GLint lengths[] = { (GLint)(body - text), (GLint)strlen(parts[1]),
                        (GLint)strlen(body) };
    GLuint shader = glCreateShader(stage);
    glShaderSource(shader, 3, parts, lengths);
    glCompileShader(shader);
    free(loaded);
    GLint ok = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (!ok) {
        char words[2048] = "";
        glGetShaderInfoLog(shader, sizeof words, NULL, words);
        log_compiler_words(name, words);
        glDeleteShader(shader);
        return pel_fault_set(fault, PEL_ERR_GPU, "%s does not compile: %.160s",
                             name, words);
    }
    *out = shader;
    return PEL_OK;
}

/* Compiles and links into `program`. */
static enum pel_err build(const char *shader_dir, const char *first,
                          const char *second, const char *defines,
                          GLuint program, struct pel_fault *fault)
{
    GLuint shaders[2] = { 0, 0 };
    enum pel_err err = compile(shader_dir, first, defines, &shaders[0], fault);
    if (err == PEL_OK && second) {
        err = compile(shader_dir, second, defines, &shaders[1], fault);
    }
    if (err == PEL_OK) {
        for (int i = 0; i < 2; i++) {
            if (shaders[i]) {
                glAttachShader(program, shaders[i]);
            }
        }
        glLinkProgram(program);
        for (int i = 0; i < 2; i++) {
            if (shaders[i]) {
                glDetachShader(program, shaders[i]); /* or it is kept with it */
            }
        }
        GLint ok = 0;
        glGetProgramiv(program, GL_LINK_STATUS, &ok);
        if (!ok) {
            char words[2048] = "";
            glGetProgramInfoLog(program, sizeof words, NULL, words);
            log_compiler_words(first, words);
            err = pel_fault_set(fault, PEL_ERR_GPU, "%s does not link: %.160s",
                                first, words);
        }
    }
    for (int i = 0; i < 2; i++) {
        glDeleteShader(shaders[i]); /* 0 is none */
    }
    return err;
}

enum pel_err pel_program_create(const char *shader_dir, const char *first,
                                const char *second, const char *defines,
                                GLuint *out, struct pel_fault *fault)
{
    /* A folder's shaders may change. */
    char *key = NULL;
    if (shader_dir || asprintf(&key, "%s %s %s", first, second ? second : "",
                               defines ? defines : "") < 0) {
        key = NULL;
    }
    GLuint program = glCreateProgram();
    enum pel_err err = PEL_OK;
    if (!key || !pel_binaries_link(key, program)) {
        glProgramParameteri(program, GL_PROGRAM_BINARY_RETRIEVABLE_HINT,
                            key != NULL);
        err = build(shader_dir, first, second, defines, program, fault);
        if (err == PEL_OK && key) {
            pel_binaries_keep(key, program);
        }
    }
    free(key);
    if (err != PEL_OK) {
        glDeleteProgram(program);
        program = 0;
    } else {
        glObjectLabel(GL_PROGRAM, program, -1, second ? second : first);
    }
    *out = program;
    return err;
}
