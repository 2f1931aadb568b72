#include "render/shader.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/log.h"
#include "render/binaries.h"
#include "shaders/lib/blocks.h"

#define MOST_SHADER (1 << 20) /* bytes of a file */
#define MOST_FILES 128
#define MOST_NAME 64
#define LOOK_NS 1000000000
#define MOST_COMPILERS 16       /* threads */
#define MOST_PROGRAMS (1 << 16) /* what a driver numbers higher stays */

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

static GLenum stage_of(const char *name)
{
    const char *suffix = strrchr(name, '.');
    return strcmp(suffix, ".vert") == 0   ? GL_VERTEX_SHADER
           : strcmp(suffix, ".frag") == 0 ? GL_FRAGMENT_SHADER
                                          : GL_COMPUTE_SHADER;
}

/* Begins to compile; how it went has to be asked for. */
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
    /* #version must stay first: the defines go behind its line. */
    const char *body = strchr(text, '\n') + 1;
    const char *parts[] = { text, defines ? defines : "", body };
    GLint lengths[] = { (GLint)(body - text), (GLint)strlen(parts[1]),
                        (GLint)strlen(body) };
    *out = glCreateShader(stage_of(name));
    glShaderSource(*out, 3, parts, lengths);
    glCompileShader(*out);
    free(loaded);
    return PEL_OK;
}

static enum pel_err check_shader(GLuint shader, const char *name,
                                 struct pel_fault *fault)
{
    GLint ok = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok) {
        return PEL_OK;
    }
    char words[2048] = "";
    glGetShaderInfoLog(shader, sizeof words, NULL, words);
    log_compiler_words(name, words);
    return pel_fault_set(fault, PEL_ERR_GPU, "%s does not compile: %.160s",
                         name, words);
}

static enum pel_err check_program(GLuint program, const char *name,
                                  struct pel_fault *fault)
{
    GLint ok = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &ok);
    if (ok) {
        return PEL_OK;
    }
    char words[2048] = "";
    glGetProgramInfoLog(program, sizeof words, NULL, words);
    log_compiler_words(name, words);
    return pel_fault_set(fault, PEL_ERR_GPU, "%s does not link: %.160s", name,
                         words);
}

/* As pel_program_create was given it. */
struct recipe {
    const char *dir, *first, *second, *defines;
};

static void delete_shaders(GLuint program, GLuint shaders[2])
{
    for (int i = 0; i < 2; i++) {
        if (shaders[i]) {
            glDetachShader(program, shaders[i]); /* or it is kept with it */
            glDeleteShader(shaders[i]);
            shaders[i] = 0;
        }
    }
}

/* Begins to compile and link into `program`; finish_build asks how it went. */
static enum pel_err begin_build(const struct recipe *r, GLuint program,
                                GLuint shaders[2], struct pel_fault *fault)
{
    enum pel_err err =
        compile(r->dir, r->first, r->defines, &shaders[0], fault);
    if (err == PEL_OK && r->second) {
        err = compile(r->dir, r->second, r->defines, &shaders[1], fault);
    }
    for (int i = 0; i < 2; i++) {
        if (shaders[i]) {
            glAttachShader(program, shaders[i]);
        }
    }
    if (err == PEL_OK) {
        glLinkProgram(program);
    } else {
        delete_shaders(program, shaders);
    }
    return err;
}

static enum pel_err finish_build(const struct recipe *r, GLuint program,
                                 GLuint shaders[2], struct pel_fault *fault)
{
    enum pel_err err = check_shader(shaders[0], r->first, fault);
    if (err == PEL_OK && r->second) {
        err = check_shader(shaders[1], r->second, fault);
    }
    if (err == PEL_OK) {
        err = check_program(program, r->first, fault);
    }
    delete_shaders(program, shaders);
    return err;
}

/* --- programs of the current context ------------------------------------- */

struct held {
    struct recipe recipe;
    char *defines; /* its own; NULL: not held */
    int64_t used_ns;
    bool loaded;
    GLuint shaders[2]; /* of one that is being compiled, else 0 */
};

/* By the programs' names; a thread has one context. */
static _Thread_local struct {
    struct held *at;
    GLuint count;
    unsigned loaded;
    int64_t look_ns; /* when to look for what is too much */
    bool failed;
    bool side_by_side; /* programs are compiled, while others are asked for */
    unsigned compiling;
} table;
/* One did not compile so: from then on they are made one by one, which says
 * what can be done without. */
static atomic_bool one_by_one;
static atomic_uint all_loaded, most_loaded = PEL_PROGRAM_MOST;
static _Atomic double most_idle_s = PEL_PROGRAM_IDLE_S;

