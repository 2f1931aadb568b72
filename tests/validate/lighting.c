/* Fig. 10 of Bruneton et al. 2010: energy of each row of the picture, Sun, sky
 * and refracted light apart, calm and agitated, of the renderer, of the same
 * with a constant BRDF, and of brute force. Writes pictures, plots (SVG), a
 * table (Markdown) and figures (JSON) to a folder:
 *   lighting FOLDER [SAMPLES PER ROW]
 */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "encode/encode.h"
#include "optics/brdf.h"
#include "tests/validate/reference.h"

#define COLUMNS 160
#define ROWS 120
/* Slopes: rays hit the Sun's own disc too seldom. */
#define SUN_BLUR 0.05
#define FINE 4 /* the renderer's picture is this much finer */

enum part { SUN, SKY, WATER, PARTS };
static const char *const part_names[PARTS] = { "sun", "sky", "water" };
enum method { REFERENCE, OURS, CONSTANT, METHODS };
static const char *const method_names[METHODS] = { "brute force", "Pelagos",
                                                   "constant BRDF" };

struct scene {
    const char *name;
    double wind_mps;
};
static const struct scene scenes[] = { { "calm", 3.0 }, { "agitated", 12.0 } };

struct work {
    const struct reference *reference;
    const struct pel_camera *camera;
    int samples;
    atomic_int next_row;
    double (*energy)[ROWS];    /* [PARTS] of the reference, 550 nm */
    double error[PARTS][ROWS]; /* standard error of the mean, relative */
    float *picture[PARTS];     /* RGB of COLUMNS × ROWS */
};

static double random_unit(uint64_t *s)
{
    *s = *s * 6364136223846793005u + 1442695040888963407u;
    uint64_t z = (*s ^ (*s >> 31)) * 0x9E3779B97F4A7C15u;
    return (double)(z >> 11) * 0x1p-53;
}

static void trace_row(struct work *w, int row)
{
    const struct pel_camera *c = w->camera;
    uint64_t seed = 977u * (uint64_t)(row + 1);
    double sum[PARTS] = { 0 }, square[PARTS] = { 0 };
    int met = 0;
    for (int i = 0; i < w->samples; i++) {
        int column = i % COLUMNS;
        double x = (column + random_unit(&seed)) / COLUMNS;
        double y = (row + random_unit(&seed)) / ROWS;
        struct pel_vec3 ray = { c->tan_left + x * (c->tan_right - c->tan_left),
                                c->tan_top - y * (c->tan_top - c->tan_bottom),
                                -1.0 };
        ray = pel_vec3_normalize(pel_mat3_apply(&c->world_from_camera, ray));
        struct reference_sample s;
        const struct pel_vec3 eye = { 0, 0, c->altitude_m };
        if (!reference_trace(w->reference, eye, ray, &s)) {
            continue;
        }
        met++;
        const struct pel_rgb parts[PARTS] = { s.sun, s.sky, s.water };
        for (int p = 0; p < PARTS; p++) {
            sum[p] += parts[p].g;
            square[p] += parts[p].g * parts[p].g;
            float *to = &w->picture[p][3 * (row * COLUMNS + column)];
            double share = (double)COLUMNS / w->samples;
            to[0] += (float)(parts[p].r * share);
            to[1] += (float)(parts[p].g * share);
            to[2] += (float)(parts[p].b * share);
        }
    }
    for (int p = 0; p < PARTS; p++) {
        double mean = met > 0 ? sum[p] / met : 0.0;
        w->energy[p][row] = mean;
        double variance = met > 1 ? square[p] / met - mean * mean : 0.0;
        w->error[p][row] = mean > 0 ? sqrt(variance / met) / mean : 0.0;
    }
}

static void *work_rows(void *data)
{
    struct work *w = data;
    int row;
    while ((row = atomic_fetch_add(&w->next_row, 1)) < ROWS) {
        trace_row(w, row);
        if (row % 10 == 0) {
            fprintf(stderr, "\r  brute force: row %d of %d ", row, ROWS);
        }
    }
    return NULL;
}

