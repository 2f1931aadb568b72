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
#include "base/watch.h"
#include "bridges/ais.h"
#include "bridges/endpoint.h"
#include "bridges/nmea_fleet.h"
#include "bridges/nmea_targets.h"
#include "bridges/nmea_values.h"
#include "scene/helm.h"
#include "scene/scene.h"

#define MAX_DATAGRAM PEL_BOUND_NMEA_DATAGRAM_BYTES
#define RECEIVE_BUFFER (4 << 20)
#define DATAGRAMS_A_TURN 64 /* then the loop serves others */
#define RECKON_NS 60000000000LL
/* A network that takes datagrams round each other does so within moments; a
 * clock that goes further back was set, or a log begins again. */
#define LATE_S 5.0
#define LATE_NS 2000000000LL
#define DAY_S 86400.0
#define WIND_MEAN_S 120.0
#define WIND_STEP_MPS 0.5
#define WIND_STEP_DEG 5.0
#define MAX_RUDDER_DEG 45.0 /* ownShip.rudder */

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
    struct newest {
        double utc_s; /* of the day */
        int64_t at_ns;
    } newest[PEL_NMEA_KIND_COUNT];
    bool late; /* the rest of the datagram at hand */
    struct pel_ais_assembler assembler;
    struct pel_nmea_targets targets;
    int64_t now_ns; /* receipt of the datagram at hand */
    bool moved;     /* NMEA set these: */
    double set_speed, set_turn_rate;
    bool silent, was_stale; /* no fix for RECKON_NS; for PEL_NMEA_FRESH_NS */
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

static void count_edit(struct pel_nmea *nmea, enum pel_err err,
                       const struct pel_fault *fault)
{
    static struct pel_log_limit limit;
    if (err) {
        pel_log_limited(&limit, PEL_LOG_WARNING, "NME-002",
                        "an edit by NMEA was refused: %s %s", fault->path,
                        fault->message);
        nmea->counters.refused_edits++;
    } else {
        nmea->counters.edits++;
    }
}

static bool apply(struct pel_nmea *nmea, Pelagos__State *state)
{
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    struct pel_fault fault;
    patch.state = state;
    enum pel_err err = pel_scene_patch(nmea->scene, &patch, &fault);
    count_edit(nmea, err, &fault);
    return !err;
}

static void on_wind(void *user, enum pel_err err, const struct pel_fault *fault)
{
    struct pel_nmea *nmea = user;
    count_edit(nmea, err, fault);
    nmea->wind_applied = nmea->wind_applied && !err;
}

/* An edit of its own: its sea is built first, and the ship does not wait. */
static void apply_wind(struct pel_nmea *nmea, double mps, double deg)
{
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Sea sea = PELAGOS__SEA__INIT;
    const struct pel_scene_wish wish = { .patch = &patch, .source = nmea };
    patch.state = &state;
    state.sea = &sea;
    sea.has_wind_speed = sea.has_wind_direction = 1;
    sea.wind_speed = mps;
    sea.wind_direction = deg;
    nmea->wind_applied = true;
    nmea->applied_deg = deg;
    nmea->applied_mps = mps;
    pel_scene_submit(nmea->scene, &wish, on_wind, nmea);
}

static bool came_now(const struct pel_nmea *nmea,
                     const struct pel_nmea_value *value)
{
    return value->at_ns == nmea->now_ns;
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
        nmea->silent = false;
    }
    unsigned news = pel_nmea_news(v, now);
    if (pel_nmea_heading(v, now, &out->heading)) {
        out->has_heading = (news & PEL_NMEA_NEW_HEADING) != 0;
    }
    if (pel_nmea_motion(v, now, &out->course, &out->speed)) {
        out->has_course = (news & PEL_NMEA_NEW_COURSE) != 0;
        out->has_speed = (news & PEL_NMEA_NEW_SPEED) != 0;
        out->speed = nmea->silent ? 0 : out->speed;
    }
    out->turn_rate = nmea->silent ? 0 : pel_nmea_turn_rate(v, now);
    out->has_turn_rate = came_now(nmea, &v->turn_rate[PEL_TURN_ROT]) ||
                         came_now(nmea, &v->turn_rate[PEL_TURN_VDO]) ||
                         (nmea->set_turn_rate != 0 && out->turn_rate == 0);
    out->has_roll = came_now(nmea, &v->roll);
    out->roll = v->roll.value;
    out->has_pitch = came_now(nmea, &v->pitch);
    out->pitch = v->pitch.value;
    out->has_altitude = came_now(nmea, &v->heave);
    out->altitude = v->heave.value;
}

