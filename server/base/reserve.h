/* Small pieces of memory that are always given: messages of the state, names.
 * An edit takes some hundred of them, so a reserve is kept back: where malloc
 * refuses one, the reserve is given up, and what is under way ends well; until
 * it is whole again new edits are refused (PEL_ERR_NO_MEMORY). The process ends
 * only where even that is used up. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#define PEL_RESERVE_BYTES (4 << 20)

/* Never NULL; to be freed by free(). */
void *pel_sure_malloc(size_t size);
void *pel_sure_calloc(size_t count, size_t size);
void *pel_sure_realloc(void *old, size_t size);
char *pel_sure_strdup(const char *text);

/* For what takes larger pieces and cannot be refused either: gives the reserve
 * up for another attempt; false: there is none. */
bool pel_reserve_spend(void);

/* Makes it whole where it is not; false: it cannot be now. */
bool pel_reserve_whole(void);
