#include "models/decimate.h"

#include <stdlib.h>
#include <string.h>

#include "models/nearpoint.h"

#define NONE UINT32_MAX
#define FAN 48        /* most triangles about a vertex that may go */
#define LENGTHS 0.002 /* what an edge's length counts of what it moves */
#define COLOUR                                                                 \
    0.25         /* what moving a line between colours counts of moving an     \
                    edge of the shape */
#define FLIP 0.2 /* cosine that a triangle may turn by */

struct candidate {
    float cost, moved; /* moved: the bound without the edge's length */
    uint32_t from, to; /* to NONE: the whole body of `from` */
    uint32_t stamp;
};

struct pel_decimate {
    struct pel_decimate_mesh mesh;
    uint32_t *place;   /* of each corner: its position's number */
    uint32_t *next;    /* of each corner: another corner at its position */
    uint32_t *head;    /* of each position */
    uint32_t *stamp;   /* of each position: changes of its surroundings */
    float *moved;      /* of each position: how far the surface has moved */
    uint32_t *body;    /* of each position: a representative of its body */
    uint32_t *pos_of;  /* of each vertex: its position */
    const float **xyz; /* of each position */
    bool *alive;       /* of each triangle */
    size_t positions, left, heap_count, heap_room;
    struct candidate *heap;
    double vanished; /* size of the largest body that has */
    double step;     /* the most that one collapse moved, lines included */
    bool failed;
};

/* --- small geometry ------------------------------------------------------ */

static struct pel_vec3 at(const struct pel_decimate *d, uint32_t p)
{
    const float *x = d->xyz[p];
    return (struct pel_vec3){ (double)x[0], (double)x[1], (double)x[2] };
}

/* --- the heap of candidates ---------------------------------------------- */

static bool cheaper(const struct candidate *a, const struct candidate *b)
{
    return a->cost < b->cost ||
           (a->cost == b->cost &&
            (a->from < b->from || (a->from == b->from && a->to < b->to)));
}

static void push(struct pel_decimate *d, struct candidate c)
{
    if (d->heap_count == d->heap_room) {
        size_t room = 2 * d->heap_room + 1024;
        struct candidate *heap = realloc(d->heap, room * sizeof *heap);
        if (!heap) {
            d->failed = true;
            return;
        }
        d->heap = heap;
        d->heap_room = room;
    }
    size_t i = d->heap_count++;
    while (i > 0 && cheaper(&c, &d->heap[(i - 1) / 2])) {
        d->heap[i] = d->heap[(i - 1) / 2];
        i = (i - 1) / 2;
    }
    d->heap[i] = c;
}

static struct candidate pop(struct pel_decimate *d)
{
    struct candidate top = d->heap[0], last = d->heap[--d->heap_count];
    size_t i = 0;
    for (;;) {
        size_t child = 2 * i + 1;
        if (child >= d->heap_count) {
            break;
        }
        if (child + 1 < d->heap_count &&
            cheaper(&d->heap[child + 1], &d->heap[child])) {
            child++;
        }
        if (!cheaper(&d->heap[child], &last)) {
            break;
        }
        d->heap[i] = d->heap[child];
        i = child;
    }
    d->heap[i] = last;
    return top;
}

/* --- what is around a vertex ---------------------------------------------- */

/* A fan: the triangles about a position, each turned so that the position is
 * its first corner. */
struct fan {
    int count;
    uint32_t triangle[FAN], second[FAN], third[FAN];
};

/* False: too many. */
static bool gather(struct pel_decimate *d, uint32_t p, struct fan *out)
{
    uint32_t *link = &d->head[p];
    out->count = 0;
    while (*link != NONE) {
        uint32_t corner = *link, t = corner / 3;
        if (!d->alive[t]) {
            *link = d->next[corner];
            continue;
        }
        if (out->count == FAN) {
            return false;
        }
        out->triangle[out->count] = t;
        out->second[out->count] = d->place[3 * t + (corner + 1) % 3];
        out->third[out->count++] = d->place[3 * t + (corner + 2) % 3];
        link = &d->next[corner];
    }
    return true;
}

static bool is_first(const uint32_t *list, int i)
{
    for (int j = 0; j < i; j++) {
        if (list[j] == list[i]) {
            return false;
        }
    }
    return true;
}

/* What the edge from the fan's middle to `other` is. */
enum edge {
    PLAIN,
    COLOURS,
    BORDER
}; /* of two materials; of the mesh, or of
      more than two triangles */
