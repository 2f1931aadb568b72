#include "render/lampmap.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "optics/lamp.h"
#include "optics/light.h"
#include "render/lampglow.h"
#include "render/shader.h"
#include "scene/globe.h"
#include "scene/objectray.h"
#include "seabed/seabed.h"
#include "shaders/lib/blocks.h"

#define LEAST_LX 1e-9 /* fainter is not drawn */
#define CLEAR_M 1.0   /* what stands so near to a lamp does not hide it */
#define BESIDE_M 0.25 /* rays to it that decide how much of it is hidden */
#define LAND_STEPS 96
_Static_assert(PEL_LAMP_SPOTS == PEL_MAX_LAMPS, "a bit for each lamp");

static double luminance(const double m[9], const double light[3])
{
    static const double weight[3] = { 0.2126, 0.7152, 0.0722 };
    double sum = 0;
    for (int i = 0; i < 9; i++) {
        sum += weight[i / 3] * m[i] * light[i % 3];
    }
    return sum;
}

/* --- what hides it -------------------------------------------------------- */

static bool land_between(const struct pel_seabed *bed, struct pel_vec3 eye,
                         struct pel_vec3 offset)
{
    for (int i = 1; bed && i < LAND_STEPS; i++) {
        double s = (double)i / LAND_STEPS;
        struct pel_vec3 at = pel_globe_at(eye, pel_vec3_scale(offset, s));
        double height_m = 0;
        if (pel_seabed_height(bed, at.x, at.y, &height_m) && height_m > at.z) {
            return true;
        }
    }
    return false;
}

/* Share of it that is above the horizon: of waves whose crests differ in height
 * there, where the straight way to it passes nearest to the mean sea. */
static double above_horizon(const struct pel_environment *env,
                            struct pel_vec3 eye, struct pel_vec3 offset)
{
    const double radius = PEL_EARTH_RADIUS + env->sea_level_m;
    double up = radius + eye.z - env->sea_level_m;
    double at = -up * offset.z / pel_vec3_dot(offset, offset);
    if (at <= 0 || at >= 1) {
        return 1;
    }
    struct pel_vec3 nearest = pel_vec3_scale(offset, at);
    nearest.z += up;
    double over_m = sqrt(pel_vec3_dot(nearest, nearest)) - radius;
    return fmin(fmax(0.5 + 0.5 * over_m / (sqrt(env->sea->m0) + 0.1), 0), 1);
}

/* Share of it that nothing solid hides. */
static double in_sight(const struct pel_environment *env, struct pel_vec3 eye,
                       struct pel_vec3 offset, double away_m)
{
    if (land_between(env->seabed, eye, offset)) {
        return 0;
    }
    const struct pel_vec3 level =
        pel_vec3_scale((struct pel_vec3){ -offset.y, offset.x, 0 },
                       BESIDE_M / fmax(hypot(offset.x, offset.y), 1e-3));
    const struct pel_vec3 beside[5] = { { 0, 0, 0 },
                                        level,
                                        pel_vec3_scale(level, -1),
                                        { 0, 0, BESIDE_M },
                                        { 0, 0, -BESIDE_M } };
    int seen = 0;
    for (int i = 0; i < 5; i++) {
        struct pel_vec3 to =
            pel_vec3_normalize(pel_vec3_add(offset, beside[i]));
        struct pel_object_hit hit;
        seen += !pel_objects_cast(env->objects, env->object_count, -1, eye, to,
                                  0.05, away_m - CLEAR_M, &hit);
    }
    return seen / 5.0;
}

/* --- a view's ------------------------------------------------------------- */

/* Where on the lattice, pixels; false: behind the eye or too far out. */
static bool place_of(const struct pel_camera *c,
                     const struct pel_block_view *view, struct pel_vec3 offset,
                     double out[2])
{
    const struct pel_mat3 *m = &c->world_from_camera;
    double ahead = -pel_vec3_dot(m->z, offset);
    if (ahead <= 0) {
        return false;
    }
    out[0] = pel_vec3_dot(m->x, offset) / ahead / (double)view->pixel.x;
    out[1] = -pel_vec3_dot(m->y, offset) / ahead / (double)view->pixel.y;
    double x = out[0] - (double)view->pixel.z,
           y = out[1] - (double)view->pixel.w, reach = PEL_LAMP_REACH + 2;
    return x > -reach && y > -reach && x < (double)view->size.x + reach &&
           y < (double)view->size.y + reach;
}

