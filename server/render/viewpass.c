/* The passes of one view, in their order: what its pixels are, how each is
 * drawn, the sea and the eye for the shaders, the surface, its light, what lies
 * between it and the glass. */
#include "render/viewpass.h"

#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/reserve.h"
#include "ocean/wash.h"
#include "render/acuity.h"
#include "render/band.h"
#include "render/coast.h"
#include "render/edges.h"
#include "render/mark.h"
#include "render/meshpass.h"
#include "render/shadepass.h"
#include "render/spacepass.h"
#include "render/stilltiles.h"
#include "render/uniforms.h"

#define VERTEX_BYTES 32

/* One that is drawn; its cameras stand above the sea's zero. */
struct view {
    const struct pel_draw *draw;
    unsigned asked; /* layers that are shaded */
    int border;     /* pixels more at each edge, for the eye's loss of detail */
    struct pel_camera whole, wide, part; /* with border; and margin; its band */
    struct pel_band band;
    double height_m, table_height_m; /* of the eye, and of its light's tables */
    struct pel_lens_place lens;
    double share; /* pel_space_share */
    bool high;    /* it has the form of render/spacemap.h alone */
    const struct pel_sea_programs *programs;
    struct pel_block_view block;
    struct pel_block_eye eye;
    struct pel_disc_box discs[PEL_LIGHTS];
};

/* --- what its pixels are -------------------------------------------------- */

size_t pel_view_bytes(const struct pel_environment *env)
{
    const size_t wash =
        env->wash ? sizeof(uint32_t) * pel_wash_words(env->wash, 0, 0, NULL) +
                        sizeof(struct pel_block_wash) + 1024
                  : 0;
    return PEL_VIEW_UNIFORM_BYTES + wash;
}

bool pel_view_edges(const struct pel_renderer *r, const struct pel_camera *c)
{
    bool thermal = pel_sensing_is(c) && c->sensor.sense == PEL_SENSE_THERMAL;
    return c->antialiasing && !thermal && pel_programs_have_edges(&r->programs);
}

/* Drops and the eye's loss of detail come between light and colour
 * everywhere. */
static bool is_toned_last(const struct pel_environment *env,
                          const struct pel_draw *draw, unsigned layers,
                          bool late)
{
    return late || pel_fall_map_shows(env, layers) ||
           pel_pane_map_shows(&draw->camera, layers) ||
           pel_acuity_border(env, &draw->camera, draw->layers) > 0;
}

unsigned pel_view_layers(const struct pel_renderer *r,
                         const struct pel_environment *env,
                         const struct pel_draw *draw, bool late)
{
    unsigned layers = pel_sensing_layers(&draw->camera, draw->layers);
    bool mixed = pel_view_edges(r, &draw->camera) ||
                 (env->object_count && !r->programs.compute) ||
                 is_toned_last(env, draw, layers, late);
    return mixed ? layers | PEL_LAYER_RADIANCE : layers;
}

unsigned pel_view_at_once(const struct pel_environment *env,
                          const struct pel_draw *draw, unsigned asked,
                          bool late)
{
    return is_toned_last(env, draw, asked, late)
               ? asked & ~(unsigned)PEL_LAYER_COLOR
               : asked;
}

bool pel_view_above_clouds(const struct pel_environment *env, double altitude_m)
{
    return env->clouds.cover > 0 && altitude_m > env->clouds.base_m;
}

static bool is_late(const struct view *v)
{
    return pel_lens_under(&v->lens) || (v->share > 0.0 && v->share < 1.0);
}

