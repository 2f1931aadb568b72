/* Times the renderer, the surface queries and the encoders:
 *   bench [--device NAME] [--shading NAME] [--json FILE] [--quick]
 * A table on the terminal, the same figures in FILE. docs/benchmarks.md says
 * what each figure is. */
#include <getopt.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "encode/encode.h"
#include "tests/bench/fleet.h"
#include "tests/bench/scene.h"

extern char **environ;

#define WAIT_NS 60000000000
#define MOST_FRAMES 64

static struct {
    char *device, *shading, *json, *child;
    int frames;
} options = { (char[]){ "software" }, (char[]){ "auto" },
              (char[]){ "build/bench.json" }, NULL, 15 };

static struct pel_renderer *renderer;
static struct pel_sea sea;
static FILE *json;

/* --- helpers ---------------------------------------------------------------
 */

static void die(const char *what)
{
    fprintf(stderr, "bench: %s\n", what);
    exit(1);
}

static double wall_ms(void)
{
    return (double)pel_now_ns() * 1e-6;
}

/* User and system time: of all threads, or of the children that ended. */
static double cpu_ms(int whose)
{
    struct rusage u;
    getrusage(whose, &u);
    return (double)(u.ru_utime.tv_sec + u.ru_stime.tv_sec) * 1e3 +
           (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec) * 1e-3;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, by_size);
    return count % 2 ? values[count / 2]
                     : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

static void open_renderer(void)
{
    const struct pel_renderer_options o = { .device = options.device,
                                            .shading = options.shading };
    struct pel_fault fault = { 0 };
    if (pel_renderer_create(&o, &renderer, &fault) != PEL_OK) {
        die(fault.message);
    }
}

static void make_sea(const struct bench_scene *s)
{
    pel_sea_finish(&sea);
    if (bench_sea(s, &sea) != PEL_OK) {
        die("the sea cannot be built");
    }
}

