#include "bridges/nmea.h"

#include <errno.h>
#include <glib-unix.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/metrics.h"
#include "base/vec.h"
#include "bridges/ais.h"
#include "bridges/endpoint.h"
#include "bridges/nmea_values.h"
#include "scene/scene.h"

#define MAX_DATAGRAM 4096
#define RECEIVE_BUFFER (4 << 20)
#define DATAGRAMS_A_TURN 64 /* then the loop serves others */
#define RECKON_NS 60000000000LL
#define WIND_MEAN_S 120.0
#define WIND_STEP_MPS 0.5
#define WIND_STEP_DEG 5.0
#define MAX_RUDDER_DEG 45.0 /* ownShip.rudder */
#define MAX_TARGETS 100
#define TARGET_ID 20000
#define TARGET_NS 600000000000LL /* a target unheard for 10 min goes */
#define TARGETS_AN_EDIT 16

struct target {
    uint32_t mmsi;    /* 0: free */
    int64_t heard_ns; /* 0: only its name is known */
    char name[40];
};

struct wind_mean {
    bool started;
    double time_s; /* simulated */
    double speed_mps, east, north;
};

struct pel_nmea {
    struct pel_nmea_options options;
    struct pel_scene *scene;
    struct pel_allow allow;
    int fd;
    uint16_t port;
    guint fd_source, tick_source;
    struct pel_nmea_counters counters;
    struct pel_nmea_values values;
    struct pel_nmea_lines lines;
    struct pel_ais_assembler assembler;
    struct target targets[MAX_TARGETS];
    struct pel_ais pending[TARGETS_AN_EDIT]; /* of the datagram at hand */
    size_t pending_count;
    int64_t now_ns; /* receipt of the datagram at hand */
    bool turning, stopped, was_stale;
    struct wind_mean mean;
    bool wind_applied;
    double applied_mps, applied_deg;
};

struct pel_nmea_options pel_nmea_default_options(void)
{
    return (struct pel_nmea_options){
        .listen = "127.0.0.1:10110",
        .entity = 1,
        .wind = PEL_NMEA_WIND_GIVEN,
    };
}

static bool apply(struct pel_nmea *nmea, Pelagos__State *state)
{
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    struct pel_fault fault;
    patch.state = state;
    if (pel_scene_patch(nmea->scene, &patch, &fault) != PEL_OK) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_WARNING, "NME-002",
                        "an edit by NMEA was refused: %s %s", fault.path,
                        fault.message);
        nmea->counters.refused_edits++;
        return false;
    }
    nmea->counters.edits++;
    return true;
}

/* What is new of own ship; the scene reckons the rest to this moment. */
static void own_ship(struct pel_nmea *nmea, Pelagos__Entity *out)
{
    struct pel_nmea_values *v = &nmea->values;
    int64_t now = nmea->now_ns;
    out->has_id = 1;
    out->id = nmea->options.entity;
    if (v->changed & PEL_NMEA_CHANGED_FIX) {
        out->has_latitude = out->has_longitude = 1;
        out->latitude = v->latitude;
        out->longitude = v->longitude;
        nmea->stopped = false;
    }
    unsigned news = pel_nmea_news(v, now);
    if (pel_nmea_heading(v, now, &out->heading)) {
        out->has_heading = (news & PEL_NMEA_NEW_HEADING) != 0;
    }
    if (pel_nmea_motion(v, now, &out->course, &out->speed)) {
        out->has_course = (news & PEL_NMEA_NEW_COURSE) != 0;
        out->has_speed = (news & PEL_NMEA_NEW_SPEED) != 0 || nmea->stopped;
        out->speed = nmea->stopped ? 0 : out->speed;
    }
    out->has_turn_rate = v->turn_rate[PEL_TURN_ROT].at_ns != 0 ||
                         v->turn_rate[PEL_TURN_VDO].at_ns != 0;
    out->turn_rate = nmea->stopped ? 0 : pel_nmea_turn_rate(v, now);
    out->has_roll = v->roll.at_ns != 0;
    out->roll = v->roll.value;
    out->has_pitch = v->pitch.at_ns != 0;
    out->pitch = v->pitch.value;
}

