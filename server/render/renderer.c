#include "render/renderer.h"

#include <epoxy/gl.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/log.h"
#include "render/acuity.h"
#include "render/arena.h"
#include "render/binaries.h"
#include "render/context.h"
#include "render/foammap.h"
#include "render/mesh.h"
#include "render/meter.h"
#include "render/objects.h"
#include "render/pass.h"
#include "render/probe.h"
#include "render/programs.h"
#include "render/readback.h"
#include "render/rendererstate.h"
#include "render/shader.h"
#include "render/sky.h"
#include "render/spacepass.h"
#include "render/stages.h"
#include "render/statistics.h"
#include "render/stilltiles.h"
#include "render/targets.h"
#include "render/texels.h"
#include "render/together.h"
#include "render/turn.h"
#include "render/uniforms.h"
#include "render/viewpass.h"
#include "render/waterprobe.h"
#include "render/wavefield.h"

void pel_renderer_measure(struct pel_renderer *r, bool on)
{
    r->timing.on = on;
}

void pel_renderer_stage_ms(const struct pel_renderer *r,
                           double ms[PEL_STAGE_COUNT])
{
    for (int i = 0; i < PEL_STAGE_COUNT; i++) {
        ms[i] = r->timing.ms[i];
    }
}

/* --- life ----------------------------------------------------------------- */

enum pel_err pel_renderer_create(const struct pel_renderer_options *o,
                                 struct pel_renderer **out,
                                 struct pel_fault *fault)
{
    struct pel_renderer *r = calloc(1, sizeof *r);
    if (!r) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    r->shader_dir = o->shader_dir;
    r->lose_after = o->lose_after;
    enum pel_err err =
        pel_filtering_settle(&o->filtering, &r->filtering, fault);
    if (err != PEL_OK) {
        goto fail;
    }
    r->filter = (struct pel_filter){ r->filtering.n_min, r->filtering.n_max };
    err = PEL_ERR_NO_MEMORY;
    r->mesh = calloc(1, sizeof *r->mesh);
    if (!r->mesh) {
        pel_fault_set(fault, err, "out of memory");
        goto fail;
    }
    err = pel_context_init(&r->context, o->device, o->debug, fault);
    if (err != PEL_OK) {
        goto fail;
    }
    r->wavefield.on_processor = r->context.software;
    /* Software compiles what it draws with first; and after a loss there are
     * binaries. */
    if (!r->context.software && !pel_binaries_any()) {
        pel_program_side_by_side();
    }
    pel_turn_count(!r->context.software);
    glCreateVertexArrays(1, &r->vao);
    glBindVertexArray(r->vao);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    pel_sea_texels_init(&r->tables);
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &r->vertex_texels);
    pel_stage_timer_init(&r->timing, r->context.software);
    err = pel_readback_init(&r->readback);
    if (err == PEL_OK) {
        err = pel_arena_init(&r->arena, 4 * PEL_VIEW_UNIFORM_BYTES);
    }
    if (err != PEL_OK) {
        pel_fault_set(fault, err, "no memory for the frame's buffers");
        goto fail;
    }
    err = pel_sky_init(&r->sky, r->shader_dir, fault);
    pel_programs_init(&r->programs, r->shader_dir, r->context.software,
                      o->shading, &r->filtering);
    pel_meter_init(&r->meter);
    if (err != PEL_OK) {
        goto fail;
    }
    *out = r;
    return PEL_OK;
fail:
    pel_renderer_destroy(r);
    return err;
}

