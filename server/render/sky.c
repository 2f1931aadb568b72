#include "render/sky.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "optics/airkept.h"
#include "optics/airlight.h"
#include "optics/atmosphere.h"
#include "render/programs.h"
#include "render/shader.h"
#include "render/uniforms.h"
#include "render/worker_pool.h"
#include "shaders/lib/blocks.h"

#define TABLE_WIDTH 96
#define TABLE_HEIGHT 128

static void set_sampling(GLuint texture, GLint reduced)
{
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, reduced);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

static GLuint make_texture(GLsizei width, GLsizei height, GLsizei levels,
                           const char *label)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, levels, GL_RGBA32F, width, height);
    set_sampling(texture, levels > 1 ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

static GLuint make_fbo(GLuint texture)
{
    GLuint fbo = 0;
    glCreateFramebuffers(1, &fbo);
    glNamedFramebufferTexture(fbo, GL_COLOR_ATTACHMENT0, texture, 0);
    return fbo;
}

static GLuint make_airlight(void)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_3D, 1, &texture);
    glTextureStorage3D(texture, 1, GL_RGBA32F, PEL_AIR_AZIMUTHS,
                       PEL_AIR_ZENITHS * PEL_AIR_HEIGHTS, PEL_AIR_SUNS);
    set_sampling(texture, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, texture, -1, "airlight");
    return texture;
}

static void make_table(struct pel_sky_table *t)
{
    static const GLenum both[] = { GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1 };
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &t->radiance);
    glTextureStorage3D(t->radiance, 1, GL_RGBA32F, TABLE_WIDTH, TABLE_HEIGHT,
                       PEL_LIGHTS);
    set_sampling(t->radiance, GL_LINEAR);
    glObjectLabel(GL_TEXTURE, t->radiance, -1, "sky radiance");
    t->haze = make_texture(TABLE_WIDTH, TABLE_HEIGHT, 1, "haze");
    glCreateFramebuffers(PEL_LIGHTS, t->fbos);
    for (int i = 0; i < PEL_LIGHTS; i++) {
        glNamedFramebufferTextureLayer(t->fbos[i], GL_COLOR_ATTACHMENT0,
                                       t->radiance, 0, i);
        glNamedFramebufferTexture(t->fbos[i], GL_COLOR_ATTACHMENT1, t->haze, 0);
        glNamedFramebufferDrawBuffers(t->fbos[i], 2, both);
    }
}

static enum pel_err make_pool(struct pel_sky *sky, struct pel_fault *fault)
{
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    int threads = cores < 1                     ? 1
                  : cores > PEL_WORKER_POOL_MAX ? PEL_WORKER_POOL_MAX
                                                : (int)cores;
    enum pel_err err = pel_worker_pool_create(threads, &sky->pool);
    return err ? pel_fault_set(fault, err, "no memory for threads") : err;
}

static void finish_table(struct pel_sky_table *t)
{
    glDeleteTextures(1, &t->radiance);
    glDeleteTextures(1, &t->haze);
    glDeleteFramebuffers(PEL_LIGHTS, t->fbos);
}

enum pel_sky_look pel_sky_look(const struct pel_environment *env)
{
    return env->panorama   ? PEL_SKY_PANORAMA
           : env->night.on ? PEL_SKY_NIGHT
                           : PEL_SKY_DAY;
}

