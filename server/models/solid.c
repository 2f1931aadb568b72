#include "models/solid.h"

#include <stdio.h>
#include <string.h>

#define MOST 64 /* corners of an outline, sides of a body */

static float linear(unsigned byte)
{
    double v = byte / 255.0;
    return (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
}

static void paint(struct pel_pen *pen, uint32_t colour, double roughness,
                  float metallic)
{
    struct pel_model_material m = { .metallic = metallic,
                                    .roughness = (float)roughness,
                                    .texture = -1 };
    for (int k = 0; k < 3; k++) {
        m.albedo[k] = linear(colour >> (16 - 8 * k) & 255);
    }
    snprintf(m.name, sizeof m.name, "%s %06x", metallic > 0 ? "metal" : "paint",
             colour & 0xffffff);
    pen->material = pel_shape_material(pen->shape, &m);
}

void pel_pen_node(struct pel_pen *pen, const char *name)
{
    pen->node = pel_shape_node(pen->shape, name);
}

void pel_pen_paint(struct pel_pen *pen, uint32_t colour, double roughness)
{
    paint(pen, colour, roughness, 0);
}

void pel_pen_metal(struct pel_pen *pen, uint32_t colour, double roughness)
{
    paint(pen, colour, roughness, 1);
}

static struct pel_model_vertex corner(struct pel_vec3 p)
{
    return (struct pel_model_vertex){ .position = { (float)p.x, (float)p.y,
                                                    (float)p.z } };
}

static bool same(const struct pel_model_vertex *a,
                 const struct pel_model_vertex *b)
{
    return a->position[0] == b->position[0] &&
           a->position[1] == b->position[1] && a->position[2] == b->position[2];
}

void pel_solid_triangle(struct pel_pen *pen, struct pel_vec3 a,
                        struct pel_vec3 b, struct pel_vec3 c)
{
    struct pel_model_vertex v[] = { corner(a), corner(b), corner(c) };
    if (!same(&v[0], &v[1]) && !same(&v[1], &v[2]) && !same(&v[2], &v[0])) {
        pel_shape_triangle(pen->shape, v, pen->material, pen->node);
    }
}

void pel_solid_quad(struct pel_pen *pen, struct pel_vec3 a, struct pel_vec3 b,
                    struct pel_vec3 c, struct pel_vec3 d)
{
    pel_solid_triangle(pen, a, b, c);
    pel_solid_triangle(pen, a, c, d);
}

/* Skin between two rings of n points, counterclockwise seen from the second's
 * side. */
static void skin(struct pel_pen *pen, const struct pel_vec3 *low,
                 const struct pel_vec3 *high, int n)
{
    for (int i = 0; i < n; i++) {
        int j = (i + 1) % n;
        pel_solid_quad(pen, low[i], low[j], high[j], high[i]);
    }
}

/* A lid on a convex ring: a strip from side to side, since a fan of outlines
 * with straight sides has triangles without an area. */
static void lid(struct pel_pen *pen, const struct pel_vec3 *ring, int n,
                bool up)
{
    for (int a = 0, b = n - 1; a + 1 < b; a++, b--) {
        pel_solid_triangle(pen, ring[a], ring[up ? a + 1 : b],
                           ring[up ? b : a + 1]);
        if (a + 2 < b) {
            pel_solid_triangle(pen, ring[a + 1], ring[up ? b - 1 : b],
                               ring[up ? b : b - 1]);
        }
    }
}

void pel_solid_tower(struct pel_pen *pen, const struct pel_vec2 *outline, int n,
                     double z0, double z1, double top, double cx, double cy)
{
    struct pel_vec3 low[MOST], high[MOST];
    for (int i = 0; i < n; i++) {
        low[i] = (struct pel_vec3){ outline[i].x, outline[i].y, z0 };
        high[i] = (struct pel_vec3){ cx + (outline[i].x - cx) * top,
                                     cy + (outline[i].y - cy) * top, z1 };
    }
    skin(pen, low, high, n);
    lid(pen, low, n, false);
    if (top > 0) {
        lid(pen, high, n, true);
    }
}

void pel_solid_box(struct pel_pen *pen, double x0, double x1, double y0,
                   double y1, double z0, double z1)
{
    const struct pel_vec2 outline[] = {
        { x0, y0 }, { x1, y0 }, { x1, y1 }, { x0, y1 }
    };
    pel_solid_tower(pen, outline, 4, z0, z1, 1, 0, 0);
}

void pel_solid_block(struct pel_pen *pen, double x0, double x1, double wide,
                     double z0, double z1)
{
    pel_solid_box(pen, x0, x1, -wide / 2, wide / 2, z0, z1);
}

void pel_solid_boxes(struct pel_pen *pen, double x0, double x1, double y0,
                     double y1, double z0, double z1)
{
    pel_solid_box(pen, x0, x1, y0, y1, z0, z1);
    pel_solid_box(pen, x0, x1, -y1, -y0, z0, z1);
}

void pel_solid_side(struct pel_pen *pen, const struct pel_vec2 *outline, int n,
                    double y0, double y1)
{
    struct pel_vec3 near[MOST], far[MOST];
    for (int i = 0; i < n; i++) {
        near[i] = (struct pel_vec3){ outline[i].x, y0, outline[i].y };
        far[i] = (struct pel_vec3){ outline[i].x, y1, outline[i].y };
    }
    skin(pen, far, near, n);
    lid(pen, far, n, false);
    lid(pen, near, n, true);
}

/* Two unit vectors across `along`, right-handed with it. */
static void frame(struct pel_vec3 along, struct pel_vec3 *u, struct pel_vec3 *v)
{
    struct pel_vec3 help = fabs(along.z) < 0.9 ? (struct pel_vec3){ 0, 0, 1 }
                                               : (struct pel_vec3){ 1, 0, 0 };
    *u = pel_vec3_normalize(pel_vec3_cross(help, along));
    *v = pel_vec3_cross(along, *u);
}

static void circle(struct pel_vec3 centre, struct pel_vec3 along, double r,
                   int sides, struct pel_vec3 out[MOST])
{
    struct pel_vec3 u, v;
    frame(along, &u, &v);
    for (int i = 0; i < sides; i++) {
        double a = 2 * PEL_PI * (i + 0.5) / sides;
        out[i] =
            pel_vec3_add(centre, pel_vec3_add(pel_vec3_scale(u, r * cos(a)),
                                              pel_vec3_scale(v, r * sin(a))));
    }
}

static struct pel_vec3 minus(struct pel_vec3 a, struct pel_vec3 b)
{
    return pel_vec3_add(a, pel_vec3_scale(b, -1));
}

void pel_solid_pole(struct pel_pen *pen, struct pel_vec3 a, struct pel_vec3 b,
                    double ra, double rb, int sides)
{
    struct pel_vec3 low[MOST], high[MOST];
    struct pel_vec3 along = pel_vec3_normalize(minus(b, a));
    circle(a, along, ra, sides, low);
    circle(b, along, rb, sides, high);
    skin(pen, low, high, sides);
    if (ra > 0) {
        lid(pen, low, sides, false);
    }
    if (rb > 0) {
        lid(pen, high, sides, true);
    }
}

static void turn(struct pel_vec2 p, double x, double y, int sides,
                 struct pel_vec3 out[MOST])
{
    for (int i = 0; i < sides; i++) {
        double a = 2 * PEL_PI * i / sides;
        out[i] = (struct pel_vec3){ x + p.x * cos(a), y + p.x * sin(a), p.y };
    }
}

void pel_solid_turned(struct pel_pen *pen, const struct pel_vec2 *profile,
                      int n, double x, double y, int sides)
{
    struct pel_vec3 rings[2][MOST];
    for (int i = 0; i < n; i++) {
        struct pel_vec3 *ring = rings[i & 1];
        turn(profile[i], x, y, sides, ring);
        if (i > 0) {
            skin(pen, rings[~i & 1], ring, sides);
        }
        if ((i == 0 || i == n - 1) && profile[i].x > 0) {
            lid(pen, ring, sides, i > 0);
        }
    }
}

void pel_solid_ellipsoid(struct pel_pen *pen, struct pel_vec3 centre, double a,
                         double b, double c, int sides)
{
    struct pel_vec3 rings[2][MOST];
    int rows = sides / 2;
    for (int i = 0; i <= rows; i++) {
        double t = PEL_PI * i / rows;
        double r = i == 0 || i == rows ? 0 : sin(t);
        for (int k = 0; k < sides; k++) {
            double p = 2 * PEL_PI * k / sides;
            rings[i & 1][k] = (struct pel_vec3){ centre.x + a * r * cos(p),
                                                 centre.y + b * r * sin(p),
                                                 centre.z - c * cos(t) };
        }
        if (i > 0) {
            skin(pen, rings[~i & 1], rings[i & 1], sides);
        }
    }
}

void pel_solid_tube(struct pel_pen *pen, const struct pel_vec3 *path, int n,
                    double r, int sides, bool ring)
{
    struct pel_vec3 rings[2][MOST], first[MOST];
    for (int i = 0; i < (ring ? n + 1 : n); i++) {
        int before = ring ? (i + n - 1) % n : i > 0 ? i - 1 : 0;
        int behind = ring ? (i + 1) % n : i < n - 1 ? i + 1 : n - 1;
        struct pel_vec3 *now = rings[i & 1];
        circle(path[i % n],
               pel_vec3_normalize(minus(path[behind], path[before])), r, sides,
               now);
        if (i == 0) {
            memcpy(first, now, sizeof first);
        }
        if (i == n) {
            now = first;
        }
        if (i > 0) {
            skin(pen, rings[~i & 1], now, sides);
        }
        if (!ring && (i == 0 || i == n - 1)) {
            lid(pen, now, sides, i > 0);
        }
    }
}
