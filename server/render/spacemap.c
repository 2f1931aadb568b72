#include "render/spacemap.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "continents/continents.h"
#include "optics/atmosphere.h"
#include "render/cloudsystems.h"
#include "render/programs.h"
#include "render/shader.h"
#include "render/uniforms.h"
#include "scene/geodesy.h"

#define MOST_PROGRAMS 256
#define LONGEST_OF_FFT_M 4400.0 /* the first cascade's tile */
#define CLOUDS_LEAST_M 2e4
#define CLOUDS_WHOLE_M 1.5e5
#define DEEP_NIGHT (-18.0 * PEL_DEG)
/* Air that shines beyond the horizon of an eye. */
#define AIR_BEYOND (8.0 * PEL_DEG)

double pel_space_share(const struct pel_environment *env, double height_m)
{
    bool near = env->object_count > 0 || env->lamp_count > 0 || env->seabed ||
                env->clouds.cover > 0 || env->fog_count > 0 || env->panorama;
    if (env->high || !near) {
        return env->high > 0 || (!env->high && height_m >= PEL_SPACE_LEAST_M);
    }
    /* As steady by the octave as rows themselves. */
    double x = pel_clamp(log(height_m / PEL_SPACE_WHOLE_M) /
                             log(PEL_SPACE_ALONE_M / PEL_SPACE_WHOLE_M),
                         0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

bool pel_space_is(const struct pel_environment *env, double height_m)
{
    return pel_space_share(env, height_m) >= 0.5;
}

struct pel_space_geometry
pel_space_geometry_for(const struct pel_environment *env,
                       const struct pel_camera *camera, double height_m)
{
    double lat0 = env->origin_latitude_rad / PEL_DEG,
           lon0 = env->origin_longitude_rad / PEL_DEG, lat, lon;
    pel_geo_from_local(lat0, lon0, camera->east_m, camera->north_m, &lat, &lon);
    return pel_space_geometry_of(height_m, lat * PEL_DEG, lon * PEL_DEG,
                                 pel_geo_turn(lat0, lon0, lat, lon));
}

/* By the highest that each light stands over what is seen, and the lowest the
 * Sun. */
struct pel_environment pel_space_environment(const struct pel_environment *env,
                                             double height_m)
{
    struct pel_environment here = *env;
    double reach =
        acos(PEL_EARTH_RADIUS / (PEL_EARTH_RADIUS + fmax(height_m, 0.0)));
    int at = env->lights[0].body == PEL_LIGHT_SUN ? 0 : 1;
    const struct pel_light *sun = &env->lights[at],
                           *moon = &env->lights[1 - at];
    double sun_rad = asin(pel_clamp(sun->direction.z, -1.0, 1.0)),
           moon_rad = asin(pel_clamp(moon->direction.z, -1.0, 1.0));
    bool day = sun->strength > 0 && sun_rad + reach + AIR_BEYOND > DEEP_NIGHT;
    bool moonlit = moon->strength > 0 && sun_rad - reach < 0.0 &&
                   moon_rad + reach + AIR_BEYOND > 0.0;
    const struct pel_light first = day || !moonlit ? *sun : *moon,
                           other = day || !moonlit ? *moon : *sun;
    here.lights[0] = first;
    here.lights[1] = other;
    here.lit = day && moonlit ? 2 : 1;
    here.discs = other.strength > 0 ? 2 : 1;
    return here;
}

/* --- programs ------------------------------------------------------------- */

enum pel_err pel_space_need(struct pel_space_map *m, const char *shader_dir,
                            struct pel_fault *fault)
{
    return m->air_program
               ? PEL_OK
               : pel_program_create(shader_dir, "screen.vert", "space_air.frag",
                                    NULL, &m->air_program, fault);
}

enum pel_err pel_space_need_meter(struct pel_space_map *m, int lit, bool winds,
                                  const char *shader_dir,
                                  struct pel_fault *fault)
{
    GLuint *program = &m->meter_program[winds][lit - 1];
    char defines[96];
    snprintf(defines, sizeof defines, "#define PEL_SPACE\n%s%s",
             lit > 1 ? "#define PEL_LIT 2\n" : "",
             winds ? "#define PEL_SPACE_WINDS\n" : "");
    return *program ? PEL_OK
                    : pel_program_create(shader_dir, "meter.comp", NULL,
                                         defines, program, fault);
}

GLuint pel_space_program(struct pel_space_map *m, const char *shader_dir,
                         const char *defines, struct pel_fault *fault)
{
    for (int i = 0; i < m->program_count; i++) {
        if (strcmp(m->programs[i].defines, defines) == 0) {
            return m->programs[i].program;
        }
    }
    GLuint program = 0;
    if (m->program_count == MOST_PROGRAMS) {
        pel_fault_set(fault, PEL_ERR_NO_MEMORY, "too many kinds of pictures");
        return 0;
    }
    if (pel_program_create(shader_dir, "shade.vert", "space.frag", defines,
                           &program, fault)) {
        return 0;
    }
    if (!m->programs) {
        m->programs = pel_sure_malloc(MOST_PROGRAMS * sizeof *m->programs);
    }
    char *copy = pel_sure_malloc(strlen(defines) + 1);
    strcpy(copy, defines);
    m->programs[m->program_count++] =
        (struct pel_space_program){ copy, program };
    return program;
}

/* --- light by elevation --------------------------------------------------- */

static GLuint make_layers(GLsizei levels, GLint filter, const char *label)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &texture);
    glTextureStorage3D(texture, levels, GL_RGBA32F, PEL_SPACE_MAP,
                       PEL_SPACE_MAP, PEL_SPACE_SUNS);
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, filter);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

