/* Locks that threads of all priorities share. */
#pragma once

#include <pthread.h>

/* A mutex with priority inheritance, which real-time threads may share with
 * others. */
void pel_lock_init(pthread_mutex_t *lock);
