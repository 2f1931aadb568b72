#include "render/renderer.h"

#include <epoxy/gl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/reserve.h"
#include "ocean/wash.h"
#include "render/acuity.h"
#include "render/arena.h"
#include "render/band.h"
#include "render/coast.h"
#include "render/context.h"
#include "render/edges.h"
#include "render/foammap.h"
#include "render/mark.h"
#include "render/mesh.h"
#include "render/meshpass.h"
#include "render/meter.h"
#include "render/objects.h"
#include "render/pass.h"
#include "render/probe.h"
#include "render/programs.h"
#include "render/readback.h"
#include "render/rendererstate.h"
#include "render/shadepass.h"
#include "render/shader.h"
#include "render/sky.h"
#include "render/stages.h"
#include "render/statistics.h"
#include "render/stilltiles.h"
#include "render/targets.h"
#include "render/texels.h"
#include "render/tiles.h"
#include "render/uniforms.h"
#include "render/waterprobe.h"
#include "render/wavefield.h"

/* Uniform blocks and rings of one view, with alignment. */
#define VIEW_UNIFORM_BYTES                                                     \
    (sizeof(struct pel_block_waves) + sizeof(struct pel_block_view) +          \
     sizeof(struct pel_block_eye) * 3 + sizeof(struct pel_block_seabed) +      \
     sizeof(struct pel_block_sighted) + sizeof(struct pel_block_shore) +       \
     sizeof(struct pel_block_wakes) +                                          \
     sizeof(struct pel_mesh_ring) * PEL_MESH_MAX_RINGS + 2048)
#define VERTEX_BYTES 32
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
    r->mesh = malloc(sizeof *r->mesh);
    if (!r->mesh) {
        pel_fault_set(fault, err, "out of memory");
        goto fail;
    }
    err = pel_context_init(&r->context, o->device, o->debug, fault);
    if (err != PEL_OK) {
        goto fail;
    }
    r->wavefield.on_processor = r->context.software;
    glCreateVertexArrays(1, &r->vao);
    glBindVertexArray(r->vao);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    pel_sea_texels_init(&r->tables);
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &r->vertex_texels);
    pel_stage_timer_init(&r->timing, r->context.software);
    err = pel_readback_init(&r->readback);
    if (err == PEL_OK) {
        err = pel_arena_init(&r->arena, 4 * VIEW_UNIFORM_BYTES);
    }
    if (err != PEL_OK) {
        pel_fault_set(fault, err, "no memory for the frame's buffers");
        goto fail;
    }
    err = pel_sky_init(&r->sky, r->shader_dir, fault);
    if (err == PEL_OK) {
        err =
            pel_programs_init(&r->programs, r->shader_dir, r->context.software,
                              o->shading, &r->filtering, fault);
    }
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

void pel_renderer_destroy(struct pel_renderer *r)
{
    if (!r) {
        return;
    }
    if (r->context.context) {
        pel_readback_finish(&r->readback);
        pel_arena_finish(&r->arena);
        pel_sky_finish(&r->sky);
        pel_targets_finish(&r->targets);
        pel_programs_finish(&r->programs);
        pel_meter_finish(&r->meter);
        pel_sensing_finish(&r->sensing);
        pel_prober_finish(&r->prober);
        pel_water_prober_finish(&r->water_prober);
        pel_objects_finish(&r->objects);
        pel_seabed_map_finish(&r->seabed);
        pel_wavefield_finish(&r->wavefield);
        pel_foam_map_finish(&r->foam);
        pel_cloud_map_finish(&r->clouds);
        pel_fall_map_finish(&r->falls);
        pel_pane_map_finish(&r->panes);
        pel_lamp_map_finish(&r->lamps);
        pel_lamp_glow_finish(&r->glows);
        pel_acuity_finish(&r->acuity);
        pel_wake_map_finish(&r->wakes);
        pel_shore_map_finish(&r->shore);
        glDeleteBuffers(1, &r->vertices);
        glDeleteTextures(1, &r->vertex_texels);
        pel_sea_texels_finish(&r->tables);
        glDeleteVertexArrays(1, &r->vao);
        pel_stage_timer_finish(&r->timing);
    }
    pel_context_finish(&r->context);
    free(r->mesh);
    free(r);
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
    pel_fill_eye(height_m, height_m, false, NULL, &block);
    if (r->env) {
        pel_fill_cloud_eye(r->env, r->env->clouds_x_m, r->env->clouds_y_m,
                           &block);
        pel_fill_fog_own(r->env, &block);
    }
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_EYE, &block,
                   sizeof block);
}

