#include "render/together.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "render/acuity.h"
#include "render/edges.h"
#include "render/meshpass.h"
#include "render/rendererstate.h"
#include "render/shader.h"
#include "render/spacepass.h"
#include "render/uniforms.h"

/* Of views that are drawn together, unless one alone has more: by then a large
 * device is busy and several wait less for each other's commands, and a pixel
 * takes 40 bytes of its memory. */
#define MOST_PIXELS ((size_t)8 << 20)
/* Parts of lists begin on cache lines. */
#define PIXEL_ALIGN 64
/* What does not need a quarter of the memory this often in a row gives it back.
 */
#define SMALL_DRAWS 256
#define KEPT_PIXELS (1u << 20) /* by who rests */
/* Before the entries of a list: how many each view has. */
#define LIST_HEAD (PEL_TOGETHER_MOST * sizeof(GLuint))
/* Pixels of a view to a thread that takes one entry after the other: few more
 * are suspected or cut. An indirect dispatch waits longer to begin. */
#define PIXELS_A_SUSPECT 16
#define PIXELS_AN_EDGE 32
#define CLEAR_COLUMNS 1024u

struct pel_view_together {
    struct pel_draw draw; /* its camera above the sea's zero */
    struct pel_view view;
    struct pel_mesh mesh;
    int margin;
    size_t first_pixel, first_vertex; /* of the lists */
    struct pel_block_sighted sights;
};

/* --- which views ---------------------------------------------------------- */

static bool is_plain(const struct pel_environment *env)
{
    return !env->seabed && env->object_count == 0 && env->lamp_count == 0 &&
           !(env->clouds.cover > 0) && !env->night.on && env->stale == 0;
}

static double height_of(const struct pel_camera *c)
{
    return fmax(c->altitude_m, PEL_LEAST_EYE_M);
}

bool pel_together_can(const struct pel_renderer *r,
                      const struct pel_environment *env,
                      const struct pel_draw *draw)
{
    if (!r->programs.compute || r->together.off || !is_plain(env) ||
        draw->layers != PEL_LAYER_COLOR || draw->rows > 0 ||
        pel_sensing_is(&draw->camera)) {
        return false;
    }
    struct pel_camera here = draw->camera;
    here.altitude_m -= env->sea_level_m;
    const unsigned shaded = PEL_LAYER_COLOR | PEL_LAYER_RADIANCE;
    if (pel_space_share(env, height_of(&here)) > 0.0 ||
        pel_space_share(env, pel_view_meter_height(env, &here)) > 0.0 ||
        pel_fall_map_shows(env, shaded) || pel_pane_map_shows(&here, shaded) ||
        pel_acuity_border(env, &here, draw->layers) > 0) {
        return false;
    }
    const struct pel_lens_place lens = pel_lens_place(env, &here);
    return !pel_lens_under(&lens);
}

static enum pel_err need_programs(struct pel_renderer *r,
                                  const struct pel_environment *env,
                                  bool outlines, struct pel_fault *fault)
{
    struct pel_together *t = &r->together;
    const char *defines = "#define PEL_TOGETHER\n#define PEL_KEYS\n";
    const struct {
        GLuint *program;
        const char *file, *defines;
        bool wanted;
    } needed[] = {
        { &t->search, "search.comp", defines, true },
        { &t->find, "outline_find.comp", defines, outlines },
        { &t->outline, "outline.comp", defines, outlines },
        { &t->clear, "clear.comp", NULL, outlines },
    };
    enum pel_err err =
        pel_meter_need_together(&r->meter, env, r->shader_dir, fault);
    if (err == PEL_OK) {
        err =
            pel_programs_need_together(&r->programs, env->sea, outlines, fault);
    }
    for (size_t i = 0; i < sizeof needed / sizeof *needed; i++) {
        if (err == PEL_OK && needed[i].wanted && !*needed[i].program) {
            err =
                pel_program_create(r->shader_dir, needed[i].file, NULL,
                                   needed[i].defines, needed[i].program, fault);
        }
    }
    return err;
}

