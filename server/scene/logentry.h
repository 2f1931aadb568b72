/* Writing command logs (proto/pelog.md): what the recorder and the journal have
 * in common. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "pelagos.pb-c.h"

/* One entry with its length before it, *size bytes; free(). */
uint8_t *pel_log_pack_patch(double time_s, uint64_t revision,
                            const Pelagos__Patch *patch, size_t *size);
uint8_t *pel_log_pack_step(double time_s, uint64_t revision, size_t *size);
/* The state's time and revision are the entry's; missed: frames before it. */
uint8_t *pel_log_pack_state(const Pelagos__State *state, uint64_t missed,
                            size_t *size);
/* head.state's time and revision are the entry's. */
uint8_t *pel_log_pack_head(const Pelagos__LogHead *head, size_t *size);

/* Which steps are written: each of a clock that is STEPPED, of others (`each`
 * false) one in a tenth of a simulated second after last_s, that of the last
 * entry. */
bool pel_log_wants_step(bool each, double time_s, double last_s);
