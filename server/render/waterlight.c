#include "render/waterlight.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/vec.h"
#include "optics/brdf.h"
#include "optics/facets.h"
#include "optics/linear.h"
#include "optics/waterkept.h"
#include "render/shader.h"
#include "render/uniforms.h"

#define SIZE PEL_WATER_MAP_SIZE
#define NODES PEL_WATER_NODES
#define DIRECTIONS (2 * PEL_WATER_ZENITHS)

_Static_assert(DIRECTIONS % PEL_GROUP_WATER == 0, "whole groups");
_Static_assert(PEL_WATER_LAYERS == 1 + PEL_WATER_PARTS, "a sum and parts");
_Static_assert(PEL_WATER_NODES == 12, "three vec4 of weights a row");

static const char *const buffer_names[PEL_WATER_BUFFERS] = {
    "water directions", "water nodes",    "water planes",    "water kernel",
    "water sky rows",   "water map rows", "water sky beams", "water medium",
    "water beam",       "water turns",
};

static GLuint make_texture(GLenum target, GLsizei width, GLsizei height,
                           GLsizei layers, const char *label)
{
    GLuint texture = 0;
    glCreateTextures(target, 1, &texture);
    if (target == GL_TEXTURE_2D) {
        glTextureStorage2D(texture, 1, GL_RGBA32F, width, height);
    } else {
        glTextureStorage3D(texture, 1, GL_RGBA32F, width, height, layers);
    }
    GLint filter = target == GL_TEXTURE_2D_ARRAY ? GL_LINEAR : GL_NEAREST;
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, filter);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, filter);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

/* A buffer anew: with these bytes, or (NULL) with room for them. */
static void make_buffer(struct pel_water_light *w, enum pel_water_buffer which,
                        size_t size, const void *bytes)
{
    glDeleteBuffers(1, &w->buffers[which]);
    glCreateBuffers(1, &w->buffers[which]);
    glNamedBufferStorage(w->buffers[which], (GLsizeiptr)size, bytes,
                         bytes ? 0 : GL_DYNAMIC_STORAGE_BIT);
    glObjectLabel(GL_BUFFER, w->buffers[which], -1, buffer_names[which]);
}

static void bind(const struct pel_water_light *w, GLuint binding,
                 enum pel_water_buffer which)
{
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, w->buffers[which]);
}

static void put_nodes(struct pel_vec4 to[3], double sine)
{
    double weight[NODES];
    pel_kernel_weights(sine, weight);
    for (int i = 0; i < 3; i++) {
        to[i] =
            (struct pel_vec4){ (float)weight[4 * i], (float)weight[4 * i + 1],
                               (float)weight[4 * i + 2],
                               (float)weight[4 * i + 3] };
    }
}

static void make_directions(struct pel_water_light *w)
{
    double mu[PEL_WATER_ZENITHS], weight[PEL_WATER_ZENITHS];
    GLfloat all[DIRECTIONS][2], nodes[NODES][2];
    pel_gauss_legendre(PEL_WATER_ZENITHS, 0.0, 1.0, mu, weight);
    for (int i = 0; i < DIRECTIONS; i++) {
        int k = i % PEL_WATER_ZENITHS;
        all[i][0] = (GLfloat)(i < PEL_WATER_ZENITHS ? mu[k] : -mu[k]);
        all[i][1] = (GLfloat)weight[k];
    }
    for (int i = 0; i < NODES; i++) {
        double sine = pel_kernel_sine(i);
        nodes[i][0] = (GLfloat)sine;
        nodes[i][1] = (GLfloat)sqrt(1.0 - sine * sine);
    }
    make_buffer(w, PEL_WATER_BUFFER_DIRECTIONS, sizeof all, all);
    make_buffer(w, PEL_WATER_BUFFER_KNOTS, sizeof nodes, nodes);
}

/* The sky's rows lie at e = π/2 x², as in shaders/light.comp: close together
 * near the horizon. */