enum pel_err pel_together_need(struct pel_renderer *r,
                               const struct pel_environment *env,
                               const struct pel_draw *draw,
                               struct pel_fault *fault)
{
    struct pel_together *t = &r->together;
    if (!t->views) {
        t->views = calloc(PEL_TOGETHER_MOST, sizeof *t->views);
        if (!t->views) {
            return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
        }
    }
    enum pel_err err =
        need_programs(r, env, pel_view_edges(r, &draw->camera), fault);
    if (err == PEL_ERR_GPU && r->programs.automatic) {
        pel_warn("RND-043", "%s; views are drawn one by one", fault->message);
        t->off = true;
        return PEL_OK;
    }
    return err;
}

/* --- planning ------------------------------------------------------------- */

/* What views that are drawn together share: the sea as it is read from a place,
 * and the tables of their eye and of the eye they are metered by. */
static bool is_of_same_eye(const struct pel_environment *env,
                           const struct pel_view_together *a,
                           const struct pel_view_together *b)
{
    const struct pel_camera *p = &a->draw.camera, *q = &b->draw.camera;
    return p->east_m == q->east_m && p->north_m == q->north_m &&
           p->altitude_m == q->altitude_m && a->margin == b->margin &&
           pel_view_meter_height(env, p) == pel_view_meter_height(env, q);
}

static size_t pixels_of(const struct pel_view_together *v)
{
    size_t pixels = (size_t)v->view.block.size.x * (size_t)v->view.block.size.y;
    return (pixels + PIXEL_ALIGN - 1) / PIXEL_ALIGN * PIXEL_ALIGN;
}

size_t pel_together_plan(struct pel_renderer *r,
                         const struct pel_environment *env,
                         const struct pel_draw *draws, size_t count)
{
    struct pel_together *t = &r->together;
    size_t pixels = 0, vertices = 0;
    t->count = 0;
    while (t->count < count && t->count < PEL_TOGETHER_MOST &&
           pel_together_can(r, env, &draws[t->count])) {
        struct pel_view_together *v = &t->views[t->count];
        v->draw = draws[t->count];
        v->draw.camera.altitude_m -= env->sea_level_m;
        v->view = (struct pel_view){ .draw = &v->draw };
        pel_view_plan_pixels(r, env, &v->view);
        v->margin = r->margin;
        size_t own = pixels_of(v);
        if (t->count > 0 && (pixels + own > MOST_PIXELS ||
                             !is_of_same_eye(env, v, &t->views[0]))) {
            break;
        }
        pel_view_plan_mesh(r, env, &v->view, false, &t->views[0].mesh,
                           &v->mesh);
        v->first_pixel = pixels;
        v->first_vertex = vertices;
        pixels += own;
        vertices += (size_t)v->mesh.vertex_count;
        t->count++;
    }
    return t->count;
}

/* --- memory --------------------------------------------------------------- */

static GLuint make_buffer(size_t bytes, const char *label)
{
    GLuint buffer = 0;
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, (GLsizeiptr)bytes, NULL,
                         GL_DYNAMIC_STORAGE_BIT);
    glObjectLabel(GL_BUFFER, buffer, -1, label);
    return buffer;
}

static void drop_memory(struct pel_together *t)
{
    const GLuint buffers[] = { t->vertices, t->keys, t->suspects, t->edges,
                               t->radiance };
    glDeleteBuffers(5, buffers);
    glDeleteTextures(1, &t->texels);
    t->vertices = t->keys = t->suspects = t->edges = t->radiance = 0;
    t->texels = 0;
    t->vertex_capacity = t->pixel_capacity = 0;
}

