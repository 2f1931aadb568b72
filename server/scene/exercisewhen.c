#include "scene/exercisewhen.h"

#include <glib.h>
#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "models/model.h"
#include "scene/exercise_parts.h"
#include "scene/geodesy.h"
#include "scene/helm.h"

#define WGS84_A 6378137.0
#define WGS84_E2 0.00669437999014
#define HULL_CORNERS 5
#define HELM_DRAUGHT 0.4 /* of the beam, as scene/ship.h has it */

void pel_exercise_moment_init(struct pel_exercise_moment *m,
                              const Pelagos__Exercise *exercise,
                              const Pelagos__State *state,
                              const struct pel_snapshot *snapshot,
                              double clock_s, double time_s)
{
    memset(m, 0, sizeof *m);
    m->exercise = exercise;
    m->state = state;
    m->snapshot = snapshot;
    m->clock_s = clock_s;
    m->time_s = time_s;
}

const Pelagos__ExerciseDone *pel_exercise_done(const Pelagos__ExerciseRun *run,
                                               const char *event)
{
    for (size_t i = 0; i < run->n_events; i++) {
        if (run->events[i]->event &&
            strcmp(run->events[i]->event, event) == 0) {
            return run->events[i];
        }
    }
    return NULL;
}

/* --- bodies --------------------------------------------------------------- */

static void measure(const struct pel_exercise_moment *m, size_t index,
                    struct pel_exercise_body *body)
{
    const struct pel_snapshot *s = m->snapshot;
    const struct pel_model *model = s->entities[index].model;
    const Pelagos__OwnShip *helm =
        index < m->state->n_entities
            ? pel_helm_on(m->state, m->state->entities[index])
            : NULL;
    if (model) {
        body->length_m = model->length_m;
        body->beam_m = model->beam_m;
        body->draught_m = model->draught_m;
    } else if (helm) {
        body->length_m = helm->length;
        body->beam_m = helm->beam;
        body->draught_m = HELM_DRAUGHT * helm->beam;
    }
    double draught = pel_exercise_draught(m->exercise, s->entities[index].id);
    if (!isnan(draught)) {
        body->draught_m = draught;
    }
}

static void look(const struct pel_exercise_moment *m, size_t index,
                 struct pel_exercise_body *body)
{
    const struct pel_snapshot *s = m->snapshot;
    struct pel_entity_state e;
    pel_snapshot_entity_level(s, index, m->clock_s, &e);
    body->known = PEL_BODY_THERE;
    body->east_m = e.east_m;
    body->north_m = e.north_m;
    body->heading_rad = e.heading_rad;
    body->course_rad = e.course_rad;
    body->speed_mps = e.speed_mps;
    body->turn_rps = e.turn_rate_rps;
    pel_geo_from_local(s->origin_latitude_rad / PEL_DEG,
                       s->origin_longitude_rad / PEL_DEG, e.east_m, e.north_m,
                       &body->latitude, &body->longitude);
    measure(m, index, body);
}

const struct pel_exercise_body *
pel_exercise_body_of(struct pel_exercise_moment *m, uint32_t id)
{
    for (size_t i = 0; i < m->snapshot->entity_count; i++) {
        if (m->snapshot->entities[i].id == id) {
            if (m->bodies[i].known == PEL_BODY_UNASKED) {
                look(m, i, &m->bodies[i]);
            }
            return &m->bodies[i];
        }
    }
    return NULL;
}

double pel_exercise_range(const struct pel_exercise_body *a,
                          const struct pel_exercise_body *b)
{
    return hypot(b->east_m - a->east_m, b->north_m - a->north_m);
}

void pel_exercise_cpa(const struct pel_exercise_body *a,
                      const struct pel_exercise_body *b, double *cpa_m,
                      double *tcpa_s)
{
    double x = b->east_m - a->east_m, y = b->north_m - a->north_m;
    double u =
        b->speed_mps * sin(b->course_rad) - a->speed_mps * sin(a->course_rad);
    double v =
        b->speed_mps * cos(b->course_rad) - a->speed_mps * cos(a->course_rad);
    double square = u * u + v * v;
    *tcpa_s = square > 1e-6 ? -(x * u + y * v) / square : 0;
    *cpa_m = hypot(x + u * *tcpa_s, y + v * *tcpa_s);
}

