#include "render/modelpaint.h"

#include <math.h>
#include <stdlib.h>

#include "base/vec.h"
#include "optics/colour.h"
#include "optics/light.h"

#define HEADER 3 /* texels: where each level begins, from the header */

/* Linear: rows of reflectance by colour. */
static void reflectance_matrix(double out[9])
{
    double m[9], want[9];
    const struct pel_rgb *sun = &pel_light_bodies[PEL_LIGHT_SUN].irradiance;
    const double e[3] = { sun->r, sun->g, sun->b };
    pel_colour_matrix(1.0, m);
    double white[3] = { 0.0 };
    for (int i = 0; i < 9; i++) {
        m[i] *= e[i % 3];
        white[i / 3] += m[i];
    }
    const struct pel_vec3 x = { m[0], m[3], m[6] }, y = { m[1], m[4], m[7] },
                          z = { m[2], m[5], m[8] };
    const struct pel_vec3 rows[3] = { pel_vec3_cross(y, z),
                                      pel_vec3_cross(z, x),
                                      pel_vec3_cross(x, y) };
    double det = pel_vec3_dot(x, rows[0]);
    for (int i = 0; i < 3; i++) {
        want[3 * i] = rows[i].x;
        want[3 * i + 1] = rows[i].y;
        want[3 * i + 2] = rows[i].z;
        for (int j = 0; j < 3; j++) {
            out[3 * i + j] = want[3 * i + j] * white[j] / det;
        }
    }
}

static void reflect(const double m[9], const double colour[3], float out[3])
{
    for (int i = 0; i < 3; i++) {
        double sum = m[3 * i] * colour[0] + m[3 * i + 1] * colour[1] +
                     m[3 * i + 2] * colour[2];
        out[i] = (float)pel_clamp(sum, 0.0, 1.0);
    }
}

void pel_model_reflectance(const float colour[3], float out[3])
{
    double m[9];
    const double c[3] = { (double)colour[0], (double)colour[1],
                          (double)colour[2] };
    reflectance_matrix(m);
    reflect(m, c, out);
}

/* Log2 of the nearest power of two. */
static int log_of(int size)
{
    return (int)pel_clamp(floor(log2(size) + 0.5), 0, PEL_PAINT_LEVELS - 1);
}

static size_t level_texels(int wide, int tall, int level)
{
    size_t w = (size_t)1 << (wide > level ? wide - level : 0);
    size_t h = (size_t)1 << (tall > level ? tall - level : 0);
    return (w * h + 3) / 4;
}

static int level_count(int wide, int tall)
{
    return 1 + (wide > tall ? wide : tall);
}

static size_t size_of(int wide, int tall)
{
    size_t sum = HEADER;
    for (int i = 0; i < level_count(wide, tall); i++) {
        sum += level_texels(wide, tall, i);
    }
    return sum;
}

/* A material before it with the same paint; -1: there is none. */
static int twin_of(const struct pel_model *m, size_t which)
{
    const struct pel_model_material *a = &m->materials[which];
    for (size_t i = 0; i < which; i++) {
        const struct pel_model_material *b = &m->materials[i];
        if (a->texture == b->texture && a->alpha_cutoff == b->alpha_cutoff &&
            a->albedo[0] == b->albedo[0] && a->albedo[1] == b->albedo[1] &&
            a->albedo[2] == b->albedo[2]) {
            return (int)i;
        }
    }
    return -1;
}

bool pel_model_has_holes(const struct pel_model *m)
{
    bool any = false;
    for (size_t i = 0; i < m->material_count; i++) {
        any = any || (m->materials[i].texture >= 0 &&
                      m->materials[i].alpha_cutoff > 0);
    }
    return any;
}

size_t pel_model_paint_size(const struct pel_model *m)
{
    size_t sum = 0;
    for (size_t i = 0; i < m->material_count; i++) {
        int texture = m->materials[i].texture;
        if (texture >= 0 && twin_of(m, i) < 0) {
            const struct pel_model_texture *t = &m->textures[texture];
            sum += size_of(log_of(t->width), log_of(t->height));
        }
    }
    return sum;
}

/* The mean of the texels under one of w by h that are no holes, and their
 * share. */
