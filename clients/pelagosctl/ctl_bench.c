/* bench: how fast the running pelagosd hands out pictures. */
#include "pelagosctl/ctl.h"

#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "base/clock.h"
#include "base/urgent.h"

#define MAX_VIEWS 64
#define MAX_FRAMES 100000
#define MAX_DEVICES 16

/* One view asked for as fast as the answers come; one thread each. */
struct asker {
    const char *server, *view;
    uint32_t width, height;
    int64_t end_ns;
    GArray *render_ms, *answer_ms; /* double */
    GArray *devices;               /* guint, of each picture */
    struct pel_client_error error; /* code OK: none */
};

static enum pel_client_code ask(struct asker *asker, struct pel_client *client)
{
    Pelagos__FrameRequest request = PELAGOS__FRAME_REQUEST__INIT;
    request.view = (char *)asker->view;
    request.has_width = request.has_height = 1;
    request.width = asker->width;
    request.height = asker->height;
    bool first = true;
    while (first || (pel_now_ns() < asker->end_ns &&
                     asker->render_ms->len < MAX_FRAMES)) {
        int64_t start_ns = pel_now_ns();
        Pelagos__Frame *frame = NULL;
        enum pel_client_code code =
            pel_client_frame(client, &request, &frame, &asker->error);
        if (code != PEL_CLIENT_OK) {
            return code;
        }
        double render_ms = frame->render_ms;
        guint device = frame->device;
        double answer_ms = (double)(pel_now_ns() - start_ns) * 1e-6;
        pelagos__frame__free_unpacked(frame, NULL);
        /* The first of a size pays for its buffers. */
        if (!first) {
            g_array_append_val(asker->render_ms, render_ms);
            g_array_append_val(asker->devices, device);
            g_array_append_val(asker->answer_ms, answer_ms);
        }
        first = false;
    }
    return PEL_CLIENT_OK;
}

static gpointer run_asker(gpointer data)
{
    struct asker *asker = data;
    struct pel_client *client = NULL;
    if (pel_client_connect(asker->server, 30000, &client, &asker->error) ==
        PEL_CLIENT_OK) {
        if (ask(asker, client) == PEL_CLIENT_OK) {
            asker->error.code = PEL_CLIENT_OK;
        }
    }
    pel_client_close(client);
    return NULL;
}

/* Surface queries beside the pictures, 60 a second, until `stop`. */
struct pointer {
    const char *server;
    guint points;
    gint stop;
    bool real;         /* ran in real time, as a simulator's loop may */
    GArray *answer_ms; /* double */
    struct pel_client_error error;
};

/* A ship's hull under way: a grid that moves. */
static void place_points(double (*points)[2], guint count, guint turn)
{
    for (guint i = 0; i < count; i++) {
        points[i][0] = i % 40 * 0.5 + turn * 0.1;
        points[i][1] = i / 40 * 4.0;
    }
}

static enum pel_client_code point(struct pointer *pointer,
                                  struct pel_client *client)
{
    g_autofree double(*points)[2] = g_malloc_n(pointer->points, sizeof *points);
    for (guint turn = 0; !g_atomic_int_get(&pointer->stop); turn++) {
        place_points(points, pointer->points, turn);
        int64_t start_ns = pel_now_ns();
        Pelagos__Surface *surface = NULL;
        enum pel_client_code code = pel_client_surface(
            client, points, pointer->points, NULL, &surface, &pointer->error);
        if (code != PEL_CLIENT_OK) {
            return code;
        }
        int64_t spent_ns = pel_now_ns() - start_ns;
        double ms = (double)spent_ns * 1e-6;
        pelagos__surface__free_unpacked(surface, NULL);
        g_array_append_val(pointer->answer_ms, ms);
        if (spent_ns < 16666667) {
            g_usleep((gulong)(16666667 - spent_ns) / 1000);
        }
    }
    return PEL_CLIENT_OK;
}