static void copy_layer(GLuint from, GLint level, GLint layer, GLuint to,
                       GLint to_level, GLint to_layer, GLenum target)
{
    GLsizei side = PEL_SPACE_MAP >> to_level;
    glCopyImageSubData(from, target, level, 0, 0, layer, to,
                       GL_TEXTURE_2D_ARRAY, to_level, 0, 0, to_layer, side,
                       side, 1);
}

#define SKY_LEVELS 6
_Static_assert(PEL_SKY_MAP_SIZE == 2 * PEL_SPACE_MAP, "its second level");
_Static_assert(PEL_SECOND_SIZE == PEL_SPACE_MAP, "copied whole");
_Static_assert(PEL_WATER_MAP_SIZE == PEL_SPACE_MAP, "copied whole");

static double elevation_of(int k)
{
    double x =
        PEL_SPACE_SUN_FIRST +
        (PEL_SPACE_SUN_LAST - PEL_SPACE_SUN_FIRST) * k / (PEL_SPACE_SUNS - 1.0);
    return PEL_SPACE_SUN_WIDTH * sinh(x) - PEL_SPACE_SUN_MIDDLE;
}

static void buffer_for(GLuint *buffer, size_t size, const char *label)
{
    if (!*buffer) {
        glCreateBuffers(1, buffer);
        glNamedBufferStorage(*buffer, (GLsizeiptr)size, NULL,
                             GL_DYNAMIC_STORAGE_BIT);
        glObjectLabel(GL_BUFFER, *buffer, -1, label);
    }
}

static void bind_table_eye(void *user, double height_m)
{
    struct pel_space_map *m = user;
    struct pel_block_eye block;
    pel_fill_eye(height_m, height_m, NULL, &block);
    glNamedBufferSubData(m->eye, 0, sizeof block, &block);
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_EYE, m->eye);
}

static struct pel_vec4 log2_of(struct pel_vec4 a, struct pel_vec4 b, double t)
{
    const double least = 1e-30;
    return (struct pel_vec4){
        (float)log2(fmax((double)a.x + t * (double)b.x, least)),
        (float)log2(fmax((double)a.y + t * (double)b.y, least)),
        (float)log2(fmax((double)a.z + t * (double)b.z, least)),
        0,
    };
}

