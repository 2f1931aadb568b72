#version 450 core
// Sky and sea of a picture in one dispatch: chips that are wide in compute and
// narrow in graphics shade many times faster this way.
#include "lib/blocks.h"
#include "lib/together.glsl"
#include "lib/turns.glsl"
#ifdef PEL_AREAS
#include "lib/areas.glsl"
#endif
#include "lib/spline.glsl"
#ifdef PEL_SHORE
#include "lib/shore.glsl"
#endif
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#include "lib/waves.glsl"
#endif
#include "lib/filtered.glsl"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"
#include "lib/variance.glsl"
#include "lib/ray.glsl"
#include "lib/ross.glsl"
#include "lib/water.glsl"
#include "lib/glints.glsl"
#ifdef PEL_OBJECTS
#include "lib/mirrored.glsl"
#endif
#include "lib/lamplight.glsl"
#include "lib/shade.glsl"
#if defined(PEL_FOAM) || defined(PEL_WASH)
#include "lib/foamlight.glsl"
#include "lib/foam.glsl"
#endif
#include "lib/shaded.glsl"
#include "lib/backdrop.glsl"
#include "lib/haze.glsl"
#ifdef PEL_SEABED
#include "lib/seabed.glsl"
#endif
#include "lib/sea.glsl"
#ifdef PEL_LAND
#include "lib/coast.glsl"
#endif
#ifdef PEL_OBJECTS
#include "lib/objects.glsl"
#endif
#include "lib/tone.glsl"

#ifdef PEL_TOGETHER
layout(local_size_x = PEL_GROUP_WIDE, local_size_y = PEL_GROUP_LOW) in;
#include "lib/pictures.glsl"
#else
layout(local_size_x = PEL_GROUP_SIDE, local_size_y = PEL_GROUP_SIDE) in;
layout(location = 0) uniform int wanted;
layout(location = 1) uniform ivec4 region; // pixels from xy to before zw
#endif
// Of search.comp.
layout(std430, binding = PEL_STORE_KEYS) restrict buffer keys_block { uint keys[]; };
#ifdef PEL_TOGETHER
layout(std430, binding = PEL_STORE_RADIANCE) restrict writeonly buffer radiance_block { vec4 radiance[]; };
#else
layout(binding = PEL_IMAGE_COLOR, rgba8) writeonly uniform image2D color_image;
layout(binding = PEL_IMAGE_RADIANCE, rgba32f) writeonly uniform image2D radiance_image;
#endif
#ifdef PEL_LAYERS
layout(location = PEL_UNIFORM_SLOTS) uniform int slots[PEL_COMPUTE_SLOTS];
layout(binding = PEL_IMAGE_SLOTS) writeonly uniform image2D slot_images[PEL_COMPUTE_SLOTS];
#endif

void main()
{
    take_view();
#ifdef PEL_TOGETHER
    // Groups begin with the picture's lines: what is around it comes last.
    ivec2 wide = ivec2(size.xy);
    int margin = int(PEL_OWN.picture.x);
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= wide.x || at.y >= wide.y) {
        return;
    }
    at.x += at.x < wide.x - margin ? margin : margin - wide.x;
#else
    ivec2 at = region.xy + ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= region.z || at.y >= region.w) {
        return;
    }
#endif
    uint place = FIRST_PIXEL + uint(at.y * int(size.x) + at.x);
    uint key = keys[place];
    uint triangle = 0xFFFFFFFFu - key;
    shaded s = only_light(vec3(0.0));
    float behind = 1.0;
    float shows = PEL_SHOWS_SEA;
#ifdef PEL_OBJECTS
    float cover;
    shaded nearer = shade_samples(at, cover);
    behind = 1.0 - cover;
    bool middle = true;
#ifdef PEL_LAYERS
    uvec2 seen = texelFetch(objects, at, 0).rg;
    vec3 ray = pixel_ray(lattice(at));
    middle = object_in_sight(ray, seen);
#endif
    if (behind > 0.0 || !middle)
#endif
    {
#ifdef PEL_LAND
        s = shade_coast(at, key == 0u ? 0u : triangle, shows);
#else
        if (key == 0u) {
            s = shade_backdrop(at);
        } else {
            s = shade_sea(at, triangle);
        }
#endif
    }
#ifdef PEL_OBJECTS
    // Light is mixed; the rest is the middle's.
    shaded light = only_light(vec3(0.0));
    add_light(light, s, behind);
    add_light(light, nearer, 1.0);
#ifdef PEL_LAYERS
    if (middle) {
        s = shade_object(ray, seen);
    }
#endif
    take_light(s, light);
#endif
#ifdef PEL_TOGETHER
    put_color(at, display(s.radiance, at));
    if (margin > 0) { // outlines read the keys, too
        radiance[place] = vec4(s.radiance, shows * behind);
    } else {
        keys[place] = 0u;
    }
    if (at == ivec2(margin)) {
        put_exposure(exposure.x);
    }
#else
    if ((wanted & PEL_LAST_PASS) != 0) {
        keys[place] = 0u;
    }
    if ((wanted & PEL_WANTS_RADIANCE) != 0) {
        imageStore(radiance_image, at, vec4(s.radiance, shows * behind));
    }
    if ((wanted & PEL_WANTS_COLOR) != 0) {
        imageStore(color_image, at, unpackUnorm4x8(packed_color(display(s.radiance, at))));
    }
#endif
#ifdef PEL_LAYERS
    for (int i = 0; i < PEL_COMPUTE_SLOTS; i++) {
        if (slots[i] >= 0) {
            imageStore(slot_images[i], at, layer_of(s, slots[i]));
        }
    }
#endif
}
