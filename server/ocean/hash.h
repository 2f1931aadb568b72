/* What each stream of random numbers of a sea is for. */
#pragma once

#include "base/hash.h"

enum pel_stream {
    PEL_STREAM_PHASE = 1,
    PEL_STREAM_FREQUENCY,
    PEL_STREAM_DIRECTION,
    PEL_STREAM_OFFSET,
    PEL_STREAM_SWELL = 16,   /* and one for each train */
    PEL_STREAM_CASCADE = 64, /* and one for each cascade */
};