static void make_rows(struct pel_water_light *w)
{
    struct pel_shader_row sky[PEL_WATER_SKY_ROWS], map[SIZE];
    const double step = 1.0 / PEL_WATER_SKY_ROWS;
    for (int i = 0; i < PEL_WATER_SKY_ROWS; i++) {
        double x = (i + 0.5) * step, e = 0.5 * PEL_PI * x * x;
        const struct pel_geometry at = { .sun_zenith_rad = 0.5 * PEL_PI - e };
        double azimuth_step =
            PEL_PI / PEL_WATER_SKY_COLUMNS * 2.0; /* both halves */
        double solid = azimuth_step * PEL_PI * x * step * cos(e);
        sky[i].at = (struct pel_vec4){
            (float)e, (float)(solid * pel_interface_at(&at).beam), 0, 0
        };
        put_nodes(sky[i].at_nodes, cos(e) / PEL_WATER_INDEX);
    }
    for (int i = 0; i < SIZE; i++) {
        double sine = (double)i / (SIZE - 1) / PEL_WATER_INDEX;
        map[i].at = (struct pel_vec4){ (float)sine,
                                       (float)sqrt(1.0 - sine * sine), 0, 0 };
        put_nodes(map[i].at_nodes, sine);
    }
    make_buffer(w, PEL_WATER_BUFFER_SKY_ROW, sizeof sky, sky);
    make_buffer(w, PEL_WATER_BUFFER_MAP_ROW, sizeof map, map);
}

enum pel_err pel_water_light_init(struct pel_water_light *w,
                                  const char *shader_dir,
                                  struct pel_fault *fault)
{
    static const char *const files[PEL_WATER_PROGRAMS] = {
        "water_phase.comp", "water_radiance.comp", "water_scatter.comp",
        "water_sky.comp", "water_map.comp"
    };
    memset(w, 0, sizeof *w);
    w->build = pel_water_kernel_take;
    for (int i = 0; i < PEL_WATER_PROGRAMS; i++) {
        enum pel_err err = pel_program_create(shader_dir, files[i], NULL, NULL,
                                              &w->programs[i], fault);
        if (err) {
            return err;
        }
    }
    w->phase_map = make_texture(GL_TEXTURE_3D, DIRECTIONS, NODES,
                                PEL_WATER_MODES, "water volume scattering");
    w->radiance_map = make_texture(GL_TEXTURE_3D, DIRECTIONS, NODES,
                                   PEL_WATER_PLANES, "water radiance");
    w->attenuation_map = make_texture(GL_TEXTURE_2D, NODES, PEL_WATER_PLANES, 1,
                                      "water attenuation");
    make_directions(w);
    make_rows(w);
    make_buffer(w, PEL_WATER_BUFFER_COEFFICIENTS,
                sizeof(struct pel_vec4) * PEL_WATER_MODES * NODES, NULL);
    make_buffer(w, PEL_WATER_BUFFER_MEDIUM, sizeof(struct pel_block_medium),
                NULL);
    make_buffer(w, PEL_WATER_BUFFER_TURNS,
                sizeof(struct pel_vec4) * (PEL_WATER_TURNS + 1), NULL);
    make_buffer(w, PEL_WATER_BUFFER_BEAM, sizeof(struct pel_block_beam), NULL);
    return PEL_OK;
}

void pel_water_light_finish(struct pel_water_light *w)
{
    const GLuint textures[] = { w->phase_map, w->radiance_map,
                                w->attenuation_map, w->map };
    glDeleteTextures(4, textures);
    glDeleteBuffers(PEL_WATER_BUFFERS, w->buffers);
    for (int i = 0; i < PEL_WATER_PROGRAMS; i++) {
        pel_program_delete(w->programs[i]);
    }
    memset(w, 0, sizeof *w);
}

struct pel_water_depths pel_water_light_depths(const struct pel_environment *e)
{
    return e->depths.levels > 1
               ? e->depths
               : (struct pel_water_depths){ 1, e->water.depth_m,
                                            e->water.depth_m };
}

/* --- a new water ---------------------------------------------------------- */

static struct pel_vec4 vec4(const double v[3], double last)
{
    return (struct pel_vec4){ (float)v[0], (float)v[1], (float)v[2],
                              (float)last };
}