static void displace_mesh(struct pel_renderer *r,
                          const struct pel_sea_programs *p)
{
    const struct pel_mesh *m = r->mesh;
    if (m->vertex_count > r->vertex_capacity) {
        int capacity = m->vertex_count + m->vertex_count / 4;
        glDeleteBuffers(1, &r->vertices);
        glCreateBuffers(1, &r->vertices);
        glNamedBufferStorage(r->vertices, (GLsizeiptr)capacity * VERTEX_BYTES,
                             NULL, 0);
        glObjectLabel(GL_BUFFER, r->vertices, -1, "vertices");
        r->vertex_capacity = capacity;
        glTextureBuffer(r->vertex_texels, GL_RGBA32F, r->vertices);
    }
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_VERTICES, r->vertices);
    pel_arena_bind(
        &r->arena, GL_SHADER_STORAGE_BUFFER, PEL_STORE_RINGS, m->rings,
        sizeof *m->rings * (size_t)(m->ring_count ? m->ring_count : 1));
    glBindTextureUnit(PEL_UNIT_VERTICES, r->vertex_texels);
    glUseProgram(p->mesh);
    pel_mesh_displace(m);
}

/* The nearest triangle of each pixel, in compute. */
static void search_surface(struct pel_renderer *r, bool submerged)
{
    int triangles = 2 * r->mesh->vertex_count;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_KEYS, r->targets.keys);
    if (triangles > 0) {
        glUseProgram(r->programs.search);
        glUniform1i(0, r->mesh->vertex_count);
        glUniform1i(1, submerged);
        glDispatchCompute(pel_groups(triangles, PEL_GROUP_LINE), 1, 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
}

static void raster_surface(struct pel_renderer *r, const struct pel_camera *c,
                           bool submerged)
{
    static const GLfloat far_away = 0.0f;
    /* Clearing obeys depth mask and scissor: the targets may be larger than
     * this picture. The sea's texels are read only where the depth shows a
     * triangle, but those of coasts, objects, outlines read all of them. */
    glDepthMask(GL_TRUE);
    const GLsizei width = (GLsizei)c->width + 2 * r->margin;
    const GLsizei height = (GLsizei)c->height + 2 * r->margin;
    glScissor(0, 0, width, height);
    glEnable(GL_SCISSOR_TEST);
    glClearNamedFramebufferfv(r->targets.surface_fbo, GL_DEPTH, 0, &far_away);
    if (r->any_coast || r->any_objects || r->margin) {
        static const GLuint none[4] = { 0 };
        glClearNamedFramebufferuiv(r->targets.surface_fbo, GL_COLOR, 0, none);
    }
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, r->targets.surface_fbo);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    if (!submerged) {
        /* The backs of crests would show as specks along their outlines. */
        glEnable(GL_CULL_FACE);
        glFrontFace(GL_CW);
    }
    glUseProgram(r->programs.surface);
    glViewport(-PEL_RASTER_MARGIN, -PEL_RASTER_MARGIN,
               width + 2 * PEL_RASTER_MARGIN, height + 2 * PEL_RASTER_MARGIN);
    pel_mesh_draw(r->mesh);
    glDisable(GL_SCISSOR_TEST);
    glViewport(0, 0, width, height);
    glDisable(GL_CULL_FACE);
    glDepthMask(GL_FALSE);
}

/* Asked only where waves may reach the eye: the answer of an FFT sea costs its
 * transforms on the processor. */
static bool is_submerged(const struct pel_environment *env,
                         const struct pel_camera *c)
{
    if (c->altitude_m >
        fmin(env->sea->max_height_m, 6.0 * sqrt(env->sea->m0))) {
        return false;
    }
    struct pel_surface_sample above;
    pel_sea_sample(env->sea, c->east_m, c->north_m, env->time_s, &above);
    return above.height_m > c->altitude_m;
}

