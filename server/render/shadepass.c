#include "render/shadepass.h"

#include <epoxy/gl.h>

#include "render/edges.h"
#include "render/objects.h"
#include "render/pass.h"
#include "render/rendererstate.h"
#include "render/shader.h"
#include "render/targets.h"
#include "render/tiles.h"

#define PIXEL_BARRIERS                                                         \
    (GL_FRAMEBUFFER_BARRIER_BIT | GL_PIXEL_BUFFER_BARRIER_BIT |                \
     GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT)

static GLuint program_of(const struct pel_sea_programs *p, unsigned tile,
                         enum pel_objects_known objects, enum pel_shading kind,
                         GLuint deep)
{
    unsigned coast = tile & PEL_TILE_COAST;
    bool near = objects && objects != PEL_OBJECTS_ALL;
    return near && coast == PEL_COAST_NONE ? p->near[objects][kind]
           : objects                       ? p->objects[coast][kind]
           : coast == PEL_COAST_LAND       ? p->coast[kind]
           : coast == PEL_COAST_BOTTOM     ? p->shallow[kind]
                                           : deep;
}

/* What objects can do to the sea of it. */
static enum pel_objects_known is_touched(unsigned tile)
{
    unsigned near = PEL_TILE_SHADED(tile) | PEL_TILE_MIRRORED(tile);
    bool one = (near & (near - 1)) == 0 && !(tile & PEL_TILE_COAST);
    return PEL_TILE_SHADED(tile) ? (one ? PEL_OBJECTS_ONE : PEL_OBJECTS_ALL)
           : near ? (one ? PEL_OBJECTS_ONE_MIRRORED : PEL_OBJECTS_MIRRORED)
                  : PEL_OBJECTS_UNKNOWN;
}

/* A run of tiles in the targets: from xy to before zw. At the picture's edges
 * it has the pixels beyond them that outlines need. */
static void rect_of(const struct pel_renderer *r, const struct pel_camera *c,
                    const struct pel_tile_run *run, GLint rect[4])
{
    const GLint m = r->margin;
    rect[0] = run->x > 0 ? run->x + m : 0;
    rect[1] = run->y > 0 ? run->y + m : 0;
    rect[2] = run->x + run->width + m;
    rect[3] = run->y + run->height + m;
    rect[2] += rect[2] == (GLint)c->width + m ? m : 0;
    rect[3] += rect[3] == (GLint)c->height + m ? m : 0;
}

static void keep_to(const GLint rect[4])
{
    glScissor(rect[0], rect[1], rect[2] - rect[0], rect[3] - rect[1]);
}

/* Distances of layers are sought along the sight, also beside their tile. */
static const struct pel_sea_programs *
programs_for(const struct pel_renderer *r, unsigned tile,
             const struct pel_sea_programs *p, enum pel_shading kind)
{
    bool still = r->still && tile & PEL_TILE_STILL && kind < PEL_SHADE_LAYERS;
    return still ? r->still : p;
}

