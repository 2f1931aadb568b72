#include "render/samples.h"

#include "render/shader.h"
#include "shaders/lib/blocks.h"

void pel_samples_finish(struct pel_samples *s)
{
    const GLuint textures[] = { s->numbers, s->depths, s->cover, s->shown };
    const GLuint fbos[] = { s->fbo, s->cover_fbo };
    glDeleteTextures(4, textures);
    glDeleteFramebuffers(2, fbos);
    pel_program_delete(s->raster[0]);
    pel_program_delete(s->raster[1]);
    pel_program_delete(s->any);
    pel_program_delete(s->sight);
    pel_program_delete(s->hide);
    *s = (struct pel_samples){ 0 };
}

enum pel_err pel_samples_need(struct pel_samples *s,
                              const struct pel_programs *p, bool holed,
                              struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    if (s->sight && s->by_keys != p->compute) {
        pel_program_delete(s->sight);
        s->sight = 0;
    }
    s->by_keys = p->compute;
    for (int h = 0; h < (holed ? 2 : 1) && err == PEL_OK; h++) {
        if (!s->raster[h]) {
            err = pel_program_create(
                p->shader_dir, "object.vert", "samples.frag",
                h ? "#define PEL_HOLES\n" : NULL, &s->raster[h], fault);
        }
    }
    if (err == PEL_OK && !p->compute && !s->any) {
        err = pel_program_create(p->shader_dir, "screen.vert", "any.frag", NULL,
                                 &s->any, fault);
    }
    if (err == PEL_OK && !s->sight) {
        err = p->compute
                  ? pel_program_create(p->shader_dir, "sight.comp", NULL, NULL,
                                       &s->sight, fault)
                  : pel_program_create(p->shader_dir, "screen.vert",
                                       "sight.frag", NULL, &s->sight, fault);
    }
    if (err == PEL_OK && !p->compute && !s->hide) {
        err = pel_program_create(p->shader_dir, "screen.vert", "hide.frag",
                                 NULL, &s->hide, fault);
    }
    return err;
}

static GLuint make_samples(GLenum format, GLsizei width, GLsizei height,
                           const char *label)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D_MULTISAMPLE, 1, &texture);
    glTextureStorage2DMultisample(texture, PEL_SAMPLES, format, width, height,
                                  GL_TRUE);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

static void fit(struct pel_samples *s, uint32_t width, uint32_t height)
{
    if (width <= s->width && height <= s->height) {
        return;
    }
    const GLuint textures[] = { s->numbers, s->depths, s->cover, s->shown };
    const GLuint fbos[] = { s->fbo, s->cover_fbo };
    glDeleteTextures(4, textures);
    glDeleteFramebuffers(2, fbos);
    s->width = width > s->width ? width : s->width;
    s->height = height > s->height ? height : s->height;
    GLsizei w = (GLsizei)s->width, h = (GLsizei)s->height;
    s->numbers = make_samples(GL_RG32UI, w, h, "objects' samples");
    s->depths =
        make_samples(GL_DEPTH_COMPONENT32F, w, h, "objects' samples' depths");
    glCreateTextures(GL_TEXTURE_2D, 1, &s->cover);
    glTextureStorage2D(s->cover, 1, GL_R8UI, w, h);
    glTextureParameteri(s->cover, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(s->cover, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glObjectLabel(GL_TEXTURE, s->cover, -1, "objects' cover");
    glCreateTextures(GL_TEXTURE_2D, 1, &s->shown);
    glTextureStorage2D(s->shown, 1, GL_DEPTH_COMPONENT32F, w, h);
    glObjectLabel(GL_TEXTURE, s->shown, -1, "objects' depth test");
    glCreateFramebuffers(1, &s->fbo);
    glNamedFramebufferTexture(s->fbo, GL_COLOR_ATTACHMENT0, s->numbers, 0);
    glNamedFramebufferTexture(s->fbo, GL_DEPTH_ATTACHMENT, s->depths, 0);
    glCreateFramebuffers(1, &s->cover_fbo);
    glNamedFramebufferTexture(s->cover_fbo, GL_COLOR_ATTACHMENT0, s->cover, 0);
    glNamedFramebufferTexture(s->cover_fbo, GL_DEPTH_ATTACHMENT, s->shown, 0);
}

static void keep_to(const GLint box[4])
{
    glEnable(GL_SCISSOR_TEST);
    glScissor(box[0], box[1], box[2] - box[0], box[3] - box[1]);
}

void pel_samples_begin(struct pel_samples *s, GLsizei width, GLsizei height,
                       const GLint box[4])
{
    static const GLfloat far_away = 0.0f;
    fit(s, (uint32_t)width, (uint32_t)height);
    keep_to(box);
    glDepthMask(GL_TRUE);
    /* Numbers are read where a depth says that there is one: to clear them
     * takes hardware longer than to draw them. */
    glClearNamedFramebufferfv(s->fbo, GL_DEPTH, 0, &far_away);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, s->fbo);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
}

static void sight_in_compute(struct pel_samples *s, const GLint box[4])
{
    glBindImageTexture(PEL_IMAGE_COVER, s->cover, 0, GL_FALSE, 0, GL_WRITE_ONLY,
                       GL_R8UI);
    pel_program_use(s->sight);
    glUniform4iv(0, 1, box);
    /* Also what is shaded where no object may be. */
    glDispatchCompute((s->width + PEL_GROUP_SIDE - 1) / PEL_GROUP_SIDE,
                      (s->height + PEL_GROUP_SIDE - 1) / PEL_GROUP_SIDE, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

static void sight_by_fragments(struct pel_samples *s, const GLint box[4])
{
    static const GLuint none[4] = { 0 };
    glDisable(GL_SCISSOR_TEST);
    glClearNamedFramebufferuiv(s->cover_fbo, GL_COLOR, 0, none);
    keep_to(box);
    glDepthFunc(GL_ALWAYS);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, s->cover_fbo);
    glViewport(0, 0, (GLsizei)s->width, (GLsizei)s->height);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    pel_program_use(s->any);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_FALSE);
    pel_program_use(s->sight);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDepthMask(GL_TRUE);
}

void pel_samples_sight(struct pel_samples *s, const GLint box[4])
{
    glBindTextureUnit(PEL_UNIT_OBJECT_SAMPLES, s->numbers);
    glBindTextureUnit(PEL_UNIT_OBJECT_DEPTHS, s->depths);
    if (s->by_keys) {
        sight_in_compute(s, box);
    } else {
        sight_by_fragments(s, box);
    }
    glBindTextureUnit(PEL_UNIT_OBJECT_COVER, s->cover);
    glDisable(GL_SCISSOR_TEST);
}

void pel_samples_hide(struct pel_samples *s, GLuint fbo, const GLint box[4],
                      bool middles)
{
    keep_to(box);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_ALWAYS);
    glDepthMask(GL_TRUE);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, fbo);
    glViewport(0, 0, (GLsizei)s->width, (GLsizei)s->height);
    pel_program_use(s->hide);
    glUniform1i(0, middles);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_FALSE);
    glDisable(GL_SCISSOR_TEST);
}