/* What decides how a pixel is drawn is planned for the whole picture. */
static void plan_pixels(struct pel_renderer *r,
                        const struct pel_environment *env, struct view *v)
{
    const struct pel_draw *draw = v->draw;
    const int border = v->border;
    v->lens = pel_lens_place(env, &draw->camera);
    v->share = pel_space_share(env, draw->camera.altitude_m);
    v->high = v->share >= 1.0;
    v->asked = pel_view_layers(r, env, draw, is_late(v));
    v->whole = pel_edges_camera(&draw->camera, border);
    v->band = pel_band_of(draw);
    v->band.rows += 2 * (uint32_t)border;
    v->part = pel_band_camera(&v->whole, v->band);
    v->height_m = v->whole.altitude_m;
    v->table_height_m = pel_sky_quantize_height(v->height_m);
    r->margin = pel_view_edges(r, &v->whole) && v->lens.state != PEL_LENS_WET &&
                        !v->high
                    ? PEL_EDGES_MARGIN
                    : 0;
    v->wide = pel_edges_camera(&v->whole, r->margin);
    pel_fill_view(&v->whole, &r->filter, &v->block);
    v->block.pixel.z -= (float)r->margin;
    v->block.pixel.w += (float)((int)v->band.first - r->margin);
    v->block.size.x += (float)(2 * r->margin);
    v->block.size.y = (float)((int)v->band.rows + 2 * r->margin);
}

/* Of an eye below the surface: as its mirror image above sees it. */
static struct pel_camera turned_over(const struct pel_camera *c)
{
    struct pel_camera over = *c;
    over.world_from_camera.x.z *= -1.0;
    over.world_from_camera.y.z *= -1.0;
    over.world_from_camera.z.z *= -1.0;
    return over;
}

static void plan_mesh(struct pel_renderer *r, const struct pel_environment *env,
                      const struct view *v, bool under)
{
    const struct pel_mesh_eye eye = {
        .height_m =
            under ? fmax(fabs(v->height_m), PEL_LEAST_EYE_M) : v->height_m,
        .pixel = fmin((double)v->block.pixel.x, (double)v->block.pixel.y),
        .cell_px = r->filtering.cell_px,
        .sea = env->sea,
        .losses = &r->statistics.losses,
    };
    const struct pel_camera over = turned_over(&v->wide);
    pel_mesh_plan(&eye, under ? &over : &v->wide, r->mesh);
    if (v->part.height < v->whole.height) {
        const struct pel_camera narrow = pel_edges_camera(&v->part, r->margin);
        const struct pel_camera other = turned_over(&narrow);
        pel_mesh_narrow(&eye, under ? &other : &narrow, r->mesh);
    }
}

static void plan_discs(const struct pel_renderer *r,
                       const struct pel_environment *env, struct view *v)
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
                       const struct pel_environment *env, const struct view *v)
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
                             const struct view *v)
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

/* --- what the shaders read ------------------------------------------------ */

static void bind(struct pel_renderer *r, GLuint block, const void *data,
                 size_t size)
{
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, block, data, size);
}

static void bind_seabed(struct pel_renderer *r,
                        const struct pel_environment *env,
                        const struct pel_camera *c)
{
    struct pel_block_seabed block;
    if (env->seabed) {
        pel_seabed_map_bind(&r->seabed);
    }
    pel_fill_seabed(env, &r->seabed, r->statistics.variance, r->sky.water.beams,
                    c->east_m, c->north_m, &block);
    bind(r, PEL_BLOCK_SEABED, &block, sizeof block);
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
    bind(r, PEL_BLOCK_WASH, &block, sizeof block);
}

static void bind_sea(struct pel_renderer *r, const struct pel_environment *env,
                     const struct pel_camera *c)
{
    const bool cascades = env->sea->cascades != NULL;
    if (cascades) {
        struct pel_block_cascades block;
        pel_fill_cascades(env->sea->cascades, c->east_m, c->north_m, &block);
        bind(r, PEL_BLOCK_CASCADES, &block, sizeof block);
    } else {
        bind_waves(r, env, c);
    }
    if (env->sea->shore) {
        struct pel_block_shore block;
        pel_shore_map_bind(&r->shore, env->sea->shore, cascades, c->east_m,
                           c->north_m, &block);
        bind(r, PEL_BLOCK_SHORE, &block, sizeof block);
    }
    if (env->sea->desc.area_count || env->wash) {
        struct pel_block_areas block;
        pel_fill_areas(env, c->east_m, c->north_m, &block);
        bind(r, PEL_BLOCK_AREAS, &block, sizeof block);
    }
    if (env->wash) {
        bind_wash(r, env, c);
    }
    pel_sea_texels_bind(&r->tables);
}

