#include "ocean/shore.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "ocean/cascade.h"
#include "ocean/directional.h"
#include "ocean/shorebands.h"
#include "ocean/spline.h"

#define RIM 12    /* nodes beyond the bottom, in which waves fade */
#define QUIET 2   /* outermost ones that are the sea far out */
#define SWEEPS 16 /* rounds of four at most */
/* Chosen, to what keeps the fields smooth: least depth for waves' speed; most
 * of a, at caustics; from k d = π down to FEELS of it n goes over to 1. */
#define LEAST_M 0.3
#define STEEPEST 3.0
#define FEELS 0.85
/* Height of a swash, times √(H₀ L₀) (Stockdon et al. 2006, dissipative), and
 * how far up it runs, in heights. */
#define SWASH 0.046
#define RUNS_UP 1.5
/* Share of its energy that a breaker loses in a wavelength where foam covers
 * all of it: by eye. */
#define ALL_BREAKS 0.4
#define SINGLE_HEIGHT (2.0 * M_SQRT2) /* over the root of m0 */
#define SPECTRUM_HEIGHT 4.0           /* significant */
#define HIGHEST_TENTH 1.27            /* of waves, times that */

static atomic_uint_least64_t serials;

/* One band's fields on the grid. */
struct solver {
    int columns, rows;
    double h;
    double *depth; /* < 0: land */
    double *phi;   /* of k̂·x + s; INFINITY: not reached */
    double *n, *flux;
    float (*to)[2]; /* p̂ */
    uint8_t *known; /* 1: given; 2: closed */
    int *order;
    double swash_m; /* height */
};

static double smooth(double from, double to, double x)
{
    double t = pel_clamp((x - from) / (to - from), 0, 1);
    return t * t * (3 - 2 * t);
}

/* --- the bottom -------------------------------------------------------------
 */

static double height_at(const struct pel_shore_bottom *b, double x, double y)
{
    double u = (x - b->west_m) / b->spacing_m;
    double v = (y - b->south_m) / b->spacing_m;
    if (u < -0.5 || v < -0.5 || u > b->columns - 0.5 || v > b->rows - 0.5) {
        return b->level_m - b->beyond_m;
    }
    u = pel_clamp(u, 0, b->columns - 1.000001);
    v = pel_clamp(v, 0, b->rows - 1.000001);
    int i = (int)u, j = (int)v;
    const float *at = b->height_m + (size_t)j * (size_t)b->columns + i;
    double low = at[0] + (u - i) * ((double)at[1] - at[0]);
    double high = at[b->columns] +
                  (u - i) * ((double)at[b->columns + 1] - at[b->columns]);
    return low + (v - j) * (high - low);
}

/* The mean of nine places about a node's, so that a bottom finer than the grid
 * counts. */
static double depth_at(const struct pel_shore_bottom *b, double x, double y,
                       double h)
{
    double sum = 0;
    for (int k = 0; k < 9; k++) {
        sum += height_at(b, x + (k % 3 - 1) * h / 3, y + (k / 3 - 1) * h / 3);
    }
    return b->level_m - sum / 9;
}

static void lay_grid(const struct pel_shore_bottom *b, struct pel_shore *out)
{
    double wide = (b->columns - 1) * b->spacing_m;
    double high = (b->rows - 1) * b->spacing_m;
    double h = fmax(fmax(wide, high) / PEL_SHORE_CELLS, b->spacing_m);
    out->spacing_m = h;
    out->columns = (int)ceil(wide / h) + 1 + 2 * RIM;
    out->rows = (int)ceil(high / h) + 1 + 2 * RIM;
    out->west_m = b->west_m - RIM * h;
    out->south_m = b->south_m - RIM * h;
}

/* --- arrival ----------------------------------------------------------------
 */

static double least(double a, double b)
{
    return a < b ? a : b;
}