/* Replaces the wind by its running mean: of the speed, and of the direction as
 * a unit vector. */
static void smooth_wind(struct pel_nmea *nmea, double *deg, double *mps)
{
    struct wind_mean *m = &nmea->mean;
    double time_s = pel_scene_time(nmea->scene);
    double weight = 1;
    if (m->started && time_s >= m->time_s) {
        weight = 1 - exp(-(time_s - m->time_s) / WIND_MEAN_S);
    }
    m->started = true;
    m->time_s = time_s;
    m->speed_mps += weight * (*mps - m->speed_mps);
    m->east += weight * (sin(*deg * PEL_DEG) - m->east);
    m->north += weight * (cos(*deg * PEL_DEG) - m->north);
    *mps = m->speed_mps;
    *deg = atan2(m->east, m->north) / PEL_DEG;
    *deg += *deg < 0 ? 360 : 0;
}

/* Whether the sea shall be changed now, and to what wind. */
static bool new_wind(struct pel_nmea *nmea, double *deg, double *mps)
{
    if (nmea->options.wind == PEL_NMEA_WIND_OFF ||
        !(nmea->values.changed & PEL_NMEA_CHANGED_WIND) ||
        !pel_nmea_wind(&nmea->values, nmea->now_ns, deg, mps)) {
        return false;
    }
    double step_mps = 0, step_deg = 0;
    if (nmea->options.wind == PEL_NMEA_WIND_MEAN) {
        smooth_wind(nmea, deg, mps);
        step_mps = WIND_STEP_MPS;
        step_deg = WIND_STEP_DEG;
    }
    double turned = fabs(remainder(*deg - nmea->applied_deg, 360));
    double moved = fabs(*mps - nmea->applied_mps);
    /* A wind said again is no news: another source may have changed it. */
    return !nmea->wind_applied || (moved > 0 && moved >= step_mps) ||
           (turned > 0 && turned >= step_deg);
}

static void commit_own_ship(struct pel_nmea *nmea)
{
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Entity entity = PELAGOS__ENTITY__INIT;
    Pelagos__Entity *entities = &entity;
    Pelagos__Sea sea = PELAGOS__SEA__INIT;
    Pelagos__OwnShip orders = PELAGOS__OWN_SHIP__INIT;
    double deg, mps;
    if (nmea->values.changed & PEL_NMEA_CHANGED_POSE) {
        own_ship(nmea, &entity);
        nmea->turning = entity.has_turn_rate && entity.turn_rate != 0;
        state.n_entities = 1;
        state.entities = &entities;
    }
    bool wind = new_wind(nmea, &deg, &mps);
    if (wind) {
        sea.has_wind_speed = sea.has_wind_direction = 1;
        sea.wind_speed = mps;
        sea.wind_direction = deg;
        state.sea = &sea;
    }
    if ((nmea->values.changed & PEL_NMEA_CHANGED_RUDDER) &&
        pel_scene_state(nmea->scene)->own_ship->on) {
        orders.has_rudder = 1;
        orders.rudder = pel_clamp(nmea->values.rudder.value, -MAX_RUDDER_DEG,
                                  MAX_RUDDER_DEG);
        state.own_ship = &orders;
    }
    nmea->values.changed = 0;
    if ((state.n_entities > 0 || wind || state.own_ship) &&
        apply(nmea, &state) && wind) {
        nmea->wind_applied = true;
        nmea->applied_deg = deg;
        nmea->applied_mps = mps;
    }
}