static void make_sun(struct pel_space_map *m, struct pel_sky *sky,
                     struct pel_environment *fake, int k)
{
    double e = elevation_of(k);
    pel_lights_of_sun((struct pel_vec3){ cos(e), 0, sin(e) }, fake->lights);
    struct pel_block_frame frame;
    struct pel_block_light light;
    pel_fill_frame(fake, &frame);
    /* Waves' directions, as places have them, would need maps for each. */
    frame.wind.z = frame.wind.w = 0.5f * (frame.wind.z + frame.wind.w);
    glNamedBufferSubData(m->frame, 0, sizeof frame, &frame);
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_FRAME, m->frame);
    pel_sky_update(sky, fake, bind_table_eye, m);
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT |
                    GL_BUFFER_UPDATE_BARRIER_BIT);
    for (int i = 0; i < SKY_LEVELS; i++) {
        copy_layer(sky->reflection, i + 1, 0, m->skies, i, k, GL_TEXTURE_2D);
    }
    copy_layer(sky->second, 0, 0, m->seconds, 0, k, GL_TEXTURE_2D);
    copy_layer(sky->water.map, 0, sky->water.depths.levels - 1, m->waters, 0, k,
               GL_TEXTURE_2D_ARRAY);
    glGetNamedBufferSubData(sky->light, 0, sizeof light, &light);
    m->suns[2 * k] = log2_of(light.skies[0], light.beams[0], 0.0);
    m->suns[2 * k + 1] =
        log2_of(light.skies[0], light.beams[0], fmax(sin(e), 0.0));
}

/* Weather changes the scene's sea all the time; the light that is kept follows
 * it by sixteenths of an octave, of which a thousandth or so is seen. */
static const struct pel_sea *about_as_rough(const struct pel_sea *sea,
                                            struct pel_sea *about)
{
    double mean = 0.5 * (sea->slope_variance_along + sea->slope_variance_cross);
    *about = *sea;
    about->slope_variance_along = about->slope_variance_cross =
        mean > 0 ? exp2(round(16 * log2(mean)) / 16) : 0;
    return about;
}

void pel_space_suns(struct pel_space_map *m, struct pel_sky *sky,
                    const struct pel_environment *env)
{
    static struct pel_sea about; /* one thread */
    struct pel_environment fake = *env;
    if (env->weather) {
        fake.sea = about_as_rough(env->sea, &about);
        fake.wind_to_rad = 0;
    }
    const double key[PEL_SPACE_SUN_KEYS] = {
        env->visibility_m,
        (double)sky->water.version,
        fake.sea->slope_variance_along,
        fake.sea->slope_variance_cross,
        env->water.index[1],
        fake.wind_to_rad,
    };
    if (m->suns_made && memcmp(key, m->sun_key, sizeof key) == 0) {
        return;
    }
    if (!m->skies) {
        m->skies = make_layers(SKY_LEVELS, GL_LINEAR_MIPMAP_LINEAR,
                               "skies by elevation");
        m->waters = make_layers(1, GL_LINEAR, "waters by elevation");
        m->seconds =
            make_layers(1, GL_LINEAR, "second reflections by elevation");
    }
    buffer_for(&m->frame, sizeof(struct pel_block_frame), "frame by elevation");
    buffer_for(&m->eye, sizeof(struct pel_block_eye), "eye by elevation");
    fake.lit = fake.discs = 1;
    fake.night = (struct pel_night_sky){ 0 };
    fake.panorama = NULL;
    fake.clouds = (struct pel_clouds){ 0 };
    fake.fog_count = 0;
    for (int k = 0; k < PEL_SPACE_SUNS; k++) {
        make_sun(m, sky, &fake, k);
    }
    memcpy(m->sun_key, key, sizeof key);
    m->suns_made = true;
}

/* --- the air of an eye ---------------------------------------------------- */