static double phi_at(const struct solver *s, int i, int j)
{
    return i < 0 || j < 0 || i >= s->columns || j >= s->rows
               ? INFINITY
               : s->phi[j * s->columns + i];
}

/* Godunov's scheme. */
static double arrival(const struct solver *s, int i, int j)
{
    double a = least(phi_at(s, i - 1, j), phi_at(s, i + 1, j));
    double b = least(phi_at(s, i, j - 1), phi_at(s, i, j + 1));
    double step = s->n[j * s->columns + i] * s->h;
    if (!(fabs(a - b) < step)) {
        return least(a, b) + step;
    }
    return 0.5 * (a + b + sqrt(2 * step * step - (a - b) * (a - b)));
}

static double sweep(struct solver *s, int way)
{
    double moved = 0;
    for (int jj = 0; jj < s->rows; jj++) {
        int j = way & 1 ? s->rows - 1 - jj : jj;
        for (int ii = 0; ii < s->columns; ii++) {
            int i = way & 2 ? s->columns - 1 - ii : ii;
            int at = j * s->columns + i;
            if (s->known[at]) {
                continue;
            }
            double t = arrival(s, i, j);
            if (t < s->phi[at]) {
                moved = fmax(moved, isinf(s->phi[at]) ? s->h : s->phi[at] - t);
                s->phi[at] = t;
            }
        }
    }
    return moved;
}

static void arrive(struct solver *s, const struct pel_shore_band *band)
{
    for (int j = 0; j < s->rows; j++) {
        for (int i = 0; i < s->columns; i++) {
            int at = j * s->columns + i;
            bool comes = (i == 0 && band->x > 0) || (j == 0 && band->y > 0) ||
                         (i == s->columns - 1 && band->x < 0) ||
                         (j == s->rows - 1 && band->y < 0);
            comes = comes && !s->known[at];
            s->phi[at] = comes ? s->h * (i * band->x + j * band->y) : INFINITY;
            s->known[at] = comes ? 1 : s->known[at];
        }
    }
    double moved = INFINITY;
    for (int round = 0; round < SWEEPS && moved > 1e-7 * s->h; round++) {
        moved = 0;
        for (int way = 0; way < 4; way++) {
            moved = fmax(moved, sweep(s, way));
        }
    }
}

/* --- action ------------------------------------------------------------------
 */

/* The neighbour that a node's arrival came by along one axis, −1: none; *part:
 * of p̂ along it. */
static int before(const struct solver *s, int at, int i, int j, bool along_y,
                  double other, double *part)
{
    int di = along_y ? 0 : 1, dj = along_y ? 1 : 0;
    double lower = phi_at(s, i - di, j - dj), upper = phi_at(s, i + di, j + dj);
    double from = least(lower, upper);
    double step = s->n[at] * s->h;
    *part = 0;
    if (!(from < s->phi[at])) {
        return -1;
    }
    if (!(fabs(from - other) < step)) { /* one came alone */
        *part = from < other ? 1 : 0;
    } else {
        *part = (s->phi[at] - from) / step;
    }
    *part = lower <= upper ? *part : -*part;
    return lower <= upper ? at - di - dj * s->columns
                          : at + di + dj * s->columns;
}

static int by_arrival(const void *a, const void *b, void *user)
{
    const double *phi = user;
    double pa = phi[*(const int *)a], pb = phi[*(const int *)b];
    return pa < pb ? -1 : pa > pb ? 1 : *(const int *)a - *(const int *)b;
}

static double group_speed(double omega, double k, double depth)
{
    double kd = k * depth;
    return omega / k * (kd > 20 ? 0.5 : 0.5 + kd / sinh(2 * kd));
}

/* Highest waves of a depth, m: what does not break, or at the water's edge what
 * runs up. */
static double highest_of(const struct solver *s, double depth)
{
    double swash =
        depth > 0 ? s->swash_m - 0.5 * depth : s->swash_m + depth / RUNS_UP;
    return fmax(fmax(PEL_SHORE_BREAKS * depth, swash), 0);
}