static struct target *find_target(struct pel_nmea *nmea, uint32_t mmsi)
{
    struct target *free_slot = NULL;
    for (size_t i = 0; i < MAX_TARGETS; i++) {
        if (nmea->targets[i].mmsi == mmsi) {
            return &nmea->targets[i];
        }
        if (nmea->targets[i].mmsi == 0 && !free_slot) {
            free_slot = &nmea->targets[i];
        }
    }
    if (free_slot) {
        *free_slot = (struct target){ .mmsi = mmsi };
        snprintf(free_slot->name, sizeof free_slot->name, "mmsi-%u", mmsi);
    }
    return free_slot;
}

static void commit_targets(struct pel_nmea *nmea)
{
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Entity entities[TARGETS_AN_EDIT];
    Pelagos__Entity *list[TARGETS_AN_EDIT];
    state.entities = list;
    for (size_t i = 0; i < nmea->pending_count; i++) {
        const struct pel_ais *ais = &nmea->pending[i];
        struct target *target = find_target(nmea, ais->mmsi);
        if (!target || isnan(ais->latitude) || fabs(ais->latitude) > 85) {
            nmea->counters.ais_ignored++;
            continue;
        }
        bool moves = !isnan(ais->course) && ais->speed <= 200;
        Pelagos__Entity *e = &entities[state.n_entities];
        pelagos__entity__init(e);
        e->has_id = e->has_latitude = e->has_longitude = 1;
        e->id = TARGET_ID + (uint32_t)(target - nmea->targets);
        e->name = target->name;
        e->latitude = ais->latitude;
        e->longitude = ais->longitude;
        e->has_speed = e->has_course = e->has_turn_rate = 1;
        e->speed = moves ? ais->speed : 0;
        e->course = isnan(ais->course) ? 0 : ais->course;
        e->turn_rate = isnan(ais->turn_rate) ? 0 : ais->turn_rate;
        e->has_heading = !isnan(ais->heading) || (moves && ais->speed > 0.5);
        e->heading = isnan(ais->heading) ? e->course : ais->heading;
        target->heard_ns = nmea->now_ns;
        list[state.n_entities++] = e;
    }
    nmea->pending_count = 0;
    if (state.n_entities > 0) {
        apply(nmea, &state);
    }
}

static void take_ais(struct pel_nmea *nmea, const struct pel_nmea_sentence *s)
{
    const char *payload;
    size_t length;
    struct pel_ais ais;
    switch (pel_ais_assemble(&nmea->assembler, s, &payload, &length)) {
    case PEL_AIS_WAIT:
        return;
    case PEL_AIS_DROPPED:
        nmea->counters.ais_ignored++;
        return;
    case PEL_AIS_WHOLE:
        break;
    }
    if (!pel_ais_decode(payload, length, &ais) || ais.mmsi == 0) {
        nmea->counters.ais_ignored++;
        return;
    }
    nmea->counters.ais_messages++;
    if (s->kind == PEL_NMEA_VDO) {
        pel_nmea_values_take_ais(&nmea->values, &ais, nmea->now_ns);
        return;
    }
    if (!nmea->options.ais) {
        return;
    }
    struct target *target = find_target(nmea, ais.mmsi);
    if (target && ais.name[0]) {
        snprintf(target->name, sizeof target->name, "%s", ais.name);
    }
    if (ais.has_position_report) {
        nmea->pending[nmea->pending_count++] = ais;
        if (nmea->pending_count == TARGETS_AN_EDIT) {
            commit_targets(nmea);
        }
    }
}

static void take_line(void *user, const char *line, size_t length)
{
    struct pel_nmea *nmea = user;
    struct pel_nmea_sentence s;
    enum pel_nmea_error error = pel_nmea_parse(line, length, &s);
    if (error) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_DEBUG, "NME-003",
                        "sentence dropped, %s, %zu characters",
                        pel_nmea_error_name(error), length);
        nmea->counters.errors[error]++;
        return;
    }
    nmea->counters.sentences++;
    nmea->counters.kinds[s.kind]++;
    if (s.kind == PEL_NMEA_VDM || s.kind == PEL_NMEA_VDO) {
        take_ais(nmea, &s);
    } else {
        pel_nmea_values_take(&nmea->values, &s, nmea->now_ns);
    }
}

