#include "models/shape.h"

#include <stdlib.h>
#include <string.h>

#include "models/bvh.h"
#include "models/decimate.h"

#define CREASE 0.766 /* cosine of 40 degrees: sharper edges stay edges */
#define NONE UINT32_MAX
#define FEWEST 24 /* triangles that are worth another level */

/* --- collecting ------------------------------------------------------------
 */

/* Room for one more of `size` bytes; false: there is none. */
static bool grow(struct pel_shape *s, int which, void **array, size_t count,
                 size_t size)
{
    if (s->failed || count < s->room[which]) {
        return !s->failed;
    }
    size_t room = 2 * s->room[which] + 16;
    void *more = realloc(*array, room * size);
    if (!more) {
        s->failed = true;
        return false;
    }
    *array = more;
    s->room[which] = room;
    return true;
}

int pel_shape_material(struct pel_shape *s, const struct pel_model_material *m)
{
    for (size_t i = 0; i < s->material_count; i++) {
        const struct pel_model_material *k = &s->materials[i];
        if (strcmp(k->name, m->name) == 0 &&
            memcmp(k->albedo, m->albedo, sizeof k->albedo) == 0 &&
            k->metallic == m->metallic && k->roughness == m->roughness &&
            k->alpha_cutoff == m->alpha_cutoff &&
            k->two_sided == m->two_sided && k->texture == m->texture) {
            return (int)i;
        }
    }
    if (!grow(s, 1, (void **)&s->materials, s->material_count,
              sizeof *s->materials)) {
        return 0;
    }
    s->materials[s->material_count] = *m;
    return (int)s->material_count++;
}

int pel_shape_node(struct pel_shape *s, const char *name)
{
    if (!grow(s, 2, (void **)&s->nodes, s->node_count, sizeof *s->nodes)) {
        return 0;
    }
    char *to = s->nodes[s->node_count];
    size_t length = strnlen(name, PEL_MODEL_NAME - 1);
    while (length > 0 && ((unsigned char)name[length] & 0xc0) == 0x80) {
        length--;
    }
    memset(to, 0, PEL_MODEL_NAME);
    memcpy(to, name, length);
    return (int)s->node_count++;
}

int pel_shape_texture(struct pel_shape *s, const struct pel_model_texture *t)
{
    if (!grow(s, 3, (void **)&s->textures, s->texture_count,
              sizeof *s->textures)) {
        return -1;
    }
    s->textures[s->texture_count] = *t;
    return (int)s->texture_count++;
}

void pel_shape_triangle(struct pel_shape *s,
                        const struct pel_model_vertex corners[3], int material,
                        int node)
{
    if (s->failed || s->triangle_count > PEL_MODEL_MOST_TRIANGLES) {
        return;
    }
    if (s->triangle_count == s->room[0]) {
        size_t room = 2 * s->room[0] + 256;
        void *c = realloc(s->corners, room * 3 * sizeof *s->corners);
        s->corners = c ? c : s->corners;
        void *t = realloc(s->tags, room * sizeof *s->tags);
        s->tags = t ? t : s->tags;
        if (!c || !t) {
            s->failed = true;
            return;
        }
        s->room[0] = room;
    }
    memcpy(s->corners + 3 * s->triangle_count, corners, 3 * sizeof *s->corners);
    s->tags[s->triangle_count++] =
        (struct pel_shape_tag){ (uint16_t)material, (uint16_t)node };
}

void pel_shape_clear(struct pel_shape *s)
{
    free(s->corners);
    free(s->tags);
    free(s->materials);
    free(s->nodes);
    free(s->textures);
    *s = (struct pel_shape){ 0 };
}

void pel_model_draft_clear(struct pel_model_draft *draft)
{
    for (size_t i = 0; i < sizeof draft->owned / sizeof *draft->owned; i++) {
        free(draft->owned[i]);
    }
    for (int i = 0; i < draft->model.level_count; i++) {
        free((void *)draft->model.levels[i].parts);
    }
    *draft = (struct pel_model_draft){ 0 };
}

/* --- normals ----------------------------------------------------------------
 */

static struct pel_vec3 place(const struct pel_model_vertex *v)
{
    return (struct pel_vec3){ (double)v->position[0], (double)v->position[1],
                              (double)v->position[2] };
}

static struct pel_vec3 minus(struct pel_vec3 a, struct pel_vec3 b)
{
    return (struct pel_vec3){ a.x - b.x, a.y - b.y, a.z - b.z };
}