void pel_program_limits(unsigned most, double idle_s)
{
    atomic_store(&most_loaded, most);
    atomic_store(&most_idle_s, idle_s);
}

unsigned pel_program_count(void)
{
    return atomic_load(&all_loaded);
}

bool pel_program_failed(void)
{
    return table.failed;
}

static struct held *held_of(GLuint program)
{
    struct held *h = program < table.count ? &table.at[program] : NULL;
    return h && h->defines ? h : NULL;
}

static void count_loaded(struct held *h, bool loaded)
{
    if (h->loaded != loaded) {
        h->loaded = loaded;
        table.loaded += loaded ? 1 : -1U;
        atomic_fetch_add(&all_loaded, loaded ? 1 : -1U);
    }
}

/* Of one that is being compiled what is to be asked for is not any more. */
static void let_go(struct held *h, GLuint program)
{
    table.compiling -= h->shaders[0] != 0;
    delete_shaders(program, h->shaders);
}

/* Its name stays, since whoever made it has that; a program that does nothing
 * takes the place of what the driver keeps of it. */
static void unload(GLuint program)
{
    static const char *const nothing =
        "#version 450\nlayout(local_size_x = 1) in;\nvoid main() {}\n";
    let_go(held_of(program), program);
    GLuint shader = glCreateShader(GL_COMPUTE_SHADER);
    glShaderSource(shader, 1, &nothing, NULL);
    glCompileShader(shader);
    glAttachShader(program, shader);
    glLinkProgram(program);
    glDetachShader(program, shader);
    glDeleteShader(shader);
    count_loaded(held_of(program), false);
}

/* Marks `program` as used now and unloads what is too much beside it, which is
 * looked for once a second. */
static void mark_used(struct held *h, GLuint program)
{
    const int64_t idle_ns = (int64_t)(atomic_load(&most_idle_s) * 1e9);
    const unsigned most = atomic_load(&most_loaded);
    h->used_ns = pel_now_ns();
    if (table.loaded <= most || h->used_ns < table.look_ns) {
        return;
    }
    table.look_ns = h->used_ns + (idle_ns < LOOK_NS ? idle_ns : LOOK_NS);
    while (table.loaded > most) {
        GLuint oldest = 0;
        for (GLuint i = 1; i < table.count; i++) {
            const struct held *other = &table.at[i];
            if (other->loaded && i != program &&
                other->used_ns <= h->used_ns - idle_ns &&
                (!oldest || other->used_ns < table.at[oldest].used_ns)) {
                oldest = i;
            }
        }
        if (!oldest) {
            return;
        }
        unload(oldest);
    }
}

/* What is kept of a program under; NULL: it is not, as a folder's shaders may
 * change, or there is no memory. free() it. */
static char *key_of(const struct recipe *r)
{
    char *key = NULL;
    if (r->dir || asprintf(&key, "%s %s %s", r->first,
                           r->second ? r->second : "", r->defines) < 0) {
        return NULL;
    }
    return key;
}

static void label(const struct recipe *r, GLuint program)
{
    glObjectLabel(GL_PROGRAM, program, -1, r->second ? r->second : r->first);
}

static enum pel_err finish_load(const struct recipe *r, GLuint program,
                                GLuint shaders[2], struct pel_fault *fault)
{
    enum pel_err err = finish_build(r, program, shaders, fault);
    char *key = err == PEL_OK ? key_of(r) : NULL;
    if (key) {
        pel_binaries_keep(key, program);
    }
    free(key);
    label(r, program);
    return err;
}

/* Its shaders are 0 when it is there, and what finish_load has to be told else.
 */
static enum pel_err begin_load(const struct recipe *r, GLuint program,
                               GLuint shaders[2], struct pel_fault *fault)
{
    char *key = key_of(r);
    enum pel_err err = PEL_OK;
    shaders[0] = shaders[1] = 0;
    if (!key || !pel_binaries_link(key, program)) {
        glProgramParameteri(program, GL_PROGRAM_BINARY_RETRIEVABLE_HINT,
                            key != NULL);
        err = begin_build(r, program, shaders, fault);
    } else {
        label(r, program);
    }
    free(key);
    return err;
}

static enum pel_err load(const struct recipe *r, GLuint program,
                         struct pel_fault *fault)
{
    GLuint shaders[2];
    enum pel_err err = begin_load(r, program, shaders, fault);
    return err == PEL_OK && shaders[0] ? finish_load(r, program, shaders, fault)
                                       : err;
}

/* Waits for one that is being compiled. */
static enum pel_err settle(struct held *h, GLuint program,
                           struct pel_fault *fault)
{
    if (!h->shaders[0]) {
        return PEL_OK;
    }
    table.compiling--;
    enum pel_err err = finish_load(&h->recipe, program, h->shaders, fault);
    if (err != PEL_OK) {
        table.failed = true;
        atomic_store(&one_by_one, true);
    }
    return err;
}

