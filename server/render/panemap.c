#include "render/panemap.h"

#include <math.h>

#include "render/shader.h"

/* Of drops that sit: side of their cells, radii, tangents; chance of a cell. */
static const struct {
    double side, least, most, chance;
} sitting[] = {
    { 0.013, 0.0014, 0.0036, 0.35 },
    { 0.028, 0.0030, 0.0075, 0.45 },
    { 0.065, 0.0080, 0.0210, 0.45 },
};
#define KINDS (int)(sizeof sitting / sizeof *sitting)
#define REACH 0.03 /* of drops beyond their cells, tangent */

bool pel_pane_map_shows(const struct pel_camera *c, unsigned layers)
{
    return c->wet_lens > 0 && layers & (PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
}

enum pel_err pel_pane_map_need(struct pel_pane_map *map,
                               const struct pel_environment *env,
                               const char *shader_dir, struct pel_fault *fault)
{
    GLuint *program = &map->programs[pel_light_program(env)];
    if (!map->fbo) {
        glCreateFramebuffers(1, &map->fbo);
    }
    return *program ? PEL_OK
                    : pel_program_create(shader_dir, "pane.vert", "pane.frag",
                                         pel_light_program_defines(env),
                                         program, fault);
}

void pel_pane_map_finish(struct pel_pane_map *map)
{
    glDeleteFramebuffers(1, &map->fbo);
    for (int i = 0; i < PEL_LIGHT_PROGRAMS; i++) {
        pel_program_delete(map->programs[i]);
    }
    *map = (struct pel_pane_map){ 0 };
}

/* Cells from first to before end. */
static void put_cells(const int first[2], const int end[2], double side)
{
    int columns = end[0] - first[0], rows = end[1] - first[1];
    if (columns > 0 && rows > 0) {
        glUniform4f(1, (float)first[0], (float)first[1], (float)columns,
                    (float)side);
        glDrawArrays(GL_TRIANGLES, 0, 6 * columns * rows);
    }
}

void pel_pane_map_put(struct pel_pane_map *map,
                      const struct pel_environment *env,
                      const struct pel_camera *c, GLuint light)
{
    const double low[2] = { c->tan_left - REACH, c->tan_bottom - REACH },
                 high[2] = { c->tan_right + REACH, c->tan_top + REACH };
    double lives = env->time_s / PEL_PANE_LIFE_S;
    lives -= 65536 * floor(lives / 65536);
    glNamedFramebufferTexture(map->fbo, GL_COLOR_ATTACHMENT0, light, 0);
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    /* The fourth component says what a pixel shows. */
    glBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, map->fbo);
    pel_program_use(map->programs[pel_light_program(env)]);
    glUniform4f(0, (float)c->wet_lens, (float)floor(lives),
                (float)(lives - floor(lives)), (float)(c->pane & 0xffffffU));
    for (int kind = 0; kind < KINDS; kind++) {
        const double side = sitting[kind].side;
        const int first[2] = { (int)floor(low[0] / side),
                               (int)floor(low[1] / side) },
                  end[2] = { (int)ceil(high[0] / side),
                             (int)ceil(high[1] / side) };
        glUniform4f(2, (float)sitting[kind].least, (float)sitting[kind].most,
                    (float)sitting[kind].chance, (float)(kind + 1));
        put_cells(first, end, side);
    }
    const int first[2] = { (int)floor(low[0] / PEL_PANE_RUN_WIDE), 0 },
              end[2] = { (int)ceil(high[0] / PEL_PANE_RUN_WIDE),
                         PEL_PANE_BEADS };
    glUniform4f(2, 0.0f, 0.0f, 1.0f, KINDS + 1.0f);
    put_cells(first, end, 0.0);
    glDisable(GL_BLEND);
}
