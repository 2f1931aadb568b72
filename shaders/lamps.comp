#version 450 core
// What of each lamp reaches the eye: through the air, past the sea; and over
// which pixels it is spread.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/ray.glsl"
#include "lib/cut.glsl"
#include "lib/triangles.glsl"
layout(binding = PEL_UNIT_EYE_TABLE) uniform sampler2DArray eye_table;
#include "lib/haze.glsl"
#include "lib/lamps.glsl"

layout(local_size_x = PEL_GROUP_LINE) in;
layout(location = 0) uniform uint count;
layout(std430, binding = PEL_STORE_LAMPS) restrict readonly buffer lamps_block { pel_shader_lamp lamps[]; };
layout(std430, binding = PEL_STORE_SPOTS) restrict writeonly buffer spots_block { pel_shader_spot spots[]; };

// Share of nine pixels about a place that show it before the sea.
float before_the_sea(vec2 place, vec3 offset)
{
    float away = -dot(offset, back.xyz);
    vec3 ray = pixel_ray(place);
    float seen = 0.0;
    for (int i = 0; i < 9; i++) {
        ivec2 at = ivec2(floor(place - pixel.zw)) + ivec2(i % 3, i / 3) - 1;
        at = clamp(at, ivec2(0), ivec2(size.xy) - 1);
        uint triangle = triangle_at(at);
        vec3 middle = pixel_ray(lattice(at));
        cut sea = cut_triangle(middle, triangle);
        // The sea's triangle goes on as far as the lamp's ray.
        float slant = dot(sea.facet, ray);
        float t = clamp(slant == 0.0 ? sea.t : sea.t * dot(sea.facet, middle) / slant, 0.5 * sea.t, 2.0 * sea.t);
        seen += triangle == 0u || t > away * (1.0 - PEL_LAMP_SLACK) ? 1.0 : 0.0;
    }
    return seen / 9.0;
}

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) {
        return;
    }
    vec3 offset = lamps[i].place.xyz;
    float away = lamps[i].place.w;
    vec3 dir = offset / away;
    vec3 air;
    vec3 light = lamps[i].light.rgb * haze(dir, away, air) / (away * away); // normal to the ray, Allard
    vec2 place = lamps[i].spot.xy;
    light *= before_the_sea(place, offset);
    float length_ = length(pixel_ray(place));
    float angle = pixel.x * pixel.y / (length_ * length_ * length_); // sr
    // In pixels, of what is seen to glow.
    float radius = max(PEL_LAMP_LEAST_PX, 0.5 * lamps[i].light.w / away / pixel.x * length_ + 1.0);
    radius = min(radius, float(PEL_LAMP_REACH));
    float sum = 0.0;
    if (radius < 6.0) {
        vec2 middle = fract(place);
        for (int y = -6; y <= 6; y++) {
            for (int x = -6; x <= 6; x++) {
                sum += lamp_spread(vec2(x, y) + 0.5 - middle, radius);
            }
        }
    } else {
        sum = 0.25 * PI * radius * radius;
    }
    float scattered = lamps[i].spot.z;
    vec3 halo = light * (scattered * PEL_GLARE_NORM);
    // As far as it can be seen.
    float shown = dot(vec3(dot(red.rgb, halo), dot(green.rgb, halo), dot(blue.rgb, halo)), vec3(0.2126, 0.7152, 0.0722)) *
                  exposing.g;
    float core = PEL_GLARE_CORE / pixel.x * length_ * length_; // px
    float reach = core * sqrt(max(shown / PEL_LAMP_SHOWN - 1.0, 0.0));
    reach = min(reach, float(PEL_LAMP_REACH));
    spots[i].light = vec4(light * ((1.0 - scattered) / (angle * sum)), radius);
    spots[i].halo = vec4(halo, reach);
    spots[i].place = vec4(place, core, max(max(radius, reach), 1.0));
}
