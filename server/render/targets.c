#include "render/targets.h"

#include <stddef.h>

#define SMALL_DRAWS 256
#define KEPT_PIXELS (1u << 20) /* by who rests */

void pel_targets_finish(struct pel_targets *t)
{
    const GLuint textures[] = { t->triangles, t->depth_test, t->color };
    const GLuint fbos[] = { t->surface_fbo, t->light_fbo, t->layers_fbo,
                            t->color_fbo, t->both_fbo };
    glDeleteTextures(3, textures);
    glDeleteBuffers(1, &t->keys);
    glDeleteBuffers(1, &t->suspects);
    glDeleteBuffers(1, &t->edges);
    glDeleteTextures(PEL_LAYERS, t->planes);
    glDeleteFramebuffers(5, fbos);
    *t = (struct pel_targets){ 0 };
}

void pel_targets_rest(struct pel_targets *t)
{
    if ((size_t)t->width * t->height > KEPT_PIXELS) {
        pel_targets_finish(t);
    }
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

/* A buffer of what edges.c dispatches by, and of an entry for each pixel: what
 * did not fit would depend on the order of threads. */
static GLuint make_list(uint32_t width, uint32_t height, GLsizeiptr entry_bytes,
                        const char *label)
{
    GLuint list = 0;
    glCreateBuffers(1, &list);
    glNamedBufferStorage(list, 16 + (GLsizeiptr)width * height * entry_bytes,
                         NULL, GL_DYNAMIC_STORAGE_BIT);
    glObjectLabel(GL_BUFFER, list, -1, label);
    return list;
}

GLenum pel_plane_format(int layer)
{
    static const GLenum formats[] = { 0, GL_R32F, GL_RG32F, 0, GL_RGBA32F };
    return formats[pel_layer_stride(&pel_layer_table[layer])];
}

static void make_plane(struct pel_targets *t, int layer)
{
    t->planes[layer] = make_target(pel_plane_format(layer), t->width, t->height,
                                   pel_layer_table[layer].name);
}

GLuint pel_targets_attach(struct pel_targets *t, const struct pel_pass *pass)
{
    if (!pass->layers) {
        return pass->kind == PEL_SHADE_COLOR  ? t->color_fbo
               : pass->kind == PEL_SHADE_BOTH ? t->both_fbo
                                              : t->light_fbo;
    }
    if (!t->layers_fbo) {
        glCreateFramebuffers(1, &t->layers_fbo);
        glNamedFramebufferTexture(t->layers_fbo, GL_DEPTH_ATTACHMENT,
                                  t->depth_test, 0);
        glNamedFramebufferTexture(t->layers_fbo, GL_COLOR_ATTACHMENT0,
                                  t->planes[PEL_AT_RADIANCE], 0);
    }
    GLenum buffers[1 + PEL_FRAGMENT_SLOTS] = {
        pass->first ? GL_COLOR_ATTACHMENT0 : GL_NONE,
    };
    for (GLenum i = 0; i < PEL_FRAGMENT_SLOTS; i++) {
        GLint layer = pass->layer[i];
        GLenum place = GL_COLOR_ATTACHMENT1 + i;
        glNamedFramebufferTexture(t->layers_fbo, place,
                                  layer < 0 ? 0 : t->planes[layer], 0);
        buffers[1 + i] = layer < 0 ? GL_NONE : place;
    }
    glNamedFramebufferDrawBuffers(t->layers_fbo, 1 + PEL_FRAGMENT_SLOTS,
                                  buffers);
    return t->layers_fbo;
}

void pel_targets_fit(struct pel_targets *t, uint32_t width, uint32_t height,
                     unsigned asked)
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
        t->suspects = make_list(w, h, 16, "suspects, mixed light");
        t->edges = make_list(w, h, 8, "edges");
        t->depth_test = make_target(GL_DEPTH_COMPONENT32F, w, h, "depth test");
        make_plane(t, PEL_AT_RADIANCE);
        t->color = make_target(GL_RGBA8, w, h, "color");
        GLuint *fbos[] = { &t->surface_fbo, &t->light_fbo, &t->color_fbo,
                           &t->both_fbo };
        const GLuint colors[] = { t->triangles, t->planes[PEL_AT_RADIANCE],
                                  t->color, t->planes[PEL_AT_RADIANCE] };
        for (int i = 0; i < 4; i++) {
            glCreateFramebuffers(1, fbos[i]);
            glNamedFramebufferTexture(*fbos[i], GL_COLOR_ATTACHMENT0, colors[i],
                                      0);
            glNamedFramebufferTexture(*fbos[i], GL_DEPTH_ATTACHMENT,
                                      t->depth_test, 0);
        }
        static const GLenum both[] = { GL_COLOR_ATTACHMENT0,
                                       GL_COLOR_ATTACHMENT1 };
        glNamedFramebufferTexture(t->both_fbo, GL_COLOR_ATTACHMENT1, t->color,
                                  0);
        glNamedFramebufferDrawBuffers(t->both_fbo, 2, both);
    }
    const unsigned stored = pel_layers_stored(asked);
    for (int i = 0; i < PEL_LAYERS; i++) {
        if ((stored & pel_layer_table[i].bit) && !t->planes[i]) {
            make_plane(t, i);
        }
    }
}
