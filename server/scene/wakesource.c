#include "scene/wakesource.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "models/model.h"
#include "models/waterline.h"
#include "scene/geodesy.h"
#include "scene/reckon.h"
#include "scene/track.h"

#define MOST_AHEAD 150   /* points of a pose reckoned on, or of a helm */
#define LONGEST_S 64.0   /* of a piece under a helm */
#define STALE_S 8.0      /* of an epoch */
#define STALE_SHARE 0.1  /* of the shortest tile's side */
#define SETTLED 20.0     /* time constants after which a ship goes steadily */
#define SETTLED_S 3600.0 /* at most */

/* --- under a helm --------------------------------------------------------- */

struct knot {
    double time_s;
    struct pel_ship_motion motion;
};

struct pel_wake_knots {
    pthread_mutex_t lock;
    struct pel_ship_orders orders;
    double start_s, step_s, before, first_s; /* pel_ship_time; the first step */
    double settled_s; /* from then on speed and turn are steady */
    /* Of the time before, as far as they were needed. */
    size_t count, room;
    struct knot *knot;
    uint64_t steps; /* of the last */
    bool whole;     /* the last is at settled_s or later */
};

static struct pel_wake_knots *knots_of(const struct pel_ship *ship)
{
    struct pel_wake_knots *k = pel_sure_calloc(1, sizeof *k);
    k->knot = pel_sure_calloc(16, sizeof *k->knot);
    const struct pel_ship_orders *o = &ship->orders;
    double pace = fmax(fabs(o->throttle), 0.05) * o->max_speed_mps;
    double slowest = fmax(o->surge_time_s, o->turn_time * o->length_m / pace);
    pthread_mutex_init(&k->lock, NULL);
    k->orders = *o;
    k->start_s = ship->start_s;
    k->step_s = ship->step_s;
    k->before = ship->whole;
    k->first_s = pel_ship_time(ship, 1) - ship->start_s;
    k->settled_s = k->start_s + fmin(SETTLED * slowest, SETTLED_S);
    k->room = 16;
    k->count = 1;
    k->knot[0] = (struct knot){ ship->start_s, ship->start };
    return k;
}

/* Whether a chord from a to b would be too far off the arc between. */
static bool bends(const struct pel_ship_motion *a,
                  const struct pel_ship_motion *b, double seconds)
{
    double way = hypot(b->east_m - a->east_m, b->north_m - a->north_m);
    double turned = fabs(b->heading_rad - a->heading_rad);
    double gained = fabs(b->speed_mps - a->speed_mps);
    return way * turned + gained * seconds > 8.0 * PEL_TRACK_WITHIN_M;
}

/* The next point, or none: it has settled. */
static void step_on(struct pel_wake_knots *k)
{
    const struct knot *last = &k->knot[k->count - 1];
    struct pel_ship_motion m = last->motion;
    double time_s;
    uint64_t n = k->steps;
    do {
        pel_ship_steer(&k->orders, n == 0 ? k->first_s : k->step_s, &m);
        time_s = (k->before + (double)++n) * k->step_s;
    } while (!bends(&last->motion, &m, time_s - last->time_s) &&
             time_s < last->time_s + LONGEST_S && time_s < k->settled_s);
    if (k->count == k->room) {
        k->room *= 2;
        k->knot = pel_sure_realloc(k->knot, k->room * sizeof *k->knot);
    }
    k->knot[k->count++] = (struct knot){ time_s, m };
    k->steps = n;
    k->whole = time_s >= k->settled_s;
}

/* Seconds between the points of a steady motion. */
static double stride_of(double speed_mps, double turn_rate_rps)
{
    double bow = fabs(speed_mps * turn_rate_rps);
    return fmin(LONGEST_S, sqrt(8.0 * PEL_TRACK_WITHIN_M / fmax(bow, 1e-6)));
}

static void add_point(struct pel_wake_track *track, double time_s, double x,
                      double y)
{
    if (track->count == PEL_WAKE_POINTS) {
        track->count--;
        memmove(track->point, track->point + 1,
                (size_t)track->count * sizeof track->point[0]);
    }
    track->point[track->count++] = (struct pel_wake_point){ time_s, x, y };
}

/* Points j · stride_s after a pose, as many as can be seen and one after
 * until_s; `most_s`: it goes no farther. */
