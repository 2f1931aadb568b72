#include "render/wavefield.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ocean/evolve.h"
#include "ocean/foam.h"
#include "render/shader.h"
#include "render/worker_pool.h"
#include "shaders/lib/blocks.h"

#define N PEL_CASCADE_N
#define LEVELS PEL_CASCADE_LEVELS
#define LEVEL_TEXELS (N * N / 3 * 4 + 4) /* of all levels, and a little */
#define MOST_THREADS PEL_CASCADES
#define LINE_BYTES ((GLsizeiptr)N * N * 32) /* of one cascade */

static GLuint make_array(GLenum format, GLsizei levels, GLsizei cascades,
                         const char *label)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &texture);
    glTextureStorage3D(texture, levels, format, N, N, cascades);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_REPEAT);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER,
                        levels > 1 ? GL_LINEAR_MIPMAP_LINEAR : GL_NEAREST);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

static void make_set(struct pel_wavefield_textures *set)
{
    set->displacement =
        make_array(GL_RGBA32F, LEVELS, PEL_CASCADES, "displacement");
    set->slopes = make_array(GL_RGBA32F, LEVELS, PEL_CASCADES, "slopes");
    set->fold = make_array(GL_R32F, LEVELS, PEL_CASCADES, "fold");
}

static void need_breaking(struct pel_wavefield_textures *set)
{
    if (!set->breaking) {
        set->breaking =
            make_array(GL_RG32F, LEVELS, PEL_FOAM_CASCADES, "breaking");
    }
}

/* --- on the processor ----------------------------------------------------- */

/* Every level of one cascade's fields, finest first, as they are uploaded. */
struct levels {
    float displacement[LEVEL_TEXELS][4], slopes[LEVEL_TEXELS][4];
    float fold[LEVEL_TEXELS];
    float breaking[LEVEL_TEXELS][2];
};

struct pel_wavefield_cpu {
    struct pel_worker_pool *pool;
    struct pel_evolve_work *work[MOST_THREADS]; /* one a member */
    struct levels *levels;                      /* one a cascade */
    const struct pel_cascades *cascades;        /* of the work under way */
    bool foam;
    double time_s;
};

static void cpu_destroy(struct pel_wavefield_cpu *cpu)
{
    if (!cpu) {
        return;
    }
    pel_worker_pool_destroy(cpu->pool);
    for (int i = 0; i < MOST_THREADS; i++) {
        pel_evolve_work_destroy(cpu->work[i]);
    }
    free(cpu->levels);
    free(cpu);
}

static enum pel_err cpu_create(int threads, struct pel_wavefield_cpu **out)
{
    struct pel_wavefield_cpu *cpu = calloc(1, sizeof *cpu);
    if (!cpu) {
        return PEL_ERR_NO_MEMORY;
    }
    if (threads <= 0) {
        threads = (int)sysconf(_SC_NPROCESSORS_ONLN);
    }
    threads = threads < 1 ? 1 : threads;
    threads = threads > MOST_THREADS ? MOST_THREADS : threads;
    enum pel_err err = pel_worker_pool_create(threads, &cpu->pool);
    cpu->levels = malloc(PEL_CASCADES * sizeof *cpu->levels);
    bool whole = err == PEL_OK && cpu->levels;
    for (int i = 0; whole && i < pel_worker_pool_members(cpu->pool); i++) {
        cpu->work[i] = pel_evolve_work_create();
        whole = cpu->work[i] != NULL;
    }
    if (!whole) {
        cpu_destroy(cpu);
        return PEL_ERR_NO_MEMORY;
    }
    *out = cpu;
    return PEL_OK;
}

static void evolve_cascade(void *user, int member, int index)
{
    struct pel_wavefield_cpu *cpu = user;
    struct levels *to = &cpu->levels[index];
    const struct pel_evolve_target target = {
        to->displacement, to->slopes, to->fold, NULL, NULL, NULL
    };
    pel_evolve(cpu->cascades, index, cpu->time_s, cpu->work[member], &target);
    for (int n = N, at = 0; n > 1; at += n * n, n /= 2) {
        int next = at + n * n;
        pel_evolve_halve(to->displacement[at], n, 4, to->displacement[next]);
        pel_evolve_halve(to->slopes[at], n, 4, to->slopes[next]);
        pel_evolve_halve(&to->fold[at], n, 1, &to->fold[next]);
    }
    if (!cpu->foam || index >= PEL_FOAM_CASCADES) {
        return;
    }
    const struct pel_evolve_target foam = { .breaking = to->breaking };
    pel_evolve(cpu->cascades, index, cpu->time_s, cpu->work[member], &foam);
    for (int n = N, at = 0; n > 1; at += n * n, n /= 2) {
        pel_evolve_halve(to->breaking[at], n, 2, to->breaking[at + n * n]);
    }
}

