#include "render/nightmap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "optics/stars.h"
#include "shaders/lib/blocks.h"

static const double planet_colours[PEL_PLANETS] = { 0.82, 1.36, 0.83, 1.04 };

void pel_night_textures_finish(struct pel_night_textures *n)
{
    glDeleteTextures(1, &n->zonal);
    glDeleteTextures(1, &n->off);
    glDeleteBuffers(1, &n->stars);
    *n = (struct pel_night_textures){ 0 };
}

static GLuint make_texture(GLsizei width, GLsizei height, const char *label)
{
    GLuint t = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &t);
    glTextureStorage2D(t, 1, GL_RGBA32F, width, height);
    glTextureParameteri(t, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(t, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(t, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(t, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, t, -1, label);
    return t;
}

void pel_night_key(const struct pel_environment *env,
                   double key[PEL_NIGHT_KEYS])
{
    const struct pel_night_sky *n = &env->night;
    key[0] = n->on ? env->visibility_m : 0.0;
    key[1] = n->on ? n->local_minute.x.x : 0.0;
    key[2] = n->on ? n->local_minute.x.y : 0.0;
    key[3] = n->on ? n->local_minute.z.z : 0.0;
    key[4] = n->on ? floor(n->sun_longitude_rad * 1e3) : 0.0;
}

void pel_night_textures_fit(struct pel_night_textures *n,
                            const struct pel_environment *env)
{
    double key[PEL_NIGHT_KEYS];
    pel_night_key(env, key);
    if (n->off && memcmp(key, n->key, sizeof key) == 0) {
        return;
    }
    if (!n->off) {
        n->zonal = make_texture(1, PEL_NIGHT_ROWS, "night by elevation");
        n->off = make_texture(PEL_NIGHT_SIDE, PEL_NIGHT_SIDE, "night");
        glCreateBuffers(1, &n->stars);
        glObjectLabel(GL_BUFFER, n->stars, -1, "stars");
    }
    struct pel_night_sky night = env->night;
    night.sun_longitude_rad = 1e-3 * key[4]; /* what the key says */
    struct pel_night_map *map = pel_sure_malloc(sizeof *map);
    pel_night_map_make(&night, env->visibility_m, map);
    glTextureSubImage2D(n->zonal, 0, 0, 0, 1, PEL_NIGHT_ROWS, GL_RGBA, GL_FLOAT,
                        map->zonal);
    glTextureSubImage2D(n->off, 0, 0, 0, PEL_NIGHT_SIDE, PEL_NIGHT_SIDE,
                        GL_RGBA, GL_FLOAT, map->off);
    n->air = map->air;
    free(map);
    memcpy(n->key, key, sizeof key);
}

/* On the lattice, and its irradiance. */
struct spot {
    float x, y;
    struct pel_rgb light;
};

struct list {
    struct spot *at;
    size_t count, room;
};

static void add_spot(struct list *l, const struct pel_block_view *v,
                     struct pel_vec3 to, struct pel_rgb light)
{
    const struct pel_vec4 *r = &v->right, *u = &v->up, *b = &v->back;
    double ahead =
        -(to.x * (double)b->x + to.y * (double)b->y + to.z * (double)b->z);
    if (ahead < 0.02) {
        return;
    }
    double x =
        (to.x * (double)r->x + to.y * (double)r->y + to.z * (double)r->z) /
        (ahead * (double)v->pixel.x);
    double y =
        -(to.x * (double)u->x + to.y * (double)u->y + to.z * (double)u->z) /
        (ahead * (double)v->pixel.y);
    double left = x - (double)v->pixel.z, top = y - (double)v->pixel.w;
    if (left < -2 || top < -2 || left > (double)v->size.x + 2 ||
        top > (double)v->size.y + 2) {
        return;
    }
    if (l->count == l->room) {
        size_t room = l->room ? 2 * l->room : 256;
        struct spot *grown = pel_sure_realloc(l->at, room * sizeof *grown);
        l->at = grown;
        l->room = room;
    }
    l->at[l->count++] = (struct spot){ (float)x, (float)y, light };
}

/* Before the Moon: hidden. */
static bool is_hidden(const struct pel_environment *env, struct pel_vec3 to)
{
    for (int i = 0; i < PEL_LIGHTS; i++) {
        const struct pel_light *l = &env->lights[i];
        if (l->body == PEL_LIGHT_MOON && l->strength > 0.0 &&
            pel_vec3_dot(to, l->direction) > cos(pel_light_radius(l))) {
            return true;
        }
    }
    return false;
}

static void find_spots(const struct pel_environment *env,
                       const struct pel_block_view *view, struct list *l)
{
    const struct pel_night_sky *n = &env->night;
    size_t count;
    const struct pel_star *stars = pel_stars(&count);
    double share = n->stars;
    for (size_t i = 0; i < count + PEL_PLANETS && share > 0.0; i++) {
        bool star = i < count;
        const struct pel_planet *p = star ? NULL : &n->planets[i - count];
        struct pel_vec3 to =
            star ? pel_vec3_add(stars[i].to,
                                pel_vec3_scale(stars[i].moves, n->years))
                 : p->to;
        to = pel_mat3_apply(&n->local, to);
        if (to.z < -0.1 || is_hidden(env, to)) {
            continue;
        }
        struct pel_rgb e =
            star ? stars[i].irradiance
                 : pel_star_irradiance(p->magnitude, planet_colours[i - count]);
        add_spot(l, view, to,
                 (struct pel_rgb){ share * e.r, share * e.g, share * e.b });
    }
}

/* Tiles that its kernel, three pixels wide, touches: from xy to zw. */
static void tiles_of(const struct spot *s, const struct pel_block_view *v,
                     size_t across, size_t down, size_t box[4])
{
    double x = (double)s->x - (double)v->pixel.z,
           y = (double)s->y - (double)v->pixel.w;
    const double side = PEL_STAR_TILE;
    box[0] = (size_t)fmax(floor((x - 2) / side), 0);
    box[1] = (size_t)fmax(floor((y - 2) / side), 0);
    box[2] = (size_t)fmin(fmax(floor((x + 2) / side), 0), (double)across - 1);
    box[3] = (size_t)fmin(fmax(floor((y + 2) / side), 0), (double)down - 1);
}

void pel_night_textures_bind(struct pel_night_textures *n,
                             const struct pel_environment *env,
                             const struct pel_block_view *view)
{
    struct list l = { 0 };
    find_spots(env, view, &l);
    size_t across = ((size_t)view->size.x + PEL_STAR_TILE - 1) / PEL_STAR_TILE,
           down = ((size_t)view->size.y + PEL_STAR_TILE - 1) / PEL_STAR_TILE;
    size_t tiles = across * down, entries = 0, box[4];
    size_t *count = pel_sure_calloc(tiles + 1, sizeof *count);
    for (size_t i = 0; i < l.count; i++) {
        tiles_of(&l.at[i], view, across, down, box);
        for (size_t y = box[1]; y <= box[3]; y++) {
            for (size_t x = box[0]; x <= box[2]; x++) {
                count[y * across + x]++;
                entries++;
            }
        }
    }
    /* The tiles' first words and counts, then two for each star of each. */
    size_t size = (tiles + 2 * entries) * sizeof(struct pel_vec4);
    struct pel_vec4 *words = pel_sure_calloc(1, size);
    size_t next = tiles;
    for (size_t t = 0; t < tiles; t++) {
        words[t] = (struct pel_vec4){ (float)next, (float)count[t], 0, 0 };
        next += 2 * count[t];
        count[t] = 0;
    }
    for (size_t i = 0; i < l.count; i++) {
        const struct spot *s = &l.at[i];
        tiles_of(s, view, across, down, box);
        for (size_t y = box[1]; y <= box[3]; y++) {
            for (size_t x = box[0]; x <= box[2]; x++) {
                size_t t = y * across + x;
                struct pel_vec4 *to =
                    words + (size_t)words[t].x + 2 * count[t]++;
                to[0] = (struct pel_vec4){ s->x, s->y, 0, 0 };
                to[1] = (struct pel_vec4){ (float)s->light.r, (float)s->light.g,
                                           (float)s->light.b, 0 };
            }
        }
    }
    glNamedBufferData(n->stars, (GLsizeiptr)size, words, GL_STREAM_DRAW);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_STARS, n->stars);
    glBindTextureUnit(PEL_UNIT_NIGHT, n->off);
    free(words);
    free(count);
    free(l.at);
}
