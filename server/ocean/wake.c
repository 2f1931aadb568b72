#include "ocean/wake.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "ocean/fft.h"
#include "ocean/sea.h"

#define N PEL_WAKE_N
#define MODES PEL_WAKE_MODES

/* Packets count in full in this share of a tile's side about its middle, and
 * less and less up to the second: an edge would diffract waves back into the
 * tile. Reads fade over the shares FADE to FADED. */
#define WHOLE 0.30
#define HELD 0.47
#define FADE PEL_WAKE_FADE
#define FADED PEL_WAKE_FADED
/* The middle of the tiles lies half way back to where the ship was so long ago,
 * but so that the tile still holds the hull, and this much of a length more. */
#define BEHIND_S 120.0
#define AHEAD 0.6
/* A tile's share in a wave falls from 1 to 0 over the last of its modes, from
 * this share of the highest on: a sharp end rings over the whole tile. What the
 * tile of long waves leaves is the other one's. */
static const double ends_from[PEL_WAKE_TILES] = { 0.55, 0.65, 0.8 };
#define VISCOSITY 1.2e-6 /* m²/s, of the sea */

/* Tables of a hull's two transforms. */
#define ALONG_STEPS 32.0 /* a unit of s */
#define DEEP_STEPS 1024

struct form {
    double scale; /* of the beam */
    size_t along_count;
    float *along;               /* G(s) */
    float deep[DEEP_STEPS + 2]; /* over k, 0..k_most */
    double k_most;
};

/* ∫_0^1 P'(ξ) sin(sξ) dξ, without its sign. */
static double along_transform(double m, double s)
{
    double e = 1.0 - m;
    double scale = 2.0 / (e * e);
    if (s < 0.05) { /* to s³: differences of near numbers beyond */
        double first = (1.0 - m * m * m) / 3.0 - m * (1.0 - m * m) / 2.0;
        double third =
            (1.0 - pow(m, 5.0)) / 5.0 - m * (1.0 - pow(m, 4.0)) / 4.0;
        return scale * s * (first - s * s * third / 6.0);
    }
    return scale * (-e * cos(s) / s + (sin(s) - sin(s * m)) / (s * s));
}

/* cosh k(d − z) / cosh kd */
static double rises(double k, double z, double depth_m)
{
    if (depth_m <= 0 || k * depth_m > 15.0) {
        return exp(-k * z);
    }
    z = fmin(z, depth_m);
    return (exp(-k * z) + exp(-k * (2.0 * depth_m - z))) /
           (1.0 + exp(-2.0 * k * depth_m));
}

/* ∫_0^1 P(ζ) rises(k, Tζ) dζ, Simpson's rule. */
static double deep_transform(const struct pel_hull *hull, double m, double k,
                             double depth_m)
{
    enum { STEPS = 64 };
    double sum = 0;
    for (int i = 0; i <= STEPS; i++) {
        double z = (double)i / STEPS;
        double past = fmax(z - m, 0.0) / (1.0 - m);
        double weight = i == 0 || i == STEPS ? 1.0 : i % 2 ? 4.0 : 2.0;
        sum += weight * (1.0 - past * past) *
               rises(k, hull->draught_m * z, depth_m);
    }
    return sum / (3.0 * STEPS);
}

static enum pel_err form_init(struct form *form, const struct pel_hull *hull,
                              double k_most, double depth_m)
{
    /* (2 + m) / 3 (2 + n) / 3 of the box is filled. */
    const double wigley = 4.0 / 9.0, full = 0.6;
    double n = 0.85 * pel_clamp((hull->block - wigley) / (full - wigley), 0, 1);
    double m = pel_clamp(9.0 * hull->block / (2.0 + n) - 2.0, 0.0, 0.93);
    form->scale = hull->block / ((2.0 + m) * (2.0 + n) / 9.0);
    form->k_most = k_most;
    form->along_count =
        (size_t)(0.5 * hull->length_m * k_most * ALONG_STEPS) + 3;
    form->along = malloc(form->along_count * sizeof *form->along);
    if (!form->along) {
        return PEL_ERR_NO_MEMORY;
    }
    for (size_t i = 0; i < form->along_count; i++) {
        form->along[i] = (float)along_transform(m, (double)i / ALONG_STEPS);
    }
    for (int i = 0; i < DEEP_STEPS + 2; i++) {
        form->deep[i] =
            (float)deep_transform(hull, n, k_most * i / DEEP_STEPS, depth_m);
    }
    return PEL_OK;
}

