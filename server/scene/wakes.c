#include "scene/wakes.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "models/model.h"
#include "scene/geodesy.h"
#include "scene/helm.h"
#include "scene/reckon.h"

/* Tracks are summed up at whole multiples of this; between, moments follow. */
#define EPOCH_S 1.0
#define LEG_POINTS 12 /* of a turn that is reckoned on */
#define KEPT 24       /* pasts and moments */

struct source {
    struct pel_hull hull;
    struct pel_entity_state pose;
    int count;
    struct pel_wake_point point[PEL_WAKE_POINTS];
};

struct pel_wakes {
    atomic_uint refs;
    double reckoning_s, depth_m;
    size_t count;
    struct source source[];
};

/* --- of the state --------------------------------------------------------- */

static double block_of(const struct pel_model *m)
{
    double volume = 0;
    for (size_t i = 0; i < m->column_count; i++) {
        volume -= (double)m->columns[i].area * (double)m->columns[i].bottom;
    }
    double box = m->length_m * m->beam_m * m->draught_m;
    return box > 0 && volume > 0 ? pel_clamp(volume / box, 0.3, 0.85) : 0.6;
}

static bool makes_waves(const Pelagos__State *state,
                        const struct pel_snapshot *s, size_t i)
{
    const Pelagos__Entity *e = state->entities[i];
    const struct pel_model *m = s->entities[i].model;
    return e->wake && m && m->length_m > 1 && m->beam_m > 0.1 &&
           m->draught_m > 0.05 && !pel_helm_on(state, e);
}

static void read_source(const Pelagos__State *state,
                        const struct pel_snapshot *s, size_t i,
                        struct source *to)
{
    const Pelagos__Entity *e = state->entities[i];
    const struct pel_model *m = s->entities[i].model;
    to->hull =
        (struct pel_hull){ m->length_m, m->beam_m, m->draught_m, block_of(m) };
    to->pose = s->entities[i];
    for (size_t k = 0; k < e->n_track && k < PEL_WAKE_POINTS - LEG_POINTS - 2;
         k++) {
        struct pel_wake_point *p = &to->point[to->count];
        p->time_s = e->track[k]->time;
        if (p->time_s < to->pose.pose_time_s &&
            (k == 0 || p->time_s > p[-1].time_s)) {
            pel_geo_to_local(state->origin->latitude, state->origin->longitude,
                             e->track[k]->latitude, e->track[k]->longitude,
                             &p->x_m, &p->y_m);
            to->count++;
        }
    }
}

struct pel_wakes *pel_wakes_of(const Pelagos__State *state,
                               const struct pel_snapshot *s)
{
    size_t count = 0;
    for (size_t i = 0; i < state->n_entities; i++) {
        count += makes_waves(state, s, i);
    }
    if (count == 0) {
        return NULL;
    }
    if (count > PEL_WAKES) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_WARNING, "SCN-031",
                        "%zu entities make waves; those of the first %d are "
                        "there",
                        count, PEL_WAKES);
        count = PEL_WAKES;
    }
    struct pel_wakes *w = calloc(1, sizeof *w + count * sizeof w->source[0]);
    if (!w) {
        abort();
    }
    atomic_init(&w->refs, 1);
    w->reckoning_s = s->reckoning_s;
    w->depth_m = state->sea->has_depth ? state->sea->depth : 0;
    for (size_t i = 0; i < state->n_entities && w->count < count; i++) {
        if (makes_waves(state, s, i)) {
            read_source(state, s, i, &w->source[w->count++]);
        }
    }
    return w;
}

struct pel_wakes *pel_wakes_ref(struct pel_wakes *w)
{
    if (w) {
        atomic_fetch_add(&w->refs, 1);
    }
    return w;
}

void pel_wakes_unref(struct pel_wakes *w)
{
    if (w && atomic_fetch_sub(&w->refs, 1) == 1) {
        free(w);
    }
}

/* --- of a moment ---------------------------------------------------------- */

static void add_point(struct pel_wake_track *track, double time_s, double x,
                      double y)
{
    track->point[track->count++] = (struct pel_wake_point){ time_s, x, y };
}

/* The track as it is at time_s: of the past what is stored, then the pose,
 * reckoned on. */
static void track_at(const struct source *from, double reckoning_s,
                     double time_s, struct pel_wake_track *out)
{
    const struct pel_entity_state *e = &from->pose;
    memset(out, 0, sizeof *out); /* it is compared by its bytes */
    out->hull = from->hull;
    memcpy(out->point, from->point,
           (size_t)from->count * sizeof from->point[0]);
    out->count = from->count;
    add_point(out, e->pose_time_s, e->east_m, e->north_m);
    double until = pel_reckon_seconds(e->pose_time_s, time_s, reckoning_s);
    if (until <= 0) {
        return;
    }
    int steps = e->turn_rate_rps != 0 ? LEG_POINTS : 1;
    for (int i = 1; i <= steps; i++) {
        double east, north, s = until * i / steps;
        pel_reckon_move(e->speed_mps, e->course_rad, e->turn_rate_rps, s, &east,
                        &north);
        add_point(out, e->pose_time_s + s, e->east_m + east,
                  e->north_m + north);
    }
    if (time_s > e->pose_time_s + until) { /* it is held there */
        const struct pel_wake_point *last = &out->point[out->count - 1];
        add_point(out, time_s, last->x_m, last->y_m);
    }
}

