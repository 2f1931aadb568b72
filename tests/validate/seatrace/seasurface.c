#include "seasurface.h"

#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

static void *room(size_t count, size_t size)
{
    void *memory = calloc(count, size);
    if (!memory) {
        fprintf(stderr, "seatrace: no memory\n");
        exit(2);
    }
    return memory;
}

/* --- Fourier transform, radix 2 ---------------------------------------- */

static void transform_line(double complex *a, int n,
                           const double complex *roots)
{
    for (int i = 1, j = 0; i < n; i++) {
        int bit = n >> 1;
        for (; j & bit; bit >>= 1) {
            j ^= bit;
        }
        j ^= bit;
        if (i < j) {
            double complex t = a[i];
            a[i] = a[j];
            a[j] = t;
        }
    }
    for (int half = 1; half < n; half *= 2) {
        int step = n / (2 * half);
        for (int i = 0; i < n; i += 2 * half) {
            for (int j = 0; j < half; j++) {
                double complex t = a[i + j + half] * roots[j * step];
                a[i + j + half] = a[i + j] - t;
                a[i + j] += t;
            }
        }
    }
}

static void transform_square(double complex *a, int n)
{
    double complex *roots = room((size_t)n / 2 + 1, sizeof(*roots));
    double complex *column = room((size_t)n, sizeof(*column));
    for (int i = 0; i < n / 2; i++) {
        roots[i] = cexp(2 * PI * I * i / n);
    }
    for (int y = 0; y < n; y++) {
        transform_line(a + (size_t)y * n, n, roots);
    }
    for (int x = 0; x < n; x++) {
        for (int y = 0; y < n; y++) {
            column[y] = a[(size_t)y * n + x];
        }
        transform_line(column, n, roots);
        for (int y = 0; y < n; y++) {
            a[(size_t)y * n + x] = column[y];
        }
    }
    free(roots);
    free(column);
}

/* --- levels -------------------------------------------------------------- */

/* Mean square gradient of the bilinear surface through a mode's nodes, of the
 * mode's own: what bilinear interpolation leaves of its slopes. */
static double bilinear_gain(double kx, double ky, double cell)
{
    double sx = 2 / cell * sin(kx * cell / 2);
    double sy = 2 / cell * sin(ky * cell / 2);
    return (sx * sx * (2 + cos(ky * cell)) + sy * sy * (2 + cos(kx * cell))) /
           (3 * (kx * kx + ky * ky));
}

/* A mode has the spectrum's energy over its cell of wave numbers, by 4 x 4
 * points of it, so that the band's edges are not ragged. */
static double mode_energy(const struct sea_level *level,
                          const struct sea_spectrum *spectrum, double dk,
                          int mx, int my, double wind_x, double wind_y)
{
    enum { SUB = 4 };
    double sum = 0;
    for (int i = 0; i < SUB * SUB; i++) {
        int column = i % SUB, line = i / SUB;
        double kx = dk * (mx + (column + 0.5) / SUB - 0.5);
        double ky = dk * (my + (line + 0.5) / SUB - 0.5);
        double k = hypot(kx, ky);
        if (k >= level->k_from && k < level->k_to) {
            sum += sea_spectrum_density(spectrum, k,
                                        (kx * wind_x + ky * wind_y) / k) *
                   k * k;
        }
    }
    /* Slope variance, not energy, is what light asks of a cell. */
    double at = dk * dk * (mx * mx + my * my);
    return sum / (SUB * SUB) / at * dk * dk;
}

static void prepare(struct sea_level *level,
                    const struct sea_spectrum *spectrum, double wind_x,
                    double wind_y)
{
    int n = level->n;
    double dk = 2 * PI / level->size_m, cell = level->size_m / n;
    /* The wind in the level's own axes. */
    double wx = level->cos * wind_x + level->sin * wind_y;
    double wy = -level->sin * wind_x + level->cos * wind_y;
    level->amplitude = room((size_t)n * n, sizeof(float));
    level->height = room((size_t)n * n, sizeof(float));
    for (int y = 0; y < n; y++) {
        int my = y < n / 2 ? y : y - n;
        for (int x = 0; x < n; x++) {
            int mx = x < n / 2 ? x : x - n;
            double k = dk * sqrt(mx * mx + my * my);
            if (k == 0 || k > level->k_to + dk || k < level->k_from - dk) {
                continue;
            }
            double e = mode_energy(level, spectrum, dk, mx, my, wx, wy);
            level->amplitude[(size_t)y * n + x] =
                (float)sqrt(e / bilinear_gain(mx * dk, my * dk, cell));
        }
    }
}

