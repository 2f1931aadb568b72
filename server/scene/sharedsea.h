/* A sea that snapshots share: built lazily, by the first thread that needs
 * it. Internal to the scene; other rooms use pel_snapshot_sea (snapshot.h). */
#pragma once

#include <pthread.h>
#include <stdatomic.h>

#include "ocean/sea.h"

struct pel_shared_sea {
    atomic_uint refs;
    struct pel_sea_desc desc; /* as asked for; the sea's own is normalized */
    char *record;             /* which one `desc.measured` is; NULL: none */
    pthread_mutex_t lock;     /* while it is built */
    atomic_bool built;
    struct pel_sea sea;
};
