#include "scene/ship.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "scene/wakes.h"

#define HEAVE_DAMPING 0.35 /* of critical; ships lie at 0.3 to 0.5 */
#define SHORTEST 1e-6      /* of a step; less may be a double's rounding */
#define SLOWEST 0.05       /* of the speed: below, steering grows no slower */
#define MOST_HEAVE_M 50.0
#define MOST_ANGLE_RAD (60.0 * PEL_DEG)

double pel_ship_heave_period(double beam_m)
{
    return 2 * PEL_PI * sqrt(1.6 * beam_m / 2.5 / PEL_GRAVITY);
}

double pel_ship_roll_period(double beam_m)
{
    return 0.8 * beam_m / sqrt(beam_m / 20);
}

struct pel_ship_mode pel_ship_respond(struct pel_ship_mode start,
                                      double period_s, double damping,
                                      double from, double to, double span_s,
                                      double seconds)
{
    double omega = 2 * PEL_PI / period_s;
    double slope = (to - from) / span_s;
    double decay = damping * omega;
    double turning = omega * sqrt(1 - damping * damping);
    /* A particular solution is the ramp itself, late by 2 ζ / ω. */
    double late = from - 2 * damping * slope / omega;
    double x = start.x - late, rate = start.rate - slope;
    double shrink = exp(-decay * seconds);
    double c = cos(turning * seconds), s = sin(turning * seconds);
    return (struct pel_ship_mode){
        .x = late + slope * seconds +
             shrink * (x * c + (rate + decay * x) / turning * s),
        .rate =
            slope + shrink * (rate * c -
                              (omega * omega * x + decay * rate) / turning * s),
    };
}

void pel_ship_steer(const struct pel_ship_orders *o, double seconds,
                    struct pel_ship_motion *m)
{
    double pace = fmax(fabs(m->speed_mps), SLOWEST * o->max_speed_mps);
    double turn_time_s = o->turn_time * o->length_m / pace;
    double steady = o->turn_gain * m->speed_mps / o->length_m * o->rudder_rad;
    double ordered = o->throttle * o->max_speed_mps;
    double east = 0, north = 0;
    const struct pel_ship_motion start = *m;
    /* Speed and heading in closed form; the track by Simpson's rule. */
    for (int i = 0; i <= 2; i++) {
        double t = 0.5 * i * seconds;
        double turned = exp(-t / turn_time_s);
        double rate = start.turn_rate_rps - steady;
        m->speed_mps =
            ordered + (start.speed_mps - ordered) * exp(-t / o->surge_time_s);
        m->turn_rate_rps = steady + rate * turned;
        m->heading_rad =
            start.heading_rad + steady * t + rate * turn_time_s * (1 - turned);
        double weight = (i == 1 ? 4 : 1) * seconds / 6;
        east += weight * m->speed_mps * sin(m->heading_rad);
        north += weight * m->speed_mps * cos(m->heading_rad);
    }
    m->east_m += east;
    m->north_m += north;
}

/* pel_sea_query, with the height of others' waves. */
static void query(const struct pel_ship *ship, const struct pel_ship_motion *m,
                  double time_s, const struct pel_sea *sea,
                  const struct pel_vec2 points[PEL_SHIP_POINTS],
                  struct pel_surface_sample samples[PEL_SHIP_POINTS])
{
    struct pel_vec2 at[PEL_SHIP_POINTS];
    struct pel_wake_shift there[PEL_SHIP_POINTS];
    if (!pel_wakes_reach(ship->wakes, ship->self, time_s,
                         (struct pel_vec2){ m->east_m, m->north_m },
                         ship->orders.length_m + ship->orders.beam_m)) {
        pel_sea_query(sea, points, PEL_SHIP_POINTS, time_s, samples);
        return;
    }
    const struct pel_box of = pel_box_of(points, PEL_SHIP_POINTS);
    const struct pel_wake_moment *moment =
        pel_wakes_within(ship->wakes, time_s, &of);
    for (int i = 0; i < PEL_SHIP_POINTS; i++) {
        at[i] = pel_wakes_before(moment, ship->self, points[i], &there[i]);
    }
    pel_sea_query(sea, at, PEL_SHIP_POINTS, time_s, samples);
    for (int i = 0; i < PEL_SHIP_POINTS; i++) {
        samples[i].height_m += there[i].d.z;
    }
    pel_wake_moment_unref(moment);
}

