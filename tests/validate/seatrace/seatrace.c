/* Light of realised seas by rays: the reference of tests/validate/seatrace.
 *
 *   seatrace --wind 7 [OPTION...] <rows
 *
 * A row on standard input is `zenith azimuth wide high`, degrees (sealight.h).
 * Each figure is printed as `ROW NAME MEAN ERROR`, the standard error from the
 * scatter between realisations; ROW is `sea` for the surface itself.
 *
 *   --spectrum pm|elfouhaily   --fetch M        --shortest M
 *   --wind-to DEG              anticlockwise from the Sun's azimuth
 *   --skies FILE               see read_skies; none: white sky alone
 *   --realisations N  --rays N (of a row and realisation)  --facets N
 *   --nodes N  --threads N  --seed N  --index N
 *   --chop 1                   crests sharpened (seasurface.h)
 */
#include "sealight.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS = 256, REALISATIONS = 256, THREADS = 16 };

struct options {
    const char *spectrum, *skies;
    double wind, fetch, shortest, wind_to, index;
    int realisations, rays, facets, nodes, threads, seed, chop;
};

struct sea_figures {
    double m0, along, cross;
};

static struct options options = { .spectrum = "pm",
                                  .wind = 7,
                                  .fetch = 2e6,
                                  .index = 0,
                                  .realisations = 8,
                                  .rays = 4000,
                                  .facets = 1000000,
                                  .nodes = 512,
                                  .threads = 1,
                                  .seed = 1 };
static struct sea_spectrum spectrum;
static struct sea_row rows[ROWS];
static int row_count;
static struct sea_sky *skies;
static int sun_count;
static struct sea_row_light (*lights)[ROWS];
static struct sea_figures figures[REALISATIONS];

static _Noreturn void end(const char *what, const char *name)
{
    fprintf(stderr, "seatrace: %s %s\n", what, name);
    exit(2);
}

static void read_options(int argc, char **argv)
{
    struct {
        const char *name;
        const char **text;
        double *number;
        int *whole;
    } known[] = {
        { "--spectrum", &options.spectrum, 0, 0 },
        { "--skies", &options.skies, 0, 0 },
        { "--wind", 0, &options.wind, 0 },
        { "--fetch", 0, &options.fetch, 0 },
        { "--shortest", 0, &options.shortest, 0 },
        { "--wind-to", 0, &options.wind_to, 0 },
        { "--index", 0, &options.index, 0 },
        { "--realisations", 0, 0, &options.realisations },
        { "--rays", 0, 0, &options.rays },
        { "--facets", 0, 0, &options.facets },
        { "--nodes", 0, 0, &options.nodes },
        { "--threads", 0, 0, &options.threads },
        { "--seed", 0, 0, &options.seed },
        { "--chop", 0, 0, &options.chop },
    };
    for (int i = 1; i < argc; i += 2) {
        size_t k = 0, count = sizeof(known) / sizeof(*known);
        while (k < count && strcmp(argv[i], known[k].name)) {
            k++;
        }
        if (k == count || i + 1 == argc) {
            end("no such option, or without its value:", argv[i]);
        }
        if (known[k].text) {
            *known[k].text = argv[i + 1];
        } else if (known[k].number) {
            *known[k].number = strtod(argv[i + 1], 0);
        } else {
            *known[k].whole = atoi(argv[i + 1]);
        }
    }
    if (options.realisations < 2 || options.realisations > REALISATIONS ||
        options.threads < 1 || options.threads > THREADS || options.rays < 1 ||
        options.facets < 1 || options.nodes < 256 ||
        (options.nodes & (options.nodes - 1)) || options.wind < 1 ||
        options.wind > 30) {
        end("a value is out of its range; see", "seatrace.c");
    }
}

/* Doubles: the number of Suns; then for each its elevation in degrees, its
 * irradiance, and the table of struct sea_sky. */
static void read_skies(const char *name)
{
    FILE *file = fopen(name, "rb");
    double count;
    if (!file || fread(&count, sizeof(count), 1, file) != 1 || count < 1 ||
        count > SEA_SUNS) {
        end("cannot read", name);
    }
    sun_count = (int)count;
    skies = calloc((size_t)sun_count, sizeof(*skies));
    for (int i = 0; skies && i < sun_count; i++) {
        double head[2];
        if (fread(head, sizeof(head), 1, file) != 1) {
            end("cannot read", name);
        }
        double elevation = head[0] * 3.14159265358979323846 / 180;
        skies[i].sun[0] = cos(elevation);
        skies[i].sun[2] = sin(elevation);
        skies[i].irradiance = head[1];
        float *to = &skies[i].radiance[0][0][0];
        for (size_t k = 0; k < sizeof(skies[i].radiance) / sizeof(float); k++) {
            double value;
            if (fread(&value, sizeof(value), 1, file) != 1) {
                end("cannot read", name);
            }
            to[k] = (float)value;
        }
    }
    fclose(file);
}

static void read_rows(void)
{
    double zenith, azimuth, wide, high;
    const double degree = 3.14159265358979323846 / 180;
    while (row_count < ROWS &&
           scanf("%lf %lf %lf %lf", &zenith, &azimuth, &wide, &high) == 4) {
        rows[row_count++] = (struct sea_row){ zenith * degree, azimuth * degree,
                                              wide * degree, high * degree };
    }
}