static GLuint make_table(GLenum target, const char *label)
{
    GLuint texture = 0;
    glCreateTextures(target, 1, &texture);
    if (target == GL_TEXTURE_2D) {
        glTextureStorage2D(texture, 1, GL_RGBA32F, PEL_SPACE_COLUMNS,
                           PEL_SPACE_ROWS);
    } else {
        glTextureStorage3D(texture, 1, GL_RGBA32F, PEL_SPACE_COLUMNS,
                           PEL_SPACE_ROWS, PEL_LIGHTS);
    }
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

static void make_air(struct pel_space_air *a)
{
    static const GLenum both[] = { GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1 };
    a->radiance = make_table(GL_TEXTURE_2D_ARRAY, "air from high up");
    a->through = make_table(GL_TEXTURE_2D, "through the air from high up");
    glCreateFramebuffers(PEL_LIGHTS, a->fbos);
    for (int i = 0; i < PEL_LIGHTS; i++) {
        glNamedFramebufferTextureLayer(a->fbos[i], GL_COLOR_ATTACHMENT0,
                                       a->radiance, 0, i);
        glNamedFramebufferTexture(a->fbos[i], GL_COLOR_ATTACHMENT1, a->through,
                                  0);
        glNamedFramebufferDrawBuffers(a->fbos[i], 2, both);
    }
}

static void air_key(const struct pel_environment *env,
                    const struct pel_block_space *b, double key[PEL_SPACE_KEYS])
{
    static const struct pel_light none;
    for (int i = 0; i < PEL_LIGHTS; i++) {
        bool lit = i < env->lit;
        const struct pel_light *l = lit ? &env->lights[i] : &none;
        const double all[8] = {
            lit ? (double)b->space_lights[i].x : 0,
            lit ? (double)b->space_lights[i].y : 0,
            lit ? (double)b->space_lights[i].z : 0,
            l->strength,
            l->radius_rad,
            lit ? l->body : -1,
            0,
            0,
        };
        memcpy(key + 8 * i, all, sizeof all);
    }
    key += 8 * PEL_LIGHTS;
    *key++ = (double)b->space_eye.x;
    *key++ = (double)b->space_eye.y;
    *key++ = (double)b->space_eye.w;
    *key++ = env->visibility_m;
    *key = env->lit;
}

static void draw_air(struct pel_space_map *m, const struct pel_sky *sky,
                     const struct pel_environment *env,
                     const struct pel_space_air *a)
{
    glBindTextureUnit(PEL_UNIT_TRANSMITTANCE, sky->transmittance);
    glBindTextureUnit(PEL_UNIT_AIRLIGHT, sky->airlight);
    glDisable(GL_DEPTH_TEST);
    glViewport(0, 0, PEL_SPACE_COLUMNS, PEL_SPACE_ROWS);
    pel_program_use(m->air_program);
    for (int i = 0; i < env->lit; i++) {
        glUniform1i(1, i);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, a->fbos[i]);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
}

void pel_space_bind(struct pel_space_map *m, const struct pel_sky *sky,
                    const struct pel_environment *env,
                    const struct pel_block_space *block)
{
    double key[PEL_SPACE_KEYS];
    air_key(env, block, key);
    struct pel_space_air *a = &m->eyes[0];
    for (int i = 0; i < PEL_SPACE_EYES; i++) {
        struct pel_space_air *e = &m->eyes[i];
        if (e->made && memcmp(key, e->key, sizeof key) == 0) {
            a = e;
            break;
        }
        if (e->last_used < a->last_used) {
            a = e;
        }
    }
    if (!a->made || memcmp(key, a->key, sizeof key) != 0) {
        if (!a->through) {
            make_air(a);
        }
        draw_air(m, sky, env, a);
        memcpy(a->key, key, sizeof key);
        a->made = true;
    }
    a->last_used = ++m->uses;
    glBindTextureUnit(PEL_UNIT_TRANSMITTANCE, sky->transmittance);
    glBindTextureUnit(PEL_UNIT_REFLECTION, sky->reflection);
    glBindTextureUnit(PEL_UNIT_SECOND, sky->second);
    glBindTextureUnit(PEL_UNIT_WATER, sky->water.map);
    glBindTextureUnit(PEL_UNIT_SPACE_AIR, a->radiance);
    glBindTextureUnit(PEL_UNIT_SPACE_THROUGH, a->through);
    glBindTextureUnit(PEL_UNIT_SPACE_SKIES, m->skies);
    glBindTextureUnit(PEL_UNIT_SPACE_WATERS, m->waters);
    glBindTextureUnit(PEL_UNIT_SPACE_SECONDS, m->seconds);
    glBindTextureUnit(PEL_UNIT_SPACE_LAND, m->land);
    glBindTextureUnit(PEL_UNIT_SPACE_GROUND, m->ground);
}

/* --- continents ----------------------------------------------------------- */

static GLuint make_globe(GLenum format, GLsizei columns, GLsizei rows,
                         GLsizei levels, const char *label)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, levels, format, columns, rows);
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER,
                        levels > 1 ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

