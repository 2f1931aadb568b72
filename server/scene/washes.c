#include "scene/washes.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/lock.h"
#include "base/reserve.h"
#include "models/waterline.h"
#include "scene/build.h"
#include "scene/geodesy.h"
#include "scene/helm.h"
#include "scene/leaving.h"
#include "scene/reckon.h"
#include "scene/track.h"

#define LEG_POINTS 12 /* of a turn that is reckoned on */

_Static_assert(PEL_WATERLINE_PARTS == PEL_WASH_STATIONS, "one waterline");
_Static_assert(PEL_TRACK_MOST + PEL_SHIP_TRAIL + LEG_POINTS + 2 <=
                   PEL_WASH_POINTS,
               "room for a track");

struct source {
    size_t entity;             /* in the snapshot */
    struct pel_wash_ship ship; /* of the points those of the state */
};

struct pel_washes {
    atomic_uint refs;
    double latitude, longitude; /* of the origin, deg */
    size_t count;
    struct source source[];
};

/* --- of the state --------------------------------------------------------- */

static bool read_hull(const Pelagos__State *state, const Pelagos__Entity *e,
                      const struct pel_model *m, struct pel_wash_ship *to)
{
    const Pelagos__OwnShip *helm = pel_helm_on(state, e);
    struct pel_model_waterline line;
    if (m && m->length_m > 1 && m->beam_m > 0.1 && m->draught_m > 0.05) {
        to->length_m = m->length_m;
        to->beam_m = m->beam_m;
        to->draught_m = m->draught_m;
    } else if (helm) {
        to->length_m = helm->length;
        to->beam_m = helm->beam;
        to->draught_m = helm->beam / 2.5;
    } else {
        return false;
    }
    pel_wash_waterline(to);
    if (m && pel_model_waterline(m, &line)) {
        to->stem_m = line.stem_m;
        to->stern_m = line.stern_m;
        memcpy(to->half_m, line.half_m, sizeof to->half_m);
    }
    return true;
}

static struct pel_wash_point point_of(double latitude, double longitude,
                                      const Pelagos__TrackPoint *p)
{
    struct pel_wash_point out = { .time_s = p->time,
                                  .heading_rad = NAN,
                                  .push_mps = p->has_push ? p->push : NAN };
    pel_geo_to_local(latitude, longitude, p->latitude, p->longitude, &out.x_m,
                     &out.y_m);
    if (p->has_heading) {
        double turned =
            pel_geo_convergence(latitude, longitude, p->latitude, p->longitude);
        out.heading_rad = p->heading * PEL_DEG + turned;
    }
    return out;
}

/* False: it comes no later than the last. */
static bool add(struct pel_wash_ship *s, const struct pel_wash_point *p)
{
    if (s->count > 0 && !(p->time_s > s->point[s->count - 1].time_s)) {
        return false;
    }
    s->point[s->count++] = *p;
    return true;
}

static void read_track(const Pelagos__State *state, const Pelagos__Entity *e,
                       struct pel_wash_ship *to)
{
    to->count = 0;
    for (size_t k = 0; k < e->n_track && k < PEL_TRACK_MOST; k++) {
        struct pel_wash_point p = point_of(
            state->origin->latitude, state->origin->longitude, e->track[k]);
        (void)add(to, &p);
    }
}

static bool leaves_wash(const Pelagos__State *state,
                        const struct pel_snapshot *s, size_t i)
{
    struct pel_wash_ship ship;
    const Pelagos__Entity *e = state->entities[i];
    return e->wash && read_hull(state, e, s->entities[i].model, &ship);
}

struct pel_washes *pel_washes_of(const Pelagos__State *state,
                                 const struct pel_snapshot *s)
{
    size_t index[PEL_WASHES];
    size_t count = pel_leaving_choose(state, s, "leave a wash", PEL_WASHES,
                                      leaves_wash, index);
    if (count == 0) {
        return NULL;
    }
    struct pel_washes *w =
        pel_sure_calloc(1, sizeof *w + count * sizeof w->source[0]);
    atomic_init(&w->refs, 1);
    w->latitude = state->origin->latitude;
    w->longitude = state->origin->longitude;
    for (; w->count < count; w->count++) {
        struct source *to = &w->source[w->count];
        const Pelagos__Entity *e = state->entities[index[w->count]];
        to->entity = index[w->count];
        (void)read_hull(state, e, s->entities[to->entity].model, &to->ship);
        read_track(state, e, &to->ship);
    }
    return w;
}

struct pel_washes *pel_washes_ref(struct pel_washes *w)
{
    if (w) {
        atomic_fetch_add(&w->refs, 1);
    }
    return w;
}

void pel_washes_unref(struct pel_washes *w)
{
    if (w && atomic_fetch_sub(&w->refs, 1) == 1) {
        free(w);
    }
}

/* --- of a moment ---------------------------------------------------------- */

