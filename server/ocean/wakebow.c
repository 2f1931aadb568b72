#include "ocean/wakebow.h"

#include <math.h>

#define N PEL_WAKE_N
#define LONG 1.6 /* crest distances from the crest to the ridge's end */
#define WIDE 1.5 /* heights from the hull to its foot */
#define LEAST_LONG 3.0
#define LEAST_WIDE 2.5

/* 1 at 0, 0 from 1 on, smooth. */
static double hump(double x)
{
    return fabs(x) < 1 ? 0.5 + 0.5 * cos(PEL_PI * x) : 0;
}

bool pel_wake_bow_of(const struct pel_wake_track *track, double speed_mps,
                     const struct pel_wake_tile *tile,
                     struct pel_wake_raised *out)
{
    const struct pel_wake_bow *bow = &track->bow;
    double texel = tile->length_m / N, draught = track->hull.draught_m, alpha;
    if (!(bow->long_m > 0)) {
        return false;
    }
    struct pel_bow_wave w =
        pel_bow_wave_at(bow->half_m, bow->long_m, draught, speed_mps, &alpha);
    double behind = LONG * w.crest_m, beside = WIDE * w.height_m;
    *out = (struct pel_wake_raised){
        .bow = bow,
        .speed_mps = speed_mps,
        .high_m = fmin(w.height_m, PEL_WAKE_BOW_MOST * draught),
        .crest_m = w.crest_m,
        .before_m = fmax(w.crest_m, LEAST_WIDE * texel),
        .behind_m = fmax(behind, LEAST_LONG * texel),
        .beside_m = fmax(beside, LEAST_WIDE * texel),
    };
    out->share =
        fmin(behind / out->behind_m, 1) * fmin(beside / out->beside_m, 1);
    return w.crest_m > 0;
}

struct pel_vec2 pel_wake_bow_crest(const struct pel_wake_raised *r)
{
    double out = pel_bow_half_m(r->bow->half_m, r->bow->long_m, r->crest_m);
    return (struct pel_vec2){ r->x_m - r->crest_m * r->ex - out * r->ey,
                              r->y_m - r->crest_m * r->ey + out * r->ex };
}

/* Aft of the stem and off the middle, of its height. */
static double ridge(const struct pel_wake_raised *r, double aft, double off)
{
    double a = aft - r->crest_m;
    double along = hump(a / (a < 0 ? r->before_m : r->behind_m));
    if (along <= 0) {
        return 0;
    }
    double half = pel_bow_half_m(r->bow->half_m, r->bow->long_m, aft);
    return along * hump(fmax(fabs(off) - half, 0) / r->beside_m);
}

void pel_wake_bow_add(const struct pel_wake_raised *r, double thin_m,
                      const struct pel_wake_tile *tile)
{
    double high = r->share * fmax(r->high_m - thin_m, 0);
    double texel = tile->length_m / N, half = 0.5 * r->behind_m / texel;
    /* What the spline, of variance 1/3, takes off the top. */
    high /= 1 - PEL_PI * PEL_PI / (48 * half * half);
    double cx = r->x_m - r->crest_m * r->ex, cy = r->y_m - r->crest_m * r->ey;
    double widest = pel_bow_half_m(r->bow->half_m, r->bow->long_m,
                                   r->crest_m + r->behind_m);
    double reach = hypot(r->behind_m, r->beside_m + widest) + texel;
    int i0 = (int)floor((cx - reach) / texel);
    int j0 = (int)floor((cy - reach) / texel);
    int n = (int)fmin(ceil(2 * reach / texel) + 1, N);
    for (int j = j0; j < j0 + n && high > 0; j++) {
        for (int i = i0; i < i0 + n; i++) {
            double dx = i * texel - r->x_m, dy = j * texel - r->y_m;
            double aft = -(dx * r->ex + dy * r->ey);
            double off = dy * r->ex - dx * r->ey, step = 0.1 * texel;
            float *t = tile->texels[(j & (N - 1)) * N + (i & (N - 1))];
            t[2] += (float)(high * ridge(r, aft, off));
            t[3] += (float)(high * r->speed_mps *
                            (ridge(r, aft + step, off) -
                             ridge(r, aft - step, off)) /
                            (2 * step));
        }
    }
}
