/* pelagosd: options, wiring, signals. */
#include <glib-unix.h>
#include <glib.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/heap.h"
#include "base/hostport.h"
#include "base/log.h"
#include "base/metrics.h"
#include "base/reserve.h"
#include "base/trial.h"
#include "base/urgent.h"
#include "base/watch.h"
#include "bridges/cigi.h"
#include "bridges/console.h"
#include "bridges/modbus.h"
#include "bridges/nmea.h"
#include "bridges/nmea_out.h"
#include "bridges/nmea_tcp.h"
#include "cluster/cluster.h"
#include "frames/debrief.h"
#include "frames/frames.h"
#include "net/net.h"
#include "options.h"
#include "scene/exercise.h"
#include "scene/recorder.h"
#include "scene/scene.h"
#include "scene/weatherlead.h"
#include "service.h"

#define EXIT_USAGE 2
#define DRAIN_MS 2000

struct daemon {
    int argc;
    char **argv;
    struct pel_options options;
    int64_t started_ns;
    GMainLoop *loop;
    struct pel_scene *scene;
    bool kept; /* the state, at the end */
    struct pel_frames *frames;
    struct pel_sealedlog *sealed; /* NULL: nothing of an exercise is recorded */
    struct pel_recorder *recorder;
    struct pel_debrief *debrief;
    struct pel_exercises *exercises;
    struct pel_cluster *cluster; /* NULL: a daemon by itself */
    struct pel_weather_lead *weather;
    struct pel_metrics *metrics;
    struct pel_net *net;
    struct pel_modbus *modbus;
    struct pel_console *console;
    struct pel_nmea *nmea;
    struct pel_nmea_tcp *nmea_tcp;
    struct pel_nmea_out *nmea_out;
    struct pel_cigi *cigi;
    struct pel_service *service;
    char http_host[PEL_HOST_SIZE], tcp_host[PEL_HOST_SIZE],
        rtsp_host[PEL_HOST_SIZE]; /* the net keeps pointers */
    char **http_hosts, **origins, **proxies, **relays;
    bool stopping;
};

static const char *or_null(const char *text)
{
    return *text ? text : NULL;
}

/* --- parts --------------------------------------------------------------- */

static enum pel_err start_realtime(struct daemon *d, struct pel_fault *fault)
{
    bool real;
    enum pel_realtime mode = (enum pel_realtime)d->options.realtime;
    enum pel_err err = pel_urgent_init(mode, &real, fault);
    if (err == PEL_OK && mode == PEL_REALTIME_AUTO && !real) {
        pel_info("DMN-013", "no real time for answers: while pictures are "
                            "drawn on the processor they may wait some ms "
                            "longer; LimitRTPRIO=2 (systemd) or ulimit -r 2 "
                            "permits it, --realtime off silences this");
    }
    return err;
}

static bool in_exercise(const struct daemon *d)
{
    return *d->options.exercise && strcmp(d->options.exercise, "off") != 0;
}

static struct pel_scene_options scene_options(const struct daemon *d)
{
    return (struct pel_scene_options){
        .state_path = or_null(d->options.state),
        .journal_goes_on = d->options.journal_full == 1,
        .wave_count = d->options.waves,
        .spectra = or_null(d->options.spectra),
        .bathymetry = or_null(d->options.bathymetry),
        .models = or_null(d->options.models),
        .weather = or_null(d->options.weather),
        .panoramas = or_null(d->options.panoramas),
        .sealed = in_exercise(d),
    };
}

static enum pel_err start_scene(struct daemon *d, struct pel_fault *fault)
{
    const struct pel_scene_options options = scene_options(d);
    enum pel_err err = pel_scene_create(&options, &d->scene, fault);
    if (err == PEL_OK) {
        pel_metrics_add(d->metrics, pel_scene_collect, d->scene);
    }
    return err;
}