/* What the device holds, piece by piece. */
static void give_back(struct pel_renderer *r, void (*rest)(void *), void *user)
{
#define GIVE(call) ((call), rest(user))
    while (pel_readback_give_one(&r->readback)) {
        rest(user);
    }
    GIVE(pel_readback_finish(&r->readback));
    GIVE(pel_arena_finish(&r->arena));
    GIVE(pel_sky_finish(&r->sky));
    GIVE(pel_space_map_finish(&r->space));
    GIVE(pel_targets_finish(&r->targets));
    GIVE(pel_programs_finish(&r->programs));
    GIVE(pel_meter_finish(&r->meter));
    GIVE(pel_together_finish(&r->together));
    GIVE(pel_ycbcr_finish(&r->ycbcr));
    GIVE(pel_sensing_finish(&r->sensing));
    GIVE(pel_prober_finish(&r->prober));
    GIVE(pel_water_prober_finish(&r->water_prober));
    GIVE(pel_objects_finish(&r->objects));
    GIVE(pel_seabed_map_finish(&r->seabed));
    GIVE(pel_wavefield_finish(&r->wavefield));
    GIVE(pel_foam_map_finish(&r->foam));
    GIVE(pel_cloud_map_finish(&r->clouds));
    GIVE(pel_fall_map_finish(&r->falls));
    GIVE(pel_pane_map_finish(&r->panes));
    GIVE(pel_lamp_map_finish(&r->lamps));
    GIVE(pel_lamp_glow_finish(&r->glows));
    GIVE(pel_acuity_finish(&r->acuity));
    GIVE(pel_under_map_finish(&r->under));
    GIVE(pel_mote_map_finish(&r->motes));
    GIVE(pel_wake_map_finish(&r->wakes));
    GIVE(pel_shore_map_finish(&r->shore));
    GIVE(glDeleteBuffers(1, &r->vertices));
    GIVE(glDeleteTextures(1, &r->vertex_texels));
    GIVE(pel_sea_texels_finish(&r->tables));
    GIVE(glDeleteVertexArrays(1, &r->vao));
    GIVE(pel_stage_timer_finish(&r->timing));
#undef GIVE
}

void pel_renderer_leave(struct pel_renderer *r, void (*rest)(void *),
                        void *user)
{
    if (!r) {
        return;
    }
    const bool counted = r->context.context && !r->context.software;
    if (r->context.context) {
        give_back(r, rest, user);
    }
    pel_context_finish(&r->context);
    pel_turn_count(-counted); /* not before: its memory goes by the driver */
    free(r->mesh);
    free(r);
}

static void no_rest(void *user)
{
    (void)user;
}

void pel_renderer_destroy(struct pel_renderer *r)
{
    pel_renderer_leave(r, no_rest, NULL);
}

const char *pel_renderer_description(const struct pel_renderer *r)
{
    return r->context.description;
}
bool pel_renderer_is_software(const struct pel_renderer *r)
{
    return r->context.software;
}

/* --- a frame -------------------------------------------------------------- */

static void bind_table_eye(void *user, double height_m)
{
    struct pel_renderer *r = user;
    struct pel_block_eye block;
    pel_fill_eye(height_m, height_m, NULL, &block);
    if (r->env) {
        pel_fill_cloud_eye(r->env, r->env->clouds_x_m, r->env->clouds_y_m,
                           &block);
        pel_fill_fog_own(r->env, &block);
    }
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_EYE, &block,
                   sizeof block);
}

/* --- a frame's needs ------------------------------------------------------ */

unsigned pel_renderer_programs(void)
{
    return pel_program_count();
}

bool pel_renderer_in_compute(const struct pel_renderer *r)
{
    return r->programs.compute;
}

static void order_lights(struct pel_environment *env)
{
    struct pel_lights_shown shown = pel_lights_order(env->lights);
    env->lit = shown.lit;
    env->discs = shown.discs;
    for (int i = 0; i < PEL_LIGHTS; i++) {
        env->lights[i].direction = pel_sky_quantize(env->lights[i].direction);
    }
}

/* The height field and the light in the water, which *env may have to do
 * without. */
static enum pel_err fit_water(struct pel_renderer *r,
                              struct pel_environment *env)
{
    enum pel_err err = pel_seabed_map_fit(&r->seabed, env->seabed);
    if (err == PEL_OK && env->seabed) {
        env->depths = pel_seabed_depths(env);
    }
    return err == PEL_OK ? pel_water_light_update(&r->sky.water, env) : err;
}

static void bind_frame(struct pel_renderer *r,
                       const struct pel_environment *env)
{
    struct pel_block_frame frame;
    pel_fill_frame(env, &frame);
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_FRAME, &frame,
                   sizeof frame);
}

