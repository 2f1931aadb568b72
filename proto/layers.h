/* The layers of a picture, from layers.def. Constant data and pure functions:
 * any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* Places in the table. */
enum {
#define PEL_LAYER(ID, member, name, channels, samples, unit, from, text)       \
    PEL_AT_##ID,
#include "proto/layers.def"
    PEL_LAYERS
};

/* Sets of layers are sums of these. */
enum pel_layer {
    PEL_LAYER_COLOR = 1 << 0, /* 8-bit sRGB, exposed and tone-mapped */
#define PEL_LAYER(ID, member, name, channels, samples, unit, from, text)       \
    PEL_LAYER_##ID = 2 << PEL_AT_##ID,
#include "proto/layers.def"
};

enum pel_layer_from {
    PEL_LAYER_FROM_LIGHT,
    PEL_LAYER_FROM_SURFACE,
    PEL_LAYER_FROM_WATER,
    PEL_LAYER_FROM_HOST, /* the shaders write none of these */
};

struct pel_layer_info {
    const char *name;
    enum pel_layer bit;
    const char *channels; /* one letter a component, as OpenEXR names them */
    bool full_float;      /* keeps 32 bits where others are halves */
    const char *unit;
    enum pel_layer_from from;
};
extern const struct pel_layer_info pel_layer_table[PEL_LAYERS];

/* All names, by ", ". */
extern const char *const pel_layer_names;

/* The layer called `name`, or NULL. */
const struct pel_layer_info *pel_layer_find(const char *name);

/* All layers of light, which add up; others are what the middle of a pixel
 * sees. */
unsigned pel_layers_of_light(void);

/* All layers that are made that way. */
unsigned pel_layers_from(enum pel_layer_from from);
