/* What several devices of one host draw together, through the frame path of the
 * daemon: pictures a second of views, by list of devices, and how busy its
 * threads are meanwhile, in cores.
 *
 *   bench_devices [--views 64] [--size 1280x720]
 *                 [--codec jpeg|h264|none|planes|coded]
 *                 [--ask] [--threads N] [--seconds 4] [--lose N]
 *                 [--withdraw] [--count N] [--hz 240] LIST...
 *
 * Each LIST is one of pelagosd --device. Views are live (at most --hz, 67
 * million pixels together), or with --ask each is asked for again as soon as it
 * is there, every time of another moment. The lists take turns, three times
 * each; medians. --count: one list until so many pictures, and what they leave
 * of heap, descriptors and threads. --lose: the last device of each list
 * pretends to be lost every N pictures; with --withdraw it is not to be had
 * again after the first N. --codec none: views are drawn and read back by a
 * thread a device and no more, frames 1/30 s apart, each device its share of
 * the views; planes: as JPEG's encoder takes them; coded: as its scan. */
#include <dirent.h>
#include <getopt.h>
#include <malloc.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <glib.h>

#include "base/clock.h"
#include "base/log.h"
#include "frames/core.h"
#include "scene/scene.h"

#define MOST_LISTS 8
#define ROUNDS 3
#define WARM_S 2.0
#define FIRST_WARM_S 6.0 /* programs are made */

static struct {
    int views, threads, lose;
    unsigned width, height;
    bool h264, drawn, ask, withdraw;
    enum pel_ycbcr form; /* of what is drawn and no more */
    double seconds, hz;
    uint64_t count;
} options = {
    .views = 64, .width = 1280, .height = 720, .seconds = 4, .hz = 240
};

struct viewer {
    char name[16];
    struct pel_subscription *live;
    int64_t last_ns;
    int device; /* that drew the last one */
};

static struct pel_scene *scene;
static struct pel_frames *frames;
static struct viewer viewers[PEL_MAX_VIEWS];
static uint64_t pictures, failures, moment;
static uint64_t by_device[16];
static int losing; /* the last device, which --lose is of */
/* Between two pictures of a view; and of a view whose pictures both came from
 * devices that are not lost. */
static int64_t worst_ns, worst_kept_ns;

static void die(const char *what, const struct pel_fault *fault)
{
    fprintf(stderr, "bench_devices: %s: %s\n", what,
            fault ? fault->message : "");
    exit(1);
}

static void ask(struct viewer *viewer);

static void on_picture(void *user, enum pel_err err,
                       const struct pel_fault *fault, struct pel_frame *frame)
{
    struct viewer *viewer = user;
    (void)fault;
    if (err == PEL_OK) {
        int64_t now = pel_now_ns();
        int64_t gap = viewer->last_ns ? now - viewer->last_ns : 0;
        bool kept = viewer->device != losing && (int)frame->device != losing;
        worst_ns = gap > worst_ns ? gap : worst_ns;
        worst_kept_ns = kept && gap > worst_kept_ns ? gap : worst_kept_ns;
        viewer->last_ns = now;
        viewer->device = (int)frame->device;
        pictures++;
        by_device[frame->device % 16]++;
    } else {
        failures++;
    }
    if (options.ask) {
        ask(viewer);
    }
}

static void ask(struct viewer *viewer)
{
    Pelagos__FrameRequest request = PELAGOS__FRAME_REQUEST__INIT;
    struct pel_fault fault;
    request.view = viewer->name;
    request.has_time = true;
    request.time = (double)moment++ / 30;
    if (pel_frames_request(frames, &request, on_picture, viewer, NULL,
                           &fault) != PEL_OK) {
        die("a request", &fault);
    }
}

static void run_for(double seconds)
{
    int64_t end = pel_now_ns() + (int64_t)(seconds * 1e9);
    while (pel_now_ns() < end) {
        g_main_context_iteration(NULL, TRUE);
    }
}

static gboolean nudge(gpointer user)
{
    (void)user;
    return G_SOURCE_CONTINUE;
}

