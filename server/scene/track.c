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
                                    e->speed,     e->course,   e->turn_rate };
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

static void append(Pelagos__Entity *e, double time_s, double latitude,
                   double longitude)
{
    size_t old = 0;
    while (old + 2 < e->n_track && e->track[old + 1]->time < time_s - KEPT_S) {
        old++;
    }
    if (old == 0 && e->n_track >= PEL_TRACK_MOST) {
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
                 double longitude)
{
    if (e->n_track > 0 && time_s <= e->track[e->n_track - 1]->time + 0.05) {
        return;
    }
    if (off_piece(e, time_s, latitude, longitude) > PEL_TRACK_WITHIN_M) {
        append(e, time_s, latitude, longitude);
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
        pass(e, before->time_s + s, lat, lon);
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
    if (!e->wake || astray(before, e, reckoning_s)) {
        pel_track_drop(e);
        return;
    }
    double seconds =
        pel_reckon_seconds(before->time_s, e->pose_time, reckoning_s);
    if (seconds <= 0) {
        return;
    }
    pass(e, before->time_s, before->latitude, before->longitude);
    pass_arc(before, e, seconds);
    pass(e, e->pose_time, e->latitude, e->longitude);
}
