#include "render/spacepass.h"

#include <stdio.h>

#include "render/pass.h"
#include "render/shader.h"
#include "render/targets.h"
#include "render/uniforms.h"

#define DEFINES 640

static void defines_of(struct pel_renderer *r,
                       const struct pel_environment *here,
                       enum pel_shading kind, bool disc, char out[DEFINES])
{
    char surface[PEL_SURFACE_TEXT];
    pel_programs_surface(&r->programs, here->sea, surface);
    snprintf(out, DEFINES, "%s%s%s%s%s%s%s%s", surface,
             pel_shading_defines(kind),
             here->lit > 1 ? "#define PEL_LIT 2\n" : "",
             here->night.on ? "#define PEL_NIGHT\n" : "",
             here->clouds.cover > 0 ? "#define PEL_SPACE_CLOUDS\n" : "",
             here->weather ? "#define PEL_SPACE_WINDS\n" : "",
             disc ? "#define PEL_DISCS 2\n" : "#define PEL_NO_DISC\n",
             pel_programs_foam(here->sea));
}

static GLuint program_of(struct pel_renderer *r,
                         const struct pel_environment *here,
                         enum pel_shading kind, bool disc,
                         struct pel_fault *fault)
{
    char defines[DEFINES];
    defines_of(r, here, kind, disc, defines);
    return pel_space_program(&r->space, r->shader_dir, defines, fault);
}

enum pel_err pel_space_need_view(struct pel_renderer *r,
                                 const struct pel_environment *env,
                                 double height_m, unsigned layers,
                                 struct pel_fault *fault)
{
    const struct pel_environment here = pel_space_environment(env, height_m);
    enum pel_err err = pel_space_need(&r->space, r->shader_dir, fault);
    if (err == PEL_OK) {
        err = pel_space_need_meter(&r->space, here.lit, here.weather,
                                   r->shader_dir, fault);
    }
    struct pel_pass pass = pel_pass_first(layers, false);
    do {
        for (int disc = 0; layers && disc < 2 && err == PEL_OK; disc++) {
            if (!program_of(r, &here, pass.kind, disc, fault)) {
                err = fault->code;
            }
        }
    } while (err == PEL_OK && pel_pass_next(&pass, false));
    return err;
}

/* What fog, and of a meter clouds, hide on average. */
static void veil(const struct pel_environment *env, bool clouds,
                 struct pel_block_space *block)
{
    const double mu = 0.6;
    double open = 1.0, shine = 0.0, depth = 0.0;
    for (int i = 0; i < env->fog_count; i++) {
        const struct pel_fog *f = &env->fog[i];
        depth += f->radius_m > 0 ? 0 : f->extinction * (f->top_m - f->base_m);
    }
    if (depth > 0) {
        open = exp(-depth / mu);
        shine = 1.0 - pel_cloud_through((1 - PEL_CLOUD_ASYMMETRY) * depth, mu);
    }
    if (clouds && env->clouds.cover > 0) {
        const struct pel_cloud_kind *kind = pel_cloud_kind(env->clouds.genus);
        double deep = 0.5 * kind->extinction * env->clouds.thickness_m;
        double bright =
            1.0 - pel_cloud_through((1 - PEL_CLOUD_ASYMMETRY) * deep, mu);
        shine = shine * (1 - env->clouds.cover) + bright * env->clouds.cover;
        open *= 1 - env->clouds.cover;
    }
    block->space_more.z = (float)(1.0 - open);
    block->space_more.w = (float)(open < 1.0 ? shine / (1.0 - open) : 0.0);
}

static void bind_frame(struct pel_renderer *r,
                       const struct pel_environment *env)
{
    struct pel_block_frame frame;
    pel_fill_frame(env, &frame);
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_FRAME, &frame,
                   sizeof frame);
}

/* Colours and the meter's level are those of light where it stands highest of
 * all that is seen. Returns the level, lx. */
static double bind_high_frame(struct pel_renderer *r,
                              const struct pel_environment *here,
                              const struct pel_space_geometry *g)
{
    struct pel_block_frame frame;
    struct pel_light highest[PEL_LIGHTS];
    double reach = g->whole * pel_space_reach(g), m[9];
    pel_fill_frame(here, &frame);
    for (int i = 0; i < PEL_LIGHTS; i++) {
        highest[i] = here->lights[i];
        double e = asin(pel_clamp(highest[i].direction.z, -1.0, 1.0));
        highest[i].direction.z = sin(fmin(e + reach, 0.5 * PEL_PI));
    }
    pel_lights_colours(highest, here->lit, here->night.on, m);
    struct pel_vec4 *row[3] = { &frame.red, &frame.green, &frame.blue };
    for (int i = 0; i < 3; i++) {
        row[i]->x = (float)m[3 * i];
        row[i]->y = (float)m[3 * i + 1];
        row[i]->z = (float)m[3 * i + 2];
    }
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_FRAME, &frame,
                   sizeof frame);
    return pel_lights_level(highest, here->lit, here->night.on);
}