static enum edge edge_of(const struct pel_decimate *d, const struct fan *f,
                         uint32_t other)
{
    int count = 0;
    uint16_t material = 0;
    bool colours = false;
    for (int i = 0; i < f->count; i++) {
        if (f->second[i] == other || f->third[i] == other) {
            uint16_t m = d->mesh.tags[f->triangle[i]].material;
            colours = colours || (count > 0 && m != material);
            material = m;
            count++;
        }
    }
    return count != 2 ? BORDER : colours ? COLOURS : PLAIN;
}

static int neighbours(const struct fan *f, uint32_t out[2 * FAN])
{
    int count = 0;
    for (int i = 0; i < f->count; i++) {
        out[count++] = f->second[i];
        out[count++] = f->third[i];
    }
    int kept = 0;
    for (int i = 0; i < count; i++) {
        if (is_first(out, i)) {
            out[kept++] = out[i];
        }
    }
    return kept;
}

/* Whether `a` may go to `b` by the edges of a kind that meet in it: there are
 * none, or it goes along one of two; *other: where the other one leads, or
 * NONE. */
static bool keeps(const struct pel_decimate *d, const struct fan *f,
                  const uint32_t *around, int count, uint32_t b, enum edge kind,
                  uint32_t *other)
{
    int edges = 0;
    bool along = false;
    *other = NONE;
    for (int i = 0; i < count; i++) {
        if (edge_of(d, f, around[i]) == kind) {
            edges++;
            along = along || around[i] == b;
            *other = around[i] == b ? *other : around[i];
        }
    }
    return edges == 0 || (edges == 2 && along);
}

/* What a and b both have beside them must be what their triangles have: else
 * the collapse would glue two sheets together. */
static bool keeps_topology(const struct fan *fa, const struct fan *fb,
                           const uint32_t *around, int count, uint32_t b)
{
    int common = 0, shared = 0;
    for (int i = 0; i < count; i++) {
        bool there = false;
        for (int j = 0; j < fb->count && !there; j++) {
            there = fb->second[j] == around[i] || fb->third[j] == around[i];
        }
        common += there && around[i] != b;
    }
    for (int i = 0; i < fa->count; i++) {
        shared += fa->second[i] == b || fa->third[i] == b;
    }
    return common == shared && shared > 0;
}

/* How far moving a to b moves the surface; INFINITY: not to be done. */
static double displacement(struct pel_decimate *d, uint32_t a, uint32_t b)
{
    struct fan fa, fb;
    uint32_t around[2 * FAN], border, line;
    if (!gather(d, a, &fa) || !gather(d, b, &fb)) {
        return INFINITY;
    }
    int count = neighbours(&fa, around);
    if (!keeps_topology(&fa, &fb, around, count, b) ||
        !keeps(d, &fa, around, count, b, BORDER, &border)) {
        return INFINITY;
    }
    struct pel_vec3 from = at(d, a), to = at(d, b);
    double nearest = INFINITY;
    for (int i = 0; i < fa.count; i++) {
        if (fa.second[i] == b || fa.third[i] == b) {
            continue;
        }
        struct pel_vec3 s = at(d, fa.second[i]), t = at(d, fa.third[i]);
        struct pel_vec3 old =
            pel_vec3_cross(pel_vec3_minus(s, from), pel_vec3_minus(t, from));
        struct pel_vec3 new =
            pel_vec3_cross(pel_vec3_minus(s, to), pel_vec3_minus(t, to));
        if (pel_vec3_dot(old, new) <=
            FLIP * pel_vec3_length(old) * pel_vec3_length(new)) {
            return INFINITY;
        }
        nearest = fmin(nearest, pel_triangle_distance(from, to, s, t));
    }
    if (border != NONE) {
        nearest = fmax(nearest, pel_segment_distance(from, to, at(d, border)));
    }
    if (!keeps(d, &fa, around, count, b, COLOURS, &line)) {
        nearest =
            fmax(nearest, COLOUR * pel_vec3_length(pel_vec3_minus(from, to)));
    } else if (line != NONE) {
        nearest = fmax(nearest, pel_segment_distance(from, to, at(d, line)));
    }
    return nearest;
}

static void consider(struct pel_decimate *d, uint32_t a, uint32_t b)
{
    double by = displacement(d, a, b);
    if (by < 1e9) {
        double moved = (double)d->moved[a] + by;
        double far = pel_vec3_length(pel_vec3_minus(at(d, a), at(d, b)));
        push(d,
             (struct candidate){ (float)(moved + LENGTHS * far), (float)moved,
                                 a, b, d->stamp[a] + d->stamp[b] });
    }
}

/* --- collapsing ------------------------------------------------------------
 */

/* The vertex at b that the corner at a of triangle t becomes: of t's material
 * and with the normal most like its own. */