struct kept_past {
    struct pel_wake_track track;
    double time_s, depth_m;
    struct pel_wake_past *past;
    uint64_t used;
};

struct moment {
    struct pel_wake_moment public; /* first */
    atomic_uint refs;
    struct pel_wakes *of;
    double time_s;
    uint64_t used;
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct kept_past *pasts[KEPT];
static struct moment *moments[KEPT];
static uint64_t uses;

static struct pel_wake_past *past_of(const struct source *from,
                                     const struct pel_wakes *w, double epoch_s)
{
    struct pel_wake_track track;
    track_at(from, w->reckoning_s, epoch_s, &track);
    int oldest = 0;
    for (int i = 0; i < KEPT; i++) {
        struct kept_past *k = pasts[i];
        if (k && k->time_s == epoch_s && k->depth_m == w->depth_m &&
            memcmp(&k->track, &track, sizeof track) == 0) {
            k->used = ++uses;
            return k->past;
        }
        if (!k || (pasts[oldest] && k->used < pasts[oldest]->used)) {
            oldest = i;
        }
    }
    struct kept_past *k = malloc(sizeof *k);
    if (!k || pel_wake_past_create(&track, epoch_s, w->depth_m, &k->past)) {
        abort();
    }
    k->track = track;
    k->time_s = epoch_s;
    k->depth_m = w->depth_m;
    k->used = ++uses;
    if (pasts[oldest]) {
        pel_wake_past_destroy(pasts[oldest]->past);
        free(pasts[oldest]);
    }
    pasts[oldest] = k;
    return k->past;
}

static struct moment *make_moment(struct pel_wakes *w, double time_s)
{
    struct moment *m = calloc(1, sizeof *m);
    if (!m) {
        abort();
    }
    atomic_init(&m->refs, 1);
    m->of = pel_wakes_ref(w);
    m->time_s = time_s;
    double epoch_s = floor(time_s / EPOCH_S) * EPOCH_S;
    for (size_t i = 0; i < w->count; i++) {
        const struct pel_wake_past *past = past_of(&w->source[i], w, epoch_s);
        if (pel_wake_later(past, time_s - epoch_s, &m->public.wake[i])) {
            abort();
        }
        m->public.count++;
    }
    return m;
}

const struct pel_wake_moment *pel_snapshot_wakes(const struct pel_snapshot *s,
                                                 double time_s)
{
    if (!s->wakes) {
        return NULL;
    }
    pthread_mutex_lock(&lock);
    struct moment *found = NULL;
    int oldest = 0;
    for (int i = 0; i < KEPT && !found; i++) {
        struct moment *m = moments[i];
        if (m && m->of == s->wakes && m->time_s == time_s) {
            found = m;
        }
        if (!m || (moments[oldest] && m->used < moments[oldest]->used)) {
            oldest = i;
        }
    }
    if (!found) {
        found = make_moment(s->wakes, time_s);
        if (moments[oldest]) {
            pel_wake_moment_unref(&moments[oldest]->public);
        }
        moments[oldest] = found;
    }
    found->used = ++uses;
    atomic_fetch_add(&found->refs, 1);
    pthread_mutex_unlock(&lock);
    return &found->public;
}

void pel_wake_moment_unref(const struct pel_wake_moment *moment)
{
    struct moment *m = (struct moment *)moment;
    if (m && atomic_fetch_sub(&m->refs, 1) == 1) {
        for (size_t i = 0; i < m->public.count; i++) {
            pel_wake_destroy(m->public.wake[i]);
        }
        pel_wakes_unref(m->of);
        free(m);
    }
}

/* --- over a place --------------------------------------------------------- */

struct pel_vec2 pel_wakes_before(const struct pel_wake_moment *moment,
                                 struct pel_vec2 place,
                                 struct pel_wake_shift *there)
{
    struct pel_vec2 at = place;
    for (int step = 0; step < 20; step++) {
        *there = (struct pel_wake_shift){ 0 };
        for (size_t i = 0; i < moment->count; i++) {
            pel_wake_add(moment->wake[i], at.x, at.y, there);
        }
        double ex = at.x + there->d.x - place.x;
        double ey = at.y + there->d.y - place.y;
        if (fabs(ex) + fabs(ey) < 1e-6) {
            break;
        }
        at.x -= ex;
        at.y -= ey;
    }
    return at;
}

void pel_wakes_onto(const struct pel_wake_shift *w,
                    struct pel_surface_sample *sample)
{
    double gx = w->hx - sample->normal.x / sample->normal.z;
    double gy = w->hy - sample->normal.y / sample->normal.z;
    double a = 1 + w->dxx, b = w->dxy, c = w->dyx, d = 1 + w->dyy;
    double det = fmax(a * d - b * c, 0.05);
    struct pel_vec3 normal = { -(d * gx - c * gy) / det,
                               -(a * gy - b * gx) / det, 1 };
    sample->normal = pel_vec3_normalize(normal);
    sample->height_m += w->d.z;
    sample->velocity_mps.z += w->rise_mps;
}