static void fit_vertices(struct pel_together *t, size_t vertices)
{
    if (vertices <= t->vertex_capacity) {
        return;
    }
    t->vertex_capacity = vertices + vertices / 4;
    glDeleteBuffers(1, &t->vertices);
    t->vertices =
        make_buffer(t->vertex_capacity * PEL_VERTEX_BYTES, "vertices together");
    if (!t->texels) {
        glCreateTextures(GL_TEXTURE_BUFFER, 1, &t->texels);
    }
    glTextureBuffer(t->texels, GL_RGBA32F, t->vertices);
}

static void fit_pixels(struct pel_together *t, size_t pixels, bool outlines)
{
    t->small_draws = 4 * pixels < t->pixel_capacity ? t->small_draws + 1 : 0;
    if (t->small_draws > SMALL_DRAWS) {
        drop_memory(t);
        t->small_draws = 0;
    }
    bool more = pixels > t->pixel_capacity;
    if (more) {
        drop_memory(t);
        t->pixel_capacity = pixels;
        t->keys = make_buffer(pixels * sizeof(GLuint), "keys together");
        glClearNamedBufferData(t->keys, GL_R32UI, GL_RED_INTEGER,
                               GL_UNSIGNED_INT, NULL);
    }
    if (outlines && !t->radiance) {
        const size_t all = t->pixel_capacity;
        t->suspects = make_buffer(LIST_HEAD + all * 4, "suspects together");
        t->edges = make_buffer(LIST_HEAD + all * 8, "edges together");
        t->radiance = make_buffer(all * 16, "radiance together");
    }
}

/* --- memory for what was planned ------------------------------------------ */

static struct pel_readback_source source_of(const struct pel_renderer *r,
                                            const struct pel_view_together *v,
                                            int64_t started_ns)
{
    const struct pel_camera *c = &v->draw.camera;
    return (struct pel_readback_source){
        .auto_exposure = c->auto_exposure,
        .exposure_ev = c->exposure_ev,
        .width = c->width,
        .height = c->height,
        .rows = c->height,
        .layers = v->draw.layers,
        .ycbcr = pel_view_ycbcr(r, &v->draw),
        .quality = v->draw.quality,
        .user = v->draw.user,
        .started_ns = started_ns,
    };
}

static enum pel_err reserve_slots(struct pel_renderer *r)
{
    struct pel_together *t = &r->together;
    int64_t started_ns = pel_now_ns();
    for (size_t i = 0; i < t->count; i++) {
        const struct pel_readback_source source =
            source_of(r, &t->views[i], started_ns);
        t->slots[i] = pel_readback_reserve(&r->readback, &source);
        if (!t->slots[i]) {
            pel_readback_unreserve(t->slots, i);
            return PEL_ERR_NO_MEMORY;
        }
    }
    return PEL_OK;
}

/* Where any becomes planes, the colours of all stay on the device until they
 * are made. */
static void fit_planes(struct pel_renderer *r)
{
    struct pel_together *t = &r->together;
    t->any_planes = false;
    for (size_t i = 0; i < t->count; i++) {
        const struct pel_draw *draw = &t->views[i].draw;
        t->planes[i] = (struct pel_ycbcr_view){ .form = pel_view_ycbcr(r, draw),
                                                .quality = draw->quality,
                                                .width = draw->camera.width,
                                                .height = draw->camera.height,
                                                .slot = t->slots[i] };
        t->any_planes |= t->planes[i].form != PEL_YCBCR_NONE;
    }
    if (t->any_planes) {
        pel_ycbcr_fit(&r->ycbcr, t->planes, t->count);
    }
}

/* --- what the shaders read ------------------------------------------------ */

