#include "render/panoramamap.h"

#include <math.h>

#include "panorama/panorama.h"

void pel_panorama_map_finish(struct pel_panorama_map *map)
{
    glDeleteTextures(1, &map->texture);
    *map = (struct pel_panorama_map){ 0 };
}

void pel_panorama_map_fit(struct pel_panorama_map *map,
                          const struct pel_environment *env)
{
    const struct pel_panorama *p = env->panorama;
    if (map->texture && map->id == p->id) {
        return;
    }
    pel_panorama_map_finish(map);
    GLsizei levels = 1 + (GLsizei)floor(log2(p->columns));
    glCreateTextures(GL_TEXTURE_2D, 1, &map->texture);
    glTextureStorage2D(map->texture, levels, GL_RGBA16F, p->columns, p->rows);
    glTextureParameteri(map->texture, GL_TEXTURE_MIN_FILTER,
                        GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(map->texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(map->texture, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTextureParameteri(map->texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, map->texture, -1, "panorama");
    glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
    glTextureSubImage2D(map->texture, 0, 0, 0, p->columns, p->rows, GL_RGB,
                        GL_HALF_FLOAT, p->halves);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glGenerateTextureMipmap(map->texture);
    map->id = p->id;
}

void pel_panorama_key(const struct pel_environment *env,
                      double key[PEL_PANORAMA_KEYS])
{
    key[0] = env->panorama ? (double)env->panorama->id : 0.0;
    key[1] = env->panorama ? env->panorama_scale : 0.0;
    key[2] = env->panorama ? env->panorama_azimuth_rad : 0.0;
}

void pel_panorama_fill(const struct pel_environment *env, const double m[9],
                       struct pel_vec4 out[3])
{
    const struct pel_vec3 x = { m[0], m[3], m[6] }, y = { m[1], m[4], m[7] },
                          z = { m[2], m[5], m[8] };
    const struct pel_vec3 rows[3] = { pel_vec3_cross(y, z),
                                      pel_vec3_cross(z, x),
                                      pel_vec3_cross(x, y) };
    double scale =
        env->panorama->unit * env->panorama_scale / pel_vec3_dot(x, rows[0]);
    const double last[3] = { env->panorama_azimuth_rad,
                             log2(env->panorama->columns / (2.0 * PEL_PI)), 0 };
    for (int i = 0; i < 3; i++) {
        out[i] =
            (struct pel_vec4){ (float)(rows[i].x * scale),
                               (float)(rows[i].y * scale),
                               (float)(rows[i].z * scale), (float)last[i] };
    }
}
