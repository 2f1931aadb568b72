/* A picture of the whole sky in equal steps of azimuth and elevation, in place
 * of the computed one: immutable, reference counted. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"

#define PEL_PANORAMA_MOST_COLUMNS 4096
#define PEL_PANORAMA_LEAST_COLUMNS 16

struct pel_panorama {
    uint64_t id; /* of no other in this process */
    int columns, rows;
    double unit; /* of the halves, in the file's values */
    /* Linear Rec. 709, three a texel, rows from the zenith; the middle column
     * looks along the picture's azimuth, and right of it is clockwise. */
    const uint16_t *halves;
    /* Its Sun, where it was taken out: from the middle column clockwise and
     * above the horizon; the irradiance normal to its beam, in the file's
     * values times steradian. */
    bool has_sun;
    double sun_azimuth_rad, sun_elevation_rad, sun[3];
};

/* Of linear Rec. 709 values, finite and not negative, two columns a row.
 * `take_sun`: light of the brightest spot above the horizon that outshines its
 * surroundings by PEL_PANORAMA_SUN is taken out; what is around it fills its
 * place. NO_MEMORY, MALFORMED (sizes, values). */
#define PEL_PANORAMA_SUN 20.0
PEL_CHECK enum pel_err pel_panorama_create(int columns, int rows, float *values,
                                           bool take_sun,
                                           const struct pel_panorama **out,
                                           struct pel_fault *fault);
const struct pel_panorama *pel_panorama_ref(const struct pel_panorama *p);
void pel_panorama_unref(const struct pel_panorama *p); /* NULL allowed */

/* Nearest half of a value in [0, 65504]. */
uint16_t pel_half_of(float value);

/* What the reader hands over, in the machine's own order:
 *   0  "pelpano1"
 *   8  u32 columns, u32 rows
 *  16  f32 values, three a texel, rows from the zenith */
#define PEL_PANORAMA_MAGIC "pelpano1"
#define PEL_PANORAMA_HEAD 16
#define PEL_PANORAMA_WIRE_MOST                                                 \
    (PEL_PANORAMA_HEAD +                                                       \
     6u * PEL_PANORAMA_MOST_COLUMNS * PEL_PANORAMA_MOST_COLUMNS)

/* Reads a file of `directory` by pelagos-panorama, a process of its own
 * (base/helper.h); waits, at most PEL_PANORAMA_LOAD_MS. CONFLICT (no
 * directory), INVALID, NOT_FOUND, IO, NO_MEMORY, MALFORMED: *fault says why. */
#define PEL_PANORAMA_LOAD_MS 15000
PEL_CHECK enum pel_err pel_panorama_load(const char *directory,
                                         const char *file, bool take_sun,
                                         const struct pel_panorama **out,
                                         struct pel_fault *fault);
