#include "optics/stars.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/log.h"

/* Of those whose colour is not known. */
#define USUAL_COLOUR 0.45
/* T Coronae Borealis: the catalogue has its outburst. */
#define NOVA 5958

/* B − V by number in the catalogue. */
static const struct {
    int number;
    double b_v;
} colours[] = {
    { 2491, 0.00 },  { 2326, 0.15 },  { 5340, 1.23 },  { 5459, 0.71 },
    { 7001, 0.00 },  { 1708, 0.80 },  { 1713, -0.03 }, { 2943, 0.42 },
    { 472, -0.16 },  { 2061, 1.85 },  { 5267, -0.23 }, { 7557, 0.22 },
    { 1457, 1.54 },  { 6134, 1.83 },  { 5056, -0.23 }, { 2990, 1.00 },
    { 8728, 0.09 },  { 7924, 0.09 },  { 4853, -0.23 }, { 5460, 0.88 },
    { 4730, -0.24 }, { 3982, -0.11 }, { 2618, -0.21 }, { 6527, -0.22 },
    { 4763, 1.59 },  { 1790, -0.22 }, { 1791, -0.13 }, { 3685, 0.00 },
    { 1903, -0.19 }, { 4731, -0.26 }, { 8425, -0.13 }, { 4905, -0.02 },
    { 3207, -0.22 }, { 1017, 0.48 },  { 4301, 1.07 },  { 2693, 0.68 },
    { 6879, -0.03 }, { 5191, -0.19 }, { 3307, 1.28 },  { 6553, 0.40 },
    { 2088, 0.03 },  { 6217, 1.44 },  { 2421, 0.00 },  { 7790, -0.20 },
    { 3485, 0.04 },  { 3748, 1.44 },  { 2891, 0.03 },  { 2294, -0.23 },
    { 617, 1.15 },   { 424, 0.60 },   { 7121, -0.22 }, { 188, 1.02 },
    { 1948, -0.21 }, { 5288, 1.01 },  { 337, 1.58 },   { 15, -0.11 },
    { 6556, 0.15 },  { 5563, 1.47 },  { 936, -0.05 },  { 603, 1.37 },
    { 4534, 0.09 },  { 2004, -0.17 }, { 5793, -0.02 }, { 7796, 0.68 },
    { 6705, 1.52 },  { 168, 1.17 },   { 21, 0.34 },    { 1852, -0.22 },
    { 5054, 0.02 },  { 3165, -0.26 }, { 3634, 1.66 },  { 4295, -0.02 },
    { 4554, 0.00 },  { 5953, -0.12 }, { 6241, 1.15 },  { 8308, 1.53 },
    { 8775, 1.67 },  { 8781, -0.04 }, { 6378, 0.06 },
};

/* Eastward and northward, seconds of arc a year. */
static const struct {
    int number;
    double east, north;
} motions[] = {
    { 5459, -3.678, 0.482 },  { 5460, -3.600, 0.952 },
    { 5340, -1.093, -2.000 }, { 2491, -0.546, -1.223 },
    { 2943, -0.714, -1.037 }, { 8085, 4.156, 3.259 },
    { 8086, 4.107, 3.144 },   { 8387, 3.961, -2.538 },
    { 1325, -2.240, -3.420 }, { 1008, 3.038, 0.726 },
    { 321, 3.422, -1.599 },   { 509, -1.721, 0.854 },
    { 7557, 0.537, 0.386 },
};

static struct pel_vec3 motion_of(int number, double d, double a)
{
    const struct pel_vec3 east = { -sin(a), cos(a), 0 },
                          north = { -sin(d) * cos(a), -sin(d) * sin(a),
                                    cos(d) };
    for (size_t i = 0; i < sizeof motions / sizeof *motions; i++) {
        if (motions[i].number == number) {
            return pel_vec3_scale(
                pel_vec3_add(pel_vec3_scale(east, motions[i].east),
                             pel_vec3_scale(north, motions[i].north)),
                PEL_DEG / 3600.0);
        }
    }
    return (struct pel_vec3){ 0, 0, 0 };
}

struct pel_rgb pel_star_irradiance(double magnitude, double b_v)
{
    const struct pel_rgb sun = PEL_SUN_IRRADIANCE;
    double v = 3.63e-11 * pow(10.0, -0.4 * magnitude), redder = b_v - 0.65;
    return (struct pel_rgb){ v * sun.r / sun.g * pow(10.0, 0.22 * redder), v,
                             v * sun.b / sun.g * pow(10.0, -0.4 * redder) };
}

static double colour_of(int number)
{
    for (size_t i = 0; i < sizeof colours / sizeof *colours; i++) {
        if (colours[i].number == number) {
            return colours[i].b_v;
        }
    }
    return USUAL_COLOUR;
}

size_t pel_stars_read(const char *text, struct pel_star *out, size_t most)
{
    size_t count = 0;
    for (const char *line = text; line && *line && count < most;) {
        double declination, hours, magnitude;
        int number = 0, name = 0;
        const char *end = strchr(line, '\n');
        if (sscanf(line, "%lf %lf %lf \"%n", &declination, &hours, &magnitude,
                   &name) == 3 &&
            name) {
            const char *quote = strchr(line + name, '"');
            if (quote && (!end || quote < end)) {
                number = (int)strtol(quote + 1, NULL, 10);
            }
            double d = declination * PEL_DEG, a = hours * 15.0 * PEL_DEG;
            if (number != NOVA) {
                out[count++] = (struct pel_star){
                    .to = { cos(d) * cos(a), cos(d) * sin(a), sin(d) },
                    .moves = motion_of(number, d, a),
                    .irradiance =
                        pel_star_irradiance(magnitude, colour_of(number)),
                    .magnitude = magnitude,
                };
            }
        }
        line = end ? end + 1 : NULL;
    }
    return count;
}

static struct pel_star *catalogue;
static size_t catalogue_count;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void load(void)
{
    char *text = NULL;
    size_t size = 0;
    struct pel_fault fault = { 0 };
    if (pel_file_read(PEL_STARS_FILE, 4 << 20, &text, &size, &fault)) {
        pel_warn("OPT-001",
                 "no stars at night: %s; Debian's package xplanet "
                 "has them",
                 fault.message);
        return;
    }
    catalogue = malloc(sizeof *catalogue * PEL_STARS_MOST);
    if (catalogue) {
        catalogue_count = pel_stars_read(text, catalogue, PEL_STARS_MOST);
    }
    free(text);
}

const struct pel_star *pel_stars(size_t *count)
{
    pthread_once(&once, load);
    *count = catalogue_count;
    return catalogue;
}
