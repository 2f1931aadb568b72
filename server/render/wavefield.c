#include "render/wavefield.h"

#include <string.h>

#define N PEL_CASCADE_N
#define LEVELS 9

static GLuint make_array(GLenum format, GLsizei levels, const char *label)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &texture);
    glTextureStorage3D(texture, levels, format, N, N, PEL_CASCADES);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_REPEAT);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER,
                        levels > 1 ? GL_LINEAR_MIPMAP_LINEAR : GL_NEAREST);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

struct parameters {
    float cascade[PEL_CASCADES][4];
    float gain[N][2];
};

static enum pel_err make(struct pel_wavefield *field, const char *shader_dir,
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
    field->amplitudes = make_array(GL_RGBA32F, 1, "amplitudes");
    field->modes = make_array(GL_RG32F, 1, "modes");
    field->displacement = make_array(GL_RGBA32F, LEVELS, "displacement");
    field->slopes = make_array(GL_RGBA32F, LEVELS, "slopes");
    field->fold = make_array(GL_R32F, LEVELS, "fold");
    glCreateBuffers(1, &field->lines);
    glNamedBufferStorage(field->lines, (GLsizeiptr)N * N * PEL_CASCADES * 32,
                         NULL, 0);
    glObjectLabel(GL_BUFFER, field->lines, -1, "transform lines");
    glCreateBuffers(1, &field->parameters);
    glNamedBufferStorage(field->parameters, sizeof(struct parameters), NULL,
                         GL_DYNAMIC_STORAGE_BIT);
    glObjectLabel(GL_BUFFER, field->parameters, -1, "cascades");
    field->made = true;
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
    glBindTextureUnit(PEL_UNIT_DISPLACEMENT, field->displacement);
    glBindTextureUnit(PEL_UNIT_SLOPES, field->slopes);
    glBindTextureUnit(PEL_UNIT_FOLD, field->fold);
}

static void bind_images(const struct pel_wavefield *field, GLint level)
{
    glBindImageTexture(0, field->displacement, level, GL_TRUE, 0, GL_WRITE_ONLY,
                       GL_RGBA32F);
    glBindImageTexture(1, field->slopes, level, GL_TRUE, 0, GL_WRITE_ONLY,
                       GL_RGBA32F);
    glBindImageTexture(2, field->fold, level, GL_TRUE, 0, GL_WRITE_ONLY,
                       GL_R32F);
}

/* glGenerateTextureMipmap takes a draw for each layer and level: a
 * millisecond on hardware. */
static void make_levels(const struct pel_wavefield *field)
{
    bind_fields(field);
    glUseProgram(field->mips_program);
    for (GLint level = 1; level < LEVELS; level++) {
        GLuint groups = (GLuint)((N >> level) + 7) / 8;
        bind_images(field, level);
        glUniform1i(0, level - 1);
        glDispatchCompute(groups, groups, PEL_CASCADES);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    }
}

static void transform(struct pel_wavefield *field, double time_s)
{
    glBindTextureUnit(0, field->amplitudes);
    glBindTextureUnit(1, field->modes);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, field->lines);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, field->parameters);
    glUseProgram(field->rows_program);
    glUniform1d(0, time_s);
    glDispatchCompute(1, N, PEL_CASCADES);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    glUseProgram(field->columns_program);
    bind_images(field, 0);
    glDispatchCompute(1, N, PEL_CASCADES);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    make_levels(field);
}

enum pel_err pel_wavefield_run(struct pel_wavefield *field,
                               const char *shader_dir,
                               const struct pel_sea_desc *desc,
                               const struct pel_cascades *cascades,
                               double time_s, struct pel_fault *fault)
{
    if (!field->made) {
        enum pel_err err = make(field, shader_dir, fault);
        if (err != PEL_OK) {
            return err;
        }
    }
    if (!field->computed || memcmp(desc, &field->desc, sizeof *desc) != 0) {
        upload(field, cascades);
        memcpy(&field->desc, desc, sizeof *desc);
        field->computed = false;
    }
    if (!field->computed || field->time_s != time_s) {
        transform(field, time_s);
        field->time_s = time_s;
        field->computed = true;
    }
    bind_fields(field);
    return PEL_OK;
}

void pel_wavefield_finish(struct pel_wavefield *field)
{
    const GLuint textures[] = { field->amplitudes, field->modes,
                                field->displacement, field->slopes,
                                field->fold };
    const GLuint buffers[] = { field->lines, field->parameters };
    glDeleteTextures(5, textures);
    glDeleteBuffers(2, buffers);
    glDeleteProgram(field->rows_program);
    glDeleteProgram(field->columns_program);
    glDeleteProgram(field->mips_program);
    *field = (struct pel_wavefield){ 0 };
}