static void fill(const struct pel_view_together *v, size_t first_ring,
                 size_t ev_word, struct pel_shader_together *out)
{
    const struct pel_mesh *m = &v->mesh;
    _Static_assert(sizeof out->view == sizeof v->view.block,
                   "both have the members of PEL_VIEW_MEMBERS");
    *out = (struct pel_shader_together){
        .columns = { (float)m->column_rad, (float)m->columns_around, 0, 0 },
        .first = { (unsigned)v->first_vertex, (unsigned)first_ring,
                   (unsigned)v->first_pixel, (unsigned)m->vertex_count },
        .picture = { (unsigned)v->margin, (unsigned)ev_word,
                     (unsigned)m->block_count,
                     pel_edges_sideways(&v->view.part) },
    };
    memcpy(&out->view, &v->view.block, sizeof out->view);
    GLuint apart[PEL_OUTLINE_BLOCKS][2];
    pel_edges_apart(m, apart);
    memcpy(out->apart, apart, sizeof apart);
    for (int i = 0; i < m->block_count; i++) {
        const struct pel_mesh_block *b = &m->blocks[i];
        out->blocks[i] =
            (struct pel_uvec4){ (unsigned)b->first_ring, (unsigned)b->rings,
                                (unsigned)b->first_column,
                                (unsigned)b->columns };
        out->bases[i].x = (unsigned)b->base;
    }
}

/* Rings of all meshes, one after the other: where those of each begin. */
static bool place_rings(struct pel_renderer *r, size_t first[PEL_TOGETHER_MOST])
{
    struct pel_together *t = &r->together;
    size_t end = 0;
    for (size_t i = 0; i < t->count; i++) {
        const struct pel_mesh *m = &t->views[i].mesh;
        size_t at = 0;
        size_t bytes =
            sizeof *m->rings * (size_t)(m->ring_count > 0 ? m->ring_count : 1);
        if (!pel_arena_put(&r->arena, m->rings, bytes, &at)) {
            return false;
        }
        t->rings_at = i == 0 ? at : t->rings_at;
        first[i] = (at - t->rings_at) / sizeof *m->rings;
        end = at + bytes;
    }
    t->rings_bytes = end - t->rings_at;
    return true;
}

static bool place_views(struct pel_renderer *r)
{
    struct pel_together *t = &r->together;
    struct pel_block_together block = { 0 };
    size_t rings[PEL_TOGETHER_MOST];
    if (!place_rings(r, rings)) {
        return false;
    }
    for (size_t i = 0; i < t->count; i++) {
        const struct pel_camera *c = &t->views[i].draw.camera;
        fill(&t->views[i], rings[i],
             t->any_planes
                 ? (size_t)c->width * c->height
                 : pel_readback_ev_offset(t->slots[i]) / sizeof(float),
             &block.together[i]);
    }
    return pel_arena_put(&r->arena, &block, sizeof block, &t->views_at);
}

enum pel_err pel_together_reserve(struct pel_renderer *r)
{
    struct pel_together *t = &r->together;
    const struct pel_view_together *last = &t->views[t->count - 1];
    enum pel_err err = reserve_slots(r);
    if (err == PEL_OK) {
        fit_pixels(t, last->first_pixel + pixels_of(last), last->margin > 0);
        fit_vertices(t,
                     last->first_vertex + (size_t)last->mesh.vertex_count + 1);
        fit_planes(r);
        if (!place_views(r)) {
            pel_readback_unreserve(t->slots, t->count);
            err = PEL_ERR_NO_MEMORY;
        }
    }
    return err;
}

void pel_together_rest(struct pel_together *t)
{
    if (t->pixel_capacity > KEPT_PIXELS) {
        drop_memory(t);
    }
}

void pel_together_finish(struct pel_together *t)
{
    drop_memory(t);
    pel_program_delete(t->search);
    pel_program_delete(t->find);
    pel_program_delete(t->outline);
    pel_program_delete(t->clear);
    free(t->views);
    *t = (struct pel_together){ 0 };
}

/* --- drawing -------------------------------------------------------------- */

