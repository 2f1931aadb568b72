#include "scene/wakes.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/lock.h"
#include "base/reserve.h"
#include "models/model.h"
#include "scene/leaving.h"
#include "scene/wakepasts.h"
#include "scene/wakesource.h"

#define MOMENTS 12
#define MOMENT_BYTES ((size_t)72 << 20)

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
    size_t index[PEL_WAKES];
    size_t count = pel_leaving_choose(state, s, "make waves", PEL_WAKES,
                                      makes_waves, index);
    if (count == 0) {
        return NULL;
    }
    struct pel_wakes *w =
        pel_sure_calloc(1, sizeof *w + count * sizeof w->source[0]);
    atomic_init(&w->refs, 1);
    w->serial = atomic_fetch_add(&serials, 1) + 1;
    w->depth_m = state->sea->has_depth ? state->sea->depth : 0;
    for (; w->count < count; w->count++) {
        pel_wake_source_read(state, s, index[w->count], &w->source[w->count]);
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

/* --- one ship at a moment ------------------------------------------------- */

static pthread_once_t once = PTHREAD_ONCE_INIT;
static pthread_mutex_t lock; /* guards the moments and uses */
static uint64_t uses;

static void begin(void)
{
    pel_lock_init(&lock);
}

static void enter(void)
{
    pthread_once(&once, begin);
    pthread_mutex_lock(&lock);
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

/* What of the track of its source counts at time_s: the whole, up to its epoch.
 */
struct course {
    struct pel_wake_track track, before;
    double epoch_s;
};

static void lay_course(const struct pel_wake_source *from, double time_s,
                       struct course *c)
{
    pel_wake_source_track(from, time_s, &c->track);
    c->epoch_s = pel_wake_source_epoch(from, &c->track, time_s);
    cut_track(&c->track, c->epoch_s, &c->before);
}

/* --- moments -------------------------------------------------------------- */

/* A ship's part of it. What is begun is some thread's, what is made everyone's.
 */
struct part {
    struct course *course;
    struct pel_wake wake;
    bool lay_begun, laid;
    bool begun[PEL_WAKE_TILES], made[PEL_WAKE_TILES];
};

struct moment {
    unsigned users; /* and the list */
    uint64_t serial, used;
    double time_s;
    size_t count, bytes;
    struct part part[PEL_WAKES];
};

static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static struct moment *moments[MOMENTS];

static void put_moment(struct moment *m) /* has the lock */
{
    if (m && --m->users == 0) {
        for (size_t i = 0; i < m->count; i++) {
            struct part *p = &m->part[i];
            for (int k = 0; k < PEL_WAKE_TILES; k++) {
                free(p->wake.tile[k].texels);
            }
            free(p->course);
        }
        free(m);
    }
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
    struct moment *m = pel_sure_calloc(1, sizeof *m);
    m->users = 1;
    m->serial = w->serial;
    m->time_s = time_s;
    m->count = w->count;
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

static struct pel_wake_kept *take_past(const struct pel_wakes *w,
                                       const struct course *c)
{
    return pel_wake_kept_take(&c->before, c->epoch_s, w->depth_m);
}

/* What its track has left in the water, and where its tiles lie; the past of
 * the epoch that follows is made meanwhile. */
static void lay(const struct pel_wakes *w, size_t i, double time_s,
                struct part *p)
{
    struct course *now = pel_sure_malloc(sizeof *now),
                  *next = pel_sure_malloc(sizeof *next);
    lay_course(&w->source[i], time_s, now);
    p->course = now;
    struct pel_wake_kept *kept = take_past(w, now);
    pel_wake_lay(pel_wake_kept_past(kept), &now->track, time_s, &p->wake);
    pel_wake_kept_put(kept);
    lay_course(&w->source[i], time_s + PEL_WAKE_EPOCH_LAG_S, next);
    if (next->epoch_s > now->epoch_s && next->epoch_s <= time_s) {
        pel_wake_kept_soon(&next->before, next->epoch_s, w->depth_m);
    }
    free(next);
}

static void fill(const struct pel_wakes *w, struct moment *m, size_t i, int k)
{
    struct part *p = &m->part[i];
    p->begun[k] = true;
    pthread_mutex_unlock(&lock);
    struct pel_wake_kept *kept = take_past(w, p->course);
    if (pel_wake_fill(pel_wake_kept_past(kept), &p->course->track, m->time_s, k,
                      &p->wake) &&
        (!pel_reserve_spend() ||
         pel_wake_fill(pel_wake_kept_past(kept), &p->course->track, m->time_s,
                       k, &p->wake))) {
        abort();
    }
    pel_wake_kept_put(kept);
    enter();
    p->made[k] = true;
    m->bytes += PEL_WAKE_TILE_BYTES;
    bound(m);
    pthread_cond_broadcast(&changed);
}

static bool wanted(const struct part *p, int k, const struct pel_box *of)
{
    return !of || pel_wake_tile_holds(&p->wake.tile[k], of->low, of->high);
}

/* The next piece of work that no thread has begun; false: there is none now. */
static bool make_some(const struct pel_wakes *w, struct moment *m,
                      const struct pel_box *of)
{
    for (size_t i = 0; i < m->count; i++) {
        struct part *p = &m->part[i];
        if (!p->lay_begun) {
            p->lay_begun = true;
            pthread_mutex_unlock(&lock);
            lay(w, i, m->time_s, p);
            enter();
            p->laid = true;
            pthread_cond_broadcast(&changed);
            return true;
        }
        for (int k = 0; p->laid && k < PEL_WAKE_TILES; k++) {
            if (!p->begun[k] && wanted(p, k, of)) {
                fill(w, m, i, k);
                return true;
            }
        }
    }
    return false;
}

static bool is_whole(const struct moment *m, const struct pel_box *of)
{
    for (size_t i = 0; i < m->count; i++) {
        const struct part *p = &m->part[i];
        if (!p->laid) {
            return false;
        }
        for (int k = 0; k < PEL_WAKE_TILES; k++) {
            if (!p->made[k] && wanted(p, k, of)) {
                return false;
            }
        }
    }
    return true;
}

static struct moment *open_moment(const struct pel_wakes *w, double time_s)
{
    struct moment *m = find_moment(w, time_s);
    m->used = ++uses;
    m->users++;
    return m;
}

/* As its user has it: what others add later is not in it. */
struct taken {
    struct pel_wake_moment public; /* first */
    struct moment *of;
};

static const struct pel_wake_moment *take(const struct pel_wakes *w,
                                          struct moment *m)
{
    struct taken *t = pel_sure_calloc(1, sizeof *t);
    t->of = m;
    t->public.count = m->count;
    for (size_t i = 0; i < m->count; i++) {
        t->public.id[i] = w->source[i].id;
        for (int k = 0; k < PEL_WAKE_TILES; k++) {
            if (m->part[i].made[k]) {
                t->public.wake[i].tile[k] = m->part[i].wake.tile[k];
            }
        }
    }
    return &t->public;
}

void pel_wake_moment_unref(const struct pel_wake_moment *moment)
{
    struct taken *t = (struct taken *)moment;
    if (t) {
        enter();
        put_moment(t->of);
        pthread_mutex_unlock(&lock);
        free(t);
    }
}

static const struct pel_wake_moment *at(const struct pel_wakes *w,
                                        double time_s, const struct pel_box *of)
{
    if (!w) {
        return NULL;
    }
    enter();
    struct moment *m = open_moment(w, time_s);
    while (!is_whole(m, of)) {
        if (!make_some(w, m, of)) {
            pthread_cond_wait(&changed, &lock);
        }
    }
    const struct pel_wake_moment *out = take(w, m);
    pthread_mutex_unlock(&lock);
    return out;
}

const struct pel_wake_moment *pel_wakes_at(const struct pel_wakes *w,
                                           double time_s)
{
    return at(w, time_s, NULL);
}

/* pel_wakes_before reads this near to its place: farther than ship waves carry
 * water. */
static struct pel_box read_by(const struct pel_box *of)
{
    const double far = 32.0; /* m */
    return (struct pel_box){ { of->low.x - far, of->low.y - far },
                             { of->high.x + far, of->high.y + far } };
}

const struct pel_wake_moment *pel_wakes_within(const struct pel_wakes *w,
                                               double time_s,
                                               const struct pel_box *of)
{
    struct pel_box read = read_by(of);
    return at(w, time_s, &read);
}

bool pel_wakes_prepare(const struct pel_wakes *w, double time_s,
                       const struct pel_box *of, bool (*go_on)(void *user),
                       void *user)
{
    if (!w) {
        return true;
    }
    struct pel_box read = read_by(of);
    enter();
    struct moment *m = open_moment(w, time_s);
    while (go_on(user) && make_some(w, m, &read)) {
    }
    bool whole = is_whole(m, &read);
    put_moment(m);
    pthread_mutex_unlock(&lock);
    return whole;
}

static void forget(uint64_t serial)
{
    enter();
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
    enter();
    for (int i = 0; i < MOMENTS; i++) {
        sum += moments[i] ? moments[i]->bytes : 0;
    }
    pthread_mutex_unlock(&lock);
    return sum + pel_wake_kept_bytes();
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
                pel_wake_add(&moment->wake[i], at.x, at.y, there);
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