static void make_scene(void)
{
    struct pel_scene_options o = { .wave_count = 60 };
    struct pel_fault fault;
    if (pel_scene_create(&o, &scene, &fault) != PEL_OK) {
        die("the scene", &fault);
    }
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Sea sea = PELAGOS__SEA__INIT;
    sea.has_synthesiser = sea.has_wind_speed = true;
    sea.synthesiser = PELAGOS__SYNTHESISER__FFT;
    sea.wind_speed = 8;
    state.sea = &sea;
    Pelagos__View views[PEL_MAX_VIEWS], *list[PEL_MAX_VIEWS];
    for (int i = 0; i < options.views; i++) {
        pelagos__view__init(&views[i]);
        /* The first takes the place of the state's own. */
        snprintf(viewers[i].name, sizeof viewers[i].name, i ? "v%d" : "bridge",
                 i);
        views[i].name = viewers[i].name;
        views[i].has_width = views[i].has_height = views[i].has_yaw = true;
        views[i].has_entity = views[i].has_up = true;
        views[i].entity = 1;
        views[i].up = 12;
        views[i].width = options.width;
        views[i].height = options.height;
        views[i].yaw = -170.0 + 340.0 * i / options.views;
        list[i] = &views[i];
    }
    state.n_views = (size_t)options.views;
    state.views = list;
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    patch.state = &state;
    if (pel_scene_patch(scene, &patch, &fault) != PEL_OK) {
        die(fault.path, &fault);
    }
}

static void begin(const char *list)
{
    losing = 0;
    for (const char *c = list; *c; c++) {
        losing += *c == ',';
    }
    struct pel_frames_options o = {
        .device = list,
        .max_fps = options.hz,
        .quality = 1,
        .encoder_threads = options.threads,
        .lose_after = (unsigned)options.lose,
        .lose_only = options.lose ? losing : -1,
        .lose_for_good = options.withdraw,
    };
    struct pel_fault fault;
    if (pel_frames_create(&o, scene, &frames, &fault) != PEL_OK) {
        die(list, &fault);
    }
    const struct pel_profile profile = {
        .codec = options.h264 ? PEL_CODEC_H264 : PEL_CODEC_PICTURE,
        .quality = 80,
        .kbps = options.h264 ? 5000 : 0,
    };
    for (int i = 0; i < options.views; i++) {
        viewers[i].last_ns = 0;
        if (options.ask) {
            ask(&viewers[i]);
        } else if (pel_frames_open(frames, viewers[i].name, &profile,
                                   on_picture, &viewers[i], &viewers[i].live,
                                   &fault) != PEL_OK) {
            die(viewers[i].name, &fault);
        }
    }
}

static void end(void)
{
    for (int i = 0; i < options.views && !options.ask; i++) {
        pel_frames_unsubscribe(viewers[i].live);
    }
    options.ask = options.ask && frames == NULL;
    if (!pel_frames_destroy(frames)) {
        _exit(1);
    }
    frames = NULL;
}

static void reset(void)
{
    pictures = failures = 0;
    worst_ns = worst_kept_ns = 0;
    memset(by_device, 0, sizeof by_device);
}

/* --- how busy threads are --------------------------------------------------
 */

#define MANY_NAMES 64
struct busy {
    char name[16];
    double ticks;
    int threads;
};

/* Processor time of all threads, by name. */
static int look_at_threads(struct busy out[MANY_NAMES])
{
    int count = 0;
    DIR *d = opendir("/proc/self/task");
    for (struct dirent *e; d && (e = readdir(d));) {
        char path[288], name[16] = "";
        unsigned long user = 0, system = 0;
        snprintf(path, sizeof path, "/proc/self/task/%s/stat", e->d_name);
        FILE *f = fopen(path, "r");
        if (!f) {
            continue;
        }
        int got = fscanf(f,
                         "%*d (%15[^)]) %*c %*d %*d %*d %*d %*d %*u %*u %*u "
                         "%*u %*u %lu %lu",
                         name, &user, &system);
        fclose(f);
        int i = 0;
        while (i < count && strcmp(out[i].name, name) != 0) {
            i++;
        }
        if (got != 3 || i == MANY_NAMES) {
            continue;
        }
        if (i == count) {
            count++;
            snprintf(out[i].name, sizeof out[i].name, "%s", name);
            out[i].ticks = out[i].threads = 0;
        }
        out[i].ticks += (double)(user + system);
        out[i].threads++;
    }
    if (d) {
        closedir(d);
    }
    return count;
}

