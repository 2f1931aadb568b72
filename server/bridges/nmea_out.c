#include "bridges/nmea_out.h"

#include <errno.h>
#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "base/log.h"
#include "base/vec.h"
#include "base/watch.h"
#include "bridges/nmea_traffic.h"
#include "bridges/nmea_write.h"
#include "bridges/target.h"
#include "scene/geodesy.h"
#include "scene/helm.h"

#define MAX_OUTLETS 8
#define DEEP_M 1000.0 /* the schema's default, which is no sounding */
#define KNOT (1852.0 / 3600.0)

/* --- the sentences -------------------------------------------------------- */

/* "5236.00000,N": minutes of five decimals, 2 cm, never 60. */
static void angle(double degrees, int width, const char *signs, char out[24])
{
    long long units = llround(fabs(degrees) * 6e6);
    snprintf(out, 24, "%0*lld%02lld.%05lld,%c", width, units / 6000000,
             units % 6000000 / 100000, units % 100000, signs[degrees < 0]);
}

static void say_place(struct pel_nmea_writer *w,
                      const struct pel_nmea_report *r)
{
    char lat[24], lon[24], clock[16];
    double whole_s = floor(r->unix_s);
    time_t seconds = (time_t)whole_s;
    struct tm utc;
    gmtime_r(&seconds, &utc);
    snprintf(clock, sizeof clock, "%02d%02d%02d.%02d", utc.tm_hour, utc.tm_min,
             utc.tm_sec, (int)((r->unix_s - whole_s) * 100));
    angle(r->latitude, 2, "NS", lat);
    angle(r->longitude, 3, "EW", lon);
    pel_nmea_say(w, '$', "GPRMC,%s,A,%s,%s,%.2f,%.1f,%02d%02d%02d,,,A", clock,
                 lat, lon, r->speed_mps / KNOT, pel_nmea_bearing(r->course),
                 utc.tm_mday, utc.tm_mon + 1, utc.tm_year % 100);
    pel_nmea_say(w, '$', "GPGGA,%s,%s,%s,1,12,0.9,%.1f,M,0.0,M,,", clock, lat,
                 lon, r->altitude_m);
    pel_nmea_say(w, '$', "GPVTG,%.1f,T,,M,%.2f,N,%.2f,K,A",
                 pel_nmea_bearing(r->course), r->speed_mps / KNOT,
                 r->speed_mps * 3.6);
    pel_nmea_say(w, '$', "GPZDA,%s,%02d,%02d,%04d,00,00", clock, utc.tm_mday,
                 utc.tm_mon + 1, utc.tm_year + 1900);
}

/* The wind on board: what blows, less what the ship makes. */
static void say_wind(struct pel_nmea_writer *w, const struct pel_nmea_report *r)
{
    double to = (r->wind_from + 180) * PEL_DEG, over = r->course * PEL_DEG;
    double east = r->wind_mps * sin(to) - r->speed_mps * sin(over);
    double north = r->wind_mps * cos(to) - r->speed_mps * cos(over);
    double from = atan2(-east, -north) / PEL_DEG;
    pel_nmea_say(w, '$', "WIMWD,%.1f,T,,M,%.2f,N,%.2f,M",
                 pel_nmea_bearing(r->wind_from), r->wind_mps / KNOT,
                 r->wind_mps);
    pel_nmea_say(w, '$', "WIMWV,%.1f,R,%.2f,N,A",
                 pel_nmea_bearing(from - r->heading),
                 hypot(east, north) / KNOT);
}

size_t pel_nmea_out_write(const struct pel_nmea_report *r,
                          char out[PEL_NMEA_OUT_SIZE], size_t *count)
{
    struct pel_nmea_writer w = { out, PEL_NMEA_OUT_SIZE, 0, 0 };
    say_place(&w, r);
    pel_nmea_say(&w, '$', "HEHDT,%.1f,T", pel_nmea_bearing(r->heading));
    pel_nmea_say(&w, '$', "HEROT,%.1f,A",
                 r->turn_rate * 60); /* degrees a minute */
    if (!isnan(r->wind_mps)) {
        say_wind(&w, r);
    }
    if (!isnan(r->depth_m)) {
        pel_nmea_say(&w, '$', "SDDPT,%.1f,0.0", r->depth_m);
    }
    pel_nmea_say(&w, '$', "YXXDR,A,%.2f,D,PITCH,A,%.2f,D,ROLL", r->pitch,
                 r->roll);
    if (!isnan(r->rudder)) {
        pel_nmea_say(&w, '$', "AGRSA,%.1f,A,,", r->rudder);
    }
    *count = w.count;
    return w.used;
}

/* --- own ship ------------------------------------------------------------- */

