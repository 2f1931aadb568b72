#version 450 core
// Sky and sea of a picture in one dispatch: chips that are wide in compute and
// narrow in graphics shade many times faster this way.
#include "lib/blocks.h"
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#include "lib/waves.glsl"
#endif
#include "lib/filtered.glsl"
#include "lib/sky.glsl"
#include "lib/variance.glsl"
#include "lib/ray.glsl"
#include "lib/ross.glsl"
#include "lib/water.glsl"
#include "lib/shade.glsl"
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
#include "lib/tone.glsl"

layout(local_size_x = PEL_GROUP_SIDE, local_size_y = PEL_GROUP_SIDE) in;
layout(location = 0) uniform int wanted;
layout(location = 1) uniform ivec4 region; // pixels from xy to before zw
// Of search.comp.
layout(std430, binding = PEL_STORE_KEYS) restrict buffer keys_block { uint keys[]; };
#ifdef PEL_WATER_PARTS
layout(binding = 0, rgba32f) writeonly uniform image2D single_image;
layout(binding = 1, rgba32f) writeonly uniform image2D second_image;
layout(binding = 2, rgba32f) writeonly uniform image2D higher_image;
layout(binding = 3, rgba32f) writeonly uniform image2D bottom_image;
#else
layout(binding = 0, rgba32f) writeonly uniform image2D radiance_image;
#endif
#ifdef PEL_LAYERS
layout(binding = 1, r32f) writeonly uniform image2D depth_image;
layout(binding = 2, rgba32f) writeonly uniform image2D normal_image;
layout(binding = 3, rgba32f) writeonly uniform image2D sun_image;
layout(binding = 4, rgba32f) writeonly uniform image2D sky_image;
layout(binding = 5, rgba32f) writeonly uniform image2D water_image;
layout(binding = 6, rgba32f) writeonly uniform image2D air_image;
layout(binding = 7, rg32f) writeonly uniform image2D variance_image;
#elif !defined(PEL_WATER_PARTS)
layout(binding = 1, rgba8) writeonly uniform image2D color_image;
#endif

void main()
{
    ivec2 at = region.xy + ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= region.z || at.y >= region.w) {
        return;
    }
    int place = at.y * int(size.x) + at.x;
    uint key = keys[place];
    uint triangle = 0xFFFFFFFFu - key;
    shaded s;
#ifdef PEL_LAND
    s = shade_coast(at, key == 0u ? 0u : triangle);
#else
    if (key == 0u) {
        s = shade_backdrop(at);
    } else {
        s = shade_sea(at, triangle);
    }
#endif
    if ((wanted & PEL_LAST_PASS) != 0) {
        keys[place] = 0u;
    }
#ifdef PEL_WATER_PARTS
    imageStore(single_image, at, vec4(s.parts.single, 1.0));
    imageStore(second_image, at, vec4(s.parts.second, 1.0));
    imageStore(higher_image, at, vec4(s.parts.higher, 1.0));
    imageStore(bottom_image, at, vec4(s.parts.bottom, 1.0));
#else
    if ((wanted & PEL_WANTS_RADIANCE) != 0) {
        imageStore(radiance_image, at, vec4(s.radiance, 1.0));
    }
#endif
#ifdef PEL_LAYERS
    imageStore(depth_image, at, vec4(s.depth));
    imageStore(normal_image, at, s.normal);
    imageStore(sun_image, at, vec4(s.sun, 1.0));
    imageStore(sky_image, at, vec4(s.sky, 1.0));
    imageStore(water_image, at, vec4(s.water, 1.0));
    imageStore(air_image, at, vec4(s.air, 1.0));
    imageStore(variance_image, at, vec4(s.variance, 0.0, 0.0));
#elif !defined(PEL_WATER_PARTS)
    if ((wanted & PEL_WANTS_COLOR) != 0) {
        imageStore(color_image, at, vec4(display(s.radiance, at), 1.0));
    }
#endif
}
