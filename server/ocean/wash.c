#include "ocean/wash.h"

#include <math.h>
#include <stdlib.h>

#include "base/reserve.h"
#include "ocean/foam.h"

#define OLDEST_S PEL_WASH_KEPT_S
/* What rises from the screw holds so much of the first foam at first; bubbles
 * of about a millimetre rise at so much. */
#define RISING 0.35
#define RISE_MPS 0.25
#define SCREW 0.65    /* of the draught: its diameter */
#define DENSEST 0.92  /* of the surface is foam, at most */
#define RACE_MPS 2.0  /* that makes 1 − 1/e of it */
#define INSIDE 0.03   /* of the length: the race begins inside the hull */
#define ROUGH_S 12.0  /* the boil's own waves take so long to die */
#define BEGINS_S 15.0 /* a track fades in */
#define BOW_KEPT_S 60.0
#define BEFORE 1.4    /* heights that a front breaks off the stem */
#define UNSTEADY 0.35 /* of its thickness comes and goes */
#define SHEET 0.6     /* of the streak's foam is left beside it */

enum line { AFT, ASTERN, BOW };

/* The ship as it passed. */
struct passed {
    double x, y, ex, ey; /* amidships; unit vector to the bow */
    double ahead_mps, speed_mps, push_mps;
};

static double smooth(double lo, double hi, double x)
{
    double t = pel_clamp((x - lo) / (hi - lo), 0, 1);
    return t * t * (3 - 2 * t);
}

/* --- parts ---------------------------------------------------------------- */

double pel_wash_half_m(double beam_m, double length_m, double sailed_m)
{
    return 0.5 * beam_m * pow(1 + 256 * fmax(sailed_m, 0) / length_m, 0.2);
}

void pel_wash_waterline(struct pel_wash_ship *s)
{
    s->stem_m = 0.5 * s->length_m;
    s->stern_m = -0.5 * s->length_m;
    for (int i = 0; i < PEL_WASH_STATIONS; i++) {
        double f = (i + 0.5) / PEL_WASH_STATIONS;
        double e = fmax(1 - f / 0.3, 0), r = fmax(1 - (1 - f) / 0.15, 0);
        s->half_m[i] = 0.5 * s->beam_m * (1 - e * e) * (1 - 0.4 * r * r);
    }
}

static double half_at(const struct pel_wash_ship *s, double aft_m)
{
    return pel_bow_half_m(s->half_m, s->stem_m - s->stern_m, aft_m);
}

/* The widest up to there: what was thrown aside stays where it is. */
static double widest_at(const struct pel_wash_ship *s, double aft_m)
{
    double part = (s->stem_m - s->stern_m) / PEL_WASH_STATIONS;
    double most = half_at(s, aft_m);
    for (int i = 0; i < PEL_WASH_STATIONS && (i + 0.5) * part < aft_m; i++) {
        most = fmax(most, s->half_m[i]);
    }
    return most;
}

struct pel_bow_wave pel_wash_bow(const struct pel_wash_ship *s,
                                 double speed_mps, double *alpha_rad)
{
    return pel_bow_wave_at(s->half_m, s->stem_m - s->stern_m, s->draught_m,
                           speed_mps, alpha_rad);
}

double pel_wash_race_mps(double speed_mps, double push_mps)
{
    double u = fmax(speed_mps, 0);
    return sqrt(u * u + PEL_WASH_LOADING * push_mps * push_mps) - u;
}

double pel_wash_reach_m(double race_mps, double screw_m, double age_s)
{
    double core = 6.2 * screw_m;
    double way = race_mps * age_s;
    return way <= core ? way : sqrt(core * (2 * way - core));
}

double pel_wash_foam_left(double age_s, double rising_s)
{
    double first = exp(-age_s / PEL_FOAM_LIFE_S);
    return first + RISING * rising_s / (rising_s - PEL_FOAM_LIFE_S) *
                       (exp(-age_s / rising_s) - first);
}

static double rising_s(const struct pel_wash_ship *s)
{
    return pel_clamp(s->draught_m / RISE_MPS, 6, 60);
}

/* --- where it was --------------------------------------------------------- */

static void place_at(const struct pel_wash_ship *s, double time_s, double *x,
                     double *y, int *piece)
{
    int i = 0;
    while (i + 2 < s->count && s->point[i + 1].time_s <= time_s) {
        i++;
    }
    const struct pel_wash_point *a = &s->point[i], *b = a + 1;
    double f = pel_clamp((time_s - a->time_s) / (b->time_s - a->time_s), 0, 1);
    *x = a->x_m + f * (b->x_m - a->x_m);
    *y = a->y_m + f * (b->y_m - a->y_m);
    *piece = i;
}

