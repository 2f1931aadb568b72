#include "render/sensing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "models/model.h"
#include "optics/atmosphere.h"
#include "optics/colour.h"
#include "optics/lowlight.h"
#include "optics/thermal.h"
#include "render/pass.h"
#include "render/shader.h"
#include "shaders/lib/blocks.h"

#define FUNNEL_K 90.0 /* above the air, and a funnel's size about it */
#define TRANSOM_K 12.0
#define SUN_LEAST_K 6.0

static const unsigned of_heat[PEL_SENSE_PLANES] = {
    PEL_AT_DEPTH,          PEL_AT_NORMAL, PEL_AT_FRESNEL,
    PEL_AT_SLOPE_VARIANCE, PEL_AT_ID,     PEL_AT_FOAM,
};

bool pel_sensing_is(const struct pel_camera *c)
{
    return c->sensor.kind == PEL_SENSOR_ON &&
           c->sensor.sense != PEL_SENSE_VISIBLE;
}

static bool is_thermal(const struct pel_camera *c)
{
    return c->sensor.sense == PEL_SENSE_THERMAL;
}

unsigned pel_sensing_layers(const struct pel_camera *c, unsigned layers)
{
    if (!pel_sensing_is(c) || !(layers & PEL_LAYER_COLOR)) {
        return layers;
    }
    bool depth_too = pel_layers_stored(layers) & PEL_LAYER_DEPTH;
    layers &= ~(unsigned)PEL_LAYER_COLOR;
    if (!is_thermal(c)) {
        return layers | PEL_LAYER_RADIANCE;
    }
    for (int i = 0; i < PEL_SENSE_PLANES; i++) {
        layers |= (unsigned)pel_layer_table[of_heat[i]].bit;
    }
    return depth_too ? layers : layers | PEL_DEPTH_OF_THINGS;
}

/* --- tables --------------------------------------------------------------- */

