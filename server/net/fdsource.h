/* A file descriptor and a wake-up time as one source of the main loop. */
#pragma once

#include <stdint.h>

#include <glib.h>

/* `ready`: conditions of the descriptor that hold now, 0 when only the wake-up
 * time came. May destroy its own source. */
typedef void (*pel_fdsource_ready)(void *user, GIOCondition ready);

struct pel_fdsource;

/* Attached to the default context; the descriptor stays the caller's. */
struct pel_fdsource *pel_fdsource_create(int fd, GIOCondition wanted,
                                         pel_fdsource_ready ready, void *user);

/* Call before closing the descriptor. NULL allowed. */
void pel_fdsource_destroy(struct pel_fdsource *source);

void pel_fdsource_want(struct pel_fdsource *source, GIOCondition wanted);

/* Wakes up once at `when_ns` (CLOCK_MONOTONIC); 0: at the loop's next turn,
 * -1: never. */
void pel_fdsource_wake_at(struct pel_fdsource *source, int64_t when_ns);