/* Row means of the renderer's layers, over pixels that are sea. */
static bool draw_rows(struct pel_renderer *r, const struct pel_environment *env,
                      const struct pel_camera *camera,
                      double energy[PARTS][ROWS], float *pictures[PARTS])
{
    struct pel_draw draw = { .camera = *camera,
                             .layers = PEL_LAYER_SUN | PEL_LAYER_SKY |
                                       PEL_LAYER_WATER | PEL_LAYER_DEPTH };
    draw.camera.width *= FINE;
    draw.camera.height *= FINE;
    if (pel_renderer_submit(r, env, &draw, 1) != PEL_OK) {
        return false;
    }
    struct pel_picture *p = pel_renderer_collect(r, 60000000000);
    if (!p) {
        return false;
    }
    const float *layers[PARTS] = { p->sun, p->sky, p->water };
    for (int part = 0; part < PARTS; part++) {
        memset(pictures[part], 0, sizeof(float) * 3 * COLUMNS * ROWS);
        for (int row = 0; row < ROWS; row++) {
            double sum = 0.0;
            int met = 0;
            for (int i = row * FINE * COLUMNS * FINE;
                 i < (row + 1) * FINE * COLUMNS * FINE; i++) {
                if (!isfinite(p->depth[i])) {
                    continue;
                }
                sum += layers[part][4 * i + 1];
                met++;
                int column = i % (COLUMNS * FINE) / FINE;
                for (int c = 0; c < 3; c++) {
                    pictures[part][3 * (row * COLUMNS + column) + c] +=
                        layers[part][4 * i + c] / (FINE * FINE);
                }
            }
            energy[part][row] = met > 0 ? sum / met : 0.0;
        }
    }
    pel_picture_release(p);
    return true;
}

static void save_picture(const char *folder, const char *scene, enum part part,
                         enum method method, const float *rgb, double white)
{
    static uint8_t rgba[COLUMNS * ROWS * 4];
    for (int i = 0; i < COLUMNS * ROWS; i++) {
        for (int c = 0; c < 3; c++) {
            double v = pow(pel_clamp(rgb[3 * i + c] / white, 0, 1), 1 / 2.2);
            rgba[4 * i + c] = (uint8_t)lround(255 * v);
        }
        rgba[4 * i + 3] = 255;
    }
    static const char *const short_names[] = { "reference", "ours",
                                               "constant" };
    char path[512];
    snprintf(path, sizeof path, "%s/%s-%s-%s.png", folder, scene,
             part_names[part], short_names[method]);
    struct pel_bytes png;
    FILE *file = fopen(path, "wb");
    if (file && pel_png_encode(rgba, COLUMNS, ROWS, &png) == PEL_OK) {
        fwrite(png.data, 1, png.size, file);
        pel_bytes_finish(&png);
    }
    if (file) {
        fclose(file);
    }
}

static void save_plot(const char *folder, const char *scene, enum part part,
                      double energy[METHODS][PARTS][ROWS], int first)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s-%s.svg", folder, scene,
             part_names[part]);
    FILE *f = fopen(path, "w");
    if (!f) {
        return;
    }
    double most = 0;
    for (int m = 0; m < METHODS; m++) {
        for (int row = first; row < ROWS; row++) {
            most = fmax(most, energy[m][part][row]);
        }
    }
    fprintf(f,
            "<svg xmlns='http://www.w3.org/2000/svg' width='520' height='320' "
            "font-family='sans-serif' font-size='12'>\n"
            "<rect width='520' height='320' fill='white'/>\n"
            "<text x='60' y='18'>%s sea, %s: mean radiance of a row at 550 nm"
            "</text>\n<path d='M60 30V280H500' fill='none' stroke='black'/>\n"
            "<text x='200' y='306'>row below the horizon</text>\n"
            "<text x='4' y='40'>%.3g</text>\n",
            scene, part_names[part], most);
    static const char *const colors[] = { "black", "#0a6ebd", "#c0392b" };
    for (int m = 0; m < METHODS; m++) {
        fprintf(
            f,
            "<text x='380' y='%d' fill='%s'>%s</text>\n<polyline fill='none' "
            "stroke='%s' points='",
            44 + 16 * m, colors[m], method_names[m], colors[m]);
        for (int row = first; row < ROWS; row++) {
            fprintf(f, "%.1f,%.1f ",
                    60 + 440.0 * (row - first) / (ROWS - first),
                    280 - 245 * energy[m][part][row] / most);
        }
        fprintf(f, "'/>\n");
    }
    fprintf(f, "</svg>\n");
    fclose(f);
}

