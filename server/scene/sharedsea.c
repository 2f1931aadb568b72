#include "scene/sharedsea.h"

#include <stdlib.h>

#include "base/watch.h"
#include "scene/build.h"

const struct pel_sea *pel_shared_sea_value(struct pel_shared_sea *sea)
{
    if (!atomic_load(&sea->built)) {
        PEL_WATCH("sea");
        pthread_mutex_lock(&sea->lock);
        /* The description was tested: only memory can fail. */
        if (!atomic_load(&sea->built) &&
            pel_sea_build(&sea->desc, &sea->sea) != PEL_OK) {
            abort();
        }
        atomic_store(&sea->built, true);
        pthread_mutex_unlock(&sea->lock);
    }
    return &sea->sea;
}

bool pel_shared_sea_built(const struct pel_shared_sea *sea)
{
    return atomic_load(&sea->built);
}

struct pel_shared_sea *pel_shared_sea_ref(struct pel_shared_sea *sea)
{
    atomic_fetch_add(&sea->refs, 1);
    return sea;
}

const struct pel_sea *pel_snapshot_sea(const struct pel_snapshot *s)
{
    return pel_shared_sea_value(s->sea);
}

void pel_shared_sea_unref(struct pel_shared_sea *sea)
{
    if (sea && atomic_fetch_sub(&sea->refs, 1) == 1) {
        pel_sea_finish(&sea->sea);
        pthread_mutex_destroy(&sea->lock);
        free(sea->record);
        free(sea);
    }
}
