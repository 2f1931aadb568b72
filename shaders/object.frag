#version 450 core
// Which triangle of an object a pixel shows: the nearest that is not behind the
// sea, or that stands behind sea in its own hull.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/cut.glsl"
#include "lib/model.glsl"
#ifdef PEL_HOLES
#include "lib/holes.glsl"
#endif

flat in uvec2 number;
flat in vec4 plane;
flat in vec2 reach;
layout(location = 0) out uvec2 seen;

#ifdef PEL_KEYS
layout(std430, binding = PEL_STORE_KEYS) restrict readonly buffer keys_block { uint keys[]; };

uint sea_at(ivec2 at)
{
    uint key = keys[at.y * int(size.x) + at.x];
    return key == 0u ? 0u : 0xFFFFFFFFu - key;
}
#else
layout(binding = PEL_UNIT_TRIANGLES) uniform usampler2D triangles;

uint sea_at(ivec2 at)
{
    return texelFetch(triangles, at, 0).r;
}
#endif

const float NEAR = 0.05;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 ray = pixel_ray(lattice(at));
    float slant = dot(plane.xyz, ray);
    float t = slant == 0.0 ? reach.x : clamp(plane.w / slant, reach.x, reach.y);
#ifdef PEL_HOLES
    if (hole_on_ray(number, ray, 0.5)) {
        discard;
    }
#endif
    uint triangle = sea_at(at);
    int entity = int(number.x) - 1;
    if (triangle != 0u) {
        float sea = cut_triangle(ray, triangle).t;
        if (sea < t && !hull_keeps_dry(entity, sea * ray, t * ray, slant > 0.0)) {
            discard;
        }
    }
    gl_FragDepth = NEAR / t;
    seen = number;
}
