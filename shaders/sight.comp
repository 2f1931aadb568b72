#version 450 core
// Which samples of a pixel show an object: chips that are narrow in graphics take
// eight times as long to find those that have any.
#define PEL_KEYS
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/cut.glsl"
#include "lib/triangles.glsl"
#include "lib/model.glsl"
#include "lib/samples.glsl"
#include "lib/sight.glsl"

layout(local_size_x = PEL_GROUP_SIDE, local_size_y = PEL_GROUP_SIDE) in;
layout(binding = PEL_IMAGE_COVER, r8ui) writeonly uniform uimage2D cover_image;
layout(location = 0) uniform ivec4 region; // pixels from xy to before zw may show some

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    bool may = all(greaterThanEqual(at, region.xy)) && all(lessThan(at, region.zw));
    imageStore(cover_image, at, uvec4(may ? samples_in_sight(at) : 0u));
}