static double table_at(const float *table, double x)
{
    size_t i = (size_t)x;
    double f = x - (double)i;
    return (1.0 - f) * (double)table[i] + f * (double)table[i + 1];
}

/* A piece of track as the modes need it. */
struct piece {
    double begin_s, end_s;
    double x, y;   /* at its end */
    double vx, vy; /* m/s */
    double ex, ey; /* unit, along it */
    double strength;
};

struct summing {
    const struct form *form;
    const struct pel_hull *hull;
    double time_s, depth_m;
    int count;
    struct piece piece[PEL_WAKE_POINTS];
};

static double dispersion(double k, double depth_m, double *group_mps)
{
    double kd = depth_m > 0 ? k * depth_m : 100.0;
    double th = kd > 20.0 ? 1.0 : tanh(kd);
    double omega = sqrt(PEL_GRAVITY * k * th);
    double shallow = kd > 20.0 ? 0.0 : 2.0 * kd / sinh(2.0 * kd);
    *group_mps = 0.5 * omega / k * (1.0 + shallow);
    return omega;
}

/* Cuts [*a, *b] to where at + by τ lies within ± half; false: nowhere. */
static bool clip(double at, double by, double half, double *a, double *b)
{
    if (fabs(by) < 1e-12) {
        return fabs(at) < half;
    }
    double p = (-half - at) / by, q = (half - at) / by;
    *a = fmax(*a, fmin(p, q));
    *b = fmin(*b, fmax(p, q));
    return *a < *b;
}

static double sinc(double x)
{
    return fabs(x) < 1e-6 ? 1.0 : sin(x) / x;
}

/* A packet's way through a tile, from its middle, while τ goes over a piece. */
struct way {
    double at[2], by[2];
    double whole, held; /* half sides */
};

/* Where a packet's weight begins or ceases to fall, within (from, to). */
static int breaks_of(const struct way *way, double from, double to,
                     double at[6])
{
    int count = 0;
    at[count++] = from;
    for (int i = 0; i < 4; i++) {
        int axis = i / 2;
        double bound = i % 2 ? way->whole : -way->whole;
        double t = (bound - way->at[axis]) / way->by[axis];
        if (!(t > from && t < to)) {
            continue;
        }
        int k = count++;
        for (; k > 1 && at[k - 1] > t; k--) {
            at[k] = at[k - 1];
        }
        at[k] = t;
    }
    at[count] = to;
    return count;
}

/* ∫ weight(τ) e^{i g (τ − mid)} dτ over a stretch in which one axis says the
 * weight: 1, or falling like a cosine. */
static void stretch(const struct way *way, double mid, double length, double g,
                    double out[2])
{
    double half = 0.5 * length;
    double x = way->at[0] + way->by[0] * mid, y = way->at[1] + way->by[1] * mid;
    int axis = fabs(y) > fabs(x);
    double p = axis ? y : x;
    out[0] = length * sinc(g * half);
    out[1] = 0;
    if (fabs(p) > way->whole) {
        double per_m = PEL_PI / (way->held - way->whole);
        double theta = (fabs(p) - way->whole) * per_m;
        double q = copysign(way->by[axis], way->by[axis] * p) * per_m;
        double up = sinc((g + q) * half), down = sinc((g - q) * half);
        out[0] = 0.5 * out[0] + 0.25 * length * cos(theta) * (up + down);
        out[1] = 0.25 * length * sin(theta) * (up - down);
    }
}

/* i Q of a piece at k. */
static double emission(const struct summing *s, const struct piece *p,
                       double kx, double ky, double k)
{
    double along = 0.5 * s->hull->length_m * (kx * p->ex + ky * p->ey);
    return p->strength * copysign(1.0, along) *
           table_at(s->form->along, fabs(along) * ALONG_STEPS) *
           table_at(s->form->deep, k / s->form->k_most * DEEP_STEPS);
}