struct train { /* a band's waves, of the sea far out */
    const struct pel_shore_band *band;
    double omega, far_speed;
    double share;  /* of the energy of all bands */
    double factor; /* height over the root of m0 */
    double energy; /* of all bands */
};

/* One node from those before it. */
static void carry(struct solver *s, const struct train *t, int at,
                  float (*nodes)[4], uint8_t *changed)
{
    int i = at % s->columns, j = at / s->columns;
    double parts[2];
    double along_x = least(phi_at(s, i - 1, j), phi_at(s, i + 1, j));
    double along_y = least(phi_at(s, i, j - 1), phi_at(s, i, j + 1));
    const int from[2] = { before(s, at, i, j, false, along_y, &parts[0]),
                          before(s, at, i, j, true, along_x, &parts[1]) };
    bool touched = s->n[at] != 1.0;
    double into = 0;
    for (int k = 0; k < 2; k++) {
        if (from[k] >= 0 && parts[k] != 0) {
            touched = touched || changed[from[k]];
            double flows = (double)s->to[from[k]][k] * (parts[k] > 0 ? 1 : -1);
            into += fmax(flows, 0) * s->flux[from[k]];
        }
    }
    double sum = fabs(parts[0]) + fabs(parts[1]);
    s->to[at][0] = (float)parts[0];
    s->to[at][1] = (float)parts[1];
    changed[at] = touched;
    if (!touched) {
        s->flux[at] = t->far_speed;
        s->to[at][0] = (float)t->band->x;
        s->to[at][1] = (float)t->band->y;
        return;
    }
    double k = t->band->k * s->n[at];
    double depth = s->depth[at];
    double speed = group_speed(t->omega, k, fmax(depth, LEAST_M));
    double flux = sum > 0 ? into / sum : 0;
    double most = highest_of(s, depth) / t->factor;
    /* Of a band as of all: each has its share of what may stand there. */
    double cap = most * most / t->energy * speed;
    cap = fmin(cap, STEEPEST * STEEPEST * speed);
    double lost = flux > cap ? (flux - cap) / flux : 0;
    s->flux[at] = flux < cap ? flux : cap;
    double a = sqrt(s->flux[at] / speed);
    nodes[at][0] =
        (float)(s->phi[at] - s->h * (i * t->band->x + j * t->band->y));
    nodes[at][1] = (float)(a - 1);
    nodes[at][2] = (float)(fmin(a, 1 / s->n[at]) - 1);
    nodes[at][3] =
        (float)(t->share *
                pel_clamp(lost * 2 * PEL_PI / (k * s->h) / ALL_BREAKS, 0, 1));
}

/* Land and what no wave reaches: still, with the s of neighbours, so that
 * splines near it are smooth. */
static void fill_dry(const struct solver *s, float (*nodes)[4],
                     uint8_t *changed)
{
    const int size = s->columns * s->rows;
    uint8_t *filled = pel_sure_calloc((size_t)size, 1);
    for (int at = 0; at < size; at++) {
        filled[at] = isfinite(s->phi[at]);
        if (!filled[at]) {
            nodes[at][1] = nodes[at][2] = -1;
            changed[at] = 1;
        }
    }
    for (int round = 1; round <= 4; round++) {
        for (int at = 0; at < size; at++) {
            int i = at % s->columns, j = at / s->columns, count = 0;
            double sum = 0;
            const int beside[4] = { i > 0 ? at - 1 : at,
                                    i + 1 < s->columns ? at + 1 : at,
                                    j > 0 ? at - s->columns : at,
                                    j + 1 < s->rows ? at + s->columns : at };
            for (int k = 0; k < 4 && !filled[at]; k++) {
                if (filled[beside[k]] && filled[beside[k]] <= round) {
                    sum += (double)nodes[beside[k]][0];
                    count++;
                }
            }
            if (count > 0) {
                nodes[at][0] = (float)(sum / count);
                filled[at] = (uint8_t)(round + 1);
            }
        }
    }
    free(filled);
}