static struct pel_frames_options frames_options(const struct daemon *d)
{
    static const char *const shadings[] = { "auto", "fragment", "compute" };
    return (struct pel_frames_options){
        .device = d->options.device,
        .shader_dir = or_null(d->options.shader_dir),
        .shading = shadings[d->options.shading],
        .gl_debug = d->options.gl_debug,
        .lose_after = (unsigned)d->options.gl_lose,
        .lose_only = d->options.gl_lose_device,
        .lose_for_good = d->options.gl_lose_for_good,
        .paper_form = d->options.reflection == 1,
        .max_fps = d->options.fps,
        .quality = d->options.quality,
        .encoder_threads = d->options.encoder_threads,
        .video_encoder = d->options.video_encoder,
    };
}

static enum pel_err start_frames(struct daemon *d, struct pel_fault *fault)
{
    const struct pel_frames_options options = frames_options(d);
    enum pel_err err = pel_frames_create(&options, d->scene, &d->frames, fault);
    if (err == PEL_OK) {
        pel_metrics_add(d->metrics, pel_frames_collect, d->frames);
    }
    return err;
}

static enum pel_err start_record(struct daemon *d, struct pel_fault *fault)
{
    bool records = *d->options.record || *d->options.recordings;
    if (in_exercise(d) && records) {
        d->sealed = pel_sealedlog_create();
    }
    const struct pel_recorder_options options = {
        .record = {
            .path = or_null(d->options.record),
            .segment_mib = d->options.record_segment_mib,
            .keep = (unsigned)d->options.record_keep,
            .keep_days = d->options.record_days,
            .again_s = 10,
            .program = "pelagosd " PEL_VERSION,
            .device = pel_frames_device(d->frames),
            .wave_count = d->options.waves,
            .sealed = d->sealed,
        },
        .directory = or_null(d->options.recordings),
    };
    const struct pel_debrief_options debrief = {
        .frames = frames_options(d),
        .scene = scene_options(d),
    };
    enum pel_err err =
        pel_recorder_create(&options, d->scene, &d->recorder, fault);
    if (err == PEL_OK) {
        d->debrief = pel_debrief_create(&debrief, d->recorder);
        pel_metrics_add(d->metrics, pel_recorder_collect, d->recorder);
        pel_metrics_add(d->metrics, pel_debrief_collect, d->debrief);
    }
    return err;
}

static enum pel_err start_exercises(struct daemon *d, struct pel_fault *fault)
{
    const struct pel_exercises_options options = {
        .directory = or_null(d->options.exercises),
        /* Of several daemons, what was led goes on where the master is. */
        .state_path = in_exercise(d) ? NULL : or_null(d->options.state),
    };
    enum pel_err err =
        pel_exercises_create(&options, d->scene, &d->exercises, fault);
    if (err == PEL_OK) {
        pel_metrics_add(d->metrics, pel_exercises_collect, d->exercises);
    }
    return err;
}

static enum pel_err start_cluster(struct daemon *d, struct pel_fault *fault)
{
    const struct pel_cluster_options options = {
        .url = d->options.exercise,
        .cert = or_null(d->options.exercise_cert),
        .key = or_null(d->options.exercise_key),
        .ca = or_null(d->options.exercise_ca),
        .name = or_null(d->options.exercise_node),
        .address = *d->options.exercise_address ? d->options.exercise_address
                                                : d->options.http,
        .rank = d->options.exercise_rank,
        .spare = d->options.exercise_spare,
        .rate_hz = d->options.fps,
        .program = "pelagosd " PEL_VERSION,
        .wave_count = d->options.waves,
        .log = d->sealed,
        .exercises = d->exercises,
        .stray = (uint64_t)d->options.exercise_stray,
        .ahead_ms = d->options.exercise_clock_ms,
    };
    if (!in_exercise(d)) {
        return PEL_OK;
    }
    enum pel_err err =
        pel_cluster_create(&options, d->scene, d->frames, &d->cluster, fault);
    if (err == PEL_OK) {
        pel_metrics_add(d->metrics, pel_cluster_collect, d->cluster);
    }
    return err;
}

