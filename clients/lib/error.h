/* How every error of the library ends: a code and a sentence in the caller's
 * hands. */
#pragma once

#include "pelagos.h"

/* Fills *error, which may be NULL; returns the code. */
enum pel_client_code client_fail(struct pel_client_error *error,
                                 enum pel_client_code code, const char *format,
                                 ...) __attribute__((format(printf, 3, 4)));
