/* Where the wash of ships is: the index, and what it does to a place. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "ocean/wash.h"

#define SLOPE_M 0.02
#define LEAST_CELL_M 8.0
#define COUNT_BITS 10

static double smooth(double lo, double hi, double x)
{
    double t = pel_clamp((x - lo) / (hi - lo), 0, 1);
    return t * t * (3 - 2 * t);
}

static double mix(double a, double b, double f)
{
    return a + f * (b - a);
}

/* --- index ---------------------------------------------------------------- */

struct box {
    double low[2], high[2];
};

static double reach_of(const struct pel_wash_node *n)
{
    double most =
        fmax(n->half_m, fmax(1.1 * n->core_m, n->side_m + n->side_half_m));
    return 1.2 * most + PEL_WASH_SOFTEST_M + 2.0;
}

static void widen(struct box *b, double x, double y)
{
    b->low[0] = fmin(b->low[0], x);
    b->low[1] = fmin(b->low[1], y);
    b->high[0] = fmax(b->high[0], x);
    b->high[1] = fmax(b->high[1], y);
}

static struct box empty_box(void)
{
    return (struct box){ { HUGE_VAL, HUGE_VAL }, { -HUGE_VAL, -HUGE_VAL } };
}

/* Of the piece from node i on; false: there is none. */
static bool box_of(const struct pel_wash *w, size_t i, struct box *out)
{
    if (i + 1 >= w->count || w->node[i + 1].begins) {
        return false;
    }
    *out = empty_box();
    for (int end = 0; end < 2; end++) {
        const struct pel_wash_node *n = &w->node[i + (size_t)end];
        double r = reach_of(n);
        for (int side = -1; side <= 1; side += 2) {
            widen(out, n->x_m - side * r * n->ty, n->y_m + side * r * n->tx);
        }
    }
    return true;
}

static int place_in(double at, double low, double per_m, int count)
{
    return (int)pel_clamp((at - low) * per_m, 0, count - 1);
}

static void cells_of(const struct pel_wash *w, const struct box *b, int out[4])
{
    double per_m = w->cells_per_m;
    out[0] = place_in(b->low[0], w->west_m, per_m, w->columns);
    out[1] = place_in(b->low[1], w->south_m, per_m, w->rows);
    out[2] = place_in(b->high[0], w->west_m, per_m, w->columns);
    out[3] = place_in(b->high[1], w->south_m, per_m, w->rows);
}

static bool shape_grid(struct pel_wash *w)
{
    struct box all = empty_box(), b;
    for (size_t i = 0; i < w->count; i++) {
        if (box_of(w, i, &b)) {
            widen(&all, b.low[0], b.low[1]);
            widen(&all, b.high[0], b.high[1]);
        }
    }
    if (!(all.high[0] > all.low[0])) {
        return false;
    }
    double x = all.high[0] - all.low[0], y = all.high[1] - all.low[1];
    double cell = fmax(fmax(x, y) / PEL_WASH_CELLS, LEAST_CELL_M);
    w->west_m = all.low[0];
    w->south_m = all.low[1];
    w->cells_per_m = 1 / cell;
    w->columns = (int)pel_clamp(ceil(x / cell), 1, PEL_WASH_CELLS);
    w->rows = (int)pel_clamp(ceil(y / cell), 1, PEL_WASH_CELLS);
    return true;
}

/* Adds 1 to each cell of each piece, or lists the pieces there. */
static void go_over(struct pel_wash *w, bool listing)
{
    const uint32_t most = (1u << COUNT_BITS) - 1;
    for (size_t i = 0; i < w->count; i++) {
        struct box b;
        int c[4];
        if (!box_of(w, i, &b)) {
            continue;
        }
        cells_of(w, &b, c);
        for (int row = c[1]; row <= c[3]; row++) {
            for (int column = c[0]; column <= c[2]; column++) {
                uint32_t *cell = &w->cell[row * w->columns + column];
                uint32_t number = *cell & most;
                if (number == most) {
                    continue;
                }
                if (listing) {
                    w->list[(*cell >> COUNT_BITS) + number] = (uint32_t)i;
                }
                ++*cell;
            }
        }
    }
}

