/* Entities get the models of their CIGI types: edits of their own, which take
 * effect when a thread has made them. Control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"

struct pel_cigi_shapes;
struct pel_scene;

struct pel_cigi_shape_counters {
    uint64_t unknown; /* times that an entity got a type not in the table */
    uint64_t edits, refused_edits;
};

/* Reads the table (cigi_types.h). Errors: IO; INVALID and others of the table:
 * *fault names file, line, field, value and range. */
PEL_CHECK enum pel_err pel_cigi_shapes_create(const char *path,
                                              struct pel_scene *scene,
                                              struct pel_cigi_shapes **out,
                                              struct pel_fault *fault);
void pel_cigi_shapes_destroy(struct pel_cigi_shapes *shapes); /* NULL allowed */

/* The host has said an entity's type, or removed the entity. NULL allowed,
 * here and below. */
void pel_cigi_shapes_take(struct pel_cigi_shapes *shapes, uint32_t id,
                          unsigned type, bool removed);

/* What was taken becomes an edit; after the edit that made the entities. */
void pel_cigi_shapes_commit(struct pel_cigi_shapes *shapes);

struct pel_cigi_shape_counters
pel_cigi_shapes_counters(const struct pel_cigi_shapes *shapes);
