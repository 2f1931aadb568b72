#include "scene/wakes.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "models/model.h"
#include "scene/wakesource.h"

#define MOMENTS 12
#define PASTS 9
#define MOMENT_BYTES ((size_t)48 << 20)

struct pel_wakes {
    atomic_uint refs;
    uint64_t serial; /* of no other */
    double depth_m;
    size_t count;
    struct pel_wake_source source[];
};

/* --- of the state --------------------------------------------------------- */

static bool makes_waves(const Pelagos__State *state,
                        const struct pel_snapshot *s, size_t i)
{
    const Pelagos__Entity *e = state->entities[i];
    const struct pel_model *m = s->entities[i].model;
    return e->wake && m && m->length_m > 1 && m->beam_m > 0.1 &&
           m->draught_m > 0.05;
}

struct pel_wakes *pel_wakes_of(const Pelagos__State *state,
                               const struct pel_snapshot *s)
{
    static atomic_ullong serials;
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
    w->serial = atomic_fetch_add(&serials, 1) + 1;
    w->depth_m = state->sea->has_depth ? state->sea->depth : 0;
    for (size_t i = 0; i < state->n_entities && w->count < count; i++) {
        if (makes_waves(state, s, i)) {
            pel_wake_source_read(state, s, i, &w->source[w->count++]);
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

static void forget(uint64_t serial);

void pel_wakes_unref(struct pel_wakes *w)
{
    if (w && atomic_fetch_sub(&w->refs, 1) == 1) {
        forget(w->serial);
        for (size_t i = 0; i < w->count; i++) {
            pel_wake_source_finish(&w->source[i]);
        }
        free(w);
    }
}

void pel_wakes_keep(const struct pel_wakes *w, const Pelagos__State *state,
                    double time_s, Pelagos__Entity *entity)
{
    for (size_t i = 0; w && i < w->count; i++) {
        if (w->source[i].id == entity->id && w->source[i].knots) {
            pel_wake_source_keep(&w->source[i], state, time_s, entity);
        }
    }
}

/* --- pasts ---------------------------------------------------------------- */

/* Kept for all scenes: what they were made from says which they are. Whoever
 * finds one that is not made yet waits. */
struct past {
    struct pel_wake_track track; /* up to its moment */
    double time_s, depth_m;
    unsigned users; /* and the list */
    uint64_t used;
    pthread_mutex_t making;
    struct pel_wake_past *past;
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct past *pasts[PASTS];
static uint64_t uses;

static void put_past(struct past *p) /* has the lock */
{
    if (p && --p->users == 0) {
        pel_wake_past_destroy(p->past);
        pthread_mutex_destroy(&p->making);
        free(p);
    }
}

/* The track up to a moment, with a point there; the same bytes of all that are
 * alike so far. */
static void cut_track(const struct pel_wake_track *from, double time_s,
                      struct pel_wake_track *out)
{
    memset(out, 0, sizeof *out);
    out->hull = from->hull;
    for (int i = 0; i < from->count && from->point[i].time_s <= time_s; i++) {
        out->point[out->count++] = from->point[i];
    }
    int n = out->count;
    if (n > 0 && n < from->count && from->point[n - 1].time_s < time_s) {
        const struct pel_wake_point *a = &from->point[n - 1], *b = a + 1;
        double f = (time_s - a->time_s) / (b->time_s - a->time_s);
        out->point[out->count++] =
            (struct pel_wake_point){ time_s, a->x_m + f * (b->x_m - a->x_m),
                                     a->y_m + f * (b->y_m - a->y_m) };
    }
}

static struct past *find_past(const struct pel_wake_track *track, double time_s,
                              double depth_m)
{
    int oldest = 0;
    for (int i = 0; i < PASTS; i++) {
        struct past *p = pasts[i];
        if (p && p->time_s == time_s && p->depth_m == depth_m &&
            memcmp(&p->track, track, sizeof *track) == 0) {
            return p;
        }
        if (!p || (pasts[oldest] && p->used < pasts[oldest]->used)) {
            oldest = i;
        }
    }
    struct past *p = calloc(1, sizeof *p);
    if (!p) {
        abort();
    }
    p->track = *track;
    p->time_s = time_s;
    p->depth_m = depth_m;
    p->users = 1;
    pthread_mutex_init(&p->making, NULL);
    put_past(pasts[oldest]);
    pasts[oldest] = p;
    return p;
}

/* The waves of one ship at time_s. */
static struct pel_wake *make_wake(const struct pel_wakes *w, size_t i,
                                  double time_s)
{
    struct pel_wake_track track, before;
    struct pel_wake *wake;
    pel_wake_source_track(&w->source[i], time_s, &track);
    double epoch_s = pel_wake_source_epoch(&w->source[i], &track, time_s);
    cut_track(&track, epoch_s, &before);
    pthread_mutex_lock(&lock);
    struct past *p = find_past(&before, epoch_s, w->depth_m);
    p->used = ++uses;
    p->users++;
    pthread_mutex_unlock(&lock);
    pthread_mutex_lock(&p->making);
    if (!p->past &&
        pel_wake_past_create(&p->track, epoch_s, w->depth_m, &p->past)) {
        abort();
    }
    pthread_mutex_unlock(&p->making);
    if (pel_wake_later(p->past, &track, time_s, &wake)) {
        abort();
    }
    pthread_mutex_lock(&lock);
    put_past(p);
    pthread_mutex_unlock(&lock);
    return wake;
}

/* --- moments -------------------------------------------------------------- */

struct moment {
    struct pel_wake_moment public; /* first */
    unsigned users;
    uint64_t serial, used;
    double time_s;
    size_t begun, made, bytes;
};

static pthread_cond_t made = PTHREAD_COND_INITIALIZER;
static struct moment *moments[MOMENTS];

static void put_moment(struct moment *m) /* has the lock */
{
    if (m && --m->users == 0) {
        for (size_t i = 0; i < m->public.count; i++) {
            pel_wake_destroy(m->public.wake[i]);
        }
        free(m);
    }
}

void pel_wake_moment_unref(const struct pel_wake_moment *moment)
{
    pthread_mutex_lock(&lock);
    put_moment((struct moment *)moment);
    pthread_mutex_unlock(&lock);
}

static struct moment *find_moment(const struct pel_wakes *w, double time_s)
{
    int oldest = 0;
    for (int i = 0; i < MOMENTS; i++) {
        struct moment *m = moments[i];
        if (m && m->serial == w->serial && m->time_s == time_s) {
            return m;
        }
        if (!m || (moments[oldest] && m->used < moments[oldest]->used)) {
            oldest = i;
        }
    }
    struct moment *m = calloc(1, sizeof *m);
    if (!m) {
        abort();
    }
    m->users = 1;
    m->serial = w->serial;
    m->time_s = time_s;
    m->public.count = w->count;
    for (size_t i = 0; i < w->count; i++) {
        m->public.id[i] = w->source[i].id;
    }
    put_moment(moments[oldest]);
    moments[oldest] = m;
    return m;
}

/* Lets go of those not used for longest while all take too much. */
static void bound(const struct moment *but)
{
    for (;;) {
        size_t sum = 0;
        int oldest = -1;
        for (int i = 0; i < MOMENTS; i++) {
            sum += moments[i] ? moments[i]->bytes : 0;
            if (moments[i] && moments[i] != but && moments[i]->bytes > 0 &&
                (oldest < 0 || moments[i]->used < moments[oldest]->used)) {
                oldest = i;
            }
        }
        if (sum <= MOMENT_BYTES || oldest < 0) {
            return;
        }
        put_moment(moments[oldest]);
        moments[oldest] = NULL;
    }
}

/* Threads that want the same moment share its ships. */
static void make_moment(const struct pel_wakes *w, struct moment *m)
{
    while (m->begun < m->public.count) {
        size_t i = m->begun++;
        pthread_mutex_unlock(&lock);
        struct pel_wake *wake = make_wake(w, i, m->time_s);
        pthread_mutex_lock(&lock);
        m->public.wake[i] = wake;
        for (int k = 0; k < PEL_WAKE_TILES; k++) {
            m->bytes += wake->tile[k].texels ? PEL_WAKE_TILE_BYTES : 0;
        }
        if (++m->made == m->public.count) {
            pthread_cond_broadcast(&made);
            bound(m);
        }
    }
    while (m->made < m->public.count) {
        pthread_cond_wait(&made, &lock);
    }
}

const struct pel_wake_moment *pel_wakes_at(const struct pel_wakes *w,
                                           double time_s)
{
    if (!w) {
        return NULL;
    }
    pthread_mutex_lock(&lock);
    struct moment *m = find_moment(w, time_s);
    m->used = ++uses;
    m->users++;
    make_moment(w, m);
    pthread_mutex_unlock(&lock);
    return &m->public;
}

static void forget(uint64_t serial)
{
    pthread_mutex_lock(&lock);
    for (int i = 0; i < MOMENTS; i++) {
        if (moments[i] && moments[i]->serial == serial) {
            put_moment(moments[i]);
            moments[i] = NULL;
        }
    }
    pthread_mutex_unlock(&lock);
}

size_t pel_wakes_bytes(void)
{
    size_t sum = 0;
    pthread_mutex_lock(&lock);
    for (int i = 0; i < MOMENTS; i++) {
        sum += moments[i] ? moments[i]->bytes : 0;
    }
    for (int i = 0; i < PASTS; i++) {
        sum += pasts[i] && pasts[i]->past ? pel_wake_past_bytes(pasts[i]->past)
                                          : 0;
    }
    pthread_mutex_unlock(&lock);
    return sum;
}

/* --- over a place --------------------------------------------------------- */

bool pel_wakes_reach(const struct pel_wakes *w, int64_t but, double time_s,
                     struct pel_vec2 place, double radius_m)
{
    for (size_t i = 0; w && i < w->count; i++) {
        struct pel_wake_track track;
        if (w->source[i].id != but) {
            pel_wake_source_track(&w->source[i], time_s, &track);
            if (pel_wake_reaches(&track, time_s, w->depth_m, place.x, place.y,
                                 radius_m)) {
                return true;
            }
        }
    }
    return false;
}

struct pel_vec2 pel_wakes_before(const struct pel_wake_moment *moment,
                                 int64_t but, struct pel_vec2 place,
                                 struct pel_wake_shift *there)
{
    struct pel_vec2 at = place;
    for (int step = 0; step < 20; step++) {
        *there = (struct pel_wake_shift){ 0 };
        for (size_t i = 0; i < moment->count; i++) {
            if (moment->id[i] != but) {
                pel_wake_add(moment->wake[i], at.x, at.y, there);
            }
        }
        double ex = at.x + there->d.x - place.x;
        double ey = at.y + there->d.y - place.y;
        if (fabs(ex) + fabs(ey) < 1e-5) { /* m */
            break;
        }
        /* Newton's step. */
        double a = 1 + there->dxx, d = 1 + there->dyy;
        double det = fmax(a * d - there->dxy * there->dyx, 0.2);
        at.x -= (d * ex - there->dxy * ey) / det;
        at.y -= (a * ey - there->dyx * ex) / det;
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