enum pel_err pel_wash_index(struct pel_wash *w)
{
    if (!shape_grid(w)) {
        w->columns = w->rows = 0;
        return PEL_OK;
    }
    size_t cells = (size_t)w->columns * (size_t)w->rows;
    w->cell = pel_sure_calloc(cells, sizeof *w->cell);
    go_over(w, false);
    for (size_t i = 0; i < cells; i++) {
        size_t number = w->cell[i];
        w->cell[i] = (uint32_t)w->listed << COUNT_BITS;
        w->listed += number;
    }
    w->list = pel_sure_calloc(w->listed, sizeof *w->list);
    go_over(w, true);
    return PEL_OK;
}

/* --- a place -------------------------------------------------------------- */

/* What the edges are off by, in half-widths: they billow. */
static double bend_at(double x, double y)
{
    double a = x * PEL_WASH_BEND_1_X + y * PEL_WASH_BEND_1_Y;
    double b = x * PEL_WASH_BEND_2_X + y * PEL_WASH_BEND_2_Y;
    return PEL_WASH_BEND * (sin(2 * PEL_PI * (a - floor(a))) +
                            sin(2 * PEL_PI * (b - floor(b))));
}

/* A band `off` from its middle as a footprint sees it: its mean is kept. */
static double band(double off, double half, double from, double to, double soft)
{
    double wide = fmax(half, fmin(soft, half + PEL_WASH_SOFTEST_M));
    return (1 - smooth(from, to, fabs(off) / wide)) * half / wide;
}

struct sum {
    double calm, foam, bubbles;
};

static void add_piece(const struct pel_wash_node *a, double x, double y,
                      double bend, double footprint, struct sum *sum)
{
    const struct pel_wash_node *b = a + 1;
    double f0 = (x - a->x_m) * a->tx + (y - a->y_m) * a->ty;
    double f1 = (x - b->x_m) * b->tx + (y - b->y_m) * b->ty;
    if (!(f0 >= 0 && f1 < 0)) {
        return;
    }
    double f = f0 / (f0 - f1), soft = 0.5 * footprint;
    double nx = -mix(a->ty, b->ty, f), ny = mix(a->tx, b->tx, f);
    double v = ((x - mix(a->x_m, b->x_m, f)) * nx +
                (y - mix(a->y_m, b->y_m, f)) * ny) /
               fmax(hypot(nx, ny), 0.1);
    double half = mix(a->half_m, b->half_m, f);
    double core = mix(a->core_m, b->core_m, f);
    double beside = mix(a->side_m, b->side_m, f);
    double side = mix(a->side_half_m, b->side_half_m, f);
    double wake = band(v + bend * half, half, 0.65, 1, soft);
    double amid = band(v + bend * core, core, 0.4, 1.1, soft);
    double off = fabs(v) - beside;
    sum->calm = fmax(sum->calm, mix(a->calm, b->calm, f) * wake);
    sum->bubbles = fmax(sum->bubbles, mix(a->bubbles, b->bubbles, f) * amid);
    double foam = fmax(mix(a->core, b->core, f) * amid,
                       mix(a->side, b->side, f) *
                           band(off + bend * side, side, 0.4, 1, soft));
    sum->foam = fmax(sum->foam, foam);
}

/* Pieces that may hold places about one. */
struct near {
    uint32_t count;
    const uint32_t *list;
};

static struct near near_of(const struct pel_wash *w, double x, double y)
{
    double cx = (x - w->west_m) * w->cells_per_m;
    double cy = (y - w->south_m) * w->cells_per_m;
    if (cx >= 0 && cy >= 0 && cx < w->columns && cy < w->rows) {
        uint32_t cell = w->cell[(int)cy * w->columns + (int)cx];
        return (struct near){ cell & ((1u << COUNT_BITS) - 1),
                              w->list + (cell >> COUNT_BITS) };
    }
    return (struct near){ 0 };
}

static struct pel_washed washed_by(const struct pel_wash *w,
                                   const struct near *near, double x, double y,
                                   double footprint_m)
{
    struct sum sum = { 0 };
    double bend = near->count ? bend_at(x, y) : 0;
    for (uint32_t i = 0; i < near->count; i++) {
        add_piece(&w->node[near->list[i]], x, y, bend, footprint_m, &sum);
    }
    return (struct pel_washed){ 1 - sum.calm + PEL_WASH_CHURNED * sum.foam,
                                sum.foam, sum.bubbles };
}