static void fill_eye(const struct pel_renderer *r,
                     const struct pel_environment *env, struct view *v)
{
    const struct pel_camera *c = &v->part;
    pel_fill_eye(v->height_m, v->table_height_m, r->mesh, &v->eye);
    pel_fill_spray(env->sea->foam, v->height_m, &v->eye);
    if (env->sea->foam) {
        pel_fill_grain(env->sea->foam, env->wind_to_rad, c->east_m, c->north_m,
                       &v->eye);
    }
    pel_fill_cloud_eye(env, c->east_m - env->clouds.east_mps * env->time_s,
                       c->north_m - env->clouds.north_mps * env->time_s,
                       &v->eye);
    pel_fill_fog(env, c->east_m, c->north_m, &v->eye);
}

/* By the eye of the first window, so that all views of a meter get the same. */
static double meter_height(const struct pel_environment *env,
                           const struct pel_camera *c)
{
    double altitude_m = c->sight_count
                            ? c->sights[0].altitude_m - env->sea_level_m
                            : c->altitude_m;
    return fmax(altitude_m, PEL_LEAST_EYE_M);
}

static void expose(struct pel_renderer *r, const struct pel_environment *env,
                   const struct pel_camera *c, bool under)
{
    double height_m = meter_height(env, c);
    double table_height_m = pel_sky_quantize_height(height_m);
    struct pel_block_eye eye;
    struct pel_block_sighted sights;
    pel_fill_eye(height_m, table_height_m, NULL, &eye);
    pel_fill_spray(env->sea->foam, height_m, &eye);
    pel_fill_fog(env, c->east_m, c->north_m, &eye);
    pel_fill_sights(env, c, &sights);
    pel_acuity_meter(env, c, &sights);
    bind(r, PEL_BLOCK_EYE, &eye, sizeof eye);
    bind(r, PEL_BLOCK_SIGHTS, &sights, sizeof sights);
    double share = pel_space_share(env, height_m);
    if (share < 1.0) {
        pel_sky_bind_eye(&r->sky, env, table_height_m);
        pel_meter_run(&r->meter, env, under);
    }
    if (share > 0.0) {
        pel_space_expose(r, env, c, height_m);
    }
}

