#include "ocean/wakebasin.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>

#include "ocean/sea.h"

#define N PEL_WAKE_N
#define MODES PEL_WAKE_MODES
#define LANES PEL_FFT_LANES
#define VISCOSITY 1.2e-6 /* m²/s, of the sea */
/* A tile's share in a wave falls from 1 to 0 over the last of its modes, from
 * this share of the highest on: a sharp end rings over the whole tile. What the
 * tile of long waves leaves is the other one's. */
static const double ends_from[PEL_WAKE_TILES] = { 0.55, 0.65, 0.8 };
/* Weights of packets are linear over no more than this share of a tile's side:
 * a fifth of the ramp. */
#define STRAIGHT 0.034
#define MOST_STRETCHES 4096

typedef pel_lanes lanes;
typedef pel_ints ints;

/* --- modes ---------------------------------------------------------------- */

static double dispersion(double k, double depth_m, double *group_mps)
{
    double kd = depth_m > 0 ? k * depth_m : 100.0;
    double th = kd > 20.0 ? 1.0 : tanh(kd);
    double omega = sqrt(PEL_GRAVITY * k * th);
    double shallow = kd > 20.0 ? 0.0 : 2.0 * kd / sinh(2.0 * kd);
    *group_mps = 0.5 * omega / k * (1.0 + shallow);
    return omega;
}

/* Gain of the cubic B-spline for a wave of mode number m. */
static double spline_gain(int m)
{
    double x = PEL_PI * m / N;
    double s = m == 0 ? 1.0 : sin(x) / x;
    return s * s * s * s;
}

/* Share of tile i in waves of k, without regard to those of longer waves. */
static double up_to(const struct pel_wake_basin *basin, int i, double k)
{
    double u = k * basin->band[i].length_m / (2.0 * PEL_PI * MODES);
    double from = ends_from[i];
    return u <= from  ? 1.0
           : u >= 1.0 ? 0.0
                      : 0.5 + 0.5 * cos(PEL_PI * (u - from) / (1.0 - from));
}

static double share_of(const struct pel_wake_basin *basin, int i, double k)
{
    return up_to(basin, i, k) -
           (i > (basin->far ? 0 : 1) ? up_to(basin, i - 1, k) : 0.0);
}

static void fill_mode(const struct pel_wake_basin *basin, int i, int m, int n,
                      double share, struct pel_wake_bunch *b, int l)
{
    const struct pel_hull *hull = &basin->hull;
    double length = basin->band[i].length_m, step = 2.0 * PEL_PI / length;
    double k = step * hypot(m, n), group;
    double turns = dispersion(k, basin->depth_m, &group) / (2.0 * PEL_PI);
    double gain = share / (spline_gain(m) * spline_gain(n) * length * length);
    b->m[l] = (float)m;
    b->n[l] = (float)n;
    b->ux[l] = (float)(m * step / k);
    b->uy[l] = (float)(n * step / k);
    b->k[l] = (float)k;
    b->turns[l] = (float)turns;
    b->group[l] = (float)group;
    b->gain[l] = (float)(gain * 2.0 * hull->beam_m * basin->form.scale *
                         hull->draught_m * pel_hull_form_deep(&basin->form, k));
}

/* Half of the plane: k and −k together. What fills up the last bunch has no
 * gain. */
