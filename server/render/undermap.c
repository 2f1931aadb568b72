#include "render/undermap.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/vec.h"
#include "render/lampglow.h"
#include "render/pass.h"
#include "render/seabedmap.h"
#include "render/shader.h"
#include "render/uniforms.h"

#define ROWS (2 * PEL_UNDER_ROWS + 2)
#define BLUR_RAD 0.01 /* of the line on the dome */
/* Of a beam that goes through the surface: how much its direction in the water
 * turns with a facet's slope. */
#define TURNED (1.0 - 1.0 / PEL_WATER_INDEX)
/* Water whose bottom is not level is taken as level ones of these depths. */
#define DEPTHS_AN_OCTAVE 3.0
#define FACETS 8 /* that light goes through or is mirrored by */
#define REST_NS 10000000000LL
#define FOCUS_LEAST 0.02 /* sine of the light's elevation */

/* --- where the eye is ----------------------------------------------------- */

struct pel_lens_place pel_lens_place(const struct pel_environment *env,
                                     const struct pel_camera *c)
{
    struct pel_lens_place p = { .state = PEL_LENS_HIGH };
    double crests = fmin(env->sea->max_height_m, 6.0 * sqrt(env->sea->m0));
    if (c->altitude_m > crests + 2.0 * PEL_UNDER_DOME) {
        return p;
    }
    struct pel_surface_sample above;
    pel_sea_sample(env->sea, c->east_m, c->north_m, env->time_s, &above);
    double up = fmax(above.normal.z, 0.1);
    p.above_m = above.height_m - c->altitude_m;
    p.slope = (struct pel_vec2){ -above.normal.x / up, -above.normal.y / up };
    double reach = PEL_UNDER_DOME *
                   (sqrt(1.0 + p.slope.x * p.slope.x + p.slope.y * p.slope.y) +
                    4.0 * BLUR_RAD);
    p.state = p.above_m > reach    ? PEL_LENS_WET
              : p.above_m > -reach ? PEL_LENS_CROSSED
                                   : PEL_LENS_DRY;
    return p;
}

/* --- programs ------------------------------------------------------------- */

static GLuint *place_of(struct pel_under_map *map, const char *defines)
{
    for (int i = 0; i < map->program_count; i++) {
        if (strcmp(map->programs[i].defines, defines) == 0) {
            return &map->programs[i].program;
        }
    }
    return NULL;
}

static enum pel_err need(struct pel_under_map *map, const char *shader_dir,
                         const char *first, const char *second,
                         const char *defines, struct pel_fault *fault)
{
    if (place_of(map, defines)) {
        return PEL_OK;
    }
    GLuint program = 0;
    enum pel_err err =
        pel_program_create(shader_dir, first, second, defines, &program, fault);
    if (err != PEL_OK) {
        return err;
    }
    /* The oldest makes room: it is made again if it is wanted again. */
    if (map->program_count == PEL_UNDER_PROGRAMS) {
        pel_program_delete(map->programs[0].program);
        memmove(map->programs, map->programs + 1,
                sizeof *map->programs * (PEL_UNDER_PROGRAMS - 1));
        map->program_count--;
    }
    struct pel_under_program *to = &map->programs[map->program_count++];
    snprintf(to->defines, sizeof to->defines, "%s", defines);
    to->program = program;
    return PEL_OK;
}

enum part { SHAFTS, FIND, SURFACE, LAMPS, SCENE, HULLS, ABOVE, PARTS };

static void defines_of(const struct pel_environment *env,
                       const struct pel_programs *p, enum part part,
                       enum pel_shading kind, char out[512])
{
    static const char *const of[] = {
        [SHAFTS] = "#define PEL_SHAFT\n",
        [FIND] = "#define PEL_FIND\n",
        [SURFACE] = "#define PEL_OF_SURFACE\n",
        [LAMPS] = "#define PEL_OF_LAMPS\n",
        [SCENE] = "",
        [HULLS] = "#define PEL_OBJECTS\n",
        [ABOVE] = "#define PEL_ABOVE\n",
    };
    const bool shades = part >= SCENE;
    char surface[PEL_SURFACE_TEXT];
    pel_programs_surface(p, env->sea, surface);
    snprintf(out, 512, "%s%s%s%s%s%s%s%s%s", surface, of[part],
             shades ? pel_cameras_define(p->light) : "",
             part >= LAMPS && pel_lamp_glow_any_below(env)
                 ? "#define PEL_LAMPS_BELOW\n"
                 : "",
             part >= SURFACE ? pel_programs_foam(env->sea) : "",
             shades ? pel_shading_defines(kind) : "",
             part >= SURFACE ? pel_light_program_defines(env) : "",
             env->seabed && part != SHAFTS ? "#define PEL_SEABED\n" : "",
             part >= HULLS && p->textured ? "#define PEL_TEXTURED\n" : "");
}

