/* What streams cost: views rendered, read back and encoded at once, and which
 * of these is the limit; the encoders' own cost and what comes with it here.
 *
 *   bench_streams [--device NAME] [--views 1,8,32,64] [--seconds 3]
 *                 [--sea trochoids|fft] [--threads N] [--json FILE]
 *
 * The renderer and the encoders are the daemon's, from mapped readback buffers
 * to bytes; one encoder a view, a thread a core, nothing left out: what is full
 * waits. docs/benchmarks.md says what each figure is. */
#include <getopt.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>
#include <turbojpeg.h>

#include "base/clock.h"
#include "base/log.h"
#include "encode/encode.h"
#include "encode/planes.h"
#include "encode/video.h"
#include "frames/pictureplanes.h"
#include "tests/bench/scene.h"

#define WIDTH 1280
#define HEIGHT 720
#define KBPS 5000
#define QUALITY 80
#define MAX_VIEWS 64
#define MAX_THREADS 64
#define QUEUED 2 /* pictures that wait for one view's encoder */
#define WAIT_NS 60000000000
#define SAMPLES 24 /* pictures for the encoders alone */

/* As the daemon does it; and JPEGs of planes, which processors code where the
 * device cannot. */
enum work { WORK_NONE, WORK_JPEG, WORK_H264, WORK_PLANES, WORKS };
static const char *const work_names[] = { "none", "JPEG", "H.264", "planes" };
static const char *const work_keys[] = { "none", "jpeg", "h264", "planes" };

static struct {
    const char *device, *json, *views;
    double seconds;
    int threads;
    bool fft;
} options = {
    "software", "build/bench-streams.json", "1,8,32,64", 3.0, 0, false
};

static struct pel_renderer *renderer;
static struct pel_sea sea;

static void die(const char *what)
{
    fprintf(stderr, "bench_streams: %s\n", what);
    exit(1);
}

/* --- encoders, each view's pictures in order ------------------------------ */

struct view {
    struct pel_video *video;
    struct pel_picture *queue[QUEUED];
    unsigned count;
};

static struct {
    pthread_mutex_t lock; /* protects queues, ended */
    /* Each wakes one thread: where all woke, at each picture, half of what this
     * measures was their waking. */
    pthread_cond_t work_for[MAX_THREADS], room;
    struct view views[MAX_VIEWS];
    size_t view_count;
    int threads;
    bool ended;
    enum work work;
    atomic_ullong pictures, bytes;
} line = { .lock = PTHREAD_MUTEX_INITIALIZER,
           .room = PTHREAD_COND_INITIALIZER };

static size_t encode(struct pel_video *video, const struct pel_picture *p,
                     enum work work)
{
    struct pel_bytes bytes = { 0 };
    enum pel_err err = PEL_OK;
    struct pel_planes_given given;
    const struct pel_planes_given *planes =
        pel_picture_planes(p, &given) ? &given : NULL;
    if (work == WORK_JPEG || work == WORK_PLANES) {
        const struct pel_encode_input in = { .rgba = p->rgba,
                                             .planes = planes,
                                             .scan = pel_picture_scan(p),
                                             .width = p->width,
                                             .height = p->height,
                                             .quality = QUALITY };
        err = pel_jpeg_encode(&in, &bytes);
    } else if (work == WORK_H264) {
        const struct pel_video_picture picture = {
            .rgba = p->rgba,
            .planes = planes,
            .width = p->width,
            .height = p->height,
            .stamp_ns = pel_now_ns(),
        };
        struct pel_fault fault;
        bool key;
        err = pel_video_encode(video, &picture, KBPS, &bytes, &key, &fault);
        if (err != PEL_OK) {
            die(fault.message);
        }
    }
    if (err != PEL_OK) {
        die("encoding failed");
    }
    size_t size = bytes.size;
    pel_bytes_finish(&bytes);
    return size;
}