static enum pel_err fill_band(struct pel_wake_basin *basin, int i)
{
    struct pel_wake_band *band = &basin->band[i];
    double step = 2.0 * PEL_PI / band->length_m;
    for (int pass = 0; pass < 2; pass++) {
        int p = 0;
        for (int n = 0; n <= MODES; n++) {
            for (int m = n ? -MODES : 1; m <= MODES; m++) {
                double share = share_of(basin, i, step * hypot(m, n));
                if (share <= 0) {
                    continue;
                }
                if (pass) {
                    struct pel_wake_bunch *b = &band->bunch[p / LANES];
                    fill_mode(basin, i, m, n, share, b, p % LANES);
                    float group = b->group[p % LANES];
                    band->slowest_mps = fmin(band->slowest_mps, (double)group);
                    band->fastest_mps = fmax(band->fastest_mps, (double)group);
                }
                p++;
            }
        }
        if (!pass) {
            band->bunch_count = (p + LANES - 1) / LANES;
            band->bunch = aligned_alloc(64, (size_t)band->bunch_count *
                                                sizeof *band->bunch);
            if (!band->bunch) {
                return PEL_ERR_NO_MEMORY;
            }
            const struct pel_wake_bunch none = { .k = pel_lanes_spread(1),
                                                 .m = pel_lanes_spread(1) };
            band->bunch[band->bunch_count - 1] = none;
            band->slowest_mps = HUGE_VAL;
        }
    }
    return PEL_OK;
}

static void destroy(struct pel_wake_basin *basin)
{
    for (int i = basin->far ? 0 : 1; i < PEL_WAKE_TILES; i++) {
        free(basin->band[i].bunch);
    }
    pel_hull_form_finish(&basin->form);
    free(basin);
}

static enum pel_err create(const struct pel_hull *hull, double depth_m,
                           bool far, struct pel_wake_basin **out)
{
    struct pel_wake_basin *basin = calloc(1, sizeof *basin);
    if (!basin) {
        return PEL_ERR_NO_MEMORY;
    }
    basin->hull = *hull;
    basin->depth_m = depth_m;
    basin->far = far;
    double near_m = pel_wake_near_m(hull);
    enum pel_err err = pel_hull_form_init(
        &basin->form, hull, MODES * 2.0 * PEL_PI / near_m, depth_m);
    for (int i = 0; i < PEL_WAKE_TILES; i++) {
        basin->band[i].length_m =
            near_m * pow(PEL_WAKE_RATIO, PEL_WAKE_TILES - 1 - i);
    }
    for (int i = far ? 0 : 1; err == PEL_OK && i < PEL_WAKE_TILES; i++) {
        err = fill_band(basin, i);
    }
    if (err != PEL_OK) {
        destroy(basin);
        return err;
    }
    if (!far) {
        basin->band[0] = basin->band[1];
    }
    *out = basin;
    return PEL_OK;
}

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct shared {
    struct pel_wake_basin *basin;
    unsigned users;
    struct shared *next;
} * shared;

static bool same(const struct pel_wake_basin *b, const struct pel_hull *hull,
                 double depth_m, bool far)
{
    return b->hull.length_m == hull->length_m &&
           b->hull.beam_m == hull->beam_m &&
           b->hull.draught_m == hull->draught_m &&
           b->hull.block == hull->block && b->depth_m == depth_m &&
           b->far == far;
}

enum pel_err pel_wake_basin_get(const struct pel_hull *hull, double depth_m,
                                bool far, const struct pel_wake_basin **out)
{
    enum pel_err err = PEL_OK;
    pthread_mutex_lock(&lock);
    struct shared *s = shared;
    while (s && !same(s->basin, hull, depth_m, far)) {
        s = s->next;
    }
    if (!s) {
        s = calloc(1, sizeof *s);
        err = s ? create(hull, depth_m, far, &s->basin) : PEL_ERR_NO_MEMORY;
        if (err == PEL_OK) {
            s->next = shared;
            shared = s;
        }
    }
    if (err == PEL_OK) {
        s->users++;
        *out = s->basin;
    } else {
        free(s);
    }
    pthread_mutex_unlock(&lock);
    return err;
}

void pel_wake_basin_put(const struct pel_wake_basin *basin)
{
    pthread_mutex_lock(&lock);
    for (struct shared **s = &shared; basin && *s; s = &(*s)->next) {
        struct shared *here = *s;
        if (here->basin == basin) {
            if (--here->users == 0) {
                *s = here->next;
                destroy(here->basin);
                free(here);
            }
            break;
        }
    }
    pthread_mutex_unlock(&lock);
}

