#include "ocean/wake.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "ocean/fft.h"
#include "ocean/lanes.h"
#include "ocean/sea.h"
#include "ocean/spline.h"
#include "ocean/wakebasin.h"
#include "ocean/wakebow.h"

#define N PEL_WAKE_N
#define MODES PEL_WAKE_MODES
#define STRIPS (N / PEL_FFT_LANES)

/* Reads fade over these shares of a tile's side. */
#define FADE PEL_WAKE_FADE
#define FADED PEL_WAKE_FADED
/* The middle of the tiles lies half way back to where the ship was so long ago,
 * but so that the tile still holds the hull, and this much of a length more. */
#define BEHIND_S 120.0
#define AHEAD 0.6

/* Two dimensions of inverse transforms: strips of rows, whose lanes are rows,
 * then of columns. Only rows up to MODES from the first, either way round, hold
 * anything. */
struct plane {
    struct pel_fft_strip rows[STRIPS], columns[STRIPS];
};

struct work {
    struct plane heave, sway; /* (h, ∂h/∂t), (Dx, Dy) */
};

static bool is_empty(int strip)
{
    int j = strip * PEL_FFT_LANES;
    return j > MODES && j + PEL_FFT_LANES <= N - MODES;
}

PEL_CLONES static void lay_rows(const struct pel_fft_strip *rows, int j,
                                struct pel_fft_strip *columns)
{
    pel_lanes_lay_rows(rows, j, columns);
}

PEL_CLONES static void store(const struct work *w, int b, float (*texels)[4])
{
    const struct pel_fft_strip *sway = &w->sway.columns[b];
    const struct pel_fft_strip *heave = &w->heave.columns[b];
    for (int j = 0; j < N; j++) {
        pel_lanes_store4(&texels[j * N + b * PEL_FFT_LANES], sway->re[j],
                         sway->im[j], heave->re[j], heave->im[j]);
    }
}

static void transform_rows(struct plane *g)
{
    for (int b = 0; b < STRIPS; b++) {
        if (is_empty(b)) {
            pel_lanes_lay_none(b * PEL_FFT_LANES, g->columns);
        } else {
            pel_fft_strip(&g->rows[b]);
            lay_rows(&g->rows[b], b * PEL_FFT_LANES, g->columns);
        }
    }
}

static void transform(struct work *w, float (*texels)[4])
{
    transform_rows(&w->heave);
    transform_rows(&w->sway);
    for (int b = 0; b < STRIPS; b++) {
        pel_fft_strip(&w->heave.columns[b]);
        pel_fft_strip(&w->sway.columns[b]);
        store(w, b, texels);
    }
}

double pel_wake_near_m(const struct pel_hull *hull)
{
    return fmax(PEL_WAKE_NEAR_M, 3.0 * hull->length_m);
}

/* --- the track ------------------------------------------------------------ */

struct legs {
    int count;
    double fastest_mps;
    struct pel_wake_leg leg[PEL_WAKE_POINTS];
};