static void *run_encoder(void *argument)
{
    size_t first = (size_t)(uintptr_t)argument;
    pthread_mutex_lock(&line.lock);
    for (;;) {
        struct view *view = NULL;
        for (size_t i = first; i < line.view_count && !view;
             i += (size_t)line.threads) {
            view = line.views[i].count > 0 ? &line.views[i] : NULL;
        }
        if (!view && line.ended) {
            break;
        }
        if (!view) {
            pthread_cond_wait(&line.work_for[first], &line.lock);
            continue;
        }
        struct pel_picture *picture = view->queue[0];
        pthread_mutex_unlock(&line.lock);
        size_t size = encode(view->video, picture, line.work);
        pel_picture_release(picture);
        atomic_fetch_add(&line.pictures, 1);
        atomic_fetch_add(&line.bytes, size);
        pthread_mutex_lock(&line.lock);
        view->queue[0] = view->queue[1];
        view->count--;
        pthread_cond_signal(&line.room);
    }
    pthread_mutex_unlock(&line.lock);
    return NULL;
}

static void hand_over(struct pel_picture *picture)
{
    struct view *view = picture->user;
    if (line.work == WORK_NONE) {
        pel_picture_release(picture);
        atomic_fetch_add(&line.pictures, 1);
        return;
    }
    pthread_mutex_lock(&line.lock);
    while (view->count == QUEUED) {
        pthread_cond_wait(&line.room, &line.lock);
    }
    view->queue[view->count++] = picture;
    pthread_cond_signal(&line.work_for[(view - line.views) % line.threads]);
    pthread_mutex_unlock(&line.lock);
}

static void start_encoders(pthread_t threads[MAX_THREADS])
{
    const struct pel_video_config config = { .fps = 30.0 };
    line.ended = false;
    for (size_t i = 0; i < line.view_count; i++) {
        line.views[i] = (struct view){ .video = pel_video_create(&config) };
    }
    for (int i = 0; i < line.threads; i++) {
        pthread_cond_init(&line.work_for[i], NULL);
        if (pthread_create(&threads[i], NULL, run_encoder,
                           (void *)(uintptr_t)i) != 0) {
            die("no thread");
        }
    }
}

static void stop_encoders(pthread_t threads[MAX_THREADS])
{
    pthread_mutex_lock(&line.lock);
    line.ended = true;
    for (int i = 0; i < line.threads; i++) {
        pthread_cond_signal(&line.work_for[i]);
    }
    pthread_mutex_unlock(&line.lock);
    for (int i = 0; i < line.threads; i++) {
        pthread_join(threads[i], NULL);
    }
    for (size_t i = 0; i < line.view_count; i++) {
        pel_video_destroy(line.views[i].video);
    }
}

/* --- frames -------------------------------------------------------------- */

static struct pel_environment environment;
static struct pel_draw draws[MAX_VIEWS];

static void set_up_views(void)
{
    struct bench_scene s = bench_default;
    s.width = WIDTH;
    s.height = HEIGHT;
    s.fft = options.fft;
    if (bench_sea(&s, &sea) != PEL_OK) {
        die("the sea cannot be built");
    }
    environment = bench_environment(&s, &sea);
    for (int i = 0; i < MAX_VIEWS; i++) {
        s.heading = 360.0 / MAX_VIEWS * i;
        draws[i] = (struct pel_draw){ .camera = bench_camera(&s),
                                      .layers = PEL_LAYER_COLOR,
                                      .user = &line.views[i] };
    }
}

static struct pel_picture *collect(void)
{
    struct pel_picture *p = pel_renderer_collect(renderer, WAIT_NS);
    if (!p) {
        die("no picture came");
    }
    return p;
}

/* One frame of all views; what was finished before goes to the encoders. */
static void draw_frame(size_t views)
{
    environment.time_s += 1.0 / 30.0;
    for (;;) {
        enum pel_err err =
            pel_renderer_submit(renderer, &environment, draws, views);
        if (err == PEL_OK) {
            break;
        }
        if (err != PEL_ERR_BUSY) {
            die("drawing failed");
        }
        if (pel_renderer_in_flight(renderer) > 0) {
            hand_over(collect());
        } else {
            usleep(200); /* the encoders hold every buffer */
        }
    }
    while (pel_renderer_in_flight(renderer) > views) {
        hand_over(collect());
    }
}

struct rate {
    double pictures; /* a second, of all views */
    double cpu_ms;   /* of all threads, a picture */
    double mbytes;   /* a second */
};

static double cpu_ms(void)
{
    struct rusage u;
    getrusage(RUSAGE_SELF, &u);
    return (double)(u.ru_utime.tv_sec + u.ru_stime.tv_sec) * 1e3 +
           (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec) * 1e-3;
}

