/* Fig. 10 of Bruneton et al. 2010: energy of each row of the picture, Sun, sky
 * and refracted light apart, calm and agitated, of the renderer, of the same
 * with the paper's own sky and with a constant BRDF, and of brute force. Writes
 * pictures, plots (SVG), a table (Markdown) and figures (JSON) to a folder:
 *   lighting FOLDER [--quick] [--rays MOST]
 * Status 3 where a part of the light misses what is wanted of it. --quick takes
 * so few rays that the reference itself is uncertain: what its energies moved
 * by when the rays doubled last is added to each bound.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "encode/encode.h"
#include "optics/brdf.h"
#include "tests/validate/rowtrace.h"

#define COLUMNS 160
#define ROWS 120
/* Slopes: rays hit the Sun's own disc too seldom. */
#define SUN_BLUR 0.05
#define FINE 4 /* the renderer's picture is this much finer */
#define LEAST_RAYS 4096
#define MOVE 0.01

static const char *const part_names[PARTS] = { "sun", "sky", "water" };
enum method { REFERENCE, OURS, PAPER, CONSTANT, METHODS };
static const struct {
    const char *name, *key, *color;
} methods[METHODS] = { { "brute force", "reference", "black" },
                       { "Pelagos", "ours", "#0a6ebd" },
                       { "as the paper", "paper", "#2e9e4f" },
                       { "constant BRDF", "constant", "#c0392b" } };

struct scene {
    const char *name;
    double wind_mps;
    /* What is wanted of ours: mean relative error of each part. */
    double wanted[PARTS];
};
static const struct scene scenes[] = {
    { "calm", 3.0, { 0.05, 0.03, 0.02 } },
    { "agitated", 12.0, { 0.05, 0.08, 0.02 } },
};

