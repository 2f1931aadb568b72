#include "weather/weather.h"

#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"

/* What the public part points into. */
struct field {
    struct pel_weather public; /* first */
    atomic_uint refs;
    double *latitude_deg, *unix_s;
    int16_t *values[PEL_WEATHER_NUMBERS];
    uint8_t *known;
    char notes[PEL_WEATHER_MOST_NOTES];
};

#define WIND_KNOWN 1
#define WAVES_KNOWN 2

static atomic_uint_least64_t serials;

double pel_weather_quantum(enum pel_weather_number number)
{
    switch (number) {
    case PEL_WEATHER_WIND_EAST:
    case PEL_WEATHER_WIND_NORTH:
        return 1.0 / 256;
    case PEL_WEATHER_DIRECTION:
    case PEL_WEATHER_SWELL_DIRECTION:
        return PEL_PI / 32767;
    default:
        return 1.0 / 1024;
    }
}

int16_t pel_weather_quantise(enum pel_weather_number number, double value)
{
    double quanta = value / pel_weather_quantum(number);
    return fabs(quanta) <= 32767.5
               ? (int16_t)fmin(fmax(rint(quanta), -32767), 32767)
               : PEL_WEATHER_NONE;
}

/* --- making --------------------------------------------------------------- */

static unsigned numbers_of(const struct pel_weather_grid *grid)
{
    unsigned has = 0;
    for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
        has |= grid->values[n] ? 1u << n : 0;
    }
    return has;
}

static enum pel_err check_sizes(const struct pel_weather_grid *g,
                                struct pel_fault *fault)
{
    if (g->columns < 2 || g->columns > PEL_WEATHER_MOST_COLUMNS ||
        g->rows < 2 || g->rows > PEL_WEATHER_MOST_ROWS || g->times < 1 ||
        g->times > PEL_WEATHER_MOST_TIMES) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%d × %d nodes at %d times; it must be 2 to %d × "
                             "2 to %d at 1 to %d",
                             g->columns, g->rows, g->times,
                             PEL_WEATHER_MOST_COLUMNS, PEL_WEATHER_MOST_ROWS,
                             PEL_WEATHER_MOST_TIMES);
    }
    size_t count = (size_t)g->columns * (size_t)g->rows * (size_t)g->times;
    int numbers = __builtin_popcount(numbers_of(g));
    if (count * (size_t)numbers > PEL_WEATHER_MOST_VALUES) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%d × %d nodes of %d numbers at %d times are more "
                             "than %zu: a coarser grid, a smaller region or "
                             "fewer times",
                             g->columns, g->rows, numbers, g->times,
                             PEL_WEATHER_MOST_VALUES);
    }
    return PEL_OK;
}

static enum pel_err check_place(const struct pel_weather_grid *g,
                                struct pel_fault *fault)
{
    bool steps = g->east_step > 0 && g->north_step > 0 &&
                 g->east_step <= PEL_WEATHER_MOST_STEP_DEG &&
                 g->north_step <= PEL_WEATHER_MOST_STEP_DEG;
    double north = g->south_deg + (g->rows - 1) * g->north_step;
    double wide = (g->columns - 1) * g->east_step;
    if (!steps) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "nodes are %g° and %g° apart; at most %g°",
                             g->east_step, g->north_step,
                             PEL_WEATHER_MOST_STEP_DEG);
    }
    if (!(fabs(g->west_deg) <= 360 && g->south_deg >= -90 - 1e-6 &&
          north <= 90 + 1e-6 && wide <= 360 + 1e-6)) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "latitudes %g to %g, longitudes %g to %g are not "
                             "degrees",
                             g->south_deg, north, g->west_deg,
                             g->west_deg + wide);
    }
    for (int t = 0; t < g->times; t++) {
        double s = g->unix_s[t];
        if (!(s >= PEL_WEATHER_FIRST_UNIX_S && s <= PEL_WEATHER_LAST_UNIX_S) ||
            (t > 0 && s <= g->unix_s[t - 1])) {
            return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                                 "its times must rise, from 1900 to 2100");
        }
    }
    return PEL_OK;
}

