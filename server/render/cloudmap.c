#include "render/cloudmap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "optics/light.h"
#include "render/lampglow.h"
#include "render/programs.h"
#include "render/shader.h"
#include "shaders/lib/blocks.h"

#define SIDE PEL_CLOUD_SIDE
#define LEVELS 10

static GLuint make_tile(GLenum format, const char *label)
{
    GLuint t = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &t);
    glTextureStorage2D(t, LEVELS, format, SIDE, SIDE);
    glTextureParameteri(t, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTextureParameteri(t, GL_TEXTURE_WRAP_T, GL_REPEAT);
    glTextureParameteri(t, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glObjectLabel(GL_TEXTURE, t, -1, label);
    return t;
}

static GLuint make_fbo(GLuint texture)
{
    GLuint fbo = 0;
    glCreateFramebuffers(1, &fbo);
    glNamedFramebufferTexture(fbo, GL_COLOR_ATTACHMENT0, texture, 0);
    return fbo;
}

/* Rows `from` to before `to`. */
static void draw_rows(GLuint program, GLuint fbo, GLsizei width, GLsizei height,
                      GLint from, GLint to)
{
    glDisable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, fbo);
    glViewport(0, 0, width, height);
    pel_program_use(program);
    glScissor(0, from, width, to - from);
    glEnable(GL_SCISSOR_TEST);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_SCISSOR_TEST);
}

static void make_field(struct pel_cloud_map *map)
{
    float(*texels)[4] = pel_sure_malloc(sizeof *texels * SIDE * SIDE);
    pel_cloud_field(map->genus, map->seed, texels);
    /* Anew each time: a software device may still read the last one. */
    glDeleteTextures(1, &map->field);
    map->field = make_tile(GL_RGBA32F, "clouds");
    glTextureSubImage2D(map->field, 0, 0, 0, SIDE, SIDE, GL_RGBA, GL_FLOAT,
                        texels);
    glGenerateTextureMipmap(map->field);
    /* A third cheaper than between two levels. */
    glTextureParameteri(map->field, GL_TEXTURE_MIN_FILTER,
                        GL_LINEAR_MIPMAP_NEAREST);
    free(texels);
}

static void key_of(const struct pel_environment *env,
                   double key[PEL_CLOUD_KEYS])
{
    const struct pel_clouds *c = &env->clouds;
    const double all[] = { c->cover,  c->genus,
                           c->base_m, c->thickness_m,
                           c->seed,   atan2(c->north_mps, c->east_mps) };
    memcpy(key, all, sizeof all);
    for (int i = 0; i < PEL_LIGHTS; i++) {
        const struct pel_vec3 *to = &env->lights[i].direction;
        double *at = key + 6 + 3 * i;
        at[0] = i < env->lit ? to->x : 0;
        at[1] = i < env->lit ? to->y : 0;
        at[2] = i < env->lit ? to->z : 0;
    }
}

static void make_shade(struct pel_cloud_map *map,
                       const struct pel_environment *env)
{
    if (!map->shade) {
        map->shade = make_tile(GL_RGBA32F, "shade of clouds");
        map->shade_fbo = make_fbo(map->shade);
    }
    draw_rows(map->shade_program[env->lit - 1], map->shade_fbo, SIDE, SIDE, 0,
              SIDE);
    glGenerateTextureMipmap(map->shade);
}

enum pel_err pel_cloud_map_need(struct pel_cloud_map *map,
                                const struct pel_environment *env,
                                const char *shader_dir, struct pel_fault *fault)
{
    GLuint *program = &map->shade_program[env->lit - 1];
    return env->clouds.cover <= 0 || *program
               ? PEL_OK
               : pel_program_create(
                     shader_dir, "screen.vert", "cloud_shade.frag",
                     pel_light_program_defines(env), program, fault);
}

void pel_cloud_map_bind(struct pel_cloud_map *map,
                        const struct pel_environment *env,
                        void (*bind_eye)(void *user, double height_m),
                        void *user)
{
    const struct pel_clouds *clouds = &env->clouds;
    if (clouds->cover <= 0) {
        return;
    }
    if (!map->field || map->genus != clouds->genus ||
        map->seed != clouds->seed) {
        map->genus = clouds->genus;
        map->seed = clouds->seed;
        make_field(map);
    }
    glBindTextureUnit(PEL_UNIT_CLOUDS, map->field);
    double key[PEL_CLOUD_KEYS];
    key_of(env, key);
    if (memcmp(key, map->key, sizeof key) != 0) {
        memcpy(map->key, key, sizeof key);
        bind_eye(user, 0);
        make_shade(map, env);
    }
    glBindTextureUnit(PEL_UNIT_CLOUD_SHADE, map->shade);
}

