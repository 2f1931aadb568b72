#include "render/waterlight.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

#define SIZE PEL_WATER_TABLE_SIZE
#define LAST ((int)(90.0 / PEL_WATER_SUN_STEP_DEG))

static GLuint make_texture(const char *label)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, GL_RGBA32F, SIZE, SIZE);
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
    w->sun = make_texture("water by sun");
    w->sky = make_texture("water by sky");
    w->map = make_texture("water");
    w->nodes[0] = w->nodes[1] = -1;
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
    if (pel_water_table_build(&w->body, zenith, NULL, &w->tables[slot])) {
        memset(&w->tables[slot], 0, sizeof w->tables[slot]); /* no memory */
    }
    w->nodes[slot] = node;
    return slot;
}

static void upload(GLuint texture, const void *low, const void *high,
                   double part)
{
    float texels[SIZE * SIZE * 4];
    const float *a = low, *b = high;
    for (int i = 0; i < SIZE * SIZE * 4; i++) {
        texels[i] = a[i] + (float)part * (b[i] - a[i]);
    }
    glTextureSubImage2D(texture, 0, 0, 0, SIZE, SIZE, GL_RGBA, GL_FLOAT,
                        texels);
}

void pel_water_light_update(struct pel_water_light *w,
                            const struct pel_water_body *body, double sun_z)
{
    bool same_water = memcmp(body, &w->body, sizeof *body) == 0;
    if (w->version && same_water && w->sun_z == sun_z) {
        return;
    }
    if (!same_water) {
        w->body = *body;
        w->nodes[0] = w->nodes[1] = -1;
    }
    double zenith = acos(pel_clamp(sun_z, 0.0, 1.0)) / PEL_DEG;
    double at = pel_clamp(zenith / PEL_WATER_SUN_STEP_DEG, 0.0, LAST);
    int low = (int)fmin(at, LAST - 1);
    int a = slot_of(w, low, low + 1), b = slot_of(w, low + 1, low);
    const struct pel_water_table *from = &w->tables[a], *to = &w->tables[b];
    upload(w->sun, from->sun, to->sun, at - low);
    upload(w->sky, from->sky, to->sky, at - low);
    w->sun_z = sun_z;
    w->version++;
}
