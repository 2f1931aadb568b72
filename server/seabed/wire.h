/* What pelagos-seabed hands to the daemon: a height field in bytes. The reader
 * works on files from anywhere, so the daemon trusts nothing in them. Any
 * thread.
 *
 *   0  "pelsbed1"
 *   8  u32 columns, u32 rows
 *  16  f64 east, f64 north of the first node [m], f64 spacing [m]
 *  40  f32 heights [m], rows from south, nodes from west; NaN: no data
 *
 * All in the machine's own order: both ends are on one. */
#pragma once

#include "seabed/seabed.h"

#define PEL_SEABED_WIRE_MAGIC "pelsbed1"
#define PEL_SEABED_WIRE_HEAD 40
#define PEL_SEABED_WIRE_MOST                                                   \
    (PEL_SEABED_WIRE_HEAD + 4u * PEL_SEABED_MOST * PEL_SEABED_MOST)

/* Writes the head. */
void pel_seabed_wire_head(int columns, int rows, double west_m, double south_m,
                          double spacing_m,
                          unsigned char out[PEL_SEABED_WIRE_HEAD]);

/* MALFORMED, and what pel_seabed_create refuses. */
PEL_CHECK enum pel_err pel_seabed_wire_read(const unsigned char *bytes,
                                            size_t size,
                                            const struct pel_seabed **out,
                                            struct pel_fault *fault);