static void put_medium(struct pel_water_light *w)
{
    double full[3], single[3], peak[3];
    struct pel_phase_split split[3];
    for (int i = 0; i < 3; i++) {
        struct pel_medium m = pel_water_medium(&w->body, i);
        struct pel_phase phase = pel_medium_phase(&m);
        split[i] = pel_phase_split(&phase);
        peak[i] = split[i].peak;
        full[i] = m.absorption + m.scattering;
        single[i] = full[i];
        if (pel_orders_extinction(w->orders) == PEL_EXTINCTION_REDUCED) {
            single[i] -= m.scattering * pel_medium_forward(&m);
        }
    }
    struct pel_block_medium block = {
        .full_extinction = vec4(full, w->orders == PEL_ORDERS_ALL),
        .single_extinction = vec4(single, 0.0),
        .scattering = vec4(w->body.scattering, 0.0),
        .ground = vec4(w->body.albedo, 0.0),
        .peak = vec4(peak, 0.0),
    };
    for (int i = 0; i < w->depths.levels; i++) {
        block.depth[i].x = (float)pel_water_depth(&w->depths, i);
    }
    glNamedBufferSubData(w->buffers[PEL_WATER_BUFFER_MEDIUM], 0, sizeof block,
                         &block);
    struct pel_vec4 turns[PEL_WATER_TURNS + 1];
    for (int k = 0; k <= PEL_WATER_TURNS; k++) {
        double half = (double)k / PEL_WATER_TURNS, rest[3];
        for (int i = 0; i < 3; i++) {
            rest[i] = pel_phase_rest(&split[i], 1.0 - 2.0 * half * half);
        }
        turns[k] = vec4(rest, 0.0);
    }
    glNamedBufferSubData(w->buffers[PEL_WATER_BUFFER_TURNS], 0, sizeof turns,
                         turns);
}

static void put_planes(struct pel_water_light *w)
{
    struct pel_vec4 planes[PEL_WATER_LEVELS_MAX * PEL_WATER_PLANES][2];
    int count = w->depths.levels * PEL_WATER_PLANES;
    for (int k = 0; k < count; k++) {
        double depth[3], weight[3];
        for (int i = 0; i < 3; i++) {
            struct pel_medium m = pel_water_medium(&w->body, i);
            m.depth_m = pel_water_depth(&w->depths, k / PEL_WATER_PLANES);
            depth[i] = pel_sampling_plane(&m, PEL_WATER_PLANES,
                                          k % PEL_WATER_PLANES, &weight[i]);
        }
        planes[k][0] = vec4(depth, 0.0);
        planes[k][1] = vec4(weight, 0.0);
    }
    make_buffer(w, PEL_WATER_BUFFER_PLANE, sizeof planes[0] * (size_t)count,
                planes);
}

/* The kernel of every depth, on the heap; NULL: no memory. */
static struct pel_water_kernel *make_kernel(const struct pel_water_light *w,
                                            const struct pel_environment *env,
                                            struct pel_water_depths depths)
{
    struct pel_water_kernel *kernel =
        malloc(sizeof *kernel * (size_t)depths.levels);
    if (kernel && w->build(&env->water, &depths, env->orders, kernel)) {
        free(kernel);
        return NULL;
    }
    return kernel;
}