static struct rate measure(size_t views, enum work work)
{
    pthread_t threads[MAX_THREADS] = { 0 };
    line.view_count = views;
    line.work = work;
    /* As the daemon asks; devices that make none give pixels. */
    static const enum pel_ycbcr planes[WORKS] = {
        [WORK_JPEG] = PEL_YCBCR_CODED,
        [WORK_H264] = PEL_YCBCR_VIDEO,
        [WORK_PLANES] = PEL_YCBCR_JPEG,
    };
    for (size_t i = 0; i < views; i++) {
        draws[i].ycbcr = planes[work];
        draws[i].quality = QUALITY;
    }
    start_encoders(threads);
    draw_frame(views);
    draw_frame(views);
    draw_frame(views);
    unsigned long long before = atomic_load(&line.pictures);
    unsigned long long bytes = atomic_load(&line.bytes);
    int64_t start = pel_now_ns();
    double cpu = cpu_ms();
    while ((double)(pel_now_ns() - start) * 1e-9 < options.seconds) {
        draw_frame(views);
    }
    double seconds = (double)(pel_now_ns() - start) * 1e-9;
    double pictures = (double)(atomic_load(&line.pictures) - before);
    struct rate rate = {
        .pictures = pictures / seconds,
        .cpu_ms = (cpu_ms() - cpu) / pictures,
        .mbytes = (double)(atomic_load(&line.bytes) - bytes) * 1e-6 / seconds,
    };
    while (pel_renderer_in_flight(renderer) > 0) {
        hand_over(collect());
    }
    stop_encoders(threads);
    return rate;
}

/* --- encoders without a renderer ----------------------------------------- */

static uint8_t *samples[SAMPLES];

static void take_samples(void)
{
    for (int i = 0; i < SAMPLES; i++) {
        environment.time_s += 1.0 / 30.0;
        if (pel_renderer_submit(renderer, &environment, draws, 1) != PEL_OK) {
            die("drawing failed");
        }
        struct pel_picture *p = collect();
        samples[i] = malloc((size_t)WIDTH * HEIGHT * 4);
        memcpy(samples[i], p->rgba, (size_t)WIDTH * HEIGHT * 4);
        pel_picture_release(p);
    }
}

struct alone {
    enum work work;
    double seconds;
    atomic_ullong *pictures;
};

/* There and back through the samples, so that the sea moves as it does. */
static int sample_at(int i)
{
    int at = i % (2 * SAMPLES - 2);
    return at < SAMPLES ? at : 2 * SAMPLES - 2 - at;
}

static void *encode_alone(void *argument)
{
    const struct alone *a = argument;
    const struct pel_video_config config = { .fps = 30.0 };
    struct pel_video *video = pel_video_create(&config);
    int64_t start = 0;
    for (int i = 0;; i++) {
        const struct pel_picture p = { .rgba = samples[sample_at(i)],
                                       .width = WIDTH,
                                       .height = HEIGHT };
        encode(video, &p, a->work);
        if (i == 2) {
            start = pel_now_ns();
        } else if (i > 2) {
            atomic_fetch_add(a->pictures, 1);
            if ((double)(pel_now_ns() - start) * 1e-9 > a->seconds) {
                break;
            }
        }
    }
    pel_video_destroy(video);
    return NULL;
}

/* Pictures a second by so many encoders at once. */
static double encoders_alone(enum work work, int count)
{
    atomic_ullong pictures = 0;
    struct alone a = { work, options.seconds, &pictures };
    pthread_t threads[MAX_THREADS];
    for (int i = 0; i < count; i++) {
        if (pthread_create(&threads[i], NULL, encode_alone, &a) != 0) {
            die("no thread");
        }
    }
    for (int i = 0; i < count; i++) {
        pthread_join(threads[i], NULL);
    }
    return (double)pictures / options.seconds;
}

/* --- the libraries alone ------------------------------------------------- */

/* The samples as an encoder takes them: more than the processor's caches hold,
 * as the pictures that we are given. */
static void make_planes(uint8_t *planes[SAMPLES], bool planar)
{
    size_t luma = (size_t)WIDTH * HEIGHT;
    struct pel_planes_scratch none = { 0 };
    for (int i = 0; i < SAMPLES; i++) {
        planes[i] = malloc(luma * 3 / 2);
        const struct pel_planes p = {
            .y = planes[i],
            .u = planes[i] + luma,
            .v = planar ? planes[i] + luma * 5 / 4 : NULL,
            .y_stride = WIDTH,
            .u_stride = planar ? WIDTH / 2 : WIDTH,
            .v_stride = WIDTH / 2,
            .width = WIDTH,
            .height = HEIGHT,
        };
        if (pel_planes_fill(samples[i], WIDTH * 4, WIDTH, HEIGHT, planar, &none,
                            &p) != PEL_OK) {
            die("converting failed");
        }
    }
}

