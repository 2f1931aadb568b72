#include "render/shoremap.h"

#include <string.h>

static void load(struct pel_shore_map *map, const struct pel_shore *shore)
{
    /* Anew each time: a software device may still read the last one. */
    glDeleteTextures(1, &map->nodes);
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &map->nodes);
    glTextureStorage3D(map->nodes, 1, GL_RGBA32F, shore->columns, shore->rows,
                       shore->bands);
    glTextureParameteri(map->nodes, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(map->nodes, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTextureSubImage3D(map->nodes, 0, 0, 0, 0, shore->columns, shore->rows,
                        shore->bands, GL_RGBA, GL_FLOAT, shore->nodes);
    glObjectLabel(GL_TEXTURE, map->nodes, -1, "waves over the bottom");
    map->serial = shore->serial;
}

void pel_shore_map_bind(struct pel_shore_map *map,
                        const struct pel_shore *shore, bool cascades,
                        double east_m, double north_m,
                        struct pel_block_shore *out)
{
    if (!map->nodes || map->serial != shore->serial) {
        load(map, shore);
    }
    glBindTextureUnit(cascades ? PEL_UNIT_SHORE_OF_CASCADES
                               : PEL_UNIT_SHORE_OF_WAVES,
                      map->nodes);
    memset(out, 0, sizeof *out);
    out->shore_grid = (struct pel_vec4){
        (float)((east_m - shore->west_m) / shore->spacing_m),
        (float)((north_m - shore->south_m) / shore->spacing_m),
        (float)(1 / shore->spacing_m), 0
    };
    out->shore_size =
        (struct pel_vec4){ (float)shore->columns, (float)shore->rows, 0, 0 };
    _Static_assert(PEL_SHORE_WAVES == PEL_SEA_MAX_WAVES, "a band a wave");
    for (int i = 0; i < PEL_SEA_MAX_WAVES; i++) {
        float *number = &out->shore_waves[i / 32].x + i / 8 % 4;
        *number += (float)(shore->of_wave[i] << 3 * (i % 8));
    }
    for (int b = 0; b < shore->bands; b++) {
        out->shore_bands[b] =
            (struct pel_vec4){ (float)shore->band[b].x, (float)shore->band[b].y,
                               (float)shore->band[b].k, 0 };
    }
}

void pel_shore_map_finish(struct pel_shore_map *map)
{
    glDeleteTextures(1, &map->nodes);
    *map = (struct pel_shore_map){ 0 };
}