/* One mode of the waves that travel along k, from all pieces. */
static void sum_mode(const struct summing *s, const struct pel_wake_tile *tile,
                     double kx, double ky, double k, double out[2])
{
    double group;
    double omega = dispersion(k, s->depth_m, &group);
    double cgx = group * kx / k, cgy = group * ky / k;
    double re = 0, im = 0;
    for (int i = 0; i < s->count; i++) {
        const struct piece *p = &s->piece[i];
        /* τ from the piece's end on; the packet is at X(τ) + c_g (t − τ). */
        double from = p->begin_s - p->end_s, to = 0;
        double age = s->time_s - p->end_s;
        const struct way way = {
            { p->x + cgx * age - tile->x_m, p->y + cgy * age - tile->y_m },
            { p->vx - cgx, p->vy - cgy },
            WHOLE * tile->length_m,
            HELD * tile->length_m,
        };
        if (!clip(way.at[0], way.by[0], way.held, &from, &to) ||
            !clip(way.at[1], way.by[1], way.held, &from, &to)) {
            continue;
        }
        double g = omega - kx * p->vx - ky * p->vy;
        double form = emission(s, p, kx, ky, k);
        double at[6];
        int count = breaks_of(&way, from, to, at);
        for (int b = 0; b < count; b++) {
            double mid = 0.5 * (at[b] + at[b + 1]), part[2];
            stretch(&way, mid, at[b + 1] - at[b], g, part);
            double phase = kx * (p->x + p->vx * mid) +
                           ky * (p->y + p->vy * mid) + omega * (age - mid);
            double a = form * exp(-2.0 * VISCOSITY * k * k * (age - mid));
            /* −i a e^{−i phase} part */
            double c = a * cos(phase), d = a * sin(phase);
            re += c * part[1] - d * part[0];
            im -= c * part[0] + d * part[1];
        }
    }
    out[0] = re;
    out[1] = im;
}

/* Two dimensions of inverse transforms in place; only rows up to MODES from the
 * first, either way round, hold anything. */
struct plane {
    float re[N][N], im[N][N];
};

struct work {
    struct plane heave, sway; /* (h, ∂h/∂t), (Dx, Dy) */
    struct pel_fft_strip strip;
};

static void transform(struct plane *g, struct pel_fft_strip *strip)
{
    for (int j = 0; j < N; j += PEL_FFT_LANES) {
        if (j > MODES && j + PEL_FFT_LANES <= N - MODES) {
            continue;
        }
        for (int i = 0; i < N; i++) {
            for (int l = 0; l < PEL_FFT_LANES; l++) {
                strip->re[i][l] = g->re[j + l][i];
                strip->im[i][l] = g->im[j + l][i];
            }
        }
        pel_fft_strip(strip);
        for (int i = 0; i < N; i++) {
            for (int l = 0; l < PEL_FFT_LANES; l++) {
                g->re[j + l][i] = strip->re[i][l];
                g->im[j + l][i] = strip->im[i][l];
            }
        }
    }
    for (int i = 0; i < N; i += PEL_FFT_LANES) {
        for (int j = 0; j < N; j++) {
            memcpy(&strip->re[j], &g->re[j][i], sizeof strip->re[j]);
            memcpy(&strip->im[j], &g->im[j][i], sizeof strip->im[j]);
        }
        pel_fft_strip(strip);
        for (int j = 0; j < N; j++) {
            memcpy(&g->re[j][i], &strip->re[j], sizeof strip->re[j]);
            memcpy(&g->im[j][i], &strip->im[j], sizeof strip->im[j]);
        }
    }
}

/* Gain of the cubic B-spline for a wave of mode number m. */
static double spline_gain(int m)
{
    double x = PEL_PI * m / N;
    double s = m == 0 ? 1.0 : sin(x) / x;
    return s * s * s * s;
}

double pel_wake_near_m(const struct pel_hull *hull)
{
    return fmax(PEL_WAKE_NEAR_M, 3.0 * hull->length_m);
}

static double side_m(int i, double near_m)
{
    return near_m * pow(PEL_WAKE_RATIO, PEL_WAKE_TILES - 1 - i);
}

/* Share of tile i in waves of k, without regard to those of longer waves. */
static double up_to(int i, double near_m, double k)
{
    double u = k * side_m(i, near_m) / (2.0 * PEL_PI * MODES);
    double from = ends_from[i];
    return u <= from  ? 1.0
           : u >= 1.0 ? 0.0
                      : 0.5 + 0.5 * cos(PEL_PI * (u - from) / (1.0 - from));
}

