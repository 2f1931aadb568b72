#include "render/seabedmap.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "ocean/cascade.h"
#include "optics/brdf.h"
#include "optics/waterkernel.h"

/* --- the highest of squares ----------------------------------------------- */

/* Level 0 from nodes, the others from the level before. The last square of a
 * row or column takes what is over. */
static void fill_level(struct pel_seabed_tops *t, int k,
                       const struct pel_seabed *bed)
{
    int w = k ? t->columns[k - 1] : bed->columns;
    int h = k ? t->rows[k - 1] : bed->rows;
    const float *from = k ? t->highest + t->first[k - 1] : bed->height_m;
    float *to = t->highest + t->first[k];
    int reach = k ? 1 : 2; /* a square of nodes has both its borders */
    for (int y = 0; y < t->rows[k]; y++) {
        int end_y = y + 1 < t->rows[k] ? 2 * y + reach : h - 1;
        for (int x = 0; x < t->columns[k]; x++) {
            int end_x = x + 1 < t->columns[k] ? 2 * x + reach : w - 1;
            float highest = -HUGE_VALF;
            for (int j = 2 * y; j <= end_y; j++) {
                for (int i = 2 * x; i <= end_x; i++) {
                    highest = fmaxf(highest, from[j * w + i]);
                }
            }
            to[y * t->columns[k] + x] = highest;
        }
    }
}

enum pel_err pel_seabed_tops_init(struct pel_seabed_tops *tops,
                                  const struct pel_seabed *bed)
{
    int w = bed->columns / 2, h = bed->rows / 2;
    *tops = (struct pel_seabed_tops){ 0 };
    for (bool more = true; more;) {
        int k = tops->levels++;
        tops->columns[k] = w;
        tops->rows[k] = h;
        tops->first[k] = tops->count;
        tops->count += (size_t)w * (size_t)h;
        more = (w > 1 || h > 1) && tops->levels < PEL_SEABED_TOP_LEVELS;
        w = w > 1 ? w / 2 : 1;
        h = h > 1 ? h / 2 : 1;
    }
    tops->highest = malloc(sizeof *tops->highest * tops->count);
    for (int k = 0; k < tops->levels && tops->highest; k++) {
        fill_level(tops, k, bed);
    }
    return tops->highest ? PEL_OK : PEL_ERR_NO_MEMORY;
}

void pel_seabed_tops_finish(struct pel_seabed_tops *tops)
{
    free(tops->highest);
    *tops = (struct pel_seabed_tops){ 0 };
}

/* --- textures ------------------------------------------------------------- */

static int levels_of(int columns, int rows)
{
    return 1 + (int)floor(log2(columns > rows ? columns : rows));
}

void pel_seabed_map_finish(struct pel_seabed_map *map)
{
    glDeleteTextures(1, &map->heights);
    glDeleteBuffers(1, &map->tops);
    pel_seabed_tops_finish(&map->squares);
    *map = (struct pel_seabed_map){ 0 };
}

/* The steepest of the field's squares, as a tangent. */
static double steepest(const struct pel_seabed *bed)
{
    float most = 0.0f;
    int w = bed->columns;
    for (int y = 0; y + 1 < bed->rows; y++) {
        const float *row = bed->height_m + (size_t)y * (size_t)w;
        for (int x = 0; x + 1 < w; x++) {
            float a = row[x + 1] - row[x], b = row[x + w] - row[x];
            float c = row[x + w + 1] - row[x + w];
            float d = row[x + w + 1] - row[x + 1];
            most = fmaxf(most, fmaxf(a * a, c * c) + fmaxf(b * b, d * d));
        }
    }
    return sqrt((double)most) / bed->spacing_m;
}

