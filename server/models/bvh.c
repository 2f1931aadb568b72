#include "models/bvh.h"

#include <stdlib.h>
#include <string.h>

#include "models/nearpoint.h"

#define LEAF 4
#define DEPTH 64 /* of 2^64 triangles, halved each time */

struct node {
    float low[3], high[3];
    uint32_t first; /* leaf: of `order`; else its second child, the first
                       child follows it */
    uint32_t count; /* of a leaf, else 0 */
};

struct pel_bvh {
    const struct pel_model_vertex *vertices;
    const uint32_t *indices;
    size_t node_count;
    struct node *nodes;
    uint32_t *order;
    size_t triangle_count;
};

struct builder {
    struct pel_bvh *bvh;
    float (*centres)[3];
};

static void bound(const struct pel_bvh *b, uint32_t from, uint32_t count,
                  struct node *out)
{
    for (int k = 0; k < 3; k++) {
        out->low[k] = INFINITY;
        out->high[k] = -INFINITY;
    }
    for (uint32_t i = from; i < from + count; i++) {
        for (int c = 0; c < 3; c++) {
            const float *p =
                b->vertices[b->indices[3 * (size_t)b->order[i] + (size_t)c]]
                    .position;
            for (int k = 0; k < 3; k++) {
                out->low[k] = fminf(out->low[k], p[k]);
                out->high[k] = fmaxf(out->high[k], p[k]);
            }
        }
    }
}

static bool before(const struct builder *b, uint32_t x, uint32_t y, int axis)
{
    float dx = b->centres[x][axis], dy = b->centres[y][axis];
    return dx < dy || (dx == dy && x < y);
}

/* Puts the `rank` smallest of order[from, from + count) first (Hoare). */
static void partition(const struct builder *b, uint32_t from, uint32_t count,
                      uint32_t rank, int axis)
{
    uint32_t *o = b->bvh->order + from;
    int64_t low = 0, high = (int64_t)count - 1;
    while (low < high) {
        uint32_t pivot = o[(low + high) / 2];
        int64_t i = low, j = high;
        while (i <= j) {
            while (before(b, o[i], pivot, axis)) {
                i++;
            }
            while (before(b, pivot, o[j], axis)) {
                j--;
            }
            if (i <= j) {
                uint32_t t = o[i];
                o[i++] = o[j];
                o[j--] = t;
            }
        }
        if (rank <= j) {
            high = j;
        } else if (rank >= i) {
            low = i;
        } else {
            return;
        }
    }
}

static int longest(const struct builder *b, uint32_t from, uint32_t count)
{
    float low[3] = { INFINITY, INFINITY, INFINITY };
    float high[3] = { -INFINITY, -INFINITY, -INFINITY };
    int axis = 0;
    for (uint32_t i = from; i < from + count; i++) {
        const float *c = b->centres[b->bvh->order[i]];
        for (int k = 0; k < 3; k++) {
            low[k] = fminf(low[k], c[k]);
            high[k] = fmaxf(high[k], c[k]);
        }
    }
    for (int k = 1; k < 3; k++) {
        axis = high[k] - low[k] > high[axis] - low[axis] ? k : axis;
    }
    return axis;
}

/* NOLINTNEXTLINE(misc-no-recursion): as deep as the logarithm of count. */
static void split(struct builder *b, uint32_t from, uint32_t count)
{
    size_t at = b->bvh->node_count++;
    struct node *n = &b->bvh->nodes[at];
    bound(b->bvh, from, count, n);
    if (count <= LEAF) {
        n->first = from;
        n->count = count;
        return;
    }
    uint32_t half = count / 2;
    n->count = 0;
    partition(b, from, count, half, longest(b, from, count));
    split(b, from, half);
    n->first = (uint32_t)b->bvh->node_count;
    split(b, from + half, count - half);
}