/* The pieces of a track within [from_s, until_s]; the last goes on. */
static void legs_of(const struct pel_wake_track *track, double from_s,
                    double until_s, struct legs *out)
{
    out->count = 0;
    out->fastest_mps = 0;
    for (int i = 0; i + 1 < track->count; i++) {
        const struct pel_wake_point *a = &track->point[i], *b = a + 1;
        bool open = i + 2 == track->count;
        double lasts = b->time_s - a->time_s;
        double begin_s = fmax(a->time_s, from_s);
        double end_s = open ? until_s : fmin(b->time_s, until_s);
        double vx = (b->x_m - a->x_m) / lasts, vy = (b->y_m - a->y_m) / lasts;
        double speed = hypot(vx, vy);
        if (!(lasts > 0) || speed < 1e-3 || begin_s >= end_s) {
            continue;
        }
        out->fastest_mps = fmax(out->fastest_mps, speed);
        out->leg[out->count++] = (struct pel_wake_leg){
            .begin_s = begin_s,
            .end_s = end_s,
            .x = a->x_m + vx * (end_s - a->time_s),
            .y = a->y_m + vy * (end_s - a->time_s),
            .vx = vx,
            .vy = vy,
        };
    }
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

/* The middle of a tile of this side. */
static struct pel_vec2 middle_of(const struct pel_wake_track *track,
                                 double time_s, double length_m)
{
    struct pel_vec2 now = place_at(track, time_s);
    struct pel_vec2 then = place_at(track, time_s - BEHIND_S);
    double back = 0.5 * hypot(then.x - now.x, then.y - now.y);
    double most = PEL_WAKE_WHOLE * length_m - AHEAD * track->hull.length_m;
    double share = 0.5 * (back > most ? most / back : 1.0);
    return (struct pel_vec2){ now.x + share * (then.x - now.x),
                              now.y + share * (then.y - now.y) };
}

/* A slow ship's first tile is one more of the second's, this far behind it, in
 * sides. */
#define TRAIL 0.68
#define TRAIL_S 600.0 /* at most */

static struct pel_vec2 middle_behind(const struct pel_wake_track *track,
                                     double time_s, double length_m)
{
    struct pel_vec2 now = place_at(track, time_s);
    struct pel_vec2 then = place_at(track, time_s - BEHIND_S);
    double speed = hypot(then.x - now.x, then.y - now.y) / BEHIND_S;
    double back_s = TRAIL * length_m / fmax(speed, 0.5);
    return middle_of(track, time_s - fmin(back_s, TRAIL_S), length_m);
}

/* --- its waves ------------------------------------------------------------ */

struct pel_wake_past {
    const struct pel_wake_basin *basin; /* its own */
    double time_s;
    struct pel_wake_amplitudes *amplitudes[PEL_WAKE_TILES];
};

/* Whether waves that stand before the ship are of the far tile. */
static bool goes_far(const struct pel_wake_track *track,
                     const struct legs *legs, double depth_m)
{
    double side =
        pel_wake_near_m(&track->hull) * PEL_WAKE_RATIO * PEL_WAKE_RATIO;
    double u2 = legs->fastest_mps * legs->fastest_mps;
    return 2.0 * PEL_PI * u2 / PEL_GRAVITY > side / MODES ||
           (depth_m > 0 && u2 > 0.5 * PEL_GRAVITY * depth_m);
}

static struct pel_vec2 middle(const struct pel_wake_basin *basin, int i,
                              const struct pel_wake_track *track, double time_s)
{
    double length = basin->band[i].length_m;
    return i > 0 || basin->far ? middle_of(track, time_s, length)
                               : middle_behind(track, time_s, length);
}

bool pel_wake_reaches(const struct pel_wake_track *track, double time_s,
                      double depth_m, double x_m, double y_m, double radius_m)
{
    struct legs legs;
    legs_of(track, -HUGE_VAL, time_s, &legs);
    bool far = goes_far(track, &legs, depth_m);
    double side = pel_wake_near_m(&track->hull) * PEL_WAKE_RATIO *
                  (far ? PEL_WAKE_RATIO : 1.0);
    struct pel_vec2 at = middle_of(track, time_s, side);
    struct pel_vec2 behind = far ? at : middle_behind(track, time_s, side);
    double off = fmin(fmax(fabs(x_m - at.x), fabs(y_m - at.y)),
                      fmax(fabs(x_m - behind.x), fabs(y_m - behind.y)));
    return legs.count > 0 && off < FADED * side + radius_m;
}

static size_t bytes_of(const struct pel_wake_band *band)
{
    return (size_t)band->bunch_count * sizeof(struct pel_wake_amplitudes);
}

static enum pel_err sum_up(struct pel_wake_past *past,
                           const struct pel_wake_track *track,
                           const struct legs *legs)
{
    for (int i = 0; i < PEL_WAKE_TILES; i++) {
        const struct pel_wake_band *band = &past->basin->band[i];
        struct pel_vec2 place = middle(past->basin, i, track, past->time_s);
        struct pel_vec2 ahead = middle(past->basin, 1, track, past->time_s);
        past->amplitudes[i] = aligned_alloc(64, bytes_of(band));
        if (!past->amplitudes[i]) {
            return PEL_ERR_NO_MEMORY;
        }
        memset(past->amplitudes[i], 0, bytes_of(band));
        pel_wake_band_add(past->basin, i, legs->leg, legs->count, past->time_s,
                          &place, i == 0 && !past->basin->far ? &ahead : NULL,
                          past->amplitudes[i]);
    }
    return PEL_OK;
}

enum pel_err pel_wake_past_create(const struct pel_wake_track *track,
                                  double time_s, double depth_m,
                                  struct pel_wake_past **out)
{
    struct pel_wake_past *past = calloc(1, sizeof *past);
    struct legs *legs = malloc(sizeof *legs);
    enum pel_err err = PEL_ERR_NO_MEMORY;
    if (past && legs) {
        legs_of(track, -HUGE_VAL, time_s, legs);
        bool far = goes_far(track, legs, depth_m);
        past->time_s = time_s;
        err = pel_wake_basin_get(&track->hull, depth_m, far, &past->basin);
    }
    if (err == PEL_OK) {
        err = sum_up(past, track, legs);
    }
    free(legs);
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
            free(past->amplitudes[i]);
        }
        pel_wake_basin_put(past->basin);
        free(past);
    }
}