static void say_busy(const struct busy *before, int count, double seconds)
{
    struct busy now[MANY_NAMES];
    int all = look_at_threads(now);
    printf("    cores:");
    for (int i = 0; i < all; i++) {
        double ticks = now[i].ticks;
        for (int k = 0; k < count; k++) {
            ticks -=
                strcmp(now[i].name, before[k].name) == 0 ? before[k].ticks : 0;
        }
        double cores = ticks / (double)sysconf(_SC_CLK_TCK) / seconds;
        if (cores > 0.02) {
            printf(" %s %.2f of %d", now[i].name, cores, now[i].threads);
        }
    }
    printf("\n");
}

/* --- drawing alone ----------------------------------------------------------
 */

static atomic_bool drawing;

struct drawer {
    pthread_t thread;
    char device[16];
    int first, views;
    atomic_ullong pictures;
    uint64_t bits; /* of the first view at time 0 */
};

/* FNV-1a. */
static uint64_t bits_of(const struct pel_picture *picture)
{
    uint64_t bits = 0xcbf29ce484222325u;
    const uint8_t *bytes = picture->rgba ? picture->rgba : picture->planes[0];
    size_t size =
        (picture->rgba ? 4 : 1) * (size_t)picture->width * picture->height;
    if (picture->ycbcr == PEL_YCBCR_CODED) { /* its first group's */
        bytes = (const uint8_t *)picture->scan.words;
        size = 4 + picture->scan.words[0] / 8;
    }
    for (size_t i = 0; i < size; i++) {
        bits = (bits ^ bytes[i]) * 0x100000001b3u;
    }
    return bits;
}

static void take(struct drawer *self, struct pel_renderer *r, int64_t wait_ns)
{
    struct pel_picture *picture = pel_renderer_collect(r, wait_ns);
    if (picture) {
        self->bits = self->bits ? self->bits : bits_of(picture);
        atomic_fetch_add(&self->pictures, 1);
        pel_picture_release(picture);
    }
}

static void *draw_alone(void *argument)
{
    struct drawer *self = argument;
    const struct pel_renderer_options o = { .device = self->device };
    struct pel_renderer *r;
    struct pel_fault fault;
    if (pel_renderer_create(&o, &r, &fault) != PEL_OK) {
        die(self->device, &fault);
    }
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    for (int frame = 0; atomic_load(&drawing); frame++) {
        double time_s = (double)frame / 30;
        size_t first = frame > 0 ? (size_t)self->first : 0;
        struct pel_environment env = pel_environment_of(s, time_s);
        pel_environment_light(s, &env);
        env.sea = pel_snapshot_sea(s);
        /* At once, as the daemon's render threads do. */
        struct pel_draw draws[PEL_MAX_VIEWS];
        for (int i = 0; i < self->views; i++) {
            draws[i] = (struct pel_draw){
                .layers = PEL_LAYER_COLOR,
                .ycbcr = options.form,
                .quality = 80,
            };
            pel_snapshot_camera(s, first + (size_t)i, time_s, 0, 0,
                                &draws[i].camera);
        }
        while (pel_renderer_submit(r, &env, draws, (size_t)self->views) ==
               PEL_ERR_BUSY) {
            take(self, r, 100000000);
        }
        while (pel_renderer_in_flight(r) > (size_t)self->views) {
            take(self, r, 100000000);
        }
    }
    while (pel_renderer_in_flight(r) > 0) {
        take(self, r, 100000000);
    }
    pel_snapshot_unref(s);
    pel_renderer_destroy(r);
    return NULL;
}