/* By the eye of the first window, so that all views of a meter get the same. */
static void expose(struct pel_renderer *r, const struct pel_environment *env,
                   const struct pel_camera *c, bool submerged)
{
    double altitude_m = c->sight_count
                            ? c->sights[0].altitude_m - env->sea_level_m
                            : c->altitude_m;
    double height_m = fmax(altitude_m, PEL_LEAST_EYE_M);
    double table_height_m = pel_sky_quantize_height(height_m);
    struct pel_block_eye eye;
    struct pel_block_sighted sights;
    pel_fill_eye(height_m, table_height_m, submerged, NULL, &eye);
    pel_fill_spray(env->sea->foam, submerged ? 0.0 : height_m, &eye);
    pel_fill_fog(env, c->east_m, c->north_m, &eye);
    pel_fill_sights(env, c, &sights);
    pel_acuity_meter(env, c, &sights);
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_EYE, &eye,
                   sizeof eye);
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_SIGHTS, &sights,
                   sizeof sights);
    pel_sky_bind_eye(&r->sky, env, table_height_m);
    pel_meter_run(&r->meter, env);
}

/* For shaders/lib/waves.glsl. All groups of a dispatch read them: hardware from
 * memory of its own, or the host's is what they wait for. */
static void bind_waves(struct pel_renderer *r,
                       const struct pel_environment *env,
                       const struct pel_camera *c)
{
    struct pel_block_waves block;
    pel_fill_waves(env, c->east_m, c->north_m, &block);
    if (r->context.software) {
        pel_arena_texels(&r->arena, r->arena.texels, PEL_UNIT_WAVES, &block,
                         sizeof block);
    } else {
        pel_texels_set(&r->tables.waves, &block, sizeof block);
        glBindTextureUnit(PEL_UNIT_WAVES, r->tables.waves.texture);
    }
}

/* Words of a moment's wash, with alignment; 0: none. */
static size_t wash_bytes(const struct pel_environment *env)
{
    return env->wash
               ? sizeof(uint32_t) * pel_wash_words(env->wash, 0, 0, NULL) +
                     sizeof(struct pel_block_wash) + 1024
               : 0;
}

static void bind_wash(struct pel_renderer *r, const struct pel_environment *env,
                      const struct pel_camera *c)
{
    struct pel_block_wash block;
    size_t count = pel_wash_words(env->wash, 0, 0, NULL);
    uint32_t *words = pel_sure_malloc(sizeof *words * (count + 1));
    pel_wash_words(env->wash, c->east_m, c->north_m, words);
    pel_arena_bind(&r->arena, GL_SHADER_STORAGE_BUFFER, PEL_STORE_WASH, words,
                   sizeof *words * (count + 1));
    free(words);
    pel_fill_wash(env, c->east_m, c->north_m, &block);
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_WASH, &block,
                   sizeof block);
}

static bool draws_edges(const struct pel_renderer *r,
                        const struct pel_camera *c)
{
    bool thermal = pel_sensing_is(c) && c->sensor.sense == PEL_SENSE_THERMAL;
    return c->antialiasing && !thermal && pel_programs_have_edges(&r->programs);
}

/* Drops and the eye's loss of detail come between light and colour
 * everywhere. */
static bool is_toned_last(const struct pel_environment *env,
                          const struct pel_draw *draw, unsigned layers)
{
    return pel_fall_map_shows(env, layers) ||
           pel_pane_map_shows(&draw->camera, layers) ||
           pel_acuity_border(env, &draw->camera, draw->layers) > 0;
}

/* Outlines are mixed in radiance, objects as fragments with what is behind
 * them. */
static unsigned to_shade(const struct pel_renderer *r,
                         const struct pel_environment *env,
                         const struct pel_draw *draw)
{
    unsigned layers = pel_sensing_layers(&draw->camera, draw->layers);
    bool mixed = draws_edges(r, &draw->camera) ||
                 (env->object_count && !r->programs.compute) ||
                 is_toned_last(env, draw, layers);
    return mixed ? layers | PEL_LAYER_RADIANCE : layers;
}

/* What is shaded of it at once. */
static unsigned at_once(const struct pel_environment *env,
                        const struct pel_draw *draw, unsigned asked)
{
    return is_toned_last(env, draw, asked) ? asked & ~(unsigned)PEL_LAYER_COLOR
                                           : asked;
}

/* At an altitude above the sea's zero. */
static bool is_above_clouds(const struct pel_environment *env,
                            double altitude_m)
{
    return env->clouds.cover > 0 && altitude_m > env->clouds.base_m;
}

/* Everything up to the colour, with `border` more pixels at each edge; the
 * camera stands above the sea's zero. What decides how a pixel is drawn is
 * planned for the whole picture. */
