#include "models/model.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "models/bvh.h"
#include "models/openness.h"
#include "models/shape.h"

/* What the public part points into. */
struct held {
    struct pel_model public; /* first */
    atomic_uint refs;
    struct pel_bvh *bvh;
    void *blocks[9 + PEL_MODEL_LEVELS + PEL_MODEL_MOST_TEXTURES];
    size_t block_count;
};

static atomic_uint_least64_t serials;

static const char *const names[] = {
#define PEL_MODEL_CLASS(id, text) #id,
#include "models/classes.def"
};
static const char *const texts[] = {
#define PEL_MODEL_CLASS(id, text) text,
#include "models/classes.def"
};

const char *pel_model_class_name(enum pel_model_class class)
{
    return (unsigned)class < PEL_MODEL_CLASSES ? names[class] : names[0];
}

const char *pel_model_class_text(enum pel_model_class class)
{
    return (unsigned)class < PEL_MODEL_CLASSES ? texts[class] : texts[0];
}

static bool is_text(const char *text, size_t size)
{
    return memchr(text, '\0', size) != NULL;
}

static bool within(double v, double low, double high)
{
    return v >= low && v <= high; /* NaN: no */
}

static bool check_counts(const struct pel_model *d)
{
    return (unsigned)d->class < PEL_MODEL_CLASSES &&
           is_text(d->name, sizeof d->name) && d->vertex_count >= 3 &&
           d->vertex_count <= PEL_MODEL_MOST_VERTICES && d->index_count >= 3 &&
           d->index_count <= 3 * 2 * (size_t)PEL_MODEL_MOST_TRIANGLES &&
           d->material_count >= 1 &&
           d->material_count <= PEL_MODEL_MOST_MATERIALS &&
           d->texture_count <= PEL_MODEL_MOST_TEXTURES && d->node_count >= 1 &&
           d->node_count <= PEL_MODEL_MOST_NODES && d->level_count >= 1 &&
           d->level_count <= PEL_MODEL_LEVELS &&
           d->eye_count <= PEL_MODEL_MOST_EYES &&
           d->light_count <= PEL_MODEL_MOST_LIGHTS;
}

static bool check_vertices(const struct pel_model *d)
{
    for (size_t i = 0; i < d->vertex_count; i++) {
        const struct pel_model_vertex *v = &d->vertices[i];
        double length = 0;
        for (int k = 0; k < 3; k++) {
            if (!within((double)v->position[k], -PEL_MODEL_MOST_SIZE_M,
                        PEL_MODEL_MOST_SIZE_M)) {
                return false;
            }
            length += (double)v->normal[k] * (double)v->normal[k];
        }
        if (!within(length, 0.99, 1.01) ||
            !within((double)v->uv[0], -1e6, 1e6) ||
            !within((double)v->uv[1], -1e6, 1e6)) {
            return false;
        }
    }
    for (size_t i = 0; i < d->index_count; i++) {
        if (d->indices[i] >= d->vertex_count) {
            return false;
        }
    }
    return true;
}

static bool check_level(const struct pel_model *d,
                        const struct pel_model_level *l, size_t *next)
{
    size_t count = 0;
    if (l->part_count < 1 ||
        l->part_count >
            (size_t)PEL_MODEL_MOST_MATERIALS * PEL_MODEL_MOST_NODES ||
        !within((double)l->error_m, 0, 1e4)) {
        return false;
    }
    for (size_t i = 0; i < l->part_count; i++) {
        const struct pel_model_part *p = &l->parts[i];
        if (p->first != *next || p->count < 3 || p->count % 3 != 0 ||
            p->count > d->index_count - *next ||
            p->material >= d->material_count || p->node >= d->node_count) {
            return false;
        }
        *next += p->count;
        count += p->count / 3;
    }
    return count == l->triangles && count <= PEL_MODEL_MOST_TRIANGLES;
}

static bool check_materials(const struct pel_model *d)
{
    for (size_t i = 0; i < d->material_count; i++) {
        const struct pel_model_material *m = &d->materials[i];
        bool fine = is_text(m->name, sizeof m->name) &&
                    within((double)m->metallic, 0, 1) &&
                    within((double)m->roughness, 0.02, 1) &&
                    within((double)m->alpha_cutoff, 0, 1) && m->texture >= -1 &&
                    m->texture < (int)d->texture_count;
        for (int k = 0; k < 3; k++) {
            fine = fine && within((double)m->albedo[k], 0, 1);
        }
        if (!fine) {
            return false;
        }
    }
    size_t texels = 0;
    for (size_t i = 0; i < d->texture_count; i++) {
        const struct pel_model_texture *t = &d->textures[i];
        if (t->width < 1 || t->width > PEL_MODEL_MOST_SIDE || t->height < 1 ||
            t->height > PEL_MODEL_MOST_SIDE) {
            return false;
        }
        texels += (size_t)t->width * (size_t)t->height;
    }
    return texels <= PEL_MODEL_MOST_TEXELS;
}

