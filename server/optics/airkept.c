#include "optics/airkept.h"

#include <pthread.h>
#include <stdlib.h>

#include "optics/clearair.h"

struct kept {
    struct pel_atmosphere air; /* first: what users hold */
    double visibility_m;
    int users; /* and one while it is among `last` */
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
/* The newest first. Two, since scenes go to and fro between two airs more often
 * than among more; each is 8 MB. */
static struct kept *last[2];

static void drop(struct kept *k)
{
    if (k && --k->users == 0) {
        pel_atmosphere_finish(&k->air);
        free(k);
    }
}

static struct kept *find(double visibility_m)
{
    struct kept *k = NULL;
    pthread_mutex_lock(&lock);
    for (int i = 0; i < 2 && !k; i++) {
        if (last[i] && last[i]->visibility_m == visibility_m) {
            k = last[i];
            last[i] = last[0];
            last[0] = k;
            k->users++;
        }
    }
    pthread_mutex_unlock(&lock);
    return k;
}

enum pel_err pel_air_take(double visibility_m, pel_airlight_share *share,
                          void *pool, const struct pel_atmosphere **out)
{
    struct kept *k = find(visibility_m);
    if (!k) {
        k = malloc(sizeof *k);
        if (!k) {
            return PEL_ERR_NO_MEMORY;
        }
        const struct pel_atmosphere_desc desc = { visibility_m };
        pel_atmosphere_init(&desc, &k->air);
        enum pel_err err =
            visibility_m == pel_clear_air.visibility_m
                ? pel_atmosphere_take_table(&k->air, &pel_clear_air.light)
                : pel_atmosphere_tabulate(&k->air, share, pool);
        if (err != PEL_OK) {
            free(k);
            return err;
        }
        k->visibility_m = visibility_m;
        k->users = 2;
        pthread_mutex_lock(&lock);
        drop(last[1]);
        last[1] = last[0];
        last[0] = k;
        pthread_mutex_unlock(&lock);
    }
    *out = &k->air;
    return PEL_OK;
}

void pel_air_give(const struct pel_atmosphere *air)
{
    pthread_mutex_lock(&lock);
    drop((struct kept *)air);
    pthread_mutex_unlock(&lock);
}
