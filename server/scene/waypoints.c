#include "scene/waypoints.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/reserve.h"

enum { NORMAL_X, NORMAL_Y, NORMAL_Z, HEIGHT, HEADING, PITCH, ROLL, VALUES };

struct knot {
    double time_s, value[VALUES], rate[VALUES];
};

struct pel_way {
    atomic_uint refs;
    size_t count;
    struct knot knots[];
};

static double slope(const struct knot *a, const struct knot *b, int k)
{
    return (b->value[k] - a->value[k]) / (b->time_s - a->time_s);
}

/* Through the neighbours, by their distances. */
static double smooth(double before, double after, double h0, double h1)
{
    return (before * h1 + after * h0) / (h0 + h1);
}

/* Fritsch and Butland: none at a turning point. */
static double monotone(double before, double after, double h0, double h1)
{
    double w0 = 2 * h1 + h0, w1 = h1 + 2 * h0;
    return before * after > 0 ? (w0 + w1) / (w0 / before + w1 / after) : 0;
}

static void set_rates(struct pel_way *way)
{
    size_t last = way->count - 1;
    for (size_t i = 0; i <= last && last > 0; i++) {
        struct knot *k = &way->knots[i];
        for (int v = 0; v < VALUES; v++) {
            double before = i > 0 ? slope(k - 1, k, v) : 0;
            double after = i < last ? slope(k, k + 1, v) : 0;
            double h0 = i > 0 ? k->time_s - k[-1].time_s : 0;
            double h1 = i < last ? k[1].time_s - k->time_s : 0;
            k->rate[v] = i == 0          ? after
                         : i == last     ? before
                         : v <= NORMAL_Z ? smooth(before, after, h0, h1)
                                         : monotone(before, after, h0, h1);
        }
    }
}

struct pel_way *pel_way_of(Pelagos__Waypoint *const *points, size_t count)
{
    struct pel_way *way =
        pel_sure_calloc(1, sizeof *way + count * sizeof(struct knot));
    atomic_init(&way->refs, 1);
    way->count = count;
    for (size_t i = 0; i < count; i++) {
        const Pelagos__Waypoint *p = points[i];
        struct knot *k = &way->knots[i];
        double c = cos(p->latitude * PEL_DEG);
        k->time_s = p->time;
        k->value[NORMAL_X] = c * cos(p->longitude * PEL_DEG);
        k->value[NORMAL_Y] = c * sin(p->longitude * PEL_DEG);
        k->value[NORMAL_Z] = sin(p->latitude * PEL_DEG);
        k->value[HEIGHT] = asinh(p->height);
        const double degrees[] = { p->heading, p->pitch, p->roll };
        for (int a = 0; a < 3; a++) {
            double *to = &k->value[HEADING + a];
            *to = degrees[a] * PEL_DEG;
            if (i > 0) {
                double from = k[-1].value[HEADING + a];
                *to = from + remainder(*to - from, 2 * PEL_PI);
            }
        }
    }
    set_rates(way);
    return way;
}

struct pel_way *pel_way_ref(struct pel_way *way)
{
    if (way) {
        atomic_fetch_add(&way->refs, 1);
    }
    return way;
}

void pel_way_unref(struct pel_way *way)
{
    if (way && atomic_fetch_sub(&way->refs, 1) == 1) {
        free(way);
    }
}

static double hermite(const struct knot *a, const struct knot *b, int v,
                      double t)
{
    double h = b->time_s - a->time_s;
    double d = b->value[v] - a->value[v];
    double r0 = h * a->rate[v] - d, r1 = h * b->rate[v] - d;
    /* A straight line with a bend on it: what rests stays, to the bit. */
    return a->value[v] + t * d + t * (1 - t) * ((1 - t) * r0 - t * r1);
}

void pel_way_at(const struct pel_way *way, double time_s,
                struct pel_way_pose *out)
{
    const struct knot *first = way->knots, *last = first + way->count - 1;
    double value[VALUES];
    const struct knot *a = first;
    while (a < last - 1 && time_s >= a[1].time_s) {
        a++;
    }
    const struct knot *b = a < last ? a + 1 : a;
    double t = b > a ? (time_s - a->time_s) / (b->time_s - a->time_s) : 0;
    t = pel_clamp(t, 0, 1);
    for (int v = 0; v < VALUES; v++) {
        value[v] = b > a ? hermite(a, b, v, t) : a->value[v];
    }
    *out = (struct pel_way_pose){
        .latitude =
            atan2(value[NORMAL_Z], hypot(value[NORMAL_X], value[NORMAL_Y])) /
            PEL_DEG,
        .longitude = atan2(value[NORMAL_Y], value[NORMAL_X]) / PEL_DEG,
        .height_m = sinh(value[HEIGHT]),
        .heading_rad = value[HEADING],
        .pitch_rad = value[PITCH],
        .roll_rad = value[ROLL],
    };
}