/* Fragments without a coast draw discs by programs of their own. */
static enum pel_programs_light light_of(const struct pel_renderer *r,
                                        const struct pel_environment *env,
                                        bool cameras)
{
    bool with_sea = r->programs.compute || env->seabed;
    int night = !with_sea       ? 0
                : env->panorama ? PEL_LIGHT_PANORAMA
                : env->night.on ? PEL_LIGHT_NIGHT
                                : 0;
    return pel_light_veils(env) + night + (cameras ? PEL_LIGHT_CAMERAS : 0) +
           (env->lit > 1                 ? PEL_LIGHT_TWO
            : env->discs > 1 && with_sea ? PEL_LIGHT_ONE_AND_DISC
                                         : PEL_LIGHT_ONE);
}

static enum pel_err need_light(struct pel_renderer *r,
                               const struct pel_environment *env,
                               struct pel_fault *fault)
{
    enum pel_err err = pel_sky_need(&r->sky, env, r->shader_dir, fault);
    return err ? err
               : pel_cloud_map_need(&r->clouds, env, r->shader_dir, fault);
}

/* What an eye that water may reach wants more. */
static enum pel_err need_under(struct pel_renderer *r,
                               const struct pel_environment *env,
                               unsigned layers, struct pel_fault *fault)
{
    enum pel_err err =
        pel_meter_need(&r->meter, env, true, r->shader_dir, fault);
    if (err == PEL_OK) {
        err = pel_under_map_need(&r->under, env, &r->programs, PEL_SHADE_LIGHT,
                                 fault);
    }
    if (err == PEL_OK && pel_mote_map_shows(env, layers)) {
        err = pel_mote_map_need(&r->motes, env, &r->programs, fault);
    }
    struct pel_pass pass = pel_pass_first(layers, false);
    do {
        if (err == PEL_OK) {
            err = pel_under_map_need(&r->under, env, &r->programs, pass.kind,
                                     fault);
        }
        if (err == PEL_OK && env->object_count) {
            err = pel_objects_need(&r->objects, env, &r->programs, pass.kind,
                                   fault);
        }
    } while (err == PEL_OK && pel_pass_next(&pass, false));
    return err;
}

static enum pel_err need_low(struct pel_renderer *r,
                             const struct pel_environment *env, unsigned layers,
                             struct pel_fault *fault)
{
    bool coast = env->seabed != NULL, objects = env->object_count > 0;
    enum pel_err err = PEL_OK;
    bool compute;
    do { /* once more where it turned to fragments meanwhile */
        compute = r->programs.compute;
        struct pel_pass pass = pel_pass_first(layers, compute);
        do {
            err = pel_programs_need(&r->programs, env->sea, pass.kind, coast,
                                    objects, fault);
            if (err == PEL_OK && pel_still_wanted(env, &r->programs)) {
                err = pel_programs_need_still(&r->programs, env->sea, pass.kind,
                                              coast, objects, fault);
            }
            if (err == PEL_OK && objects) {
                err = pel_objects_need(&r->objects, env, &r->programs,
                                       pass.kind, fault);
            }
        } while (err == PEL_OK && pel_pass_next(&pass, compute));
    } while (err == PEL_OK && compute != r->programs.compute);
    return err;
}

/* Above the sea's zero, of the eye and of its meter. */
static double eye_height(const struct pel_environment *env,
                         const struct pel_draw *draw)
{
    return fmax(draw->camera.altitude_m - env->sea_level_m, PEL_LEAST_EYE_M);
}

static double meter_height(const struct pel_environment *env,
                           const struct pel_draw *draw)
{
    const struct pel_camera *c = &draw->camera;
    return c->sight_count ? fmax(c->sights[0].altitude_m - env->sea_level_m,
                                 PEL_LEAST_EYE_M)
                          : eye_height(env, draw);
}

static bool any_high(const struct pel_environment *env,
                     const struct pel_draw *draws, size_t count)
{
    bool any = false;
    for (size_t i = 0; i < count; i++) {
        any |= pel_space_share(env, eye_height(env, &draws[i])) > 0 ||
               pel_space_share(env, meter_height(env, &draws[i])) > 0;
    }
    return any;
}