static void bind_views(struct pel_renderer *r)
{
    const struct pel_together *t = &r->together;
    glBindBufferRange(GL_SHADER_STORAGE_BUFFER, PEL_STORE_RINGS,
                      r->arena.buffer, (GLintptr)t->rings_at,
                      (GLsizeiptr)t->rings_bytes);
    glBindBufferRange(GL_UNIFORM_BUFFER, PEL_BLOCK_VIEW, r->arena.buffer,
                      (GLintptr)t->views_at, sizeof(struct pel_block_together));
    if (t->any_planes) {
        pel_ycbcr_begin(&r->ycbcr, t->planes, t->count);
        return;
    }
    GLuint pictures[PEL_TOGETHER_MOST];
    for (size_t i = 0; i < PEL_TOGETHER_MOST; i++) {
        pictures[i] = pel_readback_buffer(t->slots[i < t->count ? i : 0]);
    }
    glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_PICTURES,
                      PEL_TOGETHER_MOST, pictures);
}

/* Exposures; the eye of their meter and its tables are bound. */
static void meter(struct pel_renderer *r, const struct pel_environment *env)
{
    const struct pel_together *t = &r->together;
    const struct pel_camera *c = &t->views[0].draw.camera;
    struct pel_block_all_sighted sights = { 0 };
    struct pel_block_eye eye;
    for (size_t i = 0; i < t->count; i++) {
        struct pel_block_sighted own;
        pel_view_fill_meter(env, &t->views[i].draw.camera, &eye, &own);
        memcpy(&sights.all_sighted[i], &own, sizeof own);
    }
    pel_view_bind(r, PEL_BLOCK_EYE, &eye, sizeof eye);
    pel_view_bind(r, PEL_BLOCK_SIGHTS, &sights, sizeof sights);
    pel_sky_bind_eye(&r->sky, env,
                     pel_sky_quantize_height(pel_view_meter_height(env, c)));
    pel_meter_run_together(&r->meter, env, (GLuint)t->count);
}

static void bind_eye(struct pel_renderer *r, const struct pel_environment *env)
{
    struct pel_view *first = &r->together.views[0].view;
    pel_view_fill_eye(env, &r->together.views[0].mesh, first);
    pel_view_bind(r, PEL_BLOCK_EYE, &first->eye, sizeof first->eye);
}

/* --- stages --------------------------------------------------------------- */

/* Of all views: most vertices, width and height with what is around it; and the
 * pixels of their lists. */
struct extent {
    int vertices, width, height;
    size_t pixels;
    bool outlines;
};

/* Stages that do not need each other have no barrier between them. The exposure
 * takes as long as finding triangles, on one unit of the device for each view.
 */
static void find_surface(struct pel_renderer *r,
                         const struct pel_environment *env,
                         const struct pel_sea_programs *programs,
                         const struct extent *all)
{
    struct pel_together *t = &r->together;
    const GLuint views = (GLuint)t->count;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_VERTICES, t->vertices);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_KEYS, t->keys);
    glBindTextureUnit(PEL_UNIT_VERTICES, t->texels);
    pel_view_bind_net(r, t->vertices);
    if (all->outlines) {
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_SUSPECTS,
                         t->suspects);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_EDGES, t->edges);
    }
    if (all->vertices > 0) {
        pel_program_use(programs->together_mesh);
        glDispatchCompute(pel_groups(all->vertices, PEL_GROUP_LINE), 1, views);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT |
                        GL_TEXTURE_FETCH_BARRIER_BIT);
    }
    pel_stage_end(&r->timing, PEL_STAGE_MESH);
    meter(r, env);
    if (all->vertices > 0) {
        pel_program_use(t->search);
        pel_mesh_search(2 * all->vertices, views);
    }
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_UNIFORM_BARRIER_BIT);
    pel_stage_end(&r->timing, PEL_STAGE_RASTER);
}

/* Threads of a list that has an entry for one of so many pixels. */
static GLuint list_groups(const struct extent *all, int pixels)
{
    return pel_groups(all->width * all->height, pixels * PEL_GROUP_LINE);
}

/* From the triangles: while pixels are shaded, who follows outlines waits for
 * memory most of the time. */
