/* Small vectors, double precision. The local frame is right-handed: x east,
 * y north, z up. */
#pragma once

#include <math.h>
#include <stddef.h>

#define PEL_PI 3.14159265358979323846
#define PEL_DEG (PEL_PI / 180.0)

struct pel_vec2 {
    double x, y;
};

/* Of two corners. */
struct pel_box {
    struct pel_vec2 low, high;
};

struct pel_vec3 {
    double x, y, z;
};

/* Columns are the images of the axes: v_out = x·v.x + y·v.y + z·v.z. */
struct pel_mat3 {
    struct pel_vec3 x, y, z;
};

static inline struct pel_vec3 pel_vec3_add(struct pel_vec3 a, struct pel_vec3 b)
{
    return (struct pel_vec3){ a.x + b.x, a.y + b.y, a.z + b.z };
}

static inline struct pel_vec3 pel_vec3_scale(struct pel_vec3 a, double s)
{
    return (struct pel_vec3){ a.x * s, a.y * s, a.z * s };
}

static inline double pel_vec3_dot(struct pel_vec3 a, struct pel_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct pel_vec3 pel_vec3_cross(struct pel_vec3 a,
                                             struct pel_vec3 b)
{
    return (struct pel_vec3){ a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z,
                              a.x * b.y - a.y * b.x };
}

static inline struct pel_vec3 pel_vec3_normalize(struct pel_vec3 a)
{
    return pel_vec3_scale(a, 1.0 / sqrt(pel_vec3_dot(a, a)));
}

static inline struct pel_vec3 pel_mat3_apply(const struct pel_mat3 *m,
                                             struct pel_vec3 v)
{
    return pel_vec3_add(
        pel_vec3_add(pel_vec3_scale(m->x, v.x), pel_vec3_scale(m->y, v.y)),
        pel_vec3_scale(m->z, v.z));
}

static inline double pel_clamp(double v, double lo, double hi)
{
    return v < lo ? lo : v > hi ? hi : v;
}

/* A direction within 0 <= out < 360, which stays below 360 when it is written
 * with so many decimals: what would be 360 there is 0. */
static inline double pel_bearing_deg(double degrees, int decimals)
{
    double turned = fmod(degrees, 360);
    turned += turned < 0 ? 360 : 0;
    return turned >= 360 - 0.5 * pow(10, -decimals) ? 0 : turned;
}

/* The least that holds n points; none holds nothing. */
static inline struct pel_box pel_box_of(const struct pel_vec2 *points, size_t n)
{
    struct pel_box box = { { HUGE_VAL, HUGE_VAL }, { -HUGE_VAL, -HUGE_VAL } };
    for (size_t i = 0; i < n; i++) {
        box.low.x = fmin(box.low.x, points[i].x);
        box.low.y = fmin(box.low.y, points[i].y);
        box.high.x = fmax(box.high.x, points[i].x);
        box.high.y = fmax(box.high.y, points[i].y);
    }
    return box;
}