/* --- what a track puts into them ------------------------------------------ */

/* A leg, or a part of one over which weights are linear. */
struct stretch {
    double age_s; /* of its middle */
    float half_s, strength;
    float x, y;   /* its middle, from the tile's */
    float vx, vy; /* m/s */
    float ex, ey; /* unit, along it, times what makes the table's argument */
    float fx, fy; /* its middle, turns a mode number */
    float gx, gy; /* turns a second a mode number, from its speed */
};

struct window {         /* two: of packets, of reads */
    float per_m, whole; /* of a share of a tile's side */
    bool beside;        /* of another tile, whose middle is there */
    float x, y;
};

static struct stretch stretch_of(const struct pel_wake_basin *basin,
                                 double length_m,
                                 const struct pel_wake_leg *leg, double begin_s,
                                 double end_s, double time_s,
                                 const struct pel_vec2 *place)
{
    double mid = 0.5 * (begin_s + end_s), speed = hypot(leg->vx, leg->vy);
    double x = leg->x + leg->vx * (mid - leg->end_s);
    double y = leg->y + leg->vy * (mid - leg->end_s);
    double to_table = 0.5 * basin->hull.length_m * PEL_HULL_STEPS / speed;
    double fx = x / length_m, fy = y / length_m;
    return (struct stretch){
        .age_s = time_s - mid,
        .half_s = (float)(0.5 * (end_s - begin_s)),
        .strength = (float)(speed * (end_s - begin_s)),
        .x = (float)(place ? x - place->x : 0),
        .y = (float)(place ? y - place->y : 0),
        .vx = (float)leg->vx,
        .vy = (float)leg->vy,
        .ex = (float)(leg->vx * to_table),
        .ey = (float)(leg->vy * to_table),
        .fx = (float)(fx - floor(fx)),
        .fy = (float)(fy - floor(fy)),
        .gx = (float)(leg->vx / length_m),
        .gy = (float)(leg->vy / length_m),
    };
}

/* Whether any of its packets is in the tile: they travel at least so slowly and
 * at most so fast. */
static bool reaches(const struct pel_wake_band *band, const struct stretch *s,
                    double speed)
{
    double half = (double)s->half_s;
    double off = hypot((double)s->x, (double)s->y), own = speed * half;
    double reach = 1.5 * PEL_WAKE_HELD * band->length_m + own;
    return band->slowest_mps * (s->age_s - half) < off + reach &&
           band->fastest_mps * (s->age_s + half) > off - reach;
}

PEL_INLINE lanes size_of(lanes x)
{
    return (lanes)((ints)x & 0x7fffffff);
}

PEL_INLINE lanes larger(lanes a, lanes b)
{
    return pel_lanes_choose((ints)(a > b), a, b);
}

/* 1 within, falling smoothly to 0 at the border. */
PEL_INLINE lanes within(const struct window *w, lanes x, lanes y)
{
    lanes u = larger(size_of(x), size_of(y)) * w->per_m - w->whole;
    u = pel_lanes_choose((ints)(u > 0.0f), u, pel_lanes_spread(0.0f));
    u = pel_lanes_choose((ints)(u < 1.0f), u, pel_lanes_spread(1.0f));
    return 1.0f - u * u * (3.0f - 2.0f * u);
}

PEL_INLINE lanes weight_of(const struct window *w, lanes x, lanes y)
{
    lanes weight = within(w, x, y);
    if (w->beside) { /* whose reads fade too */
        lanes xo = x - w->x, yo = y - w->y;
        weight *= 1.0f - within(w, xo, yo) * within(&w[1], xo, yo);
    }
    return weight;
}

PEL_INLINE bool any(lanes x)
{
    int32_t all = 0;
    ints bits = (ints)x;
    for (int l = 0; l < LANES; l++) {
        all |= bits[l];
    }
    return all != 0;
}