/* Unit vector to the bow. */
static void heading_at(const struct pel_wash_ship *s, int piece, double time_s,
                       struct passed *p)
{
    const struct pel_wash_point *a = &s->point[piece], *b = a + 1;
    double turn = remainder(b->heading_rad - a->heading_rad, 2 * PEL_PI);
    double f = pel_clamp((time_s - a->time_s) / (b->time_s - a->time_s), 0, 1);
    double h = a->heading_rad + f * turn;
    if (isnan(h)) {
        h = isnan(a->heading_rad) ? b->heading_rad : a->heading_rad;
    }
    if (isnan(h)) {
        h = atan2(b->x_m - a->x_m, b->y_m - a->y_m);
    }
    p->ex = sin(h);
    p->ey = cos(h);
}

static struct passed passed_at(const struct pel_wash_ship *s, double time_s)
{
    struct passed p;
    int piece, other;
    double first = s->point[0].time_s, last = s->point[s->count - 1].time_s;
    double x[2], y[2], from = fmax(time_s - 2, first);
    double to = fmin(time_s + 2, last);
    place_at(s, time_s, &p.x, &p.y, &piece);
    heading_at(s, piece, time_s, &p);
    place_at(s, from, &x[0], &y[0], &other);
    place_at(s, to, &x[1], &y[1], &other);
    double vx = (x[1] - x[0]) / fmax(to - from, 1e-3);
    double vy = (y[1] - y[0]) / fmax(to - from, 1e-3);
    p.speed_mps = hypot(vx, vy);
    p.ahead_mps = vx * p.ex + vy * p.ey;
    p.push_mps = s->point[piece].push_mps;
    if (isnan(p.push_mps)) {
        p.push_mps = p.ahead_mps;
    }
    return p;
}

/* --- lines ---------------------------------------------------------------- */

static enum pel_err add_node(struct pel_wash *w,
                             const struct pel_wash_node *node)
{
    if (w->count == w->room) {
        size_t room = w->room ? 2 * w->room : 256;
        struct pel_wash_node *more =
            pel_sure_realloc(w->node, room * sizeof *more);
        w->node = more;
        w->room = room;
    }
    w->node[w->count++] = *node;
    return PEL_OK;
}

struct left { /* of one moment τ */
    double passed_s, age_s, sailed_m, fade;
    double ahead; /* of the stem: 1 where the front of a bow wave may be */
    struct passed p;
};

/* Pushed aft; what the ship's own drag does not take of it goes on. */
static void leave_aft(const struct pel_wash_ship *s, const struct left *l,
                      struct pel_wash_node *n)
{
    const struct passed *p = &l->p;
    double screw = SCREW * s->draught_m, u = p->speed_mps;
    double race = pel_wash_race_mps(p->ahead_mps, p->push_mps);
    double net2 = fmax(p->push_mps * p->push_mps - u * u, 0);
    double reach =
        pel_wash_reach_m(sqrt(PEL_WASH_LOADING * net2), screw, l->age_s);
    double back = reach - s->stern_m - INSIDE * s->length_m;
    double wide = pel_wash_half_m(s->beam_m, s->length_m, l->sailed_m);
    double stirred = 1 - exp(-(u * u + race * race));
    double foam = 1 - exp(-(race / RACE_MPS) * (race / RACE_MPS));
    n->x_m = p->x - back * p->ex;
    n->y_m = p->y - back * p->ey;
    n->core_m = fmax(0.5 * wide, 0.5 * screw + 0.12 * reach);
    n->core = DENSEST * foam * l->fade *
              fmin(pel_wash_foam_left(l->age_s, rising_s(s)), 1);
    n->half_m = fmax(wide, 1.2 * n->core_m);
    n->calm = PEL_WASH_CALM * stirred * l->fade *
              (1 - exp(-l->age_s / ROUGH_S)) *
              exp(-l->age_s / PEL_WASH_CALM_LIFE_S);
    n->bubbles = foam * l->fade * exp(-l->age_s / PEL_WASH_BUBBLES_LIFE_S);
}