static void realise(struct sea_surface *surface, struct sea_facet *facets,
                    int number)
{
    struct sea_random random;
    sea_random_init(&random, (uint64_t)options.seed * 1000 + (uint64_t)number);
    sea_surface_fill(surface, &random);
    figures[number] =
        (struct sea_figures){ surface->m0, surface->along, surface->cross };
    if (sun_count) {
        sea_facets(surface, &random, facets, options.facets);
    }
    for (int i = 0; i < row_count; i++) {
        struct sea_row_light *light = &lights[number][i];
        sea_row_sun(surface, options.index, &rows[i], skies, sun_count, facets,
                    options.facets, &random, light);
        sea_row_rays(surface, options.index, &rows[i], skies, sun_count,
                     options.rays, &random, light);
    }
}

static void *work(void *argument)
{
    int first = *(int *)argument;
    struct sea_surface surface;
    sea_surface_init(&surface, &spectrum, options.nodes,
                     options.wind_to * 3.14159265358979323846 / 180);
    if (options.chop) {
        sea_surface_chop(&surface, &spectrum);
    }
    struct sea_facet *facets = calloc((size_t)options.facets, sizeof(*facets));
    if (!facets) {
        end("no memory for", "facets");
    }
    for (int i = first; i < options.realisations; i += options.threads) {
        realise(&surface, facets, i);
    }
    free(facets);
    sea_surface_finish(&surface);
    return 0;
}

/* Mean and standard error of realisations' values, `stride` bytes apart. */
static void print(const char *row, const char *name, const double *value,
                  size_t stride)
{
    int n = options.realisations;
    double sum = 0, squares = 0;
    for (int i = 0; i < n; i++) {
        double x = *(const double *)((const char *)value + (size_t)i * stride);
        sum += x;
        squares += x * x;
    }
    double mean = sum / n;
    double variance = fmax(squares / n - mean * mean, 0) * n / (n - 1);
    printf("%s %s %.9g %.3g\n", row, name, mean, sqrt(variance / n));
}

static void print_row(int i)
{
    struct sea_row_light *l = &lights[0][i];
    size_t stride = sizeof(lights[0]);
    char row[16], name[32];
    snprintf(row, sizeof(row), "%d", i);
    print(row, "fresnel", &l->fresnel, stride);
    print(row, "white", &l->white, stride);
    print(row, "closed", &l->closed, stride);
    print(row, "once", &l->once, stride);
    print(row, "blocked", &l->blocked, stride);
    print(row, "area", &l->area, stride);
    print(row, "lost", &l->lost, stride);
    for (int s = 0; s < sun_count; s++) {
        for (int c = 0; c < SEA_CHANNELS; c++) {
            snprintf(name, sizeof(name), "sky.%d.%d", s, c);
            print(row, name, &l->sky[s][c], stride);
        }
        snprintf(name, sizeof(name), "skyOnce.%d", s);
        print(row, name, &l->sky_once[s], stride);
        snprintf(name, sizeof(name), "sun.%d", s);
        print(row, name, &l->sun[s], stride);
        snprintf(name, sizeof(name), "sunMore.%d", s);
        print(row, name, &l->sun_more[s], stride);
        snprintf(name, sizeof(name), "sunRays.%d", s);
        print(row, name, &l->sun_rays[s], stride);
    }
}

int main(int argc, char **argv)
{
    read_options(argc, argv);
    if (options.index == 0) {
        options.index = sea_water_index(35, 15, 550);
    }
    enum sea_kind kind = strcmp(options.spectrum, "elfouhaily")
                             ? SEA_PIERSON_MOSKOWITZ
                             : SEA_ELFOUHAILY;
    if (kind == SEA_PIERSON_MOSKOWITZ && strcmp(options.spectrum, "pm")) {
        end("no such spectrum:", options.spectrum);
    }
    if (options.shortest <= 0) {
        options.shortest = kind == SEA_ELFOUHAILY ? 0.0028 : 0.02;
    }
    sea_spectrum_init(&spectrum, kind, options.wind, options.fetch,
                      options.shortest);
    if (options.skies) {
        read_skies(options.skies);
    }
    read_rows();
    lights = calloc((size_t)options.realisations, sizeof(*lights));
    if (!lights) {
        end("no memory for", "rows");
    }
    pthread_t thread[THREADS];
    int first[THREADS];
    for (int i = 0; i < options.threads; i++) {
        first[i] = i;
        if (pthread_create(&thread[i], 0, work, &first[i])) {
            end("no", "thread");
        }
    }
    for (int i = 0; i < options.threads; i++) {
        pthread_join(thread[i], 0);
    }
    struct sea_moments whole =
        sea_spectrum_moments(&spectrum, spectrum.k_low, spectrum.k_high);
    printf("sea index %.9g 0\n", options.index);
    printf("sea m0.spectrum %.9g 0\n", whole.m0);
    printf("sea along.spectrum %.9g 0\n", whole.along);
    printf("sea cross.spectrum %.9g 0\n", whole.cross);
    print("sea", "m0", &figures[0].m0, sizeof(*figures));
    print("sea", "along", &figures[0].along, sizeof(*figures));
    print("sea", "cross", &figures[0].cross, sizeof(*figures));
    for (int i = 0; i < row_count; i++) {
        print_row(i);
    }
    free(lights);
    free(skies);
    return 0;
}