static const Pelagos__Entity *entity_now(struct pel_nmea *nmea)
{
    const Pelagos__State *state = pel_scene_state(nmea->scene);
    for (size_t i = 0; i < state->n_entities; i++) {
        if (state->entities[i]->id == nmea->options.entity) {
            return state->entities[i];
        }
    }
    return NULL;
}

static bool model_leads(struct pel_nmea *nmea)
{
    return pel_helm_of(pel_scene_state(nmea->scene), nmea->options.entity);
}

/* Who moves the entity, for the log; NULL: nobody but NMEA. */
static const char *other_leader(struct pel_nmea *nmea)
{
    const Pelagos__Entity *e = entity_now(nmea);
    if (!e) {
        return "nobody: it was removed";
    }
    if (model_leads(nmea)) {
        return "a helm that is on (ownShip, entities.*.helm)";
    }
    return nmea->moved && e->speed == nmea->set_speed &&
                   e->turn_rate == nmea->set_turn_rate
               ? NULL
               : "another client or bridge";
}

/* Remembers the motion that the last edit left. */
static void remember_motion(struct pel_nmea *nmea)
{
    const Pelagos__Entity *e = entity_now(nmea);
    nmea->moved = e != NULL;
    nmea->set_speed = e ? e->speed : 0;
    nmea->set_turn_rate = e ? e->turn_rate : 0;
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
    /* A repeated wind changes nothing: another source may have set its own. */
    return !nmea->wind_applied || (moved > 0 && moved >= step_mps) ||
           (turned > 0 && turned >= step_deg);
}

/* Brings the order to the helm that is on: the entity's, else ownShip. The
 * patch has room for the entity. */
static void steer(struct pel_nmea *nmea, Pelagos__OwnShip *orders,
                  Pelagos__State *patch)
{
    const Pelagos__State *now = pel_scene_state(nmea->scene);
    const Pelagos__OwnShip *helm = pel_helm_of(now, nmea->options.entity);
    if (helm && helm != now->own_ship) {
        patch->entities[0]->has_id = 1;
        patch->entities[0]->id = nmea->options.entity;
        patch->entities[0]->helm = orders;
        patch->n_entities = 1;
    } else if (now->own_ship->on) {
        patch->own_ship = orders;
    }
}

static void commit_own_ship(struct pel_nmea *nmea)
{
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Entity entity = PELAGOS__ENTITY__INIT;
    Pelagos__Entity *entities = &entity;
    Pelagos__OwnShip orders = PELAGOS__OWN_SHIP__INIT;
    double deg, mps;
    state.entities = &entities;
    if (nmea->values.changed & PEL_NMEA_CHANGED_POSE) {
        own_ship(nmea, &entity);
        state.n_entities = 1;
    }
    bool pose = state.n_entities > 0;
    bool takes_over = pose && model_leads(nmea);
    if (new_wind(nmea, &deg, &mps)) {
        apply_wind(nmea, mps, deg);
    }
    if (nmea->values.changed & PEL_NMEA_CHANGED_RUDDER) {
        orders.has_rudder = 1;
        orders.rudder = pel_clamp(nmea->values.rudder.value, -MAX_RUDDER_DEG,
                                  MAX_RUDDER_DEG);
        steer(nmea, &orders, &state);
    }
    nmea->values.changed = 0;
    if ((state.n_entities == 0 && !state.own_ship) || !apply(nmea, &state)) {
        return;
    }
    if (pose) {
        remember_motion(nmea);
    }
    if (takes_over && !model_leads(nmea)) {
        pel_info("NME-008",
                 "NMEA moves entity %u again; its helm is off (on of ownShip "
                 "or entities.*.helm)",
                 nmea->options.entity);
    }
}

