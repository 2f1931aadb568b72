#include "scene/almanac.h"

#include <math.h>

#include <glib.h>

#include "base/vec.h"
#include "message.h"
#include "scene/ephemeris.h"
#include "scene/scene_parts.h"
#include "scene/sun.h"

#define DAY_S 86400.0
#define STEP_S 1200.0 /* two crossings nearer than this are one graze */
#define HORIZON ((-34.0 - 16.0) / 60.0 * PEL_DEG)
#define MAX_WAITING 128

struct place {
    double latitude, longitude; /* radians */
};
typedef double (*elevation_at)(double unix_s, const struct place *place);

static double sun_elevation(double unix_s, const struct place *place)
{
    double azimuth, elevation;
    pel_sun_position(unix_s, place->latitude, place->longitude, &azimuth,
                     &elevation);
    return elevation;
}

static double moon_elevation(double unix_s, const struct place *place)
{
    struct pel_moon_place moon;
    pel_ephemeris_moon(unix_s, place->latitude, place->longitude, &moon);
    return asin(pel_clamp(moon.direction.z, -1, 1));
}

/* Where the body is at the horizon, between two moments on both sides of it. */
static double crossing(elevation_at at, const struct place *place, double lo,
                       double hi)
{
    bool rises = at(hi, place) > HORIZON;
    while (hi - lo > 1) {
        double mid = 0.5 * (lo + hi);
        if ((at(mid, place) > HORIZON) == rises) {
            hi = mid;
        } else {
            lo = mid;
        }
    }
    return 0.5 * (lo + hi);
}

/* Where it is highest, between two moments that have its greatest elevation
 * between them: by thirds. */
static double top(elevation_at at, const struct place *place, double lo,
                  double hi)
{
    while (hi - lo > 1) {
        double a = lo + (hi - lo) / 3, b = hi - (hi - lo) / 3;
        if (at(a, place) < at(b, place)) {
            lo = a;
        } else {
            hi = b;
        }
    }
    return 0.5 * (lo + hi);
}

static void find(elevation_at at, double midnight_s, const struct place *place,
                 struct pel_body_day *out)
{
    const int steps = (int)(DAY_S / STEP_S);
    double before = at(midnight_s - STEP_S, place), now = at(midnight_s, place);
    *out = (struct pel_body_day){ NAN, NAN, NAN, NAN };
    for (int i = 0; i <= steps; i++) {
        double t = midnight_s + STEP_S * i, next = at(t + STEP_S, place);
        if (now >= before && now > next && isnan(out->culmination_s)) {
            double when = top(at, place, t - STEP_S, t + STEP_S);
            if (when >= midnight_s && when < midnight_s + DAY_S) {
                out->culmination_s = when;
                out->highest_rad = at(when, place);
            }
        }
        if (i < steps && (now > HORIZON) != (next > HORIZON)) {
            double *when = next > now ? &out->rise_s : &out->set_s;
            *when = isnan(*when) ? crossing(at, place, t, t + STEP_S) : *when;
        }
        before = now;
        now = next;
    }
}

void pel_almanac_sun(double midnight_s, double latitude_rad,
                     double longitude_rad, struct pel_body_day *out)
{
    const struct place place = { latitude_rad, longitude_rad };
    find(sun_elevation, midnight_s, &place, out);
}

void pel_almanac_moon(double midnight_s, double latitude_rad,
                      double longitude_rad, struct pel_body_day *out)
{
    const struct place place = { latitude_rad, longitude_rad };
    find(moon_elevation, midnight_s, &place, out);
}

/* --- the answer ----------------------------------------------------------- */

static void set_utc(ProtobufCMessage *message, const char *name, double unix_s)
{
    const ProtobufCFieldDescriptor *field =
        protobuf_c_message_descriptor_get_field_by_name(message->descriptor,
                                                        name);
    GDateTime *when =
        isnan(unix_s) ? NULL : g_date_time_new_from_unix_utc(llround(unix_s));
    if (when) {
        g_autofree char *text = g_date_time_format(when, "%Y-%m-%dT%H:%M:%SZ");
        pel_message_set_string(message, field, text);
        g_date_time_unref(when);
    }
}