enum pel_err pel_under_map_need(struct pel_under_map *map,
                                const struct pel_environment *env,
                                const struct pel_programs *p,
                                enum pel_shading kind, struct pel_fault *fault)
{
    char defines[512];
    enum pel_err err = PEL_OK;
    if (!map->map_program) {
        err = pel_program_create(p->shader_dir, "under_map.comp", NULL, NULL,
                                 &map->map_program, fault);
    }
    if (err == PEL_OK && env->object_count && !map->above_program) {
        err = pel_program_create(p->shader_dir, "under_above.vert",
                                 "under_above.frag", NULL, &map->above_program,
                                 fault);
    }
    static const char *const files[PARTS] = { "under_shafts.comp",
                                              "under_find.frag",
                                              "under_surface.frag",
                                              "under_lamps.frag" };
    const bool wanted[PARTS] = { true,
                                 true,
                                 true,
                                 pel_lamp_glow_any_below(env),
                                 true,
                                 env->object_count > 0,
                                 env->object_count > 0 };
    for (int i = 0; i < PARTS && err == PEL_OK; i++) {
        const char *file = files[i] ? files[i] : "under.frag";
        defines_of(env, p, (enum part)i, i == ABOVE ? PEL_SHADE_LIGHT : kind,
                   defines);
        if (wanted[i]) {
            err = need(map, p->shader_dir, i == SHAFTS ? file : "screen.vert",
                       i == SHAFTS ? NULL : file, defines, fault);
        }
    }
    return err;
}

static void finish_found(struct pel_under_map *map)
{
    const GLuint textures[] = { map->found, map->normal,     map->foam,
                                map->back,  map->lamps,      map->lamps_on,
                                map->above, map->above_depth };
    const GLuint fbos[] = { map->found_fbo, map->surface_fbo, map->lamps_fbo,
                            map->above_fbo };
    glDeleteTextures(8, textures);
    glDeleteFramebuffers(4, fbos);
    map->back = map->lamps = map->lamps_on = map->lamps_fbo = 0;
    map->above = map->above_depth = map->above_fbo = 0;
}

static void finish_light(struct pel_under_map *map)
{
    glDeleteTextures(1, &map->map);
    glDeleteTextures(1, &map->shafts);
    glDeleteBuffers(2, map->kernels);
}

void pel_under_map_rest(struct pel_under_map *map)
{
    if (!map->map || pel_now_ns() - map->used_ns < REST_NS) {
        return;
    }
    finish_light(map);
    finish_found(map);
    map->map = map->shafts = 0;
    map->width = map->height = 0;
    map->made = false; /* with it the kernels and all that lies in the map */
}

void pel_under_map_finish(struct pel_under_map *map)
{
    for (int i = 0; i < map->program_count; i++) {
        pel_program_delete(map->programs[i].program);
    }
    pel_program_delete(map->map_program);
    pel_program_delete(map->above_program);
    finish_light(map);
    finish_found(map);
    memset(map, 0, sizeof *map);
}

/* --- the water's light ---------------------------------------------------- */

static GLuint make_array(GLsizei levels, GLenum format, GLsizei width,
                         GLsizei height, GLsizei layers, const char *label)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &texture);
    glTextureStorage3D(texture, levels, format, width, height, layers);
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER,
                        levels > 1 ? GL_LINEAR_MIPMAP_NEAREST : GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

static void make(struct pel_under_map *map)
{
    map->map = make_array(1, GL_RGBA32F, PEL_UNDER_COLUMNS, ROWS,
                          PEL_LIGHTS * PEL_UNDER_LEVELS, "light under water");
    map->shafts = make_array(PEL_SHAFT_MEAN + 1, GL_RGBA16F, PEL_SHAFT_PLACES,
                             PEL_SHAFT_PLACES, PEL_SHAFT_DEPTHS, "shafts");
    glClearTexImage(map->shafts, 0, GL_RGBA, GL_FLOAT, NULL);
    glCreateBuffers(2, map->kernels);
    for (int i = 0; i < 2; i++) {
        glNamedBufferStorage(map->kernels[i], sizeof(struct pel_under_kernel),
                             NULL, GL_DYNAMIC_STORAGE_BIT);
        glObjectLabel(GL_BUFFER, map->kernels[i], -1, "light under water");
    }
}