/* The table along the hull at |s|; signed like s. */
PEL_INLINE lanes along_of(const float *table, lanes s)
{
    lanes out, at = size_of(s);
    for (int l = 0; l < LANES; l++) {
        int i = (int)at[l];
        float f = at[l] - (float)i;
        out[l] = table[i] + f * (table[i + 1] - table[i]);
    }
    return (lanes)((ints)out ^ ((ints)s & (int)0x80000000));
}

/* −i a ∫ w(τ) e^{−i phase(τ)} dτ of the waves that travel along side · k; w
 * goes from `begin` to `end`. */
PEL_INLINE void add_waves(const struct pel_wake_bunch *b,
                          const struct stretch *s, float side, lanes a,
                          lanes aged, lanes begin, lanes end, lanes *re,
                          lanes *im)
{
    const float two_pi = 6.28318530718f;
    lanes slip = b->turns - side * (b->m * s->gx + b->n * s->gy);
    lanes turns = slip * s->half_s, q = turns * two_pi, cq, sq, c, d;
    pel_lanes_turn(pel_lanes_part(turns), &cq, &sq);
    ints small = (ints)(size_of(q) < 0.03f);
    lanes per_q = 1.0f / pel_lanes_choose(small, pel_lanes_spread(1.0f), q);
    lanes even = pel_lanes_choose(small, 1.0f - q * q * (1.0f / 6), sq * per_q);
    lanes odd = pel_lanes_choose(small, q * (1.0f / 3), (even - cq) * per_q);
    even = even * 0.5f * (begin + end);
    odd = odd * 0.5f * (end - begin);
    pel_lanes_turn(pel_lanes_part(side * (b->m * s->fx + b->n * s->fy) + aged),
                   &c, &d);
    *re += a * (c * odd - d * even);
    *im -= a * (c * even + d * odd);
}

PEL_INLINE void add_stretch(const struct pel_wake_bunch *b,
                            const struct stretch *s, const float *table,
                            const struct window *window,
                            struct pel_wake_amplitudes *to)
{
    lanes one = pel_lanes_spread(1.0f), w[4] = { one, one, one, one };
    float age = (float)s->age_s;
    if (window) {
        lanes gx = b->group * b->ux, gy = b->group * b->uy;
        float from = age + s->half_s, until = age - s->half_s;
        float xa = s->x - s->vx * s->half_s, ya = s->y - s->vy * s->half_s;
        float xb = s->x + s->vx * s->half_s, yb = s->y + s->vy * s->half_s;
        w[0] = weight_of(window, xa + gx * from, ya + gy * from);
        w[1] = weight_of(window, xb + gx * until, yb + gy * until);
        w[2] = weight_of(window, xa - gx * from, ya - gy * from);
        w[3] = weight_of(window, xb - gx * until, yb - gy * until);
        if (!any(w[0] + w[1] + w[2] + w[3])) {
            return;
        }
    }
    lanes along = b->k * (b->ux * s->ex + b->uy * s->ey);
    lanes a = b->gain * s->strength * along_of(table, along) *
              (1.0f - b->k * b->k * (float)(2.0 * VISCOSITY * s->age_s));
    lanes aged = pel_lanes_fraction(b->turns, s->age_s);
    add_waves(b, s, 1.0f, a, aged, w[0], w[1], &to->re, &to->im);
    add_waves(b, s, -1.0f, -a, aged, w[2], w[3], &to->back_re, &to->back_im);
}

PEL_CLONES static void add_windowed(const struct pel_wake_band *band,
                                    const struct stretch *list, int count,
                                    const float *table,
                                    const struct window *window,
                                    struct pel_wake_amplitudes *to)
{
    for (int i = 0; i < band->bunch_count; i++) {
        struct pel_wake_amplitudes sum = to[i];
        for (int k = 0; k < count; k++) {
            add_stretch(&band->bunch[i], &list[k], table, window, &sum);
        }
        to[i] = sum;
    }
}