static bool is_place(struct pel_vec3 at)
{
    const double most = PEL_MODEL_MOST_SIZE_M;
    return within(at.x, -most, most) && within(at.y, -most, most) &&
           within(at.z, -most, most);
}

static bool check_points(const struct pel_model *d)
{
    for (size_t i = 0; i < d->node_count; i++) {
        if (!is_text(d->nodes[i], PEL_MODEL_NAME)) {
            return false;
        }
    }
    for (size_t i = 0; i < d->eye_count; i++) {
        if (!is_text(d->eyes[i].name, PEL_MODEL_NAME) ||
            !is_place(d->eyes[i].at)) {
            return false;
        }
    }
    for (size_t i = 0; i < d->light_count; i++) {
        const struct pel_model_light *l = &d->lights[i];
        bool fine = is_text(l->name, PEL_MODEL_NAME) && is_place(l->at) &&
                    within((double)l->range_m, 0, 1e5) &&
                    within((double)l->from_rad, -100, 100) &&
                    within((double)l->to_rad, -100, 100);
        for (int k = 0; k < 3; k++) {
            fine = fine && within((double)l->colour[k], 0, 1);
        }
        if (!fine) {
            return false;
        }
    }
    return within(d->length_m, 0, PEL_MODEL_MOST_SIZE_M) &&
           within(d->beam_m, 0, PEL_MODEL_MOST_SIZE_M) &&
           within(d->draught_m, 0, PEL_MODEL_MOST_SIZE_M) &&
           within(d->height_m, 0, PEL_MODEL_MOST_SIZE_M);
}

static enum pel_err check(const struct pel_model *d, struct pel_fault *fault)
{
    if (!check_counts(d)) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "more than a model may have");
    }
    if (!check_vertices(d)) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "a vertex is no number, farther than %.0f m from "
                             "the middle, or not there",
                             PEL_MODEL_MOST_SIZE_M);
    }
    size_t next = 0;
    for (int i = 0; i < d->level_count; i++) {
        if (!check_level(d, &d->levels[i], &next)) {
            return pel_fault_set(fault, PEL_ERR_MALFORMED,
                                 "level %d of its triangles is damaged", i);
        }
    }
    if (!check_materials(d)) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "a material or texture is out of range");
    }
    return check_points(d)
               ? PEL_OK
               : pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                               "a name, size, eye point or light is out of "
                               "range");
}

/* A copy that the model owns; NULL: no memory. */
static const void *keep(struct held *h, const void *from, size_t size)
{
    void *copy = malloc(size + 1);
    if (copy) {
        if (size > 0) {
            memcpy(copy, from, size);
        }
        h->blocks[h->block_count++] = copy;
        h->public.bytes += size;
    }
    return copy;
}

static bool copy_textures(struct held *h, const struct pel_model *d)
{
    struct pel_model_texture *to = NULL;
    if (d->texture_count > 0) {
        to = malloc(d->texture_count * sizeof *to);
        if (!to) {
            return false;
        }
        h->blocks[h->block_count++] = to;
    }
    h->public.textures = to;
    for (size_t i = 0; i < d->texture_count; i++) {
        to[i] = d->textures[i];
        to[i].rgba = keep(h, d->textures[i].rgba,
                          4 * (size_t)to[i].width * (size_t)to[i].height);
        if (!to[i].rgba) {
            return false;
        }
    }
    return true;
}

static bool copy(struct held *h, const struct pel_model *d)
{
    struct pel_model *m = &h->public;
    *m = *d;
    m->bytes = sizeof *h;
    m->bvh = NULL;
    m->open = NULL;
    m->columns = NULL;
    m->column_count = 0;
    for (int i = 0; i < d->level_count; i++) {
        m->levels[i].parts =
            keep(h, d->levels[i].parts,
                 d->levels[i].part_count * sizeof *d->levels[i].parts);
        if (!m->levels[i].parts) {
            return false;
        }
    }
    m->vertices = keep(h, d->vertices, d->vertex_count * sizeof *d->vertices);
    m->indices = keep(h, d->indices, d->index_count * sizeof *d->indices);
    m->materials =
        keep(h, d->materials, d->material_count * sizeof *d->materials);
    m->nodes = keep(h, d->nodes, d->node_count * sizeof *d->nodes);
    m->eyes = keep(h, d->eyes, d->eye_count * sizeof *d->eyes);
    m->lights = keep(h, d->lights, d->light_count * sizeof *d->lights);
    return m->vertices && m->indices && m->materials && m->nodes && m->eyes &&
           m->lights && copy_textures(h, d);
}