/* Depth at a place: by the height field, else the one that is set. */
static double depth(const Pelagos__State *state, const struct pel_snapshot *s,
                    double east_m, double north_m)
{
    double level = state->sea->level;
    if (s->seabed) {
        double depth_m = level + pel_snapshot_depth(s, east_m, north_m);
        return depth_m > 0 ? depth_m : NAN;
    }
    if (state->sea->has_depth) {
        return state->sea->depth + level;
    }
    return state->water->depth < DEEP_M ? state->water->depth + level : NAN;
}

bool pel_nmea_out_report_of(struct pel_scene *scene, uint32_t entity,
                            struct pel_nmea_report *out)
{
    const Pelagos__State *state = pel_scene_state(scene);
    double time_s = state->clock->time;
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    bool found = false;
    for (size_t i = 0; i < s->entity_count && !found; i++) {
        struct pel_entity_state e;
        if (s->entities[i].id != entity) {
            continue;
        }
        const Pelagos__OwnShip *helm = pel_helm_of(state, entity);
        double lat0 = state->origin->latitude, lon0 = state->origin->longitude;
        found = true;
        pel_snapshot_entity_at(s, i, time_s, &e);
        *out = (struct pel_nmea_report){
            .unix_s = s->epoch_unix_s + time_s,
            .altitude_m = e.altitude_m,
            .turn_rate = e.turn_rate_rps / PEL_DEG,
            .speed_mps = e.speed_mps,
            .roll = e.roll_rad / PEL_DEG,
            .pitch = e.pitch_rad / PEL_DEG,
            .wind_from = state->sea->wind_direction,
            .wind_mps = state->sea->wind_speed,
            .depth_m = depth(state, s, e.east_m, e.north_m),
            .rudder = helm ? helm->rudder : NAN,
        };
        pel_geo_from_local(lat0, lon0, e.east_m, e.north_m, &out->latitude,
                           &out->longitude);
        double turned =
            pel_geo_convergence(lat0, lon0, out->latitude, out->longitude);
        out->heading = (e.heading_rad - turned) / PEL_DEG;
        out->course = (e.course_rad - turned) / PEL_DEG;
    }
    pel_snapshot_unref(s);
    return found;
}

/* --- the bridge ----------------------------------------------------------- */

/* A ship, and where it is sent. */
struct outlet {
    uint32_t entity;
    int fd; /* -1: none yet */
    int family;
    struct pel_target *to;
    struct pel_nmea_radar radar;
};

struct pel_nmea_out {
    struct pel_scene *scene;
    struct pel_metrics *metrics;
    size_t count;
    struct outlet outlets[MAX_OUTLETS];
    guint timer;
    enum pel_nmea_traffic_kind others;
    double rate_hz;
    uint64_t reports, datagrams, sentences, failures;
    uint64_t unresolved; /* reports that had nowhere to go */
};

/* Of one outlet, while what it is told is written. */
struct sending {
    struct pel_nmea_out *bridge;
    struct outlet *outlet;
};

/* A socket of the family that the name has now. */
static bool open_outlet(struct outlet *outlet, int family)
{
    int yes = 1;
    if (outlet->fd >= 0 && outlet->family == family) {
        return true;
    }
    if (outlet->fd >= 0) {
        close(outlet->fd);
    }
    outlet->family = family;
    outlet->fd = socket(family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (outlet->fd >= 0) {
        setsockopt(outlet->fd, SOL_SOCKET, SO_BROADCAST, &yes, sizeof yes);
    }
    return outlet->fd >= 0;
}

static void send_text(void *user, struct pel_nmea_writer *w)
{
    static struct pel_log_limit limit;
    const struct sending *to = user;
    struct pel_nmea_out *o = to->bridge;
    socklen_t size;
    const struct sockaddr *address = pel_target_address(to->outlet->to, &size);
    if (!address) {
        o->unresolved++;
    } else if (open_outlet(to->outlet, address->sa_family) &&
               sendto(to->outlet->fd, w->out, w->used,
                      MSG_DONTWAIT | MSG_NOSIGNAL, address,
                      size) == (ssize_t)w->used) {
        o->datagrams++;
        o->sentences += w->count;
    } else {
        o->failures++;
        pel_target_failed(to->outlet->to);
        pel_log_limited(&limit, PEL_LOG_WARNING, "NMO-002",
                        "NMEA was not sent: %s", strerror(errno));
    }
    w->used = w->count = 0;
}

static void report_ship(struct pel_nmea_out *o, struct outlet *outlet)
{
    struct pel_nmea_report report;
    char text[PEL_NMEA_OUT_SIZE];
    struct pel_nmea_writer w = { text, sizeof text, 0, 0 };
    struct sending to = { o, outlet };
    if (!pel_nmea_out_report_of(o->scene, outlet->entity, &report)) {
        return;
    }
    w.used = pel_nmea_out_write(&report, text, &w.count);
    send_text(&to, &w);
    const struct pel_nmea_traffic traffic = { o->others, outlet->entity,
                                              o->reports, o->rate_hz };
    if (o->others) {
        pel_nmea_traffic_say(&traffic, o->scene, &outlet->radar, &w, send_text,
                             &to);
    }
}

static gboolean on_timer(gpointer user)
{
    PEL_WATCH("nmea out");
    struct pel_nmea_out *o = user;
    for (size_t i = 0; i < o->count; i++) {
        report_ship(o, &o->outlets[i]);
    }
    o->reports++;
    return G_SOURCE_CONTINUE;
}

static void collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_nmea_out *o = user;
    pel_metric(page, "pelagos_nmea_out_datagrams_total", PEL_METRIC_COUNTER,
               "Datagrams of NMEA sent.", NULL, (double)o->datagrams);
    pel_metric(page, "pelagos_nmea_out_sentences_total", PEL_METRIC_COUNTER,
               "Sentences in them.", NULL, (double)o->sentences);
    pel_metric(page, "pelagos_nmea_out_failures_total", PEL_METRIC_COUNTER,
               "Reports that the system did not send.", NULL,
               (double)o->failures);
    pel_metric(page, "pelagos_nmea_out_unresolved_total", PEL_METRIC_COUNTER,
               "Reports that were not sent, as the name of their host is not "
               "resolved.",
               NULL, (double)o->unresolved);
}