/* A tile's modes, in pairs: mode p travels along k, mode p + pairs along −k. */
struct modes {
    struct pel_wake_tile tile; /* without texels */
    int pairs, padded;         /* of a multiple of LANES */
    int (*at)[2];              /* m, n */
    float (*unit)[2];          /* k/|k| */
    float *turns;              /* ω / 2π, of a pair */
    /* Of each mode: what is in the water, what the ship adds (amplitude at
     * the past's moment, its slip (ω − k·V) / 2π). */
    float *re, *im, *add_re, *add_im, *slip;
    void *memory;
};

struct pel_wake_past {
    double vx, vy; /* the ship's */
    struct modes modes[PEL_WAKE_TILES];
};

static bool modes_alloc(struct modes *m, int pairs)
{
    m->pairs = pairs;
    m->padded = (pairs + PEL_FFT_LANES - 1) / PEL_FFT_LANES * PEL_FFT_LANES;
    size_t n = (size_t)m->padded;
    float *f = calloc(15 * n, sizeof *f);
    m->memory = f;
    if (!f) {
        return false;
    }
    m->at = (int(*)[2])f;
    m->unit = (float(*)[2])(f + 2 * n);
    m->turns = f + 4 * n;
    m->re = f + 5 * n;
    m->im = f + 7 * n;
    m->add_re = f + 9 * n;
    m->add_im = f + 11 * n;
    m->slip = f + 13 * n;
    return true;
}

/* Mode p of the pair at m, n; `open`: the piece that goes on, or NULL. */
static void fill_mode(const struct summing *s, const struct piece *open,
                      struct modes *modes, int p, double kx, double ky,
                      double gain)
{
    double k = hypot(kx, ky), a[2], group;
    double omega = dispersion(k, s->depth_m, &group);
    sum_mode(s, &modes->tile, kx, ky, k, a);
    modes->re[p] = (float)(gain * a[0]);
    modes->im[p] = (float)(gain * a[1]);
    if (open) {
        double c = gain * emission(s, open, kx, ky, k);
        double phase = kx * open->x + ky * open->y;
        modes->add_re[p] = (float)(-c * sin(phase));
        modes->add_im[p] = (float)(-c * cos(phase));
        modes->slip[p] =
            (float)((omega - kx * open->vx - ky * open->vy) / (2.0 * PEL_PI));
    }
}

static double share_of(int which, double near_m, double k)
{
    return up_to(which, near_m, k) -
           (which ? up_to(which - 1, near_m, k) : 0.0);
}

/* Half of the plane: k and −k together. */
static enum pel_err fill_modes(const struct summing *s,
                               const struct piece *open, int which,
                               struct modes *modes)
{
    double length_m = modes->tile.length_m;
    double step = 2.0 * PEL_PI / length_m;
    double near_m = pel_wake_near_m(s->hull);
    for (int pass = 0; pass < 2; pass++) {
        int p = 0;
        for (int n = 0; n <= MODES; n++) {
            for (int m = n ? -MODES : 1; m <= MODES; m++) {
                double kx = m * step, ky = n * step, k = hypot(kx, ky), group;
                double share = share_of(which, near_m, k);
                if (share <= 0) {
                    continue;
                }
                if (pass) {
                    double gain = share / (spline_gain(m) * spline_gain(n) *
                                           length_m * length_m);
                    modes->at[p][0] = m;
                    modes->at[p][1] = n;
                    modes->unit[p][0] = (float)(kx / k);
                    modes->unit[p][1] = (float)(ky / k);
                    modes->turns[p] =
                        (float)(dispersion(k, s->depth_m, &group) /
                                (2.0 * PEL_PI));
                    fill_mode(s, open, modes, p, kx, ky, gain);
                    fill_mode(s, open, modes, p + modes->padded, -kx, -ky,
                              gain);
                }
                p++;
            }
        }
        if (!pass && !modes_alloc(modes, p)) {
            return PEL_ERR_NO_MEMORY;
        }
    }
    return PEL_OK;
}

static void add_piece(struct summing *s, const struct pel_wake_point *a,
                      const struct pel_wake_point *b, double end_s)
{
    double lasts = b->time_s - a->time_s;
    double vx = (b->x_m - a->x_m) / lasts, vy = (b->y_m - a->y_m) / lasts;
    double speed = hypot(vx, vy);
    if (!(lasts > 0) || speed < 1e-3 || a->time_s >= end_s) {
        return;
    }
    s->piece[s->count++] = (struct piece){
        .begin_s = a->time_s,
        .end_s = end_s,
        .x = a->x_m + vx * (end_s - a->time_s),
        .y = a->y_m + vy * (end_s - a->time_s),
        .vx = vx,
        .vy = vy,
        .ex = vx / speed,
        .ey = vy / speed,
        .strength =
            2.0 * speed * s->hull->beam_m * s->form->scale * s->hull->draught_m,
    };
}