static enum pel_err check(const struct pel_weather_grid *g, bool waves_alone,
                          struct pel_fault *fault)
{
    unsigned has = numbers_of(g);
    unsigned waves = has & PEL_WEATHER_WAVES, parts = has & PEL_WEATHER_PARTS;
    if (!waves_alone && (has & PEL_WEATHER_WIND) != PEL_WEATHER_WIND) {
        return pel_fault_set(fault, PEL_ERR_INVALID, "it has no wind");
    }
    bool whole = waves == PEL_WEATHER_WAVES &&
                 (parts == 0 || parts == PEL_WEATHER_PARTS);
    if (waves_alone ? !whole || (has & PEL_WEATHER_WIND) || g->waves
                    : (waves || parts) && (!whole || g->waves)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "it has waves in part: height, period and "
                             "direction go together");
    }
    enum pel_err err = check_sizes(g, fault);
    return err ? err : check_place(g, fault);
}

static void destroy(struct field *f)
{
    for (int n = 0; f && n < PEL_WEATHER_NUMBERS; n++) {
        free(f->values[n]);
    }
    if (f) {
        free(f->latitude_deg);
        free(f->unix_s);
        free(f->known);
        pel_weather_unref(f->public.waves);
        free(f);
    }
}

/* Whether a grid that goes round the Earth lacks a row at this pole. */
static bool lacks_pole(const struct pel_weather_grid *g, bool around,
                       double end_deg)
{
    double gap = 90 - fabs(end_deg);
    return around && gap > 1e-3 * g->north_step && gap < 1.01 * g->north_step;
}

static struct field *allocate(const struct pel_weather_grid *g)
{
    struct field *f = calloc(1, sizeof *f);
    if (!f) {
        return NULL;
    }
    struct pel_weather *w = &f->public;
    double wide = g->columns * g->east_step;
    double north = g->south_deg + (g->rows - 1) * g->north_step;
    w->around = wide > 360 - 0.01 * g->east_step;
    /* A last column that is the first again goes. */
    w->columns = g->columns - (wide > 360 + 0.5 * g->east_step);
    w->times = g->times;
    w->west_deg = g->west_deg;
    w->east_step = w->around ? 360.0 / w->columns : g->east_step;
    w->has = numbers_of(g);
    bool below = lacks_pole(g, w->around, g->south_deg);
    bool above = lacks_pole(g, w->around, north);
    w->rows = g->rows + below + above;
    size_t nodes = (size_t)w->columns * (size_t)w->rows;
    size_t count = nodes * (size_t)w->times;
    f->latitude_deg = calloc((size_t)w->rows, sizeof *f->latitude_deg);
    f->unix_s = calloc((size_t)w->times, sizeof *f->unix_s);
    f->known = calloc(count, 1);
    bool whole = f->latitude_deg && f->unix_s && f->known;
    for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
        if (g->values[n]) {
            f->values[n] = calloc(count, sizeof *f->values[n]);
            whole = whole && f->values[n];
        }
        w->values[n] = f->values[n];
    }
    if (!whole) {
        destroy(f);
        return NULL;
    }
    for (int r = 0; r < w->rows; r++) {
        f->latitude_deg[r] = g->south_deg + (r - below) * g->north_step;
    }
    f->latitude_deg[0] = below ? -90 : f->latitude_deg[0];
    f->latitude_deg[w->rows - 1] = above ? 90 : f->latitude_deg[w->rows - 1];
    memcpy(f->unix_s, g->unix_s, (size_t)w->times * sizeof *f->unix_s);
    w->latitude_deg = f->latitude_deg;
    w->unix_s = f->unix_s;
    w->known = f->known;
    w->notes = f->notes;
    snprintf(f->notes, sizeof f->notes, "%s", g->notes ? g->notes : "");
    atomic_init(&f->refs, 1);
    return f;
}