static void measure(struct pel_model *m)
{
    double low[3] = { INFINITY, INFINITY, INFINITY };
    double high[3] = { -INFINITY, -INFINITY, -INFINITY };
    for (size_t i = 0; i < m->vertex_count; i++) {
        const float *p = m->vertices[i].position;
        double r2 = 0;
        for (int k = 0; k < 3; k++) {
            low[k] = fmin(low[k], (double)p[k]);
            high[k] = fmax(high[k], (double)p[k]);
            r2 += (double)p[k] * (double)p[k];
        }
        m->radius_m = fmax(m->radius_m, sqrt(r2));
    }
    m->low = (struct pel_vec3){ low[0], low[1], low[2] };
    m->high = (struct pel_vec3){ high[0], high[1], high[2] };
    m->length_m = m->length_m > 0 ? m->length_m : high[0] - low[0];
    m->beam_m = m->beam_m > 0 ? m->beam_m : high[1] - low[1];
    m->draught_m = m->draught_m > 0 ? m->draught_m : fmax(0, -low[2]);
    m->height_m = m->height_m > 0 ? m->height_m : fmax(0, high[2]);
}

#define ALONG 24
#define ACROSS 8

/* Columns on a lattice of the box of what is under water. */
static bool stand(struct held *h)
{
    struct pel_model *m = &h->public;
    struct pel_model_column columns[ALONG * ACROSS];
    double low[2] = { INFINITY, INFINITY }, high[2] = { -INFINITY, -INFINITY };
    for (size_t i = 0; i < 3 * m->levels[0].triangles; i++) {
        const float *p = m->vertices[m->indices[i]].position;
        for (int k = 0; k < 2 && p[2] < 0; k++) {
            low[k] = fmin(low[k], (double)p[k]);
            high[k] = fmax(high[k], (double)p[k]);
        }
    }
    double dx = (high[0] - low[0]) / ALONG, dy = (high[1] - low[1]) / ACROSS;
    const struct pel_vec3 up = { 0, 0, 1 };
    size_t count = 0;
    for (int i = 0; i < ALONG * ACROSS && dx > 0 && dy > 0; i++) {
        struct pel_model_hit hit;
        double x = low[0] + (i / ACROSS + 0.5) * dx;
        double y = low[1] + (i % ACROSS + 0.5) * dy;
        double below = m->low.z - 1;
        if (pel_model_cast(m, (struct pel_vec3){ x, y, below }, up, -below,
                           &hit)) {
            columns[count++] =
                (struct pel_model_column){ (float)x, (float)y,
                                           (float)(below + hit.distance_m),
                                           (float)(dx * dy) };
        }
    }
    m->columns = keep(h, columns, count * sizeof *columns);
    m->column_count = count;
    return m->columns != NULL;
}

static void destroy(struct held *h)
{
    for (size_t i = 0; i < h->block_count; i++) {
        free(h->blocks[i]);
    }
    pel_bvh_free(h->bvh);
    free(h);
}