/* Ends the speed, or only the rate of turn, that NMEA set. */
static void stop(struct pel_nmea *nmea, bool speed)
{
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Entity entity = PELAGOS__ENTITY__INIT;
    Pelagos__Entity *entities = &entity;
    state.n_entities = 1;
    state.entities = &entities;
    entity.has_id = entity.has_turn_rate = 1;
    entity.id = nmea->options.entity;
    entity.has_speed = speed;
    if (apply(nmea, &state)) {
        remember_motion(nmea);
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
    if (nmea->options.ais) {
        pel_nmea_targets_take_ais(&nmea->targets, &ais, nmea->now_ns);
    }
}

static bool says_fix(enum pel_nmea_kind kind)
{
    return kind == PEL_NMEA_RMC || kind == PEL_NMEA_GGA ||
           kind == PEL_NMEA_GNS || kind == PEL_NMEA_GLL;
}

/* Whether a fix of this kind with a later time came a moment ago. */
static bool is_late(struct pel_nmea *nmea, const struct pel_nmea_sentence *s)
{
    struct newest *newest = &nmea->newest[s->kind];
    if (!says_fix(s->kind) || !isfinite(s->utc_s)) {
        return false;
    }
    double behind_s = remainder(newest->utc_s - s->utc_s, DAY_S);
    if (newest->at_ns != 0 && nmea->now_ns - newest->at_ns < LATE_NS &&
        behind_s > 0 && behind_s < LATE_S) {
        return true;
    }
    *newest = (struct newest){ s->utc_s, nmea->now_ns };
    return false;
}

/* A line that has no checksum, with the one that it should have. */
static enum pel_nmea_error parse_bare(const char *line, size_t length,
                                      struct pel_nmea_sentence *out)
{
    char text[PEL_NMEA_MAX_SENTENCE + 4];
    const char *begin = line;
    unsigned sum = 0;
    while (length > 0 && line[length - 1] == ' ') {
        length--;
    }
    for (const char *p = line; p < line + length; p++) {
        begin = *p == '$' || *p == '!' ? p + 1 : begin;
    }
    if (length + 3 > PEL_NMEA_MAX_SENTENCE ||
        memchr(begin, '*', (size_t)(line + length - begin))) {
        return PEL_NMEA_NO_CHECKSUM;
    }
    for (const char *p = begin; p < line + length; p++) {
        sum ^= (unsigned char)*p;
    }
    memcpy(text, line, length);
    snprintf(text + length, 4, "*%02X", sum & 0xff);
    return pel_nmea_parse(text, length + 3, out);
}

static enum pel_nmea_error parse(struct pel_nmea *nmea, const char *line,
                                 size_t length, struct pel_nmea_sentence *out)
{
    enum pel_nmea_error error = pel_nmea_parse(line, length, out);
    if (error == PEL_NMEA_NO_CHECKSUM && nmea->options.no_checksum) {
        error = parse_bare(line, length, out);
        nmea->counters.unchecked += error == PEL_NMEA_OK;
    }
    return error;
}

static void take_line(void *user, const char *line, size_t length)
{
    struct pel_nmea *nmea = user;
    struct pel_nmea_sentence s;
    enum pel_nmea_error error = parse(nmea, line, length, &s);
    if (error) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_DEBUG, "NME-003",
                        "sentence dropped, %s, %zu characters",
                        pel_nmea_error_name(error), length);
        nmea->counters.errors[error]++;
        return;
    }
    nmea->counters.sentences++;
    nmea->counters.resynchronised += s.resynchronised;
    nmea->counters.kinds[s.kind]++;
    if (nmea->late || is_late(nmea, &s)) {
        nmea->counters.late += !nmea->late;
        nmea->late = true;
        return;
    }
    if (s.kind == PEL_NMEA_VDM || s.kind == PEL_NMEA_VDO) {
        take_ais(nmea, &s);
    } else if (s.kind != PEL_NMEA_TTM && s.kind != PEL_NMEA_TLL) {
        pel_nmea_values_take(&nmea->values, &s, nmea->now_ns);
    } else if (nmea->options.ais) {
        pel_nmea_targets_take_radar(&nmea->targets, &s, nmea->now_ns);
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
    pel_nmea_targets_commit(&nmea->targets, nmea->now_ns);
}

void pel_nmea_feed(struct pel_nmea *nmea, const void *bytes, size_t size)
{
    nmea->counters.datagrams++;
    nmea->now_ns = pel_now_ns();
    nmea->late = false;
    pel_nmea_lines_feed(&nmea->lines, bytes, size, take_line, nmea);
    pel_nmea_lines_end(&nmea->lines, take_line, nmea);
    commit_lines(nmea);
}

void pel_nmea_feed_stream(struct pel_nmea *nmea, struct pel_nmea_lines *lines,
                          const void *bytes, size_t size)
{
    nmea->now_ns = pel_now_ns();
    pel_nmea_lines_feed(lines, bytes, size, take_line, nmea);
    nmea->late = false;
    commit_lines(nmea);
}

static gboolean on_readable(gint fd, GIOCondition condition, gpointer user)
{
    PEL_WATCH("nmea");
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
                            "datagram of %zd bytes refused: %s", size,
                            (size_t)size > sizeof bytes
                                ? "too long"
                                : "its sender is not in --nmea-allow");
            nmea->counters.refused_datagrams++;
            continue;
        }
        pel_nmea_feed(nmea, bytes, (size_t)size);
    }
    return G_SOURCE_CONTINUE;
}

static void status_at(const struct pel_nmea *nmea, int64_t now,
                      struct pel_nmea_status *status)
{
    const struct pel_nmea_values *v = &nmea->values;
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
    status->targets = pel_nmea_targets_count(&nmea->targets);
    status->known = pel_nmea_targets_known(&nmea->targets);
}