static enum pel_err start_weather(struct daemon *d, struct pel_fault *fault)
{
    (void)fault;
    d->weather = pel_weather_lead_create(d->scene);
    return PEL_OK;
}

static enum pel_err start_net(struct daemon *d, struct pel_fault *fault)
{
    struct pel_net_options options = {
        .unix_path = or_null(d->options.unix_path),
        .exercises = d->exercises,
        .cluster = d->cluster,
        .metrics = d->metrics,
        .debrief = d->debrief,
        .token_path = or_null(d->options.token_file),
        .tls_cert_path = or_null(d->options.tls_cert),
        .tls_key_path = or_null(d->options.tls_key),
        /* pel_options_check has seen to TLS or --plain. */
        .allow_remote = *d->options.token_file != 0,
    };
    pel_net_limits_default(&options.limits);
    if (*d->options.http &&
        pel_hostport_split(d->options.http, d->http_host, &options.http_port) ==
            PEL_HOST_NUMBER) {
        options.http_address = d->http_host;
    }
    if (*d->options.tcp &&
        pel_hostport_split(d->options.tcp, d->tcp_host, &options.tcp_port) ==
            PEL_HOST_NUMBER) {
        options.tcp_address = d->tcp_host;
    }
    if (*d->options.rtsp &&
        pel_hostport_split(d->options.rtsp, d->rtsp_host, &options.rtsp_port) ==
            PEL_HOST_NUMBER) {
        options.rtsp_address = d->rtsp_host;
    }
    if (*d->options.http_hosts) {
        d->http_hosts = pel_options_split(d->options.http_hosts);
        options.http_hosts = (const char *const *)d->http_hosts;
    }
    if (*d->options.allow_origin) {
        d->origins = pel_options_split(d->options.allow_origin);
        options.http_origins = (const char *const *)d->origins;
    }
    if (*d->options.trust_proxy) {
        d->proxies = pel_options_split(d->options.trust_proxy);
        options.http_proxies = (const char *const *)d->proxies;
    }
    if (*d->options.whep_ports) {
        (void)pel_options_split_ports(d->options.whep_ports,
                                      &options.whep_port_min,
                                      &options.whep_port_max);
    }
    if (*d->options.whep_servers) {
        d->relays = pel_options_split(d->options.whep_servers);
        options.whep_servers = (const char *const *)d->relays;
    }
    if (*d->options.whep_peers &&
        pel_allow_parse(d->options.whep_peers, &options.whep_peers, fault)) {
        return fault->code;
    }
    return pel_net_create(&options, d->scene, d->frames, &d->net, fault);
}

static enum pel_err start_nmea(struct daemon *d, struct pel_fault *fault)
{
    static const enum pel_nmea_wind winds[] = { PEL_NMEA_WIND_OFF,
                                                PEL_NMEA_WIND_GIVEN,
                                                PEL_NMEA_WIND_MEAN };
    struct pel_nmea_options options = pel_nmea_default_options();
    const struct pel_nmea_tcp_options tcp = {
        .listen = d->options.nmea_tcp,
        .allow = or_null(d->options.nmea_allow),
        .metrics = d->metrics,
    };
    options.listen = or_null(d->options.nmea);
    options.allow = or_null(d->options.nmea_allow);
    options.entity = (uint32_t)d->options.nmea_entity;
    options.wind = winds[d->options.nmea_wind];
    options.ais = d->options.nmea_ais;
    options.targets = d->options.nmea_targets;
    options.no_checksum = d->options.nmea_checksum == 1;
    options.metrics = d->metrics;
    if (!*d->options.nmea && !*d->options.nmea_tcp) {
        return PEL_OK;
    }
    enum pel_err err = pel_nmea_create(&options, d->scene, &d->nmea, fault);
    return err || !*tcp.listen
               ? err
               : pel_nmea_tcp_create(&tcp, d->nmea, &d->nmea_tcp, fault);
}

