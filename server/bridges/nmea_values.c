#include "bridges/nmea_values.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

#define STEERAGE_MPS 0.5 /* below it a course says nothing of the heading */

static double wrap(double deg)
{
    double wrapped = fmod(deg, 360);
    return wrapped < 0 ? wrapped + 360 : wrapped;
}

bool pel_nmea_fresh(const struct pel_nmea_value *value, int64_t now_ns)
{
    return value->at_ns != 0 && now_ns - value->at_ns <= PEL_NMEA_FRESH_NS;
}

/* Index of the best fresh of `count` values, else of the newest, else -1. */
static int best(const struct pel_nmea_value *values, int count, int64_t now_ns)
{
    int newest = -1;
    for (int i = 0; i < count; i++) {
        if (pel_nmea_fresh(&values[i], now_ns)) {
            return i;
        }
        if (values[i].at_ns != 0 &&
            (newest < 0 || values[i].at_ns > values[newest].at_ns)) {
            newest = i;
        }
    }
    return newest;
}

static const struct pel_nmea_value *
best_heading(const struct pel_nmea_values *v, int64_t now_ns)
{
    int i = best(v->heading, PEL_HEADINGS, now_ns);
    if (i >= 0 && pel_nmea_fresh(&v->heading[i], now_ns)) {
        return &v->heading[i];
    }
    for (int k = PEL_MOTION_GNSS; k <= PEL_MOTION_VDO; k++) {
        if (pel_nmea_fresh(&v->course[k], now_ns) &&
            pel_nmea_fresh(&v->speed[k], now_ns) &&
            v->speed[k].value > STEERAGE_MPS) {
            return &v->course[k];
        }
    }
    return i >= 0 ? &v->heading[i] : NULL;
}

bool pel_nmea_heading(const struct pel_nmea_values *v, int64_t now_ns,
                      double *deg)
{
    const struct pel_nmea_value *heading = best_heading(v, now_ns);
    if (heading) {
        *deg = heading->value;
    }
    return heading != NULL;
}

bool pel_nmea_motion(const struct pel_nmea_values *v, int64_t now_ns,
                     double *course_deg, double *speed_mps)
{
    int i = best(v->speed, PEL_MOTIONS, now_ns);
    if (i < 0) {
        return false;
    }
    *speed_mps = v->speed[i].value;
    if (v->course[i].at_ns != 0) {
        *course_deg = v->course[i].value;
        return true;
    }
    return pel_nmea_heading(v, now_ns, course_deg);
}

unsigned pel_nmea_news(const struct pel_nmea_values *v, int64_t now_ns)
{
    const struct pel_nmea_value *heading = best_heading(v, now_ns);
    int i = best(v->speed, PEL_MOTIONS, now_ns);
    unsigned news = 0;
    if (heading && heading->at_ns == now_ns) {
        news |= PEL_NMEA_NEW_HEADING;
    }
    if (i >= 0 && (v->course[i].at_ns != 0 ? v->course[i].at_ns == now_ns
                                           : news & PEL_NMEA_NEW_HEADING)) {
        news |= PEL_NMEA_NEW_COURSE;
    }
    if (i >= 0 && v->speed[i].at_ns == now_ns) {
        news |= PEL_NMEA_NEW_SPEED;
    }
    return news;
}

double pel_nmea_turn_rate(const struct pel_nmea_values *v, int64_t now_ns)
{
    int i = best(v->turn_rate, PEL_TURNS, now_ns);
    return i >= 0 && pel_nmea_fresh(&v->turn_rate[i], now_ns)
               ? v->turn_rate[i].value
               : 0;
}

bool pel_nmea_wind(const struct pel_nmea_values *v, int64_t now_ns,
                   double *direction_deg, double *speed_mps)
{
    int i = best(v->wind_speed, PEL_WINDS, now_ns);
    if (i < 0 || v->wind_direction[i].at_ns == 0) {
        return false;
    }
    *direction_deg = v->wind_direction[i].value;
    *speed_mps = v->wind_speed[i].value;
    return true;
}

static bool in_range(struct pel_nmea_values *v, double value, double low,
                     double high)
{
    if (isnan(value)) { /* an empty field */
        return false;
    }
    if (value < low || value > high) {
        v->out_of_range++;
        return false;
    }
    return true;
}

static bool set(struct pel_nmea_values *v, struct pel_nmea_value *to,
                double value, double low, double high, int64_t now_ns,
                unsigned changed)
{
    if (!in_range(v, value, low, high)) {
        return false;
    }
    *to = (struct pel_nmea_value){ value, now_ns };
    v->changed |= changed;
    return true;
}

static void set_heading(struct pel_nmea_values *v, int source, double deg,
                        int64_t now_ns)
{
    set(v, &v->heading[source], deg, 0, 360, now_ns, PEL_NMEA_CHANGED_POSE);
}