static void draw_pixels(struct pel_renderer *r,
                        const struct pel_environment *env,
                        const struct pel_draw *draw, int border)
{
    const unsigned asked = to_shade(r, env, draw);
    const struct pel_camera full = pel_edges_camera(&draw->camera, border);
    const struct pel_camera *whole = &full;
    struct pel_band band = pel_band_of(draw);
    band.rows += 2 * (uint32_t)border;
    double height_m = fmax(whole->altitude_m, PEL_LEAST_EYE_M);
    double table_height_m = pel_sky_quantize_height(height_m);
    struct pel_block_view view;
    pel_fill_view(whole, &r->filter, &view);
    bool submerged = is_submerged(env, whole);
    r->margin = draws_edges(r, whole) && !submerged ? PEL_EDGES_MARGIN : 0;
    view.pixel.z -= (float)r->margin;
    view.pixel.w += (float)((int)band.first - r->margin);
    view.size.x += (float)(2 * r->margin);
    view.size.y = (float)((int)band.rows + 2 * r->margin);
    const struct pel_mesh_eye mesh_eye = {
        .height_m = height_m,
        .pixel = fmin((double)view.pixel.x, (double)view.pixel.y),
        .cell_px = r->filtering.cell_px,
        .sea = env->sea,
        .losses = &r->statistics.losses,
    };
    const struct pel_camera part = pel_band_camera(whole, band);
    const struct pel_camera *c = &part;
    const struct pel_camera wide = pel_edges_camera(whole, r->margin);
    pel_mesh_plan(&mesh_eye, &wide, r->mesh);
    if (c->height < whole->height) {
        const struct pel_camera narrow = pel_edges_camera(c, r->margin);
        pel_mesh_narrow(&mesh_eye, &narrow, r->mesh);
    }
    struct pel_disc_box discs[PEL_LIGHTS];
    for (int i = 0; i < PEL_LIGHTS; i++) {
        discs[i] =
            i >= env->discs
                ? (struct pel_disc_box){ 0 }
                : pel_band_disc(
                      &wide, env->lights[i].direction,
                      pel_light_radius(&env->lights[i]),
                      (struct pel_band){ band.first,
                                         band.rows + 2 * (uint32_t)r->margin });
    }
    bool cascades = env->sea->cascades != NULL;
    r->programs.above = is_above_clouds(env, whole->altitude_m);
    const struct pel_sea_programs *programs =
        pel_programs_of(&r->programs, env->sea);
    r->any_coast = env->seabed &&
                   pel_coast_plan(env, &r->seabed, whole,
                                  pel_water_visible_m(&env->water), r->tiles);
    if (r->any_coast && env->coast_everywhere) {
        for (size_t i = 0; i < PEL_MAX_TILES; i++) {
            r->tiles[i] = PEL_COAST_LAND;
        }
    }
    bool still = pel_still_wanted(env, &r->programs);
    if (!r->any_coast && (env->object_count || still)) {
        memset(r->tiles, PEL_COAST_NONE, sizeof r->tiles);
    }
    still = still && pel_still_tiles(env, whole, r->tiles);
    r->still = still ? pel_programs_still(&r->programs, env->sea) : NULL;
    r->any_objects = env->object_count &&
                     pel_objects_plan(&r->objects, env, whole, r->tiles);
    if (r->any_coast || r->any_objects || r->still) {
        pel_band_tiles(whole, band, r->tiles);
    }
    if (r->any_coast) {
        struct pel_block_seabed block;
        pel_seabed_map_bind(&r->seabed);
        pel_fill_seabed(env, &r->seabed, r->statistics.variance,
                        r->sky.water.beams, c->east_m, c->north_m, &block);
        pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_SEABED, &block,
                       sizeof block);
    }
    struct pel_block_eye eye;
    pel_fill_eye(height_m, table_height_m, submerged, r->mesh, &eye);
    pel_fill_spray(env->sea->foam, submerged ? 0.0 : height_m, &eye);
    if (env->sea->foam) {
        pel_fill_grain(env->sea->foam, env->wind_to_rad, c->east_m, c->north_m,
                       &eye);
    }
    pel_fill_cloud_eye(env, c->east_m - env->clouds.east_mps * env->time_s,
                       c->north_m - env->clouds.north_mps * env->time_s, &eye);
    pel_fill_fog(env, c->east_m, c->north_m, &eye);
    if (cascades) {
        struct pel_block_cascades block;
        pel_fill_cascades(env->sea->cascades, c->east_m, c->north_m, &block);
        pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_CASCADES, &block,
                       sizeof block);
    } else {
        bind_waves(r, env, c);
    }
    if (env->sea->shore) {
        struct pel_block_shore block;
        pel_shore_map_bind(&r->shore, env->sea->shore, cascades, c->east_m,
                           c->north_m, &block);
        pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_SHORE, &block,
                       sizeof block);
    }
    if (env->sea->desc.area_count || env->wash) {
        struct pel_block_areas block;
        pel_fill_areas(env, c->east_m, c->north_m, &block);
        pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_AREAS, &block,
                       sizeof block);
    }
    if (env->wash) {
        bind_wash(r, env, c);
    }
    pel_sea_texels_bind(&r->tables);
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_EYE, &eye,
                   sizeof eye);
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_VIEW, &view,
                   sizeof view);
    if (asked & PEL_LAYER_COLOR || whole->auto_exposure ||
        pel_sensing_is(whole)) {
        expose(r, env, &draw->camera, submerged);
        pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_EYE, &eye,
                       sizeof eye);
    }
    pel_targets_fit(&r->targets, c->width + 2 * (uint32_t)r->margin,
                    c->height + 2 * (uint32_t)r->margin, asked);
    pel_stage_begin(&r->timing);
    pel_sky_bind_eye(&r->sky, env, table_height_m);
    pel_stage_end(&r->timing, PEL_STAGE_SKY);
    if (env->wakes) {
        struct pel_block_wakes block;
        pel_wake_map_bind(&r->wakes, env, c->east_m, c->north_m, &block);
        pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, PEL_BLOCK_WAKES, &block,
                       sizeof block);
    }
    displace_mesh(r, programs);
    pel_stage_end(&r->timing, PEL_STAGE_MESH);
    if (r->programs.compute) {
        search_surface(r, submerged);
    } else {
        raster_surface(r, c, submerged);
    }
    bool compute = r->programs.compute;
    if (env->lamp_count > 0) {
        pel_lamp_glow_bind(&r->glows, env, whole, band.first, r->margin);
    }
    if (r->any_objects) {
        glBindTextureUnit(PEL_UNIT_TRIANGLES, r->targets.triangles);
        pel_objects_light(&r->objects, &r->sky);
        GLint box[4];
        pel_shade_box(r, c, box);
        pel_objects_raster(&r->objects, env, whole, &view, box, &r->arena,
                           compute, pel_shade_middles(asked));
        glViewport(0, 0, (GLsizei)view.size.x, (GLsizei)view.size.y);
    }
    pel_stage_end(&r->timing, PEL_STAGE_RASTER);
    if (env->wakes) { /* tables of the light had their place */
        pel_wake_map_again(&r->wakes);
    }
    if (env->night.on) {
        pel_night_textures_bind(&r->sky.night, env, &view);
    }
    if (env->panorama) {
        glBindTextureUnit(PEL_UNIT_PANORAMA, r->sky.panorama.texture);
    }
    if (env->lamp_count > 0) {
        pel_lamp_map_plan(&r->lamps, env, whole, &view);
        pel_lamp_map_find(&r->lamps, &r->programs, &r->targets, &r->arena);
    }
    if (env->clouds.cover > 0) {
        pel_cloud_map_scape(&r->clouds, *pel_programs_cloudscape(&r->programs),
                            env, whole, &view);
        glViewport(0, 0, (GLsizei)view.size.x, (GLsizei)view.size.y);
    }
    const unsigned now = at_once(env, draw, asked);
    const bool toned = pel_shade_tones(r, now);
    const GLsizei width = (GLsizei)view.size.x, height = (GLsizei)view.size.y;
    if (env->lamp_count > 0 && toned) {
        glViewport(0, 0, width, height);
        pel_lamp_map_alone(&r->lamps, compute, (uint32_t)width,
                           (uint32_t)height);
    }
    if (compute) {
        pel_shade_dispatches(r, c, programs, now);
    } else {
        pel_shade_fragments(r, c, discs, programs, now);
    }
    if (pel_fall_map_shows(env, asked) && !submerged && !r->programs.above) {
        glViewport(0, 0, width, height);
        pel_fall_map_put(&r->falls, env, c, &view, &r->targets);
    }
    GLuint light = r->targets.planes[PEL_AT_RADIANCE], sharp = light;
    if (border > 0) {
        light = pel_acuity_run(&r->acuity, &r->targets, width, height,
                               r->margin + border);
    }
    const unsigned wanted = pel_sensing_layers(&draw->camera, draw->layers);
    if (env->lamp_count > 0 && (!toned || wanted & PEL_LAYER_RADIANCE)) {
        glViewport(0, 0, width, height);
        pel_lamp_map_put(&r->lamps, sharp);
        if (light != sharp) {
            pel_lamp_map_put(&r->lamps, light);
        }
    }
    if (pel_pane_map_shows(c, asked) && !submerged) {
        glViewport(0, 0, width, height);
        pel_pane_map_put(&r->panes, env, c, sharp);
        if (light != sharp) {
            pel_pane_map_put(&r->panes, env, c, light);
        }
    }
    pel_stage_end(&r->timing, PEL_STAGE_SHADE);
    if (!toned && asked & PEL_LAYER_COLOR) {
        pel_shade_tone(r, c, light);
    }
}

