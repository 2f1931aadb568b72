/* A sea that snapshots share: built lazily, by the first thread that needs
 * it. Internal to the scene; other rooms use pel_snapshot_sea (snapshot.h). */
#pragma once

#include <pthread.h>
#include <stdatomic.h>

#include "base/heap.h"
#include "ocean/sea.h"
#include "seabed/seabed.h"

/* The bottom that a sea's waves feel; zeroed: none. */
struct pel_laid {
    const struct pel_seabed *bed; /* a reference */
    double level_m, beyond_m;     /* of the sea; depth beyond the field */
};

struct pel_shared_sea {
    struct pel_discard discard; /* first */
    atomic_uint refs;
    struct pel_sea_desc desc; /* as asked for; the sea's own is normalized */
    struct pel_laid laid;
    char *record;         /* which one `desc.measured` is; NULL: none */
    pthread_mutex_t lock; /* while it is built */
    atomic_bool built;
    struct pel_sea sea;
};
