#include "render/viewplan.h"

#include <stdlib.h>

#include "base/reserve.h"
#include "ocean/wash.h"
#include "render/acuity.h"
#include "render/edges.h"
#include "render/rendererstate.h"
#include "render/shader.h"
#include "render/spacepass.h"
#include "render/uniforms.h"

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

bool pel_view_is_late(const struct pel_view *v)
{
    return pel_lens_under(&v->lens) || (v->share > 0.0 && v->share < 1.0);
}

/* What decides how a pixel is drawn is planned for the whole picture. */
void pel_view_plan_pixels(struct pel_renderer *r,
                          const struct pel_environment *env, struct pel_view *v)
{
    const struct pel_draw *draw = v->draw;
    const int border = v->border;
    v->lens = pel_lens_place(env, &draw->camera);
    v->share = pel_space_share(env, draw->camera.altitude_m);
    v->high = v->share >= 1.0;
    v->asked = pel_view_layers(r, env, draw, pel_view_is_late(v));
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

void pel_view_plan_mesh(const struct pel_renderer *r,
                        const struct pel_environment *env,
                        const struct pel_view *v, bool under,
                        const struct pel_mesh *like, struct pel_mesh *mesh)
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
    pel_mesh_plan(&eye, under ? &over : &v->wide, like, mesh);
    if (v->part.height < v->whole.height) {
        const struct pel_camera narrow = pel_edges_camera(&v->part, r->margin);
        const struct pel_camera other = turned_over(&narrow);
        pel_mesh_narrow(&eye, under ? &other : &narrow, mesh);
    }
}

/* --- what the shaders read ------------------------------------------------ */

void pel_view_bind(struct pel_renderer *r, GLuint block, const void *data,
                   size_t size)
{
    pel_arena_bind(&r->arena, GL_UNIFORM_BUFFER, block, data, size);
}

void pel_view_bind_seabed(struct pel_renderer *r,
                          const struct pel_environment *env,
                          const struct pel_camera *c)
{
    struct pel_block_seabed block;
    if (env->seabed) {
        pel_seabed_map_bind(&r->seabed);
    }
    pel_fill_seabed(env, &r->seabed, r->statistics.variance, r->sky.water.beams,
                    c->east_m, c->north_m, &block);
    pel_view_bind(r, PEL_BLOCK_SEABED, &block, sizeof block);
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
        if (pel_sea_is_stored(r->context.software)) {
            glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_WAVES,
                             r->tables.waves.buffer);
        }
    }
}

void pel_view_bind_net(const struct pel_renderer *r, GLuint vertices)
{
    if (pel_sea_is_stored(r->context.software)) {
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_NET, vertices);
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
    pel_view_bind(r, PEL_BLOCK_WASH, &block, sizeof block);
}

void pel_view_bind_sea(struct pel_renderer *r,
                       const struct pel_environment *env,
                       const struct pel_camera *c)
{
    const bool cascades = env->sea->cascades != NULL;
    if (cascades) {
        struct pel_block_cascades block;
        pel_fill_cascades(env->sea->cascades, c->east_m, c->north_m, &block);
        pel_view_bind(r, PEL_BLOCK_CASCADES, &block, sizeof block);
    } else {
        bind_waves(r, env, c);
    }
    if (env->sea->shore) {
        struct pel_block_shore block;
        pel_shore_map_bind(&r->shore, env->sea->shore, cascades, c->east_m,
                           c->north_m, &block);
        pel_view_bind(r, PEL_BLOCK_SHORE, &block, sizeof block);
    }
    if (env->sea->desc.area_count || env->wash) {
        struct pel_block_areas block;
        pel_fill_areas(env, c->east_m, c->north_m, &block);
        pel_view_bind(r, PEL_BLOCK_AREAS, &block, sizeof block);
    }
    if (env->wash) {
        bind_wash(r, env, c);
    }
    pel_sea_texels_bind(&r->tables);
}

void pel_view_fill_eye(const struct pel_environment *env,
                       const struct pel_mesh *mesh, struct pel_view *v)
{
    const struct pel_camera *c = &v->part;
    pel_fill_eye(v->height_m, v->table_height_m, mesh, &v->eye);
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
double pel_view_meter_height(const struct pel_environment *env,
                             const struct pel_camera *c)
{
    double altitude_m = c->sight_count
                            ? c->sights[0].altitude_m - env->sea_level_m
                            : c->altitude_m;
    return fmax(altitude_m, PEL_LEAST_EYE_M);
}

void pel_view_fill_meter(const struct pel_environment *env,
                         const struct pel_camera *c, struct pel_block_eye *eye,
                         struct pel_block_sighted *sights)
{
    double height_m = pel_view_meter_height(env, c);
    pel_fill_eye(height_m, pel_sky_quantize_height(height_m), NULL, eye);
    pel_fill_spray(env->sea->foam, height_m, eye);
    pel_fill_fog(env, c->east_m, c->north_m, eye);
    pel_fill_sights(env, c, sights);
    pel_acuity_meter(env, c, sights);
}

static void expose(struct pel_renderer *r, const struct pel_environment *env,
                   const struct pel_camera *c, bool under)
{
    double height_m = pel_view_meter_height(env, c);
    struct pel_block_eye eye;
    struct pel_block_sighted sights;
    pel_view_fill_meter(env, c, &eye, &sights);
    pel_view_bind(r, PEL_BLOCK_EYE, &eye, sizeof eye);
    pel_view_bind(r, PEL_BLOCK_SIGHTS, &sights, sizeof sights);
    double share = pel_space_share(env, height_m);
    if (share < 1.0) {
        pel_sky_bind_eye(&r->sky, env, pel_sky_quantize_height(height_m));
        pel_meter_run(&r->meter, env, under);
    }
    if (share > 0.0) {
        pel_space_expose(r, env, c, height_m);
    }
}

void pel_view_bind_eye(struct pel_renderer *r,
                       const struct pel_environment *env,
                       const struct pel_view *v)
{
    pel_view_bind(r, PEL_BLOCK_EYE, &v->eye, sizeof v->eye);
    pel_view_bind(r, PEL_BLOCK_VIEW, &v->block, sizeof v->block);
    if (v->asked & PEL_LAYER_COLOR || v->whole.auto_exposure ||
        pel_sensing_is(&v->whole)) {
        expose(r, env, &v->draw->camera, pel_lens_under(&v->lens));
        pel_view_bind(r, PEL_BLOCK_EYE, &v->eye, sizeof v->eye);
    }
}

void pel_view_bind_wakes(struct pel_renderer *r,
                         const struct pel_environment *env,
                         const struct pel_view *v)
{
    if (env->wakes) {
        struct pel_block_wakes block;
        pel_wake_map_bind(&r->wakes, env, v->part.east_m, v->part.north_m,
                          &block);
        pel_view_bind(r, PEL_BLOCK_WAKES, &block, sizeof block);
    }
}

enum pel_ycbcr pel_view_ycbcr(const struct pel_renderer *r,
                              const struct pel_draw *draw)
{
    return r->programs.compute && draw->layers == PEL_LAYER_COLOR &&
                   draw->rows == 0
               ? draw->ycbcr
               : PEL_YCBCR_NONE;
}
