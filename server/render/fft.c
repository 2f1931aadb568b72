#include "render/fft.h"

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

static enum pel_err make(struct pel_fft *fft, const char *shader_dir,
                         struct pel_fault *fault)
{
    enum pel_err err = pel_program_create(shader_dir, "fft_rows.comp", NULL,
                                          NULL, &fft->rows_program, fault);
    if (err == PEL_OK) {
        err = pel_program_create(shader_dir, "fft_columns.comp", NULL, NULL,
                                 &fft->columns_program, fault);
    }
    if (err != PEL_OK) {
        return err;
    }
    fft->amplitudes = make_array(GL_RGBA32F, 1, "amplitudes");
    fft->modes = make_array(GL_RG32F, 1, "modes");
    fft->displacement = make_array(GL_RGBA32F, LEVELS, "displacement");
    fft->slopes = make_array(GL_RGBA32F, LEVELS, "slopes");
    fft->fold = make_array(GL_R32F, LEVELS, "fold");
    glCreateBuffers(1, &fft->lines);
    glNamedBufferStorage(fft->lines, (GLsizeiptr)N * N * PEL_CASCADES * 32, NULL,
                         0);
    glObjectLabel(GL_BUFFER, fft->lines, -1, "transform lines");
    glCreateBuffers(1, &fft->parameters);
    glNamedBufferStorage(fft->parameters, sizeof(struct parameters), NULL,
                         GL_DYNAMIC_STORAGE_BIT);
    glObjectLabel(GL_BUFFER, fft->parameters, -1, "cascades");
    fft->made = true;
    return PEL_OK;
}

static void upload(struct pel_fft *fft, const struct pel_cascades *cascades)
{
    struct parameters p;
    for (int c = 0; c < PEL_CASCADES; c++) {
        const struct pel_cascade *from = &cascades->cascade[c];
        glTextureSubImage3D(fft->amplitudes, 0, 0, 0, c, N, N, 1, GL_RGBA,
                            GL_FLOAT, from->h0);
        glTextureSubImage3D(fft->modes, 0, 0, 0, c, N, N, 1, GL_RG, GL_FLOAT,
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
    glNamedBufferSubData(fft->parameters, 0, sizeof p, &p);
}

static void transform(struct pel_fft *fft, double time_s)
{
    glBindTextureUnit(0, fft->amplitudes);
    glBindTextureUnit(1, fft->modes);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, fft->lines);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, fft->parameters);
    glUseProgram(fft->rows_program);
    glUniform1d(0, time_s);
    glDispatchCompute(1, N, PEL_CASCADES);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    glUseProgram(fft->columns_program);
    glBindImageTexture(0, fft->displacement, 0, GL_TRUE, 0, GL_WRITE_ONLY,
                       GL_RGBA32F);
    glBindImageTexture(1, fft->slopes, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(2, fft->fold, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
    glDispatchCompute(1, N, PEL_CASCADES);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
    glGenerateTextureMipmap(fft->displacement);
    glGenerateTextureMipmap(fft->slopes);
    glGenerateTextureMipmap(fft->fold);
}

enum pel_err pel_fft_run(struct pel_fft *fft, const char *shader_dir,
                         const struct pel_sea_desc *desc,
                         const struct pel_cascades *cascades, double time_s,
                         struct pel_fault *fault)
{
    if (!fft->made) {
        enum pel_err err = make(fft, shader_dir, fault);
        if (err != PEL_OK) {
            return err;
        }
    }
    if (!fft->computed || memcmp(desc, &fft->desc, sizeof *desc) != 0) {
        upload(fft, cascades);
        memcpy(&fft->desc, desc, sizeof *desc);
        fft->computed = false;
    }
    if (!fft->computed || fft->time_s != time_s) {
        transform(fft, time_s);
        fft->time_s = time_s;
        fft->computed = true;
    }
    glBindTextureUnit(PEL_UNIT_DISPLACEMENT, fft->displacement);
    glBindTextureUnit(PEL_UNIT_SLOPES, fft->slopes);
    glBindTextureUnit(PEL_UNIT_FOLD, fft->fold);
    return PEL_OK;
}

void pel_fft_finish(struct pel_fft *fft)
{
    const GLuint textures[] = { fft->amplitudes, fft->modes, fft->displacement,
                                fft->slopes, fft->fold };
    const GLuint buffers[] = { fft->lines, fft->parameters };
    glDeleteTextures(5, textures);
    glDeleteBuffers(2, buffers);
    glDeleteProgram(fft->rows_program);
    glDeleteProgram(fft->columns_program);
    *fft = (struct pel_fft){ 0 };
}