/* Copies the rows of one time, those at added poles left as they are. */
static void copy_time(struct field *f, const struct pel_weather_grid *g, int t)
{
    const struct pel_weather *w = &f->public;
    int below = w->latitude_deg[0] < g->south_deg - 1e-9 * g->north_step;
    size_t width = (size_t)w->columns;
    for (int r = 0; r < g->rows; r++) {
        size_t to = ((size_t)t * (size_t)w->rows + (size_t)(r + below)) * width;
        size_t from =
            ((size_t)t * (size_t)g->rows + (size_t)r) * (size_t)g->columns;
        for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
            if (f->values[n]) {
                memcpy(f->values[n] + to, g->values[n] + from,
                       width * sizeof *f->values[n]);
            }
        }
    }
}

/* The node at a number of columns and rows away; −1: none. */
static int64_t neighbour(const struct pel_weather *w, int64_t node, int dx,
                         int dy)
{
    int64_t x = node % w->columns + dx, y = node / w->columns + dy;
    if (w->around) {
        x = (x + w->columns) % w->columns;
    }
    bool inside = x >= 0 && x < w->columns && y >= 0 && y < w->rows;
    return inside ? y * w->columns + x : -1;
}

/* Gives the nodes of one time without these numbers those of a near node that
 * has them: ring by ring from the coasts inland. `queue`: room for all nodes.
 * False: no node has them. */
static bool fill(struct field *f, int t, unsigned numbers, uint8_t mark,
                 int32_t *queue)
{
    const struct pel_weather *w = &f->public;
    int64_t nodes = (int64_t)w->columns * w->rows, end = 0;
    uint8_t *known = f->known + t * nodes;
    int16_t *values[PEL_WEATHER_NUMBERS];
    uint8_t done = (uint8_t)(mark << 4);
    for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
        bool mine = f->values[n] && (numbers & 1u << n);
        values[n] = mine ? f->values[n] + t * nodes : NULL;
    }
    for (int64_t i = 0; i < nodes; i++) {
        bool whole = true;
        for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
            whole = whole && !(values[n] && values[n][i] == PEL_WEATHER_NONE);
        }
        if (whole) {
            known[i] |= mark | done;
            queue[end++] = (int32_t)i;
        }
    }
    if (end == 0) {
        return false;
    }
    for (int64_t at = 0; at < end && end < nodes; at++) {
        static const int steps[4][2] = {
            { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 }
        };
        for (int s = 0; s < 4; s++) {
            int64_t to = neighbour(w, queue[at], steps[s][0], steps[s][1]);
            if (to < 0 || known[to] & done) {
                continue;
            }
            for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
                if (values[n]) {
                    values[n][to] = values[n][queue[at]];
                }
            }
            known[to] |= done;
            queue[end++] = (int32_t)to;
        }
    }
    for (int64_t i = 0; i < nodes; i++) {
        known[i] &= (uint8_t)~done;
    }
    return true;
}

/* The row at a pole is the mean of the one beside it, as a vector: the pole's
 * "east" turns with the longitude. */