/* The pose, reckoned on as others see it. */
static void go_on(const struct pel_snapshot *s,
                  const struct pel_entity_state *e, double time_s,
                  struct pel_wash_ship *to)
{
    double until = pel_reckon_seconds(e->pose_time_s, time_s, s->reckoning_s);
    int steps = until <= 0 ? 0 : e->turn_rate_rps != 0 ? LEG_POINTS : 1;
    struct pel_wash_point p = { e->pose_time_s, e->east_m, e->north_m,
                                e->heading_rad, NAN };
    (void)add(to, &p);
    for (int i = 1; i <= steps; i++) {
        double east, north, after = until * i / steps;
        pel_reckon_move(e->speed_mps, e->course_rad, e->turn_rate_rps, after,
                        &east, &north);
        p.time_s = e->pose_time_s + after;
        p.x_m = e->east_m + east;
        p.y_m = e->north_m + north;
        p.heading_rad = e->heading_rad + e->turn_rate_rps * after;
        (void)add(to, &p);
    }
    p.time_s = time_s; /* it is held there */
    (void)add(to, &p);
}

/* As the state would have it: the way there and back rounds. */
static struct pel_wash_point mark_point(const struct pel_washes *w,
                                        const struct pel_ship *ship,
                                        const struct pel_ship_mark *m)
{
    Pelagos__TrackPoint p = PELAGOS__TRACK_POINT__INIT;
    pel_ship_mark_to_state(w->latitude, w->longitude, ship, m, &p);
    return point_of(w->latitude, w->longitude, &p);
}

static void sail_on(const struct pel_washes *w, const struct pel_snapshot *s,
                    const struct pel_sailing *sailing, double time_s,
                    struct pel_wash_ship *to)
{
    const struct pel_ship *ship = &sailing->ship;
    struct pel_ship_mark mark[PEL_SHIP_TRAIL];
    int count = pel_ship_trail(ship, time_s, mark);
    while (to->count > 0 && count > 0 &&
           to->point[to->count - 1].time_s > mark[0].time_s - 1e-9) {
        to->count--; /* what the state has of this run */
    }
    for (int i = 0; i < count; i++) {
        struct pel_wash_point p = mark_point(w, ship, &mark[i]);
        (void)add(to, &p);
    }
    struct pel_ship_motion m;
    pel_snapshot_ship_motion(s, ship, time_s, &m);
    struct pel_wash_point now = { time_s, m.east_m, m.north_m, m.heading_rad,
                                  ship->orders.throttle *
                                      ship->orders.max_speed_mps };
    (void)add(to, &now);
}

static const struct pel_wash *make_wash(const struct pel_snapshot *s,
                                        double time_s)
{
    const struct pel_washes *w = s->washes;
    struct pel_wash *wash;
    if (pel_wash_create(&wash)) {
        abort();
    }
    for (size_t i = 0; i < w->count; i++) {
        struct pel_wash_ship ship = w->source[i].ship;
        size_t entity = w->source[i].entity;
        const struct pel_sailing *sailing = pel_snapshot_ship(s, entity);
        while (ship.count > 0 && ship.point[ship.count - 1].time_s >= time_s) {
            ship.count--;
        }
        if (sailing) {
            sail_on(w, s, sailing, time_s, &ship);
        } else {
            go_on(s, &s->entities[entity], time_s, &ship);
        }
        if (pel_wash_add(wash, &ship, time_s)) {
            abort();
        }
    }
    if (pel_wash_index(wash)) {
        abort();
    }
    return wash;
}

/* Moments that are asked for at a time: of queries' slices, of a frame. */
#define MOMENTS 3

struct pel_wash_moments {
    pthread_mutex_t lock;
    int next;
    double time_s[MOMENTS];
    const struct pel_wash *wash[MOMENTS];
};

struct pel_wash_moments *pel_wash_moments_of(const struct pel_washes *washes)
{
    if (!washes) {
        return NULL;
    }
    struct pel_wash_moments *m = pel_sure_calloc(1, sizeof *m);
    pel_lock_init(&m->lock);
    return m;
}

void pel_wash_moments_destroy(struct pel_wash_moments *m)
{
    if (m) {
        for (int i = 0; i < MOMENTS; i++) {
            pel_wash_destroy(m->wash[i]);
        }
        pthread_mutex_destroy(&m->lock);
        free(m);
    }
}

const struct pel_wash *pel_snapshot_wash(const struct pel_snapshot *s,
                                         double time_s)
{
    struct pel_wash_moments *m = s->wash_moments;
    if (!s->washes || !m) {
        return s->washes ? make_wash(s, time_s) : NULL;
    }
    pthread_mutex_lock(&m->lock);
    int i = 0;
    while (i < MOMENTS && (!m->wash[i] || m->time_s[i] != time_s)) {
        i++;
    }
    if (i == MOMENTS) {
        i = m->next;
        m->next = (m->next + 1) % MOMENTS;
        pel_wash_destroy(m->wash[i]);
        m->wash[i] = make_wash(s, time_s);
        m->time_s[i] = time_s;
    }
    const struct pel_wash *wash = pel_wash_ref(m->wash[i]);
    pthread_mutex_unlock(&m->lock);
    return wash;
}
