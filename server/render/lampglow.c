#include "render/lampglow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "optics/lamp.h"
#include "optics/light.h"
#include "render/coast.h"
#include "scene/globe.h"

#define HEAD_WORDS (4 * (1 + PEL_GLOW_TEXELS * PEL_GLOWS))
#define GRID 5          /* rays a side of a tile that are tried */
#define BESIDE_PX 16    /* beyond its edges, too */
#define MORE_SLOPES 1.2 /* than shading counts: the mesh is not level */
#define KOSCHMIEDER 3.912
#define FLOOD_CD 500

void pel_lamp_inverse(const double m[9], double out[9])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3,
                d = (j + 2) % 3;
            out[3 * j + i] =
                m[3 * a + c] * m[3 * b + d] - m[3 * a + d] * m[3 * b + c];
        }
    }
    double det = m[0] * out[0] + m[1] * out[3] + m[2] * out[6];
    for (int i = 0; i < 9; i++) {
        out[i] /= det;
    }
}

static double luminance(const double m[9], const double light[3])
{
    static const double weight[3] = { 0.2126, 0.7152, 0.0722 };
    double sum = 0;
    for (int i = 0; i < 9; i++) {
        sum += weight[i / 3] * m[i] * light[i % 3];
    }
    return sum;
}

void pel_lamp_spectral(const double m[9], const double inverse[9],
                       const double colour_cd[3], double out[3])
{
    double whole =
        0.2126 * colour_cd[0] + 0.7152 * colour_cd[1] + 0.0722 * colour_cd[2];
    for (int i = 0; i < 3; i++) {
        out[i] = fmax(inverse[3 * i] * colour_cd[0] +
                          inverse[3 * i + 1] * colour_cd[1] +
                          inverse[3 * i + 2] * colour_cd[2],
                      0);
    }
    double now = luminance(m, out);
    for (int i = 0; i < 3; i++) {
        out[i] *= now > 0 ? whole / now : 0;
    }
}

/* --- which ---------------------------------------------------------------- */

struct candidate {
    const struct pel_lamp *lamp;
    struct pel_vec3 offset;
    double shines;
};

static int brighter(const void *a, const void *b)
{
    const struct candidate *x = a, *y = b;
    return x->shines < y->shines   ? 1
           : x->shines > y->shines ? -1
           : x->lamp > y->lamp     ? 1
                                   : -1;
}

static int in_order(const void *a, const void *b)
{
    const struct candidate *x = a, *y = b;
    return x->lamp > y->lamp ? 1 : -1;
}

/* In the order of the list. */
static size_t choose(const struct pel_environment *env, struct pel_vec3 eye,
                     struct candidate out[PEL_MAX_LAMPS])
{
    size_t count = 0;
    for (size_t i = 0; i < env->lamp_count; i++) {
        const struct pel_lamp *l = &env->lamps[i];
        struct pel_vec3 at = { l->east_m, l->north_m, l->altitude_m };
        struct pel_vec3 offset = pel_globe_offset(eye, at);
        double away2 = pel_vec3_dot(offset, offset);
        double stands_for = l->mirrors ? l->mirrors : 1;
        if (away2 > 1e-4 && at.z > env->sea_level_m && stands_for > 0) {
            out[count++] =
                (struct candidate){ l, offset,
                                    stands_for * l->intensity_cd[1] / away2 };
        }
    }
    qsort(out, count, sizeof *out, brighter);
    count = count < PEL_GLOWS ? count : PEL_GLOWS;
    qsort(out, count, sizeof *out, in_order);
    return count;
}

static void put_floats(uint32_t *words, const double *values)
{
    for (int i = 0; i < 4 * PEL_GLOW_TEXELS; i++) {
        float f = (float)values[i];
        memcpy(words + i, &f, sizeof f);
    }
}

static void describe(const struct candidate *c, const double m[9],
                     const double inverse[9], double extinction,
                     uint32_t *words)
{
    const struct pel_lamp *l = c->lamp;
    double light[3], middle = l->from_rad + 0.5 * l->arc_rad;
    pel_lamp_spectral(m, inverse, l->intensity_cd, light);
    for (int i = 0; i < 3; i++) {
        light[i] *= l->mirrors ? l->mirrors : 1;
    }
    struct pel_vec3 right = pel_vec3_cross(l->ahead, l->up);
    struct pel_vec3 axis =
        l->beam_rad > 0 ? l->ahead
                        : pel_vec3_add(pel_vec3_scale(l->ahead, cos(middle)),
                                       pel_vec3_scale(right, sin(middle)));
    /* Deviation of where its light comes from; lamps are points. */
    double wide = l->unseen ? 0.25 * l->size_m : 0;
    const double all[4 * PEL_GLOW_TEXELS] = {
        c->offset.x,   c->offset.y, c->offset.z, extinction,
        light[0],      light[1],    light[2],    l->beam_rad,
        axis.x,        axis.y,      axis.z,      fmin(0.5 * l->arc_rad, 4),
        l->up.x,       l->up.y,     l->up.z,     fmax(l->cutoff_rad, 1e-3),
        l->spread_rad, wide,        0,           0,
    };
    put_floats(words, all);
}

/* --- where ---------------------------------------------------------------- */