/* Depths of level water that the water about a place is taken as, and the share
 * of the second. */
static void columns_at(const struct pel_environment *env,
                       const struct pel_camera *c, double depth_m[2],
                       double *share)
{
    depth_m[0] = depth_m[1] = env->water.depth_m;
    *share = 0.0;
    if (env->seabed) {
        double outside = -env->water.depth_m - env->sea_level_m;
        double deep = env->sea_level_m -
                      pel_seabed_drawn(env->seabed, c->east_m, c->north_m,
                                       outside + env->sea_level_m);
        deep = pel_clamp(deep, 0.5, PEL_DEPTH_MAX);
        double octaves = DEPTHS_AN_OCTAVE * log2(deep), whole = floor(octaves);
        depth_m[0] = exp2(whole / DEPTHS_AN_OCTAVE);
        depth_m[1] = exp2((whole + 1.0) / DEPTHS_AN_OCTAVE);
        *share = octaves - whole;
    }
}

/* The place of the kernel of a depth, -1: no memory. */
static int kernel_of(struct pel_under_map *map,
                     const struct pel_environment *env, double depth_m)
{
    int at = map->used[1] < map->used[0];
    for (int i = 0; i < 2; i++) {
        at = map->kernel_depth_m[i] == depth_m ? i : at;
    }
    map->used[at] = ++map->uses;
    if (map->kernel_depth_m[at] == depth_m) {
        return at;
    }
    struct pel_under_kernel *kernel = malloc(sizeof *kernel);
    if (!kernel || pel_under_kernel_build(&env->water, &map->medium, depth_m,
                                          kernel) != PEL_OK) {
        free(kernel);
        return -1;
    }
    glNamedBufferSubData(map->kernels[at], 0, sizeof *kernel, kernel);
    free(kernel);
    map->kernel_depth_m[at] = depth_m;
    map->version++;
    return at;
}

static bool fit_medium(struct pel_under_map *map,
                       const struct pel_environment *env)
{
    double deepest = env->water.depth_m;
    if (env->seabed) {
        deepest = fmax(deepest, env->sea_level_m - env->seabed->lowest_m);
    }
    if (map->made && map->deepest_m == deepest &&
        memcmp(&map->body, &env->water,
               offsetof(struct pel_water_body, land)) == 0) {
        return true;
    }
    if (!map->map) {
        make(map);
    }
    map->kernel_depth_m[0] = map->kernel_depth_m[1] = 0.0;
    map->made =
        pel_under_medium_make(&env->water, deepest, &map->medium) == PEL_OK;
    map->body = env->water;
    map->deepest_m = deepest;
    return map->made;
}

static void fill_map(struct pel_under_map *map,
                     const struct pel_environment *env, struct pel_sky *sky,
                     const int kernel[2], double share)
{
    double key[PEL_SKY_LIGHT_KEYS + 4];
    memcpy(key, sky->light_key, sizeof sky->light_key);
    key[PEL_SKY_LIGHT_KEYS] = (double)map->version;
    key[PEL_SKY_LIGHT_KEYS + 1] = kernel[0];
    key[PEL_SKY_LIGHT_KEYS + 2] = kernel[1];
    key[PEL_SKY_LIGHT_KEYS + 3] = share;
    if (memcmp(key, map->light_key, sizeof key) == 0) {
        return;
    }
    memcpy(map->light_key, key, sizeof key);
    const struct pel_water_waves waves = { env->sea->slope_variance_along,
                                           env->sea->slope_variance_cross,
                                           env->wind_to_rad };
    for (int i = 0; i < env->lit; i++) {
        pel_water_light_enter(&sky->water, env->lights, i, &waves,
                              sky->sea.radiance);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_WATER_KERNEL,
                         map->kernels[kernel[0]]);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_UNDER_NEXT,
                         map->kernels[kernel[1]]);
        glBindImageTexture(PEL_IMAGE_UNDER, map->map, 0, GL_TRUE, 0,
                           GL_WRITE_ONLY, GL_RGBA32F);
        pel_program_use(map->map_program);
        glUniform1i(0, i);
        glUniform1f(1, (float)share);
        glDispatchCompute(ROWS, PEL_UNDER_LEVELS, 1);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT |
                        GL_SHADER_STORAGE_BARRIER_BIT |
                        GL_BUFFER_UPDATE_BARRIER_BIT);
    }
}

