/* How every function of the library reports an error: a code and a sentence. */
#pragma once

#include "pelagos.h"

/* Fills *error, which may be NULL; returns the code. */
enum pel_client_code client_fail(struct pel_client_error *error,
                                 enum pel_client_code code, const char *format,
                                 ...) __attribute__((format(printf, 3, 4)));
/* What the analyzer, which sees one source at a time, cannot know. */
#ifdef __clang_analyzer__
#define client_fail(error, code, ...)                                          \
    ((void)(client_fail)(error, code, __VA_ARGS__), (code))
#endif