enum pel_err pel_sky_need(struct pel_sky *sky,
                          const struct pel_environment *env,
                          const char *shader_dir, struct pel_fault *fault)
{
    const int at = pel_light_program(env);
    const enum pel_sky_look look = pel_sky_look(env);
    const char *lights = env->lit > 1 ? "#define PEL_LIT 2\n" : "";
    const char *clouded = pel_light_program_defines(env);
    char dark[64], both[32 + PEL_LIGHT_TEXT];
    snprintf(dark, sizeof dark, "%s%s", lights, pel_sky_look_defines(look));
    snprintf(both, sizeof both, "%s%s", clouded, pel_sky_look_defines(look));
    const struct {
        GLuint *program;
        const char *first, *second, *defines;
        bool wanted;
    } programs[] = {
        { &sky->table_program[look], "screen.vert", "sky.frag", dark, true },
        { &sky->reflection_program[look][at], "screen.vert", "reflection.frag",
          both, true },
        { &sky->second_program[at], "screen.vert", "second.frag", clouded,
          true },
        { &sky->light_program[at], "light.comp", NULL,
          env->fog_count ? clouded : lights, true },
        { &sky->veiled_program[at], "light_clouds.comp", NULL, clouded,
          pel_light_veiled(env) },
    };
    enum pel_err err = PEL_OK;
    for (size_t i = 0; i < sizeof programs / sizeof *programs; i++) {
        if (err == PEL_OK && programs[i].wanted && !*programs[i].program) {
            err = pel_program_create(shader_dir, programs[i].first,
                                     programs[i].second, programs[i].defines,
                                     programs[i].program, fault);
        }
    }
    return err;
}

enum pel_err pel_sky_init(struct pel_sky *sky, const char *shader_dir,
                          struct pel_fault *fault)
{
    *sky = (struct pel_sky){ 0 };
    const struct {
        GLuint *program;
        const char *first, *second;
    } programs[] = {
        { &sky->transmittance_program, "screen.vert", "transmittance.frag" },
    };
    for (size_t i = 0; i < sizeof programs / sizeof *programs; i++) {
        enum pel_err err = pel_program_create(shader_dir, programs[i].first,
                                              programs[i].second, NULL,
                                              programs[i].program, fault);
        if (err != PEL_OK) {
            return err;
        }
    }
    const struct pel_environment plain = { .lit = 1 };
    enum pel_err err = pel_sky_need(sky, &plain, shader_dir, fault);
    if (err != PEL_OK) {
        return err;
    }
    sky->transmittance = make_texture(
        PEL_TRANSMITTANCE_WIDTH, PEL_TRANSMITTANCE_HEIGHT, 1, "transmittance");
    sky->transmittance_fbo = make_fbo(sky->transmittance);
    sky->airlight = make_airlight();
    err = make_pool(sky, fault);
    if (err != PEL_OK) {
        return err;
    }
    make_table(&sky->sea);
    err = pel_water_light_init(&sky->water, shader_dir, fault);
    if (err != PEL_OK) {
        return err;
    }
    sky->reflection =
        make_texture(PEL_SKY_MAP_SIZE, PEL_SKY_MAP_SIZE, 7, "reflection map");
    sky->reflection_fbo = make_fbo(sky->reflection);
    sky->second =
        make_texture(PEL_SECOND_SIZE, PEL_SECOND_SIZE, 1, "second reflections");
    sky->second_fbo = make_fbo(sky->second);
    glCreateBuffers(1, &sky->light);
    glNamedBufferStorage(sky->light, sizeof(struct pel_block_light), NULL, 0);
    glObjectLabel(GL_BUFFER, sky->light, -1, "light");
    return PEL_OK;
}

void pel_sky_finish(struct pel_sky *sky)
{
    pel_program_delete(sky->transmittance_program);
    for (int i = 0; i < PEL_LIGHT_PROGRAMS; i++) {
        for (int look = 0; look < PEL_SKY_LOOKS; look++) {
            pel_program_delete(sky->reflection_program[look][i]);
        }
        pel_program_delete(sky->second_program[i]);
        pel_program_delete(sky->light_program[i]);
        pel_program_delete(sky->veiled_program[i]);
    }
    const GLuint textures[] = { sky->transmittance, sky->airlight,
                                sky->reflection, sky->second };
    glDeleteTextures(4, textures);
    const GLuint fbos[] = { sky->transmittance_fbo, sky->reflection_fbo,
                            sky->second_fbo };
    glDeleteFramebuffers(3, fbos);
    finish_table(&sky->sea);
    for (int i = 0; i < PEL_SKY_EYES; i++) {
        finish_table(&sky->eyes[i]);
    }
    for (int i = 0; i < PEL_SKY_LOOKS; i++) {
        pel_program_delete(sky->table_program[i]);
    }
    pel_panorama_map_finish(&sky->panorama);
    pel_night_textures_finish(&sky->night);
    pel_water_light_finish(&sky->water);
    pel_worker_pool_destroy(sky->pool);
    glDeleteBuffers(1, &sky->light);
    *sky = (struct pel_sky){ 0 };
}