static enum pel_err start_nmea_out(struct daemon *d, struct pel_fault *fault)
{
    struct pel_nmea_out_options options = {
        .to = d->options.nmea_out,
        .rate_hz = d->options.nmea_out_rate,
        .entity = (uint32_t)d->options.nmea_entity,
        .others = (enum pel_nmea_traffic_kind)d->options.nmea_out_targets,
        .metrics = d->metrics,
    };
    if (!*d->options.nmea_out || strcmp(d->options.nmea_out, "off") == 0) {
        return PEL_OK;
    }
    return pel_nmea_out_create(&options, d->scene, &d->nmea_out, fault);
}

/* In the options' order of words. */
static const enum pel_modbus_order orders[] = {
    PEL_MODBUS_ABCD, PEL_MODBUS_CDAB, PEL_MODBUS_BADC, PEL_MODBUS_DCBA
};

static enum pel_err start_console(struct daemon *d, struct pel_fault *fault)
{
    struct pel_console_options options = pel_console_default_options();
    options.server = d->options.console;
    options.table_path = d->options.console_table;
    options.order = orders[d->options.console_order];
    options.rate_hz = d->options.console_rate;
    options.unit = d->options.console_unit;
    options.timeout_ms = d->options.console_timeout_ms;
    options.stale_ms = d->options.console_stale_ms;
    options.metrics = d->metrics;
    if (!*d->options.console) {
        return PEL_OK;
    }
    return pel_console_create(&options, d->scene, &d->console, fault);
}

static enum pel_err start_cigi(struct daemon *d, struct pel_fault *fault)
{
    struct pel_cigi_options options = pel_cigi_default_options();
    options.listen = d->options.cigi;
    options.host = or_null(d->options.cigi_host);
    options.allow = or_null(d->options.cigi_allow);
    options.entities = or_null(d->options.cigi_entities);
    options.database = d->options.cigi_database;
    options.rate_hz = d->options.cigi_rate;
    options.silence_s = d->options.cigi_silence_s;
    options.hold = d->options.cigi_gone == 1;
    options.exercises = d->exercises;
    options.metrics = d->metrics;
    if (!*d->options.cigi) {
        return PEL_OK;
    }
    return pel_cigi_create(&options, d->scene, &d->cigi, fault);
}

static void modbus_status(void *user, struct pel_modbus_status *status)
{
    struct daemon *d = user;
    struct pel_frames_stats s;
    pel_frames_get_stats(d->frames, &s);
    *status = (struct pel_modbus_status){
        .frame_number = s.frames_drawn,
        .frames_per_s = pel_frames_rate(d->frames),
        .render_ms = s.render_ms_median,
        .frames_stalled = pel_frames_stuck(d->frames),
    };
    if (d->nmea) {
        struct pel_nmea_status nmea;
        pel_nmea_status(d->nmea, &nmea);
        status->nmea_stale = nmea.stale;
        status->nmea_sentences = nmea.sentences;
        status->nmea_errors = nmea.errors;
    }
}

static enum pel_err start_modbus(struct daemon *d, struct pel_fault *fault)
{
    struct pel_modbus_options options = pel_modbus_default_options();
    options.listen = d->options.modbus;
    options.allow = or_null(d->options.modbus_allow);
    options.rtu = d->options.modbus_framing == 1;
    options.order = orders[d->options.modbus_order];
    options.units = d->options.modbus_units;
    options.safe = d->options.modbus_safe;
    options.max_clients = d->options.modbus_clients;
    options.heartbeat_ms = d->options.modbus_heartbeat_ms;
    options.extrapolate_ms = d->options.modbus_extrapolate_ms;
    options.metrics = d->metrics;
    options.exercises = d->exercises;
    options.status = modbus_status;
    options.user = d;
    if (!*d->options.modbus) {
        return PEL_OK;
    }
    return pel_modbus_create(&options, d->scene, &d->modbus, fault);
}

static enum pel_err start(struct daemon *d, struct pel_fault *fault)
{
    enum pel_err (*const parts[])(struct daemon *, struct pel_fault *) = {
        start_realtime,  start_scene,   start_frames,   start_record,
        start_exercises, start_cluster, start_weather,  start_modbus,
        start_net,       start_nmea,    start_nmea_out, start_cigi,
        start_console
    };
    d->metrics = pel_metrics_create();
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        enum pel_err err = parts[i](d, fault);
        if (err != PEL_OK) {
            return err;
        }
    }
    return PEL_OK;
}