static void shade_tiles(struct pel_renderer *r, const struct pel_camera *c,
                        const struct pel_sea_programs *all,
                        const struct pel_pass *pass)
{
    glEnable(GL_SCISSOR_TEST);
    for (struct pel_tile_run run = { 0 }; pel_tiles_next(r->tiles, c, &run);) {
        enum pel_objects_known objects =
            r->any_objects ? is_touched(run.tile) : PEL_OBJECTS_UNKNOWN;
        const struct pel_sea_programs *p =
            programs_for(r, run.tile, all, pass->kind);
        GLint rect[4];
        rect_of(r, c, &run, rect);
        keep_to(rect);
        pel_program_use(program_of(p, run.tile, objects, pass->kind,
                                   p->fragments[pass->kind]));
        pel_pass_use(pass);
        if (objects) {
            pel_objects_use(&r->objects, run.tile,
                            objects >= PEL_OBJECTS_ONE_MIRRORED);
        }
        glDepthFunc((run.tile & PEL_TILE_COAST) == PEL_COAST_LAND ? GL_ALWAYS
                                                                  : GL_LESS);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    glDisable(GL_SCISSOR_TEST);
}

static void dispatch_tiles(struct pel_renderer *r, const struct pel_camera *c,
                           const struct pel_sea_programs *p,
                           const struct pel_pass *pass, int wanted)
{
    for (struct pel_tile_run run = { 0 }; pel_tiles_next(r->tiles, c, &run);) {
        pel_program_use(program_of(
            p, run.tile, r->any_objects ? PEL_OBJECTS_ALL : PEL_OBJECTS_UNKNOWN,
            pass->kind, p->compute_program[pass->kind]));
        pel_pass_use(pass);
        if (r->any_objects) {
            pel_objects_use(&r->objects, run.tile, false);
        }
        glUniform1i(0, wanted);
        GLint rect[4];
        rect_of(r, c, &run, rect);
        glUniform4iv(1, 1, rect);
        glDispatchCompute(pel_groups(rect[2] - rect[0], PEL_GROUP_SIDE),
                          pel_groups(rect[3] - rect[1], PEL_GROUP_SIDE), 1);
    }
}

/* Pixels without a sample of objects fail the test of depth. */
static void show_samples_only(struct pel_renderer *r, GLuint fbo)
{
    glNamedFramebufferTexture(fbo, GL_DEPTH_ATTACHMENT,
                              r->objects.samples.shown, 0);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
}

static void show_all(struct pel_renderer *r, GLuint fbo)
{
    glDisable(GL_DEPTH_TEST);
    glNamedFramebufferTexture(fbo, GL_DEPTH_ATTACHMENT, r->targets.depth_test,
                              0);
}

static void shade_objects(struct pel_renderer *r, const struct pel_camera *c,
                          const struct pel_pass *pass, bool sampled, bool fft)
{
    GLuint fbo = pel_targets_attach(&r->targets, pass);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, fbo);
    if (sampled) {
        show_samples_only(r, fbo);
    }
    glEnable(GL_SCISSOR_TEST);
    for (struct pel_tile_run run = { 0 }; pel_tiles_next(r->tiles, c, &run);) {
        if (run.tile & PEL_TILE_OBJECTS) {
            GLint rect[4];
            rect_of(r, c, &run, rect);
            keep_to(rect);
            pel_program_use(pel_objects_program(&r->objects, sampled, run.tile,
                                                pass->kind, fft));
            pel_pass_use(pass);
            glDrawArrays(GL_TRIANGLES, 0, 3);
        }
    }
    glDisable(GL_SCISSOR_TEST);
    show_all(r, fbo);
}

/* Objects over what is behind them: their light by the share of each pixel that
 * they cover, other layers where its middle shows one. */
static void put_objects(struct pel_renderer *r, const struct pel_camera *c,
                        const struct pel_sea_programs *p,
                        const struct pel_pass *pass)
{
    const struct pel_sea_programs *first = r->programs.seas;
    bool fft = (p - first) % 2 == 1;
    struct pel_pass light;
    glDisable(GL_DEPTH_TEST);
    if (pel_pass_light(pass, &light)) {
        glEnable(GL_BLEND);
        /* The fourth component keeps the part that shows none. */
        glBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO,
                            GL_ONE_MINUS_SRC_ALPHA);
        shade_objects(r, c, &light, true, fft);
        glDisable(GL_BLEND);
    }
    if (pel_pass_rest(pass, &light)) {
        shade_objects(r, c, &light, false, fft);
    }
}

/* Sea where the surface was drawn, sky where it was not: the depth test
 * separates them before a pixel is shaded. In tiles with a coast the program
 * decides. */
