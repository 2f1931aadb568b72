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
#include "spacewaves.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RADIAN (3.14159265358979323846 / 180)

enum { SIGHTS = 65536, HEIGHTS = 64, MEANS = 16, RAYS = 20000 };

static const double irradiance[AIR_CHANNELS] = { 1.474, 1.850, 1.912 };
static const int nanometres[AIR_CHANNELS] = { 680, 550, 440 };

static struct {
    double visibility, radius, sun, wind, albedo, toward, error;
    int paths, most, seed, orders;
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
    .orders = 8,
    .heights = "20000,400000,10000000",
    .ground = "fresnel",
};

static struct air air;
static struct air_sun sun;
static struct air_ground ground;
static struct space_waves waves;
static bool has_waves;
static struct air_escape escapes[RAYS];
static struct air_vec axis; /* of the ground's slopes, in the eye's frame */

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
        { "--orders", 0, &options.orders, 0 },
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
    } else if (strcmp(options.ground, "fresnel") &&
               strcmp(options.ground, "waves")) {
        end("no such ground:", options.ground);
    } else {
        has_waves = !strcmp(options.ground, "waves");
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
    axis = ground.axis;
    if (has_waves) {
        space_waves_init(&waves, &ground, options.wind, options.orders,
                         (uint64_t)options.seed);
    }
}

/* By what a sight meets first; more: turned more than once, its squares too. */
struct figures {
    double glint, single, once, more[AIR_PARTS], sum, squares;
    int means;
};

static double error_of(const struct figures *f)
{
    double mean = f->sum / f->means;
    return sqrt(fmax(f->squares / f->means - mean * mean, 0) / (f->means - 1));
}

static void follow_paths(const struct air_scene *scene,
                         const struct air_sight *sight, uint64_t seed,
                         struct figures *f)
{
    for (int wanted = MEANS;; wanted *= 2) {
        for (; f->means < wanted; f->means++) {
            double part[AIR_PARTS], all = 0;
            air_parts(scene, sight, options.paths, seed + (uint64_t)f->means,
                      part);
            for (int i = 0; i < AIR_PARTS; i++) {
                f->more[i] += part[i];
                all += part[i];
            }
            f->sum += all;
            f->squares += all * all;
        }
        if (error_of(f) <=
                options.error * (f->once - f->glint + f->sum / f->means) ||
            2.0 * wanted * options.paths > (double)MEANS * options.most) {
            return;
        }
    }
}

/* What a sight meets, for all wavelengths, in its frame; the ground's axis is
 * turned into that. */
static void meet(const struct space_eye *eye, struct air_vec toward,
                 uint64_t seed, struct air_first *first, double *error)
{
    struct air_vec place;
    const struct air_vec to_sun = { sin(eye->sun_zenith), 0,
                                    cos(eye->sun_zenith) };
    ground.axis = space_turned(&air, eye, toward, axis);
    *error = 0;
    *first = (struct air_first){ 0 };
    if (has_waves && space_meets(&air, eye, toward, &place) == SPACE_GROUND) {
        double r = sqrt(air_dot(place, place));
        struct air_vec up = { place.x / r, place.y / r, place.z / r };
        *first =
            space_waves_first(&waves, space_turned(&air, eye, toward, toward),
                              space_turned(&air, eye, toward, up),
                              space_turned(&air, eye, toward, to_sun), seed,
                              escapes, RAYS, error);
    }
}

static struct figures look(const struct space_eye *eye, struct air_vec toward,
                           int channel, const struct air_first *first,
                           uint64_t seed)
{
    struct air_scene scene = { &air, &sun, &ground };
    struct air_sight s;
    struct air_vec turned = ground.axis;
    ground.axis = axis;
    struct figures f = { .glint = space_glint(&scene, eye, toward, channel) };
    ground.axis = turned;
    if (!space_sight(&air, eye, toward, channel, &s)) {
        f.means = 1;
        return f;
    }
    s.first = first->count ? first : NULL;
    const struct air_ground black = { .kind = AIR_BLACK };
    const struct air_scene bare = { &air, &sun, &black };
    double once[AIR_SUNS], alone[AIR_SUNS];
    air_once(&scene, &s, once);
    air_once(&bare, &s, alone);
    f.single = alone[0];
    f.once = once[0];
    follow_paths(&scene, &s, seed, &f);
    return f;
}

static void measure(const struct space_eye *eye, const double *sight,
                    const uint64_t seed[AIR_CHANNELS])
{
    struct air_vec toward = space_toward(sight[0] * RADIAN, sight[1] * RADIAN);
    struct air_first first;
    double rough;
    meet(eye, toward, seed[0], &first, &rough);
    for (int c = 0; c < AIR_CHANNELS; c++) {
        struct figures f = look(eye, toward, c, &first, seed[c]);
        double by = irradiance[c], each = by / f.means;
        double mirrored = f.more[AIR_MIRRORED] * each;
        double error = f.means > 1 ? error_of(&f) * by : 0;
        printf("%.10g,%g,%g,%d,%.6g,%.2g,%.6g,%.6g", eye->height * 1e3,
               sight[0], sight[1], nanometres[c], f.once * by + f.sum * each,
               hypot(error, rough * mirrored), f.glint * by, f.single * by);
        printf(",%.6g,%.6g,%.6g\n", f.single * by + f.more[AIR_TURNED] * each,
               mirrored,
               (f.once - f.single - f.glint) * by +
                   f.more[AIR_LEFT_WATER] * each);
        fflush(stdout);
    }
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
         "once,air,mirrored,water");
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
            uint64_t seed[AIR_CHANNELS];
            for (int c = 0; c < AIR_CHANNELS; c++) {
                seed[c] = ((uint64_t)options.seed << 48) + ((uint64_t)i << 42) +
                          ((uint64_t)k << 26) + ((uint64_t)c << 24);
            }
            measure(&eye, sights[k], seed);
        }
    }
    return 0;
}
