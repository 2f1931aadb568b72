#include "render/wakemap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "render/wakegrid.h"

_Static_assert(PEL_WAKE_N >> PEL_WAKE_ROUGH_LEVEL == PEL_WAKE_ROUGH_N,
               "a level of the texture");
_Static_assert(PEL_WAKES *PEL_WAKE_TILES == PEL_WAKE_LAYERS, "a layer a tile");

static void make(struct pel_wake_map *map)
{
    glCreateTextures(GL_TEXTURE_2D_ARRAY, PEL_WAKE_SETS, map->sets);
    for (int i = 0; i < PEL_WAKE_SETS; i++) {
        glTextureStorage3D(map->sets[i], PEL_WAKE_ROUGH_LEVEL + 1, GL_RGBA32F,
                           PEL_WAKE_N, PEL_WAKE_N, PEL_WAKE_LAYERS);
        glTextureParameteri(map->sets[i], GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTextureParameteri(map->sets[i], GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        glObjectLabel(GL_TEXTURE, map->sets[i], -1, "ship waves");
    }
}

void pel_wake_map_load(struct pel_wake_map *map,
                       const struct pel_environment *env)
{
    if (!env->wakes) {
        return;
    }
    if (!map->sets[0]) {
        make(map);
    }
    map->current = (map->current + 1) % PEL_WAKE_SETS;
    float(*rough)[4] =
        pel_sure_malloc(sizeof *rough * PEL_WAKE_ROUGH_N * PEL_WAKE_ROUGH_N);
    GLuint set = map->sets[map->current];
    GLint layer = 0;
    for (size_t i = 0; i < env->wakes->count; i++) {
        for (int k = 0; k < PEL_WAKE_TILES; k++) {
            const struct pel_wake_tile *t = &env->wakes->wake[i].tile[k];
            if (t->texels) {
                glTextureSubImage3D(set, 0, 0, 0, layer, PEL_WAKE_N, PEL_WAKE_N,
                                    1, GL_RGBA, GL_FLOAT, t->texels);
                pel_wake_tile_slopes(t, rough);
                glTextureSubImage3D(set, PEL_WAKE_ROUGH_LEVEL, 0, 0, layer++,
                                    PEL_WAKE_ROUGH_N, PEL_WAKE_ROUGH_N, 1,
                                    GL_RGBA, GL_FLOAT, rough);
            }
        }
    }
    free(rough);
}

void pel_wake_map_bind(const struct pel_wake_map *map,
                       const struct pel_environment *env, double east_m,
                       double north_m, struct pel_block_wakes *out)
{
    memset(out, 0, sizeof *out);
    size_t layers = 0;
    for (size_t i = 0; i < env->wakes->count; i++) {
        for (int k = 0; k < PEL_WAKE_TILES; k++) {
            const struct pel_wake_tile *t = &env->wakes->wake[i].tile[k];
            if (!t->texels) {
                continue;
            }
            struct pel_shader_wake *to = &out->wakes[layers++];
            double x = east_m / t->length_m, y = north_m / t->length_m;
            to->place = (struct pel_vec4){ (float)(t->x_m - east_m),
                                           (float)(t->y_m - north_m),
                                           (float)(PEL_WAKE_N / t->length_m),
                                           (float)t->length_m };
            to->offset.x = (float)((x - floor(x)) * PEL_WAKE_N);
            to->offset.y = (float)((y - floor(y)) * PEL_WAKE_N);
        }
    }
    pel_wake_grid_fill(layers, out);
    pel_wake_map_again(map);
}

void pel_wake_map_again(const struct pel_wake_map *map)
{
    glBindTextureUnit(PEL_UNIT_WAKES, map->sets[map->current]);
}

void pel_wake_map_finish(struct pel_wake_map *map)
{
    glDeleteTextures(PEL_WAKE_SETS, map->sets);
    *map = (struct pel_wake_map){ 0 };
}