static void set_motion(struct pel_nmea_values *v, int source, double course,
                       double speed, int64_t now_ns)
{
    set(v, &v->course[source], course, 0, 360, now_ns, PEL_NMEA_CHANGED_POSE);
    set(v, &v->speed[source], speed, 0, 200, now_ns, PEL_NMEA_CHANGED_POSE);
}

static void set_fix(struct pel_nmea_values *v, int source, double latitude,
                    double longitude, int64_t now_ns)
{
    if (!in_range(v, latitude, -90, 90) || !in_range(v, longitude, -180, 180)) {
        return;
    }
    v->fixes_at_ns[source] = now_ns;
    for (int better = 0; better < source; better++) {
        if (v->fixes_at_ns[better] != 0 &&
            now_ns - v->fixes_at_ns[better] <= PEL_NMEA_FRESH_NS) {
            return;
        }
    }
    v->latitude = latitude;
    v->longitude = longitude;
    v->fix_at_ns = now_ns;
    v->changed |= PEL_NMEA_CHANGED_POSE | PEL_NMEA_CHANGED_FIX;
}

static void take_fix(struct pel_nmea_values *v, int source,
                     const struct pel_nmea_sentence *s, int64_t now_ns)
{
    if (!s->valid || isnan(s->latitude) || isnan(s->longitude)) {
        v->void_fixes++;
        return;
    }
    set_fix(v, source, s->latitude, s->longitude, now_ns);
}

/* A direction and a speed count together or not at all. */
static void set_wind(struct pel_nmea_values *v, int source, double direction,
                     double speed, int64_t now_ns)
{
    if (!in_range(v, direction, 0, 360) || !in_range(v, speed, 0, 30)) {
        return;
    }
    v->wind_direction[source] = (struct pel_nmea_value){ direction, now_ns };
    v->wind_speed[source] = (struct pel_nmea_value){ speed, now_ns };
    if (best(v->wind_speed, PEL_WINDS, now_ns) == source) {
        v->changed |= PEL_NMEA_CHANGED_WIND;
    }
}

#define TAKE(name)                                                             \
    static void take_##name(struct pel_nmea_values *v,                         \
                            const struct pel_nmea_sentence *s, int64_t now_ns)

/* MWV, VWT and VWR are measured from the bow. Relative wind is the air's motion
 * past the ship, so the ship's own motion is added to get the true one. */
static void wind_from_bow(struct pel_nmea_values *v, int source,
                          const struct pel_nmea_sentence *s, int64_t now_ns)
{
    double heading, course, speed;
    if (!s->valid || !in_range(v, s->wind_angle, 0, 360) ||
        isnan(s->wind_speed) || !pel_nmea_heading(v, now_ns, &heading)) {
        return;
    }
    double from = wrap(heading + s->wind_angle);
    if (s->wind_true) {
        set_wind(v, source, from, s->wind_speed, now_ns);
        return;
    }
    if (!pel_nmea_motion(v, now_ns, &course, &speed)) {
        return;
    }
    double east =
        -s->wind_speed * sin(from * PEL_DEG) + speed * sin(course * PEL_DEG);
    double north =
        -s->wind_speed * cos(from * PEL_DEG) + speed * cos(course * PEL_DEG);
    set_wind(v, source, wrap(atan2(-east, -north) / PEL_DEG),
             hypot(east, north), now_ns);
}

TAKE(mwv)
{
    wind_from_bow(v, s->wind_true ? PEL_WIND_MWV_TRUE : PEL_WIND_MWV_RELATIVE,
                  s, now_ns);
}

TAKE(vwt)
{
    wind_from_bow(v, PEL_WIND_VWT, s, now_ns);
}

TAKE(vwr)
{
    wind_from_bow(v, PEL_WIND_VWR, s, now_ns);
}

/* Without any variation yet it counts as 0: better than no heading at all. */
static void take_magnetic(struct pel_nmea_values *v, int source,
                          const struct pel_nmea_sentence *s, int64_t now_ns)
{
    double deviation = isnan(s->deviation) ? 0 : s->deviation;
    double variation = v->variation.at_ns ? v->variation.value : 0;
    if (in_range(v, s->magnetic_heading, 0, 360)) {
        set_heading(v, source,
                    wrap(s->magnetic_heading + deviation + variation), now_ns);
    }
}

TAKE(hdg)
{
    set(v, &v->variation, s->variation, -180, 180, now_ns, 0);
    take_magnetic(v, PEL_HEADING_HDG, s, now_ns);
}

TAKE(hdm)
{
    take_magnetic(v, PEL_HEADING_HDM, s, now_ns);
}

static void set_attitude(struct pel_nmea_values *v, double roll, double pitch,
                         int64_t now_ns)
{
    set(v, &v->roll, roll, -180, 180, now_ns, PEL_NMEA_CHANGED_POSE);
    set(v, &v->pitch, pitch, -90, 90, now_ns, PEL_NMEA_CHANGED_POSE);
}

TAKE(pashr)
{
    set_heading(v, PEL_HEADING_PASHR, s->heading, now_ns);
    set_attitude(v, s->roll, s->pitch, now_ns);
    set(v, &v->heave, s->heave, -50, 50, now_ns, PEL_NMEA_CHANGED_POSE);
}

