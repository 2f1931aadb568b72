#include "render/fallmap.h"

#include <math.h>
#include <stdio.h>

#include "optics/falling.h"
#include "render/shader.h"

bool pel_fall_map_shows(const struct pel_environment *env, unsigned layers)
{
    return (env->rain_mm_h > 0 || env->snow_mm_h > 0) &&
           layers & (PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
}

static int what_falls(const struct pel_environment *env)
{
    return env->rain_mm_h > 0 ? (env->snow_mm_h > 0 ? 2 : 0) : 1;
}

enum pel_err pel_fall_map_need(struct pel_fall_map *map,
                               const struct pel_environment *env,
                               const char *shader_dir, struct pel_fault *fault)
{
    const int kind = pel_light_program(env);
    const char *defines = pel_light_program_defines(env);
    enum pel_err err = PEL_OK;
    if (!map->fbo) {
        glCreateFramebuffers(1, &map->fbo);
    }
    GLuint *fallen = &map->fallen[what_falls(env)][kind];
    if (!*fallen) {
        char with[PEL_LIGHT_TEXT + 64];
        snprintf(with, sizeof with,
                 "%s#define PEL_DROPS %d\n#define PEL_FLAKES %d\n", defines,
                 env->rain_mm_h > 0 ? PEL_FALL_DROPS : 0,
                 env->snow_mm_h > 0 ? PEL_FALL_FLAKES : 0);
        err = pel_program_create(shader_dir, "screen.vert", "fallen.frag", with,
                                 fallen, fault);
    }
    if (err == PEL_OK && !map->falling[kind]) {
        err = pel_program_create(shader_dir, "falling.vert", "falling.frag",
                                 defines, &map->falling[kind], fault);
    }
    return err;
}

void pel_fall_map_finish(struct pel_fall_map *map)
{
    glDeleteFramebuffers(1, &map->fbo);
    for (int i = 0; i < PEL_LIGHT_PROGRAMS; i++) {
        for (int k = 0; k < 3; k++) {
            pel_program_delete(map->fallen[k][i]);
        }
        pel_program_delete(map->falling[i]);
    }
    *map = (struct pel_fall_map){ 0 };
}

static double shutter(const struct pel_camera *c)
{
    bool low_light = c->sensor.kind == PEL_SENSOR_ON &&
                     c->sensor.sense == PEL_SENSE_LOW_LIGHT;
    return low_light            ? c->sensor.exposure_s
           : c->shutter_s > 0.0 ? c->shutter_s
                                : PEL_FALL_SHUTTER_S;
}

/* Takes the mean of what follows out of the air's. */
static void put_mean(const struct pel_environment *env, GLuint program,
                     const struct pel_fall_plan *plan)
{
    GLfloat kinds[2 * PEL_FALL_KINDS][4] = { 0 };
    const int drops = env->rain_mm_h > 0 ? PEL_FALL_DROPS : 0,
              count = drops + (env->snow_mm_h > 0 ? PEL_FALL_FLAKES : 0);
    int next[2] = { 0, drops };
    for (int i = 0; i < plan->count; i++) {
        const struct pel_fall_kind *k = &plan->kinds[i];
        GLfloat(*to)[4] = &kinds[2 * next[k->flake]++];
        to[0][0] = (float)k->axis.x;
        to[0][1] = (float)k->axis.y;
        to[0][2] = (float)k->axis.z;
        to[0][3] = (float)k->covers;
        to[1][0] =
            (float)(k->extinction * (PEL_FALL_FARTHEST_M - PEL_FALL_NEAREST_M));
    }
    pel_program_use(program);
    glUniform4f(0, 0.0f, env->fall_bare, 0.0f, 0.0f);
    glUniform4fv(1, 2 * count, kinds[0]);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

/* Cells of the columns from first to before end. */
static void put_columns(const struct pel_fall_shell *s,
                        const struct pel_fall_range *range, double far_m,
                        int first, int end)
{
    /* Of the farthest column; one for where the first begins in its cell. */
    int rows =
        2 + (int)ceil(2 * s->near_m * (range->slope_last - range->slope_first) /
                      s->cell_m);
    if (end > first && range->slope_last > range->slope_first) {
        glUniform4f(5, (float)first, (float)rows, (float)range->slope_first,
                    (float)far_m);
        glDrawArrays(GL_TRIANGLES, 0, 6 * rows * (end - first));
    }
}

/* In the order of columns, whichever of them are seen: so tiles add up streaks
 * in the same order. */
static void put_shell(const struct pel_fall_shell *s,
                      const struct pel_fall_range *seen, double far_m,
                      bool bare)
{
    /* Beyond it the shell is too far away. */
    double steep = sqrt(fmax(pow(far_m / s->near_m, 2) - 1, 0));
    struct pel_fall_range range = *seen;
    range.slope_first = fmax(range.slope_first, -steep);
    range.slope_last = fmin(range.slope_last, steep);
    int first = (int)floor(range.turn_first * s->columns),
        count = (int)ceil(range.turns * s->columns) + 1;
    count = count < s->columns ? count : s->columns;
    int beyond = first + count - s->columns;
    glUniform4f(3, (float)s->near_m, (float)s->columns, (float)s->cell_m,
                (float)(s->seed & 0xffffffU));
    glUniform4f(4, (float)s->chance, (float)s->weight, (float)s->spread_m2,
                bare);
    put_columns(s, &range, far_m, 0, beyond);
    put_columns(s, &range, far_m, first,
                beyond > 0 ? s->columns : first + count);
}

static void put_kind(const struct pel_fall_kind *k, const struct pel_camera *c,
                     bool bare)
{
    struct pel_fall_range range =
        pel_fall_range(k, &c->world_from_camera, c->tan_left, c->tan_right,
                       c->tan_bottom, c->tan_top);
    glUniform4f(0, (float)k->axis.x, (float)k->axis.y, (float)k->axis.z,
                (float)(k->flake ? -k->diameter_m : k->diameter_m));
    glUniform4f(1, (float)k->side.x, (float)k->side.y, (float)k->side.z,
                (float)k->streak_m);
    glUniform4f(2, (float)floor(k->turn), (float)(k->turn - floor(k->turn)),
                (float)(k->past_mps * PEL_FALL_LIFE_S), 0.0f);
    for (int i = 0; i < k->shell_count; i++) {
        put_shell(&k->shells[i], &range, k->far_m, bare);
    }
}

void pel_fall_map_put(struct pel_fall_map *map,
                      const struct pel_environment *env,
                      const struct pel_camera *c,
                      const struct pel_block_view *view,
                      const struct pel_targets *targets)
{
    const int kind = pel_light_program(env);
    const struct pel_fall_desc desc = {
        .rain_mm_h = env->rain_mm_h,
        .snow_mm_h = env->snow_mm_h,
        .wind_mps = env->wind_mps,
        .wind_to_rad = env->wind_to_rad,
        .eye_mps = c->velocity_mps,
        .shutter_s = shutter(c),
        .time_s = env->time_s,
        .seed = env->sea->desc.seed,
        .pixel_rad = (double)view->pixel.x,
        .only = env->fall_only,
    };
    struct pel_fall_plan plan;
    pel_fall_plan(&desc, &plan);
    glNamedFramebufferTexture(map->fbo, GL_COLOR_ATTACHMENT0,
                              targets->planes[PEL_AT_RADIANCE], 0);
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    /* The fourth component says what a pixel shows. */
    glBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, map->fbo);
    put_mean(env, map->fallen[what_falls(env)][kind], &plan);
    pel_program_use(map->falling[kind]);
    for (int i = 0; i < plan.count; i++) {
        put_kind(&plan.kinds[i], c, env->fall_bare);
    }
    glDisable(GL_BLEND);
}
