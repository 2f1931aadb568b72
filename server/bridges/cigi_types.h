/* Which models CIGI's entity types are: a file of text, a line a type,
 *
 *   NUMBER MODEL
 *
 * NUMBER within 0 .. 65535, MODEL the schema's Model as JSON, say
 * {"name": "tanker", "length": 180}; a line that begins with # is a comment.
 * Any thread. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "pelagos.pb-c.h"

#define PEL_CIGI_TYPES_MOST 1024
#define PEL_CIGI_TYPES_FILE 262144 /* bytes */

struct pel_cigi_types {
    size_t count;
    struct pel_cigi_type {
        uint16_t number;
        Pelagos__Model *model;
    } types[PEL_CIGI_TYPES_MOST];
};

/* INVALID and what the JSON's reader says: *fault names line, field, value and
 * range. A file of a model is read when an entity
 * is given it. */
PEL_CHECK enum pel_err pel_cigi_types_read(const char *text, size_t size,
                                           struct pel_cigi_types *out,
                                           struct pel_fault *fault);
void pel_cigi_types_finish(struct pel_cigi_types *types);

/* NULL: not in the table. */
const Pelagos__Model *pel_cigi_types_find(const struct pel_cigi_types *types,
                                          unsigned number);