/* The slope that mirrors a lamp at `offset` where this ray meets the level sea;
 * just below the horizon where it passes over it. */
static double slope_for(struct pel_vec3 dir, double height_m,
                        struct pel_vec3 offset)
{
    double level = hypot(dir.x, dir.y);
    double dip = sqrt(2 * height_m / PEL_EARTH_RADIUS);
    double fall = fmax(-dir.z / fmax(level, 1e-9), dip);
    double far = height_m / fall;
    double slant = sqrt(1 + fall * fall);
    struct pel_vec3 d = { dir.x / fmax(level, 1e-9) / slant,
                          dir.y / fmax(level, 1e-9) / slant, -fall / slant };
    struct pel_vec3 to = pel_vec3_normalize(
        pel_vec3_add(offset, pel_vec3_scale(d, -far * slant)));
    double up = to.z - d.z;
    return up > 1e-6 ? hypot(to.x - d.x, to.y - d.y) / up : HUGE_VAL;
}

static uint32_t mask_of(const struct pel_camera *c, double height_m,
                        double most, const struct candidate *glows,
                        size_t count, const double box[4])
{
    uint32_t mask = 0;
    for (int i = 0; i < GRID * GRID; i++) {
        double x = box[0] + (box[1] - box[0]) * (i % GRID) / (GRID - 1),
               y = box[2] + (box[3] - box[2]) * (i / GRID) / (GRID - 1);
        struct pel_vec3 dir = pel_vec3_normalize(pel_mat3_apply(
            &c->world_from_camera, (struct pel_vec3){ x, y, -1 }));
        for (size_t k = 0; k < count; k++) {
            mask |= glows[k].lamp->unseen ||
                            slope_for(dir, height_m, glows[k].offset) < most
                        ? 1U << k
                        : 0;
        }
    }
    return mask;
}

void pel_lamp_glow_bind(struct pel_lamp_glow *g,
                        const struct pel_environment *env,
                        const struct pel_camera *c, uint32_t first_row,
                        int margin)
{
    static struct candidate glows[PEL_MAX_LAMPS];
    if (!g->words) {
        g->words = calloc(HEAD_WORDS + PEL_MAX_TILES, sizeof *g->words);
        if (!g->words) {
            abort();
        }
        glCreateBuffers(1, &g->buffer);
        glCreateTextures(GL_TEXTURE_BUFFER, 1, &g->texels);
    }
    const struct pel_vec3 eye = { c->east_m, c->north_m,
                                  c->altitude_m + env->sea_level_m };
    double height_m = fmax(c->altitude_m, PEL_LEAST_EYE_M), m[9], inverse[9];
    size_t count = choose(env, eye, glows);
    pel_lights_colours(env->lights, env->lit, env->night.on, m);
    pel_lamp_inverse(m, inverse);
    uint32_t across = (c->width + PEL_TILE - 1) / PEL_TILE,
             down = (c->height + PEL_TILE - 1) / PEL_TILE;
    const uint32_t head[4] = { across, first_row,
                               (uint32_t)margin | (uint32_t)count << 16, down };
    memcpy(g->words, head, sizeof head);
    for (size_t i = 0; i < count; i++) {
        describe(&glows[i], m, inverse, KOSCHMIEDER / env->visibility_m,
                 g->words + 4 * (1 + PEL_GLOW_TEXELS * i));
    }
    uint32_t floods = 0;
    for (size_t i = 0; i < count; i++) {
        floods |= glows[i].lamp->intensity_cd[1] >= FLOOD_CD ? 1U << i : 0;
    }
    g->words[4 * PEL_GLOW_TEXELS + 2] = floods;
    double most = MORE_SLOPES * PEL_LAMP_SLOPES *
                  sqrt(fmax(env->sea->slope_variance_along,
                            env->sea->slope_variance_cross) +
                       1e-6);
    double px = (c->tan_right - c->tan_left) / c->width,
           py = (c->tan_top - c->tan_bottom) / c->height;
    for (uint32_t i = 0; i < across * down && i < PEL_MAX_TILES; i++) {
        double x = i % across * PEL_TILE, y = (double)(i / across) * PEL_TILE;
        const double box[4] = { c->tan_left + px * (x - BESIDE_PX),
                                c->tan_left + px * (x + PEL_TILE + BESIDE_PX),
                                c->tan_top - py * (y + PEL_TILE + BESIDE_PX),
                                c->tan_top - py * (y - BESIDE_PX) };
        g->words[HEAD_WORDS + i] =
            mask_of(c, height_m, most, glows, count, box);
    }
    glNamedBufferData(g->buffer,
                      (GLsizeiptr)(sizeof *g->words *
                                   (HEAD_WORDS + (across * down + 3) / 4 * 4)),
                      g->words, GL_STREAM_DRAW);
    glTextureBuffer(g->texels, GL_RGBA32UI, g->buffer);
    glBindTextureUnit(PEL_UNIT_LAMP_GLOWS, g->texels);
}

void pel_lamp_glow_finish(struct pel_lamp_glow *g)
{
    glDeleteBuffers(1, &g->buffer);
    glDeleteTextures(1, &g->texels);
    free(g->words);
    *g = (struct pel_lamp_glow){ 0 };
}