double pel_exercise_under_keel(const struct pel_exercise_moment *m,
                               const struct pel_exercise_body *body)
{
    return pel_snapshot_depth(m->snapshot, body->east_m, body->north_m) +
           m->snapshot->sea_level_m - body->draught_m;
}

/* --- hulls ---------------------------------------------------------------- */

/* Corners in the plane, in the order of the hull's rim. */
static int outline(const struct pel_exercise_body *b,
                   struct pel_vec2 out[HULL_CORNERS])
{
    double l = b->length_m / 2, w = b->beam_m / 2;
    bool ship = b->length_m >= 3 * b->beam_m;
    double forward[HULL_CORNERS] = { -l, -l, ship ? l / 2 : l, l,
                                     ship ? l / 2 : l };
    double right[HULL_CORNERS] = { -w, w, w, ship ? 0 : -w, -w };
    double s = sin(b->heading_rad), c = cos(b->heading_rad);
    int count = ship ? 5 : 4;
    for (int i = 0; i < count; i++) {
        out[i].x = b->east_m + forward[i] * s + right[i] * c;
        out[i].y = b->north_m + forward[i] * c - right[i] * s;
    }
    return count;
}

static double cross(struct pel_vec2 o, struct pel_vec2 a, struct pel_vec2 b)
{
    return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

/* Of a convex rim that goes clockwise, seen from above. */
static bool within(struct pel_vec2 p, const struct pel_vec2 *rim, int count)
{
    bool left = false, right = false;
    for (int i = 0; i < count; i++) {
        double side = cross(rim[i], rim[(i + 1) % count], p);
        left = left || side > 0;
        right = right || side < 0;
    }
    return !(left && right);
}

/* Those that only touch are no distance apart (from_edge). */
static bool cuts(struct pel_vec2 a, struct pel_vec2 b, struct pel_vec2 c,
                 struct pel_vec2 d)
{
    return cross(a, b, c) * cross(a, b, d) < 0 &&
           cross(c, d, a) * cross(c, d, b) < 0;
}

static double from_edge(struct pel_vec2 p, struct pel_vec2 a, struct pel_vec2 b)
{
    double x = b.x - a.x, y = b.y - a.y;
    double square = x * x + y * y;
    double t = square > 0 ? ((p.x - a.x) * x + (p.y - a.y) * y) / square : 0;
    t = pel_clamp(t, 0, 1);
    return hypot(a.x + t * x - p.x, a.y + t * y - p.y);
}

double pel_exercise_hulls(const struct pel_exercise_body *a,
                          const struct pel_exercise_body *b)
{
    struct pel_vec2 p[HULL_CORNERS], q[HULL_CORNERS];
    if (a->length_m <= 0 || b->length_m <= 0) {
        return NAN;
    }
    int n = outline(a, p), k = outline(b, q);
    double least = INFINITY;
    if (within(p[0], q, k) || within(q[0], p, n)) {
        return 0;
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < k; j++) {
            struct pel_vec2 p1 = p[(i + 1) % n], q1 = q[(j + 1) % k];
            if (cuts(p[i], p1, q[j], q1)) {
                return 0;
            }
            least = fmin(least, from_edge(p[i], q[j], q1));
            least = fmin(least, from_edge(q[j], p[i], p1));
        }
    }
    return least;
}

/* --- areas ---------------------------------------------------------------- */

int pel_exercise_corners(const char *text, double out[PEL_EXERCISE_CORNERS][2])
{
    int count = 0;
    for (const char *at = text;; at++) {
        char *end;
        if (count == PEL_EXERCISE_CORNERS) {
            return -1;
        }
        for (int i = 0; i < 2; i++) {
            out[count][i] = g_ascii_strtod(at, &end);
            if (end == at || !isfinite(out[count][i]) ||
                fabs(out[count][i]) > (i ? 180 : 90)) {
                return -1;
            }
            at = end;
        }
        count++;
        at += strspn(at, " ");
        if (!*at) {
            return count >= 3 ? count : -1;
        }
        if (*at != ',') {
            return -1;
        }
    }
}

/* Degrees of longitude, by the shorter way. */
static double eastward(double from, double to)
{
    return remainder(to - from, 360);
}

static bool in_polygon(const char *corners, double latitude, double longitude)
{
    double c[PEL_EXERCISE_CORNERS][2];
    int count = pel_exercise_corners(corners, c);
    bool in = false;
    for (int i = 0, j = count - 1; i < count; j = i++) {
        double xi = eastward(longitude, c[i][1]);
        double xj = eastward(longitude, c[j][1]);
        if ((c[i][0] > latitude) != (c[j][0] > latitude) &&
            0 < (xj - xi) * (latitude - c[i][0]) / (c[j][0] - c[i][0]) + xi) {
            in = !in;
        }
    }
    return in;
}