/* Pushed forward, along both sides of the hull. */
static void leave_astern(const struct pel_wash_ship *s, const struct left *l,
                         struct pel_wash_node *n)
{
    const struct passed *p = &l->p;
    double screw = SCREW * s->draught_m, before = 0.06 * s->length_m;
    double race = pel_wash_race_mps(0, p->push_mps);
    double reach = pel_wash_reach_m(race, screw, l->age_s);
    double along = reach - before + s->stern_m;
    double foam = (1 - exp(-(race / RACE_MPS) * (race / RACE_MPS))) *
                  smooth(0, before, reach) * l->fade;
    double left =
        DENSEST * foam * fmin(pel_wash_foam_left(l->age_s, rising_s(s)), 1);
    n->x_m = p->x + along * p->ex;
    n->y_m = p->y + along * p->ey;
    n->core_m = 0.4 * s->beam_m;
    n->core = left * (1 - smooth(0.1, 0.25, reach / s->length_m));
    n->side_half_m = 0.4 * screw + 0.08 * reach;
    n->side_m = 0.5 * s->beam_m * smooth(-before, 3 * before, reach) +
                0.5 * n->side_half_m;
    n->side = left;
    n->half_m = n->side_m + 1.5 * n->side_half_m;
    n->calm = PEL_WASH_CALM * foam * (1 - exp(-l->age_s / ROUGH_S)) *
              exp(-l->age_s / PEL_WASH_CALM_LIFE_S);
    n->bubbles = foam * exp(-l->age_s / PEL_WASH_BUBBLES_LIFE_S);
}

/* How far the front of the bow wave has gone outward from the hull: with the
 * hull's push until the wave, of period T, is spent. */
static double outward_m(double speed_mps, double alpha, double period_s,
                        double age_s)
{
    double a = fmin(alpha, 0.25 * PEL_PI);
    return speed_mps * sin(a) * cos(a) * period_s *
           (1 - exp(-age_s / period_s));
}

/* Pulses of a wave that has no steady form, in the water that met it then;
 * none where nodes are too far apart for them. */
static double pulses(double time_s, double period_s, double age_s)
{
    double seen = age_s / (2 * period_s), a = 2 * PEL_PI * time_s / period_s;
    return exp(-seen * seen) * (0.6 * sin(a) + 0.4 * sin(1.618 * a));
}

/* Thrown aside where the bow wave breaks: a streak at its front, and between
 * that and the hull what the front has left. */
static void leave_bow(const struct pel_wash_ship *s, const struct left *l,
                      struct pel_wash_node *n)
{
    const struct passed *p = &l->p;
    double alpha, u = fmax(p->ahead_mps, 0);
    struct pel_bow_wave wave = pel_wash_bow(s, u, &alpha);
    double z = wave.height_m, x = l->sailed_m;
    double reach = fmax(wave.crest_m, 0.1);
    double period = fmax(2 * PEL_PI * sqrt(z / PEL_GRAVITY), 0.5);
    double wild = smooth(1, 1.5, wave.excess);
    double before = BEFORE * wild * z; /* it breaks so far off the stem */
    double ahead = before * l->ahead;
    double pulse = UNSTEADY * wild * pulses(l->passed_s, period, l->age_s);
    /* A sheet is white from where it falls; a breaking front all along. */
    double white = fmax(smooth(0.2 * reach, 0.9 * reach, x), wild);
    double all = DENSEST * wave.breaks * white * l->fade;
    double young = period * (1 - exp(-l->age_s / period));
    double thick = z * (0.5 + 1.3 * (1 - exp(-x / (1.5 * reach))));
    double front = before * sqrt(1 - l->ahead * l->ahead) + widest_at(s, x) +
                   outward_m(u, alpha, period, l->age_s);
    n->x_m = p->x + (s->stem_m + ahead) * p->ex;
    n->y_m = p->y + (s->stem_m + ahead) * p->ey;
    n->side_half_m = 0.5 * thick * (1 + pulse) + 0.01 * s->beam_m + 0.05;
    n->side_m = front + (0.3 + 0.5 * pulse) * thick;
    n->side = all * exp(-(l->age_s - 0.7 * young) / PEL_FOAM_LIFE_S);
    n->core_m = (n->side_m + 0.1) / 0.85;
    n->core =
        SHEET * all *
        fmin(pel_wash_foam_left(l->age_s, pel_clamp(z / RISE_MPS, 5, 30)), 1);
    n->bubbles = 0.5 * all * exp(-l->age_s / BOW_KEPT_S);
    n->half_m = 0.1;
}

static void make_node(const struct pel_wash_ship *s, enum line line,
                      const struct left *l, struct pel_wash_node *n)
{
    *n = (struct pel_wash_node){ .side_half_m = 0.1 };
    switch (line) {
    case AFT:
        leave_aft(s, l, n);
        break;
    case ASTERN:
        leave_astern(s, l, n);
        break;
    case BOW:
        leave_bow(s, l, n);
        break;
    }
}