static void free_planes(uint8_t *planes[SAMPLES])
{
    for (int i = 0; i < SAMPLES; i++) {
        free(planes[i]);
    }
}

/* NV12 samples straight into x264enc, as video.c sets it: CPU ms a picture. */
static double x264_ms(int rounds)
{
    GstElement *pipeline = gst_parse_launch(
        "appsrc name=in format=time max-buffers=1 block=true "
        "caps=video/x-raw,format=NV12,width=1280,height=720,framerate=30/1 ! "
        "x264enc speed-preset=ultrafast tune=zerolatency threads=1 bframes=0 "
        "key-int-max=1073741824 byte-stream=true vbv-buf-capacity=400 "
        "bitrate=5000 ! appsink name=out sync=false async=false max-buffers=4",
        NULL);
    if (!pipeline) {
        return 0.0;
    }
    GstElement *in = gst_bin_get_by_name(GST_BIN(pipeline), "in");
    GstElement *out = gst_bin_get_by_name(GST_BIN(pipeline), "out");
    size_t size = (size_t)WIDTH * HEIGHT * 3 / 2;
    uint8_t *planes[SAMPLES];
    make_planes(planes, false);
    gst_element_set_state(pipeline, GST_STATE_PLAYING);
    double cpu = 0.0;
    for (int i = 0; i < rounds + 3; i++) {
        cpu = i == 3 ? cpu_ms() : cpu;
        GstBuffer *buffer = gst_buffer_new_wrapped_full(
            GST_MEMORY_FLAG_READONLY, planes[sample_at(i)], size, 0, size, NULL,
            NULL);
        GST_BUFFER_PTS(buffer) = (GstClockTime)i * GST_SECOND / 30;
        gst_app_src_push_buffer(GST_APP_SRC(in), buffer);
        GstSample *sample = gst_app_sink_pull_sample(GST_APP_SINK(out));
        if (!sample) {
            die("x264enc gives nothing");
        }
        gst_sample_unref(sample);
    }
    cpu = (cpu_ms() - cpu) / rounds;
    gst_element_set_state(pipeline, GST_STATE_NULL);
    gst_object_unref(in);
    gst_object_unref(out);
    gst_object_unref(pipeline);
    free_planes(planes);
    return cpu;
}

/* The same of turbojpeg; cached: the planes are in the processor's caches. */
static double jpeg_ms(bool cached, int rounds)
{
    tjhandle handle = tjInitCompress();
    size_t luma = (size_t)WIDTH * HEIGHT;
    unsigned long room = tjBufSize(WIDTH, HEIGHT, TJSAMP_420);
    unsigned char *out = malloc(room);
    uint8_t *planes[SAMPLES];
    make_planes(planes, true);
    uint8_t *near = malloc(luma * 3 / 2);
    double spent = 0.0;
    for (int i = 0; i < rounds; i++) {
        uint8_t *y = planes[sample_at(i)];
        if (cached) {
            y = memcpy(near, y, luma * 3 / 2);
        }
        double cpu = cpu_ms();
        const unsigned char *parts[] = { y, y + luma, y + luma * 5 / 4 };
        const int strides[] = { WIDTH, WIDTH / 2, WIDTH / 2 };
        unsigned long size = room;
        if (tjCompressFromYUVPlanes(handle, parts, WIDTH, strides, HEIGHT,
                                    TJSAMP_420, &out, &size, QUALITY,
                                    TJFLAG_NOREALLOC) != 0) {
            die("turbojpeg gives nothing");
        }
        spent += cpu_ms() - cpu;
    }
    tjDestroy(handle);
    free(out);
    free(near);
    free_planes(planes);
    return spent / rounds;
}