static void mean_pole(struct field *f, int t, int row, int beside)
{
    const struct pel_weather *w = &f->public;
    size_t nodes = (size_t)w->columns * (size_t)w->rows;
    size_t first = (size_t)t * nodes;
    size_t to = first + (size_t)row * (size_t)w->columns;
    size_t from = first + (size_t)beside * (size_t)w->columns;
    double side = row > 0 ? 1 : -1; /* north or south pole */
    double sum[PEL_WEATHER_NUMBERS] = { 0 };
    struct pel_vec2 wind = { 0, 0 }, go[2] = { { 0, 0 }, { 0, 0 } };
    static const int directions[2] = { PEL_WEATHER_DIRECTION,
                                       PEL_WEATHER_SWELL_DIRECTION };
    for (int c = 0; c < w->columns; c++) {
        double a = side * c * w->east_step * PEL_DEG;
        double x = f->values[0][from + (size_t)c];
        double y = f->values[1][from + (size_t)c];
        wind.x += x * cos(a) - y * sin(a);
        wind.y += x * sin(a) + y * cos(a);
        for (int n = 2; n < PEL_WEATHER_NUMBERS; n++) {
            sum[n] += f->values[n] ? f->values[n][from + (size_t)c] : 0;
        }
        for (int k = 0; k < 2; k++) {
            const int16_t *v = f->values[directions[k]];
            double d = v ? v[from + (size_t)c] * (PEL_PI / 32767) + a : 0;
            go[k].x += cos(d);
            go[k].y += sin(d);
        }
    }
    for (int c = 0; c < w->columns; c++) {
        double a = side * c * w->east_step * PEL_DEG;
        size_t at = to + (size_t)c;
        f->values[0][at] =
            (int16_t)rint((wind.x * cos(a) + wind.y * sin(a)) / w->columns);
        f->values[1][at] =
            (int16_t)rint((wind.y * cos(a) - wind.x * sin(a)) / w->columns);
        for (int n = 2; n < PEL_WEATHER_NUMBERS; n++) {
            if (f->values[n]) {
                f->values[n][at] = (int16_t)rint(sum[n] / w->columns);
            }
        }
        for (int k = 0; k < 2; k++) {
            int16_t *v = f->values[directions[k]];
            if (v) {
                double d = remainder(atan2(go[k].y, go[k].x) - a, 2 * PEL_PI);
                v[at] = (int16_t)rint(d * (32767 / PEL_PI));
            }
        }
        f->known[at] = f->known[from + (size_t)c];
    }
}

static enum pel_err take_time(struct field *f, const struct pel_weather_grid *g,
                              int t, int32_t *queue, struct pel_fault *fault)
{
    const struct pel_weather *w = &f->public;
    bool below = w->latitude_deg[0] < g->south_deg - 1e-9 * g->north_step;
    bool above = w->rows > g->rows + below;
    /* Until they are made, rows at poles are as land. */
    for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
        size_t row = (size_t)w->columns, all = row * (size_t)w->rows;
        int16_t *v = f->values[n] ? f->values[n] + (size_t)t * all : NULL;
        for (size_t c = 0; v && c < row; c++) {
            v[c] = below ? PEL_WEATHER_NONE : v[c];
            v[all - row + c] = above ? PEL_WEATHER_NONE : v[all - row + c];
        }
    }
    copy_time(f, g, t);
    unsigned waves = PEL_WEATHER_WAVES | PEL_WEATHER_PARTS;
    if (((w->has & PEL_WEATHER_WIND) &&
         !fill(f, t, PEL_WEATHER_WIND, WIND_KNOWN, queue)) ||
        ((w->has & waves) && !fill(f, t, waves, WAVES_KNOWN, queue))) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "of its times number %d of %d has no %s anywhere",
                             t + 1, w->times,
                             !(w->has & PEL_WEATHER_WIND) ||
                                     (f->known[(size_t)t * (size_t)w->columns *
                                               (size_t)w->rows] &
                                      WIND_KNOWN)
                                 ? "waves"
                                 : "wind");
    }
    if (below) {
        mean_pole(f, t, 0, 1);
    }
    if (above) {
        mean_pole(f, t, w->rows - 1, w->rows - 2);
    }
    return PEL_OK;
}

