#include "render/mirror.h"

#include <math.h>
#include <stdio.h>

#include "render/programs.h"
#include "render/shader.h"

#define NEAREST_M 0.5
#define MARGIN 0.02 /* of the view */

static GLuint make_views(GLenum format, GLint filter, const char *name)
{
    GLuint t;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &t);
    glTextureStorage3D(t, PEL_MIRROR_LEVELS, format, PEL_MIRROR_WIDTH,
                       PEL_MIRROR_HEIGHT, PEL_OBJECT_MIRRORS);
    glTextureParameteri(t, GL_TEXTURE_MIN_FILTER, filter);
    glTextureParameteri(t, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    glTextureParameteri(t, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
    glObjectLabel(GL_TEXTURE, t, -1, name);
    return t;
}

void pel_mirrors_forget_program(struct pel_mirrors *m)
{
    pel_program_delete(m->program);
    m->program = 0;
}

enum pel_err pel_mirrors_need(struct pel_mirrors *m, const char *shader_dir,
                              bool textured, bool holed, const char *light,
                              struct pel_fault *fault)
{
    char defines[96 + PEL_LIGHT_TEXT];
    snprintf(defines, sizeof defines, "%s%s", light,
             textured ? "#define PEL_TEXTURED\n" : "");
    enum pel_err err =
        m->program
            ? PEL_OK
            : pel_program_create(shader_dir, "screen.vert", "mirror.frag",
                                 defines, &m->program, fault);
    for (int h = 0; h < (holed ? 2 : 1) && err == PEL_OK; h++) {
        if (!m->raster[h]) {
            err = pel_program_create(shader_dir, "mirror.vert", "number.frag",
                                     h ? "#define PEL_HOLES\n" : NULL,
                                     &m->raster[h], fault);
        }
    }
    if (err != PEL_OK || m->radiance) {
        return err;
    }
    if (err == PEL_OK) {
        err = pel_program_create(shader_dir, "mirror_mips.comp", NULL, NULL,
                                 &m->mips_program, fault);
    }
    if (err != PEL_OK) {
        return err;
    }
    m->radiance =
        make_views(GL_RGBA16F, GL_LINEAR_MIPMAP_LINEAR, "mirrored objects");
    m->away = make_views(GL_RG16F, GL_LINEAR_MIPMAP_NEAREST,
                         "how far mirrored objects are");
    glCreateTextures(GL_TEXTURE_2D, 1, &m->depth);
    glTextureStorage2D(m->depth, 1, GL_DEPTH_COMPONENT32F, PEL_MIRROR_WIDTH,
                       PEL_MIRROR_HEIGHT);
    glCreateTextures(GL_TEXTURE_2D, 1, &m->numbers);
    glTextureStorage2D(m->numbers, 1, GL_RG32UI, PEL_MIRROR_WIDTH,
                       PEL_MIRROR_HEIGHT);
    glTextureParameteri(m->numbers, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(m->numbers, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glObjectLabel(GL_TEXTURE, m->numbers, -1, "mirrored triangles");
    glCreateFramebuffers(1, &m->numbers_fbo);
    glNamedFramebufferTexture(m->numbers_fbo, GL_COLOR_ATTACHMENT0, m->numbers,
                              0);
    glNamedFramebufferTexture(m->numbers_fbo, GL_DEPTH_ATTACHMENT, m->depth, 0);
    static const GLenum both[2] = { GL_COLOR_ATTACHMENT0,
                                    GL_COLOR_ATTACHMENT1 };
    glCreateFramebuffers(PEL_OBJECT_MIRRORS, m->fbos);
    for (int i = 0; i < PEL_OBJECT_MIRRORS; i++) {
        glNamedFramebufferTextureLayer(m->fbos[i], GL_COLOR_ATTACHMENT0,
                                       m->radiance, 0, i);
        glNamedFramebufferTextureLayer(m->fbos[i], GL_COLOR_ATTACHMENT1,
                                       m->away, 0, i);
        glNamedFramebufferDrawBuffers(m->fbos[i], 2, both);
        glNamedFramebufferTexture(m->fbos[i], GL_DEPTH_ATTACHMENT, m->depth, 0);
    }
    return PEL_OK;
}

void pel_mirrors_finish(struct pel_mirrors *m)
{
    glDeleteFramebuffers(PEL_OBJECT_MIRRORS, m->fbos);
    glDeleteTextures(1, &m->radiance);
    glDeleteTextures(1, &m->away);
    glDeleteTextures(1, &m->depth);
    glDeleteTextures(1, &m->numbers);
    glDeleteFramebuffers(1, &m->numbers_fbo);
    pel_program_delete(m->raster[0]);
    pel_program_delete(m->raster[1]);
    pel_program_delete(m->program);
    pel_program_delete(m->mips_program);
    *m = (struct pel_mirrors){ 0 };
}

bool pel_mirror_look(const struct pel_vec3 *points, int count, double sea_m,
                     double px, struct pel_mirror_view *out)
{
    const struct pel_vec3 image = { 0, 0, 2 * sea_m };
    struct pel_vec3 middle = { 0, 0, 0 };
    for (int i = 0; i < count; i++) {
        middle = pel_vec3_add(middle, pel_vec3_scale(points[i], 1.0 / count));
    }
    middle = pel_vec3_add(middle, pel_vec3_scale(image, -1));
    double level = hypot(middle.x, middle.y);
    const struct pel_vec3 side = { level > 1e-3 ? middle.y / level : 1,
                                   level > 1e-3 ? -middle.x / level : 0, 0 };
    out->forward = pel_vec3_normalize(middle);
    out->across = side;
    out->upward = pel_vec3_cross(side, out->forward);
    out->image_m = image.z;
    out->middle_m = sqrt(pel_vec3_dot(middle, middle));
    double box[4] = { HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL };
    for (int i = 0; i < count; i++) {
        struct pel_vec3 p = pel_vec3_add(points[i], pel_vec3_scale(image, -1));
        double depth = pel_vec3_dot(p, out->forward);
        if (depth < NEAREST_M) {
            return false;
        }
        double x = pel_vec3_dot(p, out->across) / depth;
        double y = pel_vec3_dot(p, out->upward) / depth;
        box[0] = fmin(box[0], x);
        box[1] = fmin(box[1], y);
        box[2] = fmax(box[2], x);
        box[3] = fmax(box[3], y);
    }
    double part = 1.0;
    while (part > 0.125 && 0.5 * part * PEL_MIRROR_WIDTH > px) {
        part *= 0.5;
    }
    double wide = fmax(box[2] - box[0], 1e-6),
           tall = fmax(box[3] - box[1], 1e-6);
    out->left = box[0] - MARGIN * wide;
    out->low = box[1] - MARGIN * tall;
    out->per_x = part / ((1 + 2 * MARGIN) * wide);
    out->per_y = part / ((1 + 2 * MARGIN) * tall);
    out->part = part;
    return true;
}

void pel_mirrors_begin(struct pel_mirrors *m)
{
    glViewport(0, 0, PEL_MIRROR_WIDTH, PEL_MIRROR_HEIGHT);
    glBindTextureUnit(PEL_UNIT_OBJECTS, m->numbers);
    m->views = 0;
    m->part = 0;
}

void pel_mirrors_draw(struct pel_mirrors *m, int layer, double part, bool holed,
                      void (*draw)(const void *user, int i), const void *user,
                      int i)
{
    static const GLfloat nothing[4] = { 0 };
    GLuint fbo = m->fbos[layer];
    m->views = layer >= m->views ? layer + 1 : m->views;
    /* What this picture or the one before it may have drawn into. */
    double cleared = m->parts[layer] > 0 ? fmax(m->parts[layer], part) : 1.0;
    m->parts[layer] = part;
    m->part = fmax(m->part, cleared);
    const GLsizei width = (GLsizei)(cleared * PEL_MIRROR_WIDTH),
                  height = (GLsizei)(cleared * PEL_MIRROR_HEIGHT);
    glScissor(0, 0, width, height);
    glDepthMask(GL_TRUE);
    glClearNamedFramebufferfv(m->numbers_fbo, GL_DEPTH, 0, nothing);
    /* By framebuffers it takes hardware half as long again. */
    glClearTexSubImage(m->radiance, 0, 0, 0, layer, width, height, 1, GL_RGBA,
                       GL_FLOAT, NULL);
    glClearTexSubImage(m->away, 0, 0, 0, layer, width, height, 1, GL_RG,
                       GL_FLOAT, NULL);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, m->numbers_fbo);
    pel_program_use(m->raster[holed]);
    glEnable(GL_CLIP_DISTANCE0);
    glDepthFunc(GL_GREATER);
    draw(user, i);
    glDisable(GL_CLIP_DISTANCE0);
    /* Where there is something. */
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_LESS);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, fbo);
    pel_program_use(m->program);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static GLuint groups_of(double texels, int level)
{
    return (GLuint)ceil(texels / (1 << level) / PEL_GROUP_SIDE);
}

/* glGenerateTextureMipmap takes a draw for each view and level, of those that
 * were not drawn too. */
void pel_mirrors_end(struct pel_mirrors *m)
{
    glBindTextureUnit(PEL_UNIT_MIRRORS, m->radiance);
    glBindTextureUnit(PEL_UNIT_MIRROR_DEPTHS, m->away);
    pel_program_use(m->mips_program);
    for (GLint level = 1; level < PEL_MIRROR_LEVELS; level++) {
        glBindImageTexture(PEL_IMAGE_MIRRORS, m->radiance, level, GL_TRUE, 0,
                           GL_WRITE_ONLY, GL_RGBA16F);
        glBindImageTexture(PEL_IMAGE_MIRROR_DEPTHS, m->away, level, GL_TRUE, 0,
                           GL_WRITE_ONLY, GL_RG16F);
        glUniform1i(0, level - 1);
        glDispatchCompute(groups_of(m->part * PEL_MIRROR_WIDTH, level),
                          groups_of(m->part * PEL_MIRROR_HEIGHT, level),
                          (GLuint)m->views);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    }
}