static void add_steady(struct pel_wake_track *track, double pose_s, double x,
                       double y, double speed_mps, double course_rad,
                       double turn_rate_rps, double until_s, double most_s)
{
    double stride = stride_of(speed_mps, turn_rate_rps);
    double after = until_s - pose_s;
    if (turn_rate_rps == 0 && isfinite(most_s)) {
        stride = most_s;
    }
    if (after < 0) {
        return;
    }
    double last = stride > 0 ? floor(fmin(after, most_s) / stride) + 1 : 0;
    for (double j = fmax(1, last - MOST_AHEAD); j <= last; j++) {
        double s = fmin(j * stride, most_s), east, north;
        pel_reckon_move(speed_mps, course_rad, turn_rate_rps, s, &east, &north);
        if (pose_s + s > track->point[track->count - 1].time_s) {
            add_point(track, pose_s + s, x + east, y + north);
        }
    }
    if (after >= most_s) { /* it is held there */
        const struct pel_wake_point *p = &track->point[track->count - 1];
        add_point(track, p->time_s + 1e9, p->x_m, p->y_m);
    }
}

static void add_knots(struct pel_wake_knots *k, double time_s,
                      struct pel_wake_track *track)
{
    pthread_mutex_lock(&k->lock);
    while (!k->whole && k->knot[k->count - 1].time_s <= time_s) {
        step_on(k);
    }
    size_t end = k->count;
    while (end > 1 && k->knot[end - 2].time_s > time_s) {
        end--;
    }
    for (size_t i = end > MOST_AHEAD ? end - MOST_AHEAD : 0; i < end; i++) {
        add_point(track, k->knot[i].time_s, k->knot[i].motion.east_m,
                  k->knot[i].motion.north_m);
    }
    struct knot last = k->knot[k->count - 1];
    bool steady = k->whole && last.time_s <= time_s;
    pthread_mutex_unlock(&k->lock);
    if (steady) {
        const struct pel_ship_motion *m = &last.motion;
        add_steady(track, last.time_s, m->east_m, m->north_m, m->speed_mps,
                   m->heading_rad, m->turn_rate_rps, time_s, HUGE_VAL);
    }
}

/* --- sources -------------------------------------------------------------- */

static double block_of(const struct pel_model *m)
{
    double volume = 0;
    for (size_t i = 0; i < m->column_count; i++) {
        volume -= (double)m->columns[i].area * (double)m->columns[i].bottom;
    }
    double box = m->length_m * m->beam_m * m->draught_m;
    return box > 0 && volume > 0 ? pel_clamp(volume / box, 0.3, 0.85) : 0.6;
}

/* The parts of a model that make waves. */
struct shape {
    uint64_t serial; /* 0: none */
    double block;
    struct pel_wake_bow bow;
};

/* Keeps the shapes of the models that this thread asked for last: rays at a
 * hull take tens of microseconds, for each edit of any ship. */
static const struct shape *shape_of(const struct pel_model *m)
{
    enum { KEPT = 16 };
    static _Thread_local struct shape kept[KEPT];
    struct shape *shape = &kept[m->serial % KEPT];
    if (shape->serial != m->serial) {
        struct pel_model_waterline line;
        *shape = (struct shape){ .serial = m->serial, .block = block_of(m) };
        if (pel_model_waterline(m, &line)) {
            struct pel_wake_bow *bow = &shape->bow;
            bow->stem_m = line.stem_m;
            bow->long_m = line.stem_m - line.stern_m;
            memcpy(bow->half_m, line.half_m, sizeof bow->half_m);
        }
    }
    return shape;
}

void pel_wake_source_read(const Pelagos__State *state,
                          const struct pel_snapshot *s, size_t index,
                          struct pel_wake_source *to)
{
    const Pelagos__Entity *e = state->entities[index];
    const struct pel_model *m = s->entities[index].model;
    const struct pel_sailing *sailing = pel_snapshot_ship(s, index);
    to->id = e->id;
    const struct shape *shape = shape_of(m);
    to->hull =
        (struct pel_hull){ m->length_m, m->beam_m, m->draught_m, shape->block };
    to->bow = shape->bow;
    to->pose = s->entities[index];
    to->reckoning_s = s->reckoning_s;
    to->knots = sailing ? knots_of(&sailing->ship) : NULL;
    double before_s = sailing ? sailing->ship.start_s : to->pose.pose_time_s;
    for (size_t k = 0; k < e->n_track && k < PEL_TRACK_MOST; k++) {
        struct pel_wake_point *p = &to->point[to->count];
        p->time_s = e->track[k]->time;
        if (p->time_s < before_s &&
            (to->count == 0 || p->time_s > p[-1].time_s)) {
            pel_geo_to_local(state->origin->latitude, state->origin->longitude,
                             e->track[k]->latitude, e->track[k]->longitude,
                             &p->x_m, &p->y_m);
            to->count++;
        }
    }
}