struct pel_bvh *pel_bvh_create(const struct pel_model_vertex *vertices,
                               const uint32_t *indices, size_t count)
{
    struct pel_bvh *bvh = calloc(1, sizeof *bvh);
    float(*centres)[3] = malloc((count + 1) * sizeof *centres);
    if (!bvh || !centres) {
        free(bvh);
        free(centres);
        return NULL;
    }
    *bvh =
        (struct pel_bvh){ .vertices = vertices,
                          .indices = indices,
                          .triangle_count = count,
                          .nodes = malloc((count + 1) * sizeof *bvh->nodes),
                          .order = malloc((count + 1) * sizeof *bvh->order) };
    if (!bvh->nodes || !bvh->order) {
        free(centres);
        pel_bvh_free(bvh);
        return NULL;
    }
    for (size_t t = 0; t < count; t++) {
        bvh->order[t] = (uint32_t)t;
        for (int k = 0; k < 3; k++) {
            centres[t][k] = 0;
            for (int c = 0; c < 3; c++) {
                centres[t][k] +=
                    vertices[indices[3 * t + (size_t)c]].position[k];
            }
        }
    }
    split(&(struct builder){ bvh, centres }, 0, (uint32_t)count);
    free(centres);
    struct node *nodes =
        realloc(bvh->nodes, bvh->node_count * sizeof *bvh->nodes);
    bvh->nodes = nodes ? nodes : bvh->nodes;
    return bvh;
}

void pel_bvh_free(struct pel_bvh *bvh)
{
    if (bvh) {
        free(bvh->nodes);
        free(bvh->order);
        free(bvh);
    }
}

size_t pel_bvh_bytes(const struct pel_bvh *bvh)
{
    return sizeof *bvh + bvh->node_count * sizeof *bvh->nodes +
           bvh->triangle_count * sizeof *bvh->order;
}

/* The ray sheared so that it runs along z (Woop, Benthin, Wald 2013). */
struct ray {
    double o[3], inverse[3];
    int kx, ky, kz;
    double sx, sy, sz;
};

static void prepare(struct pel_vec3 origin, struct pel_vec3 direction,
                    struct ray *r)
{
    double d[3] = { direction.x, direction.y, direction.z };
    *r = (struct ray){ .o = { origin.x, origin.y, origin.z } };
    for (int k = 0; k < 3; k++) {
        r->inverse[k] = 1.0 / d[k];
        r->kz = fabs(d[k]) > fabs(d[r->kz]) ? k : r->kz;
    }
    r->kx = (r->kz + 1) % 3;
    r->ky = (r->kz + 2) % 3;
    if (d[r->kz] < 0) {
        int t = r->kx;
        r->kx = r->ky;
        r->ky = t;
    }
    r->sx = d[r->kx] / d[r->kz];
    r->sy = d[r->ky] / d[r->kz];
    r->sz = 1.0 / d[r->kz];
}

/* Where the ray enters the box: infinity where it does not. */
static double enters(const struct ray *r, const struct node *n, double most)
{
    double near = 0, far = most;
    for (int k = 0; k < 3; k++) {
        double a = ((double)n->low[k] - r->o[k]) * r->inverse[k];
        double b = ((double)n->high[k] - r->o[k]) * r->inverse[k];
        /* 0 · infinity: the ray runs in the slab's face. */
        if (a == a && b == b) {
            double first = a < b ? a : b, last = a < b ? b : a;
            near = first > near ? first : near;
            far = last < far ? last : far;
        }
    }
    return near <= far * (1 + 4e-16) ? near : INFINITY;
}

