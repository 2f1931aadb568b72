#include "render/acuity.h"

#include <math.h>

#include "optics/vision.h"
#include "render/shader.h"
#include "shaders/lib/blocks.h"

/* Higher up no light is so little that the loss would be seen. */
#define SUN_SINE (-0.0349)

static bool is_dark(const struct pel_environment *env)
{
    for (int i = 0; i < PEL_LIGHTS; i++) {
        const struct pel_light *l = &env->lights[i];
        if (l->body == PEL_LIGHT_SUN && l->strength > 0.0 &&
            l->direction.z > SUN_SINE) {
            return false;
        }
    }
    return true;
}

int pel_acuity_border(const struct pel_environment *env,
                      const struct pel_camera *c, unsigned layers)
{
    if (c->vision != PEL_VISION_EYE || c->sensor.kind != PEL_SENSOR_NONE ||
        !(layers & PEL_LAYER_COLOR) || !is_dark(env)) {
        return 0;
    }
    /* As shaders/acuity.frag, at most anywhere in the picture. */
    double x = fmax(fabs(c->tan_left), fabs(c->tan_right));
    double y = fmax(fabs(c->tan_top), fabs(c->tan_bottom));
    double px = (c->tan_right - c->tan_left) / c->width;
    double py = (c->tan_top - c->tan_bottom) / c->height;
    double y2 = 1.0 + y * y, r2 = y2 + x * x;
    double angle = pel_vision_blur(0.0);
    double along = angle * fmax(r2 / sqrt(y2), 1.0 + x * x) * sqrt(y2) / px;
    double across = angle * sqrt(r2 * y2) / py;
    along = ceil(3.0 * fmin(along, PEL_ACUITY_WIDEST));
    across = ceil(3.0 * fmin(across, PEL_ACUITY_WIDEST));
    double lean = fmin(x * y, 0.5 * x) * py / px;
    double most = fmax(along + ceil(across * lean), across) + 1.0;
    return (int)fmin(most, PEL_ACUITY_BORDER);
}

void pel_acuity_meter(const struct pel_environment *env,
                      const struct pel_camera *c,
                      struct pel_block_sighted *sights)
{
    if (!c->auto_exposure && pel_acuity_border(env, c, PEL_LAYER_COLOR)) {
        sights->meter.x = (float)(c->sight_count ? c->sight_count : 1);
        sights->rod.w = PEL_VISION_EYE_FIXED;
    }
}

enum pel_err pel_acuity_need(struct pel_acuity *a, const char *shader_dir,
                             struct pel_fault *fault)
{
    static const char *const defines[2] = { "#define PEL_ALONG_ROWS\n", NULL };
    enum pel_err err = PEL_OK;
    for (int i = 0; i < 2 && err == PEL_OK; i++) {
        if (!a->programs[i]) {
            err = pel_program_create(shader_dir, "screen.vert", "acuity.frag",
                                     defines[i], &a->programs[i], fault);
        }
    }
    return err;
}

static void drop_textures(struct pel_acuity *a)
{
    glDeleteTextures(2, a->textures);
    glDeleteFramebuffers(2, a->fbos);
    a->width = a->height = 0;
}

void pel_acuity_finish(struct pel_acuity *a)
{
    drop_textures(a);
    pel_program_delete(a->programs[0]);
    pel_program_delete(a->programs[1]);
    *a = (struct pel_acuity){ 0 };
}

/* As large as the targets, which shrink and grow. */
static void fit(struct pel_acuity *a, const struct pel_targets *t)
{
    if (a->width == t->width && a->height == t->height) {
        return;
    }
    drop_textures(a);
    a->width = t->width;
    a->height = t->height;
    glCreateTextures(GL_TEXTURE_2D, 2, a->textures);
    glCreateFramebuffers(2, a->fbos);
    for (int i = 0; i < 2; i++) {
        glTextureStorage2D(a->textures[i], 1, GL_RGBA32F, (GLsizei)a->width,
                           (GLsizei)a->height);
        glTextureParameteri(a->textures[i], GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTextureParameteri(a->textures[i], GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        glObjectLabel(GL_TEXTURE, a->textures[i], -1, "acuity");
        glNamedFramebufferTexture(a->fbos[i], GL_COLOR_ATTACHMENT0,
                                  a->textures[i], 0);
    }
}

GLuint pel_acuity_run(struct pel_acuity *a, const struct pel_targets *t,
                      GLsizei width, GLsizei height, GLint border)
{
    fit(a, t);
    glDisable(GL_DEPTH_TEST);
    glBindTextureUnit(PEL_UNIT_RADIANCE, t->planes[PEL_AT_RADIANCE]);
    for (int i = 0; i < 2; i++) {
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, a->fbos[i]);
        pel_program_use(a->programs[i]);
        GLint skip = i ? border : 0;
        glViewport(skip, skip, width - 2 * skip, height - 2 * skip);
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glBindTextureUnit(PEL_UNIT_ACUITY_ROWS, a->textures[0]);
    }
    return a->textures[1];
}