static void upload_levels(const struct pel_wavefield_textures *set, int cascade,
                          const struct levels *from)
{
    for (int level = 0, n = N, at = 0; level < LEVELS;
         level++, at += n * n, n /= 2) {
        glTextureSubImage3D(set->displacement, level, 0, 0, cascade, n, n, 1,
                            GL_RGBA, GL_FLOAT, from->displacement[at]);
        glTextureSubImage3D(set->slopes, level, 0, 0, cascade, n, n, 1, GL_RGBA,
                            GL_FLOAT, from->slopes[at]);
        glTextureSubImage3D(set->fold, level, 0, 0, cascade, n, n, 1, GL_RED,
                            GL_FLOAT, &from->fold[at]);
        if (set->breaking && cascade < PEL_FOAM_CASCADES) {
            glTextureSubImage3D(set->breaking, level, 0, 0, cascade, n, n, 1,
                                GL_RG, GL_FLOAT, from->breaking[at]);
        }
    }
}

static void transform_on_processor(struct pel_wavefield *field,
                                   const struct pel_cascades *cascades,
                                   double time_s)
{
    struct pel_wavefield_cpu *cpu = field->cpu;
    cpu->cascades = cascades;
    cpu->time_s = time_s;
    cpu->foam = field->foam;
    pel_worker_pool_run(cpu->pool, PEL_CASCADES, evolve_cascade, cpu);
    field->current = (field->current + 1) % PEL_WAVEFIELD_SETS;
    struct pel_wavefield_textures *set = &field->sets[field->current];
    if (!set->displacement) {
        make_set(set);
    }
    if (field->foam) {
        need_breaking(set);
    }
    for (int c = 0; c < PEL_CASCADES; c++) {
        upload_levels(set, c, &cpu->levels[c]);
    }
}

/* --- by compute shaders --------------------------------------------------- */

struct parameters {
    float cascade[PEL_CASCADES][4];
    float gain[N][2];
};

static enum pel_err make_programs(struct pel_wavefield *field,
                                  const char *shader_dir,
                                  struct pel_fault *fault)
{
    enum pel_err err = pel_program_create(shader_dir, "fft_rows.comp", NULL,
                                          NULL, &field->rows_program, fault);
    if (err == PEL_OK) {
        err = pel_program_create(shader_dir, "fft_columns.comp", NULL, NULL,
                                 &field->columns_program, fault);
    }
    if (err == PEL_OK) {
        err = pel_program_create(shader_dir, "fft_mips.comp", NULL, NULL,
                                 &field->mips_program, fault);
    }
    if (err != PEL_OK) {
        return err;
    }
    field->amplitudes = make_array(GL_RGBA32F, 1, PEL_CASCADES, "amplitudes");
    field->modes = make_array(GL_RG32F, 1, PEL_CASCADES, "modes");
    make_set(&field->sets[0]);
    glCreateBuffers(1, &field->lines);
    glNamedBufferStorage(
        field->lines, LINE_BYTES * (PEL_CASCADES + PEL_FOAM_CASCADES), NULL, 0);
    glObjectLabel(GL_BUFFER, field->lines, -1, "transform lines");
    glCreateBuffers(1, &field->parameters);
    glNamedBufferStorage(field->parameters, sizeof(struct parameters), NULL,
                         GL_DYNAMIC_STORAGE_BIT);
    glObjectLabel(GL_BUFFER, field->parameters, -1, "cascades");
    return PEL_OK;
}