void sea_surface_init(struct sea_surface *surface,
                      const struct sea_spectrum *spectrum, int nodes,
                      double wind_to_rad)
{
    memset(surface, 0, sizeof(*surface));
    surface->wind_x = cos(wind_to_rad);
    surface->wind_y = sin(wind_to_rad);
    /* The longest waves are the eighth of a tile; of the first level, whose
     * peak waves are an eighth of its tile, the whole tile. */
    double shortest = 2 * PI / spectrum->k_high;
    double ratio = nodes / (double)(SEA_CELLS_PER_WAVE * 8);
    double size = 8 * 2 * PI / spectrum->k_peak;
    double from = spectrum->k_low;
    while (surface->levels < SEA_LEVELS) {
        struct sea_level *level = &surface->level[surface->levels];
        double to = 2 * PI * nodes / SEA_CELLS_PER_WAVE / size;
        /* Turned by the golden angle: no two rows of nodes run alike. */
        double turn = 2.39996 * (surface->levels + 0.3);
        *level = (struct sea_level){ .n = nodes,
                                     .size_m = size,
                                     .cos = cos(turn),
                                     .sin = sin(turn),
                                     .k_from = from,
                                     .k_to = fmin(to, spectrum->k_high) };
        prepare(level, spectrum, surface->wind_x, surface->wind_y);
        surface->levels++;
        if (to >= spectrum->k_high) {
            return;
        }
        from = to;
        size = fmax(size / ratio, shortest * nodes / SEA_CELLS_PER_WAVE);
    }
    fprintf(stderr, "seatrace: %d levels do not reach %g m\n", SEA_LEVELS,
            shortest);
    exit(2);
}

/* What stands above a level, how steep it is, and the sums over levels. */
static void measure(struct sea_surface *surface)
{
    surface->m0 = surface->along = surface->cross = 0;
    for (int l = 0; l < surface->levels; l++) {
        struct sea_level *level = &surface->level[l];
        int n = level->n;
        double cell = level->size_m / n;
        double highest = 0, steepest = 0, m0 = 0, xx = 0, xy = 0, yy = 0;
        for (int y = 0; y < n; y++) {
            const float *row = level->height + (size_t)y * n;
            const float *next = level->height + (size_t)((y + 1) % n) * n;
            for (int x = 0; x < n; x++) {
                double a = row[x], b = row[(x + 1) % n];
                double c = next[x], d = next[(x + 1) % n];
                double gx = fmax(fabs(b - a), fabs(d - c)) / cell;
                double gy = fmax(fabs(c - a), fabs(d - b)) / cell;
                highest = fmax(highest, fabs(a));
                steepest = fmax(steepest, hypot(gx, gy));
                /* Means over the bilinear cell, exactly. */
                double u = (b - a) / cell, v = (d - c) / cell;
                double p = (c - a) / cell, q = (d - b) / cell;
                m0 += a * a;
                xx += (u * u + u * v + v * v) / 3;
                yy += (p * p + p * q + q * q) / 3;
                xy += (u + v) * (p + q) / 4;
            }
        }
        double count = (double)n * n;
        /* Wind in the level's axes. */
        double wx = level->cos * surface->wind_x + level->sin * surface->wind_y;
        double wy =
            -level->sin * surface->wind_x + level->cos * surface->wind_y;
        surface->m0 += m0 / count;
        surface->along +=
            (wx * wx * xx + 2 * wx * wy * xy + wy * wy * yy) / count;
        surface->cross +=
            (wy * wy * xx - 2 * wx * wy * xy + wx * wx * yy) / count;
        level->highest = highest;
        level->steepest = steepest;
        surface->steeper[l + 1] = surface->steeper[l] + steepest;
    }
    surface->finer[surface->levels] = 0;
    for (int l = surface->levels - 1; l >= 0; l--) {
        surface->finer[l] = surface->finer[l + 1] + surface->level[l].highest;
    }
}