static void list_outlines(struct pel_renderer *r, const struct extent *all)
{
    struct pel_together *t = &r->together;
    const GLuint views = (GLuint)t->count;
    pel_program_use(t->find);
    glDispatchCompute(pel_groups(all->width, PEL_GROUP_LINE),
                      pel_groups(all->height, PEL_OUTLINE_ROWS), views);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    pel_program_use(t->outline);
    glDispatchCompute(list_groups(all, PIXELS_A_SUSPECT), 1, views);
}

static void shade(struct pel_renderer *r, const struct pel_environment *env,
                  const struct pel_sea_programs *programs,
                  const struct extent *all)
{
    struct pel_together *t = &r->together;
    if (env->wakes) { /* tables of the light had their place */
        pel_wake_map_again(&r->wakes);
    }
    if (env->panorama) {
        glBindTextureUnit(PEL_UNIT_PANORAMA, r->sky.panorama.texture);
    }
    if (t->radiance) {
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_RADIANCE,
                         t->radiance);
    }
    pel_program_use(programs->together);
    glDispatchCompute(pel_groups(all->width, PEL_GROUP_WIDE),
                      pel_groups(all->height, PEL_GROUP_LOW), (GLuint)t->count);
}

static void mix_outlines(struct pel_renderer *r, const struct extent *all)
{
    struct pel_together *t = &r->together;
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    pel_program_use(r->programs.together_mix);
    glDispatchCompute(list_groups(all, PIXELS_AN_EDGE), 1, (GLuint)t->count);
    glBindBufferRange(GL_SHADER_STORAGE_BUFFER, PEL_STORE_KEYS, t->keys, 0,
                      (GLsizeiptr)(all->pixels * sizeof(GLuint)));
    pel_program_use(t->clear);
    glDispatchCompute(
        CLEAR_COLUMNS,
        pel_groups((int)all->pixels, (int)(CLEAR_COLUMNS * PEL_GROUP_LINE)), 1);
}

static struct extent extent_of(const struct pel_together *t)
{
    const struct pel_view_together *last = &t->views[t->count - 1];
    struct extent all = { .pixels = last->first_pixel + pixels_of(last) };
    for (size_t i = 0; i < t->count; i++) {
        const struct pel_view_together *v = &t->views[i];
        const int vertices = v->mesh.vertex_count;
        const int width = (int)v->view.block.size.x;
        const int height = (int)v->view.block.size.y;
        all.vertices = vertices > all.vertices ? vertices : all.vertices;
        all.width = width > all.width ? width : all.width;
        all.height = height > all.height ? height : all.height;
    }
    all.outlines = last->margin > 0 && all.vertices > 0;
    return all;
}

void pel_together_draw(struct pel_renderer *r,
                       const struct pel_environment *env)
{
    struct pel_together *t = &r->together;
    const struct pel_view_together *last = &t->views[t->count - 1];
    const struct extent all = extent_of(t);
    r->programs.above = false;
    const struct pel_sea_programs *programs =
        pel_programs_of(&r->programs, env->sea);
    bind_eye(r, env);
    pel_view_bind_sea(r, env, &last->view.part);
    bind_views(r);
    pel_view_bind_wakes(r, env, &last->view);
    pel_stage_begin(&r->timing);
    find_surface(r, env, programs, &all);
    bind_eye(r, env);
    pel_sky_bind_eye(&r->sky, env, last->view.table_height_m);
    pel_stage_end(&r->timing, PEL_STAGE_SKY);
    if (all.outlines) {
        list_outlines(r, &all);
    }
    shade(r, env, programs, &all);
    if (all.outlines) {
        mix_outlines(r, &all);
    }
    if (t->any_planes) {
        pel_ycbcr_end(&r->ycbcr, t->planes, t->count);
    }
    /* The next ones use the same memory. */
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_UNIFORM_BARRIER_BIT |
                    GL_BUFFER_UPDATE_BARRIER_BIT |
                    GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT);
    pel_stage_end(&r->timing, PEL_STAGE_SHADE);
    pel_readback_send(&r->readback, t->slots, t->count);
    pel_stage_end(&r->timing, PEL_STAGE_READBACK);
}
