#include <string.h>

#include "render/renderer.h"

#define LIGHT "W m^-2 sr^-1 nm^-1"

const struct pel_layer_info pel_layer_table[PEL_LAYERS] = {
    { "radiance", PEL_LAYER_RADIANCE, "RGB", 4, false, LIGHT },
    { "sun", PEL_LAYER_SUN, "RGB", 4, false, LIGHT },
    { "sky", PEL_LAYER_SKY, "RGB", 4, false, LIGHT },
    { "water", PEL_LAYER_WATER, "RGB", 4, false, LIGHT },
    { "air", PEL_LAYER_AIR, "RGB", 4, false, LIGHT },
    /* A half is 4 m coarse at 5 km. */
    { "depth", PEL_LAYER_DEPTH, "Z", 1, true, "m" },
    { "normal", PEL_LAYER_NORMAL, "XYZ", 4, false, "1" },
    { "fresnel", PEL_LAYER_FRESNEL, "V", 4, false, "1" },
    { "slopeVariance", PEL_LAYER_SLOPE_VARIANCE, "XY", 2, false, "1" },
    { "waterSingle", PEL_LAYER_WATER_SINGLE, "RGB", 4, false, LIGHT },
    { "waterSecond", PEL_LAYER_WATER_SECOND, "RGB", 4, false, LIGHT },
    { "waterHigher", PEL_LAYER_WATER_HIGHER, "RGB", 4, false, LIGHT },
    { "bottom", PEL_LAYER_BOTTOM, "RGB", 4, false, LIGHT },
};

const struct pel_layer_info *pel_layer_find(const char *name)
{
    for (int i = 0; i < PEL_LAYERS; i++) {
        if (strcmp(name, pel_layer_table[i].name) == 0) {
            return &pel_layer_table[i];
        }
    }
    return NULL;
}

size_t pel_layer_bytes(unsigned layers)
{
    size_t bytes = layers & PEL_LAYER_COLOR ? 4 : 0;
    for (int i = 0; i < PEL_LAYERS; i++) {
        const struct pel_layer_info *l = &pel_layer_table[i];
        /* F̄ is read with the normal. */
        bool shared =
            l->bit == PEL_LAYER_FRESNEL && (layers & PEL_LAYER_NORMAL);
        if ((layers & l->bit) && !shared) {
            bytes += sizeof(float) * (size_t)l->floats;
        }
    }
    return bytes;
}

const float *pel_picture_layer(const struct pel_picture *p,
                               const struct pel_layer_info *layer)
{
    switch (layer->bit) {
    case PEL_LAYER_RADIANCE:
        return p->radiance;
    case PEL_LAYER_SUN:
        return p->sun;
    case PEL_LAYER_SKY:
        return p->sky;
    case PEL_LAYER_WATER:
        return p->water;
    case PEL_LAYER_AIR:
        return p->air;
    case PEL_LAYER_DEPTH:
        return p->depth;
    case PEL_LAYER_NORMAL:
        return p->normal;
    case PEL_LAYER_FRESNEL:
        return p->normal ? p->normal + 3 : NULL;
    case PEL_LAYER_SLOPE_VARIANCE:
        return p->slope_variance;
    case PEL_LAYER_WATER_SINGLE:
        return p->water_part[PEL_WATER_SINGLE];
    case PEL_LAYER_WATER_SECOND:
        return p->water_part[PEL_WATER_SECOND];
    case PEL_LAYER_WATER_HIGHER:
        return p->water_part[PEL_WATER_HIGHER];
    case PEL_LAYER_BOTTOM:
        return p->water_part[PEL_WATER_BOTTOM];
    case PEL_LAYER_COLOR:
        break;
    }
    return NULL;
}