size_t pel_wake_past_bytes(const struct pel_wake_past *past)
{
    size_t sum = sizeof *past;
    for (int i = 0; i < PEL_WAKE_TILES; i++) {
        const struct pel_wake_band *band = &past->basin->band[i];
        sum += bytes_of(band) + (size_t)band->bunch_count * sizeof *band->bunch;
    }
    return sum;
}

PEL_INLINE void put(struct plane *g, int j, int i, float re, float im)
{
    struct pel_fft_strip *rows = &g->rows[j / PEL_FFT_LANES];
    rows->re[i][j % PEL_FFT_LANES] = re;
    rows->im[i][j % PEL_FFT_LANES] = im;
}

static void put_mode(const struct pel_wake_bunch *b,
                     const struct pel_wake_amplitudes *a, int l, struct work *w)
{
    int m = (int)b->m[l], n = (int)b->n[l];
    int i = m & (N - 1), j = n, io = -m & (N - 1), jo = -n & (N - 1);
    float omega = 2.0f * (float)PEL_PI * b->turns[l];
    float ux = b->ux[l], uy = b->uy[l];
    /* H = (B(k) + B*(−k)) / 2, its rate −i ω (B(k) − B*(−k)) / 2 */
    float hr = 0.5f * (a->re[l] + a->back_re[l]);
    float hi = 0.5f * (a->im[l] - a->back_im[l]);
    float vr = 0.5f * omega * (a->im[l] + a->back_im[l]);
    float vi = -0.5f * omega * (a->re[l] - a->back_re[l]);
    put(&w->heave, j, i, hr - vi, hi + vr);
    put(&w->heave, jo, io, hr + vi, vr - hi);
    /* H (i ux − uy) and its like at −k */
    put(&w->sway, j, i, -uy * hr - ux * hi, ux * hr - uy * hi);
    put(&w->sway, jo, io, uy * hr - ux * hi, -ux * hr - uy * hi);
}

/* Real fields of modes that travel along k and −k, two in each plane. */
static void put_modes(const struct pel_wake_band *band,
                      const struct pel_wake_amplitudes *a, struct work *w)
{
    for (int b = 0; b < STRIPS; b++) {
        if (!is_empty(b)) {
            memset(&w->heave.rows[b], 0, sizeof w->heave.rows[b]);
            memset(&w->sway.rows[b], 0, sizeof w->sway.rows[b]);
        }
    }
    for (int p = 0; p < band->bunch_count; p++) {
        for (int l = 0; l < PEL_FFT_LANES; l++) {
            if (band->bunch[p].gain[l] > 0) {
                put_mode(&band->bunch[p], &a[p], l, w);
            }
        }
    }
}