static void upload(struct pel_wavefield *field,
                   const struct pel_cascades *cascades)
{
    struct parameters p;
    for (int c = 0; c < PEL_CASCADES; c++) {
        const struct pel_cascade *from = &cascades->cascade[c];
        glTextureSubImage3D(field->amplitudes, 0, 0, 0, c, N, N, 1, GL_RGBA,
                            GL_FLOAT, from->h0);
        glTextureSubImage3D(field->modes, 0, 0, 0, c, N, N, 1, GL_RG, GL_FLOAT,
                            from->mode);
        p.cascade[c][0] = (float)from->length_m;
        p.cascade[c][1] = (float)from->turn_cos;
        p.cascade[c][2] = (float)from->turn_sin;
        p.cascade[c][3] = 0.0f;
    }
    for (int i = 0; i < N; i++) {
        p.gain[i][0] = cascades->displacement_gain[i];
        p.gain[i][1] = cascades->slope_gain[i];
    }
    glNamedBufferSubData(field->parameters, 0, sizeof p, &p);
}

static void bind_fields(const struct pel_wavefield *field)
{
    const struct pel_wavefield_textures *set = &field->sets[field->current];
    glBindTextureUnit(PEL_UNIT_DISPLACEMENT, set->displacement);
    glBindTextureUnit(PEL_UNIT_SLOPES, set->slopes);
    glBindTextureUnit(PEL_UNIT_FOLD, set->fold);
    if (field->foam) {
        glBindTextureUnit(PEL_UNIT_BREAKING, set->breaking);
    }
}