static uint32_t wedge(const struct pel_decimate *d, const struct fan *fb,
                      uint32_t b, uint32_t t, uint32_t own)
{
    const float *n = d->mesh.vertices[own].normal;
    uint32_t best = NONE;
    double most = -INFINITY;
    for (int i = 0; i < fb->count; i++) {
        uint32_t f = fb->triangle[i];
        for (uint32_t c = 3 * f; c < 3 * f + 3; c++) {
            if (d->place[c] != b) {
                continue;
            }
            const float *m = d->mesh.vertices[d->mesh.indices[c]].normal;
            double like = (double)(n[0] * m[0] + n[1] * m[1] + n[2] * m[2]);
            like +=
                d->mesh.tags[f].material == d->mesh.tags[t].material ? 4 : 0;
            if (like > most) {
                most = like;
                best = d->mesh.indices[c];
            }
        }
    }
    return best;
}

static void collapse(struct pel_decimate *d, uint32_t a, uint32_t b,
                     float moved)
{
    struct fan fa, fb;
    if (!gather(d, a, &fa) || !gather(d, b, &fb)) {
        return;
    }
    for (int i = 0; i < fa.count; i++) {
        uint32_t t = fa.triangle[i];
        if (fa.second[i] == b || fa.third[i] == b) {
            d->alive[t] = false;
            d->left--;
            continue;
        }
        for (uint32_t c = 3 * t; c < 3 * t + 3; c++) {
            if (d->place[c] == a) {
                d->mesh.indices[c] = wedge(d, &fb, b, t, d->mesh.indices[c]);
                d->place[c] = b;
                d->next[c] = d->head[b];
                d->head[b] = c;
                break;
            }
        }
    }
    d->head[a] = NONE;
    d->step = fmax(d->step, (double)(moved - d->moved[a]));
    d->moved[b] = fmaxf(d->moved[b], moved);
    struct fan f;
    uint32_t around[2 * FAN];
    d->stamp[b]++;
    if (!gather(d, b, &f)) {
        return;
    }
    int count = neighbours(&f, around);
    for (int i = 0; i < count; i++) {
        d->stamp[around[i]]++;
    }
    for (int i = 0; i < count; i++) {
        consider(d, b, around[i]);
        consider(d, around[i], b);
    }
}

static uint32_t root(uint32_t *body, uint32_t p)
{
    while (body[p] != p) {
        body[p] = body[body[p]];
        p = body[p];
    }
    return p;
}

static void vanish(struct pel_decimate *d, const struct candidate *c)
{
    if (d->left == 0) {
        return;
    }
    for (size_t t = 0; t < d->mesh.triangle_count; t++) {
        if (d->alive[t] && d->body[d->place[3 * t]] == c->from) {
            d->alive[t] = false;
            d->left--;
        }
    }
    d->vanished = fmax(d->vanished, (double)c->moved);
}

/* --- begin, go on, end ------------------------------------------------------
 */

static uint32_t hash(const float p[3])
{
    uint32_t h = 2166136261u;
    for (int k = 0; k < 3; k++) {
        uint32_t bits;
        float v = p[k] + 0.0f; /* −0 is 0 */
        memcpy(&bits, &v, 4);
        h = (h ^ bits) * 16777619u;
        h ^= h >> 15;
    }
    return h;
}

/* Numbers the positions: vertices at one place are one. */
static bool weld(struct pel_decimate *d)
{
    size_t n = d->mesh.vertex_count, room = 16;
    while (room < 2 * n) {
        room *= 2;
    }
    uint32_t *table = malloc(room * sizeof *table);
    if (!table) {
        return false;
    }
    memset(table, 0xff, room * sizeof *table);
    for (size_t v = 0; v < n; v++) {
        const float *p = d->mesh.vertices[v].position;
        size_t slot = hash(p) & (room - 1);
        while (table[slot] != NONE && (d->xyz[table[slot]][0] != p[0] ||
                                       d->xyz[table[slot]][1] != p[1] ||
                                       d->xyz[table[slot]][2] != p[2])) {
            slot = (slot + 1) & (room - 1);
        }
        if (table[slot] == NONE) {
            table[slot] = (uint32_t)d->positions;
            d->xyz[d->positions++] = p;
        }
        d->pos_of[v] = table[slot];
    }
    free(table);
    return true;
}