/* Into the sea far out, over the outermost nodes. */
static void fade(const struct solver *s, double k, float (*nodes)[4],
                 uint8_t *changed)
{
    const double middle = 0.5 * (RIM - QUIET);
    for (int at = 0; at < s->columns * s->rows; at++) {
        int i = at % s->columns, j = at / s->columns;
        int edge =
            (int)fmin(fmin(i, s->columns - 1 - i), fmin(j, s->rows - 1 - j));
        double in = fmax(edge - QUIET, 0);
        if (!changed[at] || in >= 2 * middle) {
            continue;
        }
        double lost = smooth(0, 0.5, fabs((double)nodes[at][0]) * k) *
                      (1 - fabs(in / middle - 1));
        double own = smooth(middle - 1, middle + 1, in);
        nodes[at][0] = (float)(own * (double)nodes[at][0]);
        nodes[at][1] =
            (float)((1 + own * (double)nodes[at][1]) * (1 - lost) - 1);
        nodes[at][2] =
            (float)((1 + own * (double)nodes[at][2]) * (1 - lost) - 1);
        nodes[at][3] = (float)(own * (double)nodes[at][3]);
    }
}

static void solve(struct solver *s, const struct train *t, double depth_far,
                  float (*nodes)[4], uint8_t *changed)
{
    const int size = s->columns * s->rows;
    const struct pel_shore_band *band = t->band;
    for (int at = 0; at < size; at++) {
        double d = fmax(s->depth[at], LEAST_M), kd = band->k * d;
        double slower =
            kd < PEL_PI ? pel_dispersion_k(t->omega, d) / band->k : 1.0;
        slower = fmax(slower, 1.0);
        s->n[at] = 1 + (slower - 1) * (1 - smooth(FEELS * PEL_PI, PEL_PI, kd));
        if (depth_far > 0 && d >= depth_far) {
            s->n[at] = 1;
        }
        s->known[at] = s->depth[at] < -RUNS_UP * s->swash_m - LEAST_M ? 2 : 0;
        s->order[at] = at;
        changed[at] = 0;
    }
    arrive(s, band);
    qsort_r(s->order, (size_t)size, sizeof *s->order, by_arrival, s->phi);
    for (int o = 0; o < size && isfinite(s->phi[s->order[o]]); o++) {
        int at = s->order[o];
        if (s->known[at] == 1) {
            s->flux[at] = t->far_speed;
            s->to[at][0] = (float)band->x;
            s->to[at][1] = (float)band->y;
        } else {
            carry(s, t, at, nodes, changed);
        }
    }
    fill_dry(s, nodes, changed);
    fade(s, band->k, nodes, changed);
}

/* --- all bands --------------------------------------------------------------
 */

static void solver_finish(struct solver *s)
{
    free(s->depth);
    free(s->phi);
    free(s->n);
    free(s->flux);
    free(s->to);
    free(s->known);
    free(s->order);
}

static bool solver_init(const struct pel_shore *shore, struct solver *s)
{
    size_t size = (size_t)shore->columns * (size_t)shore->rows;
    *s = (struct solver){
        .columns = shore->columns,
        .rows = shore->rows,
        .h = shore->spacing_m,
        .depth = calloc(size, sizeof *s->depth),
        .phi = calloc(size, sizeof *s->phi),
        .n = calloc(size, sizeof *s->n),
        .flux = calloc(size, sizeof *s->flux),
        .to = calloc(size, sizeof *s->to),
        .known = calloc(size, 1),
        .order = calloc(size, sizeof *s->order),
    };
    return s->depth && s->phi && s->n && s->flux && s->to && s->known &&
           s->order;
}

