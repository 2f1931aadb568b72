/* JSON that is not the schema's: every value of a text that is no object and no
 * list, with its path. Strict as json.h. Any thread. */
#pragma once

#include <stddef.h>

#include "base/err.h"

/* path: `kvs.0.value`; value: a string unescaped, a number, true, false or
 * null as it is written. */
typedef void (*pel_json_each)(void *user, const char *path, const char *value);

/* MALFORMED: the text is not JSON; what came before was told. */
PEL_CHECK enum pel_err pel_json_walk(const char *text, size_t length,
                                     pel_json_each each, void *user,
                                     struct pel_fault *fault);