/* The angle that a triangle has at one of its corners. */
static double angle(const struct pel_model_vertex *c, int at)
{
    struct pel_vec3 a = minus(place(&c[(at + 1) % 3]), place(&c[at]));
    struct pel_vec3 b = minus(place(&c[(at + 2) % 3]), place(&c[at]));
    struct pel_vec3 n = pel_vec3_cross(a, b);
    return atan2(sqrt(pel_vec3_dot(n, n)), pel_vec3_dot(a, b));
}

static uint64_t mix(const float *values, int count)
{
    uint64_t h = 1469598103934665603u;
    for (int k = 0; k < count; k++) {
        uint32_t bits;
        float v = values[k] + 0.0f; /* −0 is 0 */
        memcpy(&bits, &v, 4);
        h = (h ^ bits) * 1099511628211u;
        h ^= h >> 29;
    }
    return h;
}

/* Work on the triangles that have an area. */
struct work {
    size_t count; /* of triangles */
    struct pel_model_vertex *corners;
    struct pel_shape_tag *tags;
    struct pel_vec3 *faces; /* unit normals */
    uint32_t *next, *table; /* corners at one place, chained */
    size_t room;
};

static bool same_place(const struct pel_model_vertex *a,
                       const struct pel_model_vertex *b)
{
    return a->position[0] == b->position[0] &&
           a->position[1] == b->position[1] && a->position[2] == b->position[2];
}

static void take_triangles(const struct pel_shape *s, struct work *w)
{
    for (size_t t = 0; t < s->triangle_count; t++) {
        const struct pel_model_vertex *c = s->corners + 3 * t;
        struct pel_vec3 n = pel_vec3_cross(minus(place(&c[1]), place(&c[0])),
                                           minus(place(&c[2]), place(&c[0])));
        double l = sqrt(pel_vec3_dot(n, n));
        if (!(l > 1e-10)) {
            continue;
        }
        memcpy(w->corners + 3 * w->count, c, 3 * sizeof *c);
        w->tags[w->count] = s->tags[t];
        w->faces[w->count++] = pel_vec3_scale(n, 1 / l);
    }
}

static void chain(struct work *w)
{
    memset(w->table, 0xff, w->room * sizeof *w->table);
    for (uint32_t c = 0; c < 3 * w->count; c++) {
        size_t slot = mix(w->corners[c].position, 3) & (w->room - 1);
        while (w->table[slot] != NONE &&
               !same_place(&w->corners[w->table[slot]], &w->corners[c])) {
            slot = (slot + 1) & (w->room - 1);
        }
        w->next[c] = w->table[slot];
        w->table[slot] = c;
    }
}

static void set_normal(struct pel_model_vertex *v, struct pel_vec3 n)
{
    n = pel_vec3_normalize(n);
    v->normal[0] = (float)n.x;
    v->normal[1] = (float)n.y;
    v->normal[2] = (float)n.z;
}

/* A body may have thousands of corners at one place; no more are looked at. */
#define MOST_AROUND 64

static void smooth(struct work *w)
{
    chain(w);
    for (size_t slot = 0; slot < w->room; slot++) {
        for (uint32_t c = w->table[slot]; c != NONE; c = w->next[c]) {
            struct pel_model_vertex *v = &w->corners[c];
            double l2 = (double)v->normal[0] * (double)v->normal[0] +
                        (double)v->normal[1] * (double)v->normal[1] +
                        (double)v->normal[2] * (double)v->normal[2];
            struct pel_vec3 own = w->faces[c / 3], sum = { 0 };
            if (l2 > 1e-12 && isfinite(l2)) {
                set_normal(v, (struct pel_vec3){ (double)v->normal[0],
                                                 (double)v->normal[1],
                                                 (double)v->normal[2] });
                continue;
            }
            int seen = 0;
            for (uint32_t o = w->table[slot]; o != NONE && seen < MOST_AROUND;
                 o = w->next[o], seen++) {
                struct pel_vec3 face = w->faces[o / 3];
                if (w->tags[o / 3].node == w->tags[c / 3].node &&
                    pel_vec3_dot(face, own) > CREASE) {
                    double by = angle(w->corners + o / 3 * 3, (int)(o % 3));
                    sum = pel_vec3_add(sum, pel_vec3_scale(face, by));
                }
            }
            set_normal(v, pel_vec3_dot(sum, sum) > 1e-12 ? sum : own);
        }
    }
}

/* --- vertices
 * ----------------------------------------------------------------- */

static bool same_vertex(const struct pel_model_vertex *a,
                        const struct pel_model_vertex *b)
{
    return same_place(a, b) && a->normal[0] == b->normal[0] &&
           a->normal[1] == b->normal[1] && a->normal[2] == b->normal[2] &&
           a->uv[0] == b->uv[0] && a->uv[1] == b->uv[1];
}