static void resample(const struct pel_model_texture *t, double cutoff,
                     const double linear[256], int x, int y, int w, int h,
                     double out[4])
{
    int nx = (int)ceil((double)t->width / w);
    int ny = (int)ceil((double)t->height / h);
    double all[3] = { 0 };
    out[0] = out[1] = out[2] = out[3] = 0.0;
    for (int i = 0; i < nx * ny; i++) {
        int from_x = (int)((x + (i % nx + 0.5) / nx) * t->width / w);
        int from_y = (int)((y + (i / nx + 0.5) / ny) * t->height / h);
        const uint8_t *texel =
            &t->rgba[4 * ((size_t)from_y * (size_t)t->width + (size_t)from_x)];
        double there = texel[3] / 255.0 >= cutoff;
        out[3] += there / (nx * ny);
        for (int k = 0; k < 3; k++) {
            all[k] += linear[texel[k]] / (nx * ny);
            out[k] += there * linear[texel[k]] / (nx * ny);
        }
    }
    for (int k = 0; k < 3; k++) {
        out[k] = out[3] > 0 ? out[k] / out[3] : all[k];
    }
}

static uint32_t packed(const float c[4])
{
    uint32_t bits = (uint32_t)lrintf(255.0f * c[3]) << 24;
    for (int k = 0; k < 3; k++) {
        bits |= (uint32_t)lrintf(255.0f * sqrtf(c[k])) << (8 * k);
    }
    return bits;
}

/* Colours of what is there; where nothing is, of all. */
static void halve(float *c, int w, int h)
{
    int across = w > 1 ? 2 : 1, up = h > 1 ? 2 : 1;
    float part = 1.0f / (float)(across * up);
    for (int i = 0; i < w / across * (h / up); i++) {
        int x = across * (i % (w / across)), y = up * (i / (w / across));
        float sum[4] = { 0 }, all[3] = { 0 };
        for (int n = 0; n < across * up; n++) {
            const float *from = &c[4 * ((y + n / across) * w + x + n % across)];
            for (int k = 0; k < 3; k++) {
                all[k] += from[k];
                sum[k] += from[3] * from[k];
            }
            sum[3] += from[3];
        }
        for (int k = 0; k < 3; k++) {
            c[4 * i + k] = sum[3] > 0.0f ? sum[k] / sum[3] : all[k] * part;
        }
        c[4 * i + 3] = sum[3] * part;
    }
}

static void write_levels(float *c, int wide, int tall, uint32_t *out)
{
    size_t at = HEADER;
    int w = 1 << wide, h = 1 << tall;
    for (int level = 0; level < level_count(wide, tall); level++) {
        out[level] = (uint32_t)at;
        for (int i = 0; i < w * h; i++) {
            out[4 * at + (size_t)i] = packed(c + 4 * i);
        }
        at += level_texels(wide, tall, level);
        halve(c, w, h);
        w = w > 1 ? w / 2 : 1;
        h = h > 1 ? h / 2 : 1;
    }
}

static bool write_texture(const struct pel_model_texture *t,
                          const struct pel_model_material *of, uint32_t *out)
{
    int wide = log_of(t->width), tall = log_of(t->height);
    int w = 1 << wide, h = 1 << tall;
    float *c = malloc((size_t)w * (size_t)h * 4 * sizeof *c);
    double linear[256], m[9];
    if (!c) {
        return false;
    }
    for (int i = 0; i < 256; i++) {
        double v = i / 255.0;
        linear[i] = v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
    }
    reflectance_matrix(m);
    for (int i = 0; i < w * h; i++) {
        double colour[4];
        resample(t, (double)of->alpha_cutoff, linear, i % w, i / w, w, h,
                 colour);
        for (int k = 0; k < 3; k++) {
            colour[k] *= (double)of->albedo[k];
        }
        reflect(m, colour, c + 4 * i);
        c[4 * i + 3] = (float)colour[3];
    }
    write_levels(c, wide, tall, out);
    free(c);
    return true;
}

bool pel_model_paint_write(const struct pel_model *m, uint32_t first,
                           uint32_t *out, float *materials)
{
    const size_t words = 4 * (size_t)PEL_OBJECT_MATERIAL_TEXELS;
    size_t at = 0;
    for (size_t i = 0; i < m->material_count; i++) {
        const struct pel_model_material *from = &m->materials[i];
        float *to = &materials[words * i + 6];
        int twin = twin_of(m, i);
        to[0] = to[1] = 0.0f;
        if (from->texture < 0) {
            continue;
        }
        if (twin >= 0) {
            to[0] = materials[words * (size_t)twin + 6];
            to[1] = materials[words * (size_t)twin + 7];
            continue;
        }
        const struct pel_model_texture *t = &m->textures[from->texture];
        int wide = log_of(t->width), tall = log_of(t->height);
        if (!write_texture(t, from, out + 4 * at)) {
            return false;
        }
        to[0] = (float)(first + at);
        to[1] = (float)(1 + wide + PEL_PAINT_SIZES * tall);
        at += size_of(wide, tall);
    }
    return true;
}