/* The second order, by the maps. */
static void scatter(struct pel_water_light *w)
{
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_MEDIUM,
                     w->buffers[PEL_WATER_BUFFER_MEDIUM]);
    bind(w, PEL_STORE_WATER_KERNEL, PEL_WATER_BUFFER_KERNEL);
    bind(w, PEL_STORE_WATER_DIRECTIONS, PEL_WATER_BUFFER_DIRECTIONS);
    bind(w, PEL_STORE_WATER_NODES, PEL_WATER_BUFFER_KNOTS);
    bind(w, PEL_STORE_WATER_PLANES, PEL_WATER_BUFFER_PLANE);
    bind(w, PEL_STORE_WATER_TURNS, PEL_WATER_BUFFER_TURNS);
    glBindTextureUnit(PEL_UNIT_WATER_PHASE, w->phase_map);
    glBindTextureUnit(PEL_UNIT_WATER_RADIANCE, w->radiance_map);
    glBindTextureUnit(PEL_UNIT_WATER_ATTENUATION, w->attenuation_map);
    glBindImageTexture(PEL_IMAGE_WATER_PHASE, w->phase_map, 0, GL_TRUE, 0,
                       GL_WRITE_ONLY, GL_RGBA32F);
    pel_program_use(w->programs[PEL_WATER_PHASE_MAP]);
    glDispatchCompute(DIRECTIONS / PEL_GROUP_WATER, NODES, 1);
    glBindImageTexture(PEL_IMAGE_WATER_RADIANCE, w->radiance_map, 0, GL_TRUE, 0,
                       GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(PEL_IMAGE_WATER_ATTENUATION, w->attenuation_map, 0,
                       GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    GLuint radiance = w->programs[PEL_WATER_RADIANCE_MAP];
    GLuint scattering = w->programs[PEL_WATER_SCATTER_MAP];
    for (int level = 0; level < w->depths.levels; level++) {
        pel_program_use(radiance);
        glUniform1i(0, level);
        glDispatchCompute(DIRECTIONS / PEL_GROUP_WATER, NODES,
                          PEL_WATER_PLANES);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
        pel_program_use(scattering);
        glUniform1i(0, level);
        glDispatchCompute(NODES, NODES, 1);
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                        GL_SHADER_STORAGE_BARRIER_BIT);
    }
}

static bool is_current(const struct pel_water_light *w,
                       const struct pel_environment *env,
                       struct pel_water_depths depths)
{
    return w->version && w->orders == env->orders &&
           memcmp(&env->water, &w->body,
                  offsetof(struct pel_water_body, land)) == 0 &&
           depths.levels == w->depths.levels &&
           depths.first_m == w->depths.first_m &&
           depths.last_m == w->depths.last_m;
}

/* What the maps still hold, in place of what is wanted. */
static enum pel_err keep_the_last(struct pel_water_light *w,
                                  struct pel_environment *env)
{
    bool whole = w->version && (w->depths.levels > 1) == (env->seabed != NULL);
    if (!w->failed) {
        pel_error("RND-044",
                  "no memory for the light in a new water; %s, every frame "
                  "tries again",
                  whole ? "pictures keep the last one"
                        : "nothing is drawn without it");
    }
    w->failed = true;
    if (!whole) {
        return PEL_ERR_NO_MEMORY;
    }
    memcpy(&env->water, &w->body, offsetof(struct pel_water_body, land));
    env->depths = w->depths;
    env->orders = w->orders;
    return PEL_OK;
}

enum pel_err pel_water_light_update(struct pel_water_light *w,
                                    struct pel_environment *env)
{
    struct pel_water_depths depths = pel_water_light_depths(env);
    if (is_current(w, env, depths)) {
        return PEL_OK;
    }
    struct pel_water_kernel *kernel = make_kernel(w, env, depths);
    if (!kernel) {
        return keep_the_last(w, env);
    }
    size_t size = sizeof *kernel * (size_t)depths.levels;
    if (depths.levels != w->depths.levels) {
        glDeleteTextures(1, &w->map);
        w->map = make_texture(GL_TEXTURE_2D_ARRAY, SIZE, SIZE,
                              PEL_LIGHTS * PEL_WATER_LAYERS * depths.levels,
                              "water");
        make_buffer(w, PEL_WATER_BUFFER_KERNEL, size, NULL);
    }
    w->body = env->water;
    w->depths = depths;
    w->orders = env->orders;
    put_medium(w);
    put_planes(w);
    glNamedBufferSubData(w->buffers[PEL_WATER_BUFFER_KERNEL], 0,
                         (GLsizeiptr)size, kernel);
    free(kernel);
    if (w->orders != PEL_ORDERS_SINGLE) {
        scatter(w);
    }
    w->failed = false;
    w->version++;
    return PEL_OK;
}

/* --- new lights ----------------------------------------------------------- */