/* What the lines fed since the last time have changed is one edit. */
static void commit_lines(struct pel_nmea *nmea)
{
    nmea->counters.out_of_range = nmea->values.out_of_range;
    nmea->counters.void_fixes = nmea->values.void_fixes;
    if (nmea->values.changed) {
        commit_own_ship(nmea);
    }
    if (nmea->pending_count > 0) {
        commit_targets(nmea);
    }
}

void pel_nmea_feed(struct pel_nmea *nmea, const void *bytes, size_t size)
{
    nmea->counters.datagrams++;
    nmea->now_ns = pel_now_ns();
    pel_nmea_lines_feed(&nmea->lines, bytes, size, take_line, nmea);
    pel_nmea_lines_end(&nmea->lines, take_line, nmea);
    commit_lines(nmea);
}

void pel_nmea_feed_stream(struct pel_nmea *nmea, struct pel_nmea_lines *lines,
                          const void *bytes, size_t size)
{
    nmea->now_ns = pel_now_ns();
    pel_nmea_lines_feed(lines, bytes, size, take_line, nmea);
    commit_lines(nmea);
}

static gboolean on_readable(gint fd, GIOCondition condition, gpointer user)
{
    (void)condition;
    struct pel_nmea *nmea = user;
    for (int i = 0; i < DATAGRAMS_A_TURN; i++) {
        char bytes[MAX_DATAGRAM];
        struct sockaddr_storage peer = { 0 };
        socklen_t peer_size = sizeof peer;
        ssize_t size = recvfrom(fd, bytes, sizeof bytes, MSG_TRUNC,
                                (struct sockaddr *)&peer, &peer_size);
        if (size < 0) {
            break; /* nothing more, or an ICMP error of someone's */
        }
        if ((size_t)size > sizeof bytes ||
            !pel_allow_has(&nmea->allow, (struct sockaddr *)&peer)) {
            static struct pel_log_limit limit;
            pel_log_limited(&limit, PEL_LOG_WARNING, "NME-004",
                            "datagram refused: %zd bytes, of a sender %s", size,
                            (size_t)size > sizeof bytes ? "that sends too many"
                                                        : "not in the list");
            nmea->counters.refused_datagrams++;
            continue;
        }
        pel_nmea_feed(nmea, bytes, (size_t)size);
    }
    return G_SOURCE_CONTINUE;
}

static void expire_targets(struct pel_nmea *nmea)
{
    for (size_t i = 0; i < MAX_TARGETS; i++) {
        struct target *t = &nmea->targets[i];
        if (t->heard_ns == 0 || nmea->now_ns - t->heard_ns < TARGET_NS) {
            continue;
        }
        char path[32];
        char *paths = path;
        snprintf(path, sizeof path, "entities.%zu", TARGET_ID + i);
        Pelagos__Patch patch = PELAGOS__PATCH__INIT;
        struct pel_fault fault;
        patch.n_remove = 1;
        patch.remove = &paths;
        if (pel_scene_patch(nmea->scene, &patch, &fault) != PEL_OK) {
            nmea->counters.refused_edits++; /* somebody removed it before */
        }
        *t = (struct target){ 0 };
    }
}