/* Corners become vertices, in place; returns how many. */
static size_t weld(struct work *w, uint32_t *indices)
{
    size_t count = 0;
    memset(w->table, 0xff, w->room * sizeof *w->table);
    for (uint32_t c = 0; c < 3 * w->count; c++) {
        struct pel_model_vertex v = w->corners[c];
        size_t slot = mix(v.position, 8) & (w->room - 1);
        while (w->table[slot] != NONE &&
               !same_vertex(&w->corners[w->table[slot]], &v)) {
            slot = (slot + 1) & (w->room - 1);
        }
        if (w->table[slot] == NONE) {
            w->table[slot] = (uint32_t)count;
            w->corners[count++] = v;
        }
        indices[c] = w->table[slot];
    }
    return count;
}

/* --- parts and levels
 * ----------------------------------------------------------- */

struct order {
    uint32_t key, triangle;
};

static int by_key(const void *a, const void *b)
{
    const struct order *x = a, *y = b;
    return x->key != y->key
               ? (x->key > y->key) - (x->key < y->key)
               : (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

/* Appends a level's triangles to `to` in the order of their parts; false: no
 * memory. */
static bool add_level(struct pel_model *m, const uint32_t *indices,
                      const struct pel_shape_tag *tags, size_t count,
                      double error_m, uint32_t *to)
{
    struct order *order = malloc((count + 1) * sizeof *order);
    size_t parts = 0;
    if (!order) {
        return false;
    }
    for (size_t t = 0; t < count; t++) {
        order[t] =
            (struct order){ (uint32_t)tags[t].material << 16 | tags[t].node,
                            (uint32_t)t };
    }
    qsort(order, count, sizeof *order, by_key);
    for (size_t t = 0; t < count; t++) {
        parts += t == 0 || order[t].key != order[t - 1].key;
    }
    struct pel_model_part *part = calloc(parts + 1, sizeof *part);
    if (!part) {
        free(order);
        return false;
    }
    m->levels[m->level_count++] = (struct pel_model_level){
        .part_count = parts,
        .parts = part,
        .triangles = count,
        .error_m = (float)error_m,
    };
    for (size_t t = 0; t < count; t++) {
        if (t == 0 || order[t].key != order[t - 1].key) {
            part += t > 0;
            *part = (struct pel_model_part){
                .first = (uint32_t)m->index_count,
                .material = tags[order[t].triangle].material,
                .node = tags[order[t].triangle].node,
            };
        }
        part->count += 3;
        memcpy(to + m->index_count, indices + 3 * (size_t)order[t].triangle,
               3 * sizeof *to);
        m->index_count += 3;
    }
    free(order);
    return true;
}

/* How far a level is from the model: the most of SAMPLES vertices' distances
 * to it, or the size of what has vanished. */
#define SAMPLES 4096
static bool measure(const struct pel_model *m, const struct work *w,
                    const uint32_t *rest, size_t count, double *error_m)
{
    struct pel_bvh *bvh = pel_bvh_create(w->corners, rest, count);
    size_t step = m->vertex_count / SAMPLES + 1;
    if (!bvh) {
        return false;
    }
    for (size_t v = 0; v < m->vertex_count; v += step) {
        *error_m = fmax(*error_m, pel_bvh_nearest(bvh, place(&w->corners[v])));
    }
    pel_bvh_free(bvh);
    return true;
}

/* Each level has at most a third of the last one's triangles. */
static bool add_levels(struct pel_model *m, struct work *w, uint32_t *indices,
                       uint32_t *to)
{
    struct pel_decimate_mesh mesh = {
        .vertices = w->corners,
        .vertex_count = m->vertex_count,
        .triangle_count = w->count,
        .indices = indices,
        .tags = w->tags,
    };
    if (!add_level(m, indices, w->tags, w->count, 0, to)) {
        return false;
    }
    struct pel_decimate *d = pel_decimate_begin(&mesh);
    uint32_t *rest = malloc((w->count + 1) * 3 * sizeof *rest);
    struct pel_shape_tag *tags = malloc((w->count + 1) * sizeof *tags);
    bool fine = d && rest && tags;
    size_t last = w->count;
    double error_m = 0;
    while (fine && m->level_count < PEL_MODEL_LEVELS && last >= FEWEST) {
        struct pel_decimate_mesh out = { .indices = rest, .tags = tags };
        double now_m = 0;
        fine = pel_decimate_to(d, last / 3, &out, &now_m);
        if (!fine || out.triangle_count < 4 ||
            out.triangle_count > last * 2 / 3) {
            break;
        }
        last = out.triangle_count;
        fine = measure(m, w, rest, last, &now_m);
        error_m = fmax(error_m, now_m);
        fine = fine && add_level(m, rest, tags, last, error_m, to);
    }
    pel_decimate_end(d);
    free(rest);
    free(tags);
    return fine;
}

/* --- all together
 * ------------------------------------------------------------------ */

static bool copy_array(const void **to, const void *from, size_t size,
                       void **owned)
{
    *owned = malloc(size + 1);
    if (*owned && size > 0) {
        memcpy(*owned, from, size);
    }
    *to = *owned;
    return *owned != NULL;
}

static bool copy_rest(const struct pel_shape *s, struct pel_model_draft *out)
{
    struct pel_model *m = &out->model;
    memcpy(m->name, s->name, sizeof s->name);
    m->class = s->class;
    m->material_count = s->material_count;
    m->node_count = s->node_count;
    m->texture_count = s->texture_count;
    m->eye_count = s->eye_count;
    m->light_count = s->light_count;
    m->length_m = s->length_m;
    m->beam_m = s->beam_m;
    m->draught_m = s->draught_m;
    m->height_m = s->height_m;
    return copy_array((const void **)&m->materials, s->materials,
                      s->material_count * sizeof *s->materials,
                      &out->owned[2]) &&
           copy_array((const void **)&m->nodes, s->nodes,
                      s->node_count * sizeof *s->nodes, &out->owned[3]) &&
           copy_array((const void **)&m->textures, s->textures,
                      s->texture_count * sizeof *s->textures, &out->owned[4]) &&
           copy_array((const void **)&m->eyes, s->eyes,
                      s->eye_count * sizeof *s->eyes, &out->owned[5]) &&
           copy_array((const void **)&m->lights, s->lights,
                      s->light_count * sizeof *s->lights, &out->owned[6]);
}

static bool begin(const struct pel_shape *s, struct work *w)
{
    size_t n = s->triangle_count + 1;
    w->room = 64;
    while (w->room < 6 * n) {
        w->room *= 2;
    }
    w->corners = malloc(3 * n * sizeof *w->corners);
    w->tags = malloc(n * sizeof *w->tags);
    w->faces = malloc(n * sizeof *w->faces);
    w->next = malloc(3 * n * sizeof *w->next);
    w->table = malloc(w->room * sizeof *w->table);
    return w->corners && w->tags && w->faces && w->next && w->table;
}

static enum pel_err check(const struct pel_shape *s, struct pel_fault *fault)
{
    if (s->triangle_count > PEL_MODEL_MOST_TRIANGLES) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "more than %d triangles; simplify it",
                             PEL_MODEL_MOST_TRIANGLES);
    }
    if (s->material_count > PEL_MODEL_MOST_MATERIALS ||
        s->node_count > PEL_MODEL_MOST_NODES ||
        s->texture_count > PEL_MODEL_MOST_TEXTURES) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%zu materials, %zu nodes, %zu textures; at most "
                             "%d, %d, %d; join some",
                             s->material_count, s->node_count, s->texture_count,
                             PEL_MODEL_MOST_MATERIALS, PEL_MODEL_MOST_NODES,
                             PEL_MODEL_MOST_TEXTURES);
    }
    return PEL_OK;
}