static struct pel_camera make_camera(void)
{
    const double pitch = -14 * PEL_DEG;
    struct pel_camera c = { .altitude_m = 12,
                            .width = COLUMNS,
                            .height = ROWS,
                            .auto_exposure = true };
    c.world_from_camera = (struct pel_mat3){
        { 1, 0, 0 },
        { 0, -sin(pitch), cos(pitch) },
        { 0, -cos(pitch), -sin(pitch) },
    };
    c.tan_right = tan(25 * PEL_DEG);
    c.tan_left = -c.tan_right;
    c.tan_top = c.tan_right * ROWS / COLUMNS;
    c.tan_bottom = -c.tan_top;
    return c;
}

/* First row whose upper edge is 0.4° under the horizon: above it the flat
 * Earth of the reference is not the sphere of the renderer. */
static int first_row(const struct pel_camera *c)
{
    double horizon = tan(14 * PEL_DEG - 0.4 * PEL_DEG);
    double y = (c->tan_top - horizon) / (c->tan_top - c->tan_bottom) * ROWS;
    return (int)ceil(y);
}

static bool run_scene(struct pel_renderer *r, const struct scene *scene,
                      const char *folder, int samples, FILE *table, FILE *json,
                      bool last)
{
    static struct pel_sea sea;
    const struct pel_sea_desc desc = { .wind_mps = scene->wind_mps,
                                       .direction_rad = 0.5 * PEL_PI,
                                       .fetch_m = 2e5,
                                       .gamma = 3.3,
                                       .seed = 5,
                                       .wave_count = 60 };
    if (pel_sea_build(&desc, &sea) != PEL_OK) {
        return false;
    }
    const double visibility = 60000, elevation = 35 * PEL_DEG;
    struct pel_environment env = {
        .time_s = 20,
        .sea = &sea,
        .sun = { 0, cos(elevation), sin(elevation) },
        .wind_mps = scene->wind_mps,
        .wind_to_rad = desc.direction_rad,
        .visibility_m = visibility,
        .water = pel_water_deep(0.3),
        .no_air = true,
        .sun_blur = SUN_BLUR,
    };
    struct pel_atmosphere *air = malloc(sizeof *air);
    const struct pel_atmosphere_desc air_desc = { visibility };
    pel_atmosphere_init(&air_desc, air);
    pel_atmosphere_tabulate(air);
    struct pel_rgb sun = pel_atmosphere_sun_irradiance(air, 0, env.sun);
    struct pel_rgb sky = pel_atmosphere_sky_irradiance(air, env.sun);
    free(air);
    static struct pel_water_table leaving;
    if (pel_water_table_build(&env.water, acos(env.sun.z), NULL, &leaving)) {
        return false;
    }
    const struct reference_light light = {
        .sun = env.sun,
        .sun_irradiance = sun,
        .sky_irradiance = sky,
        .water = &leaving,
        .slope_sigma =
            sqrt(0.5 * (sea.slope_variance_along + sea.slope_variance_cross)),
        .blur = SUN_BLUR,
    };
    static double energy[METHODS][PARTS][ROWS];
    static float pictures[METHODS][PARTS][3 * COLUMNS * ROWS];
    memset(pictures, 0, sizeof pictures);
    struct pel_camera camera = make_camera();
    struct reference *reference =
        reference_create(&sea, env.time_s, visibility, &light);
    if (!reference) {
        return false;
    }
    struct work work = { .reference = reference,
                         .camera = &camera,
                         .samples = samples,
                         .energy = energy[REFERENCE],
                         .picture = { pictures[REFERENCE][SUN],
                                      pictures[REFERENCE][SKY],
                                      pictures[REFERENCE][WATER] } };
    atomic_store(&work.next_row, first_row(&camera) - 1);
    pthread_t threads[64];
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    count = count < 1 ? 1 : count > 64 ? 64 : count;
    for (long i = 0; i < count; i++) {
        pthread_create(&threads[i], NULL, work_rows, &work);
    }
    for (long i = 0; i < count; i++) {
        pthread_join(threads[i], NULL);
    }
    reference_destroy(reference);
    for (int m = OURS; m < METHODS; m++) {
        float *to[PARTS] = { pictures[m][SUN], pictures[m][SKY],
                             pictures[m][WATER] };
        env.constant_brdf = m == CONSTANT;
        if (!draw_rows(r, &env, &camera, energy[m], to)) {
            return false;
        }
    }
    int first = first_row(&camera);
    for (int p = 0; p < PARTS; p++) {
        double error[METHODS] = { 0 }, noise = 0, white = 0;
        for (int row = first; row < ROWS; row++) {
            double truth = energy[REFERENCE][p][row];
            for (int m = OURS; m < METHODS; m++) {
                error[m] += fabs(energy[m][p][row] - truth) / truth;
            }
            noise += work.error[p][row];
            white = fmax(white, truth);
        }
        int rows = ROWS - first;
        fprintf(table, "| %s, %.0f m/s | %s | %.1f %% | %.1f %% | %.1f %% |\n",
                scene->name, scene->wind_mps, part_names[p],
                100 * error[OURS] / rows, 100 * error[CONSTANT] / rows,
                100 * noise / rows);
        fprintf(json,
                "  {\"sea\": \"%s\", \"part\": \"%s\", \"error\": %.5f, "
                "\"constantBrdf\": %.5f, \"referenceNoise\": %.5f}%s\n",
                scene->name, part_names[p], error[OURS] / rows,
                error[CONSTANT] / rows, noise / rows,
                last && p == PARTS - 1 ? "" : ",");
        for (int m = 0; m < METHODS; m++) {
            save_picture(folder, scene->name, (enum part)p, (enum method)m,
                         pictures[m][p], 1.2 * white);
        }
        save_plot(folder, scene->name, (enum part)p, energy, first);
    }
    return true;
}