struct pel_vec3 pel_sky_quantize(struct pel_vec3 to)
{
    const double step = 0.005 * PEL_DEG;
    double elevation = step * round(asin(pel_clamp(to.z, -1.0, 1.0)) / step);
    double azimuth = step * round(atan2(to.y, to.x) / step);
    return (struct pel_vec3){ cos(elevation) * cos(azimuth),
                              cos(elevation) * sin(azimuth), sin(elevation) };
}

double pel_sky_quantize_height(double height_m)
{
    /* Above the atmosphere its top is as good: there is no light in between. */
    double top_m = PEL_ATMOSPHERE_RADIUS - PEL_EARTH_RADIUS;
    double octave = log2(fmax(height_m, 0.5));
    /* A ship's heave is to find its tables again; what is seen from high up
     * lies in the air and would jump (climb_test). */
    double steps = octave < 6.0 ? 16.0 : octave < 8.0 ? 64.0 : 256.0;
    return fmin(exp2(round(octave * steps) / steps), top_m);
}

static void draw_screen(GLuint program, GLuint fbo, GLsizei width,
                        GLsizei height)
{
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, fbo);
    glViewport(0, 0, width, height);
    pel_program_use(program);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static void share_air(void *pool, int count,
                      void (*work)(void *user, int member, int i), void *user)
{
    pel_worker_pool_run(pool, count, work, user);
}

/* On the processor: in the frame that first shows this air, as the water's
 * kernel is, so that a picture is a function of its scene. */
static void update_airlight(struct pel_sky *sky, double visibility_m)
{
    const struct pel_atmosphere *air = NULL;
    if (pel_air_take(visibility_m, share_air, sky->pool, &air)) {
        return; /* the air of before stays */
    }
    glTextureSubImage3D(sky->airlight, 0, 0, 0, 0, PEL_AIR_AZIMUTHS,
                        PEL_AIR_ZENITHS * PEL_AIR_HEIGHTS, PEL_AIR_SUNS,
                        GL_RGBA, GL_FLOAT, air->airlight->log2);
    pel_air_give(air);
}

static void update_air(struct pel_sky *sky, double visibility_m)
{
    if (sky->air_made && sky->air_key == visibility_m) {
        return;
    }
    draw_screen(sky->transmittance_program, sky->transmittance_fbo,
                PEL_TRANSMITTANCE_WIDTH, PEL_TRANSMITTANCE_HEIGHT);
    update_airlight(sky, visibility_m);
    sky->air_key = visibility_m;
    sky->air_made = true;
}

static void draw_table(struct pel_sky *sky, struct pel_sky_table *t,
                       const struct pel_environment *env)
{
    GLuint program = sky->table_program[pel_sky_look(env)];
    pel_program_use(program);
    glBindTextureUnit(PEL_UNIT_TRANSMITTANCE, sky->transmittance);
    glBindTextureUnit(PEL_UNIT_AIRLIGHT, sky->airlight);
    if (env->night.on) {
        const struct pel_rgb *air = &sky->night.air;
        glBindTextureUnit(PEL_UNIT_NIGHT, sky->night.zonal);
        glUniform3f(2, (GLfloat)air->r, (GLfloat)air->g, (GLfloat)air->b);
    }
    if (env->panorama) {
        glBindTextureUnit(PEL_UNIT_PANORAMA, sky->panorama.texture);
    }
    glUniform2f(0, TABLE_WIDTH, TABLE_HEIGHT);
    for (int i = 0; i < env->lit; i++) {
        glUniform1i(1, i);
        draw_screen(program, t->fbos[i], TABLE_WIDTH, TABLE_HEIGHT);
    }
}

