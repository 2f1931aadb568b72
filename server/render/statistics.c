#include "render/statistics.h"

#include <string.h>

#include "render/sky.h"

bool pel_statistics_need(struct pel_statistics *s,
                         const struct pel_environment *env,
                         const struct pel_filter *filter)
{
    struct pel_statistics_key key;
    memset(&key, 0, sizeof key);
    memcpy(&key.desc, &env->sea->desc, sizeof key.desc);
    key.wind_to_rad = env->wind_to_rad;
    key.constant_brdf = env->constant_brdf;
    if (memcmp(&key, &s->key, sizeof key) == 0) {
        return false;
    }
    memcpy(&s->key, &key, sizeof key);
    pel_mesh_losses(env->sea, filter, &s->losses);
    pel_fill_variance(env->sea, filter, s->variance);
    if (env->constant_brdf) {
        const int nearest = (int)(5.0 * PEL_VARIANCE_STEPS); /* 3 cm */
        for (int i = 0; i < PEL_VARIANCE_COUNT; i++) {
            s->variance[i] = s->variance[nearest];
        }
    }
    return true;
}