/* On the ellipsoid's sphere of curvature at the circle's centre: to 1e-4 of
 * the radius for circles of some ten miles. */
static bool in_circle(const Pelagos__ExerciseArea *area, double latitude,
                      double longitude)
{
    double phi = area->latitude * PEL_DEG;
    double w = 1 - WGS84_E2 * sin(phi) * sin(phi);
    double prime = WGS84_A / sqrt(w);
    double meridian = prime * (1 - WGS84_E2) / w;
    double north = (latitude - area->latitude) * PEL_DEG * meridian;
    double east = eastward(area->longitude, longitude) * PEL_DEG * prime *
                  cos((phi + latitude * PEL_DEG) / 2);
    return hypot(east, north) <= area->radius;
}

bool pel_exercise_in_area(const Pelagos__ExerciseArea *area, double latitude,
                          double longitude)
{
    return !area           ? true
           : area->corners ? in_polygon(area->corners, latitude, longitude)
                           : in_circle(area, latitude, longitude);
}

/* --- conditions ----------------------------------------------------------- */

static bool is_placed(const Pelagos__ExerciseWhen *w,
                      const struct pel_exercise_body *b)
{
    if ((w->has_north_of && !(b->latitude > w->north_of)) ||
        (w->has_south_of && !(b->latitude < w->south_of)) ||
        (w->has_east_of && !(eastward(w->east_of, b->longitude) > 0)) ||
        (w->has_west_of && !(eastward(w->west_of, b->longitude) < 0))) {
        return false;
    }
    return (!w->inside ||
            pel_exercise_in_area(w->inside, b->latitude, b->longitude)) &&
           (!w->outside ||
            !pel_exercise_in_area(w->outside, b->latitude, b->longitude));
}

static bool is_near(struct pel_exercise_moment *m,
                    const Pelagos__ExerciseWhen *w,
                    const struct pel_exercise_body *b)
{
    const struct pel_exercise_body *other = pel_exercise_body_of(m, w->other);
    double cpa, tcpa;
    if (!other) {
        return false;
    }
    double range = pel_exercise_range(b, other);
    pel_exercise_cpa(b, other, &cpa, &tcpa);
    return (!w->has_range_below || range < w->range_below) &&
           (!w->has_range_above || range > w->range_above) &&
           (!w->has_cpa_below || (cpa < w->cpa_below && tcpa > 0)) &&
           (!w->has_tcpa_below || (tcpa < w->tcpa_below && tcpa > 0));
}

static bool is_about(struct pel_exercise_moment *m,
                     const Pelagos__ExerciseWhen *w)
{
    bool moves = w->has_speed_below || w->has_speed_above;
    bool places = w->has_north_of || w->has_south_of || w->has_east_of ||
                  w->has_west_of || w->inside || w->outside;
    if (!moves && !places && !w->has_other && !w->has_under_keel_below) {
        return true;
    }
    const struct pel_exercise_body *b = pel_exercise_body_of(
        m, w->has_entity ? w->entity : m->exercise->own_ship);
    if (!b || !is_placed(w, b) ||
        (w->has_speed_below && !(b->speed_mps < w->speed_below)) ||
        (w->has_speed_above && !(b->speed_mps > w->speed_above)) ||
        (w->has_under_keel_below &&
         !(pel_exercise_under_keel(m, b) < w->under_keel_below))) {
        return false;
    }
    return !w->has_other || is_near(m, w, b);
}

static bool holds(struct pel_exercise_moment *m, const Pelagos__ExerciseWhen *w)
{
    if (w->has_at && !(m->time_s >= w->at)) {
        return false;
    }
    if (w->after) {
        const Pelagos__ExerciseDone *done =
            pel_exercise_done(m->state->exercise, w->after);
        if (!done || done->count == 0 ||
            !(m->time_s >= done->time + w->delay)) {
            return false;
        }
    }
    return is_about(m, w);
}

bool pel_exercise_holds(struct pel_exercise_moment *m,
                        const Pelagos__ExerciseEvent *event)
{
    for (size_t i = 0; i < event->n_when; i++) {
        if (holds(m, event->when[i])) {
            return true;
        }
    }
    return false;
}
