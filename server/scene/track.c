#include "scene/track.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "base/log.h"
#include "base/vec.h"
#include "message.h"
#include "scene/geodesy.h"
#include "scene/reckon.h"

/* Faster than any ship, or a place this far from the reckoned one: it was
 * placed there. */
#define FASTEST_MPS 45.0
#define ASTRAY_M 60.0
/* What is older has left every tile. */
#define KEPT_S 1200.0
#define MOST_ARCS 32

struct pel_track_pose pel_track_pose_of(const Pelagos__Entity *e)
{
    return (struct pel_track_pose){ e->pose_time, e->latitude, e->longitude,
                                    e->speed,     e->course,   e->turn_rate,
                                    e->heading };
}

static const ProtobufCFieldDescriptor *list_field(void)
{
    return protobuf_c_message_descriptor_get_field_by_name(
        &pelagos__entity__descriptor, "track");
}

static void drop_first(Pelagos__Entity *e, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        pelagos__track_point__free_unpacked(e->track[i], NULL);
    }
    e->n_track -= count;
    for (size_t i = 0; i < e->n_track; i++) {
        e->track[i] = e->track[i + count];
    }
    if (e->n_track == 0) {
        free(e->track);
        e->track = NULL;
    }
}

void pel_track_cut(Pelagos__Entity *e, double from_s)
{
    size_t count = e->n_track;
    while (count > 0 && e->track[count - 1]->time >= from_s) {
        count--;
        pelagos__track_point__free_unpacked(e->track[count], NULL);
    }
    if (count == 0 && e->n_track > 0) {
        free(e->track);
        e->track = NULL;
    }
    e->n_track = count;
}

/* The first that is hardly off the straight line between its neighbours; 0:
 * none, the first of all. */
static size_t spare(const Pelagos__Entity *e)
{
    for (size_t i = 1; i + 2 < e->n_track; i++) {
        const Pelagos__TrackPoint *p = e->track[i];
        const Pelagos__TrackPoint *a = e->track[i - 1], *b = e->track[i + 1];
        double bx, by, x, y, f = (p->time - a->time) / (b->time - a->time);
        pel_geo_to_local(a->latitude, a->longitude, b->latitude, b->longitude,
                         &bx, &by);
        pel_geo_to_local(a->latitude, a->longitude, p->latitude, p->longitude,
                         &x, &y);
        if (hypot(x - f * bx, y - f * by) < 0.1 * PEL_TRACK_WITHIN_M) {
            return i;
        }
    }
    return 0;
}

static void drop_one(Pelagos__Entity *e, size_t at)
{
    pelagos__track_point__free_unpacked(e->track[at], NULL);
    for (size_t i = at; i + 1 < e->n_track; i++) {
        e->track[i] = e->track[i + 1];
    }
    e->n_track--;
}

Pelagos__TrackPoint *pel_track_add(Pelagos__Entity *e, double time_s,
                                   double latitude, double longitude)
{
    size_t old = 0;
    while (old + 2 < e->n_track && e->track[old + 1]->time < time_s - KEPT_S) {
        old++;
    }
    size_t spared = old == 0 && e->n_track >= PEL_TRACK_MOST ? spare(e) : 0;
    if (spared > 0) {
        drop_one(e, spared);
    } else if (old == 0 && e->n_track >= PEL_TRACK_MOST) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_WARNING, "SCN-030",
                        "entity %u: its track has %d points; the oldest waves "
                        "of its wake are left out",
                        e->id, PEL_TRACK_MOST);
        old = 1;
    }
    if (old > 0) {
        drop_first(e, old);
    }
    Pelagos__TrackPoint *p =
        (Pelagos__TrackPoint *)pel_message_append(&e->base, list_field());
    p->has_time = p->has_latitude = p->has_longitude = true;
    p->time = time_s;
    p->latitude = latitude;
    p->longitude = longitude;
    return p;
}

void pel_track_mark(Pelagos__Entity *e, const Pelagos__TrackPoint *point)
{
    if (e->n_track > 0 && point->time <= e->track[e->n_track - 1]->time) {
        return;
    }
    Pelagos__TrackPoint *p =
        pel_track_add(e, point->time, point->latitude, point->longitude);
    p->has_heading = point->has_heading;
    p->heading = point->heading;
    p->has_push = point->has_push;
    p->push = point->push;
}

/* Whether a place is a stride on from the last point: what lies further back
 * then stays as it is. */