/* Of what enters, the mean direction is taken to be as below a level sea. */
static double beam_below(struct pel_vec3 to, double sun_mu,
                         const struct pel_water_waves *waves)
{
    const struct pel_water_waves level = { 0 };
    const struct pel_water_waves *w = waves ? waves : &level;
    double c = cos(w->wind_to_rad), s = sin(w->wind_to_rad);
    to.z = pel_clamp(to.z, 0.0, 1.0);
    const struct pel_vec3 in_wind = { c * to.x + s * to.y, c * to.y - s * to.x,
                                      to.z };
    return pel_facets_entering(in_wind, w->along, w->cross) * to.z / sun_mu;
}

static void put_beam(struct pel_water_light *w, int light, struct pel_vec3 to,
                     const struct pel_water_waves *waves)
{
    double zenith = acos(pel_clamp(to.z, 0.0, 1.0));
    const struct pel_geometry at = { .sun_zenith_rad = zenith };
    struct pel_interface face = pel_interface_at(&at);
    double sine = sin(zenith) / PEL_WATER_INDEX;
    w->beams[light] = beam_below(to, face.sun_mu, waves);
    struct pel_block_beam block = {
        .refracted = { (float)sine, (float)face.sun_mu, (float)w->beams[light],
                       0 },
    };
    put_nodes(block.at_nodes, sine);
    glNamedBufferSubData(w->buffers[PEL_WATER_BUFFER_BEAM], 0, sizeof block,
                         &block);
}

static void make_sky(struct pel_water_light *w, int light)
{
    GLuint sky = w->programs[PEL_WATER_SKY];
    bind(w, PEL_STORE_WATER_ROWS, PEL_WATER_BUFFER_SKY_ROW);
    pel_program_use(sky);
    glUniform1i(0, light);
    glDispatchCompute(PEL_WATER_MODES, 1, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void pel_water_light_enter(struct pel_water_light *w,
                           const struct pel_light *lights, int i,
                           const struct pel_water_waves *waves,
                           GLuint sky_table)
{
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_BEAM,
                     w->buffers[PEL_WATER_BUFFER_BEAM]);
    bind(w, PEL_STORE_WATER_COEFFICIENTS, PEL_WATER_BUFFER_COEFFICIENTS);
    glBindTextureUnit(PEL_UNIT_SKY_TABLE, sky_table);
    put_beam(w, i, lights[i].direction, waves);
    make_sky(w, i);
}

static void map_light(struct pel_water_light *w, int light)
{
    GLuint map = w->programs[PEL_WATER_MAP];
    make_sky(w, light);
    bind(w, PEL_STORE_WATER_ROWS, PEL_WATER_BUFFER_MAP_ROW);
    pel_program_use(map);
    glUniform1i(0, light);
    glDispatchCompute(SIZE, (GLuint)w->depths.levels, 1);
    glMemoryBarrier(GL_UNIFORM_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                    GL_TEXTURE_FETCH_BARRIER_BIT |
                    GL_SHADER_STORAGE_BARRIER_BIT);
}

void pel_water_light_map(struct pel_water_light *w,
                         const struct pel_light *lights, int lit,
                         const struct pel_water_waves *waves, GLuint sky_table,
                         GLuint light)
{
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_MEDIUM,
                     w->buffers[PEL_WATER_BUFFER_MEDIUM]);
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_BEAM,
                     w->buffers[PEL_WATER_BUFFER_BEAM]);
    bind(w, PEL_STORE_WATER_TURNS, PEL_WATER_BUFFER_TURNS);
    bind(w, PEL_STORE_WATER_COEFFICIENTS, PEL_WATER_BUFFER_COEFFICIENTS);
    bind(w, PEL_STORE_WATER_KERNEL, PEL_WATER_BUFFER_KERNEL);
    glBindTextureUnit(PEL_UNIT_SKY_TABLE, sky_table);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_LIGHT, light);
    glBindImageTexture(PEL_IMAGE_WATER_MAP, w->map, 0, GL_TRUE, 0,
                       GL_WRITE_ONLY, GL_RGBA32F);
    for (int i = 0; i < lit; i++) {
        put_beam(w, i, lights[i].direction, waves);
        map_light(w, i);
    }
}
