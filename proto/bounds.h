/* Limits that a client can reach, from bounds.def. */
#pragma once

enum {
#define PEL_BOUND(ID, value, unit, where, what, next, counter)                 \
    PEL_BOUND_##ID = (value),
#include "proto/bounds.def"
};
