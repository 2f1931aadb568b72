/* A ship in realised seas, pixel by pixel, by rays:
 *   shiptrace < scene > pixels
 *
 * The scene, words and numbers:
 *   wind W fetch F chop C      a sea of Pierson and Moskowitz, W in m/s, its
 *                              waves running to the azimuth TO (degrees, from
 *                              x to y), crests sharpened where C is 1
 *   to TO realisations N rays N (of a pixel and realisation) seed N nodes N
 *   eye X Y Z  pitch P  field F (degrees)  width W  height H  skip N
 *       looks along x; lines 0 .. skip - 1 are left out
 *   columns FROM TO
 *   elevation E  irradiance R G B  water R G B  fade R G B
 *   suns N A…                  azimuths, degrees from x to y
 *   sky FILE                   121 x 181 x 3 doubles (sealight.h)
 *   mesh FILE                  of a triangle ten doubles: corners, albedo
 *
 * x is where the eye looks, z up. It prints for each realisation, line and
 * column means of struct ship_sight as float: FIELDS of them.
 */
#include "shiplight.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define DEGREE (PI / 180)

static struct options {
    double wind, fetch, chop, to, realisations, rays, seed, nodes, eye[3];
    double pitch, field, width, height, skip, columns[2], elevation;
    double suns, azimuth[SHIP_SUNS];
} o;

static struct ship_scene scene;

static void end(const char *why, const char *what)
{
    fprintf(stderr, "shiptrace: %s %s\n", why, what);
    exit(2);
}

static double *read_file(const char *name, size_t *count)
{
    FILE *file = fopen(name, "rb");
    if (!file || fseek(file, 0, SEEK_END)) {
        end("cannot read", name);
    }
    *count = (size_t)ftell(file) / sizeof(double);
    rewind(file);
    double *values = calloc(*count + 1, sizeof(double));
    if (!values || fread(values, sizeof(double), *count, file) != *count) {
        end("cannot read", name);
    }
    fclose(file);
    return values;
}

static void read_mesh(const char *name)
{
    size_t count;
    double *values = read_file(name, &count);
    struct ship_triangle *t = calloc(count / 10 + 1, sizeof(*t));
    for (size_t i = 0; t && i < count / 10; i++) {
        memcpy(t[i].corner, values + 10 * i, sizeof(t[i].corner));
        t[i].albedo = values[10 * i + 9];
    }
    free(values);
    ship_mesh_init(&scene.mesh, t, (int)(count / 10));
}

static void read_sky(const char *name)
{
    size_t count;
    double *values = read_file(name, &count);
    if (count != sizeof(scene.sky[0].radiance) / sizeof(float)) {
        end("not a sky:", name);
    }
    for (int s = 0; s < SHIP_SUNS; s++) {
        float *to = &scene.sky[s].radiance[0][0][0];
        for (size_t i = 0; i < count; i++) {
            to[i] = (float)values[i];
        }
    }
    free(values);
}

static const struct word {
    const char *name;
    double *to;
    int count;
} words[] = {
    { "wind", &o.wind, 1 },
    { "fetch", &o.fetch, 1 },
    { "chop", &o.chop, 1 },
    { "to", &o.to, 1 },
    { "realisations", &o.realisations, 1 },
    { "rays", &o.rays, 1 },
    { "seed", &o.seed, 1 },
    { "nodes", &o.nodes, 1 },
    { "eye", o.eye, 3 },
    { "pitch", &o.pitch, 1 },
    { "field", &o.field, 1 },
    { "width", &o.width, 1 },
    { "height", &o.height, 1 },
    { "skip", &o.skip, 1 },
    { "columns", o.columns, 2 },
    { "elevation", &o.elevation, 1 },
    { "suns", &o.suns, 1 },
    { "azimuths", o.azimuth, SHIP_SUNS },
    { "irradiance", scene.irradiance, SHIP_CHANNELS },
    { "water", scene.water, SHIP_CHANNELS },
    { "fade", scene.fade, SHIP_CHANNELS },
};