static double measure_drawn(const char *list)
{
    struct drawer drawers[16];
    int count = 0;
    for (const char *at = list; count < 16; at++) {
        size_t length = strcspn(at, ",");
        snprintf(drawers[count++].device, sizeof drawers[0].device, "%.*s",
                 (int)length, at);
        at += length;
        if (*at == 0) {
            break;
        }
    }
    atomic_store(&drawing, true);
    for (int i = 0; i < count; i++) {
        struct drawer *d = &drawers[i];
        d->first = options.views * i / count;
        d->views = options.views * (i + 1) / count - d->first;
        atomic_init(&d->pictures, 0);
        d->bits = 0;
        if (pthread_create(&d->thread, NULL, draw_alone, d) != 0) {
            die("a thread", NULL);
        }
        pthread_setname_np(d->thread, "draw");
    }
    usleep((useconds_t)(WARM_S * 2e6));
    unsigned long long first[16], sum = 0;
    for (int i = 0; i < count; i++) {
        first[i] = atomic_load(&drawers[i].pictures);
    }
    struct busy before[MANY_NAMES];
    int names = look_at_threads(before);
    int64_t began = pel_now_ns();
    usleep((useconds_t)(options.seconds * 1e6));
    double seconds = (double)(pel_now_ns() - began) * 1e-9;
    printf("  %-12s by device", list);
    for (int i = 0; i < count; i++) {
        unsigned long long own = atomic_load(&drawers[i].pictures) - first[i];
        printf(" %llu", own);
        sum += own;
    }
    bool alike = true;
    for (int i = 1; i < count; i++) {
        alike = alike && drawers[i].bits == drawers[0].bits;
    }
    printf(": %.0f pictures/s, first pictures %s (%016llx)\n",
           (double)sum / seconds, alike ? "the same to the bit" : "DIFFER",
           (unsigned long long)drawers[0].bits);
    say_busy(before, names, seconds);
    fflush(stdout);
    atomic_store(&drawing, false);
    for (int i = 0; i < count; i++) {
        pthread_join(drawers[i].thread, NULL);
    }
    return (double)sum / seconds;
}

/* --- the frame path ---------------------------------------------------------
 */

