/* The passes of one view, in their order: how each of its pixels is drawn, the
 * surface, its light, what lies between it and the glass. */
#include "render/viewpass.h"

#include <epoxy/gl.h>
#include <string.h>

#include "base/clock.h"
#include "render/acuity.h"
#include "render/band.h"
#include "render/coast.h"
#include "render/edges.h"
#include "render/mark.h"
#include "render/meshpass.h"
#include "render/shadepass.h"
#include "render/shader.h"
#include "render/spacepass.h"
#include "render/stilltiles.h"
#include "render/uniforms.h"
#include "render/viewplan.h"

static void plan_discs(const struct pel_renderer *r,
                       const struct pel_environment *env, struct pel_view *v)
{
    const struct pel_band band = { v->band.first,
                                   v->band.rows + 2 * (uint32_t)r->margin };
    for (int i = 0; i < PEL_LIGHTS; i++) {
        v->discs[i] =
            i >= env->discs
                ? (struct pel_disc_box){ 0 }
                : pel_band_disc(&v->wide, env->lights[i].direction,
                                pel_light_radius(&env->lights[i]), band);
    }
}

/* What each tile of the picture holds besides the open sea. */
static void plan_tiles(struct pel_renderer *r,
                       const struct pel_environment *env,
                       const struct pel_view *v)
{
    const struct pel_camera *whole = &v->whole;
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
                     pel_objects_plan(&r->objects, env, whole, false, r->tiles);
    if (r->any_coast || r->any_objects || r->still) {
        pel_band_tiles(whole, v->band, r->tiles);
    }
}

/* Of an eye in the water: its objects alone. */
static void plan_tiles_under(struct pel_renderer *r,
                             const struct pel_environment *env,
                             const struct pel_view *v)
{
    memset(r->tiles, PEL_COAST_NONE, sizeof r->tiles);
    r->any_coast = false;
    r->still = NULL;
    r->any_objects =
        env->object_count &&
        pel_objects_plan(&r->objects, env, &v->whole, true, r->tiles);
    if (r->any_objects) {
        pel_band_tiles(&v->whole, v->band, r->tiles);
    }
}

/* --- the surface ---------------------------------------------------------- */

static void displace_mesh(struct pel_renderer *r,
                          const struct pel_sea_programs *p)
{
    const struct pel_mesh *m = r->mesh;
    if (m->vertex_count > r->vertex_capacity) {
        int capacity = m->vertex_count + m->vertex_count / 4;
        glDeleteBuffers(1, &r->vertices);
        glCreateBuffers(1, &r->vertices);
        glNamedBufferStorage(r->vertices,
                             (GLsizeiptr)capacity * PEL_VERTEX_BYTES, NULL, 0);
        glObjectLabel(GL_BUFFER, r->vertices, -1, "vertices");
        r->vertex_capacity = capacity;
        glTextureBuffer(r->vertex_texels, GL_RGBA32F, r->vertices);
    }
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_VERTICES, r->vertices);
    pel_arena_bind(
        &r->arena, GL_SHADER_STORAGE_BUFFER, PEL_STORE_RINGS, m->rings,
        sizeof *m->rings * (size_t)(m->ring_count ? m->ring_count : 1));
    glBindTextureUnit(PEL_UNIT_VERTICES, r->vertex_texels);
    pel_view_bind_net(r, r->vertices);
    pel_program_use(p->mesh);
    pel_mesh_displace(m);
}

/* The nearest triangle of each pixel, in compute. */
static void search_surface(struct pel_renderer *r, bool under)
{
    int triangles = 2 * r->mesh->vertex_count;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_KEYS, r->targets.keys);
    if (triangles > 0) {
        pel_program_use(r->programs.search);
        glUniform1i(0, r->mesh->vertex_count);
        glUniform1i(1, under);
        pel_mesh_search(triangles, 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
}

static void raster_surface(struct pel_renderer *r, const struct pel_camera *c,
                           bool under)
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
    if (r->any_coast || r->any_objects || r->margin || under) {
        static const GLuint none[4] = { 0 };
        glClearNamedFramebufferuiv(r->targets.surface_fbo, GL_COLOR, 0, none);
    }
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, r->targets.surface_fbo);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    if (!under) {
        /* The backs of crests would show as specks along their outlines. */
        glEnable(GL_CULL_FACE);
        glFrontFace(GL_CW);
    }
    pel_program_use(r->programs.surface);
    glViewport(-PEL_RASTER_MARGIN, -PEL_RASTER_MARGIN,
               width + 2 * PEL_RASTER_MARGIN, height + 2 * PEL_RASTER_MARGIN);
    pel_mesh_draw(r->mesh);
    glDisable(GL_SCISSOR_TEST);
    glViewport(0, 0, width, height);
    glDisable(GL_CULL_FACE);
    glDepthMask(GL_FALSE);
}