/* Nodes whose neighbourhood is not all zero, within `reach` nodes. */
static void spread(struct pel_shore *shore, const uint8_t *changed, int reach)
{
    int w = shore->columns, h = shore->rows;
    uint8_t *rows = pel_sure_calloc((size_t)w * (size_t)h, 1);
    for (int j = 0; j < h; j++) {
        int until = -1;
        for (int pass = 0; pass < 2; pass++) {
            until = -1;
            for (int k = 0; k < w; k++) {
                int i = pass ? w - 1 - k : k, at = j * w + i;
                until = changed[at] ? k + reach : until;
                rows[at] |= k <= until;
            }
        }
    }
    for (int i = 0; i < w; i++) {
        for (int pass = 0; pass < 2; pass++) {
            int until = -1;
            for (int k = 0; k < h; k++) {
                int at = (pass ? h - 1 - k : k) * w + i;
                until = rows[at] ? k + reach : until;
                shore->changed[at] |= k <= until;
            }
        }
    }
    free(rows);
}

static bool only_singles(const struct pel_sea_desc *d)
{
    return d->wind_mps == 0 && d->swell_count == 0 && d->single_count > 0;
}

static void solve_all(const struct pel_sea *sea, struct solver *s,
                      struct pel_shore *shore, uint8_t *any, uint8_t *changed)
{
    size_t size = (size_t)shore->columns * (size_t)shore->rows;
    double energy = 0, slow = 0;
    for (int b = 0; b < shore->bands; b++) {
        energy += shore->band[b].energy;
        slow += shore->band[b].energy / shore->band[b].k;
    }
    double height = only_singles(&sea->desc) ? SINGLE_HEIGHT : SPECTRUM_HEIGHT;
    s->swash_m =
        SWASH * sqrt(height * sqrt(energy) * 2 * PEL_PI * slow / energy);
    for (int b = 0; b < shore->bands; b++) {
        const struct pel_shore_band *band = &shore->band[b];
        double depth_m = sea->desc.depth_m;
        double omega = pel_dispersion_depth(band->k, depth_m);
        const struct train t = {
            .band = band,
            .omega = omega,
            .far_speed =
                group_speed(omega, band->k, depth_m > 0 ? depth_m : 1e6),
            .share = band->energy / energy,
            .factor =
                height == SPECTRUM_HEIGHT ? HIGHEST_TENTH * height : height,
            .energy = energy,
        };
        solve(s, &t, depth_m, shore->nodes + (size_t)b * size, changed);
        for (size_t at = 0; at < size; at++) {
            const float *node = shore->nodes[(size_t)b * size + at];
            any[at] |= node[0] != 0 || node[1] != 0 || node[2] != 0;
            shore->highest = fmax(shore->highest, 1 + (double)node[1]);
        }
    }
    /* One sum of what breaks, in every band. */
    for (size_t at = 0; at < size; at++) {
        float sum = 0;
        for (int b = 0; b < shore->bands; b++) {
            sum += shore->nodes[(size_t)b * size + at][3];
        }
        for (int b = 0; b < shore->bands; b++) {
            shore->nodes[(size_t)b * size + at][3] = sum;
        }
    }
}

static enum pel_err make(const struct pel_sea *sea,
                         const struct pel_shore_bottom *bottom,
                         struct pel_shore *shore)
{
    lay_grid(bottom, shore);
    size_t size = (size_t)shore->columns * (size_t)shore->rows;
    struct solver s;
    uint8_t *any = calloc(size, 1), *changed = calloc(size, 1);
    shore->nodes = calloc(size * (size_t)shore->bands, sizeof *shore->nodes);
    shore->changed = calloc(size, 1);
    bool room = solver_init(shore, &s) && any && changed && shore->nodes &&
                shore->changed;
    for (size_t at = 0; at < size && room; at++) {
        int i = (int)at % shore->columns, j = (int)at / shore->columns;
        s.depth[at] = depth_at(bottom, shore->west_m + i * s.h,
                               shore->south_m + j * s.h, s.h);
    }
    if (room) {
        shore->reach_m = sea->max_shift_m;
        solve_all(sea, &s, shore, any, changed);
        spread(shore, any, 3 + (int)ceil(sea->max_shift_m / s.h));
    }
    solver_finish(&s);
    free(any);
    free(changed);
    return room ? PEL_OK : PEL_ERR_NO_MEMORY;
}