enum pel_err pel_shape_finish(const struct pel_shape *s,
                              struct pel_model_draft *out,
                              struct pel_fault *fault)
{
    struct work w = { 0 };
    enum pel_err err = check(s, fault);
    *out = (struct pel_model_draft){ 0 };
    if (err) {
        return err;
    }
    bool fine = !s->failed && begin(s, &w);
    if (fine) {
        take_triangles(s, &w);
    }
    if (fine && w.count == 0) {
        err = pel_fault_set(fault, PEL_ERR_INVALID,
                            "it has no triangles with an area");
    } else if (fine) {
        uint32_t *indices = malloc(3 * w.count * sizeof *indices);
        uint32_t *all = malloc(2 * 3 * w.count * sizeof *all);
        fine = indices && all;
        if (fine) {
            smooth(&w);
            out->model.vertex_count = weld(&w, indices);
            fine =
                copy_rest(s, out) && add_levels(&out->model, &w, indices, all);
        }
        free(indices);
        out->model.indices = out->owned[1] = all;
        out->model.vertices = out->owned[0] = w.corners;
        w.corners = NULL;
    }
    free(w.corners);
    free(w.tags);
    free(w.faces);
    free(w.next);
    free(w.table);
    if (!fine && !err) {
        err = pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    if (err) {
        pel_model_draft_clear(out);
    }
    return err;
}