static void find_surface(struct pel_renderer *r,
                         const struct pel_environment *env,
                         const struct pel_view *v, bool under)
{
    pel_view_bind_wakes(r, env, v);
    displace_mesh(r, v->programs);
    pel_stage_end(&r->timing, PEL_STAGE_MESH);
    if (r->programs.compute) {
        search_surface(r, under);
    }
    if (!r->programs.compute || under) {
        raster_surface(r, &v->part, under);
    }
}

/* --- its light ------------------------------------------------------------ */

static void over_all(const struct pel_view *v)
{
    glViewport(0, 0, (GLsizei)v->block.size.x, (GLsizei)v->block.size.y);
}

static void raster_objects(struct pel_renderer *r,
                           const struct pel_environment *env,
                           const struct pel_view *v)
{
    GLint box[4];
    glBindTextureUnit(PEL_UNIT_TRIANGLES, r->targets.triangles);
    pel_objects_light(&r->objects, &r->sky);
    pel_shade_box(r, &v->part, box);
    pel_objects_raster(&r->objects, env, &v->whole, &v->block, box, &r->arena,
                       r->programs.compute, pel_shade_middles(v->asked));
    over_all(v);
}

/* What is looked up per pixel while it is shaded. */
static void find_light(struct pel_renderer *r,
                       const struct pel_environment *env,
                       const struct pel_view *v)
{
    if (env->wakes) { /* tables of the light had their place */
        pel_wake_map_again(&r->wakes);
    }
    if (env->night.on) {
        pel_night_textures_bind(&r->sky.night, env, &v->block);
    }
    if (env->panorama) {
        glBindTextureUnit(PEL_UNIT_PANORAMA, r->sky.panorama.texture);
    }
    if (env->lamp_count > 0) {
        pel_lamp_map_plan(&r->lamps, env, &v->whole, &v->block);
        pel_lamp_map_find(&r->lamps, &r->programs, &r->targets, &r->arena);
    }
    if (env->clouds.cover > 0) {
        pel_cloud_map_scape(&r->clouds, *pel_programs_cloudscape(&r->programs),
                            env, &v->whole, &v->block);
        over_all(v);
    }
}

static void shade(struct pel_renderer *r, const struct pel_environment *env,
                  const struct pel_view *v, unsigned now, bool toned)
{
    if (env->lamp_count > 0 && toned) {
        over_all(v);
        pel_lamp_map_alone(&r->lamps, r->programs.compute,
                           (uint32_t)v->block.size.x,
                           (uint32_t)v->block.size.y);
    }
    if (r->programs.compute) {
        pel_shade_dispatches(r, &v->part, v->programs, now);
    } else {
        pel_shade_fragments(r, &v->part, v->discs, v->programs, now);
    }
}

/* Drops, the eye's loss of detail, lamps and the pane, on the radiance. The
 * light that colours are made of. */
static GLuint put_over(struct pel_renderer *r,
                       const struct pel_environment *env,
                       const struct pel_view *v, bool toned)
{
    const unsigned wanted =
        pel_sensing_layers(&v->draw->camera, v->draw->layers);
    const GLuint sharp = r->targets.planes[PEL_AT_RADIANCE];
    GLuint light = sharp;
    const bool wet = v->lens.state == PEL_LENS_WET;
    if (pel_fall_map_shows(env, v->asked) && !wet && !v->high &&
        !r->programs.above) {
        over_all(v);
        pel_fall_map_put(&r->falls, env, &v->part, &v->block, &r->targets);
    }
    if (v->border > 0) {
        light =
            pel_acuity_run(&r->acuity, &r->targets, (GLsizei)v->block.size.x,
                           (GLsizei)v->block.size.y, r->margin + v->border);
    }
    if (env->lamp_count > 0 && !wet && !v->high &&
        (!toned || wanted & PEL_LAYER_RADIANCE)) {
        over_all(v);
        pel_lamp_map_put(&r->lamps, sharp, 1.0 - v->share);
        if (light != sharp) {
            pel_lamp_map_put(&r->lamps, light, 1.0 - v->share);
        }
    }
    if (pel_pane_map_shows(&v->part, v->asked) && !wet) {
        over_all(v);
        pel_pane_map_put(&r->panes, env, &v->part, sharp);
        if (light != sharp) {
            pel_pane_map_put(&r->panes, env, &v->part, light);
        }
    }
    return light;
}