void sea_surface_chop(struct sea_surface *surface,
                      const struct sea_spectrum *spectrum)
{
    double whole_to = pow(0.7 / 5.5, 2), most = pow(0.98 / 5.5, 2);
    double before = 0;
    surface->choppy = 1;
    for (int l = 0; l < surface->levels; l++) {
        struct sea_level *level = &surface->level[l];
        struct sea_moments m =
            sea_spectrum_moments(spectrum, level->k_from, level->k_to);
        double slopes = m.along + m.cross;
        double whole = fmin(fmax(whole_to - before, 0), slopes);
        /* What is over is let in ever less: 1 - exp(-x) never exceeds. */
        double over0 = fmax(before - whole_to, 0);
        double over1 = fmax(before + slopes - whole_to, 0);
        double room_left = most - whole_to;
        double allowed = whole + room_left * (exp(-over0 / room_left) -
                                              exp(-over1 / room_left));
        level->chop = sqrt(allowed / slopes);
        before += slopes;
        for (int axis = 0; axis < 2; axis++) {
            level->shift[axis] =
                room((size_t)level->n * level->n, sizeof(float));
        }
    }
}

/* Fills `to` with the modes' heights, or their displacements along one of the
 * level's axes, of one set of random numbers. */
static void synthesise(const struct sea_level *level,
                       const double complex *mode, int axis, float *to)
{
    int n = level->n;
    size_t count = (size_t)n * n;
    double complex *work = room(count, sizeof(*work));
    for (size_t i = 0; i < count; i++) {
        work[i] = mode[i];
        if (axis >= 0) {
            int x = (int)(i % n), y = (int)(i / n);
            double k[2] = { x < n / 2 ? x : x - n, y < n / 2 ? y : y - n };
            double length = hypot(k[0], k[1]);
            work[i] *= length > 0 ? I * k[axis] / length * level->chop : 0;
        }
    }
    transform_square(work, n);
    for (size_t i = 0; i < count; i++) {
        to[i] = (float)creal(work[i]);
    }
    free(work);
}

void sea_surface_fill(struct sea_surface *surface, struct sea_random *random)
{
    for (int l = 0; l < surface->levels; l++) {
        struct sea_level *level = &surface->level[l];
        size_t count = (size_t)level->n * level->n;
        double complex *mode = room(count, sizeof(*mode));
        for (size_t i = 0; i < count; i++) {
            if (level->amplitude[i] > 0) {
                double a, b;
                sea_random_normal(random, &a, &b);
                mode[i] = (double)level->amplitude[i] * (a + b * I);
            }
        }
        synthesise(level, mode, -1, level->height);
        for (int axis = 0; surface->choppy && axis < 2; axis++) {
            synthesise(level, mode, axis, level->shift[axis]);
        }
        free(mode);
        level->move_x = level->size_m * sea_random_unit(random);
        level->move_y = level->size_m * sea_random_unit(random);
    }
    measure(surface);
}

void sea_surface_sinusoid(struct sea_surface *surface, double amplitude_m,
                          double wavelength_m, int waves, int nodes)
{
    memset(surface, 0, sizeof(*surface));
    surface->levels = 1;
    surface->wind_x = 1;
    struct sea_level *level = &surface->level[0];
    *level = (struct sea_level){ .n = nodes,
                                 .size_m = waves * wavelength_m,
                                 .cos = 1 };
    level->amplitude = room(1, sizeof(float));
    level->height = room((size_t)nodes * nodes, sizeof(float));
    for (int i = 0; i < nodes * nodes; i++) {
        level->height[i] =
            (float)(amplitude_m * sin(2 * PI * waves * (i % nodes) / nodes));
    }
    measure(surface);
}

void sea_surface_finish(struct sea_surface *surface)
{
    for (int l = 0; l < surface->levels; l++) {
        free(surface->level[l].amplitude);
        free(surface->level[l].height);
        free(surface->level[l].shift[0]);
        free(surface->level[l].shift[1]);
    }
    surface->levels = 0;
}

/* The four nodes about a place, and where between them it lies. */
struct cell {
    double a, b, c, d, u, v;
};