static double measure(const char *list, int round)
{
    if (options.drawn) {
        return measure_drawn(list);
    }
    bool asks = options.ask;
    begin(list);
    run_for(round == 0 ? FIRST_WARM_S : WARM_S);
    reset();
    struct busy before[MANY_NAMES];
    int names = look_at_threads(before);
    struct pel_frames_stats first, s;
    pel_frames_get_stats(frames, &first);
    int64_t began = pel_now_ns();
    run_for(options.seconds);
    double seconds = (double)(pel_now_ns() - began) * 1e-9;
    double rate = (double)pictures / seconds;
    printf("  %-12s %8.0f pictures/s, by device", list, rate);
    for (int i = 0; i < 16; i++) {
        if (by_device[i]) {
            printf(" %llu", (unsigned long long)by_device[i]);
        }
    }
    pel_frames_get_stats(frames, &s);
    printf("; %.1f ms between two at most, %.1f of views beside the last "
           "device's, %llu failed, %llu losses meanwhile\n",
           (double)worst_ns * 1e-6, (double)worst_kept_ns * 1e-6,
           (unsigned long long)failures,
           (unsigned long long)(s.losses - first.losses));
    say_busy(before, names, seconds);
    fflush(stdout);
    end();
    options.ask = asks;
    return rate;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int entries(const char *path)
{
    int count = 0;
    DIR *d = opendir(path);
    while (d && readdir(d)) {
        count++;
    }
    if (d) {
        closedir(d);
    }
    return count;
}

static void count_on(const char *list)
{
    begin(list);
    run_for(20);
    reset();
    struct mallinfo2 first = mallinfo2();
    int fds = entries("/proc/self/fd"), tasks = entries("/proc/self/task");
    int64_t began = pel_now_ns();
    for (uint64_t said = 0; pictures < options.count;) {
        g_main_context_iteration(NULL, TRUE);
        if (pictures - said >= options.count / 10) {
            said = pictures;
            struct mallinfo2 now = mallinfo2();
            printf("%9llu pictures, %5.0f/s, heap %+9.1f kB, %+d descriptors, "
                   "%+d threads\n",
                   (unsigned long long)pictures,
                   (double)pictures / ((double)(pel_now_ns() - began) * 1e-9),
                   ((double)now.uordblks - (double)first.uordblks) * 1e-3,
                   entries("/proc/self/fd") - fds,
                   entries("/proc/self/task") - tasks);
            fflush(stdout);
        }
    }
    struct mallinfo2 now = mallinfo2();
    printf("%llu pictures, %llu failed: %.4f byte of heap each\n",
           (unsigned long long)pictures, (unsigned long long)failures,
           ((double)now.uordblks - (double)first.uordblks) / (double)pictures);
    end();
}

static void read_options(int argc, char **argv)
{
    static const struct option table[] = {
        { "views", required_argument, NULL, 'v' },
        { "size", required_argument, NULL, 's' },
        { "codec", required_argument, NULL, 'c' },
        { "seconds", required_argument, NULL, 't' },
        { "threads", required_argument, NULL, 'n' },
        { "lose", required_argument, NULL, 'l' },
        { "withdraw", no_argument, NULL, 'w' },
        { "count", required_argument, NULL, 'k' },
        { "ask", no_argument, NULL, 'a' },
        { "hz", required_argument, NULL, 'h' },
        { 0 },
    };
    for (int c; (c = getopt_long(argc, argv, "", table, NULL)) != -1;) {
        switch (c) {
        case 'v':
            options.views = atoi(optarg);
            break;
        case 's':
            if (sscanf(optarg, "%ux%u", &options.width, &options.height) != 2) {
                die("--size is WIDTHxHEIGHT", NULL);
            }
            break;
        case 'c':
            options.h264 = strcmp(optarg, "h264") == 0;
            options.form = strcmp(optarg, "planes") == 0  ? PEL_YCBCR_JPEG
                           : strcmp(optarg, "coded") == 0 ? PEL_YCBCR_CODED
                                                          : PEL_YCBCR_NONE;
            options.drawn =
                strcmp(optarg, "none") == 0 || options.form != PEL_YCBCR_NONE;
            break;
        case 't':
            options.seconds = strtod(optarg, NULL);
            break;
        case 'n':
            options.threads = atoi(optarg);
            break;
        case 'l':
            options.lose = atoi(optarg);
            break;
        case 'w':
            options.withdraw = true;
            break;
        case 'k':
            options.count = strtoull(optarg, NULL, 10);
            break;
        case 'a':
            options.ask = true;
            break;
        case 'h':
            options.hz = strtod(optarg, NULL);
            break;
        default:
            exit(2);
        }
    }
    if (options.views < 1 || options.views > PEL_MAX_VIEWS) {
        die("--views is 1 to 64", NULL);
    }
    if (optind == argc || argc - optind > MOST_LISTS) {
        die("1 to 8 lists of devices are wanted", NULL);
    }
}

int main(int argc, char **argv)
{
    read_options(argc, argv);
    pel_log_set_level(PEL_LOG_ERROR);
    g_timeout_add(20, nudge, NULL);
    make_scene();
    if (options.count) {
        count_on(argv[optind]);
        pel_scene_destroy(scene);
        return failures > 0;
    }
    int lists = argc - optind;
    double rate[MOST_LISTS][ROUNDS];
    printf("%d views of %ux%u, %s, %s\n", options.views, options.width,
           options.height,
           options.drawn  ? "drawn"
           : options.h264 ? "H.264"
                          : "JPEG",
           options.ask ? "asked for" : "live");
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = 0; i < lists; i++) {
            rate[i][round] = measure(argv[optind + i], round);
        }
    }
    for (int i = 0; i < lists; i++) {
        qsort(rate[i], ROUNDS, sizeof rate[i][0], by_value);
        printf("%-12s median %8.0f pictures/s, %.2f times %s\n",
               argv[optind + i], rate[i][ROUNDS / 2],
               rate[i][ROUNDS / 2] / rate[0][ROUNDS / 2], argv[optind]);
    }
    pel_scene_destroy(scene);
    return 0;
}