#define LAND_LEVELS 12
_Static_assert(PEL_CONTINENT_ROWS >> (LAND_LEVELS - 1) == 2, "halves");

/* Levels of detail made here: software devices take ten times as long. */
static void put_land(GLuint texture, const uint8_t *share)
{
    int columns = PEL_CONTINENT_COLUMNS, rows = PEL_CONTINENT_ROWS;
    uint8_t *half = pel_sure_malloc((size_t)columns * (size_t)rows / 4);
    const uint8_t *from = share;
    for (int level = 0; level < LAND_LEVELS; level++) {
        glTextureSubImage2D(texture, level, 0, 0, columns, rows, GL_RED,
                            GL_UNSIGNED_BYTE, from);
        columns /= 2;
        rows /= 2;
        for (int y = 0; y < rows; y++) { /* in place from the second on */
            const uint8_t *low = from + (size_t)(4 * y) * (size_t)columns,
                          *high = low + 2 * columns;
            for (int x = 0; x < columns; x++) {
                int sum =
                    low[2 * x] + low[2 * x + 1] + high[2 * x] + high[2 * x + 1];
                half[(size_t)y * (size_t)columns + (size_t)x] =
                    (uint8_t)((sum + 2) / 4);
            }
        }
        from = half;
    }
    free(half);
}

void pel_space_continents(struct pel_space_map *m,
                          const struct pel_environment *env)
{
    if (m->land_sought || !env->continents) {
        return;
    }
    m->land_sought = true;
    const struct pel_continents *c = pel_continents_get();
    if (!c) {
        return;
    }
    m->land = make_globe(GL_R8, PEL_CONTINENT_COLUMNS, PEL_CONTINENT_ROWS,
                         LAND_LEVELS, "shares of land");
    put_land(m->land, c->share);
    m->ground = make_globe(GL_RGBA16, PEL_GROUND_COLUMNS, PEL_GROUND_ROWS, 1,
                           "albedo of land");
    glTextureSubImage2D(m->ground, 0, 0, 0, PEL_GROUND_COLUMNS, PEL_GROUND_ROWS,
                        GL_RGBA, GL_UNSIGNED_SHORT, c->ground);
}

/* --- the block ------------------------------------------------------------ */

static struct pel_vec4 vec4(double x, double y, double z, double w)
{
    return (struct pel_vec4){ (float)x, (float)y, (float)z, (float)w };
}

/* --- systems of clouds -----------------------------------------------------
 */

