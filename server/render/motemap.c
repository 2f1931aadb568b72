#include "render/motemap.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ocean/cascade.h"
#include "render/lampglow.h"
#include "render/shader.h"

#define SWAYS_SIGMAS 3.0 /* of waves, that particles are looked for */

bool pel_mote_map_shows(const struct pel_environment *env, unsigned layers)
{
    return env->motes.per_m3 > 0 &&
           layers & (PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
}

static void defines_of(const struct pel_environment *env,
                       const struct pel_programs *p, bool objects,
                       char out[512])
{
    snprintf(out, 512, "%s%s%s%s%s",
             env->sea->cascades ? "#define PEL_FFT\n" : "",
             pel_hardware_defines(p->software),
             objects ? "#define PEL_OBJECTS\n" : "",
             pel_lamp_glow_any_below(env) ? "#define PEL_LAMPS_BELOW\n" : "",
             pel_light_program_defines(env));
}

static GLuint *place_of(struct pel_mote_map *map, const char *defines)
{
    for (int i = 0; i < map->program_count; i++) {
        if (strcmp(map->programs[i].defines, defines) == 0) {
            return &map->programs[i].program;
        }
    }
    return NULL;
}

static enum pel_err need(struct pel_mote_map *map, const char *shader_dir,
                         const char *defines, struct pel_fault *fault)
{
    const int room = sizeof map->programs / sizeof *map->programs;
    GLuint program = 0;
    if (place_of(map, defines)) {
        return PEL_OK;
    }
    enum pel_err err = pel_program_create(shader_dir, "mote.vert", "mote.frag",
                                          defines, &program, fault);
    if (err != PEL_OK) {
        return err;
    }
    /* The oldest makes room. */
    if (map->program_count == room) {
        pel_program_delete(map->programs[0].program);
        memmove(map->programs, map->programs + 1,
                sizeof *map->programs * (size_t)(room - 1));
        map->program_count--;
    }
    struct pel_mote_program *to = &map->programs[map->program_count++];
    snprintf(to->defines, sizeof to->defines, "%s", defines);
    to->program = program;
    return PEL_OK;
}

enum pel_err pel_mote_map_need(struct pel_mote_map *map,
                               const struct pel_environment *env,
                               const struct pel_programs *p,
                               struct pel_fault *fault)
{
    if (!map->motes) {
        map->motes = malloc(sizeof *map->motes * PEL_MOTE_MOST);
        if (!map->motes) {
            return pel_fault_set(fault, PEL_ERR_NO_MEMORY,
                                 "no memory for particles in the water");
        }
        glCreateFramebuffers(1, &map->fbo);
        glCreateBuffers(1, &map->buffer);
        glObjectLabel(GL_BUFFER, map->buffer, -1, "particles");
    }
    char defines[512];
    defines_of(env, p, false, defines);
    enum pel_err err = need(map, p->shader_dir, defines, fault);
    if (err == PEL_OK && env->object_count) {
        defines_of(env, p, true, defines);
        err = need(map, p->shader_dir, defines, fault);
    }
    return err;
}

void pel_mote_map_finish(struct pel_mote_map *map)
{
    for (int i = 0; i < map->program_count; i++) {
        pel_program_delete(map->programs[i].program);
    }
    glDeleteFramebuffers(1, &map->fbo);
    glDeleteBuffers(1, &map->buffer);
    free(map->motes);
    *map = (struct pel_mote_map){ 0 };
}

/* How the waves of each cascade fall with depth, so that their variance does as
 * that of its modes at this one. [1/m] */
static void falls_of(const struct pel_cascades *c, double deep_m,
                     double falls[PEL_CASCADES])
{
    double before[PEL_CASCADES] = { 0 }, after[PEL_CASCADES] = { 0 };
    for (int i = 0; i + 1 < PEL_CASCADE_BOUNDS; i++) {
        double k = exp(c->log_k0 + c->step * (i + 0.5));
        double m0 = c->beyond[i].m0 - c->beyond[i + 1].m0;
        int of = 0;
        while (of + 1 < PEL_CASCADES && k >= c->cascade[of].k_hi) {
            of++;
        }
        before[of] += m0;
        after[of] += m0 * exp(-2.0 * k * deep_m);
    }
    for (int i = 0; i < PEL_CASCADES; i++) {
        falls[i] = after[i] > 0 ? log(before[i] / after[i]) / (2.0 * deep_m)
                                : c->cascade[i].k_lo;
    }
}

/* Variance of the height of the water that rests so deep. [m²] */
static double variance_at(const struct pel_sea *sea, double deep_m)
{
    double sum = 0;
    if (sea->cascades) {
        double falls[PEL_CASCADES];
        falls_of(sea->cascades, deep_m, falls);
        for (int i = 0; i < PEL_CASCADES; i++) {
            sum += sea->cascades->cascade[i].m0 * exp(-2.0 * falls[i] * deep_m);
        }
        return sum;
    }
    for (int i = 0; i < sea->count; i++) {
        const struct pel_wave *w = &sea->waves[i];
        sum += 0.5 * w->amplitude * w->amplitude *
               exp(-2.0 * hypot(w->kx, w->ky) * deep_m);
    }
    return sum;
}

static double deep_of(const struct pel_camera *c)
{
    return fmax(-c->altitude_m, 0.1);
}

struct pel_mote_view pel_mote_map_view(const struct pel_environment *env,
                                       const struct pel_camera *c,
                                       double extinction)
{
    return (struct pel_mote_view){
        .eye = { c->east_m, c->north_m, c->altitude_m },
        .world_from_camera = c->world_from_camera,
        .tan_left = c->tan_left,
        .tan_right = c->tan_right,
        .tan_bottom = c->tan_bottom,
        .tan_top = c->tan_top,
        .pixel_rad = (c->tan_right - c->tan_left) / c->width,
        .extinction = extinction,
        .sways_m = SWAYS_SIGMAS * sqrt(variance_at(env->sea, deep_of(c))),
        .wind_to_rad = env->wind_to_rad,
        .time_s = env->time_s,
        .seed = env->sea->desc.seed,
    };
}

/* Middles may lie beyond the edges. */
static void over_more(const struct pel_block_view *v)
{
    GLsizei w = (GLsizei)v->size.x, h = (GLsizei)v->size.y;
    glViewport(-PEL_MOTE_MARGIN, -PEL_MOTE_MARGIN, w + 2 * PEL_MOTE_MARGIN,
               h + 2 * PEL_MOTE_MARGIN);
    glScissor(0, 0, w, h);
}

void pel_mote_map_put(struct pel_mote_map *map,
                      const struct pel_environment *env,
                      const struct pel_programs *p, const struct pel_camera *c,
                      double extinction, const struct pel_block_view *v,
                      bool objects, const struct pel_targets *targets)
{
    const struct pel_mote_view seen = pel_mote_map_view(env, c, extinction);
    size_t count =
        pel_motes_seen(&env->motes, &seen, map->motes, PEL_MOTE_MOST);
    if (count == 0) {
        return;
    }
    double falls[4] = { 0 };
    _Static_assert(PEL_CASCADES <= 4, "a vector");
    if (env->sea->cascades) {
        falls_of(env->sea->cascades, deep_of(c), falls);
    }
    char defines[512];
    defines_of(env, p, objects, defines);
    const GLuint *program = place_of(map, defines);
    glNamedBufferData(map->buffer, (GLsizeiptr)(count * sizeof *map->motes),
                      map->motes, GL_STREAM_DRAW);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_MOTES, map->buffer);
    glNamedFramebufferTexture(map->fbo, GL_COLOR_ATTACHMENT0,
                              targets->planes[PEL_AT_RADIANCE], 0);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, map->fbo);
    pel_program_use(program ? *program : 0);
    glUniform4f(0, (float)falls[0], (float)falls[1], (float)falls[2],
                (float)falls[3]);
    glUniform1f(1, (float)pel_mote_reach(&env->motes, &seen));
    over_more(v);
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_SCISSOR_TEST);
    glEnable(GL_PROGRAM_POINT_SIZE);
    glEnable(GL_BLEND);
    /* The fourth component says what a pixel shows. */
    glBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
    glDrawArrays(GL_POINTS, 0, (GLsizei)count);
    glDisable(GL_BLEND);
    glDisable(GL_PROGRAM_POINT_SIZE);
    glDisable(GL_SCISSOR_TEST);
    glViewport(0, 0, (GLsizei)v->size.x, (GLsizei)v->size.y);
}
