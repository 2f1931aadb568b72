#include "render/objects.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "optics/atmosphere.h"
#include "optics/wet.h"
#include "render/objectplan.h"
#include "render/objectshadow.h"
#include "render/shader.h"
#include "render/uniforms.h"

#define MOST_SLOTS (PEL_OBJECT_SHADOWS + PEL_MAX_ENTITIES)

/* --- life ------------------------------------------------------------------
 */

static void finish_targets(struct pel_objects *o)
{
    glDeleteFramebuffers(1, &o->fbo);
    glDeleteTextures(1, &o->seen);
    glDeleteTextures(1, &o->depth);
    o->fbo = o->seen = o->depth = 0;
    o->width = o->height = 0;
}

static void delete_shading(struct pel_objects *o)
{
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 3 * PEL_SHADE_COUNT; k++) {
            pel_program_delete(
                o->shade[i][k / PEL_SHADE_COUNT][k % PEL_SHADE_COUNT]);
        }
    }
    memset(o->shade, 0, sizeof o->shade);
}

void pel_objects_finish(struct pel_objects *o)
{
    pel_model_pool_finish(&o->pool);
    finish_targets(o);
    pel_mirrors_finish(&o->mirrors);
    glDeleteFramebuffers(PEL_OBJECT_SHADOWS, o->shadow_fbos);
    glDeleteTextures(1, &o->shadows);
    glDeleteTextures(1, &o->places);
    glDeleteTextures(1, &o->surroundings);
    glDeleteBuffers(1, &o->ambient);
    pel_program_delete(o->surroundings_program);
    pel_program_delete(o->ambient_program);
    for (int h = 0; h < 2; h++) {
        pel_program_delete(o->shadow_program[h]);
        pel_program_delete(o->raster[h]);
        pel_program_delete(o->raster_keys[h]);
    }
    delete_shading(o);
    pel_samples_finish(&o->samples);
    *o = (struct pel_objects){ 0 };
}

