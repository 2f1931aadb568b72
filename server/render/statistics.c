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
    if (memcmp(&key, &s->key, sizeof key) == 0) {
        return false;
    }
    memcpy(&s->key, &key, sizeof key);
    pel_mesh_losses(env->sea, filter, &s->losses);
    pel_fill_variance(env->sea, filter, s->variance);
    if (env->sea->foam) {
        pel_fill_foam_left(env->sea, filter, s->breaking);
    }
    return true;
}
