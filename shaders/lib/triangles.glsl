// The triangle that the middle of a pixel sees, 0: none. Of search.comp, or as it
// was rasterised.
#include "lib/together.glsl"
#ifdef PEL_KEYS
layout(std430, binding = PEL_STORE_KEYS) restrict readonly buffer keys_block { uint keys[]; };

uint triangle_at(ivec2 at)
{
    uint key = keys[FIRST_PIXEL + uint(at.y * int(size.x) + at.x)];
    return key == 0u ? 0u : 0xFFFFFFFFu - key;
}
#else
layout(binding = PEL_UNIT_TRIANGLES) uniform usampler2D triangles;

uint triangle_at(ivec2 at)
{
    return texelFetch(triangles, at, 0).r;
}
#endif
