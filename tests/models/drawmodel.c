/* Draws a model from the side, the front, above and ahead of the bow, with
 * nothing but triangles, a depth buffer and Lambert's light: for the contact
 * sheet (sheet.py). Pixels are 3 × 3 samples.
 *
 *   drawmodel builtin NAME LEVEL OUT.png
 *   drawmodel DIRECTORY FILE LEVEL OUT.png
 *
 * Prints one line of what it is. The sea is drawn as a line. */
#include <spng.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "models/builtin.h"
#include "models/modelload.h"

#define WIDTH 1200
#define HEIGHT 620
#define SAMPLES 3
#define W (WIDTH * SAMPLES)
#define H (HEIGHT * SAMPLES)

static float colour[H][W][3], depth[H][W];

/* A window of the picture and what it sees: along `from` of the model. */
struct view {
    int x, y, width, height; /* pixels */
    struct pel_vec3 right, up, towards;
    double perspective; /* distance of the eye over the radius; 0: none */
};

static void clear(const struct view *v, double horizon)
{
    for (int y = v->y * SAMPLES; y < (v->y + v->height) * SAMPLES; y++) {
        for (int x = v->x * SAMPLES; x < (v->x + v->width) * SAMPLES; x++) {
            bool sea = y > horizon * SAMPLES;
            const float sky[] = { 0.62f, 0.72f, 0.82f };
            const float water[] = { 0.28f, 0.42f, 0.5f };
            memcpy(colour[y][x], sea ? water : sky, sizeof sky);
            depth[y][x] = INFINITY;
        }
    }
}

struct projected {
    double x, y, z;
};

static struct projected project(const struct view *v, const double middle[2],
                                double scale, const float *p, double radius)
{
    struct pel_vec3 at = { (double)p[0], (double)p[1], (double)p[2] };
    double x = pel_vec3_dot(at, v->right), y = pel_vec3_dot(at, v->up);
    double z = -pel_vec3_dot(at, v->towards);
    if (v->perspective > 0) {
        double eye = v->perspective * radius;
        x *= eye / (eye + z);
        y *= eye / (eye + z);
    }
    return (struct projected){
        (v->x + v->width / 2.0 + (x - middle[0]) * scale) * SAMPLES,
        (v->y + v->height / 2.0 - (y - middle[1]) * scale) * SAMPLES, z
    };
}

static void shade(const struct pel_model *m, const struct pel_model_part *part,
                  const struct pel_model_vertex *const c[3], const double w[3],
                  float out[3], bool *hole)
{
    const struct pel_model_material *a = &m->materials[part->material];
    double n[3] = { 0 }, uv[2] = { 0 };
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++) {
            n[i] += w[k] * (double)c[k]->normal[i];
        }
        uv[0] += w[k] * (double)c[k]->uv[0];
        uv[1] += w[k] * (double)c[k]->uv[1];
    }
    double light = 0.42 * n[0] - 0.53 * n[1] + 0.73 * n[2];
    double sum = 0.25 + 0.1 * n[2] + 0.75 * fmax(0, light);
    *hole = false;
    for (int i = 0; i < 3; i++) {
        out[i] = (float)((double)a->albedo[i] * sum);
    }
    if (a->texture >= 0) {
        const struct pel_model_texture *t = &m->textures[a->texture];
        int x = (int)((uv[0] - floor(uv[0])) * t->width);
        int y = (int)((uv[1] - floor(uv[1])) * t->height);
        x = x < t->width ? x : t->width - 1;
        y = y < t->height ? y : t->height - 1;
        const uint8_t *texel =
            t->rgba + 4 * ((size_t)y * (size_t)t->width + (size_t)x);
        for (int i = 0; i < 3; i++) {
            out[i] *= powf((float)texel[i] / 255.0f, 2.2f);
        }
        *hole =
            a->alpha_cutoff > 0 && texel[3] / 255.0 < (double)a->alpha_cutoff;
    }
}

static void draw_triangle(const struct pel_model *m, const struct view *v,
                          const struct pel_model_part *part,
                          const struct projected p[3],
                          const struct pel_model_vertex *const c[3])
{
    double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) -
                  (p[2].x - p[0].x) * (p[1].y - p[0].y);
    /* Outside is counterclockwise, and y is downward here: backs are not
     * drawn, as they should not be seen. */
    if (area == 0 || (area > 0 && !m->materials[part->material].two_sided)) {
        return;
    }
    double x0 = fmin(p[0].x, fmin(p[1].x, p[2].x));
    double x1 = fmax(p[0].x, fmax(p[1].x, p[2].x));
    double y0 = fmin(p[0].y, fmin(p[1].y, p[2].y));
    double y1 = fmax(p[0].y, fmax(p[1].y, p[2].y));
    x0 = fmax(ceil(x0 - 0.5), v->x * SAMPLES);
    y0 = fmax(ceil(y0 - 0.5), v->y * SAMPLES);
    x1 = fmin(x1, (v->x + v->width) * SAMPLES - 1);
    y1 = fmin(y1, (v->y + v->height) * SAMPLES - 1);
    for (int y = (int)y0; y + 0.5 <= y1; y++) {
        for (int x = (int)x0; x + 0.5 <= x1; x++) {
            double w[3], px = x + 0.5, py = y + 0.5;
            for (int k = 0; k < 3; k++) {
                const struct projected *a = &p[(k + 1) % 3];
                const struct projected *b = &p[(k + 2) % 3];
                w[k] = ((b->x - a->x) * (py - a->y) -
                        (b->y - a->y) * (px - a->x)) /
                       area;
            }
            float z = (float)(w[0] * p[0].z + w[1] * p[1].z + w[2] * p[2].z);
            if (w[0] < 0 || w[1] < 0 || w[2] < 0 || z >= depth[y][x]) {
                continue;
            }
            float out[3];
            bool hole;
            shade(m, part, c, w, out, &hole);
            if (!hole) {
                memcpy(colour[y][x], out, sizeof out);
                depth[y][x] = z;
            }
        }
    }
}