/* Each body but the largest may vanish, at the cost of its size. */
static bool find_bodies(struct pel_decimate *d)
{
    struct box {
        float low[3], high[3];
    } *boxes = calloc(d->positions + 1, sizeof *boxes);
    double largest = 0;
    if (!boxes) {
        return false;
    }
    for (size_t p = 0; p < d->positions; p++) {
        d->body[p] = root(d->body, (uint32_t)p);
        for (int k = 0; k < 3; k++) {
            /* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): welded */
            boxes[p].low[k] = boxes[p].high[k] = d->xyz[p][k];
        }
    }
    for (size_t p = 0; p < d->positions; p++) {
        struct box *b = &boxes[d->body[p]];
        for (int k = 0; k < 3; k++) {
            b->low[k] = fminf(b->low[k], d->xyz[p][k]);
            b->high[k] = fmaxf(b->high[k], d->xyz[p][k]);
        }
    }
    for (int pass = 0; pass < 2; pass++) {
        for (size_t p = 0; p < d->positions; p++) {
            double size = 0;
            for (int k = 0; k < 3; k++) {
                double side = (double)(boxes[p].high[k] - boxes[p].low[k]);
                size += side * side;
            }
            size = sqrt(size);
            if (d->body[p] != p) {
                continue;
            }
            if (pass == 0) {
                largest = fmax(largest, size);
            } else if (size < largest) {
                push(d, (struct candidate){ (float)size, (float)size,
                                            (uint32_t)p, NONE, 0 });
            }
        }
    }
    free(boxes);
    return true;
}

static void link_corners(struct pel_decimate *d)
{
    for (size_t p = 0; p < d->positions; p++) {
        d->head[p] = NONE;
        d->body[p] = (uint32_t)p;
    }
    d->left = d->mesh.triangle_count;
    for (uint32_t c = 0; c < 3 * d->mesh.triangle_count; c++) {
        d->place[c] = d->pos_of[d->mesh.indices[c]];
        d->next[c] = d->head[d->place[c]];
        d->head[d->place[c]] = c;
        d->alive[c / 3] = true;
        if (c % 3 > 0) {
            uint32_t a = root(d->body, d->place[c]);
            uint32_t b = root(d->body, d->place[c - 1]);
            d->body[a > b ? a : b] = a > b ? b : a;
        }
    }
    for (uint32_t c = 0; c < 3 * d->mesh.triangle_count; c++) {
        /* The other triangle of the edge has it the other way. */
        consider(d, d->place[c], d->place[c / 3 * 3 + (c + 1) % 3]);
    }
}

struct pel_decimate *pel_decimate_begin(const struct pel_decimate_mesh *mesh)
{
    struct pel_decimate *d = calloc(1, sizeof *d);
    size_t n = mesh->vertex_count + 1, c = 3 * mesh->triangle_count + 1;
    if (!d) {
        return NULL;
    }
    d->mesh = *mesh;
    d->place = calloc(c, sizeof *d->place);
    d->next = calloc(c, sizeof *d->next);
    d->head = calloc(n, sizeof *d->head);
    d->stamp = calloc(n, sizeof *d->stamp);
    d->moved = calloc(n, sizeof *d->moved);
    d->body = calloc(n, sizeof *d->body);
    d->pos_of = calloc(n, sizeof *d->pos_of);
    d->xyz = calloc(n, sizeof *d->xyz);
    d->alive = calloc(c, sizeof *d->alive);
    if (!d->place || !d->next || !d->head || !d->stamp || !d->moved ||
        !d->body || !d->pos_of || !d->xyz || !d->alive || !weld(d)) {
        pel_decimate_end(d);
        return NULL;
    }
    link_corners(d);
    if (!find_bodies(d) || d->failed) {
        pel_decimate_end(d);
        return NULL;
    }
    return d;
}

static void step(struct pel_decimate *d)
{
    struct candidate c = pop(d);
    if (c.to == NONE) {
        vanish(d, &c);
    } else if (d->head[c.from] != NONE && d->head[c.to] != NONE) {
        if (c.stamp == d->stamp[c.from] + d->stamp[c.to]) {
            collapse(d, c.from, c.to, c.moved);
        } else {
            consider(d, c.from, c.to);
        }
    }
}

bool pel_decimate_to(struct pel_decimate *d, size_t triangles,
                     struct pel_decimate_mesh *out, double *least_m)
{
    while (d->left > triangles && d->heap_count > 0 && !d->failed) {
        step(d);
    }
    out->triangle_count = 0;
    for (size_t t = 0; t < d->mesh.triangle_count; t++) {
        if (d->alive[t]) {
            memcpy(out->indices + 3 * out->triangle_count,
                   d->mesh.indices + 3 * t, 3 * sizeof *out->indices);
            out->tags[out->triangle_count++] = d->mesh.tags[t];
        }
    }
    *least_m = fmax(d->vanished, d->step);
    return !d->failed;
}

void pel_decimate_end(struct pel_decimate *d)
{
    if (d) {
        free(d->place);
        free(d->next);
        free(d->head);
        free(d->stamp);
        free(d->moved);
        free(d->body);
        free(d->pos_of);
        free((void *)d->xyz);
        free(d->alive);
        free(d->heap);
        free(d);
    }
}