static struct pel_vec4 vec4(double x, double y, double z, double w)
{
    return (struct pel_vec4){ (float)x, (float)y, (float)z, (float)w };
}

static struct pel_vec4 rgb(const double v[PEL_WATER_WAVELENGTHS], double w)
{
    return vec4(v[0], v[1], v[2], w);
}

/* In the light that a level sea would let in: below the surface above the eye
 * near crests, below the mean sea deeper down. */
static double depth_in_light(const struct pel_environment *env,
                             const struct pel_camera *c,
                             const struct pel_lens_place *place)
{
    double depth = -c->altitude_m, raised = place->above_m - depth;
    double deviation = fmax(sqrt(env->sea->m0), 1e-3);
    double near = exp(-0.5 * fmax(depth, 0.0) / deviation);
    return fmax(depth + raised * near, 0.0);
}

static void fill_block(const struct pel_under_map *map,
                       const struct pel_environment *env,
                       const struct pel_sky *sky, const struct pel_camera *c,
                       const struct pel_lens_place *place,
                       struct pel_block_under *out)
{
    const struct pel_under_medium *m = &map->medium;
    double octaves = log2(1.0 + m->last_m / m->step_m);
    bool shafts = env->caustics && env->lights[0].direction.z > FOCUS_LEAST;
    *out = (struct pel_block_under){
        .under_eye = vec4(-c->altitude_m, place->above_m, place->slope.x,
                          place->slope.y),
        .under_lens = vec4(place->state == PEL_LENS_CROSSED, 0.0, 0.0, shafts),
        .under_scaled = rgb(m->scaled, 0.0),
        .under_full = rgb(m->full, 0.0),
        .under_scatter = rgb(env->water.scattering, 0.0),
        .under_fall = rgb(m->fall, 0.0),
        .under_levels = vec4(1.0 / m->step_m, (PEL_UNDER_LEVELS - 1) / octaves,
                             PEL_UNDER_LEVELS - 1, 0.0),
        .under_ground =
            rgb(env->water.albedo,
                env->water.depth_m + (env->seabed ? env->sea_level_m : 0.0)),
        .under_drift = vec4(depth_in_light(env, c, place), FACETS, 0.0,
                            m->peak_square / (TURNED * TURNED)),
    };
    float lamps[PEL_UNDER_LAMPS * PEL_GLOW_TEXELS][4] = { 0 };
    out->under_lens.y = (float)pel_lamp_glow_below(env, c, lamps);
    memcpy(out->under_lamps, lamps, sizeof out->under_lamps);
    for (int i = 0; i < env->lit; i++) {
        const struct pel_vec3 to = env->lights[i].direction;
        double x = to.x / PEL_WATER_INDEX, y = to.y / PEL_WATER_INDEX;
        double across = fmin(hypot(x, y), 1.0 / PEL_WATER_INDEX);
        out->under_beams[i] =
            vec4(x, y, sqrt(1.0 - across * across), sky->water.beams[i]);
    }
    memcpy(out->under_turns, m->turns, sizeof out->under_turns);
}

bool pel_under_map_bind(struct pel_under_map *map,
                        const struct pel_environment *env, struct pel_sky *sky,
                        const struct pel_camera *c,
                        const struct pel_lens_place *place,
                        struct pel_arena *arena)
{
    double depth_m[2], share;
    map->used_ns = pel_now_ns();
    columns_at(env, c, depth_m, &share);
    if (!fit_medium(map, env)) {
        return false;
    }
    int kernel[2];
    for (int i = 0; i < 2; i++) {
        kernel[i] = kernel_of(map, env, depth_m[i]);
        if (kernel[i] < 0) {
            return false;
        }
    }
    fill_map(map, env, sky, kernel, share);
    struct pel_block_under block;
    fill_block(map, env, sky, c, place, &block);
    pel_arena_bind(arena, GL_UNIFORM_BUFFER, PEL_BLOCK_UNDER, &block,
                   sizeof block);
    glBindTextureUnit(PEL_UNIT_UNDER, map->map);
    glBindTextureUnit(PEL_UNIT_SHAFTS, map->shafts);
    return true;
}

