/* Values of a message in the ranges that the schema gives them. Any thread. */
#pragma once

#include <protobuf-c/protobuf-c.h>

#include "base/err.h"

/* Every value of `message`, whose path is `path` (""; "a.b"), in its range and
 * finite, enums known, texts of printable UTF-8 and at most as long as the
 * schema says. On refusal *fault (NULL allowed) names path, value, unit and
 * range. */
PEL_CHECK enum pel_err pel_message_check(const ProtobufCMessage *message,
                                         const char *path,
                                         struct pel_fault *fault);
