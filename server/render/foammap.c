#include "render/foammap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"

#define GRAIN PEL_FOAM_GRAIN
#define GRAIN_LEVELS 10

/* A level as shaders read it, mean and mean square. What pixels leave of the
 * structure differs between walls and holes, and a sum of normal distributions
 * of many widths has longer tails than one: of sparse foam a sixteenth more
 * would be seen by pixels of a metre. So a part of each variance gives way to
 * the level's mean, by as much as keeps the foam of every bound
 * (docs/physics/foam.md has how well). */
#define EVEN 0.85

static void load_level(GLuint texture, int level, int n,
                       const float (*texels)[2])
{
    float(*shown)[2] = pel_sure_malloc(sizeof *shown * GRAIN * GRAIN);
    double mean = 0;
    for (int i = 0; i < n * n; i++) {
        double m = (double)texels[i][0];
        mean += fmax((double)texels[i][1] - m * m, 0) / (n * n);
    }
    double even = EVEN * mean;
    for (int i = 0; i < n * n; i++) {
        double m = (double)texels[i][0];
        double left = fmax((double)texels[i][1] - m * m, 0);
        shown[i][0] = texels[i][0];
        shown[i][1] = (float)(m * m + left + even * (mean - left));
    }
    glTextureSubImage2D(texture, level, 0, 0, n, n, GL_RG, GL_FLOAT,
                        level ? (const float(*)[2])shown : texels);
    free(shown);
}

static void make_grain(struct pel_foam_map *map)
{
    float(*texels)[2] = pel_sure_malloc(sizeof *texels * GRAIN * GRAIN);
    for (int i = 0; i < GRAIN * GRAIN; i++) {
        texels[i][0] = pel_foam_grain[i];
        texels[i][1] = pel_foam_grain[i] * pel_foam_grain[i];
    }
    glCreateTextures(GL_TEXTURE_2D, 1, &map->grain);
    glTextureStorage2D(map->grain, GRAIN_LEVELS, GL_RG32F, GRAIN, GRAIN);
    glTextureParameteri(map->grain, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTextureParameteri(map->grain, GL_TEXTURE_WRAP_T, GL_REPEAT);
    glTextureParameteri(map->grain, GL_TEXTURE_MIN_FILTER,
                        GL_LINEAR_MIPMAP_NEAREST);
    glObjectLabel(GL_TEXTURE, map->grain, -1, "foam's structure");
    /* In place: a texel's readers come before its writer. */
    for (int level = 0, n = GRAIN; n > 0; level++, n /= 2) {
        load_level(map->grain, level, n, (const float(*)[2])texels);
        for (int i = 0; i < n / 2 * (n / 2); i++) {
            int at = i / (n / 2) * 2 * n + i % (n / 2) * 2;
            for (int k = 0; k < 2; k++) {
                texels[i][k] =
                    0.25f * (texels[at][k] + texels[at + 1][k] +
                             texels[at + n][k] + texels[at + n + 1][k]);
            }
        }
    }
    free(texels);
}

static void make_table(struct pel_foam_map *map, const struct pel_foam *foam)
{
    /* Anew each time: a software device may still read the last one. */
    glDeleteTextures(1, &map->table);
    glCreateTextures(GL_TEXTURE_3D, 1, &map->table);
    glTextureStorage3D(map->table, 1, GL_R32F, PEL_FOAM_SIDE, PEL_FOAM_SIDE,
                       PEL_FOAM_LEVELS);
    glTextureParameteri(map->table, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(map->table, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTextureParameteri(map->table, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
    glTextureParameteri(map->table, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureSubImage3D(map->table, 0, 0, 0, 0, PEL_FOAM_SIDE, PEL_FOAM_SIDE,
                        PEL_FOAM_LEVELS, GL_RED, GL_FLOAT, foam->table);
    glObjectLabel(GL_TEXTURE, map->table, -1, "foam");
}

void pel_foam_map_bind(struct pel_foam_map *map, const struct pel_sea *sea,
                       bool wash)
{
    if (!sea->foam && !wash) {
        return;
    }
    if (!map->grain) {
        make_grain(map);
    }
    glBindTextureUnit(PEL_UNIT_FOAM_GRAIN, map->grain);
    if (!sea->foam) {
        return;
    }
    if (!map->table || memcmp(&map->desc, &sea->desc, sizeof map->desc) != 0) {
        make_table(map, sea->foam);
        memcpy(&map->desc, &sea->desc, sizeof map->desc);
    }
    glBindTextureUnit(PEL_UNIT_FOAM, map->table);
}

void pel_foam_map_finish(struct pel_foam_map *map)
{
    const GLuint textures[] = { map->table, map->grain };
    glDeleteTextures(2, textures);
    *map = (struct pel_foam_map){ 0 };
}
