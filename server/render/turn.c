#include "render/turn.h"

#include <pthread.h>
#include <stdatomic.h>

#include "base/lock.h"

/* Those who wait, each on a condition of its own: a power of two, and more than
 * there are devices. */
#define WAITING 64u

static pthread_once_t once = PTHREAD_ONCE_INIT;
static pthread_mutex_t lock; /* protects next, served, busy */
static pthread_cond_t called[WAITING];
static unsigned next, served;
static bool busy;
static atomic_int devices;

static void init(void)
{
    pel_lock_init(&lock);
    for (unsigned i = 0; i < WAITING; i++) {
        pthread_cond_init(&called[i], NULL);
    }
}

void pel_turn_count(int change)
{
    atomic_fetch_add(&devices, change);
}

bool pel_turn_begin(void)
{
    if (atomic_load(&devices) < 2) {
        return false;
    }
    pthread_once(&once, init);
    pthread_mutex_lock(&lock);
    unsigned own = next++;
    while (busy || served != own) {
        pthread_cond_wait(&called[own % WAITING], &lock);
    }
    busy = true;
    served++;
    pthread_mutex_unlock(&lock);
    return true;
}

void pel_turn_end(bool had)
{
    if (!had) {
        return;
    }
    pthread_mutex_lock(&lock);
    busy = false;
    unsigned following = served;
    pthread_mutex_unlock(&lock);
    pthread_cond_signal(&called[following % WAITING]);
}