struct pel_washed pel_wash_at(const struct pel_wash *w, double x, double y,
                              double footprint_m)
{
    struct near near = near_of(w, x, y);
    return washed_by(w, &near, x, y, footprint_m);
}

bool pel_wash_near(const struct pel_wash *w, double x, double y)
{
    const struct box around = { { x - PEL_WASH_NEAR_M, y - PEL_WASH_NEAR_M },
                                { x + PEL_WASH_NEAR_M, y + PEL_WASH_NEAR_M } };
    double per_m = w->cells_per_m;
    if (w->columns == 0 || (around.high[0] - w->west_m) * per_m < 0 ||
        (around.high[1] - w->south_m) * per_m < 0 ||
        (around.low[0] - w->west_m) * per_m >= w->columns ||
        (around.low[1] - w->south_m) * per_m >= w->rows) {
        return false;
    }
    int c[4];
    cells_of(w, &around, c);
    for (int row = c[1]; row <= c[3]; row++) {
        for (int column = c[0]; column <= c[2]; column++) {
            if (w->cell[row * w->columns + column] & ((1u << COUNT_BITS) - 1)) {
                return true;
            }
        }
    }
    return false;
}

/* Those of `from` between whose ends a place within `off` may lie; as many as
 * there is room for, or all. */
static struct near nearer(const struct pel_wash *w, const struct near *from,
                          double x, double y, double off, uint32_t room,
                          uint32_t *list)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < from->count; i++) {
        const struct pel_wash_node *a = &w->node[from->list[i]], *b = a + 1;
        double f0 = (x - a->x_m) * a->tx + (y - a->y_m) * a->ty;
        double f1 = (x - b->x_m) * b->tx + (y - b->y_m) * b->ty;
        if (f0 >= -off && f1 < off) {
            if (count == room) {
                return *from;
            }
            list[count++] = from->list[i];
        }
    }
    return (struct near){ count, list };
}

double pel_wash_factor(const struct pel_wash *w, double x, double y,
                       struct pel_vec2 *slope)
{
    enum { ROOM = 32 };
    const double h = SLOPE_M;
    const struct pel_vec2 at[5] = {
        { x, y }, { x + h, y }, { x - h, y }, { x, y + h }, { x, y - h }
    };
    uint32_t list[ROOM];
    double up[5];
    struct near all = near_of(w, x, y);
    struct near few = nearer(w, &all, x, y, 2 * h, ROOM, list);
    for (int i = 0; i < 5; i++) {
        up[i] = washed_by(w, &few, at[i].x, at[i].y, 0).up;
    }
    slope->x = (up[1] - up[2]) / (2 * h);
    slope->y = (up[3] - up[4]) / (2 * h);
    return up[0];
}

/* --- for shaders ---------------------------------------------------------- */

static void put(uint32_t *to, double value)
{
    float f = (float)value;
    memcpy(to, &f, sizeof f);
}

size_t pel_wash_words(const struct pel_wash *w, double east_m, double north_m,
                      uint32_t *out)
{
    size_t cells = (size_t)w->columns * (size_t)w->rows;
    size_t nodes = PEL_WASH_NODE_WORDS * w->count;
    for (size_t i = 0; i < w->count && out; i++) {
        const struct pel_wash_node *n = &w->node[i];
        const double words[PEL_WASH_NODE_WORDS] = {
            n->x_m - east_m, n->y_m - north_m, n->tx,     n->ty,
            n->half_m,       n->calm,          n->core_m, n->core,
            n->side_m,       n->side_half_m,   n->side,   n->bubbles,
        };
        for (size_t k = 0; k < PEL_WASH_NODE_WORDS; k++) {
            put(out + PEL_WASH_NODE_WORDS * i + k, words[k]);
        }
    }
    if (out && w->listed) {
        memcpy(out + nodes, w->list, w->listed * sizeof *out);
        memcpy(out + nodes + w->listed, w->cell, cells * sizeof *out);
    }
    return nodes + w->listed + cells;
}