static gpointer run_pointer(gpointer data)
{
    struct pointer *pointer = data;
    struct pel_client *client = NULL;
    struct pel_urgent urgent;
    pel_urgent_begin(&urgent, PEL_URGENT_CONTROL);
    pointer->real = urgent.real;
    if (pel_client_connect(pointer->server, 30000, &client, &pointer->error) ==
        PEL_CLIENT_OK) {
        if (point(pointer, client) == PEL_CLIENT_OK) {
            pointer->error.code = PEL_CLIENT_OK;
        }
    }
    pel_client_close(client);
    return NULL;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Nearest-rank percentile; sorts. */
static double percentile(GArray *values, double p)
{
    if (values->len == 0) {
        return 0.0;
    }
    qsort(values->data, values->len, sizeof(double), compare);
    guint rank = (guint)(p * (values->len - 1) + 0.5);
    return g_array_index(values, double, rank);
}

struct row {
    uint32_t width, height;
    guint views, points, frames;
    double seconds, render_median, render_p95, answer_median, answer_p95;
    double points_median, points_p99; /* ms of a query of `points` */
    bool points_real;                 /* the asker ran in real time */
    GArray *device_ms[MAX_DEVICES];   /* double, of what each drew; or NULL */
};

/* What each device drew, where pictures came from several. */
static void print_devices(const struct row *row, bool json)
{
    guint several = 0;
    for (guint i = 0; i < MAX_DEVICES; i++) {
        several += row->device_ms[i] != NULL;
    }
    bool first = true;
    for (guint i = 0; i < MAX_DEVICES; i++) {
        GArray *ms = row->device_ms[i];
        if (!ms || (several < 2 && !json)) {
            continue;
        }
        double rate = ms->len / row->seconds, median = percentile(ms, 0.5);
        if (json) {
            printf("%s{\"device\":%u,\"framesPerSecond\":%.2f,"
                   "\"renderMsMedian\":%.3f,\"renderMsP95\":%.3f}",
                   first ? "" : ",", i, rate, median, percentile(ms, 0.95));
        } else {
            printf("  device %-8u %9.1f %9.1f %7.1f\n", i, rate, median,
                   percentile(ms, 0.95));
        }
        first = false;
    }
}

static void note_devices(struct row *row, const struct asker *asker)
{
    for (guint i = 0; i < asker->devices->len; i++) {
        guint device = g_array_index(asker->devices, guint, i);
        device = MIN(device, MAX_DEVICES - 1);
        if (!row->device_ms[device]) {
            row->device_ms[device] = g_array_new(FALSE, FALSE, sizeof(double));
        }
        g_array_append_vals(row->device_ms[device],
                            &g_array_index(asker->render_ms, double, i), 1);
    }
}

static void print_row(const struct row *row, bool json, bool first)
{
    double rate = row->frames / row->seconds;
    if (json) {
        printf("%s{\"width\":%u,\"height\":%u,\"views\":%u,\"frames\":%u,"
               "\"framesPerSecond\":%.2f,\"renderMsMedian\":%.3f,"
               "\"renderMsP95\":%.3f,\"answerMsMedian\":%.3f,"
               "\"answerMsP95\":%.3f,\"points\":%u,"
               "\"pointsMsMedian\":%.3f,\"pointsMsP99\":%.3f,"
               "\"pointsRealTime\":%s,\"devices\":[",
               first ? "" : ",\n", row->width, row->height, row->views,
               row->frames, rate, row->render_median, row->render_p95,
               row->answer_median, row->answer_p95, row->points,
               row->points_median, row->points_p99,
               row->points_real ? "true" : "false");
        print_devices(row, true);
        printf("]}");
        return;
    }
    char size[32];
    g_snprintf(size, sizeof size, "%ux%u", row->width, row->height);
    printf("%-11s %5u %9.1f %9.1f %7.1f %9.1f %7.1f", size, row->views, rate,
           row->render_median, row->render_p95, row->answer_median,
           row->answer_p95);
    if (row->points) {
        printf(" %9.2f %7.2f %s", row->points_median, row->points_p99,
               row->points_real ? "real time" : "normal");
    }
    printf("\n");
    print_devices(row, false);
    fflush(stdout);
}

static enum ctl_exit run_row(struct ctl *ctl, char *const *views,
                             double seconds, struct row *row)
{
    struct asker askers[MAX_VIEWS];
    GThread *threads[MAX_VIEWS];
    int64_t start_ns = pel_now_ns();
    for (guint i = 0; i < row->views; i++) {
        askers[i] = (struct asker){
            .server = pel_client_address(ctl->client),
            .view = views[i],
            .width = row->width,
            .height = row->height,
            .end_ns = start_ns + (int64_t)(seconds * 1e9),
            .render_ms = g_array_new(FALSE, FALSE, sizeof(double)),
            .answer_ms = g_array_new(FALSE, FALSE, sizeof(double)),
            .devices = g_array_new(FALSE, FALSE, sizeof(guint)),
        };
        threads[i] = g_thread_new("asker", run_asker, &askers[i]);
    }
    struct pointer pointer = {
        .server = pel_client_address(ctl->client),
        .points = row->points,
        .answer_ms = g_array_new(FALSE, FALSE, sizeof(double)),
    };
    GThread *pointing =
        row->points ? g_thread_new("pointer", run_pointer, &pointer) : NULL;
    GArray *render = g_array_new(FALSE, FALSE, sizeof(double));
    GArray *answer = g_array_new(FALSE, FALSE, sizeof(double));
    const struct pel_client_error *error = NULL;
    for (guint i = 0; i < row->views; i++) {
        g_thread_join(threads[i]);
        error =
            askers[i].error.code != PEL_CLIENT_OK ? &askers[i].error : error;
        g_array_append_vals(render, askers[i].render_ms->data,
                            askers[i].render_ms->len);
        g_array_append_vals(answer, askers[i].answer_ms->data,
                            askers[i].answer_ms->len);
        note_devices(row, &askers[i]);
        g_array_unref(askers[i].devices);
        g_array_unref(askers[i].render_ms);
        g_array_unref(askers[i].answer_ms);
    }
    row->seconds = (double)(pel_now_ns() - start_ns) * 1e-9;
    if (pointing) {
        g_atomic_int_set(&pointer.stop, 1);
        g_thread_join(pointing);
        error = pointer.error.code != PEL_CLIENT_OK ? &pointer.error : error;
    }
    row->points_median = percentile(pointer.answer_ms, 0.5);
    row->points_p99 = percentile(pointer.answer_ms, 0.99);
    row->points_real = pointer.real;
    g_array_unref(pointer.answer_ms);
    row->frames = render->len;
    row->render_median = percentile(render, 0.5);
    row->render_p95 = percentile(render, 0.95);
    row->answer_median = percentile(answer, 0.5);
    row->answer_p95 = percentile(answer, 0.95);
    g_array_unref(render);
    g_array_unref(answer);
    return error ? ctl_report(ctl, error) : CTL_DONE;
}

static enum ctl_exit run_rows(struct ctl *ctl, char *const *sizes, char **views,
                              guint points, double seconds)
{
    bool json = ctl_flag(ctl, "json");
    enum ctl_exit status = CTL_DONE;
    if (json) {
        printf("[");
    } else {
        printf("%-11s %5s %9s %9s %7s %9s %7s%s\n", "size", "views", "frames/s",
               "draw ms", "p95", "answer ms", "p95",
               points ? " points ms     p99 class" : "");
    }
    for (size_t i = 0; sizes[i] && status == CTL_DONE; i++) {
        struct row row = { .views = g_strv_length(views), .points = points };
        if (sscanf(sizes[i], "%ux%u", &row.width, &row.height) != 2) {
            return ctl_say(CTL_USAGE, "\"%s\" is not WIDTHxHEIGHT", sizes[i]);
        }
        status = run_row(ctl, views, seconds, &row);
        if (status == CTL_DONE) {
            print_row(&row, json, i == 0);
        }
        for (guint k = 0; k < MAX_DEVICES; k++) {
            g_clear_pointer(&row.device_ms[k], g_array_unref);
        }
    }
    if (json) {
        puts("]");
    }
    return status;
}

enum ctl_exit ctl_bench(struct ctl *ctl)
{
    double seconds = 3.0, points = 0.0;
    if (ctl_number(ctl, "seconds", 0.1, 600, &seconds) ||
        ctl_number(ctl, "points", 1, 10000, &points)) {
        return CTL_USAGE;
    }
    bool real;
    if (points > 0 &&
        pel_urgent_init(PEL_REALTIME_AUTO, &real, NULL) != PEL_OK) {
        return CTL_USAGE;
    }
    Pelagos__State *state = NULL;
    enum ctl_exit status = ctl_fetch(ctl, &state);
    if (status != CTL_DONE) {
        return status;
    }
    const char *names = ctl_value(ctl, "views");
    if (!names && state->n_views > 0) {
        names = state->views[0]->name;
    }
    const char *list = ctl_value(ctl, "sizes");
    g_auto(GStrv) sizes =
        g_strsplit(list ? list : "640x360,1280x720,1920x1080", ",", -1);
    g_auto(GStrv) views = g_strsplit(names ? names : "", ",", -1);
    guint count = g_strv_length(views);
    if (count == 0 || count > MAX_VIEWS) {
        status = ctl_say(CTL_USAGE, "1 to %d views are wanted", MAX_VIEWS);
    } else {
        status = run_rows(ctl, sizes, views, (guint)points, seconds);
    }
    pelagos__state__free_unpacked(state, NULL);
    return status;
}
