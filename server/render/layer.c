#include <math.h>
#include <string.h>

#include "optics/atmosphere.h"
#include "render/renderer.h"
#include "render/uniforms.h"

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
    { "position", PEL_LAYER_POSITION, "XYZ", 3, true, "m" },
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
    bool depth = !(layers & PEL_LAYER_DEPTH) && (layers & PEL_LAYER_POSITION);
    bytes += depth ? sizeof(float) : 0;
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
    case PEL_LAYER_POSITION:
        break;
    }
    return NULL;
}

void pel_picture_position_origin(const struct pel_camera *camera,
                                 double *east_m, double *north_m)
{
    const double step = PEL_POSITION_STEP_M;
    *east_m = step * round(camera->east_m / step);
    *north_m = step * round(camera->north_m / step);
}

/* Where the vector p from the eye leads: the sphere as shaders/mesh.comp lays
 * it, an arc r from the nadir r cos(r / 2R) away and 2R sin²(r / 2R) down. */
static struct pel_vec3 place_of(struct pel_vec3 p, double eye_m)
{
    double flat = hypot(p.x, p.y), arc = flat;
    for (int i = 0; i < 3; i++) { /* an arc of 300 km within 1 mm */
        arc = flat / cos(0.5 * arc / PEL_EARTH_RADIUS);
    }
    double stretch = flat > 0 ? arc / flat : 1.0;
    double half = sin(0.5 * arc / PEL_EARTH_RADIUS);
    return (struct pel_vec3){ p.x * stretch, p.y * stretch,
                              p.z + eye_m +
                                  2.0 * PEL_EARTH_RADIUS * half * half };
}

void pel_picture_position(const struct pel_picture *picture,
                          const struct pel_camera *camera, double sea_level_m,
                          float *xyz)
{
    struct pel_block_view view; /* the very rays of the shaders */
    const struct pel_filter filter = PEL_FILTER_DEFAULT;
    pel_fill_view(camera, &filter, &view);
    double east, north;
    pel_picture_position_origin(camera, &east, &north);
    double eye = fmax(camera->altitude_m - sea_level_m, PEL_LEAST_EYE_M);
    for (size_t i = 0; i < (size_t)picture->width * picture->height; i++) {
        double u = ((double)view.pixel.z + (double)(i % picture->width) + 0.5) *
                   (double)view.pixel.x;
        double v = ((double)view.pixel.w + (double)(i / picture->width) + 0.5) *
                   (double)view.pixel.y;
        struct pel_vec3 ray = {
            (double)view.right.x * u - (double)view.up.x * v -
                (double)view.back.x,
            (double)view.right.y * u - (double)view.up.y * v -
                (double)view.back.y,
            (double)view.right.z * u - (double)view.up.z * v -
                (double)view.back.z,
        };
        double range = (double)picture->depth[i];
        float *to = xyz + 3 * i;
        if (isinf(range)) {
            to[0] = to[1] = to[2] = 0.0f;
            continue;
        }
        struct pel_vec3 p = pel_vec3_scale(pel_vec3_normalize(ray), range);
        struct pel_vec3 place = place_of(p, eye);
        to[0] = (float)(camera->east_m - east + place.x);
        to[1] = (float)(camera->north_m - north + place.y);
        to[2] = (float)(place.z + sea_level_m);
    }
}
