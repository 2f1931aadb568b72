#include "scene/sharedsea.h"

#include <stdlib.h>

#include "base/reserve.h"
#include "base/watch.h"
#include "ocean/shore.h"
#include "scene/build.h"

static enum pel_err build(struct pel_shared_sea *sea)
{
    const struct pel_seabed *bed = sea->laid.bed;
    enum pel_err err = pel_sea_build(&sea->desc, &sea->sea);
    if (err == PEL_OK && bed) {
        const struct pel_shore_bottom bottom = {
            .columns = bed->columns,
            .rows = bed->rows,
            .west_m = bed->west_m,
            .south_m = bed->south_m,
            .spacing_m = bed->spacing_m,
            .height_m = bed->height_m,
            .level_m = sea->laid.level_m,
            .beyond_m = sea->laid.beyond_m,
        };
        err = pel_sea_lay(&sea->sea, &bottom);
        if (err) {
            pel_sea_finish(&sea->sea);
        }
    }
    return err;
}

const struct pel_sea *pel_shared_sea_value(struct pel_shared_sea *sea)
{
    if (!atomic_load(&sea->built)) {
        PEL_WATCH("sea");
        pthread_mutex_lock(&sea->lock);
        /* The description was tested: only memory can fail. */
        if (!atomic_load(&sea->built) && build(sea) != PEL_OK &&
            (!pel_reserve_spend() || build(sea) != PEL_OK)) {
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

static void drop(struct pel_discard *discard)
{
    struct pel_shared_sea *sea = (struct pel_shared_sea *)discard;
    pel_sea_finish(&sea->sea);
    pel_seabed_unref(sea->laid.bed);
    pthread_mutex_destroy(&sea->lock);
    free(sea->record);
    free(sea);
}

void pel_shared_sea_unref(struct pel_shared_sea *sea)
{
    if (sea && atomic_fetch_sub(&sea->refs, 1) == 1) {
        sea->discard.drop = drop;
        pel_heap_discard(&sea->discard);
    }
}