/* The fix has become stale: what becomes of the ship, in the log. */
static void say_stale(struct pel_nmea *nmea, double age_s)
{
    const char *leader = other_leader(nmea);
    char what[80];
    if (leader) {
        snprintf(what, sizeof what, "is moved by %s and goes on", leader);
    } else {
        snprintf(what, sizeof what,
                 "goes on by its last speed and stops %d s after the fix",
                 (int)(RECKON_NS / 1000000000));
    }
    pel_warn("NME-005", "position is stale: no fix for %.0f s; entity %u %s",
             age_s, nmea->options.entity, what);
}

/* The end of dead reckoning. Only a motion of NMEA's own is stopped. */
static void fall_silent(struct pel_nmea *nmea)
{
    const char *leader = other_leader(nmea);
    nmea->silent = true;
    if (leader) {
        pel_info("NME-009",
                 "no fix for %d s; entity %u is not stopped, it is moved by %s",
                 (int)(RECKON_NS / 1000000000), nmea->options.entity, leader);
        return;
    }
    stop(nmea, true);
    pel_warn("NME-010", "no fix for %d s; entity %u is stopped",
             (int)(RECKON_NS / 1000000000), nmea->options.entity);
}

void pel_nmea_tick(struct pel_nmea *nmea, int64_t now_ns)
{
    struct pel_nmea_values *v = &nmea->values;
    struct pel_nmea_status status;
    nmea->now_ns = now_ns;
    status_at(nmea, now_ns, &status);
    if (status.stale && !nmea->was_stale) {
        say_stale(nmea, status.fix_age_s);
    } else if (!status.stale && nmea->was_stale) {
        pel_info("NME-006", "position is fresh again");
    }
    if (status.stale != nmea->was_stale) {
        pel_scene_set_stale(nmea->scene, PEL_STALE_NMEA, status.stale);
    }
    nmea->was_stale = status.stale;
    if (!nmea->silent && v->fix_at_ns != 0 &&
        nmea->now_ns - v->fix_at_ns > RECKON_NS) {
        fall_silent(nmea);
    }
    if (nmea->moved && nmea->set_turn_rate != 0 &&
        pel_nmea_turn_rate(v, nmea->now_ns) == 0) {
        if (!other_leader(nmea)) {
            stop(nmea, false);
        }
        nmea->set_turn_rate = 0;
    }
    pel_nmea_targets_expire(&nmea->targets, nmea->now_ns);
}

static gboolean on_tick(gpointer user)
{
    PEL_WATCH("nmea");
    pel_nmea_tick(user, pel_now_ns());
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
          c->edits + c->targets.edits },
        { "pelagos_nmea_refused_edits_total",
          "Changes by NMEA that the scene refused.",
          c->refused_edits + c->targets.refused_edits },
        { "pelagos_nmea_ais_messages_total", "AIS messages decoded.",
          c->ais_messages },
        { "pelagos_nmea_unchecked_total",
          "Sentences without a checksum, taken all the same.", c->unchecked },
        { "pelagos_nmea_ais_ignored_total",
          "AIS messages of other types, incomplete or damaged.",
          c->ais_ignored + c->targets.ignored },
        { "pelagos_nmea_late_total",
          "NMEA datagrams that came behind a newer one.", c->late },
        { "pelagos_nmea_resynchronised_total",
          "Sentences read after what a broken line left before them.",
          c->resynchronised },
        { "pelagos_nmea_targets_evicted_total",
          "AIS and radar targets that gave way to nearer or newer ones.",
          c->targets.evicted },
        { "pelagos_nmea_targets_refused_total",
          "AIS and radar targets farther than all, with every place taken.",
          c->targets.refused },
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
               "AIS and radar targets shown.", NULL, (double)s.targets);
    pel_metric(page, "pelagos_nmea_ais_known", PEL_METRIC_GAUGE,
               "AIS targets known, shown or not, and radar targets shown.",
               NULL, (double)s.known);
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
    nmea->targets.scene = scene;
    nmea->targets.own_ship = options->entity;
    nmea->targets.counters = &nmea->counters.targets;
    if (options->ais && options->targets > PEL_NMEA_TARGETS) {
        nmea->targets.fleet = pel_nmea_fleet_create(
            (size_t)MIN(options->targets, PEL_NMEA_FLEET));
    }
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
    pel_scene_forget(nmea->scene, nmea);
    pel_nmea_targets_finish(&nmea->targets);
    pel_nmea_fleet_destroy(nmea->targets.fleet);
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
    status_at(nmea, pel_now_ns(), status);
    status->sentences = nmea->counters.sentences;
    for (size_t i = 0; i < PEL_NMEA_ERROR_COUNT; i++) {
        status->errors += nmea->counters.errors[i];
    }
}

uint16_t pel_nmea_port(const struct pel_nmea *nmea)
{
    return nmea->port;
}