void pel_ship_sea(const struct pel_ship *ship, const struct pel_ship_motion *m,
                  double time_s, const struct pel_sea *sea, double out[3])
{
    const struct pel_ship_orders *o = &ship->orders;
    static const double along[] = { -0.4, -0.2, 0, 0.2, 0.4 };
    static const double across[] = { -0.4, 0, 0.4 };
    struct pel_vec2 points[PEL_SHIP_POINTS];
    struct pel_surface_sample samples[PEL_SHIP_POINTS];
    double sh = sin(m->heading_rad), ch = cos(m->heading_rad);
    double height = 0, bow = 0, starboard = 0, bow2 = 0, starboard2 = 0;
    for (int i = 0; i < PEL_SHIP_POINTS; i++) {
        double x = along[i / 3] * o->length_m, y = across[i % 3] * o->beam_m;
        points[i].x = m->east_m + x * sh + y * ch;
        points[i].y = m->north_m + x * ch - y * sh;
    }
    query(ship, m, time_s, sea, points, samples);
    for (int i = 0; i < PEL_SHIP_POINTS; i++) {
        double x = along[i / 3] * o->length_m, y = across[i % 3] * o->beam_m;
        height += samples[i].height_m;
        bow += x * samples[i].height_m;
        bow2 += x * x;
        starboard += y * samples[i].height_m;
        starboard2 += y * y;
    }
    out[0] = height / PEL_SHIP_POINTS;
    out[1] = atan(bow / bow2);
    out[2] = -atan(starboard / starboard2); /* starboard down is positive */
}

/* A sea beyond what the filters are for does not capsize the camera. */
static void hold(struct pel_ship_mode *mode, double most)
{
    if (!(fabs(mode->x) <= most)) {
        mode->x = copysign(most, mode->x);
        mode->rate = 0;
    }
}

/* The motion `seconds` into a step. */
static void move(const struct pel_ship *ship, const struct pel_ship_step *step,
                 double seconds, struct pel_ship_motion *out)
{
    const struct pel_ship_orders *o = &ship->orders;
    struct pel_ship_mode *modes[] = { &out->heave, &out->pitch, &out->roll };
    const double periods[] = { o->heave_period_s, o->pitch_period_s,
                               o->roll_period_s };
    const double damping[] = { HEAVE_DAMPING, HEAVE_DAMPING, o->roll_damping };
    *out = step->motion;
    if (seconds <= 0) {
        return;
    }
    pel_ship_steer(o, seconds, out);
    for (int i = 0; i < 3; i++) {
        *modes[i] =
            pel_ship_respond(*modes[i], periods[i], damping[i], step->sea[i],
                             step->sea_after[i], step->span_s, seconds);
        hold(modes[i], i == 0 ? MOST_HEAVE_M : MOST_ANGLE_RAD);
    }
}

/* The step that begins with this motion; the sea at its end is looked up where
 * the ship will then be. */
static void open_step(const struct pel_ship *ship, uint64_t number,
                      const struct pel_sea *sea, struct pel_ship_step *step)
{
    struct pel_ship_motion after = step->motion;
    pel_ship_steer(&ship->orders, step->span_s, &after);
    pel_ship_sea(ship, &after, pel_ship_time(ship, number + 1), sea,
                 step->sea_after);
}

double pel_ship_step_s(double rate)
{
    return PEL_SHIP_STEP_S * fmax(1, rate / 4);
}

double pel_ship_whole(double time_s, double step_s)
{
    return floor(time_s / step_s + SHORTEST);
}

double pel_ship_time(const struct pel_ship *ship, uint64_t step)
{
    return step == 0 ? ship->start_s
                     : (ship->whole + (double)step) * ship->step_s;
}

static void next_step(const struct pel_ship *ship, uint64_t count,
                      const struct pel_ship_step *last,
                      const struct pel_sea *sea, struct pel_ship_step *next)
{
    move(ship, last, last->span_s, &next->motion);
    next->time_s = pel_ship_time(ship, count);
    next->span_s = ship->step_s;
    for (int i = 0; i < 3; i++) {
        next->sea[i] = last->sea_after[i];
    }
    open_step(ship, count, sea, next);
}

/* --- the way ------------------------------------------------------------- */

/* How far it is from the straight way between the last two, gone on with. */
static bool strays(const struct pel_ship_mark *marks, int count,
                   const struct pel_ship_mark *m)
{
    if (count < 2) {
        return true;
    }
    const struct pel_ship_mark *a = &marks[count - 2], *b = a + 1;
    double f = (m->time_s - b->time_s) / (b->time_s - a->time_s);
    double x = b->east_m + f * (b->east_m - a->east_m);
    double y = b->north_m + f * (b->north_m - a->north_m);
    return hypot(m->east_m - x, m->north_m - y) > PEL_SHIP_MARK_M ||
           fabs(m->heading_rad - b->heading_rad) > PEL_SHIP_MARK_RAD;
}

static void mark(struct pel_ship_mark *marks, int *count, double time_s,
                 const struct pel_ship_motion *at)
{
    const struct pel_ship_mark m = { time_s, at->east_m, at->north_m,
                                     at->heading_rad };
    if (!strays(marks, *count, &m)) {
        return;
    }
    if (*count == PEL_SHIP_TRAIL) {
        memmove(marks, marks + 1, sizeof *marks * (PEL_SHIP_TRAIL - 1));
        --*count;
    }
    marks[(*count)++] = m;
}