static void submit(const struct pel_environment *env,
                   const struct pel_draw *draws, size_t count)
{
    if (pel_renderer_submit(renderer, env, draws, count) != PEL_OK) {
        die("drawing failed");
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

/* Submits one moment's views and waits for all their pixels. */
static void frame(struct pel_environment *env, const struct pel_draw *draws,
                  size_t count)
{
    env->time_s += 1.0 / 30.0;
    submit(env, draws, count);
    for (size_t i = 0; i < count; i++) {
        pel_picture_release(collect());
    }
}

/* --- frames ----------------------------------------------------------------
 */

struct cost {
    double wall_ms; /* median of frames one by one */
    double cpu_ms;  /* of all threads, a frame */
};

static struct cost cost_of(struct pel_environment *env,
                           const struct pel_draw *draws, size_t count)
{
    double times[MOST_FRAMES];
    for (int i = 0; i < 3; i++) {
        frame(env, draws, count);
    }
    double cpu = cpu_ms(RUSAGE_SELF);
    for (int i = 0; i < options.frames; i++) {
        double start = wall_ms();
        frame(env, draws, count);
        times[i] = wall_ms() - start;
    }
    cpu = (cpu_ms(RUSAGE_SELF) - cpu) / options.frames;
    return (struct cost){ median(times, options.frames), cpu };
}

/* Wall time a frame while two more are always under way. */
static double pipelined_ms(struct pel_environment *env,
                           const struct pel_draw *draw)
{
    double start = 0.0;
    for (int i = -3; i < options.frames; i++) {
        env->time_s += 1.0 / 30.0;
        submit(env, draw, 1);
        if (i >= -1) {
            pel_picture_release(collect());
        }
        if (i == -1) {
            start = wall_ms();
        }
    }
    double ms = (wall_ms() - start) / options.frames;
    while (pel_renderer_in_flight(renderer) > 0) {
        pel_picture_release(collect());
    }
    return ms;
}

static void stages_of(struct pel_environment *env, const struct pel_draw *draw,
                      double ms[PEL_STAGE_COUNT])
{
    enum { RUNS = 7 };
    double runs[PEL_STAGE_COUNT][RUNS];
    pel_renderer_measure(renderer, true);
    for (int i = 0; i < RUNS; i++) {
        double now[PEL_STAGE_COUNT];
        frame(env, draw, 1);
        pel_renderer_stage_ms(renderer, now);
        for (int s = 0; s < PEL_STAGE_COUNT; s++) {
            runs[s][i] = now[s];
        }
    }
    pel_renderer_measure(renderer, false);
    for (int s = 0; s < PEL_STAGE_COUNT; s++) {
        ms[s] = median(runs[s], RUNS);
    }
}

static void bench_frames(void)
{
    static const struct {
        const char *name;
        uint32_t width, height;
        double height_m, pitch;
        bool quick, fft;
    } cases[] = {
        { "peers 1024x768", 1024, 768, 6.0, 0.0, true, false },
        { "peers 1280x720", 1280, 720, 6.0, 0.0, false, false },
        { "peers 1920x1080", 1920, 1080, 6.0, 0.0, true, false },
        { "FFT 1024x768", 1024, 768, 6.0, 0.0, true, true },
        { "FFT 1920x1080", 1920, 1080, 6.0, 0.0, false, true },
        { "4 m 1024x768", 1024, 768, 4.0, 0.0, false, false },
        { "1000 m 1024x768", 1024, 768, 1000.0, 0.0, true, false },
        { "8000 m 1024x768", 1024, 768, 8000.0, 0.0, false, false },
        { "1000 m, 20° down", 1024, 768, 1000.0, -20.0, false, false },
    };
    printf("\nframes, ms          wall  CPU/2  piped |");
    for (int s = 0; s < PEL_STAGE_COUNT; s++) {
        printf(" %8s", pel_stage_name((enum pel_stage)s));
    }
    printf("\n");
    fprintf(json, "  \"frames\": [");
    const char *comma = "";
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        if (options.frames < 15 && !cases[i].quick) {
            continue;
        }
        struct bench_scene s = bench_default;
        s.width = cases[i].width;
        s.height = cases[i].height;
        s.height_m = cases[i].height_m;
        s.pitch = cases[i].pitch;
        s.fft = cases[i].fft;
        make_sea(&s);
        struct pel_environment env = bench_environment(&s, &sea);
        const struct pel_draw draw = { .camera = bench_camera(&s),
                                       .layers = PEL_LAYER_COLOR };
        double stage[PEL_STAGE_COUNT];
        struct cost c = cost_of(&env, &draw, 1);
        double piped = pipelined_ms(&env, &draw);
        stages_of(&env, &draw, stage);
        printf("%-17s %6.2f %6.2f %6.2f |", cases[i].name, c.wall_ms,
               0.5 * c.cpu_ms, piped);
        fprintf(json,
                "%s\n    {\"name\": \"%s\", \"width\": %u, \"height\": %u, "
                "\"wallMs\": %.3f, \"cpuMs\": %.3f, \"pipelinedMs\": %.3f, "
                "\"stagesMs\": {",
                comma, cases[i].name, s.width, s.height, c.wall_ms, c.cpu_ms,
                piped);
        for (int k = 0; k < PEL_STAGE_COUNT; k++) {
            printf(" %8.2f", stage[k]);
            fprintf(json, "%s\"%s\": %.3f", k ? ", " : "",
                    pel_stage_name((enum pel_stage)k), stage[k]);
        }
        printf("\n");
        fprintf(json, "}}");
        comma = ",";
        fflush(stdout);
    }
    fprintf(json, "\n  ],\n");
}

/* Things on the sea beside none, 1280 × 720. */
static void bench_fleets(void)
{
    struct bench_scene s = bench_default;
    s.width = 1280;
    s.height = 720;
    make_sea(&s);
    const struct pel_draw draw = { .camera = bench_camera(&s),
                                   .layers = PEL_LAYER_COLOR };
    double none = 0;
    printf("\nobjects, 1280x720   wall  CPU/2         |   raster    shade     "
           "tone\n");
    fprintf(json, "  \"objects\": [");
    for (int i = 0; i < BENCH_FLEETS; i++) {
        struct pel_environment env = bench_environment(&s, &sea);
        if (!bench_fleet_set((enum bench_fleet)i, &env)) {
            die("no memory for models");
        }
        double stage[PEL_STAGE_COUNT];
        struct cost c = cost_of(&env, &draw, 1);
        stages_of(&env, &draw, stage);
        none = i ? none : c.cpu_ms;
        printf("%-17s %6.2f %6.2f %+6.1f%% | %8.2f %8.2f %8.2f\n",
               bench_fleet_name((enum bench_fleet)i), c.wall_ms, 0.5 * c.cpu_ms,
               100 * (c.cpu_ms / none - 1), stage[PEL_STAGE_RASTER],
               stage[PEL_STAGE_SHADE], stage[PEL_STAGE_TONE]);
        fprintf(json,
                "%s\n    {\"name\": \"%s\", \"wallMs\": %.3f, \"cpuMs\": "
                "%.3f, \"rasterMs\": %.3f, \"shadeMs\": %.3f}",
                i ? "," : "", bench_fleet_name((enum bench_fleet)i), c.wall_ms,
                c.cpu_ms, stage[PEL_STAGE_RASTER], stage[PEL_STAGE_SHADE]);
        fflush(stdout);
    }
    fprintf(json, "\n  ],\n");
}

/* --- views -----------------------------------------------------------------
 */

/* Column x, row y of 4 × 2 parts of a camera. */
static struct pel_camera part_of(const struct pel_camera *whole, int x, int y)
{
    struct pel_camera c = *whole;
    double w = (whole->tan_right - whole->tan_left) / 4.0;
    double h = (whole->tan_top - whole->tan_bottom) / 2.0;
    c.width = whole->width / 4;
    c.height = whole->height / 2;
    c.tan_left = whole->tan_left + w * x;
    c.tan_right = c.tan_left + w;
    c.tan_top = whole->tan_top - h * y;
    c.tan_bottom = c.tan_top - h;
    return c;
}

static void bench_views(void)
{
    struct bench_scene s = bench_default;
    s.width = 1280;
    s.height = 360;
    make_sea(&s);
    struct pel_environment env = bench_environment(&s, &sea);
    const struct pel_draw one = { .camera = bench_camera(&s),
                                  .layers = PEL_LAYER_COLOR };
    struct pel_draw tiles[8], around[8];
    s.width = 320;
    s.height = 180;
    for (int i = 0; i < 8; i++) {
        tiles[i] = one;
        tiles[i].camera = part_of(&one.camera, i % 4, i / 4);
        s.heading = 45.0 * i;
        around[i] = one;
        around[i].camera = bench_camera(&s);
    }
    struct cost whole = cost_of(&env, &one, 1);
    struct cost parts = cost_of(&env, tiles, 8);
    printf("\nviews               wall  CPU/2  ms a frame\n");
    printf("%-17s %6.2f %6.2f\n", "1 of 1280x360", whole.wall_ms,
           0.5 * whole.cpu_ms);
    printf("%-17s %6.2f %6.2f  its parts: ratio %.2f wall, %.2f CPU\n",
           "8 of 320x180", parts.wall_ms, 0.5 * parts.cpu_ms,
           parts.wall_ms / whole.wall_ms, parts.cpu_ms / whole.cpu_ms);
    fprintf(json,
            "  \"views\": {\"one1280x360Ms\": %.3f, \"eightPartsMs\": %.3f, "
            "\"ratioWall\": %.3f, \"ratioCpu\": %.3f, \"around\": [",
            whole.wall_ms, parts.wall_ms, parts.wall_ms / whole.wall_ms,
            parts.cpu_ms / whole.cpu_ms);
    for (int n = 1; n <= 8; n *= 2) {
        struct cost c = cost_of(&env, around, (size_t)n);
        printf("%d of 320x180%6s %6.2f %6.2f  60° wide, all around\n", n, "",
               c.wall_ms, 0.5 * c.cpu_ms);
        fprintf(json, "%s{\"views\": %d, \"wallMs\": %.3f, \"cpuMs\": %.3f}",
                n > 1 ? ", " : "", n, c.wall_ms, c.cpu_ms);
    }
    fprintf(json, "]},\n");
    fflush(stdout);
}

/* --- queries and encoders
 * ----------------------------------------------------- */

static double thread_cpu_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static double queries_per_second(bool fft)
{
    enum { POINTS = 4096 };
    static struct pel_vec2 points[POINTS];
    static struct pel_surface_sample samples[POINTS];
    struct bench_scene s = bench_default;
    s.fft = fft;
    make_sea(&s);
    for (int i = 0; i < POINTS; i++) {
        points[i] = (struct pel_vec2){ i % 64 * 1.7, i / 64 * 2.3 };
    }
    double start = thread_cpu_ms(), spent = 0.0;
    int rounds = 0;
    while (spent < (options.frames < 15 ? 100.0 : 400.0)) {
        /* A new moment of the cascades has its transforms, timed apart. */
        pel_sea_query(&sea, points, POINTS, fft ? 10.0 : 10.0 + rounds,
                      samples);
        rounds++;
        spent = thread_cpu_ms() - start;
    }
    return 1e3 * POINTS * rounds / spent;
}

static double new_moment_ms(void)
{
    enum { MOMENTS = 10 };
    struct pel_surface_sample sample;
    double start = thread_cpu_ms();
    for (int i = 0; i < MOMENTS; i++) {
        pel_sea_sample(&sea, 0, 0, 100.0 + i, &sample);
    }
    return (thread_cpu_ms() - start) / MOMENTS;
}

static void bench_queries(void)
{
    double trochoids = queries_per_second(false);
    double cascades = queries_per_second(true);
    double moment = new_moment_ms();
    printf("\nsurface queries a second on one core: %.0f of 60 waves, %.0f of "
           "cascades\n"
           "(and %.1f ms of transforms for each new moment of these)\n",
           trochoids, cascades, moment);
    fprintf(json,
            "  \"queriesPerSecond\": %.0f, \"cascadeQueriesPerSecond\": "
            "%.0f, \"cascadeMomentMs\": %.2f,\n",
            trochoids, cascades, moment);
}

static enum pel_err encode(int kind, const struct pel_picture *p,
                           struct pel_bytes *out)
{
    const struct pel_exr_layer layers[] = {
        { .channels = "RGB", .pixels = p->radiance, .stride = 4 },
        { .name = "depth",
          .channels = "Z",
          .pixels = p->depth,
          .stride = 1,
          .full_float = true },
        { .name = "normal",
          .channels = "XYZ",
          .pixels = p->normal,
          .stride = 4 },
    };
    const struct pel_encode_input image = {
        .width = p->width,
        .height = p->height,
        .rgba = p->rgba,
        .quality = 90,
        .layers = layers,
        .layer_count = kind == 2 ? 1 : 3,
    };
    static pel_encode *const encoders[] = { pel_jpeg_encode, pel_png_encode,
                                            pel_exr_encode, pel_exr_encode };
    return encoders[kind](&image, out);
}

static void bench_encoders(void)
{
    static const char *const names[] = { "JPEG", "PNG", "EXR",
                                         "EXR, 3 layers" };
    static const char *const keys[] = { "jpegMs", "pngMs", "exrMs",
                                        "exrLayersMs" };
    struct bench_scene s = bench_default;
    s.width = 1280;
    s.height = 720;
    make_sea(&s);
    struct pel_environment env = bench_environment(&s, &sea);
    const struct pel_draw draw = { .camera = bench_camera(&s),
                                   .layers =
                                       PEL_LAYER_COLOR | PEL_LAYER_RADIANCE |
                                       PEL_LAYER_DEPTH | PEL_LAYER_NORMAL };
    submit(&env, &draw, 1);
    struct pel_picture *p = collect();
    printf("\nencoders at 1280x720, CPU ms on one core\n");
    fprintf(json, "  \"encoders\": {");
    for (int kind = 0; kind < 4; kind++) {
        double times[5];
        struct pel_bytes bytes = { 0 };
        for (int i = 0; i < 5; i++) {
            pel_bytes_finish(&bytes);
            double start = thread_cpu_ms();
            if (encode(kind, p, &bytes) != PEL_OK) {
                die("encoding failed");
            }
            times[i] = thread_cpu_ms() - start;
        }
        double ms = median(times, 5);
        printf("%-17s %6.2f  %7.0f kB\n", names[kind], ms,
               (double)bytes.size * 1e-3);
        fprintf(json, "%s\"%s\": %.3f", kind ? ", " : "", keys[kind], ms);
        pel_bytes_finish(&bytes);
    }
    fprintf(json, "},\n");
    pel_picture_release(p);
}

/* --- processes of their own
 * ------------------------------------------------------ */

static double resident_mb(void)
{
    char line[128];
    long kb = 0;
    FILE *f = fopen("/proc/self/status", "r");
    while (f && fgets(line, sizeof line, f)) {
        sscanf(line, "VmRSS: %ld", &kb);
    }
    if (f) {
        fclose(f);
    }
    return (double)kb / 1024.0;
}

/* Runs in the child: prints one number. */
static int child(void)
{
    struct bench_scene s = bench_default;
    bool memory = strcmp(options.child, "memory") == 0;
    s.width = memory ? 1920 : 1280;
    s.height = memory ? 1080 : 720;
    double start = wall_ms();
    open_renderer();
    make_sea(&s);
    struct pel_environment env = bench_environment(&s, &sea);
    const struct pel_draw draw = { .camera = bench_camera(&s),
                                   .layers = PEL_LAYER_COLOR };
    frame(&env, &draw, 1);
    double first = wall_ms() - start;
    if (memory) {
        pipelined_ms(&env, &draw);
    }
    printf("%.3f\n", memory ? resident_mb() : first);
    pel_renderer_destroy(renderer);
    pel_sea_finish(&sea);
    return 0;
}

/* The number a child prints; `extra` is one more variable for it, or NULL. */
static double ask_child(char *what, char *extra)
{
    char *argv[] = { (char[]){ "bench" },
                     (char[]){ "--child" },
                     what,
                     (char[]){ "--device" },
                     options.device,
                     (char[]){ "--shading" },
                     options.shading,
                     NULL };
    char *vars[512] = { extra };
    int count = extra ? 1 : 0;
    for (int i = 0; environ[i] && count < 511; i++) {
        vars[count++] = environ[i];
    }
    int ends[2];
    if (pipe(ends) != 0) {
        die("no pipe");
    }
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    pid_t pid;
    int failed =
        posix_spawn(&pid, "/proc/self/exe", &actions, NULL, argv, vars);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    double value = -1.0;
    FILE *f = fdopen(ends[0], "r");
    if (!failed && f) {
        char line[64];
        if (fgets(line, sizeof line, f)) {
            value = atof(line);
        }
        waitpid(pid, NULL, 0);
    }
    if (f) {
        fclose(f);
    }
    return value;
}

static void bench_start(void)
{
    char off[] = "MESA_SHADER_CACHE_DISABLE=1";
    char off_nvidia[] = "__GL_SHADER_DISK_CACHE=0";
    char start[] = "start", memory_word[] = "memory";
    bool software = pel_renderer_is_software(renderer);
    double cpu[4];
    cpu[0] = cpu_ms(RUSAGE_CHILDREN);
    double cold = ask_child(start, software ? off : off_nvidia);
    cpu[1] = cpu_ms(RUSAGE_CHILDREN);
    ask_child(start, NULL); /* fills the cache */
    cpu[2] = cpu_ms(RUSAGE_CHILDREN);
    double warm = ask_child(start, NULL);
    cpu[3] = cpu_ms(RUSAGE_CHILDREN);
    double memory = ask_child(memory_word, NULL);
    printf(
        "\nstart to first 1280x720 frame: cold %.0f ms (CPU %.0f), warm %.0f "
        "ms (CPU %.0f)\n",
        cold, cpu[1] - cpu[0], warm, cpu[3] - cpu[2]);
    printf("resident with one 1920x1080 view: %.0f MB\n", memory);
    fprintf(json,
            "  \"start\": {\"coldMs\": %.1f, \"coldCpuMs\": %.1f, "
            "\"warmMs\": %.1f, \"warmCpuMs\": %.1f},\n"
            "  \"residentMb\": %.1f\n",
            cold, cpu[1] - cpu[0], warm, cpu[3] - cpu[2], memory);
}

/* --- the machine
 * ---------------------------------------------------------------- */

static void cpu_model(char out[128])
{
    char line[256];
    snprintf(out, 128, "unknown");
    FILE *f = fopen("/proc/cpuinfo", "r");
    while (f && fgets(line, sizeof line, f)) {
        if (sscanf(line, "model name : %127[^\n\"\\]", out) == 1) {
            break;
        }
    }
    if (f) {
        fclose(f);
    }
}

static void say_machine(void)
{
    char model[128];
    double load[3] = { 0 };
    cpu_model(model);
    getloadavg(load, 3);
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    printf("%s\n%s, %ld cores, load average %.2f\n",
           pel_renderer_description(renderer), model, cores, load[0]);
    fprintf(json,
            "{\n  \"version\": \"%s\",\n  \"device\": \"%s\",\n"
            "  \"cpu\": \"%s\",\n  \"cores\": %ld,\n  \"load\": %.2f,\n"
            "  \"framesEach\": %d,\n",
            PEL_VERSION, pel_renderer_description(renderer), model, cores,
            load[0], options.frames);
}

static void parse(int argc, char **argv)
{
    static const struct option longs[] = {
        { "device", required_argument, NULL, 'd' },
        { "shading", required_argument, NULL, 's' },
        { "json", required_argument, NULL, 'j' },
        { "quick", no_argument, NULL, 'q' },
        { "child", required_argument, NULL, 'c' }, /* its own */
        { 0 },
    };
    int c;
    while ((c = getopt_long(argc, argv, "", longs, NULL)) != -1) {
        switch (c) {
        case 'd':
            options.device = optarg;
            break;
        case 's':
            options.shading = optarg;
            break;
        case 'j':
            options.json = optarg;
            break;
        case 'q':
            options.frames = 5;
            break;
        case 'c':
            options.child = optarg;
            break;
        default:
            fprintf(stderr, "usage: bench [--device auto|software|N] "
                            "[--shading auto|fragment|compute] [--json FILE] "
                            "[--quick]\n");
            exit(2);
        }
    }
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    if (options.child) {
        return child();
    }
    json = fopen(options.json, "w");
    if (!json) {
        die("cannot write the JSON file");
    }
    open_renderer();
    say_machine();
    bench_frames();
    bench_fleets();
    bench_views();
    bench_queries();
    bench_encoders();
    bench_start();
    fprintf(json, "}\n");
    fclose(json);
    pel_renderer_destroy(renderer);
    pel_sea_finish(&sea);
    return 0;
}