/* `7@127.0.0.1:10111`, or of the entity that is given. */
static enum pel_err read_outlet(const struct pel_nmea_out_options *options,
                                const char *text, struct outlet *out,
                                struct pel_fault *fault)
{
    const char *at = strchr(text, '@');
    char *end;
    const struct pel_target_options to = { "nmea-out", at ? at + 1 : text,
                                           AF_UNSPEC, options->metrics };
    *out = (struct outlet){ .entity = options->entity, .fd = -1 };
    if (at) {
        unsigned long id = strtoul(text, &end, 10);
        out->entity = (uint32_t)id;
        if (!g_ascii_isdigit(*text) || end != at || id > 65535) {
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "--nmea-out: '%.80s' is not "
                                 "[ENTITY@]HOST:PORT, ENTITY 0 .. 65535",
                                 text);
        }
    }
    return pel_target_create(&to, &out->to, fault);
}

static void close_outlets(struct pel_nmea_out *o)
{
    for (size_t i = 0; i < o->count; i++) {
        pel_target_destroy(o->outlets[i].to);
        if (o->outlets[i].fd >= 0) {
            close(o->outlets[i].fd);
        }
    }
}

static enum pel_err read_outlets(const struct pel_nmea_out_options *options,
                                 struct pel_nmea_out *o,
                                 struct pel_fault *fault)
{
    g_auto(GStrv) words = g_strsplit(options->to, ",", -1);
    guint count = g_strv_length(words);
    if (!(options->rate_hz >= 0.1 && options->rate_hz <= 50) || count == 0 ||
        count > MAX_OUTLETS) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "--nmea-out: %s at %g Hz: 1 to 8 of "
                             "[ENTITY@]HOST:PORT, separated by commas, "
                             "and 0.1 to 50 Hz are wanted",
                             options->to, options->rate_hz);
    }
    enum pel_err err = PEL_OK;
    for (guint i = 0; i < count && !err; i++) {
        struct outlet *outlet = &o->outlets[o->count++];
        struct pel_nmea_out_options own = *options;
        const char *at = strchr(words[i], '@');
        for (guint k = 0; k < i; k++) { /* one line of metrics a host */
            own.metrics = strcmp(pel_target_text(o->outlets[k].to),
                                 at ? at + 1 : words[i]) == 0
                              ? NULL
                              : own.metrics;
        }
        err = read_outlet(&own, words[i], outlet, fault);
    }
    for (size_t i = 0; i < o->count && !err; i++) {
        pel_info("NMO-001", "NMEA 0183 of entity %u is sent over UDP to %s",
                 o->outlets[i].entity, pel_target_text(o->outlets[i].to));
    }
    if (err) {
        close_outlets(o);
    }
    return err;
}

enum pel_err pel_nmea_out_create(const struct pel_nmea_out_options *options,
                                 struct pel_scene *scene,
                                 struct pel_nmea_out **out,
                                 struct pel_fault *fault)
{
    struct pel_nmea_out made = { .scene = scene,
                                 .metrics = options->metrics,
                                 .others = options->others,
                                 .rate_hz = options->rate_hz };
    enum pel_err err = read_outlets(options, &made, fault);
    if (err) {
        return err;
    }
    struct pel_nmea_out *o = g_new0(struct pel_nmea_out, 1);
    *o = made;
    o->timer =
        g_timeout_add((guint)lround(1000 / options->rate_hz), on_timer, o);
    if (o->metrics) {
        pel_metrics_add(o->metrics, collect, o);
    }
    *out = o;
    return PEL_OK;
}

void pel_nmea_out_destroy(struct pel_nmea_out *o)
{
    if (!o) {
        return;
    }
    if (o->metrics) {
        pel_metrics_remove(o->metrics, collect, o);
    }
    g_source_remove(o->timer);
    close_outlets(o);
    g_free(o);
}