static struct pel_vec2 place_at(const struct pel_wake_track *track, double t)
{
    int i = 0;
    while (i + 2 < track->count && track->point[i + 1].time_s < t) {
        i++;
    }
    const struct pel_wake_point *a = &track->point[i], *b = a + 1;
    double f = fmax((t - a->time_s) / (b->time_s - a->time_s), 0.0);
    return (struct pel_vec2){ a->x_m + f * (b->x_m - a->x_m),
                              a->y_m + f * (b->y_m - a->y_m) };
}

/* The middle of tile `which` where the ship is at `now`. */
static void place_tile(const struct pel_wake_track *track, double time_s,
                       int which, struct pel_wake_tile *tile)
{
    struct pel_vec2 now = place_at(track, time_s);
    struct pel_vec2 then = place_at(track, time_s - BEHIND_S);
    tile->length_m = side_m(which, pel_wake_near_m(&track->hull));
    double back = 0.5 * hypot(then.x - now.x, then.y - now.y);
    double most = WHOLE * tile->length_m - AHEAD * track->hull.length_m;
    double share = 0.5 * (back > most ? most / back : 1.0);
    tile->x_m = now.x + share * (then.x - now.x);
    tile->y_m = now.y + share * (then.y - now.y);
}

static void add_pieces(struct summing *s, const struct pel_wake_track *track)
{
    for (int i = 0; i + 1 < track->count; i++) {
        const struct pel_wake_point *a = &track->point[i], *b = a + 1;
        bool open = i + 2 == track->count;
        add_piece(s, a, b, open ? s->time_s : fmin(b->time_s, s->time_s));
    }
}

enum pel_err pel_wake_past_create(const struct pel_wake_track *track,
                                  double time_s, double depth_m,
                                  struct pel_wake_past **out)
{
    double near_m = pel_wake_near_m(&track->hull);
    struct form form = { 0 };
    struct pel_wake_past *past = calloc(1, sizeof *past);
    struct summing *s = calloc(1, sizeof *s);
    enum pel_err err = PEL_ERR_NO_MEMORY;
    if (past && s) {
        err = form_init(&form, &track->hull, MODES * 2.0 * PEL_PI / near_m,
                        depth_m);
    }
    if (err == PEL_OK) {
        *s = (struct summing){ .form = &form,
                               .hull = &track->hull,
                               .time_s = time_s,
                               .depth_m = depth_m };
        add_pieces(s, track);
        const struct piece *last = s->count ? &s->piece[s->count - 1] : NULL;
        /* A ship that stands has no last piece. */
        last = last && last->end_s >= time_s ? last : NULL;
        past->vx = last ? last->vx : 0;
        past->vy = last ? last->vy : 0;
        for (int i = 0; err == PEL_OK && i < PEL_WAKE_TILES; i++) {
            place_tile(track, time_s, i, &past->modes[i].tile);
            err = fill_modes(s, last, i, &past->modes[i]);
        }
    }
    free(form.along);
    free(s);
    if (err != PEL_OK) {
        pel_wake_past_destroy(past);
        return err;
    }
    *out = past;
    return PEL_OK;
}

void pel_wake_past_destroy(struct pel_wake_past *past)
{
    if (past) {
        for (int i = 0; i < PEL_WAKE_TILES; i++) {
            free(past->modes[i].memory);
        }
        free(past);
    }
}

/* Amplitudes of all modes later_s on: those in the water turn, and the ship
 * adds a piece. Into re, im, PAIRS of padded each. */
