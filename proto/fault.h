/* Faults on the wire: struct pel_fault ↔ Error. Any thread. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"

/* Fills *out; its strings are *fault's, so `fault` must outlive it, and *out
 * must not be freed. */
void pel_fault_to_error(const struct pel_fault *fault, Pelagos__Error *out);

/* A copy of an Error as a fault. */
void pel_fault_from_error(const Pelagos__Error *error, struct pel_fault *out);

/* Puts path and value (NULL: none) into *fault (NULL allowed), truncated, and
 * the unit and range that the schema gives the path. */
void pel_fault_at(struct pel_fault *fault, const char *path, const char *value);

/* Fills *fault (NULL allowed) with "PATH WHAT", path and value; returns the
 * code. */
enum pel_err pel_fault_refuse(enum pel_err code, const char *path,
                              const char *value, const char *what,
                              struct pel_fault *fault);