/* Names seen: HEEL and TRIM (B&G), ROLL and PITCH (gpsd's and most others),
 * PTCH (Airmar). Angular, in degrees. */
TAKE(xdr)
{
    for (size_t i = 0; i < s->transducer_count; i++) {
        const struct pel_nmea_transducer *t = &s->transducers[i];
        if (t->type != 'A' || t->unit != 'D') {
            continue;
        }
        if (strcmp(t->name, "HEEL") == 0 || strcmp(t->name, "ROLL") == 0) {
            set_attitude(v, t->value, NAN, now_ns);
        } else if (strcmp(t->name, "TRIM") == 0 ||
                   strcmp(t->name, "PITCH") == 0 ||
                   strcmp(t->name, "PTCH") == 0) {
            set_attitude(v, NAN, t->value, now_ns);
        }
    }
}

TAKE(vhw)
{
    set_heading(v, PEL_HEADING_VHW, s->heading, now_ns);
    if (!isnan(s->heading) && !isnan(s->magnetic_heading)) {
        set(v, &v->variation, remainder(s->heading - s->magnetic_heading, 360),
            -180, 180, now_ns, 0);
    }
    set(v, &v->speed[PEL_MOTION_VHW], s->speed, 0, 200, now_ns,
        PEL_NMEA_CHANGED_POSE);
}

TAKE(rmc)
{
    take_fix(v, PEL_FIX_RMC, s, now_ns);
    set(v, &v->variation, s->variation, -180, 180, now_ns, 0);
    if (s->valid) {
        set_motion(v, PEL_MOTION_GNSS, s->course, s->speed, now_ns);
    }
}

TAKE(gga)
{
    take_fix(v, PEL_FIX_GGA, s, now_ns);
}

TAKE(gns)
{
    take_fix(v, PEL_FIX_GNS, s, now_ns);
}

TAKE(gll)
{
    take_fix(v, PEL_FIX_GLL, s, now_ns);
}

TAKE(vtg)
{
    if (s->valid) {
        set_motion(v, PEL_MOTION_GNSS, s->course, s->speed, now_ns);
    }
}

TAKE(hdt)
{
    set_heading(v, PEL_HEADING_HDT, s->heading, now_ns);
}

TAKE(ths)
{
    if (s->valid) {
        set_heading(v, PEL_HEADING_THS, s->heading, now_ns);
    }
}

TAKE(rot)
{
    if (s->valid) {
        set(v, &v->turn_rate[PEL_TURN_ROT], s->turn_rate, -90, 90, now_ns,
            PEL_NMEA_CHANGED_POSE);
    }
}

TAKE(mwd)
{
    set_wind(v, PEL_WIND_MWD, s->wind_direction, s->wind_speed, now_ns);
}

TAKE(mda)
{
    set_wind(v, PEL_WIND_MDA, s->wind_direction, s->wind_speed, now_ns);
}

TAKE(rsa)
{
    if (s->valid) {
        set(v, &v->rudder, s->rudder, -90, 90, now_ns, PEL_NMEA_CHANGED_RUDDER);
    }
}

TAKE(dpt)
{
    set(v, &v->depth, s->depth + (isnan(s->depth_offset) ? 0 : s->depth_offset),
        0, 12000, now_ns, 0);
}

TAKE(dbt)
{
    set(v, &v->depth, s->depth, 0, 12000, now_ns, 0);
}

TAKE(nothing) /* says nothing of own ship, or comes by another way */
{
    (void)v;
    (void)s;
    (void)now_ns;
}

void pel_nmea_values_take(struct pel_nmea_values *v,
                          const struct pel_nmea_sentence *s, int64_t now_ns)
{
    static void (*const takes[PEL_NMEA_KIND_COUNT])(
        struct pel_nmea_values *, const struct pel_nmea_sentence *, int64_t) = {
        [PEL_NMEA_OTHER] = take_nothing,
#define NMEA_SENTENCE(kind, address, parse, take, text)                        \
    [PEL_NMEA_##kind] = take_##take,
#include "bridges/nmea_sentences.def"
#undef NMEA_SENTENCE
    };
    takes[s->kind](v, s, now_ns);
}

void pel_nmea_values_take_ais(struct pel_nmea_values *v,
                              const struct pel_ais *ais, int64_t now_ns)
{
    if (!ais->has_position_report) {
        return;
    }
    if (isnan(ais->latitude) || isnan(ais->longitude)) {
        v->void_fixes++;
    } else {
        set_fix(v, PEL_FIX_VDO, ais->latitude, ais->longitude, now_ns);
    }
    set_motion(v, PEL_MOTION_VDO, ais->course, ais->speed, now_ns);
    set_heading(v, PEL_HEADING_VDO, ais->heading, now_ns);
    set(v, &v->turn_rate[PEL_TURN_VDO], ais->turn_rate, -90, 90, now_ns,
        PEL_NMEA_CHANGED_POSE);
}