/* From high up: one pass over all pixels. */
static void draw_high(struct pel_renderer *r, const struct pel_environment *env,
                      struct pel_view *v)
{
    const unsigned now = pel_view_at_once(env, v->draw, v->asked, false);
    pel_view_fill_eye(env, r->mesh, v);
    pel_view_bind_sea(r, env, &v->part);
    pel_view_bind_wakes(r, env, v);
    pel_view_bind_eye(r, env, v);
    pel_targets_fit(&r->targets, v->part.width, v->part.height, v->asked);
    pel_stage_begin(&r->timing);
    pel_space_begin(r, env, &v->whole, v->height_m);
    pel_stage_end(&r->timing, PEL_STAGE_SKY);
    if (env->night.on) {
        pel_night_textures_bind(&r->sky.night, env, &v->block);
    }
    over_all(v);
    bool toned = pel_space_shade(r, env, &v->wide, v->band, now);
    const GLuint light = put_over(r, env, v, toned);
    pel_stage_end(&r->timing, PEL_STAGE_SHADE);
    if (!toned && v->asked & PEL_LAYER_COLOR) {
        pel_shade_tone(r, &v->part, light);
    }
    pel_space_end(r, env);
}

/* The form from high up over the low one's picture. */
static void mix_high(struct pel_renderer *r, const struct pel_environment *env,
                     const struct pel_view *v, unsigned now)
{
    pel_space_begin(r, env, &v->whole, v->height_m);
    if (env->night.on) {
        pel_night_textures_bind(&r->sky.night, env, &v->block);
    }
    over_all(v);
    pel_space_mix(r, env, &v->wide, now, v->share);
    pel_space_end(r, env);
}

/* By an eye in the air. */
static void draw_in_air(struct pel_renderer *r,
                        const struct pel_environment *env,
                        const struct pel_view *v, unsigned now, bool toned)
{
    find_surface(r, env, v, false);
    if (env->lamp_count > 0) {
        pel_lamp_glow_bind(&r->glows, env, &v->whole, v->band.first, r->margin);
    }
    if (r->any_objects) {
        raster_objects(r, env, v);
    }
    pel_stage_end(&r->timing, PEL_STAGE_RASTER);
    find_light(r, env, v);
    shade(r, env, v, now, toned);
}

/* By an eye in the water, over that in the air where the surface crosses the
 * lens; the sea and the light are bound. */
static void draw_in_water(struct pel_renderer *r,
                          const struct pel_environment *env, struct pel_view *v,
                          unsigned now)
{
    plan_tiles_under(r, env, v);
    pel_view_bind_seabed(r, env, &v->part);
    find_surface(r, env, v, true);
    if (r->any_objects) {
        raster_objects(r, env, v);
    }
    pel_stage_end(&r->timing, PEL_STAGE_RASTER);
    if (env->wakes) {
        pel_wake_map_again(&r->wakes);
    }
    over_all(v);
    pel_under_map_draw(&r->under, env, &r->programs, &r->targets, now,
                       v->lens.state == PEL_LENS_CROSSED,
                       r->any_objects ? &r->objects : NULL, &v->block);
    if (pel_mote_map_shows(env, v->asked)) {
        pel_mote_map_put(&r->motes, env, &r->programs, &v->whole,
                         pel_under_map_least(&r->under), &v->block,
                         r->any_objects, &r->targets);
    }
    if (r->programs.compute) {
        glClearNamedBufferData(r->targets.keys, GL_R32UI, GL_RED_INTEGER,
                               GL_UNSIGNED_INT, NULL);
    }
}

