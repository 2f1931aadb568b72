#include "render/waterlight.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

#define SIZE PEL_WATER_TABLE_SIZE
#define LAST ((int)(90.0 / PEL_WATER_SUN_STEP_DEG))

static GLuint make_texture(const char *label, int layers)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &texture);
    glTextureStorage3D(texture, 1, GL_RGBA32F, SIZE, SIZE, layers);
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

void pel_water_light_init(struct pel_water_light *w)
{
    memset(w, 0, sizeof *w);
    w->nodes[0] = w->nodes[1] = -1;
}

/* Textures for so many levels of depth. */
static void fit(struct pel_water_light *w, int levels)
{
    pel_water_light_finish(w);
    w->sun = make_texture("water by sun", levels);
    w->sky = make_texture("water by sky", levels);
    w->map = make_texture("water", levels * (1 + PEL_WATER_PARTS));
}

void pel_water_light_finish(struct pel_water_light *w)
{
    const GLuint textures[] = { w->sun, w->sky, w->map };
    glDeleteTextures(3, textures);
    w->sun = w->sky = w->map = 0;
}

/* Slot of the node's table, built if it is not there, in place of the one that
 * is not `keep`. */
static int slot_of(struct pel_water_light *w, int node, int keep)
{
    for (int i = 0; i < 2; i++) {
        if (w->nodes[i] == node) {
            return i;
        }
    }
    int slot = w->nodes[0] == keep ? 1 : 0;
    double zenith = node * PEL_WATER_SUN_STEP_DEG * PEL_DEG;
    for (int i = 0; i < w->depths.levels; i++) {
        struct pel_water_table *to = &w->tables[slot][i];
        struct pel_water_body body = w->body;
        body.depth_m = pel_water_depth(&w->depths, i);
        if (pel_water_table_build(&body, zenith, NULL, to)) {
            memset(to, 0, sizeof *to); /* no memory */
        }
    }
    w->nodes[slot] = node;
    return slot;
}

static void upload(GLuint texture, int level, const void *low, const void *high,
                   double part)
{
    float texels[SIZE * SIZE * 4];
    const float *a = low, *b = high;
    for (int i = 0; i < SIZE * SIZE * 4; i++) {
        texels[i] = a[i] + (float)part * (b[i] - a[i]);
    }
    glTextureSubImage3D(texture, 0, 0, 0, level, SIZE, SIZE, 1, GL_RGBA,
                        GL_FLOAT, texels);
}

struct pel_water_depths pel_water_light_depths(const struct pel_environment *e)
{
    return e->depths.levels > 1
               ? e->depths
               : (struct pel_water_depths){ 1, e->water.depth_m,
                                            e->water.depth_m };
}

void pel_water_light_update(struct pel_water_light *w,
                            const struct pel_environment *env)
{
    struct pel_water_depths depths = pel_water_light_depths(env);
    bool same_water = memcmp(&env->water, &w->body, sizeof w->body) == 0 &&
                      depths.levels == w->depths.levels &&
                      depths.first_m == w->depths.first_m &&
                      depths.last_m == w->depths.last_m;
    if (w->version && same_water && w->sun_z == env->sun.z) {
        return;
    }
    if (depths.levels != w->depths.levels) {
        fit(w, depths.levels);
    }
    if (!same_water) {
        w->body = env->water;
        w->depths = depths;
        w->nodes[0] = w->nodes[1] = -1;
    }
    double zenith = acos(pel_clamp(env->sun.z, 0.0, 1.0)) / PEL_DEG;
    double at = pel_clamp(zenith / PEL_WATER_SUN_STEP_DEG, 0.0, LAST);
    int low = (int)fmin(at, LAST - 1);
    int a = slot_of(w, low, low + 1), b = slot_of(w, low + 1, low);
    for (int i = 0; i < depths.levels; i++) {
        const struct pel_water_table *from = &w->tables[a][i];
        const struct pel_water_table *to = &w->tables[b][i];
        upload(w->sun, i, from->sun, to->sun, at - low);
        upload(w->sky, i, from->sky, to->sky, at - low);
    }
    w->sun_z = env->sun.z;
    w->version++;
}