/* Without memory it is not held, and stays loaded: NULL. */
static struct held *hold(const struct recipe *recipe, GLuint program)
{
    if (program >= table.count) {
        GLuint count = program + 64;
        struct held *grown = program < MOST_PROGRAMS
                                 ? realloc(table.at, count * sizeof *grown)
                                 : NULL;
        if (!grown) {
            return NULL;
        }
        memset(grown + table.count, 0, (count - table.count) * sizeof *grown);
        table.at = grown;
        table.count = count;
    }
    struct held *held = &table.at[program];
    *held =
        (struct held){ .recipe = *recipe, .defines = strdup(recipe->defines) };
    held->recipe.defines = held->defines;
    if (!held->defines) {
        return NULL;
    }
    count_loaded(held, true);
    mark_used(held, program);
    return held;
}

enum pel_err pel_program_create(const char *shader_dir, const char *first,
                                const char *second, const char *defines,
                                GLuint *out, struct pel_fault *fault)
{
    const struct recipe recipe = { shader_dir, first, second,
                                   defines ? defines : "" };
    GLuint program = glCreateProgram(), shaders[2];
    enum pel_err err = begin_load(&recipe, program, shaders, fault);
    struct held *held = err == PEL_OK ? hold(&recipe, program) : NULL;
    if (held && shaders[0] && table.side_by_side && !shader_dir &&
        !atomic_load(&one_by_one)) {
        memcpy(held->shaders, shaders, sizeof shaders);
        table.compiling++;
    } else if (err == PEL_OK && shaders[0]) {
        err = finish_load(&recipe, program, shaders, fault);
    }
    if (err != PEL_OK) {
        pel_program_delete(program);
        program = 0;
    }
    *out = program;
    return err;
}

static void take_compilers(GLuint threads)
{
    if (epoxy_has_gl_extension("GL_KHR_parallel_shader_compile")) {
        glMaxShaderCompilerThreadsKHR(threads);
    } else if (epoxy_has_gl_extension("GL_ARB_parallel_shader_compile")) {
        glMaxShaderCompilerThreadsARB(threads);
    }
}

void pel_program_side_by_side(void)
{
    take_compilers(MOST_COMPILERS);
    table.side_by_side = true;
}

void pel_program_one_by_one(void)
{
    if (table.side_by_side) {
        take_compilers(0);
        table.side_by_side = false;
    }
}

enum pel_err pel_program_settle(struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    for (GLuint i = 1; i < table.count && table.compiling > 0; i++) {
        struct held *h = held_of(i);
        enum pel_err own = h ? settle(h, i, err ? NULL : fault) : PEL_OK;
        err = err ? err : own;
    }
    return err;
}

void pel_program_use(GLuint program)
{
    struct held *h = held_of(program);
    struct pel_fault fault = { 0 };
    enum pel_err err = h ? settle(h, program, &fault) : PEL_OK;
    if (h && !h->loaded) {
        err = load(&h->recipe, program, &fault);
        table.failed |= err != PEL_OK;
        count_loaded(h, true);
    }
    if (err != PEL_OK) {
        pel_error("RND-047", "a program could not be made again: %s",
                  fault.message);
    }
    if (h) {
        mark_used(h, program);
    }
    glUseProgram(program);
}

static void drop(struct held *h, GLuint program)
{
    let_go(h, program);
    count_loaded(h, false);
    free(h->defines);
    *h = (struct held){ 0 };
}

bool pel_sea_is_stored(bool software)
{
    GLint bindings = 0;
    glGetIntegerv(GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS, &bindings);
    return !software && bindings > PEL_STORE_NET;
}

const char *pel_hardware_defines(bool software)
{
    return software ? ""
           : pel_sea_is_stored(software)
               ? "#define PEL_HARDWARE\n#define PEL_STORED\n"
               : "#define PEL_HARDWARE\n";
}

void pel_program_delete(GLuint program)
{
    struct held *h = held_of(program);
    if (h) {
        drop(h, program);
    }
    glDeleteProgram(program);
}

void pel_program_forget_all(void)
{
    for (GLuint i = 0; i < table.count; i++) {
        if (table.at[i].defines) {
            /* They end with the context, which may be gone. */
            memset(table.at[i].shaders, 0, sizeof table.at[i].shaders);
            drop(&table.at[i], i);
        }
    }
    free(table.at);
    table.at = NULL;
    table.count = 0;
    table.look_ns = 0;
    table.failed = false;
    table.side_by_side = false;
    table.compiling = 0;
}
