/* Where the cascades are read: the water at rest, sheared a little and slowly,
 * so that a tile does not visibly repeat (cascade.h, Sampling). Twin of
 * shaders/lib/cascades.glsl: shear. */
#pragma once

#include <stdint.h>
#include <string.h>

#include "base/simd.h"
#include "shaders/lib/blocks.h"

#define PEL_SHEARS (2 * PEL_CASCADES) /* two a cascade; PEL_SHEAR_RATIO */

/* Shear i carries a place x by v q(f · x), q(t) = r − 2 r |r| − 1/8 with r what
 * is left of t + 1/4 beyond the nearest whole number: smooth, of period 1, and
 * at the origin 0 as its slope is. v is normal to f, |v| |f| the shear: areas
 * stay, and so does the variance of what is read. */
struct pel_shears {
    double fx[PEL_SHEARS], fy[PEL_SHEARS]; /* 1/m; 2 c and 2 c + 1 are those of
                                              cascade c */
    double v[PEL_SHEARS][2];               /* m */
    double turn[PEL_SHEARS][4];            /* vx fx, vx fy, vy fx, vy fy */
};

/* Where cascade c is read for a place: by its own shears and those of all the
 * coarser ones; and the derivative of that place by the other. */
struct pel_sheared {
    double place[PEL_SHEARS / 2][2];
    double by[PEL_SHEARS / 2][4]; /* ∂X/∂x, ∂X/∂y, ∂Y/∂x, ∂Y/∂y */
};

/* For a place (x, y) in metres, |x|, |y| ≤ 1e9. Any thread. */
PEL_INLINE void pel_shear(const struct pel_shears *s, double x, double y,
                          struct pel_sheared *out)
{
    typedef double lanes __attribute__((vector_size(8 * PEL_SHEARS)));
    typedef int64_t bits __attribute__((vector_size(8 * PEL_SHEARS)));
    typedef double pair __attribute__((vector_size(16)));
    typedef double matrix __attribute__((vector_size(32)));
    const double magic = 6755399441055744.0; /* 1.5 · 2⁵² */
    lanes fx, fy;
    memcpy(&fx, s->fx, sizeof fx);
    memcpy(&fy, s->fy, sizeof fy);
    lanes t = fx * x + fy * y + 0.25;
    lanes r = t - ((t + magic) - magic);
    lanes size = (lanes)((bits)r & INT64_MAX);
    lanes q = r - 2.0 * r * size - 0.125;
    lanes g = 1.0 - 4.0 * size;
    pair place = { x, y };
    matrix by = { 1, 0, 0, 1 };
    for (int c = 0; c < PEL_SHEARS / 2; c++) {
        for (int i = 2 * c; i < 2 * c + 2; i++) {
            pair v;
            matrix turn;
            memcpy(&v, s->v[i], sizeof v);
            memcpy(&turn, s->turn[i], sizeof turn);
            place += v * q[i];
            by += turn * g[i];
        }
        memcpy(out->place[c], &place, sizeof place);
        memcpy(out->by[c], &by, sizeof by);
    }
}
