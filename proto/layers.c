#include "proto/layers.h"

#include <string.h>

const struct pel_layer_info pel_layer_table[PEL_LAYERS] = {
#define HALF false
#define FLOAT true
#define PEL_LAYER(ID, member, name, channels, samples, unit, from, text)       \
    { name, PEL_LAYER_##ID, channels, samples, unit, PEL_LAYER_FROM_##from },
#include "proto/layers.def"
};

static const char names[] =
#define PEL_LAYER(ID, member, name, channels, samples, unit, from, text)       \
    ", " name
#include "proto/layers.def"
    ;
const char *const pel_layer_names = names + 2;

/* A set of them is an unsigned int. */
_Static_assert(PEL_LAYERS < 32, "more layers than bits");

const struct pel_layer_info *pel_layer_find(const char *name)
{
    for (int i = 0; i < PEL_LAYERS; i++) {
        if (strcmp(name, pel_layer_table[i].name) == 0) {
            return &pel_layer_table[i];
        }
    }
    return NULL;
}

unsigned pel_layers_of_light(void)
{
    unsigned layers = 0;
    for (int i = 0; i < PEL_LAYERS; i++) {
        const struct pel_layer_info *l = &pel_layer_table[i];
        layers |= strcmp(l->unit, PEL_UNIT_LIGHT) == 0 ? l->bit : 0;
    }
    return layers;
}

unsigned pel_layers_from(enum pel_layer_from from)
{
    unsigned layers = 0;
    for (int i = 0; i < PEL_LAYERS; i++) {
        layers |= pel_layer_table[i].from == from ? pel_layer_table[i].bit : 0;
    }
    return layers;
}