/* Everything up to the colour. */
static enum pel_err draw_pixels(struct pel_renderer *r,
                                const struct pel_environment *env,
                                const struct pel_draw *draw, int border)
{
    struct pel_view v = { .draw = draw, .border = border };
    pel_view_plan_pixels(r, env, &v);
    if (v.high) {
        draw_high(r, env, &v);
        return PEL_OK;
    }
    const bool under = pel_lens_under(&v.lens);
    const bool wet = v.lens.state == PEL_LENS_WET;
    pel_view_plan_mesh(r, env, &v, wet, r->mesh, r->mesh);
    plan_discs(r, env, &v);
    r->programs.above = pel_view_above_clouds(env, v.whole.altitude_m);
    v.programs = pel_programs_of(&r->programs, env->sea);
    if (!wet) {
        plan_tiles(r, env, &v);
    }
    if (r->any_coast || under) {
        pel_view_bind_seabed(r, env, &v.part);
    }
    pel_view_fill_eye(env, r->mesh, &v);
    pel_view_bind_sea(r, env, &v.part);
    if (under && !pel_under_map_bind(&r->under, env, &r->sky, &v.whole, &v.lens,
                                     &r->arena)) {
        return PEL_ERR_NO_MEMORY;
    }
    pel_view_bind_eye(r, env, &v);
    if (under) {
        pel_under_map_shafts(&r->under, env, &r->programs);
    }
    pel_targets_fit(&r->targets, v.part.width + 2 * (uint32_t)r->margin,
                    v.part.height + 2 * (uint32_t)r->margin, v.asked);
    pel_stage_begin(&r->timing);
    pel_sky_bind_eye(&r->sky, env, v.table_height_m);
    pel_stage_end(&r->timing, PEL_STAGE_SKY);
    const unsigned now =
        pel_view_at_once(env, draw, v.asked, pel_view_is_late(&v));
    const bool toned = pel_shade_tones(r, now);
    if (!wet) {
        draw_in_air(r, env, &v, now, toned);
    }
    if (under) {
        if (!wet) {
            pel_view_plan_mesh(r, env, &v, true, r->mesh, r->mesh);
            pel_view_fill_eye(env, r->mesh, &v);
            pel_view_bind(r, PEL_BLOCK_EYE, &v.eye, sizeof v.eye);
        }
        draw_in_water(r, env, &v, now);
    }
    if (v.share > 0.0) {
        mix_high(r, env, &v, now);
    }
    const GLuint light = put_over(r, env, &v, toned);
    pel_stage_end(&r->timing, PEL_STAGE_SHADE);
    if (!toned && v.asked & PEL_LAYER_COLOR) {
        pel_shade_tone(r, &v.part, light);
    }
    return PEL_OK;
}

static enum pel_err read_planes(struct pel_renderer *r,
                                const struct pel_readback_source *s)
{
    struct pel_readback_slot *slot = pel_readback_reserve(&r->readback, s);
    if (!slot) {
        return PEL_ERR_BUSY;
    }
    struct pel_ycbcr_view view = { .form = s->ycbcr,
                                   .quality = s->quality,
                                   .width = s->width,
                                   .height = s->height,
                                   .slot = slot };
    pel_ycbcr_one(&r->ycbcr, r->targets.color, s->x, &view);
    glCopyNamedBufferSubData(s->exposure, pel_readback_buffer(slot), 0,
                             (GLintptr)pel_readback_ev_offset(slot), 16);
    glMemoryBarrier(GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT);
    pel_readback_send(&r->readback, &slot, 1);
    return PEL_OK;
}

enum pel_err pel_view_draw(struct pel_renderer *r,
                           const struct pel_environment *env,
                           const struct pel_draw *draw)
{
    int64_t started_ns = pel_now_ns();
    struct pel_draw here = *draw;
    here.camera.altitude_m -= env->sea_level_m;
    const struct pel_camera *c = &here.camera;
    struct pel_band band = pel_band_of(draw);
    const int border = pel_acuity_border(env, c, draw->layers);
    enum pel_err err = draw_pixels(r, env, &here, border);
    if (err != PEL_OK) {
        return err;
    }
    if (pel_sensing_is(c) && draw->layers & PEL_LAYER_COLOR) {
        const struct pel_camera part = pel_band_camera(c, band);
        pel_shade_sense(r, env, &part);
    }
    if (env->stale && draw->layers & PEL_LAYER_COLOR) {
        pel_mark_stale(r->targets.color_fbo, c->width, c->height, band.first,
                       band.rows, r->margin + border, env->stale);
    }
    pel_stage_end(&r->timing, PEL_STAGE_TONE);
    struct pel_readback_source source = {
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
    source.ycbcr = pel_view_ycbcr(r, draw);
    source.quality = draw->quality;
    err = source.ycbcr != PEL_YCBCR_NONE
              ? read_planes(r, &source)
              : pel_readback_push(&r->readback, &source);
    pel_stage_end(&r->timing, PEL_STAGE_READBACK);
    return err;
}