/* False: a thread hangs, and the process cannot end in the usual way. */
static bool finish(struct daemon *d)
{
    pel_service_stopping(d->service);
    pel_modbus_destroy(d->modbus);
    pel_console_destroy(d->console);
    pel_cigi_destroy(d->cigi);
    pel_nmea_out_destroy(d->nmea_out);
    pel_nmea_tcp_destroy(d->nmea_tcp);
    pel_nmea_destroy(d->nmea);
    pel_net_destroy(d->net);
    if (d->cluster) {
        pel_metrics_remove(d->metrics, pel_cluster_collect, d->cluster);
    }
    pel_cluster_destroy(d->cluster);
    if (d->frames) {
        pel_metrics_remove(d->metrics, pel_frames_collect, d->frames);
    }
    if (d->exercises) {
        pel_metrics_remove(d->metrics, pel_exercises_collect, d->exercises);
    }
    pel_exercises_destroy(d->exercises);
    pel_weather_lead_destroy(d->weather);
    if (d->debrief) {
        pel_metrics_remove(d->metrics, pel_recorder_collect, d->recorder);
        pel_metrics_remove(d->metrics, pel_debrief_collect, d->debrief);
    }
    bool joined = pel_debrief_destroy(d->debrief);
    pel_recorder_destroy(d->recorder);
    pel_sealedlog_destroy(d->sealed);
    joined = pel_frames_destroy(d->frames) && joined;
    if (d->scene) {
        pel_metrics_remove(d->metrics, pel_scene_collect, d->scene);
    }
    d->kept = pel_scene_destroy(d->scene);
    if (joined) {
        pel_metrics_destroy(d->metrics);
        g_strfreev(d->http_hosts);
        g_strfreev(d->origins);
        g_strfreev(d->proxies);
        g_strfreev(d->relays);
        g_main_loop_unref(d->loop);
    }
    return joined;
}

/* --- signals -------------------------------------------------------------- */

static void drained(void *user)
{
    struct daemon *d = user;
    g_main_loop_quit(d->loop);
}

static gboolean terminate(gpointer user)
{
    PEL_WATCH("service");
    struct daemon *d = user;
    if (d->stopping) {
        g_main_loop_quit(d->loop); /* asked twice */
        return G_SOURCE_CONTINUE;
    }
    pel_info("DMN-008", "stopping");
    d->stopping = true;
    pel_net_drain(d->net, DRAIN_MS, drained, d);
    return G_SOURCE_CONTINUE;
}

static void apply_live(struct daemon *d, const struct pel_options *fresh)
{
    d->options.log_level = fresh->log_level;
    d->options.fps = fresh->fps;
    d->options.quality = fresh->quality;
    pel_log_set_level((enum pel_log_level)d->options.log_level);
    pel_frames_set_max_fps(d->frames, d->options.fps);
    if (d->cluster) {
        pel_cluster_set_rate(d->cluster, d->options.fps);
    }
    pel_frames_set_quality(d->frames, d->options.quality);
}

static gboolean reload(gpointer user)
{
    PEL_WATCH("options");
    struct daemon *d = user;
    struct pel_options fresh;
    enum pel_options_action action;
    struct pel_fault fault;
    if (pel_options_read(d->argc, d->argv, &fresh, &action, &fault) != PEL_OK) {
        pel_error("DMN-020", "options stay as they were: %s", fault.message);
        return G_SOURCE_CONTINUE;
    }
    pel_options_log_changes(&d->options, &fresh);
    apply_live(d, &fresh);
    pel_net_reload(d->net);
    pel_info("DMN-022", "options read again");
    return G_SOURCE_CONTINUE;
}

