#include "base/reserve.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static void *_Atomic reserve;

bool pel_reserve_whole(void)
{
    void *none = NULL;
    if (atomic_load(&reserve)) {
        return true;
    }
    void *fresh = malloc(PEL_RESERVE_BYTES);
    if (fresh && !atomic_compare_exchange_strong(&reserve, &none, fresh)) {
        free(fresh); /* another thread was faster */
    }
    return fresh != NULL;
}

bool pel_reserve_spend(void)
{
    void *had = atomic_exchange(&reserve, NULL);
    free(had);
    return had != NULL;
}

void *pel_sure_realloc(void *old, size_t size)
{
    size = size > 0 ? size : 1;
    void *memory = realloc(old, size);
    if (!memory) {
        /* Threads that fail together share what one has given up. */
        (void)pel_reserve_spend();
        memory = realloc(old, size);
    }
    if (!memory) {
        abort();
    }
    return memory;
}

void *pel_sure_malloc(size_t size)
{
    return pel_sure_realloc(NULL, size);
}

void *pel_sure_calloc(size_t count, size_t size)
{
    void *memory = calloc(count > 0 ? count : 1, size > 0 ? size : 1);
    if (!memory) {
        (void)pel_reserve_spend();
        memory = calloc(count > 0 ? count : 1, size > 0 ? size : 1);
    }
    if (!memory) {
        abort();
    }
    return memory;
}

char *pel_sure_strdup(const char *text)
{
    size_t size = strlen(text) + 1;
    return memcpy(pel_sure_malloc(size), text, size);
}