static void table_key(const struct pel_environment *env, double height_m,
                      double key[PEL_SKY_KEYS])
{
    /* A table is counted from its light's azimuth, but its last bits are not.
     */
    static const struct pel_light none;
    for (int i = 0; i < PEL_LIGHTS; i++) {
        const struct pel_light *light = i < env->lit ? &env->lights[i] : &none;
        *key++ = light->direction.x;
        *key++ = light->direction.y;
        *key++ = light->direction.z;
        *key++ = light->strength;
        *key++ = light->radius_rad;
        *key++ = i < env->lit ? light->body : -1;
    }
    pel_night_key(env, key);
    key += PEL_NIGHT_KEYS;
    pel_panorama_key(env, key);
    key += PEL_PANORAMA_KEYS;
    *key++ = env->visibility_m;
    *key = height_m;
}

static void cloud_key(const struct pel_environment *env,
                      double key[PEL_SKY_CLOUD_KEYS])
{
    const struct pel_clouds *c = &env->clouds;
    const double all[PEL_SKY_CLOUD_KEYS] = {
        c->cover,        c->genus,        c->base_m,
        c->thickness_m,  c->seed,         atan2(c->north_mps, c->east_mps),
        env->clouds_x_m, env->clouds_y_m,
    };
    for (int i = 0; i < PEL_SKY_CLOUD_KEYS; i++) {
        key[i] = c->cover > 0 ? all[i] : 0;
    }
}

static void fog_key(const struct pel_environment *env,
                    double key[PEL_SKY_FOG_KEYS])
{
    struct pel_block_eye eye = { .fog_layers = { .x = 0 } };
    pel_fill_fog_own(env, &eye);
    *key++ = env->fog_count;
    for (int i = 0; i < PEL_FOGS; i++, key += 8) {
        const struct pel_shader_fog *f = &eye.fogs[i];
        const float all[8] = { f->shape.x, f->shape.y, f->shape.z, f->shape.w,
                               f->place.x, f->place.y, f->place.z, 0 };
        for (int k = 0; k < 8; k++) {
            key[k] = (double)all[k];
        }
    }
}

/* What clouds and fog leave of the light on the sea, by the map that it
 * mirrors. */