static void turn_modes(const struct pel_wake_past *past, const struct modes *m,
                       double later_s, float *re, float *im)
{
    double length_m = m->tile.length_m;
    /* The middle of the piece is as many tiles further. */
    double fx = 0.5 * past->vx * later_s / length_m;
    double fy = 0.5 * past->vy * later_s / length_m;
    for (int p = 0; p < 2 * m->padded; p++) {
        int q = p < m->padded ? p : p - m->padded;
        float side = p < m->padded ? 1.0f : -1.0f;
        float a = 2.0f * (float)PEL_PI * m->turns[q] * (float)later_s;
        float c = cosf(a), d = sinf(a);
        re[p] = m->re[p] * c + m->im[p] * d;
        im[p] = m->im[p] * c - m->re[p] * d;
        float slip = (float)PEL_PI * m->slip[p] * (float)later_s;
        float grown =
            (float)later_s * (fabsf(slip) < 1e-3f ? 1.0f : sinf(slip) / slip);
        float b = 2.0f * (float)PEL_PI * side *
                      ((float)m->at[q][0] * (float)fx +
                       (float)m->at[q][1] * (float)fy) +
                  0.5f * a;
        float e = grown * cosf(b), f = grown * sinf(b);
        re[p] += m->add_re[p] * e + m->add_im[p] * f;
        im[p] += m->add_im[p] * e - m->add_re[p] * f;
    }
}

/* Real fields of modes that travel along k and −k, two in each plane. */
static void put_modes(const struct modes *m, const float *re, const float *im,
                      struct work *w)
{
    memset(&w->heave, 0, sizeof w->heave);
    memset(&w->sway, 0, sizeof w->sway);
    for (int p = 0; p < m->pairs; p++) {
        int q = p + m->padded;
        int i = m->at[p][0] & (N - 1), j = m->at[p][1];
        int io = -m->at[p][0] & (N - 1), jo = -j & (N - 1);
        float omega = 2.0f * (float)PEL_PI * m->turns[p];
        float ux = m->unit[p][0], uy = m->unit[p][1];
        /* H = (B(k) + B*(−k)) / 2, its rate −i ω (B(k) − B*(−k)) / 2 */
        float hr = 0.5f * (re[p] + re[q]), hi = 0.5f * (im[p] - im[q]);
        float vr = 0.5f * omega * (im[p] + im[q]);
        float vi = -0.5f * omega * (re[p] - re[q]);
        w->heave.re[j][i] = hr - vi;
        w->heave.im[j][i] = hi + vr;
        w->heave.re[jo][io] = hr + vi;
        w->heave.im[jo][io] = vr - hi;
        /* H (i ux − uy) and its like at −k */
        w->sway.re[j][i] = -uy * hr - ux * hi;
        w->sway.im[j][i] = ux * hr - uy * hi;
        w->sway.re[jo][io] = uy * hr - ux * hi;
        w->sway.im[jo][io] = -ux * hr - uy * hi;
    }
}

static enum pel_err make_tile(const struct pel_wake_past *past, int which,
                              double later_s, struct work *w,
                              struct pel_wake_tile *tile)
{
    const struct modes *m = &past->modes[which];
    size_t n = 2 * (size_t)m->padded;
    float *amplitudes = calloc(2 * n, sizeof *amplitudes);
    *tile = m->tile;
    tile->x_m += past->vx * later_s;
    tile->y_m += past->vy * later_s;
    tile->texels = malloc((size_t)N * N * sizeof *tile->texels);
    if (!amplitudes || !tile->texels) {
        free(amplitudes);
        return PEL_ERR_NO_MEMORY;
    }
    turn_modes(past, m, later_s, amplitudes, amplitudes + n);
    put_modes(m, amplitudes, amplitudes + n, w);
    free(amplitudes);
    transform(&w->heave, &w->strip);
    transform(&w->sway, &w->strip);
    for (int i = 0; i < N * N; i++) {
        float *t = tile->texels[i];
        t[0] = w->sway.re[i / N][i % N];
        t[1] = w->sway.im[i / N][i % N];
        t[2] = w->heave.re[i / N][i % N];
        t[3] = w->heave.im[i / N][i % N];
    }
    return PEL_OK;
}

enum pel_err pel_wake_later(const struct pel_wake_past *past, double later_s,
                            struct pel_wake **out)
{
    struct pel_wake *wake = calloc(1, sizeof *wake);
    struct work *w = aligned_alloc(64, sizeof *w);
    enum pel_err err = wake && w ? PEL_OK : PEL_ERR_NO_MEMORY;
    for (int i = 0; err == PEL_OK && i < PEL_WAKE_TILES; i++) {
        err = make_tile(past, i, later_s, w, &wake->tile[i]);
    }
    free(w);
    if (err != PEL_OK) {
        pel_wake_destroy(wake);
        return err;
    }
    *out = wake;
    return PEL_OK;
}