static Pelagos__AlmanacBody *body(const struct pel_body_day *day,
                                  double azimuth_rad, double elevation_rad)
{
    Pelagos__AlmanacBody *out = (Pelagos__AlmanacBody *)pel_message_new(
        &pelagos__almanac_body__descriptor);
    out->has_azimuth = out->has_elevation = true;
    out->azimuth = fmod(azimuth_rad / PEL_DEG + 360.0, 360.0);
    out->elevation = elevation_rad / PEL_DEG;
    out->has_highest = !isnan(day->highest_rad);
    out->highest = out->has_highest ? day->highest_rad / PEL_DEG : 0;
    set_utc(&out->base, "rise", day->rise_s);
    set_utc(&out->base, "culmination", day->culmination_s);
    set_utc(&out->base, "set", day->set_s);
    return out;
}

static Pelagos__Almanac *almanac(double unix_s, const struct place *place)
{
    Pelagos__Almanac *out =
        (Pelagos__Almanac *)pel_message_new(&pelagos__almanac__descriptor);
    double midnight = DAY_S * floor(unix_s / DAY_S), azimuth, elevation;
    struct pel_body_day day;
    struct pel_moon_place moon;
    set_utc(&out->base, "utc", unix_s);
    pel_almanac_sun(midnight, place->latitude, place->longitude, &day);
    pel_sun_position(unix_s, place->latitude, place->longitude, &azimuth,
                     &elevation);
    out->sun = body(&day, azimuth, elevation);
    pel_almanac_moon(midnight, place->latitude, place->longitude, &day);
    pel_ephemeris_moon(unix_s, place->latitude, place->longitude, &moon);
    out->moon = body(&day, atan2(moon.direction.x, moon.direction.y),
                     asin(pel_clamp(moon.direction.z, -1, 1)));
    out->moon->has_lit = true;
    out->moon->lit = moon.lit;
    return out;
}

/* --- on a thread ---------------------------------------------------------- */

struct asked {
    struct pel_task task;
    double unix_s;
    struct place place;
    Pelagos__Almanac *answer;
    pel_almanac_done done;
    void *user;
};

static void work(struct pel_task *task)
{
    struct asked *a = (struct asked *)task;
    a->answer = almanac(a->unix_s, &a->place);
}

static void tell(struct pel_task *task, bool dropped)
{
    struct asked *a = (struct asked *)task;
    struct pel_fault fault = { 0 };
    enum pel_err err = dropped ? pel_fault_set(&fault, PEL_ERR_CONFLICT,
                                               "the daemon is stopping")
                               : PEL_OK;
    a->done(a->user, err, &fault, a->answer);
    if (a->answer) {
        pelagos__almanac__free_unpacked(a->answer, NULL);
    }
    g_free(a);
}

enum pel_err pel_scene_ask_almanac(struct pel_scene *scene,
                                   const Pelagos__AlmanacQuery *query,
                                   pel_almanac_done done, void *user,
                                   struct pel_fault *fault)
{
    const Pelagos__State *state = pel_scene_state(scene);
    double epoch;
    enum pel_err err = pel_utc_parse(state->clock->utc, &epoch);
    if (err) {
        return pel_fault_set(fault, err, "clock.utc is %s",
                             state->clock->utc); /* the state was tested */
    }
    if (pel_worker_count(scene->numbers) >= MAX_WAITING) {
        return pel_fault_set(fault, PEL_ERR_BUSY,
                             "%d questions of numbers wait already",
                             MAX_WAITING);
    }
    struct asked *a = g_new0(struct asked, 1);
    a->task = (struct pel_task){ .work = work, .done = tell };
    a->unix_s = epoch + (query->has_time ? query->time : state->clock->time);
    a->place = (struct place){ state->origin->latitude * PEL_DEG,
                               state->origin->longitude * PEL_DEG };
    a->done = done;
    a->user = user;
    pel_worker_push(scene->numbers, &a->task);
    return PEL_OK;
}
