#include "render/cloudmap.h"

#include <stdlib.h>

#include "shaders/lib/blocks.h"

#define SIDE PEL_CLOUD_SIDE
#define LEVELS 10

static void make(struct pel_cloud_map *map)
{
    float(*texels)[4] = malloc(sizeof *texels * SIDE * SIDE);
    if (!texels) {
        abort();
    }
    pel_cloud_field(map->genus, map->seed, texels);
    /* Anew each time: a software device may still read the last one. */
    glDeleteTextures(1, &map->field);
    glCreateTextures(GL_TEXTURE_2D, 1, &map->field);
    glTextureStorage2D(map->field, LEVELS, GL_RGBA32F, SIDE, SIDE);
    glTextureParameteri(map->field, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTextureParameteri(map->field, GL_TEXTURE_WRAP_T, GL_REPEAT);
    glTextureParameteri(map->field, GL_TEXTURE_MIN_FILTER,
                        GL_LINEAR_MIPMAP_LINEAR);
    glTextureSubImage2D(map->field, 0, 0, 0, SIDE, SIDE, GL_RGBA, GL_FLOAT,
                        texels);
    glGenerateTextureMipmap(map->field);
    glObjectLabel(GL_TEXTURE, map->field, -1, "clouds");
    free(texels);
}

void pel_cloud_map_bind(struct pel_cloud_map *map,
                        const struct pel_clouds *clouds)
{
    if (clouds->cover <= 0) {
        return;
    }
    if (!map->field || map->genus != clouds->genus ||
        map->seed != clouds->seed) {
        map->genus = clouds->genus;
        map->seed = clouds->seed;
        make(map);
    }
    glBindTextureUnit(PEL_UNIT_CLOUDS, map->field);
}

void pel_cloud_map_finish(struct pel_cloud_map *map)
{
    glDeleteTextures(1, &map->field);
    *map = (struct pel_cloud_map){ 0 };
}
