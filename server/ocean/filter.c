#include "ocean/filter.h"

#include <math.h>
#include <stdlib.h>

#include "ocean/cascade.h"
#include "ocean/filtered_cascades.h"
#include "ocean/wander.h"

double pel_filter_weight(const struct pel_filter *f, double wavelengths)
{
    double x =
        pel_clamp((wavelengths - f->n_min) / (f->n_max - f->n_min), 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

double pel_filter_gain(const struct pel_filter *f, double wavelengths)
{
    double y = 1.0 / (wavelengths * wavelengths);
    return pel_filter_weight(f, wavelengths) * (1.0 - y * (1.6449 - 0.78 * y));
}

/* The default bounds' middle is 1.75 wavelengths. */
static double finer(const struct pel_filter *f)
{
    return log2((f->n_min + f->n_max) / 3.5);
}

double pel_filter_slope_bias(const struct pel_filter *f)
{
    return finer(f) - 0.5;
}

double pel_filter_shift_bias(const struct pel_filter *f)
{
    return finer(f) - 2.0;
}

/* Eq. 4's resolved part of one wave, in wind axes (c, s). */
static void take_resolved(const struct pel_wave *w, double c, double s,
                          double gain, struct pel_slopes *left)
{
    double k2 = w->kx * w->kx + w->ky * w->ky;
    double h2 = w->amplitude * w->amplitude;
    double kept =
        gain * gain * h2 / (1.0 + sqrt(1.0 - w->chop * w->chop * k2 * h2));
    struct pel_wave_square k = pel_wave_square(w);
    left->along -= kept * (c * c * k.xx + 2.0 * c * s * k.xy + s * s * k.yy);
    left->cross -= kept * (s * s * k.xx - 2.0 * c * s * k.xy + c * c * k.yy);
    left->mixed -= kept * (c * s * (k.yy - k.xx) + (c * c - s * s) * k.xy);
}

static double wavelengths_of(const struct pel_wave *w, double footprint_m)
{
    return 2.0 * PEL_PI / (footprint_m * hypot(w->kx, w->ky));
}

struct pel_slopes pel_sea_slopes_left(const struct pel_sea *sea,
                                      const struct pel_filter *filter,
                                      double footprint_m)
{
    if (sea->cascades) {
        return pel_cascades_left(sea->cascades, footprint_m,
                                 pel_filter_slope_bias(filter));
    }
    struct pel_slopes left = { sea->slope_variance_along,
                               sea->slope_variance_cross,
                               sea->slope_covariance };
    double c = cos(sea->desc.direction_rad), s = sin(sea->desc.direction_rad);
    for (int i = 0; i < sea->count; i++) {
        double lengths = wavelengths_of(&sea->waves[i], footprint_m);
        if (lengths > filter->n_min) {
            take_resolved(&sea->waves[i], c, s,
                          pel_filter_gain(filter, lengths), &left);
        }
    }
    left.along = fmax(left.along, 0);
    left.cross = fmax(left.cross, 0);
    return left;
}

static void filtered_trochoids(const struct pel_sea *sea,
                               const struct pel_filter *filter,
                               double footprint_m, struct pel_vec2 at,
                               double time_s, struct pel_filtered *out)
{
    struct pel_vec3 d = { 0, 0, 0 };
    double xx = 0, xy = 0, yx = 0, yy = 0, zx = 0, zy = 0;
    for (int i = 0; i < sea->count; i++) {
        const struct pel_wave *w = &sea->waves[i];
        double lengths = wavelengths_of(w, footprint_m);
        double moved = w->amplitude * pel_filter_weight(filter, lengths);
        double h = w->amplitude * pel_filter_gain(filter, lengths);
        if (moved == 0) {
            continue;
        }
        struct pel_wave_phase p = pel_wave_at(w, at.x, at.y, time_s);
        double s = sin(p.phase), c = cos(p.phase), k = hypot(w->kx, w->ky);
        double across = w->chop * h / k;
        d.x -= w->kx / k * w->chop * moved * s;
        d.y -= w->ky / k * w->chop * moved * s;
        d.z += moved * c;
        xx += w->kx * p.kx * across * c;
        xy += w->kx * p.ky * across * c;
        yx += w->ky * p.kx * across * c;
        yy += w->ky * p.ky * across * c;
        zx -= p.kx * h * s;
        zy -= p.ky * h * s;
    }
    struct pel_vec3 along_x = { 1.0 - xx, -yx, zx };
    struct pel_vec3 along_y = { -xy, 1.0 - yy, zy };
    out->shift = d;
    out->normal = pel_vec3_normalize(pel_vec3_cross(along_x, along_y));
}

enum pel_err pel_sea_filtered(const struct pel_sea *sea,
                              const struct pel_filter *filter,
                              double footprint_m, const struct pel_vec2 *points,
                              size_t n, double time_s, struct pel_filtered *out)
{
    if (sea->cascades) {
        enum pel_err err = pel_cascades_filtered(
            sea->cascades, filter, footprint_m, points, n, time_s, out);
        if (err) {
            return err;
        }
    }
    struct pel_slopes left = pel_sea_slopes_left(sea, filter, footprint_m);
    for (size_t i = 0; i < n; i++) {
        if (!sea->cascades) {
            filtered_trochoids(sea, filter, footprint_m, points[i], time_s,
                               &out[i]);
        }
        out[i].left = left;
    }
    return PEL_OK;
}