static enum pel_err draw_view(struct pel_renderer *r,
                              const struct pel_environment *env,
                              const struct pel_draw *draw)
{
    int64_t started_ns = pel_now_ns();
    struct pel_draw here = *draw;
    here.camera.altitude_m -= env->sea_level_m;
    const struct pel_camera *c = &here.camera;
    struct pel_band band = pel_band_of(draw);
    const int border = pel_acuity_border(env, c, draw->layers);
    draw_pixels(r, env, &here, border);
    if (pel_sensing_is(c) && draw->layers & PEL_LAYER_COLOR) {
        const struct pel_camera part = pel_band_camera(c, band);
        pel_shade_sense(r, env, &part);
    }
    if (env->stale && draw->layers & PEL_LAYER_COLOR) {
        pel_mark_stale(r->targets.color_fbo, c->width, c->height, band.first,
                       band.rows, r->margin + border, env->stale);
    }
    pel_stage_end(&r->timing, PEL_STAGE_TONE);
    const struct pel_readback_source source = {
        .color_fbo = r->targets.color_fbo,
        .planes = r->targets.planes,
        .exposure = r->meter.exposure,
        .auto_exposure = c->auto_exposure,
        .exposure_ev = c->exposure_ev,
        .width = c->width,
        .height = c->height,
        .first_row = band.first,
        .rows = band.rows,
        .x = r->margin + border,
        .y = r->margin + border,
        .layers = draw->layers,
        .user = draw->user,
        .started_ns = started_ns,
    };
    enum pel_err err = pel_readback_push(&r->readback, &source);
    pel_stage_end(&r->timing, PEL_STAGE_READBACK);
    return err;
}