static double ours_ms(enum work work, int rounds)
{
    const struct pel_video_config config = { .fps = 30.0 };
    struct pel_video *video = pel_video_create(&config);
    double cpu = 0.0;
    for (int i = 0; i < rounds + 3; i++) {
        cpu = i == 3 ? cpu_ms() : cpu;
        const struct pel_picture p = { .rgba = samples[sample_at(i)],
                                       .width = WIDTH,
                                       .height = HEIGHT };
        encode(video, &p, work);
    }
    cpu = (cpu_ms() - cpu) / rounds;
    pel_video_destroy(video);
    return cpu;
}

static double convert_ms(bool planar, int rounds)
{
    size_t luma = (size_t)WIDTH * HEIGHT;
    uint8_t *yuv = malloc(luma * 3 / 2);
    struct pel_planes_scratch none = { 0 };
    const struct pel_planes p = {
        .y = yuv,
        .u = yuv + luma,
        .v = planar ? yuv + luma * 5 / 4 : NULL,
        .y_stride = WIDTH,
        .u_stride = planar ? WIDTH / 2 : WIDTH,
        .v_stride = WIDTH / 2,
        .width = WIDTH,
        .height = HEIGHT,
    };
    double cpu = cpu_ms();
    for (int i = 0; i < rounds; i++) {
        if (pel_planes_fill(samples[sample_at(i)], WIDTH * 4, WIDTH, HEIGHT,
                            planar, &none, &p) != PEL_OK) {
            die("converting failed");
        }
    }
    cpu = (cpu_ms() - cpu) / rounds;
    free(yuv);
    return cpu;
}

/* Rounds in turns, so that what else the machine does falls on all alike; the
 * least of each, as other programs only add. */
static void bench_overhead(FILE *json)
{
    enum { TURNS = 5, ROUNDS = 60 };
    double least[7] = { 1e9, 1e9, 1e9, 1e9, 1e9, 1e9, 1e9 };
    for (int t = 0; t < TURNS; t++) {
        const double now[7] = {
            ours_ms(WORK_H264, ROUNDS), x264_ms(ROUNDS),
            convert_ms(false, ROUNDS),  ours_ms(WORK_JPEG, ROUNDS),
            jpeg_ms(false, ROUNDS),     convert_ms(true, ROUNDS),
            jpeg_ms(true, ROUNDS),
        };
        for (int i = 0; i < 7; i++) {
            least[i] = now[i] < least[i] ? now[i] : least[i];
        }
    }
    printf("\nCPU ms a picture    ours  encoder  conversion   ours over the "
           "encoder, over both\n");
    for (int k = 0; k < 2; k++) {
        const double *m = least + 3 * k;
        printf("%-17s %6.2f   %6.2f      %6.2f   %+.0f %%, %+.0f %%\n",
               work_names[k == 0 ? WORK_H264 : WORK_JPEG], m[0], m[1], m[2],
               100.0 * (m[0] / m[1] - 1.0),
               100.0 * (m[0] / (m[1] + m[2]) - 1.0));
        fprintf(json,
                "  \"%sMs\": {\"ours\": %.3f, \"encoder\": %.3f, "
                "\"conversion\": %.3f},\n",
                work_keys[k == 0 ? WORK_H264 : WORK_JPEG], m[0], m[1], m[2]);
    }
    printf("turbojpeg with its planes in the caches: %.2f, ours over it %+.0f "
           "%%\n",
           least[6], 100.0 * (least[3] / least[6] - 1.0));
    fflush(stdout);
}

/* --- the table ----------------------------------------------------------- */

/* Which stage gives fewer pictures by itself; when together they give far
 * fewer than either, they take each other's cores. */
static const char *limit_of(size_t views, double drawn, double encoded,
                            double both)
{
    int encoders = views < (size_t)line.threads ? (int)views : line.threads;
    double most = encoded * encoders / line.threads;
    double less = drawn < most ? drawn : most;
    return both < 0.8 * less ? "cores"
           : drawn < most    ? "rendering"
                             : "encoding";
}

static void bench_row(FILE *json, size_t views, const double alone[WORKS],
                      bool first)
{
    struct rate rates[WORKS];
    printf("%5zu", views);
    for (int w = 0; w < WORKS; w++) {
        rates[w] = measure(views, (enum work)w);
        printf(" | %7.1f %8.1f %6.2f", rates[w].pictures / (double)views,
               rates[w].pictures, rates[w].cpu_ms);
        fflush(stdout);
    }
    fprintf(json, "%s\n    {\"views\": %zu", first ? "" : ",", views);
    for (int w = WORK_H264; w < WORKS; w++) {
        printf(" | %s", limit_of(views, rates[WORK_NONE].pictures, alone[w],
                                 rates[w].pictures));
    }
    for (int w = 0; w < WORKS; w++) {
        fprintf(json,
                ", \"%s\": {\"picturesPerSecond\": %.1f, \"cpuMs\": %.3f, "
                "\"megabytesPerSecond\": %.2f}",
                work_keys[w], rates[w].pictures, rates[w].cpu_ms,
                rates[w].mbytes);
    }
    fprintf(json, "}");
    printf("\n");
}