static GLuint make_table(GLsizei width, GLsizei height, const float *texels,
                         const char *label)
{
    GLuint t;
    glCreateTextures(GL_TEXTURE_2D, 1, &t);
    glTextureStorage2D(t, 1, GL_RG32F, width, height);
    glTextureSubImage2D(t, 0, 0, 0, width, height, GL_RG, GL_FLOAT, texels);
    glTextureParameteri(t, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(t, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(t, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(t, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, t, -1, label);
    return t;
}

static void make_tables(struct pel_sensing *s)
{
    enum { W = PEL_SENSE_COSINES, H = PEL_SENSE_DEVIATIONS };
    float(*rough)[2] = pel_sure_malloc(sizeof *rough * W * H);
    float(*heats)[2] = pel_sure_malloc(sizeof *heats * PEL_SENSE_HEATS);
    double level[PEL_THERMAL_LEVELS];
    pel_thermal_level(level);
    for (int i = 0; i < W * H; i++) {
        double root = (i % W) / (W - 1.0),
               deviation = PEL_SENSE_DEVIATION_MOST * (i / W) / (H - 1.0);
        struct pel_thermal_rough e =
            pel_thermal_rough(root * root, deviation * deviation, level);
        rough[i][0] = (float)e.emissivity;
        rough[i][1] = (float)e.mirrored;
    }
    double hottest = sqrt(sqrt(pel_thermal_radiance(PEL_SENSE_MOST_K)));
    for (int i = 0; i < PEL_SENSE_HEATS; i++) {
        double at = i / (PEL_SENSE_HEATS - 1.0);
        double kelvin =
            PEL_SENSE_LEAST_K + at * (PEL_SENSE_MOST_K - PEL_SENSE_LEAST_K);
        heats[i][0] = (float)sqrt(sqrt(pel_thermal_radiance(kelvin)));
        heats[i][1] = (float)pel_thermal_temperature(pow(at * hottest, 4));
    }
    s->rough = make_table(W, H, rough[0], "emissivity of the sea");
    s->heats = make_table(PEL_SENSE_HEATS, 1, heats[0], "heat");
    free(rough);
    free(heats);
}

enum pel_err pel_sensing_need(struct pel_sensing *s,
                              const struct pel_programs *programs,
                              const struct pel_camera *c,
                              struct pel_fault *fault)
{
    GLuint *program = &s->programs[programs->light][is_thermal(c)];
    if (*program || !pel_sensing_is(c)) {
        return PEL_OK;
    }
    char defines[64 + PEL_LIGHT_TEXT];
    const char *light = pel_light_defines(programs->light);
    strncpy(defines, is_thermal(c) ? "#define PEL_THERMAL\n" : "",
            sizeof defines - 1);
    strncat(defines, light ? light : "", sizeof defines - 1 - strlen(defines));
    if (is_thermal(c) && !s->rough) {
        make_tables(s);
    }
    return pel_program_create(programs->shader_dir, "screen.vert", "sense.frag",
                              defines, program, fault);
}

void pel_sensing_finish(struct pel_sensing *s)
{
    for (int i = 0; i < PEL_LIGHT_KINDS; i++) {
        pel_program_delete(s->programs[i][0]);
        pel_program_delete(s->programs[i][1]);
    }
    glDeleteTextures(1, &s->rough);
    glDeleteTextures(1, &s->heats);
    *s = (struct pel_sensing){ 0 };
}

/* --- hot places ----------------------------------------------------------- */

struct spot {
    struct pel_vec3 at; /* from the eye */
    double radius_m, excess_k, away_m;
    uint32_t id;
};

/* Around what a model's node of this name holds; false: it has none. */
static bool node_box(const struct pel_model *m, const char *name,
                     struct pel_vec3 *low, struct pel_vec3 *high)
{
    *low = (struct pel_vec3){ INFINITY, INFINITY, INFINITY };
    *high = pel_vec3_scale(*low, -1);
    for (size_t i = 0; i < m->levels[0].part_count; i++) {
        const struct pel_model_part *p = &m->levels[0].parts[i];
        for (uint32_t k = 0;
             strcmp(m->nodes[p->node], name) == 0 && k < p->count; k++) {
            const float *v = m->vertices[m->indices[p->first + k]].position;
            *low = (struct pel_vec3){ fmin(low->x, (double)v[0]),
                                      fmin(low->y, (double)v[1]),
                                      fmin(low->z, (double)v[2]) };
            *high = (struct pel_vec3){ fmax(high->x, (double)v[0]),
                                       fmax(high->y, (double)v[1]),
                                       fmax(high->z, (double)v[2]) };
        }
    }
    return high->x >= low->x;
}

static bool has_engine(const struct pel_model *m)
{
    return m->class > PEL_MODEL_OTHER && m->class < PEL_MODEL_ROWING_BOAT &&
           m->class != PEL_MODEL_SAILING_YACHT;
}

/* The top of a funnel, or the transom, where engines are outboard or cooled by
 * wet exhausts. */
static bool find_spot(const struct pel_object *o, struct spot *out)
{
    struct pel_vec3 low, high, at;
    if (!has_engine(o->model)) {
        return false;
    }
    if (node_box(o->model, "funnel", &low, &high)) {
        at = (struct pel_vec3){ 0.5 * (low.x + high.x), 0.5 * (low.y + high.y),
                                high.z };
        out->radius_m = 0.6 * fmax(high.x - low.x, high.y - low.y);
        out->excess_k = FUNNEL_K;
    } else {
        at = (struct pel_vec3){ o->model->low.x, 0, 0.3 };
        out->radius_m = fmin(0.3 * o->model->beam_m, 2.0);
        out->excess_k = TRANSOM_K;
    }
    out->id = o->id;
    out->at = pel_mat3_apply(&o->world_from_model, at);
    return true;
}

/* The nearest to the eye, in a fixed order. */
static int find_spots(const struct pel_environment *env,
                      const struct pel_camera *c,
                      struct spot out[PEL_SENSE_SPOTS])
{
    int count = 0;
    for (size_t i = 0; i < env->object_count; i++) {
        const struct pel_object *o = &env->objects[i];
        struct spot s;
        if (!find_spot(o, &s)) {
            continue;
        }
        double east = o->east_m - c->east_m, north = o->north_m - c->north_m;
        s.at.x += east;
        s.at.y += north;
        s.at.z += o->altitude_m - env->sea_level_m - c->altitude_m -
                  (east * east + north * north) / (2 * PEL_EARTH_RADIUS);
        s.away_m = hypot(east, north);
        int k = count < PEL_SENSE_SPOTS ? count++ : PEL_SENSE_SPOTS;
        for (; k > 0 && s.away_m < out[k - 1].away_m; k--) {
            if (k < PEL_SENSE_SPOTS) {
                out[k] = out[k - 1];
            }
        }
        if (k < PEL_SENSE_SPOTS) {
            out[k] = s;
        }
    }
    return count;
}

/* --- the pass ------------------------------------------------------------- */

struct numbers {
    float v[PEL_SENSE_ALL][4];
};

static void put(float to[4], double x, double y, double z, double w)
{
    to[0] = (float)x;
    to[1] = (float)y;
    to[2] = (float)z;
    to[3] = (float)w;
}

static void fill_heat(const struct pel_environment *env,
                      const struct pel_camera *c, struct numbers *out)
{
    const struct pel_sensor *s = &c->sensor;
    struct pel_thermal_air air =
        pel_thermal_air(s->air_k, s->humidity, env->visibility_m, s->cloud);
    const struct pel_vec3 sun = env->lights[0].direction;
    double sunned = pel_thermal_sunned(
        sun.z, env->lights[0].body == PEL_LIGHT_SUN, env->wind_mps);
    double low = s->low_k, span = s->span_k;
    if (span <= 0) {
        low = pel_thermal_temperature(pel_thermal_sky(&air, 0.15)) - 1;
        low = fmin(low, fmin(s->sea_k, s->air_k) - SUN_LEAST_K);
        span = fmax(s->sea_k, s->air_k) + fmax(sunned, SUN_LEAST_K) - low;
    }
    put(out->v[0], pel_thermal_radiance(s->sea_k),
        pel_thermal_radiance(s->air_k), air.zenith,
        env->no_air ? 0 : air.extinction);
    put(out->v[1], low, 1 / span, s->netd_k, s->air_k);
    put(out->v[2], sun.x, sun.y, sun.z, sunned);
    struct spot spots[PEL_SENSE_SPOTS];
    int count = find_spots(env, c, spots);
    for (int i = 0; i < count; i++) {
        float(*to)[4] = &out->v[PEL_SENSE_UNIFORMS + 2 * i];
        put(to[0], spots[i].at.x, spots[i].at.y, spots[i].at.z,
            spots[i].radius_m);
        put(to[1], spots[i].id + 1.0, spots[i].excess_k, 0, 0);
    }
}

/* Exposed light is that of a grey spectrum which gives as many photons. */
static void fill_photons(const struct pel_camera *c, struct numbers *out)
{
    static const float screens[][3] = { { 1, 1, 1 },
                                        { 0.30F, 1.00F, 0.36F },
                                        { 0.90F, 0.97F, 1.00F } };
    double n[3], m[9];
    pel_lowlight_photons(c->sensor.exposure_s, c->sensor.f_number, n);
    pel_colour_matrix(1.0, m);
    double light = 0.2126 * (m[0] + m[1] + m[2]) +
                   0.7152 * (m[3] + m[4] + m[5]) +
                   0.0722 * (m[6] + m[7] + m[8]);
    put(out->v[0], n[0], n[1], n[2], light / (n[0] + n[1] + n[2]));
    const float *screen = screens[c->sensor.phosphor];
    memcpy(out->v[1], screen, sizeof screens[0]);
}

void pel_sensing_run(struct pel_sensing *s, const struct pel_programs *programs,
                     const struct pel_environment *env,
                     const struct pel_camera *c, const GLuint *planes)
{
    struct numbers numbers = { 0 };
    pel_program_use(s->programs[programs->light][is_thermal(c)]);
    if (is_thermal(c)) {
        fill_heat(env, c, &numbers);
        glBindTextureUnit(PEL_UNIT_SENSE_ROUGH, s->rough);
        glBindTextureUnit(PEL_UNIT_SENSE_HEAT, s->heats);
        for (GLuint i = 0; i < PEL_SENSE_PLANES; i++) {
            glBindTextureUnit(PEL_UNIT_SENSE_PLANES + i, planes[of_heat[i]]);
        }
    } else {
        fill_photons(c, &numbers);
        glBindTextureUnit(PEL_UNIT_RADIANCE, planes[PEL_AT_RADIANCE]);
    }
    glUniform4fv(0, PEL_SENSE_ALL, numbers.v[0]);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    for (GLuint i = 0; i < PEL_SENSE_PLANES; i++) {
        glBindTextureUnit(PEL_UNIT_SENSE_PLANES + i, 0);
    }
}