static void bind_eye(struct pel_renderer *r, const struct pel_environment *env,
                     const struct view *v)
{
    bind(r, PEL_BLOCK_EYE, &v->eye, sizeof v->eye);
    bind(r, PEL_BLOCK_VIEW, &v->block, sizeof v->block);
    if (v->asked & PEL_LAYER_COLOR || v->whole.auto_exposure ||
        pel_sensing_is(&v->whole)) {
        expose(r, env, &v->draw->camera, pel_lens_under(&v->lens));
        bind(r, PEL_BLOCK_EYE, &v->eye, sizeof v->eye);
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
static void search_surface(struct pel_renderer *r, bool under)
{
    int triangles = 2 * r->mesh->vertex_count;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_KEYS, r->targets.keys);
    if (triangles > 0) {
        glUseProgram(r->programs.search);
        glUniform1i(0, r->mesh->vertex_count);
        glUniform1i(1, under);
        glDispatchCompute(pel_groups(triangles, PEL_GROUP_LINE), 1, 1);
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
    glUseProgram(r->programs.surface);
    glViewport(-PEL_RASTER_MARGIN, -PEL_RASTER_MARGIN,
               width + 2 * PEL_RASTER_MARGIN, height + 2 * PEL_RASTER_MARGIN);
    pel_mesh_draw(r->mesh);
    glDisable(GL_SCISSOR_TEST);
    glViewport(0, 0, width, height);
    glDisable(GL_CULL_FACE);
    glDepthMask(GL_FALSE);
}

static void bind_wakes(struct pel_renderer *r,
                       const struct pel_environment *env, const struct view *v)
{
    if (env->wakes) {
        struct pel_block_wakes block;
        pel_wake_map_bind(&r->wakes, env, v->part.east_m, v->part.north_m,
                          &block);
        bind(r, PEL_BLOCK_WAKES, &block, sizeof block);
    }
}

static void find_surface(struct pel_renderer *r,
                         const struct pel_environment *env,
                         const struct view *v, bool under)
{
    bind_wakes(r, env, v);
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

static void over_all(const struct view *v)
{
    glViewport(0, 0, (GLsizei)v->block.size.x, (GLsizei)v->block.size.y);
}

static void raster_objects(struct pel_renderer *r,
                           const struct pel_environment *env,
                           const struct view *v)
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
                       const struct pel_environment *env, const struct view *v)
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
                  const struct view *v, unsigned now, bool toned)
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
                       const struct pel_environment *env, const struct view *v,
                       bool toned)
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
                      struct view *v)
{
    const unsigned now = pel_view_at_once(env, v->draw, v->asked, false);
    fill_eye(r, env, v);
    bind_sea(r, env, &v->part);
    bind_wakes(r, env, v);
    bind_eye(r, env, v);
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
                     const struct view *v, unsigned now)
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
                        const struct pel_environment *env, const struct view *v,
                        unsigned now, bool toned)
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
                          const struct pel_environment *env, struct view *v,
                          unsigned now)
{
    plan_tiles_under(r, env, v);
    bind_seabed(r, env, &v->part);
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
    struct view v = { .draw = draw, .border = border };
    plan_pixels(r, env, &v);
    if (v.high) {
        draw_high(r, env, &v);
        return PEL_OK;
    }
    const bool under = pel_lens_under(&v.lens);
    const bool wet = v.lens.state == PEL_LENS_WET;
    plan_mesh(r, env, &v, wet);
    plan_discs(r, env, &v);
    r->programs.above = pel_view_above_clouds(env, v.whole.altitude_m);
    v.programs = pel_programs_of(&r->programs, env->sea);
    if (!wet) {
        plan_tiles(r, env, &v);
    }
    if (r->any_coast || under) {
        bind_seabed(r, env, &v.part);
    }
    fill_eye(r, env, &v);
    bind_sea(r, env, &v.part);
    if (under && !pel_under_map_bind(&r->under, env, &r->sky, &v.whole, &v.lens,
                                     &r->arena)) {
        return PEL_ERR_NO_MEMORY;
    }
    bind_eye(r, env, &v);
    if (under) {
        pel_under_map_shafts(&r->under, env, &r->programs);
    }
    pel_targets_fit(&r->targets, v.part.width + 2 * (uint32_t)r->margin,
                    v.part.height + 2 * (uint32_t)r->margin, v.asked);
    pel_stage_begin(&r->timing);
    pel_sky_bind_eye(&r->sky, env, v.table_height_m);
    pel_stage_end(&r->timing, PEL_STAGE_SKY);
    const unsigned now = pel_view_at_once(env, draw, v.asked, is_late(&v));
    const bool toned = pel_shade_tones(r, now);
    if (!wet) {
        draw_in_air(r, env, &v, now, toned);
    }
    if (under) {
        if (!wet) {
            plan_mesh(r, env, &v, true);
            fill_eye(r, env, &v);
            bind(r, PEL_BLOCK_EYE, &v.eye, sizeof v.eye);
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
    err = pel_readback_push(&r->readback, &source);
    pel_stage_end(&r->timing, PEL_STAGE_READBACK);
    return err;
}