static void begin(struct pel_renderer *r, const struct pel_environment *env,
                  const struct pel_camera *c, double height_m, bool meter)
{
    const struct pel_environment here = pel_space_environment(env, height_m);
    const struct pel_space_geometry g =
        pel_space_geometry_for(env, c, height_m);
    struct pel_block_space block;
    pel_space_continents(&r->space, env);
    double level = bind_high_frame(r, &here, &g);
    pel_fill_space(&r->space, &here, &g, &block);
    block.space_sun.w = (float)level;
    veil(&here, meter, &block);
    if (here.weather) {
        block.space_winds = pel_wind_map_place(&r->space.winds, &here);
        pel_wind_map_bind(&r->space.winds);
    }
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_SPACE, &block,
                   sizeof block);
    pel_space_bind(&r->space, &r->sky, &here, &block);
}

void pel_space_begin(struct pel_renderer *r, const struct pel_environment *env,
                     const struct pel_camera *c, double height_m)
{
    begin(r, env, c, height_m, false);
}

void pel_space_end(struct pel_renderer *r, const struct pel_environment *env)
{
    bind_frame(r, env);
}

void pel_space_expose(struct pel_renderer *r, const struct pel_environment *env,
                      const struct pel_camera *c, double height_m)
{
    const struct pel_environment here = pel_space_environment(env, height_m);
    const GLuint program =
        r->space.meter_program[here.weather != NULL][here.lit - 1];
    begin(r, env, c, height_m, true);
    pel_program_use(program);
    glUniform1f(0, (float)pel_space_share(env, height_m));
    pel_meter_use(&r->meter, program);
    pel_space_end(r, env);
}

static void draw(GLuint program, const struct pel_pass *pass)
{
    pel_program_use(program);
    pel_pass_use(pass);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static struct pel_environment here_of(const struct pel_environment *env,
                                      const struct pel_camera *whole)
{
    return pel_space_environment(env, fmax(whole->altitude_m, PEL_LEAST_EYE_M));
}

/* Which of the attachments of a pass are light, as bits. */
static unsigned of_light(const struct pel_pass *pass)
{
    unsigned bits = 1;
    for (int i = 0; i < PEL_FRAGMENT_SLOTS; i++) {
        int layer = pass->layer[i];
        if (layer >= 0 && pel_layers_of_light() & pel_layer_table[layer].bit) {
            bits |= 2u << i;
        }
    }
    return bits;
}

void pel_space_mix(struct pel_renderer *r, const struct pel_environment *env,
                   const struct pel_camera *whole, unsigned layers,
                   double share)
{
    const struct pel_environment here = here_of(env, whole);
    struct pel_fault fault;
    struct pel_pass pass = pel_pass_first(layers, false);
    glDisable(GL_DEPTH_TEST);
    glBlendColor(0, 0, 0, (float)share);
    do {
        const unsigned light = of_light(&pass);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER,
                          pel_targets_attach(&r->targets, &pass));
        for (GLuint i = 0; i <= PEL_FRAGMENT_SLOTS; i++) {
            const bool mixed = light >> i & 1;
            const GLboolean shown = mixed || share >= 0.5;
            (mixed ? glEnablei : glDisablei)(GL_BLEND, i);
            glColorMaski(i, shown, shown, shown, shown);
        }
        /* The radiance's fourth component stays the low form's. */
        glBlendFuncSeparate(GL_CONSTANT_ALPHA, GL_ONE_MINUS_CONSTANT_ALPHA,
                            GL_ZERO, GL_ONE);
        draw(program_of(r, &here, pass.kind, true, &fault), &pass);
    } while (pel_pass_next(&pass, false));
    glDisable(GL_BLEND);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

bool pel_space_shade(struct pel_renderer *r, const struct pel_environment *env,
                     const struct pel_camera *whole, struct pel_band band,
                     unsigned layers)
{
    const struct pel_environment here = here_of(env, whole);
    struct pel_fault fault;
    struct pel_pass pass = pel_pass_first(layers, false);
    bool toned = pass.kind == PEL_SHADE_COLOR || pass.kind == PEL_SHADE_BOTH;
    glDisable(GL_DEPTH_TEST);
    do {
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER,
                          pel_targets_attach(&r->targets, &pass));
        draw(program_of(r, &here, pass.kind, false, &fault), &pass);
        glEnable(GL_SCISSOR_TEST);
        for (int i = 0; i < here.discs; i++) {
            struct pel_disc_box box =
                pel_band_disc(whole, here.lights[i].direction,
                              pel_light_radius(&here.lights[i]), band);
            if (box.width > 0 && box.height > 0) {
                glScissor(box.x, box.y, box.width, box.height);
                draw(program_of(r, &here, pass.kind, true, &fault), &pass);
            }
        }
        glDisable(GL_SCISSOR_TEST);
    } while (pel_pass_next(&pass, false));
    return toned;
}