static void make_amplitudes(const struct pel_wake_past *past, int which,
                            const struct legs *since, double time_s,
                            struct pel_wake_amplitudes *a)
{
    const struct pel_wake_band *band = &past->basin->band[which];
    pel_wake_band_turn(band, past->amplitudes[which], time_s - past->time_s, a);
    if (which > 0 || past->basin->far) { /* the ship is not in it */
        pel_wake_band_add(past->basin, which, since->leg, since->count, time_s,
                          NULL, NULL, a);
    }
}

static enum pel_err make_texels(const struct pel_wake_past *past, int which,
                                const struct legs *since, double time_s,
                                struct work *w, struct pel_wake_tile *tile)
{
    const struct pel_wake_band *band = &past->basin->band[which];
    struct pel_wake_amplitudes *a = aligned_alloc(64, bytes_of(band));
    tile->texels = malloc(PEL_WAKE_TILE_BYTES);
    if (!a || !tile->texels) {
        free(a);
        return PEL_ERR_NO_MEMORY;
    }
    make_amplitudes(past, which, since, time_s, a);
    put_modes(band, a, w);
    free(a);
    transform(w, tile->texels);
    return PEL_OK;
}

void pel_wake_lay(const struct pel_wake_past *past,
                  const struct pel_wake_track *track, double time_s,
                  struct pel_wake *out)
{
    for (int i = 0; i < PEL_WAKE_TILES; i++) {
        struct pel_vec2 place = middle(past->basin, i, track, time_s);
        out->tile[i] = (struct pel_wake_tile){
            .length_m = past->basin->band[i].length_m,
            .x_m = place.x,
            .y_m = place.y,
        };
    }
}

bool pel_wake_tile_holds(const struct pel_wake_tile *tile, struct pel_vec2 low,
                         struct pel_vec2 high)
{
    double held = FADED * tile->length_m;
    return low.x < tile->x_m + held && high.x > tile->x_m - held &&
           low.y < tile->y_m + held && high.y > tile->y_m - held;
}

typedef float channels __attribute__((vector_size(16)));

/* Value and derivatives by x and y of four channels. */
struct read {
    channels v, x, y;
};

static void read_tile(const struct pel_wake_tile *tile, double x, double y,
                      struct read *r);

/* The height of a tile's waves at one place, without its texels. NO_MEMORY. */
static enum pel_err height_at(const struct pel_wake_past *past, int which,
                              const struct legs *since, double time_s, double x,
                              double y, double *out)
{
    enum { SIDE = 2 * MODES + 1 };
    const struct pel_wake_band *band = &past->basin->band[which];
    struct pel_wake_amplitudes *a = aligned_alloc(64, bytes_of(band));
    double c[2][SIDE], s[2][SIDE], sum = 0;
    if (!a) {
        return PEL_ERR_NO_MEMORY;
    }
    make_amplitudes(past, which, since, time_s, a);
    for (int i = 0; i < SIDE; i++) {
        double turn = 2 * PEL_PI * (i - MODES) / band->length_m;
        /* What the tile's spline makes of it. */
        double seen = (2 + cos(2 * PEL_PI * (i - MODES) / N)) / 3;
        c[0][i] = seen * cos(turn * x);
        s[0][i] = seen * sin(turn * x);
        c[1][i] = seen * cos(turn * y);
        s[1][i] = seen * sin(turn * y);
    }
    for (int p = 0; p < band->bunch_count; p++) {
        const struct pel_wake_bunch *b = &band->bunch[p];
        for (int l = 0; l < PEL_FFT_LANES; l++) {
            int m = (int)b->m[l] + MODES, n = (int)b->n[l] + MODES;
            double hr = (double)(a[p].re[l] + a[p].back_re[l]);
            double hi = (double)(a[p].im[l] - a[p].back_im[l]);
            if (b->gain[l] > 0) {
                sum += hr * (c[0][m] * c[1][n] - s[0][m] * s[1][n]) -
                       hi * (s[0][m] * c[1][n] + c[0][m] * s[1][n]);
            }
        }
    }
    free(a);
    *out = sum;
    return PEL_OK;
}