void pel_lamp_map_plan(struct pel_lamp_map *map,
                       const struct pel_environment *env,
                       const struct pel_camera *c,
                       const struct pel_block_view *view)
{
    double m[9], inverse[9];
    pel_lights_colours(env->lights, env->lit, env->night.on, m);
    pel_lamp_inverse(m, inverse);
    const struct pel_vec3 eye = { c->east_m, c->north_m,
                                  c->altitude_m + env->sea_level_m };
    map->count = 0;
    for (size_t i = 0; i < env->lamp_count; i++) {
        const struct pel_lamp *lamp = &env->lamps[i];
        struct pel_vec3 offset = pel_globe_offset(
            eye,
            (struct pel_vec3){ lamp->east_m, lamp->north_m, lamp->altitude_m });
        double away_m = sqrt(pel_vec3_dot(offset, offset)), place[2];
        if (lamp->unseen || !(away_m > 0.1) ||
            !place_of(c, view, offset, place)) {
            continue;
        }
        double share =
            pel_lamp_towards(lamp, pel_vec3_scale(offset, -1 / away_m));
        double light[3];
        pel_lamp_spectral(m, inverse, lamp->intensity_cd, light);
        if (luminance(m, light) * share / (away_m * away_m) < LEAST_LX) {
            continue;
        }
        share *= above_horizon(env, eye, offset);
        share *= share > 0 ? in_sight(env, eye, offset, away_m) : 0;
        if (share > 0) {
            map->lamps[map->count++] = (struct pel_shader_lamp){
                .place = { (float)offset.x, (float)offset.y, (float)offset.z,
                           (float)away_m },
                .light = { (float)(light[0] * share), (float)(light[1] * share),
                           (float)(light[2] * share), (float)lamp->size_m },
                .spot = { (float)place[0], (float)place[1], (float)c->glare,
                          0 },
            };
        }
    }
}

/* --- programs ------------------------------------------------------------- */

enum pel_err pel_lamp_map_need(struct pel_lamp_map *map,
                               const struct pel_programs *p,
                               const struct pel_environment *env,
                               struct pel_fault *fault)
{
    if (env->lamp_count == 0) {
        return PEL_OK;
    }
    if (!map->lamps) {
        map->lamps = malloc(sizeof *map->lamps * PEL_MAX_LAMPS);
        if (!map->lamps) {
            return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
        }
        glCreateBuffers(1, &map->spots);
        glNamedBufferStorage(map->spots,
                             sizeof(struct pel_shader_spot) * PEL_MAX_LAMPS,
                             NULL, 0);
        glObjectLabel(GL_BUFFER, map->spots, -1, "lamps");
        glCreateTextures(GL_TEXTURE_BUFFER, 1, &map->spots_texels);
        glTextureBuffer(map->spots_texels, GL_RGBA32F, map->spots);
        glCreateFramebuffers(1, &map->fbo);
    }
    char defines[512];
    snprintf(defines, sizeof defines, "%s%s", pel_light_defines(p->light),
             p->compute ? "#define PEL_KEYS\n" : "");
    GLuint *find = &map->find[p->compute][p->light];
    enum pel_err err = PEL_OK;
    if (!*find) {
        err = pel_program_create(p->shader_dir, "lamps.comp", NULL, defines,
                                 find, fault);
    }
    if (err == PEL_OK && p->compute && !map->alone) {
        err = pel_program_create(p->shader_dir, "lamp.comp", NULL, NULL,
                                 &map->alone, fault);
    }
    if (err == PEL_OK && !map->put) {
        err = pel_program_create(p->shader_dir, "lamp.vert", "lamp.frag", NULL,
                                 &map->put, fault);
    }
    for (int added = 0; added < 2; added++) {
        snprintf(defines, sizeof defines, "%s#define PEL_LAMPS\n%s",
                 pel_light_defines(p->light),
                 added ? "#define PEL_LAMPS_ADDED\n" : "");
        GLuint *tone = &map->tone[added][p->light];
        if (err == PEL_OK && !*tone) {
            err = pel_program_create(p->shader_dir, "screen.vert", "tone.frag",
                                     defines, tone, fault);
        }
    }
    return err;
}

