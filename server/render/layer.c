#include <math.h>
#include <string.h>

#include "optics/atmosphere.h"
#include "render/renderer.h"
#include "render/spacemap.h"
#include "render/uniforms.h"

unsigned pel_layers_stored(unsigned layers)
{
    const unsigned host = pel_layers_from(PEL_LAYER_FROM_HOST);
    return (layers & ~(host | PEL_LAYER_COLOR)) |
           (layers & host ? PEL_LAYER_DEPTH : 0);
}

int pel_layer_stride(const struct pel_layer_info *layer)
{
    int channels = (int)strlen(layer->channels);
    /* Devices draw into one, two or four. */
    return channels == 3 && layer->from != PEL_LAYER_FROM_HOST ? 4 : channels;
}

size_t pel_layer_bytes(unsigned layers)
{
    const unsigned all = layers | pel_layers_stored(layers);
    size_t bytes = layers & PEL_LAYER_COLOR ? 4 : 0;
    for (int i = 0; i < PEL_LAYERS; i++) {
        const struct pel_layer_info *l = &pel_layer_table[i];
        if (all & l->bit) {
            bytes += sizeof(float) * (size_t)pel_layer_stride(l);
        }
    }
    return bytes;
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

/* From high up: on the ellipsoid, as lib/space.glsl lays it. */
static struct pel_vec3 place_below(const struct pel_space_geometry *g,
                                   struct pel_vec3 p)
{
    const struct pel_vec3 there = pel_mat3_apply(&g->from, p);
    double sine = fmin(hypot(there.x, there.y) / PEL_EARTH_RADIUS, 1.0);
    double stretch = sine > 1e-9 ? asin(sine) / sine : 1.0;
    return (struct pel_vec3){ p.x * stretch, p.y * stretch, 0.0 };
}

void pel_picture_position(const struct pel_picture *picture,
                          const struct pel_camera *camera,
                          const struct pel_environment *env, float *xyz)
{
    const double sea_level_m = env->sea_level_m;
    struct pel_block_view view; /* the very rays of the shaders */
    const struct pel_filter filter = PEL_FILTER_DEFAULT;
    pel_fill_view(camera, &filter, &view);
    double east, north;
    pel_picture_position_origin(camera, &east, &north);
    double eye = camera->altitude_m - sea_level_m;
    const bool high = pel_space_is(env, eye);
    struct pel_space_geometry g = { 0 };
    if (high) {
        g = pel_space_geometry_for(env, camera, eye);
    }
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
        struct pel_vec3 place = high ? place_below(&g, p) : place_of(p, eye);
        to[0] = (float)(camera->east_m - east + place.x);
        to[1] = (float)(camera->north_m - north + place.y);
        to[2] = (float)(place.z + sea_level_m);
    }
}
