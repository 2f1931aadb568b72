/* Answers of surface queries as bytes: the same as protobuf-c packs, ten
 * times as fast. Any thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "ocean/sea.h"

/* The delimited bytes of a Reply with a Surface; malloc()ed. At most 10,000
 * samples. */
uint8_t *pel_surface_reply(bool has_id, uint64_t id, double time_s,
                           const struct pel_surface_sample *samples,
                           size_t count, size_t *size);