void pel_under_map_shafts(struct pel_under_map *map,
                          const struct pel_environment *env,
                          const struct pel_programs *p)
{
    char defines[512];
    if (!env->caustics || env->lights[0].direction.z <= FOCUS_LEAST) {
        return;
    }
    defines_of(env, p, SHAFTS, PEL_SHADE_LIGHT, defines);
    const GLuint *program = place_of(map, defines);
    glBindImageTexture(PEL_IMAGE_SHAFTS, map->shafts, 0, GL_TRUE, 0,
                       GL_WRITE_ONLY, GL_RGBA16F);
    pel_program_use(program ? *program : 0);
    glDispatchCompute(PEL_SHAFT_PLACES / PEL_GROUP_SIDE,
                      PEL_SHAFT_PLACES / PEL_GROUP_SIDE, PEL_SHAFT_DEPTHS);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT |
                    GL_TEXTURE_UPDATE_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
    glGenerateTextureMipmap(map->shafts);
}

double pel_under_map_least(const struct pel_under_map *map)
{
    const double *c = map->medium.scaled;
    return fmin(c[0], fmin(c[1], c[2]));
}

/* --- drawing -------------------------------------------------------------- */

static GLuint make_found(const struct pel_under_map *map, const char *label)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, GL_RGBA32F, (GLsizei)map->width,
                       (GLsizei)map->height);
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

static GLuint make_found_fbo(int count, const GLuint textures[])
{
    static const GLenum of[] = { GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1,
                                 GL_COLOR_ATTACHMENT2 };
    GLuint fbo = 0;
    glCreateFramebuffers(1, &fbo);
    for (int i = 0; i < count; i++) {
        glNamedFramebufferTexture(fbo, of[i], textures[i], 0);
    }
    glNamedFramebufferDrawBuffers(fbo, count, of);
    return fbo;
}

static void fit_found(struct pel_under_map *map, const struct pel_targets *t)
{
    if (map->width == t->width && map->height == t->height) {
        return;
    }
    finish_found(map);
    map->width = t->width;
    map->height = t->height;
    map->found = make_found(map, "met under water");
    map->normal = make_found(map, "surface from below");
    map->foam = make_found(map, "foam from below");
    map->found_fbo = make_found_fbo(1, &map->found);
    map->surface_fbo =
        make_found_fbo(2, (const GLuint[]){ map->normal, map->foam });
}

static void fit_back(struct pel_under_map *map)
{
    if (!map->back) {
        glDeleteFramebuffers(1, &map->surface_fbo);
        map->back = make_found(map, "light on foam from below");
        map->surface_fbo = make_found_fbo(
            3, (const GLuint[]){ map->normal, map->foam, map->back });
    }
}

static void fit_lamps(struct pel_under_map *map)
{
    if (!map->lamps) {
        map->lamps = make_found(map, "lamps in the water");
        map->lamps_on = make_found(map, "lamps on things in the water");
        map->lamps_fbo =
            make_found_fbo(2, (const GLuint[]){ map->lamps, map->lamps_on });
    }
}