/* Once a second: what silence changes. */
static gboolean on_tick(gpointer user)
{
    struct pel_nmea *nmea = user;
    struct pel_nmea_values *v = &nmea->values;
    nmea->now_ns = pel_now_ns();
    bool stop = v->fix_at_ns != 0 && nmea->now_ns - v->fix_at_ns > RECKON_NS;
    bool turn_ends = nmea->turning && pel_nmea_turn_rate(v, nmea->now_ns) == 0;
    if ((stop && !nmea->stopped) || turn_ends) {
        nmea->stopped = nmea->stopped || stop;
        v->changed |= PEL_NMEA_CHANGED_POSE;
        commit_own_ship(nmea);
    }
    struct pel_nmea_status status;
    pel_nmea_status(nmea, &status);
    if (status.stale && !nmea->was_stale) {
        pel_warn("NME-005", "position is stale: no fix for %.0f s",
                 status.fix_age_s);
    } else if (!status.stale && nmea->was_stale) {
        pel_info("NME-006", "position is fresh again");
    }
    if (status.stale != nmea->was_stale) {
        pel_scene_set_stale(nmea->scene, PEL_STALE_NMEA, status.stale);
    }
    nmea->was_stale = status.stale;
    expire_targets(nmea);
    return G_SOURCE_CONTINUE;
}

static void collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_nmea *nmea = user;
    const struct pel_nmea_counters *c = &nmea->counters;
    char label[64];
    for (int i = 0; i < PEL_NMEA_KIND_COUNT; i++) {
        snprintf(label, sizeof label, "kind=\"%s\"",
                 pel_nmea_kind_name((enum pel_nmea_kind)i));
        pel_metric(page, "pelagos_nmea_sentences_total", PEL_METRIC_COUNTER,
                   "NMEA sentences read, by kind.", label, (double)c->kinds[i]);
    }
    for (int i = 1; i < PEL_NMEA_ERROR_COUNT; i++) {
        snprintf(label, sizeof label, "reason=\"%s\"",
                 pel_nmea_error_name((enum pel_nmea_error)i));
        pel_metric(page, "pelagos_nmea_dropped_total", PEL_METRIC_COUNTER,
                   "NMEA sentences that could not be read, by reason.", label,
                   (double)c->errors[i]);
    }
    const struct {
        const char *name, *help;
        uint64_t value;
    } counters[] = {
        { "pelagos_nmea_datagrams_total", "NMEA datagrams taken.",
          c->datagrams },
        { "pelagos_nmea_refused_datagrams_total",
          "NMEA datagrams of a sender not allowed, or too long.",
          c->refused_datagrams },
        { "pelagos_nmea_out_of_range_total",
          "Values in NMEA sentences outside the schema's range.",
          c->out_of_range },
        { "pelagos_nmea_void_fixes_total",
          "NMEA position sentences without a fix.", c->void_fixes },
        { "pelagos_nmea_edits_total", "Changes of the scene by NMEA.",
          c->edits },
        { "pelagos_nmea_refused_edits_total",
          "Changes by NMEA that the scene refused.", c->refused_edits },
        { "pelagos_nmea_ais_messages_total", "AIS messages decoded.",
          c->ais_messages },
        { "pelagos_nmea_ais_ignored_total",
          "AIS messages of other types, incomplete or damaged.",
          c->ais_ignored },
    };
    for (size_t i = 0; i < sizeof counters / sizeof counters[0]; i++) {
        pel_metric(page, counters[i].name, PEL_METRIC_COUNTER, counters[i].help,
                   NULL, (double)counters[i].value);
    }
    struct pel_nmea_status s;
    pel_nmea_status(nmea, &s);
    pel_metric(page, "pelagos_nmea_stale", PEL_METRIC_GAUGE,
               "1 when there was a fix, but none in the last 10 s.", NULL,
               s.stale);
    pel_metric(page, "pelagos_nmea_fix_age_seconds", PEL_METRIC_GAUGE,
               "Time since the last fix; -1: never.", NULL, s.fix_age_s);
    pel_metric(page, "pelagos_nmea_ais_targets", PEL_METRIC_GAUGE,
               "AIS targets shown.", NULL, (double)s.ais_targets);
    if (!isnan(s.depth_m)) {
        pel_metric(page, "pelagos_nmea_depth_meters", PEL_METRIC_GAUGE,
                   "Depth of water that DPT or DBT gave last.", NULL,
                   s.depth_m);
    }
    if (!isnan(s.rudder_deg)) {
        pel_metric(page, "pelagos_nmea_rudder_degrees", PEL_METRIC_GAUGE,
                   "Rudder angle that RSA gave last, starboard positive.", NULL,
                   s.rudder_deg);
    }
}