/* --- a frame's needs ------------------------------------------------------ */

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
                                        const struct pel_environment *env)
{
    bool with_sea = r->programs.compute || env->seabed;
    int night = !with_sea       ? 0
                : env->panorama ? PEL_LIGHT_PANORAMA
                : env->night.on ? PEL_LIGHT_NIGHT
                                : 0;
    return pel_light_veils(env) + night +
           (env->lit > 1                 ? PEL_LIGHT_TWO
            : env->discs > 1 && with_sea ? PEL_LIGHT_ONE_AND_DISC
                                         : PEL_LIGHT_ONE);
}

static enum pel_err need_light(struct pel_renderer *r,
                               const struct pel_environment *env,
                               struct pel_fault *fault)
{
    enum pel_err err = pel_sky_need(&r->sky, env, r->shader_dir, fault);
    if (err == PEL_OK) {
        err = pel_cloud_map_need(&r->clouds, env, r->shader_dir, fault);
    }
    return err ? err : pel_meter_need(&r->meter, env, r->shader_dir, fault);
}

static enum pel_err need_view(struct pel_renderer *r,
                              const struct pel_environment *env,
                              const struct pel_draw *draw,
                              struct pel_fault *fault)
{
    bool coast = env->seabed != NULL, objects = env->object_count > 0;
    enum pel_err err = PEL_OK;
    r->programs.above =
        is_above_clouds(env, draw->camera.altitude_m - env->sea_level_m);
    bool compute;
    do { /* once more where it turned to fragments meanwhile */
        compute = r->programs.compute;
        struct pel_pass pass =
            pel_pass_first(at_once(env, draw, to_shade(r, env, draw)), compute);
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
    if (err == PEL_OK) {
        err = pel_sensing_need(&r->sensing, &r->programs, &draw->camera, fault);
    }
    if (err == PEL_OK) {
        err = pel_lamp_map_need(&r->lamps, &r->programs, env, fault);
    }
    if (err == PEL_OK && pel_acuity_border(env, &draw->camera, draw->layers)) {
        err = pel_acuity_need(&r->acuity, r->shader_dir, fault);
    }
    if (err == PEL_OK && pel_fall_map_shows(env, to_shade(r, env, draw))) {
        err = pel_fall_map_need(&r->falls, env, r->shader_dir, fault);
    }
    if (err == PEL_OK &&
        pel_pane_map_shows(&draw->camera, to_shade(r, env, draw))) {
        err = pel_pane_map_need(&r->panes, env, r->shader_dir, fault);
    }
    return err == PEL_OK && draws_edges(r, &draw->camera)
               ? pel_programs_need_edges(&r->programs, fault)
               : err;
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
    enum pel_err err =
        pel_programs_take_light(&r->programs, light_of(r, env), &fault);
    if (err == PEL_OK) {
        err = need_light(r, env, &fault);
    }
    if (err == PEL_OK && env->object_count) {
        err = pel_objects_fit(&r->objects, env, &r->programs, &fault);
    }
    for (size_t i = 0; i < count && err == PEL_OK; i++) {
        err = need_view(r, env, &draws[i], &fault);
    }
    if (err != PEL_OK) {
        pel_error("RND-040", "a view was not drawn: %s", fault.message);
    }
    return err;
}

enum pel_err pel_renderer_submit(struct pel_renderer *r,
                                 const struct pel_environment *env,
                                 const struct pel_draw *draws, size_t count)
{
    if (count > pel_readback_free(&r->readback)) {
        return PEL_ERR_BUSY;
    }
    struct pel_fault fault = { 0 };
    struct pel_environment here = *env;
    order_lights(&here);
    enum pel_err err = need_programs(r, &here, draws, count);
    if (err != PEL_OK) {
        return err;
    }
    err = pel_arena_begin(&r->arena, (count + 1) * VIEW_UNIFORM_BYTES +
                                         count * (pel_objects_bytes(env) +
                                                  wash_bytes(env) +
                                                  pel_lamp_map_bytes(env)));
    if (err != PEL_OK) {
        return err;
    }
    for (int i = 0; i < PEL_STAGE_COUNT; i++) {
        r->timing.ms[i] = 0.0;
    }
    err = fit_water(r, &here);
    if (err != PEL_OK) {
        pel_arena_end(&r->arena);
        return err;
    }
    pel_stage_begin(&r->timing);
    bind_frame(r, &here);
    r->env = &here;
    pel_cloud_map_bind(&r->clouds, &here, bind_table_eye, r);
    if (here.sea->cascades) {
        err = pel_wavefield_run(&r->wavefield, r->shader_dir, &here.sea->desc,
                                here.sea->cascades, here.time_s, &fault);
        if (err != PEL_OK) {
            pel_error("RND-041", "the waves of a frame were not computed: %s",
                      fault.message);
            pel_arena_end(&r->arena);
            return err;
        }
        pel_stage_end(&r->timing, PEL_STAGE_WAVES);
    }
    if (pel_statistics_need(&r->statistics, &here, &r->filter)) {
        pel_sea_texels_variance(&r->tables, r->statistics.variance,
                                r->statistics.breaking);
    }
    pel_foam_map_bind(&r->foam, here.sea, here.wash != NULL);
    pel_wake_map_load(&r->wakes, &here);
    pel_sky_update(&r->sky, &here, bind_table_eye, r);
    r->env = NULL;
    pel_stage_end(&r->timing, PEL_STAGE_SKY);
    for (size_t i = 0; i < count && err == PEL_OK; i++) {
        err = draw_view(r, &here, &draws[i]);
    }
    pel_arena_end(&r->arena);
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
              (r->lose_after > 0 && r->readback.pushed >= r->lose_after);
    return r->lost;
}

size_t pel_renderer_abandon(struct pel_renderer *r, void **users, size_t most)
{
    pel_readback_drop_bands(&r->readback);
    return pel_readback_abandon(&r->readback, users, most);
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
        (err = pel_arena_begin(&r->arena, 2 * VIEW_UNIFORM_BYTES)) != PEL_OK) {
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
    pel_fill_eye(probe->height_m, table_height_m, false, NULL, &eye);
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