static void fit_above(struct pel_under_map *map)
{
    if (map->above) {
        return;
    }
    glCreateTextures(GL_TEXTURE_2D, 1, &map->above);
    glTextureStorage2D(map->above, 1, GL_RG32UI, (GLsizei)map->width,
                       (GLsizei)map->height);
    glTextureParameteri(map->above, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(map->above, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glObjectLabel(GL_TEXTURE, map->above, -1, "objects above water");
    glCreateTextures(GL_TEXTURE_2D, 1, &map->above_depth);
    glTextureStorage2D(map->above_depth, 1, GL_DEPTH_COMPONENT32F,
                       (GLsizei)map->width, (GLsizei)map->height);
    glCreateFramebuffers(1, &map->above_fbo);
    glNamedFramebufferTexture(map->above_fbo, GL_COLOR_ATTACHMENT0, map->above,
                              0);
    glNamedFramebufferTexture(map->above_fbo, GL_DEPTH_ATTACHMENT,
                              map->above_depth, 0);
}

static void find_above(struct pel_under_map *map,
                       const struct pel_objects *objects,
                       const struct pel_block_view *view)
{
    static const GLfloat far_away = 0.0f;
    static const GLuint none[4] = { 0 };
    fit_above(map);
    glDepthMask(GL_TRUE);
    glClearNamedFramebufferfv(map->above_fbo, GL_DEPTH, 0, &far_away);
    glClearNamedFramebufferuiv(map->above_fbo, GL_COLOR, 0, none);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, map->above_fbo);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    pel_objects_draw(objects, view, map->above_program);
    glDisable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glViewport(0, 0, (GLsizei)view->size.x, (GLsizei)view->size.y);
    glBindTextureUnit(PEL_UNIT_UNDER_ABOVE, map->above);
}

static void use(struct pel_under_map *map, const struct pel_environment *env,
                const struct pel_programs *p, enum part part,
                enum pel_shading kind)
{
    char defines[512];
    defines_of(env, p, part, kind, defines);
    const GLuint *program = place_of(map, defines);
    pel_program_use(program ? *program : 0);
}

static void find(struct pel_under_map *map, const struct pel_environment *env,
                 const struct pel_programs *p, enum part part, GLuint fbo)
{
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, fbo);
    use(map, env, p, part, PEL_SHADE_LIGHT);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

/* Light is blended along the line on the lens and at silhouettes. */
static void draw_light(struct pel_under_map *map,
                       const struct pel_environment *env,
                       const struct pel_programs *p, enum part part,
                       struct pel_targets *targets)
{
    const struct pel_pass light = pel_pass_first(PEL_LAYER_RADIANCE, false);
    glEnable(GL_BLEND);
    /* What is above adds to the sky in the window. */
    glBlendFuncSeparate(GL_ONE, part == ABOVE ? GL_ONE : GL_ONE_MINUS_SRC_ALPHA,
                        GL_ZERO,
                        part == HULLS ? GL_ONE_MINUS_SRC_ALPHA : GL_ONE);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, pel_targets_attach(targets, &light));
    use(map, env, p, part, light.kind);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_BLEND);
}

/* What is no light is the nearer's. */
static void draw_layers(struct pel_under_map *map,
                        const struct pel_environment *env,
                        const struct pel_programs *p, enum part part,
                        struct pel_targets *targets, unsigned asked, bool first)
{
    struct pel_pass pass = pel_pass_first(asked, false);
    pass.first = first;
    do {
        if (pass.layers || pass.first) {
            glBindFramebuffer(GL_DRAW_FRAMEBUFFER,
                              pel_targets_attach(targets, &pass));
            use(map, env, p, part, pass.kind);
            pel_pass_use(&pass);
            glDrawArrays(GL_TRIANGLES, 0, 3);
        }
    } while (pel_pass_next(&pass, false));
}

void pel_under_map_draw(struct pel_under_map *map,
                        const struct pel_environment *env,
                        const struct pel_programs *p,
                        struct pel_targets *targets, unsigned asked,
                        bool crossed, const struct pel_objects *objects,
                        const struct pel_block_view *view)
{
    fit_found(map, targets);
    glBindTextureUnit(PEL_UNIT_TRIANGLES, targets->triangles);
    glDisable(GL_DEPTH_TEST);
    find(map, env, p, FIND, map->found_fbo);
    glBindTextureUnit(PEL_UNIT_UNDER_FOUND, map->found);
    if (env->sea->foam || p->wash) {
        fit_back(map);
    }
    find(map, env, p, SURFACE, map->surface_fbo);
    glBindTextureUnit(PEL_UNIT_UNDER_NORMAL, map->normal);
    glBindTextureUnit(PEL_UNIT_UNDER_FOAM, map->foam);
    glBindTextureUnit(PEL_UNIT_UNDER_BACK, map->back);
    if (pel_lamp_glow_any_below(env)) {
        fit_lamps(map);
        find(map, env, p, LAMPS, map->lamps_fbo);
        glBindTextureUnit(PEL_UNIT_UNDER_LAMPS, map->lamps);
        glBindTextureUnit(PEL_UNIT_UNDER_LAMPS_ON, map->lamps_on);
    }
    if (crossed) {
        draw_light(map, env, p, SCENE, targets);
    }
    draw_layers(map, env, p, SCENE, targets, asked, !crossed);
    if (objects) {
        find_above(map, objects, view);
        draw_light(map, env, p, ABOVE, targets);
        draw_light(map, env, p, HULLS, targets);
        draw_layers(map, env, p, HULLS, targets, asked, false);
    }
}
