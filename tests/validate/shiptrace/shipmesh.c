#include "shipmesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *room(size_t count, size_t size)
{
    void *memory = calloc(count, size);
    if (!memory) {
        fprintf(stderr, "shiptrace: no memory\n");
        exit(2);
    }
    return memory;
}

static void cross(const double *a, const double *b, double *out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void box_of(const struct ship_triangle *t, int count,
                   struct ship_node *node)
{
    for (int i = 0; i < 3; i++) {
        node->low[i] = INFINITY;
        node->high[i] = -INFINITY;
        for (int j = 0; j < 3 * count; j++) {
            double x = t[j / 3].corner[j % 3][i];
            node->low[i] = fmin(node->low[i], x);
            node->high[i] = fmax(node->high[i], x);
        }
    }
}

static double middle(const struct ship_triangle *t, int axis)
{
    return t->corner[0][axis] + t->corner[1][axis] + t->corner[2][axis];
}

static int by_x(const void *a, const void *b)
{
    double d = middle(a, 0) - middle(b, 0);
    return (d > 0) - (d < 0);
}

static int by_y(const void *a, const void *b)
{
    double d = middle(a, 1) - middle(b, 1);
    return (d > 0) - (d < 0);
}

static int by_z(const void *a, const void *b)
{
    double d = middle(a, 2) - middle(b, 2);
    return (d > 0) - (d < 0);
}

/* Halves along the longest side, down to four triangles. */
static void divide(struct ship_mesh *mesh, int at)
{
    struct ship_node *node = &mesh->node[at];
    box_of(mesh->triangle + node->first, node->count, node);
    if (node->count <= 4) {
        return;
    }
    int axis = 0;
    for (int i = 1; i < 3; i++) {
        if (node->high[i] - node->low[i] > node->high[axis] - node->low[axis]) {
            axis = i;
        }
    }
    qsort(mesh->triangle + node->first, (size_t)node->count,
          sizeof(struct ship_triangle),
          axis == 0   ? by_x
          : axis == 1 ? by_y
                      : by_z);
    int half = node->count / 2, child = mesh->nodes;
    mesh->nodes += 2;
    mesh->node[child] =
        (struct ship_node){ .first = node->first, .count = half };
    mesh->node[child + 1] = (struct ship_node){ .first = node->first + half,
                                                .count = node->count - half };
    node->child = child;
    node->count = 0;
    divide(mesh, child);
    divide(mesh, child + 1);
}

void ship_mesh_init(struct ship_mesh *mesh, struct ship_triangle *triangle,
                    int count)
{
    mesh->triangle = triangle;
    mesh->triangles = count;
    mesh->node = room(2 * (size_t)count + 2, sizeof(*mesh->node));
    for (int i = 0; i < count; i++) {
        struct ship_triangle *t = &triangle[i];
        double a[3], b[3];
        for (int j = 0; j < 3; j++) {
            a[j] = t->corner[1][j] - t->corner[0][j];
            b[j] = t->corner[2][j] - t->corner[0][j];
        }
        cross(a, b, t->normal);
        double length = sqrt(dot(t->normal, t->normal));
        for (int j = 0; j < 3; j++) {
            t->normal[j] /= fmax(length, 1e-30);
        }
    }
    mesh->nodes = 1;
    mesh->node[0] = (struct ship_node){ .first = 0, .count = count };
    divide(mesh, 0);
}

void ship_mesh_finish(struct ship_mesh *mesh)
{
    free(mesh->triangle);
    free(mesh->node);
    memset(mesh, 0, sizeof(*mesh));
}

static int meets_box(const struct ship_node *node, const double *from,
                     const double *over, double farthest)
{
    double enter = 0, leave = farthest;
    for (int i = 0; i < 3; i++) {
        double a = (node->low[i] - from[i]) * over[i];
        double b = (node->high[i] - from[i]) * over[i];
        enter = fmax(enter, fmin(a, b));
        leave = fmin(leave, fmax(a, b));
    }
    return enter <= leave * (1 + 1e-12);
}

/* Moeller and Trumbore 1997; infinity where it is missed. */
static double meet(const struct ship_triangle *t, const double *from,
                   const double *direction)
{
    double a[3], b[3], p[3], s[3], q[3];
    for (int i = 0; i < 3; i++) {
        a[i] = t->corner[1][i] - t->corner[0][i];
        b[i] = t->corner[2][i] - t->corner[0][i];
        s[i] = from[i] - t->corner[0][i];
    }
    cross(direction, b, p);
    double determinant = dot(a, p);
    if (fabs(determinant) < 1e-14) {
        return INFINITY;
    }
    double u = dot(s, p) / determinant;
    cross(s, a, q);
    double v = dot(direction, q) / determinant;
    if (u < 0 || v < 0 || u + v > 1) {
        return INFINITY;
    }
    double distance = dot(b, q) / determinant;
    return distance > 1e-4 ? distance : INFINITY;
}

int ship_mesh_cast(const struct ship_mesh *mesh, const double *from,
                   const double *direction, double farthest,
                   struct ship_hit *hit)
{
    int stack[64], depth = 0;
    double over[3], nearest = farthest;
    const struct ship_triangle *found = NULL;
    for (int i = 0; i < 3; i++) {
        over[i] = 1 / (fabs(direction[i]) > 1e-12 ? direction[i] : 1e-12);
    }
    stack[depth++] = 0;
    while (depth > 0) {
        const struct ship_node *node = &mesh->node[stack[--depth]];
        if (!meets_box(node, from, over, nearest)) {
            continue;
        }
        if (node->count == 0) {
            stack[depth++] = node->child;
            stack[depth++] = node->child + 1;
            continue;
        }
        for (int i = 0; i < node->count; i++) {
            const struct ship_triangle *t = &mesh->triangle[node->first + i];
            double distance = meet(t, from, direction);
            if (distance < nearest) {
                nearest = distance;
                found = t;
            }
        }
        if (found && !hit) {
            return 1;
        }
    }
    if (!found) {
        return 0;
    }
    if (hit) {
        double side = dot(found->normal, direction) > 0 ? -1 : 1;
        hit->distance = nearest;
        hit->albedo = found->albedo;
        for (int i = 0; i < 3; i++) {
            hit->normal[i] = side * found->normal[i];
        }
    }
    return 1;
}