static void shade(struct pel_renderer *r, const struct pel_camera *c,
                  const struct pel_disc_box *discs,
                  const struct pel_sea_programs *p, const struct pel_pass *pass)
{
    enum pel_shading kind = pass->kind;
    const int backdrop = pel_programs_backdrop(&r->programs, kind);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER,
                      pel_targets_attach(&r->targets, pass));
    glEnable(GL_DEPTH_TEST);
    glBindTextureUnit(PEL_UNIT_TRIANGLES, r->targets.triangles);
    glDepthFunc(GL_EQUAL);
    pel_program_use(r->programs.backdrop[r->programs.look][backdrop]);
    pel_pass_use(pass);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    for (int i = 0; i < PEL_LIGHTS; i++) {
        if (discs[i].width > 0 && discs[i].height > 0) {
            glEnable(GL_SCISSOR_TEST);
            glScissor(discs[i].x, discs[i].y, discs[i].width, discs[i].height);
            pel_program_use(r->programs.disc[r->programs.look][backdrop]);
            pel_pass_use(pass);
            glDrawArrays(GL_TRIANGLES, 0, 3);
            glDisable(GL_SCISSOR_TEST);
        }
    }
    glDepthFunc(GL_LESS);
    if (r->any_objects) {
        glDepthRangef(PEL_HIDDEN_DEPTH, PEL_HIDDEN_DEPTH);
    }
    if (r->any_coast || r->any_objects || r->still) {
        shade_tiles(r, c, p, pass);
    } else {
        pel_program_use(p->fragments[kind]);
        pel_pass_use(pass);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    glDepthRangef(0.0f, 1.0f);
    glDisable(GL_DEPTH_TEST);
}

bool pel_shade_tones(const struct pel_renderer *r, unsigned asked)
{
    const struct pel_pass pass = pel_pass_first(asked, r->programs.compute);
    return r->programs.compute
               ? asked & PEL_LAYER_COLOR
               : pass.kind == PEL_SHADE_COLOR || pass.kind == PEL_SHADE_BOTH;
}

bool pel_shade_middles(unsigned asked)
{
    return pel_layers_stored(asked) &
           ~(pel_layers_of_light() | PEL_LAYER_COLOR);
}

void pel_shade_box(const struct pel_renderer *r, const struct pel_camera *c,
                   GLint box[4])
{
    GLint low[2] = { (GLint)c->width, (GLint)c->height }, high[2] = { 0, 0 };
    for (struct pel_tile_run run = { 0 }; pel_tiles_next(r->tiles, c, &run);) {
        GLint rect[4];
        rect_of(r, c, &run, rect);
        for (int i = 0; i < 2 && run.tile & PEL_TILE_OBJECTS; i++) {
            low[i] = rect[i] < low[i] ? rect[i] : low[i];
            high[i] = rect[2 + i] > high[i] ? rect[2 + i] : high[i];
        }
    }
    for (int i = 0; i < 2; i++) {
        bool any = high[i] > low[i];
        box[i] = any ? low[i] : 0;
        box[2 + i] = any ? high[i] : 0;
    }
}

static void bind_images(struct pel_renderer *r, const struct pel_pass *pass)
{
    glBindImageTexture(PEL_IMAGE_COLOR, r->targets.color, 0, GL_FALSE, 0,
                       GL_WRITE_ONLY, GL_RGBA8);
    glBindImageTexture(PEL_IMAGE_RADIANCE, r->targets.planes[PEL_AT_RADIANCE],
                       0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    for (GLuint i = 0; i < PEL_COMPUTE_SLOTS && pass->layer[i] >= 0; i++) {
        glBindImageTexture(PEL_IMAGE_SLOTS + i,
                           r->targets.planes[pass->layer[i]], 0, GL_FALSE, 0,
                           GL_WRITE_ONLY, pel_plane_format(pass->layer[i]));
    }
}

/* Sky, sea, display colour and layers in one dispatch. */
static void shade_compute(struct pel_renderer *r, const struct pel_camera *c,
                          const struct pel_sea_programs *p,
                          const struct pel_pass *pass, int wanted)
{
    bind_images(r, pass);
    if (r->any_coast || r->any_objects) {
        dispatch_tiles(r, c, p, pass, wanted);
    } else {
        pel_program_use(p->compute_program[pass->kind]);
        pel_pass_use(pass);
        glUniform1i(0, wanted);
        const GLint width = (GLint)c->width + 2 * r->margin;
        const GLint height = (GLint)c->height + 2 * r->margin;
        glUniform4i(1, 0, 0, width, height);
        glDispatchCompute(pel_groups(width, PEL_GROUP_SIDE),
                          pel_groups(height, PEL_GROUP_SIDE), 1);
    }
    glMemoryBarrier(PIXEL_BARRIERS);
}

/* Once all is shaded, margins too. */
static void mix_edges(struct pel_renderer *r, const struct pel_camera *c,
                      unsigned asked, bool toned)
{
    const GLint m = r->margin;
    const GLint region[4] = { m, m, m + (GLint)c->width, m + (GLint)c->height };
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    pel_edges_list(&r->programs, &r->targets, r->mesh, pel_edges_sideways(c),
                   region);
    pel_edges_mix(&r->programs, &r->targets, asked, toned);
    glMemoryBarrier(PIXEL_BARRIERS);
}

/* `added`: the light has the lamps. */
static void begin_tone(struct pel_renderer *r, GLuint light, bool added)
{
    glBindTextureUnit(PEL_UNIT_RADIANCE, light);
    glDisable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, r->targets.color_fbo);
    pel_program_use(r->programs.lamps ? r->lamps.tone[added][r->programs.light]
                                      : r->programs.tone);
}

