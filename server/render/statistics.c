#include "render/statistics.h"

#include <string.h>

#include "render/sky.h"

static void fill_by_azimuth(struct pel_statistics *s,
                            const struct pel_environment *env,
                            const struct pel_filter *filter)
{
    if (!s->by_azimuth) {
        GLuint t = 0;
        glCreateTextures(GL_TEXTURE_3D, 1, &t);
        glTextureStorage3D(t, 1, GL_RG32F, PEL_LENGTH_COUNT, PEL_ASPECT_COUNT,
                           PEL_AZIMUTH_COUNT);
        glTextureParameteri(t, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glTextureParameteri(t, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
        glTextureParameteri(t, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glTextureParameteri(t, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
        glTextureParameteri(t, GL_TEXTURE_WRAP_R, GL_REPEAT);
        glObjectLabel(GL_TEXTURE, t, -1, "variance by azimuth");
        s->by_azimuth = t;
    }
    static struct pel_variance table[PEL_LONG_VARIANCES];
    pel_fill_long_variance(env->sea, filter, table);
    for (int i = 0; i < PEL_LONG_VARIANCES && env->constant_brdf; i++) {
        table[i] = s->variance[0];
    }
    glTextureSubImage3D(s->by_azimuth, 0, 0, 0, 0, PEL_LENGTH_COUNT,
                        PEL_ASPECT_COUNT, PEL_AZIMUTH_COUNT, GL_RG, GL_FLOAT,
                        table);
    glBindTextureUnit(PEL_UNIT_VARIANCE, s->by_azimuth);
}

void pel_statistics_need(struct pel_statistics *s,
                         const struct pel_environment *env,
                         const struct pel_filter *filter, bool long_footprints)
{
    struct pel_statistics_key key;
    memset(&key, 0, sizeof key);
    memcpy(&key.desc, &env->sea->desc, sizeof key.desc);
    key.wind_to_rad = env->wind_to_rad;
    key.constant_brdf = env->constant_brdf;
    if (memcmp(&key, &s->key, sizeof key) == 0) {
        return;
    }
    memcpy(&s->key, &key, sizeof key);
    pel_mesh_heights(env->sea, &s->heights);
    pel_fill_variance(env->sea, filter, s->variance);
    if (env->constant_brdf) {
        const int nearest = (int)(5.0 * PEL_VARIANCE_STEPS); /* 3 cm */
        for (int i = 0; i < PEL_VARIANCE_COUNT; i++) {
            s->variance[i] = s->variance[nearest];
        }
    }
    if (long_footprints) {
        fill_by_azimuth(s, env, filter);
    }
}

void pel_statistics_finish(struct pel_statistics *s)
{
    glDeleteTextures(1, &s->by_azimuth);
    *s = (struct pel_statistics){ 0 };
}