static void bench_views(FILE *json)
{
    double alone[WORKS] = { 0 };
    printf("\n%d encoders at once, without a renderer, pictures a second:",
           line.threads);
    for (int w = WORK_H264; w < WORKS; w++) {
        alone[w] = encoders_alone((enum work)w, line.threads);
        printf(" %s %.0f", work_names[w], alone[w]);
        fprintf(json, "  \"%sAlonePerSecond\": %.1f,\n", work_keys[w],
                alone[w]);
    }
    printf("\n\n%5s", "views");
    for (int w = 0; w < WORKS; w++) {
        printf(" | %-7s pictures CPU ms", w == 0 ? "drawn" : work_names[w]);
    }
    printf(" | limit with H.264, with planes\n");
    fprintf(json, "  \"rows\": [");
    char list[256];
    snprintf(list, sizeof list, "%s", options.views);
    bool first = true;
    for (char *at = strtok(list, ","); at; at = strtok(NULL, ",")) {
        int views = atoi(at);
        if (views < 1 || views > MAX_VIEWS) {
            die("--views: 1 to 64");
        }
        bench_row(json, (size_t)views, alone, first);
        first = false;
    }
    fprintf(json, "\n  ]\n}\n");
}

static void parse(int argc, char **argv)
{
    static const struct option longs[] = {
        { "device", required_argument, NULL, 'd' },
        { "views", required_argument, NULL, 'v' },
        { "seconds", required_argument, NULL, 's' },
        { "sea", required_argument, NULL, 'w' },
        { "threads", required_argument, NULL, 't' },
        { "json", required_argument, NULL, 'j' },
        { 0 },
    };
    int c;
    while ((c = getopt_long(argc, argv, "", longs, NULL)) != -1) {
        switch (c) {
        case 'd':
            options.device = optarg;
            break;
        case 'v':
            options.views = optarg;
            break;
        case 's':
            options.seconds = atof(optarg);
            break;
        case 'w':
            options.fft = strcmp(optarg, "fft") == 0;
            if (!options.fft && strcmp(optarg, "trochoids") != 0) {
                die("--sea: trochoids or fft");
            }
            break;
        case 't':
            options.threads = atoi(optarg);
            break;
        case 'j':
            options.json = optarg;
            break;
        default:
            fprintf(stderr,
                    "usage: bench_streams [--device auto|software|N] "
                    "[--views 1,8,32,64] [--seconds S] "
                    "[--sea trochoids|fft] [--threads N] [--json FILE]\n");
            exit(2);
        }
    }
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    line.threads = options.threads > 0 ? options.threads : (int)cores;
    line.threads = line.threads > MAX_THREADS ? MAX_THREADS : line.threads;
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    gst_init(NULL, NULL);
    pel_log_set_level(PEL_LOG_WARNING);
    FILE *json = fopen(options.json, "w");
    if (!json) {
        die("cannot write the JSON file");
    }
    const struct pel_renderer_options o = { .device = options.device };
    struct pel_fault fault = { 0 };
    if (pel_renderer_create(&o, &renderer, &fault) != PEL_OK) {
        die(fault.message);
    }
    printf("%s, %ld cores, %dx%d, H.264 of %d kbit/s, JPEG of quality %d\n",
           pel_renderer_description(renderer), sysconf(_SC_NPROCESSORS_ONLN),
           WIDTH, HEIGHT, KBPS, QUALITY);
    fprintf(json, "{\n  \"device\": \"%s\", \"threads\": %d,\n",
            pel_renderer_description(renderer), line.threads);
    set_up_views();
    take_samples();
    bench_overhead(json);
    bench_views(json);
    fclose(json);
    for (int i = 0; i < SAMPLES; i++) {
        free(samples[i]);
    }
    pel_renderer_destroy(renderer);
    pel_sea_finish(&sea);
    return 0;
}