static void draw(const struct pel_model *m, const struct view *v, int level)
{
    const struct pel_model_level *l = &m->levels[level];
    double low[2] = { INFINITY, INFINITY }, high[2] = { -INFINITY, -INFINITY };
    const double none[2] = { 0, 0 };
    struct view whole = *v;
    whole.x = -v->width / 2;
    whole.y = -v->height / 2;
    for (size_t i = 0; i < m->vertex_count; i++) {
        struct projected p = project(&whole, none, 1.0 / SAMPLES,
                                     m->vertices[i].position, m->radius_m);
        low[0] = fmin(low[0], p.x);
        high[0] = fmax(high[0], p.x);
        low[1] = fmin(low[1], -p.y);
        high[1] = fmax(high[1], -p.y);
    }
    double middle[2] = { (low[0] + high[0]) / 2, (low[1] + high[1]) / 2 };
    double scale = fmin((v->width - 24) / (high[0] - low[0]),
                        (v->height - 24) / (high[1] - low[1]));
    clear(v, v->towards.z < 0.5 && v->perspective == 0
                 ? v->y + v->height / 2.0 + middle[1] * scale
                 : (v->perspective > 0 ? 0 : 1e9));
    for (size_t i = 0; i < l->part_count; i++) {
        const struct pel_model_part *part = &l->parts[i];
        for (uint32_t k = part->first; k < part->first + part->count; k += 3) {
            const struct pel_model_vertex *c[3];
            struct projected p[3];
            for (int j = 0; j < 3; j++) {
                c[j] = &m->vertices[m->indices[k + (uint32_t)j]];
                p[j] = project(v, middle, scale, c[j]->position, m->radius_m);
            }
            draw_triangle(m, v, part, p, c);
        }
    }
}

static void draw_all(const struct pel_model *m, int level)
{
    const struct pel_vec3 x = { 1, 0, 0 }, y = { 0, 1, 0 }, z = { 0, 0, 1 };
    const struct pel_vec3 back = { 0, -1, 0 };
    const struct pel_vec3 ahead =
        pel_vec3_normalize((struct pel_vec3){ 0.6, -0.75, 0.3 });
    const struct pel_vec3 right =
        pel_vec3_normalize((struct pel_vec3){ 0.75, 0.6, 0 });
    const struct view views[] = {
        { 0, 0, 800, 310, x, z, back, 0 },
        { 800, 0, 400, 310, y, z, x, 0 },
        { 0, 310, 600, 310, x, y, z, 0 },
        { 600, 310, 600, 310, right, pel_vec3_cross(ahead, right), ahead, 3 },
    };
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        draw(m, &views[i], level);
    }
}

static int save(const char *path)
{
    static uint8_t rgb[HEIGHT][WIDTH][3];
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            for (int k = 0; k < 3; k++) {
                float sum = 0;
                for (int s = 0; s < SAMPLES * SAMPLES; s++) {
                    sum += colour[y * SAMPLES + s / SAMPLES]
                                 [x * SAMPLES + s % SAMPLES][k];
                }
                double v = pow((double)sum / (SAMPLES * SAMPLES), 1 / 2.2);
                rgb[y][x][k] = (uint8_t)(255 * fmin(v, 1) + 0.5);
            }
        }
    }
    FILE *file = fopen(path, "wb");
    if (!file) {
        perror(path);
        return 1;
    }
    spng_ctx *png = spng_ctx_new(SPNG_CTX_ENCODER);
    struct spng_ihdr head = { .width = WIDTH,
                              .height = HEIGHT,
                              .bit_depth = 8,
                              .color_type = SPNG_COLOR_TYPE_TRUECOLOR };
    spng_set_png_file(png, file);
    spng_set_ihdr(png, &head);
    int err = spng_encode_image(png, rgb, sizeof rgb, SPNG_FMT_PNG,
                                SPNG_ENCODE_FINALIZE);
    spng_ctx_free(png);
    return fclose(file) || err;
}

int main(int argc, char **argv)
{
    const struct pel_model *model = NULL;
    struct pel_fault fault = { 0 };
    if (argc != 5) {
        fprintf(stderr,
                "usage: drawmodel builtin|DIRECTORY NAME|FILE LEVEL OUT.png\n");
        return 2;
    }
    const struct pel_builtin what = { .name = argv[2] };
    const struct pel_model_source source = { .directory = argv[1],
                                             .file = argv[2] };
    char notes[PEL_MODEL_NOTES] = "";
    if (strcmp(argv[1], "builtin") == 0
            ? pel_builtin_make(&what, &model, &fault)
            : pel_model_load(&source, &model, notes, &fault)) {
        fprintf(stderr, "%s\n", fault.message);
        return 1;
    }
    int level = atoi(argv[3]);
    level = level < 0                     ? 0
            : level >= model->level_count ? model->level_count - 1
                                          : level;
    printf("%s  %s  %.4g x %.4g x %.4g m + %.4g m  ", model->name,
           pel_model_class_text(model->class), model->length_m, model->beam_m,
           model->draught_m, model->height_m);
    for (int i = 0; i < model->level_count; i++) {
        printf("%s%zu", i ? "/" : "", model->levels[i].triangles);
    }
    printf(" triangles  %.0f kB%s%s\n", (double)model->bytes / 1024,
           *notes ? "  " : "", notes);
    draw_all(model, level);
    int failed = save(argv[4]);
    pel_model_unref(model);
    return failed;
}
