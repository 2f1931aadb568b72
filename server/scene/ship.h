/* Own ship for when there is no simulator: steered by rudder and throttle,
 * carried by the sea that is drawn. docs/physics/ships.md has the equations.
 *
 * The motion is a function of the start (state, orders, time) and of simulated
 * time: it goes in steps that end at multiples of PEL_SHIP_STEP_S, each solved
 * in closed form, so it does not depend on when or how often it is sampled. The
 * sea is asked at these multiples alone, whenever orders came and of whichever
 * ship, so that its moments can be computed ahead. Pure functions, any thread.
 * Local frame of scene/snapshot.h. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ocean/sea.h"

#define PEL_SHIP_STEP_S 0.2
/* Steps that are kept: of moments just past, which are answered exactly, and
 * of some to come, which a thread may have done ahead. */
#define PEL_SHIP_HISTORY 64
/* How far ahead of the last step it is looked; later it stays there. */
#define PEL_SHIP_AHEAD_S 10.0
#define PEL_SHIP_POINTS 15 /* of the hull, where the sea lifts it */

/* What steers it and what it is. Constant between two starts. */
struct pel_ship_orders {
    double
        rudder_rad;  /* ordered and met at once; positive turns to starboard */
    double throttle; /* -1..1 */
    double length_m, beam_m;
    double max_speed_mps, surge_time_s;
    double turn_gain, turn_time; /* Nomoto's K' and T', not dimensional */
    double heave_period_s, pitch_period_s, roll_period_s;
    double roll_damping; /* of critical, 0.01..0.95 */
};

/* One degree of freedom that the sea drives: position and rate. */
struct pel_ship_mode {
    double x, rate;
};

struct pel_ship_motion {
    double east_m, north_m, heading_rad;
    double speed_mps, turn_rate_rps;
    struct pel_ship_mode heave, pitch, roll; /* m, rad (bow up, starb. down) */
};

/* A step: the motion at its start, and what the sea asks at both ends. */
struct pel_ship_step {
    double time_s, span_s;
    struct pel_ship_motion motion;
    double sea[3], sea_after[3]; /* heave, pitch, roll */
};

struct pel_wakes;

/* Where it was, for its wash: of every PEL_SHIP_MARK_STEPS-th step those that a
 * straight way does not pass within PEL_SHIP_MARK_M, or with another heading;
 * the latest. */
#define PEL_SHIP_TRAIL 240
#define PEL_SHIP_MARK_STEPS 10
#define PEL_SHIP_MARK_M 0.5
#define PEL_SHIP_MARK_RAD 0.05
struct pel_ship_mark {
    double time_s, east_m, north_m, heading_rad;
};

struct pel_ship {
    struct pel_ship_orders orders;
    double step_s;
    double start_s;
    double whole; /* steps of simulated time before the start */
    struct pel_ship_motion start;
    /* Ship waves (wakes.h), its own left out; NULL: none. */
    const struct pel_wakes *wakes;
    int64_t self;   /* its entity */
    uint64_t count; /* steps done; the last is steps[count % HISTORY] */
    bool asked;     /* the sea of the first step is known */
    struct pel_ship_step steps[PEL_SHIP_HISTORY];
    int mark_count;
    struct pel_ship_mark marks[PEL_SHIP_TRAIL]; /* oldest first */
};

/* Natural periods where none are given: heave and pitch 2π √(1.6 d / g) with
 * the draught d = beam / 2.5 (added mass as large as the ship's, block over
 * waterplane coefficient 0.8), roll 0.8 B / √GM with GM = B / 20 (weather
 * criterion of the IMO's Intact Stability Code 2008, C = 0.4). */
double pel_ship_heave_period(double beam_m);
double pel_ship_roll_period(double beam_m);

/* Begins at time_s. rate: of simulated time; above 4 the steps are longer by
 * rate / 4, so that their number in real time is bounded. The sea is asked when
 * a later moment is. */
void pel_ship_start(struct pel_ship *ship, const struct pel_ship_orders *orders,
                    const struct pel_ship_motion *motion, double time_s,
                    double rate);

/* Length of a step at a rate of simulated time. */
double pel_ship_step_s(double rate);
/* Steps of this length that are over at a time, within a millionth of one. */
double pel_ship_whole(double time_s, double step_s);
/* When the step of this number begins, 0 the first. */
double pel_ship_time(const struct pel_ship *ship, uint64_t step);

/* Whether pel_ship_at looks at the sea for time_s, and pel_ship_advance; else
 * they take NULL for it. */
bool pel_ship_asks(const struct pel_ship *ship, double time_s);
bool pel_ship_steps(const struct pel_ship *ship, double time_s);

/* Does every step that ends at or before time_s, and looks up the sea of the
 * first; true: there was something to do. */
bool pel_ship_advance(struct pel_ship *ship, double time_s,
                      const struct pel_sea *sea);

/* The motion at time_s; before the oldest step kept: that one's start. */
void pel_ship_at(const struct pel_ship *ship, double time_s,
                 const struct pel_sea *sea, struct pel_ship_motion *out);

/* Its marks before time_s, those of steps to come too, which need no sea;
 * returns their number. */
int pel_ship_trail(const struct pel_ship *ship, double time_s,
                   struct pel_ship_mark out[PEL_SHIP_TRAIL]);

/* Solves x'' + 2 ζ ω x' + ω² x = ω² (from + (to - from) t / span) in closed
 * form over `seconds`, 0 < ζ < 1. */
struct pel_ship_mode pel_ship_respond(struct pel_ship_mode start,
                                      double period_s, double damping,
                                      double from, double to, double span_s,
                                      double seconds);

/* Nomoto's first-order steering T r' + r = K δ and first-order surge
 * Tu u' + u = throttle umax over `seconds`, the sea left out: T = T' L / |U|,
 * K = K' U / L, U the speed at the start. */
void pel_ship_steer(const struct pel_ship_orders *orders, double seconds,
                    struct pel_ship_motion *motion);

/* Forgets the steps that begin after time_s: what they met has changed. */
void pel_ship_forget(struct pel_ship *ship, double time_s);

/* What the sea, and the waves of other ships, ask of the hull at a place and
 * time: mean height, and the angles of the plane that fits it best at the
 * hull's points. Of the ship: its orders, wakes and self. */
void pel_ship_sea(const struct pel_ship *ship,
                  const struct pel_ship_motion *motion, double time_s,
                  const struct pel_sea *sea, double out[3]);