static enum pel_err need_view(struct pel_renderer *r,
                              const struct pel_environment *env,
                              const struct pel_draw *draw,
                              struct pel_fault *fault)
{
    const enum pel_ycbcr form = pel_view_ycbcr(r, draw);
    const bool planes = form != PEL_YCBCR_NONE;
    if (pel_together_can(r, env, draw)) {
        enum pel_err err = pel_together_need(r, env, draw, fault);
        if (err != PEL_OK || !r->together.off) {
            return err == PEL_OK && planes
                       ? pel_ycbcr_need(&r->ycbcr, true, form, r->shader_dir,
                                        fault)
                       : err;
        }
    }
    if (planes) {
        enum pel_err err =
            pel_ycbcr_need(&r->ycbcr, false, form, r->shader_dir, fault);
        if (err != PEL_OK) {
            return err;
        }
    }
    enum pel_err err =
        pel_meter_need(&r->meter, env, false, r->shader_dir, fault);
    if (err == PEL_OK) {
        err = pel_programs_need_alone(&r->programs, fault);
    }
    double height_m = eye_height(env, draw), meter_m = meter_height(env, draw);
    struct pel_camera here = draw->camera;
    here.altitude_m -= env->sea_level_m;
    const struct pel_lens_place lens = pel_lens_place(env, &here);
    const bool under = pel_lens_under(&lens);
    const double share = pel_space_share(env, height_m);
    const bool late = under || (share > 0 && share < 1);
    const unsigned all = pel_view_layers(r, env, draw, late);
    const unsigned layers = pel_view_at_once(env, draw, all, late);
    r->programs.above = pel_view_above_clouds(env, here.altitude_m);
    if (err == PEL_OK && share < 1) {
        err = need_low(r, env, layers, fault);
    }
    if (err == PEL_OK && share > 0) {
        err = pel_space_need_view(r, env, height_m, layers, fault);
    }
    if (err == PEL_OK && pel_space_share(env, meter_m) > 0) {
        err = pel_space_need_view(r, env, meter_m, 0, fault);
    }
    if (err == PEL_OK) {
        err = pel_sensing_need(&r->sensing, &r->programs, &draw->camera, fault);
    }
    if (err == PEL_OK) {
        err = pel_lamp_map_need(&r->lamps, &r->programs, env, fault);
    }
    if (err == PEL_OK && pel_acuity_border(env, &draw->camera, draw->layers)) {
        err = pel_acuity_need(&r->acuity, r->shader_dir, fault);
    }
    if (err == PEL_OK && pel_fall_map_shows(env, all)) {
        err = pel_fall_map_need(&r->falls, env, r->shader_dir, fault);
    }
    if (err == PEL_OK && pel_pane_map_shows(&draw->camera, all)) {
        err = pel_pane_map_need(&r->panes, env, r->shader_dir, fault);
    }
    if (err == PEL_OK && under) {
        err = need_under(r, env, layers, fault);
    }
    return err == PEL_OK && pel_view_edges(r, &draw->camera)
               ? pel_programs_need_edges(&r->programs, fault)
               : err;
}

#define EYES_NS 30000000000LL /* programs for them stay in use */

/* Whether all views are cameras', and were for a while: who looks now and then
 * as an eye does not have programs made anew each time. */
static bool only_cameras(struct pel_renderer *r, const struct pel_draw *draws,
                         size_t count)
{
    int64_t now_ns = pel_now_ns();
    for (size_t i = 0; i < count; i++) {
        const struct pel_camera *c = &draws[i].camera;
        if (c->vision != PEL_VISION_CAMERA ||
            c->sensor.kind != PEL_SENSOR_NONE) {
            r->eyes_until_ns = now_ns + EYES_NS;
        }
    }
    return r->programs.software && now_ns >= r->eyes_until_ns;
}