enum pel_err pel_nmea_create(const struct pel_nmea_options *options,
                             struct pel_scene *scene, struct pel_nmea **out,
                             struct pel_fault *fault)
{
    if (options->entity > 65535) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "nmea-entity: %u is not in 0..65535",
                             options->entity);
    }
    struct pel_nmea *nmea = g_new0(struct pel_nmea, 1);
    nmea->options = *options;
    nmea->scene = scene;
    nmea->fd = -1;
    enum pel_err err = pel_allow_parse(options->allow, &nmea->allow, fault);
    if (!err && options->listen) {
        err = pel_endpoint_open("nmea", options->listen, options->allow,
                                SOCK_DGRAM, &nmea->fd, &nmea->port, fault);
    }
    if (err) {
        pel_nmea_destroy(nmea);
        return err;
    }
    if (nmea->fd >= 0) {
        /* A log at a hundred times its pace comes in bursts; more than the
         * system's limit is not given, and no error. */
        int bytes = RECEIVE_BUFFER;
        setsockopt(nmea->fd, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
        nmea->fd_source = g_unix_fd_add(nmea->fd, G_IO_IN, on_readable, nmea);
        pel_info("NME-001", "NMEA 0183 on UDP %s, port %u, moves entity %u",
                 options->listen, nmea->port, options->entity);
    }
    nmea->tick_source = g_timeout_add_seconds(1, on_tick, nmea);
    if (options->metrics) {
        pel_metrics_add(options->metrics, collect, nmea);
    }
    *out = nmea;
    return PEL_OK;
}

void pel_nmea_destroy(struct pel_nmea *nmea)
{
    if (!nmea) {
        return;
    }
    if (nmea->tick_source) {
        g_source_remove(nmea->tick_source);
        if (nmea->options.metrics) {
            pel_metrics_remove(nmea->options.metrics, collect, nmea);
        }
    }
    if (nmea->fd_source) {
        g_source_remove(nmea->fd_source);
    }
    if (nmea->fd >= 0) {
        close(nmea->fd);
    }
    g_free(nmea);
}

const struct pel_nmea_counters *pel_nmea_counters(const struct pel_nmea *nmea)
{
    return &nmea->counters;
}

void pel_nmea_status(const struct pel_nmea *nmea,
                     struct pel_nmea_status *status)
{
    const struct pel_nmea_values *v = &nmea->values;
    int64_t now = pel_now_ns();
    *status = (struct pel_nmea_status){
        .fix_fresh =
            v->fix_at_ns != 0 && now - v->fix_at_ns <= PEL_NMEA_FRESH_NS,
        .attitude_fresh =
            pel_nmea_fresh(&v->roll, now) || pel_nmea_fresh(&v->pitch, now),
        .fix_age_s = v->fix_at_ns ? (double)(now - v->fix_at_ns) * 1e-9 : -1,
        .depth_m = v->depth.at_ns ? v->depth.value : NAN,
        .rudder_deg = v->rudder.at_ns ? v->rudder.value : NAN,
    };
    for (int i = 0; i < PEL_HEADINGS; i++) {
        status->heading_fresh |= pel_nmea_fresh(&v->heading[i], now);
    }
    for (int i = 0; i < PEL_WINDS; i++) {
        status->wind_fresh |= pel_nmea_fresh(&v->wind_speed[i], now);
    }
    status->stale = v->fix_at_ns != 0 && !status->fix_fresh;
    for (size_t i = 0; i < MAX_TARGETS; i++) {
        status->ais_targets += nmea->targets[i].heard_ns != 0;
    }
}

uint16_t pel_nmea_port(const struct pel_nmea *nmea)
{
    return nmea->port;
}