enum pel_err pel_wake_create(const struct pel_wake_track *track, double time_s,
                             double depth_m, struct pel_wake **out)
{
    struct pel_wake_past *past = NULL;
    enum pel_err err = pel_wake_past_create(track, time_s, depth_m, &past);
    if (err == PEL_OK) {
        err = pel_wake_later(past, 0, out);
        pel_wake_past_destroy(past);
    }
    return err;
}

void pel_wake_destroy(struct pel_wake *wake)
{
    if (wake) {
        for (int i = 0; i < PEL_WAKE_TILES; i++) {
            free(wake->tile[i].texels);
        }
        free(wake);
    }
}

/* Uniform cubic B-spline of the four texels around, and its derivative. */
static void spline(double f, double w[4], double d[4])
{
    double g = 1.0 - f;
    w[0] = g * g * g / 6.0;
    w[1] = (4.0 - 6.0 * f * f + 3.0 * f * f * f) / 6.0;
    w[2] = (4.0 - 6.0 * g * g + 3.0 * g * g * g) / 6.0;
    w[3] = f * f * f / 6.0;
    d[0] = -0.5 * g * g;
    d[1] = f * (1.5 * f - 2.0);
    d[2] = g * (2.0 - 1.5 * g);
    d[3] = 0.5 * f * f;
}

/* 1 inside, 0 at the border, and its derivative by x. */
static double fade(double x, double length_m, double *slope)
{
    double u = (fabs(x) / length_m - FADE) / (FADED - FADE);
    *slope = 0;
    if (u <= 0 || u >= 1) {
        return u <= 0 ? 1.0 : 0.0;
    }
    *slope = copysign(-6.0 * u * (1.0 - u) / ((FADED - FADE) * length_m), x);
    return 1.0 - u * u * (3.0 - 2.0 * u);
}

/* Value and derivatives by x and y of four channels. */
struct read {
    double v[4], x[4], y[4];
};

static void read_tile(const struct pel_wake_tile *tile, double x, double y,
                      struct read *r)
{
    double u = x / tile->length_m, v = y / tile->length_m;
    u = (u - floor(u)) * N;
    v = (v - floor(v)) * N;
    int i0 = (int)u, j0 = (int)v;
    double wx[4], dx[4], wy[4], dy[4];
    spline(u - i0, wx, dx);
    spline(v - j0, wy, dy);
    memset(r, 0, sizeof *r);
    double per_m = N / tile->length_m;
    for (int j = 0; j < 4; j++) {
        const float(*row)[4] = (const float(*)[4])tile->texels +
                               (size_t)((j0 + j - 1 + N) % N) * N;
        for (int i = 0; i < 4; i++) {
            const float *t = row[(i0 + i - 1 + N) % N];
            for (int c = 0; c < 4; c++) {
                r->v[c] += wx[i] * wy[j] * (double)t[c];
                r->x[c] += dx[i] * wy[j] * per_m * (double)t[c];
                r->y[c] += wx[i] * dy[j] * per_m * (double)t[c];
            }
        }
    }
}

void pel_wake_add(const struct pel_wake *wake, double x_m, double y_m,
                  struct pel_wake_shift *to)
{
    for (int i = 0; i < PEL_WAKE_TILES; i++) {
        const struct pel_wake_tile *tile = &wake->tile[i];
        double sx, sy;
        double fx = fade(x_m - tile->x_m, tile->length_m, &sx);
        double fy = fade(y_m - tile->y_m, tile->length_m, &sy);
        if (fx <= 0 || fy <= 0) {
            continue;
        }
        struct read r;
        read_tile(tile, x_m, y_m, &r);
        double f = fx * fy, gx = sx * fy, gy = fx * sy;
        to->d.x += f * r.v[0];
        to->d.y += f * r.v[1];
        to->d.z += f * r.v[2];
        to->rise_mps += f * r.v[3];
        to->dxx += f * r.x[0] + gx * r.v[0];
        to->dxy += f * r.y[0] + gy * r.v[0];
        to->dyx += f * r.x[1] + gx * r.v[1];
        to->dyy += f * r.y[1] + gy * r.v[1];
        to->hx += f * r.x[2] + gx * r.v[2];
        to->hy += f * r.y[2] + gy * r.v[2];
    }
}