static enum pel_err need_programs(struct pel_renderer *r,
                                  const struct pel_environment *env,
                                  const struct pel_draw *draws, size_t count)
{
    struct pel_fault fault;
    r->programs.look = pel_sky_look(env);
    r->programs.wakes = env->wakes != NULL;
    r->programs.wash = env->wash != NULL;
    r->programs.lamps = env->lamp_count > 0;
    r->programs.storm = env->storm;
    enum pel_err err = pel_programs_take_light(
        &r->programs, light_of(r, env, only_cameras(r, draws, count)), &fault);
    if (err == PEL_OK) {
        err = need_light(r, env, &fault);
    }
    if (err == PEL_OK && env->sea->cascades) {
        err = pel_wavefield_need(&r->wavefield, r->shader_dir, &env->sea->desc,
                                 &fault);
    }
    if (err == PEL_OK && env->object_count) {
        err = pel_objects_fit(&r->objects, env, &r->programs, &fault);
    }
    for (size_t i = 0; i < count && err == PEL_OK; i++) {
        err = need_view(r, env, &draws[i], &fault);
    }
    if (err == PEL_OK) {
        err = pel_program_settle(&fault);
    }
    if (err != PEL_OK) {
        pel_error("RND-040", "a view was not drawn: %s", fault.message);
    }
    return err;
}

/* What the views of a frame share, when their programs are there; on errors the
 * arena is given back. */
static enum pel_err begin_frame(struct pel_renderer *r,
                                struct pel_environment *here,
                                const struct pel_draw *draws, size_t count)
{
    enum pel_err err = pel_arena_begin(
        &r->arena, PEL_VIEW_UNIFORM_BYTES +
                       count * (pel_view_bytes(here) + pel_objects_bytes(here) +
                                pel_lamp_map_bytes(here)));
    if (err != PEL_OK) {
        return err;
    }
    for (int i = 0; i < PEL_STAGE_COUNT; i++) {
        r->timing.ms[i] = 0.0;
    }
    err = fit_water(r, here);
    if (err != PEL_OK) {
        pel_arena_end(&r->arena);
        return err;
    }
    pel_stage_begin(&r->timing);
    if (any_high(here, draws, count)) {
        pel_space_suns(&r->space, &r->sky, here);
        err = here->weather ? pel_wind_map_need(&r->space.winds, here) : PEL_OK;
        if (err != PEL_OK) {
            pel_arena_end(&r->arena);
            return err;
        }
    }
    bind_frame(r, here);
    r->env = here;
    pel_cloud_map_bind(&r->clouds, here, bind_table_eye, r);
    if (here->sea->cascades) {
        pel_wavefield_run(&r->wavefield, &here->sea->desc, here->sea->cascades,
                          here->time_s);
        pel_stage_end(&r->timing, PEL_STAGE_WAVES);
    }
    if (pel_statistics_need(&r->statistics, here, &r->filter)) {
        pel_sea_texels_variance(&r->tables, r->statistics.variance,
                                r->statistics.breaking);
    }
    pel_foam_map_bind(&r->foam, here->sea, here->wash != NULL);
    pel_wake_map_load(&r->wakes, here);
    pel_sky_update(&r->sky, here, bind_table_eye, r);
    r->env = NULL;
    pel_stage_end(&r->timing, PEL_STAGE_SKY);
    return PEL_OK;
}

enum pel_err pel_renderer_submit(struct pel_renderer *r,
                                 const struct pel_environment *env,
                                 const struct pel_draw *draws, size_t count)
{
    if (count > pel_readback_free(&r->readback)) {
        return PEL_ERR_BUSY;
    }
    struct pel_environment here = *env;
    order_lights(&here);
    if (r->drew) { /* or a lost device's context would end 0.2 s later */
        pel_program_one_by_one();
    }
    /* Not in the turn: who makes programs, at first and after a loss, takes
     * some fifty milliseconds; nor is a renderer's first frame, which takes
     * thirty, most of it while the driver makes what its calls have named. */
    enum pel_err err = need_programs(r, &here, draws, count);
    if (err != PEL_OK) {
        return err;
    }
    bool turn = r->drew && pel_turn_begin();
    err = begin_frame(r, &here, draws, count);
    bool begun = err == PEL_OK;
    for (size_t i = 0; i < count && err == PEL_OK;) {
        pel_turn_end(turn); /* others draw while these are planned */
        size_t views = pel_together_plan(r, &here, draws + i, count - i);
        err = views > 0 ? pel_together_reserve(r) : PEL_OK;
        turn = r->drew && pel_turn_begin();
        if (views == 0) {
            err = pel_view_draw(r, &here, &draws[i]);
        } else if (err == PEL_OK) {
            pel_together_draw(r, &here);
        }
        i += views > 0 ? views : 1;
    }
    if (begun) {
        pel_under_map_rest(&r->under);
        pel_arena_end(&r->arena);
    }
    pel_turn_end(turn);
    r->drew = r->drew || err == PEL_OK;
    return err;
}