static enum pel_err create(const struct pel_weather_grid *grid,
                           bool waves_alone, const struct pel_weather **out,
                           struct pel_fault *fault)
{
    enum pel_err err = check(grid, waves_alone, fault);
    if (err) {
        return err;
    }
    struct field *f = allocate(grid);
    size_t nodes = f ? (size_t)f->public.columns * (size_t)f->public.rows : 0;
    int32_t *queue = f ? malloc(nodes * sizeof *queue) : NULL;
    if (!queue) {
        err = pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    for (int t = 0; !err && t < grid->times; t++) {
        err = take_time(f, grid, t, queue, fault);
    }
    free(queue);
    if (!err && grid->waves) {
        err = create(grid->waves, true, &f->public.waves, fault);
    }
    if (err) {
        destroy(f);
        return err;
    }
    f->public.has |= f->public.waves ? f->public.waves->has : 0;
    f->public.serial = ++serials;
    *out = &f->public;
    return PEL_OK;
}

enum pel_err pel_weather_create(const struct pel_weather_grid *grid,
                                const struct pel_weather **out,
                                struct pel_fault *fault)
{
    return create(grid, false, out, fault);
}

const struct pel_weather *pel_weather_ref(const struct pel_weather *weather)
{
    if (weather) {
        atomic_fetch_add(&((struct field *)weather)->refs, 1);
    }
    return weather;
}

void pel_weather_unref(const struct pel_weather *weather)
{
    struct field *f = (struct field *)weather;
    if (f && atomic_fetch_sub(&f->refs, 1) == 1) {
        destroy(f);
    }
}

/* --- asking --------------------------------------------------------------- */

/* Between two of a rising list: the first, and how far to the second. */
struct between {
    int first, second;
    double f;
};

static struct between find(const double *list, int count, double at)
{
    int lo = 0, hi = count - 1;
    if (!(at > list[0])) {
        return (struct between){ 0, 0, 0 };
    }
    if (at >= list[hi]) {
        return (struct between){ hi, hi, 0 };
    }
    while (hi - lo > 1) {
        int mid = (lo + hi) / 2;
        if (list[mid] <= at) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    return (struct between){ lo, hi, (at - list[lo]) / (list[hi] - list[lo]) };
}

static struct between find_column(const struct pel_weather *w,
                                  double longitude_deg, bool *outside)
{
    double d = fmod(longitude_deg - w->west_deg, 360.0);
    double at = (d < 0 ? d + 360.0 : d) / w->east_step;
    double last = w->columns - 1, turn = 360.0 / w->east_step;
    if (!w->around && at > last) {
        *outside = at - last > 1e-9 && turn - at > 1e-9;
        at = at - last < turn - at ? last : 0; /* the nearer edge */
    }
    int i = (int)fmin(floor(at), last);
    int next = w->around ? (i + 1) % w->columns : i + (i < w->columns - 1);
    return (struct between){ i, next, at - i };
}

/* The eight nodes about a place and time, and their weights. */
struct corners {
    size_t at[8];
    double weight[8];
};

static double mean(const struct corners *c, const int16_t *v)
{
    double sum = 0;
    for (int i = 0; i < 8; i++) {
        sum += c->weight[i] * v[c->at[i]];
    }
    return sum;
}

struct train {
    double period_s, direction_rad, agreement;
};

/* Period and direction of waves, weighted by their energy: that of all or, of
 * swell, without the wind sea's. */
static struct train mean_train(const struct pel_weather *w,
                               const struct corners *c, bool swell,
                               enum pel_weather_number period,
                               enum pel_weather_number direction)
{
    double all = 0, time = 0;
    struct pel_vec2 way = { 0, 0 };
    for (int i = 0; i < 8; i++) {
        double h = w->values[PEL_WEATHER_HEIGHT][c->at[i]];
        double wind = swell ? w->values[PEL_WEATHER_WIND_HEIGHT][c->at[i]] : 0;
        /* The least, a quantum, so that a flat sea has some. */
        double energy = c->weight[i] * fmax(h * h - wind * wind, 1);
        double angle = w->values[direction][c->at[i]] * (PEL_PI / 32767);
        all += energy;
        time += energy * w->values[period][c->at[i]];
        way.x += energy * cos(angle);
        way.y += energy * sin(angle);
    }
    return (struct train){
        time / all * pel_weather_quantum(period),
        atan2(way.y, way.x),
        fmin(hypot(way.x, way.y) / all, 1),
    };
}

/* Answers the numbers that this grid has itself. */
static void ask(const struct pel_weather *w, double latitude_rad,
                double longitude_rad, double unix_s,
                struct pel_weather_now *out)
{
    const int16_t *const *v = w->values;
    double latitude = latitude_rad / PEL_DEG;
    bool outside = false;
    struct between x = find_column(w, longitude_rad / PEL_DEG, &outside);
    struct between y = find(w->latitude_deg, w->rows, latitude);
    struct between t = find(w->unix_s, w->times, unix_s);
    outside = outside || latitude < w->latitude_deg[0] - 1e-9 ||
              latitude > w->latitude_deg[w->rows - 1] + 1e-9;
    struct corners c;
    size_t nearest = 0;
    for (int i = 0; i < 8; i++) {
        int column = i & 1 ? x.second : x.first;
        int row = i & 2 ? y.second : y.first;
        int time = i & 4 ? t.second : t.first;
        c.at[i] = ((size_t)time * (size_t)w->rows + (size_t)row) *
                      (size_t)w->columns +
                  (size_t)column;
        c.weight[i] = (i & 1 ? x.f : 1 - x.f) * (i & 2 ? y.f : 1 - y.f) *
                      (i & 4 ? t.f : 1 - t.f);
        nearest = c.weight[i] > c.weight[nearest] ? (size_t)i : nearest;
    }
    uint8_t known = w->known[c.at[nearest]];
    *out = (struct pel_weather_now){
        .place = unix_s < w->unix_s[0]              ? PEL_WEATHER_BEFORE
                 : unix_s > w->unix_s[w->times - 1] ? PEL_WEATHER_AFTER
                 : outside                          ? PEL_WEATHER_OUTSIDE
                                                    : PEL_WEATHER_INSIDE,
        .wind_known = known & WIND_KNOWN,
        .waves_known = known & WAVES_KNOWN,
        .parts = v[PEL_WEATHER_WIND_HEIGHT] != NULL,
        .height_m = -1,
        .period_s = -1,
        .direction_rad = -1,
    };
    if (v[PEL_WEATHER_WIND_EAST]) {
        out->wind_east_mps = mean(&c, v[PEL_WEATHER_WIND_EAST]) / 256;
        out->wind_north_mps = mean(&c, v[PEL_WEATHER_WIND_NORTH]) / 256;
    }
    if (v[PEL_WEATHER_HEIGHT]) {
        struct train all =
            mean_train(w, &c, false, PEL_WEATHER_PERIOD, PEL_WEATHER_DIRECTION);
        out->height_m = fmax(mean(&c, w->values[PEL_WEATHER_HEIGHT]), 0) / 1024;
        out->period_s = all.period_s;
        out->direction_rad = all.direction_rad;
        out->agreement = all.agreement;
    }
    if (out->parts) {
        struct train swell = mean_train(w, &c, true, PEL_WEATHER_SWELL_PERIOD,
                                        PEL_WEATHER_SWELL_DIRECTION);
        out->wind_height_m =
            fmax(mean(&c, w->values[PEL_WEATHER_WIND_HEIGHT]), 0) / 1024;
        out->swell_period_s = swell.period_s;
        out->swell_direction_rad = swell.direction_rad;
        out->swell_agreement = swell.agreement;
    }
}

void pel_weather_at(const struct pel_weather *w, double latitude_rad,
                    double longitude_rad, double unix_s,
                    struct pel_weather_now *out)
{
    struct pel_weather_now wind;
    ask(w, latitude_rad, longitude_rad, unix_s, out);
    if (!w->waves) {
        return;
    }
    wind = *out;
    ask(w->waves, latitude_rad, longitude_rad, unix_s, out);
    out->waves_known = out->waves_known && out->place != PEL_WEATHER_OUTSIDE;
    out->wind_known = wind.wind_known;
    out->wind_east_mps = wind.wind_east_mps;
    out->wind_north_mps = wind.wind_north_mps;
    if (wind.place != PEL_WEATHER_INSIDE) {
        out->place = wind.place;
    }
}