struct options {
    const char *folder;
    long most; /* rays of a row */
    bool quick;
};

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
    char path[512];
    snprintf(path, sizeof path, "%s/%s-%s-%s.png", folder, scene,
             part_names[part], methods[method].key);
    const struct pel_encode_input in = { .rgba = rgba,
                                         .width = COLUMNS,
                                         .height = ROWS };
    struct pel_bytes png;
    FILE *file = fopen(path, "wb");
    if (file && pel_png_encode(&in, &png) == PEL_OK) {
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
    for (int m = 0; m < METHODS; m++) {
        fprintf(
            f,
            "<text x='380' y='%d' fill='%s'>%s</text>\n<polyline fill='none' "
            "stroke='%s' points='",
            44 + 16 * m, methods[m].color, methods[m].name, methods[m].color);
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

/* What the light of a scene is made of. */
struct lights {
    struct pel_environment env;
    struct reference_light reference;
    struct pel_water_table leaving;
    double visibility_m;
};

static bool make_lights(const struct scene *scene, const struct pel_sea *sea,
                        struct lights *out)
{
    const double elevation = 35 * PEL_DEG;
    out->visibility_m = 60000;
    out->env = (struct pel_environment){
        .time_s = 20,
        .sea = sea,
        .wind_mps = scene->wind_mps,
        .wind_to_rad = sea->desc.direction_rad,
        .visibility_m = out->visibility_m,
        .water = pel_water_deep(0.3),
        .no_air = true,
        .light_blur = SUN_BLUR,
    };
    const struct pel_vec3 sun = { 0, cos(elevation), sin(elevation) };
    pel_lights_of_sun(sun, out->env.lights);
    struct pel_atmosphere *air = malloc(sizeof *air);
    if (!air) {
        return false;
    }
    const struct pel_atmosphere_desc desc = { out->visibility_m };
    pel_atmosphere_init(&desc, air);
    if (pel_atmosphere_tabulate(air, NULL, NULL)) {
        free(air);
        return false;
    }
    out->reference = (struct reference_light){
        .sun = sun,
        .sun_irradiance = pel_atmosphere_sun_irradiance(air, 0, sun),
        .sky_irradiance = pel_atmosphere_sky_irradiance(air, sun),
        .water = &out->leaving,
        .slope_sigma =
            sqrt(0.5 * (sea->slope_variance_along + sea->slope_variance_cross)),
        .blur = SUN_BLUR,
    };
    pel_atmosphere_finish(air);
    free(air);
    return pel_water_table_build(&out->env.water, acos(sun.z), NULL,
                                 &out->leaving) == PEL_OK;
}

/* Energies and pictures of a scene by every method. */
struct results {
    double energy[METHODS][PARTS][ROWS];
    float pictures[METHODS][PARTS][3 * COLUMNS * ROWS];
    struct row_result rows[ROWS];
};

static bool trace_scene(const struct scene *scene, const struct pel_sea *sea,
                        const struct lights *l, const struct options *o,
                        struct results *out)
{
    struct reference *reference =
        reference_create(sea, l->env.time_s, l->visibility_m, &l->reference);
    if (!reference) {
        return false;
    }
    struct row_plan plan = {
        .reference = reference,
        .light = &l->reference,
        .camera = make_camera(),
        .least = o->quick ? LEAST_RAYS / 2 : LEAST_RAYS,
        .most = o->most,
        .move = MOVE,
        /* The wind blows to the north. */
        .slope_x = sea->slope_variance_cross,
        .slope_y = sea->slope_variance_along,
    };
    plan.first = first_row(&plan.camera);
    float *pictures[PARTS];
    for (int p = 0; p < PARTS; p++) {
        pictures[p] = out->pictures[REFERENCE][p];
    }
    rowtrace(&plan, scene->name, out->rows, pictures);
    for (int row = plan.first; row < ROWS; row++) {
        for (int p = 0; p < PARTS; p++) {
            out->energy[REFERENCE][p][row] = out->rows[row].energy[p];
        }
    }
    reference_destroy(reference);
    return true;
}

static struct pel_renderer *make_renderer(bool paper)
{
    struct pel_fault fault;
    struct pel_renderer *r = NULL;
    const struct pel_renderer_options options = { .device = "software",
                                                  .filtering.paper = paper };
    if (pel_renderer_create(&options, &r, &fault) != PEL_OK) {
        fprintf(stderr, "%s\n", fault.message);
        exit(1);
    }
    return r;
}

/* One renderer after the other: a thread has one context. */
static bool draw_scene(struct lights *l, struct results *out)
{
    struct pel_camera camera = make_camera();
    bool ok = true;
    for (int m = OURS; m < METHODS && ok; m++) {
        struct pel_renderer *r = make_renderer(m == PAPER);
        float *to[PARTS] = { out->pictures[m][SUN], out->pictures[m][SKY],
                             out->pictures[m][WATER] };
        l->env.constant_brdf = m == CONSTANT;
        ok = draw_rows(r, &l->env, &camera, out->energy[m], to);
        pel_renderer_destroy(r);
    }
    return ok;
}

/* Mean relative error of a part over the rows. */
static double mean_error(const struct results *r, int method, int part,
                         int first)
{
    double sum = 0;
    for (int row = first; row < ROWS; row++) {
        double truth = r->energy[REFERENCE][part][row];
        sum += fabs(r->energy[method][part][row] - truth) / truth;
    }
    return sum / (ROWS - first);
}

static void write_rows(FILE *f, const char *name, const double *v, int first)
{
    fprintf(f, "   \"%s\": [", name);
    for (int row = first; row < ROWS; row++) {
        fprintf(f, "%s%.6g", row > first ? ", " : "", v[row]);
    }
    fprintf(f, "]");
}

/* A reference that moves by more than this is none: twice what the quick form
 * is seen to do. */
#define MOVE_MOST 0.04

static bool report_part(const struct scene *scene, const struct results *r,
                        bool quick, int part, FILE *table, FILE *json,
                        bool last)
{
    int first, rows, still = 0;
    struct pel_camera camera = make_camera();
    first = first_row(&camera);
    rows = ROWS - first;
    double mean_move = 0, worst = 0, error[METHODS];
    for (int row = first; row < ROWS; row++) {
        double move = r->rows[row].move[part];
        mean_move += move / rows;
        worst = fmax(worst, move);
        still += move < MOVE;
    }
    for (int m = OURS; m < METHODS; m++) {
        error[m] = mean_error(r, m, part, first);
    }
    double room = quick ? mean_move : 0.0;
    bool met =
        error[OURS] <= scene->wanted[part] + room && mean_move <= MOVE_MOST;
    fprintf(table,
            "| %s, %.0f m/s | %s | %.1f %% | %.0f %% | %s | %.1f %% | %.1f %% "
            "| %.2f %%, %.1f %% | %d of %d |\n",
            scene->name, scene->wind_mps, part_names[part], 100 * error[OURS],
            100 * scene->wanted[part], met ? "yes" : "**no**",
            100 * error[PAPER], 100 * error[CONSTANT], 100 * mean_move,
            100 * worst, still, rows);
    fprintf(json,
            "  {\"sea\": \"%s\", \"part\": \"%s\", \"error\": %.5f, "
            "\"wanted\": %.2f, \"paper\": %.5f, \"constantBrdf\": %.5f, "
            "\"referenceMoved\": %.5f, \"referenceMovedMost\": %.5f, "
            "\"rowsStill\": %d, \"firstRow\": %d,\n",
            scene->name, part_names[part], error[OURS], scene->wanted[part],
            error[PAPER], error[CONSTANT], mean_move, worst, still, first);
    for (int m = 0; m < METHODS; m++) {
        write_rows(json, methods[m].key, r->energy[m][part], first);
        fprintf(json, "%s\n", m + 1 < METHODS ? "," : last ? "}" : "},");
    }
    return met;
}

static bool run_scene(const struct scene *scene, const struct options *o,
                      FILE *table, FILE *json, bool last, int *missed)
{
    static struct pel_sea sea;
    static struct lights lights;
    static struct results results;
    const struct pel_sea_desc desc = { .wind_mps = scene->wind_mps,
                                       .direction_rad = 0.5 * PEL_PI,
                                       .fetch_m = 2e5,
                                       .gamma = 3.3,
                                       .seed = 5,
                                       .wave_count = 60 };
    memset(&results, 0, sizeof results);
    if (pel_sea_build(&desc, &sea) != PEL_OK ||
        !make_lights(scene, &sea, &lights) || !draw_scene(&lights, &results) ||
        !trace_scene(scene, &sea, &lights, o, &results)) {
        return false;
    }
    struct pel_camera camera = make_camera();
    int first = first_row(&camera);
    for (int p = 0; p < PARTS; p++) {
        double white = 0;
        for (int row = first; row < ROWS; row++) {
            white = fmax(white, results.energy[REFERENCE][p][row]);
        }
        *missed += !report_part(scene, &results, o->quick, p, table, json,
                                last && p == PARTS - 1);
        for (int m = 0; m < METHODS; m++) {
            save_picture(o->folder, scene->name, (enum part)p, (enum method)m,
                         results.pictures[m][p], 1.2 * white);
        }
        save_plot(o->folder, scene->name, (enum part)p, results.energy, first);
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

static bool read_options(int argc, char **argv, struct options *o)
{
    *o = (struct options){ .most = 1 << 20 };
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--quick") == 0) {
            o->quick = true;
            o->most = 1 << 13;
        } else if (strcmp(argv[i], "--rays") == 0 && i + 1 < argc) {
            o->most = atol(argv[++i]);
        } else if (!o->folder && argv[i][0] != '-') {
            o->folder = argv[i];
        } else {
            return false;
        }
    }
    return o->folder && o->most > 0;
}

int main(int argc, char **argv)
{
    struct options o;
    if (!read_options(argc, argv, &o)) {
        fprintf(stderr, "usage: lighting FOLDER [--quick] [--rays MOST]\n");
        return 2;
    }
    FILE *table = open_in(o.folder, "lighting.md");
    FILE *json = open_in(o.folder, "lighting.json");
    fprintf(table,
            "Energy of the rows under the horizon, mean relative error "
            "against brute force\n\nRays of a row double, from %d to %ld at "
            "most, until its energies move by less than %.0f %%.\n\n"
            "| sea | light | Pelagos | wanted | met | as the paper | constant "
            "BRDF | reference moved, mean, most | rows still |\n"
            "|---|---|---|---|---|---|---|---|---|\n",
            LEAST_RAYS, o.most, 100 * MOVE);
    fprintf(json, "[\n");
    bool ok = true;
    int missed = 0;
    size_t count = sizeof scenes / sizeof *scenes;
    for (size_t i = 0; i < count && ok; i++) {
        ok = run_scene(&scenes[i], &o, table, json, i + 1 == count, &missed);
    }
    fprintf(json, "]\n");
    fclose(table);
    fclose(json);
    return !ok ? 1 : missed > 0 ? 3 : 0;
}
