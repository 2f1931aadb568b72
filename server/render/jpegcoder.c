#include "render/jpegcoder.h"

#include <stdlib.h>

#include "encode/jpegcode.h"
#include "render/room.h"
#include "render/shader.h"
#include "shaders/lib/blocks.h"

static enum pel_err make_tables(struct pel_jpeg_coder *c)
{
    struct pel_jpeg_tables *tables = malloc(sizeof *tables);
    enum pel_err err =
        tables ? pel_jpeg_tables_fill(tables) : PEL_ERR_NO_MEMORY;
    if (err == PEL_OK) {
        glCreateBuffers(1, &c->tables);
        glNamedBufferStorage(c->tables, sizeof *tables, tables, 0);
        glObjectLabel(GL_BUFFER, c->tables, -1, "tables of JPEG");
    }
    free(tables);
    return err;
}

enum pel_err pel_jpeg_coder_need(struct pel_jpeg_coder *c,
                                 const char *shader_dir,
                                 struct pel_fault *fault)
{
    enum pel_err err = c->tables ? PEL_OK : make_tables(c);
    if (err != PEL_OK) {
        pel_fault_set(fault, err, "no memory for the tables of JPEG");
        return err;
    }
    return c->program ? PEL_OK
                      : pel_program_create(shader_dir, "jpeg.comp", NULL, NULL,
                                           &c->program, fault);
}

void pel_jpeg_coder_finish(struct pel_jpeg_coder *c)
{
    pel_program_delete(c->program);
    glDeleteBuffers(1, &c->tables);
    glDeleteBuffers(1, &c->planes);
    *c = (struct pel_jpeg_coder){ 0 };
}

void pel_jpeg_coder_fit(struct pel_jpeg_coder *c, size_t bytes)
{
    pel_room_fit(&c->planes, &c->capacity, bytes, "planes to code");
}

void pel_jpeg_coder_run(struct pel_jpeg_coder *c,
                        const struct pel_jpeg_work *works, size_t count)
{
    GLuint of[PEL_TOGETHER_MOST][4] = { 0 };
    GLuint qualities[PEL_TOGETHER_MOST] = { 0 };
    GLuint buffers[PEL_TOGETHER_MOST];
    size_t groups = 0;
    for (size_t i = 0; i < PEL_TOGETHER_MOST; i++) {
        const struct pel_jpeg_work *w = &works[i < count ? i : 0];
        size_t own = pel_jpeg_groups(w->width, w->height);
        size_t ev = w->with_ev ? pel_readback_ev_offset(w->slot) / 4 : 0;
        of[i][0] = w->width;
        of[i][1] = w->height;
        of[i][2] = (GLuint)(w->at / 4);
        of[i][3] = (GLuint)ev;
        qualities[i] = (GLuint)w->quality;
        buffers[i] = pel_readback_buffer(w->slot);
        groups = own > groups ? own : groups;
    }
    glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_PICTURES,
                      PEL_TOGETHER_MOST, buffers);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_PLANES, c->planes);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_JPEG, c->tables);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    pel_program_use(c->program);
    glUniform4uiv(0, (GLsizei)count, of[0]);
    glUniform1uiv(PEL_TOGETHER_MOST, (GLsizei)count, qualities);
    glDispatchCompute((GLuint)groups, (GLuint)count, 1);
}