/* Once more where objects went over what was toned at once. */
static void tone_objects(struct pel_renderer *r, const struct pel_camera *c)
{
    begin_tone(r, r->targets.planes[PEL_AT_RADIANCE], false);
    show_samples_only(r, r->targets.color_fbo);
    glEnable(GL_SCISSOR_TEST);
    for (struct pel_tile_run run = { 0 }; pel_tiles_next(r->tiles, c, &run);) {
        if (run.tile & PEL_TILE_OBJECTS) {
            GLint rect[4];
            rect_of(r, c, &run, rect);
            keep_to(rect);
            glDrawArrays(GL_TRIANGLES, 0, 3);
        }
    }
    glDisable(GL_SCISSOR_TEST);
    show_all(r, r->targets.color_fbo);
}

void pel_shade_fragments(struct pel_renderer *r, const struct pel_camera *c,
                         const struct pel_disc_box *discs,
                         const struct pel_sea_programs *p, unsigned asked)
{
    struct pel_pass pass = pel_pass_first(asked, false);
    const bool toned = pel_shade_tones(r, asked);
    if (r->any_objects) {
        GLint box[4];
        pel_shade_box(r, c, box);
        pel_samples_hide(&r->objects.samples, r->targets.surface_fbo, box,
                         pel_shade_middles(asked));
        glViewport(0, 0, (GLsizei)c->width + 2 * r->margin,
                   (GLsizei)c->height + 2 * r->margin);
    }
    do {
        shade(r, c, discs, p, &pass);
        if (r->any_objects) {
            put_objects(r, c, p, &pass);
        }
    } while (pel_pass_next(&pass, false));
    if (toned && r->any_objects) {
        tone_objects(r, c);
    }
    if (r->margin) {
        mix_edges(r, c, asked, toned);
    }
}

void pel_shade_dispatches(struct pel_renderer *r, const struct pel_camera *c,
                          const struct pel_sea_programs *p, unsigned asked)
{
    int wanted = asked & PEL_LAYER_RADIANCE ? PEL_WANTS_RADIANCE : 0;
    wanted |= asked & PEL_LAYER_COLOR ? PEL_WANTS_COLOR : 0;
    struct pel_pass pass = pel_pass_first(asked, true);
    do {
        /* Outlines read the keys after it. */
        int last = pass.last && !r->margin ? PEL_LAST_PASS : 0;
        shade_compute(r, c, p, &pass, (pass.first ? wanted : 0) | last);
    } while (pel_pass_next(&pass, true));
    if (r->margin) {
        mix_edges(r, c, asked, asked & PEL_LAYER_COLOR);
        pel_program_use(r->programs.clear_keys);
        glDispatchCompute(
            pel_groups((int)c->width + 2 * r->margin, PEL_GROUP_LINE),
            (GLuint)c->height + 2 * (GLuint)r->margin, 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
}

void pel_shade_tone(struct pel_renderer *r, const struct pel_camera *c,
                    GLuint light)
{
    begin_tone(r, light, true);
    glViewport(r->margin, r->margin, (GLsizei)c->width, (GLsizei)c->height);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void pel_shade_sense(struct pel_renderer *r, const struct pel_environment *env,
                     const struct pel_camera *c)
{
    glDisable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, r->targets.color_fbo);
    glViewport(r->margin, r->margin, (GLsizei)c->width, (GLsizei)c->height);
    pel_sensing_run(&r->sensing, &r->programs, env, c, r->targets.planes);
}
