/* The formats of pictures, from formats.def. Constant data and pure functions:
 * any thread. */
#pragma once

#include <stddef.h>

#include "pelagos.pb-c.h"

enum pel_format_uses {
    PEL_FORMAT_LAYERS = 1 << 0,  /* linear, with layers; else 8-bit colour */
    PEL_FORMAT_QUALITY = 1 << 1, /* of FrameRequest */
    PEL_FORMAT_TRUTH = 1 << 3,   /* no picture: of the id layer */
    PEL_FORMAT_QUICK = 1 << 2,   /* milliseconds; the others wait for it */
    PEL_FORMAT_PLANES = 1 << 4,  /* made of luma and chroma as well */
};

struct pel_format {
    Pelagos__FrameFormat format;
    const char *name;   /* as the schema calls it */
    const char *ending; /* without a dot */
    const char *mime;
    unsigned uses; /* enum pel_format_uses */
};

enum {
#define PEL_FORMAT(ID, ending, mime, encoder, uses, text) PEL_FORMAT_AT_##ID,
#include "proto/formats.def"
    PEL_FORMATS
};
extern const struct pel_format pel_format_table[PEL_FORMATS];

/* All endings, by ", ", and names likewise. */
extern const char *const pel_format_endings;
extern const char *const pel_format_names;

/* Names of the formats with all of `uses`, by ", ", cut to `size`. */
void pel_format_names_of(unsigned uses, char *out, size_t size);

/* The row of a format; NULL: there is none. */
const struct pel_format *pel_format_of(Pelagos__FrameFormat format);

/* The row of an ending, or of a path by its ending, upper or lower case, an
 * alias too. NULL: there is none. */
const struct pel_format *pel_format_by_ending(const char *ending);
const struct pel_format *pel_format_by_path(const char *path);
