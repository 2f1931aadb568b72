/* Radiance of the Earth's air and sea from any height by random paths, for
 * lines of sight from standard input, each an angle from the nadir (180:
 * straight up) and an azimuth from the Sun's in degrees:
 *
 *     spacetrace --heights M,… --sun ZENITH [OPTION…] <sights
 *
 * Prints CSV, a line for each height, sight and wavelength (README.md). A sight
 * takes sixteen means of `paths`, and twice as many until the error is the
 * wanted share of the radiance, sixteen times `most` at most. */
#include "spacesight.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RADIAN (3.14159265358979323846 / 180)

enum { SIGHTS = 65536, HEIGHTS = 64, MEANS = 16 };

static const double irradiance[AIR_CHANNELS] = { 1.474, 1.850, 1.912 };
static const int nanometres[AIR_CHANNELS] = { 680, 550, 440 };

static struct {
    double visibility, radius, sun, wind, albedo, toward, error;
    int paths, most, seed;
    const char *heights, *ground, *slopes, *water, *index;
} options = {
    .visibility = 40,
    .radius = 6360,
    .sun = 40,
    .wind = 7,
    .albedo = 0.06,
    .error = 0.005,
    .paths = 500,
    .most = 16000,
    .seed = 1,
    .heights = "20000,400000,10000000",
    .ground = "fresnel",
};

static struct air air;
static struct air_sun sun;
static struct air_ground ground;

static void end(const char *what, const char *word)
{
    fprintf(stderr, "spacetrace: %s %s\n", what, word);
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
        { "--heights", 0, 0, &options.heights },
        { "--visibility", &options.visibility, 0, 0 },
        { "--radius", &options.radius, 0, 0 },
        { "--sun", &options.sun, 0, 0 },
        { "--ground", 0, 0, &options.ground },
        { "--albedo", &options.albedo, 0, 0 },
        { "--wind", &options.wind, 0, 0 },
        { "--slopes", 0, 0, &options.slopes },
        { "--toward", &options.toward, 0, 0 },
        { "--water", 0, 0, &options.water },
        { "--index", 0, 0, &options.index },
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
    if (!(options.radius >= 100 && options.radius <= 1e6)) {
        end("the radius is 100 to", "1000000 km");
    }
    if (!(options.sun >= 0 && options.sun <= 180)) {
        end("the Sun is 0 to 180 degrees", "from the zenith");
    }
}

static void three(const char *words, double of[AIR_CHANNELS])
{
    if (words && sscanf(words, "%lf,%lf,%lf", &of[0], &of[1], &of[2]) != 3) {
        end("three numbers, for 680, 550 and 440 nm, not", words);
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
    } else {
        three(options.water, ground.albedo);
        three(options.index, ground.index);
    }
    if (options.slopes) {
        int read =
            sscanf(options.slopes, "%lf,%lf", &ground.variance, &ground.across);
        if (!(read >= 1 && ground.variance > 1e-8 && ground.across >= 0)) {
            end("no variances along and across:", options.slopes);
        }
        double to = options.toward * RADIAN;
        ground.axis = (struct air_vec){ cos(to), sin(to), 0 };
    }
}

static void measure(const struct space_eye *eye, const double *sight,
                    int channel, uint64_t seed)
{
    const struct air_scene scene = { &air, &sun, &ground };
    struct air_vec toward = space_toward(sight[0] * RADIAN, sight[1] * RADIAN);
    struct air_sight s;
    double glint = space_glint(&scene, eye, toward, channel);
    double once[AIR_SUNS] = { 0 }, sum = 0, squares = 0, mean = 0, error = 0;
    double single = 0;
    if (space_sight(&air, eye, toward, channel, &s)) {
        const struct air_ground black = { .kind = AIR_BLACK };
        const struct air_scene bare = { &air, &sun, &black };
        double alone[AIR_SUNS];
        air_once(&scene, &s, once);
        air_once(&bare, &s, alone);
        single = alone[0];
        int n = 0;
        for (int wanted = MEANS;; wanted *= 2) {
            for (; n < wanted; n++) {
                double more[AIR_SUNS];
                air_more(&scene, &s, options.paths, seed + (uint64_t)n, more);
                sum += more[0];
                squares += more[0] * more[0];
            }
            mean = sum / n;
            error = sqrt(fmax(squares / n - mean * mean, 0) / (n - 1));
            if (error <= options.error * (once[0] - glint + mean) ||
                2.0 * wanted * options.paths > (double)MEANS * options.most) {
                break;
            }
        }
    }
    double by = irradiance[channel];
    printf("%.10g,%g,%g,%d,%.6g,%.2g,%.6g,%.6g\n", eye->height * 1e3, sight[0],
           sight[1], nanometres[channel], (once[0] + mean) * by, error * by,
           glint * by, single * by);
    fflush(stdout);
}

int main(int argc, char **argv)
{
    static double sights[SIGHTS][2];
    int count = 0;
    read_options(argc, argv);
    choose_ground();
    air_init(&air, options.visibility);
    air.ground = options.radius;
    air.top = options.radius + 60;
    air_tabulate(&air);
    air_sun_init(&sun, &air);
    while (count < SIGHTS &&
           scanf("%lf %lf", &sights[count][0], &sights[count][1]) == 2) {
        count++;
    }
    puts("height_m,nadir_deg,azimuth_deg,wavelength_nm,radiance,error,glint,"
         "once");
    char *rest = (char *)options.heights;
    for (int i = 0; *rest && i < HEIGHTS; i++) {
        char *from = rest;
        struct space_eye eye = { .height = strtod(from, &rest) / 1e3,
                                 .sun_zenith = options.sun * RADIAN };
        if (rest == from || !(eye.height > 0 && eye.height < 1e6)) {
            end("heights are above 0 and below a million km, not", from);
        }
        rest += *rest != 0;
        for (int k = 0; k < count; k++) {
            for (int c = 0; c < AIR_CHANNELS; c++) {
                uint64_t seed = ((uint64_t)options.seed << 48) +
                                ((uint64_t)i << 42) + ((uint64_t)k << 26) +
                                ((uint64_t)c << 24);
                measure(&eye, sights[k], c, seed);
            }
        }
    }
    return 0;
}