int pel_ship_trail(const struct pel_ship *ship, double time_s,
                   struct pel_ship_mark out[PEL_SHIP_TRAIL])
{
    uint64_t step = ship->count;
    int count = ship->mark_count;
    const struct pel_ship_step *last = &ship->steps[step % PEL_SHIP_HISTORY];
    struct pel_ship_motion m = last->motion;
    double span_s = last->span_s;
    double until = fmin(time_s, last->time_s + PEL_SHIP_AHEAD_S);
    memcpy(out, ship->marks, sizeof *out * (size_t)count);
    for (;;) {
        double at = pel_ship_time(ship, ++step);
        if (at >= until) {
            break;
        }
        pel_ship_steer(&ship->orders, span_s, &m);
        span_s = ship->step_s;
        if (step % PEL_SHIP_MARK_STEPS == 0) {
            mark(out, &count, at, &m);
        }
    }
    while (count > 0 && out[count - 1].time_s >= time_s) {
        count--;
    }
    return count;
}

void pel_ship_start(struct pel_ship *ship, const struct pel_ship_orders *orders,
                    const struct pel_ship_motion *motion, double time_s,
                    double rate)
{
    double step_s = pel_ship_step_s(rate);
    *ship = (struct pel_ship){
        .orders = *orders,
        .step_s = step_s,
        .start_s = time_s,
        .whole = pel_ship_whole(time_s, step_s),
        .start = *motion,
        .steps[0] = { .time_s = time_s, .motion = *motion },
    };
    ship->steps[0].span_s = pel_ship_time(ship, 1) - time_s;
    mark(ship->marks, &ship->mark_count, time_s, motion);
}

/* The sea of the first step: at its start between what it asks there at the
 * multiples before and after. */
static void ask_first(const struct pel_ship *ship, const struct pel_sea *sea,
                      struct pel_ship_step *first)
{
    double gone = first->time_s / ship->step_s - ship->whole, after[3];
    pel_ship_sea(ship, &first->motion, ship->whole * ship->step_s, sea,
                 first->sea);
    if (gone > SHORTEST) {
        pel_ship_sea(ship, &first->motion, pel_ship_time(ship, 1), sea, after);
        for (int i = 0; i < 3; i++) {
            first->sea[i] += gone * (after[i] - first->sea[i]);
        }
    }
    open_step(ship, 0, sea, first);
}

bool pel_ship_steps(const struct pel_ship *ship, double time_s)
{
    return pel_ship_time(ship, ship->count + 1) <= time_s;
}

bool pel_ship_asks(const struct pel_ship *ship, double time_s)
{
    return pel_ship_steps(ship, time_s) ||
           (!ship->asked && time_s > ship->start_s);
}

void pel_ship_forget(struct pel_ship *ship, double time_s)
{
    while (ship->count > 0 &&
           ship->steps[ship->count % PEL_SHIP_HISTORY].time_s > time_s) {
        ship->count--;
    }
}

bool pel_ship_advance(struct pel_ship *ship, double time_s,
                      const struct pel_sea *sea)
{
    bool moved = false;
    if (!ship->asked && time_s > ship->start_s) {
        ask_first(ship, sea, &ship->steps[0]);
        ship->asked = moved = true;
    }
    for (;;) {
        uint64_t next = ship->count + 1;
        if (!(pel_ship_time(ship, next) <= time_s)) {
            return moved;
        }
        next_step(ship, next, &ship->steps[ship->count % PEL_SHIP_HISTORY], sea,
                  &ship->steps[next % PEL_SHIP_HISTORY]);
        ship->count = next;
        if (next % PEL_SHIP_MARK_STEPS == 0) {
            const struct pel_ship_step *at =
                &ship->steps[next % PEL_SHIP_HISTORY];
            mark(ship->marks, &ship->mark_count, at->time_s, &at->motion);
        }
        moved = true;
    }
}

void pel_ship_at(const struct pel_ship *ship, double time_s,
                 const struct pel_sea *sea, struct pel_ship_motion *out)
{
    uint64_t count = ship->count;
    struct pel_ship_step step = ship->steps[count % PEL_SHIP_HISTORY];
    double latest_s = step.time_s + PEL_SHIP_AHEAD_S;
    time_s = fmin(time_s, latest_s);
    if (!ship->asked && time_s > step.time_s) {
        ask_first(ship, sea, &step);
    }
    while (pel_ship_time(ship, count + 1) <= time_s) {
        struct pel_ship_step next = { 0 };
        next_step(ship, ++count, &step, sea, &next);
        step = next;
    }
    while (step.time_s > time_s && count > 0 &&
           ship->count - count < PEL_SHIP_HISTORY - 1) {
        step = ship->steps[--count % PEL_SHIP_HISTORY];
    }
    move(ship, &step, time_s - step.time_s, out);
}
