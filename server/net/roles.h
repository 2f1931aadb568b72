/* What the holder of a token may do: proto/roles.def. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "base/share.h"
#include "pelagos.pb-c.h"

/* Each may do what those before it may. */
enum pel_role {
    PEL_ROLE_NONE, /* no token */
    PEL_ROLE_WATCH,
    PEL_ROLE_STEER,
    PEL_ROLE_INSTRUCT,
};

enum pel_role pel_role_of_rank(enum pel_rank rank);
enum pel_rank pel_rank_of_role(enum pel_role role);

/* "watch", "steer", "instruct"; "none". */
const char *pel_role_name(enum pel_role role);
/* NONE: there is no such role. */
enum pel_role pel_role_by_name(const char *name);

/* The i-th field that a patch of this role may set, as roles.def has it, or
 * "*" for all; NULL: there are no more. */
const char *pel_role_field(enum pel_role has, size_t i);

/* The least role for a route of proto/routes.def, and for a command of Request.
 */
enum pel_role pel_role_of_route(const char *method, const char *pattern);
enum pel_role pel_role_of_command(Pelagos__Request__CommandCase command);

/* FORBIDDEN where `has` is less than `needs`; `what` names it. */
PEL_CHECK enum pel_err pel_role_need(enum pel_role has, enum pel_role needs,
                                     const char *what, struct pel_fault *fault);

/* The state as the role reads it: a copy of *state alone, whose parts are
 * borrowed, without the fields that it may not read. */
void pel_role_seen(enum pel_role has, const Pelagos__State *state,
                   Pelagos__State *out);
/* FORBIDDEN for a path into one of these. */
PEL_CHECK enum pel_err pel_role_read(enum pel_role has, const char *path,
                                     struct pel_fault *fault);

/* Whether the role may make this patch of the state; FORBIDDEN names the first
 * field that it may not. */
PEL_CHECK enum pel_err pel_role_patch(enum pel_role has,
                                      const Pelagos__Patch *patch,
                                      const Pelagos__State *state,
                                      struct pel_fault *fault);
