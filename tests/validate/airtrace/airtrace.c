/* Radiance of the clear sky by random paths, for lines of sight from standard
 * input, each a zenith angle and an azimuth from the Sun's in degrees:
 *
 *     airtrace [--visibility KM] [--suns ZENITH,…] [--ground fresnel|lambert|
 *              black] [--albedo A] [--wind M/S] [--height M] [--paths N]
 *              [--error SHARE] [--most N] [--threads N] [--seed N]
 *
 * Prints a line for each sight, Sun and channel: `sight sun channel radiance
 * error once`: W m-2 sr-1 nm-1, the standard error of it, and the light of the
 * first order in it. A sight takes sixteen means of `paths`, and twice as many
 * until the error is the wanted share of the radiance, sixteen times `most` at
 * most. The result does not depend on the number of threads. */
#include "airpath.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RADIAN (3.14159265358979323846 / 180)

enum { SIGHTS = 4096, THREADS = 256, MEANS = 16 };

/* Above it, paths seek where the Sun shines, each Sun by itself. */
#define DUSK 86.0

static const double irradiance[AIR_CHANNELS] = { 1.474, 1.850, 1.912 };

static struct {
    double visibility, albedo, wind, height, error;
    int paths, most, threads, seed;
    const char *suns, *ground;
} options = {
    .visibility = 40,
    .albedo = 0.06,
    .wind = 7,
    .height = 2,
    .error = 0.004,
    .paths = 500,
    .most = 16000,
    .threads = 1,
    .seed = 1,
    .suns = "60",
    .ground = "fresnel",
};

struct answer {
    double light, error, once;
};

static struct air air;
static struct air_sun sun;
static struct air_ground ground;
static double suns[AIR_SUNS];
static int sun_count, sight_count, next_task;
static double sights[SIGHTS][2];
static struct answer (*answers)[AIR_SUNS][AIR_CHANNELS];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void end(const char *what, const char *word)
{
    fprintf(stderr, "airtrace: %s %s\n", what, word);
    exit(2);
}

/* One line of sight in one channel, for Suns from `first` on. */
static void measure(int index, int channel, int first, int count)
{
    const struct air_scene scene = { &air, &sun, &ground };
    double zenith = sights[index][0] * RADIAN;
    double azimuth = sights[index][1] * RADIAN;
    struct air_sight sight = {
        .channel = channel,
        .height = options.height / 1e3,
        .toward = { sin(zenith) * cos(azimuth), sin(zenith) * sin(azimuth),
                    cos(zenith) },
        .suns = count,
        .guided = suns[first] > DUSK,
    };
    for (int i = 0; i < count; i++) {
        sight.zenith[i] = suns[first + i] * RADIAN;
    }
    double once[AIR_SUNS], sum[AIR_SUNS] = { 0 }, squares[AIR_SUNS] = { 0 };
    air_once(&scene, &sight, once);
    double worst = 1;
    uint64_t seed = ((uint64_t)options.seed << 40) + ((uint64_t)index << 24) +
                    ((uint64_t)channel << 22) + ((uint64_t)first << 18);
    int n = 0;
    for (int wanted = MEANS; worst > options.error &&
                             wanted * options.paths <= MEANS * options.most;
         wanted *= 2) {
        for (; n < wanted; n++) {
            double more[AIR_SUNS];
            air_more(&scene, &sight, options.paths, seed + (uint64_t)n, more);
            for (int i = 0; i < count; i++) {
                sum[i] += more[i];
                squares[i] += more[i] * more[i];
            }
        }
        worst = 0;
        for (int i = 0; i < count; i++) {
            double mean = sum[i] / n;
            double variance = fmax(squares[i] / n - mean * mean, 0) / (n - 1);
            struct answer *a = &answers[index][first + i][channel];
            a->once = once[i] * irradiance[channel];
            a->light = (once[i] + mean) * irradiance[channel];
            a->error = sqrt(variance) * irradiance[channel];
            worst = fmax(worst, a->light > 0 ? a->error / a->light : 0);
        }
    }
}

