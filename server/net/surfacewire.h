/* Answers of surface queries as bytes, written by the threads that compute
 * them: as protobuf-c packs, ten times as fast, and as the converter of proto/
 * writes JSON. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "frames/frames.h"

/* The delimited bytes of a Reply with a Surface. */
struct pel_surface_form pel_surface_reply(bool has_id, uint64_t id);

/* A Surface as JSON. */
extern const struct pel_surface_form pel_surface_json;
