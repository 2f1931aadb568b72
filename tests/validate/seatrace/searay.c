#include "searay.h"

#include <math.h>

double sea_water_index(double salinity, double celsius, double nm)
{
    double s = salinity, t = celsius;
    return 1.31405 + (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t * t) * s -
           2.02e-6 * t * t + (15.868 + 0.01155 * s - 0.00423 * t) / nm -
           4382 / (nm * nm) + 1.1455e6 / (nm * nm * nm);
}

double sea_fresnel(double cosine, double index)
{
    double sine2 = (1 - cosine * cosine) / (index * index);
    double inside = sqrt(1 - sine2);
    double s = (cosine - index * inside) / (cosine + index * inside);
    double p = (index * cosine - inside) / (index * cosine + inside);
    return 0.5 * (s * s + p * p);
}

void sea_reflect(const double *direction, const double *normal, double *out)
{
    double twice = 2 * sea_dot(direction, normal);
    double length = 0;
    for (int i = 0; i < 3; i++) {
        out[i] = direction[i] - twice * normal[i];
        length += out[i] * out[i];
    }
    for (int i = 0; i < 3; i++) {
        out[i] /= sqrt(length);
    }
}

/* How far the ray is clear for certain; *gap is the height above the surface
 * where all grids had to be asked, otherwise positive. Longer waves are asked
 * first: high above the short ones only their greatest height matters. */
static double clear_length(const struct sea_surface *surface, double x,
                           double y, double z, double across, double up,
                           double *gap)
{
    if (surface->choppy) {
        /* Displaced, the surface is steeper than its grids' sum of greatest
         * gradients only where all of them meet, which is never. */
        *gap = z - sea_surface_height(surface, x, y, 0);
        double closing = surface->steeper[surface->levels] * across - up;
        return closing <= 0 ? INFINITY : *gap / closing;
    }
    *gap = z;
    for (int l = 0;; l++) {
        *gap -= sea_level_height(&surface->level[l], x, y);
        double sure = *gap - surface->finer[l + 1];
        int last = l + 1 == surface->levels;
        if (last || sure > 0.3 * *gap) {
            if (sure > 0 || last) {
                double closing = surface->steeper[l + 1] * across - up;
                return closing <= 0 ? INFINITY : sure / closing;
            }
        }
    }
}

static void find_normal(const struct sea_surface *surface, const double *point,
                        double *normal)
{
    double g[2];
    sea_surface_height(surface, point[0], point[1], g);
    double scale = 1 / sqrt(1 + g[0] * g[0] + g[1] * g[1]);
    normal[0] = -g[0] * scale;
    normal[1] = -g[1] * scale;
    normal[2] = scale;
}

enum sea_end sea_trace(const struct sea_surface *surface, const double *from,
                       const double *direction, struct sea_hit *hit)
{
    enum { STEPS = 20000 };
    double across = hypot(direction[0], direction[1]), up = direction[2];
    double top = surface->finer[0];
    double at = 0, clear = 0;
    if (from[2] > top) {
        if (up >= 0) {
            return SEA_ESCAPED;
        }
        at = (top - from[2]) / up;
        clear = at;
    }
    for (hit->steps = 0; hit->steps < STEPS; hit->steps++) {
        double x = from[0] + at * direction[0];
        double y = from[1] + at * direction[1];
        double z = from[2] + at * up;
        if (z > top && up >= 0) {
            return SEA_ESCAPED;
        }
        double gap;
        double step = clear_length(surface, x, y, z, across, up, &gap);
        if (gap < 0) {
            break;
        }
        if (isinf(step)) {
            return SEA_ESCAPED;
        }
        clear = at;
        at += fmax(step, SEA_STEP_M);
    }
    if (hit->steps == STEPS) {
        return SEA_LOST;
    }
    /* Between clear and at the ray goes under. */
    for (int i = 0; i < 60 && at - clear > 1e-8; i++) {
        double middle = 0.5 * (clear + at);
        double x = from[0] + middle * direction[0];
        double y = from[1] + middle * direction[1];
        double z = from[2] + middle * up;
        if (z < sea_surface_height(surface, x, y, 0)) {
            at = middle;
        } else {
            clear = middle;
        }
    }
    for (int i = 0; i < 3; i++) {
        hit->point[i] = from[i] + clear * direction[i];
    }
    /* The normal of the side that the ray goes under in: between two cells
     * they differ. */
    double under[3] = { from[0] + at * direction[0],
                        from[1] + at * direction[1], 0 };
    find_normal(surface, under, hit->normal);
    if (sea_dot(direction, hit->normal) >= 0) {
        find_normal(surface, hit->point, hit->normal);
    }
    return SEA_HIT;
}

int sea_sees(const struct sea_surface *surface, double x, double y,
             const double *direction)
{
    double point[3] = { x, y, sea_surface_height(surface, x, y, 0) + 1e-7 };
    struct sea_hit hit;
    return sea_trace(surface, point, direction, &hit) == SEA_ESCAPED;
}
