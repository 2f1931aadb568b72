/* Radiance under a sea by random paths, for lines of sight from standard input,
 * each a zenith angle (0: straight up) and an azimuth from the Sun's, in
 * degrees:
 *
 *     undertrace --depths M,… --absorption A --scattering B [OPTION…] <sights
 *
 * Prints CSV, a line for each depth and sight (README.md). A sight takes
 * sixteen means of `paths`, and twice as many until the error is the wanted
 * share of the radiance, sixteen times `most` at most. */
#include "underpath.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RADIAN (UNDER_PI / 180)

enum { SIGHTS = 65536, DEPTHS = 64, MEANS = 16 };

static struct {
    double absorption, scattering, molecules, depolarization, index, toward;
    double sun, irradiance, sky, error, bottom, albedo, sought;
    int paths, most, seed;
    const char *depths, *phase, *slopes, *skies;
} options = {
    .absorption = 0.05,
    .scattering = 0.1,
    .depolarization = 0.039,
    .index = 1.34,
    .sun = 30,
    .irradiance = 1,
    .error = 0.005,
    .bottom = INFINITY,
    .sought = -1,
    .paths = 500,
    .most = 64000,
    .seed = 1,
    .depths = "1,5,20",
    .phase = "ff:0.0183",
};

static struct under_phase phase;
static struct under_sky sky;

static void end(const char *what, const char *word)
{
    fprintf(stderr, "undertrace: %s %s\n", what, word);
    exit(2);
}