/* Nodes that pixels from `first` on ask for, beyond them too. */
static GLsizei nodes(float first, float count, float a_pixel)
{
    return (GLsizei)(floorf((first + count) * a_pixel) -
                     floorf(first * a_pixel)) +
           4;
}

/* Whether a node of this row, counted from the lattice's axis, may serve the
 * sky: not more than three below the horizon, which dips by 0.08 at most. */
static bool row_has_sky(const struct pel_block_view *v, double row,
                        const double edges[2])
{
    double down = row * (double)v->pixel.y;
    double below = 0.08 + 3 * (double)(v->pixel.y / v->size.w);
    for (int i = 0; i < 2; i++) {
        double across = edges[i] * (double)v->pixel.x;
        double z = (double)v->right.z * across - (double)v->up.z * down -
                   (double)v->back.z;
        if (z > -below * sqrt(1 + across * across + down * down)) {
            return true;
        }
    }
    return false;
}

/* What flashes light within them, about the eye. */
static void set_glows(GLuint program, const struct pel_environment *env,
                      const struct pel_camera *camera)
{
    float places[PEL_CLOUD_GLOWS][4] = { 0 };
    double brightest = 0, m[9], inverse[9], light[3] = { 0 };
    for (size_t i = 0; i < env->glow_count; i++) {
        brightest = fmax(brightest, env->glows[i].intensity_cd[1]);
    }
    for (size_t i = 0; i < env->glow_count; i++) {
        const struct pel_lightning_glow *g = &env->glows[i];
        places[i][0] = (float)(g->east_m - camera->east_m);
        places[i][1] = (float)(g->north_m - camera->north_m);
        places[i][2] = (float)g->altitude_m;
        places[i][3] = (float)(g->intensity_cd[1] / brightest);
    }
    if (env->glow_count > 0) {
        /* Of one colour all. */
        const double *colour = env->glows[0].intensity_cd;
        const double all[3] = { brightest * colour[0] / colour[1], brightest,
                                brightest * colour[2] / colour[1] };
        pel_lights_colours(env->lights, env->lit, env->night.on, m);
        pel_lamp_inverse(m, inverse);
        pel_lamp_spectral(m, inverse, all, light);
    }
    pel_program_use(program);
    glUniform1i(PEL_UNIFORM_GLOW_COUNT, (GLint)env->glow_count);
    glUniform3f(PEL_UNIFORM_GLOW_LIGHT, (float)light[0], (float)light[1],
                (float)light[2]);
    glUniform4fv(PEL_UNIFORM_GLOWS, PEL_CLOUD_GLOWS, &places[0][0]);
}

void pel_cloud_map_scape(struct pel_cloud_map *map, GLuint program,
                         const struct pel_environment *env,
                         const struct pel_camera *camera,
                         const struct pel_block_view *view)
{
    if (env->storm) {
        set_glows(program, env, camera);
    }
    GLsizei width = nodes(view->pixel.z, view->size.x, view->size.w),
            height = nodes(view->pixel.w, view->size.y, view->size.w);
    if (width > map->width || height > map->height) {
        map->width = width > map->width ? width : map->width;
        map->height = height > map->height ? height : map->height;
        glDeleteTextures(1, &map->scape);
        glDeleteFramebuffers(1, &map->scape_fbo);
        glCreateTextures(GL_TEXTURE_2D, 1, &map->scape);
        glTextureStorage2D(map->scape, 1, GL_RGBA32F, map->width, map->height);
        glTextureParameteri(map->scape, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glObjectLabel(GL_TEXTURE, map->scape, -1, "clouds before the sky");
        map->scape_fbo = make_fbo(map->scape);
    }
    double a_node = 1 / (double)view->size.w;
    double left = (floor((double)(view->pixel.z * view->size.w)) - 1) * a_node,
           top = (floor((double)(view->pixel.w * view->size.w)) - 1) * a_node;
    const double edges[2] = { left, left + (width - 1) * a_node };
    GLint from = 0, to = height;
    while (from < to && !row_has_sky(view, top + from * a_node, edges)) {
        from++;
    }
    while (to > from && !row_has_sky(view, top + (to - 1) * a_node, edges)) {
        to--;
    }
    draw_rows(program, map->scape_fbo, width, height, from, to);
    glBindTextureUnit(PEL_UNIT_CLOUDSCAPE, map->scape);
}

void pel_cloud_map_finish(struct pel_cloud_map *map)
{
    const GLuint textures[] = { map->field, map->shade, map->scape },
                 fbos[] = { map->shade_fbo, map->scape_fbo };
    glDeleteTextures(3, textures);
    glDeleteFramebuffers(2, fbos);
    for (int i = 0; i < PEL_LIGHTS; i++) {
        pel_program_delete(map->shade_program[i]);
    }
    *map = (struct pel_cloud_map){ 0 };
}
