#include "render/targets.h"

#include <stddef.h>

#define SMALL_DRAWS 256

void pel_targets_finish(struct pel_targets *t)
{
    const GLuint textures[] = { t->triangles, t->depth_test, t->color };
    const GLuint fbos[] = { t->surface_fbo, t->light_fbo, t->layers_fbo,
                            t->color_fbo, t->parts_fbo };
    glDeleteTextures(3, textures);
    glDeleteBuffers(1, &t->keys);
    glDeleteTextures(PEL_HDR_ATTACHMENTS, t->hdr);
    glDeleteTextures(PEL_WATER_PARTS, t->parts);
    glDeleteFramebuffers(5, fbos);
    *t = (struct pel_targets){ 0 };
}

static GLuint make_target(GLenum format, uint32_t width, uint32_t height,
                          const char *label)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, format, (GLsizei)width, (GLsizei)height);
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

const GLenum pel_hdr_formats[PEL_HDR_ATTACHMENTS] = {
    GL_RGBA32F, GL_R32F,    GL_RGBA32F, GL_RGBA32F,
    GL_RGBA32F, GL_RGBA32F, GL_RGBA32F, GL_RG32F,
};
static const char *const hdr_labels[PEL_HDR_ATTACHMENTS] = {
    "radiance", "depth", "normal", "sun",
    "sky",      "water", "air",    "slope variance",
};

static void make_layer_targets(struct pel_targets *t)
{
    GLenum buffers[PEL_HDR_ATTACHMENTS];
    glCreateFramebuffers(1, &t->layers_fbo);
    for (unsigned i = 0; i < PEL_HDR_ATTACHMENTS; i++) {
        if (i > 0) {
            t->hdr[i] = make_target(pel_hdr_formats[i], t->width, t->height,
                                    hdr_labels[i]);
        }
        buffers[i] = GL_COLOR_ATTACHMENT0 + i;
        glNamedFramebufferTexture(t->layers_fbo, buffers[i], t->hdr[i], 0);
    }
    glNamedFramebufferTexture(t->layers_fbo, GL_DEPTH_ATTACHMENT, t->depth_test,
                              0);
    glNamedFramebufferDrawBuffers(t->layers_fbo, PEL_HDR_ATTACHMENTS, buffers);
}

static void make_part_targets(struct pel_targets *t)
{
    GLenum buffers[PEL_WATER_PARTS];
    glCreateFramebuffers(1, &t->parts_fbo);
    for (unsigned i = 0; i < PEL_WATER_PARTS; i++) {
        t->parts[i] =
            make_target(GL_RGBA32F, t->width, t->height, "part of the water");
        buffers[i] = GL_COLOR_ATTACHMENT0 + i;
        glNamedFramebufferTexture(t->parts_fbo, buffers[i], t->parts[i], 0);
    }
    glNamedFramebufferTexture(t->parts_fbo, GL_DEPTH_ATTACHMENT, t->depth_test,
                              0);
    glNamedFramebufferDrawBuffers(t->parts_fbo, PEL_WATER_PARTS, buffers);
}

void pel_targets_fit(struct pel_targets *t, uint32_t width, uint32_t height,
                     bool layers, bool parts)
{
    bool small = (size_t)width * height * 4 < (size_t)t->width * t->height;
    t->small_draws = small ? t->small_draws + 1 : 0;
    if (t->small_draws > SMALL_DRAWS) {
        pel_targets_finish(t);
    }
    if (width > t->width || height > t->height) {
        uint32_t w = width > t->width ? width : t->width;
        uint32_t h = height > t->height ? height : t->height;
        pel_targets_finish(t);
        t->width = w;
        t->height = h;
        t->triangles = make_target(GL_R32UI, w, h, "triangles");
        glCreateBuffers(1, &t->keys);
        glNamedBufferStorage(t->keys, (GLsizeiptr)w * h * 4, NULL, 0);
        glClearNamedBufferData(t->keys, GL_R32UI, GL_RED_INTEGER,
                               GL_UNSIGNED_INT, NULL);
        glObjectLabel(GL_BUFFER, t->keys, -1, "keys");
        t->depth_test = make_target(GL_DEPTH_COMPONENT32F, w, h, "depth test");
        t->hdr[0] = make_target(pel_hdr_formats[0], w, h, hdr_labels[0]);
        t->color = make_target(GL_RGBA8, w, h, "color");
        GLuint *fbos[] = { &t->surface_fbo, &t->light_fbo, &t->color_fbo };
        const GLuint colors[] = { t->triangles, t->hdr[0], t->color };
        for (int i = 0; i < 3; i++) {
            glCreateFramebuffers(1, fbos[i]);
            glNamedFramebufferTexture(*fbos[i], GL_COLOR_ATTACHMENT0, colors[i],
                                      0);
            glNamedFramebufferTexture(*fbos[i], GL_DEPTH_ATTACHMENT,
                                      t->depth_test, 0);
        }
    }
    if (layers && !t->layers_fbo) {
        make_layer_targets(t);
    }
    if (parts && !t->parts_fbo) {
        make_part_targets(t);
    }
}