void pel_wake_source_finish(struct pel_wake_source *source)
{
    if (source->knots) {
        pthread_mutex_destroy(&source->knots->lock);
        free(source->knots->knot);
        free(source->knots);
    }
}

void pel_wake_source_track(const struct pel_wake_source *from, double time_s,
                           struct pel_wake_track *out)
{
    const struct pel_entity_state *e = &from->pose;
    memset(out, 0, sizeof *out); /* it is compared by its bytes */
    out->hull = from->hull;
    out->bow = from->bow;
    memcpy(out->point, from->point,
           (size_t)from->count * sizeof from->point[0]);
    out->count = from->count;
    if (from->knots) {
        add_knots(from->knots, time_s, out);
        return;
    }
    add_point(out, e->pose_time_s, e->east_m, e->north_m);
    add_steady(out, e->pose_time_s, e->east_m, e->north_m, e->speed_mps,
               e->course_rad, e->turn_rate_rps, time_s, from->reckoning_s);
}

/* The newest point of a track at or before time_s; the first. */
static const struct pel_wake_point *
point_before(const struct pel_wake_track *track, double time_s)
{
    int i = track->count - 1;
    while (i > 0 && track->point[i].time_s > time_s) {
        i--;
    }
    return &track->point[i];
}

/* Seconds in which a ship goes too far from where it was at p. */
static double stale_of(const struct pel_wake_source *from,
                       const struct pel_wake_track *track,
                       const struct pel_wake_point *p)
{
    if (p + 1 == track->point + track->count) {
        return STALE_S;
    }
    double speed =
        hypot(p[1].x_m - p->x_m, p[1].y_m - p->y_m) / (p[1].time_s - p->time_s);
    return fmin(STALE_S,
                STALE_SHARE * pel_wake_near_m(&from->hull) / fmax(speed, 0.1));
}

double pel_wake_source_epoch(const struct pel_wake_source *from,
                             const struct pel_wake_track *track, double time_s)
{
    const struct pel_wake_point *p = point_before(track, time_s);
    if (p->time_s > time_s) {
        return time_s;
    }
    double stale = stale_of(from, track, p);
    double lag = fmin(PEL_WAKE_EPOCH_LAG_S, 0.25 * stale);
    double until_s = fmax(time_s - lag, track->point[0].time_s);
    p = point_before(track, until_s);
    stale = stale_of(from, track, p);
    double apart = stale - fmin(PEL_WAKE_EPOCH_LAG_S, 0.25 * stale);
    /* A pose that a host sends with each picture is none to begin at, but the
     * point of the track before it; nor is what lies between. */
    bool pose = !from->knots && p->time_s == from->pose.pose_time_s;
    if (pose && p > track->point && p->time_s - p[-1].time_s <= 1.5 * stale) {
        p--;
    }
    bool before_pose = !from->knots && p + 1 < track->point + track->count &&
                       p[1].time_s == from->pose.pose_time_s;
    if (before_pose && until_s - p->time_s <= 1.5 * stale) {
        return p->time_s;
    }
    return p->time_s + floor((until_s - p->time_s) / apart) * apart;
}

void pel_wake_source_keep(const struct pel_wake_source *from,
                          const Pelagos__State *state, double time_s,
                          Pelagos__Entity *entity)
{
    struct pel_wake_track track;
    pel_wake_source_track(from, time_s, &track);
    pel_track_cut(entity, time_s);
    double after_s = entity->n_track > 0
                         ? entity->track[entity->n_track - 1]->time
                         : -HUGE_VAL;
    for (int i = 0; i < track.count && track.point[i].time_s < time_s; i++) {
        const struct pel_wake_point *p = &track.point[i];
        double latitude, longitude;
        if (p->time_s >= from->knots->start_s && p->time_s > after_s) {
            pel_geo_from_local(state->origin->latitude,
                               state->origin->longitude, p->x_m, p->y_m,
                               &latitude, &longitude);
            pel_track_add(entity, p->time_s, latitude, longitude);
        }
    }
}
