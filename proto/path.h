/* Fields by path: `sea.windSpeed`, `views.bridge.yaw`, `entities.1.heading`,
 * `entities.ownship.heading`, `sea.swell.0.height`. `view.` and `entity.` are
 * accepted for `views.` and `entities.`. Any thread. */
#pragma once

#include <stddef.h>

#include "base/err.h"
#include "fields.h"
#include "pelagos.pb-c.h"

/* What a path names, without looking at a state. */
struct pel_path_info {
    const ProtobufCMessageDescriptor *message; /* that holds the field */
    const ProtobufCFieldDescriptor *field;     /* descriptor: enum's values */
    const struct pel_field *info;              /* unit, range, doc */
};

/* Resolves a path; an element of a list (`views.bridge`) resolves to the list
 * field. NOT_FOUND with the path; `fault` may be NULL. */
PEL_CHECK enum pel_err pel_path_find(const char *path,
                                     struct pel_path_info *out,
                                     struct pel_fault *fault);

/* Adds one assignment to a patch. `value` is text: a number, an enum's name, a
 * string without quotes, `true`; NULL or `null` resets the field (removes the
 * element). `now` (NULL allowed) is the present state: from it a list without
 * key (sea.swell) is copied at first touch, as patches replace it whole;
 * without it an index may only follow those already in the patch.
 * NOT_FOUND or INVALID, and the patch is unchanged. Ranges are not tested. */
PEL_CHECK enum pel_err pel_path_set(Pelagos__Patch *patch,
                                    const Pelagos__State *now, const char *path,
                                    const char *value, struct pel_fault *fault);

/* As pel_path_set, with a number: an enum's by its value, a bool by 0 and not
 * 0, a whole number rounded. INVALID also for a field that is no number. */
PEL_CHECK enum pel_err pel_path_set_number(Pelagos__Patch *patch,
                                           const Pelagos__State *now,
                                           const char *path, double value,
                                           struct pel_fault *fault);

/* A new patch for pel_path_set; pelagos__patch__free_unpacked(p, NULL). */
Pelagos__Patch *pel_patch_new(void);

/* Writes the value at `path` of a state as text (a message or list as JSON);
 * an absent field gives "". NOT_FOUND: no such field or element; OUT_OF_RANGE:
 * it does not fit `size`. */
PEL_CHECK enum pel_err pel_path_get(const Pelagos__State *state,
                                    const char *path, char *out, size_t size,
                                    struct pel_fault *fault);

/* Calls back for every field below State in the schema's order, with a path
 * that has `*` for keys and indices (`entities.*.heading`). */
void pel_path_each(void (*callback)(const char *path,
                                    const struct pel_path_info *info,
                                    void *user),
                   void *user);

/* Resets the field, element or list at `path` of a message of type State:
 * default where the schema has one, else absent. NOT_FOUND, or CONFLICT for a
 * name that several elements share; the message is then unchanged. */
PEL_CHECK enum pel_err pel_path_remove(Pelagos__State *state, const char *path,
                                       struct pel_fault *fault);