static void read_scene(void)
{
    char name[32], file[1024];
    while (scanf("%31s", name) == 1) {
        size_t i = 0, count = sizeof(words) / sizeof(*words);
        while (i < count && strcmp(words[i].name, name)) {
            i++;
        }
        for (int j = 0; i < count && j < words[i].count; j++) {
            if (scanf("%lf", &words[i].to[j]) != 1) {
                end("no number after", name);
            }
        }
        if (i < count) {
            continue;
        }
        if (scanf("%1023s", file) != 1) {
            end("nothing after", name);
        }
        if (strcmp(name, "mesh") == 0) {
            read_mesh(file);
        } else if (strcmp(name, "sky") == 0) {
            read_sky(file);
        } else {
            end("no such word:", name);
        }
    }
}

/* Through a pixel, anywhere in it. */
static void through(int column, int line, struct sea_random *random, double *d)
{
    double scale = 2 * tan(o.field / 2 * DEGREE) / o.width;
    double u = (column + sea_random_unit(random) - o.width / 2) * scale;
    double v = (o.height / 2 - line - sea_random_unit(random)) * scale;
    double c = cos(o.pitch * DEGREE), s = sin(o.pitch * DEGREE);
    d[0] = c - v * s;
    d[1] = -u;
    d[2] = s + v * c;
    double length = sqrt(sea_dot(d, d));
    for (int i = 0; i < 3; i++) {
        d[i] /= length;
    }
}

static void pixel(int column, int line, struct sea_random *random)
{
    enum { FIELDS = sizeof(struct ship_sight) / sizeof(double) };
    double sum[FIELDS] = { 0 };
    for (int i = 0; i < (int)o.rays; i++) {
        double direction[3];
        struct ship_sight sight;
        through(column, line, random, direction);
        ship_look(&scene, o.eye, direction, random, &sight);
        const double *value = (const double *)&sight;
        for (int j = 0; j < FIELDS; j++) {
            sum[j] += value[j];
        }
    }
    float out[FIELDS];
    for (int j = 0; j < FIELDS; j++) {
        out[j] = (float)(sum[j] / o.rays);
    }
    fwrite(out, sizeof(out), 1, stdout);
}

/* Waves up to twice as long as the ship, 30 m: with longer ones it goes. */
static double washed(const struct sea_spectrum *spectrum)
{
    enum { STEPS = 4000, ANGLES = 90 };
    double sum = 0, low = log(PI / 30), high = log(PI / 0.02);
    for (int i = 0; i < STEPS; i++) {
        double k = exp(low + (i + 0.5) / STEPS * (high - low));
        for (int a = 0; a < ANGLES; a++) {
            double cosine = cos((a + 0.5) / ANGLES * 2 * PI);
            sum += sea_spectrum_density(spectrum, k, cosine) * k * k *
                   (high - low) / STEPS * 2 * PI / ANGLES;
        }
    }
    return sqrt(sum);
}

int main(void)
{
    read_scene();
    scene.index = 1.34;
    scene.suns = (int)o.suns;
    for (int s = 0; s < scene.suns; s++) {
        double e = o.elevation * DEGREE, a = o.azimuth[s] * DEGREE;
        scene.sky[s].sun[0] = cos(e) * cos(a);
        scene.sky[s].sun[1] = cos(e) * sin(a);
        scene.sky[s].sun[2] = sin(e);
    }
    static struct sea_spectrum spectrum;
    sea_spectrum_init(&spectrum, SEA_PIERSON_MOSKOWITZ, o.wind, o.fetch, 0.02);
    sea_surface_init(&scene.surface, &spectrum, (int)o.nodes, o.to * DEGREE);
    if (o.chop > 0) {
        sea_surface_chop(&scene.surface, &spectrum);
    }
    scene.washed = washed(&spectrum);
    struct sea_random random;
    sea_random_init(&random, (uint64_t)o.seed);
    for (int r = 0; r < (int)o.realisations; r++) {
        sea_surface_fill(&scene.surface, &random);
        for (int line = (int)o.skip; line < (int)o.height; line++) {
            for (int x = (int)o.columns[0]; x < (int)o.columns[1]; x++) {
                pixel(x, line, &random);
            }
        }
    }
    sea_surface_finish(&scene.surface);
    ship_mesh_finish(&scene.mesh);
    return 0;
}