static bool hits(const struct ray *r, const struct pel_bvh *b,
                 uint32_t triangle, double most, struct pel_bvh_hit *out)
{
    double x[3], y[3], z[3];
    for (int c = 0; c < 3; c++) {
        const float *p =
            b->vertices[b->indices[3 * (size_t)triangle + (size_t)c]].position;
        double depth = (double)p[r->kz] - r->o[r->kz];
        x[c] = (double)p[r->kx] - r->o[r->kx] - r->sx * depth;
        y[c] = (double)p[r->ky] - r->o[r->ky] - r->sy * depth;
        z[c] = r->sz * depth;
    }
    double u = x[2] * y[1] - y[2] * x[1];
    double v = x[0] * y[2] - y[0] * x[2];
    double w = x[1] * y[0] - y[1] * x[0];
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) {
        return false;
    }
    double sum = u + v + w;
    double distance = (u * z[0] + v * z[1] + w * z[2]) / sum;
    if (sum == 0 || !(distance > 0 && distance <= most)) {
        return false;
    }
    *out = (struct pel_bvh_hit){ .triangle = triangle,
                                 .distance = distance,
                                 .u = v / sum,
                                 .v = w / sum,
                                 .front = sum > 0 };
    return true;
}

bool pel_bvh_cast(const struct pel_bvh *bvh, struct pel_vec3 origin,
                  struct pel_vec3 direction, double most,
                  bool (*solid)(const void *user,
                                const struct pel_bvh_hit *hit),
                  const void *user, struct pel_bvh_hit *out)
{
    struct ray ray;
    uint32_t stack[DEPTH + 2], depth = 0;
    double entry[DEPTH + 2];
    bool found = false;
    prepare(origin, direction, &ray);
    stack[depth] = 0;
    entry[depth++] = enters(&ray, &bvh->nodes[0], most);
    while (depth > 0) {
        uint32_t at = stack[--depth];
        const struct node *n = &bvh->nodes[at];
        if (!(entry[depth] <= most)) {
            continue;
        }
        if (n->count == 0) {
            uint32_t first = at + 1, last = n->first;
            double near = enters(&ray, &bvh->nodes[first], most);
            double far = enters(&ray, &bvh->nodes[last], most);
            if (far < near) {
                double t = near;
                near = far;
                far = t;
                first = n->first;
                last = at + 1;
            }
            entry[depth] = far;
            stack[depth] = last;
            depth += far < INFINITY;
            entry[depth] = near;
            stack[depth] = first;
            depth += near < INFINITY;
            continue;
        }
        for (uint32_t i = 0; i < n->count; i++) {
            struct pel_bvh_hit hit;
            if (hits(&ray, bvh, bvh->order[n->first + i], most, &hit) &&
                (!solid || solid(user, &hit))) {
                *out = hit;
                most = hit.distance;
                found = true;
            }
        }
    }
    return found;
}

static double box_distance(const struct node *n, struct pel_vec3 p)
{
    const double at[3] = { p.x, p.y, p.z };
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double off = fmax(
            0, fmax((double)n->low[k] - at[k], at[k] - (double)n->high[k]));
        sum += off * off;
    }
    return sqrt(sum);
}

static struct pel_vec3 corner(const struct pel_bvh *b, uint32_t triangle,
                              size_t c)
{
    const float *p = b->vertices[b->indices[3 * (size_t)triangle + c]].position;
    return (struct pel_vec3){ (double)p[0], (double)p[1], (double)p[2] };
}

double pel_bvh_nearest(const struct pel_bvh *bvh, struct pel_vec3 point)
{
    uint32_t stack[DEPTH + 1], depth = 0;
    double best = INFINITY;
    stack[depth++] = 0;
    while (depth > 0) {
        uint32_t at = stack[--depth];
        const struct node *n = &bvh->nodes[at];
        if (box_distance(n, point) >= best) {
            continue;
        }
        for (uint32_t i = 0; i < n->count; i++) {
            uint32_t t = bvh->order[n->first + i];
            best = fmin(best, pel_triangle_distance(point, corner(bvh, t, 0),
                                                    corner(bvh, t, 1),
                                                    corner(bvh, t, 2)));
        }
        if (n->count == 0) {
            bool first = box_distance(&bvh->nodes[at + 1], point) <=
                         box_distance(&bvh->nodes[n->first], point);
            stack[depth++] = first ? n->first : at + 1;
            stack[depth++] = first ? at + 1 : n->first;
        }
    }
    return best;
}