/* The age after this one: a tenth more, the track's points between. */
static double next_age(const struct pel_wash_ship *s, enum line line,
                       double time_s, double age)
{
    double next =
        line == BOW ? 1.15 * age + 0.12 : fmin(1.1 * age + 0.35, age + 30);
    for (int i = s->count - 1; i >= 0; i--) {
        double at = time_s - s->point[i].time_s;
        if (at > age + 0.05) {
            return fmin(at, next);
        }
    }
    return next;
}

static bool in_line(enum line line, const struct passed *p)
{
    return line == BOW ? p->ahead_mps > 0.5
                       : (p->push_mps < 0) == (line == ASTERN);
}

/* Towards the next, between its neighbours. */
static void set_directions(struct pel_wash *w, size_t first)
{
    for (size_t i = first; i < w->count; i++) {
        struct pel_wash_node *n = &w->node[i];
        const struct pel_wash_node *a = n->begins ? n : n - 1;
        bool ends = i + 1 == w->count || n[1].begins;
        const struct pel_wash_node *b = ends ? n : n + 1;
        double dx = b->x_m - a->x_m, dy = b->y_m - a->y_m, d = hypot(dx, dy);
        n->tx = d > 0 ? dx / d : 1;
        n->ty = d > 0 ? dy / d : 0;
    }
}

/* From the last node. */
static double apart(const struct pel_wash *w, const struct pel_wash_node *n)
{
    const struct pel_wash_node *last = w->node + w->count;
    return w->count ? hypot(n->x_m - last[-1].x_m, n->y_m - last[-1].y_m)
                    : HUGE_VAL;
}

/* Before the stem, where a bow wave breaks there: round. */
static enum pel_err add_front(struct pel_wash *w, const struct pel_wash_ship *s,
                              const struct left *at)
{
    static const double ahead[] = { 1, 0.94, 0.8, 0.5 };
    enum pel_err err = PEL_OK;
    struct left l = *at;
    for (size_t i = 0; i < sizeof ahead / sizeof *ahead && !err; i++) {
        struct pel_wash_node n;
        l.ahead = ahead[i];
        make_node(s, BOW, &l, &n);
        n.begins = i == 0;
        if (n.begins || apart(w, &n) > 0.02) {
            err = add_node(w, &n);
        }
    }
    return err;
}

static enum pel_err add_line(struct pel_wash *w, const struct pel_wash_ship *s,
                             double time_s, enum line line)
{
    double began = time_s - s->point[0].time_s, before = 0;
    double most = line == BOW ? BOW_KEPT_S : OLDEST_S;
    double end = fmin(most, began);
    struct left l = { 0 };
    size_t first = w->count;
    bool begins = true;
    enum pel_err err = PEL_OK;
    for (double age = 0; !err; age = next_age(s, line, time_s, age)) {
        age = fmin(age, end);
        struct passed p = passed_at(s, time_s - age);
        if (age > 0) {
            l.sailed_m += 0.5 * (p.speed_mps + l.p.speed_mps) * (age - before);
        }
        before = l.age_s = age;
        l.passed_s = time_s - age;
        l.p = p;
        l.fade = (1 - smooth(0.75, 1, age / most)) *
                 smooth(0, fmin(BEGINS_S, 0.5 * began), began - age);
        bool belongs = in_line(line, &p);
        if (line == BOW && age == 0 && belongs) {
            err = add_front(w, s, &l);
            begins = false;
        }
        struct pel_wash_node n;
        make_node(s, line, &l, &n);
        n.begins = begins;
        if (!belongs) {
            begins = true;
        } else if (!err && (begins || apart(w, &n) > 0.02 * s->beam_m)) {
            err = add_node(w, &n);
            begins = false;
        }
        if (age >= end) {
            break;
        }
    }
    set_directions(w, first);
    return err;
}

enum pel_err pel_wash_add(struct pel_wash *w, const struct pel_wash_ship *ship,
                          double time_s)
{
    if (ship->count < 2) {
        return PEL_OK;
    }
    enum pel_err err = add_line(w, ship, time_s, AFT);
    if (!err) {
        err = add_line(w, ship, time_s, ASTERN);
    }
    return err ? err : add_line(w, ship, time_s, BOW);
}

enum pel_err pel_wash_create(struct pel_wash **out)
{
    *out = pel_sure_calloc(1, sizeof **out);
    atomic_init(&(*out)->users, 1);
    return PEL_OK;
}

const struct pel_wash *pel_wash_ref(const struct pel_wash *w)
{
    atomic_fetch_add(&((struct pel_wash *)w)->users, 1);
    return w;
}

void pel_wash_destroy(const struct pel_wash *w)
{
    if (w && atomic_fetch_sub(&((struct pel_wash *)w)->users, 1) == 1) {
        free(w->node);
        free(w->cell);
        free(w->list);
        free((void *)w);
    }
}