static FILE *open_in(const char *folder, const char *name)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    if (!file) {
        perror(path);
        exit(1);
    }
    return file;
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        fprintf(stderr, "usage: lighting FOLDER [SAMPLES PER ROW]\n");
        return 2;
    }
    int samples = argc > 2 ? atoi(argv[2]) : 40000;
    struct pel_fault fault;
    struct pel_renderer *r;
    const struct pel_renderer_options options = { .device = "software" };
    if (pel_renderer_create(&options, &r, &fault) != PEL_OK) {
        fprintf(stderr, "%s\n", fault.message);
        return 1;
    }
    FILE *table = open_in(argv[1], "lighting.md");
    FILE *json = open_in(argv[1], "lighting.json");
    fprintf(table,
            "Energy of the rows under the horizon, mean relative error "
            "against brute force (%d rays a row)\n\n"
            "| sea | light | Pelagos | constant BRDF | noise of the "
            "reference |\n|---|---|---|---|---|\n",
            samples);
    fprintf(json, "[\n");
    bool ok = true;
    size_t count = sizeof scenes / sizeof *scenes;
    for (size_t i = 0; i < count && ok; i++) {
        fprintf(stderr, "%s sea, wind %.0f m/s\n", scenes[i].name,
                scenes[i].wind_mps);
        ok = run_scene(r, &scenes[i], argv[1], samples, table, json,
                       i + 1 == count);
        fprintf(stderr, "\n");
    }
    fprintf(json, "]\n");
    fclose(table);
    fclose(json);
    pel_renderer_destroy(r);
    return ok ? 0 : 1;
}