static void read_options(int argc, char **argv)
{
    struct {
        const char *name;
        double *real;
        int *whole;
        const char **word;
    } known[] = {
        { "--absorption", &options.absorption, 0, 0 },
        { "--scattering", &options.scattering, 0, 0 },
        { "--phase", 0, 0, &options.phase },
        { "--molecules", &options.molecules, 0, 0 },
        { "--depolarization", &options.depolarization, 0, 0 },
        { "--index", &options.index, 0, 0 },
        { "--slopes", 0, 0, &options.slopes },
        { "--toward", &options.toward, 0, 0 },
        { "--sun", &options.sun, 0, 0 },
        { "--irradiance", &options.irradiance, 0, 0 },
        { "--sky", &options.sky, 0, 0 },
        { "--sky-file", 0, 0, &options.skies },
        { "--bottom", &options.bottom, 0, 0 },
        { "--albedo", &options.albedo, 0, 0 },
        { "--depths", 0, 0, &options.depths },
        { "--sought", &options.sought, 0, 0 },
        { "--error", &options.error, 0, 0 },
        { "--paths", 0, &options.paths, 0 },
        { "--most", 0, &options.most, 0 },
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
}

static void choose_phase(void)
{
    enum under_kind kind = UNDER_FOURNIER_FORAND;
    double parameter = 0;
    if (sscanf(options.phase, "ff:%lf", &parameter) == 1) {
        if (!(parameter >= 1e-4 && parameter <= 0.2)) {
            end("a backscattered fraction is 0.0001 to 0.2, not",
                options.phase);
        }
    } else if (sscanf(options.phase, "hg:%lf", &parameter) == 1) {
        kind = UNDER_HENYEY_GREENSTEIN;
        if (!(fabs(parameter) < 0.99)) {
            end("a mean cosine is -0.99 to 0.99, not", options.phase);
        }
    } else if (!strcmp(options.phase, "molecules")) {
        kind = UNDER_HENYEY_GREENSTEIN;
        options.molecules = 1;
    } else {
        end("no such phase function:", options.phase);
    }
    under_phase_init(&phase, kind, parameter, options.molecules,
                     options.depolarization);
}

static struct under_scene scene_of(void)
{
    struct under_scene scene = {
        .absorption = options.absorption,
        .scattering = options.scattering,
        .phase = &phase,
        .surface = { .index = options.index,
                     .toward = options.toward * RADIAN },
        .sun_zenith = options.sun * RADIAN,
        .irradiance = options.irradiance,
        .sky = &sky,
        .bottom = options.bottom,
        .albedo = options.albedo,
    };
    if (!(options.absorption >= 0 && options.scattering >= 0 &&
          options.absorption + options.scattering > 0)) {
        end("absorption and scattering are positive,", "1/m");
    }
    if (!(options.sun >= 0 && options.sun < 90 && options.index >= 1)) {
        end("the Sun is 0 to 90 degrees from the zenith,", "the index above 1");
    }
    if (options.absorption <= 0 && isinf(options.bottom)) {
        end("without absorption there must be", "a bottom");
    }
    if (options.slopes) {
        struct under_surface *s = &scene.surface;
        int read = sscanf(options.slopes, "%lf,%lf", &s->along, &s->across);
        s->across = read == 1 ? s->along : s->across;
        if (!(read >= 1 && s->along > 1e-8 && s->across > 1e-8)) {
            end("no variances along and across:", options.slopes);
        }
    }
    scene.sought = options.sought < 0 ? under_rate(&scene) : options.sought;
    if (scene.sought >= options.absorption + options.scattering) {
        end("sought is less than", "absorption and scattering together");
    }
    return scene;
}

static void measure(const struct under_scene *scene, double depth,
                    const double *sight, uint64_t seed)
{
    double zenith = sight[0] * RADIAN, azimuth = sight[1] * RADIAN;
    struct under_vec toward = { sin(zenith) * cos(azimuth),
                                sin(zenith) * sin(azimuth), cos(zenith) };
    double sum[2] = { 0 }, squares[2] = { 0 }, mean[2], error[2];
    int n = 0;
    for (int wanted = MEANS;; wanted *= 2) {
        for (; n < wanted; n++) {
            struct under_light light = under_look(
                scene, depth, toward, options.paths, seed + (uint64_t)n);
            const double found[2] = { light.scattered, light.window };
            for (int k = 0; k < 2; k++) {
                sum[k] += found[k];
                squares[k] += found[k] * found[k];
            }
        }
        for (int k = 0; k < 2; k++) {
            mean[k] = sum[k] / n;
            error[k] =
                sqrt(fmax(squares[k] / n - mean[k] * mean[k], 0) / (n - 1));
        }
        if ((error[0] <= options.error * mean[0] &&
             error[1] <= options.error * (mean[0] + mean[1])) ||
            2.0 * wanted * options.paths > (double)MEANS * options.most) {
            break;
        }
    }
    printf("%g,%g,%g,%.6g,%.2g,%.6g,%.2g,%.6g\n", depth, sight[0], sight[1],
           mean[0], error[0], mean[1], error[1],
           under_sun(scene, depth, toward));
    fflush(stdout);
}

int main(int argc, char **argv)
{
    static double sights[SIGHTS][2];
    int count = 0;
    const char *why;
    read_options(argc, argv);
    choose_phase();
    sky.uniform = options.sky;
    if (options.skies && under_sky_read(&sky, options.skies, &why)) {
        end(options.skies, why);
    }
    struct under_scene scene = scene_of();
    while (count < SIGHTS &&
           scanf("%lf %lf", &sights[count][0], &sights[count][1]) == 2) {
        count++;
    }
    puts("depth_m,zenith_deg,azimuth_deg,scattered,scattered_error,"
         "window_sky,window_sky_error,window_sun");
    char *rest = (char *)options.depths;
    for (int i = 0; *rest && i < DEPTHS; i++) {
        char *from = rest;
        double depth = strtod(from, &rest);
        if (rest == from || !(depth >= 0 && depth <= options.bottom)) {
            end("depths are 0 to the bottom's, not", from);
        }
        rest += *rest != 0;
        for (int k = 0; k < count; k++) {
            measure(&scene, depth, sights[k],
                    ((uint64_t)options.seed << 48) + ((uint64_t)i << 42) +
                        ((uint64_t)k << 24));
        }
    }
    under_sky_free(&sky);
    return 0;
}