enum pel_err pel_model_create(const struct pel_model *draft,
                              const struct pel_model **out,
                              struct pel_fault *fault)
{
    enum pel_err err = check(draft, fault);
    *out = NULL;
    if (err) {
        return err;
    }
    struct held *h = calloc(1, sizeof *h);
    if (!h || !copy(h, draft) ||
        !(h->bvh = pel_bvh_create(h->public.vertices, h->public.indices,
                                  h->public.levels[0].triangles))) {
        if (h) {
            destroy(h);
        }
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    h->public.bvh = h->bvh;
    h->public.bytes += pel_bvh_bytes(h->bvh);
    h->public.serial = atomic_fetch_add(&serials, 1) + 1;
    measure(&h->public);
    if (!stand(h)) {
        destroy(h);
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    atomic_init(&h->refs, 1);
    *out = &h->public;
    return PEL_OK;
}

enum pel_err pel_model_shade(const struct pel_model *model,
                             struct pel_fault *fault)
{
    struct held *h = (struct held *)model;
    size_t size = model->vertex_count * sizeof(struct pel_model_open);
    struct pel_model_open *open = model->open ? NULL : malloc(size);
    if (model->open) {
        return PEL_OK;
    }
    if (!open) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    pel_model_openness(model, open);
    h->public.open = open;
    h->blocks[h->block_count++] = open;
    h->public.bytes += size;
    return PEL_OK;
}

const struct pel_model *pel_model_ref(const struct pel_model *model)
{
    if (model) {
        atomic_fetch_add(&((struct held *)model)->refs, 1);
    }
    return model;
}

void pel_model_unref(const struct pel_model *model)
{
    struct held *h = (struct held *)model;
    if (h && atomic_fetch_sub(&h->refs, 1) == 1) {
        destroy(h);
    }
}

static const struct pel_model_part *part_of(const struct pel_model *m,
                                            uint32_t triangle)
{
    const struct pel_model_level *l = &m->levels[0];
    size_t low = 0, high = l->part_count - 1;
    while (low < high) {
        size_t middle = (low + high + 1) / 2;
        if (l->parts[middle].first <= 3 * (size_t)triangle) {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    return &l->parts[low];
}

static size_t wrapped(double v, int size)
{
    double at = floor((v - floor(v)) * size);
    return (size_t)pel_clamp(at, 0, size - 1);
}

/* Whether the texel that is met is there. */
static bool solid(const void *user, const struct pel_bvh_hit *hit)
{
    const struct pel_model *m = user;
    const struct pel_model_material *a =
        &m->materials[part_of(m, hit->triangle)->material];
    if (a->alpha_cutoff <= 0 || a->texture < 0) {
        return true;
    }
    const struct pel_model_texture *t = &m->textures[a->texture];
    const uint32_t *corners = m->indices + 3 * (size_t)hit->triangle;
    double uv[2];
    for (int k = 0; k < 2; k++) {
        uv[k] = (1 - hit->u - hit->v) * (double)m->vertices[corners[0]].uv[k] +
                hit->u * (double)m->vertices[corners[1]].uv[k] +
                hit->v * (double)m->vertices[corners[2]].uv[k];
    }
    size_t texel =
        wrapped(uv[1], t->height) * (size_t)t->width + wrapped(uv[0], t->width);
    return t->rgba[4 * texel + 3] / 255.0 >= (double)a->alpha_cutoff;
}

static struct pel_vec3 corner(const struct pel_model *m, uint32_t index)
{
    const float *p = m->vertices[index].position;
    return (struct pel_vec3){ (double)p[0], (double)p[1], (double)p[2] };
}

bool pel_model_cast(const struct pel_model *model, struct pel_vec3 origin,
                    struct pel_vec3 direction, double most_m,
                    struct pel_model_hit *hit)
{
    struct pel_bvh_hit found;
    const struct held *h = (const struct held *)model;
    if (!pel_bvh_cast(h->bvh, origin, direction, most_m, solid, model,
                      &found)) {
        return false;
    }
    const uint32_t *i = model->indices + 3 * (size_t)found.triangle;
    const struct pel_model_part *part = part_of(model, found.triangle);
    struct pel_vec3 a = corner(model, i[0]);
    struct pel_vec3 b =
        pel_vec3_add(corner(model, i[1]), pel_vec3_scale(a, -1));
    struct pel_vec3 c =
        pel_vec3_add(corner(model, i[2]), pel_vec3_scale(a, -1));
    struct pel_vec3 n = pel_vec3_normalize(pel_vec3_cross(b, c));
    *hit = (struct pel_model_hit){
        .distance_m = found.distance,
        .triangle = found.triangle,
        .material = part->material,
        .node = part->node,
        .normal = pel_vec3_scale(n, pel_vec3_dot(n, direction) > 0 ? -1 : 1),
        .front = found.front,
    };
    return true;
}

bool pel_model_top(const struct pel_model *model, double x, double y,
                   struct pel_model_hit *hit, double *z)
{
    double from = model->high.z + 1;
    if (!pel_model_cast(model, (struct pel_vec3){ x, y, from },
                        (struct pel_vec3){ 0, 0, -1 }, from - model->low.z + 1,
                        hit)) {
        return false;
    }
    *z = from - hit->distance_m;
    return true;
}

int pel_model_level_for(const struct pel_model *model, double pixels_per_m,
                        double most_px)
{
    int level = model->level_count - 1;
    while (level > 0 &&
           (double)model->levels[level].error_m * pixels_per_m > most_px) {
        level--;
    }
    return level;
}