static bool strides(const Pelagos__Entity *e, double latitude, double longitude)
{
    double x, y;
    if (e->n_track == 0) {
        return true;
    }
    const Pelagos__TrackPoint *b = e->track[e->n_track - 1];
    pel_geo_to_local(b->latitude, b->longitude, latitude, longitude, &x, &y);
    return hypot(x, y) > PEL_TRACK_STRIDE_M;
}

/* How far a place is from the last piece, gone on with. */
static double off_piece(const Pelagos__Entity *e, double time_s,
                        double latitude, double longitude)
{
    if (e->n_track < 2) {
        return HUGE_VAL;
    }
    const Pelagos__TrackPoint *a = e->track[e->n_track - 2];
    const Pelagos__TrackPoint *b = e->track[e->n_track - 1];
    double ax, ay, x, y;
    pel_geo_to_local(b->latitude, b->longitude, a->latitude, a->longitude, &ax,
                     &ay);
    pel_geo_to_local(b->latitude, b->longitude, latitude, longitude, &x, &y);
    double f = (time_s - b->time) / (a->time - b->time);
    return hypot(x - f * ax, y - f * ay);
}

static void pass(Pelagos__Entity *e, double time_s, double latitude,
                 double longitude, double heading_deg)
{
    if (e->n_track > 0 && time_s <= e->track[e->n_track - 1]->time + 0.05) {
        return;
    }
    if (strides(e, latitude, longitude) ||
        off_piece(e, time_s, latitude, longitude) > PEL_TRACK_WITHIN_M) {
        Pelagos__TrackPoint *p = pel_track_add(e, time_s, latitude, longitude);
        double turned = fmod(heading_deg, 360);
        p->has_heading = e->wash;
        p->heading = turned < 0 ? turned + 360 : turned;
    }
}

/* The arc that a turn reckons it along. */
static void pass_arc(const struct pel_track_pose *before, Pelagos__Entity *e,
                     double seconds)
{
    double bow = fabs(before->turn_rate_dps) * PEL_DEG * before->speed_mps;
    if (bow < 1e-6) {
        return;
    }
    double step = sqrt(8.0 * PEL_TRACK_WITHIN_M / bow);
    int count = (int)fmin(seconds / step, MOST_ARCS);
    for (int i = 1; i <= count; i++) {
        double s = seconds * i / (count + 1), east, north, lat, lon;
        pel_reckon_move(before->speed_mps, before->course_deg * PEL_DEG,
                        before->turn_rate_dps * PEL_DEG, s, &east, &north);
        pel_geo_from_local(before->latitude, before->longitude, east, north,
                           &lat, &lon);
        pass(e, before->time_s + s, lat, lon,
             before->heading_deg + before->turn_rate_dps * s);
    }
}

/* Whether it cannot have sailed there. */
static bool astray(const struct pel_track_pose *before,
                   const Pelagos__Entity *e, double reckoning_s)
{
    double seconds = e->pose_time - before->time_s, x, y, east, north;
    pel_geo_to_local(before->latitude, before->longitude, e->latitude,
                     e->longitude, &x, &y);
    double held = pel_reckon_seconds(before->time_s, e->pose_time, reckoning_s);
    pel_reckon_move(before->speed_mps, before->course_deg * PEL_DEG,
                    before->turn_rate_dps * PEL_DEG, held, &east, &north);
    double off = hypot(x - east, y - north), way = hypot(x, y);
    if (seconds <= 0) {
        return seconds < 0 || way > 1.0;
    }
    return way > FASTEST_MPS * seconds + 1.0 ||
           (before->speed_mps > 0 && off > ASTRAY_M + 0.5 * way);
}

void pel_track_drop(Pelagos__Entity *e)
{
    if (e->n_track > 0) {
        drop_first(e, e->n_track);
    }
}

void pel_track_go_on(const struct pel_track_pose *before, Pelagos__Entity *e,
                     double reckoning_s)
{
    if (!(e->wake || e->wash) || astray(before, e, reckoning_s)) {
        pel_track_drop(e);
        return;
    }
    double seconds =
        pel_reckon_seconds(before->time_s, e->pose_time, reckoning_s);
    if (seconds <= 0) {
        return;
    }
    pass(e, before->time_s, before->latitude, before->longitude,
         before->heading_deg);
    pass_arc(before, e, seconds);
    pass(e, e->pose_time, e->latitude, e->longitude, e->heading);
}