/* Of all waves beside the hull at the crest: those of its tile, filled, and the
 * longer ones. */
static enum pel_err height_beside(const struct pel_wake_past *past,
                                  const struct legs *since, double time_s,
                                  const struct pel_wake_raised *raised,
                                  const struct pel_wake_tile *tile, double *out)
{
    enum pel_err err = PEL_OK;
    struct pel_vec2 at = pel_wake_bow_crest(raised);
    struct read r;
    read_tile(tile, at.x, at.y, &r);
    *out = (double)r.v[2];
    int first = past->basin->far ? 0 : 1;
    for (int i = first; i < PEL_WAKE_TILES - 1 && err == PEL_OK; i++) {
        double more = 0;
        err = height_at(past, i, since, time_s, at.x, at.y, &more);
        *out += more;
    }
    return err;
}

/* Adds what the bow wave lacks of its height, of the mean speed of the last
 * seconds, to the tile with the hull. */
static enum pel_err raise_bow(const struct pel_wake_past *past,
                              const struct pel_wake_track *track,
                              const struct legs *since, double time_s,
                              const struct pel_wake_tile *tile)
{
    struct pel_vec2 now = place_at(track, time_s);
    struct pel_vec2 then = place_at(track, time_s - PEL_WAKE_BOW_S);
    double dx = now.x - then.x, dy = now.y - then.y, way = hypot(dx, dy);
    struct pel_wake_raised raised;
    if (way <= 0 ||
        !pel_wake_bow_of(track, way / PEL_WAKE_BOW_S, tile, &raised)) {
        return PEL_OK;
    }
    raised.x_m = now.x + track->bow.stem_m * dx / way;
    raised.y_m = now.y + track->bow.stem_m * dy / way;
    raised.ex = dx / way;
    raised.ey = dy / way;
    double thin = 0;
    enum pel_err err = height_beside(past, since, time_s, &raised, tile, &thin);
    pel_wake_bow_add(&raised, thin, tile);
    return err;
}

enum pel_err pel_wake_fill(const struct pel_wake_past *past,
                           const struct pel_wake_track *track, double time_s,
                           int which, struct pel_wake *wake)
{
    struct legs *since = malloc(sizeof *since);
    struct work *w = aligned_alloc(64, sizeof *w);
    enum pel_err err = since && w ? PEL_OK : PEL_ERR_NO_MEMORY;
    if (err == PEL_OK) {
        legs_of(track, past->time_s, time_s, since);
        err = make_texels(past, which, since, time_s, w, &wake->tile[which]);
    }
    if (err == PEL_OK && which == PEL_WAKE_TILES - 1) {
        err = raise_bow(past, track, since, time_s, &wake->tile[which]);
    }
    free(w);
    free(since);
    return err;
}

