#include "render/renderer.h"

#include <epoxy/gl.h>
#include <stdlib.h>

#include "base/clock.h"
#include "render/context.h"
#include "render/readback.h"
#include "render/shader.h"

struct pel_renderer {
    struct pel_context context;
    struct pel_readback readback;
    GLuint vao, tone, light;
    GLuint color, hdr, dist, normal, color_fbo, hdr_fbo;
    uint32_t width, height;
};

const char *pel_stage_name(enum pel_stage stage)
{
    static const char *const names[] = { "sky", "mesh", "raster", "shade",
                                         "tone", "readback" };
    return (unsigned)stage < PEL_STAGE_COUNT ? names[stage] : "";
}

static void resize(struct pel_renderer *r, uint32_t w, uint32_t h)
{
    if (w <= r->width && h <= r->height) {
        return;
    }
    w = w > r->width ? w : r->width;
    h = h > r->height ? h : r->height;
    GLuint *textures[] = { &r->color, &r->hdr, &r->dist, &r->normal };
    static const GLenum formats[] = { GL_RGBA8, GL_RGBA32F, GL_R32F, GL_RGBA32F };
    for (int i = 0; i < 4; i++) {
        glDeleteTextures(1, textures[i]);
        glCreateTextures(GL_TEXTURE_2D, 1, textures[i]);
        glTextureStorage2D(*textures[i], 1, formats[i], (GLsizei)w, (GLsizei)h);
    }
    glNamedFramebufferTexture(r->color_fbo, GL_COLOR_ATTACHMENT0, r->color, 0);
    glNamedFramebufferTexture(r->hdr_fbo, GL_COLOR_ATTACHMENT0, r->hdr, 0);
    glNamedFramebufferTexture(r->hdr_fbo, GL_COLOR_ATTACHMENT1, r->dist, 0);
    glNamedFramebufferTexture(r->hdr_fbo, GL_COLOR_ATTACHMENT2, r->normal, 0);
    r->width = w;
    r->height = h;
}

enum pel_err pel_renderer_create(const struct pel_renderer_options *o,
                                 struct pel_renderer **out,
                                 struct pel_fault *fault)
{
    struct pel_renderer *r = calloc(1, sizeof *r);
    if (!r) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    enum pel_err err = pel_context_init(&r->context, o->device, o->debug, fault);
    if (err != PEL_OK) {
        goto fail;
    }
    err = pel_readback_init(&r->readback);
    if (err != PEL_OK) {
        goto fail;
    }
    err = pel_program_create(o->shader_dir, "screen.vert", "tone.frag", NULL,
                             &r->tone, fault);
    if (err != PEL_OK) {
        goto fail;
    }
    static const float ev[4] = { 15 };
    glCreateVertexArrays(1, &r->vao);
    glCreateBuffers(1, &r->light);
    glNamedBufferStorage(r->light, sizeof ev, ev, 0);
    glCreateFramebuffers(1, &r->color_fbo);
    glCreateFramebuffers(1, &r->hdr_fbo);
    *out = r;
    return PEL_OK;
fail:
    pel_renderer_destroy(r);
    return err;
}

void pel_renderer_destroy(struct pel_renderer *r)
{
    if (r) {
        if (r->context.context) {
            pel_readback_finish(&r->readback);
        }
        pel_context_finish(&r->context);
        free(r);
    }
}

const char *pel_renderer_description(const struct pel_renderer *r)
{
    return r->context.description;
}

bool pel_renderer_is_software(const struct pel_renderer *r)
{
    return r->context.software;
}

enum pel_err pel_renderer_submit(struct pel_renderer *r,
                                 const struct pel_environment *env,
                                 const struct pel_draw *draws, size_t count)
{
    (void)env;
    if (count > pel_readback_free(&r->readback)) {
        return PEL_ERR_BUSY;
    }
    for (size_t i = 0; i < count; i++) {
        int64_t started = pel_now_ns();
        const struct pel_camera *c = &draws[i].camera;
        resize(r, c->width, c->height);
        glBindVertexArray(r->vao);
        glViewport(0, 0, (GLsizei)c->width, (GLsizei)c->height);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, r->color_fbo);
        glUseProgram(r->tone);
        glDrawArrays(GL_TRIANGLES, 0, 3);
        struct pel_readback_source source = {
            .color_fbo = r->color_fbo,
            .hdr_fbo = r->hdr_fbo,
            .light = r->light,
            .width = c->width,
            .height = c->height,
            .layers = draws[i].layers,
            .user = draws[i].user,
            .started_ns = started,
        };
        enum pel_err err = pel_readback_push(&r->readback, &source);
        if (err != PEL_OK) {
            return err;
        }
    }
    return PEL_OK;
}

struct pel_picture *pel_renderer_collect(struct pel_renderer *r, int64_t wait_ns)
{
    return pel_readback_pop(&r->readback, wait_ns);
}

size_t pel_renderer_in_flight(const struct pel_renderer *r)
{
    return r->readback.in_flight;
}

void pel_renderer_measure(struct pel_renderer *r, bool on)
{
    (void)r, (void)on;
}

void pel_renderer_stage_ms(const struct pel_renderer *r,
                           double ms[PEL_STAGE_COUNT])
{
    (void)r;
    for (int i = 0; i < PEL_STAGE_COUNT; i++) {
        ms[i] = 0;
    }
}