static void ready(void *user)
{
    struct daemon *d = user;
    if (!d->stopping) {
        d->service = pel_service_ready(d->frames);
        pel_net_ready(d->net);
    }
}

/* --- main ----------------------------------------------------------------- */

static struct pel_urgent control; /* GLib's poll function has no data */

static gint account_and_poll(GPollFD *fds, guint count, gint timeout)
{
    pel_urgent_account(&control);
    pel_watch_sleep();
    gint ready = g_poll(fds, count, timeout);
    pel_watch_wake();
    return ready;
}

static int run(struct daemon *d)
{
    struct pel_fault fault = { 0 };
    int status = EXIT_SUCCESS;
    d->loop = g_main_loop_new(NULL, FALSE);
    (void)pel_reserve_whole(); /* else tried again by the first edit */
    pel_info("DMN-001", "pelagosd %s", PEL_VERSION);
    /* Before anybody can know that we are there. */
    g_unix_signal_add(SIGTERM, terminate, d);
    g_unix_signal_add(SIGINT, terminate, d);
    g_unix_signal_add(SIGHUP, reload, d);
    if (pel_service_limits(&fault) != PEL_OK || start(d, &fault) != PEL_OK) {
        pel_error("DMN-009", "cannot start: %s", fault.message);
        status = EXIT_FAILURE;
    } else {
        pel_service_warm_up(d->frames, d->scene, d->started_ns, ready, d);
        pel_heap_begin();
        pel_urgent_begin(&control, PEL_URGENT_CONTROL);
        pel_watch_begin();
        pel_metrics_add(d->metrics, pel_watch_collect, NULL);
        g_main_context_set_poll_func(NULL, account_and_poll);
        g_main_loop_run(d->loop);
        pel_heap_end();
    }
    bool joined = finish(d);
    status = d->kept ? status : EXIT_FAILURE;
    if (!joined) {
        _exit(status);
    }
    return status;
}

/* Everything is made as for a start, but for what would show outside. */
static int check(struct daemon *d)
{
    struct pel_fault fault = { 0 };
    pel_trial_begin();
    if (d->options.log_level > PEL_LOG_WARNING) {
        pel_log_set_level(PEL_LOG_WARNING); /* nothing has begun */
    }
    d->loop = g_main_loop_new(NULL, FALSE);
    bool good =
        pel_service_limits(&fault) == PEL_OK && start(d, &fault) == PEL_OK;
    bool joined = finish(d);
    if (good) {
        printf("the options are good\n");
    } else {
        fprintf(stderr, "pelagosd: cannot start: %s\n", fault.message);
    }
    fflush(stdout);
    if (!joined) {
        _exit(good ? EXIT_SUCCESS : EXIT_FAILURE);
    }
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}

int main(int argc, char **argv)
{
    static struct daemon d;
    enum pel_options_action action;
    struct pel_fault fault = { 0 };
    pel_heap_settle();
    d.started_ns = pel_now_ns();
    d.argc = argc;
    d.argv = argv;
    if (pel_options_read(argc, argv, &d.options, &action, &fault) != PEL_OK) {
        fprintf(stderr, "pelagosd: %s\n", fault.message);
        return EXIT_USAGE;
    }
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); /* ulimit -f: EFBIG, as a disk that is full */
    pel_log_set_format((enum pel_log_format)d.options.log_format);
    pel_log_set_level((enum pel_log_level)d.options.log_level);
    switch (action) {
    case PEL_ACTION_RUN:
        return run(&d);
    case PEL_ACTION_HELP:
        pel_options_print_help(stdout);
        break;
    case PEL_ACTION_VERSION:
        printf("pelagosd %s\n", PEL_VERSION);
        break;
    case PEL_ACTION_MAN:
        pel_options_print_man(stdout);
        break;
    case PEL_ACTION_COMPLETION:
        pel_options_print_completion(stdout);
        break;
    case PEL_ACTION_CONFIG:
        pel_options_print_config(stdout, &d.options);
        break;
    case PEL_ACTION_CHECK:
        return check(&d);
    }
    return EXIT_SUCCESS;
}
