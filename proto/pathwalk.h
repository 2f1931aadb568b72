/* Paths, component by component. Behind path.h; not for other rooms. */
#pragma once

#include <protobuf-c/protobuf-c.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "path.h"

#define PATH_MAX_BYTES 256

/* Takes the next component of *rest; false at the end. Components may be
 * empty (which no field is called). */
bool path_next(const char **rest, const char **name, size_t *length);

/* The field of `type` that a component names; `top`: view and entity are
 * accepted for views and entities. */
const ProtobufCFieldDescriptor *
path_field(const ProtobufCMessageDescriptor *type, const char *name,
           size_t length, bool top);

/* NOT_FOUND at a path. */
enum pel_err path_unknown(const char *path, const char *what,
                          struct pel_fault *fault);

/* Index of the element of a list that a component names: by key, by unique
 * `name`, or by index where the list has no key. CONFLICT: several. */
PEL_CHECK enum pel_err path_element(const ProtobufCMessage *holder,
                                    const ProtobufCFieldDescriptor *field,
                                    const char *name, size_t length,
                                    const char *path, size_t *index,
                                    struct pel_fault *fault);

/* Whole decimal index of a component; false: it is none. */
bool path_index(const char *name, size_t length, size_t *index);

static inline bool path_is_list(const ProtobufCFieldDescriptor *field)
{
    return field->label == PROTOBUF_C_LABEL_REPEATED &&
           field->type == PROTOBUF_C_TYPE_MESSAGE;
}