static void make_surroundings(struct pel_objects *o)
{
    glCreateTextures(GL_TEXTURE_2D, 1, &o->surroundings);
    glTextureStorage2D(o->surroundings, 6, GL_RGBA16F, PEL_SURROUNDINGS_SIZE,
                       PEL_SURROUNDINGS_SIZE);
    glTextureParameteri(o->surroundings, GL_TEXTURE_MIN_FILTER,
                        GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(o->surroundings, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(o->surroundings, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, o->surroundings, -1, "surroundings");
    glCreateBuffers(1, &o->ambient);
    glNamedBufferStorage(o->ambient, sizeof(struct pel_block_surroundings),
                         NULL, 0);
    glObjectLabel(GL_BUFFER, o->ambient, -1, "surroundings' light");
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &o->places);
}

static void make_shadows(struct pel_objects *o)
{
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &o->shadows);
    glTextureStorage3D(o->shadows, 1, GL_DEPTH_COMPONENT32F, PEL_SHADOW_SIZE,
                       PEL_SHADOW_SIZE, PEL_OBJECT_SHADOWS);
    glTextureParameteri(o->shadows, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(o->shadows, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(o->shadows, GL_TEXTURE_COMPARE_MODE,
                        GL_COMPARE_REF_TO_TEXTURE);
    glTextureParameteri(o->shadows, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    glTextureParameteri(o->shadows, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(o->shadows, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, o->shadows, -1, "objects' shadows");
    glCreateFramebuffers(PEL_OBJECT_SHADOWS, o->shadow_fbos);
    for (int i = 0; i < PEL_OBJECT_SHADOWS; i++) {
        glNamedFramebufferTextureLayer(o->shadow_fbos[i], GL_DEPTH_ATTACHMENT,
                                       o->shadows, 0, i);
        glNamedFramebufferDrawBuffer(o->shadow_fbos[i], GL_NONE);
    }
}

static enum pel_err need_shading(struct pel_objects *o,
                                 const struct pel_programs *p, bool sampled,
                                 int land, enum pel_shading kind,
                                 struct pel_fault *fault)
{
    kind = kind == PEL_SHADE_BOTH ? PEL_SHADE_LIGHT : kind;
    GLuint *program = &o->shade[sampled][land][kind];
    char defines[224 + PEL_LIGHT_TEXT];
    snprintf(
        defines, sizeof defines, "%s%s%s%s%s%s%s%s", pel_shading_defines(kind),
        pel_light_defines(p->light), p->lamps ? "#define PEL_LAMPS\n" : "",
        p->textured ? "#define PEL_TEXTURED\n" : "",
        sampled ? "#define PEL_SAMPLED\n" : "",
        land ? "#define PEL_LAND\n" : "", land == 2 ? "#define PEL_FFT\n" : "",
        land ? pel_hardware_defines(p->software) : "");
    return *program
               ? PEL_OK
               : pel_program_create(p->shader_dir, "screen.vert",
                                    "objects.frag", defines, program, fault);
}

/* Of models without holes or with. */
static enum pel_err need_raster(struct pel_objects *o,
                                const struct pel_programs *p, bool middles,
                                int holed, struct pel_fault *fault)
{
    GLuint *raster = p->compute ? &o->raster_keys[holed] : &o->raster[holed];
    enum pel_err err = PEL_OK;
    char defines[64];
    snprintf(defines, sizeof defines, "%s%s",
             p->compute ? "#define PEL_KEYS\n" : "",
             holed ? "#define PEL_HOLES\n" : "");
    if (middles && !*raster) {
        err = pel_program_create(p->shader_dir, "object.vert", "object.frag",
                                 defines, raster, fault);
    }
    if (err == PEL_OK && !o->shadow_program[holed]) {
        err = pel_program_create(p->shader_dir, "shadow.vert", "shadow.frag",
                                 holed ? "#define PEL_HOLES\n" : NULL,
                                 &o->shadow_program[holed], fault);
    }
    return err;
}

enum pel_err pel_objects_fit(struct pel_objects *o,
                             const struct pel_environment *env,
                             struct pel_programs *p, struct pel_fault *fault)
{
    enum pel_err err = pel_model_pool_fit(&o->pool, env, fault);
    bool other = o->light != p->light || o->lamps != p->lamps;
    o->light = p->light;
    o->lamps = p->lamps;
    if (err == PEL_OK && other) {
        pel_program_delete(o->surroundings_program);
        o->surroundings_program = 0;
    }
    bool painted = o->pool.textured != p->textured;
    if (err == PEL_OK && painted) {
        pel_programs_texture(p, o->pool.textured);
    }
    if (err == PEL_OK && (other || painted)) {
        delete_shading(o);
        pel_mirrors_forget_program(&o->mirrors);
    }
    return err;
}

enum pel_err pel_objects_need(struct pel_objects *o,
                              const struct pel_environment *env,
                              const struct pel_programs *p,
                              enum pel_shading kind, struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    bool middles = kind >= PEL_SHADE_LAYERS;
    for (int h = 0; h < (o->pool.holed ? 2 : 1) && err == PEL_OK; h++) {
        err = need_raster(o, p, middles, h, fault);
    }
    if (err == PEL_OK) {
        err = pel_samples_need(&o->samples, p, o->pool.holed, fault);
    }
    const int land = env->sea->cascades ? 2 : 1;
    for (int k = 0; k < 4 && err == PEL_OK && !p->compute; k++) {
        bool sampled = k & 1, wanted = sampled || middles;
        if (wanted && (k < 2 || env->seabed)) {
            err = need_shading(o, p, sampled, k < 2 ? 0 : land, kind, fault);
        }
    }
    if (err == PEL_OK && !o->surroundings_program) {
        err = pel_program_create(p->shader_dir, "surroundings.comp", NULL,
                                 pel_light_defines(p->light),
                                 &o->surroundings_program, fault);
    }
    if (err == PEL_OK && !o->ambient_program) {
        err = pel_program_create(p->shader_dir, "ambient.comp", NULL, NULL,
                                 &o->ambient_program, fault);
    }
    if (err == PEL_OK) {
        char lights[32 + PEL_LIGHT_TEXT];
        snprintf(lights, sizeof lights, "%s%s", pel_light_defines(p->light),
                 p->lamps ? "#define PEL_LAMPS\n" : "");
        err = pel_mirrors_need(&o->mirrors, p->shader_dir, p->textured,
                               o->pool.holed, lights, fault);
    }
    if (err == PEL_OK && !o->surroundings) {
        make_surroundings(o);
        make_shadows(o);
    }
    return err;
}

GLuint pel_objects_program(const struct pel_objects *o, bool sampled,
                           unsigned tile, enum pel_shading kind, bool fft)
{
    bool land = (tile & PEL_TILE_COAST) == PEL_COAST_LAND;
    return o->shade[sampled][land ? 1 + fft : 0][kind];
}

void pel_objects_use(const struct pel_objects *o, unsigned tile, bool one)
{
    unsigned near = PEL_TILE_SHADED(tile) | PEL_TILE_MIRRORED(tile);
    for (int i = 0; i < PEL_OBJECT_SHADOWS && one; i++) {
        if (near == 1U << i) {
            glUniform4fv(PEL_UNIFORM_PLACE, PEL_OBJECT_PLACE_TEXELS,
                         &o->near[i].texels[0].x);
        }
    }
    GLint shaded = (GLint)PEL_TILE_SHADED(tile);
    glUniform3i(PEL_UNIFORM_NEAR, (GLint)PEL_TILE_MIRRORED(tile), shaded,
                tile & PEL_TILE_HULLS ? shaded : 0);
}

/* --- light ------------------------------------------------------------------
 */

void pel_objects_light(struct pel_objects *o, const struct pel_sky *sky)
{
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_SURROUNDINGS, o->ambient);
    glBindTextureUnit(PEL_UNIT_SURROUNDINGS, o->surroundings);
    if (o->light_made &&
        memcmp(o->light_key, sky->light_key, sizeof o->light_key) == 0) {
        return;
    }
    glBindTextureUnit(PEL_UNIT_REFLECTION, sky->reflection);
    glBindTextureUnit(PEL_UNIT_SECOND, sky->second);
    glBindTextureUnit(PEL_UNIT_WATER, sky->water.map);
    glBindTextureUnit(PEL_UNIT_SKY_TABLE, sky->sea.radiance);
    glBindImageTexture(PEL_IMAGE_SURROUNDINGS, o->surroundings, 0, GL_FALSE, 0,
                       GL_WRITE_ONLY, GL_RGBA16F);
    pel_program_use(o->surroundings_program);
    glDispatchCompute(PEL_SURROUNDINGS_SIZE / PEL_GROUP_SIDE,
                      PEL_SURROUNDINGS_SIZE / PEL_GROUP_SIDE, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT |
                    GL_TEXTURE_UPDATE_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
    glGenerateTextureMipmap(o->surroundings);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_SURROUNDINGS,
                     o->ambient);
    pel_program_use(o->ambient_program);
    glDispatchCompute(1, 1, 1);
    glMemoryBarrier(GL_UNIFORM_BARRIER_BIT);
    memcpy(o->light_key, sky->light_key, sizeof o->light_key);
    o->light_made = true;
}

/* --- drawing ----------------------------------------------------------------
 */

static void fit_targets(struct pel_objects *o, uint32_t width, uint32_t height)
{
    if (width <= o->width && height <= o->height) {
        return;
    }
    uint32_t w = width > o->width ? width : o->width;
    uint32_t h = height > o->height ? height : o->height;
    finish_targets(o);
    o->width = w;
    o->height = h;
    glCreateTextures(GL_TEXTURE_2D, 1, &o->seen);
    glTextureStorage2D(o->seen, 1, GL_RG32UI, (GLsizei)w, (GLsizei)h);
    glTextureParameteri(o->seen, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(o->seen, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glObjectLabel(GL_TEXTURE, o->seen, -1, "objects");
    glCreateTextures(GL_TEXTURE_2D, 1, &o->depth);
    glTextureStorage2D(o->depth, 1, GL_DEPTH_COMPONENT32F, (GLsizei)w,
                       (GLsizei)h);
    glObjectLabel(GL_TEXTURE, o->depth, -1, "objects' depth test");
    glCreateFramebuffers(1, &o->fbo);
    glNamedFramebufferTexture(o->fbo, GL_COLOR_ATTACHMENT0, o->seen, 0);
    glNamedFramebufferTexture(o->fbo, GL_DEPTH_ATTACHMENT, o->depth, 0);
}

size_t pel_objects_bytes(const struct pel_environment *env)
{
    return env->object_count
               ? (env->object_count + PEL_OBJECT_SHADOWS) *
                         PEL_OBJECT_PLACE_TEXELS * sizeof(struct pel_vec4) +
                     1024
               : 0;
}

static struct pel_vec4 vec4(struct pel_vec3 v, double w)
{
    return (struct pel_vec4){ (float)v.x, (float)v.y, (float)v.z, (float)w };
}

/* The layers of shadows of others that may fall on it, as bits. */
static float shadowed_by(const struct pel_objects *o,
                         const struct pel_environment *env,
                         const struct pel_object_drawn *d)
{
    unsigned bits = 0;
    for (int i = 0; i < o->drawn_count; i++) {
        const struct pel_object_drawn *other = &o->drawn[i];
        if (other != d && other->slot < PEL_OBJECT_SHADOWS &&
            pel_shadow_reaches(env, &env->objects[other->object],
                               &env->objects[d->object])) {
            bits |= 1U << other->slot;
        }
    }
    return (float)bits;
}

/* 1/m: of light in the water, which turned forward goes on. */
static float fade_of(const struct pel_environment *env, int i)
{
    const struct pel_water_body *w = &env->water;
    double particles = fmax(w->scattering[i] - w->molecular[i], 0);
    return (float)(w->absorption[i] + 0.5 * w->molecular[i] +
                   w->back[i] * particles);
}

/* The texels of lib/model.glsl: placed_object, object_facts, in_hull. */
static void place(const struct pel_objects *o,
                  const struct pel_environment *env, const struct pel_camera *c,
                  const struct pel_object_drawn *d, struct pel_vec4 *out)
{
    const struct pel_object *object = &env->objects[d->object];
    const struct pel_mat3 *m = &object->world_from_model;
    const float *plan = o->pool.models[d->model].plan;
    struct pel_vec3 origin = pel_object_origin(env, object, c);
    out[0] = vec4(m->x, origin.x);
    out[1] = vec4(m->y, origin.y);
    out[2] = vec4(m->z, origin.z);
    out[3] = (struct pel_vec4){ (float)object->id, (float)object->model->class,
                                (float)d->model,
                                d->slot < PEL_OBJECT_SHADOWS ? (float)d->slot
                                                             : -1.0f };
    out[4] = (struct pel_vec4){ plan[0], plan[1], plan[2], plan[3] };
    pel_shadow_look(env, object, d->shadow_px, &out[5]);
    const struct pel_mirror_view *image = &d->image;
    out[8] = vec4(image->forward, d->slot);
    out[9] = vec4(image->across, image->image_m);
    out[10] = vec4(image->upward, shadowed_by(o, env, d));
    out[11] = (struct pel_vec4){ (float)image->left, (float)image->low,
                                 (float)image->per_x, (float)image->per_y };
    memcpy(&out[12], d->in_mirror, sizeof out[12]);
    memcpy(&out[13], d->in_shade, sizeof out[13]);
    memcpy(&out[17], d->in_water, sizeof out[17]);
    out[14] = (struct pel_vec4){ (float)image->middle_m, d->taper[0],
                                 d->taper[1], d->taper[2] };
    const float *paint = o->pool.models[d->model].paint;
    out[15] = (struct pel_vec4){ fade_of(env, 0), fade_of(env, 1),
                                 fade_of(env, 2), (float)object->model->low.z };
    out[16] = (struct pel_vec4){ paint[0], paint[1], paint[2],
                                 (float)pel_object_mirrored_below(env) };
    double m0 = env->sea->m0, off = object->altitude_m - env->sea_level_m;
    bool swims = fabs(off) < 1 + 4 * sqrt(m0);
    double wet = pel_wet_deviation(m0, object->model->length_m);
    out[18] = (struct pel_vec4){ swims ? (float)wet : -1.0f, 0, 0, 0 };
}

static void bind_places(struct pel_objects *o,
                        const struct pel_environment *env,
                        const struct pel_camera *c, struct pel_arena *arena)
{
    static _Thread_local struct pel_vec4
        texels[MOST_SLOTS * PEL_OBJECT_PLACE_TEXELS];
    size_t size = (size_t)(PEL_OBJECT_SHADOWS + o->drawn_count) *
                  PEL_OBJECT_PLACE_TEXELS * sizeof *texels;
    memset(texels, 0, size);
    for (int i = 0; i < o->drawn_count; i++) {
        const struct pel_object_drawn *d = &o->drawn[i];
        place(o, env, c, d, &texels[d->slot * PEL_OBJECT_PLACE_TEXELS]);
    }
    memcpy(o->near, texels, sizeof o->near);
    pel_arena_texels(arena, o->places, PEL_UNIT_OBJECT_PLACES, texels, size);
}

/* Where the window of the rasteriser begins on the lattice: the same for all
 * pictures of a lattice that is not very wide. */
#define WINDOW_HALF 8192
static double window_from(double first, double size)
{
    double middle = first + 0.5 * size, step = WINDOW_HALF / 2.0;
    bool near = fabs(first) < WINDOW_HALF && fabs(first + size) < WINDOW_HALF;
    return (near ? 0.0 : step * round(middle / step)) - WINDOW_HALF;
}

static void open_window(const struct pel_block_view *view)
{
    double x = window_from((double)view->pixel.z, (double)view->size.x);
    double y = window_from((double)view->pixel.w, (double)view->size.y);
    glUniform3f(1, (float)x, (float)y, 1.0f / WINDOW_HALF);
    glViewportIndexedf(0, (float)x - view->pixel.z, (float)y - view->pixel.w,
                       2.0f * WINDOW_HALF, 2.0f * WINDOW_HALF);
}

/* Leaves out the backs of triangles of one side; `front`: how their fronts turn
 * in the window. */
static void draw_fronts(const struct pel_objects *o, int i, GLenum front)
{
    glFrontFace(front);
    if (o->pool.models[o->drawn[i].model].one_sided) {
        glEnable(GL_CULL_FACE);
    } else {
        glDisable(GL_CULL_FACE);
    }
}

static void draw_level(const struct pel_objects *o, int i, int level)
{
    const struct pel_object_drawn *d = &o->drawn[i];
    const struct pel_pool_model *p = &o->pool.models[d->model];
    glUniform2i(0, d->slot, (GLint)p->first_triangle[level]);
    glDrawArrays(GL_TRIANGLES, 0,
                 3 * (GLsizei)p->model->levels[level].triangles);
}

/* With backs: what is under the sea is cut off, so that one looks in. */
static void draw_image(const void *user, int i)
{
    const struct pel_objects *o = user;
    draw_level(o, i, o->drawn[i].mirror_level);
}

static void draw_shadows(struct pel_objects *o)
{
    static const GLfloat far_away = 1.0f;
    glDepthFunc(GL_LESS);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.0f, 0.0f);
    for (int i = 0; i < o->drawn_count; i++) {
        const struct pel_object_drawn *d = &o->drawn[i];
        if (d->slot >= PEL_OBJECT_SHADOWS) {
            continue;
        }
        GLuint fbo = o->shadow_fbos[d->slot];
        /* And what filters read beyond. */
        glScissor(0, 0, d->shadow_px + 4, d->shadow_px + 4);
        glViewport(0, 0, PEL_SHADOW_SIZE, PEL_SHADOW_SIZE);
        glClearNamedFramebufferfv(fbo, GL_DEPTH, 0, &far_away);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, fbo);
        pel_program_use(o->shadow_program[o->pool.models[d->model].holed]);
        draw_fronts(o, i, GL_CCW);
        draw_level(o, i, d->shadow_level);
    }
    glDisable(GL_CULL_FACE);
    glDisable(GL_POLYGON_OFFSET_FILL);
    glBindTextureUnit(PEL_UNIT_OBJECT_SHADOWS, o->shadows);
}

static void draw_mirrored(struct pel_objects *o)
{
    int count = 0;
    for (int i = 0; i < o->drawn_count; i++) {
        if (o->drawn[i].mirrored) {
            if (count++ == 0) {
                pel_mirrors_begin(&o->mirrors);
            }
            pel_mirrors_draw(
                &o->mirrors, o->drawn[i].slot, o->drawn[i].image.part,
                o->pool.models[o->drawn[i].model].holed, draw_image, o, i);
        }
    }
    if (count > 0) {
        pel_mirrors_end(&o->mirrors);
    }
    glBindTextureUnit(PEL_UNIT_MIRRORS, o->mirrors.radiance);
    glBindTextureUnit(PEL_UNIT_MIRROR_DEPTHS, o->mirrors.away);
}

/* What the middles of pixels show. */
static void draw_middles(struct pel_objects *o, GLsizei width, GLsizei height)
{
    static const GLfloat far_away = 0.0f;
    static const GLuint none[4] = { 0 };
    fit_targets(o, (uint32_t)width, (uint32_t)height);
    glDepthMask(GL_TRUE);
    glScissor(0, 0, width, height);
    glEnable(GL_SCISSOR_TEST);
    glClearNamedFramebufferfv(o->fbo, GL_DEPTH, 0, &far_away);
    glClearNamedFramebufferuiv(o->fbo, GL_COLOR, 0, none);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, o->fbo);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
}

static void draw_seen(struct pel_objects *o, const struct pel_block_view *view,
                      const GLuint programs[2])
{
    for (int h = 0; h < (o->pool.holed ? 2 : 1); h++) {
        pel_program_use(programs[h]);
        open_window(view);
        for (int i = 0; i < o->drawn_count; i++) {
            const struct pel_object_drawn *d = &o->drawn[i];
            if (d->seen && o->pool.models[d->model].holed == h) {
                draw_fronts(o, i, GL_CW);
                draw_level(o, i, d->level);
            }
        }
    }
    glDisable(GL_CULL_FACE);
}

void pel_objects_draw(const struct pel_objects *o,
                      const struct pel_block_view *view, GLuint program)
{
    pel_program_use(program);
    open_window(view);
    for (int i = 0; i < o->drawn_count; i++) {
        if (o->drawn[i].seen) {
            draw_level(o, i, o->drawn[i].level);
        }
    }
}

void pel_objects_raster(struct pel_objects *o,
                        const struct pel_environment *env,
                        const struct pel_camera *camera,
                        const struct pel_block_view *view, const GLint box[4],
                        struct pel_arena *arena, bool keys, bool middles)
{
    GLsizei width = (GLsizei)view->size.x, height = (GLsizei)view->size.y;
    bind_places(o, env, camera, arena);
    pel_model_pool_bind(&o->pool);
    if (middles) {
        draw_middles(o, width, height);
        draw_seen(o, view, keys ? o->raster_keys : o->raster);
    }
    pel_samples_begin(&o->samples, width, height, box);
    draw_seen(o, view, o->samples.raster);
    pel_samples_sight(&o->samples, box);
    glEnable(GL_SCISSOR_TEST);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    draw_shadows(o);
    draw_mirrored(o);
    glBindTextureUnit(PEL_UNIT_OBJECTS, o->seen);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
}