PEL_CLONES static void add_all(const struct pel_wake_band *band,
                               const struct stretch *list, int count,
                               const float *table,
                               struct pel_wake_amplitudes *to)
{
    for (int i = 0; i < band->bunch_count; i++) {
        struct pel_wake_amplitudes sum = to[i];
        for (int k = 0; k < count; k++) {
            add_stretch(&band->bunch[i], &list[k], table, NULL, &sum);
        }
        to[i] = sum;
    }
}

/* Adds a list and empties it. */
static void flush(const struct pel_wake_basin *basin,
                  const struct pel_wake_band *band, struct stretch *list,
                  int *count, const struct pel_vec2 *place,
                  const struct pel_vec2 *but, struct pel_wake_amplitudes *to)
{
    const double ramp = (PEL_WAKE_HELD - PEL_WAKE_WHOLE) * band->length_m;
    const double fade = (PEL_WAKE_FADED - PEL_WAKE_FADE) * band->length_m;
    const struct window window[2] = {
        {
            (float)(1.0 / ramp),
            (float)(PEL_WAKE_WHOLE / (PEL_WAKE_HELD - PEL_WAKE_WHOLE)),
            but && place,
            but && place ? (float)(but->x - place->x) : 0,
            but && place ? (float)(but->y - place->y) : 0,
        },
        {
            .per_m = (float)(1.0 / fade),
            .whole = (float)(PEL_WAKE_FADE / (PEL_WAKE_FADED - PEL_WAKE_FADE)),
        },
    };
    if (place) {
        add_windowed(band, list, *count, basin->form.along, window, to);
    } else {
        add_all(band, list, *count, basin->form.along, to);
    }
    *count = 0;
}

void pel_wake_band_add(const struct pel_wake_basin *basin, int i,
                       const struct pel_wake_leg *legs, int count,
                       double time_s, const struct pel_vec2 *place,
                       const struct pel_vec2 *but,
                       struct pel_wake_amplitudes *to)
{
    enum { AT_ONCE = 128 };
    const struct pel_wake_band *band = &basin->band[i];
    struct stretch list[AT_ONCE];
    int listed = 0;
    for (int k = 0; k < count; k++) {
        const struct pel_wake_leg *leg = &legs[k];
        double lasts = leg->end_s - leg->begin_s;
        double speed = hypot(leg->vx, leg->vy);
        double most = STRAIGHT * band->length_m / fmax(speed, 1.0);
        int parts = place ? (int)fmin(ceil(lasts / most), MOST_STRETCHES) : 1;
        for (int p = 0; p < parts; p++) {
            list[listed] = stretch_of(
                basin, band->length_m, leg, leg->begin_s + lasts * p / parts,
                leg->begin_s + lasts * (p + 1) / parts, time_s, place);
            listed += !place || reaches(band, &list[listed], speed);
            if (listed == AT_ONCE) {
                flush(basin, band, list, &listed, place, but, to);
            }
        }
    }
    flush(basin, band, list, &listed, place, but, to);
}

PEL_CLONES static void turn(const struct pel_wake_bunch *bunch, int count,
                            const struct pel_wake_amplitudes *from,
                            double later_s, struct pel_wake_amplitudes *to)
{
    for (int i = 0; i < count; i++) {
        lanes c, d;
        struct pel_wake_amplitudes a = from[i];
        pel_lanes_turn(pel_lanes_fraction(bunch[i].turns, later_s), &c, &d);
        to[i].re = a.re * c + a.im * d;
        to[i].im = a.im * c - a.re * d;
        to[i].back_re = a.back_re * c + a.back_im * d;
        to[i].back_im = a.back_im * c - a.back_re * d;
    }
}

void pel_wake_band_turn(const struct pel_wake_band *band,
                        const struct pel_wake_amplitudes *from, double later_s,
                        struct pel_wake_amplitudes *to)
{
    turn(band->bunch, band->bunch_count, from, later_s, to);
}