enum pel_err pel_wake_later(const struct pel_wake_past *past,
                            const struct pel_wake_track *track, double time_s,
                            struct pel_wake **out)
{
    struct pel_wake *wake = calloc(1, sizeof *wake);
    enum pel_err err = wake ? PEL_OK : PEL_ERR_NO_MEMORY;
    if (wake) {
        pel_wake_lay(past, track, time_s, wake);
    }
    for (int i = 0; err == PEL_OK && i < PEL_WAKE_TILES; i++) {
        err = pel_wake_fill(past, track, time_s, i, wake);
    }
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
        err = pel_wake_later(past, track, time_s, out);
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

static void read_tile(const struct pel_wake_tile *tile, double x, double y,
                      struct read *r)
{
    double u = x / tile->length_m, v = y / tile->length_m;
    u = (u - floor(u)) * N;
    v = (v - floor(v)) * N;
    int i0 = (int)u, j0 = (int)v;
    double wx[4], dx[4], wy[4], dy[4];
    pel_cubic_spline(u - i0, wx, dx);
    pel_cubic_spline(v - j0, wy, dy);
    *r = (struct read){ 0 };
    float per_m = (float)(N / tile->length_m);
    for (int j = 0; j < 4; j++) {
        const float(*row)[4] = (const float(*)[4])tile->texels +
                               (size_t)((j0 + j - 1 + N) % N) * N;
        channels sum = { 0 }, slope = { 0 };
        for (int i = 0; i < 4; i++) {
            channels t;
            memcpy(&t, row[(i0 + i - 1 + N) % N], sizeof t);
            sum += t * (float)wx[i];
            slope += t * (float)dx[i];
        }
        r->v += sum * (float)wy[j];
        r->x += slope * ((float)wy[j] * per_m);
        r->y += sum * ((float)dy[j] * per_m);
    }
}

void pel_wake_add(const struct pel_wake *wake, double x_m, double y_m,
                  struct pel_wake_shift *to)
{
    for (int i = 0; i < PEL_WAKE_TILES; i++) {
        const struct pel_wake_tile *tile = &wake->tile[i];
        double sx, sy, held = FADED * tile->length_m;
        if (!tile->texels || fabs(x_m - tile->x_m) >= held ||
            fabs(y_m - tile->y_m) >= held) {
            continue;
        }
        double fx = fade(x_m - tile->x_m, tile->length_m, &sx);
        double fy = fade(y_m - tile->y_m, tile->length_m, &sy);
        if (fx <= 0 || fy <= 0) {
            continue;
        }
        struct read r;
        read_tile(tile, x_m, y_m, &r);
        double f = fx * fy, gx = sx * fy, gy = fx * sy;
        double v[4], x[4], y[4];
        for (int c = 0; c < 4; c++) {
            v[c] = f * (double)r.v[c];
            x[c] = f * (double)r.x[c] + gx * (double)r.v[c];
            y[c] = f * (double)r.y[c] + gy * (double)r.v[c];
        }
        to->d.x += v[0];
        to->d.y += v[1];
        to->d.z += v[2];
        to->rise_mps += v[3];
        to->dxx += x[0];
        to->dxy += y[0];
        to->dyx += x[1];
        to->dyy += y[1];
        to->hx += x[2];
        to->hy += y[2];
    }
}

void pel_wake_tile_slopes(const struct pel_wake_tile *tile, float (*out)[4])
{
    enum { SIDE = PEL_WAKE_ROUGH_N, BLOCK = N / SIDE, EVERY = 2 };
    const float(*t)[4] = (const float(*)[4])tile->texels;
    const double per_m = N / tile->length_m;
    const double scale = per_m * per_m * EVERY * EVERY / (BLOCK * BLOCK);
    for (int b = 0; b < SIDE * SIDE; b++) {
        double xx = 0, yy = 0, xy = 0;
        for (int k = 0; k < BLOCK * BLOCK / (EVERY * EVERY); k++) {
            int i = b % SIDE * BLOCK + k % (BLOCK / EVERY) * EVERY;
            int j = b / SIDE * BLOCK + k / (BLOCK / EVERY) * EVERY;
            double h[3][3];
            for (int n = 0; n < 9; n++) {
                int row = (j + n / 3 - 1) & (N - 1);
                int column = (i + n % 3 - 1) & (N - 1);
                h[n / 3][n % 3] = (double)t[row * N + column][2];
            }
            /* The spline's derivatives at a texel. */
            double x = (h[0][2] - h[0][0] + 4 * (h[1][2] - h[1][0]) + h[2][2] -
                        h[2][0]) /
                       12;
            double y = (h[2][0] - h[0][0] + 4 * (h[2][1] - h[0][1]) + h[2][2] -
                        h[0][2]) /
                       12;
            xx += x * x;
            yy += y * y;
            xy += x * y;
        }
        out[b][0] = (float)(scale * xx);
        out[b][1] = (float)(scale * yy);
        out[b][2] = (float)(scale * xy);
        out[b][3] = 0;
    }
}