static void *work(void *arg)
{
    (void)arg;
    int day = 0;
    while (day < sun_count && suns[day] <= DUSK) {
        day++;
    }
    int tasks = sight_count * AIR_CHANNELS;
    for (;;) {
        pthread_mutex_lock(&lock);
        int task = next_task++;
        pthread_mutex_unlock(&lock);
        if (task >= tasks) {
            return 0;
        }
        if (day > 0) {
            measure(task / AIR_CHANNELS, task % AIR_CHANNELS, 0, day);
        }
        for (int i = day; i < sun_count; i++) {
            measure(task / AIR_CHANNELS, task % AIR_CHANNELS, i, 1);
        }
    }
}

static void read_options(int argc, char **argv)
{
    struct {
        const char *name;
        double *real;
        int *whole;
        const char **word;
    } known[] = {
        { "--visibility", &options.visibility, 0, 0 },
        { "--suns", 0, 0, &options.suns },
        { "--ground", 0, 0, &options.ground },
        { "--albedo", &options.albedo, 0, 0 },
        { "--wind", &options.wind, 0, 0 },
        { "--height", &options.height, 0, 0 },
        { "--error", &options.error, 0, 0 },
        { "--paths", 0, &options.paths, 0 },
        { "--most", 0, &options.most, 0 },
        { "--threads", 0, &options.threads, 0 },
        { "--seed", 0, &options.seed, 0 },
    };
    for (int i = 1; i < argc; i += 2) {
        size_t k = 0, n = sizeof(known) / sizeof(*known);
        while (k < n && strcmp(argv[i], known[k].name)) {
            k++;
        }
        if (k == n || i + 1 == argc) {
            end("what is", argv[i]);
        } else if (known[k].real) {
            *known[k].real = atof(argv[i + 1]);
        } else if (known[k].whole) {
            *known[k].whole = atoi(argv[i + 1]);
        } else {
            *known[k].word = argv[i + 1];
        }
    }
    if (options.threads < 1 || options.threads > THREADS) {
        end("threads:", "1 to 256");
    }
}

static void choose_ground(void)
{
    air_ground_sea(&ground, options.wind);
    if (!strcmp(options.ground, "lambert")) {
        ground.kind = AIR_LAMBERT;
        for (int c = 0; c < AIR_CHANNELS; c++) {
            ground.albedo[c] = options.albedo;
        }
    } else if (!strcmp(options.ground, "black")) {
        ground.kind = AIR_BLACK;
    } else if (strcmp(options.ground, "fresnel")) {
        end("no such ground:", options.ground);
    }
}

/* In rising order: day first. */
static void read_suns(void)
{
    char *rest = (char *)options.suns;
    while (*rest) {
        if (sun_count == AIR_SUNS) {
            end("too many", "Suns");
        }
        suns[sun_count] = strtod(rest, &rest);
        if (sun_count && suns[sun_count] < suns[sun_count - 1]) {
            end("Suns are not in order:", options.suns);
        }
        sun_count++;
        rest += *rest != 0;
    }
}

int main(int argc, char **argv)
{
    read_options(argc, argv);
    choose_ground();
    read_suns();
    air_init(&air, options.visibility);
    air_sun_init(&sun, &air);
    while (sight_count < SIGHTS && scanf("%lf %lf", &sights[sight_count][0],
                                         &sights[sight_count][1]) == 2) {
        sight_count++;
    }
    answers = calloc(SIGHTS, sizeof(*answers));
    if (!answers) {
        end("no memory for", "answers");
    }
    pthread_t thread[THREADS];
    for (int i = 0; i < options.threads; i++) {
        if (pthread_create(&thread[i], 0, work, 0)) {
            end("no", "thread");
        }
    }
    for (int i = 0; i < options.threads; i++) {
        pthread_join(thread[i], 0);
    }
    for (int i = 0; i < sight_count; i++) {
        for (int s = 0; s < sun_count; s++) {
            for (int c = 0; c < AIR_CHANNELS; c++) {
                const struct answer *a = &answers[i][s][c];
                printf("%d %d %d %.6g %.2g %.6g\n", i, s, c, a->light, a->error,
                       a->once);
            }
        }
    }
    free(answers);
    return 0;
}