struct pel_picture *pel_renderer_collect(struct pel_renderer *r,
                                         int64_t wait_ns)
{
    return pel_readback_pop(&r->readback, wait_ns);
}

size_t pel_renderer_in_flight(const struct pel_renderer *r)
{
    return r->readback.in_flight;
}

bool pel_renderer_band_done(struct pel_renderer *r, int64_t wait_ns)
{
    return pel_readback_band_done(&r->readback, wait_ns);
}

void pel_renderer_drop_bands(struct pel_renderer *r)
{
    pel_readback_drop_bands(&r->readback);
}

bool pel_renderer_lost(struct pel_renderer *r)
{
    r->lost = r->lost || pel_context_lost(&r->context) ||
              pel_program_failed() ||
              (r->lose_after > 0 && r->readback.pushed >= r->lose_after);
    return r->lost;
}

size_t pel_renderer_abandon(struct pel_renderer *r, void **users, size_t most)
{
    pel_readback_drop_bands(&r->readback);
    return pel_readback_abandon(&r->readback, users, most);
}

void pel_renderer_rest(struct pel_renderer *r)
{
    bool turn = r->drew && pel_turn_begin();
    pel_targets_rest(&r->targets);
    pel_together_rest(&r->together);
    pel_under_map_rest(&r->under);
    pel_readback_rest(&r->readback);
    glFlush();
    pel_turn_end(turn);
}

bool pel_renderer_unused(const struct pel_renderer *r)
{
    return pel_readback_free(&r->readback) == PEL_READBACK_SLOTS;
}

enum pel_err pel_renderer_probe(struct pel_renderer *r,
                                const struct pel_environment *env,
                                const struct pel_probe *probe,
                                struct pel_probe_answer *out,
                                struct pel_fault *fault)
{
    struct pel_environment here = *env;
    order_lights(&here);
    enum pel_err err =
        pel_prober_init(&r->prober, here.lit, r->shader_dir, fault);
    if (err == PEL_OK) {
        err = need_light(r, &here, fault);
    }
    if (err == PEL_OK &&
        (err = pel_arena_begin(&r->arena, 2 * PEL_VIEW_UNIFORM_BYTES)) !=
            PEL_OK) {
        pel_fault_set(fault, err, "no memory for the frame's buffers");
    }
    if (err != PEL_OK) {
        return err;
    }
    here.seabed = NULL;
    err = pel_water_light_update(&r->sky.water, &here);
    if (err != PEL_OK) {
        pel_arena_end(&r->arena);
        return pel_fault_set(fault, err,
                             "no memory for the light in the water");
    }
    bind_frame(r, &here);
    pel_sky_update(&r->sky, &here, bind_table_eye, r);
    double table_height_m = pel_sky_quantize_height(probe->height_m);
    struct pel_block_eye eye;
    pel_fill_eye(probe->height_m, table_height_m, NULL, &eye);
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_EYE, &eye,
                   sizeof eye);
    pel_sky_bind_eye(&r->sky, &here, table_height_m);
    pel_prober_run(&r->prober, here.lit, here.lights[0].body != PEL_LIGHT_SUN,
                   probe, out);
    pel_arena_end(&r->arena);
    return PEL_OK;
}

enum pel_err pel_renderer_probe_water(struct pel_renderer *r,
                                      const struct pel_environment *env,
                                      const struct pel_geometry *at,
                                      struct pel_water_parts *out,
                                      struct pel_fault *fault)
{
    const double view[1][2] = { { at->view_zenith_rad, at->azimuth_rad } };
    const struct pel_water_depths depths = { 1, env->water.depth_m,
                                             env->water.depth_m };
    return pel_water_prober_run(&r->water_prober, r->shader_dir, &env->water,
                                &depths, env->water.depth_m, env->orders,
                                at->sun_zenith_rad, view, 1, out, fault);
}