static void fill_origin(const struct pel_environment *env, double from,
                        struct pel_block_space *out)
{
    const double lat = env->origin_latitude_rad,
                 lon = env->origin_longitude_rad;
    const struct pel_vec3 at = { cos(lat) * cos(lon), cos(lat) * sin(lon),
                                 sin(lat) };
    double o[PEL_CLOUD_OCTAVES] = { 0 };
    if (env->clouds.cover > 0) {
        pel_cloud_systems(at, from, o);
    }
    out->space_origin = vec4(at.x, at.y, at.z, o[0]);
    out->space_systems[0] = vec4(o[1], o[2], o[3], o[4]);
    out->space_systems[1] = vec4(o[5], o[6], o[7], o[8]);
}

static void put_columns(const struct pel_mat3 *m, struct pel_vec4 out[3])
{
    out[0] = vec4(m->x.x, m->x.y, m->x.z, 0);
    out[1] = vec4(m->y.x, m->y.y, m->y.z, 0);
    out[2] = vec4(m->z.x, m->z.y, m->z.z, 0);
}

void pel_fill_space(const struct pel_space_map *m,
                    const struct pel_environment *env,
                    const struct pel_space_geometry *g,
                    struct pel_block_space *out)
{
    const double radius = PEL_EARTH_RADIUS, r = radius + g->height_m;
    const struct pel_rgb sun = pel_light_bodies[PEL_LIGHT_SUN].irradiance;
    double longest =
        env->sea->cascades ? LONGEST_OF_FFT_M
        : env->sea->count
            ? 2.0 * PEL_PI / hypot(env->sea->waves[0].kx, env->sea->waves[0].ky)
            : 0.0;
    const double systems = fmod(0.618 * env->clouds.seed, 64.0) - 32.0;
    *out = (struct pel_block_space){
        .space_eye =
            vec4(g->height_m, -sqrt(g->height_m * (radius + r)) / r, g->whole,
                 fmin(g->height_m, PEL_ATMOSPHERE_RADIUS - radius)),
        .space_more = vec4(env->continents && m->land, longest, 0, 0),
        /* Systems of clouds fade in as tiles of the field become many. */
        .space_cloud =
            vec4(systems,
                 0.8 * pel_clamp(log(g->height_m / CLOUDS_LEAST_M) /
                                     log(CLOUDS_WHOLE_M / CLOUDS_LEAST_M),
                                 0.0, 1.0),
                 0, 0),
        .space_sun = vec4(sun.r, sun.g, sun.b, 0),
    };
    fill_origin(env, systems, out);
    put_columns(&g->from, out->space_from);
    put_columns(&g->earth, out->space_earth);
    for (int i = 0; i < PEL_LIGHTS; i++) {
        const struct pel_vec3 to = env->lights[i].direction;
        const struct pel_vec3 there =
            pel_vec3_normalize(pel_mat3_apply(&g->from, to));
        out->space_lights[i] =
            vec4(there.x, there.y, there.z, asin(pel_clamp(to.z, -1.0, 1.0)));
    }
    memcpy(out->space_suns, m->suns, sizeof m->suns);
}

void pel_space_map_finish(struct pel_space_map *m)
{
    pel_program_delete(m->air_program);
    for (int i = 0; i < PEL_LIGHTS; i++) {
        pel_program_delete(m->meter_program[0][i]);
        pel_program_delete(m->meter_program[1][i]);
    }
    pel_wind_map_finish(&m->winds);
    for (int i = 0; i < m->program_count; i++) {
        pel_program_delete(m->programs[i].program);
        free(m->programs[i].defines);
    }
    free(m->programs);
    for (int i = 0; i < PEL_SPACE_EYES; i++) {
        struct pel_space_air *a = &m->eyes[i];
        glDeleteTextures(1, &a->radiance);
        glDeleteTextures(1, &a->through);
        glDeleteFramebuffers(PEL_LIGHTS, a->fbos);
    }
    const GLuint textures[] = { m->skies, m->waters, m->seconds, m->land,
                                m->ground };
    glDeleteTextures(5, textures);
    const GLuint buffers[] = { m->frame, m->eye };
    glDeleteBuffers(2, buffers);
    *m = (struct pel_space_map){ 0 };
}
