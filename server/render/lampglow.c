#include "render/lampglow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "optics/lamp.h"
#include "optics/light.h"
#include "render/coast.h"
#include "scene/globe.h"

#define HEAD_WORDS (4 * (1 + PEL_GLOW_TEXELS * PEL_GLOWS))
/* More than shading counts, since the mesh is not level. */
#define MORE_SLOPES 1.1
#define MORE_LIGHT 2
#define BESIDE_PX 4 /* beyond a picture's edges, for its margin */
#define MOST_TILES (16 * PEL_MAX_TILES)
#define PI_F ((float)PEL_PI)
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

struct pel_glow_candidate {
    const struct pel_lamp *lamp;
    struct pel_vec3 offset;
    double shines;
    double luminous; /* cd, for as many as it stands for, < 0: it is wide */
};

static int brighter(const void *a, const void *b)
{
    const struct pel_glow_candidate *x = a, *y = b;
    return x->shines < y->shines   ? 1
           : x->shines > y->shines ? -1
           : x->lamp > y->lamp     ? 1
                                   : -1;
}

static int in_order(const void *a, const void *b)
{
    const struct pel_glow_candidate *x = a, *y = b;
    return x->lamp > y->lamp ? 1 : -1;
}

/* In the order of the list. */
static size_t choose(const struct pel_environment *env, struct pel_vec3 eye,
                     struct pel_glow_candidate out[PEL_MAX_LAMPS])
{
    size_t count = 0;
    for (size_t i = 0; i < env->lamp_count; i++) {
        const struct pel_lamp *l = &env->lamps[i];
        struct pel_vec3 at = { l->east_m, l->north_m, l->altitude_m };
        struct pel_vec3 offset = pel_globe_offset(eye, at);
        double away2 = pel_vec3_dot(offset, offset);
        double stands_for = l->mirrors ? l->mirrors : 1;
        if (away2 > 1e-4 && at.z > env->sea_level_m && stands_for > 0) {
            out[count++] = (struct pel_glow_candidate){
                l, offset, stands_for * l->intensity_cd[1] / away2, 0
            };
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

static void describe(struct pel_glow_candidate *c, const double m[9],
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
    c->luminous = luminance(m, light) * (wide > 0 ? -1 : 1);
    const double all[4 * PEL_GLOW_TEXELS] = {
        c->offset.x,   c->offset.y, c->offset.z, c->luminous,
        light[0],      light[1],    light[2],    l->beam_rad,
        axis.x,        axis.y,      axis.z,      fmin(0.5 * l->arc_rad, 4),
        l->up.x,       l->up.y,     l->up.z,     fmax(l->cutoff_rad, 1e-3),
        l->spread_rad, wide,        0,           extinction,
    };
    put_floats(words, all);
}

int pel_lamp_glow_below(const struct pel_environment *env,
                        const struct pel_camera *c,
                        float out[PEL_UNDER_LAMPS * PEL_GLOW_TEXELS][4])
{
    struct pel_glow_candidate below[PEL_UNDER_LAMPS + 1];
    const struct pel_vec3 eye = { c->east_m, c->north_m,
                                  c->altitude_m + env->sea_level_m };
    int count = 0;
    for (size_t i = 0; i < env->lamp_count; i++) {
        const struct pel_lamp *l = &env->lamps[i];
        struct pel_vec3 at = { l->east_m, l->north_m, l->altitude_m };
        if (at.z < env->sea_level_m && l->mirrors >= 0) {
            struct pel_vec3 offset = pel_globe_offset(eye, at);
            double away2 = pel_vec3_dot(offset, offset) + 1.0;
            below[count++] =
                (struct pel_glow_candidate){ l, offset,
                                             l->intensity_cd[1] / away2, 0 };
            qsort(below, (size_t)count, sizeof *below, brighter);
            count = count < PEL_UNDER_LAMPS ? count : PEL_UNDER_LAMPS;
        }
    }
    double m[9], inverse[9];
    pel_lights_colours(env->lights, env->lit, env->night.on, m);
    pel_lamp_inverse(m, inverse);
    for (int i = 0; i < count; i++) {
        uint32_t words[4 * PEL_GLOW_TEXELS];
        describe(&below[i], m, inverse, 0.0, words);
        memcpy(out[PEL_GLOW_TEXELS * i], words, sizeof words);
    }
    return count;
}

bool pel_lamp_glow_any_below(const struct pel_environment *env)
{
    for (size_t i = 0; i < env->lamp_count; i++) {
        if (env->lamps[i].altitude_m < env->sea_level_m &&
            env->lamps[i].mirrors >= 0) {
            return true;
        }
    }
    return false;
}

/* --- where ---------------------------------------------------------------- */

/* A lamp by its azimuth, distance over ground and height over the eye. */
struct bearing {
    float azimuth, away, above, intensity;
};

/* The pixels of a tile: azimuths about a middle and tangents of depression. */
struct patch {
    float azimuth, half, fall[2], lowest;
};

/* What is the same for all tiles. */
struct sea_seen {
    float height_m, dip, waves; /* waves: their height by that of the eye */
    float variance, mean;
    struct bearing bearings[PEL_GLOWS];
    size_t count;
};

/* The square of the slope that mirrors a lamp by the most that it reaches
 * (lamp_reaches), at a point of the sea under a line of sight, `ahead` from the
 * lamp's foot along it and `beside`. */
static float reached(const struct sea_seen *s, const struct bearing *b,
                     float fall, float stretch, float along, float across)
{
    const float radius = (float)PEL_EARTH_RADIUS;
    float over = fmaxf(fall * fall - s->dip * s->dip, 0);
    float away = stretch * 2 * s->height_m / (fall + sqrtf(over));
    float local = fall - away / radius, level = 1 / sqrtf(1 + local * local);
    float x = along - away, tilt = away / radius;
    float z = b->above + s->height_m + 0.5F * away * tilt + x * tilt;
    float far2 = x * x + across * across + z * z, near_ = 1 / sqrtf(far2);
    float sum[3] = { x * near_ - level, across * near_,
                     fmaxf(z * near_ + local * level, 1e-6F) };
    float flat2 = sum[0] * sum[0] + sum[1] * sum[1];
    float dull = 1 - fminf(0.5F * sqrtf(flat2 + sum[2] * sum[2]), 1);
    float shown = MORE_LIGHT * b->intensity * s->mean *
                  ((float)PEL_LAMP_DULLEST + dull * dull * dull * dull * dull);
    float most = shown > far2 ? 2 * logf(shown / far2) : 0;
    most = fminf(most, (float)(PEL_LAMP_SLOPES * PEL_LAMP_SLOPES));
    return flat2 - sum[2] * sum[2] * s->variance * most;
}

static uint32_t mask_of(const struct sea_seen *s, const struct patch *p)
{
    uint32_t mask = 0;
    for (size_t k = 0; k < s->count; k++) {
        const struct bearing *b = &s->bearings[k];
        float turn = fabsf(remainderf(b->azimuth - p->azimuth, 2 * PI_F));
        turn = fmaxf(turn - p->half, 0);
        float along = b->away * cosf(turn), across = b->away * sinf(turn);
        float middle = 0.5F * (p->fall[0] + p->fall[1]);
        bool shown =
            b->intensity < 0 ||
            reached(s, b, p->fall[1], 1 - s->waves, along, across) < 0 ||
            reached(s, b, p->fall[0], 1 + s->waves, along, across) < 0 ||
            reached(s, b, middle, 1, along, across) < 0;
        mask |= shown ? 1U << k : 0;
    }
    return mask;
}

/* Where the i-th line between tiles runs; outermost ones beyond the picture. */
static double edge_px(uint32_t i, uint32_t size)
{
    double x = (double)i * PEL_GLOW_TILE;
    return i == 0 ? -BESIDE_PX : x < size ? x : (double)size + BESIDE_PX;
}

/* Of a corner of tiles: azimuth and tangent of depression. */
static void look_at(const struct pel_camera *c, uint32_t i, uint32_t j,
                    float out[2])
{
    double x = edge_px(i, c->width), y = edge_px(j, c->height);
    x = c->tan_left + (c->tan_right - c->tan_left) / c->width * x;
    y = c->tan_top - (c->tan_top - c->tan_bottom) / c->height * y;
    struct pel_vec3 dir =
        pel_mat3_apply(&c->world_from_camera, (struct pel_vec3){ x, y, -1 });
    double level = sqrt(dir.x * dir.x + dir.y * dir.y);
    out[0] = atan2f((float)dir.x, (float)dir.y);
    out[1] = (float)(-dir.z / fmax(level, 1e-3));
}

static struct patch patch_of(const struct sea_seen *s, const float *upper,
                             const float *lower)
{
    const float *corners[4] = { upper, upper + 2, lower, lower + 2 };
    struct patch p = { upper[0], 0, { upper[1], upper[1] }, 0 };
    float low = 0, high = 0;
    for (int i = 1; i < 4; i++) {
        float turn = remainderf(corners[i][0] - p.azimuth, 2 * PI_F);
        low = fminf(low, turn);
        high = fmaxf(high, turn);
        p.fall[0] = fminf(p.fall[0], corners[i][1]);
        p.fall[1] = fmaxf(p.fall[1], corners[i][1]);
    }
    p.azimuth += 0.5F * (low + high);
    /* About the nadir every azimuth is in it. */
    p.half = high - low > 1 ? PI_F : 0.5F * (high - low);
    p.lowest = p.fall[1];
    p.fall[0] = fmaxf(p.fall[0], s->dip);
    p.fall[1] = fmaxf(p.fall[1], s->dip);
    return p;
}

static void fill_tiles(const struct pel_environment *env,
                       const struct pel_camera *c, double height_m,
                       const struct pel_glow_candidate *glows, size_t count,
                       uint32_t across, uint32_t down, uint32_t *masks)
{
    double along = env->sea->slope_variance_along,
           cross = env->sea->slope_variance_cross;
    struct sea_seen s = {
        .height_m = (float)height_m,
        .dip = (float)sqrt(2 * height_m / PEL_EARTH_RADIUS),
        .waves = (float)fmin(3 * sqrt(env->sea->m0) / height_m, 0.5),
        .variance =
            (float)(MORE_SLOPES * MORE_SLOPES * (fmax(along, cross) + 1e-6)),
        .mean = (float)(PEL_LAMP_MEAN / sqrt(along * cross + 1e-12)),
        .count = count,
    };
    for (size_t k = 0; k < count; k++) {
        struct pel_vec3 to = glows[k].offset;
        s.bearings[k] = (struct bearing){
            atan2f((float)to.x, (float)to.y),
            (float)hypot(to.x, to.y),
            (float)to.z,
            (float)glows[k].luminous,
        };
    }
    float(*rows[2])[2] = { pel_sure_malloc(sizeof **rows * (across + 1)),
                           pel_sure_malloc(sizeof **rows * (across + 1)) };
    /* No crest is higher than such an eye. */
    const bool sea_below = s.waves < 0.5F;
    for (uint32_t j = 0; j <= down; j++) {
        for (uint32_t i = 0; i <= across; i++) {
            look_at(c, i, j, rows[j & 1][i]);
        }
        for (uint32_t i = 0; i < across && j > 0; i++) {
            struct patch p = patch_of(&s, rows[(j - 1) & 1][i], rows[j & 1][i]);
            bool sky = sea_below && p.lowest < 0;
            masks[(j - 1) * across + i] = sky ? 0 : mask_of(&s, &p);
        }
    }
    free(rows[0]);
    free(rows[1]);
}

void pel_lamp_glow_bind(struct pel_lamp_glow *g,
                        const struct pel_environment *env,
                        const struct pel_camera *c, uint32_t first_row,
                        int margin)
{
    if (!g->words) {
        g->glows = pel_sure_calloc(PEL_MAX_LAMPS, sizeof *g->glows);
        g->words = pel_sure_calloc(HEAD_WORDS + MOST_TILES, sizeof *g->words);
        glCreateBuffers(1, &g->buffer);
        glCreateTextures(GL_TEXTURE_BUFFER, 1, &g->texels);
    }
    struct pel_glow_candidate *glows = g->glows;
    const struct pel_vec3 eye = { c->east_m, c->north_m,
                                  c->altitude_m + env->sea_level_m };
    double height_m = c->altitude_m, m[9], inverse[9];
    size_t count = choose(env, eye, glows);
    pel_lights_colours(env->lights, env->lit, env->night.on, m);
    pel_lamp_inverse(m, inverse);
    uint32_t across = (c->width - 1) / PEL_GLOW_TILE + 1,
             down = (c->height - 1) / PEL_GLOW_TILE + 1;
    down = down < MOST_TILES / across ? down : MOST_TILES / across;
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
    fill_tiles(env, c, height_m, glows, count, across, down,
               g->words + HEAD_WORDS);
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
    free(g->glows);
    *g = (struct pel_lamp_glow){ 0 };
}