void pel_lamp_map_finish(struct pel_lamp_map *map)
{
    glDeleteBuffers(1, &map->spots);
    glDeleteTextures(1, &map->spots_texels);
    glDeleteTextures(1, &map->light);
    glDeleteFramebuffers(1, &map->fbo);
    for (int i = 0; i < PEL_LIGHT_KINDS; i++) {
        pel_program_delete(map->find[0][i]);
        pel_program_delete(map->find[1][i]);
        pel_program_delete(map->tone[0][i]);
        pel_program_delete(map->tone[1][i]);
    }
    pel_program_delete(map->put);
    pel_program_delete(map->alone);
    free(map->lamps);
    *map = (struct pel_lamp_map){ 0 };
}

size_t pel_lamp_map_bytes(const struct pel_environment *env)
{
    return env->lamp_count
               ? sizeof(struct pel_shader_lamp) * env->lamp_count + 1024
               : 0;
}

void pel_lamp_map_find(struct pel_lamp_map *map, const struct pel_programs *p,
                       const struct pel_targets *targets,
                       struct pel_arena *arena)
{
    if (map->count == 0) {
        return;
    }
    pel_arena_bind(arena, GL_SHADER_STORAGE_BUFFER, PEL_STORE_LAMPS, map->lamps,
                   sizeof *map->lamps * map->count);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_SPOTS, map->spots);
    glBindTextureUnit(PEL_UNIT_TRIANGLES, targets->triangles);
    pel_program_use(map->find[p->compute][p->light]);
    glUniform1ui(0, (GLuint)map->count);
    glDispatchCompute(
        ((GLuint)map->count + PEL_GROUP_LINE - 1) / PEL_GROUP_LINE, 1, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

static void draw_alone(struct pel_lamp_map *map, uint32_t width,
                       uint32_t height)
{
    static const GLfloat none[4] = { 0 };
    glNamedFramebufferTexture(map->fbo, GL_COLOR_ATTACHMENT0, map->light, 0);
    glScissor(0, 0, (GLsizei)width, (GLsizei)height);
    glEnable(GL_SCISSOR_TEST);
    glClearNamedFramebufferfv(map->fbo, GL_COLOR, 0, none);
    glDisable(GL_SCISSOR_TEST);
    pel_lamp_map_put(map, map->light, 1.0);
}

void pel_lamp_map_alone(struct pel_lamp_map *map, bool compute, uint32_t width,
                        uint32_t height)
{
    if (width > map->width || height > map->height) {
        map->width = width > map->width ? width : map->width;
        map->height = height > map->height ? height : map->height;
        glDeleteTextures(1, &map->light);
        glCreateTextures(GL_TEXTURE_2D, 1, &map->light);
        glTextureStorage2D(map->light, 1, GL_RGBA32F, (GLsizei)map->width,
                           (GLsizei)map->height);
        glObjectLabel(GL_TEXTURE, map->light, -1, "lamps alone");
    }
    if (compute) {
        glBindTextureUnit(PEL_UNIT_LAMPS, map->spots_texels);
        glBindImageTexture(PEL_IMAGE_RADIANCE, map->light, 0, GL_FALSE, 0,
                           GL_WRITE_ONLY, GL_RGBA32F);
        pel_program_use(map->alone);
        glUniform1ui(0, (GLuint)map->count);
        glDispatchCompute((width + PEL_GROUP_SIDE - 1) / PEL_GROUP_SIDE,
                          (height + PEL_GROUP_SIDE - 1) / PEL_GROUP_SIDE, 1);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    } else {
        draw_alone(map, width, height);
    }
    glBindTextureUnit(PEL_UNIT_LAMP_LIGHT, map->light);
}

void pel_lamp_map_put(struct pel_lamp_map *map, GLuint light, double share)
{
    if (map->count == 0) {
        return;
    }
    glNamedFramebufferTexture(map->fbo, GL_COLOR_ATTACHMENT0, light, 0);
    glDisable(GL_DEPTH_TEST);
    glBindTextureUnit(PEL_UNIT_LAMPS, map->spots_texels);
    glEnable(GL_BLEND);
    glBlendColor(0, 0, 0, (float)share);
    glBlendFuncSeparate(share < 1.0 ? GL_CONSTANT_ALPHA : GL_ONE, GL_ONE,
                        GL_ZERO, GL_ONE);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, map->fbo);
    pel_program_use(map->put);
    glDrawArraysInstanced(GL_TRIANGLES, 0, 6, (GLsizei)map->count);
    glDisable(GL_BLEND);
}