enum pel_err pel_shore_create(const struct pel_sea *sea,
                              const struct pel_shore_bottom *bottom,
                              struct pel_shore **out)
{
    *out = NULL;
    struct pel_shore *shore = calloc(1, sizeof *shore);
    if (!shore) {
        return PEL_ERR_NO_MEMORY;
    }
    shore->serial = atomic_fetch_add(&serials, 1) + 1;
    shore->highest = 1;
    pel_shore_bands_of(sea, shore);
    enum pel_err err = shore->bands ? make(sea, bottom, shore) : PEL_OK;
    size_t size = (size_t)shore->columns * (size_t)shore->rows;
    bool any = err == PEL_OK && shore->bands &&
               memchr(shore->changed, 1, size) != NULL;
    if (!any) {
        pel_shore_destroy(shore);
        return err;
    }
    *out = shore;
    return PEL_OK;
}

void pel_shore_destroy(struct pel_shore *shore)
{
    if (shore) {
        free(shore->nodes);
        free(shore->changed);
        free(shore);
    }
}

/* --- reading ----------------------------------------------------------------
 */

bool pel_shore_far(const struct pel_shore *shore, double x_m, double y_m)
{
    double u = (x_m - shore->west_m) / shore->spacing_m;
    double v = (y_m - shore->south_m) / shore->spacing_m;
    int i = (int)pel_clamp(rint(u), 0, shore->columns - 1);
    int j = (int)pel_clamp(rint(v), 0, shore->rows - 1);
    return !shore->changed[j * shore->columns + i];
}

void pel_shore_at(const struct pel_shore *shore, int band, double x_m,
                  double y_m, struct pel_shored *out)
{
    *out = (struct pel_shored){ .a = 1, .b = 1 };
    double u = (x_m - shore->west_m) / shore->spacing_m;
    double v = (y_m - shore->south_m) / shore->spacing_m;
    if (!(u >= 1 && v >= 1 && u < shore->columns - 2 && v < shore->rows - 2)) {
        return;
    }
    int i = (int)u, j = (int)v;
    double wi[4], wj[4], di[4], dj[4];
    pel_cubic_spline(u - i, wi, di);
    pel_cubic_spline(v - j, wj, dj);
    const float(*nodes)[4] =
        (const float(*)[4])shore->nodes +
        (size_t)band * (size_t)shore->columns * (size_t)shore->rows;
    double value[4] = { 0 }, dx[4] = { 0 }, dy[4] = { 0 };
    for (int q = 0; q < 4; q++) {
        for (int p = 0; p < 4; p++) {
            const float *node = nodes[(j + q - 1) * shore->columns + i + p - 1];
            for (int c = 0; c < 4; c++) {
                double t = (double)node[c];
                value[c] += wi[p] * wj[q] * t;
                dx[c] += di[p] * wj[q] * t;
                dy[c] += wi[p] * dj[q] * t;
            }
        }
    }
    double per_m = 1 / shore->spacing_m;
    *out = (struct pel_shored){
        .s = value[0],
        .a = 1 + value[1],
        .b = 1 + value[2],
        .sx = dx[0] * per_m,
        .sy = dy[0] * per_m,
        .ax = dx[1] * per_m,
        .ay = dy[1] * per_m,
        .bx = dx[2] * per_m,
        .by = dy[2] * per_m,
        .breaks = value[3],
    };
}
