#version 450 core
// What an eye in the water meets in a pixel besides objects: how far away, which
// it is, how much the waves focus light on the bottom there, and how deep the
// water is below the surface there. By itself, for software devices take minutes
// to compile all loops of a pixel together.
#define PEL_UNDER
#include "lib/blocks.h"
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
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/water.glsl"
#include "lib/seabed.glsl"
#include "lib/cut.glsl"

layout(binding = PEL_UNIT_TRIANGLES) uniform usampler2D triangles;
layout(location = 0) out vec4 found;

const float FAR = 2000.0;

// To the bottom, negative: it is not seen; over a field to what is told from
// the water.
float bottom_distance(vec3 sight, float end)
{
    float level = sight.z < 0.0 ? (under_ground.w - under_eye.x) / -sight.z : FAR;
#ifdef PEL_SEABED
    vec3 c = under_scaled.rgb;
    float seen = min(7.0 / max(min(min(c.r, c.g), c.b), 1e-3), FAR);
    float field = seabed_distance(sight, min(end, seen));
    // Beyond the field it is level.
    bool beyond = level < seen && seabed_height(bed_node(level * sight.xy)) <= bed_beyond.x + 1e-3;
    level = field >= 0.0 ? field : beyond ? level : FAR;
#endif
    return level < min(end, FAR) ? max(level, 0.01) : -1.0; // of an eye in the ground, too
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 ray = pixel_ray(lattice(at));
    float ray_length = length(ray);
    vec3 sight = ray / ray_length;
    uint triangle = texelFetch(triangles, at, 0).r;
    float flat_ = sight.z > 0.0 ? max(under_eye.y, 0.02) / sight.z : FAR;
    float end = triangle == 0u ? flat_ : cut_triangle(ray, triangle).t * ray_length;
    float floor_ = bottom_distance(sight, end);
    bool bottom = floor_ >= 0.0;
    float s = min(bottom ? floor_ : end, FAR);
    float kind = bottom ? PEL_UNDER_BOTTOM : s < FAR ? PEL_UNDER_SURFACE : PEL_UNDER_NOTHING;
    vec3 light = lights[PEL_LIGHT_FIRST].direction.xyz;
    float focus = 0.0;
    if (bottom && bed_beyond.w > 0.5 && light.z > 0.02) {
        float footprint = s * pixel.x * inversesqrt(max(-sight.z, 0.02));
        focus = caustic(PEL_LIGHT_FIRST, s * sight.xy, max(under_eye.x - s * sight.z, 0.01), footprint, light,
                        under_beams[PEL_LIGHT_FIRST].z) - 1.0;
    }
    float deep = under_ground.w;
#ifdef PEL_SEABED
    // Where light goes that the surface mirrors there.
    deep = -seabed_height(bed_node(s * sight.xy));
    deep = -seabed_height(bed_node(sight.xy * (s + deep / max(sight.z, 0.3))));
#endif
    found = vec4(s, kind, focus, max(deep, 0.0));
}