static enum pel_err fill_map(struct pel_seabed_map *map,
                             const struct pel_seabed *bed)
{
    struct pel_seabed_tops *squares = &map->squares;
    enum pel_err err = pel_seabed_tops_init(squares, bed);
    if (err) {
        return err;
    }
    glCreateTextures(GL_TEXTURE_2D, 1, &map->heights);
    glTextureStorage2D(map->heights, levels_of(bed->columns, bed->rows),
                       GL_R32F, bed->columns, bed->rows);
    glTextureParameteri(map->heights, GL_TEXTURE_MIN_FILTER,
                        GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(map->heights, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(map->heights, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, map->heights, -1, "seabed");
    glTextureSubImage2D(map->heights, 0, 0, 0, bed->columns, bed->rows, GL_RED,
                        GL_FLOAT, bed->height_m);
    glGenerateTextureMipmap(map->heights);
    glCreateBuffers(1, &map->tops);
    glNamedBufferStorage(map->tops,
                         (GLsizeiptr)(squares->count * sizeof(float)),
                         squares->highest, 0);
    glObjectLabel(GL_BUFFER, map->tops, -1, "highest of the seabed");
    map->steepest = steepest(bed);
    map->serial = bed->serial;
    return PEL_OK;
}

enum pel_err pel_seabed_map_fit(struct pel_seabed_map *map,
                                const struct pel_seabed *bed)
{
    uint64_t serial = bed ? bed->serial : 0;
    enum pel_err err = PEL_OK;
    if (map->serial != serial) {
        pel_seabed_map_finish(map);
        err = bed ? fill_map(map, bed) : PEL_OK;
    }
    if (err) {
        pel_seabed_map_finish(map);
    }
    return err;
}

void pel_seabed_map_bind(const struct pel_seabed_map *map)
{
    glBindTextureUnit(PEL_UNIT_SEABED_HEIGHTS, map->heights);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_SEABED_TOPS,
                     map->tops);
}

/* --- what the shaders know ------------------------------------------------ */

/* Tables of the water's light over depth: steps of about 0.8 octave. */
#define DEPTH_LEVELS 12
#define SHALLOWEST_M 0.25

struct pel_water_depths pel_seabed_depths(const struct pel_environment *env)
{
    double deepest =
        fmax(env->sea_level_m - env->seabed->lowest_m, env->water.depth_m);
    deepest = fmin(deepest, pel_water_visible_m(&env->water));
    return (struct pel_water_depths){
        .levels = DEPTH_LEVELS,
        .first_m = SHALLOWEST_M,
        .last_m = fmax(deepest, 4 * SHALLOWEST_M),
    };
}

/* Ground under a film of water is darker, for the film sends light back to it
 * (J. Lekner, M. Dorf, Applied Optics 27(7), 1988). */
static double wet_albedo(double dry)
{
    const double inward = 1 - 0.02, n2 = 1.33 * 1.33;
    const double kept = 1 - (1 - 0.066) / n2; /* by the film, from below */
    return 1 - inward * (1 - dry) / (1 - kept * dry);
}

static struct pel_vec4 vec4(double x, double y, double z, double w)
{
    return (struct pel_vec4){ (float)x, (float)y, (float)z, (float)w };
}

/* Rays through the waves that a footprint resolves begin to cross where their
 * spread, of mean 1, deviates by more than this. */
#define SPREAD_RMS 0.35
/* A footprint resolves half of a wave that is so many times as long. */
#define RESOLVED 1.75

/* Footprints below which the waves' rays would cross, by depth. */
static void fill_focus(double light_z,
                       const struct pel_variance left[PEL_VARIANCE_COUNT],
                       struct pel_vec4 out[PEL_FOCUS_COUNT])
{
    const double eta = 1.0 / PEL_WATER_INDEX;
    double cosine = sqrt(1.0 - eta * eta * (1.0 - light_z * light_z));
    double reach = (cosine - eta * light_z) / cosine; /* a metre of depth */
    double bend2 = 0; /* mean square curvature of longer waves, 1/m² */
    int depth = PEL_FOCUS_COUNT - 1;
    for (int i = PEL_VARIANCE_COUNT - 2; i >= 0 && depth >= 0; i--) {
        double footprint = exp2(PEL_VARIANCE_FIRST + i / PEL_VARIANCE_STEPS);
        double k = 2.0 * PEL_PI / (RESOLVED * footprint);
        double band = (double)(left[i + 1].along - left[i].along) +
                      (double)(left[i + 1].cross - left[i].cross);
        bend2 += k * k * fmax(band, 0.0);
        while (depth >= 0 &&
               reach * exp2(PEL_FOCUS_FIRST + depth / PEL_FOCUS_STEPS) *
                       sqrt(bend2) >
                   SPREAD_RMS) {
            out[depth--] = vec4(log2(footprint), 0.0, 0.0, 0.0);
        }
    }
    while (depth >= 0) {
        out[depth--] = vec4(PEL_VARIANCE_FIRST, 0.0, 0.0, 0.0);
    }
}

static void fill_light(double zenith_cosine, double beam,
                       const struct pel_seabed_map *map,
                       const struct pel_variance left[PEL_VARIANCE_COUNT],
                       int i, struct pel_block_seabed *out)
{
    double z = pel_clamp(zenith_cosine, 0.0, 1.0);
    const struct pel_geometry at = { .sun_zenith_rad = acos(z) };
    struct pel_interface f = pel_interface_at(&at);
    double slope = f.sun_mu / sqrt(fmax(1.0 - f.sun_mu * f.sun_mu, 1e-9));
    out->bed_beams[i] = vec4(beam * f.sun_mu * PEL_KERNEL_LEAVING / PEL_PI,
                             map->steepest > slope ? 1.0 : 0.0, 0.0, 0.0);
    fill_focus(z, left, &out->bed_focus[PEL_FOCUS_COUNT * i]);
}

void pel_fill_seabed(const struct pel_environment *env,
                     const struct pel_seabed_map *map,
                     const struct pel_variance left[PEL_VARIANCE_COUNT],
                     const double beams[PEL_LIGHTS], double east_m,
                     double north_m, struct pel_block_seabed *out)
{
    const struct pel_seabed *bed = env->seabed;
    const struct pel_water_body *w = &env->water;
    bool all = env->orders == PEL_ORDERS_ALL;
    double turned[PEL_WATER_WAVELENGTHS], fall[PEL_WATER_WAVELENGTHS];
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        struct pel_medium m = pel_water_medium(w, i);
        turned[i] = w->scattering[i] * (1.0 - pel_medium_mean_cosine(&m));
        fall[i] = (w->absorption[i] + turned[i]) / log(2.0);
        turned[i] = all ? turned[i] : 0.0;
    }
    *out = (struct pel_block_seabed){
        /* Two standard deviations: what one crest in forty reaches. */
        .bed_beyond = vec4(-w->depth_m - env->sea_level_m,
                           0.05 + 2.0 * sqrt(env->sea->m0), map->squares.levels,
                           env->caustics ? 1.0 : 0.0),
        .bed_wet = vec4(wet_albedo(w->land[0]), wet_albedo(w->land[1]),
                        wet_albedo(w->land[2]), 0.0),
        .bed_dry = vec4(w->land[0], w->land[1], w->land[2], 0.0),
        .bed_under = vec4(w->albedo[0], w->albedo[1], w->albedo[2], 0.0),
        .bed_extinction = vec4(w->absorption[0] + w->scattering[0],
                               w->absorption[1] + w->scattering[1],
                               w->absorption[2] + w->scattering[2], 0.0),
        .bed_fall = vec4(fall[0], fall[1], fall[2], PEL_CASCADES),
        .bed_absorption =
            vec4(all ? w->absorption[0] : 0.0, all ? w->absorption[1] : 0.0,
                 all ? w->absorption[2] : 0.0, 0.0),
        .bed_turned = vec4(turned[0], turned[1], turned[2], 0.0),
    };
    for (int i = 0; i < env->lit; i++) {
        fill_light(env->lights[i].direction.z, beams[i], map, left, i, out);
    }
    if (!bed) {
        return;
    }
    out->bed_place = vec4((east_m - bed->west_m) / bed->spacing_m,
                          (north_m - bed->south_m) / bed->spacing_m,
                          1.0 / bed->spacing_m, bed->spacing_m);
    out->bed_size = vec4(bed->columns, bed->rows,
                         bed->highest_m - env->sea_level_m, -env->sea_level_m);
    for (int i = 0; i < map->squares.levels; i++) {
        out->bed_level[i] =
            vec4((double)map->squares.first[i], map->squares.columns[i],
                 map->squares.rows[i], 0.0);
    }
}
