/* MPEG transport stream (ISO/IEC 13818-1) of one H.264 video: what players
 * without RTSP open over HTTP. A pure function of its state and input; one
 * state for each reader. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "encode/encode.h"

#define PEL_TS_PACKET 188

/* All zero at the start. */
struct pel_ts {
    uint8_t pat, pmt, video; /* continuity counters */
};

/* Packets of one access unit (Annex B). time_ns counts from the stream's
 * start, 0 or more; a key frame has the program's tables before it. Players
 * show it 0.1 s after its clock reference. INVALID: no bytes; NO_MEMORY. */
PEL_CHECK enum pel_err pel_ts_write(struct pel_ts *ts, const uint8_t *unit,
                                    size_t size, int64_t time_ns, bool key,
                                    struct pel_bytes *out);