static void veiled_light(struct pel_sky *sky, int at)
{
    glBindTextureUnit(PEL_UNIT_REFLECTION, sky->reflection);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_LIGHT, sky->light);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT |
                    GL_SHADER_STORAGE_BARRIER_BIT);
    pel_program_use(sky->veiled_program[at]);
    glDispatchCompute(1, 1, 1);
    glMemoryBarrier(GL_UNIFORM_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

void pel_sky_update(struct pel_sky *sky, const struct pel_environment *env,
                    void (*bind_eye)(void *user, double height_m), void *user)
{
    update_air(sky, env->visibility_m);
    if (env->night.on) {
        pel_night_textures_fit(&sky->night, env);
    }
    if (env->panorama) {
        pel_panorama_map_fit(&sky->panorama, env);
    }
    double key[PEL_SKY_KEYS];
    table_key(env, PEL_SKY_SEA_HEIGHT, key);
    bool fresh = !sky->sea.made || memcmp(key, sky->sea.key, sizeof key) != 0;
    if (fresh) {
        bind_eye(user, PEL_SKY_SEA_HEIGHT);
        draw_table(sky, &sky->sea, env);
        memcpy(sky->sea.key, key, sizeof key);
        sky->sea.made = true;
    }
    double light_key[PEL_SKY_LIGHT_KEYS];
    memcpy(light_key, key, sizeof key);
    light_key[PEL_SKY_KEYS] = (double)sky->water.version;
    light_key[PEL_SKY_KEYS + 1] = env->sea->slope_variance_along;
    light_key[PEL_SKY_KEYS + 2] = env->sea->slope_variance_cross;
    light_key[PEL_SKY_KEYS + 3] = env->wind_to_rad;
    light_key[PEL_SKY_KEYS + 4] = env->water.index[1];
    cloud_key(env, light_key + PEL_SKY_KEYS + 5);
    fog_key(env, light_key + PEL_SKY_KEYS + 5 + PEL_SKY_CLOUD_KEYS);
    const int at = pel_light_program(env);
    if (!sky->light_made ||
        memcmp(light_key, sky->light_key, sizeof light_key)) {
        glBindTextureUnit(PEL_UNIT_TRANSMITTANCE, sky->transmittance);
        glBindTextureUnit(PEL_UNIT_SKY_TABLE, sky->sea.radiance);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_LIGHT, sky->light);
        pel_program_use(sky->light_program[at]);
        glDispatchCompute(1, 1, 1);
        glMemoryBarrier(GL_UNIFORM_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                        GL_TEXTURE_FETCH_BARRIER_BIT);
        glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_LIGHT, sky->light);
        const struct pel_water_waves waves = { env->sea->slope_variance_along,
                                               env->sea->slope_variance_cross,
                                               env->wind_to_rad };
        pel_water_light_map(&sky->water, env->lights, env->lit, &waves,
                            sky->sea.radiance, sky->light);
        if (env->night.on) {
            glBindTextureUnit(PEL_UNIT_NIGHT, sky->night.off);
        }
        if (env->panorama) {
            glBindTextureUnit(PEL_UNIT_PANORAMA, sky->panorama.texture);
        }
        const GLuint reflect = sky->reflection_program[pel_sky_look(env)][at];
        pel_program_use(reflect);
        glUniform2f(0, PEL_SKY_MAP_SIZE, (float)PEL_REFLECTION_HALF_WIDTH);
        if (pel_light_veiled(env)) {
            bind_eye(user, PEL_SKY_SEA_HEIGHT);
            glBindTextureUnit(PEL_UNIT_TRANSMITTANCE, sky->transmittance);
            glBindTextureUnit(PEL_UNIT_SKY_TABLE, sky->sea.radiance);
        }
        draw_screen(reflect, sky->reflection_fbo, PEL_SKY_MAP_SIZE,
                    PEL_SKY_MAP_SIZE);
        glGenerateTextureMipmap(sky->reflection);
        if (pel_light_veiled(env)) {
            veiled_light(sky, at);
        }
        draw_screen(sky->second_program[at], sky->second_fbo, PEL_SECOND_SIZE,
                    PEL_SECOND_SIZE);
        memcpy(sky->light_key, light_key, sizeof light_key);
        sky->light_made = true;
    }
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_LIGHT, sky->light);
}

void pel_sky_bind_eye(struct pel_sky *sky, const struct pel_environment *env,
                      double height_m)
{
    double key[PEL_SKY_KEYS];
    table_key(env, height_m, key);
    struct pel_sky_table *t = &sky->eyes[0];
    for (int i = 0; i < PEL_SKY_EYES; i++) {
        struct pel_sky_table *e = &sky->eyes[i];
        if (e->made && memcmp(key, e->key, sizeof key) == 0) {
            t = e;
            break;
        }
        if (e->last_used < t->last_used) {
            t = e;
        }
    }
    if (!t->made || memcmp(key, t->key, sizeof key) != 0) {
        if (!t->haze) {
            make_table(t);
        }
        draw_table(sky, t, env);
        memcpy(t->key, key, sizeof key);
        t->made = true;
    }
    t->last_used = ++sky->uses;
    glBindTextureUnit(PEL_UNIT_TRANSMITTANCE, sky->transmittance);
    glBindTextureUnit(PEL_UNIT_REFLECTION, sky->reflection);
    glBindTextureUnit(PEL_UNIT_SECOND, sky->second);
    glBindTextureUnit(PEL_UNIT_WATER, sky->water.map);
    glBindTextureUnit(PEL_UNIT_EYE_TABLE, t->radiance);
    glBindTextureUnit(PEL_UNIT_EYE_HAZE, t->haze);
}