static inline struct cell find(const struct sea_level *level, const float *grid,
                               double x, double y)
{
    double scale = level->n / level->size_m;
    double px = (level->cos * x + level->sin * y + level->move_x) * scale;
    double py = (-level->sin * x + level->cos * y + level->move_y) * scale;
    double fx = floor(px), fy = floor(py);
    int mask = level->n - 1;
    int ix = (int)((long long)fx & mask), iy = (int)((long long)fy & mask);
    const float *row = grid + (size_t)iy * level->n;
    const float *next = grid + (size_t)((iy + 1) & mask) * level->n;
    int jx = (ix + 1) & mask;
    return (struct cell){ .a = row[ix],
                          .b = row[jx],
                          .c = next[ix],
                          .d = next[jx],
                          .u = px - fx,
                          .v = py - fy };
}

/* Bilinear value, and its derivatives by x and y. */
static inline double value_of(const struct sea_level *level,
                              const struct cell *f, double *by)
{
    double low = f->a + f->u * (f->b - f->a);
    double high = f->c + f->u * (f->d - f->c);
    double scale = level->n / level->size_m;
    double du = ((1 - f->v) * (f->b - f->a) + f->v * (f->d - f->c)) * scale;
    double dv = (high - low) * scale;
    by[0] = level->cos * du - level->sin * dv;
    by[1] = level->sin * du + level->cos * dv;
    return low + f->v * (high - low);
}

double sea_level_height(const struct sea_level *level, double x, double y)
{
    double by[2];
    struct cell f = find(level, level->height, x, y);
    return value_of(level, &f, by);
}

/* Displacement of a place at rest, and its derivatives by x and y. */
static void displace(const struct sea_surface *surface, double x, double y,
                     double *d, double (*by)[2])
{
    d[0] = d[1] = by[0][0] = by[0][1] = by[1][0] = by[1][1] = 0;
    for (int l = 0; l < surface->levels; l++) {
        const struct sea_level *level = &surface->level[l];
        double c = level->cos, s = level->sin;
        double of[2], g[2][2]; /* in the level's axes; g by x and y */
        for (int axis = 0; axis < 2; axis++) {
            struct cell f = find(level, level->shift[axis], x, y);
            of[axis] = value_of(level, &f, g[axis]);
        }
        d[0] += c * of[0] - s * of[1];
        d[1] += s * of[0] + c * of[1];
        for (int j = 0; j < 2; j++) {
            by[0][j] += c * g[0][j] - s * g[1][j];
            by[1][j] += s * g[0][j] + c * g[1][j];
        }
    }
}

/* The place at rest whose particle is over (x, y): Newton's steps. inverse:
 * of the derivative of x0 + D(x0). */
static void find_rest(const struct sea_surface *surface, double x, double y,
                      double *rest, double (*inverse)[2])
{
    rest[0] = x;
    rest[1] = y;
    for (int i = 0; i < 12; i++) {
        double d[2], by[2][2];
        displace(surface, rest[0], rest[1], d, by);
        double a = 1 + by[0][0], b = by[0][1], c = by[1][0], e = 1 + by[1][1];
        /* Folded places are few, and left to a slower step. */
        double determinant = fmax(a * e - b * c, 0.2);
        inverse[0][0] = e / determinant;
        inverse[0][1] = -b / determinant;
        inverse[1][0] = -c / determinant;
        inverse[1][1] = a / determinant;
        double off[2] = { rest[0] + d[0] - x, rest[1] + d[1] - y };
        if (hypot(off[0], off[1]) < 2e-7) {
            return;
        }
        for (int j = 0; j < 2; j++) {
            rest[j] -= inverse[j][0] * off[0] + inverse[j][1] * off[1];
        }
    }
}

double sea_surface_height(const struct sea_surface *surface, double x, double y,
                          double *gradient)
{
    double rest[2] = { x, y }, inverse[2][2] = { { 1, 0 }, { 0, 1 } };
    if (surface->choppy) {
        find_rest(surface, x, y, rest, inverse);
    }
    double z = 0, g[2] = { 0, 0 };
    for (int l = 0; l < surface->levels; l++) {
        const struct sea_level *level = &surface->level[l];
        struct cell f = find(level, level->height, rest[0], rest[1]);
        double own[2];
        z += value_of(level, &f, own);
        g[0] += own[0];
        g[1] += own[1];
    }
    if (gradient) {
        gradient[0] = inverse[0][0] * g[0] + inverse[1][0] * g[1];
        gradient[1] = inverse[0][1] * g[0] + inverse[1][1] * g[1];
    }
    return z;
}