static void bind_images(const struct pel_wavefield *field, GLint level)
{
    const struct pel_wavefield_textures *set = &field->sets[field->current];
    glBindImageTexture(PEL_IMAGE_DISPLACEMENT, set->displacement, level,
                       GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(PEL_IMAGE_SLOPES, set->slopes, level, GL_TRUE, 0,
                       GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(PEL_IMAGE_FOLD, set->fold, level, GL_TRUE, 0,
                       GL_WRITE_ONLY, GL_R32F);
}

static void bind_breaking(const struct pel_wavefield *field, GLint level)
{
    glBindImageTexture(PEL_IMAGE_BREAKING, field->sets[field->current].breaking,
                       level, GL_TRUE, 0, GL_WRITE_ONLY, GL_RG32F);
}

_Static_assert((LEVELS - 1) % PEL_MIPS == 0, "dispatches make PEL_MIPS each");

/* Levels of a field from one on; fields beside each other need no barrier. */
static void make_levels(GLuint field, GLenum format, GLint from, GLuint layers)
{
    const GLuint groups = (GLuint)(N >> from) / 16;
    glBindTextureUnit(PEL_UNIT_MIPS, field);
    for (GLuint i = 0; i < PEL_MIPS; i++) {
        glBindImageTexture(PEL_IMAGE_MIPS + i, field, from + 1 + (GLint)i,
                           GL_TRUE, 0, GL_WRITE_ONLY, format);
    }
    glDispatchCompute(groups, groups, layers);
}

/* glGenerateTextureMipmap takes a draw for each layer and level: a
 * millisecond on hardware. */
static void make_all_levels(const struct pel_wavefield *field)
{
    const struct pel_wavefield_textures *set = &field->sets[field->current];
    pel_program_use(field->mips_program);
    for (GLint from = 0; from + 1 < LEVELS; from += PEL_MIPS) {
        glUniform1i(0, from);
        make_levels(set->displacement, GL_RGBA32F, from, PEL_CASCADES);
        make_levels(set->slopes, GL_RGBA32F, from, PEL_CASCADES);
        make_levels(set->fold, GL_R32F, from, PEL_CASCADES);
        if (field->foam) {
            make_levels(set->breaking, GL_RG32F, from, PEL_FOAM_CASCADES);
        }
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    }
}

/* Lines of what breaks come after those of the sea, and no pass of the one
 * waits for the other's. */
static void bind_lines(const struct pel_wavefield *field, bool breaking)
{
    glBindBufferRange(GL_SHADER_STORAGE_BUFFER, PEL_STORE_LINES, field->lines,
                      breaking ? LINE_BYTES * PEL_CASCADES : 0,
                      LINE_BYTES *
                          (breaking ? PEL_FOAM_CASCADES : PEL_CASCADES));
}

static void transform_rows(const struct pel_wavefield *field, double time_s,
                           bool breaking)
{
    bind_lines(field, breaking);
    pel_program_use(breaking ? field->foam_programs[0] : field->rows_program);
    glUniform1d(0, time_s);
    glDispatchCompute(1, N, breaking ? PEL_FOAM_CASCADES : PEL_CASCADES);
}

static void transform_columns(const struct pel_wavefield *field, bool breaking)
{
    bind_lines(field, breaking);
    pel_program_use(breaking ? field->foam_programs[1]
                             : field->columns_program);
    if (breaking) {
        bind_breaking(field, 0);
    } else {
        bind_images(field, 0);
    }
    glDispatchCompute(1, N, breaking ? PEL_FOAM_CASCADES : PEL_CASCADES);
}

static void transform_by_shaders(struct pel_wavefield *field, double time_s)
{
    glBindTextureUnit(PEL_UNIT_AMPLITUDES, field->amplitudes);
    glBindTextureUnit(PEL_UNIT_MODES, field->modes);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_MODES,
                     field->parameters);
    transform_rows(field, time_s, false);
    if (field->foam) {
        transform_rows(field, time_s, true);
    }
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    transform_columns(field, false);
    if (field->foam) {
        transform_columns(field, true);
    }
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    make_all_levels(field);
}

/* --- a frame -------------------------------------------------------------- */

static enum pel_err make(struct pel_wavefield *field, const char *shader_dir,
                         struct pel_fault *fault)
{
    enum pel_err err;
    if (field->on_processor) {
        err = cpu_create(field->threads, &field->cpu);
        if (err != PEL_OK) {
            return pel_fault_set(fault, err, "no memory for transforms");
        }
    } else {
        err = make_programs(field, shader_dir, fault);
    }
    field->made = err == PEL_OK;
    return err;
}

static enum pel_err need_foam(struct pel_wavefield *field,
                              const char *shader_dir, struct pel_fault *fault)
{
    static const char *const names[2] = { "fft_rows.comp", "fft_columns.comp" };
    enum pel_err err = PEL_OK;
    for (int i = 0; i < 2 && !err && !field->on_processor; i++) {
        if (!field->foam_programs[i]) {
            err = pel_program_create(shader_dir, names[i], NULL,
                                     "#define PEL_FOAM\n",
                                     &field->foam_programs[i], fault);
        }
    }
    if (!err && !field->on_processor) {
        need_breaking(&field->sets[0]);
    }
    return err;
}

enum pel_err pel_wavefield_need(struct pel_wavefield *field,
                                const char *shader_dir,
                                const struct pel_sea_desc *desc,
                                struct pel_fault *fault)
{
    enum pel_err err = field->made ? PEL_OK : make(field, shader_dir, fault);
    return err == PEL_OK && desc->whitecaps > 0
               ? need_foam(field, shader_dir, fault)
               : err;
}

void pel_wavefield_run(struct pel_wavefield *field,
                       const struct pel_sea_desc *desc,
                       const struct pel_cascades *cascades, double time_s)
{
    field->foam = desc->whitecaps > 0;
    if (!field->computed || memcmp(desc, &field->desc, sizeof *desc) != 0) {
        if (!field->on_processor) {
            upload(field, cascades);
        }
        memcpy(&field->desc, desc, sizeof *desc);
        field->computed = false;
    }
    if (!field->computed || field->time_s != time_s) {
        if (field->on_processor) {
            transform_on_processor(field, cascades, time_s);
        } else {
            transform_by_shaders(field, time_s);
        }
        field->time_s = time_s;
        field->computed = true;
    }
    bind_fields(field);
}

void pel_wavefield_finish(struct pel_wavefield *field)
{
    const GLuint textures[] = { field->amplitudes, field->modes };
    const GLuint buffers[] = { field->lines, field->parameters };
    glDeleteTextures(2, textures);
    glDeleteBuffers(2, buffers);
    for (int i = 0; i < PEL_WAVEFIELD_SETS; i++) {
        const struct pel_wavefield_textures *set = &field->sets[i];
        const GLuint fields[] = { set->displacement, set->slopes, set->fold,
                                  set->breaking };
        glDeleteTextures(4, fields);
    }
    for (int i = 0; i < 2; i++) {
        pel_program_delete(field->foam_programs[i]);
    }
    pel_program_delete(field->rows_program);
    pel_program_delete(field->columns_program);
    pel_program_delete(field->mips_program);
    cpu_destroy(field->cpu);
    *field = (struct pel_wavefield){ 0 };
}
